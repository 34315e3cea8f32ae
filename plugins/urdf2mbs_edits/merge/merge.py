"""The three-way merge: what was written last, what people made of it, and the new conversion."""

from __future__ import annotations

import re
from copy import deepcopy

import msgspec
from lxml import etree

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read, read_again
from urdf2mbs_edits.diff.flat import Thing, Version, flat, things
from urdf2mbs_edits.diff.matching import match, match_added
from urdf2mbs_edits.merge.build import build
from urdf2mbs_edits.merge.keep import keep
from urdf2mbs_edits.merge.plan import Left, Plan, plan_of
from urdf2mbs_edits.merge.settle import Prefer, Settled, Side
from urdf2mbs_edits.rewrite import write
from urdf2mbs_edits.unknown import unknown_elements

#: The element of each thing in its file, by the numbers of both; a tag, where it has no number.
Places = dict[int, int | str]


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
    wins, and all but places in the diagram is a conflict.  ``new`` becomes the merged model.  The
    file is the edited one, in which only what the plan says is another.

    Raises ConversionError where the merged file would be none that can be read.
    """
    assert edited.origin is not None
    other = new.origin.source if new.origin else None
    before, ours, theirs = versions(base, edited, new)
    settled = Settled(before, ours, theirs, prefer)
    sources: dict[Side, bytes | None] = {"edited": edited.origin.source, "urdf": other}
    mine, there = ({n: _place(t) for n, t in side.things.items()} for side in (ours, theirs))
    unknown = unknown_elements(new)
    numbers = build(settled, new)
    new.origin, new.version = edited.origin, edited.version
    if settled.moved:
        drawn = {part: ours.things[n].part for part, n in numbers.items() if n in ours.things}
        keep(new, drawn)
    brought = [
        (int(mine[n]), field[1:], unknown.get(int(there[n]), {}).get(field[1:]))
        for n, field in sorted(settled.taken)
        if field[0] == "?" and n in settled.there
    ]
    data = write(new, other=other, unknown=brought)
    final = read(data, "the merged file")
    written = things(final)
    for thing, then in zip(things(new), written, strict=True):
        then.number = numbers[id(thing.part)]
    result = flat(final, written)
    if other is None:
        theirs.know(result)
    plan, left = plan_of(settled, result)
    names = {
        (thing.kind, thing.name): settled.name(n) if n in settled.there else None
        for n, thing in theirs.things.items()
        if thing.kind in ("body", "joint")
    }
    return Merged(data, plan, names, _fragments(left, sources, {"edited": mine, "urdf": there}))


def versions(base: Mbs, edited: Mbs, new: Mbs) -> list[Version]:
    """The tables of the three models, in which what is the same has one number."""
    models = base, edited, new
    found = [things(mbs) for mbs in models]
    for after in found[1:]:
        match(found[0], after)
    known = {thing.number for thing in found[0]}
    match_added(*([t for t in side if t.number not in known] for side in found[1:]))
    versions = [flat(mbs, side) for mbs, side in zip(models, found, strict=True)]
    if new.origin is None:
        versions[2].know(versions[0])
    return versions


def _place(thing: Thing) -> int | str:
    """The number of a thing's element in its file; of the base and the view, the tag."""
    if thing.kind in ("base", "view"):
        return "base" if thing.kind == "base" else "x3D"
    return thing.part.origin.number if thing.part.origin else 0


def _fragments(
    left: list[Left], sources: dict[Side, bytes | None], places: dict[Side, Places]
) -> bytes | None:
    """The elements of things that are left out of their files, each behind the lines that say why;
    a model that was not read has none."""
    root = etree.Element("mbsDescR7")
    for side, source in sources.items():
        elements = read_again(source)[1] if source else []
        why: dict[int | str, list[str]] = {}
        for _, number, said in [one for one in left if one[0] == side and elements]:
            why.setdefault(places[side][number], []).append(said)
        for place, words in why.items():
            # two hyphens end a comment
            root.extend([etree.Comment(f" {re.sub('-(?=-)', '- ', said)} ") for said in words])
            if place:  # else it is the whole file
                found = elements[place] if isinstance(place, int) else elements[0].find(place)
                assert found is not None
                element = deepcopy(found)
                element.tail = None
                root.append(element)
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
