#ifndef MBS_SENSOR_h
#define MBS_SENSOR_h
typedef struct MbsSensor {
    double P[4], R[4][4], V[4], OM[4], A[4], OMP[4];
    double *J[7];
} MbsSensor;
#endif
