"""Edits by themselves: a YAML file of changes, which a lab keeps beside its URDF.

Each document of the file is a list of the edits that ``differences`` finds from a base to an
edited file; a later document changes what the earlier ones have made.
"""

from __future__ import annotations

from typing import Any

import msgspec

from urdf2mbs.diff.changes import Change, content, in_words, plain_values
from urdf2mbs.diff.matching import Thing, things
from urdf2mbs.diff.words import line
from urdf2mbs.mbs import model
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.merge.apply import Applying, Edit, Known, Prefer, as_tuple
from urdf2mbs.messages.diagnostics import ConfigError, printable

#: What each kind of thing is, where it can be added.
_TYPES: dict[str, Any] = {
    "body": model.Body, "joint": model.Joint, "point": model.Point, "shape": model.Shape,
    "sensor": model.Sensor, "force": model.Sensor, "cut": model.Connection,
    "link": model.Connection, "user constraint": model.UserConstraint,
    "user model": model.UserModel, "parameter": model.Parameter,
    "user variable": model.UserVariable, "view": model.View, "viewpoint": model.Viewpoint,
    "light": model.Light,
}  # fmt: skip


def text(changes: list[Change]) -> str:
    """One document: each edit behind a line that says it in words."""
    import yaml

    parts = ["---\n"]
    for change in changes:
        said = printable(line(change)).replace("\n", " ")
        dumped = yaml.safe_dump(
            [msgspec.to_builtins(change)], sort_keys=False, allow_unicode=True,
            default_flow_style=None, width=100,
        )  # fmt: skip
        parts.append(f"# {said}\n{dumped}")
    return "".join(parts)


def read(data: bytes, file: str) -> list[list[tuple[Change, Any]]]:
    """The documents of a file of edits: each edit, and the object that it adds, if it adds one.

    Raises ConfigError.
    """
    import yaml

    from urdf2mbs.engine.yaml_text import Loader

    try:
        # of the safe kind
        documents = [document or [] for document in yaml.load_all(data, Loader)]
        return [
            [(change, _added(change)) for change in changes]
            for changes in msgspec.convert(documents, list[list[Change]])
        ]
    except (yaml.YAMLError, msgspec.ValidationError, UnicodeDecodeError) as error:
        raise ConfigError(
            "edits-unreadable", f"this is no file of edits: {' '.join(str(error).split())}",
            file=file, hint="urdf2mbs edits writes one",
        ) from None  # fmt: skip


def _added(change: Change) -> Any:
    if change.change in ("added", "removed") and change.kind not in _TYPES:
        raise msgspec.ValidationError(f"no '{change.kind}' can be {change.change}")
    return msgspec.convert(change.after, _TYPES[change.kind]) if change.change == "added" else None


def apply(mbs: Mbs, changes: list[tuple[Change, Any]], prefer: Prefer) -> Applying:
    """Make the edits of one document; gives what became of them.

    Raises ValueError where an edit has a value of another type than the model.
    """
    there = things(mbs)
    known = Known([(thing, thing) for thing in there])
    applying = Applying(there, known, None, prefer)
    edits = [Edit(change, _target(there, known, change), part) for change, part in changes]
    applying.apply(edits)
    for edit in edits:
        if edit.target is not None:
            part = edit.target.part
            try:
                msgspec.convert(msgspec.to_builtins(part, enc_hook=lambda _: None), type(part))
            except msgspec.ValidationError as error:
                raise ValueError(f"{line(edit.change)}: {error}") from None
    return applying


def _target(there: list[Thing], known: Known, change: Change) -> Thing | None:
    """The thing that an edit changes; of what was added or reordered, its owner."""
    if change.change in ("added", "reordered"):
        return known.owners.get(change.owner)
    found = [
        thing for thing in there
        if thing.kind == change.kind and (thing.name == change.name or change.kind in _ONLY)
        and (thing.owner is None or in_words(thing.owner) == change.owner)
    ]  # fmt: skip
    for thing in found:  # shapes may have one name
        now = plain_values(thing).get(change.field, content(thing.part))
        if as_tuple(now) == as_tuple(change.before):
            return thing
    return found[0] if found else None


_ONLY = frozenset(["model", "base", "view"])
