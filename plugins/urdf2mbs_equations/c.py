"""The equations in C, for MBsysC.

A long function is split into pieces, which compile faster and run faster::

    PIECE mbs_dirdyna_1(MbsData *s, double *RESTRICT w)      { ... w[0] = x12; ... }
    PIECE mbs_dirdyna_2(double **M, double *RESTRICT w)      { const double x12 = w[0]; ... }
    void mbs_dirdyna(double **M, ...)  { double w[1]; mbs_dirdyna_1(s, w); mbs_dirdyna_2(M, w); }

Variables that several pieces use are elements of an array: ``w`` of numbers, ``v`` of pairs.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from urdf2mbs.plugin import Mbs
from urdf2mbs_equations.followers import Follower
from urdf2mbs_equations.pairs import pair_mirrored
from urdf2mbs_equations.routine import (
    Absent,
    Cases,
    Content,
    Loops,
    OperationCount,
    Refused,
    Routine,
    Statement,
    list_arrays,
)
from urdf2mbs_equations.writer import CASES, Writer

_FORCES = "double **frc, double **trq"
#: The parameters of each function.
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
#: The declarations of user functions.
DECLARATIONS = {
    "user_ExtForces": f"double *USER(ExtForces)({_MOTION});",
    "user_Link3DForces": f"double *USER(Link3DForces)({_MOTION});",
    "user_LinkForces": "double USER(LinkForces)(double Z, double Zd, MbsData *s, double tsim, "
    "int ilnk);",
}

#: The number of statements in a piece.  Of 40 to 1000, 60 to 100 compile and run fastest.
PIECE_LENGTH = 80

#: The arrays of MbsData with two indices.
MATRICES = frozenset(["l", "In", "dpt", "frc", "trq"])

#: accelred of a model without loops.
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

#: The headers that a file includes, by a word in its text.
HEADERS = {"stderr": "<stdio.h>", "memset(": "<string.h>"}
#: The sections of the template that a file begins with, by a word in its text.
MACROS = {"PIECE ": "pieces", "pair ": "pairs"}


class CWriter(Writer):
    """Writes functions for MBsysC."""

    suffix, comment, template, missing_functions = "c", "//", "accelred.c", frozenset()

    def __init__(self, mbs: Mbs, *, pairs: bool = True) -> None:
        super().__init__(mbs)
        self.pairs = pairs

    def write_function(self, name: str, content: Content) -> str:
        """Return the text of a file, without its head."""
        if isinstance(content, Absent | Refused):
            text = self._write_stub(name, content)
        elif isinstance(content, dict):
            text = self._write_cases(name, content)
        elif isinstance(content, Loops):
            lists = ("dependent", "independent") if name == "accelred" else ("dependent",)
            text = self._write_model(content, *lists)
            text += self.read_sections("info", "calls", "forces", "loops", name)
        elif name == "accelred":
            text = self._write_model(None) + self.read_sections("info", "calls", "forces")
            text += self._write_routine("static void accelerations", "MbsData *s", content) + TREE
        else:
            text = self._write_routine(f"void mbs_{name}", PARAMETERS[name], content)
            if self.pairs and content.mirrored:
                text = self._add_pairs(name, content, text)
        return self._write_includes(name, text) + text.rstrip("\n") + "\n"

    def write_followers(self, followers: Sequence[Follower]) -> str:
        """Return the file that moves followers and reduces matrices, without its head."""
        rows = [
            f"    {{{joint}, {leader}, {factor!r}, {offset if k == 0 else 0.0!r}}},\n"
            for joint, factors, offset in followers
            for k, (leader, factor) in enumerate(factors.items())
        ]
        sizes = _write_enum({"JOINTS": len(self.mbs.numbers()), "COUPLINGS": len(rows)})
        table = f"static const Coupling couplings[] = {{\n{''.join(rows)}}};\n\n"
        coupling, functions = self.read_sections("coupling"), self.read_sections("followers")
        return f'#include "mbs_data.h"\n\n{coupling}{sizes}{table}{functions}'

    def _add_pairs(self, name: str, routine: Routine, plain_text: str) -> str:
        """Write a function twice: with pairs for gcc and clang, without for other compilers."""
        self.count = OperationCount()  # that of the function with pairs
        paired = pair_mirrored(routine)
        text = self._write_routine(f"void mbs_{name}", PARAMETERS[name], paired)
        return f"#if HAS_PAIRS\n\n{text}\n#else\n\n{plain_text}\n#endif\n"

    def _write_includes(self, name: str, text: str) -> str:
        """Write the includes and macros that a file needs."""
        headers = "#include <math.h>\n"
        headers += "".join(f"#include {HEADERS[word]}\n" for word in HEADERS if word in text)
        headers += '\n#include "mbs_data.h"\n'
        headers += '#include "mbs_sensor.h"\n' * name.endswith("sensor")
        macros = self.read_sections(*(MACROS[word] for word in MACROS if word in text))
        return f"{headers}\n{macros}"

    def _write_model(self, loops: Loops | None, *lists: str) -> str:
        """Write the tables of the template for this model."""
        features = {name: int(value) for name, value in self.find_features().items()}
        text = _write_enum({"JOINTS": len(self.mbs.numbers()), **features})
        if loops is not None:
            sizes = {
                "DEPENDENT": len(loops.dependent),
                "INDEPENDENT": len(loops.independent),
                "CUTS": loops.n_cut_rows,
                "USER_ROWS": loops.n_user_rows,
                "ROWS": loops.n_cut_rows + loops.n_user_rows,
            }
            text += _write_enum(sizes)
            text += "/* numbers of the joints, the first of each list not being used */\n"
            for name in lists:
                numbers = ", ".join(map(str, [0, *getattr(loops, name)]))
                text += f"static const int {name}[] = {{{numbers}}};\n"
        return text + "\n"

    def _write_stub(self, name: str, content: Absent | Refused) -> str:
        """Write a function that only says why it does nothing."""
        text = f'    fputs("mbs_{name}: {content.message}\\n", stderr);\n    s->flag_stop = 1;\n'
        head = "void"
        if name in ("accelred", "invdynared"):
            head = f"{self.read_sections('info')}int"
            text += "    return MBS_INFO_FAILURE;\n"
        if isinstance(content, Absent):  # only libraries of before 2025 call it
            text = f"#ifndef MBS_BEFORE_2025\n{text}#endif\n"
        text = _mark_unused(PARAMETERS[name].split(", ")) + text
        return f"{head} mbs_{name}({PARAMETERS[name]})\n{{\n{text}}}\n"

    def _write_cases(self, name: str, cases: Cases) -> str:
        """Write a function that calls another routine for each number."""
        text = choices = ""
        for number, routine in cases.items():
            case = f"mbs_{name}_{number}"
            text += self._write_routine(
                f"static void {case}", "MbsSensor *sens, MbsData *s", routine
            )
            text += "\n"
            choices += f"    case {number}:\n        {case}(sens, s);\n        break;\n"
        body = (
            f"    switch (isens) {{\n{choices}"
            f'    default:\n        fprintf(stderr, "mbs_{name}: the model has no {CASES[name]} '
            f'%d: it has {len(cases)}\\n", isens);\n'
            "        s->flag_stop = 1;\n        break;\n    }\n"
        )
        return text + _write_function(f"void mbs_{name}", PARAMETERS[name], body)

    def _write_routine(self, head: str, parameters: str, routine: Routine) -> str:
        """Write a function; ``head`` ends with its name."""
        statements = self.make_statements(routine)
        calls = [statement.call for statement in statements if statement.call is not None]
        if len(statements) > PIECE_LENGTH and not calls:
            return _write_in_pieces(head, parameters, statements)
        text = body = ""
        if calls:
            functions = sorted({call.function for call in calls})
            declarations = "".join(f"{DECLARATIONS[function]}\n" for function in functions)
            text = f"{self.read_sections('calls')}{declarations}\n"
        for call in calls:
            pointer = "" if call.function == "user_LinkForces" else "*"
            body += f"    double {pointer}{call.result};\n"
            for array in call.arguments[:6] if pointer else ():
                size = "[4][4] = {{0.0}}" if array.startswith("Rx") else "[4] = {0.0}"
                body += f"    double {array}{size};\n"
        body += _read_arrays(statements) + "".join(map(_write_statement, statements))
        return text + _write_function(head, parameters, body)


class _SharedVariable(NamedTuple):
    """A variable that one piece computes and others use."""

    type: str
    element: str
    """Where it is, such as ``w[3]``."""


#: The arrays of shared variables, by the type of their elements.
SHARED_ARRAYS = {"double": "w", "pair": "v"}


def _write_in_pieces(head: str, parameters: str, statements: list[Statement]) -> str:
    """Write a function as pieces of ``PIECE_LENGTH`` statements."""
    pieces = [
        statements[start : start + PIECE_LENGTH]
        for start in range(0, len(statements), PIECE_LENGTH)
    ]
    shared = _find_shared(pieces)
    sizes = {
        kind: sum(variable.type == kind for variable in shared.values()) for kind in SHARED_ARRAYS
    }
    arrays = {kind: array for kind, array in SHARED_ARRAYS.items() if sizes[kind]}
    available = [p for p in parameters.split(", ") if not p.endswith((" tsim", " isens"))]
    available += [f"{kind} *RESTRICT {array}" for kind, array in arrays.items()]
    name = head.split(" ")[-1]
    text = "".join(f"    {kind} {array}[{sizes[kind]}];\n" for kind, array in arrays.items())
    functions = ""
    for number, piece in enumerate(pieces, start=1):
        body = _write_piece(piece, shared)
        used = [parameter for parameter in available if _uses(body, parameter)]
        functions += f"PIECE {name}_{number}({', '.join(used)})\n{{\n{body}}}\n\n"
        text += f"    {name}_{number}({', '.join(map(_get_name, used))});\n"
    return functions + _write_function(head, parameters, text)


def _find_shared(pieces: list[list[Statement]]) -> dict[str, _SharedVariable]:
    """Find the variables that are used in other pieces than the one that computes them."""
    piece_of = {line.variable: number for number, piece in enumerate(pieces) for line in piece}
    types = {
        line.variable: "pair" if line.is_pair else "double" for piece in pieces for line in piece
    }
    shared: dict[str, _SharedVariable] = {}
    sizes = dict.fromkeys(SHARED_ARRAYS, 0)
    for number, piece in enumerate(pieces):
        for name in [name for line in piece for name in line.uses]:
            if piece_of.get(name, number) != number and name not in shared:
                kind = types[name]
                shared[name] = _SharedVariable(kind, f"{SHARED_ARRAYS[kind]}[{sizes[kind]}]")
                sizes[kind] += 1
    return shared


def _write_piece(statements: list[Statement], shared: dict[str, _SharedVariable]) -> str:
    """Write the body of a piece.

    A shared variable is read just before its first use, so that it needs no register earlier.
    """
    body = _read_arrays(statements)
    computed_here = {line.variable for line in statements}
    is_read: set[str] = set()
    for line in statements:
        for name in dict.fromkeys(line.uses):
            if name in shared and name not in computed_here and name not in is_read:
                is_read.add(name)
                body += f"    const {shared[name].type} {name} = {shared[name].element};\n"
        body += _write_statement(line)
        if line.variable in shared:
            body += f"    {shared[line.variable].element} = {line.variable};\n"
    return body


def _write_function(head: str, parameters: str, body: str) -> str:
    """Write a function; parameters of Robotran's signature that it does not use are marked."""
    unused = [parameter for parameter in parameters.split(", ") if not _uses(body, parameter)]
    return f"{head}({parameters})\n{{\n{_mark_unused(unused)}{body}}}\n"


def _mark_unused(parameters: list[str]) -> str:
    return "".join(f"    (void){_get_name(parameter)};\n" for parameter in parameters)


def _get_name(parameter: str) -> str:
    return parameter.split(" ")[-1].lstrip("*")


def _uses(body: str, parameter: str) -> bool:
    return re.search(rf"\b{_get_name(parameter)}\b", body) is not None


def _read_arrays(statements: list[Statement]) -> str:
    """Write the declarations of the arrays of MbsData that statements read."""
    return "".join(
        f"    double {'**' if array in MATRICES else '*'}{array} = s->{array};\n"
        for array in list_arrays(statements)
    )


def _write_statement(statement: Statement) -> str:
    call = statement.call
    if call is not None:
        function = call.function.removeprefix("user_")
        return f"    {call.result} = USER({function})({', '.join(call.arguments)});\n"
    declaration = ""
    if statement.variable is not None:
        declaration = "const pair " if statement.is_pair else "const double "
    targets = [target.replace(".", "->") for target in statement.targets]
    return f"    {declaration}{' = '.join([*targets, statement.text])};\n"


def _write_enum(values: dict[str, int]) -> str:
    return f"enum {{{', '.join(f'{name} = {value}' for name, value in values.items())}}};\n"
