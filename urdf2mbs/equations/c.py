"""The equations in C, in pieces that a compiler makes short work of."""

from __future__ import annotations

from urdf2mbs.equations.c_accelred import ACCELRED, REFUSED, closed, prelude
from urdf2mbs.equations.c_names import PARAMETERS, declarations
from urdf2mbs.equations.loops import Loops, Refused
from urdf2mbs.equations.pairs import in_pairs
from urdf2mbs.equations.routine import (
    Call,
    Cases,
    Count,
    Piece,
    Routine,
    Statement,
    arrays,
    split,
    statements,
)
from urdf2mbs.mbs.model import Mbs

#: So many statements are one function: gcc takes several times as long for all in one, and of
#: 40, 60, 100, 300 and 1000 those of 60 and 100 run fastest.
PIECE = 80

#: The arrays of MbsData with two indices.
TABLES = frozenset(["l", "In", "dpt", "frc", "trq"])

PIECE_MACRO = """\
#if defined(__GNUC__) || defined(__clang__)
#define PIECE static __attribute__((noinline)) void
#else
#define PIECE static void
#endif
"""

#: What is done for two mirrored limbs at a time.
PAIR_TYPE = """\
#if defined(__GNUC__) || defined(__clang__)
typedef double pair __attribute__((vector_size(16)));
#else
#error "pairs are for gcc and clang: generate with --no-pairs, or equations: {pairs: false}"
#endif
#define PAIR(x, y) ((pair) {(x), (y)})

"""


class Writer:
    def __init__(self, mbs: Mbs, *, pairs: bool = True) -> None:
        self.mbs, self.pairs = mbs, pairs

    def function(self, name: str, made: Routine | Cases | Loops | Refused) -> tuple[str, Count]:
        """The text of a file below its header, and what was counted."""
        includes = ["#include <math.h>", "", '#include "mbs_data.h"']
        if name.endswith("sensor"):
            includes.append('#include "mbs_sensor.h"')
        top = "\n".join(includes) + "\n\n"
        whole = f"mbs_{name}"
        if isinstance(made, Cases):
            text, count = self._cases(whole, made)
        elif isinstance(made, Loops):
            text, count = prelude(self.mbs) + closed(made), Count()
        elif isinstance(made, Refused):
            text, count = REFUSED, Count()
        elif name == "accelred":
            text, count = self._accelred(made)
        else:
            text, count = self._routine(whole, PARAMETERS[name], made)
        return top + text, count

    def _routine(
        self, name: str, parameters: str, made: Routine, kind: str = "void"
    ) -> tuple[str, Count]:
        if self.pairs and made.alike:
            made = in_pairs(made, made.alike)
        lines, count = statements(made)
        calls = [line.call for line in lines if line.call is not None]
        if calls or len(lines) <= PIECE:
            text = declarations(sorted({call.function for call in calls}))
            text += PAIR_TYPE * any(line.pair for line in lines)
            text += f"{kind} {name}({parameters})\n{{\n"
            text += "".join(f"    {line}\n" for call in calls for line in _declared(call))
            text += _body(lines)
            return text + "}\n", count
        used = [one for one in parameters.split(", ") if not one.endswith((" tsim", " isens"))]
        pieces, sizes = split(lines, PIECE)
        shared = [f"{'pair' if array == 'v' else 'double'} *restrict {array}" for array in sizes]
        taken = ", ".join([*used, *shared])
        passed = ", ".join([*(one.split(" ")[-1].lstrip("*") for one in used), *sizes])
        text = PIECE_MACRO + "\n" + PAIR_TYPE * any(line.pair for line in lines)
        for number, piece in enumerate(pieces, start=1):
            text += f"PIECE {name}_{number}({taken})\n{{\n{_body(piece.lines, piece)}}}\n\n"
        text += f"{kind} {name}({parameters})\n{{\n"
        for array, size in sizes.items():
            text += f"    {'pair' if array == 'v' else 'double'} {array}[{size}];\n"
        text += "".join(f"    {name}_{i}({passed});\n" for i in range(1, len(pieces) + 1))
        return text + "}\n", count

    def _cases(self, name: str, cases: Cases) -> tuple[str, Count]:
        text, total = "", Count()
        macro = False
        for number, routine in cases.routines.items():
            one, count = self._routine(
                f"{name}_{number}", "MbsSensor *sens, MbsData *s", routine, "static void"
            )
            if one.startswith(PIECE_MACRO):
                one = one if not macro else one[len(PIECE_MACRO) + 1 :]
                macro = True
            text, total = text + one + "\n", total + count
        text += f"void {name}({PARAMETERS['sensor']})\n{{\n    switch (isens) {{\n"
        for number in cases.routines:
            text += f"    case {number}:\n        {name}_{number}(sens, s);\n        break;\n"
        return text + "    default:\n        break;\n    }\n}\n", total

    def _accelred(self, made: Routine) -> tuple[str, Count]:
        text, count = self._routine("accelerations", "MbsData *s", made, "static void")
        return text + "\n" + prelude(self.mbs) + ACCELRED, count


def _declared(call: Call) -> list[str]:
    """The variables that a call takes and gives."""
    name = call.function.removeprefix("user_")
    if name == "LinkForces":
        return [f"double {call.result};"]
    out = [f"double *{call.result};"]
    for array in call.arguments[:6]:
        size = "[4][4] = {{0.0}}" if array.startswith("Rx") else "[4] = {0.0}"
        out.append(f"double {array}{size};")
    return out


def _body(lines: list[Statement], piece: Piece | None = None) -> str:
    takes, gives = (dict(piece.takes), piece.gives) if piece else ({}, {})
    out = [f"    double {'**' if a in TABLES else '*'}{a} = s->{a};" for a in arrays(lines)]
    for line in lines:
        # as late as can be: each is one register less
        for name in dict.fromkeys(line.uses):
            if name in takes:
                place = takes.pop(name)
                out.append(f"    const {'pair' if place[0] == 'v' else 'double'} {name} = {place};")
        if line.call is not None:
            call = line.call
            name = call.function.removeprefix("user_")
            out.append(f"    {call.result} = USER({name})({', '.join(call.arguments)});")
        elif line.variable is not None:
            kind = "pair" if line.pair else "double"
            out.append(f"    const {kind} {line.variable} = {line.text};")
            if line.variable in gives:
                out.append(f"    {gives[line.variable]} = {line.variable};")
        else:
            places = " = ".join(place.replace(".", "->") for place in line.places)
            out.append(f"    {places} = {line.text};")
    return "\n".join(out) + "\n" if out else ""
