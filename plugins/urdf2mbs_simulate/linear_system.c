/* The linear system of a stage: A of slopes.c is assembled, factorized and solved in its nonzero elements. */
#include "runtime.h"

/* List the nonzero elements, with fill-in: the elimination of row k couples all of its columns. */
void list_nonzeros(Jacobian *jacobian)
{
    for (int k = jacobian->n_unknowns - 1; k >= 0; k--) {
        int *list = jacobian->nonzero_column[k], n = 0;

        for (int j = 0; j < k; j++)
            if (jacobian->is_nonzero[k][j])
                list[n++] = j;
        jacobian->n_nonzero[k] = n;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < i; j++)
                jacobian->is_nonzero[list[i]][list[j]] = 1;
    }
}

/* A = M - h D - h^2 K */
static void compute_matrix(Jacobian *jacobian, double h)
{
    for (int i = 0; i < jacobian->n_unknowns; i++) {
        const double *M = jacobian->M[i], *D = jacobian->D[i], *K = jacobian->K[i];

        jacobian->A[i][i] = M[i] - h * (D[i] + h * K[i]);
        for (int m = 0; m < jacobian->n_nonzero[i]; m++) {
            const int j = jacobian->nonzero_column[i][m];

            jacobian->A[i][j] = M[j] - h * (D[j] + h * K[j]);
            jacobian->A[j][i] = jacobian->M[j][i] - h * (jacobian->D[j][i] + h * jacobian->K[j][i]);
        }
    }
}

/* A = U L with U unit upper and L lower triangular, both in A.  For k from the last to the first:

       U_ik = A_ik / A_kk      A_ij -= U_ik A_kj      (i, j < k) */
static void factorize(Jacobian *jacobian)
{
    for (int k = jacobian->n_unknowns - 1; k >= 0; k--) {
        const int n = jacobian->n_nonzero[k], *list = jacobian->nonzero_column[k];
        const double *pivot_row = jacobian->A[k];

        for (int m = 0; m < n; m++) {
            double *row = jacobian->A[list[m]];

            row[k] /= pivot_row[k];
            if (row[k] == 0.0)
                continue;
            for (int j = 0; j < n; j++)
                row[list[j]] -= row[k] * pivot_row[list[j]];
        }
    }
}

/* b = M (h g_v) + K (h^2 g_q), where each nonzero pair of a row and a column is in the list of the later one. */
static void compute_right_side(const Jacobian *jacobian, int n_independent, double h, const double *g, double *b)
{
    const double *g_w = g + 2 * n_independent - 1; /* from 1 */
    double h_g_v[MAX_UNKNOWNS] = {0}, h2_g_q[MAX_UNKNOWNS] = {0};

    for (int i = 0; i < jacobian->n_unknowns; i++) {
        const int is_speed = i < n_independent;
        const double *M = jacobian->M[i], *K = jacobian->K[i];

        h_g_v[i] = h * (is_speed ? g[n_independent + i] : g_w[jacobian->state_of_unknown[i]]);
        h2_g_q[i] = is_speed ? h * h * g[i] : 0.0;
        b[i] = M[i] * h_g_v[i] + K[i] * h2_g_q[i];
        for (int m = 0; m < jacobian->n_nonzero[i]; m++) {
            const int j = jacobian->nonzero_column[i][m];

            b[i] += M[j] * h_g_v[j] + K[j] * h2_g_q[j];
            b[j] += jacobian->M[j][i] * h_g_v[i] + jacobian->K[j][i] * h2_g_q[i];
        }
    }
}

/* Solve U z = b, from the last row on, then L x = z, from the first; x is put into b. */
static void solve_factorized(const Jacobian *jacobian, double *b)
{
    for (int k = jacobian->n_unknowns - 1; k >= 0; k--)
        for (int m = 0; m < jacobian->n_nonzero[k]; m++) {
            const int i = jacobian->nonzero_column[k][m];

            b[i] -= jacobian->A[i][k] * b[k];
        }
    for (int k = 0; k < jacobian->n_unknowns; k++) {
        const double *row = jacobian->A[k];

        for (int m = 0; m < jacobian->n_nonzero[k]; m++)
            b[k] -= row[jacobian->nonzero_column[k][m]] * b[jacobian->nonzero_column[k][m]];
        b[k] /= row[k];
    }
}

/* Solve (1 - h J) k = h g.  Both g and k are of the size of the state: q, u, w.

       A k_v = h (M g_v + h K g_q)      k_q = h (g_q + k_u)

   States that are not among the unknowns are explicit: k_w = h g_w. */
void solve_stage(Run *run, double h, const double *g, double *k)
{
    Jacobian *jacobian = &run->jacobian;
    const int n_independent = run->data.nqu, before_w = 2 * n_independent - 1;
    double k_v[MAX_UNKNOWNS] = {0};

    if (h != jacobian->factorized_h) {
        jacobian->factorized_h = h;
        compute_matrix(jacobian, h);
        factorize(jacobian);
    }
    compute_right_side(jacobian, n_independent, h, g, k_v);
    solve_factorized(jacobian, k_v);
    for (int i = 1; i <= N_STATES; i++)
        k[before_w + i] = h * g[before_w + i];
    for (int i = 0; i < jacobian->n_unknowns; i++)
        k[i < n_independent ? n_independent + i : before_w + jacobian->state_of_unknown[i]] = k_v[i];
    for (int i = 0; i < n_independent; i++)
        k[i] = h * (g[i] + k[n_independent + i]);
}
