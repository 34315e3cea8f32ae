/* Equations of motion for Python: a call computes one state, or many, one after the other.

   The file is compiled once for each function, with -DMASS_MATRIX and so on.

   The caller has n joints, from index 0, with u, u' and u''.  The equations have all joints of the
   model, from index 1.  Joints that never move stay at q0; followers (<mimic>) move with their
   leaders, so that with constant T and q0

       q = T u + q0           q' = T u'            q'' = T u''

   Forces do the same work along u as along q.  Mass matrix, bias and inverse dynamics, Jacobians
   and derivatives are those of all joints, reduced:

       M = T^T M_q T          f = T^T f_q          J = J_q T          df/du = T^T (df_q/dq) T */
#include <string.h>

#include "mbs_data.h"
#include "mbs_sensor.h"

/* A pivot is 0 if it is this much smaller than its diagonal element of M. */
#define SINGULAR 1e-13

/* Code for processors with vectors of four numbers, beside code for all others: the same sums. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__GLIBC__)
#define WIDE_VECTORS __attribute__((target_clones("avx2", "default")))
#else
#define WIDE_VECTORS
#endif

/* An element of T: a follower moves by factor for each unit of its leader. */
typedef struct Coupling {
    int follower, leader;
    double factor;
} Coupling;

/* Joints of the caller, from an index, that follow one another in the model, from a number. */
typedef struct JointRun {
    int index, number, length;
} JointRun;

/* What Python gives: see CallInC in memory.py. */
typedef struct Call {
    MbsData *s;
    int n_all, n;     /* joints of the model, and of the caller */
    int n_runs;
    const JointRun *run; /* the caller's joints */
    int n_couplings;
    const Coupling *coupling;
    const double *q0, *zeros; /* (n_all + 1) */
    int n_independent;
    const int *independent; /* indices of the caller's joints that are not driven */
    int place, point;       /* the last joint of a body, and a point of it; 0 is its origin */
    int n_parameters;       /* columns of the regressor */
    int n_states, n_numbers; /* numbers of an output, for a state */
    const double *input[3]; /* (n_states, n): what the function does not take is null, for zeros */
    double *output[3];      /* (n_states, n_numbers) */
    double **table[3];      /* rows of all joints, from index 1; zeros before the first call */
    double *matrix[3];      /* (n, n) */
    double *vector;         /* (n_all + 1) */
    double *bias;           /* (n) */
    double *factors;        /* (n, n): L, and the inverse of D on its diagonal */
    double *columns;        /* (n, 3 n) */
    int singular;           /* the caller's joint whose pivot was 0 */
} Call;

int evaluate(Call *call);

/* --- from all joints to the caller's --- */

/* True if T is the unit matrix: the equations then fill the results themselves. */
static int is_whole(const Call *call)
{
    return call->n == call->n_all;
}

/* x = T u + x0 */
static void spread(const Call *call, const double *u, const double *x0, double *x)
{
    memcpy(x, x0, (call->n_all + 1) * sizeof *x);
    for (int i = 0; u && i < call->n_runs; i++)
        memcpy(x + call->run[i].number, u + call->run[i].index, call->run[i].length * sizeof *x);
    for (int i = 0; i < call->n_couplings; i++) {
        const Coupling *c = &call->coupling[i];
        x[c->follower] += c->factor * x[c->leader];
    }
}

/* f = T^T f_q, which changes f_q. */
static void reduce_vector(const Call *call, double *restrict f_q, double *restrict f)
{
    for (int i = 0; i < call->n_couplings; i++) {
        const Coupling *c = &call->coupling[i];
        f_q[c->leader] += c->factor * f_q[c->follower];
    }
    for (const JointRun *run = call->run; run < call->run + call->n_runs; run++)
        for (int k = 0; k < run->length; k++)
            f[run->index + k] = f_q[run->number + k];
}

/* Add the rows of followers to those of their leaders: T^T A. */
static void reduce_rows(const Call *call, double **rows, int n_columns)
{
    for (int i = 0; i < call->n_couplings; i++) {
        const Coupling *c = &call->coupling[i];
        for (int k = 1; k <= n_columns; k++)
            rows[c->leader][k] += c->factor * rows[c->follower][k];
    }
}

/* Return the rows, from index 1, that the equations are to fill for a matrix (n, n_columns).
   Elements that are always zero are not filled. */
static double **begin(const Call *call, int number, double *matrix, int n_columns)
{
    double **rows = call->table[number];
    if (is_whole(call))
        memset(matrix, 0, (size_t)call->n * n_columns * sizeof *matrix);
    for (int k = 1; k <= call->n_all; k++) {
        if (is_whole(call))
            rows[k] = matrix + (k - 1) * n_columns - 1;
        else if (call->n_couplings) /* it was changed by the reduction */
            memset(rows[k], 0, (n_columns + 1) * sizeof **rows);
    }
    return rows;
}

/* matrix = T^T A T, with the rows of ``begin``. */
static void finish(const Call *call, int number, double *matrix)
{
    double **rows = call->table[number];
    if (is_whole(call))
        return;
    reduce_rows(call, rows, call->n_all);
    for (int i = 0; i < call->n_runs; i++)
        for (int k = 0; k < call->run[i].length; k++)
            reduce_vector(call, rows[call->run[i].number + k],
                          matrix + (call->run[i].index + k) * call->n);
}

/* --- the functions --- */

#if defined MASS_MATRIX || defined FORWARD_DYNAMICS || defined FORWARD_DERIVATIVES
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);

static void compute_mass_matrix(const Call *call, double *M)
{
    mbs_dirdyna(begin(call, 0, M, call->n_all), call->vector, call->s, 0.0);
    finish(call, 0, M);
}
#endif

#ifdef MASS_MATRIX
static int compute(Call *call, double **output, const double *unused)
{
    compute_mass_matrix(call, output[0]);
    return 0;
}
#endif

#if defined BIAS || defined INVERSE_DYNAMICS
void mbs_invdyna(double *phi, MbsData *s, double tsim);

static int compute(Call *call, double **output, const double *unused)
{
    mbs_invdyna(call->vector, call->s, 0.0);
    reduce_vector(call, call->vector, output[0]);
    return 0;
}
#endif

#if defined INVERSE_DERIVATIVES || defined FORWARD_DERIVATIVES
void mbs_derivatives(double **Dq, double **Dqd, double **Dqdd, MbsData *s);

static void compute_inverse_derivatives(const Call *call, double *by_q, double *by_qd,
                                        double *by_qdd)
{
    const int n = call->n_all;
    double **Dq = begin(call, 0, by_q, n), **Dqd = begin(call, 1, by_qd, n);
    mbs_derivatives(Dq, Dqd, begin(call, 2, by_qdd, n), call->s);
    finish(call, 0, by_q);
    finish(call, 1, by_qd);
    finish(call, 2, by_qdd);
}
#endif

#ifdef INVERSE_DERIVATIVES
static int compute(Call *call, double **output, const double *unused)
{
    compute_inverse_derivatives(call, output[0], output[1], output[2]);
    return 0;
}
#endif

#if defined FORWARD_DYNAMICS || defined FORWARD_DERIVATIVES
/* row = row - factor * pivot_row; most factors are 0. */
static inline void subtract_multiple(double *restrict row, double factor,
                              const double *restrict pivot_row, int n_columns)
{
    if (factor != 0.0)
        for (int j = 0; j < n_columns; j++)
            row[j] -= factor * pivot_row[j];
}

/* Factorize the mass matrix of the independent joints, A = L^T D L, which keeps the zeros between
   branches of a tree (Featherstone, Rigid Body Dynamics Algorithms, 2008, 6.5). Return -1 if A is
   singular, else 0. */
static int factorize(Call *call, const double *M)
{
    const int n = call->n;
    double *A = call->factors;
    for (int k = 0; k < call->n_independent; k++)
        for (int i = 0; i <= k; i++)
            A[k * n + i] = M[call->independent[k] * n + call->independent[i]];
    for (int k = call->n_independent - 1; k >= 0; k--) {
        double *row = A + k * n, size = M[call->independent[k] * (n + 1)];
        if (!(row[k] > SINGULAR * size)) {
            call->singular = call->independent[k];
            return -1;
        }
        row[k] = 1.0 / row[k];
        for (int i = k - 1; i >= 0; i--) {
            if (row[i] == 0.0)
                continue;
            const double factor = row[i] * row[k];
            subtract_multiple(A + i * n, factor, row, i + 1);
            row[i] = factor;
        }
    }
    return 0;
}

/* Solve A X = X, with a row of X for each independent joint. */
WIDE_VECTORS static void solve(const Call *call, double *X, int n_columns)
{
    const int n = call->n;
    const double *A = call->factors;
    for (int k = call->n_independent - 1; k >= 0; k--) /* X = L^-T X */
        for (int i = 0; i < k; i++)
            subtract_multiple(X + i * n_columns, A[k * n + i], X + k * n_columns, n_columns);
    for (int k = 0; k < call->n_independent; k++) { /* X = L^-1 D^-1 X */
        for (int j = 0; j < n_columns; j++)
            X[k * n_columns + j] *= A[k * n + k];
        for (int i = 0; i < k; i++)
            subtract_multiple(X + k * n_columns, A[k * n + i], X + i * n_columns, n_columns);
    }
}

/* qdd = A^-1 (tau - bias); driven joints do not accelerate. Return -1 if A is singular, else 0. */
static int accelerate(Call *call, const double *tau, double *qdd)
{
    double *x = call->columns;
    compute_mass_matrix(call, call->matrix[0]);
    reduce_vector(call, call->vector, call->bias);
    if (factorize(call, call->matrix[0]))
        return -1;
    for (int k = 0; k < call->n_independent; k++)
        x[k] = tau[call->independent[k]] - call->bias[call->independent[k]];
    solve(call, x, 1);
    for (int k = 0; k < call->n_independent; k++)
        qdd[call->independent[k]] = x[k];
    return 0;
}
#endif

#ifdef FORWARD_DYNAMICS
static int compute(Call *call, double **output, const double *tau)
{
    memset(output[0], 0, call->n * sizeof *output[0]);
    return accelerate(call, tau, output[0]);
}
#endif

#ifdef FORWARD_DERIVATIVES
/* With A qdd + bias = tau, and the derivatives of inverse dynamics at this qdd:

       dqdd/du = -A^-1 dtau/du        dqdd/du' = -A^-1 dtau/du'        dqdd/dtau = A^-1 */
static int compute(Call *call, double **output, const double *tau)
{
    const int n = call->n, width = 3 * n;
    double *X = call->columns, *qdd = output[0]; /* for a while */
    memset(qdd, 0, n * sizeof *qdd);
    if (accelerate(call, tau, qdd))
        return -1;
    spread(call, qdd, call->zeros, call->s->qdd);
    compute_inverse_derivatives(call, call->matrix[1], call->matrix[2], call->matrix[0]);
    memset(X, 0, call->n_independent * width * sizeof *X);
    for (int k = 0; k < call->n_independent; k++) {
        const int row = call->independent[k];
        for (int j = 0; j < n; j++) {
            X[k * width + j] = -call->matrix[1][row * n + j];
            X[k * width + n + j] = -call->matrix[2][row * n + j];
        }
        X[k * width + 2 * n + row] = 1.0;
    }
    solve(call, X, width);
    for (int part = 0; part < 3 && call->n_independent < n; part++)
        memset(output[part], 0, n * n * sizeof *X);
    for (int k = 0; k < call->n_independent; k++)
        for (int part = 0; part < 3; part++)
            memcpy(output[part] + call->independent[k] * n, X + k * width + part * n,
                   n * sizeof *X);
    return 0;
}
#endif

#ifdef REGRESSOR
void mbs_regressor(double **Y, MbsData *s);

static int compute(Call *call, double **output, const double *unused)
{
    double **Y = begin(call, 0, output[0], call->n_parameters);
    mbs_regressor(Y, call->s);
    reduce_rows(call, Y, call->n_parameters);
    for (int i = 0; i < call->n_runs && !is_whole(call); i++)
        for (int k = 0; k < call->run[i].length; k++)
            memcpy(output[0] + (call->run[i].index + k) * call->n_parameters,
                   Y[call->run[i].number + k] + 1, call->n_parameters * sizeof **Y);
    return 0;
}
#endif

#ifdef ENERGY
void mbs_energy(double *E, MbsData *s);

static int compute(Call *call, double **output, const double *unused)
{
    mbs_energy(output[0] - 1, call->s);
    return 0;
}
#endif

#ifdef CENTRE_OF_MASS
void mbs_com(double *P, MbsData *s);

static int compute(Call *call, double **output, const double *unused)
{
    mbs_com(output[0] - 1, call->s);
    return 0;
}
#endif

#ifdef MOMENTUM
void mbs_momentum(double *P, double *L, MbsData *s);

static int compute(Call *call, double **output, const double *unused)
{
    mbs_momentum(output[0] - 1, output[0] + 2, call->s);
    return 0;
}
#endif

#if defined POSITION || defined JACOBIAN
void mbs_gensensor(MbsSensor *sens, MbsData *s, int isens);

/* Compute the frame after a joint, and the lever from its origin to a point, in base axes. The rows
   of R are the axes of the frame. */
static void compute_frame(const Call *call, MbsSensor *sens, double *lever)
{
    memset(sens, 0, sizeof *sens);
    for (int axis = 1; axis <= 3; axis++)
        sens->R[axis][axis] = 1.0;
    for (int row = 1; row <= 6; row++) {
        sens->J[row] = call->table[0][row];
        memset(sens->J[row], 0, (call->n_all + 1) * sizeof(double));
    }
    if (call->place) /* 0 is the base */
        mbs_gensensor(sens, call->s, call->place);
    for (int k = 1; k <= 3; k++) {
        lever[k] = 0.0;
        for (int axis = 1; axis <= 3; axis++)
            lever[k] += sens->R[axis][k] * call->s->dpt[axis][call->point];
    }
}
#endif

#ifdef POSITION
static int compute(Call *call, double **output, const double *unused)
{
    MbsSensor sens;
    double lever[4];
    compute_frame(call, &sens, lever);
    for (int k = 1; k <= 3; k++)
        output[0][k - 1] = sens.P[k] + lever[k];
    return 0;
}
#endif

#ifdef JACOBIAN
/* The point at the lever r from the origin P moves with v = v_P + omega x r. */
static int compute(Call *call, double **output, const double *unused)
{
    MbsSensor sens;
    double lever[4];
    compute_frame(call, &sens, lever);
    for (int k = 1; k <= 3; k++) {
        const int i = k % 3 + 1, j = (k + 1) % 3 + 1;
        for (int joint = 1; joint <= call->n_all; joint++)
            sens.J[k][joint] += sens.J[3 + i][joint] * lever[j] - sens.J[3 + j][joint] * lever[i];
    }
    for (int row = 1; row <= 6; row++)
        reduce_vector(call, sens.J[row], output[0] + (row - 1) * call->n);
    return 0;
}
#endif

/* Compute all states. Return 0, or the number of the state, from 1, whose M is singular. */
int evaluate(Call *call)
{
    MbsData *s = call->s;
    for (int state = 0; state < call->n_states; state++) {
        const double *input[3];
        double *output[3];
        for (int k = 0; k < 3; k++) {
            input[k] = call->input[k] ? call->input[k] + (size_t)state * call->n : 0;
            output[k] = call->output[k] + (size_t)state * call->n_numbers;
        }
        spread(call, input[0], call->q0, s->q);
        spread(call, input[1], call->zeros, s->qd);
        spread(call, input[2], call->zeros, s->qdd); /* forward dynamics does not read it */
        memset(call->vector, 0, (call->n_all + 1) * sizeof *call->vector);
        if (compute(call, output, input[2]))
            return state + 1;
    }
    return 0;
}
