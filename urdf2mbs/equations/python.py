"""The equations in Python, plain or for numba."""

from __future__ import annotations

from dataclasses import replace

from urdf2mbs.equations.routine import (
    Call,
    Cases,
    Loops,
    Piece,
    Routine,
    Statement,
    arrays,
    split,
    statements,
)
from urdf2mbs.equations.writer import CASES, Writer
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


class PythonWriter(Writer):
    suffix, comment, template = "py", "#", "accelred.py.in"

    def __init__(self, mbs: Mbs, *, numba: bool = False) -> None:
        super().__init__(mbs)
        self.numba = numba

    def top(self, name: str, text: str) -> str:
        names = [name for name in ("cos", "sin", "sqrt") if f"{name}(" in text]
        lines = [f"from math import {', '.join(names)}\n"] if names else []
        if "sys.stderr" in text:
            lines.insert(0, "import sys\n")
        if "np." in text:
            lines.append("import numpy as np\n")
        if " zeros(" in text:
            lines.append("from numpy import zeros\n")
        return "\n".join(lines) + "\n\n" if lines else ""

    def model(self, loops: Loops | None) -> str:
        text = "".join(f"{name} = {value}\n" for name, value in self.facts().items())
        if loops is not None:
            for name in ("dependent", "independent", "driven", "cuts"):
                text += f"{name.upper()} = {getattr(loops, name)}\n"
            text += f"USER_ROWS = {loops.user}\n"
        return text + "\n\n"

    def stub(self, name: str, message: str, *, needed: bool) -> str:
        parameters, doc = FUNCTIONS[name]
        failure = "    return -1\n" if name == "accelred" else ""
        return (
            f'def {name}({parameters}):\n    """{doc}"""\n'
            f'    print("{name}: {message}", file=sys.stderr)\n    s.flag_stop = 1\n{failure}'
        )

    def routine(self, name: str, routine: Routine) -> str:
        if self.numba and name in ("dirdyna", "invdyna"):
            return self._compiled(name, routine)
        parameters, doc = FUNCTIONS[name]
        return self.write(name, parameters, routine, doc)

    def tree(self, routine: Routine) -> str:
        return self.write("_accelerations", "s", routine) + "\n\n" + self.common(None, "tree")

    def cases(self, name: str, cases: Cases) -> str:
        parameters, doc = FUNCTIONS[name]
        text = ""
        for number, routine in cases.routines.items():
            text += self.write(f"_sensor_{number}", "sens, s", routine) + "\n\n"
        table = ", ".join(f"{number}: _sensor_{number}" for number in cases.routines)
        return text + (
            f"_SENSORS = {{{table}}}\n\n\n"
            f'def sensor({parameters}):\n    """{doc}"""\n'
            "    if isens not in _SENSORS:\n"
            f'        raise ValueError(f"the model has no {CASES[name]} {{isens}}: '
            f'it has {len(cases.routines)}")\n'
            "    _SENSORS[isens](sens, s)\n"
        )

    def whole(
        self, name: str, parameters: str, lines: list[Statement], doc: str, start: str
    ) -> str:
        out = [f'    """{doc}"""'] * bool(doc)
        out += [f"    {array} = s.{array}.tolist()" for array in arrays(lines)]
        for line in lines:
            if line.call is not None and line.call.function != "user_LinkForces":
                for array in line.call.arguments[:6]:
                    size = "(4, 4)" if array.startswith("Rx") else "4"
                    out.append(f"    {array} = zeros({size})")
        out += self.body(lines)
        return "\n".join([f"def {name}({parameters}):", *(out or ["    pass"])]) + "\n"

    def _compiled(self, name: str, routine: Routine) -> str:
        """A function in pieces that numba compiles."""
        parameters, doc = FUNCTIONS[name]
        lines, count = statements(routine)
        self.count += count
        used = arrays(lines)
        lines = [replace(line, text=line.text.replace("][", ", ")) for line in lines]
        pieces, sizes = split(lines, PIECE)
        results = parameters.split(", s,")[0]
        given = ", ".join([results, *used, "w"])
        out = ["from numba import njit", "from numpy import empty", "", ""]
        for number, piece in enumerate(pieces, start=1):
            out += ["@njit(cache=True)", f"def _{name}_{number}({given}):"]
            out += [f"    {variable} = {place}" for variable, place in piece.takes.items()]
            out += [*self.body(piece.lines, Piece([], gives=piece.gives)), "", ""]
        out += [f"def {name}({parameters}):", f'    """{doc}"""']
        out.append(f"    w = empty({sizes.get('w', 0)})")
        passed = ", ".join([results, *(f"s.{array}" for array in used), "w"])
        out += [f"    _{name}_{number}({passed})" for number in range(1, len(pieces) + 1)]
        return "\n".join(out) + "\n"

    def variable(self, name: str, text: str, *, pair: bool) -> str:
        return f"{name} = {text}"

    def place(self, place: str) -> str:
        return place.replace("][", ", ")

    def call(self, call: Call) -> str:
        return f"{call.result} = s.{call.function}({', '.join(call.arguments)})"
