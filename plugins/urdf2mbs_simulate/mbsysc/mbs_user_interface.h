#ifndef MBS_USER_INTERFACE_h
#define MBS_USER_INTERFACE_h
typedef struct UserModel UserModel;
typedef struct { int n_in, n_out; } UserIoInfo;
typedef struct UserIO UserIO;
UserModel* mbs_new_user_model();
void mbs_delete_user_model(UserModel *um);
UserIO* mbs_new_user_IO(UserIoInfo *ioInfo);
void mbs_delete_user_IO(UserIO *uvs);
#endif
