/* What Robotran's library is for a project in C: it calls equations and user functions.

   Compiled with RUN_JOINTS, and with RUN_CUTS and RUN_USER_ROWS, the numbers of constraints. */
#include <string.h>

#include "runtime.h"

Push *pushes;
/* Add what a push does in the joints. */
static void add_push(MbsData *s, const Push *push)
{
    double force[4];

    memcpy(force, push->force, sizeof force);
    turn_force(force);
    find_frame(s, push->joint, push->at);
    for (int j = 1; j <= RUN_JOINTS; j++)
        for (int i = 1; i <= 3; i++)
            s->Qq[j] += frame.J[i][j] * force[i] + frame.J[3 + i][j] * cross(arm, force, i);
}

/* What equations of 2025 and later call; the compiler is told that the others are user_X. */
double *user_call_JointForces(MbsData *s, double tsim)
{
    run_JointForces(s, tsim);
    for (const Push *push = pushes; push && push->joint; push++)
        if (push->start <= tsim && tsim < push->stop)
            add_push(s, push);
    return s->Qq;
}

/* The derivative f of the state y: q and qd of the independent joints, and ux.  0 if it was found. */
int accelerate(MbsData *s, double t, const double *y, double *f)
{
    const int n = s->nqu;

    s->tsim = t;
    for (int i = 0; i < n; i++) {
        s->q[s->qu[i + 1]] = y[i];
        s->qd[s->qu[i + 1]] = y[n + i];
    }
    for (int i = 0; i < s->nqv; i++)
        s->q[s->qv[i + 1]] = s->guess[i];
    memcpy(s->ux + 1, y + 2 * n, s->Nux * sizeof *y);
    if (kept_accelred(s, t))
        return -1;
    if (s->Nux) {
        show_base(s);
        user_Derivative(s);
        hide_base(s);
    }
    for (int i = 0; i < n; i++) {
        f[i] = s->qd[s->qu[i + 1]];
        f[n + i] = s->qdd[s->qu[i + 1]];
    }
    memcpy(f + 2 * n, s->uxd + 1, s->Nux * sizeof *f);
    return 0;
}

/* What user_dirdyn_init, _loop and _finish are given. */
#define ROW(i) zeros + (i) * (RUN_JOINTS + 1)
static double zeros[7 * (RUN_JOINTS + 1)];
static MbsSensor sensor = {.J = {ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6)}};
static MbsAux aux = {&sensor};
static MbsDirdynOptions options;
MbsDirdyn dirdyn = {&options, &aux};
