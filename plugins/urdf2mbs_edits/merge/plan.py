"""The plan of a merge: its updates, kept edits, conflicts and orphans."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

import msgspec

from urdf2mbs_edits.diff.changes import (
    Change,
    Differences,
    compare_tables,
    export_content,
    resolve_value,
)
from urdf2mbs_edits.diff.table import FieldPath, ModelTable, is_diagram_position
from urdf2mbs_edits.diff.wording import describe_change, describe_changes, format_value
from urdf2mbs_edits.merge.check import SideNames
from urdf2mbs_edits.merge.decide import MergedTable, Winner

#: The heading of updates that follow from others.
COMPUTED = "computed anew"


class Conflict(msgspec.Struct):
    """Two changes of one value, or a change of what the edit removed."""

    edit: Change
    urdf: Any
    """The value of the converted side."""
    wins: Winner

    def describe(self, names: SideNames) -> str:
        """Describe the conflict in a sentence."""
        winner = names.converted if self.wins == "urdf" else names.edited
        if self.edit.change == "removed":
            converted = f"{names.converted} changed it"
        else:
            converted = f"{names.converted} has {format_value(self.urdf)}"
        return f"{describe_change(self.edit)}; {converted}; {winner} is used"


class Orphan(msgspec.Struct):
    """Edits of an entity that the converted model no longer has."""

    kind: str
    name: str
    edits: list[Change]
    why: str

    def describe(self) -> str:
        """Describe the orphan in a sentence."""
        return f"{self.why}: {'; '.join(map(describe_change, self.edits))}"


class Plan(msgspec.Struct):
    """What a merge does to the edited file."""

    updated: list[Change]
    """What changes in the edited file."""
    kept: list[Change]
    """What stays as people have it, and differs from the new conversion."""
    conflicts: list[Conflict]
    orphaned: list[Orphan]

    def list_computed(self, stated_models: Collection[str]) -> list[Change]:
        """Return the updates that follow from others or from options, such as stiffnesses.

        Args:
            stated_models: The user models whose parameters are as the URDF states them; those of
                all others are computed.
        """
        stated_owners = {f"user model '{name}'" for name in stated_models}
        return [
            change
            for change in self.updated
            if change.kind == "parameter" and change.owner not in stated_owners
        ]

    def describe(self, names: SideNames, computed: Sequence[Change] = ()) -> dict[str, list[str]]:
        """Describe the plan in sentences by heading; changes of the drawing are counted.

        Args:
            names: What messages call the two sides.
            computed: The updates that get a heading of their own, after the others.
        """
        stated = [change for change in self.updated if change not in computed]
        return {
            "updated": describe_changes(Differences(stated, ("", ""), {})),
            **({COMPUTED: list(map(describe_change, computed))} if computed else {}),
            "kept": describe_changes(Differences(self.kept, ("", ""), {})),
            "in conflict": [conflict.describe(names) for conflict in self.conflicts],
            "orphaned": [orphan.describe() for orphan in self.orphaned],
        }


class _LostEdit(NamedTuple):
    """An edit of an entity that ``converted`` removed."""

    number: int
    change: Change


def make_plan(table: MergedTable, merged: ModelTable, names: SideNames) -> Plan:
    """Make the plan of a merge.

    Args:
        table: The decisions.
        merged: The table of the merged file.
        names: What messages call the two sides.
    """
    return Plan(
        updated=[change for change, _ in compare_tables(table.edited, merged)],
        kept=[change for change, _ in compare_tables(table.converted, merged)],
        conflicts=[
            _describe_conflict(table, path)
            for path in table.conflicts
            if not path.field or path.number in table.entities
        ],
        orphaned=_group_orphans(table, names),
    )


def _describe_conflict(table: MergedTable, path: FieldPath) -> Conflict:
    """Describe the conflict at a path."""
    number, field = path
    converted = table.converted.entities[number]
    entity = table.edited.entities.get(number, converted)
    edit = table.edits.get(path) or Change(
        "changed", entity.kind, entity.name, entity.owner_label, field
    )
    if field:
        value = resolve_value(table.converted, number, field)
        is_edit_used = table.is_from_edited(number, field)
    else:
        value = export_content(converted)
        is_edit_used = number not in table.entities
    return Conflict(edit, value, "edited" if is_edit_used else "urdf")


def _group_orphans(table: MergedTable, names: SideNames) -> list[Orphan]:
    """Group the lost edits by the largest entity that was removed."""
    orphans: dict[int, Orphan] = {}
    for number, change in _list_lost_edits(table):
        entity = table.edited.entities[number]
        why = f"{entity.label} was removed by {names.converted}"
        while entity.owner and entity.owner.number not in table.entities:
            entity = entity.owner
        orphan = orphans.setdefault(entity.number, Orphan(entity.kind, entity.name, [], why))
        orphan.edits.append(change)
    return list(orphans.values())


def _list_lost_edits(table: MergedTable) -> Iterator[_LostEdit]:
    """Yield the edits of values of entities that ``converted`` removed."""
    for (number, field), change in table.edits.items():
        is_removed = number in table.base.entities and number not in table.converted.entities
        is_value = change.change not in ("reordered", "removed")
        if is_removed and is_value and not is_diagram_position(change.kind, field):
            yield _LostEdit(number, change)
