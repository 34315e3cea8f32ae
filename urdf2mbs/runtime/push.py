"""Pushes: forces on a link for a while, beside those of the project."""

from __future__ import annotations

import re
from typing import Any

import msgspec
import numpy as np

from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.model import Body, Mbs
from urdf2mbs.messages.diagnostics import ConfigError, nearest
from urdf2mbs.runtime.data import MbsData
from urdf2mbs.spatial import Vec

_NUMBER = r"[-+]?[\d.]+(?:[eE][-+]?\d+)?"
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
    try:
        if found is None:
            raise ValueError
        x, y, z = (float(word) for word in found.group(2, 3, 4))
        start, stop = found.group(5, 6)
        push = Push(found[1], (x, y, z), float(start or 0.0), float(stop or "inf"))
        if push.start < push.stop:
            return push
        raise ValueError
    except ValueError:
        raise ConfigError(
            "usage", f"--push {text}: it reads LINK:FX,FY,FZ@START..STOP",
            hint="such as chest:20,0,0@0.5..0.6 (N, s)",
        ) from None  # fmt: skip


def add_pushes(data: MbsData) -> None:
    """Let ``user_JointForces`` add what the pushes do in the joints."""
    if data.push is not None or not data.pushes:
        return
    user = data.user_JointForces
    places = [(push, *_place(data, push.link)) for push in data.pushes]
    ways = [_way(data.mbs, body) for _, body, _ in places]

    def add(tsim: float) -> None:
        for (push, body, at), way in zip(places, ways, strict=True):
            if push.start <= tsim < push.stop:
                data.Qq += in_joints(data, way, body, at, np.array(push.force))

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


def _place(data: MbsData, link: str) -> tuple[str, Any]:
    """The body that a link is part of, and the point (m) in its frame that is pushed."""
    for body in data.mbs.bodies:
        if body.name == link:
            return body.name, np.array(body.com or (0.0, 0.0, 0.0))
    for body in data.mbs.bodies:
        for point in body.points:
            if point.name == link:
                return body.name, np.array(point.coordinates)
    known = [body.name for body in data.mbs.bodies]
    raise ConfigError(
        "usage", f"the model has no body and no point '{link}' to push",
        file=str(data.mbs_file), hint=nearest(link, known),
    )  # fmt: skip


def _way(mbs: Mbs, name: str) -> Mbs:
    """The bodies from the base to a body, alone."""
    kept: list[Body] = []
    for body in reversed(mbs.bodies):
        if body.name == (kept[0].parent if kept else name):
            kept.insert(0, body)
    return msgspec.structs.replace(mbs, bodies=kept)


def in_joints(data: MbsData, way: Mbs, body: str, at: Any, force: Any) -> Any:
    """The joint forces (from index 1) that do the work of a force at a point of a body."""
    placed = place(
        way, {j.name: data.q[data.joint_id[j.name]] for b in way.bodies for j in b.joints}
    )
    pose = placed.bodies[body]
    point = np.array(pose.xyz) + np.array(pose.rot).reshape(3, 3) @ at
    found = np.zeros(data.njoint + 1)
    for index in placed.way(body):
        joint = placed.joints[index]
        lever = np.array(joint.axis)
        if joint.joint.type[0] == "R":
            lever = np.cross(lever, point - np.array(joint.origin))
        found[data.joint_id[joint.joint.name]] = lever @ force
    return found
