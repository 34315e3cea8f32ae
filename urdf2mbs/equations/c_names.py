"""Functions in C by Robotran's names: their parameters, and how those of the user are called."""

from __future__ import annotations

#: The parameters of each function.
PARAMETERS = {
    "dirdyna": "double **M, double *c, MbsData *s, double tsim",
    "invdyna": "double *phi, MbsData *s, double tsim",
    "accelred": "MbsData *s, double tsim",
    "cons_hJ": "double *h, double **Jac, MbsData *s, double tsim",
    "cons_jdqd": "double *Jdqd, MbsData *s, double tsim",
    "link": "double **frc, double **trq, double *Flink, double *Z, double *Zd, MbsData *s, "
    "double tsim",
    "link3D": "double **frc, double **trq, MbsData *s, double tsim",
    "extforces": "double **frc, double **trq, MbsData *s, double tsim",
    "sensor": "MbsSensor *sens, MbsData *s, int isens",
    "gensensor": "MbsSensor *sens, MbsData *s, int isens",
}

#: How the user's functions are called: since 2025 through functions of Robotran's library.
USER_MACRO = """\
#ifdef MBS_BEFORE_2025
#define USER(name) user_##name
#else
#define USER(name) user_call_##name
#endif
"""
_MOTION = (
    "double PxF[4], double RxF[4][4], double VxF[4], double OMxF[4], double AxF[4], "
    "double OMPxF[4], MbsData *s, double tsim, int ixF"
)
USER = {
    "ExtForces": f"double *USER(ExtForces)({_MOTION});",
    "Link3DForces": f"double *USER(Link3DForces)({_MOTION});",
    "LinkForces": "double USER(LinkForces)(double Z, double Zd, MbsData *s, double tsim, "
    "int ilnk);",
    "JointForces": "double *USER(JointForces)(MbsData *s, double tsim);",
    "DrivenJoints": "void USER(DrivenJoints)(MbsData *s, double tsim);",
}


def declarations(functions: list[str]) -> str:
    if not functions:
        return ""
    declared = "".join(USER[function.removeprefix("user_")] + "\n" for function in functions)
    return f"{USER_MACRO}\n{declared}\n"
