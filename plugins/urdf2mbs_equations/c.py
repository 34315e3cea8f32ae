"""The equations in C, in pieces that a compiler makes short work of."""

from __future__ import annotations

import re

from urdf2mbs.plugin import Mbs
from urdf2mbs_equations.pairs import in_pairs
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

#: The parameters of each function.
_FORCES = "double **frc, double **trq"
PARAMETERS = {
    "dirdyna": "double **M, double *c, MbsData *s, double tsim",
    "invdyna": "double *phi, MbsData *s, double tsim",
    "accelred": "MbsData *s, double tsim",
    "invdynared": "MbsData *s, double tsim",
    "cons_hJ": "double *h, double **Jac, MbsData *s, double tsim",
    "cons_jdqd": "double *Jdqd, MbsData *s, double tsim",
    "link": f"{_FORCES}, double *Flink, double *Z, double *Zd, MbsData *s, double tsim",
    "link3D": f"{_FORCES}, MbsData *s, double tsim",
    "extforces": f"{_FORCES}, MbsData *s, double tsim",
    "sensor": "MbsSensor *sens, MbsData *s, int isens",
    "energy": "double *E, MbsData *s",
    "momentum": "double *P, double *L, MbsData *s",
    "com": "double *P, MbsData *s",
    "derivatives": "double **Dq, double **Dqd, double **Dqdd, MbsData *s",
    "regressor": "double **Y, MbsData *s",
    "gensensor": "MbsSensor *sens, MbsData *s, int isens",
}

_MOTION = (
    "double PxF[4], double RxF[4][4], double VxF[4], double OMxF[4], double AxF[4], "
    "double OMPxF[4], MbsData *s, double tsim, int ixF"
)
USER = {
    "user_ExtForces": f"double *USER(ExtForces)({_MOTION});",
    "user_Link3DForces": f"double *USER(Link3DForces)({_MOTION});",
    "user_LinkForces": "double USER(LinkForces)(double Z, double Zd, MbsData *s, double tsim, "
    "int ilnk);",
}

#: A long function is cut into pieces of so many statements.  Pieces of 60 to 100 compile and run
#: fastest (tried: 40 to 1000).
PIECE = 80

#: The arrays of MbsData with two indices.
TABLES = frozenset(["l", "In", "dpt", "frc", "trq"])

TREE = """\

int mbs_accelred(MbsData *s, double tsim)
{
    set_driven(s, tsim);
    set_forces(s, tsim);
    USER(JointForces)(s, tsim);
    accelerations(s);
    return MBS_INFO_SUCCESS;
}
"""


class CWriter(Writer):
    suffix, comment, template, lacks = "c", "//", "accelred.c", frozenset()

    def __init__(self, mbs: Mbs, *, pairs: bool = True) -> None:
        super().__init__(mbs)
        self.pairs = pairs

    def function(self, name: str, made: Made) -> str:
        if isinstance(made, Absent | Refused):
            text = self._stub(name, made)
        elif isinstance(made, dict):
            text = self._cases(name, made)
        elif isinstance(made, Loops):
            lists = ("dependent", "independent") if name == "accelred" else ("dependent",)
            text = self._model(made, *lists)
            text += self.sections("info", "calls", "forces", "loops", name)
        elif name == "accelred":
            text = self._model(None) + self.sections("info", "calls", "forces")
            text += self._define("static void accelerations", "MbsData *s", made) + TREE
        else:
            if self.pairs and made.alike:
                made = in_pairs(made)
            text = self._define(f"void mbs_{name}", PARAMETERS[name], made)
        return self._includes(name, text) + text.rstrip("\n") + "\n"

    def _includes(self, name: str, text: str) -> str:
        uses = {"stderr": "<stdio.h>", "memset(": "<string.h>"}
        out = "#include <math.h>\n"
        out += "".join(f"#include {header}\n" for word, header in uses.items() if word in text)
        out += '\n#include "mbs_data.h"\n'
        out += '#include "mbs_sensor.h"\n' * name.endswith("sensor")
        parts = {"PIECE ": "pieces", "pair ": "pairs"}
        return out + "\n" + self.sections(*(part for word, part in parts.items() if word in text))

    def _model(self, loops: Loops | None, *lists: str) -> str:
        facts = {name: int(value) for name, value in self.facts().items()}
        text = _enum({"JOINTS": len(self.mbs.numbers()), **facts})
        if loops is not None:
            text += _enum(
                {"DEPENDENT": len(loops.dependent), "INDEPENDENT": len(loops.independent),
                 "CUTS": loops.cuts, "USER_ROWS": loops.user, "ROWS": loops.cuts + loops.user}
            )  # fmt: skip
            text += "/* numbers of the joints, the first of each list not being used */\n"
            for name in lists:
                numbers = ", ".join(map(str, [0, *getattr(loops, name)]))
                text += f"static const int {name}[] = {{{numbers}}};\n"
        return text + "\n"

    def _stub(self, name: str, made: Absent | Refused) -> str:
        text = f'    fputs("mbs_{name}: {made.message}\\n", stderr);\n    s->flag_stop = 1;\n'
        head = "void"
        if name in ("accelred", "invdynared"):
            head, text = self.sections("info") + "int", text + "    return MBS_INFO_FAILURE;\n"
        if isinstance(made, Absent):  # only libraries of before 2025 call it
            text = f"#ifndef MBS_BEFORE_2025\n{text}#endif\n"
        text = _voided(PARAMETERS[name].split(", ")) + text
        return f"{head} mbs_{name}({PARAMETERS[name]})\n{{\n{text}}}\n"

    def _cases(self, name: str, cases: Cases) -> str:
        """A function that does another routine for each number."""
        text = choice = ""
        for number, routine in cases.items():
            case = f"mbs_{name}_{number}"
            text += self._define(f"static void {case}", "MbsSensor *sens, MbsData *s", routine)
            text += "\n"
            choice += f"    case {number}:\n        {case}(sens, s);\n        break;\n"
        body = (
            f"    switch (isens) {{\n{choice}"
            f'    default:\n        fprintf(stderr, "mbs_{name}: the model has no {CASES[name]} '
            f'%d: it has {len(cases)}\\n", isens);\n'
            "        s->flag_stop = 1;\n        break;\n    }\n"
        )
        return text + _function(f"void mbs_{name}", PARAMETERS[name], body)

    def _define(self, head: str, parameters: str, routine: Routine) -> str:
        """A function; ``head`` ends with its name."""
        lines = self.statements(routine)
        calls = [line.call for line in lines if line.call is not None]
        if len(lines) > PIECE and not calls:
            return _in_pieces(head, parameters, lines)
        text = body = ""
        if calls:
            functions = sorted({call.function for call in calls})
            declared = "".join(f"{USER[function]}\n" for function in functions)
            text = f"{self.sections('calls')}{declared}\n"
        for call in calls:
            pointer = "" if call.function == "user_LinkForces" else "*"
            body += f"    double {pointer}{call.result};\n"
            for array in call.arguments[:6] if pointer else ():
                size = "[4][4] = {{0.0}}" if array.startswith("Rx") else "[4] = {0.0}"
                body += f"    double {array}{size};\n"
        body += _read(lines) + "".join(map(_statement, lines))
        return text + _function(head, parameters, body)


def _in_pieces(head: str, parameters: str, lines: list[Statement]) -> str:
    """A function in several pieces, which share arrays: w of numbers, v of pairs."""
    pieces = [lines[i : i + PIECE] for i in range(0, len(lines), PIECE)]
    piece_of = {line.variable: k for k, piece in enumerate(pieces) for line in piece}
    kinds = {line.variable: "v" if line.pair else "w" for line in lines}
    shared: dict[str, str] = {}
    sizes = {"w": 0, "v": 0}
    for k, piece in enumerate(pieces):
        for name in [name for line in piece for name in line.uses]:
            if piece_of.get(name, k) != k and name not in shared:
                shared[name] = f"{kinds[name]}[{sizes[kinds[name]]}]"
                sizes[kinds[name]] += 1
    used = [p for p in parameters.split(", ") if not p.endswith((" tsim", " isens"))]
    types = {array: "pair" if array == "v" else "double" for array in sizes if sizes[array]}
    given = [*used, *(f"{kind} *restrict {array}" for array, kind in types.items())]
    name = head.split(" ")[-1]
    text = end = ""
    for k, piece in enumerate(pieces):
        body = _read(piece)
        here: set[str | None] = set()
        for line in piece:
            # as late as can be: each is one register less
            for variable in dict.fromkeys(line.uses):
                if variable in shared and piece_of[variable] != k and variable not in here:
                    here.add(variable)
                    kind = types[kinds[variable]]
                    body += f"    const {kind} {variable} = {shared[variable]};\n"
            body += _statement(line)
            if line.variable in shared:
                body += f"    {shared[line.variable]} = {line.variable};\n"
        taken = [p for p in given if _uses(body, p)]
        text += f"PIECE {name}_{k + 1}({', '.join(taken)})\n{{\n{body}}}\n\n"
        end += f"    {name}_{k + 1}({', '.join(map(_name, taken))});\n"
    arrays_shared = "".join(
        f"    {kind} {array}[{sizes[array]}];\n" for array, kind in types.items()
    )
    return text + _function(head, parameters, arrays_shared + end)


def _function(head: str, parameters: str, body: str) -> str:
    """A function, with a line for each parameter that Robotran gives and the body does not use."""
    unused = [p for p in parameters.split(", ") if not _uses(body, p)]
    return f"{head}({parameters})\n{{\n{_voided(unused)}{body}}}\n"


def _voided(parameters: list[str]) -> str:
    return "".join(f"    (void){_name(p)};\n" for p in parameters)


def _name(parameter: str) -> str:
    return parameter.split(" ")[-1].lstrip("*")


def _uses(body: str, parameter: str) -> bool:
    return re.search(rf"\b{_name(parameter)}\b", body) is not None


def _read(lines: list[Statement]) -> str:
    """The arrays of the data that some statements use."""
    return "".join(
        f"    double {'**' if a in TABLES else '*'}{a} = s->{a};\n" for a in arrays(lines)
    )


def _statement(line: Statement) -> str:
    if line.call is not None:
        function = line.call.function.removeprefix("user_")
        return f"    {line.call.result} = USER({function})({', '.join(line.call.arguments)});\n"
    kind = "" if line.variable is None else "const pair " if line.pair else "const double "
    places = [place.replace(".", "->") for place in line.places]
    return f"    {kind}{' = '.join([*places, line.text])};\n"


def _enum(values: dict[str, int]) -> str:
    return f"enum {{{', '.join(f'{name} = {value}' for name, value in values.items())}}};\n"
