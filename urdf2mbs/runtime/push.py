"""Pushes: forces on a link for a while, beside those of the project."""

from __future__ import annotations

import re
from typing import Any

import msgspec

from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.model import Body, Mbs
from urdf2mbs.messages.diagnostics import ConfigError, nearest
from urdf2mbs.runtime.data import MbsData
from urdf2mbs.spatial import ZERO, Vec, add, cross, dot, rotate

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_FORM = re.compile(
    rf"(.+):({_NUMBER}),({_NUMBER}),({_NUMBER})@((?:{_NUMBER})?)\.\.((?:{_NUMBER})?)"
)


class Push(msgspec.Struct, frozen=True):
    """A force (N, in the axes of the base) from ``start`` to ``stop`` (s)."""

    link: str
    """A body of the .mbs, pushed at its centre of mass; or an anchor point, pushed there."""
    force: Vec
    start: float = 0.0
    stop: float = float("inf")


def parse(text: str) -> Push:
    """``LINK:FX,FY,FZ@START..STOP``; without a time it lasts from the start, or to the end."""
    found = _FORM.fullmatch(text.replace("...", "..0."))
    if found is not None:
        x, y, z = map(float, found.group(2, 3, 4))
        start, stop = float(found[5] or 0.0), float(found[6] or "inf")
        if start < stop:
            return Push(found[1], (x, y, z), start, stop)
    raise ConfigError(
        "usage", f"--push {text}: it reads LINK:FX,FY,FZ@START..STOP",
        hint="such as chest:20,0,0@0.5..0.6 (N, s)",
    )  # fmt: skip


def add_pushes(data: MbsData) -> None:
    """Let ``user_JointForces`` add what the pushes do in the joints."""
    if data.push is not None or not data.pushes:
        return
    user = data.user_JointForces
    places = [(push, *_place(data, push.link)) for push in data.pushes]
    ways = [(push, _way(data.mbs, body), at) for push, body, at in places]

    def add(tsim: float) -> None:
        for push, way, at in ways:
            if push.start <= tsim < push.stop:
                _add_force(data, way, at, push.force)

    def user_joint_forces(mbs_data: MbsData, tsim: float) -> None:
        user(mbs_data, tsim)
        add(tsim)

    data.push, data.user_JointForces = add, user_joint_forces


def columns_of_pushes(data: MbsData, time: Any) -> dict[str, Any]:
    """``push1.BODY.Fx``, ...: the force (N) in each frame, and ``dx``, ... the point (m) where it
    acts, in the axes of the body."""
    found: dict[str, Any] = {}
    for number, push in enumerate(data.pushes, start=1):
        body, at = _place(data, push.link)
        acts = (push.start <= time) & (time < push.stop)
        name = f"push{number}.{body}"
        found |= {f"{name}.F{axis}": acts * x for axis, x in zip("xyz", push.force, strict=True)}
        found |= {f"{name}.d{axis}": acts * 0.0 + x for axis, x in zip("xyz", at, strict=True)}
    return found


def _place(data: MbsData, link: str) -> tuple[str, Vec]:
    """The body that a link is part of, and the point (m) in its frame that is pushed."""
    bodies = {body.name: body for body in data.mbs.bodies}
    if link in bodies:
        return link, bodies[link].com or ZERO
    for body in data.mbs.bodies:
        for point in body.points:
            if point.name == link:
                return body.name, point.coordinates
    raise ConfigError(
        "usage", f"the model has no body and no point '{link}' to push",
        file=str(data.mbs_file), hint=nearest(link, bodies),
    )  # fmt: skip


def _way(mbs: Mbs, name: str) -> list[Body]:
    """The bodies from the base to a body."""
    kept: list[Body] = []
    for body in reversed(mbs.bodies):
        if body.name == (kept[0].parent if kept else name):
            kept.insert(0, body)
    return kept


def _add_force(data: MbsData, way: list[Body], at: Vec, force: Vec) -> None:
    """Add the joint forces to Qq that do the work of a force at a point of the last body."""
    values = {j.name: data.q[data.joint_id[j.name]] for body in way for j in body.joints}
    placed = place(msgspec.structs.replace(data.mbs, bodies=way), values)
    pose = placed.bodies[way[-1].name]
    moment = cross(add(pose.xyz, rotate(pose.rot, at)), force)
    for joint in placed.joints:
        turn, shift = joint.twist
        data.Qq[data.joint_id[joint.joint.name]] += dot(turn, moment) + dot(shift, force)
