"""Decide each value of a merge: three tables become one.

The two sides of a merge start from the same base: the *edited* file, in which people changed the
base, and the *converted* model, in which the URDF changed it::

        base --- people ---> edited ------+
          |                               |--> merged
          +----- the URDF ---> converted -+

For each path, the merged table takes the value of the only side that changed it.  If both changed
it, the preference decides, and the path is a conflict.  An entity that one side removed is not in
the merged model, unless the other side changed it and wins.

The decisions are independent, so they may not fit together: a reference may have lost its target.
``check`` finds that.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal, NamedTuple

import msgspec

from urdf2mbs_edits.diff.changes import Change, compare_tables
from urdf2mbs_edits.diff.table import Entity, FieldPath, ModelTable, is_diagram_position
from urdf2mbs_edits.merge.order import Orders, merge_orders, sort_parents_first

#: The side whose value is used; ``urdf`` is the converted model.
Winner = Literal["urdf", "edited"]
#: Who wins if both sides changed a value: for all fields, or by the names of fields.
Preference = Winner | dict[str, Winner]

#: Kinds and fields that people set, not the URDF: there the edit wins by default.
_KINDS_SET_BY_PEOPLE = frozenset(["sensor", "force", "view", "viewpoint", "light", "user variable"])
_FIELDS_SET_BY_PEOPLE = frozenset(
    ["q", "qd", "qdd", "nature", "symbols", "actuated", "color", "transparency"]
)


class MergedTable(msgspec.Struct):
    """The table of the merged model: its entities, and which side gives each value."""

    base: ModelTable
    edited: ModelTable
    converted: ModelTable
    edits: dict[FieldPath, Change]
    """The changes from base to edited."""
    keeps_layout: bool
    """Whether the diagram stays as people have it, since they moved something in it."""
    entities: dict[int, Entity] = {}
    """The entities of the merged model, as edited if both sides have them."""
    orders: dict[FieldPath, list[int]] = {}
    """The children of each entity, by kind, in their order."""
    from_converted: set[FieldPath] = set()
    """Paths with the value of ``converted``, of entities that ``edited`` also has."""
    conflicts: list[FieldPath] = []
    """Paths that both sides changed differently."""

    def is_from_edited(self, number: int, field: str) -> bool:
        """Return whether a value is that of ``edited``."""
        return number in self.edited.values and (number, field) not in self.from_converted

    def get_value(self, number: int, field: str) -> Any:
        """Return a merged value; None if the entity has no such field."""
        return self._get_side(number, field).values[number].get(field)

    def get_name(self, number: int) -> str:
        """Return the merged name of an entity; a parameter may have the name of a joint."""
        value = self.get_value(number, "name")
        target = value[0] if isinstance(value, tuple) else value
        if not isinstance(target, int):
            return str(target)
        if target in self.entities:
            return self.get_name(target)
        return self._get_side(number, "name").entities[number].name

    def _get_side(self, number: int, field: str) -> ModelTable:
        """Return the side that gives a value."""
        return self.edited if self.is_from_edited(number, field) else self.converted


def decide(
    base: ModelTable,
    edited: ModelTable,
    converted: ModelTable,
    preference: Preference | None = "urdf",
) -> MergedTable:
    """Decide which side gives each value of the merged model.

    Args:
        base: The version from which both sides started.
        edited: The version that people edited.
        converted: The new conversion, or the other version of a file.
        preference: Who wins if both sides changed a value.  None: people made both sides;
            ``edited`` wins, and each difference but a position in the diagram is a conflict.
    """
    edits = {path: change for change, path in reversed(compare_tables(base, edited))}
    # A conversion draws its diagram anew: moved as a whole, not mixed box by box.
    keeps_layout = preference is not None and any(
        is_diagram_position(change.kind, path.field) for path, change in edits.items()
    )
    table = MergedTable(base, edited, converted, edits, keeps_layout)
    for number in edited.values:
        if number in converted.values:
            _decide_values(table, number, preference)
    deleted = _find_deletions(table, preference)
    table.entities = _select_entities(table, deleted)
    table.orders = _decide_orders(table, preference)
    return table


def _decide_values(table: MergedTable, number: int, preference: Preference | None) -> None:
    """Decide the values of an entity that both sides have, but not the orders of its children."""
    base_values = table.base.values.get(number, {})
    edited_values, converted_values = table.edited.values[number], table.converted.values[number]
    kind = table.edited.entities[number].kind
    for field in dict.fromkeys([*edited_values, *converted_values]):
        base, edited, converted = (
            values.get(field) for values in (base_values, edited_values, converted_values)
        )
        if field[0] == "[" or converted in (edited, base):
            continue
        if table.keeps_layout and edited is not None and is_diagram_position(kind, field):
            continue
        path = FieldPath(number, field)
        if edited == base or _resolve_conflict(table, path, preference) == "urdf":
            table.from_converted.add(path)


class _Ruling(NamedTuple):
    """Who wins if both sides changed a value, and whether people should know."""

    winner: Winner
    is_conflict: bool


def _rule(kind: str, field: str, preference: Preference | None) -> _Ruling:
    """Decide who wins if both sides changed a field.

    Args:
        kind: Kind of the entity.
        field: The field; empty if ``edited`` removed an entity that ``converted`` changed.
        preference: As for ``decide``.
    """
    is_set_by_people = kind in _KINDS_SET_BY_PEOPLE or field in _FIELDS_SET_BY_PEOPLE
    keeps_edit = is_diagram_position(kind, field) or (is_set_by_people and preference is not None)
    winner: Winner = "edited" if keeps_edit or preference in ("edited", None) else "urdf"
    if isinstance(preference, dict):
        keys = (key for key in _list_preference_keys(field) if key in preference)
        key = next(keys, None)
        winner = winner if key is None else preference[key]
    return _Ruling(winner, is_conflict=not keeps_edit)


def _list_preference_keys(field: str) -> list[str]:
    """List the keys of the option ``prefer`` that concern a field, the first found counts."""
    if field == "":
        return ["removed"]
    if field == "place":
        return ["parent", "point"]
    key = field.strip("?[]").split(".")[0]
    return [key, "order"] if field[0] == "[" else [key]


def _resolve_conflict(table: MergedTable, path: FieldPath, preference: Preference | None) -> Winner:
    """Decide who wins where both sides changed a value, and record the conflict."""
    number, field = path
    entity = table.base.entities.get(number) or table.edited.entities[number]
    ruling = _rule(entity.kind, field, preference)
    if ruling.is_conflict and path not in table.conflicts:
        table.conflicts.append(path)
    return ruling.winner


# --- entities ---


def _find_deletions(table: MergedTable, preference: Preference | None) -> set[int]:
    """Find the entities that ``edited`` removed, without those that belong to them.

    If ``converted`` changed such an entity, or something that belongs to it, one side wins.
    """
    removed = [
        number
        for number in table.converted.values
        if number in table.base.values and number not in table.edited.values
    ]
    changed: set[int] = set()
    for number in removed:
        if _is_changed_by_conversion(table, number):
            owners = table.converted.entities[number].list_owners()
            changed |= {owner.number for owner in owners}
    deleted = set()
    for number in removed:
        if table.base.values[number]["owner"] not in table.edited.values:
            continue  # it went with its owner
        path = FieldPath(number, "")
        if number not in changed or _resolve_conflict(table, path, preference) == "edited":
            deleted.add(number)
    return deleted


def _is_changed_by_conversion(table: MergedTable, number: int) -> bool:
    """Return whether ``converted`` changed more of an entity than its place in the diagram."""
    base_values, converted_values = table.base.values[number], table.converted.values[number]
    kind = table.base.entities[number].kind
    for field in {*base_values, *converted_values}:
        base, converted = base_values.get(field), converted_values.get(field)
        if field[0] == "[":  # only children that were added are a reason to keep the entity
            if not set(converted or ()) <= set(base or ()):
                return True
        elif base != converted and not is_diagram_position(kind, field):
            return True
    return False


def _select_entities(table: MergedTable, deleted: set[int]) -> dict[int, Entity]:
    """Select the entities of both sides that neither side removed."""
    entities = {**table.converted.entities, **table.edited.entities}
    return {
        number: entity
        for number, entity in entities.items()
        if (number in table.converted.entities or number not in table.base.entities)
        and (number in table.edited.entities or not _is_deleted(table, number, deleted))
    }


def _is_deleted(table: MergedTable, number: int, deleted: Iterable[int]) -> bool:
    """Return whether an entity of ``converted`` alone is, or belongs to, a deleted entity."""
    for owner in table.converted.entities[number].list_owners():
        if owner.number in table.edited.entities:
            return False
        if owner.number in deleted:
            return True
    return False


# --- orders ---


def _decide_orders(table: MergedTable, preference: Preference | None) -> dict[FieldPath, list[int]]:
    """Decide the order of the children of each entity, kind by kind."""
    children: dict[FieldPath, set[int]] = {}
    for number, entity in table.entities.items():
        if entity.owner is not None:
            path = FieldPath(table.get_value(number, "owner"), f"[{entity.kind}]")
            children.setdefault(path, set()).add(number)
    return {path: _decide_order(table, path, children[path], preference) for path in children}


def _decide_order(
    table: MergedTable, path: FieldPath, children: set[int], preference: Preference | None
) -> list[int]:
    """Decide the order of an entity's children of one kind."""
    kind = path.field[1:-1]
    versions = (table.base, table.edited, table.converted)
    orders = Orders(
        *(
            [child for child in version.list_children(path.number, kind) if child in children]
            for version in versions
        )
    )

    def find_winner() -> Winner:
        winner = _resolve_conflict(table, path, preference)
        if winner == "urdf":
            table.from_converted.add(path)
        return winner

    def get_sort_key(run: list[int]) -> list[tuple[str, str]]:
        edited, converted = table.edited.values, table.converted.values
        return [
            (table.get_name(child), repr(edited.get(child) or converted[child])) for child in run
        ]

    # Joints act one after the other: their order is mechanics.
    sort_key = None if kind == "joint" else get_sort_key
    order = merge_orders(orders, find_winner, sort_key)
    if kind == "body":
        parents = {body: (table.get_value(body, "place") or (None,))[0] for body in order}
        return sort_parents_first(order, parents)
    return order
