"""A model as a flat table ``{path: value}``: diff compares two of them, merge makes one of three.

    path                                 value
    body 'arm'      mass                 2.0
    body 'arm'      place                (body 'trunk', point 'shoulder')
    joint 'elbow'   owner                body 'arm'
    body 'arm'      [joint]              (joint 'elbow', joint 'slide')
    body 'arm'      ?brake/force         <force>1.5</force>

A path is a thing and one of its fields.  A thing is its kind, its owner and its name, but names and
owners change: ``matching`` finds once which things of two versions are the same, and gives them one
number, which stands for the thing in paths and in references.  So names, owners and references are
values like any other, and a thing that changes places is a path with another value, whatever stood
there.  The order of what a thing holds is a value, too (in ``[]``), and so is each element and
attribute that the model does not know (behind ``?``).  Values that mean the same are equal.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import count
from math import trunc
from typing import Any

import msgspec

from urdf2mbs.plugin import BASE, ZERO, Mbs, writer
from urdf2mbs.plugin import read_mbs_again as read_again
from urdf2mbs_edits.diff.unknown import spelling, unknown

#: The elements of a file's things, by their numbers.
Elements = dict[int, Any]

#: The kinds of the things that a field of the model holds, in the order of differences.
HELD = {
    "base": "base", "bodies": "body", "joints": "joint", "points": "point", "sensor": "sensor",
    "extforce": "force", "cuts": "cut", "links": "link", "user_constraints": "user constraint",
    "user_models": "user model", "parameters": "parameter", "user_variables": "user variable",
    "shapes": "shape", "view": "view", "viewpoints": "viewpoint", "lights": "light",
}  # fmt: skip
KINDS = ("model", *HELD.values())
#: Things of the drawing alone, and fields that others have for it.
DRAWN = frozenset(["shape", "view", "viewpoint", "light"])
_DRAWING = ("position", "drawing", "graphics", "x2D", "x3D")
#: What a file may leave out, and what it then means.
_DEFAULTS: dict[str, Any] = {
    "mass": 0.0, "com": ZERO, "inertia": (0.0,) * 6, "q": 0.0, "qd": 0.0, "qdd": 0.0,
    "symbols": ("q", "qd", "qdd"),
}  # fmt: skip
#: The fields that say nothing, and those of a body that its place says.
_UNSAID = frozenset(["origin", "version", ("body", "parent"), ("body", "point")])

_numbers = count()


class Thing(msgspec.Struct, eq=False):
    """An object of a model."""

    kind: str
    """One of ``KINDS``."""
    name: str
    part: Any
    """The object of ``mbs.model``."""
    owner: Thing | None = None
    """What it belongs to: a joint to its body, a sensor to its point."""
    refers: dict[str, tuple[Thing | str | None, ...]] = {}
    """The things that a field names; None is a body's own frame, a text names nothing known."""
    carries: list[Thing] = []
    """The bodies that hang on a point."""
    number: int = msgspec.field(default_factory=_numbers.__next__)
    """Equal for things of several versions that are the same."""

    def refs(self, field: str) -> tuple[int | str | None, ...]:
        """The things that a field names, by their numbers."""
        return tuple(to.number if isinstance(to, Thing) else to for to in self.refers[field])

    def title(self) -> str:
        """The kind and the name."""
        if self.kind in ("model", "base", "view"):
            return f"the {self.kind}"
        return f"{self.kind} '{self.name}'"

    def words(self) -> str:
        """How a thing is called that others belong to; empty: the model."""
        above = f" of {self.owner.words()}" if self.kind == "point" and self.owner else ""
        return "" if self.kind == "model" else self.title() + above


class Version(msgspec.Struct):
    """One version of a model: its things in the order of the file, their values by field, and
    their elements in the file."""

    things: dict[int, Thing]
    values: dict[int, dict[str, Any]]
    elements: Elements

    def held(self, number: int, kind: str) -> list[int]:
        """The things of a kind that a thing holds, in their order."""
        held: list[int] = self.values.get(number, {}).get(f"[{kind}]", [])
        return held


def is_place(kind: str, field: str) -> bool:
    """True of the places in the 2D diagram."""
    return (field == "position" and kind not in DRAWN) or field.startswith("drawing.")


def is_drawn(kind: str, field: str) -> bool:
    """True of pictures alone: the 2D diagram or the 3D view."""
    return kind in DRAWN or field.startswith(_DRAWING)


def things(mbs: Mbs) -> list[Thing]:
    """All objects of a model, each after its owner."""
    found = list(_walk("model", mbs, None))
    base = found[1]
    bodies: dict[str | None, Thing] = {t.name: t for t in found if t.kind == "body"}
    bodies[None] = base
    joints = {thing.name: thing for thing in found if thing.kind == "joint"}
    points = {(t.owner, t.name): t for t in found if t.kind == "point"}

    def place(body: str | None, point: str | None) -> tuple[Thing | str | None, ...]:
        on = bodies.get(body, body)
        at = points.get((on, point), point) if isinstance(on, Thing) and point else point
        return on, at

    for thing in found:
        part = thing.part
        if thing.kind == "body":
            thing.refers = {"place": place(*part.place)}
            point = thing.refers["place"][1]
            if isinstance(point, Thing):
                point.carries.append(thing)
        elif thing.kind in ("cut", "link"):
            thing.refers = {e: place(*getattr(part, e)) for e in ("endpoint1", "endpoint2")}
        elif thing.kind == "user constraint":
            thing.refers = {"joints": tuple(joints.get(joint, joint) for joint in part.joints)}
        elif thing.kind == "parameter":  # often called as the joint whose number it is
            thing.refers = {"name": (joints.get(part.name, part.name),)}
        elif thing.kind in ("viewpoint", "light"):
            behind = base if part.joint == BASE else joints.get(part.joint, part.joint)
            thing.refers = {"joint": (behind,)}
    return found


def _walk(kind: str, part: Any, owner: Thing | None) -> Iterator[Thing]:
    yield (thing := Thing(kind, getattr(part, "name", ""), part, owner))
    for field in part.__struct_fields__:
        held = getattr(part, field)
        if field in HELD and not isinstance(held, tuple) and held is not None:
            for inner in held if isinstance(held, list) else [held]:
                yield from _walk(HELD[field], inner, thing)


def flat(mbs: Mbs, found: list[Thing]) -> Version:
    """The table of a model, whose things have their numbers by now."""
    its = elements(file_of(mbs), found)
    objects = set(its.values())
    values: dict[int, dict[str, Any]] = {}
    for thing in found:
        texts = unknown(its[thing.number], objects)
        values[thing.number] = said(thing) | {f"?{path}": text for path, text in texts.items()}
        if thing.owner is not None:
            values[thing.owner.number].setdefault(f"[{thing.kind}]", []).append(thing.number)
    return Version({thing.number: thing for thing in found}, values, its)


def file_of(mbs: Mbs) -> bytes:
    """The file from which a model was read, or into which it is written."""
    return mbs.origin.source if mbs.origin else writer.write(mbs)


def elements(source: bytes, found: Iterable[Thing]) -> Elements:
    """The elements of the things of a model in its file."""
    mbs, objects = read_again(source)
    its: Elements = {}
    for thing, again in zip(found, things(mbs), strict=True):
        tag = {"base": "base", "view": "x3D"}.get(thing.kind)
        one = objects[0].find(tag) if tag else objects[again.part.origin.number]
        assert one is not None
        its[thing.number] = one
    return its


def said(thing: Thing) -> dict[str, Any]:
    """What a thing says itself; a value that the file leaves out is its default."""
    owner = None if thing.owner is None else thing.owner.number
    values: dict[str, Any] = {"name": thing.name, "owner": owner}
    values |= {field: thing.refs(field) for field in thing.refers}
    for field in thing.part.__struct_fields__:
        value = getattr(thing.part, field)
        if field in values or not _UNSAID.isdisjoint([field, (thing.kind, field)]):
            continue
        if field in HELD and not isinstance(value, tuple):
            continue
        if field == "values":
            value = tuple(map(spelling, value))
        if isinstance(value, msgspec.Struct):
            for part in value.__struct_fields__:
                values[f"{field}.{part}"] = _whole_pixels(getattr(value, part))
        elif is_place(thing.kind, field):
            values[field] = _whole_pixels(value)
        elif field in _DEFAULTS:
            values[field] = _DEFAULTS[field] if value is None else value
        elif value is not None:
            values[field] = value
    for field in ("symbols", "measures"):  # in any order
        if field in values:
            values[field] = tuple(sorted(values[field]))
    return values


def _whole_pixels(value: Any) -> Any:
    """Places in the diagram in whole pixels, as MBSysPad saves them; anything else as it is."""
    if not isinstance(value, tuple):
        return value
    return tuple(_whole_pixels(c) if isinstance(c, tuple) else trunc(c) for c in value)
