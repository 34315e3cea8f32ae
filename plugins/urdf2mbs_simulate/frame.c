/* The motion of any body, from joint to joint: equations for each of them take a compiler long.

   Compiled with RUN_JOINTS, and with RUN_TREE: for each joint its type (0 to 2: T1 to T3, 3 to 5: R1 to R3), the
   joint before it, and the anchor point where its body begins; 0 is none. */
#include <math.h>
#include <string.h>

#include "runtime.h"

MbsSensor frame;
double arm[4];

static const struct { int type, before, point; } tree[RUN_JOINTS + 1] = {{0, 0, 0}, RUN_TREE};
static double at_joint[RUN_JOINTS + 1][4]; /* where the joints are that were passed (m) */

double cross(const double *a, const double *b, int i)
{
    const int k = i % 3 + 1, l = k % 3 + 1;

    return a[k] * b[l] - a[l] * b[k];
}

/* Move the frame along a way (m) in its body, which turns with it. */
static void shift(const double *way)
{
    double speed[4], bend[4];

    for (int i = 1; i <= 3; i++)
        speed[i] = cross(frame.OM, way, i);
    for (int i = 1; i <= 3; i++)
        bend[i] = cross(frame.OMP, way, i) + cross(frame.OM, speed, i);
    for (int i = 1; i <= 3; i++) {
        frame.P[i] += way[i];
        frame.V[i] += speed[i];
        frame.A[i] += bend[i];
    }
}

/* From before a joint to behind it. */
static void pass(const MbsData *s, int joint)
{
    const int point = tree[joint].point, turns = tree[joint].type >= 3, own = tree[joint].type % 3 + 1;
    const int second = own % 3 + 1, third = second % 3 + 1;
    const double c = cos(s->q[joint]), n = sin(s->q[joint]), *axis = frame.R[own];
    double way[4], extra[4];

    for (int i = 1; i <= 3; i++) {
        way[i] = turns ? 0.0 : axis[i] * s->q[joint];
        for (int k = 1; k <= 3 && point; k++)
            way[i] += frame.R[k][i] * s->dpt[k][point];
        frame.J[turns ? 3 + i : i][joint] = axis[i];
    }
    shift(way);
    memcpy(at_joint[joint], frame.P, sizeof frame.P);
    for (int i = 1; i <= 3; i++)
        extra[i] = axis[i] * s->qdd[joint] + (turns ? 1.0 : 2.0) * cross(frame.OM, axis, i) * s->qd[joint];
    for (int i = 1; i <= 3; i++) {
        const double one = frame.R[second][i], two = frame.R[third][i];

        (turns ? frame.OM : frame.V)[i] += axis[i] * s->qd[joint];
        (turns ? frame.OMP : frame.A)[i] += extra[i];
        frame.R[second][i] = turns ? c * one + n * two : one;
        frame.R[third][i] = turns ? c * two - n * one : two;
    }
}

void find_frame(const MbsData *s, int joint, const double at[4])
{
    static double jacobian[7][RUN_JOINTS + 1];
    int way[RUN_JOINTS + 1], count = 0;

    memset(&frame, 0, sizeof frame);
    memset(jacobian, 0, sizeof jacobian);
    for (int i = 0; i <= 6; i++)
        frame.J[i] = jacobian[i];
    for (int i = 1; i <= 3; i++)
        frame.R[i][i] = 1.0;
    for (int j = joint; j; j = tree[j].before)
        way[count++] = j;
    for (int k = count - 1; k >= 0; k--)
        pass(s, way[k]);
    for (int k = 0; k < count; k++) {
        const int j = way[k];
        const double turn[4] = {0.0, frame.J[4][j], frame.J[5][j], frame.J[6][j]};
        double lever[4];

        for (int i = 1; i <= 3; i++)
            lever[i] = frame.P[i] - at_joint[j][i];
        for (int i = 1; i <= 3; i++)
            frame.J[i][j] += cross(turn, lever, i);
    }
    for (int i = 1; i <= 3; i++)
        arm[i] = frame.R[1][i] * at[1] + frame.R[2][i] * at[2] + frame.R[3][i] * at[3];
}
