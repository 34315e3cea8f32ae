/* Check that the equations that a program was built with fit the .mbs that it loads.
 *
 * urdf2mbs writes this file, and those whose names begin like it, anew at each conversion: do not
 * edit them. */
#ifndef EQUATIONS_FIT_h
#define EQUATIONS_FIT_h

#ifdef __cplusplus
extern "C" {
#endif

/* Return 1 if the equations of this program fit the .mbs, or state no checksum; else print to
 * standard error which commands to run, and return 0. Call it before mbs_load: the rest of the
 * program finds joints, points and forces by their numbers, and another model may have fewer. */
int check_equations(const char *mbs_file);

#ifdef __cplusplus
}
#endif

#endif
