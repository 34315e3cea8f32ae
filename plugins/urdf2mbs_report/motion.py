"""The motion of a simulated project, for its page: resultsR/dirdyn.csv at 60 frames/s at most."""

from __future__ import annotations

import csv
import re
from base64 import b64encode
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf2mbs.plugin import Mbs, some

#: Frames in a second of the page.
FRAME_RATE = 60.0

#: The columns of a force: its components, and its point in the frame of its body.
FORCE_COLUMNS = ("Fx", "Fy", "Fz", "dx", "dy", "dz")

Rows = NDArray[np.float64]
"""(rows, columns) the numbers of a file of results."""


class MotionError(Exception):
    """A file of results cannot be played; the message says why."""


class Force(NamedTuple):
    """A force that the page shows as an arrow, in the order of its script."""

    body: str
    name: str
    """The beginning of its columns."""
    is_push: bool
    """True for a push of the user, False for an external force of the model."""


class Results(NamedTuple):
    """A file of results."""

    columns: dict[str, int]
    """The index of each column by its name."""
    rows: Rows


def read_motion(model: Mbs, project: Path, file: str = "dirdyn.csv") -> dict[str, Any] | None:
    """Read the motion of a run from its file; return None if there is no file.

    Args:
        model: The model that was simulated.
        project: The project's folder.
        file: The name of the results; by default those of the last run.

    Raises:
        MotionError: The file is broken, or of other joints.
    """
    results = _read_results(project / "resultsR" / file)
    return None if results is None else describe_motion(model, results)


def stack_columns(columns: Mapping[str, Any]) -> Results:
    """Return results in memory: an array of each column, all as long as that of the times."""
    indices = {column_name: index for index, column_name in enumerate(columns)}
    return Results(indices, np.column_stack(list(columns.values())))


def describe_motion(model: Mbs, results: Results) -> dict[str, Any]:
    """Select the times, positions, forces and energies of a run, for the script of the page.

    Args:
        model: The model that was simulated.
        results: Its results.

    Returns:
        Numbers are little-endian float32 in base64, a row for each frame: times (s), joint
        positions (rad, m), forces (N) and energies (J).  Forces are the external ones and then the
        pushes, each with Fx, Fy, Fz in the axes of the base, and dx, dy, dz (m), its point in the
        axes of its body.

    Raises:
        MotionError: The results are of other joints, or lack columns.
    """
    columns, rows = results
    joint_names = list(model.numbers())
    if {column_name for column_name in columns if column_name.startswith("q.")} != {
        f"q.{joint_name}" for joint_name in joint_names
    }:
        raise MotionError("its joints are not those of the model")
    forces = _list_forces(model, columns)
    force_columns = [f"{force.name}.{component}" for force in forces for component in FORCE_COLUMNS]
    missing_columns = [
        column_name for column_name in ("time", *force_columns) if column_name not in columns
    ]
    if missing_columns:
        raise MotionError(
            f"it has no column {some([repr(column_name) for column_name in missing_columns], 3)}"
        )
    time_column = columns["time"]
    if not np.isfinite(rows[:, time_column]).all():
        raise MotionError("a time is not a finite number")
    frames = _select_frames(rows, time_column)
    energy_columns = [
        column_name
        for column_name in ("energy.kinetic", "energy.potential")
        if column_name in columns
    ]
    return {
        "joints": joint_names,
        "forces": forces,
        "time": _pack_numbers(frames[:, [time_column]]),
        "q": _pack_numbers(frames[:, [columns[f"q.{joint_name}"] for joint_name in joint_names]]),
        "F": _pack_numbers(frames[:, [columns[column_name] for column_name in force_columns]]),
        "E": _pack_numbers(frames[:, [columns[column_name] for column_name in energy_columns]]),
    }


def _read_results(results_file: Path) -> Results | None:
    """Read a file of results; return None if there is no file."""
    try:
        with results_file.open(encoding="utf-8", newline="") as results_stream:
            csv_lines = csv.reader(results_stream)
            columns = {column_name: index for index, column_name in enumerate(next(csv_lines, []))}
            rows = [[float(cell) for cell in csv_line] for csv_line in csv_lines]
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise MotionError(f"it cannot be read: {reason}") from None
    if not rows:
        raise MotionError("it has no rows")
    if any(len(row) != len(columns) for row in rows):
        raise MotionError("its rows have not as many numbers as the first one has names")
    return Results(columns, np.array(rows))


def _list_forces(model: Mbs, columns: dict[str, int]) -> list[Force]:
    """Return the external forces of a model that have results, and then the pushes."""
    forces = [
        Force(body.name, point.extforce.name, is_push=False)
        for body in model.bodies
        for point in body.points
        if point.extforce is not None and f"{point.extforce.name}.Fx" in columns
    ]
    push_matches = (re.fullmatch(r"(push\d+\.(.+))\.Fx", column_name) for column_name in columns)
    return forces + [
        Force(push_match[2], push_match[1], is_push=True)
        for push_match in push_matches
        if push_match
    ]


def _select_frames(rows: Rows, time_column: int) -> Rows:
    """Select the rows that are at least a frame apart, and the last row."""
    row_indices, last_time = [], -np.inf
    for row_index, frame_time in enumerate(rows[:, time_column]):
        if frame_time - last_time >= 1.0 / FRAME_RATE - 1e-9 or row_index == len(rows) - 1:
            row_indices.append(row_index)
            last_time = frame_time
    return rows[row_indices]


def _pack_numbers(numbers: Rows) -> str:
    """Return numbers as float32 in base64."""
    return b64encode(np.ascontiguousarray(numbers, dtype="<f4").tobytes()).decode()
