#include "mbs_data.h"
void mbs_set_nb_userc(MbsData *mbs_data, int count);
