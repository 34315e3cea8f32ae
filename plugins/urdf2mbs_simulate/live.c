/* The live robot of a page: a simulation by itself, as WebAssembly.  The page writes the numbers that live.py
   has packed, lets time pass, and reads the numbers again.

   Compiled with RUN_JOINTS, RUN_FORCES and RUN_STATES: how many joints, external forces and user states. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime.h"

static MbsData data;
static double state[2 * RUN_JOINTS + RUN_STATES + 1], rate[2 * RUN_JOINTS + RUN_STATES + 1];
static double now, step, most, relative, absolute;
static int loops, qu[RUN_JOINTS + 1], qv[RUN_JOINTS + 1], points[RUN_FORCES + 1];
static Push pull[2];
static double *next; /* of what is packed: each row has its length before it, each table its number of rows */

static double *row(void)
{
    double *found = next + 1;

    next = found + (int) *next;
    return found;
}

static double **table(void)
{
    const int count = (int) *next++;
    double **rows = malloc(count * sizeof *rows);

    for (int i = 0; i < count; i++)
        rows[i] = row();
    return rows;
}

static void take_integers(int *found)
{
    const int count = (int) *next;
    const double *values = row();

    for (int i = 0; i < count; i++)
        found[i] = (int) values[i];
}

/* Where the page puts so many numbers. */
double *room(int count)
{
    return malloc(count * sizeof(double));
}

/* Go on at time 0 from the q, qd and ux that the numbers have.  0 if that can be done. */
int restart(void)
{
    const int n = data.nqu;

    for (int i = 0; i < n; i++) {
        state[i] = data.q[qu[i + 1]];
        state[n + i] = data.qd[qu[i + 1]];
    }
    memcpy(state + 2 * n, data.ux + 1, data.Nux * sizeof *state);
    for (int i = 0; i < data.nqv; i++)
        data.guess[i] = data.q[qv[i + 1]];
    now = turned = data.flag_stop = 0;
    turn_if_near(&data, state);
    if (accelerate(&data, now, state, rate) || begin_steps(&data))
        return -1;
    if (loops) {
        show_base(&data);
        user_dirdyn_loop(&data, &dirdyn);
        hide_base(&data);
    }
    return 0;
}

/* The model of the numbers that are packed. */
int begin(double *packed)
{
    const double *settings;
    double **rows[] = {
        &data.q, &data.qd, &data.qdd, &data.q0, &data.Qq, &data.Qc, &data.ux, &data.uxd, &data.m,
        &data.lrod, &data.Z, &data.Zd, &data.Fl, &data.qd0, &data.Lambda, &data.guess,
    };
    double ***tables[] = {&data.l, &data.In, &data.frc, &data.trq, &data.SWr, &data.l3DWr};
    int kept[RUN_JOINTS + 1];

    next = packed;
    settings = row();
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        *rows[i] = row();
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        *tables[i] = table();
    memcpy(data.dpt, table(), sizeof data.dpt);
    memcpy(data.g, row(), sizeof data.g);
    data.user_model = (UserModel *) row();
    take_integers(qu), take_integers(qv), take_integers(points), take_integers(last_joint);
    take_integers(kept);
    data.njoint = RUN_JOINTS, data.Nux = RUN_STATES, data.DonePart = 1, data.process = 3;
    data.qu = qu, data.qv = qv, data.xfidpt = points;
    data.nqu = (int) settings[0], data.nqv = (int) settings[1];
    can_turn = (int) settings[2], loops = (int) settings[3];
    step = settings[4], most = settings[5], relative = settings[6], absolute = settings[7];
    set_partition(&data, kept);
    pushes = pull;
    user_dirdyn_init(&data, &dirdyn);
    return restart();
}

/* Let time pass until end, by at most so many steps; the numbers are then those of the time that it gives.
   -1 where no step is short enough, -2 where user code has ended the run. */
double go(double end, int count)
{
    if (advance(&data, &now, end, &step, most, state, relative, absolute, count, loops) < 0
        || accelerate(&data, now, state, rate))
        return -1.0;
    show_base(&data);
    return data.flag_stop ? -2.0 : now;
}

/* A force (N, in the axes of the base) pulls at a point (m, in the axes of the body) of the body behind a
   joint; 0 is no joint. */
void pull_at(int joint, double x, double y, double z, double fx, double fy, double fz)
{
    const Push one = {joint, {0.0, x, y, z}, {0.0, fx, fy, fz}, -1.0, HUGE_VAL};

    pull[0] = one;
}
