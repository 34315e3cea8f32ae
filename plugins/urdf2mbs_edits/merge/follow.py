"""The rest of a conversion follows its model, in which edits were made."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from urdf2mbs.plugin import Conversion, OnPurpose, Part
from urdf2mbs_edits.diff.changes import Change
from urdf2mbs_edits.diff.flat import things

#: A kind and a name of the conversion, and the name now; None: it was removed.
Names = dict[tuple[str, str], str | None]
#: The kinds of things that the proof compares.
_COMPARED = frozenset(
    ["base", "body", "joint", "point", "cut", "user constraint", "user model", "parameter"]
)


def follow(conversion: Conversion, names: Names, edits: Iterable[Change], where: str) -> None:
    """Let names, simulation and proof follow the edits that a file makes."""
    meant = conversion.state(OnPurpose)
    for edit in edits:
        if edit.drawing:
            continue
        if edit.change == "added":
            meant.added[f"{edit.kind} '{edit.name}'"] = f"added in {where}"
        if edit.kind in _COMPARED and (edit.change, edit.kind) != ("added", "point"):
            meant.edited[where] = None
    _rename(conversion, names)
    _forget_removed(conversion)


def _rename(conversion: Conversion, names: Names) -> None:
    """Call the robot's bodies and joints as people call them now; forget what they removed."""
    called = conversion.names

    def now(kind: str, known: list[str]) -> list[str]:
        renamed = [names.get((kind, name), name) for name in known]
        return [name for name in renamed if name is not None]

    called.bodies = {
        link: name for link, body in called.bodies.items() for name in now("body", [body])
    }
    called.joints = {joint: now("joint", known) for joint, known in called.joints.items()}
    called.coordinates = {joint: now("joint", known) for joint, known in called.coordinates.items()}
    for link, frame in list(conversion.frames.items()):
        body = None if frame.body is None else names.get(("body", frame.body), frame.body)
        joint = None if frame.joint is None else names.get(("joint", frame.joint), frame.joint)
        if (body is None) != (frame.body is None) or (joint is None) != (frame.joint is None):
            del conversion.frames[link]
        else:
            frame.body, frame.joint = body, joint


def _forget_removed(conversion: Conversion) -> None:
    """Take out of what plugins know what uses a part of the model that is no more."""
    there = {id(thing.part) for thing in things(conversion.mbs)}
    lists: list[list[Any]] = []
    for state in conversion.states.values():
        values = [getattr(state, field) for field in getattr(state, "__struct_fields__", ())]
        lists += [value for value in values if isinstance(value, list)]
    for used in lists:
        used[:] = [part for part in used if there.issuperset(map(id, _parts(part)))]


def _parts(used: Any) -> list[Any]:
    """The objects of the model that a part of the simulation uses."""
    if isinstance(used, Part):
        return [used]
    values = [getattr(used, field) for field in getattr(used, "__struct_fields__", ())]
    lists = [value if isinstance(value, list) else [value] for value in values]
    return [part for parts in lists for part in parts if isinstance(part, Part)]
