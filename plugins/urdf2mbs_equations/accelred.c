/* The parts of generated files that are the same for all models: most of accelred and invdynared.

   Generated files are composed of its sections. The file as a whole compiles, too. */
#include <math.h>
#include <string.h>

#include "mbs_data.h"

/* --- model --- (an example: each file has its own) */
enum {JOINTS = 3, ANY_DRIVEN = 0, LINKS = 0, LINKS3D = 0, EXTFORCES = 0};
enum {DEPENDENT = 1, INDEPENDENT = 2, CUTS = 1, USER_ROWS = 0, ROWS = 1};
/* numbers of the joints, the first of each list not being used */
static const int dependent[] = {0, 3};
static const int independent[] = {0, 1, 2};

/* --- pieces --- (of long functions: a compiler must not merge them into one function again) */
#if defined(__GNUC__) || defined(__clang__)
#define PIECE static __attribute__((noinline)) void
#define RESTRICT restrict
#elif defined(_MSC_VER)
#define PIECE static __declspec(noinline) void
#define RESTRICT __restrict
#else
#define PIECE static void
#define RESTRICT restrict
#endif

/* --- pairs --- (two mirrored limbs in one vector; compilers without vectors use plain C) */
#if (defined(__GNUC__) || defined(__clang__)) && !defined(MBS_NO_PAIRS)
#define HAS_PAIRS 1
typedef double pair __attribute__((vector_size(16)));
#define PAIR(x, y) ((pair) {(x), (y)})
#else
#define HAS_PAIRS 0
#endif

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

/* Set frc and trq, the forces on bodies, to the sum of all links and external forces. */
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
/* The dependent joints v follow from the constraints h(q) = 0 and from the leaders u: those
   independent and driven joints that move a constraint (coordinate partitioning: Samin and Fisette,
   Symbolic Modeling of Multibody Systems, 2003). With the Jacobian J = dh/dq:

       J_v dv = -h             a step of Newton's method
       v' = B u'               B = -J_v^-1 J_u
       v'' = B u'' + b         b = -J_v^-1 jdqd

   All arrays count from 1, as Robotran's do. */

/* A pivot is 0 if it is this much smaller than its row of J, or than its diagonal element of A. */
#define SINGULAR 1e-13
/* A constraint is closed if h is smaller than this, relative to the largest element of its row. */
#define CLOSED 1e-9
#define MAX_ITERATIONS 100

/* The working memory: one for each thread. */
#ifdef _MSC_VER
#define THREAD_LOCAL static __declspec(thread)
#else
#define THREAD_LOCAL static __thread
#endif
THREAD_LOCAL double Jac[ROWS + 1][JOINTS + 1], h[ROWS + 1];
/* The factors of J_v, with the inverse of each pivot on the diagonal, and the swapped rows. */
THREAD_LOCAL double LU[ROWS + 1][ROWS + 1];
THREAD_LOCAL int swapped_row[ROWS + 1];
/* The Jacobian that was factorized last. It stays the same if all constraints are linear, as those
   of <mimic> are. */
THREAD_LOCAL double factorized_Jac[ROWS + 1][JOINTS + 1] = {{1.0}};
/* Column j of B belongs to leader[j]; column 0 is dv, then b. */
THREAD_LOCAL double B[ROWS + 1][JOINTS + 1];
THREAD_LOCAL int n_leaders, leader[JOINTS + 1], is_B_current;

void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);
void mbs_cons_jdqd(double *Jdqd, MbsData *s, double tsim);
void USER(cons_hJ)(double *h, double **Jac, MbsData *s, double tsim);
void USER(cons_jdqd)(double *jdqd, MbsData *s, double tsim);

/* row = row - factor * pivot_row, in the columns from first to last. Most factors are 0. */
static void subtract_multiple(double *row, double factor, const double *pivot_row, int first,
                              int last)
{
    if (factor != 0.0)
        for (int j = first; j <= last; j++)
            row[j] -= factor * pivot_row[j];
}

/* Factorize J_v by Gaussian elimination. The pivot of a column is the element that is largest
   relative to its row of J. Return -1 if J_v is singular, else 0. */
static int factorize_constraints(void)
{
    double size[ROWS + 1];
    if (memcmp(factorized_Jac, Jac, sizeof Jac) == 0)
        return 0;
    factorized_Jac[0][0] = 1.0; /* no Jac is this one, if J_v is singular */
    is_B_current = 0;
    for (int i = 1; i <= DEPENDENT; i++) {
        size[i] = 0.0;
        for (int j = 1; j <= JOINTS; j++)
            if (Jac[i][j] != 0.0 && fabs(Jac[i][j]) > size[i])
                size[i] = fabs(Jac[i][j]);
        for (int j = 1; j <= DEPENDENT; j++)
            LU[i][j] = Jac[i][dependent[j]];
    }
    for (int k = 1; k <= DEPENDENT; k++) {
        int p = k;
        for (int i = k + 1; i <= DEPENDENT; i++)
            if (fabs(LU[i][k]) * size[p] > fabs(LU[p][k]) * size[i])
                p = i;
        if (!(fabs(LU[p][k]) > SINGULAR * size[p]))
            return -1;
        swapped_row[k] = p;
        size[p] = size[k];
        for (int j = 1; j <= DEPENDENT && p != k; j++) {
            double x = LU[k][j];
            LU[k][j] = LU[p][j], LU[p][j] = x;
        }
        LU[k][k] = 1.0 / LU[k][k];
        for (int i = k + 1; i <= DEPENDENT; i++) {
            LU[i][k] *= LU[k][k];
            subtract_multiple(LU[i], LU[i][k], LU[k], k + 1, DEPENDENT);
        }
    }
    memcpy(factorized_Jac, Jac, sizeof Jac);
    return 0;
}

/* B = J_v^-1 B, in the columns from first to last. */
static void solve_constraints(int first, int last)
{
    for (int k = 1; k <= DEPENDENT; k++)
        for (int j = first; j <= last && swapped_row[k] != k; j++) {
            double x = B[k][j];
            B[k][j] = B[swapped_row[k]][j], B[swapped_row[k]][j] = x;
        }
    for (int i = 2; i <= DEPENDENT; i++) /* L */
        for (int k = 1; k < i; k++)
            subtract_multiple(B[i], LU[i][k], B[k], first, last);
    for (int i = DEPENDENT; i >= 1; i--) { /* U */
        for (int k = i + 1; k <= DEPENDENT; k++)
            subtract_multiple(B[i], LU[i][k], B[k], first, last);
        for (int j = first; j <= last; j++)
            B[i][j] *= LU[i][i];
    }
}

/* Compute h and J: rows of cuts, then rows of the user. */
static void evaluate_constraints(MbsData *s, double tsim)
{
    double *rows[ROWS + 1];
    for (int i = 0; i <= DEPENDENT; i++)
        rows[i] = Jac[i];
    memset(Jac, 0, sizeof Jac);
    if (CUTS)
        mbs_cons_hJ(h, rows, s, tsim);
    if (USER_ROWS)
        USER(cons_hJ)(h + CUTS, rows + CUTS, s, tsim);
}

/* Find the leaders, and set the columns of B to -J_u. Row 0 of J is a working space. */
static void find_leaders(void)
{
    double *size = Jac[0];
    for (int i = 1; i <= DEPENDENT; i++)
        for (int j = 1; j <= JOINTS; j++)
            size[j] += fabs(Jac[i][j]);
    for (int i = 1; i <= DEPENDENT; i++)
        size[dependent[i]] = 0.0;
    n_leaders = 0;
    for (int j = 1; j <= JOINTS; j++)
        if (size[j] != 0.0) {
            leader[++n_leaders] = j;
            for (int i = 1; i <= DEPENDENT; i++)
                B[i][n_leaders] = -Jac[i][j];
        }
}

/* Set q and qd of the dependent joints, B and b. Return -1 if a loop cannot be closed, else 0. */
static int close_loops(MbsData *s, double tsim)
{
    for (int iteration = 0;; iteration++) {
        int is_closed = 1;
        evaluate_constraints(s, tsim);
        for (int i = 1; i <= DEPENDENT; i++) {
            double size = 0.0; /* m of h for each rad: how large the model is */
            for (int j = 1; j <= JOINTS; j++)
                if (fabs(Jac[i][j]) > size)
                    size = fabs(Jac[i][j]);
            is_closed &= fabs(h[i]) < CLOSED * size;
            B[i][0] = -h[i];
        }
        if (factorize_constraints())
            return -1;
        solve_constraints(0, 0); /* also if all is closed: after one more step, h is a rounding */
        for (int i = 1; i <= DEPENDENT; i++)
            s->q[dependent[i]] += B[i][0];
        if (is_closed)
            break;
        if (iteration == MAX_ITERATIONS)
            return -1;
    }
    if (!is_B_current) {
        find_leaders();
        solve_constraints(1, n_leaders);
        is_B_current = 1;
    }
    for (int i = 1; i <= DEPENDENT; i++) {
        s->qd[dependent[i]] = 0.0;
        for (int j = 1; j <= n_leaders; j++)
            s->qd[dependent[i]] += B[i][j] * s->qd[leader[j]];
    }
    if (CUTS)
        mbs_cons_jdqd(h, s, tsim);
    if (USER_ROWS)
        USER(cons_jdqd)(h + CUTS, s, tsim);
    for (int i = 1; i <= DEPENDENT; i++)
        B[i][0] = -h[i];
    solve_constraints(0, 0);
    return 0;
}

/* Set qdd of the dependent joints: v'' = B u'' + b. */
static void accelerate_dependent(MbsData *s)
{
    for (int i = 1; i <= DEPENDENT; i++) {
        s->qdd[dependent[i]] = B[i][0];
        for (int j = 1; j <= n_leaders; j++)
            s->qdd[dependent[i]] += B[i][j] * s->qdd[leader[j]];
    }
}

/* --- accelred --- */
/* The equations of motion are M q'' + c = Q + (forces of the constraints). The accelerations are

       q'' = T x + q0''

   with x those of the independent joints, and q0'' those of all joints for x = 0. In T, the rows of
   independent joints are those of the unit matrix, the rows of dependent joints those of B. The
   forces of the constraints do no work along T:

       A x = T^T (Q - c - M q0'')      A = T^T M T */
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);

THREAD_LOCAL double M[JOINTS + 1][JOINTS + 1], Q[JOINTS + 1];
/* The lower triangle of A, then its factors. */
THREAD_LOCAL double A[JOINTS + 1][JOINTS + 1], x[JOINTS + 1];

/* M = T^T M T and Q = T^T Q, in the rows and columns of the leaders. */
static void reduce_to_leaders(void)
{
    for (int i = 1; i <= DEPENDENT; i++)
        for (int j = 1; j <= n_leaders; j++) {
            int to = leader[j], from = dependent[i];
            if (B[i][j] == 0.0)
                continue;
            Q[to] += B[i][j] * Q[from];
            subtract_multiple(M[to], -B[i][j], M[from], 1, JOINTS);
            for (int k = 1; k <= JOINTS; k++)
                M[k][to] += B[i][j] * M[k][from];
        }
}

/* Solve A x = Q. The factors A = L^T D L keep the zeros between branches of a tree (Featherstone,
   Rigid Body Dynamics Algorithms, 2008, 6.5). Row 0 keeps the diagonal. Return -1 if A is singular,
   else 0. */
static int solve_accelerations(void)
{
    for (int k = 1; k <= INDEPENDENT; k++) {
        x[k] = Q[independent[k]];
        for (int i = 1; i <= k; i++)
            A[k][i] = M[independent[k]][independent[i]];
        A[0][k] = A[k][k];
    }
    for (int k = INDEPENDENT; k >= 1; k--) { /* factorize, and x = L^-T x */
        if (!(A[k][k] > SINGULAR * A[0][k]))
            return -1;
        A[k][k] = 1.0 / A[k][k];
        for (int i = k - 1; i >= 1; i--) {
            double factor = A[k][i] * A[k][k];
            if (factor == 0.0)
                continue;
            subtract_multiple(A[i], factor, A[k], 1, i);
            A[k][i] = factor;
            x[i] -= factor * x[k];
        }
    }
    for (int k = 1; k <= INDEPENDENT; k++) { /* x = L^-1 D^-1 x */
        x[k] *= A[k][k];
        for (int i = 1; i < k; i++)
            x[k] -= A[k][i] * x[i];
    }
    return 0;
}

/* Set q, qd and qdd of the dependent joints, and qdd of the independent ones. */
int mbs_accelred(MbsData *s, double tsim)
{
    double *rows[JOINTS + 1];

    set_driven(s, tsim);
    if (close_loops(s, tsim))
        return MBS_INFO_FAILURE;
    set_forces(s, tsim);
    USER(JointForces)(s, tsim);
    for (int i = 0; i <= JOINTS; i++)
        rows[i] = M[i];
    memset(M, 0, sizeof M);
    mbs_dirdyna(rows, Q, s, tsim); /* Q = c */
    for (int j = 1; j <= INDEPENDENT; j++)
        s->qdd[independent[j]] = 0.0;
    accelerate_dependent(s);
    for (int k = 1; k <= JOINTS; k++)
        Q[k] = s->Qq[k] - Q[k];
    for (int k = 1; k <= JOINTS; k++)
        subtract_multiple(Q, s->qdd[k], M[k], 1, JOINTS);
    reduce_to_leaders();
    if (solve_accelerations())
        return MBS_INFO_FAILURE;
    for (int j = 1; j <= INDEPENDENT; j++)
        s->qdd[independent[j]] = x[j];
    accelerate_dependent(s);
    return MBS_INFO_SUCCESS;
}

/* --- invdynared --- */
void mbs_invdyna(double *Qq, MbsData *s, double tsim);

/* Set Qq of the joints that are not dependent for their qdd: Qq = T^T phi, without forces in the
   dependent joints. Also set q, qd and qdd of the dependent joints. */
int mbs_invdynared(MbsData *s, double tsim)
{
    set_driven(s, tsim);
    if (close_loops(s, tsim))
        return MBS_INFO_FAILURE;
    accelerate_dependent(s);
    set_forces(s, tsim);
    mbs_invdyna(s->Qq, s, tsim);
    for (int i = 1; i <= DEPENDENT; i++) {
        for (int j = 1; j <= n_leaders; j++)
            s->Qq[leader[j]] += B[i][j] * s->Qq[dependent[i]];
        s->Qq[dependent[i]] = 0.0;
    }
    return MBS_INFO_SUCCESS;
}

/* --- coupling --- */
/* q[follower] = factor q[leader] + offset, where several couplings of one follower are added. */
typedef struct Coupling {
    int follower, leader;
    double factor, offset;
} Coupling;

/* --- couplings --- (an example: each file has its own) */
enum {COUPLINGS = 1};
static const Coupling couplings[] = {
    {3, 2, -0.5, 0.25},
};

/* --- followers --- */
/* Set q, qd and qdd of followers by those of their leaders: q = T q + offset. */
void mbs_followers(MbsData *s)
{
    for (const Coupling *c = couplings; c < couplings + COUPLINGS; c++)
        s->q[c->follower] = s->qd[c->follower] = s->qdd[c->follower] = 0.0;
    for (const Coupling *c = couplings; c < couplings + COUPLINGS; c++) {
        s->q[c->follower] += c->factor * s->q[c->leader] + c->offset;
        s->qd[c->follower] += c->factor * s->qd[c->leader];
        s->qdd[c->follower] += c->factor * s->qdd[c->leader];
    }
}

/* f = T' f of forces, such as c.  What belongs to followers is added to their leaders, and is then
   zero. */
void mbs_reduce_vector(double *f)
{
    for (const Coupling *c = couplings; c < couplings + COUPLINGS; c++)
        f[c->leader] += c->factor * f[c->follower];
    for (const Coupling *c = couplings; c < couplings + COUPLINGS; c++)
        f[c->follower] = 0.0;
}

/* A = A T of a matrix, such as the Jacobian of a sensor. */
void mbs_reduce_columns(double **matrix, int n_rows)
{
    for (int row = 1; row <= n_rows; row++)
        mbs_reduce_vector(matrix[row]);
}

/* A = T' A T of a matrix, such as M, and the derivatives of forces. */
void mbs_reduce_matrix(double **matrix)
{
    mbs_reduce_columns(matrix, JOINTS);
    for (int column = 1; column <= JOINTS; column++) {
        for (const Coupling *c = couplings; c < couplings + COUPLINGS; c++)
            matrix[c->leader][column] += c->factor * matrix[c->follower][column];
        for (const Coupling *c = couplings; c < couplings + COUPLINGS; c++)
            matrix[c->follower][column] = 0.0;
    }
}
