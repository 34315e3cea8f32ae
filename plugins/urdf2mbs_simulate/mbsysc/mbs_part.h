#include "mbs_data.h"
typedef struct { int rowperm, verbose; } MbsPartOptions;
typedef struct { MbsPartOptions *options; } MbsPart;
MbsPart* mbs_new_part(MbsData *mbs_data);
int mbs_run_part(MbsPart *part, MbsData *mbs_data);
void mbs_delete_part(MbsPart *part);
