"""The sections of a conversion: what passes read and write, and what a pass has changed of them.

A section leaves out what has not been filled yet, so that a new body changes the section
``bodies`` alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from urdf2mbs.conversion import Conversion
from urdf2mbs.mbs import model as mbs
from urdf2mbs.urdf.changes import encode


def _holders(c: Conversion) -> list[mbs.Base | mbs.Body]:
    return [c.mbs.base, *c.mbs.bodies]


def _joints_of(c: Conversion) -> list[mbs.Joint]:
    return [joint for body in c.mbs.bodies for joint in body.joints]


def _bodies(c: Conversion) -> Any:
    segments = [
        (segment.link, segment.parent, segment.parts, [
            (step.joint.name, step.xyz, step.turns, step.axis, step.measured,
             step.frames)
            for step in segment.steps
        ])
        for segment in c.segments.values()
    ]  # fmt: skip
    return c.aligned, segments


def _anchors(c: Conversion) -> Any:
    return [
        (number, point.coordinates, point.sensor, point.extforce)
        for number, holder in enumerate(_holders(c))
        for point in holder.points
    ]


def _forces(c: Conversion) -> Any:
    model = c.mbs
    return (
        [(connection.kind, connection.length) for connection in (*model.cuts, *model.links)],
        len(model.user_constraints), model.user_models, model.user_variables,
    )  # fmt: skip


def _names(c: Conversion) -> Any:
    if not c.names.bodies:
        return None
    holders = [(holder.name, [point.name for point in holder.points]) for holder in _holders(c)]
    return c.names, c.frames, holders, [joint.name for joint in _joints_of(c)]


def _layout(c: Conversion) -> Any:
    points = [point.position for holder in _holders(c) for point in holder.points]
    joints = [joint.position for joint in _joints_of(c)]
    places = [holder.drawing for holder in _holders(c)]
    return [place for place in (*places, *points, *joints) if place]


#: Each section, and what of a conversion stands in it.
SECTIONS: dict[str, Callable[[Conversion], Any]] = {
    "robot": lambda c: c.robot,
    "base": lambda c: (c.base.floating, c.base.inserted, c.mbs.base.gravity),
    "bodies": _bodies,
    "inertias": lambda c: [
        (body.mass, body.com, body.inertia) for body in c.mbs.bodies if body.mass is not None
    ],
    "joints": lambda c: [
        (joint.type, joint.nature, joint.symbols, joint.actuated) for joint in _joints_of(c)
    ],
    "couplings": lambda c: (),
    "anchors": _anchors,
    "posture": lambda c: [joint.q for joint in _joints_of(c) if joint.q],
    "forces": _forces,
    "shapes": lambda c: ([shape for holder in _holders(c) for shape in holder.shapes], c.meshes),
    "names": _names,
    "layout": _layout,
    "view": lambda c: c.mbs.view,
    "mbs-file": lambda c: c.files.get(c.written),
}

#: The sections that may be empty: a pass that reads them needs no pass that writes them.
OPTIONAL = frozenset(["base", "couplings", "posture", "forces", "view"])


def look(conversion: Conversion) -> dict[str, bytes]:
    """What each section holds now, as bytes that can be compared.

    Raises TypeError or ValueError where a section holds what no file can hold.
    """
    of_plugins = [
        state.sections() for state in conversion.states.values() if hasattr(state, "sections")
    ]
    return {
        name: encode((take(conversion), [own[name] for own in of_plugins if own.get(name)]))
        for name, take in SECTIONS.items()
    }


def find_changed(before: dict[str, bytes], after: dict[str, bytes]) -> list[str]:
    """The sections that differ."""
    return [name for name in SECTIONS if before[name] != after[name]]
