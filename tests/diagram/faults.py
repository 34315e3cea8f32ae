"""What is wrong with a diagram: overlaps, and wires that run through what is not theirs."""

from __future__ import annotations

from math import ceil, hypot
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from urdf2mbs.diagram.sizes import measure_name

if TYPE_CHECKING:
    from collections.abc import Iterator

    from urdf2mbs.mbs.model import XY, Drawing, Mbs

#: How large MBSysPad draws a dot and a joint's label (px).
DOT, LABEL = 13.0, 30.0


class Rectangle(NamedTuple):
    what: str
    left: float
    top: float
    right: float
    bottom: float

    def overlaps(self, other: Rectangle) -> bool:
        return (
            self.left < other.right
            and other.left < self.right
            and self.top < other.bottom
            and other.top < self.bottom
        )


def square(what: str, centre: XY, size: float) -> Rectangle:
    x, y = centre
    return Rectangle(what, x - size / 2, y - size / 2, x + size / 2, y + size / 2)


def at(position: XY | None) -> XY:
    assert position is not None
    return position


def box(what: str, drawing: Drawing | None, origin: XY | None) -> Rectangle:
    assert drawing is not None
    x, y = at(origin)
    left, top = x + drawing.position[0], y + drawing.position[1]
    width, height = drawing.size
    assert drawing.shape == "rectangle"
    corners = [(x + u, y + v) for u, v in drawing.control_points]
    right, bottom = left + width, top + height
    for corner, there in zip(
        corners, [(right, top), (right, bottom), (left, bottom), (left, top)], strict=True
    ):
        assert hypot(corner[0] - there[0], corner[1] - there[1]) < 0.3
    return Rectangle(what, left, top, right, bottom)


def boxes(mbs: Mbs) -> list[Rectangle]:
    """The base's, then the bodies' in their order."""
    bodies = [box(b.name, b.drawing, b.joints[-1].position) for b in mbs.bodies]
    return [box("", mbs.base.drawing, mbs.base.position), *bodies]


class Dot(NamedTuple):
    what: str
    owner: str
    place: XY


def dots(mbs: Mbs) -> Iterator[Dot]:
    """All joints and points, and the base's own frame; '' owns those of the base."""
    yield Dot("the base", "", at(mbs.base.position))
    for point in mbs.base.points:
        yield Dot(f"point {point.name} of the base", "", at(point.position))
    for body in mbs.bodies:
        for joint in body.joints:
            yield Dot(f"joint {joint.name}", body.name, at(joint.position))
        for point in body.points:
            yield Dot(f"point {point.name} of {body.name}", body.name, at(point.position))


class Wire(NamedTuple):
    body: str
    parent: str
    start: XY
    end: XY

    @property
    def length(self) -> float:
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])


def wires(mbs: Mbs) -> Iterator[Wire]:
    """From the parent's point to the first joint, and from joint to joint."""
    starts: dict[tuple[str | None, str | None], XY] = {(None, None): at(mbs.base.position)}
    starts |= {(None, point.name): at(point.position) for point in mbs.base.points}
    for body in mbs.bodies:
        starts[body.name, None] = at(body.joints[-1].position)
        starts |= {(body.name, point.name): at(point.position) for point in body.points}
    for body in mbs.bodies:
        start = starts[body.parent, body.point]
        for joint in body.joints:
            yield Wire(body.name, body.parent or "", start, at(joint.position))
            start = at(joint.position)


def curve(wire: Wire) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Points (n, 2) of a wire, at most 2 px apart, as MBSysPad draws it: an S whose control
    points are aside by 0.2 of its length, at most by 40 px."""
    start, end = np.array(wire.start), np.array(wire.end)
    way = end - start
    if not wire.length:
        return start[None, :]
    aside = np.array([way[1], -way[0]]) / wire.length * min(0.2 * wire.length, 40.0)
    one, two = start + way / 3 + aside, end - way / 3 - aside
    t = np.linspace(0.0, 1.0, max(8, ceil(wire.length / 1.5)))[:, None]
    s = 1.0 - t
    out = s**3 * start + 3 * s * s * t * one + 3 * s * t * t * two + t**3 * end
    return np.asarray(out, dtype=np.float64)


def names(mbs: Mbs) -> list[Rectangle]:
    """Where MBSysPad writes the names of the bodies: the foot of a line is 6 px above the middle
    of the box."""
    out = []
    for body, here in zip(mbs.bodies, boxes(mbs)[1:], strict=True):
        x, y = (here.left + here.right) / 2, (here.top + here.bottom) / 2
        half_width = measure_name(body.name) / 2
        out.append(Rectangle(body.name, x - half_width, y - 16, x + half_width, y - 3))
    return out


def arrows(mbs: Mbs) -> Iterator[tuple[str, XY, XY]]:
    """From the frame of each body, or of the base, to its points."""
    yield from (("the base", at(mbs.base.position), at(p.position)) for p in mbs.base.points)
    for body in mbs.bodies:
        start = at(body.joints[-1].position)
        yield from ((body.name, start, at(point.position)) for point in body.points)


Sides = np.ndarray[tuple[int, int], np.dtype[np.float64]]


def sides(rectangles: list[Rectangle]) -> Sides:
    """Left, top, right, bottom (n, 4)."""
    return np.array([one[1:] for one in rectangles], dtype=np.float64).reshape(-1, 4)


def overlaps(one: Sides, other: Sides) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Which of one (n, 4) overlap which of the other (m, 4); what is no number does."""
    left, top, right, bottom = (side[:, None] for side in one.T)
    apart = (
        (right <= other[:, 0]) | (other[:, 2] <= left)
        | (bottom <= other[:, 1]) | (other[:, 3] <= top)
    )  # fmt: skip
    return np.asarray(~apart)


def faults(mbs: Mbs) -> list[str]:
    """All that must not be in a diagram."""
    found: list[str] = []
    solid, round_ = boxes(mbs), list(dots(mbs))
    discs = [square(dot.what, dot.place, DOT) for dot in round_]
    found += [
        f"negative: {thing}"
        for thing in (*solid, *discs)
        if not (thing.left >= 0.0 and thing.top >= 0.0)
    ]
    labels, lines = [], list(wires(mbs))
    for wire in lines:
        middle = ((wire.start[0] + wire.end[0]) / 2, (wire.start[1] + wire.end[1]) / 2)
        labels.append(square(f"a label of {wire.body}", middle, LABEL))
    solid_at, discs_at, labels_at = sides(solid), sides(discs), sides(labels)
    for name, things, at_ in (
        ("box", solid, solid_at),
        ("", discs, discs_at),
        ("", labels, labels_at),
    ):
        pairs = np.argwhere(np.triu(overlaps(at_, at_), 1))
        found += [f"{name} {things[a].what!r} on {things[b].what!r}" for a, b in pairs]
    for a, b in np.argwhere(overlaps(discs_at, solid_at)):
        if solid[b].what != round_[a].owner:
            found.append(f"{round_[a].what} in the box of {solid[b].what!r}")
    inner = discs_at + np.array([1.5, 1.5, -1.5, -1.5])
    for a, b in np.argwhere(overlaps(labels_at, inner)):
        found.append(f"{labels[a].what} on {discs[b].what}")
    for a, b in np.argwhere(overlaps(labels_at, solid_at)):
        if solid[b].what not in (lines[a].body, lines[a].parent):
            found.append(f"{labels[a].what} on the box of {solid[b].what!r}")

    places = np.array([dot.place for dot in round_])
    left, top, right, bottom = solid_at.T
    for wire in lines:
        line = curve(wire)
        near = np.hypot(*(line[:, None, :] - places[None]).transpose(2, 0, 1)).min(axis=0)
        for k in np.flatnonzero(~(near > DOT / 2)):
            if round_[k].place not in (wire.start, wire.end):
                found.append(f"a wire of {wire.body} through {round_[k].what}")
        x, y = line[:, :1], line[:, 1:]
        hit = ((left < x) & (x < right) & (top < y) & (y < bottom)).any(axis=0)
        for k in np.flatnonzero(hit):
            if solid[k].what not in (wire.body, wire.parent):
                found.append(f"a wire of {wire.body} through the box of {solid[k].what!r}")
    words = names(mbs)
    left, top, right, bottom = sides(words).T
    for owner, start, end in arrows(mbs):
        share = np.linspace(0.0, 1.0, max(2, ceil(hypot(end[0] - start[0], end[1] - start[1]))))
        x, y = (start[k] + share[:, None] * (end[k] - start[k]) for k in (0, 1))
        hit = ~((x <= left) | (right <= x) | (y <= top) | (bottom <= y))
        for k in np.flatnonzero(hit.any(axis=0)):
            found.append(f"an arrow of {owner} through the name of {words[k].what}")
    return found
