"""The changes from one model to another, entity by entity and field by field."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

import msgspec

from urdf2mbs.plugin import ORIGIN, Mbs, without_origin
from urdf2mbs_edits.diff.matching import match_entities
from urdf2mbs_edits.diff.table import (
    GRAPHICAL_KINDS,
    KINDS,
    Entity,
    FieldPath,
    ModelTable,
    is_graphical,
    list_entities,
    make_table,
)


class Change(msgspec.Struct, omit_defaults=True, forbid_unknown_fields=True):
    """One change of an entity; units and frames are those of the file."""

    change: Literal["added", "removed", "renamed", "moved", "changed", "reordered"]
    kind: str
    """Kind of the entity, one of ``table.KINDS``."""
    name: str
    """Name of the entity before the change; if it was added, after it."""
    owner: str = ""
    """Label of what the entity belongs to, by its name before; if it was added, after."""
    field: str = ""
    """The field that changed; a path of XML elements if the model does not know it."""
    before: Any = None
    after: Any = None
    drawing: bool = False
    """Whether only pictures change: the 2D diagram or the 3D view."""


class Differences(msgspec.Struct):
    """The differences of two models."""

    changes: list[Change]
    versions: tuple[str, str]
    """Versions of MBSysPad that the files name; they do not count as a difference."""
    renumbered: dict[str, tuple[int, int]]
    """Joints with another index in Robotran, by their names before."""


class LocatedChange(NamedTuple):
    """A change, and the path of the value that changed."""

    change: Change
    path: FieldPath


def find_differences(before: Mbs, after: Mbs, *, physics: bool = False) -> Differences:
    """Find the differences of two models.

    An entity that belongs to an added or removed one is not listed beside it.

    Args:
        before: One model.
        after: The model to compare with it.
        physics: Leave out changes of the drawing.
    """
    entities_before, entities_after = list_entities(before), list_entities(after)
    match_entities(entities_before, entities_after)
    located_changes = compare_tables(
        make_table(before, entities_before), make_table(after, entities_after)
    )
    indices_before, indices_after = before.numbers(), after.numbers()
    joints_after = {joint.number: joint.name for joint in entities_after if joint.kind == "joint"}
    indices = {
        joint.name: (indices_before[joint.name], indices_after[joints_after[joint.number]])
        for joint in entities_before
        if joint.kind == "joint" and joint.number in joints_after
    }
    return Differences(
        [change for change, _ in located_changes if not (physics and change.drawing)],
        (before.version, after.version),
        {name: pair for name, pair in indices.items() if pair[0] != pair[1]},
    )


def compare_tables(before: ModelTable, after: ModelTable) -> list[LocatedChange]:
    """Compare two tables; return the changes sorted by the kinds of entities."""
    changes = [*_compare_entities(before, after), *_compare_orders(before, after)]
    changes.sort(key=lambda located: KINDS.index(located.change.kind))  # stable
    return changes


def _compare_entities(before: ModelTable, after: ModelTable) -> Iterator[LocatedChange]:
    """Yield removed and added entities, then the changes of each entity in both tables."""
    for entity in _list_missing(before, after):
        change = _describe_entity("removed", entity, before=export_content(entity))
        yield LocatedChange(change, FieldPath(entity.number, ""))
    for entity in _list_missing(after, before):
        change = _describe_entity("added", entity, after=export_content(entity))
        yield LocatedChange(change, FieldPath(entity.number, ""))
    for number in before.entities:
        if number in after.entities:
            yield from _compare_values(before, after, number)


def _list_missing(table: ModelTable, other_table: ModelTable) -> Iterator[Entity]:
    """Yield the entities that only the first table has, but not what belongs to them."""
    for number, entity in table.entities.items():
        if number not in other_table.entities and (
            entity.owner is None or entity.owner.number in other_table.entities
        ):
            yield entity


def _describe_entity(verb: Any, entity: Entity, **content: Any) -> Change:
    """Return the change of a whole entity."""
    is_drawing = entity.kind in GRAPHICAL_KINDS
    return Change(verb, entity.kind, entity.name, entity.owner_label, drawing=is_drawing, **content)


def export_content(entity: Entity) -> Any:
    """Return an entity and all that belongs to it as plain data."""
    return _drop_empty(msgspec.to_builtins(entity.part, enc_hook=without_origin))


def _drop_empty(content: Any) -> Any:
    """Drop the fields of objects that have no value."""
    if isinstance(content, list):
        return [_drop_empty(part) for part in content]
    if not isinstance(content, dict):
        return content
    return {
        field: _drop_empty(value) for field, value in content.items() if value not in (None, [])
    }


def _compare_values(before: ModelTable, after: ModelTable, number: int) -> Iterator[LocatedChange]:
    """Yield the changes of an entity that both tables have: name, owner and other values."""
    entity = before.entities[number]
    values_before, values_after = before.values[number], after.values[number]
    for field in dict.fromkeys([*values_before, *values_after]):
        if field[0] == "[" or values_before.get(field) == values_after.get(field):
            continue
        old, new = resolve_value(before, number, field), resolve_value(after, number, field)
        changed_fields = [(field.lstrip("?"), old, new)]
        if field == "place":  # the two fields of the model
            pairs = zip(values_before[field], values_after[field], strict=True)
            changed_fields = [
                (part, [old[index]], [new[index]])
                for index, (part, pair) in enumerate(zip(("parent", "point"), pairs, strict=True))
                if pair[0] != pair[1]
            ]
        verb: Any = {"name": "renamed", "owner": "moved"}.get(field, "changed")
        for part, old_value, new_value in changed_fields:
            if field == "name" and old_value == new_value:
                continue
            change = Change(
                verb,
                entity.kind,
                entity.name,
                entity.owner_label,
                part,
                old_value,
                new_value,
                is_graphical(entity.kind, part),
            )
            yield LocatedChange(change, FieldPath(number, field))


def resolve_value(table: ModelTable, number: int, field: str) -> Any:
    """Return a value with names in place of references; a body's own frame is ``origin``."""
    entity = table.entities[number]
    if field == "name":
        return entity.name
    if field == "owner":
        return entity.owner_label
    if field[0] == "[":
        return [table.entities[child].name for child in table.list_children(number, field[1:-1])]
    if field in entity.references:
        return [
            ORIGIN if target is None else target.name if isinstance(target, Entity) else target
            for target in entity.references[field]
        ]
    return table.values[number].get(field)


def _compare_orders(before: ModelTable, after: ModelTable) -> Iterator[LocatedChange]:
    """Yield a change for each entity whose children of a kind have another order."""
    for number in before.entities:
        for field in before.values[number]:
            if field[0] != "[":
                continue
            kind = field[1:-1]
            children_before = before.list_children(number, kind)
            children_after = after.list_children(number, kind)
            common = set(children_before) & set(children_after)
            old = [child for child in children_before if child in common]
            new = [child for child in children_after if child in common]
            if old != new:
                change = Change(
                    "reordered",
                    kind,
                    "",
                    before.entities[number].qualified_label,
                    "order",
                    [before.entities[child].name for child in old],
                    [after.entities[child].name for child in new],
                    kind in GRAPHICAL_KINDS,
                )
                yield LocatedChange(change, FieldPath(number, field))
