/* Steps in C: linearly implicit ones of order 3, whose slopes (slopes.c) may be old or rough: the method
   ROS34PW2 of Rang and Angermann, BIT 45, 2005.  While nothing is stiff they are explicit, of order 5, by
   Dormand and Prince (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.5).

   Compiled with RUN_JOINTS, RUN_FORCES and RUN_STATES: how many joints, external forces and user states. */
#include <math.h>
#include <string.h>

#include "runtime.h"

enum { JOINTS = RUN_JOINTS, FORCES = RUN_FORCES, STATES = RUN_STATES, ALL = 2 * JOINTS + STATES + 1 };
enum { MANY = 15, SERVE = 4 };        /* stiff steps until they are implicit; steps that slopes serve for */
enum { UNKNOWN = 0, KNOWN, REFUSED }; /* a state: its derivative is found, or a step from it was refused */

/* The state of a stage is y plus by times the parts of the stages before, at the time t + at h.  The part of a
   stage is h times the derivative of its state.  An implicit method adds change times the parts before, and
   solves (1 - gamma h slopes) part = gamma times the sum.  The next y is the state of the last stage; an
   implicit method adds its part.  The error is off times the parts. */
typedef struct {
    int stages;
    double order, gamma, at[7], by[7][6], change[7][6], off[7];
} Method;

static const Method IMPLICIT = {
    .stages = 4, .order = 3.0, .gamma = 0.435866521508459,
    .at = {0.0, 0.871733043016918, 0.731579957790206, 1.0},
    .by = {
        {0.0},
        {2.0},
        {1.4192173174619762, -0.2592322116698636},
        {4.18476048231916, -0.2851920173554942, 2.294280360279042},
    },
    .change = {
        {0.0},
        {-4.588560720558083},
        {-4.18476048231916, 0.2851920173554942},
        {-6.368179200128357, -6.795620944466834, 2.8700986043310555},
    },
    .off = {0.27774994764796457, -1.403239895176002, 1.7726301276675522, 0.5},
};
static const Method EXPLICIT = {
    .stages = 7, .order = 5.0, .at = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0},
    .by = {
        {0.0},
        {1.0 / 5},
        {3.0 / 40, 9.0 / 40},
        {44.0 / 45, -56.0 / 15, 32.0 / 9},
        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
        {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
    },
    .off = {
        71.0 / 57600, 0.0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40,
    },
};

static int stiff, served;             /* by steps: how stiff it is, and how old the slopes are */
static double found[ALL], start[ALL]; /* the derivative of the state, last and at the start of a step */

/* Call it once, in a state, before the first step.  0 if no force sets too many user states. */
int begin_steps(MbsData *s)
{
    stiff = 0;
    served = SERVE;
    return find_states(s);
}

/* Get ready for a step from a state.  0 if the state has a derivative. */
static int prepare(MbsData *s, double t, const double *y, int from, int implicit)
{
    if (from == UNKNOWN && accelerate(s, t, y, found))
        return -1;
    if (from != REFUSED) {
        memcpy(start, found, sizeof start);
        for (int k = 1; k <= s->nqv; k++)
            s->guess[k - 1] = s->q[s->qv[k]];
    }
    if (implicit && (served >= SERVE || (from != REFUSED && any_begins(s)))) {
        if (from == REFUSED && accelerate(s, t, y, found))
            return -1;
        take_slopes(s);
        served = 0;
    }
    return 0;
}

/* The error of a step from y to next, as a part of what is allowed, where off is what each part of the
   state is off by.  What a speed is off by counts as the place that it leads to within a time. */
static double measure(const MbsData *s, double time, const double *y, const double *next, const double *off,
                      double rtol, double atol)
{
    const int n = s->nqu, size = 2 * n + STATES;
    double error = 0.0;

    for (int i = 0; i < size; i++) {
        const double allowed = atol + rtol * fmax(fabs(y[i]), fabs(next[i]));

        if (!isfinite(off[i]))
            return INFINITY;
        if (i < 2 * n)
            error = fmax(error, fabs(off[i]) * (i < n ? 1.0 : time) / allowed);
    }
    return error;
}

/* Compute a state at the end of a step h.  Gives the error of a force that begins there, as a part of what
   is allowed: no part of the step has felt it. */
static double miss(MbsData *s, double t, double h, const double *y, double rtol, double atol)
{
    const int n = s->nqu;
    double before[JOINTS + 1], error = 0.0;

    memcpy(before, found + n, n * sizeof *before);
    if (accelerate(s, t, y, found))
        return INFINITY;
    if (any_begins(s))
        for (int i = 0; i < n; i++)
            error = fmax(error, h * h * fabs(found[n + i] - before[i]) / (atol + rtol * fabs(y[i])));
    return error;
}

/* Count explicit steps that are as long as is stable: the slope between the last two stages, times h, is above
   3.25 (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.2). */
static void count_stiff(int size, const double *parts, const double *last_parts, const double *y,
                        const double *last)
{
    double steep = 0.0, apart = 0.0;

    for (int i = 0; i < size; i++) {
        steep += (last_parts[i] - parts[i]) * (last_parts[i] - parts[i]);
        apart += (last[i] - y[i]) * (last[i] - y[i]);
    }
    if (steep > 3.25 * 3.25 * apart)
        stiff += 3;
    else if (stiff > 0)
        stiff -= 1;
}

/* The state after h, in y, which is computed, too.  Gives the error, as a part of what is allowed. */
static double step(MbsData *s, const Method *m, double t, double h, double *y, double rtol, double atol)
{
    const int size = 2 * s->nqu + STATES, implicit = m == &IMPLICIT, last = m->stages - 1;
    double part[7][ALL], next[ALL] = {0}, before[ALL], off[ALL] = {0}, g[ALL], error;

    for (int k = 0; k <= last; k++) {
        memcpy(before, next, sizeof next);
        memcpy(next, y, size * sizeof *y);
        memset(g, 0, sizeof g);
        for (int j = 0; j < k; j++)
            for (int i = 0; i < size; i++) {
                next[i] += m->by[k][j] * part[j][i];
                g[i] += m->change[k][j] / h * part[j][i];
            }
        if (k > 0 && accelerate(s, t + m->at[k] * h, next, found))
            return INFINITY;
        for (int i = 0; i < size; i++) {
            g[i] += k > 0 ? found[i] : start[i];
            part[k][i] = h * g[i];
        }
        if (implicit)
            solve(s, m->gamma * h, g, part[k]);
    }
    for (int k = 0; k <= last; k++)
        for (int i = 0; i < size; i++)
            off[i] += m->off[k] * part[k][i];
    if (implicit) { /* what is stiff has less of an error than the method says */
        for (int i = 0; i < size; i++) {
            next[i] += part[last][i];
            g[i] = off[i] / (m->gamma * h);
        }
        solve(s, m->gamma * h, g, off);
        error = measure(s, h, y, next, off, rtol, atol);
        if (error <= 1.0)
            error = fmax(error, miss(s, t + h, h, next, rtol, atol));
    } else {
        count_stiff(size, part[last - 1], part[last], before, next);
        error = measure(s, 1.0, y, next, off, rtol, atol);
    }
    if (error <= 1.0)
        memcpy(y, next, size * sizeof *y);
    return error;
}

/* Step from *t to end, by at most so many steps; *h is the next one.  Gives how many it took, or -1 where
   none is short enough.  loops: the user's loop is called after each step. */
int advance(MbsData *s, double *t, double end, double *h, double most, double *y, double rtol,
            double atol, int count, int loops)
{
    int taken = 0, from = UNKNOWN;
    double angles[3];

    memcpy(angles, own_angles, sizeof angles);
    while (*t < end && taken < count && !s->flag_stop) {
        const double left = end - *t, now = left / ceil(left / fmin(*h, most)); /* no rest is short */
        const Method *m = FORCES || stiff >= MANY ? &IMPLICIT : &EXPLICIT;
        double error;

        if (prepare(s, *t, y, from, m == &IMPLICIT))
            return -1;
        error = step(s, m, *t, now, y, rtol, atol);
        *h = now * fmin(from == REFUSED ? 1.0 : 2.0, fmax(0.2, 0.9 / pow(error, 1.0 / m->order)));
        if (error > 1.0) {
            from = REFUSED;
            if (served > 0) /* old slopes do not serve for the next try */
                served = SERVE;
            memcpy(own_angles, angles, sizeof angles); /* the step may have led anywhere */
            if (*h < 1e-13)
                return -1;
            continue;
        }
        *t = now == left ? end : *t + now;
        taken++;
        served++;
        if (loops)
            call_loop(s);
        from = loops ? UNKNOWN : KNOWN; /* the loop may change what acts */
        if (turn_if_near(s, y)) {
            from = UNKNOWN;
            served = SERVE;
        }
        memcpy(angles, own_angles, sizeof angles);
    }
    return taken;
}
