"""The changes from one model to another, object by object and field by field."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

import msgspec

from urdf2mbs.plugin import ORIGIN, Mbs, without_origin
from urdf2mbs_edits.diff.flat import DRAWN, KINDS, Thing, Version, flat, is_drawn, things
from urdf2mbs_edits.diff.matching import match

#: A path: the number of a thing, and one of its fields; empty: all of it.
Path = tuple[int, str]


class Change(msgspec.Struct, omit_defaults=True, forbid_unknown_fields=True):
    """One thing that is another now; units and frames are those of the file."""

    change: Literal["added", "removed", "renamed", "moved", "changed", "reordered"]
    kind: str
    """Of the thing: one of ``flat.KINDS``."""
    name: str
    """Of the thing, by its name before; if it was added, after."""
    owner: str = ""
    """What the thing belongs to, in words, by its name before; if it was added, after."""
    field: str = ""
    """What changed of the thing; a path of elements where the model does not know it."""
    before: Any = None
    after: Any = None
    drawing: bool = False
    """True if the change is one of pictures alone: the 2D diagram or the 3D view."""


class Differences(msgspec.Struct):
    """The differences of two models."""

    changes: list[Change]
    versions: tuple[str, str]
    """Of MBSysPad, as the files say; no difference by themselves."""
    renumbered: dict[str, tuple[int, int]]
    """Joints, by their names before, that have another number in Robotran."""


def differences(before: Mbs, after: Mbs, *, physics: bool = False) -> Differences:
    """The differences of two models; ``physics`` leaves out what is drawn alone.

    A thing that belongs to an added or removed thing is not named beside it.
    """
    found = things(before), things(after)
    match(*found)
    changes = compare(flat(before, found[0]), flat(after, found[1]))
    joints: tuple[dict[int, str], ...] = tuple(
        {thing.number: thing.name for thing in side if thing.kind == "joint"} for side in found
    )
    ranks = before.numbers(), after.numbers()
    numbers = {
        name: (ranks[0][name], ranks[1][joints[1][number]])
        for number, name in joints[0].items()
        if number in joints[1]
    }
    return Differences(
        [change for change, _ in changes if not (physics and change.drawing)],
        (before.version, after.version),
        {name: pair for name, pair in numbers.items() if pair[0] != pair[1]},
    )


def compare(before: Version, after: Version) -> list[tuple[Change, Path]]:
    """Each change, and its path."""
    changes = list(_changes(before, after))
    changes.sort(key=lambda found: KINDS.index(found[0].kind))  # stable
    return changes


def _changes(before: Version, after: Version) -> Iterator[tuple[Change, Path]]:
    for number, thing in _only(before, after):
        yield _of_whole("removed", thing, before=content(thing)), (number, "")
    for number, thing in _only(after, before):
        yield added(thing), (number, "")
    for number in before.things:
        if number in after.things:
            yield from _of_thing(before, after, number)
    for number in before.things:
        for field in before.values[number]:
            change = _reordered(before, after, number, field[1:-1]) if field[0] == "[" else None
            if change:
                yield change, (number, field)


def _only(version: Version, other: Version) -> Iterator[tuple[int, Thing]]:
    """The things that one version has alone, without what is in them."""
    for number, thing in version.things.items():
        if number not in other.things and (not thing.owner or thing.owner.number in other.things):
            yield number, thing


def added(thing: Thing) -> Change:
    """The change that a thing was added, with all that is in it."""
    return _of_whole("added", thing, after=content(thing))


def _of_whole(does: Any, thing: Thing, **values: Any) -> Change:
    of = thing.owner.words() if thing.owner else ""
    return Change(does, thing.kind, thing.name, of, drawing=thing.kind in DRAWN, **values)


def content(thing: Thing) -> Any:
    """All that a thing says, with what belongs to it, as plain data."""
    return _stated(msgspec.to_builtins(thing.part, enc_hook=without_origin))


def _stated(content: Any) -> Any:
    """The fields of an object that say something."""
    if isinstance(content, list):
        return [_stated(part) for part in content]
    if not isinstance(content, dict):
        return content
    return {field: _stated(value) for field, value in content.items() if value not in (None, [])}


def _of_thing(before: Version, after: Version, number: int) -> Iterator[tuple[Change, Path]]:
    """The changes of a thing that is in both: of its name, its owner and its other values."""
    thing, was, now = before.things[number], before.values[number], after.values[number]
    of = thing.owner.words() if thing.owner else ""
    for field in dict.fromkeys([*was, *now]):
        if was.get(field) == now.get(field) or field[0] == "[":
            continue
        then, since = (shown(version, number, field) for version in (before, after))
        fields = [(field.lstrip("?"), then, since)]
        if field == "place":
            fields = [(part, [then[k]], [since[k]]) for k, part in enumerate(("parent", "point"))
                      if was[field][k] != now[field][k]]  # fmt: skip
        does: Any = {"name": "renamed", "owner": "moved"}.get(field, "changed")
        for part, old, new in fields:
            if field != "name" or old != new:
                drawing = is_drawn(thing.kind, part)
                yield Change(does, thing.kind, thing.name, of, part, old, new, drawing), (
                    number, field
                )  # fmt: skip


def shown(version: Version, number: int, field: str) -> Any:
    """A value, with the names of what it refers to; a body's own frame is ``origin``."""
    thing = version.things[number]
    if field == "name":
        return thing.name
    if field == "owner":
        return thing.owner.words() if thing.owner else ""
    if field[0] == "[":
        return [version.things[one].name for one in version.held(number, field[1:-1])]
    if field in thing.refers:
        return [
            ORIGIN if target is None else target.name if isinstance(target, Thing) else target
            for target in thing.refers[field]
        ]
    return version.values[number].get(field)


def _reordered(before: Version, after: Version, number: int, kind: str) -> Change | None:
    """The change that things of a kind stand in another order in what holds them."""
    orders = [version.held(number, kind) for version in (before, after)]
    old, new = ([one for one in order if one in set.intersection(*map(set, orders))]
                for order in orders)  # fmt: skip
    if old == new:
        return None
    names = [before.things[one].name for one in old], [after.things[one].name for one in new]
    of = before.things[number].words()
    return Change("reordered", kind, "", of, "order", *names, drawing=kind in DRAWN)
