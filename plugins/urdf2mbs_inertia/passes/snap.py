"""Snap: an angle that is nearly a multiple of 45 degrees becomes this multiple, if asked.

Beyond the method, which uses the numbers as they are written.  This changes the robot, and the
verdict says so.  A note for each joint bounds how far this moves the tips after the joint.
With d the angle between the two origins, e that between the two axes and l the longest distance
from the joint to a tip, a tip moves by at most ``(d + 2 e) l``, at any angle of the joint.
"""

from __future__ import annotations

from math import atan2, degrees, hypot, pi
from typing import Annotated, Any

import msgspec

from urdf2mbs.plugin import (
    ROUNDING,
    Conversion,
    Pass,
    Robot,
    UrdfJoint,
    Vec,
    counted,
    cross,
    dot,
    from_rpy,
    multiply,
    transpose,
    unit,
)


class Snap(Pass):
    """Replace angles that are nearly a multiple of 45 degrees by this multiple, if asked."""

    reads = ("robot",)
    writes = ("robot",)

    angle: Annotated[float, msgspec.Meta(gt=0.0, le=0.01)] | None = None
    """rad: an angle that is at most this off a multiple of 45 degrees is this multiple."""

    def run(self, conversion: Conversion) -> None:
        """Snap each joint, and bound by how much all together move a tip."""
        if self.angle is None:
            return
        robot = conversion.robot
        tip_distances = _compute_tip_distances(robot)
        # Of each link: how far (m) all joints before it move it at most.
        displacements = {robot.root(): 0.0}
        snapped_joints: dict[str, dict[str, Any]] = {}
        for joint in robot.depth_first():
            stated_joint = msgspec.structs.replace(joint)
            changes = _snap_joint(joint, self.angle)
            displacement = _bound_displacement(stated_joint, joint, tip_distances[joint.child])
            displacements[joint.child] = displacements[joint.parent] + displacement
            if changes:
                snapped_joints[joint.name] = {"numbers": changes, "moves": displacement}
                conversion.note(
                    "snapped",
                    f"joint '{joint.name}': {', '.join(changes)}; this moves no tip by more than "
                    f"{displacement:.2g} m",
                    joint=joint.name,
                )
        if snapped_joints:
            largest_displacement = max(displacements.values())
            conversion.note(
                "snapped",
                f"the numbers of {counted(len(snapped_joints), 'joint')} are taken for exact "
                f"angles; all together this moves no tip by more than {largest_displacement:.2g} m",
            )
            snap_report = {
                "angle": self.angle,
                "joints": snapped_joints,
                "moves": largest_displacement,
            }
            conversion.report["snap"] = snap_report


def _snap_joint(joint: UrdfJoint, max_deviation: float) -> list[str]:
    """Replace a joint's angles and axis by exact ones that are near.

    Args:
        joint: The joint, which is changed.
        max_deviation: The largest angle (rad) by which a number is changed.

    Returns:
        Each change, in words.
    """
    changes: list[str] = []
    angles: list[float] = []
    for angle_name, angle in zip(("roll", "pitch", "yaw"), joint.origin.rpy, strict=True):
        exact_angle = round(angle / (pi / 4)) * pi / 4
        if ROUNDING < abs(angle - exact_angle) <= max_deviation:
            changes.append(
                f"{angle_name} {angle!r} is taken for {degrees(exact_angle):.0f} degrees"
            )
            angles.append(exact_angle)
        else:
            angles.append(angle)
    if changes:
        roll, pitch, yaw = angles
        joint.origin = msgspec.structs.replace(joint.origin, rpy=(roll, pitch, yaw))
    largest_component = max(map(abs, joint.axis))  # the reader refuses an axis that is zero
    x, y, z = (round(component / largest_component) + 0.0 for component in joint.axis)
    if ROUNDING < _compute_angle(joint.axis, (x, y, z)) <= max_deviation:
        stated_axis = " ".join(map(repr, joint.axis))
        changes.append(f"axis {stated_axis} is taken for {x:g} {y:g} {z:g}")
        joint.axis = (x, y, z)
    return changes


def _compute_angle(first_direction: Vec, second_direction: Vec) -> float:
    """Compute the angle (rad) between two directions."""
    first, second = unit(first_direction), unit(second_direction)
    return atan2(hypot(*cross(first, second)), dot(first, second))


def _bound_displacement(
    stated_joint: UrdfJoint, snapped_joint: UrdfJoint, tip_distance: float
) -> float:
    """Bound how far (m) a changed joint moves the tips after it.

    Args:
        stated_joint: The joint as it was.
        snapped_joint: The joint as it is.
        tip_distance: The longest distance (m) from the joint's link to a tip.
    """
    if stated_joint == snapped_joint:
        return 0.0
    rotation = multiply(
        transpose(from_rpy(stated_joint.origin.rpy)), from_rpy(snapped_joint.origin.rpy)
    )
    # Exact for small angles, too: the sine of the angle is in the part that is not symmetric.
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = rotation
    sine = hypot(r32 - r23, r13 - r31, r21 - r12) / 2
    angle = atan2(sine, (r11 + r22 + r33 - 1) / 2)
    if stated_joint.axis != snapped_joint.axis:
        angle += 2 * _compute_angle(stated_joint.axis, snapped_joint.axis)
    return (tip_distance + _get_stroke(stated_joint)) * angle


def _compute_tip_distances(robot: Robot) -> dict[str, float]:
    """Compute the longest distance (m) from each link to a tip or a centre of mass after it.

    Planar and floating joints, and prismatic ones without limits, are at their initial position.
    """
    distances = {
        link_name: hypot(*link.inertial.origin.xyz) if link.inertial else 0.0
        for link_name, link in robot.links.items()
    }
    for joint in reversed(robot.depth_first()):
        distance = hypot(*joint.origin.xyz) + _get_stroke(joint) + distances[joint.child]
        distances[joint.parent] = max(distances[joint.parent], distance)
    return distances


def _get_stroke(joint: UrdfJoint) -> float:
    """Return how far (m) a prismatic joint moves its link at most, within its limits."""
    if joint.type != "prismatic" or not joint.limit:
        return 0.0
    return max(abs(joint.limit.lower or 0.0), abs(joint.limit.upper or 0.0))
