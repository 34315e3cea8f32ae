#include "mbs_data.h"
#include "mbs_xml_reader.h"
MbsData* mbs_load(const char *file, const char *build);
void mbs_load_user_model_xml(MDS_gen_strct *gen, UserModel *um);
