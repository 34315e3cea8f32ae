"""The 2D diagram of an .mbs file as an SVG picture, drawn as MBSysPad draws it.

Boxes, dots, arrows, wires and labels stand where the file puts them (pixels, y down).  What
MBSysPad leaves to a click is in the tooltips: joint and point names, nature, coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape as _t
from math import hypot

from urdf2mbs.plugin import CUTS, ORIGIN, XY, Body, Connection, ConversionError, Drawing, Mbs, Point
from urdf2mbs.plugin import MbsJoint as Joint

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
        self.drawings: dict[str | None, Drawing] = {None: mbs.base.drawing or BASE}
        for body in mbs.bodies:
            assert body.drawing is not None
            self.frames[body.name] = _at(body.joints[-1].position)
            self.drawings[body.name] = body.drawing
        self.places: dict[str | None, Box] = {}
        """The boxes."""
        for name, drawing in self.drawings.items():
            x, y = self.frames[name]
            (left, top), (width, height) = _bounds(drawing)
            self.places[name] = (x + left, y + top, x + left + width, y + top + height)
        self.points: dict[tuple[str | None, str], XY] = {}
        for name, owner in self.mbs.base_and_bodies():
            for point in owner.points:
                own_frame = point.name == ORIGIN and point.position is None
                at = self.frames[name] if own_frame else _at(point.position)
                self.points[name, point.name] = at
        dots = (*self.frames.values(), *self.points.values())
        self.taken: list[Box] = [(x - 8, y - 8, x + 8, y + 8) for x, y in dots]
        """Where dots are, and the words that are written so far."""

    def _place(self, body: str | None, point: str | None) -> XY:
        return self.frames[body] if point is None else self.points[body, point]

    def extent(self) -> Box:
        corners = [
            (x + dx, y + dy) for x, y in self.frames.values() for dx in (-8, 8) for dy in (-8, 8)
        ]
        corners += [(x + dx, y) for x, y in self.points.values() for dx in (-8, 8)]
        corners += [_at(joint.position) for body in self.mbs.bodies for joint in body.joints]
        for left, top, right, bottom in self.places.values():
            corners += [(left, top), (right, bottom)]
        xs, ys = zip(*corners, strict=True)
        return min(xs), min(ys), max(xs), max(ys)

    def boxes(self) -> Iterator[str]:
        x, y = self.frames[None]
        about = f"{self.mbs.base.name}: the base"
        dot = _tag("circle", cx=x, cy=y, r=6)
        yield _tag("g", "body base", _title(about) + self._box(None) + dot, data_body="")
        for body in self.mbs.bodies:
            box = self._box(body.name)
            yield _tag("g", "body", _title(_about_body(body)) + box, data_body=body.name)

    def _box(self, name: str | None) -> str:
        drawing, (left, top, right, bottom) = self.drawings[name], self.places[name]
        width, height = right - left, bottom - top
        if drawing.shape in ("circle", "ellipse"):
            rx, ry = width / 2, height / 2
            return _tag("ellipse", "box", cx=left + rx, cy=top + ry, rx=rx, ry=ry)
        if drawing.shape == "polyline" and drawing.control_points:
            x, y = self.frames[name]
            corners = " ".join(_p(x + dx, y + dy) for dx, dy in drawing.control_points)
            return _tag("polygon", "box", points=corners)
        return _tag("rect", "box", x=left, y=top, width=width, height=height)

    def names(self) -> Iterator[str]:
        """The names of the bodies, above the arrows that cross them."""
        for name, (left, top, right, bottom) in self.places.items():
            kind = "body-name base" if name is None else "body-name"
            dx, dy = self.drawings[name].name_pos
            x, y = (left + right) / 2 + dx, (top + bottom) / 2 - 6 + dy
            half = 4.5 * len(name or "Base")
            self.taken.append((x - half, y - 12, x + half, y + 4))
            words = _text("Base" if name is None else name, (x, y), "label")
            yield _tag("g", kind, words, data_body=name or "")

    def arrows(self) -> Iterator[str]:
        """From a body's frame to each of its points."""
        for (name, _), (bx, by) in self.points.items():
            ax, ay = self.frames[name]
            length = hypot(bx - ax, by - ay)
            if length < 12:
                continue  # the dots touch
            ux, uy = (bx - ax) / length, (by - ay) / length
            tip = bx - 5 * ux, by - 5 * uy
            one, other = [
                (tip[0] - 10 * ux + s * 4.5 * uy, tip[1] - 10 * uy - s * 4.5 * ux) for s in (1, -1)
            ]
            head = f"M{_p(*one)} L{_p(*tip)} L{_p(*other)}"
            yield _tag("path", "arrow", d=f"M{_p(ax, ay)} L{_p(*tip)} {head}")

    def wires(self) -> Iterator[str]:
        """From the parent's point through the joints of each body, labelled at the middle."""
        for body in self.mbs.bodies:
            before = self._place(body.parent, body.point)
            for joint in body.joints:
                after, number = _at(joint.position), self.numbers[joint.name]
                inside = _title(_about_joint(joint, number))
                inside += _tag("path", "wire", d=f"M{_p(*before)} {_curve(before, after)}")
                middle = (before[0] + after[0]) / 2, (before[1] + after[1]) / 2
                inside += self._label(joint.type, f"q{number}", middle)
                yield _tag("g", f"joint-label {joint.nature}", inside, data_joint=joint.name)
                before = after

    def connections(self) -> Iterator[str]:
        """The cuts, then the links; labels keep off the words that are written before."""
        for connection in (*self.mbs.cuts, *self.mbs.links):
            if connection.is_draft:
                continue
            kind = "cut" if connection.kind in CUTS else "link"
            ax, ay = self._place(*connection.endpoint1)
            bx, by = self._place(*connection.endpoint2)
            spots = [(ax + share * (bx - ax), ay + share * (by - ay)) for share in SHARES]
            words = connection.kind, connection.name
            crowd = [
                sum(_overlap(_room(spot, *words), word) for word in self.taken) for spot in spots
            ]
            inside = _title(_about_connection(connection))
            inside += _tag("path", kind, d=f"M{_p(ax, ay)} L{_p(bx, by)}")
            inside += self._label(*words, spots[crowd.index(min(crowd))])
            yield _tag("g", "connection", inside, data_name=connection.name)

    def _label(self, above: str, below: str, at: XY) -> str:
        self.taken.append(_room(at, above, below))
        x, y = at
        return _text(above, (x, y - 3), "label") + _text(below, (x, y + 12), "label")

    def dots(self) -> Iterator[str]:
        for name, owner in self.mbs.base_and_bodies():
            for point in owner.points:
                x, y = self.points[name, point.name]
                inside = _title(_about_point(point)) + _tag("circle", cx=x, cy=y, r=5)
                letters = "S" * (point.sensor is not None) + "F" * (point.extforce is not None)
                for k, letter in enumerate(letters):
                    inside += _text(letter, (x + 7 + 7 * k, y + 3), "mark")
                yield _tag("g", "point", inside, data_body=name or "", data_point=point.name)
        for body in self.mbs.bodies:
            for joint in body.joints:
                x, y = _at(joint.position)
                inside = _title(_about_joint(joint, self.numbers[joint.name]))
                inside += _tag("circle", cx=x, cy=y, r=5)
                yield _tag("g", f"joint {joint.nature}", inside, data_joint=joint.name)


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


def _room(at: XY, *words: str) -> Box:
    """What a label of two words takes."""
    half = 3.5 * max(map(len, words)) + 2
    return at[0] - half, at[1] - 14, at[0] + half, at[1] + 16


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


def _tag(name: str, kind: str = "", inside: str = "", **attributes: str | float) -> str:
    """An element of a class; ``data_x`` is its attribute ``data-x``."""
    text = f'<{name} class="{kind}"' if kind else f"<{name}"
    for key, value in attributes.items():
        said = _t(value) if isinstance(value, str) else _n(value)
        text += f' {key.replace("_", "-")}="{said}"'
    return f"{text}>{inside}</{name}>" if inside else f"{text}/>"


def _title(text: str) -> str:
    return f"<title>{_t(text)}</title>"


def _text(text: str, at: XY, kind: str) -> str:
    return _tag("text", kind, _t(text), x=at[0], y=at[1])


def _n(value: float) -> str:
    return f"{round(value, 2) + 0.0:.10g}"


def _p(x: float, y: float) -> str:
    return f"{_n(x)},{_n(y)}"
