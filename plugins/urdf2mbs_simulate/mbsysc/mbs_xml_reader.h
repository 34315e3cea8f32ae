#ifndef MBS_XML_READER_h
#define MBS_XML_READER_h
typedef struct { char *name; int type, n_value; double *value_list; } MDS_parameter_strct;
typedef struct {
    char *name;
    int n_parameter;
    MDS_parameter_strct **parameter_list;
} MDS_user_model_strct;
typedef struct { int n_user_model; MDS_user_model_strct **user_model_list; } MDS_user_models_strct;
typedef struct { MDS_user_models_strct *user_models; } MDS_gen_strct;
#endif
