"""Pushes: forces on a link for some time, in addition to those of the project."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import msgspec

from urdf2mbs.plugin import ZERO, ConfigError, Vec, nearest
from urdf2mbs_simulate.data import MbsData

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PUSH_TEXT = re.compile(
    rf"(.+):({_NUMBER}),({_NUMBER}),({_NUMBER})@((?:{_NUMBER})?)\.\.((?:{_NUMBER})?)"
)


class Push(msgspec.Struct, frozen=True):
    """A force (N, in the axes of the base) from ``start`` to ``stop`` (s)."""

    link: str
    """A body of the .mbs, pushed at its centre of mass; or an anchor point, pushed there."""
    force: Vec
    start: float = 0.0
    stop: float = float("inf")


class PlacedPush(NamedTuple):
    """A push with the place where it acts."""

    push: Push
    body: str
    point: Vec
    """In the frame of the body (m)."""


def parse_push(text: str) -> Push:
    """Parse ``LINK:FX,FY,FZ@START..STOP``.

    Args:
        text: The option; without START the push begins at 0 s, without STOP it never ends.

    Raises:
        ConfigError: The text has another form, or the push ends before it starts.
    """
    match = _PUSH_TEXT.fullmatch(text.replace("...", "..0."))
    if match is not None:
        x, y, z = map(float, match.group(2, 3, 4))
        start, stop = float(match[5] or 0.0), float(match[6] or "inf")
        if start < stop:
            return Push(match[1], (x, y, z), start, stop)
    raise ConfigError(
        "usage",
        f"--push {text}: write LINK:FX,FY,FZ@START..STOP",
        hint="such as chest:20,0,0@0.5..0.6 (N, s)",
    )


def place_pushes(data: MbsData) -> list[PlacedPush]:
    """Return each push of a model with the body and the point where it acts.

    Raises:
        ConfigError: The model has no such body or point.
    """
    return [PlacedPush(push, *_find_place(data, push.link)) for push in data._run.pushes]


def compute_push_columns(data: MbsData, time: Any) -> dict[str, Any]:
    """Compute the pushes as columns of the table of results.

    Args:
        data: The model.
        time: Of each frame (s).

    Returns:
        ``push1.BODY.Fx``, ...: the force (N, axes of the base) in each frame; ``push1.BODY.dx``,
        ...: the point (m, axes of the body) where it acts.
    """
    columns: dict[str, Any] = {}
    for number, (push, body, point) in enumerate(place_pushes(data), start=1):
        is_active = (push.start <= time) & (time < push.stop)
        name = f"push{number}.{body}"
        for axis, component in zip("xyz", push.force, strict=True):
            columns[f"{name}.F{axis}"] = is_active * component
        for axis, component in zip("xyz", point, strict=True):
            columns[f"{name}.d{axis}"] = is_active * 0.0 + component
    return columns


def _find_place(data: MbsData, link: str) -> tuple[str, Vec]:
    """Find the body of a link, and the point (m, frame of the body) that is pushed."""
    bodies = {body.name: body for body in data._run.mbs.bodies}
    # a link that is called base, or like a joint, becomes the body LINK_body
    for name in (link, f"{link}_body"):
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
