/* Declarations of our own, with the names that MBsysC's equations and user functions use. */
#ifndef MBS_DATA_h
#define MBS_DATA_h
#include "mbs_user_interface.h"

typedef struct MbsData {
    int njoint, process, flag_stop;
    double *q, *qd, *qdd, *q0, *Qq, *Qc, *ux, *uxd;
    double *dpt[4];
    int *xfidpt;
    double **SWr, **l3DWr;
    double g[4];
    UserModel *user_model;
    int DonePart;
    double tsim;
    double *m, *lrod, *Z, *Zd, *Fl;
    double **l, **In, **frc, **trq;
    int nqu, nqv, Nux, *qu, *qv;
    double *guess; /* of the dependent joints: where Newton's method starts, from index 0 */
    double *qd0, *Lambda;
} MbsData;

void mbs_delete_data(MbsData *mbs_data);
#endif
