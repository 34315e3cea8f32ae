"""The equations in JavaScript, for a page on which the robot moves."""

from __future__ import annotations

from urdf2mbs.equations.python import FUNCTIONS
from urdf2mbs.equations.routine import Loops, Made, Routine, Statement, arrays
from urdf2mbs.equations.writer import PIECE, Writer, crossing


class JavaScriptWriter(Writer):
    """Functions of Python's names and parameters, in the object ``equations``.

    Arrays are as in Python: they count from 1, and a table is an array of rows.
    """

    suffix, comment = "js", "//"

    def function(self, name: str, made: Made) -> str:
        """The text of a file below its header; nothing where a model needs no such function."""
        if isinstance(made, Loops):
            return "".join(
                f"equations.{key} = {getattr(made, key)};\n"
                for key in ("dependent", "independent", "driven", "cuts", "user")
            )
        if not isinstance(made, Routine):
            return ""
        lines = self.statements(made)
        pieces = [lines[i : i + PIECE] for i in range(0, len(lines), PIECE)]
        parameters = FUNCTIONS[name][0]
        places = {variable: f"w[{k}]" for k, variable in enumerate(crossing(pieces))}
        text = "".join(map(_memory, lines))
        for k, piece in enumerate(pieces, start=1):
            text += f"function {name}_{k}({parameters}, w) {{\n{_piece(piece, places)}}}\n"
        calls = "".join(f"  {name}_{k}({parameters}, w);\n" for k in range(1, len(pieces) + 1))
        return (
            f"equations.{name} = (() => {{\n{text}const w = new Float64Array({len(places)});\n"
            f"return ({parameters}) => {{\n{calls}}};\n}})();\n"
        )


def _memory(line: Statement) -> str:
    """What a user function is given and what it returns, declared once for all calls."""
    if line.call is None:
        return ""
    text = f"let {line.call.result};\n"
    for array in line.call.arguments[:6] if line.call.function != "user_LinkForces" else ():
        row = "new Float64Array(4)"
        rows = f"[0, 1, 2, 3].map(() => {row})" if array.startswith("Rx") else row
        text += f"const {array} = {rows};\n"
    return text


def _piece(piece: list[Statement], places: dict[str, str]) -> str:
    """The body of a function, which shares ``w`` with others."""
    names = arrays(piece)
    text = f"  const {{{', '.join(names)}}} = s;\n" if names else ""
    here = {line.variable for line in piece}
    for line in piece:
        for variable in line.uses:
            if variable in places and variable not in here:
                here.add(variable)
                text += f"  const {variable} = {places[variable]};\n"
        if line.call is not None:
            arguments = ", ".join(line.call.arguments)
            text += f"  {line.call.result} = s.{line.call.function}({arguments});\n"
        else:
            targets = [*line.places, places.get(line.variable or "", "")]
            kind = "" if line.variable is None else "const "
            text += f"  {kind}{' = '.join(filter(None, [*targets, line.text]))};\n"
    return text
