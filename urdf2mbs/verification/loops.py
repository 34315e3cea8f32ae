"""A closed loop that is cut at another joint.

A loop of rotations about parallel axes moves in a plane, wherever it is cut: a ball there takes
away the two motions in the plane, as a rotation does.  So the first robot is cut where the second
one may be: the joint of the new cut is taken away, the old cut becomes a joint, and the joints
between them carry the other way round::

    ground --A-- a --B-- b          ground --A-- a        b
                         : cut C     ->                :cut B :
    ground --D-- c ......:           ground --D-- c --C-- b
"""

from __future__ import annotations

from collections.abc import Iterator
from math import dist, hypot
from typing import NamedTuple

import msgspec

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.proof.mbs_as_robot import convert_to_robot
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.spatial import ZERO, Pose, Vec, compose, cross, inverse, rotate, transpose, unit
from urdf2mbs.urdf.model import Joint, Robot
from urdf2mbs.verification.restate import convert_to_origin, move_in_frame

#: The sine of the angle between the axes of a loop in a plane is less.
PARALLEL = 1e-6


class Closure(NamedTuple):
    """What closes a loop: a cut of an .mbs, or a joint in ``<gazebo>``."""

    name: str
    links: tuple[str, str]
    ends: tuple[Vec, Vec]
    """Where each link has its end, all joints at zero, in the frame of the root link (m)."""
    kind: str = "ball"
    """``ball``, ``rod`` or ``solid``."""
    length: float = 0.0
    """Of a rod (m)."""


class Recut(NamedTuple):
    """A robot whose loop is cut at another joint."""

    robot: Robot
    closures: list[Closure]
    """What closes its loops now."""
    old: Closure
    """The cut that is a joint now."""
    joint: Joint
    """The joint that is a cut now."""


def list_closures(robot: Robot, mbs: Mbs | None) -> list[Closure]:
    """List what closes the loops of a robot.

    Args:
        robot: The robot.
        mbs: The model that it was converted from; None for a URDF.
    """
    poses = robot.poses()
    closures = []
    for extension in robot.extensions:
        for joint in extension.joints:
            if joint.parent in poses and joint.child in poses:
                place = compose(poses[joint.child], joint.pose).xyz
                closures.append(Closure(joint.name, (joint.parent, joint.child), (place, place)))
    points = {} if mbs is None else mbs.points()
    for cut in () if mbs is None else mbs.cuts:
        ends = (cut.endpoint1, cut.endpoint2)
        links = (ends[0][0] or robot.root(), ends[1][0] or robot.root())
        if cut.is_draft or not poses.keys() >= {*links}:
            continue
        first, second = (
            compose(poses[link], Pose(points[end].coordinates if end[1] else ZERO)).xyz
            for link, end in zip(links, ends, strict=True)
        )
        closures.append(Closure(cut.name, links, (first, second), cut.kind, cut.length or 0.0))
    return closures


class ClosureComparison(NamedTuple):
    """How the loops of two robots are closed."""

    same: list[str]
    """The cuts of the second robot that the first one has, too."""
    differences: list[Difference]


def compare_closures(closures: list[Closure], mbs: Mbs, tolerance: float) -> ClosureComparison:
    """Compare where loops are closed with the cuts of a model, whose joints are the same.

    Args:
        closures: What closes the loops of the first robot.
        mbs: The second one.
        tolerance: The largest relative deviation that is no difference.
    """
    robot = convert_to_robot(mbs, "")
    cuts = {closure.name: closure for closure in list_closures(robot, mbs)}
    comparison = ClosureComparison([], [])
    for closure in closures:
        scale = max((abs(c) for end in closure.ends for c in end), default=0.0) or 1.0
        distances = {
            name: _compute_distance(closure, cut)
            for name, cut in cuts.items()
            if cut.kind == closure.kind
        }
        name = min(distances, key=distances.__getitem__, default="")
        if name and distances[name] <= tolerance * scale:
            del cuts[name]
            comparison.same.append(name)
            continue
        message = f"the loop that '{closure.name}' closes in the first robot has no "
        message += f"{closure.kind} there in the .mbs"
        if name:
            message += f"; the nearest one, '{name}', is {distances[name]:.3g} m off"
        comparison.differences.append(Difference("cut", message))
    return comparison


def _compute_distance(a: Closure, b: Closure) -> float:
    """Compute by how much the ends, or the lengths, of two closures differ (m)."""
    first, second = b.ends
    return max(
        abs(a.length - b.length),
        min(
            max(dist(first, a.ends[0]), dist(second, a.ends[1])),
            max(dist(second, a.ends[0]), dist(first, a.ends[1])),
        ),
    )


def recut(robot: Robot, closures: list[Closure]) -> Iterator[Recut]:
    """Yield a robot with one of its loops cut at another joint.

    Only loops of rotations about parallel axes are cut elsewhere.
    """
    joint_of_child = {joint.child: joint for joint in robot.joints.values()}
    poses = robot.poses()
    for closure in [each for each in closures if each.kind == "ball"]:
        paths = [_list_path(joint_of_child, link) for link in closure.links]
        shared = {joint.name for joint in paths[0]} & {joint.name for joint in paths[1]}
        loops = [[joint for joint in path if joint.name not in shared] for path in paths]
        moving = [joint for path in loops for joint in path if joint.moves]
        if not moving or not all(j.type in ("revolute", "continuous") for j in moving):
            continue
        axes = [rotate(poses[joint.child].rot, unit(joint.axis)) for joint in moving]
        if any(hypot(*cross(axes[0], axis)) > PARALLEL for axis in axes):
            continue
        kept_closures = [each for each in closures if each is not closure]
        for path, end in ((loops[0], 0), (loops[1], 1)):
            for number, joint in enumerate(path):
                if joint.moves:
                    chain = _Chain(closure, end, path[:number], joint)
                    place = poses[joint.child].xyz
                    cut = Closure(joint.name, (joint.parent, joint.child), (place, place))
                    x, y, z = axes[0]
                    for axis in ((x, y, z), (-x, -y, -z)):  # which of them, a ball does not say
                        yield Recut(_cut(robot, chain, axis), [*kept_closures, cut], closure, joint)


def _list_path(joint_of_child: dict[str, Joint], link: str) -> list[Joint]:
    """List the joints from a link to the root."""
    path = []
    while link in joint_of_child:
        path.append(joint_of_child[link])
        link = path[-1].parent
    return path


class _Chain(NamedTuple):
    """The part of a robot that is attached at the old cut when the loop is cut elsewhere."""

    closure: Closure
    end: int
    """Which end of the old cut the part has: 0 or 1."""
    reversed_joints: list[Joint]
    """The joints from the old cut to the new one, which carry the other way round."""
    joint: Joint
    """The joint that is taken away."""


def _cut(robot: Robot, chain: _Chain, axis: Vec) -> Robot:
    """Return a robot with a joint in place of a cut, and without another joint.

    Args:
        robot: The robot.
        chain: The part that is attached at the old cut now.
        axis: The axis of the loop, in the frame of the root link.
    """
    poses = robot.poses()
    closure = chain.closure
    link, carrier = closure.links[chain.end], closure.links[1 - chain.end]
    joints = {name: each for name, each in robot.joints.items() if name != chain.joint.name}
    #: The new frames of links, in that of the root link.
    frames = {link: Pose(closure.ends[chain.end], poses[link].rot)}
    for each in chain.reversed_joints:
        frames[each.parent] = poses[each.child]
        x, y, z = each.axis
        joints[each.name] = msgspec.structs.replace(
            each, parent=each.child, child=each.parent, axis=(-x, -y, -z)
        )
    local_axis = rotate(transpose(frames[link].rot), axis)
    joints[closure.name] = Joint(closure.name, "continuous", carrier, link, axis=local_axis)
    new_poses = {**poses, **frames}
    for name, each in joints.items():
        origin = compose(inverse(new_poses[each.parent]), new_poses[each.child])
        joints[name] = msgspec.structs.replace(each, origin=convert_to_origin(origin))
    links = dict(robot.links)
    for name, frame in frames.items():
        links[name] = move_in_frame(links[name], compose(inverse(frame), poses[name]))
    return msgspec.structs.replace(robot, links=links, joints=joints)
