"""What a merge does, before anything is written: what is updated, kept, in conflict, orphaned."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import msgspec

from urdf2mbs_edits.diff.changes import (
    Change,
    Differences,
    added,
    compare,
    content,
    shown,
)
from urdf2mbs_edits.diff.flat import Version, is_place
from urdf2mbs_edits.diff.words import in_words, line, value_in_words
from urdf2mbs_edits.merge.settle import Settled, Side


class Conflict(msgspec.Struct):
    """What both sides changed, or what no file can hold as both have it."""

    edit: Change
    urdf: Any
    """What the new conversion has."""
    wins: Side
    why: str = ""
    """Why the two do not go together; empty: they are two values of one path."""

    def words(self, other: str, own: str) -> str:
        """The conflict in a sentence; ``other`` and ``own`` are how the sides are called."""
        wins = other if self.wins == "urdf" else own
        has = self.why or f"{other} has {value_in_words(self.urdf)} now"
        return f"{line(self.edit)}; {has}: {wins} wins"


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


#: A thing that a side has, by its number, and why it is not so in the merged file.
Left = tuple[Side, int, str]


def plan_of(settled: Settled, result: Version) -> tuple[Plan, list[Left]]:
    """The plan, and what is left out; ``result`` is the table of the merged file."""
    ours, theirs = settled.ours, settled.theirs
    conflicts = list(_conflicts(settled))
    orphans: dict[tuple[Side, int], Orphan] = {}
    for side, number, change, why in _orphaned(settled):
        things = (ours if side == "edited" else theirs).things
        thing = things[number]
        while thing.owner and thing.owner.number not in settled.there:
            thing = thing.owner  # the largest that is gone with it
        orphan = orphans.setdefault((side, thing.number), Orphan(thing.kind, thing.name, [], why))
        orphan.edits += [change] if change else []
    left: list[Left] = [(side, number, orphan.why) for (side, number), orphan in orphans.items()]
    for conflict, number in conflicts:
        words = conflict.words(settled.other, settled.own)
        if conflict.wins == "urdf" and number in ours.things:
            left.append(("edited", number, words))
        elif conflict.wins == "edited":
            left.append(("urdf", number, words))
    updated, kept = ([change for change, _ in compare(side, result)] for side in (ours, theirs))
    said = [conflict for conflict, _ in conflicts]
    return Plan(updated, kept, said, list(orphans.values())), left


def _conflicts(settled: Settled) -> Iterator[tuple[Conflict, int]]:
    for (number, field), why in settled.contested.items():
        theirs = settled.theirs.things[number]
        if field and number not in settled.there:
            continue
        ours = settled.ours.things.get(number, theirs)
        edit = settled.edits.get((number, field)) or Change(
            "changed", ours.kind, ours.name, ours.owner.words() if ours.owner else "", field
        )
        now = shown(settled.theirs, number, field) if field else content(theirs)
        wins = settled.is_ours(number, field) if field else number not in settled.there
        yield Conflict(edit, now, "edited" if wins else "urdf", why), number


def _orphaned(settled: Settled) -> Iterator[tuple[Side, int, Change | None, str]]:
    """What cannot stand: the side that has it, its thing, the edit of it, and why."""
    base, ours, theirs, edits = settled.base, settled.ours, settled.theirs, settled.edits
    for number, why in settled.lost.items():
        side: Side = "edited" if number in ours.things else "urdf"
        version = ours if side == "edited" else theirs
        owner = version.things[number].owner
        within = owner is not None and owner.number in settled.lost
        yield side, number, None if within else added(version.things[number]), why
    for path, why in settled.homeless.items():
        if path in edits:
            yield "edited", path[0], edits[path], why
    for (number, field), change in edits.items():
        gone = number in base.things and number not in theirs.things
        whole = change.change in ("reordered", "removed")
        if gone and not whole and not is_place(change.kind, field):
            yield "edited", number, change, f"{ours.things[number].title()} is gone"
