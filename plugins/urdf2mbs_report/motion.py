"""The motion of a simulated project, for its page: resultsR/dirdyn.csv at 60 frames/s at most."""

from __future__ import annotations

import csv
import re
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.mbs.model import Mbs

#: Frames a second of the page.
RATE = 60.0


def motion(model: Mbs, project: Path, file: str = "dirdyn.csv") -> dict[str, Any] | None:
    """Times (s), joint positions (rad, m), forces (N) and energies (J) of a run, by itself the last
    of the project.

    Numbers are little-endian float32 in base64, a row for each frame.  Forces are the external ones
    and then the pushes, each with Fx, Fy, Fz in the axes of the base, and dx, dy, dz (m), its point
    in the axes of its body.  None if there is no file, or if the file is of other joints.
    """
    try:
        with (project / "resultsR" / file).open(encoding="utf-8", newline="") as text:
            rows = csv.reader(text)
            head = {name: k for k, name in enumerate(next(rows, []))}
            table = np.array([[float(cell) for cell in row] for row in rows])
    except (OSError, ValueError):
        return None
    joints = list(model.numbers())
    if {name for name in head if name.startswith("q.")} != {f"q.{name}" for name in joints}:
        return None
    if table.ndim != 2 or not len(table) or not np.isfinite(table[:, head["time"]]).all():
        return None
    table = _thinned(table, head["time"])
    forces = [
        (body.name, point.extforce.name, False)
        for body in model.bodies
        for point in body.points
        if point.extforce is not None and f"{point.extforce.name}.Fx" in head
    ]
    pushes = (re.fullmatch(r"(push\d+\.(.+))\.Fx", name) for name in head)
    forces += [(push[2], push[1], True) for push in pushes if push]
    parts = ("Fx", "Fy", "Fz", "dx", "dy", "dz")
    columns = [head[f"{name}.{part}"] for _, name, _ in forces for part in parts]
    energies = [head[name] for name in ("energy.kinetic", "energy.potential") if name in head]
    return {
        "joints": joints,
        "forces": forces,
        "time": _packed(table[:, [head["time"]]]),
        "q": _packed(table[:, [head[f"q.{name}"] for name in joints]]),
        "F": _packed(table[:, columns]),
        "E": _packed(table[:, energies]),
    }


def _thinned(table: Any, column: int) -> Any:
    """The rows that are at least a frame apart, and the last row."""
    kept, last = [], -np.inf
    for k, time in enumerate(table[:, column]):
        if time - last >= 1.0 / RATE - 1e-9 or k == len(table) - 1:
            kept.append(k)
            last = time
    return table[kept]


def _packed(values: Any) -> str:
    return b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode()
