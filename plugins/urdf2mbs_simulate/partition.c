/* Accelerations with a partition of the joints that may change while a simulation runs (coordinate reduction:
   Wehage and Haug, Journal of Mechanical Design 104, 1982; Robotran's accelred).

   The joints q are independent (u), dependent (v) or driven (c).  As many constraints h(q) = 0 are used as there
   are dependent joints; J = dh/dq:

       J_v dv = -h                                     Newton's method, for the positions of v
       v' = B l'        B = -J_v^-1 J_l                where l are the leaders: u and c that v follow
       v'' = B l'' + b  b = -J_v^-1 (dJ/dt q')         b is the column 0 of B
       T' M T u'' = T' (Q - c - M qdd_0)               T = [1; B], qdd_0: of u'' = 0

   What generated files of accelred do for one partition (accelred.c of the equations) is here for any. */
#include <math.h>
#include <string.h>

#include "runtime.h"

/* A pivot is 0 if it is so small a part of its row of J, or of its element of A. */
static const double SINGULAR = 1e-13;
/* A loop is closed where a joint would close it by a move of so much (rad, m). */
static const double CLOSED = 1e-9;
static const int MAX_NEWTON_STEPS = 100;

void mbs_cons_hJ(double *h, double **J, MbsData *s, double tsim);
void mbs_cons_jdqd(double *jdqd, MbsData *s, double tsim);
void mbs_link(double **frc, double **trq, double *Fl, double *Z, double *Zd, MbsData *s, double tsim);
void mbs_link3D(double **frc, double **trq, MbsData *s, double tsim);
void mbs_extforces(double **frc, double **trq, MbsData *s, double tsim);
double *user_call_JointForces(MbsData *s, double tsim);

/* Take the joints of MbsData, and as many constraints as there are dependent joints. */
void set_partition(Run *run, const int *rows)
{
    Partition *p = &run->partition;
    const MbsData *s = &run->data;

    p->n_dependent = s->nqv;
    p->n_independent = s->nqu;
    memcpy(p->dependent, s->qv, (s->nqv + 1) * sizeof *p->dependent);
    memcpy(p->independent, s->qu, (s->nqu + 1) * sizeof *p->independent);
    memcpy(p->row + 1, rows, s->nqv * sizeof *p->row);
    p->is_factorized = 0;
    p->has_B = 0;
}

/* row -= factor * other, in some columns.  Most factors are 0. */
static void subtract(double *row, double factor, const double *other, int first, int last)
{
    if (factor != 0.0)
        for (int j = first; j <= last; j++)
            row[j] -= factor * other[j];
}

/* --- constraints --- */

/* Compute h and J of all constraints, those of the cuts first, from index 1; J is 0 before. */
void compute_constraints(Run *run, double *h, double **J)
{
    MbsData *s = &run->data;

#if RUN_CUTS
    mbs_cons_hJ(h, J, s, s->tsim);
#endif
#if RUN_USER_ROWS
    run_cons_hJ(h + N_CUT_ROWS, J + N_CUT_ROWS, s, s->tsim);
#endif
    (void) s, (void) h, (void) J;
}

/* Compute h and J of the constraints that are used. */
static void compute_used_constraints(Run *run)
{
    Partition *p = &run->partition;
    double *rows[N_ROWS + 1];

    for (int i = 0; i <= N_ROWS; i++)
        rows[i] = p->all_J[i];
    memset(p->all_J, 0, sizeof p->all_J);
    compute_constraints(run, p->all_h, rows);
    for (int i = 1; i <= p->n_dependent; i++) {
        p->h[i] = p->all_h[p->row[i]];
        memcpy(p->J[i], p->all_J[p->row[i]], sizeof p->J[i]);
    }
}

/* Set the column 0 of B to -dJ/dt q' of the constraints that are used. */
static void compute_drift(Run *run)
{
    Partition *p = &run->partition;

#if RUN_CUTS
    mbs_cons_jdqd(p->all_h, &run->data, run->data.tsim);
#endif
#if RUN_USER_ROWS
    run_cons_jdqd(p->all_h + N_CUT_ROWS, &run->data, run->data.tsim);
#endif
    for (int i = 1; i <= p->n_dependent; i++)
        p->B[i][0] = -p->all_h[p->row[i]];
}

/* LU = J_v, with row pivots, each row scaled by its largest number.  Return 0 if J_v is regular. */
static int factorize_constraints(Partition *p)
{
    const int n = p->n_dependent;
    double size[N_ROWS + 1] = {0};

    if (p->is_factorized && memcmp(p->factorized_J + 1, p->J + 1, n * sizeof *p->J) == 0)
        return 0;
    p->is_factorized = p->has_B = 0;
    for (int i = 1; i <= n; i++) {
        for (int j = 1; j <= N_JOINTS; j++)
            size[i] = fmax(size[i], fabs(p->J[i][j]));
        for (int j = 1; j <= n; j++)
            p->LU[i][j] = p->J[i][p->dependent[j]];
    }
    for (int k = 1; k <= n; k++) {
        int pivot = k;

        for (int i = k + 1; i <= n; i++)
            if (fabs(p->LU[i][k]) * size[pivot] > fabs(p->LU[pivot][k]) * size[i])
                pivot = i;
        if (!(fabs(p->LU[pivot][k]) > SINGULAR * size[pivot]))
            return -1;
        p->swapped[k] = pivot;
        size[pivot] = size[k];
        for (int j = 1; j <= n && pivot != k; j++) {
            const double x = p->LU[k][j];

            p->LU[k][j] = p->LU[pivot][j];
            p->LU[pivot][j] = x;
        }
        p->LU[k][k] = 1.0 / p->LU[k][k];
        for (int i = k + 1; i <= n; i++) {
            p->LU[i][k] *= p->LU[k][k];
            subtract(p->LU[i], p->LU[i][k], p->LU[k], k + 1, n);
        }
    }
    memcpy(p->factorized_J + 1, p->J + 1, n * sizeof *p->J);
    p->is_factorized = 1;
    return 0;
}

/* B = LU^-1 B, in some columns. */
static void solve_constraints(Partition *p, int first, int last)
{
    const int n = p->n_dependent;

    for (int k = 1; k <= n; k++)
        for (int j = first; j <= last && p->swapped[k] != k; j++) {
            const double x = p->B[k][j];

            p->B[k][j] = p->B[p->swapped[k]][j];
            p->B[p->swapped[k]][j] = x;
        }
    for (int i = 2; i <= n; i++)
        for (int k = 1; k < i; k++)
            subtract(p->B[i], p->LU[i][k], p->B[k], first, last);
    for (int i = n; i >= 1; i--) {
        for (int k = i + 1; k <= n; k++)
            subtract(p->B[i], p->LU[i][k], p->B[k], first, last);
        for (int j = first; j <= last; j++)
            p->B[i][j] *= p->LU[i][i];
    }
}

/* Find the leaders, the joints that J moves beside the dependent ones, and set B to -J_l. */
static void find_leaders(Partition *p)
{
    double size[N_JOINTS + 1] = {0};

    for (int i = 1; i <= p->n_dependent; i++)
        for (int j = 1; j <= N_JOINTS; j++)
            size[j] += fabs(p->J[i][j]);
    for (int i = 1; i <= p->n_dependent; i++)
        size[p->dependent[i]] = 0.0;
    p->n_leaders = 0;
    for (int j = 1; j <= N_JOINTS; j++)
        if (size[j] != 0.0) {
            p->leader[++p->n_leaders] = j;
            for (int i = 1; i <= p->n_dependent; i++)
                p->B[i][p->n_leaders] = -p->J[i][j];
        }
}

/* Set the positions of the dependent joints by Newton's method.  Return 0 if the loops could be closed. */
static int close_loops(Run *run)
{
    Partition *p = &run->partition;

    for (int turn = 0;; turn++) {
        int is_closed = 1;

        compute_used_constraints(run);
        for (int i = 1; i <= p->n_dependent; i++) {
            double size = 0.0; /* m of h for each rad: how large the model is */

            for (int j = 1; j <= N_JOINTS; j++)
                size = fmax(size, fabs(p->J[i][j]));
            is_closed &= fabs(p->h[i]) < CLOSED * size;
            p->B[i][0] = -p->h[i];
        }
        if (factorize_constraints(p))
            return -1;
        solve_constraints(p, 0, 0); /* once more where all is closed: what is left then is rounding */
        for (int i = 1; i <= p->n_dependent; i++)
            run->data.q[p->dependent[i]] += p->B[i][0];
        if (is_closed)
            return 0;
        if (turn == MAX_NEWTON_STEPS)
            return -1;
    }
}

/* Set q and qd of the dependent joints, B and b.  Return 0 if the loops could be closed. */
static int resolve_dependent_joints(Run *run)
{
    Partition *p = &run->partition;
    MbsData *s = &run->data;

    if (close_loops(run))
        return -1;
    if (!p->has_B) {
        find_leaders(p);
        solve_constraints(p, 1, p->n_leaders);
        p->has_B = 1;
    }
    for (int i = 1; i <= p->n_dependent; i++) {
        s->qd[p->dependent[i]] = 0.0;
        for (int j = 1; j <= p->n_leaders; j++)
            s->qd[p->dependent[i]] += p->B[i][j] * s->qd[p->leader[j]];
    }
    compute_drift(run);
    solve_constraints(p, 0, 0);
    return 0;
}

/* v'' = B l'' + b */
static void follow_leaders(Run *run)
{
    const Partition *p = &run->partition;
    double *qdd = run->data.qdd;

    for (int i = 1; i <= p->n_dependent; i++) {
        qdd[p->dependent[i]] = p->B[i][0];
        for (int j = 1; j <= p->n_leaders; j++)
            qdd[p->dependent[i]] += p->B[i][j] * qdd[p->leader[j]];
    }
}

/* --- accelerations --- */

/* Compute the forces of links and external forces on the bodies. */
static void compute_body_forces(MbsData *s)
{
    for (int i = 1; i <= N_JOINTS; i++)
        for (int k = 1; k <= 3; k++) {
            s->frc[k][i] = 0.0;
            s->trq[k][i] = 0.0;
        }
#if RUN_LINKS
    mbs_link(s->frc, s->trq, s->Fl, s->Z, s->Zd, s, s->tsim);
#endif
#if RUN_LINKS3D
    mbs_link3D(s->frc, s->trq, s, s->tsim);
#endif
#if RUN_FORCES
    mbs_extforces(s->frc, s->trq, s, s->tsim);
#endif
}

/* M = T' M T and Q = T' Q, in the rows and columns of the leaders. */
static void reduce(Partition *p)
{
    for (int i = 1; i <= p->n_dependent; i++)
        for (int j = 1; j <= p->n_leaders; j++) {
            const int leader = p->leader[j], dependent = p->dependent[i];
            const double b = p->B[i][j];

            if (b == 0.0)
                continue;
            p->Q[leader] += b * p->Q[dependent];
            subtract(p->M[leader], -b, p->M[dependent], 1, N_JOINTS);
            for (int k = 1; k <= N_JOINTS; k++)
                p->M[k][leader] += b * p->M[k][dependent];
        }
}

/* Solve M_uu qdd = Q_u by L' D L = M_uu, which fills no zero that a tree leaves (Featherstone, Rigid Body
   Dynamics Algorithms, 2008, 6.5).  Return 0 if M_uu is regular; the row 0 of A keeps its diagonal. */
static int solve_mass_matrix(Partition *p)
{
    const int n = p->n_independent, *joint = p->independent;

    for (int k = 1; k <= n; k++) {
        p->qdd[k] = p->Q[joint[k]];
        for (int i = 1; i <= k; i++)
            p->A[k][i] = p->M[joint[k]][joint[i]];
        p->A[0][k] = p->A[k][k];
    }
    for (int k = n; k >= 1; k--) {
        if (!(p->A[k][k] > SINGULAR * p->A[0][k]))
            return -1;
        p->A[k][k] = 1.0 / p->A[k][k];
        for (int i = k - 1; i >= 1; i--) {
            const double factor = p->A[k][i] * p->A[k][k];

            if (factor == 0.0)
                continue;
            subtract(p->A[i], factor, p->A[k], 1, i);
            p->A[k][i] = factor;
            p->qdd[i] -= factor * p->qdd[k];
        }
    }
    for (int k = 1; k <= n; k++) {
        p->qdd[k] *= p->A[k][k];
        for (int i = 1; i < k; i++)
            p->qdd[k] -= p->A[k][i] * p->qdd[i];
    }
    return 0;
}

/* Set q, qd and qdd of the dependent joints, and qdd of the independent ones.  Return 0 if that can be done. */
int compute_accelerations(Run *run)
{
    Partition *p = &run->partition;
    MbsData *s = &run->data;
    double *rows[N_JOINTS + 1];

    if (ANY_DRIVEN)
        run_DrivenJoints(s, s->tsim);
    if (p->n_dependent && resolve_dependent_joints(run))
        return -1;
    compute_body_forces(s);
    user_call_JointForces(s, s->tsim);
    for (int i = 0; i <= N_JOINTS; i++)
        rows[i] = p->M[i];
    memset(p->M, 0, sizeof p->M);
    mbs_dirdyna(rows, p->Q, s, s->tsim);
    for (int j = 1; j <= p->n_independent; j++)
        s->qdd[p->independent[j]] = 0.0;
    follow_leaders(run);
    for (int k = 1; k <= N_JOINTS; k++)
        p->Q[k] = s->Qq[k] - p->Q[k];
    for (int k = 1; k <= N_JOINTS; k++)
        subtract(p->Q, s->qdd[k], p->M[k], 1, N_JOINTS);
    reduce(p);
    if (solve_mass_matrix(p))
        return -1;
    for (int j = 1; j <= p->n_independent; j++)
        s->qdd[p->independent[j]] = p->qdd[j];
    follow_leaders(run);
    return 0;
}

/* Compute dq/du of a joint, by all independent ones, from 0. */
void compute_dq_du(const Run *run, int joint, double *dq_du)
{
    const Partition *p = &run->partition;

    for (int u = 1; u <= p->n_independent; u++)
        dq_du[u - 1] = p->independent[u] == joint;
    for (int i = 1; i <= p->n_dependent; i++)
        for (int j = 1; j <= p->n_leaders && p->dependent[i] == joint; j++)
            for (int u = 1; u <= p->n_independent; u++)
                if (p->independent[u] == p->leader[j])
                    dq_du[u - 1] = p->B[i][j];
}
