/* The parts of accelred and invdynared that are the same for all models.

   Generated files are put together from its sections; as it stands, it compiles, too. */
#include <math.h>
#include <stdlib.h>

#include "mbs_data.h"

/* --- model --- (an example: each file has its own) */
enum {JOINTS = 3, ANY_DRIVEN = 0, LINKS = 0, LINKS3D = 0, EXTFORCES = 0};
enum {DEPENDENT = 1, INDEPENDENT = 2, DRIVEN = 0, CUTS = 1, USER_ROWS = 0};
/* numbers of the joints, the first of each list not being used */
static const int dependent[] = {0, 3};
static const int independent[] = {0, 1, 2};
static const int driven[] = {0};

/* --- info --- */
#ifndef MBS_INFO_SUCCESS
#define MBS_INFO_SUCCESS 0
#define MBS_INFO_FAILURE (-1)
#endif

/* --- calls --- (since 2025 through functions of Robotran's library) */
#ifdef MBS_BEFORE_2025
#define USER(name) user_##name
#else
#define USER(name) user_call_##name
#endif

/* --- forces --- */
double *USER(JointForces)(MbsData *s, double tsim);
void USER(DrivenJoints)(MbsData *s, double tsim);
void mbs_link(double **frc, double **trq, double *Flink, double *Z, double *Zd, MbsData *s,
              double tsim);
void mbs_link3D(double **frc, double **trq, MbsData *s, double tsim);
void mbs_extforces(double **frc, double **trq, MbsData *s, double tsim);

static void set_driven(MbsData *s, double tsim)
{
    if (ANY_DRIVEN)
        USER(DrivenJoints)(s, tsim);
}

/* The forces on bodies. */
static void set_forces(MbsData *s, double tsim)
{
    for (int i = 1; i <= JOINTS; i++)
        for (int k = 1; k <= 3; k++) {
            s->frc[k][i] = 0.0;
            s->trq[k][i] = 0.0;
        }
    if (LINKS)
        mbs_link(s->frc, s->trq, s->Fl, s->Z, s->Zd, s, tsim);
    if (LINKS3D)
        mbs_link3D(s->frc, s->trq, s, tsim);
    if (EXTFORCES)
        mbs_extforces(s->frc, s->trq, s, tsim);
}

/* --- loops --- */
enum {FREE = INDEPENDENT + DRIVEN, KNOWN = FREE + 1};

void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);
void mbs_cons_jdqd(double *Jdqd, MbsData *s, double tsim);
void USER(cons_hJ)(double *h, double **Jac, MbsData *s, double tsim);
void USER(cons_jdqd)(double *jdqd, MbsData *s, double tsim);

static double **table(int rows, int columns)
{
    double **t = malloc((rows + 1) * sizeof *t);
    t[0] = calloc((rows + 1) * (columns + 1), sizeof **t);
    for (int i = 1; i <= rows; i++)
        t[i] = t[0] + i * (columns + 1);
    return t;
}

static void release(double **t)
{
    free(t[0]);
    free(t);
}

/* Gauss with row pivots: a x = b for several b, the columns of x; a is lost.  0 if solved. */
static int solve(double **a, int n, double **x, int columns)
{
    for (int k = 1; k <= n; k++) {
        int p = k;
        for (int i = k + 1; i <= n; i++)
            if (fabs(a[i][k]) > fabs(a[p][k]))
                p = i;
        if (!(fabs(a[p][k]) > 1e-14))
            return -1;
        double *row = a[k], *other = x[k];
        a[k] = a[p], a[p] = row;
        x[k] = x[p], x[p] = other;
        for (int i = k + 1; i <= n; i++) {
            double f = a[i][k] / a[k][k];
            for (int j = k; j <= n; j++)
                a[i][j] -= f * a[k][j];
            for (int j = 1; j <= columns; j++)
                x[i][j] -= f * x[k][j];
        }
    }
    for (int k = n; k >= 1; k--)
        for (int j = 1; j <= columns; j++) {
            for (int i = k + 1; i <= n; i++)
                x[k][j] -= a[k][i] * x[i][j];
            x[k][j] /= a[k][k];
        }
    return 0;
}

/* The joints that are not dependent: the independent ones, then the driven ones. */
static int free_joint(int j)
{
    return j <= INDEPENDENT ? independent[j] : driven[j - INDEPENDENT];
}

static void constraints(double *h, double **Jac, MbsData *s, double tsim)
{
    for (int i = 0; i <= DEPENDENT; i++)
        for (int j = 0; j <= JOINTS; j++)
            Jac[i][j] = 0.0;
    if (CUTS)
        mbs_cons_hJ(h, Jac, s, tsim);
    if (USER_ROWS)
        USER(cons_hJ)(h + CUTS, Jac + CUTS, s, tsim);
}

/* Solve the constraints for the dependent joints: Jac of these times x = x. */
static int solve_dependent(double **Jac, double **x, int columns)
{
    double **square = table(DEPENDENT, DEPENDENT);
    for (int i = 1; i <= DEPENDENT; i++)
        for (int j = 1; j <= DEPENDENT; j++)
            square[i][j] = Jac[i][dependent[j]];
    int failed = solve(square, DEPENDENT, x, columns);
    release(square);
    return failed;
}

/* Set q and qd of the dependent joints.  Their qdd is B times qdd of the free joints, plus the
   column KNOWN of B.  0 if the loops could be closed. */
static int close_loops(MbsData *s, double tsim, double **B)
{
    double **Jac = table(DEPENDENT, JOINTS), **x = table(DEPENDENT, 1);
    double *h = calloc(DEPENDENT + 1, sizeof *h);
    int failed = -1;

    for (int turn = 0; turn < 100; turn++) {
        double largest = 0.0;
        constraints(h, Jac, s, tsim);
        for (int i = 1; i <= DEPENDENT; i++) {
            largest = fabs(h[i]) <= largest ? largest : fabs(h[i]);
            x[i][1] = -h[i];
        }
        failed = !(largest < 1e-9);
        if (!failed || solve_dependent(Jac, x, 1))
            break;
        for (int i = 1; i <= DEPENDENT; i++)
            s->q[dependent[i]] += x[i][1];
    }
    if (!failed) {
        for (int i = 1; i <= DEPENDENT; i++)
            for (int j = 1; j <= FREE; j++)
                B[i][j] = -Jac[i][free_joint(j)];
        failed = solve_dependent(Jac, B, FREE);
        for (int i = 1; i <= DEPENDENT; i++) {
            s->qd[dependent[i]] = 0.0;
            for (int j = 1; j <= FREE; j++)
                s->qd[dependent[i]] += B[i][j] * s->qd[free_joint(j)];
        }
        if (CUTS)
            mbs_cons_jdqd(h, s, tsim);
        if (USER_ROWS)
            USER(cons_jdqd)(h + CUTS, s, tsim);
        for (int i = 1; i <= DEPENDENT; i++)
            x[i][1] = -h[i];
        failed = failed || solve_dependent(Jac, x, 1);
        for (int i = 1; i <= DEPENDENT; i++)
            B[i][KNOWN] = x[i][1];
    }
    release(Jac), release(x), free(h);
    return failed;
}

/* Set qdd of the dependent joints. */
static void follow(MbsData *s, double **B)
{
    for (int i = 1; i <= DEPENDENT; i++) {
        s->qdd[dependent[i]] = B[i][KNOWN];
        for (int j = 1; j <= FREE; j++)
            s->qdd[dependent[i]] += B[i][j] * s->qdd[free_joint(j)];
    }
}

/* --- accelred --- */
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);

/* Set q, qd and qdd of the dependent joints, and qdd of the independent ones. */
int mbs_accelred(MbsData *s, double tsim)
{
    double **B = table(DEPENDENT, KNOWN), **M = table(JOINTS, JOINTS);
    double **P = table(JOINTS, INDEPENDENT), **A = table(INDEPENDENT, INDEPENDENT);
    double **y = table(INDEPENDENT, 1), *c = calloc(JOINTS + 1, sizeof *c);

    set_driven(s, tsim);
    int failed = close_loops(s, tsim, B);
    if (!failed) {
        set_forces(s, tsim);
        USER(JointForces)(s, tsim);
        mbs_dirdyna(M, c, s, tsim);
        for (int j = 1; j <= INDEPENDENT; j++)
            s->qdd[independent[j]] = 0.0;
        follow(s, B);
        /* c: what is left of the forces; P = M T, where T is 1 for the independent joints and B
           for the dependent ones; A = T' P and y = T' c.  Most of B is zero. */
        for (int k = 1; k <= JOINTS; k++) {
            c[k] = s->Qq[k] - c[k];
            for (int j = 1; j <= JOINTS; j++)
                c[k] -= M[k][j] * s->qdd[j];
            for (int j = 1; j <= INDEPENDENT; j++)
                P[k][j] = M[k][independent[j]];
        }
        for (int i = 1; i <= DEPENDENT; i++)
            for (int j = 1; j <= INDEPENDENT; j++)
                for (int k = 1; k <= JOINTS && B[i][j] != 0.0; k++)
                    P[k][j] += M[k][dependent[i]] * B[i][j];
        for (int i = 1; i <= INDEPENDENT; i++) {
            y[i][1] = c[independent[i]];
            for (int j = 1; j <= INDEPENDENT; j++)
                A[i][j] = P[independent[i]][j];
            for (int k = 1; k <= DEPENDENT; k++) {
                if (B[k][i] == 0.0)
                    continue;
                y[i][1] += B[k][i] * c[dependent[k]];
                for (int j = 1; j <= INDEPENDENT; j++)
                    A[i][j] += B[k][i] * P[dependent[k]][j];
            }
        }
        failed = solve(A, INDEPENDENT, y, 1);
        for (int i = 1; i <= INDEPENDENT; i++)
            s->qdd[independent[i]] = y[i][1];
        follow(s, B);
    }
    release(B), release(M), release(P), release(A), release(y), free(c);
    return failed ? MBS_INFO_FAILURE : MBS_INFO_SUCCESS;
}

/* --- invdynared --- */
void mbs_invdyna(double *Qq, MbsData *s, double tsim);

/* Set Qq of the free joints for qdd of the free joints, with no forces in the dependent ones;
   also q, qd and qdd of the dependent joints. */
int mbs_invdynared(MbsData *s, double tsim)
{
    double **B = table(DEPENDENT, KNOWN);

    set_driven(s, tsim);
    int failed = close_loops(s, tsim, B);
    if (!failed) {
        follow(s, B);
        set_forces(s, tsim);
        mbs_invdyna(s->Qq, s, tsim);
        for (int i = 1; i <= DEPENDENT; i++) {
            for (int j = 1; j <= FREE; j++)
                s->Qq[free_joint(j)] += B[i][j] * s->Qq[dependent[i]];
            s->Qq[dependent[i]] = 0.0;
        }
    }
    release(B);
    return failed ? MBS_INFO_FAILURE : MBS_INFO_SUCCESS;
}
