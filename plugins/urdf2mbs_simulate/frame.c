/* The motion of any body, by recursion over the joints of its chain (generated equations of all bodies would take
   a compiler long).

   Compiled with RUN_TREE: for each joint its type (0 to 2: T1 to T3, 3 to 5: R1 to R3), its parent joint (0: the
   base), and the anchor point of the parent body where it is placed (0: the origin); and with RUN_LINK_ENDS: for
   each link, of its two ends, the last joint of the body, and the anchor point. */
#include <math.h>
#include <string.h>

#include "runtime.h"

static const struct {
    int type, parent, point;
} tree[RUN_JOINTS + 1] = {{0, 0, 0}, RUN_TREE};
static const struct {
    int joint[2], point[2];
} link_ends[RUN_LINKS + 1] = {{{0, 0}, {0, 0}}, RUN_LINK_ENDS};

/* Return the component i (1 to 3) of a x b. */
double cross(const double *a, const double *b, int i)
{
    const int j = i % 3 + 1, k = j % 3 + 1;

    return a[j] * b[k] - a[k] * b[j];
}

/* Move the origin of a frame by d, which is fixed in its body:

       P += d      V += OM x d      A += OMP x d + OM x (OM x d) */
static void shift_origin(MbsSensor *sensor, const double *d)
{
    double speed[4], acceleration[4];

    for (int i = 1; i <= 3; i++)
        speed[i] = cross(sensor->OM, d, i);
    for (int i = 1; i <= 3; i++)
        acceleration[i] = cross(sensor->OMP, d, i) + cross(sensor->OM, speed, i);
    for (int i = 1; i <= 3; i++) {
        sensor->P[i] += d[i];
        sensor->V[i] += speed[i];
        sensor->A[i] += acceleration[i];
    }
}

/* Move a frame from before a joint with the axis e to after it:

       R joint:  OM += e qd    OMP += e qdd +   OM x e qd
       T joint:  V  += e qd    A   += e qdd + 2 OM x e qd */
static void pass_joint(Run *run, int joint)
{
    const MbsData *data = &run->data;
    MbsSensor *sensor = &run->frame.sensor;
    const int point = tree[joint].point, rotates = tree[joint].type >= 3, e = tree[joint].type % 3 + 1;
    const int e2 = e % 3 + 1, e3 = e2 % 3 + 1;
    const double cosine = cos(data->q[joint]), sine = sin(data->q[joint]), *axis = sensor->R[e];
    double displacement[4], acceleration[4];

    for (int i = 1; i <= 3; i++) {
        displacement[i] = rotates ? 0.0 : axis[i] * data->q[joint];
        for (int k = 1; k <= 3 && point; k++)
            displacement[i] += sensor->R[k][i] * data->dpt[k][point];
        run->frame.jacobian[rotates ? 3 + i : i][joint] = axis[i];
    }
    shift_origin(sensor, displacement);
    memcpy(run->frame.joint_position[joint], sensor->P, sizeof sensor->P);
    for (int i = 1; i <= 3; i++)
        acceleration[i] = axis[i] * data->qdd[joint]
            + (rotates ? 1.0 : 2.0) * cross(sensor->OM, axis, i) * data->qd[joint];
    for (int i = 1; i <= 3; i++) {
        const double r2 = sensor->R[e2][i], r3 = sensor->R[e3][i];

        (rotates ? sensor->OM : sensor->V)[i] += axis[i] * data->qd[joint];
        (rotates ? sensor->OMP : sensor->A)[i] += acceleration[i];
        sensor->R[e2][i] = rotates ? cosine * r2 + sine * r3 : r2;
        sensor->R[e3][i] = rotates ? cosine * r3 - sine * r2 : r3;
    }
}

/* Compute the frame after a joint (0: of the base), with its Jacobian, and the lever to a point of the body.

   The column of an R joint at p with the axis e is (e x (P - p), e), that of a T joint is (e, 0). */
void compute_frame(Run *run, int joint, const double point[4])
{
    Frame *frame = &run->frame;
    MbsSensor *sensor = &frame->sensor;
    int chain[N_JOINTS + 1], n = 0;

    memset(sensor, 0, sizeof *sensor);
    memset(frame->jacobian, 0, sizeof frame->jacobian);
    for (int i = 0; i <= 6; i++)
        sensor->J[i] = frame->jacobian[i];
    for (int i = 1; i <= 3; i++)
        sensor->R[i][i] = 1.0;
    for (int j = joint; j; j = tree[j].parent)
        chain[n++] = j;
    for (int k = n - 1; k >= 0; k--)
        pass_joint(run, chain[k]);
    for (int k = 0; k < n; k++) {
        const int j = chain[k];
        const double e[4] = {0.0, frame->jacobian[4][j], frame->jacobian[5][j], frame->jacobian[6][j]};
        double joint_to_origin[4];

        for (int i = 1; i <= 3; i++)
            joint_to_origin[i] = sensor->P[i] - frame->joint_position[j][i];
        for (int i = 1; i <= 3; i++)
            frame->jacobian[i][j] += cross(e, joint_to_origin, i);
    }
    for (int i = 1; i <= 3; i++)
        frame->lever[i] = sensor->R[1][i] * point[1] + sensor->R[2][i] * point[2] + sensor->R[3][i] * point[3];
}

/* Compute dz/dq of the length z of a link between the points P1 and P2, by all joints (from 1):

       dz/dq = e . (dP2/dq - dP1/dq)      e = (P2 - P1) / |P2 - P1| */
void compute_link_direction(Run *run, int number, double *dz_dq)
{
    const MbsData *data = &run->data;
    const Frame *frame = &run->frame;
    double position[2][4], dP_dq[2][4][N_JOINTS + 1], e[4], length = 0.0;

    for (int end = 0; end < 2; end++) {
        const int k = link_ends[number].point[end];
        const double point[4] = {0.0, data->dpt[1][k], data->dpt[2][k], data->dpt[3][k]};

        compute_frame(run, link_ends[number].joint[end], point);
        for (int i = 1; i <= 3; i++)
            position[end][i] = frame->sensor.P[i] + frame->lever[i];
        for (int j = 1; j <= N_JOINTS; j++) {
            const double omega[4] = {0.0, frame->jacobian[4][j], frame->jacobian[5][j], frame->jacobian[6][j]};

            for (int i = 1; i <= 3; i++)
                dP_dq[end][i][j] = frame->jacobian[i][j] + cross(omega, frame->lever, i);
        }
    }
    for (int i = 1; i <= 3; i++) {
        e[i] = position[1][i] - position[0][i];
        length += e[i] * e[i];
    }
    length = sqrt(length);
    for (int j = 1; j <= N_JOINTS; j++) {
        dz_dq[j] = 0.0;
        for (int i = 1; i <= 3 && length > 0.0; i++)
            dz_dq[j] += e[i] / length * (dP_dq[1][i][j] - dP_dq[0][i][j]);
    }
}
