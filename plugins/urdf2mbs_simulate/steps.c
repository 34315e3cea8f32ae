/* Steps in C: linearly implicit Euler steps, extrapolated to order 3, with an estimate of the error
   (Deuflhard, SIAM Review 27, 1985; Hairer and Wanner, Solving Ordinary Differential Equations II, IV.9).

   Implicit are the forces: that of a joint by its position and speed, an external force by the motion of
   its body, each with the user states that it sets.  Their slopes are differences of the user functions.
   All else is explicit, so no slope of the equations of motion is needed.

   Compiled with RUN_JOINTS, RUN_FORCES and RUN_STATES: how many joints, external forces and user states. */
#include <math.h>
#include <string.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"
#include "mbs_sensor.h"

enum { JOINTS = RUN_JOINTS, FORCES = RUN_FORCES, STATES = RUN_STATES, OWN = 8 };
enum { ALL = 2 * JOINTS + STATES + 1, ROWS = JOINTS + 1 };

int accelerate(MbsData *s, double t, const double *y, double *f);
void constrain(MbsData *s, double *h, double **Jac);
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);
void mbs_invdyna(double *phi, MbsData *s, double tsim);
void mbs_gensensor(MbsSensor *sens, MbsData *s, int isens);
double *run_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                      double OMP[4], MbsData *s, double tsim, int number);
double *run_JointForces(MbsData *s, double tsim);
void show_base(MbsData *s);
void hide_base(MbsData *s);
int must_turn(const double *y);

/* What acts on a joint (one speed) or on a body (six: of its anchor point, and of its rotation), about
   the present state.  A row of a slope is what one place, then one speed, then one state changes. */
typedef struct {
    int count, state[OWN]; /* its user states */
    double speed[6], force[6], rate[OWN], by[12 + OWN][6], rate_by[12 + OWN][OWN];
    /* In a step h whose speeds change by dv, the force changes by push - resist dv, and the states by
       drift + follow dv. */
    double push[6], resist[6][6], drift[OWN], follow[OWN][6];
} Act;

static const double NEAR = 1e-7;
static Act joint[ROWS], body[FORCES + 1];
static int touches[FORCES + 1];
static double reach[FORCES + 1][7][ROWS]; /* the Jacobian of each anchor point */
static double M[ROWS][ROWS], leads[ROWS][ROWS], here[ALL], qdd[ROWS];
static MbsSensor frame;

int last_joint[FORCES + 1]; /* of the body of each external force; 0: of the base */
#ifdef USER_IN_C
extern MbsDirdyn dirdyn;
#endif

/* --- slopes --- */

/* From a body's origin to the anchor point of an external force. */
static void arm_of(const MbsData *s, int number, double arm[4])
{
    for (int i = 1; i <= 3; i++) {
        arm[i] = 0.0;
        for (int k = 1; k <= 3; k++)
            arm[i] += frame.R[k][i] * s->dpt[k][s->xfidpt[number]];
    }
}

static double cross(const double *a, const double *b, int i)
{
    const int k = i % 3 + 1, l = k % 3 + 1;

    return a[k] * b[l] - a[l] * b[k];
}

/* The force and torque at the anchor point of an external force, after a small motion of its body. */
static void pull(MbsData *s, int number, const double *place, const double *speed, double *force)
{
    const double *turn = place + 2;
    double P[4], R[4][4], V[4], OM[4], A[4], OMP[4], arm[4], lever[4] = {0}, *w;

    arm_of(s, number, arm);
    for (int i = 1; i <= 3; i++) {
        P[i] = frame.P[i] + arm[i] + place[i - 1];
        V[i] = frame.V[i] + cross(frame.OM, arm, i) + speed[i - 1];
        OM[i] = frame.OM[i] + speed[2 + i];
        A[i] = frame.A[i];
        OMP[i] = frame.OMP[i];
        for (int k = 1; k <= 3; k++)
            R[k][i] = frame.R[k][i] + cross(turn, frame.R[k], i);
    }
    w = run_ExtForces(P, R, V, OM, A, OMP, s, s->tsim, number);
    for (int i = 1; i <= 3; i++)
        for (int k = 1; k <= 3; k++)
            lever[i] += R[k][i] * (w[6 + k] - s->dpt[k][s->xfidpt[number]]);
    for (int i = 1; i <= 3; i++) {
        force[i - 1] = w[i];
        force[2 + i] = w[3 + i] + cross(lever, w, i);
    }
}

/* The motion of a body, and the Jacobian of the anchor point. */
static void find_frame(MbsData *s, int number)
{
    double arm[4];

    memset(reach[number], 0, sizeof reach[number]);
    for (int i = 1; i <= 6; i++)
        frame.J[i] = reach[number][i];
    mbs_gensensor(&frame, s, last_joint[number]);
    arm_of(s, number, arm);
    for (int i = 1; i <= 3; i++) {
        body[number].speed[i - 1] = frame.V[i] + cross(frame.OM, arm, i);
        body[number].speed[2 + i] = frame.OM[i];
    }
    for (int j = 1; j <= JOINTS; j++) {
        const double turn[4] = {0.0, frame.J[4][j], frame.J[5][j], frame.J[6][j]};

        for (int i = 1; i <= 3; i++)
            frame.J[i][j] += cross(turn, arm, i);
    }
}

/* Keep what an act does, or, behind a small change, what the change has done. */
static void keep(const MbsData *s, Act *a, int speeds, int way, const double *force)
{
    for (int i = 0; i < speeds; i++) {
        if (way < 0)
            a->force[i] = force[i];
        else
            a->by[way][i] = (force[i] - a->force[i]) / NEAR;
    }
    for (int x = 0; x < a->count; x++) {
        const double rate = s->uxd[a->state[x]];

        if (way < 0)
            a->rate[x] = rate;
        else
            a->rate_by[way][x] = (rate - a->rate[x]) / NEAR;
    }
}

static void find_slopes_of_body(MbsData *s, int number)
{
    Act *b = &body[number];
    double force[6], place[12] = {0};

    find_frame(s, number);
    pull(s, number, place, place + 6, force);
    keep(s, b, 6, -1, force);
    for (int way = 0; way < 12 + b->count; way++) {
        double *moved = way < 12 ? &place[way] : &s->ux[b->state[way - 12]];
        const double before = *moved;

        *moved += NEAR;
        pull(s, number, place, place + 6, force);
        *moved = before;
        keep(s, b, 6, way, force);
    }
}

/* The force of a joint depends on this joint alone, so all joints are moved at once. */
static void find_slopes_of_joints(MbsData *s)
{
    for (int way = -1; way < 3; way++) {
        for (int j = 1; j <= JOINTS; j++) {
            s->q[j] += way == 0 ? NEAR : 0.0;
            s->qd[j] += way == 1 ? NEAR : 0.0;
            for (int x = 0; x < joint[j].count && way == 2; x++)
                s->ux[joint[j].state[x]] += NEAR;
        }
        run_JointForces(s, s->tsim);
        for (int j = 1; j <= JOINTS; j++) {
            keep(s, &joint[j], 1, way, &s->Qq[j]);
            if (way == 0 || way == 1) /* a force that drives its joint away is left explicit */
                joint[j].by[way][0] = fmin(joint[j].by[way][0], 0.0);
            s->q[j] -= way == 0 ? NEAR : 0.0;
            s->qd[j] -= way == 1 ? NEAR : 0.0;
            for (int x = 0; x < joint[j].count && way == 2; x++)
                s->ux[joint[j].state[x]] -= NEAR;
            joint[j].speed[0] = s->qd[j];
        }
    }
}

/* How each joint moves with the independent ones: leads[j][i] of the i-th, from 0. */
static void find_leads(MbsData *s)
{
    memset(leads, 0, sizeof leads);
    for (int i = 1; i <= s->nqu; i++)
        leads[s->qu[i]][i - 1] = 1.0;
#if RUN_CUTS + RUN_USER_ROWS
    enum { MOST = RUN_CUTS + RUN_USER_ROWS };
    static double h[MOST + 1], table[MOST + 1][ROWS], *rows[MOST + 1];

    memset(table, 0, sizeof table);
    for (int i = 0; i <= MOST; i++)
        rows[i] = table[i];
    constrain(s, h, rows);
    for (int k = 1; k <= s->nqv; k++) { /* Gauss and Jordan; spare rows are left over */
        const int column = s->qv[k];
        double *pivot;
        int best = k;

        for (int i = k + 1; i <= MOST; i++)
            if (fabs(rows[i][column]) > fabs(rows[best][column]))
                best = i;
        pivot = rows[best];
        rows[best] = rows[k];
        rows[k] = pivot;
        for (int i = 1; i <= MOST; i++) {
            const double part = i == k ? 0.0 : rows[i][column] / pivot[column];

            for (int j = 1; j <= JOINTS && part != 0.0; j++)
                rows[i][j] -= part * pivot[j];
        }
    }
    for (int k = 1; k <= s->nqv; k++)
        for (int i = 1; i <= s->nqu; i++)
            leads[s->qv[k]][i - 1] = -rows[k][s->qu[i]] / rows[k][s->qv[k]];
#endif
}

/* What the steps from a state need; 0 if the state has accelerations, which may be known already. */
static int prepare(MbsData *s, double t, const double *y, int known)
{
    static double *rows[ROWS], c[ROWS];

    if (!known && accelerate(s, t, y, here))
        return -1;
    memcpy(qdd, s->qdd, sizeof qdd);
    for (int b = 1; b <= FORCES; b++) {
        touches[b] = 0;
        for (int k = 1; k <= 6 && last_joint[b] > 0; k++)
            touches[b] |= s->SWr[b][k] != 0.0;
    }
    for (int i = 0; i <= JOINTS; i++)
        rows[i] = M[i];
    mbs_dirdyna(rows, c, s, t);
    find_leads(s);
    find_slopes_of_joints(s);
    for (int b = 1; b <= FORCES; b++)
        if (touches[b])
            find_slopes_of_body(s, b);
    return 0;
}

/* --- one step --- */

/* Solve A x = b for m columns; x is put into b.  From the last row on, no zero of a tree is filled. */
static void solve(int n, int width, double *A, int m, double *b)
{
    for (int k = n - 1; k >= 0; k--) {
        const double *row = A + k * width;
        int list[ROWS], count = 0;

        for (int j = 0; j < k; j++)
            if (row[j] != 0.0)
                list[count++] = j;
        for (int i = 0; i < k; i++) {
            double *other = A + i * width;
            const double part = other[k] / row[k];

            if (part == 0.0)
                continue;
            for (int j = 0; j < count; j++)
                other[list[j]] -= part * row[list[j]];
            for (int j = 0; j < m; j++)
                b[i * m + j] -= part * b[k * m + j];
        }
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < m; j++) {
            for (int k = 0; k < i; k++)
                b[i * m + j] -= A[i * width + k] * b[k * m + j];
            b[i * m + j] /= A[i * width + i];
        }
}

/* What an act does in a step h, without its states: they follow from (1 - h slope) dx = h rate. */
static void resist(Act *a, int speeds, double h)
{
    double A[OWN][OWN], b[OWN][7] = {{0}};
    const int states = 2 * speeds; /* their first way */

    for (int x = 0; x < a->count; x++) {
        b[x][0] = h * a->rate[x];
        for (int k = 0; k < a->count; k++)
            A[x][k] = (x == k) - h * a->rate_by[states + k][x];
        for (int k = 0; k < speeds; k++) {
            b[x][0] += h * h * a->rate_by[k][x] * a->speed[k];
            b[x][1 + k] = h * (h * a->rate_by[k][x] + a->rate_by[speeds + k][x]);
        }
    }
    solve(a->count, OWN, A[0], 7, b[0]);
    for (int i = 0; i < speeds; i++) {
        a->push[i] = 0.0;
        for (int k = 0; k < speeds; k++) {
            a->push[i] += h * a->by[k][i] * a->speed[k];
            a->resist[i][k] = -h * a->by[k][i] - a->by[speeds + k][i];
        }
    }
    for (int x = 0; x < a->count; x++) {
        a->drift[x] = b[x][0];
        memcpy(a->follow[x], b[x] + 1, sizeof a->follow[x]);
        for (int i = 0; i < speeds; i++) {
            a->push[i] += a->by[states + x][i] * a->drift[x];
            for (int k = 0; k < speeds; k++)
                a->resist[i][k] -= a->by[states + x][i] * a->follow[x][k];
        }
    }
}

/* Add what resists a body to H, and what pushes it to Q. */
static void add_body(int number, double h, double H[ROWS][ROWS], double *Q)
{
    double(*J)[ROWS] = reach[number];
    Act *a = &body[number];
    int list[ROWS], count = 0;

    resist(a, 6, h);
    for (int j = 1; j <= JOINTS; j++) {
        int moves = 0;

        for (int i = 1; i <= 6; i++)
            moves |= J[i][j] != 0.0;
        if (moves)
            list[count++] = j;
    }
    for (int n = 0; n < count; n++) {
        const int j = list[n];
        double row[6] = {0};

        for (int i = 0; i < 6; i++) {
            Q[j] += J[i + 1][j] * a->push[i];
            for (int k = 0; k < 6; k++)
                row[k] += h * J[i + 1][j] * a->resist[i][k];
        }
        for (int m = 0; m < count; m++)
            for (int k = 0; k < 6; k++)
                H[j][list[m]] += row[k] * J[k + 1][list[m]];
    }
}

/* Solve (M + h resist) dv = h (M qdd + push) for the independent joints; dv is that of all joints. */
static void change_speeds(const MbsData *s, double h, double *dv)
{
    const int n = s->nqu, m = s->nqv;
    static double H[ROWS][ROWS], A[ROWS][ROWS], Q[ROWS], b[ROWS];

    for (int j = 1; j <= JOINTS; j++) {
        dv[j] = 0.0;
        for (int i = 0; i < n; i++)
            dv[j] += leads[j][i] * qdd[s->qu[i + 1]];
        for (int k = 1; k <= j; k++)
            H[j][k] = H[k][j] = M[j][k];
    }
    for (int j = 1; j <= JOINTS; j++) {
        resist(&joint[j], 1, h);
        Q[j] = joint[j].push[0];
        for (int k = 1; k <= JOINTS; k++)
            Q[j] += H[j][k] * dv[k];
        H[j][j] += h * joint[j].resist[0][0];
    }
    for (int f = 1; f <= FORCES; f++)
        if (touches[f])
            add_body(f, h, H, Q);
    for (int j = 1; j <= JOINTS; j++) /* H leads, in the columns of the independent joints */
        for (int i = 0; i < n && m > 0; i++)
            for (int k = 1; k <= m; k++)
                H[j][s->qu[i + 1]] += H[j][s->qv[k]] * leads[s->qv[k]][i];
    for (int i = 0; i < n; i++) {
        b[i] = h * Q[s->qu[i + 1]];
        for (int j = 0; j < n; j++)
            A[i][j] = H[s->qu[i + 1]][s->qu[j + 1]];
        for (int k = 1; k <= m; k++) {
            const double part = leads[s->qv[k]][i];

            b[i] += part * h * Q[s->qv[k]];
            for (int j = 0; j < n; j++)
                A[i][j] += part * H[s->qv[k]][s->qu[j + 1]];
        }
    }
    solve(n, ROWS, A[0], 1, b);
    for (int j = 1; j <= JOINTS; j++) {
        dv[j] = 0.0;
        for (int i = 0; i < n; i++)
            dv[j] += leads[j][i] * b[i];
    }
}

/* A step h from the state that was prepared last, added to y. */
static void step(const MbsData *s, double h, double *y)
{
    const int n = s->nqu;
    double dv[ROWS], dx[STATES + 1];

    change_speeds(s, h, dv);
    for (int i = 0; i < n; i++) {
        y[n + i] += dv[s->qu[i + 1]];
        y[i] += h * y[n + i];
    }
    for (int k = 1; k <= STATES; k++)
        dx[k] = h * here[2 * n - 1 + k];
    for (int j = 1; j <= JOINTS; j++)
        for (int x = 0; x < joint[j].count; x++)
            dx[joint[j].state[x]] = joint[j].drift[x] + joint[j].follow[x][0] * dv[j];
    for (int f = 1; f <= FORCES; f++)
        for (int x = 0; x < body[f].count && touches[f]; x++) {
            double *of_state = &dx[body[f].state[x]];

            *of_state = body[f].drift[x];
            for (int i = 0; i < 6; i++)
                for (int j = 1; j <= JOINTS; j++)
                    *of_state += body[f].follow[x][i] * reach[f][i + 1][j] * dv[j];
        }
    for (int k = 1; k <= STATES; k++)
        y[2 * n - 1 + k] += dx[k];
}

/* --- from time to time --- */

/* Find which states each force sets: call it once, in a state.  0 if there are not too many. */
int find_states(MbsData *s)
{
    static const double still[6];
    double force[6], rate[STATES + 1], before[STATES + 1];

    memcpy(before, s->uxd, sizeof before);
    for (int f = 1; f <= FORCES; f++) {
        if (last_joint[f] == 0)
            continue;
        find_frame(s, f);
        for (int k = 1; k <= STATES; k++)
            s->uxd[k] = NAN;
        pull(s, f, still, still, force);
        body[f].count = 0;
        for (int k = 1; k <= STATES; k++)
            if (!isnan(s->uxd[k]) && body[f].count++ < OWN)
                body[f].state[body[f].count - 1] = k;
        if (body[f].count > OWN)
            return -1;
    }
    memcpy(s->uxd, before, sizeof before);
    run_JointForces(s, s->tsim);
    memcpy(rate, s->uxd, sizeof rate);
    for (int j = 1; j <= JOINTS; j++) {
        s->qd[j] += 1.0;
        run_JointForces(s, s->tsim);
        s->qd[j] -= 1.0;
        joint[j].count = 0;
        for (int k = 1; k <= STATES; k++)
            if (s->uxd[k] != rate[k]) {
                joint[j].state[0] = k;
                joint[j].count = 1;
            }
    }
    memcpy(s->uxd, before, sizeof before);
    return 0;
}

/* Compute a state at the end of a step h.  Gives the error of a force that begins there, as a part of what
   is allowed: no part of the step has felt it. */
static double missed(MbsData *s, double t, double h, const double *y, double rtol, double atol)
{
    const int n = s->nqu;
    double before[ALL], error = 0.0;
    int begins = 0;

    memcpy(before, here, sizeof before);
    if (accelerate(s, t, y, here))
        return INFINITY;
    for (int b = 1; b <= FORCES; b++)
        for (int k = 1; k <= 6 && last_joint[b] > 0 && !touches[b]; k++)
            begins |= s->SWr[b][k] != 0.0;
    for (int i = 0; i < n && begins; i++)
        error = fmax(error, h * h * fabs(here[n + i] - before[n + i]) / (atol + rtol * fabs(y[i])));
    return error;
}

/* The state after h, in y: by one step, two and three, extrapolated.  Gives the error, as a part of what
   is allowed.  known: y was computed last. */
static double extrapolate(MbsData *s, double t, double h, double *y, double rtol, double atol, int known)
{
    const int n = s->nqu, size = 2 * n + STATES;
    double by[4][ALL], error = 0.0;

    for (int parts = 3; parts >= 1; parts--)
        memcpy(by[parts], y, size * sizeof *y);
    if (prepare(s, t, y, known))
        return INFINITY;
    for (int k = 1; k <= s->nqv; k++)
        s->guess[k - 1] = s->q[s->qv[k]];
    for (int parts = 1; parts <= 3; parts++)
        step(s, h / parts, by[parts]);
    for (int parts = 2; parts <= 3; parts++)
        for (int k = 1; k < parts; k++) {
            if (prepare(s, t + k * h / parts, by[parts], 0))
                return INFINITY;
            step(s, h / parts, by[parts]);
        }
    for (int i = 0; i < size; i++) {
        const double second = 2.0 * by[2][i] - by[1][i], better = 3.0 * by[3][i] - 2.0 * by[2][i];
        const double last = (better - second) / 2.0;
        const double allowed = atol + rtol * fmax(fabs(y[i]), fabs(better));

        if (!isfinite(last))
            return INFINITY;
        if (i < 2 * n) /* what a speed is off by counts as the place that it leads to */
            error = fmax(error, fabs(last) * (i < n ? 1.0 : h) / allowed);
        by[0][i] = better + last;
    }
    if (error <= 1.0)
        error = fmax(error, missed(s, t + h, h, by[0], rtol, atol));
    if (error <= 1.0)
        memcpy(y, by[0], size * sizeof *y);
    return error;
}

/* Step from *t to end, by at most so many steps; *h is the next one.  Gives how many it took, or -1 where
   none is short enough.  loops: the user's loop is called after each step. */
int advance(MbsData *s, double *t, double end, double *h, double most, double *y, double rtol,
            double atol, int count, int loops)
{
    int taken = 0, known = 0;

    (void) loops;
    while (*t < end && taken < count && !s->flag_stop && !(taken > 0 && must_turn(y))) {
        const double left = end - *t, now = fmin(fmin(*h, most), left);
        const double error = extrapolate(s, *t, now, y, rtol, atol, known);
        const double next = now * fmin(4.0, fmax(0.2, 0.9 / cbrt(error)));

        known = error <= 1.0;
        if (now == *h || next < *h)
            *h = next;
        if (error > 1.0) {
            if (*h < 1e-13)
                return -1;
            continue;
        }
        *t = now == left ? end : *t + now;
        taken++;
#ifdef USER_IN_C
        if (loops) {
            known = 0; /* the loop may change what acts */
            mbs_invdyna(here, s, *t); /* Qc of driven joints */
            for (int j = 1; j <= JOINTS; j++)
                s->Qc[j] = here[j] - s->Qq[j];
            for (int i = 1; i <= s->nqu; i++)
                s->Qc[s->qu[i]] = 0.0;
            show_base(s);
            user_dirdyn_loop(s, &dirdyn);
            hide_base(s);
        }
#endif
    }
    return taken;
}
