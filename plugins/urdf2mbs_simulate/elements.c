/* Derivatives of the force elements of slopes.c, by differences of the user functions. */
#include <math.h>
#include <string.h>

#include "runtime.h"

static const double DIFFERENCE = 1e-7;       /* of a coordinate or its rate: m, rad, m/s, rad/s */
static const double STATE_DIFFERENCE = 1e-7; /* of a user state, relative to its size */
static const double MIN_STATE_PART = 1e-2;   /* the least one, relative to the absolute tolerance */

/* Return the difference of a user state, relative to its present or its largest value. */
double get_state_difference(const Run *run, int state, double atol)
{
    const double size = fmax(fabs(run->data.ux[state]), run->steps.largest_state[state]);

    return fmax(STATE_DIFFERENCE * size, MIN_STATE_PART * atol);
}

/* Find the states whose rates an external force sets: all rates are NaN before it is called.  States beyond
   MAX_ELEMENT_STATES are explicit. */
void find_body_states(Run *run, int number)
{
    MbsData *data = &run->data;
    const double no_motion[2 * MAX_COORDINATES] = {0};
    ForceElement *element = &run->jacobian.body[number];
    double force[MAX_COORDINATES];

    element->n_coordinates = MAX_COORDINATES;
    element->n_states = 0;
    for (int k = 1; k <= N_STATES; k++)
        data->uxd[k] = NAN;
    compute_anchor_frame(run, number);
    compute_external_force(run, number, no_motion, force);
    for (int k = 1; k <= N_STATES; k++) {
        if (isnan(data->uxd[k]) || run->jacobian.body_of_state[k])
            continue;
        run->jacobian.body_of_state[k] = number;
        if (element->n_states < MAX_ELEMENT_STATES)
            element->state[element->n_states++] = k;
    }
}

/* Copy the outputs of an element: the forces, and the rates of its states, which are in data->uxd. */
static void copy_outputs(const MbsData *data, const ForceElement *element, const double *force, double *output)
{
    for (int i = 0; i < element->n_coordinates; i++)
        output[i] = force[i];
    for (int i = 0; i < element->n_states; i++)
        output[element->n_coordinates + i] = data->uxd[element->state[i]];
}

/* dy/d(input) = (y(input + difference) - y(input)) / difference, where the first was computed last. */
static void differentiate(const MbsData *data, ForceElement *element, const double *force, int input,
                          double difference)
{
    double output[MAX_OUTPUTS] = {0};

    copy_outputs(data, element, force, output);
    for (int i = 0; i < element->n_coordinates + element->n_states; i++)
        element->derivative[input][i] = (output[i] - element->output[i]) / difference;
}

/* Differentiate an external force by the motion of its body, in the frame that was computed last. */
void differentiate_external_force(Run *run, int number, double atol)
{
    MbsData *data = &run->data;
    ForceElement *element = &run->jacobian.body[number];
    const int n_motion = 2 * element->n_coordinates;
    double force[MAX_COORDINATES], motion[2 * MAX_COORDINATES] = {0};

    compute_external_force(run, number, motion, force);
    copy_outputs(data, element, force, element->output);
    for (int input = 0; input < n_motion + element->n_states; input++) {
        const int is_motion = input < n_motion, state = is_motion ? 0 : element->state[input - n_motion];
        const double difference = is_motion ? DIFFERENCE : get_state_difference(run, state, atol);
        double *value = is_motion ? &motion[input] : &data->ux[state];
        const double before = *value;

        *value += difference;
        compute_external_force(run, number, motion, force);
        *value = before;
        differentiate(data, element, force, input, difference);
    }
}

/* Differentiate the force of a link, which pulls its ends together, by its length z and dz/dt. */
void differentiate_link(Run *run, int number)
{
    MbsData *data = &run->data;
    ForceElement *element = &run->jacobian.link[number];
    const double z = data->Z[number], zd = data->Zd[number];

    element->n_coordinates = 1;
    element->n_states = 0;
    element->output[0] = -run_LinkForces(z, zd, data, data->tsim, number);
    for (int input = 0; input < 2; input++) {
        const double force = -run_LinkForces(z + (input == 0 ? DIFFERENCE : 0.0),
                                             zd + (input == 1 ? DIFFERENCE : 0.0), data, data->tsim, number);

        differentiate(data, element, &force, input, DIFFERENCE);
    }
}
