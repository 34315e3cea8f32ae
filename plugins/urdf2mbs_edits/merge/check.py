"""Check that the decisions of a merge fit together, so that a file can hold the result.

Each value of a merge is decided for itself.  The result may be no model, as when one side removed a
body to which the other side attached a spring.  Such a merge is refused: only people know what they
meant.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from urdf2mbs_edits.diff.table import UNNAMED_KINDS, ModelTable
from urdf2mbs_edits.merge.decide import MergedTable

#: Kinds of which their owner has at most one.
_SINGLE_KINDS = frozenset(["sensor", "force", "view"])
#: Kinds whose names are unique within their owner; all others are unique within the model.
_KINDS_NAMED_IN_OWNER = frozenset(["point", "parameter"])
#: Kinds whose names need not be unique.
_KINDS_NAMED_FREELY = frozenset(["model", "base", "shape", "view", "viewpoint", "light"])


class SideNames(NamedTuple):
    """What messages call the two sides of a merge."""

    converted: str = "the URDF"
    edited: str = "the edit"


class _Claim(NamedTuple):
    """What only one entity may have: its owner, for its kind, or its name in a scope."""

    kind: str
    owner: int | None
    """None: the scope of the name is the model."""
    field: str
    name: str = ""


def check(table: MergedTable, names: SideNames) -> list[str]:
    """List the inconsistencies of a merged table, a sentence each."""
    return [
        *_check_references(table, names),
        *_check_unique(table, names),
        *_check_joints(table, names),
        *_check_cycles(table),
    ]


def _check_references(table: MergedTable, names: SideNames) -> Iterator[str]:
    """Find entities whose owner or target is not in the merged model."""
    for number, entity in table.entities.items():
        for field in ("owner", *entity.references):
            if field == "name":  # of a parameter, which may have the name of no joint
                continue
            value = table.get_value(number, field)
            for target in value if isinstance(value, tuple) else (value,):
                if isinstance(target, int) and target not in table.entities:
                    is_removed_by_urdf = target in table.edited.entities
                    side = table.edited if is_removed_by_urdf else table.converted
                    remover = names.converted if is_removed_by_urdf else names.edited
                    verb = "belongs" if field == "owner" else "refers"
                    label = _get_label(table, number)
                    target_label = side.entities[target].qualified_label
                    yield f"{label} {verb} to {target_label}, which {remover} removed"
                    break  # a point is removed with its body


def _check_unique(table: MergedTable, names: SideNames) -> Iterator[str]:
    """Find names that several entities have, and points with several sensors.

    What one side already had so is accepted.
    """
    claims: dict[_Claim, list[int]] = {}
    for number, entity in table.entities.items():
        kind, owner = entity.kind, table.get_value(number, "owner")
        if kind in _SINGLE_KINDS:
            claims.setdefault(_Claim(kind, owner, "owner"), []).append(number)
        if kind not in _KINDS_NAMED_FREELY:
            scope = owner if kind in _KINDS_NAMED_IN_OWNER else None
            claim = _Claim(kind, scope, "name", table.get_name(number))
            claims.setdefault(claim, []).append(number)
    sides = f"{names.converted} and {names.edited} each"
    for claim, numbers in claims.items():
        is_accepted = any(
            all(_has_merged_value(table, side, number, claim.field) for number in numbers)
            for side in (table.edited, table.converted)
        )
        if len(numbers) == 1 or is_accepted:
            continue
        owner_label = "" if claim.owner is None else _get_label(table, claim.owner)
        if claim.field == "owner":
            yield f"{sides} put a {claim.kind} on {owner_label}"
        else:
            scope_text = f" in {owner_label}" if owner_label else ""
            yield f"{sides} gave a {claim.kind} the name '{claim.name}'{scope_text}"


def _check_joints(table: MergedTable, names: SideNames) -> Iterator[str]:
    """Find bodies without a joint."""
    bodies_with_joints = {
        table.get_value(number, "owner")
        for number, entity in table.entities.items()
        if entity.kind == "joint"
    }
    for number, entity in table.entities.items():
        if entity.kind == "body" and number not in bodies_with_joints:
            sides = f"{names.converted} and {names.edited}"
            yield f"{_get_label(table, number)} lost all joints: {sides} moved or removed them"


def _check_cycles(table: MergedTable) -> Iterator[str]:
    """Find bodies that are their own ancestors."""
    checked: set[Any] = set()
    for number, entity in table.entities.items():
        chain: list[Any] = []  # from the body towards the base
        body: Any = number if entity.kind == "body" else None
        while body in table.entities and body not in checked and body not in chain:
            chain.append(body)
            body = (table.get_value(body, "place") or (None,))[0]
        if body in chain:
            cycle = " to ".join(
                _get_label(table, member) for member in [*chain[chain.index(body) :], body]
            )
            yield f"bodies are attached in a circle: {cycle}"
        checked |= set(chain)


def _has_merged_value(table: MergedTable, side: ModelTable, number: int, field: str) -> bool:
    """Return whether a side has the value that the merged model has."""
    values = side.values.get(number, {})
    return field in values and values[field] == table.get_value(number, field)


def _get_label(table: MergedTable, number: int) -> str:
    """Return the label of an entity of a side, by its merged name."""
    entity = table.entities.get(number)
    if entity is None:
        return (table.edited.entities.get(number) or table.converted.entities[number]).label
    if entity.kind in UNNAMED_KINDS:
        return entity.label
    return f"{entity.kind} '{table.get_name(number)}'"
