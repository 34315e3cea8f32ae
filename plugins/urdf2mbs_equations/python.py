"""The equations in Python."""

from __future__ import annotations

from urdf2mbs_equations.routine import (
    Absent,
    Cases,
    Loops,
    Made,
    Refused,
    Routine,
    Statement,
    arrays,
)
from urdf2mbs_equations.writer import CASES, Writer

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
    "energy": ("E, s", "Fill E with the kinetic and the potential energy."),
    "momentum": ("P, L, s", "Fill the momentum P and the angular momentum L."),
    "derivatives": ("Dq, Dqd, Dqdd, s", "Fill the derivatives of the joint forces."),
    "regressor": ("Y, s", "Fill the joint forces' derivatives by all inertial parameters."),
    "com": ("P, s", "Fill the position P of the centre of mass."),
    "gensensor": ("sens, s, isens", "Fill sens with the motion of the frame behind one joint."),
}

#: What is filled through a parameter.
FILLED = {"sens": "sens.P"}

#: Floats go through Python's own functions, which make nan of symbols; all else through ``s.math``.
MATH = '''\
def _math(s, read, filled):
    """A module with sin, cos and sqrt: s.math for other numbers than floats, else Python's."""
    given = getattr(s, "math", math)
    for array in read if given is math else filled:
        if array.dtype.char != ("d" if given is math else "O"):
            raise TypeError(
                "set s.math (to numpy, casadi, ...), and let q and all that is filled be arrays of "
                "objects; without s.math all are floats"
            )
    return given


'''


class PythonWriter(Writer):
    suffix, comment, template = "py", "#", "accelred.py.in"

    def function(self, name: str, made: Made) -> str:
        parameters, doc = FUNCTIONS[name]
        if isinstance(made, Absent | Refused):
            text = (
                f'def {name}({parameters}):\n    """{doc}"""\n'
                f'    print("{name}: {made.message}", file=sys.stderr)\n    s.flag_stop = 1\n'
            ) + "    return -1\n" * (name == "accelred")
        elif isinstance(made, dict):
            text = self._cases(name, made)
        elif isinstance(made, Loops):
            text = self._model(made) + self.sections("forces", "loops", "accelred")
        elif name == "accelred":
            text = self._model(None) + self.sections("forces")
            text += self._define("_accelerations", "s", made) + "\n\n" + self.sections("tree")
        else:
            text = self._define(name, parameters, made, doc)
        return _with_imports(text).rstrip("\n") + "\n"

    def _model(self, loops: Loops | None) -> str:
        text = "".join(f"{name} = {value}\n" for name, value in self.facts().items())
        if loops is not None:
            for name in ("dependent", "independent", "driven", "cuts"):
                text += f"{name.upper()} = {getattr(loops, name)}\n"
            text += f"USER_ROWS = {loops.user}\n"
        return text + "\n\n"

    def _cases(self, name: str, cases: Cases) -> str:
        """A function that does another routine for each number."""
        parameters, doc = FUNCTIONS[name]
        text = ""
        for number, routine in cases.items():
            text += self._define(f"_sensor_{number}", "sens, s", routine) + "\n\n"
        table = ", ".join(f"{number}: _sensor_{number}" for number in cases)
        return text + (
            f"_SENSORS = {{{table}}}\n\n\n"
            f'def sensor({parameters}):\n    """{doc}"""\n'
            "    if isens not in _SENSORS:\n"
            f'        raise ValueError(f"the model has no {CASES[name]} {{isens}}: '
            f'it has {len(cases)}")\n'
            "    _SENSORS[isens](sens, s)\n"
        )

    def _define(self, name: str, parameters: str, routine: Routine, doc: str = "") -> str:
        lines = self.statements(routine)
        out = [f'"""{doc}"""'] * bool(doc)
        used = arrays(lines)
        filled = [FILLED.get(p, p) for p in parameters.split(", ") if p not in ("tsim", "isens")]
        filled = [p for p in filled if p != "s"] or ["s.qdd"]
        if used:
            text = "".join(line.text for line in lines)
            functions = [name for name in ("cos", "sin", "sqrt") if f"{name}(" in text]
            read = ", ".join(f"s.{array}" for array in used if array in ("q", "qd", "qdd"))
            given = "given = " if functions else ""
            out.append(f"{given}_math(s, [{read}], [{', '.join(filled)}])")
            out += [f"{name} = given.{name}" for name in functions]
        ambiguous = "  # noqa: E741"  # l is Robotran's name
        out += [f"{array} = s.{array}.tolist(){ambiguous * (array == 'l')}" for array in used]
        for line in lines:
            if line.call is not None and line.call.function != "user_LinkForces":
                for array in line.call.arguments[:6]:
                    shape = "(4, 4)" if array.startswith("Rx") else "4"
                    out.append(f"{array} = zeros({shape}, s.q.dtype)")
        out += map(_statement, lines)
        return f"def {name}({parameters}):\n" + "".join(f"    {line}\n" for line in out or ["pass"])


def _statement(line: Statement) -> str:
    if line.call is not None:
        return f"{line.call.result} = s.{line.call.function}({', '.join(line.call.arguments)})"
    places = [place.replace("][", ", ") for place in line.places]
    return " = ".join([*places, line.text])


def _with_imports(text: str) -> str:
    text = MATH * ("_math(" in text) + text
    standard = "import math\n" * ("_math(" in text) + "import sys\n" * ("sys.stderr" in text)
    others = "import numpy as np\n" * ("np." in text)
    others += "from numpy import zeros\n" * (" zeros(" in text)
    groups = [group for group in (standard, others) if group]
    if groups and text.startswith("def "):  # a second blank line
        text = f"\n{text}"
    return "\n".join([*groups, text])
