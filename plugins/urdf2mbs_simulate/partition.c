/* accelred with the partition of MbsData, which is chosen while a simulation runs.

   RUN_FACTS are those of the model.  The constraints are all of the cuts and of the user, those that
   are kept first. */
#include <math.h>
#include <string.h>

#include "mbs_data.h"

enum {JOINTS = RUN_JOINTS, ROWS = RUN_CUTS + RUN_USER_ROWS, CUTS = ROWS > 0, USER_ROWS = 0};
enum {RUN_FACTS};

static int DEPENDENT, INDEPENDENT, dependent[JOINTS + 1], independent[JOINTS + 1], kept[ROWS + 1];
static double every_h[ROWS + 1], every_jac[ROWS + 1][JOINTS + 1];

void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);
void mbs_cons_jdqd(double *jdqd, MbsData *s, double tsim);
void user_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);
void user_cons_jdqd(double *jdqd, MbsData *s, double tsim);

/* The constraints at the present position. */
void constrain(MbsData *s, double *h, double **Jac)
{
#if RUN_CUTS
    mbs_cons_hJ(h, Jac, s, s->tsim);
#endif
#if RUN_USER_ROWS
    user_cons_hJ(h + RUN_CUTS, Jac + RUN_CUTS, s, s->tsim);
#endif
    (void) s, (void) h, (void) Jac;
}

void kept_hJ(double *h, double **Jac, MbsData *s, double tsim)
{
    double *rows[ROWS + 1];

    (void) tsim;
    for (int i = 0; i <= ROWS; i++)
        rows[i] = every_jac[i];
    memset(every_jac, 0, sizeof every_jac);
    constrain(s, every_h, rows);
    for (int i = 1; i <= DEPENDENT; i++) {
        h[i] = every_h[kept[i]];
        memcpy(Jac[i], every_jac[kept[i]], sizeof every_jac[0]);
    }
}

void kept_jdqd(double *jdqd, MbsData *s, double tsim)
{
#if RUN_CUTS
    mbs_cons_jdqd(every_h, s, tsim);
#endif
#if RUN_USER_ROWS
    user_cons_jdqd(every_h + RUN_CUTS, s, tsim);
#endif
    for (int i = 1; i <= DEPENDENT; i++)
        jdqd[i] = every_h[kept[i]];
}

#define mbs_accelred kept_accelred
#define mbs_cons_hJ kept_hJ
#define mbs_cons_jdqd kept_jdqd
#include "accelred.c" /* its sections, put here before this is compiled */

/* Take the joints of MbsData, and as many rows as there are dependent joints. */
void set_partition(MbsData *s, const int *rows)
{
    DEPENDENT = s->nqv;
    INDEPENDENT = s->nqu;
    memcpy(dependent, s->qv, (DEPENDENT + 1) * sizeof *dependent);
    memcpy(independent, s->qu, (INDEPENDENT + 1) * sizeof *independent);
    memcpy(kept + 1, rows, DEPENDENT * sizeof *kept);
    factored[0][0] = 1.0;
    known = 0;
}

/* What accelred has solved: the row of the mass matrix of an independent joint, and its force. */
const double *mass_row(int joint, double *force)
{
    *force = Q[joint];
    return M[joint];
}

/* How a joint moves with the independent ones, from 0. */
void find_leads(int joint, double *leads)
{
    for (int u = 1; u <= INDEPENDENT; u++)
        leads[u - 1] = independent[u] == joint;
    for (int i = 1; i <= DEPENDENT; i++)
        for (int j = 1; j <= leaders && dependent[i] == joint; j++)
            for (int u = 1; u <= INDEPENDENT; u++)
                if (independent[u] == leader[j])
                    leads[u - 1] = B[i][j];
}
