"""The .mbs's side of the proof: rigid groups by elementary joints, one after another."""

from __future__ import annotations

from collections.abc import Collection, Container
from functools import partial
from math import cos, sin

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.proof.groups import Side, only_ground
from urdf2mbs.proof.rigid import AXES, HERE, ORIGIN, Frame, moved, seen


def mbs_side(mbs: Mbs, moving: Collection[str], framed: Container[str] = ()) -> Side:
    """The rigid groups of an .mbs; ``moving`` are the names of its joints that are compared.

    It has the frames of all bodies, and those after the joints ``framed``.  Driven joints stand
    where they are held, all others at zero.
    """
    side = only_ground("")
    side.gravity = mbs.base.gravity
    frames = side.frames
    free: set[str | None] = set()
    points = mbs.points()
    for body in mbs.bodies:
        group, at = frames[body.parent or ""]
        if body.point is not None:
            at = (*at[:9], *moved(at, points[body.parent, body.point].coordinates))
        held: list[str] = []
        for joint in body.joints:
            if joint.name in moving:
                # its position at start is where it starts from, not where it is held
                kind = joint.type
                group = side.add(
                    group, at, kind[0] == "R", AXES[int(kind[1]) - 1],
                    _MOVES[kind], joint.name, joint.name, body.name,
                )  # fmt: skip
                side.groups[group].held = held
                at = HERE
            elif joint.q and joint.nature == "driven":
                at = _stepped(at, joint.type, joint.q)
            if joint.nature != "driven":
                held = []
            elif joint.q:
                held = [*held, f"{joint.type} {joint.q:.6g}"]
            if joint.name in framed:
                side.after[joint.name] = (group, at)
        frames[body.name] = (group, at)
        if body.parent in free or any(joint.nature != "driven" for joint in body.joints):
            free.add(body.name)
            side.mass += body.mass or 0.0
        if body.mass or body.inertia:
            tensor = body.inertia or (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            side.put(body.name, group, seen((body.mass or 0.0, body.com or ORIGIN, tensor), at))
    return side


def _stepped(at: Frame, kind: str, q: float) -> Frame:
    """A frame after one joint: T1 T2 T3 shift along, R1 R2 R3 turn about its current axes."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, x, y, z = at
    if kind == "T1":
        return (*at[:9], x + q * a11, y + q * a21, z + q * a31)
    if kind == "T2":
        return (*at[:9], x + q * a12, y + q * a22, z + q * a32)
    if kind == "T3":
        return (*at[:9], x + q * a13, y + q * a23, z + q * a33)
    c, s = cos(q), sin(q)
    if kind == "R1":
        return (
            a11, c * a12 + s * a13, c * a13 - s * a12,
            a21, c * a22 + s * a23, c * a23 - s * a22,
            a31, c * a32 + s * a33, c * a33 - s * a32, x, y, z,
        )  # fmt: skip
    if kind == "R2":
        return (
            c * a11 - s * a13, a12, c * a13 + s * a11,
            c * a21 - s * a23, a22, c * a23 + s * a21,
            c * a31 - s * a33, a32, c * a33 + s * a31, x, y, z,
        )  # fmt: skip
    return (
        c * a11 + s * a12, c * a12 - s * a11, a13,
        c * a21 + s * a22, c * a22 - s * a21, a23,
        c * a31 + s * a32, c * a32 - s * a31, a33, x, y, z,
    )  # fmt: skip


_MOVES = {kind: partial(_stepped, HERE, kind) for kind in ("T1", "T2", "T3", "R1", "R2", "R3")}
