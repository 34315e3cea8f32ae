"""The three-way merge: what was written last, what people made of it, and the new conversion."""

from __future__ import annotations

import re
from copy import deepcopy
from typing import TYPE_CHECKING

import msgspec
from lxml import etree

from urdf2mbs.plugin import Mbs
from urdf2mbs.plugin import read_mbs as read
from urdf2mbs_edits.diff.flat import HELD, Thing, Version, elements, file_of, flat, things
from urdf2mbs_edits.diff.matching import match, match_added
from urdf2mbs_edits.merge.keep import keep
from urdf2mbs_edits.merge.plan import Left, Plan, plan_of
from urdf2mbs_edits.merge.settle import Prefer, Settled, Side
from urdf2mbs_edits.merge.write import write

if TYPE_CHECKING:
    from collections.abc import Iterator

    from urdf2mbs_edits.diff.changes import Path


class Merged(msgspec.Struct):
    """The merged file, the plan, and what the new conversion's names became."""

    data: bytes
    plan: Plan
    names: dict[tuple[str, str], str | None]
    """The names of the new conversion's bodies and joints, by kind and name; None: removed."""
    orphans: bytes | None
    """An .mbs of fragments: what is orphaned, and what a conflict left out."""


def merge(base: Mbs, edited: Mbs, new: Mbs, prefer: Prefer | None = "urdf") -> Merged:
    """Apply to ``new`` what people changed from ``base`` to ``edited``.

    ``prefer`` says who wins where both changed the same thing; None: people made both, the edited
    wins, and all but places in the diagram is a conflict.  ``new``, which was made, or read and not
    changed since, becomes the merged model.  The file is the edited one, in which only what the
    plan says is another.

    Raises ConversionError where the merged file would be none that can be read.
    """
    before, ours, theirs = versions(base, edited, new)
    settled = Settled(before, ours, theirs, prefer)
    orders = settled.orders()
    if settled.moved:
        parts = ((thing.part, ours.things.get(n)) for n, thing in theirs.things.items())
        keep(new, {id(part): mine.part for part, mine in parts if mine})
        theirs.elements = elements(file_of(new), theirs.things.values())
    data = write(settled, orders, file_of(edited))
    final = read(data, "the merged file")
    written = things(final)
    first = next(iter(settled.there))
    for thing, number in zip(written, _in_order(settled, orders, first), strict=True):
        thing.number = number
    result = flat(final, written)
    plan, left = plan_of(settled, result)
    names = {
        (thing.kind, thing.name): settled.name(number) if number in settled.there else None
        for number, thing in theirs.things.items()
        if thing.kind in ("body", "joint")
    }
    sides: dict[Side, tuple[Mbs, Version]] = {"edited": (edited, ours)}
    if new.origin is not None:  # a conversion is kept as the next base
        sides["urdf"] = new, theirs
    fragments = _fragments(left, sides)
    _become(theirs, written)
    return Merged(data, plan, names, fragments)


def versions(base: Mbs, edited: Mbs, new: Mbs) -> list[Version]:
    """The tables of the three models, in which what is the same has one number."""
    models = base, edited, new
    found = [things(mbs) for mbs in models]
    for after in found[1:]:
        match(found[0], after)
    known = {thing.number for thing in found[0]}
    match_added(*([t for t in side if t.number not in known] for side in found[1:]))
    return [flat(mbs, side) for mbs, side in zip(models, found, strict=True)]


def _in_order(settled: Settled, orders: dict[Path, list[int]], number: int) -> Iterator[int]:
    """A thing and what it holds, in the order of ``things``."""
    yield number
    for field in settled.there[number].part.__struct_fields__:
        for inner in orders.get((number, f"[{HELD.get(field)}]"), ()):
            yield from _in_order(settled, orders, inner)


def _become(theirs: Version, written: list[Thing]) -> None:
    """Make the model of theirs the merged one: who knows an object of it knows it there, too."""
    known = theirs.things
    parts = {id(t.part): known[t.number].part if t.number in known else t.part for t in written}
    for thing in written:
        for field in thing.part.__struct_fields__:
            value = getattr(thing.part, field)
            if isinstance(value, list):
                value = [parts[id(one)] for one in value]
            setattr(parts[id(thing.part)], field, parts.get(id(value), value))


def _fragments(left: list[Left], sides: dict[Side, tuple[Mbs, Version]]) -> bytes | None:
    """The elements of things that are left out of their files, each behind the lines that say
    why."""
    root = etree.Element("mbsDescR7")
    for side, (mbs, version) in sides.items():
        why: dict[int, list[str]] = {}
        for _, number, said in [one for one in left if one[0] == side]:
            why.setdefault(number, []).append(said)
        found = elements(file_of(mbs), version.things.values()) if why else {}
        for number, words in why.items():
            # two hyphens end a comment
            root.extend([etree.Comment(f" {re.sub('-(?=-)', '- ', said)} ") for said in words])
            if version.things[number].kind != "model":  # else it is the whole file
                root.append(deepcopy(found[number]))
                root[-1].tail = None
    if not len(root):
        return None
    etree.indent(root)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8") + b"\n"


def with_those_before(orphans: bytes, before: bytes) -> bytes:
    """The file of orphans with those that it has already."""
    end = b"</mbsDescR7>"
    new = orphans[orphans.index(b"<mbsDescR7>") + len(b"<mbsDescR7>") : orphans.index(end)].strip()
    if not before or new in before:
        return before or orphans
    head, found, tail = before.rpartition(end)
    return head.rstrip() + b"\n  " + new + b"\n" + found + tail if found else before + orphans
