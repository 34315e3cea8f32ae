"""Describe changes in words, one line each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from urdf2mbs.plugin import counted, some
from urdf2mbs_edits.diff.changes import Change, Differences
from urdf2mbs_edits.diff.table import UNNAMED_KINDS

#: The words for fields of the model whose names are not these words.
FIELDS = {
    "com": "centre of mass",
    "q": "initial position",
    "qd": "initial velocity",
    "qdd": "initial acceleration",
    "point": "anchor point",
    "endpoint1": "first end",
    "endpoint2": "second end",
    "measures": "signals",
    "url": "file",
}
UNITS = {
    "mass": "kg",
    "com": "m",
    "inertia": "kg m^2",
    "coordinates": "m",
    "gravity": "m/s^2",
    "length": "m",
}
#: Longer texts of XML elements are cut (letters).
_MAX_LETTERS = 60
#: More children in a new order are counted only.
_MAX_REORDERED = 6


def describe_changes(
    differences: Differences, *, drawing: bool = False, hint: str = ""
) -> list[str]:
    """Describe each change in a line.

    Args:
        differences: The changes.
        drawing: Also describe each change of the drawing; by default they are counted.
        hint: How the user sees the changes of the drawing that are counted.
    """
    lines = [
        describe_change(change) for change in differences.changes if drawing or not change.drawing
    ]
    drawn = [change for change in differences.changes if change.drawing]
    if drawn and not drawing:
        entities = {(change.kind, change.owner, change.name) for change in drawn}
        counts = Counter(kind for kind, _, _ in entities)
        kinds = ", ".join(counted(counts[kind], kind) for kind in sorted(counts))
        count = counted(len(drawn), "difference")
        lines.append(f"the drawing: {count} of {kinds}" + (f" ({hint})" if hint else ""))
    return lines


def describe_remarks(differences: Differences) -> list[str]:
    """Describe changed indices of joints and versions of MBSysPad."""
    lines = []
    indices = differences.renumbered
    if indices:
        joints = some((f"'{name}' {old} -> {new}" for name, (old, new) in indices.items()), 3)
        verb = "has" if len(indices) == 1 else "have"
        count = counted(len(indices), "joint")
        lines.append(f"{count} {verb} another number in Robotran: {joints}")
    before, after = differences.versions
    if before != after:
        lines.append(f"the files are of MBSysPad {before} and {after}")
    return lines


def describe_change(change: Change) -> str:
    """Describe one change."""
    name = f" '{change.name}'" if change.name else ""
    entity = f"{change.kind}{name}" + (f" of {change.owner}" if change.owner else "")
    if change.kind in UNNAMED_KINDS:
        entity = f"the {change.kind}"
    if change.change == "added":
        return f"{entity} added{_summarize(change.kind, change.after)}"
    if change.change == "removed":
        return f"{entity} removed{_summarize(change.kind, change.before)}"
    if change.change == "renamed":
        return f"{entity} renamed to '{change.after}'"
    if change.change == "moved":
        return f"{change.kind}{name} moved from {change.before} to {change.after}"
    if change.change == "reordered":
        kinds = counted(2, change.kind).removeprefix("2 ")
        owner = f" of {change.owner}" if change.owner else ""
        order = some((f"'{child}'" for child in change.after), _MAX_REORDERED)
        return f"{kinds}{owner} reordered: {order}"
    field = FIELDS.get(change.field, change.field.replace("_", " ").replace(".", ": "))
    unit = UNITS.get(change.field, "")
    old, new = format_value(change.before), format_value(change.after)
    if old == new:  # only the last digits differ
        old, new = str(change.before), str(change.after)
    return f"{entity}: {field} {old} -> {new} {unit}".rstrip()


def _summarize(kind: str, content: dict[str, Any]) -> str:
    """Summarize an added or removed entity in a few words, after a colon."""
    facts: list[str] = []
    if kind == "body":
        joints = [
            f"'{joint['name']}' ({joint['type']}, {joint['nature']})" for joint in content["joints"]
        ]
        facts = [f"on {_describe_place((content.get('parent'), content.get('point')))}"]
        facts.append(f"{'joint' if len(joints) == 1 else 'joints'} {some(joints, 6)}")
        if "mass" in content:
            facts.append(f"{format_value(content['mass'])} kg")
    elif kind == "joint":
        facts = [content["type"], content["nature"]]
    elif kind == "point":
        facts = [f"at {format_value(content['coordinates'])} m"]
        facts += [
            f"{field} '{content[field]['name']}'"
            for field in ("sensor", "extforce")
            if field in content
        ]
    elif kind in ("cut", "link"):
        ends = [_describe_place(content[end]) for end in ("endpoint1", "endpoint2")]
        facts = [f"{content['kind']} between {ends[0]} and {ends[1]}"]
    elif kind == "shape":
        facts = [content["kind"]]
    elif kind == "parameter":
        facts = [content["type"], *content.get("values", ())[:3]]
    return f": {', '.join(facts)}" if facts else ""


def _describe_place(place: Sequence[str | None]) -> str:
    """Describe a body and one of its points."""
    body, point = place
    label = "the base" if body is None else f"body '{body}'"
    return f"{label} ({point or 'origin'})"


def format_value(value: Any) -> str:
    """Format a value of a model for a message."""
    if value is None:
        return "none"
    if isinstance(value, float):
        return f"{value:.15g}"  # a double's last digits depend on how it was computed
    if isinstance(value, list | tuple):
        if len(value) == 1:
            return format_value(value[0])
        return "(" + ", ".join(map(format_value, value)) + ")"
    if isinstance(value, str):
        if value.removeprefix("-")[:1].isdigit():
            return value  # a number of a user model
        return f"'{value}'" if len(value) <= _MAX_LETTERS else f"'{value[:_MAX_LETTERS]} ...'"
    return str(value)
