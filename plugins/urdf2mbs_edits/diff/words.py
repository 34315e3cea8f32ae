"""Changes in words, one line each: what a person reads before and after an edit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from urdf2mbs.plugin import counted, some
from urdf2mbs_edits.diff.changes import Change, Differences

#: How a field of the model is called.
FIELDS = {
    "com": "centre of mass", "q": "initial position", "qd": "initial velocity",
    "qdd": "initial acceleration", "point": "anchor point", "endpoint1": "first end",
    "endpoint2": "second end", "measures": "signals", "url": "file",
}  # fmt: skip
UNITS = {
    "mass": "kg", "com": "m", "inertia": "kg m^2", "coordinates": "m", "gravity": "m/s^2",
    "length": "m",
}  # fmt: skip
#: The longest text of an element that is shown.
_LONGEST = 60


def in_words(differences: Differences, *, drawing: bool = False) -> list[str]:
    """A line for each change; those of the drawing are counted, unless ``drawing``."""
    lines = [line(change) for change in differences.changes if drawing or not change.drawing]
    drawn = [change for change in differences.changes if change.drawing]
    if drawn and not drawing:
        things = Counter(kind for kind, _, _ in {(c.kind, c.owner, c.name) for c in drawn})
        of = ", ".join(counted(things[kind], kind) for kind in sorted(things))
        lines.append(
            f"the drawing: {counted(len(drawn), 'difference')} of {of} (--drawing lists them)"
        )
    return lines


def remarks(differences: Differences) -> list[str]:
    """Lines about numbers of joints and versions of MBSysPad."""
    lines = []
    numbers = differences.renumbered
    if numbers:
        joints = some((f"'{name}' {old} -> {new}" for name, (old, new) in numbers.items()), 3)
        verb = "has" if len(numbers) == 1 else "have"
        lines.append(
            f"{counted(len(numbers), 'joint')} {verb} another number in Robotran: {joints}"
        )
    before, after = differences.versions
    if before != after:
        lines.append(f"the files are of MBSysPad {before} and {after}")
    return lines


def line(change: Change) -> str:
    """One change in words."""
    name = f" '{change.name}'" if change.name else ""
    who = f"{change.kind}{name}" + (f" of {change.owner}" if change.owner else "")
    if change.kind in ("model", "base", "view"):
        who = f"the {change.kind}"
    if change.change == "added":
        return f"{who} added{_described(change.kind, change.after)}"
    if change.change == "removed":
        return f"{who} removed{_described(change.kind, change.before)}"
    if change.change == "renamed":
        return f"{who} is called '{change.after}' now"
    if change.change == "moved":
        return f"{change.kind}{name} moved from {change.before} to {change.after}"
    if change.change == "reordered":
        of = f" of {change.owner}" if change.owner else ""
        now = some((f"'{thing}'" for thing in change.after), 6)
        return f"the order of {counted(2, change.kind)[2:]}{of}: now {now}"
    field = FIELDS.get(change.field, change.field.replace("_", " ").replace(".", ": "))
    unit = UNITS.get(change.field, "")
    texts = [value_in_words(value) for value in (change.before, change.after)]
    if texts[0] == texts[1]:  # they differ in the last digits only
        texts = [str(value) for value in (change.before, change.after)]
    values = " -> ".join(texts)
    return f"{who}: {field} {values} {unit}".rstrip()


def _described(kind: str, content: dict[str, Any]) -> str:
    """An added or removed thing in a few words."""
    said: list[str] = []
    if kind == "body":
        joints = [f"'{j['name']}' ({j['type']}, {j['nature']})" for j in content["joints"]]
        said = [f"on {_end((content.get('parent'), content.get('point')))}"]
        said.append(f"{counted(len(joints), 'joint')[2:]} {some(joints, 6)}")
        if "mass" in content:
            said.append(f"{value_in_words(content['mass'])} kg")
    elif kind == "joint":
        said = [content["type"], content["nature"]]
    elif kind == "point":
        said = [f"at {value_in_words(content['coordinates'])} m"]
        said += [f"{of} '{content[of]['name']}'" for of in ("sensor", "extforce") if of in content]
    elif kind in ("cut", "link"):
        ends = [_end(content[end]) for end in ("endpoint1", "endpoint2")]
        said = [f"{content['kind']} between {ends[0]} and {ends[1]}"]
    elif kind == "shape":
        said = [content["kind"]]
    elif kind == "parameter":
        said = [content["type"], *content.get("values", ())[:3]]
    return f": {', '.join(said)}" if said else ""


def _end(end: Sequence[str | None]) -> str:
    body, point = end
    on = "the base" if body is None else f"body '{body}'"
    return f"{on} ({point or 'origin'})"


def value_in_words(value: Any) -> str:
    """A value as a line of differences has it."""
    if value is None:
        return "none"
    if isinstance(value, float):
        return f"{value:.15g}"  # the last digits of a double are of its computation
    if isinstance(value, list | tuple):
        if len(value) == 1:
            return value_in_words(value[0])
        return "(" + ", ".join(map(value_in_words, value)) + ")"
    if isinstance(value, str) and value.removeprefix("-")[:1].isdigit():
        return value  # a number of a user model
    if isinstance(value, str):
        return f"'{value}'" if len(value) <= _LONGEST else f"'{value[:_LONGEST]} ...'"
    return str(value)
