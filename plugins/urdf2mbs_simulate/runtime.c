/* What Robotran's library is for a project in C: it calls equations and user functions. */
#include <string.h>

#include "runtime.h"

size_t get_run_size(void)
{
    return sizeof(Run);
}

/* Begin a run, in memory that is 0. */
void initialize_run(Run *run)
{
    for (int i = 0; i < 7; i++)
        run->loop_sensor.J[i] = run->zeros;
    run->loop_aux.psens = &run->loop_sensor;
    run->dirdyn.options = &run->loop_options;
    run->dirdyn.mbs_aux = &run->loop_aux;
}

/* Add a push to the joint forces: Qq += J' (force, lever x force). */
static void add_push(Run *run, const Push *push)
{
    const Frame *frame = &run->frame;
    MbsData *s = &run->data;
    double force[4];

    memcpy(force, push->force, sizeof force);
    turn_force(run, force);
    compute_frame(run, push->joint, push->at);
    for (int j = 1; j <= N_JOINTS; j++)
        for (int i = 1; i <= 3; i++)
            s->Qq[j] += frame->jacobian[i][j] * force[i]
                + frame->jacobian[3 + i][j] * cross(frame->lever, force, i);
}

/* What equations of 2025 and later call; the compiler is told that the others are run_X. */
double *user_call_JointForces(MbsData *s, double tsim)
{
    Run *run = run_of(s);

    run_JointForces(s, tsim);
    for (const Push *push = run->pushes; push && push->joint; push++)
        if (push->start <= tsim && tsim < push->stop)
            add_push(run, push);
    return s->Qq;
}

/* Compute f = dy/dt of the state y: q and qd of the independent joints, and ux.  Return 0 if it was found.

   Newton's method closes the loops from guess, the dependent joints at the start of the step. */
int accelerate(Run *run, double t, const double *y, double *f)
{
    MbsData *s = &run->data;
    const int n = s->nqu;

    if (!run->is_time_frozen)
        s->tsim = t;
    for (int i = 0; i < n; i++) {
        s->q[s->qu[i + 1]] = y[i];
        s->qd[s->qu[i + 1]] = y[n + i];
    }
    for (int i = 0; i < s->nqv; i++)
        s->q[s->qv[i + 1]] = s->guess[i];
    memcpy(s->ux + 1, y + 2 * n, s->Nux * sizeof *y);
    if (compute_accelerations(run))
        return -1;
    if (s->Nux)
        run_Derivative(run);
    for (int i = 0; i < n; i++) {
        f[i] = s->qd[s->qu[i + 1]];
        f[n + i] = s->qdd[s->qu[i + 1]] - run->damping * y[n + i];
    }
    memcpy(f + 2 * n, s->uxd + 1, s->Nux * sizeof *f);
    return 0;
}

void compute_anchor_frame(Run *run, int number)
{
    const MbsData *s = &run->data;
    const int point = s->xfidpt[number];
    const double at[4] = {0.0, s->dpt[1][point], s->dpt[2][point], s->dpt[3][point]};

    compute_frame(run, run->last_joint[number], at);
}

/* Compute the force and torque at the anchor point of an external force, after a small motion of its body:
   displacement of the point and rotation, then the changes of their rates, in axes of the base.  The frame is
   that of compute_anchor_frame. */
void compute_external_force(Run *run, int number, const double *motion, double *force)
{
    MbsData *s = &run->data;
    const MbsSensor *sensor = &run->frame.sensor;
    const double *lever = run->frame.lever;
    double P[4] = {0}, R[4][4] = {{0}}, V[4] = {0}, OM[4] = {0}, A[4], OMP[4], offset[4] = {0}, *wrench;

    memcpy(A, sensor->A, sizeof A);
    memcpy(OMP, sensor->OMP, sizeof OMP);
    for (int i = 1; i <= 3; i++) {
        P[i] = sensor->P[i] + lever[i] + motion[i - 1];
        V[i] = sensor->V[i] + cross(sensor->OM, lever, i) + motion[5 + i];
        OM[i] = sensor->OM[i] + motion[8 + i];
        for (int k = 1; k <= 3; k++)
            R[k][i] = sensor->R[k][i] + cross(motion + 2, sensor->R[k], i);
    }
    wrench = run_ExtForces(P, R, V, OM, A, OMP, s, s->tsim, number);
    for (int i = 1; i <= 3; i++)
        for (int k = 1; k <= 3; k++)
            offset[i] += R[k][i] * (wrench[6 + k] - s->dpt[k][s->xfidpt[number]]);
    for (int i = 1; i <= 3; i++) {
        force[i - 1] = wrench[i];
        force[2 + i] = wrench[3 + i] + cross(offset, wrench, i);
    }
}

/* Call the user's loop after a step, with Qc of the driven joints: M qdd + c = Qq + Qc. */
void call_loop(Run *run)
{
    MbsData *s = &run->data;
    double force[N_JOINTS + 1];

    mbs_invdyna(force, s, s->tsim);
    for (int j = 1; j <= N_JOINTS; j++)
        s->Qc[j] = force[j] - s->Qq[j];
    for (int i = 1; i <= s->nqu; i++)
        s->Qc[s->qu[i]] = 0.0;
    enter_user_code(run);
    show_model_axes(run);
    run->is_recording = 1;
    user_dirdyn_loop(s, &run->dirdyn);
    run->is_recording = 0;
    hide_model_axes(run);
}
