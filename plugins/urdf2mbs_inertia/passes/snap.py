"""Snap: an angle that is nearly a multiple of 45 degrees becomes this multiple, if asked.

Beyond the method, which uses the numbers as they are written.  The robot is another one then, and
the verdict says so.  For each joint a note says how far this moves the tips behind the joint at
most:  the turn between the two origins, times the longest way from the joint to a tip;  twice the
turn between the two axes, times this way, at any angle of the joint.
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
    Vec,
    counted,
    cross,
    dot,
    from_rpy,
    multiply,
    transpose,
    unit,
)
from urdf2mbs.plugin import UrdfJoint as Joint


class Snap(Pass):
    reads = ("robot",)
    writes = ("robot",)

    angle: Annotated[float, msgspec.Meta(gt=0.0, le=0.01)] | None = None
    """rad: an angle that is at most this off a multiple of 45 degrees is this multiple."""

    def run(self, conversion: Conversion) -> None:
        if self.angle is None:
            return
        robot = conversion.robot
        reaches = _reaches(robot)
        moved = {robot.root(): 0.0}
        found: dict[str, dict[str, Any]] = {}
        for joint in robot.depth_first():
            old = msgspec.structs.replace(joint)
            texts = _snap(joint, self.angle)
            moves = _moves(old, joint, reaches[joint.child])
            moved[joint.child] = moved[joint.parent] + moves
            if texts:
                found[joint.name] = {"numbers": texts, "moves": moves}
                conversion.note(
                    "snapped",
                    f"joint '{joint.name}': {', '.join(texts)}; this moves no tip by more than "
                    f"{moves:.2g} m",
                    joint=joint.name,
                )
        if found:
            most = max(moved.values())
            conversion.note(
                "snapped",
                f"the numbers of {counted(len(found), 'joint')} are taken for exact angles; all "
                f"together this moves no tip by more than {most:.2g} m",
            )
            conversion.report["snap"] = {"angle": self.angle, "joints": found, "moves": most}


def _snap(joint: Joint, most: float) -> list[str]:
    """Replace a joint's angles and axis by exact ones; gives what was replaced, in words."""
    texts: list[str] = []
    exact: list[float] = []
    for name, angle in zip(("roll", "pitch", "yaw"), joint.origin.rpy, strict=True):
        near = round(angle / (pi / 4)) * pi / 4
        if not ROUNDING < abs(angle - near) <= most:
            near = angle
        else:
            texts.append(f"{name} {angle!r} is taken for {degrees(near):.0f} degrees")
        exact.append(near)
    if texts:
        roll, pitch, yaw = exact
        joint.origin = msgspec.structs.replace(joint.origin, rpy=(roll, pitch, yaw))
    largest = max(map(abs, joint.axis))  # the reader refuses an axis that is zero
    x, y, z = (round(c / largest) + 0.0 for c in joint.axis)
    if ROUNDING < _angle(joint.axis, (x, y, z)) <= most:
        listed = " ".join(map(repr, joint.axis))
        texts.append(f"axis {listed} is taken for {x:g} {y:g} {z:g}")
        joint.axis = (x, y, z)
    return texts


def _angle(one: Vec, two: Vec) -> float:
    """The angle (rad) between two directions."""
    return atan2(hypot(*cross(unit(one), unit(two))), dot(unit(one), unit(two)))


def _moves(old: Joint, new: Joint, reach: float) -> float:
    """How far (m) a tip in the ``reach`` (m) of a joint's link is moved at most."""
    if old == new:
        return 0.0
    turn = multiply(transpose(from_rpy(old.origin.rpy)), from_rpy(new.origin.rpy))
    # exact for small angles, too: the sine of the turn is in the part that is not symmetric
    sine = hypot(turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]) / 2
    angle = atan2(sine, (turn[0] + turn[4] + turn[8] - 1) / 2)
    if old.axis != new.axis:
        angle += 2 * _angle(old.axis, new.axis)
    return (reach + _slide(old)) * angle


def _reaches(robot: Robot) -> dict[str, float]:
    """For each link, the longest way (m) from its origin to a tip or a centre of mass behind."""
    reaches = {
        name: hypot(*link.inertial.origin.xyz) if link.inertial else 0.0
        for name, link in robot.links.items()
    }
    for joint in reversed(robot.depth_first()):
        way = hypot(*joint.origin.xyz) + _slide(joint) + reaches[joint.child]
        reaches[joint.parent] = max(reaches[joint.parent], way)
    return reaches


def _slide(joint: Joint) -> float:
    """How far (m) a prismatic joint moves its link at most, within its limits."""
    ends = (joint.limit.lower, joint.limit.upper) if joint.limit else ()
    return max((abs(end or 0.0) for end in ends), default=0.0) * (joint.type == "prismatic")
