/* What Robotran's library is for a project in C: it calls equations and user functions.

   Compiled with RUN_JOINTS and RUN_FORCES: how many joints and external forces. */
#include <string.h>

#include "runtime.h"

Push *pushes;
int last_joint[RUN_FORCES + 1]; /* of the body of each external force; 0: of the base */

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

/* The force and torque at the anchor point of an external force, after a small motion of its body:
   places and speeds of the point, and of the rotation. */
void find_force(MbsData *s, int number, const double *motion, double *force)
{
    double P[4], R[4][4], V[4], OM[4], A[4], OMP[4], lever[4] = {0}, *w;

    memcpy(A, frame.A, sizeof A);
    memcpy(OMP, frame.OMP, sizeof OMP);
    for (int i = 1; i <= 3; i++) {
        P[i] = frame.P[i] + arm[i] + motion[i - 1];
        V[i] = frame.V[i] + cross(frame.OM, arm, i) + motion[5 + i];
        OM[i] = frame.OM[i] + motion[8 + i];
        for (int k = 1; k <= 3; k++)
            R[k][i] = frame.R[k][i] + cross(motion + 2, frame.R[k], i);
    }
    w = run_ExtForces(P, R, V, OM, A, OMP, s, s->tsim, number);
    for (int i = 1; i <= 3; i++)
        for (int k = 1; k <= 3; k++)
            lever[i] += R[k][i] * (w[6 + k] - s->dpt[k][s->xfidpt[number]]);
    for (int i = 1; i <= 3; i++) {
        force[i - 1] = w[i];
        force[2 + i] = w[3 + i] + cross(lever, w, i);
    }
}

void find_body(MbsData *s, int number)
{
    const int point = s->xfidpt[number];
    const double at[4] = {0.0, s->dpt[1][point], s->dpt[2][point], s->dpt[3][point]};

    find_frame(s, last_joint[number], at);
}

/* What user_dirdyn_init, _loop and _finish are given. */
#define ROW(i) zeros + (i) * (RUN_JOINTS + 1)
static double zeros[7 * (RUN_JOINTS + 1)];
static MbsSensor sensor = {.J = {ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6)}};
static MbsAux aux = {&sensor};
static MbsDirdynOptions options;
MbsDirdyn dirdyn = {&options, &aux};

/* The user's loop after a step, with Qc of the driven joints. */
void call_loop(MbsData *s)
{
    static double force[RUN_JOINTS + 1];

    mbs_invdyna(force, s, s->tsim);
    for (int j = 1; j <= RUN_JOINTS; j++)
        s->Qc[j] = force[j] - s->Qq[j];
    for (int i = 1; i <= s->nqu; i++)
        s->Qc[s->qu[i]] = 0.0;
    show_base(s);
    user_dirdyn_loop(s, &dirdyn);
    hide_base(s);
}
