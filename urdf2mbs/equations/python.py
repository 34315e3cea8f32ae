"""The equations in Python, plain or for numba."""

from __future__ import annotations

from urdf2mbs.equations.loops import Loops, Refused
from urdf2mbs.equations.routine import (
    Call,
    Cases,
    Count,
    Routine,
    Statement,
    arrays,
    split,
    statements,
)
from urdf2mbs.mbs.model import Mbs

#: So many statements are one function for numba.
PIECE = 300

#: The parameters of each function, and what its docstring says.
FUNCTIONS = {
    "dirdyna": ("M, c, s, tsim", "Fill the mass matrix M and the forces c of M qdd + c = Qq."),
    "invdyna": ("phi, s, tsim", "Fill the joint forces phi for s.q, s.qd and s.qdd."),
    "accelred": ("s, tsim", "Set s.qdd from s.q and s.qd and all forces."),
    "cons_hJ": ("h, Jac, s", "Fill the constraints h and their Jacobian Jac."),
    "cons_jdqd": ("Jdqd, s", "Fill what is left of the constraints' second derivative at qdd = 0."),
    "link": ("frc, trq, Flink, Z, Zd, s, tsim", "Add the forces of all links to frc and trq."),
    "link3D": ("frc, trq, s, tsim", "Add the forces of all 3D links to frc and trq."),
    "extforces": ("frc, trq, s, tsim", "Add all external forces to frc and trq."),
    "sensor": ("sens, s, isens", "Fill sens with the motion of one sensor."),
    "gensensor": ("sens, s, isens", "Fill sens with the motion of the frame behind one joint."),
}


class Writer:
    def __init__(self, mbs: Mbs, *, numba: bool) -> None:
        self.mbs, self.numba = mbs, numba

    def function(self, name: str, made: Routine | Cases | Loops | Refused) -> tuple[str, Count]:
        """The text of a file below its header, and what was counted."""
        parameters, doc = FUNCTIONS[name]
        if isinstance(made, Cases):
            return self._cases(parameters, doc, made)
        if isinstance(made, Loops):
            return LOOPS_IMPORTS + prelude(self.mbs) + _loops(made), Count()
        if isinstance(made, Refused):
            return REFUSED, Count()
        if name == "accelred":
            inner, count = self._routine("_accelerations", "s", "", made)
            text = inner + "\n\n" + self._forces() + ACCELRED
            return _imports(text) + text, count
        numba = self.numba and name in ("dirdyna", "invdyna")
        text, count = (self._jitted if numba else self._routine)(name, parameters, doc, made)
        return _imports(text) + text, count

    def _routine(self, name: str, parameters: str, doc: str, made: Routine) -> tuple[str, Count]:
        lines, count = statements(made)
        out = [f"def {name}({parameters}):"]
        if doc:
            out.append(f'    """{doc}"""')
        out += [f"    {array} = s.{array}.tolist()" for array in arrays(lines)]
        for line in lines:
            if line.call is not None:
                out += [f"    {one}" for one in _declared(line.call)]
        out += _body(lines)
        if not doc and len(out) == 1:
            out.append("    pass")
        return "\n".join(out) + "\n", count

    def _jitted(self, name: str, parameters: str, doc: str, made: Routine) -> tuple[str, Count]:
        lines, count = statements(made)
        pieces, places = split(lines, PIECE)
        results = parameters.split(", s,")[0]
        used = arrays(lines)
        given = ", ".join([results, *used, "w"])
        out = ["from numba import njit", "from numpy import empty", "", ""]
        for number, piece in enumerate(pieces, start=1):
            out += ["@njit(cache=True)", f"def _{name}_{number}({given}):"]
            out += [f"    {variable} = {place}" for variable, place in piece.takes.items()]
            out += _body(piece.lines, piece.gives, numpy=True)
            out += ["", ""]
        out += [f"def {name}({parameters}):", f'    """{doc}"""', f"    w = empty({places['w']})"]
        passed = ", ".join([results, *(f"s.{array}" for array in used), "w"])
        out += [f"    _{name}_{number}({passed})" for number in range(1, len(pieces) + 1)]
        return "\n".join(out) + "\n", count

    def _cases(self, parameters: str, doc: str, cases: Cases) -> tuple[str, Count]:
        text, total = "", Count()
        for number, routine in cases.routines.items():
            one, count = self._routine(f"_sensor_{number}", "sens, s", "", routine)
            text, total = text + one + "\n\n", total + count
        table = ", ".join(f"{number}: _sensor_{number}" for number in cases.routines)
        text += f"_SENSORS = {{{table}}}\n\n\n"
        text += f'def sensor({parameters}):\n    """{doc}"""\n'
        text += "    if isens in _SENSORS:\n        _SENSORS[isens](sens, s)\n"
        return _imports(text) + text, total

    def _forces(self) -> str:
        return prelude(self.mbs)


ACCELRED = '''

def accelred(s, tsim):
    """Set s.qdd from s.q and s.qd and all forces."""
    _set_driven(s, tsim)
    _set_forces(s, tsim)
    _accelerations(s)
    return 0
'''

REFUSED = '''

def accelred(s, tsim):
    """Not generated: see the head of this file."""
    s.flag_stop = 1
    return -1
'''

LOOPS_IMPORTS = "import numpy as np\n\n\n"


def _loops(loops: Loops) -> str:
    text = f"""

DEPENDENT = {loops.dependent}
INDEPENDENT = {loops.independent}
DRIVEN = {loops.driven}
CUTS = {loops.cuts}
"""
    user = USER_CONSTRAINTS if loops.user else ("", "")
    return text + LOOPS.replace("@HJ@", user[0]).replace("@JDQD@", user[1])


#: What the user's own constraints add; their rows follow those of the cuts.
USER_CONSTRAINTS = (
    "    s.user_cons_hJ(h[CUTS:], jac[CUTS:], s, tsim)\n",
    "    s.user_cons_jdqd(jdqd[CUTS:], s)\n",
)

LOOPS = '''

def _constraints(s, tsim):
    count, joints = len(DEPENDENT) + 1, len(s.q)
    h, jac = np.zeros(count), np.zeros((count, joints))
    s.mbs_cons_hJ(h, jac, s)
@HJ@    return h[1:], jac[1:]


def _derivative(s, tsim):
    jdqd = np.zeros(len(DEPENDENT) + 1)
    s.mbs_cons_jdqd(jdqd, s)
@JDQD@    return jdqd[1:]


def accelred(s, tsim):
    """Set s.q, s.qd and s.qdd of the dependent joints, and s.qdd of the independent ones."""
    _set_driven(s, tsim)
    for _ in range(100):
        h, jac = _constraints(s, tsim)
        if np.abs(h).max() < 1e-9:
            break
        s.q[DEPENDENT] -= np.linalg.solve(jac[:, DEPENDENT], h)
    else:
        return -1
    s.qd[DEPENDENT] = 0.0
    s.qd[DEPENDENT] = np.linalg.solve(jac[:, DEPENDENT], -jac[:, 1:] @ s.qd[1:])
    rest = _derivative(s, tsim)
    if DRIVEN:
        rest = rest + jac[:, DRIVEN] @ s.qdd[DRIVEN]
    _set_forces(s, tsim)
    joints = len(s.q)
    m, c = np.zeros((joints, joints)), np.zeros(joints)
    s.mbs_dirdyna(m, c, s, tsim)
    turn = np.zeros((joints, len(INDEPENDENT)))
    turn[INDEPENDENT] = np.eye(len(INDEPENDENT))
    turn[DEPENDENT] = -np.linalg.solve(jac[:, DEPENDENT], jac[:, INDEPENDENT])
    known = np.zeros(joints)
    known[DEPENDENT] = -np.linalg.solve(jac[:, DEPENDENT], rest)
    known[DRIVEN] = s.qdd[DRIVEN]
    force = turn.T @ (s.Qq - c - m @ known)
    s.qdd[1:] = (known + turn @ np.linalg.solve(turn.T @ m @ turn, force))[1:]
    return 0
'''


def prelude(mbs: Mbs) -> str:
    """The functions that set driven joints and all forces, as Robotran's library does."""
    joints = [joint for body in mbs.bodies for joint in body.joints]
    kinds = {link.kind for link in mbs.links}
    driven = any(joint.nature == "driven" for joint in joints)
    text = "def _set_driven(s, tsim):\n"
    text += "    s.user_DrivenJoints(s, tsim)\n\n\n" if driven else "    pass\n\n\n"
    lines = ["s.frc[1:] = 0.0", "s.trq[1:] = 0.0"]
    if "link" in kinds:
        lines.append("s.mbs_link(s.frc, s.trq, s.Fl, s.Z, s.Zd, s, tsim)")
    if "link3D" in kinds:
        lines.append("s.mbs_link3D(s.frc, s.trq, s, tsim)")
    if any(point.extforce for body in mbs.bodies for point in body.points):
        lines.append("s.mbs_extforces(s.frc, s.trq, s, tsim)")
    lines.append("s.user_JointForces(s, tsim)")
    return text + "def _set_forces(s, tsim):\n" + "".join(f"    {line}\n" for line in lines)


def _imports(text: str) -> str:
    names = [name for name in ("cos", "sin", "sqrt") if f"{name}(" in text]
    out = f"from math import {', '.join(names)}\n" if names else ""
    if " zeros(" in text:
        out += f"{chr(10) if out else ''}from numpy import zeros\n"
    return f"{out}\n\n" if out else ""


def _declared(call: Call) -> list[str]:
    """The arrays that a call takes."""
    if call.function == "user_LinkForces":
        return []
    return [
        f"{array} = zeros({'(4, 4)' if array.startswith('Rx') else '4'})"
        for array in call.arguments[:6]
    ]


def _body(
    lines: list[Statement], gives: dict[str, str] | None = None, *, numpy: bool = False
) -> list[str]:
    out: list[str] = []
    for line in lines:
        text = line.text.replace("][", ", ") if numpy else line.text
        if line.call is not None:
            call = line.call
            out.append(f"    {call.result} = s.{call.function}({', '.join(call.arguments)})")
        elif line.variable is not None:
            out.append(f"    {line.variable} = {text}")
            if gives and line.variable in gives:
                out.append(f"    {gives[line.variable]} = {line.variable}")
        else:
            places = " = ".join(place.replace("][", ", ") for place in line.places)
            out.append(f"    {places} = {text}")
    return out
