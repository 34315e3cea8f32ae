/* The laws of the forces that NAME_robot.c applies. They are the same for all robots: what this
 * robot has stands in NAME_robot.c and NAME_tables.h, its numbers in the user models of the .mbs.
 *
 * urdf2mbs writes this file anew at each conversion: do not edit it. */
#ifndef NAME_LAWS_h
#define NAME_LAWS_h

#include <math.h>

#include "mbs_data.h"
#include "mbs_sensor.h"

/* What may touch of a body, in its frame: a point; or a point of a sphere or of a rim, which has an axis,
 * too. From the middle, rim leads so far towards the lowest point, and then so far along the rim. */
typedef struct { double at[3], axis[3], rim[2]; } Spot;
/* No spot is further from the body's origin than bound. The bristles of the body are ux[state] and
 * the two behind it. */
typedef struct { const Spot *spots; int count, state; double bound; } Contact;
/* The user model 'contact'. */
typedef struct { double ground, stiffness, speed, friction, bristle, bristle_time; } Ground;

#include "NAME_tables.h"

/* The sine of the tilt up to which a rim is upright. */
#define UPRIGHT 1e-9

/* --- forces in joints --- */

static inline double between(double low, double value, double high)
{
    return fmax(low, fmin(high, value));
}

/* A force, cut to what a motor can do; a motor without a number can do all. */
static inline double within(double effort, double push)
{
    return effort > 0.0 ? between(-effort, push, effort) : push;
}

/* The force of a stop that a joint has gone into by depth: it pushes and never pulls, and pushes
 * harder on the way in than on the way out. */
static inline double stop(double depth, double rate, double stiffness, double speed)
{
    return depth > 0.0 ? fmax(0.0, stiffness * depth * (1.0 + rate / speed)) : 0.0;
}

/* The force of the stops at the two limits of a joint. */
static inline double stops(double q, double qd, double low, double high, double stiffness,
    double speed)
{
    return stop(q - high, qd, stiffness, speed) - stop(low - q, -qd, stiffness, speed);
}

/* Friction of a joint, by a bristle that is bent by ux[state], and pulls at most with friction. What
 * is bent too far slips back within time. So a joint at rest that is pulled by less stays there. */
static inline double rub(MbsData *mbs_data, int state, double rate, double friction,
    double stiffness, double time)
{
    const double bent = mbs_data->ux[state], most = friction / stiffness;

    mbs_data->uxd[state] = rate - (bent - between(-most, bent, most)) / time;
    return stiffness * between(-most, bent + time * rate, most);
}

/* --- the ground --- */

static inline double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* c: the vector product of two vectors. */
static inline void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* How high a spot is above the body's origin (m), where upwards are the axes of the body. */
static inline double height(const Spot *spot, const double *upwards)
{
    const double middle = dot(spot->at, upwards);

    if (spot->rim[0] != 0.0) {
        const double along = dot(spot->axis, upwards);

        return middle - spot->rim[0] * sqrt(fmax(0.0, 1.0 - along * along));
    }
    return middle;
}

/* From a body's origin to where a spot touches (m), in the axes of the base. */
static inline void reach(const Spot *spot, double R[4][4], double *arm)
{
    double axis[3], lowest[3], side[3], along, size;

    for (int i = 0; i < 3; i++) { /* the rows of R are the axes of the body */
        arm[i] = spot->at[0] * R[1][i + 1] + spot->at[1] * R[2][i + 1] + spot->at[2] * R[3][i + 1];
        axis[i] = spot->axis[0] * R[1][i + 1] + spot->axis[1] * R[2][i + 1]
            + spot->axis[2] * R[3][i + 1];
    }
    if (spot->rim[0] == 0.0 && spot->rim[1] == 0.0) {
        return;
    }
    along = dot(up, axis);
    for (int i = 0; i < 3; i++) {
        lowest[i] = along * axis[i] - up[i];
    }
    size = sqrt(dot(lowest, lowest));
    for (int i = 0; i < 3; i++) { /* an upright rim has no lowest point */
        lowest[i] = size > UPRIGHT ? lowest[i] / size : across[0][i];
    }
    cross(axis, lowest, side);
    for (int i = 0; i < 3; i++) {
        arm[i] += spot->rim[0] * lowest[i] + spot->rim[1] * side[i];
    }
}

/* What the ground does to a body, by sums over its spots that are pushed: their normal force n; n by
 * up x arm (turned) and its square; n by the rate of the bristle, and by both. */
typedef struct { double n, turned[2], square, rate[2], both, force[6]; } Sums;

/* How far a bristle is bent, shortened to the length most. */
static inline void shorten(double *bent, double most)
{
    const double size = sqrt(bent[0] * bent[0] + bent[1] * bent[1]);

    if (size > most) {
        bent[0] *= most / size;
        bent[1] *= most / size;
    }
}

/* A spot below the ground is pushed with n = stiffness depth (1 - rise / speed), never pulled, and
 * rubs by a bristle, up to friction times n. The bristles of a body move as the body does, by two
 * shifts and a turn, which are its states: that of a spot is bent by shift + turn up x arm. */
static inline void add_spot(const Ground *law, const double *arm, double depth,
    const double *speed, const double *bent, Sums *sums)
{
    const double length = law->bristle, time = law->bristle_time, most = law->friction * length;
    const double n = law->stiffness * depth * (1.0 - dot(up, speed) / law->speed);
    const double turned[2] = {-dot(across[1], arm), dot(across[0], arm)};
    double here[2], kept[2], pull[2], rate[2], force[3], torque[3];

    if (n <= 0.0) {
        return;
    }
    for (int i = 0; i < 2; i++) {
        rate[i] = dot(across[i], speed);
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
        force[i] = n * (up[i] - (pull[0] * across[0][i] + pull[1] * across[1][i]) / length);
    }
    cross(arm, force, torque);
    for (int i = 0; i < 3; i++) {
        sums->force[i] += force[i];
        sums->force[i + 3] += torque[i];
    }
}

/* The force and torque of the ground on a body, at its origin, and the rates of its bristles: the
 * shift and the turn that are nearest to how they would move, each by itself. */
static inline void ground_force(const Contact *contact, const Ground *law, const double P[4],
    double R[4][4], const double V[4], const double OM[4], MbsData *mbs_data, double force[7])
{
    const double time = law->bristle_time, above = dot(up, P + 1) - law->ground;
    const double *bent = mbs_data->ux + contact->state;
    double *rates = mbs_data->uxd + contact->state;
    double arm[3], speed[3], upwards[3], centre[2], spread, part;
    Sums sums = {0};

    for (int i = 0; i < 3; i++) { /* in the air, the bristles spring back */
        rates[i] = -bent[i] / time;
        upwards[i] = dot(up, R[i + 1] + 1);
    }
    for (int k = 0; k < contact->count && above < contact->bound; k++) {
        const double depth = -(above + height(&contact->spots[k], upwards));

        if (depth > 0.0) {
            reach(&contact->spots[k], R, arm);
            cross(OM + 1, arm, speed);
            for (int i = 0; i < 3; i++) {
                speed[i] += V[i + 1];
            }
            add_spot(law, arm, depth, speed, bent, &sums);
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
    part = between(0.0, spread / (law->bristle * law->bristle) - 1.0, 1.0);
    rates[2] *= 1.0 - part;
    if (part > 0.0) {
        rates[2] += part * sums.both / (sums.n * spread);
    }
    rates[0] -= rates[2] * centre[0];
    rates[1] -= rates[2] * centre[1];
}

/* --- sensors --- */

/* What an IMU reads, in its own axes: r has them in the body, row by row. */
static inline void read_imu(const MbsSensor *sensor, const double *r, const double g[4],
    double force[4], double turn[4])
{
    double f[4], w[4];

    for (int i = 1; i <= 3; i++) { /* in the axes of the body */
        f[i] = sensor->R[i][1] * (sensor->A[1] - g[1]) + sensor->R[i][2] * (sensor->A[2] - g[2])
            + sensor->R[i][3] * (sensor->A[3] - g[3]);
        w[i] = sensor->R[i][1] * sensor->OM[1] + sensor->R[i][2] * sensor->OM[2]
            + sensor->R[i][3] * sensor->OM[3];
    }
    for (int i = 1; i <= 3; i++) { /* in those of the sensor */
        force[i] = r[i - 1] * f[1] + r[i + 2] * f[2] + r[i + 5] * f[3];
        turn[i] = r[i - 1] * w[1] + r[i + 2] * w[2] + r[i + 5] * w[3];
    }
}

#endif
