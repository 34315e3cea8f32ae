/* What the parts of the runtime have of each other. */
#ifndef RUNTIME_h
#define RUNTIME_h
#include "mbs_data.h"
#include "mbs_project_interface.h"
#include "mbs_sensor.h"

/* A force on a body for a while, beside those of the project: the joint before the body, the point in its
   axes (m), and the force in the axes of the base (N).  The last has the joint 0. */
typedef struct {
    int joint;
    double at[4], force[4], start, stop;
} Push;
extern Push *pushes;

/* frame.c: the motion behind a joint, with its Jacobian, and the way to a point of the body, as found last. */
extern MbsSensor frame;
extern double arm[4];
void find_frame(const MbsData *s, int joint, const double at[4]);
double cross(const double *a, const double *b, int i);

extern MbsDirdyn dirdyn;
int accelerate(MbsData *s, double t, const double *y, double *f);
extern int last_joint[];
void find_body(MbsData *s, int number);
void find_force(MbsData *s, int number, const double *motion, double *force);
void call_loop(MbsData *s);

/* slopes.c */
int find_states(MbsData *s);
int any_begins(const MbsData *s);
void take_slopes(MbsData *s);
void solve(const MbsData *s, double h, const double *g, double *u);

/* steps.c */
int begin_steps(MbsData *s);
int advance(MbsData *s, double *t, double end, double *h, double most, double *y, double rtol,
            double atol, int count, int loops);

/* partition.c */
void set_partition(MbsData *s, const int *rows);
int kept_accelred(MbsData *s, double tsim);
const double *mass_row(int joint, double *force);
void find_leads(int joint, double *leads);

/* turn.c */
extern int can_turn, turned;
extern double own_angles[3];
int turn_if_near(const MbsData *s, double *y);
void turn_force(double *force);
void show_base(MbsData *s);
void hide_base(MbsData *s);
double *run_JointForces(MbsData *s, double tsim);
double *run_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                      double OMP[4], MbsData *s, double tsim, int number);

/* the equations */
void mbs_invdyna(double *phi, MbsData *s, double tsim);
#endif
