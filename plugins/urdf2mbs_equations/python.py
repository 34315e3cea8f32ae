"""The equations in Python."""

from __future__ import annotations

from typing import NamedTuple

from urdf2mbs_equations.routine import (
    Absent,
    Cases,
    Content,
    Loops,
    Refused,
    Routine,
    Statement,
    list_arrays,
)
from urdf2mbs_equations.writer import CASES, Writer


class _Signature(NamedTuple):
    parameters: str
    docstring: str


SIGNATURES = {
    "dirdyna": _Signature(
        "M, c, s, tsim", "Fill the mass matrix M and the forces c of M qdd + c = Qq."
    ),
    "invdyna": _Signature("phi, s, tsim", "Fill the joint forces phi for s.q, s.qd and s.qdd."),
    "accelred": _Signature("s, tsim", "Set s.qdd from s.q and s.qd and all forces."),
    "cons_hJ": _Signature("h, Jac, s", "Fill the constraints h and their Jacobian Jac."),
    "cons_jdqd": _Signature(
        "Jdqd, s", "Fill what is left of the constraints' second derivative at qdd = 0."
    ),
    "link": _Signature(
        "frc, trq, Flink, Z, Zd, s, tsim", "Add the forces of all links to frc and trq."
    ),
    "link3D": _Signature("frc, trq, s, tsim", "Add the forces of all 3D links to frc and trq."),
    "extforces": _Signature("frc, trq, s, tsim", "Add all external forces to frc and trq."),
    "sensor": _Signature("sens, s, isens", "Fill sens with the motion of one sensor."),
    "energy": _Signature("E, s", "Fill E with the kinetic and the potential energy."),
    "momentum": _Signature("P, L, s", "Fill the momentum P and the angular momentum L."),
    "derivatives": _Signature("Dq, Dqd, Dqdd, s", "Fill the derivatives of the joint forces."),
    "regressor": _Signature(
        "Y, s", "Fill the joint forces' derivatives by all inertial parameters."
    ),
    "com": _Signature("P, s", "Fill the position P of the centre of mass."),
    "gensensor": _Signature(
        "sens, s, isens", "Fill sens with the motion of the frame behind one joint."
    ),
}

#: The array that stands for a parameter that is filled, if it is not the parameter itself.
FILLED_ARRAYS = {"sens": "sens.P"}

#: Floats use Python's own functions; all other numbers, such as symbols, use ``s.math``.
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
    """Writes functions for MBsysPy."""

    suffix, comment, template = "py", "#", "accelred.py.in"

    def write_function(self, name: str, content: Content) -> str:
        """Return the text of a file, without its head."""
        if isinstance(content, Absent | Refused):
            text = _write_stub(name, content)
        elif isinstance(content, dict):
            text = self._write_cases(name, content)
        elif isinstance(content, Loops):
            text = self._write_model(content) + self.read_sections("forces", "loops", "accelred")
        elif name == "accelred":
            text = self._write_model(None) + self.read_sections("forces")
            text += self._write_routine("_accelerations", "s", content) + "\n\n"
            text += self.read_sections("tree")
        else:
            parameters, docstring = SIGNATURES[name]
            text = self._write_routine(name, parameters, content, docstring)
        return _add_imports(text).rstrip("\n") + "\n"

    def _write_model(self, loops: Loops | None) -> str:
        """Write the tables of the template for this model."""
        tables: dict[str, object] = {**self.find_features()}
        if loops is not None:
            tables |= {
                "DEPENDENT": loops.dependent,
                "INDEPENDENT": loops.independent,
                "DRIVEN": loops.driven,
                "CUTS": loops.n_cut_rows,
                "USER_ROWS": loops.n_user_rows,
            }
        return "".join(f"{name} = {value}\n" for name, value in tables.items()) + "\n\n"

    def _write_cases(self, name: str, cases: Cases) -> str:
        """Write a function that calls another routine for each number."""
        parameters, docstring = SIGNATURES[name]
        text = ""
        for number, routine in cases.items():
            text += self._write_routine(f"_sensor_{number}", "sens, s", routine) + "\n\n"
        table = ", ".join(f"{number}: _sensor_{number}" for number in cases)
        return text + (
            f"_SENSORS = {{{table}}}\n\n\n"
            f'def sensor({parameters}):\n    """{docstring}"""\n'
            "    if isens not in _SENSORS:\n"
            f'        raise ValueError(f"the model has no {CASES[name]} {{isens}}: '
            f'it has {len(cases)}")\n'
            "    _SENSORS[isens](sens, s)\n"
        )

    def _write_routine(
        self, name: str, parameters: str, routine: Routine, docstring: str = ""
    ) -> str:
        statements = self.make_statements(routine)
        lines = [f'"""{docstring}"""'] * bool(docstring)
        arrays = list_arrays(statements)
        if arrays:
            lines += _write_functions(statements, parameters)
        ambiguous = "  # noqa: E741"  # l is Robotran's name
        lines += [f"{array} = s.{array}.tolist(){ambiguous * (array == 'l')}" for array in arrays]
        for statement in statements:
            if statement.call is not None and statement.call.function != "user_LinkForces":
                for array in statement.call.arguments[:6]:
                    shape = "(4, 4)" if array.startswith("Rx") else "4"
                    lines.append(f"{array} = zeros({shape}, s.q.dtype)")
        lines += map(_write_statement, statements)
        body = "".join(f"    {line}\n" for line in lines or ["pass"])
        return f"def {name}({parameters}):\n{body}"


def _write_functions(statements: list[Statement], parameters: str) -> list[str]:
    """Write the lines that check the kind of numbers, and that choose sin, cos and sqrt for it."""
    filled = [
        FILLED_ARRAYS.get(parameter, parameter)
        for parameter in parameters.split(", ")
        if parameter not in ("s", "tsim", "isens")
    ]
    text = "".join(statement.text for statement in statements)
    functions = [name for name in ("cos", "sin", "sqrt") if f"{name}(" in text]
    arrays = list_arrays(statements)
    state = ", ".join(f"s.{array}" for array in arrays if array in ("q", "qd", "qdd"))
    check = f"_math(s, [{state}], [{', '.join(filled or ['s.qdd'])}])"
    return [
        f"given = {check}" if functions else check,
        *(f"{name} = given.{name}" for name in functions),
    ]


def _write_stub(name: str, content: Absent | Refused) -> str:
    """Write a function that only says why it does nothing."""
    parameters, docstring = SIGNATURES[name]
    text = (
        f'def {name}({parameters}):\n    """{docstring}"""\n'
        f'    print("{name}: {content.message}", file=sys.stderr)\n    s.flag_stop = 1\n'
    )
    return text + "    return -1\n" * (name == "accelred")


def _write_statement(statement: Statement) -> str:
    call = statement.call
    if call is not None:
        return f"{call.result} = s.{call.function}({', '.join(call.arguments)})"
    targets = [target.replace("][", ", ") for target in statement.targets]
    return " = ".join([*targets, statement.text])


def _add_imports(text: str) -> str:
    text = MATH * ("_math(" in text) + text
    standard = "import math\n" * ("_math(" in text) + "import sys\n" * ("sys.stderr" in text)
    installed = "import numpy as np\n" * ("np." in text)
    installed += "from numpy import zeros\n" * (" zeros(" in text)
    groups = [group for group in (standard, installed) if group]
    if groups and text.startswith("def "):  # a second blank line
        text = f"\n{text}"
    return "\n".join([*groups, text])
