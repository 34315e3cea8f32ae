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
        changes = describe_changes(self.changes)
        return f"{self.by} (plugin '{self.plugin}') changed of the robot: {changes}"


def encode(data: Any) -> bytes:
    """A copy of data, such as a robot, that can be compared and that later changes do not reach.

    Raises TypeError or ValueError where the data holds what a URDF cannot hold.
    """

    def plain(value: Any) -> Any:
        if hasattr(value, "tolist"):  # the numbers and arrays of numpy
            return value.tolist()
        raise TypeError(f"{value!r} ({type(value).__name__})")

    return msgspec.msgpack.encode(data, enc_hook=plain)


def find_changes(before: bytes, after: bytes) -> list[Change]:
    """The changes between two robots that ``encode`` gave, in the order of the file."""
    if before == after:
        return []
    return list(_changes(*(msgspec.msgpack.decode(robot, type=Robot) for robot in (before, after))))


def describe_changes(changes: list[Change]) -> str:
    """Changes in words: "21 masses, 1 joint origin"."""
    said = []
    for kind, count in Counter(change.kind for change in changes).items():
        word, _, done = kind.replace("_", " ").partition("-")
        if count > 1:
            word = _PLURALS.get(word, word.removesuffix("s") + "s")
        said.append(f"{count} {word} {done}".rstrip())
    return ", ".join(said)


#: The kinds of changes whose plural ends otherwise than in s.
_PLURALS = {"mass": "masses", "axis": "axes"}


def _changes(before: Robot, after: Robot) -> Iterator[Change]:
    if before.name != after.name:
        yield Change("name", "", before.name, after.name)
    links = _match_renamed(list(before.links), list(after.links))
    joints = _match_renamed(list(before.joints), list(after.joints))
    yield from _compare_names("link", before.links, after.links, links)
    for name, link in before.links.items():
        if links.get(name, name) in after.links:
            yield from _compare_links(link, after.links[links.get(name, name)])
    yield from _compare_names("joint", before.joints, after.joints, joints)
    for name, joint in before.joints.items():
        if joints.get(name, name) in after.joints:
            other = after.joints[joints.get(name, name)]
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
