/* The laws of the forces that NAME_robot.c applies. They are the same for all robots: this robot's data
 * is in NAME_robot.c and NAME_tables.h, its numbers are in the user models of the .mbs.
 *
 * urdf2mbs writes this file anew at each conversion: do not edit it. */
#ifndef NAME_LAWS_h
#define NAME_LAWS_h

#include <math.h>

#include "mbs_data.h"
#include "mbs_sensor.h"

/* A part of a body that may touch the ground, in the frame of the body (m): a point, a sphere, or a
 * point of a rim. A sphere has a radius r, and rim = {r, 0}. A rim has an axis, too, and
 * rim = {r cos(a), r sin(a)}, with a the angle along the rim from its lowest point. */
typedef struct { double centre[3], axis[3], rim[2]; } Spot;
/* The spots of a body. None is further from the body's origin than bound (m). The bristles of the body
 * are ux[state], ux[state + 1] and ux[state + 2]. */
typedef struct { const Spot *spots; int count, state; double bound; } Contact;
/* The numbers of the user model 'contact': height (m), N/m, m/s, a ratio, m and s. */
typedef struct { double ground, stiffness, speed, friction, bristle, bristle_time; } Ground;

#include "NAME_tables.h"

/* The sine of the tilt up to which a rim is upright, and has no lowest point. */
#define UPRIGHT 1e-9

/* --- forces in joints --- */

static inline double clamp(double lower, double value, double upper)
{
    return fmax(lower, fmin(upper, value));
}

/* A force (N or N m), limited to the effort of a motor; a motor with effort 0 has no limit. */
static inline double limit_effort(double effort, double force)
{
    return effort > 0.0 ? clamp(-effort, force, effort) : force;
}

/* The force of a stop that a joint has gone into by depth: max(0, stiffness depth (1 + rate / speed)).
 * It pushes and never pulls, and pushes harder on the way in than on the way out. */
static inline double stop_force(double depth, double rate, double stiffness, double speed)
{
    return depth > 0.0 ? fmax(0.0, stiffness * depth * (1.0 + rate / speed)) : 0.0;
}

/* The force of the stops at both limits of a joint, to be subtracted from Qq. */
static inline double stop_forces(double q, double qd, double lower, double upper, double stiffness,
    double speed)
{
    return stop_force(q - upper, qd, stiffness, speed) - stop_force(lower - q, -qd, stiffness, speed);
}

/* The friction of a joint, by a bristle: a spring that is bent by b = ux[state], and slips where it
 * would pull with more than friction. With clip(x) limited to |x| <= friction / stiffness:
 *
 *     db/dt = rate - (b - clip(b)) / time
 *     force = stiffness clip(b + time rate)
 *
 * So a joint at rest that is pulled by less than friction stays at rest. */
static inline double joint_friction(MbsData *mbs_data, int state, double rate, double friction,
    double stiffness, double time)
{
    const double bent = mbs_data->ux[state], longest = friction / stiffness;

    mbs_data->uxd[state] = rate - (bent - clamp(-longest, bent, longest)) / time;
    return stiffness * clamp(-longest, bent + time * rate, longest);
}

/* --- the ground ---
 *
 * A spot at the depth d below the ground, with the velocity v, is pushed up and never pulled:
 *
 *     n = max(0, stiffness d (1 - up . v / speed)).
 *
 * Its friction is a bristle, as in a joint. It is bent by b, a vector in the ground, where v is the
 * part of the velocity along the ground, and clip(b) is shortened to |b| <= friction bristle:
 *
 *     db/dt = v - (b - clip(b)) / bristle_time =: r
 *     force = -n clip(b + bristle_time v) / bristle.
 *
 * The bristles of a body move as the body does. So its states are one shift s and one turn w for all
 * of them: b = s + w t, with t = up x arm, and the arm from the body's origin to the spot. Their rates
 * are the shift and the turn that are nearest to the rates r of the spots, weighted by n:
 *
 *     c = sum n t / sum n,   w' = sum n (t - c) . r / sum n |t - c|^2,   s' = sum n r / sum n - w' c. */

static inline double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Set c to the vector product of a and b. */
static inline void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* The height of a spot above the body's origin (m), with up_in_body in the axes of the body. */
static inline double spot_height(const Spot *spot, const double *up_in_body)
{
    const double centre_height = dot(spot->centre, up_in_body);

    if (spot->rim[0] != 0.0) {
        const double cosine = dot(spot->axis, up_in_body);

        return centre_height - spot->rim[0] * sqrt(fmax(0.0, 1.0 - cosine * cosine));
    }
    return centre_height;
}

/* The arm from a body's origin to where a spot touches (m), in the axes of the base. The direction from
 * the centre of a rim to its lowest point is (up . axis) axis - up. */
static inline void compute_arm(const Spot *spot, double R[4][4], double *arm)
{
    double axis[3], lowest[3], tangent[3], cosine, length;

    for (int i = 0; i < 3; i++) { /* the rows of R are the axes of the body */
        arm[i] = spot->centre[0] * R[1][i + 1] + spot->centre[1] * R[2][i + 1]
            + spot->centre[2] * R[3][i + 1];
        axis[i] = spot->axis[0] * R[1][i + 1] + spot->axis[1] * R[2][i + 1]
            + spot->axis[2] * R[3][i + 1];
    }
    if (spot->rim[0] == 0.0 && spot->rim[1] == 0.0) {
        return;
    }
    cosine = dot(up, axis);
    for (int i = 0; i < 3; i++) {
        lowest[i] = cosine * axis[i] - up[i];
    }
    length = sqrt(dot(lowest, lowest));
    for (int i = 0; i < 3; i++) { /* an upright rim has no lowest point */
        lowest[i] = length > UPRIGHT ? lowest[i] / length : across[0][i];
    }
    cross(axis, lowest, tangent);
    for (int i = 0; i < 3; i++) {
        arm[i] += spot->rim[0] * lowest[i] + spot->rim[1] * tangent[i];
    }
}

/* Sums over the spots of a body that the ground pushes: n, n t, n |t|^2, n r, n t . r, and the force
 * and torque at the body's origin. */
typedef struct { double n, turned[2], squared, rate[2], mixed, force[6]; } Sums;

/* Shorten the deflection of a bristle to a length. */
static inline void shorten(double *bent, double longest)
{
    const double length = sqrt(bent[0] * bent[0] + bent[1] * bent[1]);

    if (length > longest) {
        bent[0] *= longest / length;
        bent[1] *= longest / length;
    }
}

/* Add what the ground does at a spot, whose velocity and arm are in the axes of the base. The states of
 * the body's bristles are {s[0], s[1], w}, along the two directions across. */
static inline void add_spot(const Ground *law, const double *arm, double depth,
    const double *velocity, const double *states, Sums *sums)
{
    const double length = law->bristle, time = law->bristle_time, longest = law->friction * length;
    const double n = law->stiffness * depth * (1.0 - dot(up, velocity) / law->speed);
    const double turned[2] = {-dot(across[1], arm), dot(across[0], arm)};
    double bent[2], clipped[2], pull[2], rate[2], force[3], torque[3];

    if (n <= 0.0) {
        return;
    }
    for (int i = 0; i < 2; i++) {
        rate[i] = dot(across[i], velocity);
        clipped[i] = bent[i] = states[i] + states[2] * turned[i];
        pull[i] = bent[i] + time * rate[i];
    }
    shorten(clipped, longest);
    shorten(pull, longest);
    for (int i = 0; i < 2; i++) {
        rate[i] -= (bent[i] - clipped[i]) / time;
        sums->turned[i] += n * turned[i];
        sums->rate[i] += n * rate[i];
    }
    sums->n += n;
    sums->squared += n * (turned[0] * turned[0] + turned[1] * turned[1]);
    sums->mixed += n * (turned[0] * rate[0] + turned[1] * rate[1]);
    for (int i = 0; i < 3; i++) {
        force[i] = n * (up[i] - (pull[0] * across[0][i] + pull[1] * across[1][i]) / length);
    }
    cross(arm, force, torque);
    for (int i = 0; i < 3; i++) {
        sums->force[i] += force[i];
        sums->force[i + 3] += torque[i];
    }
}

/* Set the force and torque of the ground on a body, at its origin, and the rates of its bristles. */
static inline void ground_force(const Contact *contact, const Ground *law, const double P[4],
    double R[4][4], const double V[4], const double OM[4], MbsData *mbs_data, double force[7])
{
    const double time = law->bristle_time, height = dot(up, P + 1) - law->ground;
    const double *states = mbs_data->ux + contact->state;
    double *rates = mbs_data->uxd + contact->state;
    double arm[3], velocity[3], up_in_body[3], centre[2], spread, share;
    Sums sums = {0};

    for (int i = 0; i < 3; i++) { /* in the air, the bristles spring back */
        rates[i] = -states[i] / time;
        up_in_body[i] = dot(up, R[i + 1] + 1);
    }
    for (int k = 0; k < contact->count && height < contact->bound; k++) {
        const double depth = -(height + spot_height(&contact->spots[k], up_in_body));

        if (depth > 0.0) {
            compute_arm(&contact->spots[k], R, arm);
            cross(OM + 1, arm, velocity);
            for (int i = 0; i < 3; i++) {
                velocity[i] += V[i + 1];
            }
            add_spot(law, arm, depth, velocity, states, &sums);
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
        sums.mixed -= centre[i] * sums.rate[i];
    }
    spread = sums.squared / sums.n - centre[0] * centre[0] - centre[1] * centre[1];
    /* one spot alone does not resist a turn, which then springs back as in the air */
    share = clamp(0.0, spread / (law->bristle * law->bristle) - 1.0, 1.0);
    rates[2] *= 1.0 - share;
    if (share > 0.0) {
        rates[2] += share * sums.mixed / (sums.n * spread);
    }
    rates[0] -= rates[2] * centre[0];
    rates[1] -= rates[2] * centre[1];
}

/* --- sensors --- */

/* Set what an IMU reads, in its own axes, which are the rows of axes in the frame of the body: the
 * specific force A - g (m/s^2), and the angular velocity (rad/s). */
static inline void read_imu(const MbsSensor *sensor, const double *axes, const double g[4],
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
        force[i] = axes[i - 1] * f[1] + axes[i + 2] * f[2] + axes[i + 5] * f[3];
        turn[i] = axes[i - 1] * w[1] + axes[i + 2] * w[2] + axes[i + 5] * w[3];
    }
}

#endif
