/* The joint system of slopes.c: user_JointForces and user_Derivative, by differences.

   The pattern of their derivative is found input by input.  Inputs that change no output in common get one color,
   and are changed together (Curtis, Powell and Reid, J. Inst. Math. Appl. 13, 1974):

               q1 q2 q3
         Qq1 [  #  .  . ]      q1 and q3 change no output in common, so they have color 0; q2 has color 1:
         Qq2 [  #  #  . ]      two calls of the user functions give three columns
         Qq3 [  .  #  # ] */
#include <math.h>
#include <string.h>

#include "runtime.h"

static const double DIFFERENCE = 1e-7; /* of a joint or its rate: m, rad, m/s, rad/s */
/* The number of Jacobians after which the pattern is completed: a force may have begun. */
static const int PATTERN_AGE = 25;

static double *get_joint_input(Run *run, int input)
{
    MbsData *data = &run->data;

    if (input < N_JOINTS)
        return &data->q[input + 1];
    if (input < 2 * N_JOINTS)
        return &data->qd[input - N_JOINTS + 1];
    return &data->ux[input - 2 * N_JOINTS + 1];
}

static double get_joint_difference(const Run *run, int input, double atol)
{
    return input < 2 * N_JOINTS ? DIFFERENCE : get_state_difference(run, input - 2 * N_JOINTS + 1, atol);
}

/* Compute the outputs: Qq, then uxd.  The rates of states that external forces set are 0. */
static void compute_joint_system(Run *run, double *output)
{
    MbsData *data = &run->data;

    run_JointForces(data, data->tsim);
    if (N_STATES)
        run_Derivative(run);
    memcpy(output, data->Qq + 1, N_JOINTS * sizeof *output);
    for (int k = 1; k <= N_STATES; k++)
        output[N_JOINTS + k - 1] = run->jacobian.body_of_state[k] ? 0.0 : data->uxd[k];
}

/* Return 1 if the force of a joint depends on the position or the speed of an input joint, else 0. */
static int is_coupled(const JointSystem *system, int joint, int input_joint)
{
    return system->depends[input_joint][joint] || system->depends[N_JOINTS + input_joint][joint];
}

/* Give each input the first color whose inputs change none of its outputs. */
static void color_joint_system(JointSystem *system)
{
    memset(system->is_changed, 0, sizeof system->is_changed);
    system->n_colors = 0;
    for (int i = 0; i < N_JOINT_INPUTS; i++) {
        int color = 0, n = 0, conflicts = 1;

        for (int o = 0; o < N_JOINT_OUTPUTS; o++)
            if (system->depends[i][o])
                system->output[i][n++] = o;
        system->n_outputs[i] = n;
        while (conflicts) {
            conflicts = 0;
            for (int m = 0; m < n; m++)
                conflicts |= system->is_changed[color][system->output[i][m]];
            color += conflicts;
        }
        for (int m = 0; m < n; m++)
            system->is_changed[color][system->output[i][m]] = 1;
        system->color[i] = color;
        if (color >= system->n_colors)
            system->n_colors = color + 1;
    }
    for (int j = 0; j < N_JOINTS; j++) {
        system->is_uncoupled[j] = 1;
        for (int k = 0; k < N_JOINTS; k++)
            if (k != j && (is_coupled(system, j, k) || is_coupled(system, k, j)))
                system->is_uncoupled[j] = 0;
    }
}

/* Complete the pattern of the joint system: change its inputs one by one, and compare the outputs.  A joint always
   depends on itself, and a state, too. */
void find_joint_pattern(Run *run, double atol)
{
    JointSystem *system = &run->jacobian.joints;
    double output[N_JOINT_OUTPUTS + 1], changed[N_JOINT_OUTPUTS + 1];

    system->age = 0;
    compute_joint_system(run, output);
    for (int i = 0; i < N_JOINT_INPUTS; i++) {
        const int state = i - 2 * N_JOINTS + 1;
        double *input = get_joint_input(run, i);
        const double before = *input;

        if (state > 0 && run->jacobian.body_of_state[state])
            continue;
        *input += get_joint_difference(run, i, atol);
        compute_joint_system(run, changed);
        *input = before;
        for (int o = 0; o < N_JOINT_OUTPUTS; o++)
            system->depends[i][o] |= changed[o] != output[o] && !isnan(changed[o]);
        system->depends[i][i < 2 * N_JOINTS ? i % N_JOINTS : N_JOINTS + state - 1] = 1;
    }
    color_joint_system(system);
}

/* Differentiate the joint system, color by color.  The force of an uncoupled joint that grows with its position or
   speed is explicit: its derivative is set to 0. */
void differentiate_joint_system(Run *run, double atol)
{
    JointSystem *system = &run->jacobian.joints;
    double output[N_JOINT_OUTPUTS + 1], changed[N_JOINT_OUTPUTS + 1], before[N_JOINT_INPUTS + 1];

    if (system->age++ >= PATTERN_AGE)
        find_joint_pattern(run, atol);
    compute_joint_system(run, output);
    for (int color = 0; color < system->n_colors; color++) {
        for (int i = 0; i < N_JOINT_INPUTS; i++)
            if (system->color[i] == color && system->n_outputs[i]) {
                before[i] = *get_joint_input(run, i);
                *get_joint_input(run, i) += get_joint_difference(run, i, atol);
            }
        compute_joint_system(run, changed);
        for (int i = 0; i < N_JOINT_INPUTS; i++)
            if (system->color[i] == color && system->n_outputs[i]) {
                *get_joint_input(run, i) = before[i];
                for (int m = 0; m < system->n_outputs[i]; m++) {
                    const int o = system->output[i][m];
                    const double change = changed[o] - output[o];

                    system->derivative[i][o] = isfinite(change) ? change / get_joint_difference(run, i, atol) : 0.0;
                }
            }
    }
    for (int i = 0; i < 2 * N_JOINTS; i++)
        if (system->is_uncoupled[i % N_JOINTS])
            system->derivative[i][i % N_JOINTS] = fmin(system->derivative[i][i % N_JOINTS], 0.0);
}
