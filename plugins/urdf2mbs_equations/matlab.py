"""The equations in MATLAB, for MBsysLab; GNU Octave runs them, too.

Names, arguments and results are those of files that Robotran's generator wrote for public projects,
which have no ``accelred``, no ``invdynared`` and no ``link3D``.
"""

from __future__ import annotations

from urdf2mbs_equations.constraints import count_equations
from urdf2mbs_equations.regressor import N_PARAMETERS
from urdf2mbs_equations.routine import Content, Refused, Routine, Statement, list_arrays
from urdf2mbs_equations.writer import CASES, Writer

_LOADS = {"frc": "s.frc", "trq": "s.trq"}
_SENSOR = {
    "sens": "struct('P', zeros(3,1), 'R', zeros(3,3), 'V', zeros(3,1), 'OM', zeros(3,1), "
    "'A', zeros(3,1), 'OMP', zeros(3,1), 'J', zeros(6,{joints}))"
}
_SQUARE = "zeros({joints},{joints})"
#: The results of each function, and the value with which each result begins.
RESULTS = {
    "dirdyna": {"M": _SQUARE, "c": "zeros({joints},1)"},
    "invdyna": {"phi": "zeros({joints},1)"},
    "cons_hJ": {"h": "zeros({rows},1)", "Jac": "zeros({rows},{joints})"},
    "cons_jdqd": {"Jdqd": "zeros({rows},1)"},
    "link": {**_LOADS, **dict.fromkeys(("Flink", "Z", "Zd"), "zeros({links},1)")},
    "extforces": _LOADS,
    "sensor": _SENSOR,
    "gensensor": _SENSOR,
    "energy": {"E": "zeros(2,1)"},
    "momentum": {"P": "zeros(3,1)", "L": "zeros(3,1)"},
    "com": {"P": "zeros(3,1)"},
    "derivatives": dict.fromkeys(("Dq", "Dqd", "Dqdd"), _SQUARE),
    "regressor": {"Y": "zeros({joints},{parameters})"},
}
#: User functions, by their handles in ``usrfun``.
USER_FUNCTIONS = {"user_ExtForces": "fext", "user_LinkForces": "flink"}


class MatlabWriter(Writer):
    """Writes functions for MBsysLab."""

    suffix, comment = "m", "%"
    missing_functions = frozenset(["accelred", "invdynared", "link3D"])

    def write_function(self, name: str, content: Content) -> str:
        """Return the text of a file, without its head."""
        sizes = {
            "joints": len(self.mbs.numbers()),
            "links": sum(link.kind == "link" for link in self.mbs.links),
            "parameters": N_PARAMETERS * len(self.mbs.bodies),
            "rows": count_equations(self.mbs) if name.startswith("cons_") else 0,
        }
        results = {result: value.format(**sizes) for result, value in RESULTS[name].items()}
        number = ",isens" if name in CASES else ""
        text = (
            f"function [{','.join(results)}] = mbs_{name}_{self.mbs.name}(s,tsim,usrfun{number})\n"
        )
        text += "".join(f"{result} = {value};\n" for result, value in results.items())
        if isinstance(content, Refused):
            text += f"error('{name}: {content.message}');\n"
        elif isinstance(content, dict):
            text += "switch isens\n"
            for case, routine in content.items():
                text += f"case {case}\n{self._write_body(routine)}"
            text += (
                f"otherwise\nerror('the model has no {CASES[name]} %d: it has "
                f"{len(content)}', isens);\nend\n"
            )
        elif isinstance(content, Routine):
            text += self._write_body(content)
        return text + "end\n"

    def _write_body(self, routine: Routine) -> str:
        statements = self.make_statements(routine)
        text = "".join(f"{array} = s.{array};\n" for array in list_arrays(statements))
        for statement in statements:
            if statement.call is not None and statement.call.function == "user_ExtForces":
                for array in statement.call.arguments[:6]:
                    text += f"{array} = zeros(3,{3 if array.startswith('Rx') else 1});\n"
        return text + "".join(map(_write_statement, statements))


def _write_statement(statement: Statement) -> str:
    if statement.call is not None:
        arguments = ",".join(statement.call.arguments)
        handle = USER_FUNCTIONS[statement.call.function]
        text = f"{statement.call.result} = usrfun.{handle}({arguments});\n"
    else:
        first, *copies = statement.targets
        text = f"{first} = {statement.text};\n"
        text += "".join(f"{target} = {first};\n" for target in copies)
    # MATLAB has other brackets: M[1][3] becomes M(1,3).
    return text.replace("][", ",").replace("[", "(").replace("]", ")")
