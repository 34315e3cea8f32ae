"""The URDF's side of the proof: rigid groups by Rodrigues' formula and quaternions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from math import cos, hypot, sin

from urdf2mbs.proof.groups import Group, Side, only_ground
from urdf2mbs.proof.rigid import AXES, HERE, ORIGIN, Frame, compose, cross, moved, seen, shift, spin
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf.model import Joint, Origin, Robot

#: Components of a unit axis up to this are zero for a conversion (it says so in a note).
ALIGNED = 1e-9
#: A floating joint's coordinates, where the .mbs does not have them in another order.
SIX = ("T1", "T2", "T3", "R1", "R2", "R3")


def urdf_side(
    robot: Robot,
    moving: Mapping[str, str],
    held: Mapping[str, float],
    orders: Mapping[str, tuple[str, ...]],
) -> Side:
    """The rigid groups of a URDF.

    ``moving``: the coordinates that are compared, and their names in the .mbs; ``held``: where
    others are held (rad, m); ``orders``: how the coordinates of a floating joint follow each other.
    """
    side = only_ground(robot.root())
    frames = side.frames
    free: set[str] = set()
    for joint in robot.depth_first():
        group, at = frames[joint.parent]
        at = at_origin(at, joint.origin)
        if joint.moves:
            order = orders.get(joint.name, SIX)
            for own, kind, along in own_coordinates(joint, order):
                turns = kind[0] == "R"
                move = partial(spin if turns else shift, along)
                if own in moving:
                    one = Group(group, at, turns, along, move, own, joint.name, joint.child)
                    group, at = side.add(one), HERE
                elif held.get(own):
                    at = compose(at, move(held[own]))
        frames[joint.child] = (group, at)
        if joint.moves or joint.parent in free:
            free.add(joint.child)
    for name, link in robot.links.items():
        if link.inertial is not None:
            group, at = frames[name]
            centre, rpy = link.inertial.origin.xyz, link.inertial.origin.rpy
            if rpy != ORIGIN:
                centre, at = ORIGIN, at_origin(at, link.inertial.origin)
            side.put(name, group, seen((link.inertial.mass, centre, link.inertial.inertia), at))
            side.mass += link.inertial.mass if name in free else 0.0
    return side


def at_origin(at: Frame, origin: Origin) -> Frame:
    """Return the frame of an ``<origin>`` that is given in a frame."""
    if origin.rpy != ORIGIN:
        return compose(at, _turned(origin.rpy, origin.xyz))
    if origin.xyz != ORIGIN:
        return (*at[:9], *moved(at, origin.xyz))
    return at


def own_coordinates(joint: Joint, order: tuple[str, ...]) -> list[tuple[str, str, Vec]]:
    """A joint's coordinates: the name, a T or an R, and the axis."""
    if joint.type == "floating":
        return [(f"{joint.name}[{kind}]", kind, AXES[int(kind[1]) - 1]) for kind in order]
    axis = _direction(joint.axis)
    if joint.type == "planar":
        axes = (*in_plane(axis), axis)
        return [(f"{joint.name}[{k}]", "TTR"[k], axes[k]) for k in range(3)]
    return [(joint.name, "T" if joint.type == "prismatic" else "R", axis)]


def _direction(axis: Vec) -> Vec:
    if axis in AXES:
        return AXES[AXES.index(axis)]  # without a zero that is -0
    length = hypot(*axis)
    x, y, z = (0.0 if abs(c / length) <= ALIGNED else c for c in axis)
    length = hypot(x, y, z)
    return (x / length, y / length, z / length)


def in_plane(axis: Vec) -> tuple[Vec, Vec]:
    """The two directions in which a planar joint of a unit axis shifts; URDF leaves them open."""
    x, y, z = axis
    if x == 0.0 and y != 0.0:
        u = (0.0, -z, y)
    elif y == 0.0 and z != 0.0:
        u = (z, 0.0, -x)
    else:
        u = (-y / hypot(x, y), x / hypot(x, y), 0.0)
    return u, cross(axis, u)


def _turned(rpy: Vec, xyz: Vec) -> Frame:
    """The frame of roll, pitch and yaw, by way of the quaternion, as urdfdom does it."""
    cr, cp, cy = (cos(angle / 2) for angle in rpy)
    sr, sp, sy = (sin(angle / 2) for angle in rpy)
    x = sr * cp * cy - cr * sp * sy
    y = cr * sp * cy + sr * cp * sy
    z = cr * cp * sy - sr * sp * cy
    w = cr * cp * cy + sr * sp * sy
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
        *xyz,
    )  # fmt: skip


def carriers(robot: Robot) -> set[str]:
    """The links that have mass or carry what has."""
    useful = {link.name for link in robot.links.values() if not link.massless}
    for joint in reversed(robot.depth_first()):
        if joint.child in useful:
            useful.add(joint.parent)
    return useful
