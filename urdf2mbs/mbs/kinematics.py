"""Forward kinematics of an .mbs at one position, joint by joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs.spatial import HERE, ZERO, Pose, Vec, add, cross, from_turn, multiply, rotate


class Placed(NamedTuple):
    """The place of a joint, in the axes of the base."""

    joint: Joint
    axis: Vec
    """Along or about which it moves, of length 1."""
    origin: Vec
    """A point of its axis (m)."""
    before: int
    """Index of the joint before it, on the way to the base; -1: there is none."""

    @property
    def twist(self) -> tuple[Vec, Vec]:
        """At speed 1: the angular velocity, and the velocity of the point at the base's origin."""
        turns = self.joint.type[0] == "R"
        return (self.axis, cross(self.origin, self.axis)) if turns else (ZERO, self.axis)


class Placement(msgspec.Struct):
    """The places of bodies and joints, in the base (m)."""

    bodies: dict[str | None, Pose]
    """By name; None is the base."""
    joints: list[Placed]
    """In the order of the model."""
    last: dict[str | None, int]
    """Index of each body's last joint; -1 for the base."""

    def point(self, mbs: Mbs, body: str | None, point: str | None) -> Vec:
        """The place of an anchor point (m, in the base); None is the body's own frame."""
        pose = self.bodies[body]
        if point is None:
            return pose.xyz
        return add(pose.xyz, rotate(pose.rot, mbs.points()[body, point].coordinates))

    def way(self, body: str | None) -> list[int]:
        """Indices of the joints that move a body, from the body to the base."""
        indices: list[int] = []
        at = self.last[body]
        while at >= 0:
            indices.append(at)
            at = self.joints[at].before
        return indices


def floating(mbs: Mbs) -> Body | None:
    """The body that floats in the world: three free shifts are between it and the base."""
    for body in mbs.bodies:
        shifts = [j for j in body.joints if j.type[0] == "T" and j.nature == "independent"]
        if body.parent is None and len(shifts) == 3:
            return body
    return None


def place(mbs: Mbs, values: Mapping[str, float] | None = None) -> Placement:
    """A model whose bodies stand parents first, with its joints at these values (rad or m), or at
    their initial ones."""
    points = mbs.points()
    bodies: dict[str | None, Pose] = {None: HERE}
    last: dict[str | None, int] = {None: -1}
    joints: list[Placed] = []
    for body in mbs.bodies:
        xyz, rot = bodies[body.parent]
        point = points.get((body.parent, body.point))
        if point is not None:
            xyz = add(xyz, rotate(rot, point.coordinates))
        before = last[body.parent]
        for joint in body.joints:
            k = int(joint.type[1])
            axis = (rot[k - 1], rot[k + 2], rot[k + 5])
            joints.append(Placed(joint, axis, xyz, before))
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
