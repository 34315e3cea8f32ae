/* The functions of a project that are Python's: set_output, and without USER_IN_C the user functions.  In a page
   there is no Python, and they do nothing. */
#include <string.h>

#include "runtime.h"
#include "set_output.h"

/* Constant while user code runs: set_output of Robotran's has no other way to its MbsData. */
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
/* Copy the motion of a point to where Python sees it. */
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
                       double OMP[4], MbsData *s, double tsim, int number)
{
    copy_point(run_of(s), P, R, V, OM, A, OMP);
    if (run_of(s)->hooks.ext_forces)
        run_of(s)->hooks.ext_forces(tsim, number);
    return s->SWr[number];
}

double *user_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                          double OMP[4], MbsData *s, double tsim, int number)
{
    copy_point(run_of(s), P, R, V, OM, A, OMP);
    if (run_of(s)->hooks.link_3d_forces)
        run_of(s)->hooks.link_3d_forces(tsim, number);
    return s->l3DWr[number];
}

double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number)
{
    return run_of(s)->hooks.link_force ? run_of(s)->hooks.link_force(Z, Zd, tsim, number) : 0.0;
}

double *user_JointForces(MbsData *s, double tsim)
{
    if (run_of(s)->hooks.joint_forces)
        run_of(s)->hooks.joint_forces(tsim);
    else
        memset(s->Qq, 0, (N_JOINTS + 1) * sizeof *s->Qq);
    return s->Qq;
}

void user_DrivenJoints(MbsData *s, double tsim)
{
    if (run_of(s)->hooks.driven_joints)
        run_of(s)->hooks.driven_joints(tsim);
}

void user_Derivative(MbsData *s)
{
    if (run_of(s)->hooks.derivative)
        run_of(s)->hooks.derivative(s->tsim);
}

void user_cons_hJ(double *h, double **J, MbsData *s, double tsim)
{
    const Run *run = run_of(s);

    if (run->hooks.cons_hJ)
        run->hooks.cons_hJ(tsim);
    for (int i = 1; i <= N_USER_ROWS; i++) {
        h[i] = run->user_h[i];
        for (int j = 1; j <= N_JOINTS; j++)
            J[i][j] = run->user_J[i * (N_JOINTS + 1) + j];
    }
}

void user_cons_jdqd(double *jdqd, MbsData *s, double tsim)
{
    const Run *run = run_of(s);

    if (run->hooks.cons_jdqd)
        run->hooks.cons_jdqd(tsim);
    memcpy(jdqd + 1, run->user_jdqd + 1, N_USER_ROWS * sizeof *jdqd);
}

void user_dirdyn_init(MbsData *s, MbsDirdyn *mbs_dd)
{
    (void) s, (void) mbs_dd;
}

void user_dirdyn_loop(MbsData *s, MbsDirdyn *mbs_dd)
{
    (void) s, (void) mbs_dd; /* Python calls its own */
}
#endif
