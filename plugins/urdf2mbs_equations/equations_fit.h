/* Whether the equations that a program was built with fit the .mbs that it loads.
 *
 * urdf2mbs writes this file, and those whose names begin like it, anew at each conversion: do not
 * edit them. */
#ifndef EQUATIONS_FIT_h
#define EQUATIONS_FIT_h

#ifdef __cplusplus
extern "C" {
#endif

/* 1 if the equations of this program fit the .mbs, or do not say what they fit; else 0, and
 * standard error says which commands to run. Call it before mbs_load: the rest of the program finds joints,
 * points and forces by their numbers, and another model may have fewer. */
int check_equations(const char *mbs_file);

#ifdef __cplusplus
}
#endif

#endif
