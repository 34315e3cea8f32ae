"""Forward kinematics of an .mbs at one position, joint by joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from urdf2mbs.mbs.model import Joint, Mbs
from urdf2mbs.spatial import HERE, Pose, Vec, add, from_turn, multiply, rotate


class PlacedJoint(NamedTuple):
    """The place of a joint, in the axes of the base."""

    joint: Joint
    axis: Vec
    """Along or about which it moves, of length 1."""
    origin: Vec
    """A point of its axis (m)."""
    previous: int
    """Index of the joint before it, on the way to the base; -1: there is none."""


class Placement(msgspec.Struct):
    """The places of bodies and joints, in the base (m)."""

    bodies: dict[str | None, Pose]
    """By name; None is the base."""
    joints: list[PlacedJoint]
    """In the order of the model."""
    last_joints: dict[str | None, int]
    """Index of each body's last joint; -1 for the base."""


def compute_placement(mbs: Mbs, values: Mapping[str, float] | None = None) -> Placement:
    """A model whose bodies stand parents first, with its joints at these values (rad or m), or at
    their initial ones."""
    points = mbs.points()
    bodies: dict[str | None, Pose] = {None: HERE}
    last: dict[str | None, int] = {None: -1}
    joints: list[PlacedJoint] = []
    for body in mbs.bodies:
        xyz, rot = bodies[body.parent]
        point = points.get((body.parent, body.point))
        if point is not None:
            xyz = add(xyz, rotate(rot, point.coordinates))
        before = last[body.parent]
        for joint in body.joints:
            k = int(joint.type[1])
            axis = (rot[k - 1], rot[k + 2], rot[k + 5])
            joints.append(PlacedJoint(joint, axis, xyz, before))
            before = len(joints) - 1
            q = joint.q if values is None else values[joint.name]
            if not q:
                continue
            if joint.type[0] == "R":
                rot = multiply(rot, from_turn((k, q)))
            else:
                xyz = add(xyz, (q * axis[0], q * axis[1], q * axis[2]))
        bodies[body.name] = Pose(xyz, rot)
        last[body.name] = before
    return Placement(bodies, joints, last)
