"""Joints that follow others by ``<mimic>``: the rule of each, and limits that leave no motion."""

from __future__ import annotations

from collections.abc import Collection
from math import inf

import msgspec

from urdf2mbs.urdf.model import JOINT_TYPES, Joint, Robot

#: A common range that is this narrow, relative to the narrower of two ranges, is a single point:
#: limits are often degrees that were rounded to a few digits.
SINGLE_POINT = 1e-4


def follow(robot: Robot, name: str, free: Collection[str] = ()) -> tuple[str, float, float]:
    """Return the joint that leads a joint at the end of a chain of ``<mimic>``, and the rule.

    Args:
        robot: The robot; its ``<mimic>`` form no loop.
        name: The joint that follows.
        free: Joints that are treated as if they followed none.

    Returns:
        The name of the leader, the multiplier, and the offset (rad or m).
    """
    mimic = robot.joints[name].mimic
    multiplier, offset = 1.0, 0.0
    # the reader has freed joints that follow themselves
    while mimic is not None:
        offset += multiplier * mimic.offset
        multiplier *= mimic.multiplier
        name = mimic.joint
        mimic = None if name in free else robot.joints[name].mimic
    return name, multiplier, offset


class Bound(msgspec.Struct, frozen=True):
    """The range of a leader that the limits of a joint allow."""

    joint: Joint
    """The leader, or a joint that follows it."""
    limits: tuple[float, float]
    """The joint's own limits (rad or m)."""
    low: float
    """The lowest position of the leader (rad or m)."""
    high: float
    """The highest position of the leader (rad or m)."""


class LockedJoints(msgspec.Struct, frozen=True):
    """A leader and its followers, whose limits leave no motion, or no position, to them."""

    leader: Joint
    lowest: Bound
    """The bound that keeps the leader from going lower."""
    highest: Bound
    """The bound that keeps the leader from going higher."""

    @property
    def follower(self) -> Joint:
        """The joint whose limits or rule are the likely mistake."""
        highest, lowest = self.highest.joint, self.lowest.joint
        return lowest if highest is self.leader else highest

    def describe(self, robot: Robot) -> str:
        """Return the limits of the two joints and their common range, for a message."""
        leader_name, follower_name = self.leader.name, self.follower.name
        if self.lowest is self.highest:
            limits_text = _write_range(self.lowest.limits)
            rule = _write_rule(robot, follower_name)
            return (
                f"joint '{follower_name}' = {rule} is outside of its limits {limits_text} "
                f"at any '{leader_name}'"
            )
        bounds = (self.lowest, self.highest)
        partner_name = next(
            bound.joint.name for bound in bounds if bound.joint is not self.follower
        )
        gap = self.lowest.low - self.highest.high
        is_single = gap <= _compute_tolerance(self.lowest, self.highest)
        allowed_positions = f"only {self.lowest.low:.6g}" if is_single else "no position"
        bound_texts = "; ".join(self._describe_bound(bound, robot) for bound in bounds)
        return (
            f"joint '{follower_name}': its limits and those of '{partner_name}' leave "
            f"'{leader_name}' {allowed_positions}: {bound_texts}"
        )

    def _describe_bound(self, bound: Bound, robot: Robot) -> str:
        joint_name, limits_text = bound.joint.name, _write_range(bound.limits)
        if bound.joint is self.leader:
            return f"'{joint_name}' has the limits {limits_text}"
        allowed_range = _write_range((bound.low, bound.high))
        rule = _write_rule(robot, joint_name)
        leader_range = f"'{self.leader.name}' {allowed_range}"
        return f"'{joint_name}' = {rule} has the limits {limits_text}, and so {leader_range}"


def _write_rule(robot: Robot, joint_name: str) -> str:
    leader_name, multiplier, offset = follow(robot, joint_name)
    offset_sign = "-" if offset < 0.0 else "+"
    return f"{multiplier:.6g} * {leader_name}" + (
        f" {offset_sign} {abs(offset):.6g}" if offset else ""
    )


def _write_range(limits: tuple[float, float]) -> str:
    return f"[{limits[0]:.6g}, {limits[1]:.6g}]"


def find_locked_joints(robot: Robot) -> list[LockedJoints]:
    """Return the leaders whose limits, and those of their followers, leave at most one position.

    A follower q = multiplier * leader + offset within its limits holds the leader in a range, too.
    Followers of followers are taken as followers of the first leader.  Continuous joints have no
    limits.  A joint whose own limits leave no motion is not locked by ``<mimic>``.
    """
    bounds_by_leader: dict[str, list[Bound]] = {}
    for joint in robot.joints.values():
        if joint.mimic is None or JOINT_TYPES[joint.type] != 1:
            continue
        leader_name, multiplier, offset = follow(robot, joint.name)
        leader = robot.joints[leader_name]
        if JOINT_TYPES[leader.type] != 1:
            continue
        if leader_name not in bounds_by_leader:
            leader_limits = _get_limits(leader)
            bounds_by_leader[leader_name] = [Bound(leader, leader_limits, *leader_limits)]
        bounds_by_leader[leader_name].append(_compute_bound(joint, multiplier, offset))
    locked_joints = []
    for leader_name, leader_bounds in bounds_by_leader.items():
        lowest = max(leader_bounds, key=lambda bound: bound.low)
        highest = min(leader_bounds, key=lambda bound: bound.high)
        if highest.high - lowest.low <= _compute_tolerance(lowest, highest):
            locked_joints.append(LockedJoints(robot.joints[leader_name], lowest, highest))
    return locked_joints


def _get_limits(joint: Joint) -> tuple[float, float]:
    """Return the limits of a joint; infinite where it has none that leave a motion."""
    if joint.limit is None or joint.type == "continuous":
        return -inf, inf
    lower_limit = -inf if joint.limit.lower is None else joint.limit.lower
    upper_limit = inf if joint.limit.upper is None else joint.limit.upper
    return (lower_limit, upper_limit) if lower_limit < upper_limit else (-inf, inf)


def _compute_bound(joint: Joint, multiplier: float, offset: float) -> Bound:
    """Return the range of the leader for which a follower is within its limits."""
    limits = lower_limit, upper_limit = _get_limits(joint)
    if multiplier == 0.0:  # the follower is at its offset for any position of its leader
        return Bound(
            joint, limits, *((-inf, inf) if lower_limit <= offset <= upper_limit else (inf, -inf))
        )
    leader_range = sorted(
        (follower_limit - offset) / multiplier + 0.0
        for follower_limit in (lower_limit, upper_limit)
    )
    return Bound(joint, limits, leader_range[0], leader_range[1])


def _compute_tolerance(lowest: Bound, highest: Bound) -> float:
    """Return the width (rad or m) up to which the common range of two bounds is a single point."""
    narrower_range = min(lowest.high - lowest.low, highest.high - highest.low)
    return SINGLE_POINT * narrower_range if 0.0 < narrower_range < inf else 0.0
