/* What Robotran's library is for a project in C: it calls equations and user functions.

   Compiled with RUN_CUTS and RUN_USER_ROWS, the numbers of constraints; with USER_IN_C where the user
   functions are in C.  Without it they are Python's, and are called through the hooks. */
#include <math.h>
#include <string.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"
#include "mbs_sensor.h"
#include "set_output.h"

#ifndef RUN_ACCELRED
#define RUN_ACCELRED mbs_accelred
#endif
int RUN_ACCELRED(MbsData *s, double tsim);
double *run_JointForces(MbsData *s, double tsim);
void show_base(MbsData *s);
void hide_base(MbsData *s);
void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);

/* Functions of Python: each works on the arrays of MbsData, and on what is beside them here. */
struct {
    void (*output)(double value, const char *name);
    void (*pushes)(double t);
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
    hooks.ext_forces(tsim, number);
    return s->SWr[number];
}

double *user_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                          double OMP[4], MbsData *s, double tsim, int number)
{
    move_point(P, R, V, OM, A, OMP);
    hooks.link_3d_forces(tsim, number);
    return s->l3DWr[number];
}

double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number)
{
    (void) s;
    return hooks.link_force(Z, Zd, tsim, number);
}

double *user_JointForces(MbsData *s, double tsim)
{
    hooks.joint_forces(tsim);
    return s->Qq;
}

void user_DrivenJoints(MbsData *s, double tsim)
{
    (void) s;
    hooks.driven_joints(tsim);
}

void user_Derivative(MbsData *s)
{
    hooks.derivative(s->tsim);
}

void user_cons_hJ(double *h, double **Jac, MbsData *s, double tsim)
{
    (void) s;
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
    hooks.cons_jdqd(tsim);
    memcpy(jdqd + 1, rows_jdqd + 1, RUN_USER_ROWS * sizeof *jdqd);
}
#endif

/* What equations of 2025 and later call; the compiler is told that the others are user_X. */
double *user_call_JointForces(MbsData *s, double tsim)
{
    run_JointForces(s, tsim);
    if (hooks.pushes)
        hooks.pushes(tsim);
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
    if (RUN_ACCELRED(s, t))
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

/* The derivative of f by y, by differences: a row for each number of y, which is changed meanwhile.
   0 if it was found. */
int slopes(MbsData *s, double t, double *y, double *f, double near, double *table)
{
    const int n = 2 * s->nqu + s->Nux;

    if (accelerate(s, t, y, f))
        return -1;
    for (int k = 0; k < n; k++, table += n) {
        const double here = y[k];

        y[k] += near * fmax(1.0, fabs(here));
        if (accelerate(s, t, y, table))
            return -1;
        for (int i = 0; i < n; i++)
            table[i] = (table[i] - f[i]) / (y[k] - here);
        y[k] = here;
    }
    return 0;
}

/* The constraints at the present position. */
void constrain(MbsData *s, double *h, double **Jac)
{
#if RUN_CUTS
    mbs_cons_hJ(h, Jac, s, s->tsim);
#endif
#if RUN_USER_ROWS
    user_cons_hJ(h + RUN_CUTS, Jac + RUN_CUTS, s, s->tsim);
#endif
    (void) s, (void) h, (void) Jac;
}

/* What user_dirdyn_init, _loop and _finish are given. */
#define ROW(i) zeros + (i) * (RUN_JOINTS + 1)
static double zeros[7 * (RUN_JOINTS + 1)];
static MbsSensor sensor = {.J = {ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6)}};
static MbsAux aux = {&sensor};
static MbsDirdynOptions options;
MbsDirdyn dirdyn = {&options, &aux};
