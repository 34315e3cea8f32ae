"""The changes between two states of a robot: each value that a pass has changed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from urdf2mbs.urdf.model import Joint, Link, Robot


class Change(msgspec.Struct):
    """One value that is another now; units and frames are the URDF's."""

    kind: str
    """``mass``, ``centre`` or ``inertia``; a field of a link, joint or robot; ``order``; or
    ``link-added``, ``joint-removed`` and the like."""
    name: str
    """The link or joint, by its name before; empty for what belongs to the whole robot."""
    before: Any = None
    after: Any = None


class RobotChange(msgspec.Struct):
    """What somebody has changed of the robot that the URDF states."""

    by: str
    """The pass; or the hook, such as "the hook after 'emit'"."""
    plugin: str
    """Whose it is."""
    declared: bool
    """Whether the pass says so, by ``writes = ("robot",)``."""
    changes: list[Change]

    def __str__(self) -> str:
        return f"{self.by} (plugin '{self.plugin}') changed of the robot: {describe(self.changes)}"


def snapshot(robot: Robot) -> bytes:
    """A copy of a robot that later changes do not reach; ``between`` reads it.

    Raises TypeError or ValueError where the robot holds what a URDF cannot hold.
    """
    return encode(robot)


def encode(data: Any) -> bytes:
    """Data as bytes that can be compared; raises TypeError or ValueError where they cannot."""
    return msgspec.msgpack.encode(data, enc_hook=_plain)


def _plain(value: Any) -> Any:
    """The numbers and arrays of numpy as Python's own numbers and lists."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{value!r} ({type(value).__name__})")


def between(before: bytes, after: bytes) -> list[Change]:
    """The changes between two snapshots, in the order of the file."""
    if before == after:
        return []
    return list(_changes(*(msgspec.msgpack.decode(robot, type=Robot) for robot in (before, after))))


def describe(changes: list[Change]) -> str:
    """Changes in words: "21 masses, 1 joint origin"."""
    counts = Counter(change.kind for change in changes)
    return ", ".join(_count(kind, count) for kind, count in counts.items())


def _count(kind: str, count: int) -> str:
    word, _, done = kind.replace("_", " ").partition("-")
    if count > 1 and (not word.endswith("s") or word in _PLURALS):
        word = _PLURALS.get(word, f"{word}s")
    return f"{count} {word} {done}".rstrip()


#: The kinds of changes whose plural ends otherwise than in s.
_PLURALS = {"mass": "masses", "axis": "axes"}


def _changes(before: Robot, after: Robot) -> Iterator[Change]:
    if before.name != after.name:
        yield Change("name", "", before.name, after.name)
    links = _match_renamed(list(before.links), list(after.links))
    joints = _match_renamed(list(before.joints), list(after.joints))
    yield from _compare_names("link", before.links, after.links, links)
    for name, link in before.links.items():
        now = after.links.get(links.get(name, name))
        if now is not None:
            yield from _compare_links(link, now)
    yield from _compare_names("joint", before.joints, after.joints, joints)
    for name, joint in before.joints.items():
        other = after.joints.get(joints.get(name, name))
        if other is not None:
            yield from _compare_joints(joint, other, links, joints)
    both = ((before.links, after.links, links), (before.joints, after.joints, joints))
    if any(_is_reordered(old, new, names) for old, new, names in both):
        yield Change("order", "")
    for field in ("materials", "extensions"):
        if getattr(before, field) != getattr(after, field):
            yield Change(field, "")


def _is_reordered(
    before: Mapping[str, object], after: Mapping[str, object], names: Mapping[str, str]
) -> bool:
    """True if the links or joints that are in both robots stand in another order."""
    kept = {names.get(name, name): None for name in before if names.get(name, name) in after}
    return list(kept) != [name for name in after if name in kept]


def _match_renamed(before: list[str], after: list[str]) -> dict[str, str]:
    """The names that have another in their place."""
    if len(before) != len(after):
        return {}
    old, new = set(before), set(after)
    return {
        name: renamed
        for name, renamed in zip(before, after, strict=True)
        if name not in new and renamed not in old
    }


def _compare_names(
    kind: str, before: Mapping[str, object], after: Mapping[str, object], names: Mapping[str, str]
) -> Iterator[Change]:
    """The links or joints that were added, removed or renamed."""
    for name in before:
        if name in names:
            yield Change(f"{kind}-renamed", name, name, names[name])
        elif name not in after:
            yield Change(f"{kind}-removed", name)
    known = {*before, *names.values()}
    for name in after:
        if name not in known:
            yield Change(f"{kind}-added", name)


def _compare_links(before: Link, after: Link) -> Iterator[Change]:
    for kind, field in (("mass", "mass"), ("centre", "origin"), ("inertia", "inertia")):
        old, new = getattr(before.inertial, field, None), getattr(after.inertial, field, None)
        if old != new:
            yield Change(kind, before.name, old, new)
    for kind in ("visuals", "collisions"):
        if getattr(before, kind) != getattr(after, kind):
            yield Change(kind, before.name)


def _compare_joints(
    before: Joint, after: Joint, links: Mapping[str, str], joints: Mapping[str, str]
) -> Iterator[Change]:
    mimic = before.mimic
    if mimic is not None:
        mimic = msgspec.structs.replace(mimic, joint=joints.get(mimic.joint, mimic.joint))
    expected = msgspec.structs.replace(
        before,
        parent=links.get(before.parent, before.parent),
        child=links.get(before.child, before.child),
        mimic=mimic,
    )
    for kind in (
        "type", "parent", "child", "origin", "axis", "limit", "dynamics", "mimic",
        "safety_controller", "calibration",
    ):  # fmt: skip
        old, new = getattr(expected, kind), getattr(after, kind)
        if old != new:
            yield Change(kind, before.name, old, new)
