"""Forward kinematics of an .mbs at one position, joint by joint.

With X the pose of a body's parent in the base, p the anchor point and J_1, J_2, ... the motions of
its joints, the pose of the body is ``X p J_1(q_1) J_2(q_2) ...``.  J is a rotation about, or a
translation along, the axis x, y or z of the frame after the joints before it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from urdf2mbs.mbs.model import Joint, Mbs
from urdf2mbs.spatial import HERE, Pose, Vec, add, from_turn, multiply, rotate


class PlacedJoint(NamedTuple):
    """A joint with its axis, in the axes of the base."""

    joint: Joint
    axis: Vec
    """Unit vector along or about which it moves."""
    origin: Vec
    """A point on the axis (m)."""
    previous: int
    """Index of the joint before it in the chain from the base; -1 if it is the first."""


class Placement(msgspec.Struct):
    """The poses of bodies and joints, in the base (m)."""

    bodies: dict[str | None, Pose]
    """By name; None is the base."""
    joints: list[PlacedJoint]
    """In the order of the model."""
    last_joints: dict[str | None, int]
    """Index of each body's last joint; -1 for the base."""


def compute_placement(mbs: Mbs, positions: Mapping[str, float] | None = None) -> Placement:
    """Compute the poses of all bodies and joints.

    Args:
        mbs: A model whose bodies come after their parents.
        positions: The position of each joint (rad or m), by name; None for the initial ones.
    """
    points = mbs.points()
    bodies: dict[str | None, Pose] = {None: HERE}
    last_joints: dict[str | None, int] = {None: -1}
    joints: list[PlacedJoint] = []
    for body in mbs.bodies:
        origin, rotation = bodies[body.parent]
        point = points.get((body.parent, body.point))
        if point is not None:
            origin = add(origin, rotate(rotation, point.coordinates))
        previous_index = last_joints[body.parent]
        for joint in body.joints:
            axis_number = int(joint.type[1])
            # Column 1, 2 or 3 of the rotation is the axis x, y or z of the current frame.
            axis = (rotation[axis_number - 1], rotation[axis_number + 2], rotation[axis_number + 5])
            joints.append(PlacedJoint(joint, axis, origin, previous_index))
            previous_index = len(joints) - 1
            q = joint.q if positions is None else positions[joint.name]
            if not q:
                continue
            if joint.type[0] == "R":
                rotation = multiply(rotation, from_turn((axis_number, q)))
            else:
                origin = add(origin, (q * axis[0], q * axis[1], q * axis[2]))
        bodies[body.name] = Pose(origin, rotation)
        last_joints[body.name] = previous_index
    return Placement(bodies, joints, last_joints)
