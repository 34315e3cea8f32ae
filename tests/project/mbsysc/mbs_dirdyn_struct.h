#ifndef MBS_DIRDYN_STRUCT_h
#define MBS_DIRDYN_STRUCT_h
typedef struct MbsDirdynOptions {
    double t0, tf, dt0;
    int save2file;
    char *respath, *animpath;
} MbsDirdynOptions;
typedef struct MbsDirdyn { MbsDirdynOptions *options; } MbsDirdyn;
#endif
