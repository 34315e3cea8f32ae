/* A free base beyond 90 degrees: the state goes on in world axes that are turned by a quarter about z.

       x' = y    y' = -x        r' = C r,   C = [0 1; -1 0]

   The angles R1, R2, R3 (a, b, c) of the base have no rates where cos b = 0.  Near there the state is that in
   turned axes, in which the second angle is small; gravity and the ground are the same.  User functions and
   results are in the model's axes: what they are given is turned back, and what they return is turned.

   The spin by the rates of the angles, and how it changes while the rates do not:

       w = E (a', b', c')    E = [1    0      sin b    ]     E' (a', b', c')  =  see add_spin_drift
                                 [0  cos a  -sin a cos b]
                                 [0  sin a   cos a cos b]

   A generalized force Q of the angles is the torque n by Q = E' n (here ' transposes). */
#include <math.h>
#include <string.h>

#include "runtime.h"

static const double PI = 3.14159265358979323846;
static const double MIN_COSINE = 1e-9;  /* rates are divided by no smaller one */
static const double TURN_COSINE = 0.3;  /* of the second angle, from which the axes are turned */

enum { BACKWARD = -1, FORWARD = 1 }; /* from the model's axes to the turned ones, or back */

/* r = C r, or r = C' r */
static void turn_vector(double *r, int direction)
{
    const double x = r[1];

    r[1] = direction * r[2];
    r[2] = -direction * x;
}

/* Turn a force in the world's axes into the axes of the state. */
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
static void compute_spin(const double *angles, const double *rates, double *w)
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

/* dw += sign * (dE/dt) rates */
static void add_spin_drift(const double *angles, const double *rates, double sign, double *dw)
{
    const double a = angles[1], b = angles[2];
    const double c_term = rates[3] * cos(b), drift = rates[3] * sin(b) * rates[2];

    dw[1] += sign * c_term * rates[2];
    dw[2] += sign * (sin(a) * drift - rates[1] * (sin(a) * rates[2] + cos(a) * c_term));
    dw[3] += sign * (rates[1] * (cos(a) * rates[2] - sin(a) * c_term) - cos(a) * drift);
}

/* Find the angles of the rotation of some angles that is turned forward or backward.

   Two triples, and all full turns, are the same rotation: take those that are nearest to some. */
static void find_angles(const double *angles, int direction, const double *near, double *nearest)
{
    const double ca = cos(angles[1]), sa = sin(angles[1]), cb = cos(angles[2]), sb = sin(angles[2]);
    const double cc = cos(angles[3]), sc = sin(angles[3]);
    const double middle = asin(fmax(-1.0, fmin(1.0, -direction * sa * cb)));
    double least = INFINITY, best[3] = {0};

    for (int side = 0; side < 2; side++) {
        double distance = 0.0, triple[3] = {
            atan2(direction * sb, ca * cb) + side * PI,
            side ? PI - middle : middle,
            atan2(direction * (sa * sb * sc - ca * cc), direction * (ca * sc + sa * sb * cc)) + side * PI,
        };

        for (int i = 0; i < 3; i++) {
            triple[i] += 2.0 * PI * round((near[i] - triple[i]) / (2.0 * PI));
            distance += fabs(triple[i] - near[i]);
        }
        if (distance < least) {
            least = distance;
            memcpy(best, triple, sizeof best);
        }
    }
    memcpy(nearest, best, sizeof best);
}

/* Go on in other axes, if the second angle of the base is near 90 degrees: y becomes the state there.
   Return 1 if the axes have been turned, else 0. */
int turn_if_near(Run *run, double *y)
{
    static const double zero[3];
    const int direction = run->is_turned ? BACKWARD : FORWARD;
    double *q = y - 1, *u = y + run->data.nqu - 1, w[4]; /* from index 1 */

    if (!run->can_turn || fabs(cos(q[5])) >= TURN_COSINE)
        return 0;
    compute_spin(q + 3, u + 3, w);
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

/* Turn q, qd and qdd of the base, in the rows of the data, into the model's axes. */
static void turn_base_back(Run *run)
{
    MbsData *s = &run->data;
    double *rows[] = {s->q, s->qd, s->qdd}, *angles = s->q + 3, w[4], dw[4];

    compute_spin(angles, s->qd + 3, w);
    compute_spin(angles, s->qdd + 3, dw);
    add_spin_drift(angles, s->qd + 3, 1.0, dw);
    find_angles(angles, BACKWARD, run->shown_angles, run->shown_angles);
    memcpy(angles + 1, run->shown_angles, sizeof run->shown_angles);
    for (int i = 0; i < 3; i++)
        turn_vector(rows[i], BACKWARD);
    turn_vector(w, BACKWARD);
    turn_vector(dw, BACKWARD);
    compute_rates(angles, w, s->qd + 3);
    add_spin_drift(angles, s->qd + 3, -1.0, dw);
    compute_rates(angles, dw, s->qdd + 3);
}

/* Show q, qd and qdd of the base in the model's axes, until they are hidden.  Most user functions are called in
   the state of the one before: its axes are kept. */
void show_model_axes(Run *run)
{
    MbsData *s = &run->data;
    Turn *turn = &run->turn;
    double *rows[] = {s->q, s->qd, s->qdd};
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

void hide_model_axes(Run *run)
{
    MbsData *s = &run->data;
    double *rows[] = {s->q, s->qd, s->qdd};

    for (int i = 0; i < 3 && run->is_turned; i++)
        memcpy(rows[i], run->turn.state_axes[i], sizeof run->turn.state_axes[i]);
}

/* Turn the generalized forces Q of the base from some angles to others: n = E'^-1 Q, n = C n, Q = E' n. */
static void turn_joint_forces(double *Q, const double *from, const double *to, int direction)
{
    double n[4], a = from[1], b = from[2];
    const double rest = (Q[6] - Q[4] * sin(b)) / nonzero(cos(b));

    n[1] = Q[4];
    n[2] = Q[5] * cos(a) - rest * sin(a);
    n[3] = Q[5] * sin(a) + rest * cos(a);
    turn_vector(Q, direction);
    turn_vector(n, direction);
    a = to[1];
    b = to[2];
    Q[4] = n[1];
    Q[5] = cos(a) * n[2] + sin(a) * n[3];
    Q[6] = sin(b) * n[1] + cos(b) * (cos(a) * n[3] - sin(a) * n[2]);
}

/* Turn the forces Qq of the base's joints into the model's axes, while these are shown. */
void show_joint_forces(Run *run)
{
    if (run->is_turned)
        turn_joint_forces(run->data.Qq, run->turn.state_axes[0] + 3, run->turn.model_axes[0] + 3, BACKWARD);
}

double *run_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                      double OMP[4], MbsData *s, double tsim, int number)
{
    Run *run = run_of(s);
    double *vectors[] = {P, V, OM, A, OMP, R[1], R[2], R[3]}, *in_model_axes, *force;

    enter_user_code(run);
    if (!run->is_turned)
        return user_ExtForces(P, R, V, OM, A, OMP, s, tsim, number);
    for (int i = 0; i < 8; i++)
        turn_vector(vectors[i], BACKWARD);
    show_model_axes(run);
    in_model_axes = user_ExtForces(P, R, V, OM, A, OMP, s, tsim, number);
    hide_model_axes(run);
    for (int i = 0; i < 8; i++)
        turn_vector(vectors[i], FORWARD);
    force = run->turn.force[number]; /* equations read a force when others are computed */
    memcpy(force, in_model_axes, sizeof run->turn.force[number]);
    turn_vector(force, FORWARD);
    turn_vector(force + 3, FORWARD);
    return force;
}

/* The next functions are given and return what is the same in all axes, but they may read the base. */
void run_DrivenJoints(MbsData *s, double tsim)
{
    Run *run = run_of(s);

    enter_user_code(run);
    show_model_axes(run);
    user_DrivenJoints(s, tsim);
    hide_model_axes(run);
}

void run_Derivative(Run *run)
{
    enter_user_code(run);
    show_model_axes(run);
    user_Derivative(&run->data);
    hide_model_axes(run);
}

double run_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number)
{
    Run *run = run_of(s);
    double force;

    enter_user_code(run);
    show_model_axes(run);
    force = user_LinkForces(Z, Zd, s, tsim, number);
    hide_model_axes(run);
    return force;
}

double *run_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                         double OMP[4], MbsData *s, double tsim, int number)
{
    Run *run = run_of(s);
    double *force;

    enter_user_code(run);
    show_model_axes(run);
    force = user_Link3DForces(P, R, V, OM, A, OMP, s, tsim, number);
    hide_model_axes(run);
    return force;
}

/* A base that constraints of the user may tie to the ground is not turned. */
void run_cons_hJ(double *h, double **J, MbsData *s, double tsim)
{
    enter_user_code(run_of(s));
    user_cons_hJ(h, J, s, tsim);
}

void run_cons_jdqd(double *jdqd, MbsData *s, double tsim)
{
    enter_user_code(run_of(s));
    user_cons_jdqd(jdqd, s, tsim);
}

/* Call user_JointForces; forces on the joints of the base become those of its turned joints. */
double *run_JointForces(MbsData *s, double tsim)
{
    Run *run = run_of(s);
    double *Q = s->Qq;

    enter_user_code(run);
    show_model_axes(run);
    user_JointForces(s, tsim);
    hide_model_axes(run);
    if (run->is_turned && (Q[1] != 0.0 || Q[2] != 0.0 || Q[4] != 0.0 || Q[5] != 0.0 || Q[6] != 0.0))
        turn_joint_forces(Q, run->turn.model_axes[0] + 3, run->turn.state_axes[0] + 3, FORWARD);
    return Q;
}
