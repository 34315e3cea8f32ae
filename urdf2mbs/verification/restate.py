"""A robot that is stated otherwise: in other units, or with its base turned.

Then it differs at many joints, which hides what else differs.  So the first robot is stated as the
second one may be, and compared again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import atan2, degrees, hypot, log10, radians
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.proof.causes import describe_displacement
from urdf2mbs.proof.mbs_as_robot import convert_to_robot
from urdf2mbs.spatial import HERE, Pose, Rot, Vec, compose
from urdf2mbs.urdf.model import Inertial, Link, Origin, Robot

#: The lengths that people write for 1 m, and their names.
LENGTHS = {1000.0: "millimetres for metres", 100.0: "centimetres for metres"}
#: The decimal logarithms of the extents of two robots that may be the same deviate by less.
SAME_DECADE = 0.5
#: A shift (m), or an element of a rotation, that may be rounding of a pose.
SMALL = 1e-3
#: A cosine of the pitch below which roll and yaw are about the same axis.
GIMBAL_LOCK = 1e-12
#: A restatement is taken if at least this number of joints differ no more.  Numbers of many digits
#: do not agree by chance.
CLEARLY_FEWER = 2


class Restatement(NamedTuple):
    """A robot as another one may state it."""

    robot: Robot
    kind: str
    """The kind of the difference that it explains: ``units`` or ``root``."""
    message: str
    """The difference of the second robot, which the messages call the .mbs."""


def is_explained(before: int, after: int) -> bool:
    """Return whether a restatement explains why joints differ.

    Args:
        before: How many joints differ.
        after: How many do if the first robot is restated.
    """
    return after <= before - CLEARLY_FEWER


# --- lengths ---


def restate_lengths(robot: Robot, mbs: Mbs) -> Iterator[Restatement]:
    """Yield a robot in the lengths of a model, whose extent is larger or smaller by far.

    Args:
        robot: The first robot.
        mbs: The second one.
    """
    extent, mbs_extent = _measure(robot), _measure(convert_to_robot(mbs, ""))
    if not extent > 0.0 or not mbs_extent > 0.0:
        return
    for number, words in LENGTHS.items():
        for factor, meaning in ((number, words), (1.0 / number, _exchange(words))):
            if abs(log10(mbs_extent / extent / factor)) > SAME_DECADE:
                continue
            message = f"all lengths are {factor:g} times those in the URDF: {meaning}?"
            square = factor * factor
            with_inertia = f"{message} (inertia, too)"
            yield Restatement(_scale(robot, factor, square), "units", with_inertia)
            yield Restatement(_scale(robot, factor, 1.0), "units", message)


def _exchange(words: str) -> str:
    """Return ``metres for millimetres`` of ``millimetres for metres``."""
    first, _, second = words.partition(" for ")
    return f"{second} for {first}"


def _measure(robot: Robot) -> float:
    """Return the largest coordinate (m) of a link, or of its centre of mass, from the root."""
    poses = robot.poses()
    points = [pose.xyz for pose in poses.values()]
    points += [
        compose(poses[name], Pose(link.inertial.origin.xyz)).xyz
        for name, link in robot.links.items()
        if link.inertial is not None
    ]
    return max(max(map(abs, point)) for point in points)


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
            turned = _convert_angles(robot, convert, everywhere=everywhere)
            yield Restatement(turned, "units", message)


def _convert_angles(robot: Robot, convert: Callable[[float], float], *, everywhere: bool) -> Robot:
    """Return a robot with all its angles converted; those of inertias only if it is everywhere."""

    def turn(origin: Origin) -> Origin:
        roll, pitch, yaw = map(convert, origin.rpy)
        return Origin(origin.xyz, (roll, pitch, yaw))

    def turn_inertial(inertial: Inertial) -> Inertial:
        return Inertial(inertial.mass, inertial.inertia, turn(inertial.origin))

    return _change(robot, turn, turn_inertial if everywhere else lambda inertial: inertial)


# --- the base ---


def restate_root(
    robot: Robot, base: str, poses: Iterable[NDArray[np.float64]]
) -> Iterator[Restatement]:
    """Yield a robot whose base is turned.

    Args:
        robot: The first robot.
        base: The link that the base is: the root, or that which floats.
        poses: Poses (3, 4) of the base as it is, in that of the second robot.
    """
    for pose in poses:
        rounded = _round(pose)
        about_base = np.column_stack([rounded[:, :3], np.zeros(3)])
        for frame in (about_base, rounded, pose):
            pose_of_base = _to_pose(frame)
            if pose_of_base == HERE:
                continue
            displacement = describe_displacement((*pose_of_base.rot, *pose_of_base.xyz))
            message = f"the whole robot is {displacement} on its base in the .mbs"
            yield Restatement(_move(robot, base, pose_of_base), "root", message)


def _round(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a pose with the nearest quarter turn, without a small shift."""
    rotation, origin = np.rint(pose[:, :3]), np.where(abs(pose[:, 3]) < SMALL, 0.0, pose[:, 3])
    is_turn = abs(rotation - pose[:, :3]).max() < SMALL
    return np.column_stack([rotation if is_turn else pose[:, :3], origin])


def _to_pose(matrix: NDArray[np.float64]) -> Pose:
    """Return a pose (3, 4) as a position and a rotation."""
    x, y, z = map(float, matrix[:, 3])
    return Pose((x, y, z), tuple(map(float, matrix[:, :3].flat)))  # type: ignore[arg-type]


def _move(robot: Robot, base: str, pose: Pose) -> Robot:
    """Return a robot with all that is on its base moved by a pose."""
    joints = dict(robot.joints)
    for name, joint in joints.items():
        if joint.parent == base:
            origin = convert_to_origin(compose(pose, joint.origin.pose))
            joints[name] = msgspec.structs.replace(joint, origin=origin)
    links = {**robot.links, base: move_in_frame(robot.links[base], pose)}
    return msgspec.structs.replace(robot, links=links, joints=joints)


def move_in_frame(link: Link, pose: Pose) -> Link:
    """Return a link whose inertia is moved by a pose; its shapes are left where they are."""
    inertial = link.inertial
    if inertial is None:
        return link
    origin = convert_to_origin(compose(pose, inertial.origin.pose))
    return msgspec.structs.replace(link, inertial=msgspec.structs.replace(inertial, origin=origin))


def convert_to_origin(pose: Pose) -> Origin:
    """Return a pose as an ``<origin>``."""
    return Origin(pose.xyz, _to_rpy(pose.rot))


def _to_rpy(rot: Rot) -> Vec:
    """Return the roll, pitch and yaw (rad) of a rotation ``Rz(yaw) Ry(pitch) Rx(roll)``."""
    r11, _, _, r21, r22, r23, r31, r32, r33 = rot
    cosine = hypot(r11, r21)
    pitch = atan2(-r31, cosine)
    if cosine < GIMBAL_LOCK:  # only the sum, or the difference, of roll and yaw is known
        return (atan2(-r23, r22), pitch, 0.0)
    return (atan2(r32, r33), pitch, atan2(r21, r11))


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
