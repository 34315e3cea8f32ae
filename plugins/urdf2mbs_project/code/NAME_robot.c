/* What is known of the robot 'NAME': see NAME_robot.h. Written anew at each conversion.
 *
 * This code is the same for all robots: what this robot has stands in the tables of
 * NAME_tables.h. Each table ends with a row of zeros. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "NAME_robot.h"

/* The place of a number in the struct of the user models; NONE: this robot has no such number. */
#define AT(number) offsetof(UserModel, number)
enum { NONE = -1 };

typedef struct { int follower, leader; double multiplier, offset; } Coupling;
typedef struct {
    size_t damping, springs, friction, friction_time, stops, stop_speed;
} Switches;
typedef struct { int joint; size_t coefficient; } Damping;
typedef struct { int joint; size_t stiffness, rest; } JointSpring;
typedef struct { int joint; size_t coefficient, stiffness; int state; } Friction;
typedef struct { int joint; double side; size_t limit, stiffness; } Stop; /* side: 1 up, -1 down */
typedef struct { int joint; size_t stiffness, damping; } Hold;
typedef struct { int joint; size_t most; } Effort;
typedef struct {
    size_t ground, stiffness, speed, friction, bristle, bristle_time;
} Ground;
/* state: the place of its bristle in ux. A ball or a wheel has a radius, and a wheel an axis in
 * the body: its lowest point touches. */
typedef struct { int force, state; double radius, axis[3]; } Contact;
typedef struct { int force; size_t start, stop, parts[6]; } Wrench;
typedef struct { int link; size_t stiffness, length, damping; } Spring;
typedef struct { int isens; double axes[9]; } Sensor; /* its axes in the body, row by row */
/* Laws of plugins. */
typedef struct { int joint; double (*law)(const MbsData *mbs_data, int joint); } JointLaw;
typedef struct {
    int force;
    void (*law)(const double P[4], const double V[4], const MbsData *mbs_data, double tsim, int ixF,
        double force[7]);
} PointLaw;

#include "NAME_tables.h"

static double number(const MbsData *mbs_data, size_t place)
{
    if (place == (size_t) NONE) {
        return 0.0;
    }
    return *(const double *) ((const char *) mbs_data->user_model + place);
}

/* --- constraints: joints that follow others --- */

void NAME_constraints(double *h, double **Jac, MbsData *mbs_data)
{
    const double *q = mbs_data->q;
    int k = 0;

    for (const Coupling *c = couplings; c->follower != 0; c++) {
        k++;
        h[k] = q[c->follower] - c->multiplier * q[c->leader] - c->offset;
        Jac[k][c->follower] = 1.0;
        Jac[k][c->leader] = -c->multiplier;
    }
}

void NAME_constraints_jdqd(double *jdqd)
{
    for (int k = 1; k <= NAME_N_CONSTRAINTS; k++) {
        jdqd[k] = 0.0;
    }
}

void NAME_driven_joints(MbsData *mbs_data)
{
    double *q = mbs_data->q, *qd = mbs_data->qd, *qdd = mbs_data->qdd;

    for (const Coupling *c = driven; c->follower != 0; c++) {
        q[c->follower] = c->multiplier * q[c->leader] + c->offset;
        qd[c->follower] = c->multiplier * qd[c->leader];
        qdd[c->follower] = c->multiplier * qdd[c->leader];
    }
}

/* --- forces in joints --- */

/* The force of a stop that a joint has gone into by depth: it pushes and never pulls, and pushes
 * harder on the way in than on the way out. */
static double stop_force(double depth, double rate, double stiffness, double speed)
{
    if (depth <= 0.0) {
        return 0.0;
    }
    return fmax(0.0, stiffness * depth * (1.0 + rate / speed));
}

/* The part of a vector that is not longer than most. */
static double shortened(int n, const double *vector, double most)
{
    const double size = n == 1 ? fabs(vector[0]) : hypot(vector[0], vector[1]);

    return size <= most ? 1.0 : most / size;
}

/* How far a bristle is bent (rad or m; n is 1 or 2), as it pulls: at most by most. ux[state] and on
 * is how far it is bent. What is more than most slips back within time. So friction keeps a joint
 * or a foot at rest that is pulled by less than friction. */
static void bristle(MbsData *mbs_data, int state, int n, const double *rates, double most,
    double time, double *pull)
{
    const double *bent = mbs_data->ux + state;
    const double lost = 1.0 - shortened(n, bent, most);
    double part;

    for (int k = 0; k < n; k++) {
        mbs_data->uxd[state + k] = rates[k] - lost * bent[k] / time;
        pull[k] = bent[k] + time * rates[k];
    }
    part = shortened(n, pull, most);
    for (int k = 0; k < n; k++) {
        pull[k] *= part;
    }
}

double NAME_within_effort(const MbsData *mbs_data, int joint, double push)
{
    const Effort *e = efforts;

    while (e->joint != joint && e->joint != 0) {
        e++;
    }
    if (e->joint != 0 && number(mbs_data, e->most) > 0.0) {
        return fmax(-number(mbs_data, e->most), fmin(number(mbs_data, e->most), push));
    }
    return push;
}

void NAME_joint_forces(MbsData *mbs_data)
{
    const double *q = mbs_data->q, *qd = mbs_data->qd;
    double *Qq = mbs_data->Qq;

    if (number(mbs_data, joint_forces.damping) != 0.0) {
        for (const Damping *d = dampings; d->joint != 0; d++) {
            Qq[d->joint] -= number(mbs_data, d->coefficient) * qd[d->joint];
        }
    }
    if (number(mbs_data, joint_forces.springs) != 0.0) {
        for (const JointSpring *s = joint_springs; s->joint != 0; s++) {
            Qq[s->joint] -= number(mbs_data, s->stiffness)
                * (q[s->joint] - number(mbs_data, s->rest));
        }
    }
    if (number(mbs_data, joint_forces.friction) != 0.0) {
        for (const Friction *f = frictions; f->joint != 0; f++) {
            const double stiffness = number(mbs_data, f->stiffness);
            double pull;

            bristle(mbs_data, f->state, 1, qd + f->joint,
                number(mbs_data, f->coefficient) / stiffness,
                number(mbs_data, joint_forces.friction_time), &pull);
            Qq[f->joint] -= stiffness * pull;
        }
    }
    if (number(mbs_data, joint_forces.stops) != 0.0) {
        const double speed = number(mbs_data, joint_forces.stop_speed);

        for (const Stop *s = stops; s->joint != 0; s++) {
            const double depth = s->side * (q[s->joint] - number(mbs_data, s->limit));
            const double stiffness = number(mbs_data, s->stiffness);

            Qq[s->joint] -= s->side * stop_force(depth, s->side * qd[s->joint], stiffness, speed);
        }
    }
    if (number(mbs_data, hold_on) != 0.0) {
        for (const Hold *h = holds; h->joint != 0; h++) {
            const double push = number(mbs_data, h->stiffness) * (mbs_data->q0[h->joint] - q[h->joint])
                - number(mbs_data, h->damping) * qd[h->joint];

            Qq[h->joint] += NAME_within_effort(mbs_data, h->joint, push);
        }
    }
    for (const JointLaw *l = joint_laws; l->joint != 0; l++) {
        Qq[l->joint] += l->law(mbs_data, l->joint);
    }
}

/* --- external forces --- */

/* The force of the ground on a point: a compliant normal force, and friction up to friction times
 * the normal force by a bristle. */
static void ground_force(const double P[4], const double V[4], MbsData *mbs_data, int state,
    double force[7])
{
    const double depth = number(mbs_data, ground.ground)
        - (up[1] * P[1] + up[2] * P[2] + up[3] * P[3]);
    const double rise = up[1] * V[1] + up[2] * V[2] + up[3] * V[3];
    const double normal = number(mbs_data, ground.stiffness) * depth
        * (1.0 - rise / number(mbs_data, ground.speed));
    const int touches = depth > 0.0 && normal > 0.0; /* the ground pushes and never pulls */
    const double friction = touches ? number(mbs_data, ground.friction) : 0.0;
    const double length = number(mbs_data, ground.bristle);
    double slip[2], pull[2];

    for (int i = 0; i < 2; i++) {
        const double *way = across + 3 * i;

        /* in the air, the bristle springs back */
        slip[i] = touches ? way[0] * V[1] + way[1] * V[2] + way[2] * V[3] : 0.0;
    }
    bristle(mbs_data, state, 2, slip, friction * length, number(mbs_data, ground.bristle_time),
        pull);
    for (int i = 1; i <= 3 && touches; i++) {
        force[i] = normal
            * (up[i] - (pull[0] * across[i - 1] + pull[1] * across[i + 2]) / length);
    }
}

/* c[0] to c[2]: the vector product of two vectors. */
static void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* The force of the ground on a contact, and the torque about the centre of a ball or a wheel. */
static void contact_force(const Contact *contact, double P[4], double R[4][4], double V[4],
    double OM[4], MbsData *mbs_data, double force[7])
{
    double axis[4], arm[4], spin[4], at[4], speed[4], along = 0.0, size = 0.0;

    for (int i = 1; i <= 3; i++) { /* the rows of R are the axes of the body */
        axis[i] = contact->axis[0] * R[1][i] + contact->axis[1] * R[2][i]
            + contact->axis[2] * R[3][i];
        along += up[i] * axis[i];
    }
    for (int i = 1; i <= 3; i++) {
        arm[i] = up[i] - along * axis[i];
        size = hypot(size, arm[i]);
    }
    for (int i = 1; i <= 3; i++) {
        arm[i] *= size > 0.0 ? -contact->radius / size : 0.0;
    }
    cross(OM + 1, arm + 1, spin + 1);
    for (int i = 1; i <= 3; i++) {
        at[i] = P[i] + arm[i];
        speed[i] = V[i] + spin[i];
    }
    ground_force(at, speed, mbs_data, contact->state, force);
    cross(arm + 1, force + 1, force + 4);
}

void NAME_external_force(double PxF[4], double RxF[4][4], double VxF[4], double OMxF[4],
    MbsData *mbs_data, double tsim, int ixF, double force[7])
{
    for (int i = 1; i <= 6; i++) {
        force[i] = 0.0;
    }
    for (const Contact *c = contacts; c->force != 0; c++) {
        if (c->force == ixF) {
            contact_force(c, PxF, RxF, VxF, OMxF, mbs_data, force);
        }
    }
    for (const Wrench *w = wrenches; w->force != 0; w++) {
        if (w->force == ixF && number(mbs_data, w->start) <= tsim
            && tsim < number(mbs_data, w->stop)) {
            for (int i = 1; i <= 6; i++) {
                force[i] = number(mbs_data, w->parts[i - 1]);
            }
        }
    }
    for (const PointLaw *l = point_laws; l->force != 0; l++) {
        if (l->force == ixF) {
            l->law(PxF, VxF, mbs_data, tsim, ixF, force);
        }
    }
}

double NAME_link_force(double Z, double Zd, MbsData *mbs_data, int ilnk)
{
    for (const Spring *s = springs; s->link != 0; s++) {
        if (s->link == ilnk) {
            return number(mbs_data, s->stiffness) * (Z - number(mbs_data, s->length))
                + number(mbs_data, s->damping) * Zd;
        }
    }
    return 0.0;
}

/* --- sensors --- */

void NAME_imu(const MbsSensor *sensor, int isens, const MbsData *mbs_data, double force[4],
    double turn[4])
{
    double f[4], w[4];
    const Sensor *known = sensors;
    const double *r;

    while (known->isens != isens && known->isens != 0) {
        known++;
    }
    r = known->axes;
    for (int i = 1; i <= 3; i++) { /* in the axes of the body */
        f[i] = sensor->R[i][1] * (sensor->A[1] - mbs_data->g[1])
            + sensor->R[i][2] * (sensor->A[2] - mbs_data->g[2])
            + sensor->R[i][3] * (sensor->A[3] - mbs_data->g[3]);
        w[i] = sensor->R[i][1] * sensor->OM[1] + sensor->R[i][2] * sensor->OM[2]
            + sensor->R[i][3] * sensor->OM[3];
    }
    for (int i = 1; i <= 3; i++) { /* in those of the sensor */
        force[i] = r[i - 1] * f[1] + r[i + 2] * f[2] + r[i + 5] * f[3];
        turn[i] = r[i - 1] * w[1] + r[i + 2] * w[2] + r[i + 5] * w[3];
    }
}

/* --- what ends a run: workR/src/main.c and user_dirdyn_loop call these --- */

int NAME_check_partition(const MbsData *mbs_data)
{
    if (dependent[0] == NULL || mbs_data->DonePart == 1) {
        return 1;
    }
    fprintf(stderr, "error: there is no partition, so the loops would be open:");
    for (int i = 0; dependent[i] != NULL; i++) {
        fprintf(stderr, " %s", dependent[i]);
    }
    fprintf(stderr, " cannot be dependent together at this start position. Choose another start"
        " position, or other dependent joints (in the config of urdf2mbs:"
        " 'passes: {posture: ..., loops: {dependent: [...]}}')\n");
    return 0;
}

void NAME_check_step(MbsData *mbs_data)
{
    static int fastest = 0;
    static double speed = 0.0;
    int lost = 0, candidate = 0;

    for (int i = 1; i <= mbs_data->njoint && lost == 0; i++) {
        if (!isfinite(mbs_data->q[i]) || !isfinite(mbs_data->qd[i])) {
            lost = i;
        } else if (candidate == 0 || fabs(mbs_data->qd[i]) > fabs(mbs_data->qd[candidate])) {
            candidate = i;
        }
    }
    if (lost == 0) {
        fastest = candidate;
        speed = candidate == 0 ? 0.0 : fabs(mbs_data->qd[candidate]);
    } else if (!mbs_data->flag_stop) {
        fprintf(stderr, "error: at %g s the position or speed of joint %s is not a number",
            mbs_data->tsim, joints[lost]);
        if (fastest != 0) {
            fprintf(stderr, "; before, joint %s was the fastest, at %.3g rad/s or m/s",
                joints[fastest], speed);
        }
        fprintf(stderr, ". Take a shorter step (dt0), or softer contacts, stops and gains\n");
        mbs_data->flag_stop = 1;
    }
}

int NAME_check_run(MbsData *mbs_data)
{
    NAME_check_step(mbs_data);
    if (mbs_data->flag_stop) {
        fprintf(stderr, "error: the run stopped at %g s; the lines above say why\n",
            mbs_data->tsim);
        return 0;
    }
    return 1;
}
