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

int can_turn, turned;
double own_angles[3]; /* as they were shown last: the next ones are near */
static double kept[2][7];

static const double PI = 3.14159265358979323846, LEAST = 1e-9;

static void forth(double *v)
{
    const double x = v[1];

    v[1] = v[2];
    v[2] = -x;
}

static void back(double *v)
{
    const double x = v[1];

    v[1] = -v[2];
    v[2] = x;
}

/* 1 where the second angle of the base asks for other axes. */
int must_turn(const double *y)
{
    return can_turn && fabs(cos(y[4])) < 0.3;
}

/* Show the model's own q and qd of the base, which is near own_angles. */
void show_base(MbsData *s)
{
    double *q = s->q, *qd = s->qd, R[4][4], w[4], best = INFINITY, found[3], a, b, c, cb;
    const double ca = cos(q[4]), sa = sin(q[4]), cc = cos(q[6]), sc = sin(q[6]), sb = sin(q[5]);

    if (!turned)
        return;
    memcpy(kept[0], q, sizeof kept[0]);
    memcpy(kept[1], qd, sizeof kept[1]);
    cb = cos(q[5]);
    w[1] = qd[4] + sb * qd[6];
    w[2] = ca * qd[5] - sa * cb * qd[6];
    w[3] = sa * qd[5] + ca * cb * qd[6];
    /* the rows of the rotation, turned back: the first is the second one's opposite */
    R[1][1] = -(ca * sc + sa * sb * cc);
    R[1][2] = -(ca * cc - sa * sb * sc);
    R[1][3] = sa * cb;
    R[2][3] = sb;
    R[3][3] = ca * cb;
    back(q), back(qd), back(w);
    for (int side = 0; side < 2; side++) { /* two triples of angles are the same rotation */
        double off = 0.0, angles[3] = {
            atan2(-R[2][3], R[3][3]) + side * PI,
            side ? PI - asin(fmax(-1.0, fmin(1.0, R[1][3]))) : asin(fmax(-1.0, fmin(1.0, R[1][3]))),
            atan2(-R[1][2], R[1][1]) + side * PI,
        };

        for (int i = 0; i < 3; i++) {
            angles[i] += 2.0 * PI * round((own_angles[i] - angles[i]) / (2.0 * PI));
            off += fabs(angles[i] - own_angles[i]);
        }
        if (off < best) {
            best = off;
            memcpy(found, angles, sizeof found);
        }
    }
    memcpy(own_angles, found, sizeof found);
    a = found[0], b = found[1];
    c = cos(b);
    c = fabs(c) < LEAST ? copysign(LEAST, c) : c;
    memcpy(q + 4, found, sizeof found);
    qd[6] = (cos(a) * w[3] - sin(a) * w[2]) / c;
    qd[5] = cos(a) * w[2] + sin(a) * w[3];
    qd[4] = w[1] - sin(b) * qd[6];
}

/* Back to the turned axes. */
void hide_base(MbsData *s)
{
    if (turned) {
        memcpy(s->q, kept[0], sizeof kept[0]);
        memcpy(s->qd, kept[1], sizeof kept[1]);
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
        back(moved[i]);
    show_base(s);
    given = user_ExtForces(P, R, V, OM, A, OMP, s, tsim, number);
    hide_base(s);
    for (int i = 0; i < 8; i++)
        forth(moved[i]);
    memcpy(force, given, sizeof forces[number]);
    forth(force), forth(force + 3);
    return force;
}

/* Forces that the user puts on the joints of the base become those of its turned joints. */
double *run_JointForces(MbsData *s, double tsim)
{
    double *Q = s->Qq, n[4], a, b, c, rest;

    show_base(s);
    user_JointForces(s, tsim);
    a = s->q[4], b = s->q[5];
    hide_base(s);
    if (turned && (Q[1] != 0.0 || Q[2] != 0.0 || Q[4] != 0.0 || Q[5] != 0.0 || Q[6] != 0.0)) {
        c = cos(b);
        c = fabs(c) < LEAST ? copysign(LEAST, c) : c;
        rest = (Q[6] - Q[4] * sin(b)) / c;
        n[1] = Q[4];
        n[2] = Q[5] * cos(a) - rest * sin(a);
        n[3] = Q[5] * sin(a) + rest * cos(a);
        forth(Q), forth(n);
        a = s->q[4], b = s->q[5];
        Q[4] = n[1];
        Q[5] = cos(a) * n[2] + sin(a) * n[3];
        Q[6] = sin(b) * n[1] + cos(b) * (cos(a) * n[3] - sin(a) * n[2]);
    }
    return Q;
}
