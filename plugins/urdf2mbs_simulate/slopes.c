/* The slopes of the forces, for linearly implicit steps (steps.c), and the matrix of such a step.

   Implicit are the forces: that of a joint by its position and speed, an external force by the motion of
   its body, each with the user states that it sets.  Their slopes are differences of the user functions.
   All else is explicit.

   Compiled with RUN_JOINTS, RUN_FORCES and RUN_STATES: how many joints, external forces and user states. */
#include <math.h>
#include <string.h>

#include "runtime.h"

enum { JOINTS = RUN_JOINTS, FORCES = RUN_FORCES, STATES = RUN_STATES, OWN = 8, MOST = JOINTS + STATES + 1 };

/* What acts on a joint (it moves in 1 way) or on a body (6 ways: its anchor point, and its rotation).
   It gives a force for each way, then the rate of each of its user states.  A row of by is what a small
   place in a way changes of these, then a speed in a way, then a state. */
typedef struct {
    int count, state[OWN];
    double here[6 + OWN], by[12 + OWN][6 + OWN];
} Act;

static const double NEAR = 1e-7, REST = 1e-12; /* an explicit step of 0.1 s makes a state 1e4 times larger */
static Act joint[JOINTS + 1], body[FORCES + 1];
static int touches[FORCES + 1];

/* The unknowns of a step: the changes of the speeds of the independent joints, and of the user states of
   what acts.  Their forces and rates change by K h speed + D change, where K is found by places. */
static int unknowns, state_at[MOST];
static double M[MOST][MOST], D[MOST][MOST], K[MOST][MOST];
/* M - h D - h h K, factored.  What is not zero is listed: before the diagonal, the columns of a row, or the
   rows of a column. */
static double A[MOST][MOST], factored; /* for this h; 0: for none */
static char filled[MOST][MOST];
static int column[MOST][MOST], columns[MOST];

/* Add what acts to D and K.  reach: how each of its ways moves with some of the unknowns, which are listed. */
static void add(const Act *a, int ways, int count, int *list, double reach[6 + OWN][MOST])
{
    const int size = ways + a->count;
    double d[MOST], k[MOST];

    for (int x = 0; x < a->count; x++) {
        const int state = unknowns++;

        state_at[state] = a->state[x];
        for (int i = 0; i <= state; i++) {
            M[i][state] = M[state][i] = D[i][state] = D[state][i] = K[i][state] = K[state][i] = 0.0;
            filled[state][i] = 0;
        }
        M[state][state] = 1.0;
        for (int i = 0; i < size; i++)
            reach[i][count] = i == ways + x;
        for (int n = 0; n < count; n++)
            reach[ways + x][n] = 0.0;
        list[count++] = state;
    }
    for (int i = 0; i < size; i++) {
        memset(d, 0, sizeof d);
        memset(k, 0, sizeof k);
        for (int change = 0; change < ways + size; change++) {
            const double by = a->by[change][i], *way = reach[change < ways ? change : change - ways];

            for (int n = 0; n < count && by != 0.0; n++)
                (change < ways ? k : d)[n] += by * way[n];
        }
        for (int m = 0; m < count; m++)
            for (int n = 0; n < count && reach[i][m] != 0.0; n++) {
                D[list[m]][list[n]] += reach[i][m] * d[n];
                K[list[m]][list[n]] += reach[i][m] * k[n];
            }
    }
    for (int m = 0; m < count; m++)
        for (int n = 0; n < count; n++)
            filled[list[m]][list[n]] = 1;
}

/* Keep what an act gives, or, behind a small change, what the change has done. */
static void keep(const MbsData *s, Act *a, int ways, int change, const double *force)
{
    for (int i = 0; i < ways + a->count; i++) {
        const double now = i < ways ? force[i] : s->uxd[a->state[i - ways]];

        if (change < 0)
            a->here[i] = now;
        else
            a->by[change][i] = (now - a->here[i]) / NEAR;
    }
}

static void move_joints(MbsData *s, int way, double by)
{
    for (int j = 1; j <= JOINTS; j++) {
        s->q[j] += way == 0 ? by : 0.0;
        s->qd[j] += way == 1 ? by : 0.0;
        for (int x = 0; x < joint[j].count && way == 2; x++)
            s->ux[joint[j].state[x]] += by;
    }
}

/* The force of a joint depends on this joint alone, so all joints are moved at once. */
static void add_joints(MbsData *s)
{
    double leads[MOST], reach[6 + OWN][MOST];
    int list[MOST];

    for (int way = -1; way < 3; way++) {
        move_joints(s, way, NEAR);
        run_JointForces(s, s->tsim);
        move_joints(s, way, -NEAR);
        for (int j = 1; j <= JOINTS; j++) {
            keep(s, &joint[j], 1, way, &s->Qq[j]);
            if (way == 0 || way == 1) /* a force that drives its joint away is left explicit */
                joint[j].by[way][0] = fmin(joint[j].by[way][0], 0.0);
        }
    }
    for (int j = 1; j <= JOINTS; j++) {
        int count = 0;

        find_leads(j, leads);
        for (int u = 0; u < s->nqu; u++)
            if (leads[u] != 0.0) {
                list[count] = u;
                reach[0][count++] = leads[u];
            }
        add(&joint[j], 1, count, list, reach);
    }
}

static void add_body(MbsData *s, int number)
{
    Act *a = &body[number];
    double lead[6][MOST] = {{0}}, reach[6 + OWN][MOST], leads[MOST], force[6], motion[12] = {0};
    int list[MOST], count = 0;

    find_body(s, number);
    for (int j = 1; j <= JOINTS; j++) {
        const double turn[4] = {0.0, frame.J[4][j], frame.J[5][j], frame.J[6][j]};
        double moved = 0.0;

        for (int i = 1; i <= 6; i++)
            moved += fabs(frame.J[i][j]);
        if (moved == 0.0)
            continue;
        find_leads(j, leads);
        for (int u = 0; u < s->nqu; u++)
            for (int i = 1; i <= 3 && leads[u] != 0.0; i++) {
                lead[i - 1][u] += (frame.J[i][j] + cross(turn, arm, i)) * leads[u];
                lead[2 + i][u] += turn[i] * leads[u];
            }
    }
    for (int u = 0; u < s->nqu; u++) {
        double moved = 0.0;

        for (int i = 0; i < 6; i++) {
            reach[i][count] = lead[i][u];
            moved += fabs(lead[i][u]);
        }
        if (moved > 0.0)
            list[count++] = u;
    }
    find_force(s, number, motion, force);
    keep(s, a, 6, -1, force);
    for (int change = 0; change < 12 + a->count; change++) {
        double *moved = change < 12 ? &motion[change] : &s->ux[a->state[change - 12]];
        const double before = *moved;

        *moved += NEAR;
        find_force(s, number, motion, force);
        *moved = before;
        keep(s, a, 6, change, force);
    }
    add(a, 6, count, list, reach);
}

/* --- the matrix of a step --- */

/* True if an external force has begun since the slopes were taken, or its states are not back at zero:
   explicit steps would let them grow where they spring back within less than a step. */
static int begins(const MbsData *s, int number)
{
    int acts = 0;

    for (int k = 1; k <= 6; k++)
        acts |= s->SWr[number][k] != 0.0;
    for (int k = 0; k < body[number].count; k++)
        acts |= fabs(s->ux[body[number].state[k]]) > REST;
    return acts && !touches[number] && last_joint[number] > 0;
}

int any_begins(const MbsData *s)
{
    int begun = 0;

    for (int b = 1; b <= FORCES; b++)
        begun |= begins(s, b);
    return begun;
}

/* List what is not zero, and what becomes so when the matrix is factored from the last row on: of a tree,
   nothing does. */
static void list_columns(void)
{
    for (int k = unknowns - 1; k >= 0; k--) {
        int *list = column[k];

        columns[k] = 0;
        for (int j = 0; j < k; j++)
            if (filled[k][j])
                list[columns[k]++] = j;
        for (int m = 0; m < columns[k]; m++)
            for (int n = 0; n < m; n++)
                filled[list[m]][list[n]] = 1;
    }
}

/* Take the slopes, and the mass matrix, in the state that was computed last. */
void take_slopes(MbsData *s)
{
    const int n = s->nqu;
    double force;

    unknowns = n;
    factored = 0.0;
    memset(touches, 0, sizeof touches);
    for (int i = 0; i < n; i++) {
        const double *row = mass_row(s->qu[i + 1], &force);

        for (int j = 0; j < n; j++) {
            M[i][j] = row[s->qu[j + 1]];
            D[i][j] = K[i][j] = 0.0;
            filled[i][j] = M[i][j] != 0.0;
        }
    }
    for (int b = 1; b <= FORCES; b++)
        if (begins(s, b)) {
            touches[b] = 1;
            add_body(s, b);
        }
    add_joints(s);
    list_columns();
}

static void factor(double h)
{
    factored = h;
    for (int i = 0; i < unknowns; i++) {
        A[i][i] = M[i][i] - h * (D[i][i] + h * K[i][i]);
        for (int m = 0; m < columns[i]; m++) {
            const int j = column[i][m];

            A[i][j] = M[i][j] - h * (D[i][j] + h * K[i][j]);
            A[j][i] = M[j][i] - h * (D[j][i] + h * K[j][i]);
        }
    }
    for (int k = unknowns - 1; k >= 0; k--)
        for (int m = 0; m < columns[k]; m++) {
            double *row = A[column[k][m]];

            row[k] /= A[k][k];
            for (int j = 0; j < columns[k] && row[k] != 0.0; j++)
                row[column[k][j]] -= row[k] * A[k][column[k][j]];
        }
}

/* Solve (1 - h slopes) u = h g for u, of a state with g: (M - h D - h h K) u = h (M g + h K speed) for what
   is unknown. */
void solve(const MbsData *s, double h, const double *g, double *u)
{
    const int n = s->nqu;
    const double *rate = g + 2 * n - 1;
    double b[MOST], gain[MOST], way[MOST];

    if (h != factored)
        factor(h);
    for (int i = 0; i < unknowns; i++) {
        gain[i] = h * (i < n ? g[n + i] : rate[state_at[i]]);
        way[i] = i < n ? h * h * g[i] : 0.0;
        b[i] = M[i][i] * gain[i] + K[i][i] * way[i];
        for (int m = 0; m < columns[i]; m++) {
            const int j = column[i][m];

            b[i] += M[i][j] * gain[j] + K[i][j] * way[j];
            b[j] += M[j][i] * gain[i] + K[j][i] * way[i];
        }
    }
    for (int k = unknowns - 1; k >= 0; k--)
        for (int m = 0; m < columns[k]; m++)
            b[column[k][m]] -= A[column[k][m]][k] * b[k];
    for (int k = 0; k < unknowns; k++) {
        for (int m = 0; m < columns[k]; m++)
            b[k] -= A[k][column[k][m]] * b[column[k][m]];
        b[k] /= A[k][k];
    }
    for (int i = 0; i < n; i++) {
        u[n + i] = b[i];
        u[i] = h * (g[i] + b[i]);
    }
    for (int k = 1; k <= STATES; k++)
        u[2 * n - 1 + k] = h * rate[k];
    for (int i = n; i < unknowns; i++)
        u[2 * n - 1 + state_at[i]] = b[i];
}

/* --- the states of the forces --- */

/* Find which states each force sets: call it once, in a state.  0 if there are not too many. */
int find_states(MbsData *s)
{
    const double still[12] = {0};
    double force[6], rate[STATES + 1], before[STATES + 1];

    memcpy(before, s->uxd, sizeof before);
    for (int f = 1; f <= FORCES; f++) {
        Act *a = &body[f];

        a->count = 0;
        for (int k = 1; k <= STATES; k++)
            s->uxd[k] = NAN;
        if (last_joint[f] > 0) {
            find_body(s, f);
            find_force(s, f, still, force);
        }
        for (int k = 1; k <= STATES; k++)
            if (!isnan(s->uxd[k]) && a->count++ < OWN)
                a->state[a->count - 1] = k;
        if (a->count > OWN)
            return -1;
    }
    run_JointForces(s, s->tsim);
    memcpy(rate, s->uxd, sizeof rate);
    for (int j = 1; j <= JOINTS; j++) {
        s->qd[j] += 1.0;
        run_JointForces(s, s->tsim);
        s->qd[j] -= 1.0;
        joint[j].count = 0;
        for (int k = 1; k <= STATES; k++)
            if (s->uxd[k] != rate[k] && !isnan(s->uxd[k])) {
                joint[j].state[0] = k;
                joint[j].count = 1;
            }
    }
    memcpy(s->uxd, before, sizeof before);
    return 0;
}

