#ifndef MBS_DIRDYN_STRUCT_h
#define MBS_DIRDYN_STRUCT_h
#include "mbs_sensor.h"
typedef struct MbsDirdynOptions {
    double t0, tf, dt0;
    int save2file, saveperiod, framerate;
    char *respath, *animpath;
} MbsDirdynOptions;
typedef struct MbsAux { MbsSensor *psens; } MbsAux;
typedef struct MbsDirdyn { MbsDirdynOptions *options; MbsAux *mbs_aux; } MbsDirdyn;
#endif
