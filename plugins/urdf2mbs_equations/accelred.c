/* The parts of generated files, most of accelred and invdynared, that are the same for all models.

   Generated files are put together from its sections; as it stands, it compiles, too. */
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
/* A pivot is zero if it is so small a part of its row of Jac, or of its element of A. */
#define SINGULAR 1e-13

/* The working memory, which each thread has of its own. */
#ifdef _MSC_VER
#define KEPT static __declspec(thread)
#else
#define KEPT static __thread
#endif
KEPT double Jac[ROWS + 1][JOINTS + 1], h[ROWS + 1];
/* The columns of Jac of the dependent joints, as two triangles with the inverse of each pivot, and
   the rows that were swapped. */
KEPT double LU[ROWS + 1][ROWS + 1];
KEPT int swapped[ROWS + 1];
/* The Jac that LU was made of, at first none: where all rules are constant it stays the same. */
KEPT double factored[ROWS + 1][JOINTS + 1] = {{1.0}};
/* The dependent joints follow so many leaders, which are independent or driven: their qdd is B
   times the qdd of these, plus the column 0 of B.  B is new if LU is. */
KEPT int leaders, leader[JOINTS + 1], known;
KEPT double B[ROWS + 1][JOINTS + 1];

void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);
void mbs_cons_jdqd(double *Jdqd, MbsData *s, double tsim);
void USER(cons_hJ)(double *h, double **Jac, MbsData *s, double tsim);
void USER(cons_jdqd)(double *jdqd, MbsData *s, double tsim);

/* A row less f times another, in some columns.  Most f are zero. */
static void subtract(double *row, double f, const double *other, int first, int last)
{
    if (f != 0.0)
        for (int j = first; j <= last; j++)
            row[j] -= f * other[j];
}

/* Fill LU by Gauss with row pivots, each row by its largest number.  0 if it
   can be done. */
static int factor(void)
{
    double size[ROWS + 1];
    if (memcmp(factored, Jac, sizeof Jac) == 0)
        return 0;
    factored[0][0] = 1.0;
    known = 0;
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
        swapped[k] = p;
        size[p] = size[k];
        for (int j = 1; j <= DEPENDENT && p != k; j++) {
            double x = LU[k][j];
            LU[k][j] = LU[p][j], LU[p][j] = x;
        }
        LU[k][k] = 1.0 / LU[k][k];
        for (int i = k + 1; i <= DEPENDENT; i++) {
            LU[i][k] *= LU[k][k];
            subtract(LU[i], LU[i][k], LU[k], k + 1, DEPENDENT);
        }
    }
    memcpy(factored, Jac, sizeof Jac);
    return 0;
}

/* Solve the constraints for the dependent joints: some columns of B become LU^-1 times these. */
static void solve(int first, int last)
{
    for (int k = 1; k <= DEPENDENT; k++)
        for (int j = first; j <= last && swapped[k] != k; j++) {
            double x = B[k][j];
            B[k][j] = B[swapped[k]][j], B[swapped[k]][j] = x;
        }
    for (int i = 2; i <= DEPENDENT; i++)
        for (int k = 1; k < i; k++)
            subtract(B[i], LU[i][k], B[k], first, last);
    for (int i = DEPENDENT; i >= 1; i--) {
        for (int k = i + 1; k <= DEPENDENT; k++)
            subtract(B[i], LU[i][k], B[k], first, last);
        for (int j = first; j <= last; j++)
            B[i][j] *= LU[i][i];
    }
}

static void set_constraints(MbsData *s, double tsim)
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

/* Find the leaders, and let the columns of B be those of -Jac. */
static void set_leaders(void)
{
    double *first = Jac[0];
    for (int i = 1; i <= DEPENDENT; i++)
        for (int j = 1; j <= JOINTS; j++)
            first[j] += fabs(Jac[i][j]);
    for (int i = 1; i <= DEPENDENT; i++)
        first[dependent[i]] = 0.0;
    leaders = 0;
    for (int j = 1; j <= JOINTS; j++)
        if (first[j] != 0.0) {
            leader[++leaders] = j;
            for (int i = 1; i <= DEPENDENT; i++)
                B[i][leaders] = -Jac[i][j];
        }
}

/* Set q and qd of the dependent joints, and B.  0 if the loops could be closed. */
static int close_loops(MbsData *s, double tsim)
{
    for (int turn = 0;; turn++) {
        int closed = 1;
        set_constraints(s, tsim);
        for (int i = 1; i <= DEPENDENT; i++) {
            double size = 0.0; /* m of h for each rad: how large the model is */
            for (int j = 1; j <= JOINTS; j++)
                if (fabs(Jac[i][j]) > size)
                    size = fabs(Jac[i][j]);
            closed &= fabs(h[i]) < 1e-9 * size;
            B[i][0] = -h[i];
        }
        if (factor())
            return -1;
        solve(0, 0); /* once more where all is closed: what is left then is rounding */
        for (int i = 1; i <= DEPENDENT; i++)
            s->q[dependent[i]] += B[i][0];
        if (closed)
            break;
        if (turn == 100)
            return -1;
    }
    if (!known) {
        set_leaders();
        solve(1, leaders);
        known = 1;
    }
    for (int i = 1; i <= DEPENDENT; i++) {
        s->qd[dependent[i]] = 0.0;
        for (int j = 1; j <= leaders; j++)
            s->qd[dependent[i]] += B[i][j] * s->qd[leader[j]];
    }
    if (CUTS)
        mbs_cons_jdqd(h, s, tsim);
    if (USER_ROWS)
        USER(cons_jdqd)(h + CUTS, s, tsim);
    for (int i = 1; i <= DEPENDENT; i++)
        B[i][0] = -h[i];
    solve(0, 0);
    return 0;
}

/* Set qdd of the dependent joints. */
static void follow(MbsData *s)
{
    for (int i = 1; i <= DEPENDENT; i++) {
        s->qdd[dependent[i]] = B[i][0];
        for (int j = 1; j <= leaders; j++)
            s->qdd[dependent[i]] += B[i][j] * s->qdd[leader[j]];
    }
}

/* --- accelred --- */
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);

KEPT double M[JOINTS + 1][JOINTS + 1], Q[JOINTS + 1];
/* The mass matrix of the independent joints (below its diagonal), and their qdd. */
KEPT double A[JOINTS + 1][JOINTS + 1], x[JOINTS + 1];

/* Let the independent joints feel the dependent ones: M becomes T' M T and Q becomes T' Q, where
   T is the unit matrix with B in the rows of the dependent joints. */
static void reduce(void)
{
    for (int i = 1; i <= DEPENDENT; i++)
        for (int j = 1; j <= leaders; j++) {
            int to = leader[j], from = dependent[i];
            if (B[i][j] == 0.0)
                continue;
            Q[to] += B[i][j] * Q[from];
            subtract(M[to], -B[i][j], M[from], 1, JOINTS);
            for (int k = 1; k <= JOINTS; k++)
                M[k][to] += B[i][j] * M[k][from];
        }
}

/* Solve A x = Q by L' D L = A, which fills no zero that a tree leaves (Featherstone, Rigid Body
   Dynamics Algorithms, section 6.5).  0 if A is regular; the row 0 keeps the diagonal. */
static int accelerate(void)
{
    for (int k = 1; k <= INDEPENDENT; k++) {
        x[k] = Q[independent[k]];
        for (int i = 1; i <= k; i++)
            A[k][i] = M[independent[k]][independent[i]];
        A[0][k] = A[k][k];
    }
    for (int k = INDEPENDENT; k >= 1; k--) {
        if (!(A[k][k] > SINGULAR * A[0][k]))
            return -1;
        A[k][k] = 1.0 / A[k][k];
        for (int i = k - 1; i >= 1; i--) {
            double f = A[k][i] * A[k][k];
            if (f == 0.0)
                continue;
            subtract(A[i], f, A[k], 1, i);
            A[k][i] = f;
            x[i] -= f * x[k];
        }
    }
    for (int k = 1; k <= INDEPENDENT; k++) {
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
    mbs_dirdyna(rows, Q, s, tsim);
    for (int j = 1; j <= INDEPENDENT; j++)
        s->qdd[independent[j]] = 0.0;
    follow(s);
    for (int k = 1; k <= JOINTS; k++)
        Q[k] = s->Qq[k] - Q[k];
    for (int k = 1; k <= JOINTS; k++)
        subtract(Q, s->qdd[k], M[k], 1, JOINTS);
    reduce();
    if (accelerate())
        return MBS_INFO_FAILURE;
    for (int j = 1; j <= INDEPENDENT; j++)
        s->qdd[independent[j]] = x[j];
    follow(s);
    return MBS_INFO_SUCCESS;
}

/* --- invdynared --- */
void mbs_invdyna(double *Qq, MbsData *s, double tsim);

/* Set Qq of the free joints for qdd of the free joints, with no forces in the dependent ones;
   also q, qd and qdd of the dependent joints. */
int mbs_invdynared(MbsData *s, double tsim)
{
    set_driven(s, tsim);
    if (close_loops(s, tsim))
        return MBS_INFO_FAILURE;
    follow(s);
    set_forces(s, tsim);
    mbs_invdyna(s->Qq, s, tsim);
    for (int i = 1; i <= DEPENDENT; i++) {
        for (int j = 1; j <= leaders; j++)
            s->Qq[leader[j]] += B[i][j] * s->Qq[dependent[i]];
        s->Qq[dependent[i]] = 0.0;
    }
    return MBS_INFO_SUCCESS;
}
