#include "mbs_data.h"
#include "mbs_dirdyn_struct.h"
MbsDirdyn* mbs_new_dirdyn(MbsData *mbs_data);
int mbs_run_dirdyn(MbsDirdyn *dirdyn, MbsData *mbs_data);
void mbs_delete_dirdyn(MbsDirdyn *dirdyn, MbsData *mbs_data);
