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
/* The sine of the tilt up to which a rim is upright. */
#define UPRIGHT 1e-9

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
/* What may touch of a body, in its frame: a point; a sphere, which has a radius; or a point of a rim,
 * which has an axis, too, and is turned away from the lowest point of the rim (rad). */
typedef struct { double radius, at[3], axis[3], turn; } Spot;
/* state: the place of its bristles in ux. No spot is further from the body's origin than bound. */
typedef struct { int force, state, first, count; double bound; } Contact;
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

static double between(double low, double value, double high)
{
    return fmax(low, fmin(high, value));
}

/* How far the bristle of a joint is bent (rad or m), as it pulls: at most by most. ux[state] is how
 * far it is bent. What is more than most slips back within time. So friction keeps a joint at rest
 * that is pulled by less than friction. */
static double bristle(MbsData *mbs_data, int state, double rate, double most, double time)
{
    const double bent = mbs_data->ux[state];

    mbs_data->uxd[state] = rate - (bent - between(-most, bent, most)) / time;
    return between(-most, bent + time * rate, most);
}

double NAME_within_effort(const MbsData *mbs_data, int joint, double push)
{
    const Effort *e = efforts;

    while (e->joint != joint && e->joint != 0) {
        e++;
    }
    if (e->joint != 0 && number(mbs_data, e->most) > 0.0) {
        return between(-number(mbs_data, e->most), push, number(mbs_data, e->most));
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
            const double most = number(mbs_data, f->coefficient) / stiffness;

            Qq[f->joint] -= stiffness * bristle(mbs_data, f->state, qd[f->joint], most,
                number(mbs_data, joint_forces.friction_time));
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

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* c: the vector product of two vectors. */
static void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* From a body's origin to where a spot touches (m), in the axes of the base. */
static void reach(const Spot *spot, double R[4][4], double *arm)
{
    double axis[3], lowest[3], side[3], along, size;

    for (int i = 0; i < 3; i++) { /* the rows of R are the axes of the body */
        arm[i] = spot->at[0] * R[1][i + 1] + spot->at[1] * R[2][i + 1] + spot->at[2] * R[3][i + 1];
        axis[i] = spot->axis[0] * R[1][i + 1] + spot->axis[1] * R[2][i + 1]
            + spot->axis[2] * R[3][i + 1];
    }
    if (spot->radius == 0.0) {
        return;
    }
    along = dot(up, axis);
    for (int i = 0; i < 3; i++) {
        lowest[i] = along * axis[i] - up[i];
    }
    size = sqrt(dot(lowest, lowest));
    for (int i = 0; i < 3; i++) { /* an upright rim has no lowest point */
        lowest[i] = size > UPRIGHT ? lowest[i] / size : across[i];
    }
    cross(axis, lowest, side);
    for (int i = 0; i < 3; i++) {
        arm[i] += spot->radius * (cos(spot->turn) * lowest[i] + sin(spot->turn) * side[i]);
    }
}

/* What the ground does to a body, by sums over its spots that are pushed: their normal force n; n by
 * up x arm (turned) and its square; n by the rate of the bristle, and by both. */
typedef struct { double n, turned[2], square, rate[2], both, force[6]; } Sums;

/* How far a bristle is bent, shortened to the length most. */
static void shorten(double *bent, double most)
{
    const double size = hypot(bent[0], bent[1]);

    if (size > most) {
        bent[0] *= most / size;
        bent[1] *= most / size;
    }
}

/* A spot below the ground is pushed with n = stiffness depth (1 - rise / speed), never pulled, and
 * rubs by a bristle, up to friction times n. The bristles of a body move as the body does, by two
 * shifts and a turn, which are its states: that of a spot is bent by shift + turn up x arm. */
static void add_spot(const double *arm, double depth, const double *speed, MbsData *mbs_data,
    const double *bent, Sums *sums)
{
    const double length = number(mbs_data, ground.bristle);
    const double time = number(mbs_data, ground.bristle_time);
    const double most = number(mbs_data, ground.friction) * length;
    const double n = number(mbs_data, ground.stiffness) * depth
        * (1.0 - dot(up, speed) / number(mbs_data, ground.speed));
    const double turned[2] = {-dot(across + 3, arm), dot(across, arm)};
    double here[2], kept[2], pull[2], rate[2], force[3], torque[3];

    if (n <= 0.0) {
        return;
    }
    for (int i = 0; i < 2; i++) {
        rate[i] = dot(across + 3 * i, speed);
        kept[i] = here[i] = bent[i] + bent[2] * turned[i];
        pull[i] = here[i] + time * rate[i];
    }
    shorten(kept, most); /* what is bent too far slips back within bristle_time */
    shorten(pull, most);
    for (int i = 0; i < 2; i++) {
        rate[i] -= (here[i] - kept[i]) / time;
        sums->turned[i] += n * turned[i];
        sums->rate[i] += n * rate[i];
    }
    sums->n += n;
    sums->square += n * (turned[0] * turned[0] + turned[1] * turned[1]);
    sums->both += n * (turned[0] * rate[0] + turned[1] * rate[1]);
    for (int i = 0; i < 3; i++) {
        force[i] = n * (up[i] - (pull[0] * across[i] + pull[1] * across[i + 3]) / length);
    }
    cross(arm, force, torque);
    for (int i = 0; i < 3; i++) {
        sums->force[i] += force[i];
        sums->force[i + 3] += torque[i];
    }
}

/* The force and torque of the ground on a body, at its origin, and the rates of its bristles: the
 * shift and the turn that are nearest to how they would move, each by itself. */
static void ground_force(const Contact *contact, const double P[4], double R[4][4],
    const double V[4], const double OM[4], MbsData *mbs_data, double force[7])
{
    const double time = number(mbs_data, ground.bristle_time);
    const double *bent = mbs_data->ux + contact->state;
    double *rates = mbs_data->uxd + contact->state;
    const double above = dot(up, P + 1) - number(mbs_data, ground.ground);
    double arm[3], speed[3], centre[2], spread, part;
    Sums sums = {0};

    for (int i = 0; i < 3; i++) { /* in the air, the bristles spring back */
        rates[i] = -bent[i] / time;
    }
    for (int k = 0; k < contact->count && above < contact->bound; k++) {
        double depth;

        reach(&spots[contact->first + k], R, arm);
        depth = -(above + dot(up, arm));
        if (depth > 0.0) {
            cross(OM + 1, arm, speed);
            for (int i = 0; i < 3; i++) {
                speed[i] += V[i + 1];
            }
            add_spot(arm, depth, speed, mbs_data, bent, &sums);
        }
    }
    if (sums.n == 0.0) {
        return;
    }
    for (int i = 0; i < 6; i++) {
        force[i + 1] = sums.force[i];
    }
    for (int i = 0; i < 2; i++) {
        centre[i] = sums.turned[i] / sums.n;
        rates[i] = sums.rate[i] / sums.n;
        sums.both -= centre[i] * sums.rate[i];
    }
    spread = sums.square / sums.n - centre[0] * centre[0] - centre[1] * centre[1];
    /* one spot alone does not resist a turn */
    part = between(0.0, spread / pow(number(mbs_data, ground.bristle), 2.0) - 1.0, 1.0);
    rates[2] *= 1.0 - part;
    if (part > 0.0) {
        rates[2] += part * sums.both / (sums.n * spread);
    }
    rates[0] -= rates[2] * centre[0];
    rates[1] -= rates[2] * centre[1];
}

void NAME_external_force(double PxF[4], double RxF[4][4], double VxF[4], double OMxF[4],
    MbsData *mbs_data, double tsim, int ixF, double force[7])
{
    for (int i = 1; i <= 6; i++) {
        force[i] = 0.0;
    }
    for (const Contact *c = contacts; c->force != 0; c++) {
        if (c->force == ixF) {
            ground_force(c, PxF, RxF, VxF, OMxF, mbs_data, force);
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
