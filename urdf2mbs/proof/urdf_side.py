"""The URDF's side of the proof: rigid groups by Rodrigues' formula and quaternions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from math import cos, hypot, sin
from typing import NamedTuple

from urdf2mbs.proof.groups import Group, PlacedFrame, Side, create_side
from urdf2mbs.proof.rigid import (
    AXES,
    IDENTITY,
    ORIGIN,
    Frame,
    Inertia,
    compose,
    compute_rotation,
    compute_translation,
    cross,
    transform_inertia,
    transform_point,
)
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf.model import Inertial, Joint, Origin, Robot

#: Components of a unit axis up to this are zero for a conversion (it says so in a note).
ALIGNED = 1e-9
#: Coordinates of a floating joint, unless the .mbs has them in another order.
FLOATING_ORDER = ("T1", "T2", "T3", "R1", "R2", "R3")


class Coordinate(NamedTuple):
    """A coordinate of a URDF joint."""

    name: str
    """The name of the joint; of a planar or floating joint, with an index: ``slide[0]``."""
    type: str
    """It begins with T for a shift, with R for a rotation."""
    axis: Vec
    """Of length 1, in the frame of the joint."""


def build_urdf_side(
    robot: Robot,
    moving: Mapping[str, str],
    locked: Mapping[str, float],
    floating_orders: Mapping[str, tuple[str, ...]],
) -> Side:
    """Build the rigid groups of a URDF.

    Args:
        robot: The robot.
        moving: The coordinates that are compared, and their names in the .mbs.
        locked: Positions (rad or m) of coordinates that the .mbs holds at a constant.
        floating_orders: Order of the coordinates of floating joints, if it is not the usual one.

    Returns:
        The groups, with the frames of all links.
    """
    side = create_side(robot.root())
    free_links: set[str] = set()
    for joint in robot.depth_first():
        group, pose = side.frames[joint.parent]
        frame = PlacedFrame(group, compose_origin(pose, joint.origin))
        if joint.moves:
            order = floating_orders.get(joint.name, FLOATING_ORDER)
            for coordinate in list_coordinates(joint, order):
                if coordinate.name in moving:
                    new_group = _create_group(joint, coordinate, frame)
                    frame = PlacedFrame(side.add_group(new_group), IDENTITY)
                elif locked.get(coordinate.name):
                    motion = _compute_motion(coordinate, locked[coordinate.name])
                    frame = PlacedFrame(frame.group, compose(frame.pose, motion))
        side.frames[joint.child] = frame
        if joint.moves or joint.parent in free_links:
            free_links.add(joint.child)
    for name, link in robot.links.items():
        if link.inertial is not None:
            _add_inertia(side, name, link.inertial)
            side.moving_mass += link.inertial.mass if name in free_links else 0.0
    return side


def _create_group(joint: Joint, coordinate: Coordinate, frame: PlacedFrame) -> Group:
    """Create the group that a coordinate of a joint moves."""
    return Group(
        parent=frame.group,
        joint_frame=frame.pose,
        revolute=coordinate.type[0] == "R",
        axis=coordinate.axis,
        motion=partial(_compute_motion, coordinate),
        coordinate=coordinate.name,
        joint=joint.name,
        child=joint.child,
    )


def _compute_motion(coordinate: Coordinate, q: float) -> Frame:
    """Compute the motion of a coordinate from zero to a position (rad or m)."""
    if coordinate.type[0] == "R":
        return compute_rotation(coordinate.axis, q)
    return compute_translation(coordinate.axis, q)


def _add_inertia(side: Side, link: str, inertial: Inertial) -> None:
    """Add the inertia of a link to its group."""
    group, pose = side.frames[link]
    centre = inertial.origin.xyz
    if inertial.origin.rpy != ORIGIN:
        centre, pose = ORIGIN, compose_origin(pose, inertial.origin)
    inertia = Inertia(inertial.mass, centre, inertial.inertia)
    side.add_inertia(link, group, transform_inertia(inertia, pose))


def compose_origin(frame: Frame, origin: Origin) -> Frame:
    """Return the frame of an ``<origin>`` that is given in a frame."""
    if origin.rpy != ORIGIN:
        return compose(frame, _compute_origin_frame(origin))
    if origin.xyz != ORIGIN:
        return (*frame[:9], *transform_point(frame, origin.xyz))
    return frame


def list_coordinates(joint: Joint, floating_order: tuple[str, ...]) -> list[Coordinate]:
    """List the coordinates of a joint that moves.

    Args:
        joint: The joint.
        floating_order: Order of the coordinates if it is a floating joint.
    """
    if joint.type == "floating":
        return [
            Coordinate(f"{joint.name}[{kind}]", kind, AXES[int(kind[1]) - 1])
            for kind in floating_order
        ]
    axis = _normalize_axis(joint.axis)
    if joint.type == "planar":
        axes = (*in_plane(axis), axis)
        return [Coordinate(f"{joint.name}[{k}]", "TTR"[k], axes[k]) for k in range(3)]
    return [Coordinate(joint.name, "T" if joint.type == "prismatic" else "R", axis)]


def _normalize_axis(axis: Vec) -> Vec:
    """Return an axis at length 1, its tiny components set to zero."""
    if axis in AXES:
        return AXES[AXES.index(axis)]  # without a zero that is -0
    length = hypot(*axis)
    x, y, z = (0.0 if abs(c / length) <= ALIGNED else c for c in axis)
    length = hypot(x, y, z)
    return (x / length, y / length, z / length)


def in_plane(axis: Vec) -> tuple[Vec, Vec]:
    """Return the two directions in which a planar joint shifts; URDF does not define them.

    Args:
        axis: The normal of the plane, of length 1.
    """
    x, y, z = axis
    if x == 0.0 and y != 0.0:
        u = (0.0, -z, y)
    elif y == 0.0 and z != 0.0:
        u = (z, 0.0, -x)
    else:
        u = (-y / hypot(x, y), x / hypot(x, y), 0.0)
    return u, cross(axis, u)


def _compute_origin_frame(origin: Origin) -> Frame:
    """Compute the frame of an ``<origin>`` by the quaternion of its angles, as urdfdom does."""
    cr, cp, cy = (cos(angle / 2) for angle in origin.rpy)
    sr, sp, sy = (sin(angle / 2) for angle in origin.rpy)
    x = sr * cp * cy - cr * sp * sy
    y = cr * sp * cy + sr * cp * sy
    z = cr * cp * sy - sr * sp * cy
    w = cr * cp * cy + sr * sp * sy
    row_x = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y))
    row_y = (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x))
    row_z = (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
    return (*row_x, *row_y, *row_z, *origin.xyz)


def find_links_that_carry_mass(robot: Robot) -> set[str]:
    """Find the links that have mass, or that carry a link that has."""
    carriers = {link.name for link in robot.links.values() if not link.massless}
    for joint in reversed(robot.depth_first()):
        if joint.child in carriers:
            carriers.add(joint.parent)
    return carriers
