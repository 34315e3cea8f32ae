"""``accelred`` in C: sets driven joints and forces, closes loops, solves for accelerations."""

from __future__ import annotations

from urdf2mbs.equations.c_names import PARAMETERS, declarations
from urdf2mbs.equations.loops import Loops
from urdf2mbs.mbs.model import Mbs

#: The last lines of accelred; what comes before sets forces.
ACCELRED = """\
int mbs_accelred(MbsData *s, double tsim)
{
    set_driven(s, tsim);
    set_forces(s, tsim);
    accelerations(s);
    return 0;
}
"""


def prelude(mbs: Mbs) -> str:
    """The functions that set driven joints and all forces, as Robotran's library does."""
    joints = [joint for body in mbs.bodies for joint in body.joints]
    kinds = {link.kind for link in mbs.links}
    extforce = any(point.extforce for body in mbs.bodies for point in body.points)
    driven = any(joint.nature == "driven" for joint in joints)
    functions = ["user_JointForces", *(["user_DrivenJoints"] if driven else [])]
    text = declarations(functions)
    lines = [f"for (int i = 1; i <= {len(joints)}; i++) {{", "    for (int k = 1; k <= 3; k++) {"]
    lines += ["        s->frc[k][i] = 0.0;", "        s->trq[k][i] = 0.0;", "    }", "}"]
    pair = "double **frc, double **trq"
    if "link" in kinds:
        text += f"void mbs_link({PARAMETERS['link']});\n"
        lines.append("mbs_link(s->frc, s->trq, s->Fl, s->Z, s->Zd, s, tsim);")
    if "link3D" in kinds:
        text += f"void mbs_link3D({pair}, MbsData *s, double tsim);\n"
        lines.append("mbs_link3D(s->frc, s->trq, s, tsim);")
    if extforce:
        text += f"void mbs_extforces({pair}, MbsData *s, double tsim);\n"
        lines.append("mbs_extforces(s->frc, s->trq, s, tsim);")
    lines.append("USER(JointForces)(s, tsim);")
    text += "\nstatic void set_driven(MbsData *s, double tsim)\n{\n"
    text += "    USER(DrivenJoints)(s, tsim);\n}\n" if driven else "    (void) s, (void) tsim;\n}\n"
    text += "\nstatic void set_forces(MbsData *s, double tsim)\n{\n"
    return text + "".join(f"    {line}\n" for line in lines) + "}\n\n"


#: For a function that is not generated.
REFUSED = """\
int mbs_accelred(MbsData *s, double tsim)
{
    (void) tsim;
    s->flag_stop = 1;
    return -1;
}
"""


def closed(loops: Loops) -> str:
    def table(name: str, numbers: list[int]) -> str:
        listed = ", ".join(str(number) for number in [0, *numbers])
        return f"static const int {name}[] = {{{listed}}};\n"

    text = "#include <stdlib.h>\n\n"
    text += "void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);\n"
    text += "void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);\n"
    text += "void mbs_cons_jdqd(double *Jdqd, MbsData *s, double tsim);\n"
    if loops.user:
        text += "void USER(cons_hJ)(double *h, double **Jac, MbsData *s, double tsim);\n"
        text += "void USER(cons_jdqd)(double *jdqd, MbsData *s, double tsim);\n"
    text += "\n/* numbers of the joints, the first of each list not being used */\n"
    text += table("dependent", loops.dependent)
    text += table("independent", loops.independent)
    text += table("driven", loops.driven)
    sizes = {
        "JOINTS": loops.joints, "DEPENDENT": len(loops.dependent),
        "INDEPENDENT": len(loops.independent), "DRIVEN": len(loops.driven), "CUTS": loops.cuts,
    }  # fmt: skip
    text += f"enum {{{', '.join(f'{name} = {size}' for name, size in sizes.items())}}};\n\n"
    user = USER_CONSTRAINTS if loops.user else ("", "")
    return text + LOOPS.replace("@HJ@", user[0]).replace("@JDQD@", user[1])


#: What the user's own constraints add; their rows follow those of the cuts.
USER_CONSTRAINTS = (
    "    USER(cons_hJ)(h + CUTS, Jac + CUTS, s, tsim);\n",
    "    USER(cons_jdqd)(jdqd + CUTS, s, tsim);\n",
)

LOOPS = """\
static double **table(int rows, int columns)
{
    double **t = malloc((rows + 1) * sizeof *t);
    t[0] = calloc((rows + 1) * (columns + 1), sizeof **t);
    for (int i = 1; i <= rows; i++)
        t[i] = t[0] + i * (columns + 1);
    return t;
}

static void release(double **t)
{
    free(t[0]);
    free(t);
}

/* Gauss with row pivots: a x = b for several b, the columns of x; a is lost. 0 if solved. */
static int solve(double **a, int n, double **x, int columns)
{
    for (int k = 1; k <= n; k++) {
        int p = k;
        for (int i = k + 1; i <= n; i++)
            if (fabs(a[i][k]) > fabs(a[p][k]))
                p = i;
        if (!(fabs(a[p][k]) > 1e-14))
            return -1;
        double *row = a[k], *other = x[k];
        a[k] = a[p], a[p] = row;
        x[k] = x[p], x[p] = other;
        for (int i = k + 1; i <= n; i++) {
            double f = a[i][k] / a[k][k];
            for (int j = k; j <= n; j++)
                a[i][j] -= f * a[k][j];
            for (int j = 1; j <= columns; j++)
                x[i][j] -= f * x[k][j];
        }
    }
    for (int k = n; k >= 1; k--)
        for (int j = 1; j <= columns; j++) {
            for (int i = k + 1; i <= n; i++)
                x[k][j] -= a[k][i] * x[i][j];
            x[k][j] /= a[k][k];
        }
    return 0;
}

static void constraints(double *h, double **Jac, MbsData *s, double tsim)
{
    for (int i = 0; i <= DEPENDENT; i++)
        for (int j = 0; j <= JOINTS; j++)
            Jac[i][j] = 0.0;
    mbs_cons_hJ(h, Jac, s, tsim);
@HJ@}

static void derivative(double *jdqd, MbsData *s, double tsim)
{
    mbs_cons_jdqd(jdqd, s, tsim);
@JDQD@}

/* The columns of the dependent joints. */
static void square(double **Jac, double **Jv)
{
    for (int i = 1; i <= DEPENDENT; i++)
        for (int j = 1; j <= DEPENDENT; j++)
            Jv[i][j] = Jac[i][dependent[j]];
}

int mbs_accelred(MbsData *s, double tsim)
{
    double **Jac = table(DEPENDENT, JOINTS), **Jv = table(DEPENDENT, DEPENDENT);
    double **x = table(DEPENDENT, 1), **B = table(DEPENDENT, INDEPENDENT + 1);
    double **M = table(JOINTS, JOINTS), **T = table(JOINTS, INDEPENDENT);
    double **A = table(INDEPENDENT, INDEPENDENT), **y = table(INDEPENDENT, 1);
    double *h = calloc(DEPENDENT + 1, sizeof *h), *c = calloc(JOINTS + 1, sizeof *c);
    double *g = calloc(JOINTS + 1, sizeof *g), *r = calloc(JOINTS + 1, sizeof *r);
    int failed = -1;

    set_driven(s, tsim);
    for (int turn = 0; turn < 100; turn++) {
        double largest = 0.0;
        constraints(h, Jac, s, tsim);
        for (int i = 1; i <= DEPENDENT; i++)
            largest = fabs(h[i]) <= largest ? largest : fabs(h[i]);
        if (largest < 1e-9) {
            failed = 0;
            break;
        }
        square(Jac, Jv);
        for (int i = 1; i <= DEPENDENT; i++)
            x[i][1] = -h[i];
        if (solve(Jv, DEPENDENT, x, 1))
            break;
        for (int i = 1; i <= DEPENDENT; i++)
            s->q[dependent[i]] += x[i][1];
    }
    if (failed)
        goto end;

    for (int i = 1; i <= DEPENDENT; i++)
        s->qd[dependent[i]] = 0.0;
    for (int i = 1; i <= DEPENDENT; i++) {
        x[i][1] = 0.0;
        for (int j = 1; j <= JOINTS; j++)
            x[i][1] -= Jac[i][j] * s->qd[j];
    }
    square(Jac, Jv);
    failed = solve(Jv, DEPENDENT, x, 1);
    if (failed)
        goto end;
    for (int i = 1; i <= DEPENDENT; i++)
        s->qd[dependent[i]] = x[i][1];

    derivative(h, s, tsim);
    for (int i = 1; i <= DEPENDENT; i++) {
        B[i][INDEPENDENT + 1] = -h[i];
        for (int j = 1; j <= DRIVEN; j++)
            B[i][INDEPENDENT + 1] -= Jac[i][driven[j]] * s->qdd[driven[j]];
        for (int j = 1; j <= INDEPENDENT; j++)
            B[i][j] = -Jac[i][independent[j]];
    }
    square(Jac, Jv);
    failed = solve(Jv, DEPENDENT, B, INDEPENDENT + 1);
    if (failed)
        goto end;

    set_forces(s, tsim);
    mbs_dirdyna(M, c, s, tsim);
    for (int j = 1; j <= INDEPENDENT; j++) {
        T[independent[j]][j] = 1.0;
        for (int i = 1; i <= DEPENDENT; i++)
            T[dependent[i]][j] = B[i][j];
    }
    for (int i = 1; i <= DEPENDENT; i++)
        g[dependent[i]] = B[i][INDEPENDENT + 1];
    for (int i = 1; i <= DRIVEN; i++)
        g[driven[i]] = s->qdd[driven[i]];
    for (int k = 1; k <= JOINTS; k++) {
        r[k] = s->Qq[k] - c[k];
        for (int j = 1; j <= JOINTS; j++)
            r[k] -= M[k][j] * g[j];
    }
    for (int i = 1; i <= INDEPENDENT; i++)
        for (int k = 1; k <= JOINTS; k++) {
            if (T[k][i] == 0.0)
                continue;
            y[i][1] += T[k][i] * r[k];
            for (int j = 1; j <= INDEPENDENT; j++)
                for (int l = 1; l <= JOINTS; l++)
                    A[i][j] += T[k][i] * M[k][l] * T[l][j];
        }
    failed = solve(A, INDEPENDENT, y, 1);
    if (failed)
        goto end;
    for (int i = 1; i <= INDEPENDENT; i++)
        s->qdd[independent[i]] = y[i][1];
    for (int i = 1; i <= DEPENDENT; i++) {
        s->qdd[dependent[i]] = g[dependent[i]];
        for (int j = 1; j <= INDEPENDENT; j++)
            s->qdd[dependent[i]] += B[i][j] * y[j][1];
    }
end:
    release(Jac), release(Jv), release(x), release(B), release(M), release(T), release(A);
    release(y), free(h), free(c), free(g), free(r);
    return failed;
}
"""
