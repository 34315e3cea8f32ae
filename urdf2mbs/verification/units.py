"""Other units: millimetres for metres, degrees for radians.

A robot that is stated in other units differs at nearly every joint, which hides what else differs.
So the first robot is stated in the units that the second one may have, and compared again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import degrees, log10, radians
from typing import NamedTuple

import msgspec

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.proof.mbs_side import build_mbs_side
from urdf2mbs.proof.rigid import transform_point
from urdf2mbs.spatial import Vec, add
from urdf2mbs.urdf.model import Inertial, Origin, Robot

#: The lengths that people write for 1 m, and their names.
LENGTHS = {1000.0: "millimetres for metres", 100.0: "centimetres for metres"}
#: The decimal logarithms of the extents of two robots that may be the same deviate by less.
SAME_DECADE = 0.4
#: A unit is taken if less than this share of the differing joints is left, and two fewer.
CLEARLY_FEWER = 0.6


class Restatement(NamedTuple):
    """A robot in the units that another one may have."""

    robot: Robot
    message: str
    """What is different of the other robot, which the messages call the .mbs."""


def is_explained(before: int, after: int) -> bool:
    """Return whether other units explain why joints differ.

    Args:
        before: How many joints differ.
        after: How many do if the first robot is stated in these units.
    """
    return after < CLEARLY_FEWER * before and after <= before - 2


# --- lengths ---


def restate_lengths(robot: Robot, mbs: Mbs) -> Iterator[Restatement]:
    """Yield a robot in the lengths of a model, whose extent is larger or smaller by far.

    Args:
        robot: The first robot.
        mbs: The second one.
    """
    own, other = _measure_robot(robot), _measure_model(mbs)
    if not own > 0.0 or not other > 0.0:
        return
    for number, words in LENGTHS.items():
        for factor, meaning in ((number, words), (1.0 / number, _exchange(words))):
            if abs(log10(other / own / factor)) > SAME_DECADE:
                continue
            message = f"all lengths are {factor:g} times those in the URDF: {meaning}?"
            square = factor * factor
            yield Restatement(_scale(robot, factor, square), f"{message} (inertia, too)")
            yield Restatement(_scale(robot, factor, 1.0), message)


def _exchange(words: str) -> str:
    """Return ``metres for millimetres`` of ``millimetres for metres``."""
    first, _, second = words.partition(" for ")
    return f"{second} for {first}"


def _measure_robot(robot: Robot) -> float:
    """Return the largest distance (m) of a link, or its centre of mass, from the root."""
    poses = robot.poses()
    points = [pose.xyz for pose in poses.values()]
    points += [
        add(poses[name].xyz, link.inertial.origin.xyz)
        for name, link in robot.links.items()
        if link.inertial is not None
    ]
    return max((max(map(abs, point)) for point in points), default=0.0)


def _measure_model(mbs: Mbs) -> float:
    """Return the largest distance (m) of a body, or its centre of mass, from the ground."""
    joints = mbs.joints().values()
    side = build_mbs_side(mbs, {joint.name for joint in joints if joint.nature != "driven"})
    poses = side.compute_zero_poses()
    points: list[Vec] = [pose[9:] for pose in poses]
    points += [
        transform_point(pose, inertia.centre)
        for group, pose in zip(side.groups, poses, strict=True)
        for inertia in group.inertias.values()
    ]
    return max((max(map(abs, point)) for point in points), default=0.0)


def _scale(robot: Robot, length: float, inertia: float) -> Robot:
    """Return a robot with all its lengths, and all its inertias, multiplied."""

    def scale(origin: Origin) -> Origin:
        x, y, z = origin.xyz
        return Origin((length * x, length * y, length * z), origin.rpy)

    def scale_inertial(inertial: Inertial) -> Inertial:
        xx, xy, xz, yy, yz, zz = (inertia * c for c in inertial.inertia)
        return Inertial(inertial.mass, (xx, xy, xz, yy, yz, zz), scale(inertial.origin))

    return _change(robot, scale, scale_inertial)


# --- angles ---


def restate_angles(robot: Robot) -> Iterator[Restatement]:
    """Yield a robot whose angles are taken for degrees, or were."""
    origins = [joint.origin for joint in robot.joints.values()]
    if not any(any(origin.rpy) for origin in origins):
        return
    for convert, message in (
        (degrees, "the angles are in degrees; expected radians"),
        (radians, "the angles are as expected, if those in the URDF are in degrees"),
    ):
        for everywhere in (True, False):
            yield Restatement(_turn(robot, convert, everywhere=everywhere), message)


def _turn(robot: Robot, convert: Callable[[float], float], *, everywhere: bool) -> Robot:
    """Return a robot with all its angles converted; those of inertias only if it is everywhere."""

    def turn(origin: Origin) -> Origin:
        roll, pitch, yaw = map(convert, origin.rpy)
        return Origin(origin.xyz, (roll, pitch, yaw))

    def turn_inertial(inertial: Inertial) -> Inertial:
        return Inertial(inertial.mass, inertial.inertia, turn(inertial.origin))

    return _change(robot, turn, turn_inertial if everywhere else lambda inertial: inertial)


def _change(
    robot: Robot,
    change_origin: Callable[[Origin], Origin],
    change_inertial: Callable[[Inertial], Inertial],
) -> Robot:
    """Return a robot with other origins of its joints, and other inertias of its links."""
    links = {
        name: msgspec.structs.replace(
            link, inertial=None if link.inertial is None else change_inertial(link.inertial)
        )
        for name, link in robot.links.items()
    }
    joints = {
        name: msgspec.structs.replace(joint, origin=change_origin(joint.origin))
        for name, joint in robot.joints.items()
    }
    return msgspec.structs.replace(robot, links=links, joints=joints)
