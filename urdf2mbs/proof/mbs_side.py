"""The .mbs's side of the proof: rigid groups by elementary joints, one after another."""

from __future__ import annotations

from collections.abc import Collection, Container
from functools import partial
from math import cos, sin
from typing import cast

from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs.proof.groups import Group, PlacedFrame, Side, create_side
from urdf2mbs.proof.rigid import (
    AXES,
    IDENTITY,
    ORIGIN,
    Frame,
    Inertia,
    transform_inertia,
    transform_point,
)
from urdf2mbs.spatial import NO_INERTIA


def build_mbs_side(
    mbs: Mbs, moving: Collection[str], framed_joints: Container[str | None] = ()
) -> Side:
    """Build the rigid groups of an .mbs.

    Driven joints are at their positions at the start, all others at zero.

    Args:
        mbs: The model.
        moving: Names of the joints that are compared; each moves a group.
        framed_joints: Names of the joints after which a frame is needed, too.

    Returns:
        The groups, with the frames of all bodies.
    """
    side = create_side("")
    side.gravity = mbs.base.gravity
    points = mbs.points()
    free_bodies: set[str | None] = set()
    for body in mbs.bodies:
        frame = side.frames[body.parent or ""]
        if body.point is not None:
            origin = transform_point(frame.pose, points[body.parent, body.point].coordinates)
            frame = PlacedFrame(frame.group, (*frame.pose[:9], *origin))
        side.frames[body.name] = frame = _add_joints(side, body, frame, moving, framed_joints)
        if body.parent in free_bodies or any(j.nature != "driven" for j in body.joints):
            free_bodies.add(body.name)
            side.moving_mass += body.mass or 0.0
        if body.mass or body.inertia:
            inertia = Inertia(body.mass or 0.0, body.com or ORIGIN, body.inertia or NO_INERTIA)
            side.add_inertia(body.name, frame.group, transform_inertia(inertia, frame.pose))
    return side


def _add_joints(
    side: Side,
    body: Body,
    frame: PlacedFrame,
    moving: Collection[str],
    framed_joints: Container[str | None],
) -> PlacedFrame:
    """Add a group for each joint of a body that moves, and return the frame of the body."""
    driven_before: list[str] = []
    for joint in body.joints:
        if joint.name in moving:
            # The position of a moving joint is only its start: its zero is what is compared.
            group = _create_group(joint, body, frame, driven_before)
            frame = PlacedFrame(side.add_group(group), IDENTITY)
        elif joint.q and joint.nature == "driven":
            frame = PlacedFrame(frame.group, _move_joint(frame.pose, joint.type, joint.q))
        if joint.nature != "driven":
            driven_before = []
        elif joint.q:
            driven_before = [*driven_before, f"{joint.type} {joint.q:.6g}"]
        if joint.name in framed_joints:
            side.frames_after_joints[joint.name] = frame
    return frame


def _create_group(joint: Joint, body: Body, frame: PlacedFrame, driven_before: list[str]) -> Group:
    """Create the group that a joint moves."""
    return Group(
        parent=frame.group,
        joint_frame=frame.pose,
        revolute=joint.type[0] == "R",
        axis=AXES[int(joint.type[1]) - 1],
        motion=_MOTIONS[joint.type],
        coordinate=joint.name,
        joint=joint.name,
        child=body.name,
        driven_before=driven_before,
    )


def _move_joint(frame: Frame, joint_type: str, q: float) -> Frame:
    """Return the frame after an elementary joint.

    Args:
        frame: The frame before the joint.
        joint_type: T1 T2 T3 shift along, and R1 R2 R3 rotate about, an axis of that frame.
        q: Position of the joint (rad or m).
    """
    axis, moved = int(joint_type[1]) - 1, list(frame)
    if joint_type[0] == "T":
        for row in range(3):
            moved[9 + row] += q * frame[3 * row + axis]
    else:
        c, s = cos(q), sin(q)
        first, second = (axis + 1) % 3, (axis + 2) % 3  # the axes that rotate
        for row in (0, 3, 6):
            u, v = frame[row + first], frame[row + second]
            moved[row + first], moved[row + second] = c * u + s * v, c * v - s * u
    return cast("Frame", tuple(moved))


_MOTIONS = {
    joint_type: partial(_move_joint, IDENTITY, joint_type)
    for joint_type in ("T1", "T2", "T3", "R1", "R2", "R3")
}
