/* The state of one simulation, and what the files of the runtime call of each other.

   Nothing in the runtime is global: each function gets a Run.  A user function gets the MbsData that a Run
   begins with, as in Robotran; run_of finds the Run again.

   Compiled with RUN_JOINTS, RUN_FORCES, RUN_LINKS, RUN_LINKS3D, RUN_STATES, RUN_CUTS and RUN_USER_ROWS: the
   numbers of joints, external forces, links, 3D links, user states, equations of cuts, and equations of the
   user; and with RUN_DRIVEN: 1 if a joint is driven.  Arrays of Robotran's count from 1. */
#ifndef RUNTIME_h
#define RUNTIME_h
#include <stddef.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"
#include "mbs_sensor.h"

enum {
    N_JOINTS = RUN_JOINTS,
    N_FORCES = RUN_FORCES,
    N_LINKS = RUN_LINKS,
    N_LINKS3D = RUN_LINKS3D,
    N_STATES = RUN_STATES,
    N_CUT_ROWS = RUN_CUTS,
    N_USER_ROWS = RUN_USER_ROWS,
    N_ROWS = N_CUT_ROWS + N_USER_ROWS,
    ANY_DRIVEN = RUN_DRIVEN,
    MAX_Y = 2 * N_JOINTS + N_STATES + 1,     /* of the state y = (q, u, w) */
    MAX_UNKNOWNS = N_JOINTS + N_STATES + 1,  /* of (u, w) */
    MAX_COORDINATES = 6,                     /* of a body */
    MAX_ELEMENT_STATES = N_STATES < 16 ? N_STATES + 1 : 16,
    MAX_OUTPUTS = MAX_COORDINATES + MAX_ELEMENT_STATES,
    MAX_INPUTS = 2 * MAX_COORDINATES + MAX_ELEMENT_STATES,
    N_JOINT_INPUTS = 2 * N_JOINTS + N_STATES, /* q, qd and ux */
    N_JOINT_OUTPUTS = N_JOINTS + N_STATES,    /* Qq and uxd */
    MAX_STAGES = 7
};

/* A force on a body for a while, beside those of the project: the joint before the body, the point in its
   axes (m), and the force in the axes of the base (N).  The last has the joint 0. */
typedef struct {
    int joint;
    double at[4], force[4], start, stop;
} Push;

/* Functions of Python: each works on the arrays of MbsData and of the Run, and 0 is none. */
typedef struct {
    void (*output)(double value, const char *name);
    void (*joint_forces)(double t);
    void (*driven_joints)(double t);
    void (*derivative)(double t);
    void (*ext_forces)(double t, int number);
    void (*link_3d_forces)(double t, int number);
    double (*link_force)(double z, double zd, double t, int number);
    void (*cons_hJ)(double t);
    void (*cons_jdqd)(double t);
} Hooks;

/* frame.c: the motion of a body and its Jacobian, and the lever from its origin to a point of the body. */
typedef struct {
    MbsSensor sensor;
    double jacobian[7][N_JOINTS + 1];
    double lever[4];
    double joint_position[N_JOINTS + 1][4]; /* of the joints in the chain of the body (m) */
} Frame;

/* partition.c: the joints and equations that accelred works with, and its matrices. */
typedef struct {
    int n_dependent, n_independent, dependent[N_JOINTS + 1], independent[N_JOINTS + 1];
    int row[N_ROWS + 1];                        /* the numbers of the equations that are used, among all */
    double all_h[N_ROWS + 1], all_J[N_ROWS + 1][N_JOINTS + 1];
    double h[N_ROWS + 1], J[N_ROWS + 1][N_JOINTS + 1];
    double LU[N_ROWS + 1][N_ROWS + 1];          /* of J_v, with the inverse of each pivot */
    double factorized_J[N_ROWS + 1][N_JOINTS + 1]; /* the J that LU was made of */
    int swapped[N_ROWS + 1];
    int n_leaders, leader[N_JOINTS + 1];        /* the joints that the dependent ones follow */
    int is_factorized, has_B;
    double B[N_ROWS + 1][N_JOINTS + 1];         /* qdd_v = B qdd_leaders + column 0 of B */
    double M[N_JOINTS + 1][N_JOINTS + 1], Q[N_JOINTS + 1];
    double A[N_JOINTS + 1][N_JOINTS + 1], qdd[N_JOINTS + 1];
} Partition;

/* turn.c: q, qd and qdd of the base in the axes of the state, and in those of the model. */
typedef struct {
    double state_axes[3][7], model_axes[3][7];
    double force[N_FORCES + 1][10]; /* of the external forces, in the axes of the state */
} Turn;

/* slopes.c: an external force on a body, or a link between two points.

   Inputs are its coordinates x, dx/dt, and its states w_e; outputs are the forces along x, then the rates of
   w_e.  The coordinates of a body are the displacement of its anchor point (m) and its rotation (rad), in axes
   of the base; that of a link is its length (m). */
typedef struct {
    int n_coordinates;
    int n_states, state[MAX_ELEMENT_STATES]; /* numbers of w_e among the user states, from 1 */
    double output[MAX_OUTPUTS];
    double derivative[MAX_INPUTS][MAX_OUTPUTS]; /* [i][o]: of output o by input i */
} ForceElement;

/* slopes.c: user_JointForces and user_Derivative together, as a function of q, qd and ux.

   Inputs and outputs count from 0: q_1 ... q_n, qd_1 ... qd_n, ux_1 ...; Qq_1 ... Qq_n, uxd_1 ...  Inputs of one
   color change no output in common. */
typedef struct {
    char depends[N_JOINT_INPUTS + 1][N_JOINT_OUTPUTS + 1]; /* [i][o] */
    int n_outputs[N_JOINT_INPUTS + 1], output[N_JOINT_INPUTS + 1][N_JOINT_OUTPUTS + 1];
    int n_colors, color[N_JOINT_INPUTS + 1];
    double derivative[N_JOINT_INPUTS + 1][N_JOINT_OUTPUTS + 1]; /* of the outputs that are listed */
    char is_used[N_JOINT_INPUTS + 1][N_JOINT_OUTPUTS + 1]; /* [color][o], while colors are chosen */
    char is_alone[N_JOINTS + 1]; /* 1: the force of the joint depends on no other joint */
    int age;                     /* how often the pattern has served */
} JointSystem;

/* The unknowns that move a joint, with dq/du; or the unknown of a state. */
typedef struct {
    int n, unknown[MAX_UNKNOWNS];
    double value[MAX_UNKNOWNS];
} JointRow;

typedef struct {
    ForceElement body[N_FORCES + 1], link[N_LINKS + 1]; /* from 1 */
    JointSystem joints;
    JointRow joint_row[N_JOINT_OUTPUTS + 1];
    char has_body[N_FORCES + 1];        /* 1: the external force acted when the Jacobian was computed */
    int body_of_state[N_STATES + 1];    /* the external force that sets the rate of a state; 0: none */
    /* The unknowns are the rates of the independent joints, then those of the states of the elements. */
    int n_unknowns, state_of_unknown[MAX_UNKNOWNS], unknown_of_state[N_STATES + 1];
    double M[MAX_UNKNOWNS][MAX_UNKNOWNS], D[MAX_UNKNOWNS][MAX_UNKNOWNS];
    double K[MAX_UNKNOWNS][MAX_UNKNOWNS];    /* the columns of states are 0 */
    double A[MAX_UNKNOWNS][MAX_UNKNOWNS];    /* M - h D - h^2 K, then its factors U and L */
    double factorized_h;                     /* the h of A; 0 if A is not factorized */
    /* The columns j < k of row k that are not 0; by symmetry of the pattern, also the rows of column k. */
    int n_nonzero[MAX_UNKNOWNS], nonzero_column[MAX_UNKNOWNS][MAX_UNKNOWNS];
    char is_nonzero[MAX_UNKNOWNS][MAX_UNKNOWNS]; /* [k][j], for j < k */
} Jacobian;

/* steps.c */
typedef struct {
    int stiffness_count;             /* explicit steps that were as long as is stable, less those that were not */
    int is_touched;                  /* 1: an external force acts at the start of the step */
    int jacobian_age;                /* steps that the Jacobian has served for */
    double f_start[MAX_Y], f[MAX_Y]; /* dy/dt at the start of a step, and as computed last */
    double stage[MAX_STAGES][MAX_Y]; /* U_i, or h f_i */
    double y_start[MAX_Y];           /* the state at the start of a step */
    double largest_state[N_STATES + 1];
} Steps;

/* From a state y at t to the time end; Python, or the page, sets what is not computed. */
typedef struct {
    double t, h;                     /* h: the length of the next step (s) */
    double end, longest_step;
    double rtol, atol;
    int most_steps, calls_loop;
    double *y;
    const double *frame_time;        /* of the frames that are still to come */
    int n_frames, n_passed;          /* how many there are, and how many the last step has passed */
    double *frame_y;                 /* the state at each frame that was passed */
} Integration;

/* Python knows the members up to the line. */
typedef struct {
    MbsData data; /* first: see run_of */
    Hooks hooks;
    const Push *pushes;
    const int *last_joint;           /* of the body of each external force; 0: of the base */
    double *user_h, *user_jdqd, *user_J; /* what Python fills for the constraints of the user */
    const double *state_scale;       /* of each user state: its absolute tolerance in parts of atol */
    MbsSensor point;                 /* the point of the force that Python is asked for */
    MbsDirdyn dirdyn;
    double damping;                  /* against each speed, in parts of its mass (1/s): see equilibrium.py */
    int is_time_frozen;              /* 1: user code sees the time of the data, whatever time a step is at */
    int can_turn, is_turned;         /* whether the base may go on, and is, in turned axes */
    double shown_angles[3];          /* of the base in the model's axes, as they were shown last */
    int is_recording;                /* 1: what user code gives to set_output is kept */
    /* ------------------------------------------------------------------------------------------------ */
    Frame frame;
    Partition partition;
    Turn turn;
    Jacobian jacobian;
    Steps steps;
    MbsSensor loop_sensor;
    MbsAux loop_aux;
    MbsDirdynOptions loop_options;
    double zeros[N_JOINTS + 1];
} Run;

static inline Run *run_of(MbsData *s)
{
    return (Run *) s;
}

/* runtime.c */
size_t get_run_size(void);
void initialize_run(Run *run);
int accelerate(Run *run, double t, const double *y, double *f);
void compute_anchor_frame(Run *run, int number);
void compute_external_force(Run *run, int number, const double *motion, double *force);
void call_loop(Run *run);

/* frame.c */
void compute_frame(Run *run, int joint, const double at[4]);
double cross(const double *a, const double *b, int i);
void compute_link_direction(Run *run, int number, double *dz_dq);

/* partition.c */
void set_partition(Run *run, const int *rows);
void compute_constraints(Run *run, double *h, double **J);
int compute_accelerations(Run *run);
void compute_dq_du(const Run *run, int joint, double *dq_du);

/* elements.c */
double get_state_difference(const Run *run, int state, double atol);
void find_body_states(Run *run, int number);
void differentiate_external_force(Run *run, int number, double atol);
void differentiate_link(Run *run, int number);

/* joint_system.c */
void find_joint_pattern(Run *run, double atol);
void differentiate_joint_system(Run *run, double atol);

/* slopes.c */
void prepare_jacobian(Run *run, double atol);
int any_force_acts(const Run *run);
int any_force_begins(const Run *run);
void update_jacobian(Run *run, double atol);

/* linear_system.c */
void list_nonzeros(Jacobian *jacobian);
void solve_stage(Run *run, double h, const double *g, double *k);

/* steps.c */
void begin_steps(Run *run, double atol);
int advance(Run *run, Integration *integration);

/* turn.c */
int turn_if_near(Run *run, double *y);
void turn_force(const Run *run, double *force);
void show_model_axes(Run *run);
void hide_model_axes(Run *run);
void show_joint_forces(Run *run);
void run_cons_hJ(double *h, double **J, MbsData *s, double tsim);
void run_cons_jdqd(double *jdqd, MbsData *s, double tsim);
double *run_JointForces(MbsData *s, double tsim);
void run_Derivative(Run *run);
void run_DrivenJoints(MbsData *s, double tsim);
double run_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number);
double *run_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                         double OMP[4], MbsData *s, double tsim, int number);
double *run_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                      double OMP[4], MbsData *s, double tsim, int number);

/* hooks.c: the Run whose user code this thread runs, for set_output, which is told no MbsData. */
void enter_user_code(Run *run);

/* the equations */
void mbs_invdyna(double *phi, MbsData *s, double tsim);
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);
#endif
