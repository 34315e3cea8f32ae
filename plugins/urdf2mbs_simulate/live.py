"""The live robot of a page: the C of a simulation as WebAssembly, and the numbers it starts from.

The page's script is ``live.js``; what it calls is ``live.c``.
"""

from __future__ import annotations

import gzip
from base64 import b64encode
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs_report.page import Script
from urdf2mbs_simulate.c_code import HERE, MORE_ROWS, ROWS, TABLES, CCode, build, zig
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.dirdyn import OPTIONS, TOLERANCES, choose_code
from urdf2mbs_simulate.partition import part
from urdf2mbs_simulate.python_code import loaded, shown
from urdf2mbs_simulate.results import Results
from urdf2mbs_simulate.turn import can_turn

#: What the page calls.
EXPORTS = ("room", "begin", "restart", "go", "pull_at")
FLAGS = (
    "-target", "wasm32-wasi", "-mexec-model=reactor", "-msimd128",
    "-Wl,-s", "-Wl,-z,stack-size=4194304",
    *(f"-Wl,--export={name}" for name in EXPORTS),
)  # fmt: skip
#: What to do for a robot that lives.
HINT = "pip install 'urdf2mbs[live]' brings the compiler for a robot that can be pulled and dropped"


class Live(NamedTuple):
    """A robot that moves by itself."""

    code: bytes
    """WebAssembly of ``live.c`` and all that it needs."""
    numbers: Any
    """What ``live.c`` unpacks."""
    data: dict[str, Any]
    """For ``live.js``: where q, qd, ... begin in the numbers, each with index 0, and more."""

    def script(self) -> Script:
        """The module of the page."""
        code = gzip.compress(self.code, mtime=0)
        packed = {
            "code": b64encode(code),
            "numbers": b64encode(self.numbers.astype("<f8").tobytes()),
        }
        data = self.data | {name: text.decode() for name, text in packed.items()}
        return Script((HERE / "live.js").read_text("utf-8"), data)


def make_live(results: Results, *, step: float | None = None) -> Live | str:
    """The robot of a run, from the run's start; or why it cannot live.

    ``step``: take steps of this length (s), whatever their error.  Raises ConversionError where
    the C of the project cannot be compiled.
    """
    compiler = zig()
    if compiler is None:
        return HINT
    data = MbsData(results.data.mbs_file)
    data.user_constraints = results.data.user_constraints
    with loaded(data), shown(data):
        code = choose_code(data, None)
        if not isinstance(code, CCode) or not (code.in_c or not [*data.user_path.glob("user_*")]):
            return "the robot cannot be pulled and dropped, as its user functions are in Python"
        part(code)
    for name in ("q", "qd", "ux"):
        getattr(data, name)[1:] = results.kept[name][0, 1:]
    sources, defines = code.sources
    file = build(data, [*sources, HERE / "live.c"], [*FLAGS, *defines], compiler, ".wasm")
    numbers, places = _packed(code, step)
    bodies = {joint: body for body, joint in data.body_id.items()}
    forces = [bodies.get(joint) for joint in code.last_joint[1:]]
    more = {"places": places, "forces": forces, "states": data.Nux, "floats": can_turn(data)}
    return Live(file.read_bytes(), numbers, more)


def _packed(code: CCode, step: float | None) -> tuple[Any, dict[str, int]]:
    data = code.data
    rtol, atol = TOLERANCES[True] if step is None else (1e9, 1e9)
    settings = [
        data.nqu, data.nqv, can_turn(data), code.has_loop and not data.nqv,
        step or OPTIONS["dt0"], step or OPTIONS["dt_max"], rtol, atol,
    ]  # fmt: skip
    numbers: list[float] = []

    def put(values: Any) -> int:
        numbers.extend([len(values), *values])
        return len(numbers) - len(values)

    def put_table(rows: Any) -> int:
        numbers.append(len(rows))
        places = [put(row) for row in rows]
        return places[0]

    put(settings)
    places = {name: put(getattr(data, name)) for name in (*ROWS, *MORE_ROWS, "qd0", "Lambda")}
    put(data.q[code.dependent])
    places |= {name: put_table(getattr(data, name)) for name in (*TABLES, "SWr", "l3DWr")}
    put_table(data.dpt)
    put(data.g)
    model = put(code.model)
    if ("hold", "on") in (parameters := code.parameters()):
        places["hold"] = model + parameters.index(("hold", "on"))
    for integers in (data.qu, data.qv, data.xfidpt, code.last_joint, code.kept + 1):
        put(integers)
    return np.array(numbers, float), places
