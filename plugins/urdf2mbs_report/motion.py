"""The motion of a simulated project, for its page: resultsR/dirdyn.csv at 60 frames/s at most."""

from __future__ import annotations

import csv
import re
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.plugin import Mbs, some

#: Frames a second of the page.
RATE = 60.0


#: What the page has of a force: the force, and where it acts in the frame of its body.
FORCE = ("Fx", "Fy", "Fz", "dx", "dy", "dz")


class MotionError(Exception):
    """A file of results that cannot be played, and why, in plain words."""


def motion(model: Mbs, project: Path, file: str = "dirdyn.csv") -> dict[str, Any] | None:
    """Return the times, positions, forces and energies of a run, by default the last one.

    Numbers are little-endian float32 in base64, a row for each frame: times (s), joint positions
    (rad, m), forces (N) and energies (J).  Forces are the external ones and then the pushes, each
    with Fx, Fy, Fz in the axes of the base, and dx, dy, dz (m), its point in the axes of its body.

    Returns:
        The motion; None if there is no file.

    Raises:
        MotionError: The file is broken, or of other joints.
    """
    results = _read(project / "resultsR" / file)
    if results is None:
        return None
    head, table = results
    joints = list(model.numbers())
    if {name for name in head if name.startswith("q.")} != {f"q.{name}" for name in joints}:
        raise MotionError("its joints are not those of the model")
    forces = [
        (body.name, point.extforce.name, False)
        for body in model.bodies
        for point in body.points
        if point.extforce is not None and f"{point.extforce.name}.Fx" in head
    ]
    pushes = (re.fullmatch(r"(push\d+\.(.+))\.Fx", name) for name in head)
    forces += [(push[2], push[1], True) for push in pushes if push]
    columns = [f"{name}.{part}" for _, name, _ in forces for part in FORCE]
    missing = [name for name in ("time", *columns) if name not in head]
    if missing:
        raise MotionError(f"it has no column {some([repr(name) for name in missing], 3)}")
    if not np.isfinite(table[:, head["time"]]).all():
        raise MotionError("a time is not a finite number")
    table = _thinned(table, head["time"])
    energies = [head[name] for name in ("energy.kinetic", "energy.potential") if name in head]
    return {
        "joints": joints,
        "forces": forces,
        "time": _packed(table[:, [head["time"]]]),
        "q": _packed(table[:, [head[f"q.{name}"] for name in joints]]),
        "F": _packed(table[:, [head[name] for name in columns]]),
        "E": _packed(table[:, energies]),
    }


def _read(file: Path) -> tuple[dict[str, int], Any] | None:
    """Return the columns of a file by name, and its numbers (rows, columns); None: no file."""
    try:
        with file.open(encoding="utf-8", newline="") as text:
            rows = csv.reader(text)
            head = {name: k for k, name in enumerate(next(rows, []))}
            table = [[float(cell) for cell in row] for row in rows]
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError, csv.Error) as error:
        raise MotionError(
            f"it cannot be read: {getattr(error, 'strerror', None) or error}"
        ) from None
    if not table:
        raise MotionError("it has no rows")
    if any(len(row) != len(head) for row in table):
        raise MotionError("its rows have not as many numbers as the first one has names")
    return head, np.array(table)


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
