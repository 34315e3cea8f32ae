/* A free base in world axes that are turned by a quarter about the vertical: x' = y, y' = -x.

   The angles of the base have no solution where the second is 90 degrees.  Near there the state is that
   in turned axes, where the second angle is small.  Gravity and ground are the same.  User functions
   see the model's own axes: what they are given is turned back, and what they give is turned.

   Compiled with RUN_FORCES, the number of external forces. */
#include <math.h>
#include <string.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"

double *run_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                      double OMP[4], MbsData *s, double tsim, int number);
double *run_JointForces(MbsData *s, double tsim);
void run_DrivenJoints(MbsData *s, double tsim);
double run_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number);
double *run_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                         double OMP[4], MbsData *s, double tsim, int number);

int can_turn, turned;
double own_angles[3]; /* as they were shown last: the next ones are near */
static double kept[3][7], own[3][7]; /* q, qd and qdd of the base, as they are and as they were shown last */

static const double PI = 3.14159265358979323846, LEAST = 1e-9;

/* A quarter forth (1) or back (-1). */
static void quarter(double *v, int way)
{
    const double x = v[1];

    v[1] = way * v[2];
    v[2] = -way * x;
}

/* A force in the world's axes becomes that in the axes of the state. */
void turn_force(double *force)
{
    if (turned)
        quarter(force, 1);
}

static double away(double cosine)
{
    return fabs(cosine) < LEAST ? copysign(LEAST, cosine) : cosine;
}

/* The spin w of a body behind three joints R1, R2, R3 at q, by their rates. */
static void find_spin(const double *q, const double *rates, double *w)
{
    const double last = rates[3] * cos(q[2]);

    w[1] = rates[1] + sin(q[2]) * rates[3];
    w[2] = cos(q[1]) * rates[2] - sin(q[1]) * last;
    w[3] = sin(q[1]) * rates[2] + cos(q[1]) * last;
}

static void find_rates(const double *q, const double *w, double *rates)
{
    rates[3] = (cos(q[1]) * w[3] - sin(q[1]) * w[2]) / away(cos(q[2]));
    rates[2] = cos(q[1]) * w[2] + sin(q[1]) * w[3];
    rates[1] = w[1] - sin(q[2]) * rates[3];
}

/* Add to a how the spin changes while the rates do not. */
static void add_drift(const double *q, const double *rates, double sign, double *a)
{
    const double first = rates[1], second = rates[2], last = rates[3] * cos(q[2]);
    const double along = rates[3] * sin(q[2]) * second;

    a[1] += sign * last * second;
    a[2] += sign * (sin(q[1]) * along - first * (sin(q[1]) * second + cos(q[1]) * last));
    a[3] += sign * (first * (cos(q[1]) * second - sin(q[1]) * last) - cos(q[1]) * along);
}

/* The angles of the rotation of q that is turned forth or back, and nearest to some. */
static void find_angles(const double *q, int way, const double *near, double *found)
{
    const double ca = cos(q[1]), sa = sin(q[1]), cc = cos(q[3]), sc = sin(q[3]), sb = sin(q[2]);
    const double middle = asin(fmax(-1.0, fmin(1.0, -way * sa * cos(q[2]))));
    double best = INFINITY, nearest[3];

    for (int side = 0; side < 2; side++) { /* two triples of angles are the same rotation */
        double off = 0.0, angles[3] = {
            atan2(way * sb, ca * cos(q[2])) + side * PI,
            side ? PI - middle : middle,
            atan2(way * (sa * sb * sc - ca * cc), way * (ca * sc + sa * sb * cc)) + side * PI,
        };

        for (int i = 0; i < 3; i++) {
            angles[i] += 2.0 * PI * round((near[i] - angles[i]) / (2.0 * PI));
            off += fabs(angles[i] - near[i]);
        }
        if (off < best) {
            best = off;
            memcpy(nearest, angles, sizeof nearest);
        }
    }
    memcpy(found, nearest, sizeof nearest);
}

/* Go on in other axes, if the second angle of the base asks for them: the state y becomes the one there. */
int turn_if_near(const MbsData *s, double *y)
{
    static const double zero[3];
    const int way = turned ? -1 : 1;
    double *q = y - 1, *qd = y + s->nqu - 1, spin[4]; /* from index 1 */

    if (!can_turn || fabs(cos(q[5])) >= 0.3)
        return 0;
    find_spin(q + 3, qd + 3, spin);
    if (turned)
        find_angles(q + 3, -1, own_angles, own_angles);
    else
        memcpy(own_angles, q + 4, sizeof own_angles);
    find_angles(q + 3, way, turned ? own_angles : zero, q + 4);
    quarter(q, way), quarter(qd, way), quarter(spin, way);
    find_rates(q + 3, spin, qd + 3);
    turned = !turned;
    return 1;
}

/* Find the model's own q, qd and qdd of the base, in s. */
static void find_own(MbsData *s)
{
    double *rows[] = {s->q, s->qd, s->qdd}, *q = s->q + 3, spin[4], gain[4];

    find_spin(q, s->qd + 3, spin);
    find_spin(q, s->qdd + 3, gain);
    add_drift(q, s->qd + 3, 1.0, gain);
    find_angles(q, -1, own_angles, own_angles);
    memcpy(q + 1, own_angles, sizeof own_angles);
    for (int i = 0; i < 3; i++)
        quarter(rows[i], -1);
    quarter(spin, -1), quarter(gain, -1);
    find_rates(q, spin, s->qd + 3);
    add_drift(q, s->qd + 3, -1.0, gain);
    find_rates(q, gain, s->qdd + 3);
}

/* Show the model's own q, qd and qdd of the base: most forces are those of one state. */
void show_base(MbsData *s)
{
    double *rows[] = {s->q, s->qd, s->qdd};
    int moved = 0;

    if (!turned)
        return;
    for (int i = 0; i < 3; i++) {
        moved |= memcmp(kept[i], rows[i], sizeof kept[i]);
        memcpy(kept[i], rows[i], sizeof kept[i]);
    }
    if (moved)
        find_own(s);
    for (int i = 0; i < 3; i++)
        memcpy(moved ? own[i] : rows[i], moved ? rows[i] : own[i], sizeof own[i]);
}

/* Back to the turned axes. */
void hide_base(MbsData *s)
{
    if (turned) {
        memcpy(s->q, kept[0], sizeof kept[0]);
        memcpy(s->qd, kept[1], sizeof kept[1]);
        memcpy(s->qdd, kept[2], sizeof kept[2]);
    }
}

double *run_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                      double OMP[4], MbsData *s, double tsim, int number)
{
    static double forces[RUN_FORCES + 1][10]; /* equations read one when others are computed */
    double *moved[] = {P, V, OM, A, OMP, R[1], R[2], R[3]}, *given, *force = forces[number];

    if (!turned)
        return user_ExtForces(P, R, V, OM, A, OMP, s, tsim, number);
    for (int i = 0; i < 8; i++)
        quarter(moved[i], -1);
    show_base(s);
    given = user_ExtForces(P, R, V, OM, A, OMP, s, tsim, number);
    hide_base(s);
    for (int i = 0; i < 8; i++)
        quarter(moved[i], 1);
    memcpy(force, given, sizeof forces[number]);
    quarter(force, 1), quarter(force + 3, 1);
    return force;
}

/* What these three are given and give is the same in all axes, but they may look at the base. */
void run_DrivenJoints(MbsData *s, double tsim)
{
    show_base(s);
    user_DrivenJoints(s, tsim);
    hide_base(s);
}

double run_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number)
{
    double force;

    show_base(s);
    force = user_LinkForces(Z, Zd, s, tsim, number);
    hide_base(s);
    return force;
}

double *run_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                         double OMP[4], MbsData *s, double tsim, int number)
{
    double *force;

    show_base(s);
    force = user_Link3DForces(P, R, V, OM, A, OMP, s, tsim, number);
    hide_base(s);
    return force;
}

/* Forces that the user puts on the joints of the base become those of its turned joints. */
double *run_JointForces(MbsData *s, double tsim)
{
    double *Q = s->Qq, n[4], a, b, rest;

    show_base(s);
    user_JointForces(s, tsim);
    a = s->q[4], b = s->q[5];
    hide_base(s);
    if (turned && (Q[1] != 0.0 || Q[2] != 0.0 || Q[4] != 0.0 || Q[5] != 0.0 || Q[6] != 0.0)) {
        rest = (Q[6] - Q[4] * sin(b)) / away(cos(b));
        n[1] = Q[4];
        n[2] = Q[5] * cos(a) - rest * sin(a);
        n[3] = Q[5] * sin(a) + rest * cos(a);
        quarter(Q, 1), quarter(n, 1);
        a = s->q[4], b = s->q[5];
        Q[4] = n[1];
        Q[5] = cos(a) * n[2] + sin(a) * n[3];
        Q[6] = sin(b) * n[1] + cos(b) * (cos(a) * n[3] - sin(a) * n[2]);
    }
    return Q;
}
