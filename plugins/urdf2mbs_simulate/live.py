"""The live robot of a page: the C of a simulation as WebAssembly, and the numbers it starts from.

The page's script is ``live.js``; what it calls is ``live.c``.
"""

from __future__ import annotations

import gzip
from base64 import b64encode
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs_report.script import Script
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.compiler import HERE, Build, Source, zig
from urdf2mbs_simulate.dirdyn import FIRST_STEP, OPTIONS, OURS, choose_code, choose_tolerances
from urdf2mbs_simulate.memory import MORE_ROWS, ROWS, TABLES
from urdf2mbs_simulate.partition import part
from urdf2mbs_simulate.python_code import MbsData, loaded, shown
from urdf2mbs_simulate.results import Results

#: What the page calls.
EXPORTS = ("room", "begin", "restart", "go", "pull_at")
TARGET = ("-target", "wasm32-wasi", "-msimd128")
LINK = (
    *TARGET,
    "-mexec-model=reactor",
    "-Wl,-s",
    "-Wl,-z,stack-size=4194304",
    *(f"-Wl,--export={name}" for name in EXPORTS),
)
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


def make_live(
    results: Results,
    *,
    step: float | None = None,
    on_compile: Callable[[int, int], None] | None = None,
) -> Live | str:
    """The robot of a run, from the run's start; or why it cannot live.

    ``step``: take steps of this length (s), whatever their error.  Raises ConversionError where
    the C of the project cannot be compiled.
    """
    compiler = zig()
    if compiler is None:
        return HINT
    data = MbsData(results.data._run.file)
    data._run.user_constraints = results.data._run.user_constraints
    with loaded(data), shown(data):
        code = choose_code(data, None)
        if not code.in_c and [*data.user_path.glob("user_*")]:
            return "the robot cannot be pulled and dropped, as its user functions are in Python"
        part(code)
    for name in ("q", "qd", "ux"):
        getattr(data, name)[1:] = results.kept[name][0, 1:]
    last = code.sources[-1]
    sources = [*code.sources, Source(HERE / "live.c", last.folders, last.defines)]
    file = Build(compiler, TARGET, LINK, ".wasm", on_compile).make(sources)
    numbers, places = _packed(code, step)
    bodies = {joint: body for body, joint in data.body_id.items()}
    forces = [bodies.get(joint) for joint in code.last_joint[1:]]
    more = {
        "places": places,
        "forces": forces,
        "states": data.Nux,
        "floats": bool(code.run.can_turn),
    }
    return Live(file.read_bytes(), numbers, more)


def _packed(code: CCode, step: float | None) -> tuple[Any, dict[str, int]]:
    data = code.data
    rtol, atol = choose_tolerances(OURS, *((None, None) if step is None else (1e9, 1e9)))
    settings = [
        data.nqu,
        data.nqv,
        code.run.can_turn,
        code.has_loop and not data.nqv,
        step or FIRST_STEP,
        step or OPTIONS["dt_max"],
        rtol,
        atol,
    ]
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
    put(code.state_scale)
    for integers in (data.qu, data.qv, data.xfidpt, code.last_joint, code.kept + 1):
        put(integers)
    return np.array(numbers, float), places
