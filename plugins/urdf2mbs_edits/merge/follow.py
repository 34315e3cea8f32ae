"""Update the other parts of a conversion after edits were merged into its model."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from urdf2mbs.plugin import Conversion, OnPurpose, Part
from urdf2mbs_edits.diff.changes import Change
from urdf2mbs_edits.diff.table import list_entities

#: Merged names by kind and converted name.  None: people removed it.
MergedNames = dict[tuple[str, str], str | None]
#: The kinds that the proof compares.
_COMPARED_KINDS = frozenset(
    ["base", "body", "joint", "point", "cut", "user constraint", "user model", "parameter"]
)


def update_conversion(
    conversion: Conversion, names: MergedNames, edits: Iterable[Change], file: str
) -> None:
    """Update names, plugin states and the proof's expectations.

    Args:
        conversion: The conversion, whose model is already merged.
        names: Merged names of its bodies and joints.
        edits: The edits that were kept.
        file: Name of the edited file.
    """
    _record_purpose(conversion, edits, file)
    _rename(conversion, names)
    _drop_removed_parts(conversion)


def _record_purpose(conversion: Conversion, edits: Iterable[Change], file: str) -> None:
    """Record the edits for the proof, which accepts changes on purpose."""
    on_purpose = conversion.state(OnPurpose)
    for edit in edits:
        if edit.drawing:
            continue
        if edit.change == "added":
            on_purpose.added[f"{edit.kind} '{edit.name}'"] = f"added in {file}"
        if edit.kind in _COMPARED_KINDS and (edit.change, edit.kind) != ("added", "point"):
            on_purpose.edited[file] = None


def _rename(conversion: Conversion, merged_names: MergedNames) -> None:
    """Give the robot's bodies and joints their merged names; drop those that people removed."""
    names = conversion.names

    def rename_all(kind: str, old_names: list[str]) -> list[str]:
        renamed = [merged_names.get((kind, name), name) for name in old_names]
        return [name for name in renamed if name is not None]

    names.bodies = {
        link: name for link, body in names.bodies.items() for name in rename_all("body", [body])
    }
    names.joints = {joint: rename_all("joint", joints) for joint, joints in names.joints.items()}
    names.coordinates = {
        joint: rename_all("joint", joints) for joint, joints in names.coordinates.items()
    }
    for link, frame in list(conversion.frames.items()):
        body, joint = (
            None if name is None else merged_names.get((kind, name), name)
            for kind, name in (("body", frame.body), ("joint", frame.joint))
        )
        if (body is None) != (frame.body is None) or (joint is None) != (frame.joint is None):
            del conversion.frames[link]
        else:
            frame.body, frame.joint = body, joint


def _drop_removed_parts(conversion: Conversion) -> None:
    """Drop from the lists of plugin states what uses an object that the model no longer has."""
    parts_of_model = {id(entity.part) for entity in list_entities(conversion.mbs)}
    lists: list[list[Any]] = []
    for state in conversion.states.values():
        values = [getattr(state, field) for field in getattr(state, "__struct_fields__", ())]
        lists += [value for value in values if isinstance(value, list)]
    for items in lists:
        items[:] = [item for item in items if parts_of_model.issuperset(map(id, _list_parts(item)))]


def _list_parts(item: Any) -> list[Any]:
    """List the objects of the model that an item of a plugin state is or uses."""
    if isinstance(item, Part):
        return [item]
    values = [getattr(item, field) for field in getattr(item, "__struct_fields__", ())]
    lists = [value if isinstance(value, list) else [value] for value in values]
    return [part for parts in lists for part in parts if isinstance(part, Part)]
