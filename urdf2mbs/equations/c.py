"""The equations in C, in pieces that a compiler makes short work of."""

from __future__ import annotations

from urdf2mbs.equations.pairs import in_pairs
from urdf2mbs.equations.routine import Call, Cases, Loops, Piece, Routine, Statement, arrays
from urdf2mbs.equations.writer import CASES, Writer
from urdf2mbs.mbs.model import Mbs

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
    suffix, comment, template = "c", "//", "accelred.c"
    before = ("model", "info", "calls", "forces")
    end = ";"
    #: gcc takes several times as long for all in one function, and of 40, 60, 100, 300 and 1000
    #: statements those of 60 and 100 run fastest.
    piece = 80

    def __init__(self, mbs: Mbs, *, pairs: bool = True) -> None:
        super().__init__(mbs)
        self.pairs = pairs

    def top(self, name: str, text: str) -> str:
        out = "#include <math.h>\n"
        if "stderr" in text:
            out += "#include <stdio.h>\n"
        if "malloc(" in text:
            out += "#include <stdlib.h>\n"
        out += '\n#include "mbs_data.h"\n'
        if name.endswith("sensor"):
            out += '#include "mbs_sensor.h"\n'
        out += "\n"
        if "PIECE " in text:
            out += PIECE_MACRO
        if "pair " in text:
            out += PAIR_TYPE
        return out

    def model(self, loops: Loops | None) -> str:
        facts = {name: int(value) for name, value in self.facts().items()}
        text = _enum({"JOINTS": len(self.mbs.numbers()), **facts})
        if loops is not None:
            text += _enum(
                {"DEPENDENT": len(loops.dependent), "INDEPENDENT": len(loops.independent),
                 "DRIVEN": len(loops.driven), "CUTS": loops.cuts, "USER_ROWS": loops.user}
            )  # fmt: skip
            text += "/* numbers of the joints, the first of each list not being used */\n"
            for name in ("dependent", "independent", "driven"):
                numbers = ", ".join(map(str, [0, *getattr(loops, name)]))
                text += f"static const int {name}[] = {{{numbers}}};\n"
        return text + "\n"

    def stub(self, name: str, message: str, *, needed: bool) -> str:
        text = f'    fputs("mbs_{name}: {message}\\n", stderr);\n    s->flag_stop = 1;\n'
        head = "void"
        if name in ("accelred", "invdynared"):
            head, text = self.common(None, "info") + "int", text + "    return MBS_INFO_FAILURE;\n"
        if not needed:
            text = f"#ifndef MBS_BEFORE_2025\n{text}#endif\n"
        return f"{head} mbs_{name}({PARAMETERS[name]})\n{{\n{text}}}\n"

    def routine(self, name: str, routine: Routine) -> str:
        if self.pairs and routine.alike:
            routine = in_pairs(routine, routine.alike)
        return self.write(f"mbs_{name}", PARAMETERS[name], routine, start="void ")

    def tree(self, routine: Routine) -> str:
        return self.write("accelerations", "MbsData *s", routine, start="static void ") + TREE

    def cases(self, name: str, cases: Cases) -> str:
        text, parameters = "", "MbsSensor *sens, MbsData *s"
        choice = ""
        for number, routine in cases.routines.items():
            text += self.write(f"mbs_{name}_{number}", parameters, routine, start="static void ")
            text += "\n"
            choice += f"    case {number}:\n        mbs_{name}_{number}(sens, s);\n        break;\n"
        return text + (
            f"void mbs_{name}({PARAMETERS['sensor']})\n{{\n    switch (isens) {{\n{choice}"
            f'    default:\n        fprintf(stderr, "mbs_{name}: the model has no {CASES[name]} '
            f'%d: it has {len(cases.routines)}\\n", isens);\n'
            "        s->flag_stop = 1;\n        break;\n    }\n}\n"
        )

    def whole(
        self, name: str, parameters: str, lines: list[Statement], doc: str, start: str
    ) -> str:
        calls = [line.call for line in lines if line.call is not None]
        text = ""
        if calls:
            functions = sorted({call.function for call in calls})
            declared = "".join(f"{USER[function]}\n" for function in functions)
            text = f"{self.common(None, 'calls')}{declared}\n"
        text += f"{start}{name}({parameters})\n{{\n"
        for call in calls:
            pointer = "" if call.function == "user_LinkForces" else "*"
            text += f"    double {pointer}{call.result};\n"
            for array in call.arguments[:6] if pointer else ():
                size = "[4][4] = {{0.0}}" if array.startswith("Rx") else "[4] = {0.0}"
                text += f"    double {array}{size};\n"
        return text + self._body(lines) + "}\n"

    def in_pieces(
        self, name: str, parameters: str, pieces: list[Piece], sizes: dict[str, int],
        doc: str, start: str,
    ) -> str:  # fmt: skip
        used = [p for p in parameters.split(", ") if not p.endswith((" tsim", " isens"))]
        kinds = {array: "pair" if array == "v" else "double" for array in sizes}
        given = ", ".join([*used, *(f"{kinds[array]} *restrict {array}" for array in sizes)])
        passed = ", ".join([*(p.split(" ")[-1].lstrip("*") for p in used), *sizes])
        text = ""
        for number, piece in enumerate(pieces, start=1):
            text += f"PIECE {name}_{number}({given})\n{{\n{self._body(piece.lines, piece)}}}\n\n"
        text += f"{start}{name}({parameters})\n{{\n"
        for array, size in sizes.items():
            text += f"    {kinds[array]} {array}[{size}];\n"
        text += "".join(f"    {name}_{i}({passed});\n" for i in range(1, len(pieces) + 1))
        return text + "}\n"

    def _body(self, lines: list[Statement], piece: Piece | None = None) -> str:
        read = [f"    double {'**' if a in TABLES else '*'}{a} = s->{a};" for a in arrays(lines)]
        return "".join(f"{line}\n" for line in [*read, *self.body(lines, piece)])

    def variable(self, name: str, text: str, *, pair: bool) -> str:
        return f"const {'pair' if pair else 'double'} {name} = {text}"

    def place(self, place: str) -> str:
        return place.replace(".", "->")

    def call(self, call: Call) -> str:
        function = call.function.removeprefix("user_")
        return f"{call.result} = USER({function})({', '.join(call.arguments)})"


def _enum(values: dict[str, int]) -> str:
    return f"enum {{{', '.join(f'{name} = {value}' for name, value in values.items())}}};\n"
