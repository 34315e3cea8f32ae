"""The changes between two states of a robot: each value that a pass has changed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from urdf2mbs.urdf.model import Joint, Link, Robot

#: The kinds of changes whose plural does not end in s.
_PLURALS = {"mass": "masses", "axis": "axes"}
#: The kinds of changes of a link's inertial, and its fields.
_INERTIAL_FIELDS = {"mass": "mass", "centre": "origin", "inertia": "inertia"}
#: The kinds of changes of a joint, which are its fields.
_JOINT_FIELDS = (
    "type",
    "parent",
    "child",
    "origin",
    "axis",
    "limit",
    "dynamics",
    "mimic",
    "safety_controller",
    "calibration",
)


class Change(msgspec.Struct):
    """One value that has changed; units and frames are the URDF's."""

    kind: str
    """``mass``, ``centre`` or ``inertia``; a field of a link, joint or robot; ``order``; or
    ``link-added``, ``joint-removed`` and the like."""
    name: str
    """The link or joint, by its name before; empty if the whole robot has the value."""
    before: Any = None
    after: Any = None


class RobotChange(msgspec.Struct):
    """The changes that a plugin has made to the robot of the URDF."""

    by: str
    """The pass; or the hook, such as "the hook after 'emit'"."""
    plugin: str
    """The plugin that the pass or hook belongs to."""
    declared: bool
    """Whether the pass says so, by ``writes = ("robot",)``."""
    changes: list[Change]

    def __str__(self) -> str:
        changes = describe_changes(self.changes)
        return f"{self.by} (plugin '{self.plugin}') changed of the robot: {changes}"

    def describe(self) -> str:
        """Return the changes as a verdict names them."""
        return f"what {self.by} changed: {describe_changes(self.changes)}"


def encode(data: Any) -> bytes:
    """Return a copy of data, such as a robot, that later changes do not reach.

    Equal data have equal copies.

    Raises:
        TypeError: The data has values that a URDF cannot have.
        ValueError: As TypeError.
    """

    def to_list(value: Any) -> Any:
        if hasattr(value, "tolist"):  # the numbers and arrays of numpy
            return value.tolist()
        raise TypeError(f"{value!r} ({type(value).__name__})")

    return msgspec.msgpack.encode(data, enc_hook=to_list)


def find_changes(before: bytes, after: bytes) -> list[Change]:
    """Return the changes between two robots that ``encode`` returned, in the file's order."""
    if before == after:
        return []
    robots = (msgspec.msgpack.decode(robot, type=Robot) for robot in (before, after))
    return list(_compare_robots(*robots))


def describe_changes(changes: list[Change]) -> str:
    """Return changes in words: "21 masses, 1 joint origin"."""
    descriptions = []
    for kind, count in Counter(change.kind for change in changes).items():
        noun, _, verb = kind.replace("_", " ").partition("-")
        if count > 1:
            noun = _PLURALS.get(noun, noun.removesuffix("s") + "s")
        descriptions.append(f"{count} {noun} {verb}".rstrip())
    return ", ".join(descriptions)


class _Renamed(msgspec.Struct):
    """The new names of the links and joints that were renamed, by their names before."""

    links: Mapping[str, str]
    joints: Mapping[str, str]


def _compare_robots(before: Robot, after: Robot) -> Iterator[Change]:
    if before.name != after.name:
        yield Change("name", "", before.name, after.name)
    renamed = _Renamed(
        _match_renamed(list(before.links), list(after.links)),
        _match_renamed(list(before.joints), list(after.joints)),
    )
    yield from _compare_names("link", before.links, after.links, renamed.links)
    for old_name, link_before in before.links.items():
        link_after = after.links.get(renamed.links.get(old_name, old_name))
        if link_after is not None:
            yield from _compare_links(link_before, link_after)
    yield from _compare_names("joint", before.joints, after.joints, renamed.joints)
    for old_name, joint_before in before.joints.items():
        joint_after = after.joints.get(renamed.joints.get(old_name, old_name))
        if joint_after is not None:
            yield from _compare_joints(joint_before, joint_after, renamed)
    if _is_reordered(before.links, after.links, renamed.links) or _is_reordered(
        before.joints, after.joints, renamed.joints
    ):
        yield Change("order", "")
    for field_name in ("materials", "extensions"):
        if getattr(before, field_name) != getattr(after, field_name):
            yield Change(field_name, "")


def _is_reordered(
    before: Mapping[str, object], after: Mapping[str, object], renamed: Mapping[str, str]
) -> bool:
    """Return True if the links or joints that are in both robots have another order."""
    kept_names = {
        renamed.get(element_name, element_name): None
        for element_name in before
        if renamed.get(element_name, element_name) in after
    }
    return list(kept_names) != [
        element_name for element_name in after if element_name in kept_names
    ]


def _match_renamed(before: list[str], after: list[str]) -> dict[str, str]:
    """Return the new name of each name that is gone, if a new one is in its place."""
    if len(before) != len(after):
        return {}
    old_names, new_names = set(before), set(after)
    return {
        old_name: new_name
        for old_name, new_name in zip(before, after, strict=True)
        if old_name not in new_names and new_name not in old_names
    }


def _compare_names(
    element_kind: str,
    before: Mapping[str, object],
    after: Mapping[str, object],
    renamed: Mapping[str, str],
) -> Iterator[Change]:
    """Yield the links or joints that were added, removed or renamed."""
    for element_name in before:
        if element_name in renamed:
            yield Change(
                f"{element_kind}-renamed", element_name, element_name, renamed[element_name]
            )
        elif element_name not in after:
            yield Change(f"{element_kind}-removed", element_name)
    old_names = {*before, *renamed.values()}
    for element_name in after:
        if element_name not in old_names:
            yield Change(f"{element_kind}-added", element_name)


def _compare_links(before: Link, after: Link) -> Iterator[Change]:
    for kind, field_name in _INERTIAL_FIELDS.items():
        old_value = getattr(before.inertial, field_name, None)
        new_value = getattr(after.inertial, field_name, None)
        if old_value != new_value:
            yield Change(kind, before.name, old_value, new_value)
    for kind in ("visuals", "collisions"):
        if getattr(before, kind) != getattr(after, kind):
            yield Change(kind, before.name)


def _compare_joints(before: Joint, after: Joint, renamed: _Renamed) -> Iterator[Change]:
    """Yield the changes of a joint, but for the new names of links and joints in it."""
    mimic = before.mimic
    if mimic is not None:
        leader_name = renamed.joints.get(mimic.joint, mimic.joint)
        mimic = msgspec.structs.replace(mimic, joint=leader_name)
    expected = msgspec.structs.replace(
        before,
        parent=renamed.links.get(before.parent, before.parent),
        child=renamed.links.get(before.child, before.child),
        mimic=mimic,
    )
    for field_name in _JOINT_FIELDS:
        old_value, new_value = getattr(expected, field_name), getattr(after, field_name)
        if old_value != new_value:
            yield Change(field_name, before.name, old_value, new_value)
