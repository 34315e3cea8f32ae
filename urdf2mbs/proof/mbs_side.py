"""The .mbs's side of the proof: rigid groups by elementary joints, one after another."""

from __future__ import annotations

from collections.abc import Collection, Container
from functools import partial
from math import cos, sin
from typing import cast

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.proof.groups import Group, Side, only_ground
from urdf2mbs.proof.rigid import AXES, HERE, ORIGIN, Frame, moved, seen


def mbs_side(mbs: Mbs, moving: Collection[str], framed: Container[str | None] = ()) -> Side:
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
                one = Group(
                    group, at, kind[0] == "R", AXES[int(kind[1]) - 1],
                    _MOVES[kind], joint.name, joint.name, body.name, held=held,
                )  # fmt: skip
                group, at = side.add(one), HERE
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
    k, out = int(kind[1]) - 1, list(at)
    if kind[0] == "T":
        for row in range(3):
            out[9 + row] += q * at[3 * row + k]
    else:
        c, s = cos(q), sin(q)
        one, two = (k + 1) % 3, (k + 2) % 3  # the axes that turn
        for row in (0, 3, 6):
            u, v = at[row + one], at[row + two]
            out[row + one], out[row + two] = c * u + s * v, c * v - s * u
    return cast("Frame", tuple(out))


_MOVES = {kind: partial(_stepped, HERE, kind) for kind in ("T1", "T2", "T3", "R1", "R2", "R3")}
