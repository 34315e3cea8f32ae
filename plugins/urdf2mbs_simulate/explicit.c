/* Explicit steps, for a robot on which no external force acts and whose joints are not stiff: the method of
   Dormand and Prince of order 5 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I,
   II.5).  Their error is measured as that of the implicit ones.

   Compiled with RUN_JOINTS and RUN_STATES: how many joints and user states. */
#include <math.h>
#include <string.h>

#include "runtime.h"

enum { ALL = 2 * RUN_JOINTS + RUN_STATES + 1 };

static const double AT[7] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
static const double BY[7][6] = {
    {0.0},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
};
static const double OFF[7] = {
    71.0 / 57600, 0.0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40,
};

/* The error of a step from y to next, as a part of what is allowed, where off is what each part of the
   state is off by.  What a speed is off by counts as the place that it leads to within a time. */
double measure(const MbsData *s, double time, const double *y, const double *next, const double *off,
               double rtol, double atol)
{
    const int n = s->nqu, size = 2 * n + RUN_STATES;
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

/* The state after h, in y.  Gives the error, as a part of what is allowed.  slope: the derivative of the
   state, which is that of y if known.  *stiff grows by a step that is as long as is stable, where h times the
   largest slope is above 3.25 (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.2), and
   else falls. */
double explicit_step(MbsData *s, double t, double h, double *y, double *slope, double rtol, double atol,
                     int known, int *stiff)
{
    const int size = 2 * s->nqu + RUN_STATES;
    double rate[7][ALL], next[ALL] = {0}, before[ALL], off[ALL] = {0}, error, steep = 0.0, apart = 0.0;

    memcpy(rate[0], slope, sizeof rate[0]);
    if (!known && accelerate(s, t, y, rate[0]))
        return INFINITY;
    for (int k = 1; k < 7; k++) {
        memcpy(before, next, sizeof next);
        for (int i = 0; i < size; i++) {
            next[i] = y[i];
            for (int j = 0; j < k; j++)
                next[i] += h * BY[k][j] * rate[j][i];
        }
        if (accelerate(s, t + AT[k] * h, next, rate[k]))
            return INFINITY;
    }
    for (int i = 0; i < size; i++) {
        for (int k = 0; k < 7; k++)
            off[i] += h * OFF[k] * rate[k][i];
        steep += (rate[6][i] - rate[5][i]) * (rate[6][i] - rate[5][i]);
        apart += (next[i] - before[i]) * (next[i] - before[i]);
    }
    if (h * h * steep > 3.25 * 3.25 * apart)
        *stiff += 3;
    else if (*stiff > 0)
        *stiff -= 1;
    error = measure(s, 1.0, y, next, off, rtol, atol);
    if (error <= 1.0) {
        memcpy(y, next, size * sizeof *y);
        memcpy(slope, rate[6], sizeof rate[6]);
    }
    return error;
}
