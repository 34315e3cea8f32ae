#ifndef MBS_EQUIL_STRUCT_h
#define MBS_EQUIL_STRUCT_h
typedef struct MbsEquil { int none; } MbsEquil;
#endif
