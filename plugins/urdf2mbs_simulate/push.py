"""Pushes: forces on a link for a while, beside those of the project."""

from __future__ import annotations

import re
from typing import Any

import msgspec

from urdf2mbs.plugin import ZERO, ConfigError, Vec, nearest
from urdf2mbs_simulate.data import MbsData

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
        "usage",
        f"--push {text}: write LINK:FX,FY,FZ@START..STOP",
        hint="such as chest:20,0,0@0.5..0.6 (N, s)",
    )


def place_pushes(data: MbsData) -> list[tuple[Push, int, Vec]]:
    """Each push with the joint of its body, and the point (m) in the frame of the body."""
    found = [(push, *_place(data, push.link)) for push in data._run.pushes]
    return [(push, data.body_id[body], at) for push, body, at in found]


def columns_of_pushes(data: MbsData, time: Any) -> dict[str, Any]:
    """``push1.BODY.Fx``, ...: the force (N) in each frame, and ``dx``, ... the point (m) where it
    acts, in the axes of the body."""
    found: dict[str, Any] = {}
    for number, push in enumerate(data._run.pushes, start=1):
        body, at = _place(data, push.link)
        acts = (push.start <= time) & (time < push.stop)
        name = f"push{number}.{body}"
        found |= {f"{name}.F{axis}": acts * x for axis, x in zip("xyz", push.force, strict=True)}
        found |= {f"{name}.d{axis}": acts * 0.0 + x for axis, x in zip("xyz", at, strict=True)}
    return found


def _place(data: MbsData, link: str) -> tuple[str, Vec]:
    """The body that a link is part of, and the point (m) in its frame that is pushed."""
    bodies = {body.name: body for body in data._run.mbs.bodies}
    for name in (link, f"{link}_body"):  # a link called base, or as a joint, has got this name
        if name in bodies:
            return name, bodies[name].com or ZERO
    for body in data._run.mbs.bodies:
        for point in body.points:
            if point.name == link:
                return body.name, point.coordinates
    raise ConfigError(
        "usage",
        f"the model has no body and no point '{link}' to push; its bodies: {', '.join(bodies)}",
        file=str(data._run.file),
        hint=nearest(link, bodies),
    )
