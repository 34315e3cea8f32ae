/* Functions that call Python: set_output and, without USER_IN_C, the user functions.  In a page there is no Python,
   and they do nothing. */
#include <string.h>

#include "runtime.h"
#include "set_output.h"

/* The Run whose user code runs: set_output of Robotran has no argument that leads to it. */
static __thread Run *run_of_thread;

void enter_user_code(Run *run)
{
    run_of_thread = run;
}

void set_output(double value, const char *name)
{
    const Run *run = run_of_thread;

    if (run && run->is_recording && run->hooks.output)
        run->hooks.output(value, name);
}

#ifndef USER_IN_C
/* Copy the motion of a point to the Run, where Python reads it. */
static void copy_point(Run *run, double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                       double OMP[4])
{
    MbsSensor *point = &run->point;

    memcpy(point->P, P, sizeof point->P);
    memcpy(point->V, V, sizeof point->V);
    memcpy(point->OM, OM, sizeof point->OM);
    memcpy(point->A, A, sizeof point->A);
    memcpy(point->OMP, OMP, sizeof point->OMP);
    memcpy(point->R, R, sizeof point->R);
}

double *user_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                       double OMP[4], MbsData *data, double tsim, int number)
{
    copy_point(run_of(data), P, R, V, OM, A, OMP);
    if (run_of(data)->hooks.ext_forces)
        run_of(data)->hooks.ext_forces(tsim, number);
    return data->SWr[number];
}

double *user_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                          double OMP[4], MbsData *data, double tsim, int number)
{
    copy_point(run_of(data), P, R, V, OM, A, OMP);
    if (run_of(data)->hooks.link_3d_forces)
        run_of(data)->hooks.link_3d_forces(tsim, number);
    return data->l3DWr[number];
}

double user_LinkForces(double Z, double Zd, MbsData *data, double tsim, int number)
{
    return run_of(data)->hooks.link_force ? run_of(data)->hooks.link_force(Z, Zd, tsim, number) : 0.0;
}

double *user_JointForces(MbsData *data, double tsim)
{
    if (run_of(data)->hooks.joint_forces)
        run_of(data)->hooks.joint_forces(tsim);
    else
        memset(data->Qq, 0, (N_JOINTS + 1) * sizeof *data->Qq);
    return data->Qq;
}

void user_DrivenJoints(MbsData *data, double tsim)
{
    if (run_of(data)->hooks.driven_joints)
        run_of(data)->hooks.driven_joints(tsim);
}

void user_Derivative(MbsData *data)
{
    if (run_of(data)->hooks.derivative)
        run_of(data)->hooks.derivative(data->tsim);
}

void user_cons_hJ(double *h, double **J, MbsData *data, double tsim)
{
    const Run *run = run_of(data);

    if (run->hooks.cons_hJ)
        run->hooks.cons_hJ(tsim);
    for (int i = 1; i <= N_USER_ROWS; i++) {
        h[i] = run->user_h[i];
        for (int j = 1; j <= N_JOINTS; j++)
            J[i][j] = run->user_J[i * (N_JOINTS + 1) + j];
    }
}

void user_cons_jdqd(double *jdqd, MbsData *data, double tsim)
{
    const Run *run = run_of(data);

    if (run->hooks.cons_jdqd)
        run->hooks.cons_jdqd(tsim);
    memcpy(jdqd + 1, run->user_jdqd + 1, N_USER_ROWS * sizeof *jdqd);
}

void user_dirdyn_init(MbsData *data, MbsDirdyn *mbs_dd)
{
    (void) data, (void) mbs_dd;
}

void user_dirdyn_loop(MbsData *data, MbsDirdyn *mbs_dd)
{
    (void) data, (void) mbs_dd; /* Python calls its own */
}
#endif
