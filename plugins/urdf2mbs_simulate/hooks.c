/* The functions of a project that are Python's: set_output, and without USER_IN_C the user functions.  In a page
   there is no Python, and they do nothing.

   Compiled with RUN_JOINTS and RUN_USER_ROWS, the number of the user's constraints. */
#include <string.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"
#include "mbs_sensor.h"
#include "set_output.h"

/* Functions of Python: each works on the arrays of MbsData, and on what is beside them here. */
struct {
    void (*output)(double value, const char *name);
    void (*joint_forces)(double t);
    void (*driven_joints)(double t);
    void (*derivative)(double t);
    void (*ext_forces)(double t, int number);
    void (*link_3d_forces)(double t, int number);
    double (*link_force)(double z, double zd, double t, int number);
    void (*cons_hJ)(double t);
    void (*cons_jdqd)(double t);
} hooks;
MbsSensor motion;
double rows_h[RUN_USER_ROWS + 1], rows_jdqd[RUN_USER_ROWS + 1];
double rows_jac[(RUN_USER_ROWS + 1) * (RUN_JOINTS + 1)];

void set_output(double value, const char *name)
{
    if (hooks.output)
        hooks.output(value, name);
}

#ifndef USER_IN_C
static void move_point(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                       double OMP[4])
{
    memcpy(motion.P, P, sizeof motion.P);
    memcpy(motion.V, V, sizeof motion.V);
    memcpy(motion.OM, OM, sizeof motion.OM);
    memcpy(motion.A, A, sizeof motion.A);
    memcpy(motion.OMP, OMP, sizeof motion.OMP);
    memcpy(motion.R, R, sizeof motion.R);
}

double *user_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                       double OMP[4], MbsData *s, double tsim, int number)
{
    move_point(P, R, V, OM, A, OMP);
    if (hooks.ext_forces)
        hooks.ext_forces(tsim, number);
    return s->SWr[number];
}

double *user_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                          double OMP[4], MbsData *s, double tsim, int number)
{
    move_point(P, R, V, OM, A, OMP);
    if (hooks.link_3d_forces)
        hooks.link_3d_forces(tsim, number);
    return s->l3DWr[number];
}

double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number)
{
    (void) s;
    return hooks.link_force ? hooks.link_force(Z, Zd, tsim, number) : 0.0;
}

double *user_JointForces(MbsData *s, double tsim)
{
    if (hooks.joint_forces)
        hooks.joint_forces(tsim);
    else
        memset(s->Qq, 0, (RUN_JOINTS + 1) * sizeof *s->Qq);
    return s->Qq;
}

void user_DrivenJoints(MbsData *s, double tsim)
{
    (void) s;
    if (hooks.driven_joints)
        hooks.driven_joints(tsim);
}

void user_Derivative(MbsData *s)
{
    if (hooks.derivative)
        hooks.derivative(s->tsim);
}

void user_cons_hJ(double *h, double **Jac, MbsData *s, double tsim)
{
    (void) s;
    if (hooks.cons_hJ)
        hooks.cons_hJ(tsim);
    for (int i = 1; i <= RUN_USER_ROWS; i++) {
        h[i] = rows_h[i];
        for (int j = 1; j <= RUN_JOINTS; j++)
            Jac[i][j] = rows_jac[i * (RUN_JOINTS + 1) + j];
    }
}

void user_cons_jdqd(double *jdqd, MbsData *s, double tsim)
{
    (void) s;
    if (hooks.cons_jdqd)
        hooks.cons_jdqd(tsim);
    memcpy(jdqd + 1, rows_jdqd + 1, RUN_USER_ROWS * sizeof *jdqd);
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
