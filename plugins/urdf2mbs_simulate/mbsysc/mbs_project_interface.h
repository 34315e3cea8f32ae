#include "mbs_data.h"
#include "mbs_dirdyn_struct.h"
/* nested /* comments, /* as the real one has them */
void user_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);
void user_cons_jdqd(double *jdqd, MbsData *s, double tsim);
void user_Derivative(MbsData *s);
void user_DrivenJoints(MbsData *s, double tsim);
double* user_ExtForces(double PxF[4], double RxF[4][4], double VxF[4], double OMxF[4],
    double AxF[4], double OMPxF[4], MbsData *s, double tsim, int ixF);
double* user_JointForces(MbsData *s, double tsim);
double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int ilnk);
double* user_Link3DForces(double PxF[4], double RxF[4][4], double VxF[4], double OMxF[4],
    double AxF[4], double OMPxF[4], MbsData *s, double tsim, int ixF);
void user_dirdyn_init(MbsData *s, MbsDirdyn *mbs_dd);
void user_dirdyn_loop(MbsData *s, MbsDirdyn *mbs_dd);
void user_dirdyn_finish(MbsData *s, MbsDirdyn *mbs_dd);
void mbs_sensor(MbsSensor *sens, MbsData *s, int isens);
