"""The differences of two robots by their causes, what matters most for the motion first.

A wrong mass makes the centre and the inertia of its link wrong, a left leg has the fault of the
right one, and a joint that is left out takes all that it carries with it: each is one finding.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isclose
from typing import Any

import msgspec

from urdf2mbs.messages.diagnostics import some
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.urdf.model import Robot

#: What makes the whole robot another one.
OF_ROBOT = ("units", "root", "gravity", "base")
#: Differences of the mechanism: the robot can move in other ways.
OF_MECHANISM = ("joint-missing", "joint-extra", "type", "parent", "nature", "symbols", "cut")
#: What places a link elsewhere, or moves it otherwise.
OF_MOTION = ("frame", "zero", "axis")
#: What makes a link weigh otherwise, in the order of causes.
OF_INERTIA = ("mass", "centre", "inertia")
#: Values that deviate by less than this share are the same, on the left and on the right.
ALIKE = 1e-3
#: Inertias that differ by less, relatively, may be the same, written with fewer digits.
ROUNDED = 1e-4


class Finding(msgspec.Struct, omit_defaults=True):
    """Differences that have one cause."""

    message: str
    kind: str
    """The kind of the first difference."""
    effect: float
    """About how much it changes the motion, 0 to 1; above 1, what makes it another mechanism."""
    differences: list[int] = []
    """Their numbers in the list of all differences, from 0."""


class _Group(msgspec.Struct):
    """Differences that are told together."""

    differences: list[Difference]
    more: list[str] = []
    """The links or joints beside that of the first difference that have the same fault."""
    alike: list[Difference] = []
    """Their differences."""

    @property
    def first(self) -> Difference:
        return self.differences[0]


def find_causes(
    differences: Sequence[Difference], robot: Robot
) -> tuple[list[Difference], list[Finding]]:
    """Group differences by their causes.

    Args:
        differences: The differences.
        robot: The robot that they are of.

    Returns:
        The differences, the leading one of each cause first, and the causes in this order.
    """
    if not differences:
        return [], []
    weights = _Weights(robot)
    groups = _group_by_link(differences)
    groups = _fold_into_missing_joints(groups, robot)
    groups = _merge_alike(_merge_rounded(groups))
    groups.sort(key=lambda group: -weights.rate(group))
    order = [group.first for group in groups]
    order += [each for group in groups for each in group.differences[1:] + group.alike]
    places = {id(difference): place for place, difference in enumerate(order)}
    findings = [
        Finding(
            _word(group),
            group.first.kind,
            weights.rate(group),
            [places[id(each)] for each in group.differences + group.alike],
        )
        for group in groups
    ]
    return order, findings


def _group_by_link(differences: Sequence[Difference]) -> list[_Group]:
    """Group the differences of the inertia of a link, and of the numbers of a joint."""
    groups: dict[Any, _Group] = {}
    for number, difference in enumerate(differences):
        key: Any = number
        if difference.body is not None or difference.kind == "joint-extra":
            key = ("body", difference.body or difference.link)
        elif difference.kind in OF_INERTIA:
            key = ("inertia", difference.link)
        elif difference.kind == "parameter" and difference.joint:
            key = ("parameter", difference.joint)
        group = groups.setdefault(key, _Group([]))
        group.differences.append(difference)
    for group in groups.values():
        group.differences.sort(key=lambda each: each.kind != "joint-extra")
        if group.first.kind in OF_INERTIA:
            group.differences.sort(key=lambda each: OF_INERTIA.index(each.kind))
    return [*groups.values()]


def _fold_into_missing_joints(groups: list[_Group], robot: Robot) -> list[_Group]:
    """Let a joint that the .mbs lacks explain the missing links of its subtree."""
    missing = {group.first.link: group for group in groups if group.first.kind == "joint-missing"}
    parents = {joint.child: joint.parent for joint in robot.joints.values()}
    kept = []
    for group in groups:
        owner = None
        if group.first.kind in ("joint-missing", *OF_INERTIA):
            carrier = group.first.link
            is_lost = group.first.mbs in (None, 0.0)
            while carrier is not None and is_lost:
                if carrier in missing and missing[carrier] is not group:
                    owner = missing[carrier]  # the first joint of the branch explains all
                carrier = parents.get(carrier)
        if owner is None:
            kept.append(group)
        else:
            owner.differences += group.differences
    return kept


def _merge_rounded(groups: list[_Group]) -> list[_Group]:
    """Merge the inertias that differ by no more than numbers written with few digits do."""
    rounded = [
        group
        for group in groups
        if group.first.kind in OF_INERTIA and max(each.size for each in group.differences) < ROUNDED
    ]
    if len(rounded) < 2:
        return groups
    rounded.sort(key=lambda group: -max(each.size for each in group.differences))
    first, *others = rounded
    for group in others:
        first.alike += group.differences
        first.more.append(_name(group.first))
    return [group for group in groups if not any(group is each for each in others)]


def _merge_alike(groups: list[_Group]) -> list[_Group]:
    """Merge groups with the same fault, as of left and right."""
    merged: list[_Group] = []
    for group in groups:
        twin = next((each for each in merged if _are_alike(each, group)), None)
        if twin is None:
            merged.append(group)
            continue
        twin.alike += [*group.differences, *group.alike]
        twin.more = [*twin.more, _name(group.first), *group.more]
    return merged


def _are_alike(a: _Group, b: _Group) -> bool:
    """Return True for the same fault of two links or joints."""
    kinds_a, kinds_b = ([each.kind for each in group.differences] for group in (a, b))
    if a.first.kind != b.first.kind or _name(a.first) == _name(b.first):
        return False
    if a.first.kind in ("joint-missing", "joint-extra"):
        return True
    if kinds_a != kinds_b:
        return False
    return all(
        _have_same_words(p, q) or _have_same_numbers(p, q)
        for p, q in zip(a.differences, b.differences, strict=True)
    )


def _name(difference: Difference) -> str:
    """Return the name of the link or joint that has a difference, as a message shows it."""
    if difference.kind in (*OF_INERTIA, *OF_MOTION) and difference.link:
        return f"'{difference.link}'"
    return f"'{difference.joint or difference.link or ''}'"


def _have_same_words(a: Difference, b: Difference) -> bool:
    """Return True if two messages are the same but for the names."""
    first, second = (re.sub(r"'[^']*'", "''", each.message) for each in (a, b))
    return first == second


def _have_same_numbers(a: Difference, b: Difference) -> bool:
    """Return True if the values of two differences are the same, or mirrored."""
    if a.urdf is None or b.urdf is None:
        return False
    return all(_are_mirrored(p, q) for p, q in ((a.urdf, b.urdf), (a.mbs, b.mbs)))


def _are_mirrored(a: Any, b: Any) -> bool:
    """Return True for numbers, or tuples, that are equal but for signs and order."""
    first, second = (
        sorted(abs(c) for c in (value if isinstance(value, tuple) else (value,)))
        if isinstance(value, float | int | tuple)
        else None
        for value in (a, b)
    )
    if first is None or second is None or len(first) != len(second):
        return bool(a == b)
    scale = max((*first, *second), default=0.0)
    return all(
        isclose(p, q, rel_tol=ALIKE, abs_tol=ALIKE * scale)
        for p, q in zip(first, second, strict=True)
    )


class _Weights:
    """How much of a robot's mass each link has, and carries."""

    def __init__(self, robot: Robot) -> None:
        self.own = {
            name: 0.0 if link.inertial is None else link.inertial.mass
            for name, link in robot.links.items()
        }
        self.carried = dict(self.own)
        for joint in reversed(robot.depth_first()):
            self.carried[joint.parent] += self.carried[joint.child]
        self.total = max(sum(self.own.values()), 1e-9)

    def rate(self, group: _Group) -> float:
        """Rate how much the differences of a group change the motion."""
        kind = group.first.kind
        if kind in OF_ROBOT:
            return 3.0
        if kind in OF_MECHANISM:
            return 2.0
        rated = kind in OF_INERTIA or kind in OF_MOTION
        return max(map(self._rate, group.differences)) if rated else 0.0

    def _rate(self, difference: Difference) -> float:
        """Rate a difference: its size, by the share of the mass that it concerns."""
        link = difference.link or ""
        own, carried = self.own.get(link, 0.0), self.carried.get(link, 0.0)
        if difference.kind == "mass":
            masses = float(difference.mbs or 0.0), float(difference.urdf or 0.0)
            return abs(masses[0] - masses[1]) / self.total
        if difference.kind in OF_INERTIA:
            return difference.size * own / self.total
        # what carries no mass still carries a tool or a camera
        return difference.size * max(carried / self.total, 1e-3)


# --- words ---


def _word(group: _Group) -> str:
    """Return the message of a finding."""
    first = group.first
    message = first.message
    followers = [each for each in group.differences[1:] if each.kind != first.kind]
    if first.kind in OF_INERTIA and followers:
        message += f"; its {' and '.join(each.kind for each in followers)} "
        message += "differ, too" if len(followers) > 1 else "differs, too"
    elif first.kind == "parameter" and len(group.differences) > 1:
        others = [each.message.partition(": ")[2] for each in group.differences[1:]]
        message += f"; {some(others, 3)}"
    elif first.kind == "joint-extra" and followers:
        message += f", and has {followers[0].mbs:.9g} kg"
    elif first.kind == "joint-missing" and len(group.differences) > 1:
        lost = {each.link for each in group.differences[1:]} - {first.link, None}
        if lost:
            message += f", nor is what it carries: {some(sorted(map(repr, lost)), 4)}"
    if group.more:
        message += f" (and so {some(group.more, 4)})"
    return message
