/* The joint system of slopes.c: user_JointForces and user_Derivative, by differences.

   What depends on what is found input by input; inputs that change no output in common get one color, and are
   moved together (Curtis, Powell and Reid, J. Inst. Math. Appl. 13, 1974). */
#include <math.h>
#include <string.h>

#include "runtime.h"

static const double DIFFERENCE = 1e-7; /* of a joint or its rate: m, rad, m/s, rad/s */
/* The pattern of the joint system is completed after so many Jacobians: a force may have begun. */
static const int PATTERN_AGE = 25;

static double *get_joint_input(Run *run, int input)
{
    MbsData *s = &run->data;

    if (input < N_JOINTS)
        return &s->q[input + 1];
    if (input < 2 * N_JOINTS)
        return &s->qd[input - N_JOINTS + 1];
    return &s->ux[input - 2 * N_JOINTS + 1];
}

static double get_joint_difference(const Run *run, int input, double atol)
{
    return input < 2 * N_JOINTS ? DIFFERENCE : get_state_difference(run, input - 2 * N_JOINTS + 1, atol);
}

/* Compute the outputs: Qq, then uxd.  The rates of states that external forces set count for nothing. */
static void compute_joint_system(Run *run, double *output)
{
    MbsData *s = &run->data;

    run_JointForces(s, s->tsim);
    if (N_STATES)
        run_Derivative(run);
    memcpy(output, s->Qq + 1, N_JOINTS * sizeof *output);
    for (int k = 1; k <= N_STATES; k++)
        output[N_JOINTS + k - 1] = run->jacobian.body_of_state[k] ? 0.0 : s->uxd[k];
}

/* Return 1 if the force of a joint depends on the position or the speed of another one, else 0. */
static int is_coupled(const JointSystem *system, int joint, int other)
{
    return system->depends[other][joint] || system->depends[N_JOINTS + other][joint];
}

/* Give each input the first color of which no other input changes an output of its own. */
static void color_joint_system(JointSystem *system)
{
    memset(system->is_used, 0, sizeof system->is_used);
    system->n_colors = 0;
    for (int i = 0; i < N_JOINT_INPUTS; i++) {
        int color = 0, n = 0, clashes = 1;

        for (int o = 0; o < N_JOINT_OUTPUTS; o++)
            if (system->depends[i][o])
                system->output[i][n++] = o;
        system->n_outputs[i] = n;
        while (clashes) {
            clashes = 0;
            for (int m = 0; m < n; m++)
                clashes |= system->is_used[color][system->output[i][m]];
            color += clashes;
        }
        for (int m = 0; m < n; m++)
            system->is_used[color][system->output[i][m]] = 1;
        system->color[i] = color;
        if (color >= system->n_colors)
            system->n_colors = color + 1;
    }
    for (int j = 0; j < N_JOINTS; j++) {
        system->is_alone[j] = 1;
        for (int k = 0; k < N_JOINTS; k++)
            if (k != j && (is_coupled(system, j, k) || is_coupled(system, k, j)))
                system->is_alone[j] = 0;
    }
}

/* Complete the pattern of the joint system: move its inputs one by one, and see which outputs change. */
void find_joint_pattern(Run *run, double atol)
{
    JointSystem *system = &run->jacobian.joints;
    double output[N_JOINT_OUTPUTS + 1], moved[N_JOINT_OUTPUTS + 1];

    system->age = 0;
    compute_joint_system(run, output);
    for (int i = 0; i < N_JOINT_INPUTS; i++) {
        const int state = i - 2 * N_JOINTS + 1;
        double *input = get_joint_input(run, i);
        const double before = *input;

        if (state > 0 && run->jacobian.body_of_state[state])
            continue;
        *input += get_joint_difference(run, i, atol);
        compute_joint_system(run, moved);
        *input = before;
        for (int o = 0; o < N_JOINT_OUTPUTS; o++)
            system->depends[i][o] |= moved[o] != output[o] && !isnan(moved[o]);
        system->depends[i][i < 2 * N_JOINTS ? i % N_JOINTS : N_JOINTS + state - 1] = 1;
    }
    color_joint_system(system);
}

/* Differentiate the joint system, color by color.  A force that drives its joint away stays explicit. */
void differentiate_joint_system(Run *run, double atol)
{
    JointSystem *system = &run->jacobian.joints;
    double output[N_JOINT_OUTPUTS + 1], moved[N_JOINT_OUTPUTS + 1], before[N_JOINT_INPUTS + 1];

    if (system->age++ >= PATTERN_AGE)
        find_joint_pattern(run, atol);
    compute_joint_system(run, output);
    for (int color = 0; color < system->n_colors; color++) {
        for (int i = 0; i < N_JOINT_INPUTS; i++)
            if (system->color[i] == color && system->n_outputs[i]) {
                before[i] = *get_joint_input(run, i);
                *get_joint_input(run, i) += get_joint_difference(run, i, atol);
            }
        compute_joint_system(run, moved);
        for (int i = 0; i < N_JOINT_INPUTS; i++)
            if (system->color[i] == color && system->n_outputs[i]) {
                *get_joint_input(run, i) = before[i];
                for (int m = 0; m < system->n_outputs[i]; m++) {
                    const int o = system->output[i][m];
                    const double change = moved[o] - output[o];

                    system->derivative[i][o] = isfinite(change) ? change / get_joint_difference(run, i, atol) : 0.0;
                }
            }
    }
    for (int i = 0; i < 2 * N_JOINTS; i++)
        if (system->is_alone[i % N_JOINTS])
            system->derivative[i][i % N_JOINTS] = fmin(system->derivative[i][i % N_JOINTS], 0.0);
}
