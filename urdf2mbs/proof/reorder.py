"""Two joints whose order does not matter, such as the shifts along x and z of a planar robot.

Motions T_a and T_b commute if both shift, or if one shifts along the axis about which the other
rotates.  With nothing but a frame between them, ``T_a B T_b X = B' T_b T_a X'`` for each position:
the same robot, in another order.  With p the origin and R the rotation of the frame B of the second
joint in the frame after the first one, and b its axis there, ``R b``:

* if the first joint shifts, the second one comes first at p, and R moves what both carry;
* if it rotates, the second one comes first in its place, and B moves what both carry.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from math import hypot

import msgspec

from urdf2mbs.proof.groups import Group, PlacedFrame, Side
from urdf2mbs.proof.rigid import (
    IDENTITY,
    IDENTITY_ROTATION,
    ORIGIN,
    Frame,
    compose,
    compute_rotation,
    compute_translation,
    cross,
    rotate,
    transform_inertia,
)

#: The sine of the angle between parallel axes is less.
PARALLEL = 1e-9


def reorder_joints(urdf: Side, mbs: Side, names: Mapping[str, str]) -> None:
    """Put joints whose order does not matter into the order of the other side.

    Args:
        urdf: The side that is changed.
        mbs: The other side.
        names: The coordinates of the first side, and those of the second one.
    """
    while (pair := _find_exchange(urdf, mbs, names)) is not None:
        _exchange(urdf, *pair)


def _find_exchange(urdf: Side, mbs: Side, names: Mapping[str, str]) -> tuple[int, int] | None:
    """Find a joint, and one that it carries, which are in the other order on the other side."""
    counterparts = [0]
    counterparts += [mbs.group_of_coordinate[names[group.coordinate]] for group in urdf.groups[1:]]
    for number, group in enumerate(urdf.groups[1:], start=1):
        before = group.parent
        if (
            before
            and mbs.groups[counterparts[number]].parent != counterparts[before]
            and _carries(mbs, counterparts[number], counterparts[before])
            and _may_exchange(urdf.groups[before], group)
        ):
            return before, number
    return None


def _carries(side: Side, number: int, carried: int) -> bool:
    """Return whether a group is on the way from the ground to another one."""
    while carried:
        carried = side.groups[carried].parent
        if carried == number:
            return True
    return False


def _may_exchange(first: Group, second: Group) -> bool:
    """Return whether the order of two joints does not matter."""
    if first.joint == second.joint or (first.revolute and second.revolute):
        return False  # the coordinates of one joint have an order
    if first.inertias or len(first.children) > 1:
        return False
    if not first.revolute and not second.revolute:
        return True
    axis = rotate(second.joint_frame, second.axis)
    return hypot(*cross(first.axis, axis)) <= PARALLEL


def _exchange(side: Side, first_number: int, second_number: int) -> None:
    """Exchange a joint and the one that it carries."""
    first, second = side.groups[first_number], side.groups[second_number]
    axis = rotate(second.joint_frame, second.axis)
    place: Frame = IDENTITY
    rest = second.joint_frame
    if not first.revolute:
        place = (*IDENTITY_ROTATION, *rest[9:])
        rest = (*rest[:9], *ORIGIN)
    move = compute_rotation if second.revolute else compute_translation
    side.groups[first_number] = msgspec.structs.replace(
        second,
        parent=first.parent,
        joint_frame=compose(first.joint_frame, place),
        axis=axis,
        motion=partial(move, axis),
        reach=first.reach,
        inertias={},
        children=[second_number],
    )
    side.groups[second_number] = msgspec.structs.replace(
        first,
        parent=first_number,
        joint_frame=IDENTITY,
        reach=second.reach,
        inertias={
            name: transform_inertia(inertia, rest) for name, inertia in second.inertias.items()
        },
        children=second.children,
    )
    for child in second.children:
        carried = side.groups[child]
        carried.joint_frame = compose(rest, carried.joint_frame)
    side.frames = {
        name: PlacedFrame(second_number, compose(rest, frame.pose))
        if frame.group == second_number
        else frame
        for name, frame in side.frames.items()
        if frame.group != first_number  # nothing moves with the first joint alone any more
    }
    side.group_of_coordinate = {
        group.coordinate: number for number, group in enumerate(side.groups) if number
    }
