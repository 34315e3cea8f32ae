"""The interactive robot of a page: the C of a simulation as WebAssembly, and its start.

The page's script is ``live.js``; it calls ``live.c``.
"""

from __future__ import annotations

import gzip
from base64 import b64encode
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs_report.script import Script
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.compiler import HERE, Build, BuildFlags, OnCompile, Source, find_zig
from urdf2mbs_simulate.dirdyn import load_code
from urdf2mbs_simulate.memory import OTHER_VECTORS, STATE_VECTORS, TABLES
from urdf2mbs_simulate.partition import choose_partition
from urdf2mbs_simulate.python_code import MbsData, locate_errors, user_code
from urdf2mbs_simulate.results import Results
from urdf2mbs_simulate.solvers import FIRST_STEP, OPTIONS, OURS, choose_tolerances

#: The functions that the page calls.
EXPORTS = ("room", "begin", "restart", "go", "pull_at")
TARGET = ("-target", "wasm32-wasi", "-msimd128")
LINK = (
    *TARGET,
    "-mexec-model=reactor",
    "-Wl,-s",
    "-Wl,-z,stack-size=4194304",
    *(f"-Wl,--export={name}" for name in EXPORTS),
)
#: How to get an interactive robot, where no compiler makes WebAssembly.
HINT = "pip install ziglang brings the compiler for a page whose robot can be pulled and dropped"


class LiveRobot(NamedTuple):
    """An interactive robot."""

    code: bytes
    """WebAssembly of ``live.c`` and the files that it uses."""
    numbers: Any
    """The start, in the layout that ``begin`` of ``live.c`` unpacks."""
    data: dict[str, Any]
    """For ``live.js``: the places of q, qd, ... in the numbers, each with index 0, and more."""

    def script(self) -> Script:
        """Return the module of the page."""
        code = gzip.compress(self.code, mtime=0)
        encoded = {
            "code": b64encode(code),
            "numbers": b64encode(self.numbers.astype("<f8").tobytes()),
        }
        data = self.data | {name: text.decode() for name, text in encoded.items()}
        return Script((HERE / "live.js").read_text("utf-8"), data)


def make_live(
    results: Results, *, step: float | None = None, on_compile: OnCompile | None = None
) -> LiveRobot | str:
    """Make the interactive robot of a run, from the run's start.

    Args:
        results: Of the run.
        step: The length (s) of all steps, whatever their error; by default the error decides.
        on_compile: Called with the numbers of compiled files and of all files.

    Returns:
        The robot, or a sentence that says why it is not interactive.

    Raises:
        ConversionError: The C of the project does not compile.
    """
    zig = find_zig()
    if zig is None:
        return HINT
    data = MbsData(results.data._run.file)
    data._run.user_constraints = results.data._run.user_constraints
    with user_code(data), locate_errors(data):
        code = load_code(data, None)
        if not code.has_user_c and any(data.user_path.glob("user_*")):
            return "the robot cannot be pulled and dropped, as its user functions are in Python"
        choose_partition(code)
    for name in ("q", "qd", "ux"):
        getattr(data, name)[1:] = results.frames[name][0, 1:]
    last = code.sources[-1]
    sources = [*code.sources, Source(HERE / "live.c", last.folders, last.defines)]
    file = Build(zig, BuildFlags(TARGET, LINK, ".wasm"), on_compile).make(sources)
    numbers, places = _pack(code, step)
    bodies = {joint: body for body, joint in data.body_id.items()}
    more = {
        "places": places,
        "forces": [bodies.get(joint) for joint in code.last_joint[1:]],
        "states": data.Nux,
        "floats": bool(code.run.can_turn),
    }
    return LiveRobot(file.read_bytes(), numbers, more)


class _Packer:
    """Packs rows and tables one after the other, each with its length before it."""

    def __init__(self) -> None:
        self.numbers: list[float] = []

    def put_row(self, values: Any) -> int:
        """Append a row; return the index of its first value."""
        self.numbers.extend([len(values), *values])
        return len(self.numbers) - len(values)

    def put_table(self, rows: Any) -> int:
        """Append a table; return the index of its first value."""
        self.numbers.append(len(rows))
        places = [self.put_row(row) for row in rows]
        return places[0]


def _pack(code: CCode, step: float | None) -> tuple[Any, dict[str, int]]:
    """Return the start as numbers, in the order of ``begin`` in ``live.c``, and their places."""
    data, packer = code.data, _Packer()
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
    packer.put_row(settings)
    vectors = (*STATE_VECTORS, *OTHER_VECTORS, "qd0", "Lambda")
    places = {name: packer.put_row(getattr(data, name)) for name in vectors}
    packer.put_row(data.q[code.dependent])
    tables = (*TABLES, "SWr", "l3DWr")
    places |= {name: packer.put_table(getattr(data, name)) for name in tables}
    packer.put_table(data.dpt)
    packer.put_row(data.g)
    user_model = packer.put_row(code.user_model)
    parameters = code.list_parameters()
    if ("hold", "on") in parameters:
        places["hold"] = user_model + parameters.index(("hold", "on"))
    packer.put_row(code.state_scale)
    for integers in (data.qu, data.qv, data.xfidpt, code.last_joint, code.used_rows + 1):
        packer.put_row(integers)
    return np.array(packer.numbers, float), places
