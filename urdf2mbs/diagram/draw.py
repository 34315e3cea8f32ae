"""The 2D diagram of an .mbs file as an SVG picture, drawn as MBSysPad draws it.

Boxes, dots, arrows, wires and labels stand where the file puts them (pixels, y down).  What
MBSysPad leaves to a click is in the tooltips: joint and point names, nature, coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape as _t
from math import hypot

from urdf2mbs.mbs.model import CUTS, ORIGIN, XY, Body, Connection, Drawing, Joint, Mbs, Point
from urdf2mbs.messages.diagnostics import ConversionError

#: Left, top, right, bottom (px).
Box = tuple[float, float, float, float]

#: Round everything that is drawn (px).
MARGIN = 20.0
#: A wire is an S: the control points of a cubic lie at one and two thirds of the line between
#: its ends, aside by this share of its length, but at most by so much (px).
ASIDE, MOST_ASIDE = 0.2, 40.0

#: Where on its line the label of a cut or link may stand, the best place first.
SHARES = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8)

#: The base where the file does not say how it is drawn, as in a new model of MBSysPad.
BASE = Drawing(position=(-60.0, -28.0), size=(120.0, 56.0))

STYLE = """
.mbs text { font: 12px "DejaVu Sans", Verdana, Arial, sans-serif; fill: #333; text-anchor: middle }
.mbs .label { paint-order: stroke; stroke: #fff; stroke-width: 3px }
.mbs .box { fill: #ffffe8; stroke: #ee82ee }
.mbs .body-name > text { font-weight: bold; stroke: #ffffe8 }
.mbs .base > text { stroke: #b0b0b0 }
.mbs .base > .box { fill: #b0b0b0 }
.mbs .wire { fill: none; stroke: #00f }
.mbs .arrow { fill: none; stroke: #800040 }
.mbs .joint > circle { fill: #00f; stroke: #ffc800; stroke-width: 2px }
.mbs .point > circle { fill: #0ff; stroke: #ffc800; stroke-width: 2px }
.mbs .base > circle { fill: #808080; stroke: #000; stroke-width: 3px }
.mbs .cut, .mbs .link { fill: none; stroke-width: 1.5px }
.mbs .cut { stroke: #d00000; stroke-dasharray: 6 3 }
.mbs .link { stroke: #008000; stroke-dasharray: 2 2 }
.mbs .mark { font-size: 9px; fill: #800080; text-anchor: start }
""".strip()


def draw(mbs: Mbs) -> str:
    """The diagram as one SVG document.

    Raises ConversionError for a model without the positions that a diagram needs.
    """
    picture = _Picture(mbs)
    x0, y0, x1, y1 = picture.extent()
    x0, y0 = min(x0 - MARGIN, 0.0), min(y0 - MARGIN, 0.0)
    width, height = x1 + MARGIN - x0, y1 + MARGIN - y0
    box = f"{_n(x0)} {_n(y0)} {_n(width)} {_n(height)}"
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" class="mbs" width="{_n(width)}"'
            f' height="{_n(height)}" viewBox="{box}">',
            f"<title>{_t(mbs.name)}</title>",
            f"<style>{STYLE}</style>",
            f'<rect class="sheet" x="{_n(x0)}" y="{_n(y0)}" width="{_n(width)}"'
            f' height="{_n(height)}" fill="#fff"/>',
            *picture.boxes(),
            *picture.arrows(),
            *picture.names(),
            *picture.wires(),
            *picture.connections(),
            *picture.dots(),
            "</svg>\n",
        ]
    )


class _Picture:
    """Where everything is in the diagram, in pixels from its upper left."""

    def __init__(self, mbs: Mbs) -> None:
        self.mbs = mbs
        self.numbers = mbs.numbers()
        _require_drawings(mbs)
        self.frames: dict[str | None, XY] = {None: _at(mbs.base.position)}
        self.points: dict[tuple[str | None, str], XY] = {}
        for body in mbs.bodies:
            self.frames[body.name] = _at(body.joints[-1].position)
        for name, owner in self.mbs.owners():
            for point in owner.points:
                own_frame = point.name == ORIGIN and point.position is None
                at = self.frames[name] if own_frame else _at(point.position)
                self.points[name, point.name] = at

    def _place(self, body: str | None, point: str | None) -> XY:
        return self.frames[body] if point is None else self.points[body, point]

    def extent(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom."""
        corners = [
            (x + dx, y + dy) for x, y in self.frames.values() for dx in (-8, 8) for dy in (-8, 8)
        ]
        corners += [(x + dx, y) for x, y in self.points.values() for dx in (-8, 8)]
        corners += [_at(joint.position) for body in self.mbs.bodies for joint in body.joints]
        for name, drawing in self._drawings():
            left, top, right, bottom = self._box(name, drawing)
            corners += [(left, top), (right, bottom)]
        xs, ys = zip(*corners, strict=True)
        return min(xs), min(ys), max(xs), max(ys)

    def _drawings(self) -> Iterator[tuple[str | None, Drawing]]:
        yield None, self.mbs.base.drawing or BASE
        for body in self.mbs.bodies:
            if body.drawing is not None:
                yield body.name, body.drawing

    def _box(self, name: str | None, drawing: Drawing) -> Box:
        x, y = self.frames[name]
        (left, top), (width, height) = _bounds(drawing)
        return (x + left, y + top, x + left + width, y + top + height)

    def _name_at(self, name: str | None, drawing: Drawing) -> XY:
        left, top, right, bottom = self._box(name, drawing)
        dx, dy = drawing.name_pos
        return ((left + right) / 2 + dx, (top + bottom) / 2 - 6 + dy)

    def boxes(self) -> Iterator[str]:
        bodies = {body.name: body for body in self.mbs.bodies}
        for name, drawing in self._drawings():
            x, y = self.frames[name]
            left, top, right, bottom = self._box(name, drawing)
            width, height = right - left, bottom - top
            if drawing.shape in ("circle", "ellipse"):
                cx, cy, rx, ry = left + width / 2, top + height / 2, width / 2, height / 2
                shape = (
                    f'<ellipse class="box" cx="{_n(cx)}" cy="{_n(cy)}" rx="{_n(rx)}"'
                    f' ry="{_n(ry)}"/>'
                )
            elif drawing.shape == "polyline" and drawing.control_points:
                corners = " ".join(_p(x + dx, y + dy) for dx, dy in drawing.control_points)
                shape = f'<polygon class="box" points="{corners}"/>'
            else:
                shape = (
                    f'<rect class="box" x="{_n(left)}" y="{_n(top)}" width="{_n(width)}"'
                    f' height="{_n(height)}"/>'
                )
            if name is None:
                kind, about = "body base", f"{self.mbs.base.name}: the base"
            else:
                kind, about = "body", _about_body(bodies[name])
            dot = f'<circle cx="{_n(x)}" cy="{_n(y)}" r="6"/>' if name is None else ""
            yield (
                f'<g class="{kind}" data-body="{_t(name or "")}"><title>{_t(about)}</title>{shape}'
                f"{dot}</g>"
            )

    def names(self) -> Iterator[str]:
        """The names of the bodies, above the arrows that cross them."""
        for name, drawing in self._drawings():
            kind = "body-name base" if name is None else "body-name"
            words = _text("Base" if name is None else name, self._name_at(name, drawing), "label")
            yield f'<g class="{kind}" data-body="{_t(name or "")}">{words}</g>'

    def arrows(self) -> Iterator[str]:
        """From a body's frame to each of its points."""
        for name, owner in self.mbs.owners():
            for point in owner.points:
                (ax, ay), (bx, by) = self.frames[name], self.points[name, point.name]
                length = hypot(bx - ax, by - ay)
                if length < 12:
                    continue  # the dots touch
                ux, uy = (bx - ax) / length, (by - ay) / length
                bx, by = bx - 5 * ux, by - 5 * uy
                wings = [
                    (bx - 10 * ux + s * 4.5 * uy, by - 10 * uy - s * 4.5 * ux) for s in (1, -1)
                ]
                yield (
                    f'<path class="arrow" d="M{_p(ax, ay)} L{_p(bx, by)} M{_p(*wings[0])}'
                    f' L{_p(bx, by)} L{_p(*wings[1])}"/>'
                )

    def wires(self) -> Iterator[str]:
        """From the parent's point through the joints of each body, labelled at the middle."""
        for body in self.mbs.bodies:
            before = self._place(body.parent, body.point)
            for joint in body.joints:
                after = _at(joint.position)
                (ax, ay), (bx, by) = before, after
                x, y = (ax + bx) / 2, (ay + by) / 2
                number = self.numbers[joint.name]
                yield (
                    f'<g class="joint-label {joint.nature}" data-joint="{_t(joint.name)}"><title>'
                    f"{_t(_about_joint(joint, number))}</title>"
                    f'<path class="wire" d="M{_p(ax, ay)} {_curve(before, after)}"/>'
                    + _text(joint.type, (x, y - 3), "label")
                    + _text(f"q{number}", (x, y + 12), "label")
                    + "</g>"
                )
                before = after

    def connections(self) -> Iterator[str]:
        """The cuts, then the links; labels stand clear of other words."""
        taken = self._words()
        for connection in (*self.mbs.cuts, *self.mbs.links):
            if connection.is_draft:
                continue
            kind = "cut" if connection.kind in CUTS else "link"
            (ax, ay), (bx, by) = (
                self._place(*end) for end in (connection.endpoint1, connection.endpoint2)
            )
            half = 3.5 * max(len(connection.name), len(connection.kind)) + 2
            spots = [(ax + share * (bx - ax), ay + share * (by - ay)) for share in SHARES]
            labels = [(x - half, y - 14, x + half, y + 16) for x, y in spots]
            crowd = [sum(_overlap(label, word) for word in taken) for label in labels]
            best = crowd.index(min(crowd))
            taken.append(labels[best])
            x, y = spots[best]
            about = _about_connection(connection)
            yield (
                f'<g class="connection" data-name="{_t(connection.name)}">'
                f'<title>{_t(about)}</title><path class="{kind}"'
                f' d="M{_p(ax, ay)} L{_p(bx, by)}"/>'
                + _text(connection.kind, (x, y - 3), "label")
                + _text(connection.name, (x, y + 12), "label")
                + "</g>"
            )

    def _words(self) -> list[Box]:
        """Where words and dots stand: of joints, points and bodies."""
        boxes = [
            (x - 8, y - 8, x + 8, y + 8) for x, y in (*self.frames.values(), *self.points.values())
        ]
        for body in self.mbs.bodies:
            before = self._place(body.parent, body.point)
            for after in (_at(joint.position) for joint in body.joints):
                x, y = (before[0] + after[0]) / 2, (before[1] + after[1]) / 2
                boxes.append((x - 14, y - 14, x + 14, y + 16))
                before = after
        for name, drawing in self._drawings():
            x, y = self._name_at(name, drawing)
            half = 4.5 * len(name or "Base")
            boxes.append((x - half, y - 12, x + half, y + 4))
        return boxes

    def dots(self) -> Iterator[str]:
        for name, owner in self.mbs.owners():
            for point in owner.points:
                x, y = self.points[name, point.name]
                letters = [
                    letter
                    for letter, found in (("S", point.sensor), ("F", point.extforce))
                    if found is not None
                ]
                marks = "".join(
                    _text(letter, (x + 7 + 7 * k, y + 3), "mark")
                    for k, letter in enumerate(letters)
                )
                yield (
                    f'<g class="point" data-body="{_t(name or "")}" data-point="{_t(point.name)}">'
                    f"<title>{_t(_about_point(point))}</title>"
                    f'<circle cx="{_n(x)}" cy="{_n(y)}" r="5"/>{marks}</g>'
                )
        for body in self.mbs.bodies:
            for joint in body.joints:
                x, y = _at(joint.position)
                about = _about_joint(joint, self.numbers[joint.name])
                yield (
                    f'<g class="joint {joint.nature}" data-joint="{_t(joint.name)}">'
                    f'<title>{_t(about)}</title><circle cx="{_n(x)}" cy="{_n(y)}" r="5"/></g>'
                )


def _require_drawings(mbs: Mbs) -> None:
    missing = [] if mbs.base.position or not mbs.bodies else ["the base"]
    missing += [f"point '{point.name}'" for point in mbs.base.points if point.position is None]
    for body in mbs.bodies:
        if body.drawing is None:
            missing.append(f"body '{body.name}'")
        missing += [f"joint '{joint.name}'" for joint in body.joints if joint.position is None]
        missing += [
            f"point '{point.name}'"
            for point in body.points
            if point.position is None and point.name != ORIGIN
        ]
    if missing:
        more = f" and {len(missing) - 3} more" if len(missing) > 3 else ""
        raise ConversionError(
            "no-drawing",
            f"model '{mbs.name}' does not say where in the diagram {', '.join(missing[:3])}{more} "
            f"{'is' if len(missing) == 1 else 'are'}",
            hint="give them graphics/x2D: convert the robot with the pass 'layout', or draw and "
            "save the model in MBSysPad",
        )


def _at(position: XY | None) -> XY:
    return position or (0.0, 0.0)


def _bounds(drawing: Drawing) -> tuple[XY, XY]:
    """Upper left corner and full size of a box, relative to its body's last joint."""
    (x, y), (width, height) = drawing.position, drawing.size
    if drawing.shape == "circle":
        height = width  # both are the radius
    if drawing.shape in ("circle", "ellipse"):
        return (x - width, y - height), (2 * width, 2 * height)
    return (x, y), (width, height)


def _overlap(one: Box, another: Box) -> float:
    """The area that two boxes share."""
    width = min(one[2], another[2]) - max(one[0], another[0])
    height = min(one[3], another[3]) - max(one[1], another[1])
    return max(width, 0.0) * max(height, 0.0)


def _curve(a: XY, b: XY) -> str:
    """The way from a to b as MBSysPad draws it, to the left first."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = hypot(dx, dy)
    if length == 0.0:
        return f"L{_p(*b)}"
    aside = min(ASIDE * length, MOST_ASIDE) / length
    one = (a[0] + dx / 3 + aside * dy, a[1] + dy / 3 - aside * dx)
    two = (b[0] - dx / 3 - aside * dy, b[1] - dy / 3 + aside * dx)
    return f"C{_p(*one)} {_p(*two)} {_p(*b)}"


def _about_body(body: Body) -> str:
    lines = [body.name]
    if body.mass is not None:
        lines.append(f"mass {body.mass:.6g} kg")
    if body.com is not None:
        lines.append(f"com ({', '.join(f'{c:.6g}' for c in body.com)}) m")
    return "\n".join(lines)


def _about_joint(joint: Joint, number: int) -> str:
    unit = "rad" if joint.type.startswith("R") else "m"
    start = "" if joint.q is None else f", q = {joint.q:.6g} {unit}"
    return f"{joint.name}\n{joint.type}, q{number}, {joint.nature}{start}"


def _about_point(point: Point) -> str:
    lines = [point.name, f"({', '.join(f'{c:.6g}' for c in point.coordinates)}) m"]
    if point.sensor is not None:
        lines.append(f"sensor {point.sensor.name}")
    if point.extforce is not None:
        lines.append(f"external force {point.extforce.name}")
    return "\n".join(lines)


def _about_connection(connection: Connection) -> str:
    length = "" if connection.length is None else f", length {connection.length:.6g} m"
    return f"{connection.name}\n{connection.kind}{length}"


def _text(text: str, at: XY, kind: str) -> str:
    return f'<text class="{kind}" x="{_n(at[0])}" y="{_n(at[1])}">{_t(text)}</text>'


def _n(value: float) -> str:
    return f"{round(value, 2) + 0.0:.10g}"


def _p(x: float, y: float) -> str:
    return f"{_n(x)},{_n(y)}"
