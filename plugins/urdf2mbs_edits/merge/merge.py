"""The three-way merge: the base, the file that people edited, and the new conversion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from urdf2mbs.plugin import ConversionError, Mbs, read_mbs
from urdf2mbs_edits.diff.matching import match_added, match_entities
from urdf2mbs_edits.diff.table import (
    CHILD_KINDS,
    Entity,
    FieldPath,
    ModelTable,
    find_elements,
    list_entities,
    make_table,
    read_source,
)
from urdf2mbs_edits.merge.check import SideNames, check
from urdf2mbs_edits.merge.decide import MergedTable, Preference, decide
from urdf2mbs_edits.merge.layout import keep_layout
from urdf2mbs_edits.merge.plan import Plan, make_plan
from urdf2mbs_edits.merge.write import write

if TYPE_CHECKING:
    from collections.abc import Iterator

#: What to do if edits and URDF, or two versions of a file, do not fit together.
_HINT = "your file is unchanged: edit it or the URDF, and convert again; --fresh forgets all edits"
_HINT_FOR_GIT = "the file is unchanged: edit one of the versions, and merge again"


class Merged(msgspec.Struct):
    """A merged file, and what the merge did."""

    data: bytes
    plan: Plan
    names: dict[tuple[str, str], str | None]
    """Merged names of the converted bodies and joints, by kind and name.  None: removed."""


def merge(
    base: Mbs,
    edited: Mbs,
    converted: Mbs,
    preference: Preference | None = "urdf",
    file: str | None = None,
) -> Merged:
    """Merge the changes of people with those of a new conversion.

    The merged file is the edited file, in which only what the plan lists is changed.

    Args:
        base: The model from which both others started.
        edited: The model of the file that people edited.
        converted: The new model: just made, or read and not changed since.  It becomes the merged
            model.
        preference: Who wins if both changed a value.  None: people made both; see ``decide``.
        file: The file that is merged, for messages.

    Raises:
        ConversionError: The changes do not fit together (``merge-inconsistent``).
    """
    base_table, edited_table, converted_table = make_tables(base, edited, converted)
    table = decide(base_table, edited_table, converted_table, preference)
    if preference is None:
        names, hint = SideNames("theirs", "ours"), _HINT_FOR_GIT
    else:
        names, hint = SideNames(), _HINT
    _raise_inconsistencies(check(table, names), file, hint)
    if table.keeps_layout:
        pairs = (
            (entity.part, edited_table.entities.get(number))
            for number, entity in converted_table.entities.items()
        )
        keep_layout(converted, {id(part): match.part for part, match in pairs if match})
        entities = converted_table.entities.values()
        converted_table.elements = find_elements(read_source(converted), entities)
    data = write(table, read_source(edited))
    merged = read_mbs(data, "the merged file")
    entities_of_file = list_entities(merged)
    model = next(iter(table.entities))
    for entity, number in zip(entities_of_file, _list_in_order(table, model), strict=True):
        entity.number = number
    plan = make_plan(table, make_table(merged, entities_of_file), names)
    merged_names = {
        (entity.kind, entity.name): table.get_name(number) if number in table.entities else None
        for number, entity in converted_table.entities.items()
        if entity.kind in ("body", "joint")
    }
    _update_model(converted_table, entities_of_file)
    return Merged(data, plan, merged_names)


def make_tables(base: Mbs, edited: Mbs, converted: Mbs) -> tuple[ModelTable, ...]:
    """Make the tables of three versions, in which entities that are the same have one number."""
    models = base, edited, converted
    base_entities, *sides = entities = [list_entities(mbs) for mbs in models]
    for side in sides:
        match_entities(base_entities, side)
    base_numbers = {entity.number for entity in base_entities}
    match_added(
        *([entity for entity in side if entity.number not in base_numbers] for side in sides)
    )
    return tuple(make_table(mbs, side) for mbs, side in zip(models, entities, strict=True))


def _raise_inconsistencies(problems: list[str], file: str | None, hint: str) -> None:
    """Raise an error that has all problems, if there are any."""
    if not problems:
        return
    *previous, error = [ConversionError("merge-inconsistent", text, file=file) for text in problems]
    error.earlier = [problem.diagnostic() for problem in previous]
    error.hint = hint
    raise error


def _list_in_order(table: MergedTable, number: int) -> Iterator[int]:
    """Yield a merged entity, then all that belongs to it, in the order of ``list_entities``."""
    yield number
    for field in table.entities[number].part.__struct_fields__:
        path = FieldPath(number, f"[{CHILD_KINDS.get(field)}]")
        for child in table.orders.get(path, ()):
            yield from _list_in_order(table, child)


def _update_model(converted: ModelTable, merged: list[Entity]) -> None:
    """Make the converted model the merged one.

    Its objects stay where possible, since other parts of a conversion refer to them.
    """
    old_entities = converted.entities
    parts = {id(entity.part): old_entities.get(entity.number, entity).part for entity in merged}
    for entity in merged:
        for field in entity.part.__struct_fields__:
            value = getattr(entity.part, field)
            if isinstance(value, list):
                value = [parts[id(part)] for part in value]
            setattr(parts[id(entity.part)], field, parts.get(id(value), value))
