/* The derivative of a state: it calls equations and user functions, as Robotran's library does. */
#include <string.h>

#include "runtime.h"

size_t get_run_size(void)
{
    return sizeof(Run);
}

/* Set the pointers of a Run inside it, in memory that is 0. */
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
    MbsData *data = &run->data;
    double force[4];

    memcpy(force, push->force, sizeof force);
    turn_force(run, force);
    compute_frame(run, push->joint, push->point);
    for (int j = 1; j <= N_JOINTS; j++)
        for (int i = 1; i <= 3; i++)
            data->Qq[j] += frame->jacobian[i][j] * force[i]
                + frame->jacobian[3 + i][j] * cross(frame->lever, force, i);
}

/* Compute the joint forces of the user, and of pushes.  Equations of 2025 and later call it by this name; their
   other calls user_call_X become run_X by macros of compiler.py. */
double *user_call_JointForces(MbsData *data, double tsim)
{
    Run *run = run_of(data);

    run_JointForces(data, tsim);
    for (const Push *push = run->pushes; push && push->joint; push++)
        if (push->start <= tsim && tsim < push->stop)
            add_push(run, push);
    return data->Qq;
}

/* Compute f = dy/dt of the state y = (q, qd of the independent joints, ux).  Return 0, or -1 if it failed.

   Newton's method closes the loops, from the positions guess of the dependent joints at the start of a step. */
int accelerate(Run *run, double t, const double *y, double *f)
{
    MbsData *data = &run->data;
    const int n = data->nqu;

    if (!run->is_time_frozen)
        data->tsim = t;
    for (int i = 0; i < n; i++) {
        data->q[data->qu[i + 1]] = y[i];
        data->qd[data->qu[i + 1]] = y[n + i];
    }
    for (int i = 0; i < data->nqv; i++)
        data->q[data->qv[i + 1]] = data->guess[i];
    memcpy(data->ux + 1, y + 2 * n, data->Nux * sizeof *y);
    if (compute_accelerations(run))
        return -1;
    if (data->Nux)
        run_Derivative(run);
    for (int i = 0; i < n; i++) {
        f[i] = data->qd[data->qu[i + 1]];
        f[n + i] = data->qdd[data->qu[i + 1]] - run->damping * y[n + i];
    }
    memcpy(f + 2 * n, data->uxd + 1, data->Nux * sizeof *f);
    return 0;
}

/* Compute the frame of the body of an external force, with the lever to its anchor point. */
void compute_anchor_frame(Run *run, int number)
{
    const MbsData *data = &run->data;
    const int k = data->xfidpt[number];
    const double anchor_point[4] = {0.0, data->dpt[1][k], data->dpt[2][k], data->dpt[3][k]};

    compute_frame(run, run->last_joint[number], anchor_point);
}

/* Compute the force and torque of an external force at its anchor point, after a small motion of its body.

   The motion has 12 components in axes of the base: displacement of the point (m) and rotation (rad), then the
   changes of their rates.  The frame is that of compute_anchor_frame. */
void compute_external_force(Run *run, int number, const double *motion, double *force)
{
    MbsData *data = &run->data;
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
    wrench = run_ExtForces(P, R, V, OM, A, OMP, data, data->tsim, number);
    for (int i = 1; i <= 3; i++)
        for (int k = 1; k <= 3; k++)
            offset[i] += R[k][i] * (wrench[6 + k] - data->dpt[k][data->xfidpt[number]]);
    for (int i = 1; i <= 3; i++) {
        force[i - 1] = wrench[i];
        force[2 + i] = wrench[3 + i] + cross(offset, wrench, i);
    }
}

/* Call the user's loop after a step, with Qc of the driven joints from M qdd + c = Qq + Qc. */
void call_loop(Run *run)
{
    MbsData *data = &run->data;
    double force[N_JOINTS + 1];

    mbs_invdyna(force, data, data->tsim);
    for (int j = 1; j <= N_JOINTS; j++)
        data->Qc[j] = force[j] - data->Qq[j];
    for (int i = 1; i <= data->nqu; i++)
        data->Qc[data->qu[i]] = 0.0;
    enter_user_code(run);
    show_model_axes(run);
    run->is_recording = 1;
    user_dirdyn_loop(data, &run->dirdyn);
    run->is_recording = 0;
    hide_model_axes(run);
}
