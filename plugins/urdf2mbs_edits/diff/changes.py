"""The changes from one model to another, object by object and field by field."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import trunc
from typing import Any, Literal

import msgspec

from urdf2mbs.mbs.model import Base, Mbs, Part, View, without_origin
from urdf2mbs.spatial import ZERO
from urdf2mbs_edits.diff.matching import KINDS, Matching, Thing
from urdf2mbs_edits.unknown import spelling, unknown

#: What a file may leave out, and what it then means.
DEFAULTS: dict[str, Any] = {
    "mass": 0.0, "com": ZERO, "inertia": (0.0,) * 6, "q": 0.0, "qd": 0.0, "qdd": 0.0,
    "symbols": ("q", "qd", "qdd"),
}  # fmt: skip
#: Things of the drawing alone, and fields that others have for it.
DRAWN = frozenset(["shape", "view", "viewpoint", "light"])
DRAWING = ("position", "drawing", "graphics", "x2D", "x3D", "base/graphics")


class Change(msgspec.Struct, omit_defaults=True, forbid_unknown_fields=True):
    """One thing that is another now; units and frames are those of the file."""

    change: Literal["added", "removed", "renamed", "moved", "changed", "reordered"]
    kind: str
    """Of the thing: one of ``matching.KINDS``."""
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
    follows: str = ""
    """Of what was added or moved: after which of its like it stands; empty: it is the first."""


class Differences(msgspec.Struct):
    """The differences of two models."""

    changes: list[Change]
    versions: tuple[str, str]
    """Of MBSysPad, as the files say; no difference by themselves."""
    renumbered: dict[str, tuple[int, int]]
    """Joints, by their names before, that have another number in Robotran."""


def differences(
    before: Mbs, after: Mbs, *, physics: bool = False, same: Iterable[tuple[Any, Any]] | None = None
) -> Differences:
    """The differences of two models; ``physics`` leaves out what is drawn alone.

    A thing that belongs to an added or removed thing is not named beside it.  ``same`` are the
    objects of the two models that are the same, where this is known.
    """
    matching = Matching(before, after, same)
    changes = [
        change
        for change, _ in changed_things(matching, before, after)
        if not (physics and change.drawing)
    ]
    numbers, new_numbers = before.numbers(), after.numbers()
    renumbered = {
        old.name: (numbers[old.name], new_numbers[new.name])
        for old, new in matching.pairs()
        if old.kind == "joint" and numbers[old.name] != new_numbers[new.name]
    }
    return Differences(changes, (before.version, after.version), renumbered)


def changed_things(matching: Matching, before: Mbs, after: Mbs) -> list[tuple[Change, Thing]]:
    """Each change, and the thing before; of what was added, the thing after."""
    changes = list(_changes(matching, before, after))
    changes.sort(key=lambda change: KINDS.index(change[0].kind))  # stable
    return changes


def _changes(matching: Matching, before: Mbs, after: Mbs) -> Iterator[tuple[Change, Thing]]:
    for thing in matching.removed():
        if thing.owner is None or thing.owner in matching.partner:
            yield _of_whole("removed", thing, before=content(thing.part)), thing
    for thing in matching.added():
        if thing.owner is None or thing.owner in matching.partner:
            yield added(matching, thing), thing
    unknown_before, unknown_after = unknown(before), unknown(after)
    for old, new in matching.pairs():
        texts = _unknown_of(old, unknown_before), _unknown_of(new, unknown_after)
        for change in _of_thing(matching, old, new, texts):
            yield change, old
    yield from _reordered(matching)


def added(matching: Matching, thing: Thing) -> Change:
    """The change that a thing was added, with all that is in it."""
    follows = _follows(matching, thing)
    return _of_whole("added", thing, after=content(thing.part), follows=follows)


def _of_whole(does: Any, thing: Thing, **said: Any) -> Change:
    drawing = thing.kind in DRAWN
    return Change(does, thing.kind, thing.name, owner_in_words(thing), drawing=drawing, **said)


def content(part: Any) -> Any:
    """All that an object says, with what belongs to it, as plain data."""
    return _stated(msgspec.to_builtins(part, enc_hook=without_origin))


def _follows(matching: Matching, thing: Thing) -> str:
    """After which of its like a thing stands in its owner."""
    name = ""
    for other in matching.after:
        if other is thing:
            break
        if other.kind == thing.kind and other.owner is thing.owner:
            name = other.name
    return name


def _stated(content: Any) -> Any:
    """The fields of an object that say something."""
    if isinstance(content, list):
        return [_stated(part) for part in content]
    if not isinstance(content, dict):
        return content
    return {field: _stated(value) for field, value in content.items() if value not in (None, [])}


def _of_thing(
    matching: Matching, old: Thing, new: Thing, texts: tuple[dict[str, str], dict[str, str]]
) -> Iterator[Change]:
    """The changes of one thing: of its name, its owner, its fields, and of the elements that the
    model does not know, which have these ``texts`` by their paths, before and after."""

    def change(does: Any, field: str, was: Any, now: Any) -> Change:
        drawing = old.kind in DRAWN or field.startswith(DRAWING)
        return Change(does, old.kind, old.name, owner_in_words(old), field, was, now, drawing)

    renamed = old.name != new.name
    if renamed and "name" in old.refers:
        renamed = matching.identities(old, "name") != matching.identities(new, "name")
    if renamed:
        yield change("renamed", "name", old.name, new.name)
    if matching.identity(old.owner) != matching.identity(new.owner):
        moved = change("moved", "owner", owner_in_words(old), owner_in_words(new))
        moved.follows = _follows(matching, new)
        yield moved
    for field, values in old.refers.items():
        if field == "name":
            continue
        if matching.identities(old, field) != matching.identities(new, field):
            names = [[target_name(target) for target in values]]
            names.append([target_name(target) for target in new.refers[field]])
            yield change("changed", field, *names)
    known: tuple[dict[str, Any], dict[str, Any]] = plain_values(old), plain_values(new)
    for was, now in (known, texts):
        for field in dict.fromkeys([*was, *now]):
            if was.get(field) != now.get(field):
                yield change("changed", field, was.get(field), now.get(field))


def plain_values(thing: Thing) -> dict[str, Any]:
    """The plain values of a thing; a value that the file leaves out is its default."""
    values: dict[str, Any] = {}
    for field in thing.part.__struct_fields__:
        value = getattr(thing.part, field)
        if field in ("origin", "name", "version", *thing.refers) or isinstance(
            value, Part | Base | View
        ):
            continue
        if isinstance(value, list):  # of things, which have their own changes
            continue
        if field == "values":
            value = tuple(map(spelling, value))
        if isinstance(value, msgspec.Struct):
            for part in value.__struct_fields__:
                values[f"{field}.{part}"] = _whole_pixels(getattr(value, part))
        elif field == "position" and thing.kind not in DRAWN:
            values[field] = _whole_pixels(value)
        elif field in DEFAULTS:
            values[field] = DEFAULTS[field] if value is None else value
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


def target_name(target: Thing | str | None) -> str:
    """A thing that a field names; a body's own frame is ``origin``."""
    if isinstance(target, Thing):
        return target.name
    return "origin" if target is None else target


def owner_in_words(thing: Thing) -> str:
    """What a thing belongs to; empty: the model."""
    return "" if thing.owner is None else in_words(thing.owner)


def in_words(owner: Thing) -> str:
    """How a thing is called that others belong to; empty: the model."""
    if owner.kind == "model":
        return ""
    if owner.kind in ("base", "view"):
        return f"the {owner.kind}"
    above = f" of {owner_in_words(owner)}" if owner.kind == "point" else ""
    return f"{owner.kind} '{owner.name}'{above}"


def _unknown_of(thing: Thing, texts: dict[int, dict[str, str]]) -> dict[str, str]:
    origin = getattr(thing.part, "origin", None)
    return {} if origin is None else texts.get(origin.number, {})


def _reordered(matching: Matching) -> Iterator[tuple[Change, Thing]]:
    """The kinds of things that stand in another order, said once for each owner."""
    orders: dict[tuple[str, Thing | None], list[Thing]] = {}
    for old, new in matching.pairs():
        if matching.identity(old.owner) == matching.identity(new.owner):
            orders.setdefault((old.kind, old.owner), []).append(new)
    places = {thing: place for place, thing in enumerate(matching.after)}
    for (kind, owner), things in orders.items():
        if things != sorted(things, key=places.__getitem__):
            before = [matching.partner[thing].name for thing in things]
            after = [thing.name for thing in sorted(things, key=places.__getitem__)]
            of = "" if owner is None else in_words(owner)
            change = Change("reordered", kind, "", of, "order", before, after, kind in DRAWN)
            yield change, owner or matching.before[0]
