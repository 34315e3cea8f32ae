/* A free base past 90 degrees: its state continues in axes of the base that are turned by 90 degrees about z.

         y                    x_t             r_t = C r     C = [ 0  1  0]
         |                     |                                [-1  0  0]
         |____ x        y_t ___|                                [ 0  0  1]

       model's axes     turned axes           x_t = y     y_t = -x

   The angles R1, R2, R3 (a, b, c) of the base have no rates where cos b = 0 (gimbal lock).  Near there the state is
   that in the turned axes, where the second angle is small; gravity, along z, and the ground are the same.  User
   functions and results are in the model's axes: their arguments are turned back, and the forces that they return
   are turned.

   The angular velocity by the rates of the angles, and the angular acceleration:

       w = E (da, db, dc)/dt    E = [1    0      sin b    ]     dw/dt = E d^2(a, b, c)/dt^2 + dE/dt d(a, b, c)/dt
                                    [0  cos a  -sin a cos b]
                                    [0  sin a   cos a cos b]

   A generalized force Q of the angles is the torque n by Q = E^T n. */
#include <math.h>
#include <string.h>

#include "runtime.h"

static const double PI = 3.14159265358979323846;
static const double MIN_COSINE = 1e-9;  /* a smaller one is replaced by it in a division */
static const double TURN_COSINE = 0.3;  /* the axes are changed where that of the second angle is smaller */

enum { BACKWARD = -1, FORWARD = 1 }; /* from the turned axes to the model's, or from the model's to the turned ones */

/* r = C r, or r = C^T r */
static void turn_vector(double *r, int direction)
{
    const double x = r[1];

    r[1] = direction * r[2];
    r[2] = -direction * x;
}

/* Turn a force from the model's axes to those of the state. */
void turn_force(const Run *run, double *force)
{
    if (run->is_turned)
        turn_vector(force, FORWARD);
}

static double nonzero(double cosine)
{
    return fabs(cosine) < MIN_COSINE ? copysign(MIN_COSINE, cosine) : cosine;
}

/* w = E rates */
static void compute_angular_velocity(const double *angles, const double *rates, double *w)
{
    const double c_term = rates[3] * cos(angles[2]);

    w[1] = rates[1] + sin(angles[2]) * rates[3];
    w[2] = cos(angles[1]) * rates[2] - sin(angles[1]) * c_term;
    w[3] = sin(angles[1]) * rates[2] + cos(angles[1]) * c_term;
}

/* Solve E rates = w. */
static void compute_rates(const double *angles, const double *w, double *rates)
{
    const double a = angles[1], b = angles[2];

    rates[3] = (cos(a) * w[3] - sin(a) * w[2]) / nonzero(cos(b));
    rates[2] = cos(a) * w[2] + sin(a) * w[3];
    rates[1] = w[1] - sin(b) * rates[3];
}

/* dw += sign * dE/dt rates */
static void add_velocity_product(const double *angles, const double *rates, double sign, double *dw)
{
    const double a = angles[1], b = angles[2];
    const double c_term = rates[3] * cos(b), drift = rates[3] * sin(b) * rates[2];

    dw[1] += sign * c_term * rates[2];
    dw[2] += sign * (sin(a) * drift - rates[1] * (sin(a) * rates[2] + cos(a) * c_term));
    dw[3] += sign * (rates[1] * (cos(a) * rates[2] - sin(a) * c_term) - cos(a) * drift);
}

/* Find the angles, in the other axes, of the rotation that has these angles.

   Two triples (a, b, c), (a + pi, pi - b, c + pi), and full turns of each angle are the same rotation: those that
   are nearest to a reference are taken. */
static void find_angles(const double *angles, int direction, const double *reference, double *nearest)
{
    const double ca = cos(angles[1]), sa = sin(angles[1]), cb = cos(angles[2]), sb = sin(angles[2]);
    const double cc = cos(angles[3]), sc = sin(angles[3]);
    const double middle = asin(fmax(-1.0, fmin(1.0, -direction * sa * cb)));
    double smallest_distance = INFINITY, best[3] = {0};

    for (int is_second = 0; is_second < 2; is_second++) {
        double distance = 0.0, triple[3] = {
            atan2(direction * sb, ca * cb) + is_second * PI,
            is_second ? PI - middle : middle,
            atan2(direction * (sa * sb * sc - ca * cc), direction * (ca * sc + sa * sb * cc)) + is_second * PI,
        };

        for (int i = 0; i < 3; i++) {
            triple[i] += 2.0 * PI * round((reference[i] - triple[i]) / (2.0 * PI));
            distance += fabs(triple[i] - reference[i]);
        }
        if (distance < smallest_distance) {
            smallest_distance = distance;
            memcpy(best, triple, sizeof best);
        }
    }
    memcpy(nearest, best, sizeof best);
}

/* Change the axes if the second angle of the base is near 90 degrees: y becomes the state in the other axes.
   Return 1 if the axes have changed, else 0. */
int turn_if_near(Run *run, double *y)
{
    static const double zero[3];
    const int direction = run->is_turned ? BACKWARD : FORWARD;
    double *q = y - 1, *u = y + run->data.nqu - 1, w[4]; /* from index 1 */

    if (!run->can_turn || fabs(cos(q[5])) >= TURN_COSINE)
        return 0;
    compute_angular_velocity(q + 3, u + 3, w);
    if (run->is_turned)
        find_angles(q + 3, BACKWARD, run->shown_angles, run->shown_angles);
    else
        memcpy(run->shown_angles, q + 4, sizeof run->shown_angles);
    find_angles(q + 3, direction, run->is_turned ? run->shown_angles : zero, q + 4);
    turn_vector(q, direction);
    turn_vector(u, direction);
    turn_vector(w, direction);
    compute_rates(q + 3, w, u + 3);
    run->is_turned = !run->is_turned;
    return 1;
}

/* Turn q, qd and qdd of the base, in the data, to the model's axes. */
static void turn_base_back(Run *run)
{
    MbsData *data = &run->data;
    double *rows[] = {data->q, data->qd, data->qdd}, *angles = data->q + 3, w[4], dw[4];

    compute_angular_velocity(angles, data->qd + 3, w);
    compute_angular_velocity(angles, data->qdd + 3, dw);
    add_velocity_product(angles, data->qd + 3, 1.0, dw);
    find_angles(angles, BACKWARD, run->shown_angles, run->shown_angles);
    memcpy(angles + 1, run->shown_angles, sizeof run->shown_angles);
    for (int i = 0; i < 3; i++)
        turn_vector(rows[i], BACKWARD);
    turn_vector(w, BACKWARD);
    turn_vector(dw, BACKWARD);
    compute_rates(angles, w, data->qd + 3);
    add_velocity_product(angles, data->qd + 3, -1.0, dw);
    compute_rates(angles, dw, data->qdd + 3);
}

/* Show q, qd and qdd of the base in the model's axes, until they are hidden.  Most user functions are called in the
   state of the one before, for which they are stored. */
void show_model_axes(Run *run)
{
    MbsData *data = &run->data;
    Turn *turn = &run->turn;
    double *rows[] = {data->q, data->qd, data->qdd};
    int is_new = 0;

    if (!run->is_turned)
        return;
    for (int i = 0; i < 3; i++) {
        is_new |= memcmp(turn->state_axes[i], rows[i], sizeof turn->state_axes[i]);
        memcpy(turn->state_axes[i], rows[i], sizeof turn->state_axes[i]);
    }
    if (is_new) {
        turn_base_back(run);
        for (int i = 0; i < 3; i++)
            memcpy(turn->model_axes[i], rows[i], sizeof turn->model_axes[i]);
    }
    for (int i = 0; i < 3; i++)
        memcpy(rows[i], turn->model_axes[i], sizeof turn->model_axes[i]);
}

/* Restore q, qd and qdd of the base in the axes of the state. */
void hide_model_axes(Run *run)
{
    MbsData *data = &run->data;
    double *rows[] = {data->q, data->qd, data->qdd};

    for (int i = 0; i < 3 && run->is_turned; i++)
        memcpy(rows[i], run->turn.state_axes[i], sizeof run->turn.state_axes[i]);
}

/* Turn the generalized forces Q of the base, from its angles in some axes to those in the others:

       n = E^-T Q    n = C n    Q = E^T n */
static void turn_joint_forces(double *Q, const double *from, const double *to, int direction)
{
    double n[4], a = from[1], b = from[2];
    const double quotient = (Q[6] - Q[4] * sin(b)) / nonzero(cos(b));

    n[1] = Q[4];
    n[2] = Q[5] * cos(a) - quotient * sin(a);
    n[3] = Q[5] * sin(a) + quotient * cos(a);
    turn_vector(Q, direction);
    turn_vector(n, direction);
    a = to[1];
    b = to[2];
    Q[4] = n[1];
    Q[5] = cos(a) * n[2] + sin(a) * n[3];
    Q[6] = sin(b) * n[1] + cos(b) * (cos(a) * n[3] - sin(a) * n[2]);
}

/* Turn the forces Qq of the base's joints to the model's axes, while these are shown. */
void show_joint_forces(Run *run)
{
    if (run->is_turned)
        turn_joint_forces(run->data.Qq, run->turn.state_axes[0] + 3, run->turn.model_axes[0] + 3, BACKWARD);
}

/* Call user_ExtForces in the model's axes; return the force in the axes of the state. */
double *run_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                      double OMP[4], MbsData *data, double tsim, int number)
{
    Run *run = run_of(data);
    double *vectors[] = {P, V, OM, A, OMP, R[1], R[2], R[3]}, *in_model_axes, *force;

    enter_user_code(run);
    if (!run->is_turned)
        return user_ExtForces(P, R, V, OM, A, OMP, data, tsim, number);
    for (int i = 0; i < 8; i++)
        turn_vector(vectors[i], BACKWARD);
    show_model_axes(run);
    in_model_axes = user_ExtForces(P, R, V, OM, A, OMP, data, tsim, number);
    hide_model_axes(run);
    for (int i = 0; i < 8; i++)
        turn_vector(vectors[i], FORWARD);
    force = run->turn.force[number]; /* it must last: equations read it after they have computed others */
    memcpy(force, in_model_axes, sizeof run->turn.force[number]);
    turn_vector(force, FORWARD);
    turn_vector(force + 3, FORWARD);
    return force;
}

/* Arguments and results of the next functions do not depend on the axes, but they may read q of the base. */
void run_DrivenJoints(MbsData *data, double tsim)
{
    Run *run = run_of(data);

    enter_user_code(run);
    show_model_axes(run);
    user_DrivenJoints(data, tsim);
    hide_model_axes(run);
}

void run_Derivative(Run *run)
{
    enter_user_code(run);
    show_model_axes(run);
    user_Derivative(&run->data);
    hide_model_axes(run);
}

double run_LinkForces(double Z, double Zd, MbsData *data, double tsim, int number)
{
    Run *run = run_of(data);
    double force;

    enter_user_code(run);
    show_model_axes(run);
    force = user_LinkForces(Z, Zd, data, tsim, number);
    hide_model_axes(run);
    return force;
}

double *run_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                         double OMP[4], MbsData *data, double tsim, int number)
{
    Run *run = run_of(data);
    double *force;

    enter_user_code(run);
    show_model_axes(run);
    force = user_Link3DForces(P, R, V, OM, A, OMP, data, tsim, number);
    hide_model_axes(run);
    return force;
}

/* Where the user has constraints, the axes are never changed: they may tie the base to the ground. */
void run_cons_hJ(double *h, double **J, MbsData *data, double tsim)
{
    enter_user_code(run_of(data));
    user_cons_hJ(h, J, data, tsim);
}

void run_cons_jdqd(double *jdqd, MbsData *data, double tsim)
{
    enter_user_code(run_of(data));
    user_cons_jdqd(jdqd, data, tsim);
}

/* Call user_JointForces in the model's axes; Qq of the base are then those of the axes of the state. */
double *run_JointForces(MbsData *data, double tsim)
{
    Run *run = run_of(data);
    double *Q = data->Qq;

    enter_user_code(run);
    show_model_axes(run);
    user_JointForces(data, tsim);
    hide_model_axes(run);
    if (run->is_turned && (Q[1] != 0.0 || Q[2] != 0.0 || Q[4] != 0.0 || Q[5] != 0.0 || Q[6] != 0.0))
        turn_joint_forces(Q, run->turn.model_axes[0] + 3, run->turn.state_axes[0] + 3, FORWARD);
    return Q;
}
