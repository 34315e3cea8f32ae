"""The equations in MATLAB, for MBsysLab; GNU Octave runs them, too.

Names, arguments and results are those of the files that Robotran's generator wrote for public
projects.  There, no file has ``accelred`` or ``link3D``.
"""

from __future__ import annotations

from urdf2mbs_equations.constraints import count_equations
from urdf2mbs_equations.routine import Made, Refused, Routine, Statement, arrays
from urdf2mbs_equations.writer import CASES, Writer

#: What each function returns, and the value with which each result begins.
_LOADS = {"frc": "s.frc", "trq": "s.trq"}
_SENSOR = {
    "sens": "struct('P', zeros(3,1), 'R', zeros(3,3), 'V', zeros(3,1), 'OM', zeros(3,1), "
    "'A', zeros(3,1), 'OMP', zeros(3,1), 'J', zeros(6,{joints}))"
}
_TABLE = "zeros({joints},{joints})"
RESULTS = {
    "dirdyna": {"M": _TABLE, "c": "zeros({joints},1)"},
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
    "derivatives": dict.fromkeys(("Dq", "Dqd", "Dqdd"), _TABLE),
    "regressor": {"Y": "zeros({joints},{parameters})"},
}
#: The user's functions, by their handles in usrfun.
USER = {"user_ExtForces": "fext", "user_LinkForces": "flink"}


class MatlabWriter(Writer):
    suffix, comment = "m", "%"
    lacks = frozenset(["accelred", "invdynared", "link3D"])

    def function(self, name: str, made: Made) -> str:
        sizes = {
            "joints": len(self.mbs.numbers()),
            "links": sum(link.kind == "link" for link in self.mbs.links),
            "parameters": 10 * len(self.mbs.bodies),
            "rows": count_equations(self.mbs) if name.startswith("cons_") else 0,
        }
        begin = {result: value.format(**sizes) for result, value in RESULTS[name].items()}
        number = ",isens" if name in CASES else ""
        text = (
            f"function [{','.join(begin)}] = mbs_{name}_{self.mbs.name}(s,tsim,usrfun{number})\n"
            + "".join(f"{result} = {value};\n" for result, value in begin.items())
        )
        if isinstance(made, Refused):
            text += f"error('{name}: {made.message}');\n"
        elif isinstance(made, dict):
            text += "switch isens\n"
            for case, routine in made.items():
                text += f"case {case}\n{self._body(routine)}"
            text += (
                f"otherwise\nerror('the model has no {CASES[name]} %d: it has "
                f"{len(made)}', isens);\nend\n"
            )
        elif isinstance(made, Routine):
            text += self._body(made)
        return text + "end\n"

    def _body(self, routine: Routine) -> str:
        lines = self.statements(routine)
        text = "".join(f"{array} = s.{array};\n" for array in arrays(lines))
        for line in lines:
            if line.call is not None and line.call.function == "user_ExtForces":
                for array in line.call.arguments[:6]:
                    text += f"{array} = zeros(3,{3 if array.startswith('Rx') else 1});\n"
        return text + "".join(map(_statement, lines))


def _statement(line: Statement) -> str:
    if line.call is not None:
        arguments = ",".join(line.call.arguments)
        text = f"{line.call.result} = usrfun.{USER[line.call.function]}({arguments});\n"
    else:
        first, *more = line.places
        text = f"{first} = {line.text};\n" + "".join(f"{place} = {first};\n" for place in more)
    # M[1][3] is M(1,3) in MATLAB
    return text.replace("][", ",").replace("[", "(").replace("]", ")")
