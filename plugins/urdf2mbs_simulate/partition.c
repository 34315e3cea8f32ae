/* Accelerations with a partition of the joints that may change while a simulation runs (coordinate reduction:
   Wehage and Haug, Journal of Mechanical Design 104, 1982; Robotran's accelred).

   The joints q are independent (u), dependent (v) or driven (c).  As many constraints h(q) = 0 are used as there
   are dependent joints; J = dh/dq:

       J_v dv = -h                                Newton's method, for the positions of v
       v' = B l'        B = -J_v^-1 J_l           where l are the leaders: those u and c on which v depend
       v'' = B l'' + b  b = -J_v^-1 (dJ/dt q')    b is the column 0 of B
       T' M T u'' = T' (Q - c - M q''_0)          T = [1; B], and q''_0 are the accelerations for u'' = 0

   In M q'' + c = Q, M is the mass matrix, and Q has the forces in joints; c has all other forces.  Generated
   files of accelred (accelred.c of the equations) do the same for one partition. */
#include <math.h>
#include <string.h>

#include "runtime.h"

/* A pivot is 0 if it is smaller relative to its row of J, or to its element of A. */
static const double SINGULAR = 1e-13;
/* A loop is closed where a joint could close it by a smaller move (rad, m). */
static const double CLOSED = 1e-9;
static const int MAX_NEWTON_STEPS = 100;

void mbs_cons_hJ(double *h, double **J, MbsData *data, double tsim);
void mbs_cons_jdqd(double *jdqd, MbsData *data, double tsim);
void mbs_link(double **frc, double **trq, double *Fl, double *Z, double *Zd, MbsData *data, double tsim);
void mbs_link3D(double **frc, double **trq, MbsData *data, double tsim);
void mbs_extforces(double **frc, double **trq, MbsData *data, double tsim);
double *user_call_JointForces(MbsData *data, double tsim);

/* Set the joints, those of MbsData, and the used equations: as many rows as there are dependent joints. */
void set_partition(Run *run, const int *rows)
{
    Partition *partition = &run->partition;
    const MbsData *data = &run->data;

    partition->n_dependent = data->nqv;
    partition->n_independent = data->nqu;
    memcpy(partition->dependent, data->qv, (data->nqv + 1) * sizeof *partition->dependent);
    memcpy(partition->independent, data->qu, (data->nqu + 1) * sizeof *partition->independent);
    memcpy(partition->row + 1, rows, data->nqv * sizeof *partition->row);
    partition->is_factorized = 0;
    partition->has_B = 0;
}

/* row -= factor * pivot_row, in the columns from first to last.  Most factors are 0. */
static void subtract_row(double *row, double factor, const double *pivot_row, int first, int last)
{
    if (factor != 0.0)
        for (int j = first; j <= last; j++)
            row[j] -= factor * pivot_row[j];
}

static void swap(double *a, double *b)
{
    const double x = *a;

    *a = *b;
    *b = x;
}

/* --- constraints --- */

/* Compute h and J of all constraints, those of the cuts first, from index 1.  J must be 0 before. */
void compute_constraints(Run *run, double *h, double **J)
{
    MbsData *data = &run->data;

#if RUN_CUTS
    mbs_cons_hJ(h, J, data, data->tsim);
#endif
#if RUN_USER_ROWS
    run_cons_hJ(h + N_CUT_ROWS, J + N_CUT_ROWS, data, data->tsim);
#endif
    (void) data, (void) h, (void) J;
}

/* Compute h and J of the constraints that are used. */
static void compute_used_constraints(Run *run)
{
    Partition *partition = &run->partition;
    double *rows[N_ROWS + 1];

    for (int i = 0; i <= N_ROWS; i++)
        rows[i] = partition->all_J[i];
    memset(partition->all_J, 0, sizeof partition->all_J);
    compute_constraints(run, partition->all_h, rows);
    for (int i = 1; i <= partition->n_dependent; i++) {
        partition->h[i] = partition->all_h[partition->row[i]];
        memcpy(partition->J[i], partition->all_J[partition->row[i]], sizeof partition->J[i]);
    }
}

/* Set the column 0 of B to -dJ/dt q' of the constraints that are used. */
static void compute_drift(Run *run)
{
    Partition *partition = &run->partition;

#if RUN_CUTS
    mbs_cons_jdqd(partition->all_h, &run->data, run->data.tsim);
#endif
#if RUN_USER_ROWS
    run_cons_jdqd(partition->all_h + N_CUT_ROWS, &run->data, run->data.tsim);
#endif
    for (int i = 1; i <= partition->n_dependent; i++)
        partition->B[i][0] = -partition->all_h[partition->row[i]];
}

/* LU = J_v, with pivots by rows that are scaled by their largest element.  Return 0, or -1 if J_v is singular. */
static int factorize_constraints(Partition *partition)
{
    const int n = partition->n_dependent;
    double size[N_ROWS + 1] = {0};

    if (partition->is_factorized
        && memcmp(partition->factorized_J + 1, partition->J + 1, n * sizeof *partition->J) == 0)
        return 0;
    partition->is_factorized = partition->has_B = 0;
    for (int i = 1; i <= n; i++) {
        for (int j = 1; j <= N_JOINTS; j++)
            size[i] = fmax(size[i], fabs(partition->J[i][j]));
        for (int j = 1; j <= n; j++)
            partition->LU[i][j] = partition->J[i][partition->dependent[j]];
    }
    for (int k = 1; k <= n; k++) {
        int pivot = k;

        for (int i = k + 1; i <= n; i++)
            if (fabs(partition->LU[i][k]) * size[pivot] > fabs(partition->LU[pivot][k]) * size[i])
                pivot = i;
        if (!(fabs(partition->LU[pivot][k]) > SINGULAR * size[pivot]))
            return -1;
        partition->pivot_row[k] = pivot;
        size[pivot] = size[k];
        for (int j = 1; j <= n && pivot != k; j++)
            swap(&partition->LU[k][j], &partition->LU[pivot][j]);
        partition->LU[k][k] = 1.0 / partition->LU[k][k];
        for (int i = k + 1; i <= n; i++) {
            partition->LU[i][k] *= partition->LU[k][k];
            subtract_row(partition->LU[i], partition->LU[i][k], partition->LU[k], k + 1, n);
        }
    }
    memcpy(partition->factorized_J + 1, partition->J + 1, n * sizeof *partition->J);
    partition->is_factorized = 1;
    return 0;
}

/* B = J_v^-1 B, in the columns from first to last. */
static void solve_constraints(Partition *partition, int first, int last)
{
    const int n = partition->n_dependent;

    for (int k = 1; k <= n; k++)
        for (int j = first; j <= last && partition->pivot_row[k] != k; j++)
            swap(&partition->B[k][j], &partition->B[partition->pivot_row[k]][j]);
    for (int i = 2; i <= n; i++)
        for (int k = 1; k < i; k++)
            subtract_row(partition->B[i], partition->LU[i][k], partition->B[k], first, last);
    for (int i = n; i >= 1; i--) {
        for (int k = i + 1; k <= n; k++)
            subtract_row(partition->B[i], partition->LU[i][k], partition->B[k], first, last);
        for (int j = first; j <= last; j++)
            partition->B[i][j] *= partition->LU[i][i];
    }
}

/* Find the leaders, the joints with nonzero columns of J beside the dependent ones, and set B to -J_l. */
static void find_leaders(Partition *partition)
{
    double size[N_JOINTS + 1] = {0};

    for (int i = 1; i <= partition->n_dependent; i++)
        for (int j = 1; j <= N_JOINTS; j++)
            size[j] += fabs(partition->J[i][j]);
    for (int i = 1; i <= partition->n_dependent; i++)
        size[partition->dependent[i]] = 0.0;
    partition->n_leaders = 0;
    for (int j = 1; j <= N_JOINTS; j++)
        if (size[j] != 0.0) {
            partition->leader[++partition->n_leaders] = j;
            for (int i = 1; i <= partition->n_dependent; i++)
                partition->B[i][partition->n_leaders] = -partition->J[i][j];
        }
}

/* Set the positions of the dependent joints by Newton's method.  Return 0, or -1 if it failed. */
static int close_loops(Run *run)
{
    Partition *partition = &run->partition;

    for (int n_steps = 0;; n_steps++) {
        int is_closed = 1;

        compute_used_constraints(run);
        for (int i = 1; i <= partition->n_dependent; i++) {
            double size = 0.0; /* dh for a move of 1 rad or m */

            for (int j = 1; j <= N_JOINTS; j++)
                size = fmax(size, fabs(partition->J[i][j]));
            is_closed &= fabs(partition->h[i]) < CLOSED * size;
            partition->B[i][0] = -partition->h[i];
        }
        if (factorize_constraints(partition))
            return -1;
        solve_constraints(partition, 0, 0); /* one step more after all loops are closed: rounding is left */
        for (int i = 1; i <= partition->n_dependent; i++)
            run->data.q[partition->dependent[i]] += partition->B[i][0];
        if (is_closed)
            return 0;
        if (n_steps == MAX_NEWTON_STEPS)
            return -1;
    }
}

/* Set q and qd of the dependent joints, B and b.  Return 0, or -1 if the loops cannot be closed. */
static int resolve_dependent_joints(Run *run)
{
    Partition *partition = &run->partition;
    MbsData *data = &run->data;

    if (close_loops(run))
        return -1;
    if (!partition->has_B) {
        find_leaders(partition);
        solve_constraints(partition, 1, partition->n_leaders);
        partition->has_B = 1;
    }
    for (int i = 1; i <= partition->n_dependent; i++) {
        data->qd[partition->dependent[i]] = 0.0;
        for (int j = 1; j <= partition->n_leaders; j++)
            data->qd[partition->dependent[i]] += partition->B[i][j] * data->qd[partition->leader[j]];
    }
    compute_drift(run);
    solve_constraints(partition, 0, 0);
    return 0;
}

/* v'' = B l'' + b */
static void follow_leaders(Run *run)
{
    const Partition *partition = &run->partition;
    double *qdd = run->data.qdd;

    for (int i = 1; i <= partition->n_dependent; i++) {
        qdd[partition->dependent[i]] = partition->B[i][0];
        for (int j = 1; j <= partition->n_leaders; j++)
            qdd[partition->dependent[i]] += partition->B[i][j] * qdd[partition->leader[j]];
    }
}

/* --- accelerations --- */

/* Compute frc and trq: the links' and the external forces on the bodies. */
static void compute_body_forces(MbsData *data)
{
    for (int i = 1; i <= N_JOINTS; i++)
        for (int k = 1; k <= 3; k++) {
            data->frc[k][i] = 0.0;
            data->trq[k][i] = 0.0;
        }
#if RUN_LINKS
    mbs_link(data->frc, data->trq, data->Fl, data->Z, data->Zd, data, data->tsim);
#endif
#if RUN_LINKS3D
    mbs_link3D(data->frc, data->trq, data, data->tsim);
#endif
#if RUN_FORCES
    mbs_extforces(data->frc, data->trq, data, data->tsim);
#endif
}

/* M = T' M T and Q = T' Q, in the rows and columns of the leaders: row and column l of M, and Q_l, get those of
   v, times B. */
static void reduce(Partition *partition)
{
    for (int i = 1; i <= partition->n_dependent; i++)
        for (int j = 1; j <= partition->n_leaders; j++) {
            const int leader = partition->leader[j], dependent = partition->dependent[i];
            const double b = partition->B[i][j];

            if (b == 0.0)
                continue;
            partition->Q[leader] += b * partition->Q[dependent];
            subtract_row(partition->M[leader], -b, partition->M[dependent], 1, N_JOINTS);
            for (int k = 1; k <= N_JOINTS; k++)
                partition->M[k][leader] += b * partition->M[k][dependent];
        }
}

/* Solve M_uu u'' = Q_u by L' D L = M_uu, which keeps the zeros between the branches of a tree (Featherstone,
   Rigid Body Dynamics Algorithms, 2008, 6.5).  Return 0, or -1 if M_uu is singular.

   A has L and, on its diagonal, the inverse of D; its row 0 is the diagonal of M_uu. */
static int solve_mass_matrix(Partition *partition)
{
    const int n = partition->n_independent, *joint = partition->independent;

    for (int k = 1; k <= n; k++) {
        partition->qdd[k] = partition->Q[joint[k]];
        for (int i = 1; i <= k; i++)
            partition->A[k][i] = partition->M[joint[k]][joint[i]];
        partition->A[0][k] = partition->A[k][k];
    }
    for (int k = n; k >= 1; k--) {
        if (!(partition->A[k][k] > SINGULAR * partition->A[0][k]))
            return -1;
        partition->A[k][k] = 1.0 / partition->A[k][k];
        for (int i = k - 1; i >= 1; i--) {
            const double factor = partition->A[k][i] * partition->A[k][k];

            if (factor == 0.0)
                continue;
            subtract_row(partition->A[i], factor, partition->A[k], 1, i);
            partition->A[k][i] = factor;
            partition->qdd[i] -= factor * partition->qdd[k];
        }
    }
    for (int k = 1; k <= n; k++) {
        partition->qdd[k] *= partition->A[k][k];
        for (int i = 1; i < k; i++)
            partition->qdd[k] -= partition->A[k][i] * partition->qdd[i];
    }
    return 0;
}

/* Set q, qd and qdd of the dependent joints, and qdd of the independent ones.  Return 0, or -1 if it failed. */
int compute_accelerations(Run *run)
{
    Partition *partition = &run->partition;
    MbsData *data = &run->data;
    double *rows[N_JOINTS + 1];

    if (ANY_DRIVEN)
        run_DrivenJoints(data, data->tsim);
    if (partition->n_dependent && resolve_dependent_joints(run))
        return -1;
    compute_body_forces(data);
    user_call_JointForces(data, data->tsim);
    for (int i = 0; i <= N_JOINTS; i++)
        rows[i] = partition->M[i];
    memset(partition->M, 0, sizeof partition->M);
    mbs_dirdyna(rows, partition->Q, data, data->tsim);
    for (int j = 1; j <= partition->n_independent; j++)
        data->qdd[partition->independent[j]] = 0.0;
    follow_leaders(run);
    for (int k = 1; k <= N_JOINTS; k++)
        partition->Q[k] = data->Qq[k] - partition->Q[k];
    for (int k = 1; k <= N_JOINTS; k++)
        subtract_row(partition->Q, data->qdd[k], partition->M[k], 1, N_JOINTS);
    reduce(partition);
    if (solve_mass_matrix(partition))
        return -1;
    for (int j = 1; j <= partition->n_independent; j++)
        data->qdd[partition->independent[j]] = partition->qdd[j];
    follow_leaders(run);
    return 0;
}

/* Compute dq/du of a joint, by all independent ones, from index 0. */
void compute_dq_du(const Run *run, int joint, double *dq_du)
{
    const Partition *partition = &run->partition;

    for (int u = 1; u <= partition->n_independent; u++)
        dq_du[u - 1] = partition->independent[u] == joint;
    for (int i = 1; i <= partition->n_dependent; i++)
        for (int j = 1; j <= partition->n_leaders && partition->dependent[i] == joint; j++)
            for (int u = 1; u <= partition->n_independent; u++)
                if (partition->independent[u] == partition->leader[j])
                    dq_du[u - 1] = partition->B[i][j];
}
