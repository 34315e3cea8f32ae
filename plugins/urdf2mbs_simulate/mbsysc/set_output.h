#ifndef SET_OUTPUT_h
#define SET_OUTPUT_h
void set_output(double value, const char *name);
#endif
