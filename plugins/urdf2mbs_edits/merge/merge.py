"""The three-way merge: what was written last, what people made of it, and the new conversion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from copy import deepcopy
from typing import Any

import msgspec
from lxml import etree

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read, read_again
from urdf2mbs_edits.diff.changes import (
    Change,
    Differences,
    added,
    changed_things,
    differences,
    plain_values,
)
from urdf2mbs_edits.diff.matching import Matching, Thing, things
from urdf2mbs_edits.diff.words import in_words, line
from urdf2mbs_edits.merge.apply import Applying, Conflict, Edit, Prefer, is_place
from urdf2mbs_edits.merge.keep import keep
from urdf2mbs_edits.rewrite import write
from urdf2mbs_edits.unknown import unknown, unknown_elements


class Orphan(msgspec.Struct):
    """What people made and what can no longer stand."""

    kind: str
    name: str
    edits: list[Change]
    why: str

    def words(self) -> str:
        """The orphan in a sentence."""
        return f"{self.why}: {'; '.join(map(line, self.edits))}"


class Plan(msgspec.Struct):
    """What a merge does to the edited file."""

    updated: list[Change]
    """What changes in the edited file."""
    kept: list[Change]
    """What stays as people have it, and is not as in the new conversion."""
    conflicts: list[Conflict]
    orphaned: list[Orphan]

    def words(self, other: str = "the URDF", own: str = "the edit") -> dict[str, list[str]]:
        """The plan in sentences; places in the diagram and the like are counted.  ``other`` and
        ``own`` are how the two sides are called."""
        return {
            "updated": in_words(Differences(self.updated, ("", ""), {})),
            "kept": in_words(Differences(self.kept, ("", ""), {})),
            "in conflict": [conflict.words(other, own) for conflict in self.conflicts],
            "orphaned": [orphan.words() for orphan in self.orphaned],
        }


class Merged(msgspec.Struct):
    """A merge: the file, the plan, and what the new conversion's names became."""

    data: bytes
    plan: Plan
    names: dict[tuple[str, str], str | None]
    """The names of the new conversion's bodies and joints, by kind and name; None: removed."""
    orphans: bytes | None
    """An .mbs of fragments: what is orphaned."""


def merge(base: Mbs, edited: Mbs, new: Mbs, prefer: Prefer | None = "urdf") -> Merged:
    """Apply to ``new`` what people changed from ``base`` to ``edited``.

    ``prefer`` says who wins where both changed the same thing; None: people made both, the edited
    wins, and all but places in the diagram is a conflict.  ``new`` becomes the merged model.  The
    file is the edited one, in which only what the plan says is another.

    Raises ConversionError where the merged file would be none that can be read.
    """
    theirs = new.origin.source if new.origin else None
    pristine = read(write(new), "")
    seen, fresh = Matching(base, edited), Matching(base, new)
    bases = zip(seen.before, fresh.before, strict=True)
    to_new = {old: fresh.partner.get(thing) for old, thing in bases}
    now = {thing: to_new[seen.partner[thing]] for thing in seen.after if thing in seen.partner}
    _pair_added(seen, fresh, now)
    model = list(fresh.after)
    their_changes = changed_things(fresh, base, new)
    applying = Applying(
        fresh.after,
        seen.after,
        {old: thing for old, thing in to_new.items() if thing},
        {thing: then for thing, then in now.items() if then},
        _touched(fresh, their_changes, known=theirs is None),
        prefer,
    )
    edits = _edits(seen, changed_things(seen, base, edited), to_new, now)
    theirs_changed = [  # of elements that the model does not know
        (change, fresh.partner[old].part)
        for change, old in (their_changes if theirs is not None else ())
        if _is_unknown(change, old)
    ]
    their_elements = unknown_elements(new) if theirs is not None else {}
    their_numbers = {id(t.part): t.part.origin.number for t in fresh.after if _origin(t.part)}
    names = [(t, t.kind, t.name) for t in model if t.kind in ("body", "joint")]
    applying.apply(edits)
    _adopt(now, edited, new)
    if any(is_place(edit.change) for edit in edits):
        keep(new, {id(thing.part): old.part for old, thing in now.items() if thing})
        _adopt(now, edited, new)
    there = set(applying.model)
    orphans = _orphans(applying.orphans, now)
    brought = [
        (_origin(part).number, path, their_elements.get(their_numbers[id(part)], {}).get(path))
        for part, path in _unknown_to_bring(theirs_changed, edited, applying)
    ]
    data = write(new, other=theirs, unknown=brought)
    final = read(data, "the merged file")
    written = {
        id(thing.part): then.part for thing, then in zip(things(new), things(final), strict=True)
    }
    plan = Plan(
        _differences(edited, final, _same(edited, new), written),
        _differences(
            pristine, final,
            zip((t.part for t in things(pristine)), (t.part for t in model), strict=True), written,
        ),
        applying.conflicts,
        [Orphan(thing.kind, thing.name, changes, why) for thing, changes, why in orphans],
    )  # fmt: skip
    return Merged(
        data,
        plan,
        {(kind, name): thing.name if thing in there else None for thing, kind, name in names},
        _fragments(edited, [(thing.part, why) for thing, _, why in orphans]) if orphans else None,
    )  # fmt: skip


def _touched(fresh: Matching, changes: list[tuple[Change, Thing]], *, known: bool) -> set[Thing]:
    """The things of the new conversion in which something changed; ``known`` leaves out what the
    model does not know."""
    touched = set()
    for change, thing in changes:
        if change.change == "removed":
            touched |= {fresh.partner[owner] for owner in [thing.owner] if owner}
        elif change.change == "added":
            touched.add(thing)
        elif not is_place(change) and not (known and _is_unknown(change, thing)):
            touched.add(fresh.partner[thing])
    return touched


def _is_unknown(change: Change, thing: Thing) -> bool:
    """Whether a change is of an element or attribute that the model does not know."""
    plain = change.field in thing.refers or hasattr(thing.part, change.field.split(".")[0])
    return change.change == "changed" and not plain


def _edits(
    seen: Matching,
    changes: list[tuple[Change, Thing]],
    to_new: dict[Thing, Thing | None],
    now: dict[Thing, Thing | None],
) -> list[Edit]:
    """What people changed, each with the thing of the new conversion that gets the change."""
    edits: list[Edit] = []
    for change, thing in changes:
        if change.change != "added":
            edits.append(Edit(change, to_new[thing], seen.partner.get(thing, thing), thing))
        elif now.get(thing) is None and thing.owner is not None:
            edits.append(Edit(change, now.get(thing.owner), thing))
    for thing in seen.added():  # in what both sides added
        owner = now.get(thing.owner) if thing.owner not in seen.partner else None  # type: ignore[arg-type]
        if owner and now.get(thing) is None:
            edits.append(Edit(added(seen, thing), owner, thing))
    return edits


def _differences(
    before: Mbs, final: Mbs, same: Iterable[tuple[Any, Any]], written: dict[int, Any]
) -> list[Change]:
    """What differs in the merged file from another; ``same`` are objects of the other and of the
    merged model, ``written`` those of the file by the latter."""
    pairs = [(old, written.get(id(part))) for old, part in same]
    return differences(before, final, same=pairs).changes


def _unknown_to_bring(
    changes: list[tuple[Change, Any]], edited: Any, applying: Applying
) -> Iterator[tuple[Any, str]]:
    """What the other side alone changed of elements that the model does not know, as objects and
    paths; what both changed is a conflict, in which the file keeps its own."""
    texts = unknown(edited)
    there = {id(thing.part) for thing in applying.model}
    for change, part in changes:
        origin = _origin(part)
        if id(part) not in there or origin is None or origin.source is not edited.origin.source:
            continue
        now = texts.get(origin.number, {}).get(change.field)
        if now == change.before:
            yield part, change.field
        elif now != change.after:
            own = msgspec.structs.replace(change, after=now)
            applying.conflicts.append(Conflict(own, change.after, "edited"))


def _pair_added(seen: Matching, fresh: Matching, now: dict[Thing, Thing | None]) -> None:
    """Pair what both sides added alike, such as by a merge that was done before."""
    candidates = fresh.added()
    for thing in seen.added():
        for other in candidates:
            if (
                thing.kind == other.kind and thing.name == other.name and thing.owner
                and now.get(thing.owner) is other.owner and _said(thing) == _said(other)
                and all(
                    [now.get(t) if isinstance(t, Thing) else t for t in targets]
                    == list(other.refers[field])
                    for field, targets in thing.refers.items()
                )
            ):  # fmt: skip
                now[thing] = other
                candidates.remove(other)
                break


def _said(thing: Thing) -> dict[str, Any]:
    """The values of a thing but for its place in the diagram."""
    return {
        field: value
        for field, value in plain_values(thing).items()
        if not is_place(Change("changed", thing.kind, "", field=field))
    }


# --- the edited file ---


def _same(edited: Any, new: Mbs) -> list[tuple[Any, Any]]:
    """The objects of the edited file, and of the merged model, that are the same."""
    parts = {
        part.origin.number: part
        for part in (thing.part for thing in things(new))
        if _origin(part) and part.origin.source is edited.origin.source
    }
    same = [(t.part, parts.get(t.part.origin.number)) for t in things(edited) if _origin(t.part)]
    return [*same, (edited.base, new.base), (edited.view, new.view)]


def _origin(part: Any) -> Any:
    return getattr(part, "origin", None)


def _adopt(now: dict[Thing, Thing | None], edited: Mbs, new: Mbs) -> None:
    """Make the model that of the edited file: its elements, and its spelling of equal values."""
    new.origin, new.version = edited.origin, edited.version
    for old, thing in now.items():
        if thing is None or thing.kind == "model":
            continue
        if _origin(old.part) is not None:
            thing.part.origin = old.part.origin
        theirs = plain_values(old)
        for field, value in plain_values(thing).items():
            if theirs.get(field) == value:
                whole, _, inner = field.partition(".")
                source, target = old.part, thing.part
                if inner:
                    source, target = getattr(source, whole), getattr(target, whole)
                setattr(target, inner or whole, getattr(source, inner or whole))


# --- orphans ---


def _orphans(
    found: list[tuple[Edit, str]], now: dict[Thing, Thing | None]
) -> list[tuple[Thing, list[Change], str]]:
    """Orphaned edits by the largest thing of the edited file that is gone with them."""
    orphans: dict[Thing, tuple[list[Change], str]] = {}
    for edit, why in found:
        thing = edit.source
        while thing.owner in now and now[thing.owner] is None:
            thing = thing.owner
        orphans.setdefault(thing, ([], why))[0].append(edit.change)
    return [(thing, *said) for thing, said in orphans.items()]


def _fragments(edited: Mbs, orphans: list[tuple[Any, str]]) -> bytes:
    """The elements of objects of a file, each behind a line that says why it is there."""
    assert edited.origin is not None
    _, elements = read_again(edited.origin.source)
    root = etree.Element("mbsDescR7")
    for part, why in orphans:
        root.append(etree.Comment(f" {why.replace('--', '- -')} "))
        place = _origin(part)  # a view has none
        (element,) = deepcopy([elements[place.number]] if place else elements[0].findall("x3D"))
        element.tail = None
        root.append(element)
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
