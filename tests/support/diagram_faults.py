"""Find the faults of a diagram: overlaps, and wires that cross foreign boxes, dots or labels."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, hypot
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf2mbs.diagram.sizes import measure_name

if TYPE_CHECKING:
    from urdf2mbs.mbs.model import XY, Drawing, Mbs

#: How large MBSysPad draws a dot and the label of a joint (px).
DOT, LABEL = 13.0, 30.0

Edges = NDArray[np.float64]
"""Left, top, right, bottom (n, 4)."""


class Rectangle(NamedTuple):
    """A rectangle on the sheet (px)."""

    name: str
    left: float
    top: float
    right: float
    bottom: float

    def overlaps(self, other: Rectangle) -> bool:
        """Return True if two rectangles have a common area."""
        return (
            self.left < other.right
            and other.left < self.right
            and self.top < other.bottom
            and other.top < self.bottom
        )


class Dot(NamedTuple):
    """The dot of a joint, a point, or the base."""

    name: str
    owner: str
    """The body; "" is the base."""
    position: XY


class Wire(NamedTuple):
    """A wire from a point of the parent to the first joint of a body, or between two joints."""

    body: str
    parent: str
    start: XY
    end: XY

    @property
    def length(self) -> float:
        """Distance (px) of its ends."""
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])


# --- what is drawn ---


def square(name: str, centre: XY, size: float) -> Rectangle:
    """Return a square."""
    x, y = centre
    return Rectangle(name, x - size / 2, y - size / 2, x + size / 2, y + size / 2)


def require(position: XY | None) -> XY:
    """Return a position, which must be there."""
    assert position is not None
    return position


def box(name: str, drawing: Drawing | None, origin: XY | None) -> Rectangle:
    """Return the box of a body, and check that its control points are its corners."""
    assert drawing is not None
    assert drawing.shape == "rectangle"
    x, y = require(origin)
    left, top = x + drawing.position[0], y + drawing.position[1]
    right, bottom = left + drawing.size[0], top + drawing.size[1]
    corners = [(right, top), (right, bottom), (left, bottom), (left, top)]
    for (dx, dy), corner in zip(drawing.control_points, corners, strict=True):
        assert hypot(x + dx - corner[0], y + dy - corner[1]) < 0.3
    return Rectangle(name, left, top, right, bottom)


def boxes(mbs: Mbs) -> list[Rectangle]:
    """List the box of the base, then those of the bodies in their order."""
    bodies = [box(body.name, body.drawing, body.joints[-1].position) for body in mbs.bodies]
    return [box("", mbs.base.drawing, mbs.base.position), *bodies]


def dots(mbs: Mbs) -> Iterator[Dot]:
    """List the dots of all joints and points, and that of the base's own frame."""
    yield Dot("the base", "", require(mbs.base.position))
    for point in mbs.base.points:
        yield Dot(f"point {point.name} of the base", "", require(point.position))
    for body in mbs.bodies:
        for joint in body.joints:
            yield Dot(f"joint {joint.name}", body.name, require(joint.position))
        for point in body.points:
            yield Dot(f"point {point.name} of {body.name}", body.name, require(point.position))


def wires(mbs: Mbs) -> Iterator[Wire]:
    """List the wires from the parent's point to the first joint, and from joint to joint."""
    starts: dict[tuple[str | None, str | None], XY] = {(None, None): require(mbs.base.position)}
    starts |= {(None, point.name): require(point.position) for point in mbs.base.points}
    for body in mbs.bodies:
        starts[body.name, None] = require(body.joints[-1].position)
        starts |= {(body.name, point.name): require(point.position) for point in body.points}
    for body in mbs.bodies:
        start = starts[body.parent, body.point]
        for joint in body.joints:
            end = require(joint.position)
            yield Wire(body.name, body.parent or "", start, end)
            start = end


def curve(wire: Wire) -> NDArray[np.float64]:
    """Compute points (n, 2) of a wire, at most 2 px apart, as MBSysPad draws it.

    It is an S: a cubic Bezier curve whose control points are aside by 0.2 of the length of the
    wire, at most by 40 px.
    """
    start, end = np.array(wire.start), np.array(wire.end)
    chord = end - start
    if not wire.length:
        return start[None, :]
    aside = np.array([chord[1], -chord[0]]) / wire.length * min(0.2 * wire.length, 40.0)
    control1, control2 = start + chord / 3 + aside, end - chord / 3 - aside
    t = np.linspace(0.0, 1.0, max(8, ceil(wire.length / 1.5)))[:, None]
    s = 1.0 - t
    points = s**3 * start + 3 * s * s * t * control1 + 3 * s * t * t * control2 + t**3 * end
    return np.asarray(points, dtype=np.float64)


def names(mbs: Mbs) -> list[Rectangle]:
    """List where MBSysPad writes the names of the bodies.

    The baseline is 6 px above the middle of the box.
    """
    rectangles = []
    for body, body_box in zip(mbs.bodies, boxes(mbs)[1:], strict=True):
        x, y = (body_box.left + body_box.right) / 2, (body_box.top + body_box.bottom) / 2
        half_width = measure_name(body.name) / 2
        rectangles.append(Rectangle(body.name, x - half_width, y - 16, x + half_width, y - 3))
    return rectangles


def arrows(mbs: Mbs) -> Iterator[tuple[str, XY, XY]]:
    """List the arrows from the frame of each body, or of the base, to its points."""
    for point in mbs.base.points:
        yield "the base", require(mbs.base.position), require(point.position)
    for body in mbs.bodies:
        for point in body.points:
            yield body.name, require(body.joints[-1].position), require(point.position)


# --- faults ---


class Drawn:
    """All that is drawn in a diagram."""

    def __init__(self, mbs: Mbs) -> None:
        """List all that is drawn in the diagram of a model."""
        self.mbs = mbs
        self.boxes = boxes(mbs)
        self.dots = list(dots(mbs))
        self.discs = [square(dot.name, dot.position, DOT) for dot in self.dots]
        self.wires = list(wires(mbs))
        self.labels = []
        for wire in self.wires:
            middle = ((wire.start[0] + wire.end[0]) / 2, (wire.start[1] + wire.end[1]) / 2)
            self.labels.append(square(f"a label of {wire.body}", middle, LABEL))


def faults(mbs: Mbs) -> list[str]:
    """Find the faults of a diagram."""
    drawn = Drawn(mbs)
    return [
        *find_negative_positions(drawn),
        *find_overlaps(drawn),
        *find_crossing_wires(drawn),
        *find_crossed_names(drawn),
    ]


def find_negative_positions(drawn: Drawn) -> Iterator[str]:
    """Find boxes and dots at negative coordinates; NaN is one, too."""
    for rectangle in (*drawn.boxes, *drawn.discs):
        if not (rectangle.left >= 0.0 and rectangle.top >= 0.0):
            yield f"negative: {rectangle}"


def find_overlaps(drawn: Drawn) -> Iterator[str]:
    """Find boxes, dots and labels that overlap, or that are in a foreign box."""
    box_edges, disc_edges, label_edges = map(list_edges, (drawn.boxes, drawn.discs, drawn.labels))
    for kind, rectangles, edges in (
        ("box", drawn.boxes, box_edges),
        ("", drawn.discs, disc_edges),
        ("", drawn.labels, label_edges),
    ):
        for a, b in np.argwhere(np.triu(compute_overlaps(edges, edges), 1)):
            yield f"{kind} {rectangles[a].name!r} on {rectangles[b].name!r}"
    for a, b in np.argwhere(compute_overlaps(disc_edges, box_edges)):
        if drawn.boxes[b].name != drawn.dots[a].owner:
            yield f"{drawn.dots[a].name} in the box of {drawn.boxes[b].name!r}"
    inner_edges = disc_edges + np.array([1.5, 1.5, -1.5, -1.5])
    for a, b in np.argwhere(compute_overlaps(label_edges, inner_edges)):
        yield f"{drawn.labels[a].name} on {drawn.discs[b].name}"
    for a, b in np.argwhere(compute_overlaps(label_edges, box_edges)):
        if drawn.boxes[b].name not in (drawn.wires[a].body, drawn.wires[a].parent):
            yield f"{drawn.labels[a].name} on the box of {drawn.boxes[b].name!r}"


def list_edges(rectangles: list[Rectangle]) -> Edges:
    """Return the edges of rectangles as an array."""
    return np.array([rectangle[1:] for rectangle in rectangles], dtype=np.float64).reshape(-1, 4)


def compute_overlaps(a: Edges, b: Edges) -> NDArray[np.bool_]:
    """Compute which rectangles of a (n) overlap which of b (m); those with NaN overlap all."""
    left, top, right, bottom = (edge[:, None] for edge in a.T)
    is_apart_in_x = (right <= b[:, 0]) | (b[:, 2] <= left)
    is_apart_in_y = (bottom <= b[:, 1]) | (b[:, 3] <= top)
    return np.asarray(~(is_apart_in_x | is_apart_in_y))


def find_crossing_wires(drawn: Drawn) -> Iterator[str]:
    """Find wires that run through foreign dots or boxes."""
    positions = np.array([dot.position for dot in drawn.dots])
    left, top, right, bottom = list_edges(drawn.boxes).T
    for wire in drawn.wires:
        points = curve(wire)
        offsets = (points[:, None, :] - positions[None]).transpose(2, 0, 1)
        distances = np.hypot(*offsets).min(axis=0)
        for k in np.flatnonzero(~(distances > DOT / 2)):
            if drawn.dots[k].position not in (wire.start, wire.end):
                yield f"a wire of {wire.body} through {drawn.dots[k].name}"
        x, y = points[:, :1], points[:, 1:]
        is_inside = ((left < x) & (x < right) & (top < y) & (y < bottom)).any(axis=0)
        for k in np.flatnonzero(is_inside):
            if drawn.boxes[k].name not in (wire.body, wire.parent):
                yield f"a wire of {wire.body} through the box of {drawn.boxes[k].name!r}"


def find_crossed_names(drawn: Drawn) -> Iterator[str]:
    """Find arrows that run through names."""
    name_rectangles = names(drawn.mbs)
    left, top, right, bottom = list_edges(name_rectangles).T
    for owner, start, end in arrows(drawn.mbs):
        count = max(2, ceil(hypot(end[0] - start[0], end[1] - start[1])))
        share = np.linspace(0.0, 1.0, count)[:, None]
        x, y = (start[k] + share * (end[k] - start[k]) for k in (0, 1))
        is_inside = ~((x <= left) | (right <= x) | (y <= top) | (bottom <= y))
        for k in np.flatnonzero(is_inside.any(axis=0)):
            yield f"an arrow of {owner} through the name of {name_rectangles[k].name}"
