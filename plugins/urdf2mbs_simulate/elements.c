/* Derivatives of the force elements of slopes.c, by differences of the user functions. */
#include <math.h>
#include <string.h>

#include "runtime.h"

static const double DIFFERENCE = 1e-7;     /* of a coordinate or its rate: m, rad, m/s, rad/s */
static const double STATE_DIFFERENCE = 1e-7; /* of a user state: so small a part of its size, */
static const double MIN_STATE_PART = 1e-2;   /* or of its absolute tolerance */

/* The step of a difference by a user state: the square root of rounding, in parts of the state's own size. */
double get_state_difference(const Run *run, int state, double atol)
{
    const double size = fmax(fabs(run->data.ux[state]), run->steps.largest_state[state]);

    return fmax(STATE_DIFFERENCE * size, MIN_STATE_PART * atol);
}

/* Find the states whose rates an external force sets.  Those beyond MAX_ELEMENT_STATES stay explicit. */
void find_body_states(Run *run, int number)
{
    MbsData *s = &run->data;
    const double no_motion[2 * MAX_COORDINATES] = {0};
    ForceElement *element = &run->jacobian.body[number];
    double force[MAX_COORDINATES];

    element->n_coordinates = MAX_COORDINATES;
    element->n_states = 0;
    for (int k = 1; k <= N_STATES; k++)
        s->uxd[k] = NAN;
    compute_anchor_frame(run, number);
    compute_external_force(run, number, no_motion, force);
    for (int k = 1; k <= N_STATES; k++) {
        if (isnan(s->uxd[k]) || run->jacobian.body_of_state[k])
            continue;
        run->jacobian.body_of_state[k] = number;
        if (element->n_states < MAX_ELEMENT_STATES)
            element->state[element->n_states++] = k;
    }
}

/* Copy the outputs: forces, from the user function, and rates of states, which it has put into s->uxd. */
static void copy_outputs(const MbsData *s, const ForceElement *element, const double *force, double *output)
{
    for (int i = 0; i < element->n_coordinates; i++)
        output[i] = force[i];
    for (int i = 0; i < element->n_states; i++)
        output[element->n_coordinates + i] = s->uxd[element->state[i]];
}

/* dy/d(input) = (y(input + difference) - y(input)) / difference, where the first was computed just now. */
static void differentiate(const MbsData *s, ForceElement *element, const double *force, int input,
                          double difference)
{
    double output[MAX_OUTPUTS] = {0};

    copy_outputs(s, element, force, output);
    for (int i = 0; i < element->n_coordinates + element->n_states; i++)
        element->derivative[input][i] = (output[i] - element->output[i]) / difference;
}

/* Differentiate an external force by the motion of its body, in the frame that was computed last. */
void differentiate_external_force(Run *run, int number, double atol)
{
    MbsData *s = &run->data;
    ForceElement *element = &run->jacobian.body[number];
    const int n_motion = 2 * element->n_coordinates;
    double force[MAX_COORDINATES], motion[2 * MAX_COORDINATES] = {0};

    compute_external_force(run, number, motion, force);
    copy_outputs(s, element, force, element->output);
    for (int input = 0; input < n_motion + element->n_states; input++) {
        const int is_motion = input < n_motion, state = is_motion ? 0 : element->state[input - n_motion];
        const double difference = is_motion ? DIFFERENCE : get_state_difference(run, state, atol);
        double *value = is_motion ? &motion[input] : &s->ux[state];
        const double before = *value;

        *value += difference;
        compute_external_force(run, number, motion, force);
        *value = before;
        differentiate(s, element, force, input, difference);
    }
}

/* Differentiate the force of a link, which pulls its ends together, by its length and the rate of it. */
void differentiate_link(Run *run, int number)
{
    MbsData *s = &run->data;
    ForceElement *element = &run->jacobian.link[number];
    const double z = s->Z[number], zd = s->Zd[number];

    element->n_coordinates = 1;
    element->n_states = 0;
    element->output[0] = -run_LinkForces(z, zd, s, s->tsim, number);
    for (int input = 0; input < 2; input++) {
        const double force = -run_LinkForces(z + (input == 0 ? DIFFERENCE : 0.0),
                                             zd + (input == 1 ? DIFFERENCE : 0.0), s, s->tsim, number);

        differentiate(s, element, &force, input, DIFFERENCE);
    }
}
