"""The model of a merged table, made of the objects of theirs, as ours spells them."""

from __future__ import annotations

from copy import copy
from typing import Any

import msgspec

from urdf2mbs.mbs.model import BASE, Mbs
from urdf2mbs_edits.diff.flat import HELD, Thing
from urdf2mbs_edits.merge.settle import Settled


def build(settled: Settled, mbs: Mbs) -> dict[int, int]:
    """Make theirs, whose model this is, the merged one; the number of each object's thing, by
    ``id``.

    Who knows an object of theirs knows it in the merged model, too.  An object that ours has is
    that of its file, so that its element stays.
    """
    orders = settled.orders()
    sides = settled.ours.things, settled.theirs.things
    parts = {
        n: sides[1][n].part if n in sides[1] else copy(sides[0][n].part) for n in settled.there
    }
    for number, thing in settled.there.items():
        part, mine = parts[number], sides[0].get(number)
        if mine is not None:
            _take_ours(settled, mine, part)
            if hasattr(part, "origin"):
                part.origin = mine.part.origin
        if hasattr(part, "name"):
            part.name = settled.name(number)
        for field in part.__struct_fields__:
            held = getattr(part, field)
            if field in HELD and not isinstance(held, tuple):
                inner = [parts[one] for one in orders.get((number, f"[{HELD[field]}]"), ())]
                single = not isinstance(held, list)
                setattr(part, field, (inner[0] if inner else None) if single else inner)
        for field in thing.refers:
            _refer(settled, number, field, part)
    there: set[str | None] = {None}
    for body in mbs.bodies:
        if body.parent not in there:  # a file has parents before children
            mbs.bodies = mbs.depth_first()
            break
        there.add(body.name)
    return {id(part): number for number, part in parts.items()}


def _take_ours(settled: Settled, mine: Thing, part: Any) -> None:
    """Give an object the plain values of ours, but for those that are of theirs."""
    for field in part.__struct_fields__:
        value, then = getattr(mine.part, field), getattr(part, field)
        inner = value if isinstance(value, msgspec.Struct) else then
        if field in ("origin", "name", *mine.refers) or isinstance(value, list) or field in HELD:
            continue
        if not isinstance(inner, msgspec.Struct):
            if settled.is_ours(mine.number, field):
                setattr(part, field, value)
            continue
        taken = [one for one in inner.__struct_fields__
                 if not settled.is_ours(mine.number, f"{field}.{one}")]  # fmt: skip
        if value is None or then is None:
            setattr(part, field, then if taken else value)
        else:
            mixed = msgspec.structs.replace(value, **{one: getattr(then, one) for one in taken})
            setattr(part, field, mixed)


def _refer(settled: Settled, number: int, field: str, part: Any) -> None:
    """Name what a field refers to by the names that it has now."""
    value = settled.value(number, field)
    names = [
        target if not isinstance(target, int)
        else None if settled.there[target].kind == "base" else settled.name(target)
        for target in (() if field == "name" else value)
    ]  # fmt: skip
    if field == "joint":
        part.joint = names[0] or BASE
    elif field != "name":
        setattr(part, field, tuple(names))
