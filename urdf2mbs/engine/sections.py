"""The sections of a conversion that passes read and write, and how a pass changed them.

A section is a list of parts, such as points or joints.  Most passes only add parts, and leave
earlier ones as they are: two snapshots of a section tell added parts from changed ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.mbs import model as mbs
from urdf2mbs.urdf.changes import encode


def _list_holders(conversion: Conversion) -> list[mbs.Base | mbs.Body]:
    return [conversion.mbs.base, *conversion.mbs.bodies]


def _list_joints(conversion: Conversion) -> list[mbs.Joint]:
    return [joint for body in conversion.mbs.bodies for joint in body.joints]


def _list_robot_parts(conversion: Conversion) -> Iterable[Any]:
    robot = conversion.robot
    yield robot.name, robot.materials, robot.fixed_by
    yield from robot.extensions
    yield from robot.links.values()
    yield from robot.joints.values()


def _list_body_parts(conversion: Conversion) -> Iterable[Any]:
    yield conversion.aligned
    for segment in conversion.segments.values():
        steps = [
            (
                step.joint.name,
                step.xyz,
                step.turns,
                step.axis,
                step.measured,
                step.frames,
            )
            for step in segment.steps
        ]
        yield segment.link, segment.parent, segment.parts, steps


def _list_anchor_parts(conversion: Conversion) -> Iterable[Any]:
    for holder_index, holder in enumerate(_list_holders(conversion)):
        for point_index, point in enumerate(holder.points):
            yield holder_index, point_index, point.coordinates
            yield from filter(None, (point.sensor, point.extforce))


def _list_force_parts(conversion: Conversion) -> Iterable[Any]:
    model = conversion.mbs
    yield from ((link.kind, link.length) for link in (*model.cuts, *model.links))
    yield from (
        ("constraint", constraint_index) for constraint_index in range(len(model.user_constraints))
    )
    yield from model.user_models
    yield from model.user_variables


def _list_shape_parts(conversion: Conversion) -> Iterable[Any]:
    yield conversion.meshes
    for holder in _list_holders(conversion):
        yield from holder.shapes


def _list_name_parts(conversion: Conversion) -> Iterable[Any]:
    if conversion.names.bodies:
        yield conversion.names
        yield conversion.frames
        yield [joint.name for joint in _list_joints(conversion)]
        for holder in _list_holders(conversion):
            yield holder.name, [point.name for point in holder.points]


def _list_layout_parts(conversion: Conversion) -> Iterable[Any]:
    holders = _list_holders(conversion)
    points = [point.position for holder in holders for point in holder.points]
    joints = [joint.position for joint in _list_joints(conversion)]
    return filter(None, (*(holder.drawing for holder in holders), *points, *joints))


def _list_base_joints(conversion: Conversion) -> list[mbs.Joint]:
    base_steps = (
        step for step in conversion.steps() if step.joint.name == conversion.base.inserted
    )
    return [joint for step in base_steps for joint in step.joints]


def _list_posture_parts(conversion: Conversion) -> Iterable[Any]:
    base_joint_ids = set(map(id, _list_base_joints(conversion)))
    for joint_index, joint in enumerate(_list_joints(conversion)):
        if id(joint) not in base_joint_ids:
            yield joint_index, joint.q or 0.0


#: The function that lists the parts of each section; parts that are not filled yet are left out.
SECTIONS: dict[str, Callable[[Conversion], Iterable[Any]]] = {
    "robot": _list_robot_parts,
    "base": lambda conversion: [
        (conversion.base.floating, conversion.base.inserted, conversion.mbs.base.gravity)
    ],
    "bodies": _list_body_parts,
    "inertias": lambda conversion: (
        (body.mass, body.com, body.inertia)
        for body in conversion.mbs.bodies
        if body.mass is not None
    ),
    "joints": lambda conversion: (
        (joint_index, joint.type, joint.nature == "driven", joint.symbols, joint.actuated)
        for joint_index, joint in enumerate(_list_joints(conversion))
    ),
    "couplings": lambda conversion: (
        joint_index
        for joint_index, joint in enumerate(_list_joints(conversion))
        if joint.nature == "dependent"
    ),
    "anchors": _list_anchor_parts,
    "posture": _list_posture_parts,
    "base-position": lambda conversion: (
        (joint.name, joint.q or 0.0) for joint in _list_base_joints(conversion)
    ),
    "forces": _list_force_parts,
    "shapes": _list_shape_parts,
    "names": _list_name_parts,
    "layout": _list_layout_parts,
    "view": lambda conversion: [conversion.mbs.view],
    "mbs-file": lambda conversion: [conversion.files.get(conversion.written)],
}

#: The sections that may be empty: a pass that reads them needs no pass that writes them.
OPTIONAL = frozenset(["base", "couplings", "posture", "base-position", "forces", "view"])
#: The section that a pass may change, too, if it writes another one.
IMPLIED = {"posture": "base-position"}
#: The section that another one belongs to: a posture is of joints, a mass of a body.
ABOUT = {
    "base": "robot",
    "bodies": "robot",
    "inertias": "bodies",
    "joints": "bodies",
    "couplings": "joints",
    "anchors": "bodies",
    "posture": "joints",
    "base-position": "joints",
    "shapes": "bodies",
    "names": "bodies",
    "layout": "bodies",
}


class Change(msgspec.Struct, frozen=True):
    """How a pass changed the sections."""

    changed: list[str]
    """The sections that differ."""
    altered: list[str]
    """Those in which an earlier part was changed or removed."""


def take_snapshot(conversion: Conversion) -> dict[str, Counter[bytes]]:
    """Return the parts of each section, as bytes that can be compared.

    Raises:
        TypeError: A section has a value that no file can hold.
        ValueError: Likewise.
    """
    section_parts = {
        section: list(list_parts(conversion)) for section, list_parts in SECTIONS.items()
    }
    for state in conversion.states.values():
        plugin_sections = state.sections() if hasattr(state, "sections") else {}
        for section in plugin_sections.keys() & section_parts.keys():
            parts = plugin_sections[section]
            section_parts[section] += parts if isinstance(parts, list) else [parts] if parts else []
    return {section: Counter(map(encode, parts)) for section, parts in section_parts.items()}


def compare(before: dict[str, Counter[bytes]], after: dict[str, Counter[bytes]]) -> Change:
    """Return which sections differ between two snapshots."""
    changed = [section for section in SECTIONS if before[section] != after[section]]
    return Change(
        changed,
        [section for section in changed if before[section] - after[section]],
    )
