/* An integrator with an estimate of the error of each step.

   Where forces are stiff, steps are linearly implicit: the W-method ROS34PW2 of Rang and Angermann (BIT 45, 2005),
   of order 3 with any matrix J, so that J may be old or approximate (slopes.c).  In the notation of Hairer and
   Wanner, Solving Ordinary Differential Equations II, IV.7, for y' = f(t, y), stages i = 1 ... 4:

       (1 - gamma h J) U_i = gamma h [ f(t + alpha_i h, y + sum_j<i a_ij U_j) + sum_j<i c_ij / h U_j ]
       y_1 = y + sum_j a_4j U_j + U_4          error = (1 - gamma h J)^-1 sum_j e_j U_j

   The factor (1 - gamma h J)^-1 keeps the estimate bounded in stiff components, as the method damps them, too.

   Where nothing is stiff, steps are explicit, of order 5: the method of Dormand and Prince (Hairer, Norsett and
   Wanner, Solving Ordinary Differential Equations I, II.5), with U_j = h f_j, gamma = 0:

       U_i = h f(t + alpha_i h, y + sum_j<i a_ij U_j)     y_1 = y + sum_j a_7j U_j     error = sum_j e_j U_j

   Frames inside a step do not shorten it.  In an explicit step, their states are those of the interpolant of the
   method, of order 4 (II.6 of the same book).  An implicit step has no interpolant that is right for stiff states:
   a shorter step from the same start, with the same J, leads to the frame.

       start     frame            frame      end
         |---------:----------------:---------|       the step
         |-------->:                                  shorter steps, whose ends are the states at frames
         |------------------------->:  */
#include <math.h>
#include <string.h>

#include "runtime.h"

/* Steps are implicit from this stiffness_count on. */
enum { MAX_STIFF_STEPS = 15 };
/* The number of implicit steps that use a Jacobian. */
enum { MAX_JACOBIAN_AGE = 4 };
/* The largest number of frames inside a step. */
enum { MAX_FRAMES = 256 };
/* The start of a step: f is unknown there, or known, or a longer step from there was rejected. */
enum { UNKNOWN, KNOWN, REJECTED };

/* The error of a speed is weighted by a time (s): it is that of the position to which it leads in this time.
   While no external force acts, an error lasts to the end of a run.  While one acts, steps are short during
   impacts, after which the speeds are new, and long in lasting contact: the time is a multiple of the step. */
static const double FREE_SPEED_TIME = 1.0, MIN_SPEED_TIME = 0.01, SPEED_STEPS = 20.0;
/* The ratio of the next step to this one, and the error it aims at, relative to the allowed one. */
static const double MIN_GROWTH = 0.2, MAX_GROWTH = 2.0, SAFETY = 0.9;
static const double SHORTEST_STEP = 1e-13; /* s */
static const double ROUNDING = 1e-9;       /* of the number of steps that are left */
/* The largest rotation (rad) in a step of a base that may change its axes: turn.c takes the nearest angles. */
static const double MAX_ROTATION = 1.0;
/* h times the Lipschitz constant between the last two explicit stages, at the limit of stability (IV.2). */
static const double STABILITY_LIMIT = 3.25;

typedef struct {
    int n_stages;
    double order, gamma, alpha[MAX_STAGES], a[MAX_STAGES][6], c[MAX_STAGES][6], e[MAX_STAGES];
} Method;

static const Method ROS34PW2 = {
    .n_stages = 4, .order = 3.0, .gamma = 0.435866521508459,
    .alpha = {0.0, 0.871733043016918, 0.731579957790206, 1.0},
    .a = {
        {0.0},
        {2.0},
        {1.4192173174619762, -0.2592322116698636},
        {4.18476048231916, -0.2851920173554942, 2.294280360279042},
    },
    .c = {
        {0.0},
        {-4.588560720558083},
        {-4.18476048231916, 0.2851920173554942},
        {-6.368179200128357, -6.795620944466834, 2.8700986043310555},
    },
    .e = {0.27774994764796457, -1.403239895176002, 1.7726301276675522, 0.5},
};
static const Method DORMAND_PRINCE = {
    .n_stages = 7, .order = 5.0, .alpha = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0},
    .a = {
        {0.0},
        {1.0 / 5},
        {3.0 / 40, 9.0 / 40},
        {44.0 / 45, -56.0 / 15, 32.0 / 9},
        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
        {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
    },
    .e = {
        71.0 / 57600, 0.0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40,
    },
};
/* The coefficients i_j of the interpolant of Dormand and Prince, see interpolate. */
static const double INTERPOLANT[MAX_STAGES] = {
    -12715105075.0 / 11282082432.0, 0.0, 87487479700.0 / 32700410799.0, -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0, 69997945.0 / 29380423.0,
};

/* Prepare steps from a state that accelerate has computed; call it before the first step. */
void begin_steps(Run *run, double atol)
{
    Steps *steps = &run->steps;

    steps->stiffness_count = 0;
    steps->is_touched = 0;
    steps->jacobian_age = MAX_JACOBIAN_AGE;
    for (int k = 1; k <= N_STATES; k++)
        steps->largest_state[k] = fabs(run->data.ux[k]);
    prepare_jacobian(run, atol);
}

/* Prepare a step from y: compute f there, and J if the step is implicit.  Return 0, or -1 if it failed. */
static int prepare_step(Run *run, double t, const double *y, int start, double atol)
{
    Steps *steps = &run->steps;
    MbsData *data = &run->data;

    if (start == UNKNOWN && accelerate(run, t, y, steps->f))
        return -1;
    if (start != REJECTED) {
        memcpy(steps->f_start, steps->f, sizeof steps->f);
        for (int k = 1; k <= data->nqv; k++)
            data->guess[k - 1] = data->q[data->qv[k]];
        steps->is_touched = any_force_acts(run);
    }
    if (!steps->is_touched && steps->stiffness_count < MAX_STIFF_STEPS)
        return 0;
    if (steps->jacobian_age >= MAX_JACOBIAN_AGE || (start != REJECTED && any_force_begins(run))) {
        if (start == REJECTED && accelerate(run, t, y, steps->f))
            return -1;
        update_jacobian(run, atol);
        steps->jacobian_age = 0;
    }
    return 0;
}

/* Compute the stages of a step from y, and its end next.  Return 0, or -1 if a stage has no derivative.

   After an explicit step, f is dy/dt at its end, which is the state of its last stage. */
static int compute_stages(Run *run, const Method *method, double t, double h, const double *y, double *next)
{
    Steps *steps = &run->steps;
    const int size = 2 * run->data.nqu + N_STATES, is_implicit = method == &ROS34PW2;
    double g[MAX_Y];

    for (int i = 0; i < method->n_stages; i++) {
        memcpy(next, y, size * sizeof *y);
        memset(g, 0, sizeof g);
        for (int j = 0; j < i; j++)
            for (int k = 0; k < size; k++) {
                next[k] += method->a[i][j] * steps->stage[j][k];
                g[k] += method->c[i][j] / h * steps->stage[j][k];
            }
        if (i > 0 && accelerate(run, t + method->alpha[i] * h, next, steps->f))
            return -1;
        for (int k = 0; k < size; k++) {
            g[k] += i > 0 ? steps->f[k] : steps->f_start[k];
            steps->stage[i][k] = h * g[k];
        }
        if (is_implicit)
            solve_stage(run, method->gamma * h, g, steps->stage[i]);
    }
    for (int k = 0; k < size && is_implicit; k++)
        next[k] += steps->stage[method->n_stages - 1][k];
    return 0;
}

/* Return the error of a step from y to next, relative to the allowed one:

       max( rms_q(e), rms_u(speed_time e), max_w(e) ),    e = |error| / (atol + rtol max(|y|, |next|))

   The root mean square over all joints is that of most integrators; of user states, the largest error is used. */
static double measure_error(const Run *run, const double *y, const double *next, const double *error,
                            double speed_time, const Integration *integration)
{
    const int n = run->data.nqu;
    double position_sum = 0.0, speed_sum = 0.0, state_error = 0.0;

    for (int i = 0; i < 2 * n + N_STATES; i++) {
        const double size = integration->rtol * fmax(fabs(y[i]), fabs(next[i])), atol = integration->atol;

        if (!isfinite(error[i]))
            return INFINITY;
        if (i < n)
            position_sum += pow(error[i] / (atol + size), 2.0) / n;
        else if (i < 2 * n)
            speed_sum += pow(speed_time * error[i] / (atol + size), 2.0) / n;
        else
            state_error = fmax(state_error, fabs(error[i]) / (run->state_scale[i - 2 * n + 1] * atol + size));
    }
    return fmax(sqrt(fmax(position_sum, speed_sum)), state_error);
}

/* Return the error of a force that begins at the end y of a step h, relative to the allowed one.

   Few stages, or none, have had this force.  It changes the accelerations by f - before. */
static double measure_new_force(const Run *run, double h, const double *y, const double *before,
                            const Integration *integration)
{
    const int n = run->data.nqu;
    double error = 0.0;

    for (int i = 0; i < n; i++)
        error = fmax(error, h * h * fabs(run->steps.f[n + i] - before[n + i])
                                / (integration->atol + integration->rtol * fabs(y[i])));
    return error;
}

/* Count explicit steps at the limit of stability (Hairer and Wanner, IV.2):

       h |f_7 - f_6| = |U_7 - U_6| > STABILITY_LIMIT |y_7 - y_6|      y_i = y + sum_j a_ij U_j */
static void count_stiff_steps(Steps *steps, int size)
{
    double dU_squared = 0.0, dy_squared = 0.0;

    for (int k = 0; k < size; k++) {
        const double dU = steps->stage[6][k] - steps->stage[5][k];
        double dy = 0.0;

        for (int j = 0; j < 6; j++)
            dy += (DORMAND_PRINCE.a[6][j] - DORMAND_PRINCE.a[5][j]) * steps->stage[j][k];
        dU_squared += dU * dU;
        dy_squared += dy * dy;
    }
    if (dU_squared > STABILITY_LIMIT * STABILITY_LIMIT * dy_squared)
        steps->stiffness_count += 3;
    else if (steps->stiffness_count > 0)
        steps->stiffness_count -= 1;
}

/* Compute the state next after a step h.  Return its error, relative to the allowed one. */
static double try_step(Run *run, const Method *method, double h, double *next, const Integration *integration)
{
    Steps *steps = &run->steps;
    const double *y = integration->y;
    const int size = 2 * run->data.nqu + N_STATES;
    double difference[MAX_Y] = {0}, g[MAX_Y], before[MAX_Y], speed_time, error;

    if (compute_stages(run, method, integration->t, h, y, next))
        return INFINITY;
    for (int i = 0; i < method->n_stages; i++)
        for (int k = 0; k < size; k++)
            difference[k] += method->e[i] * steps->stage[i][k];
    if (method == &DORMAND_PRINCE) {
        count_stiff_steps(steps, size);
        error = measure_error(run, y, next, difference, FREE_SPEED_TIME, integration);
        if (any_force_acts(run))
            error = fmax(error, measure_new_force(run, h, next, steps->f_start, integration));
        return error;
    }
    for (int k = 0; k < size; k++)
        g[k] = difference[k] / (method->gamma * h);
    solve_stage(run, method->gamma * h, g, difference);
    speed_time = steps->is_touched ? fmin(fmax(SPEED_STEPS * h, MIN_SPEED_TIME), FREE_SPEED_TIME) : FREE_SPEED_TIME;
    error = measure_error(run, y, next, difference, speed_time, integration);
    if (error > 1.0)
        return error;
    memcpy(before, steps->f, sizeof before);
    if (accelerate(run, integration->t + h, next, steps->f))
        return INFINITY;
    return any_force_begins(run) ? fmax(error, measure_new_force(run, h, next, before, integration)) : error;
}

/* Compute the state at a part (0 to 1) of an explicit step from y to next, by the interpolant (contd5 of DOPRI5 in
   the book), with p = 1 - part:

       y + part (d + p (U_1 - d + part (2 d - U_1 - U_7 + p sum_j i_j U_j)))      d = next - y */
static void interpolate(const Steps *steps, int size, const double *y, const double *next, double part,
                        double *frame)
{
    const double p = 1.0 - part;

    for (int k = 0; k < size; k++) {
        const double d = next[k] - y[k], bulge = steps->stage[0][k] - d;
        double sum = 0.0;

        for (int j = 0; j < MAX_STAGES; j++)
            sum += INTERPOLANT[j] * steps->stage[j][k];
        frame[k] = y[k] + part * (d + p * (bulge + part * (d - steps->stage[6][k] - bulge + p * sum)));
    }
}

/* Compute the states at the frames that a step from t, y to next has passed. */
static void compute_frames(Run *run, const Method *method, double t, double h, const double *next,
                           Integration *integration)
{
    const int size = 2 * run->data.nqu + N_STATES;
    const double *y = run->steps.y_start;
    int n = 0;

    for (; n < integration->n_frames && integration->frame_time[n] <= integration->t; n++) {
        const double length = integration->frame_time[n] - t;
        double *frame = integration->frame_y + n * size;

        if (integration->frame_time[n] == integration->t)
            memcpy(frame, next, size * sizeof *frame);
        else if (method == &DORMAND_PRINCE)
            interpolate(&run->steps, size, y, next, length / h, frame);
        else if (compute_stages(run, method, t, length, y, frame)) /* though the longer step did not fail */
            for (int k = 0; k < size; k++)
                frame[k] = y[k] + length / h * (next[k] - y[k]);
    }
    integration->n_passed = n;
}

/* Return the length of the next step.

   The steps that are left have equal lengths, so that the last one is not short; a step passes MAX_FRAMES at most. */
static double choose_step_length(const Run *run, const Integration *integration)
{
    const double left = integration->end - integration->t, *u = integration->y + run->data.nqu;
    double h = fmin(integration->h, integration->max_step);

    if (run->can_turn)
        h = fmin(h, MAX_ROTATION / (fabs(u[3]) + fabs(u[4]) + fabs(u[5])));
    h = left / fmax(1.0, ceil(left / h - ROUNDING));
    if (integration->n_frames > MAX_FRAMES)
        h = fmin(h, integration->frame_time[MAX_FRAMES - 1] - integration->t);
    return h;
}

/* Set the state to the end of an accepted step h, and compute the frames that it has passed. */
static void accept_step(Run *run, const Method *method, double h, double *next, Integration *integration)
{
    Steps *steps = &run->steps;
    const int n = run->data.nqu, size = 2 * n + N_STATES;
    const double t = integration->t, left = integration->end - t;

    memcpy(steps->y_start, integration->y, size * sizeof *next);
    memcpy(integration->y, next, size * sizeof *next);
    integration->t = h == left ? integration->end : t + h;
    steps->jacobian_age++;
    for (int k = 1; k <= N_STATES; k++)
        steps->largest_state[k] = fmax(steps->largest_state[k], fabs(next[2 * n + k - 1]));
    compute_frames(run, method, t, h, next, integration);
}

/* Take steps until the end, max_steps, or a step that has passed a frame.  Return the number of steps, or -1 if no
   step is short enough. */
int advance(Run *run, Integration *integration)
{
    Steps *steps = &run->steps;
    const double atol = integration->atol;
    int n_taken = 0, start = UNKNOWN;
    double next[MAX_Y], angles[3];

    integration->n_passed = 0;
    while (integration->t < integration->end && n_taken < integration->max_steps && !integration->n_passed
           && !run->data.flag_stop) {
        const double h = choose_step_length(run, integration);
        const Method *method;
        double error, growth;

        if (start != REJECTED && turn_if_near(run, integration->y)) {
            start = UNKNOWN;
            steps->jacobian_age = MAX_JACOBIAN_AGE;
        }
        memcpy(angles, run->shown_angles, sizeof angles);
        if (prepare_step(run, integration->t, integration->y, start, atol))
            return -1;
        method = steps->is_touched || steps->stiffness_count >= MAX_STIFF_STEPS ? &ROS34PW2 : &DORMAND_PRINCE;
        error = try_step(run, method, h, next, integration);
        growth = fmax(MIN_GROWTH, SAFETY / pow(error, 1.0 / method->order));
        integration->h = h * fmin(start == REJECTED ? 1.0 : MAX_GROWTH, growth);
        if (error > 1.0) {
            start = REJECTED;
            if (steps->jacobian_age > 0) /* the next try has a new Jacobian */
                steps->jacobian_age = MAX_JACOBIAN_AGE;
            memcpy(run->shown_angles, angles, sizeof angles); /* the rejected step may have led anywhere */
            if (integration->h < SHORTEST_STEP)
                return -1;
            continue;
        }
        accept_step(run, method, h, next, integration);
        n_taken++;
        start = KNOWN;
        if (integration->calls_loop) {
            call_loop(run);
            start = UNKNOWN; /* the loop may have changed the forces */
        }
    }
    return n_taken;
}
