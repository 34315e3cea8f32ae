"""The files of C of a simulation: equations, user functions, and the runtime."""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs.plugin import BASE
from urdf2mbs_equations.files import FUNCTIONS
from urdf2mbs_simulate.compiler import HERE, Source, list_header_folders
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import find_equations
from urdf2mbs_simulate.model_code import RowCounts

#: The files of the runtime in C.
SOURCES = (
    "runtime.c",
    "frame.c",
    "partition.c",
    "elements.c",
    "joint_system.c",
    "slopes.c",
    "linear_system.c",
    "steps.c",
    "turn.c",
    "hooks.c",
)
#: The types of joints, by their numbers in ``frame.c``.
JOINT_TYPES = ("T1", "T2", "T3", "R1", "R2", "R3")


def list_sources(data: MbsData, row_counts: RowCounts, user_files: list[Path]) -> list[Source]:
    """Return the files of C of a simulation, with the options that they are compiled with."""
    counts = {
        "JOINTS": data.njoint,
        "CUTS": row_counts.cuts,
        "USER_ROWS": row_counts.user,
        "FORCES": data.Nxfrc,
        "STATES": data.Nux,
        "LINKS": data.Nlink,
        "LINKS3D": data.Nlink3D,
        "DRIVEN": int(bool(data.nqc)),
    }
    defines = [f"-DRUN_{name}={count}" for name, count in counts.items()]
    runtime = {name: [*defines] for name in SOURCES}
    runtime["frame.c"] += [
        f"-DRUN_TREE={_format_tree(data)}",
        f"-DRUN_LINK_ENDS={_format_link_ends(data)}",
    ]
    runtime["hooks.c"] += ["-DUSER_IN_C"] * bool(user_files)
    names = _find_called_equations(data, row_counts, [*(HERE / n for n in runtime), *user_files])
    folders = list_header_folders(data.user_path, data.symbolic_path)
    return [
        *(Source(file, folders) for file in find_equations(data, sorted(names), "c").values()),
        *(Source(file, folders) for file in user_files),
        *(Source(HERE / name, folders, tuple(words)) for name, words in runtime.items()),
    ]


def _find_called_equations(data: MbsData, row_counts: RowCounts, files: list[Path]) -> set[str]:
    """Return the functions of the equations that files call and the model has."""
    text = "".join(file.read_text("utf-8", "replace") for file in files)
    called = re.findall(r"\bmbs_(\w+)\(", re.sub(r"(?s)/\*.*?\*/|//[^\n]*", "", text))
    counts = {
        "link": data.Nlink,
        "link3D": data.Nlink3D,
        "extforces": data.Nxfrc,
        "cons_hJ": row_counts.cuts,
        "cons_jdqd": row_counts.cuts,
    }
    absent = {name for name, count in counts.items() if not count}
    return {*called} & {*FUNCTIONS} - {"accelred"} - absent


def _format_tree(data: MbsData) -> str:
    """Return the rows of ``tree`` in ``frame.c``."""
    rows: list[str] = []
    for body in data._run.mbs.bodies:
        parent = 0 if body.parent is None else data.body_id[body.parent]
        point = data.points_id[body.parent or BASE][body.point] if body.point else 0
        for joint in body.joints:
            rows.append(f"{{{JOINT_TYPES.index(joint.type)}, {parent}, {point}}}")
            parent, point = len(rows), 0
    return ", ".join(rows)


def _format_link_ends(data: MbsData) -> str:
    """Return the rows of ``link_ends`` in ``frame.c``."""
    rows = []
    for link in data._run.mbs.links:
        if link.kind == "link":
            ends = (link.endpoint1, link.endpoint2)
            joints = [data.body_id[body] if body else 0 for body, _ in ends]
            points = [data.points_id[body or BASE][name] if name else 0 for body, name in ends]
            rows.append(f"{{{{{joints[0]}, {joints[1]}}}, {{{points[0]}, {points[1]}}}}}")
    return ", ".join(rows)
