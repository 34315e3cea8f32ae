/* The state of one simulation, and the functions that the files of the runtime share.

   Nothing in the runtime is global: each function gets a Run.  A user function gets the MbsData at the start
   of the Run, as in Robotran; run_of returns the Run of an MbsData.

   Compiled with RUN_JOINTS, RUN_FORCES, RUN_LINKS, RUN_LINKS3D, RUN_STATES, RUN_CUTS and RUN_USER_ROWS: the
   numbers of joints, external forces, links, 3D links, user states, equations of cuts, and equations of the
   user; and with RUN_DRIVEN: 1 if a joint is driven.  Arrays of Robotran count from 1: index 0 is not used. */
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

/* A force on a body for some time, in addition to those of the project.  A list of pushes ends with a push of
   the joint 0. */
typedef struct {
    int joint;          /* the last joint of the body */
    double point[4];    /* where the force acts, in the axes of the body (m) */
    double force[4];    /* in the axes of the base (N) */
    double start, stop; /* s */
} Push;

/* Functions of Python, which work on the arrays of MbsData and of the Run; NULL if there is none. */
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

/* frame.c: the motion of a body, in axes of the base. */
typedef struct {
    MbsSensor sensor;                       /* position, rotation and motion of the origin */
    double jacobian[7][N_JOINTS + 1];       /* of the origin: rows 1 to 3 of v, 4 to 6 of omega */
    double lever[4];                        /* from the origin to a point of the body (m) */
    double joint_position[N_JOINTS + 1][4]; /* of the joints in the chain of the body (m) */
} Frame;

/* partition.c: the joints and equations that are used, and the matrices of its equations. */
typedef struct {
    int n_dependent, n_independent, dependent[N_JOINTS + 1], independent[N_JOINTS + 1];
    int row[N_ROWS + 1];                        /* the numbers of the used equations, among all */
    double all_h[N_ROWS + 1], all_J[N_ROWS + 1][N_JOINTS + 1];
    double h[N_ROWS + 1], J[N_ROWS + 1][N_JOINTS + 1]; /* of the used equations */
    double LU[N_ROWS + 1][N_ROWS + 1];          /* of J_v, with the inverse of each pivot */
    int pivot_row[N_ROWS + 1];                  /* the row that was swapped with row k */
    double factorized_J[N_ROWS + 1][N_JOINTS + 1]; /* the J of LU */
    int is_factorized;                          /* 1: LU is that of factorized_J */
    int n_leaders, leader[N_JOINTS + 1];        /* the joints that the dependent ones follow */
    double B[N_ROWS + 1][N_JOINTS + 1];         /* columns of the leaders; column 0 is b */
    int has_B;                                  /* 1: B is that of factorized_J */
    double M[N_JOINTS + 1][N_JOINTS + 1], Q[N_JOINTS + 1];
    double A[N_JOINTS + 1][N_JOINTS + 1], qdd[N_JOINTS + 1]; /* M_uu and its factors; u'' */
} Partition;

/* turn.c: q, qd and qdd of the base in the axes of the state, and in those of the model. */
typedef struct {
    double state_axes[3][7], model_axes[3][7];
    double force[N_FORCES + 1][10]; /* of the external forces, in the axes of the state */
} Turn;

/* slopes.c: an external force on a body, or a link between two points.

   Its inputs are the coordinates x, dx/dt, and the states w_e; its outputs are the forces along x, then the rates
   of w_e.  The coordinates of a body are the displacement of its anchor point (m) and its rotation (rad), in axes
   of the base; that of a link is its length (m). */
typedef struct {
    int n_coordinates;
    int n_states, state[MAX_ELEMENT_STATES]; /* numbers of w_e among the user states, from 1 */
    double output[MAX_OUTPUTS];
    double derivative[MAX_INPUTS][MAX_OUTPUTS]; /* [i][o]: of the output o by the input i */
} ForceElement;

/* slopes.c: user_JointForces and user_Derivative together, as a function of q, qd and ux.

   Inputs q_1 ... q_n, qd_1 ... qd_n, ux_1 ... and outputs Qq_1 ... Qq_n, uxd_1 ... count from 0.  Inputs of one
   color change no output in common. */
typedef struct {
    char depends[N_JOINT_INPUTS + 1][N_JOINT_OUTPUTS + 1]; /* [i][o]: 1 if output o depends on input i */
    int n_outputs[N_JOINT_INPUTS + 1], output[N_JOINT_INPUTS + 1][N_JOINT_OUTPUTS + 1];
    int n_colors, color[N_JOINT_INPUTS + 1];
    double derivative[N_JOINT_INPUTS + 1][N_JOINT_OUTPUTS + 1]; /* of the outputs that are listed */
    char is_changed[N_JOINT_INPUTS + 1][N_JOINT_OUTPUTS + 1]; /* [color][o], while colors are chosen */
    char is_uncoupled[N_JOINTS + 1]; /* 1: the force of the joint depends on no other joint */
    int age;                         /* Jacobians that have used the pattern */
} JointSystem;

/* dq/du of a joint, by the unknowns that move it; or the unknown of a state, with 1. */
typedef struct {
    int n, unknown[MAX_UNKNOWNS];
    double value[MAX_UNKNOWNS];
} JointRow;

/* slopes.c: the matrices M, D, K and A, and what they are assembled of. */
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

/* steps.c: the state of the integrator. */
typedef struct {
    int stiffness_count;             /* grows with explicit steps at the limit of stability */
    int is_touched;                  /* 1: an external force acts at the start of the step */
    int jacobian_age;                /* steps that have used the Jacobian */
    double f_start[MAX_Y], f[MAX_Y]; /* dy/dt at the start of a step; as computed last */
    double stage[MAX_STAGES][MAX_Y]; /* U_i, or h f_i */
    double y_start[MAX_Y];           /* the state at the start of a step */
    double largest_state[N_STATES + 1]; /* the largest absolute value of each user state so far */
} Steps;

/* An integration from the state y at t to the time end; Python, or the page, sets it up. */
typedef struct {
    double t, h;                     /* the time of y; the length of the next step (s) */
    double end, max_step;            /* s */
    double rtol, atol;
    int max_steps, calls_loop;       /* in one call of advance; 1: the user's loop is called after each */
    double *y;
    const double *frame_time;        /* of the frames after t */
    int n_frames, n_passed;          /* how many there are, and how many the last step has passed */
    double *frame_y;                 /* the state at each frame that was passed */
} Integration;

/* Python uses the members up to the line: see RunInC of memory.py. */
typedef struct {
    MbsData data; /* first: see run_of */
    Hooks hooks;
    const Push *pushes;
    const int *last_joint;           /* of the body of each external force; 0: of the base */
    double *user_h, *user_jdqd, *user_J; /* the constraints of the user, which Python fills */
    const double *state_scale;       /* of each user state: its absolute tolerance divided by atol */
    MbsSensor point;                 /* the motion of the point whose force Python computes */
    MbsDirdyn dirdyn;
    double damping;                  /* against each speed, relative to its mass (1/s): see equilibrium.py */
    int is_time_frozen;              /* 1: user code sees a constant time, that of the data */
    int can_turn, is_turned;         /* 1: the base may change its axes; is in turned axes (turn.c) */
    double shown_angles[3];          /* of the base in the model's axes, as shown last */
    int is_recording;                /* 1: values that user code gives to set_output are recorded */
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

static inline Run *run_of(MbsData *data)
{
    return (Run *) data;
}

/* runtime.c */
size_t get_run_size(void);
void initialize_run(Run *run);
int accelerate(Run *run, double t, const double *y, double *f);
void compute_anchor_frame(Run *run, int number);
void compute_external_force(Run *run, int number, const double *motion, double *force);
void call_loop(Run *run);

/* frame.c */
void compute_frame(Run *run, int joint, const double point[4]);
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
void run_cons_hJ(double *h, double **J, MbsData *data, double tsim);
void run_cons_jdqd(double *jdqd, MbsData *data, double tsim);
double *run_JointForces(MbsData *data, double tsim);
void run_Derivative(Run *run);
void run_DrivenJoints(MbsData *data, double tsim);
double run_LinkForces(double Z, double Zd, MbsData *data, double tsim, int number);
double *run_Link3DForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                         double OMP[4], MbsData *data, double tsim, int number);
double *run_ExtForces(double P[4], double R[4][4], double V[4], double OM[4], double A[4],
                      double OMP[4], MbsData *data, double tsim, int number);

/* hooks.c: set the Run whose user code this thread runs: set_output has no argument for it. */
void enter_user_code(Run *run);

/* the equations */
void mbs_invdyna(double *phi, MbsData *data, double tsim);
void mbs_dirdyna(double **M, double *c, MbsData *data, double tsim);
#endif
