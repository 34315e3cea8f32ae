/* The interactive robot of a page: a simulation as WebAssembly.

   The page copies the numbers that live.py has packed into the memory of WebAssembly.  MbsData points at them, so
   that the page reads and writes q, qd and the forces there, between calls of go. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime.h"

typedef struct {
    Run *run;
    Integration integration;
    double y[MAX_Y], f[MAX_Y], first_step;
    int qu[N_JOINTS + 1], qv[N_JOINTS + 1], points[N_FORCES + 1], last_joint[N_FORCES + 1];
    Push pull[2];
} Page;

/* Return the next row of the numbers, which its length precedes. */
static double *take_row(double **next)
{
    double *row = *next + 1;

    *next = row + (int) row[-1];
    return row;
}

/* Return the next rows of the numbers, which their number precedes. */
static double **take_table(double **next)
{
    const int n = (int) *(*next)++;
    double **rows = malloc(n * sizeof *rows);

    for (int i = 0; i < n; i++)
        rows[i] = take_row(next);
    return rows;
}

/* Copy the next row of the numbers to integers. */
static void take_integers(double **next, int *integers)
{
    const int n = (int) **next;
    const double *values = take_row(next);

    for (int i = 0; i < n; i++)
        integers[i] = (int) values[i];
}

/* Return memory for n numbers, which the page fills. */
double *room(int n)
{
    return malloc(n * sizeof(double));
}

/* Start at time 0 from the q, qd and ux of the numbers.  Return 0, or -1 if the loops cannot be closed. */
int restart(Page *page)
{
    Run *run = page->run;
    MbsData *data = &run->data;
    const int n = data->nqu;

    for (int i = 0; i < n; i++) {
        page->y[i] = data->q[data->qu[i + 1]];
        page->y[n + i] = data->qd[data->qu[i + 1]];
    }
    memcpy(page->y + 2 * n, data->ux + 1, data->Nux * sizeof *page->y);
    for (int i = 0; i < data->nqv; i++)
        data->guess[i] = data->q[data->qv[i + 1]];
    page->integration.t = 0.0;
    page->integration.h = page->first_step;
    run->is_turned = data->flag_stop = 0;
    turn_if_near(run, page->y);
    if (accelerate(run, 0.0, page->y, page->f))
        return -1;
    begin_steps(run, page->integration.atol);
    if (page->integration.calls_loop)
        call_loop(run);
    return 0;
}

/* Unpack the numbers of live.py, and start.  Return the robot, or NULL if it cannot start. */
Page *begin(double *packed)
{
    Page *page = calloc(1, sizeof *page);
    Run *run = calloc(1, get_run_size());
    MbsData *data = &run->data;
    double *next = packed, *settings = take_row(&next);
    double **rows[] = {
        &data->q, &data->qd, &data->qdd, &data->q0, &data->Qq, &data->Qc, &data->ux, &data->uxd,
        &data->m, &data->lrod, &data->Z, &data->Zd, &data->Fl, &data->qd0, &data->Lambda, &data->guess,
    };
    double ***tables[] = {&data->l, &data->In, &data->frc, &data->trq, &data->SWr, &data->l3DWr};
    int equations[N_JOINTS + 1];

    initialize_run(run);
    page->run = run;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        *rows[i] = take_row(&next);
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        *tables[i] = take_table(&next);
    memcpy(data->dpt, take_table(&next), sizeof data->dpt);
    memcpy(data->g, take_row(&next), sizeof data->g);
    data->user_model = (UserModel *) take_row(&next);
    run->state_scale = take_row(&next);
    take_integers(&next, page->qu);
    take_integers(&next, page->qv);
    take_integers(&next, page->points);
    take_integers(&next, page->last_joint);
    take_integers(&next, equations);
    data->njoint = N_JOINTS;
    data->Nux = N_STATES;
    data->DonePart = 1;
    data->process = 3;
    data->qu = page->qu;
    data->qv = page->qv;
    data->xfidpt = page->points;
    data->nqu = (int) settings[0];
    data->nqv = (int) settings[1];
    run->last_joint = page->last_joint;
    run->pushes = page->pull;
    run->can_turn = (int) settings[2];
    page->first_step = settings[4];
    page->integration = (Integration) {
        .y = page->y, .calls_loop = (int) settings[3], .max_step = settings[5],
        .rtol = settings[6], .atol = settings[7],
    };
    set_partition(run, equations);
    user_dirdyn_init(data, &run->dirdyn);
    return restart(page) ? NULL : page;
}

/* Integrate until end, by at most max_steps.  Return the time that was reached, of which the numbers are then; -1 if
   no step is short enough, -2 if user code has ended the run. */
double go(Page *page, double end, int max_steps)
{
    Integration *integration = &page->integration;

    integration->end = end;
    integration->max_steps = max_steps;
    if (advance(page->run, integration) < 0 || accelerate(page->run, integration->t, page->y, page->f))
        return -1.0;
    show_model_axes(page->run);
    return page->run->data.flag_stop ? -2.0 : integration->t;
}

/* Pull with a force (N, in the axes of the base) at a point (m, in the axes of the body) of the body after a joint;
   the joint 0 ends the pull. */
void pull_at(Page *page, int joint, double x, double y, double z, double fx, double fy, double fz)
{
    page->pull[0] = (Push) {joint, {0.0, x, y, z}, {0.0, fx, fy, fz}, -1.0, HUGE_VAL};
}
