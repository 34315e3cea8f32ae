/* The interactive robot of a page: a simulation as WebAssembly.  The page writes the numbers that live.py has
   packed, lets time pass, and reads the numbers again. */
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

/* Each of these takes what is packed next: a row has its length before it, a table its number of rows. */
static double *take_row(double **next)
{
    double *row = *next + 1;

    *next = row + (int) row[-1];
    return row;
}

static double **take_table(double **next)
{
    const int n = (int) *(*next)++;
    double **rows = malloc(n * sizeof *rows);

    for (int i = 0; i < n; i++)
        rows[i] = take_row(next);
    return rows;
}

static void take_integers(double **next, int *integers)
{
    const int n = (int) **next;
    const double *values = take_row(next);

    for (int i = 0; i < n; i++)
        integers[i] = (int) values[i];
}

/* Return where the page puts so many numbers. */
double *room(int n)
{
    return malloc(n * sizeof(double));
}

/* Go on at time 0 from the q, qd and ux that the numbers have.  Return 0 if that can be done. */
int restart(Page *page)
{
    Run *run = page->run;
    MbsData *s = &run->data;
    const int n = s->nqu;

    for (int i = 0; i < n; i++) {
        page->y[i] = s->q[s->qu[i + 1]];
        page->y[n + i] = s->qd[s->qu[i + 1]];
    }
    memcpy(page->y + 2 * n, s->ux + 1, s->Nux * sizeof *page->y);
    for (int i = 0; i < s->nqv; i++)
        s->guess[i] = s->q[s->qv[i + 1]];
    page->integration.t = 0.0;
    page->integration.h = page->first_step;
    run->is_turned = s->flag_stop = 0;
    turn_if_near(run, page->y);
    if (accelerate(run, 0.0, page->y, page->f))
        return -1;
    begin_steps(run, page->integration.atol);
    if (page->integration.calls_loop)
        call_loop(run);
    return 0;
}

/* Take the model of the numbers that are packed.  Return the page's robot, or 0 if it cannot start. */
Page *begin(double *packed)
{
    Page *page = calloc(1, sizeof *page);
    Run *run = calloc(1, get_run_size());
    MbsData *s = &run->data;
    double *next = packed, *settings = take_row(&next);
    double **rows[] = {
        &s->q, &s->qd, &s->qdd, &s->q0, &s->Qq, &s->Qc, &s->ux, &s->uxd, &s->m, &s->lrod, &s->Z, &s->Zd,
        &s->Fl, &s->qd0, &s->Lambda, &s->guess,
    };
    double ***tables[] = {&s->l, &s->In, &s->frc, &s->trq, &s->SWr, &s->l3DWr};
    int equations[N_JOINTS + 1];

    initialize_run(run);
    page->run = run;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        *rows[i] = take_row(&next);
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        *tables[i] = take_table(&next);
    memcpy(s->dpt, take_table(&next), sizeof s->dpt);
    memcpy(s->g, take_row(&next), sizeof s->g);
    s->user_model = (UserModel *) take_row(&next);
    run->state_scale = take_row(&next);
    take_integers(&next, page->qu);
    take_integers(&next, page->qv);
    take_integers(&next, page->points);
    take_integers(&next, page->last_joint);
    take_integers(&next, equations);
    s->njoint = N_JOINTS;
    s->Nux = N_STATES;
    s->DonePart = 1;
    s->process = 3;
    s->qu = page->qu;
    s->qv = page->qv;
    s->xfidpt = page->points;
    s->nqu = (int) settings[0];
    s->nqv = (int) settings[1];
    run->last_joint = page->last_joint;
    run->pushes = page->pull;
    run->can_turn = (int) settings[2];
    page->first_step = settings[4];
    page->integration = (Integration) {
        .y = page->y, .calls_loop = (int) settings[3], .longest_step = settings[5],
        .rtol = settings[6], .atol = settings[7],
    };
    set_partition(run, equations);
    user_dirdyn_init(s, &run->dirdyn);
    return restart(page) ? NULL : page;
}

/* Let time pass until end, by at most so many steps; the numbers are then those of the time that is returned.
   Return -1 where no step is short enough, -2 where user code has ended the run. */
double go(Page *page, double end, int most_steps)
{
    Integration *integration = &page->integration;

    integration->end = end;
    integration->most_steps = most_steps;
    if (advance(page->run, integration) < 0 || accelerate(page->run, integration->t, page->y, page->f))
        return -1.0;
    show_model_axes(page->run);
    return page->run->data.flag_stop ? -2.0 : integration->t;
}

/* Pull with a force (N, in the axes of the base) at a point (m, in the axes of the body) of the body behind a
   joint; 0 is no joint. */
void pull_at(Page *page, int joint, double x, double y, double z, double fx, double fy, double fz)
{
    page->pull[0] = (Push) {joint, {0.0, x, y, z}, {0.0, fx, fy, fz}, -1.0, HUGE_VAL};
}
