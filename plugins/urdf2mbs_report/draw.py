"""The 2D diagram of an .mbs file as an SVG picture, drawn as MBSysPad draws it.

Boxes, dots, arrows, wires and labels are where the file puts them (pixels, y down).  What
MBSysPad shows at a click is in the tooltips: names of joints and points, natures, coordinates::

    +----------+
    |   base   |               a box is a body, with its name
    |    o------>o  point      an arrow leads from the origin of its body to a point
    +------------ .
                    . R2       a wire is a joint, with its type and number
                      . q1
                        o      a dot is a joint; that of the last joint is the body's origin
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from math import hypot
from typing import NamedTuple

from urdf2mbs.plugin import (
    CUTS,
    ORIGIN,
    XY,
    Body,
    Connection,
    ConversionError,
    Drawing,
    Mbs,
    MbsJoint,
    Point,
    some,
)

#: Space around all that is drawn (px).
MARGIN = 20.0
#: Radius of the space that a dot takes (px).
DOT_SPACE = 8.0
#: A shorter arrow is not drawn, as the dots at its ends touch (px).
MIN_ARROW_LENGTH = 12.0

#: A wire is a cubic Bezier curve in the form of an S.  Its control points are at a third and two
#: thirds of the line between its ends, beside it by this share of its length ...
BEND_SHARE = 0.2
#: ... but by no more than this (px).
MAX_BEND = 40.0

#: Where on its line the label of a cut or link may be, the best place first.
LABEL_SHARES = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8)

#: The base where the file does not say how it is drawn, as in a new model of MBSysPad.
BASE_DRAWING = Drawing(position=(-60.0, -28.0), size=(120.0, 56.0))

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


class Box(NamedTuple):
    """A rectangle (px)."""

    left: float
    top: float
    right: float
    bottom: float

    @property
    def width(self) -> float:
        """Its size along x (px)."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """Its size along y (px)."""
        return self.bottom - self.top

    def compute_overlap(self, other_box: Box) -> float:
        """Compute the area that two boxes share (px^2)."""
        width = min(self.right, other_box.right) - max(self.left, other_box.left)
        height = min(self.bottom, other_box.bottom) - max(self.top, other_box.top)
        return max(width, 0.0) * max(height, 0.0)


def draw(mbs: Mbs) -> str:
    """Draw the diagram of a model as an SVG document.

    Raises:
        ConversionError: The model lacks the positions that a diagram needs.
    """
    _require_positions(mbs)
    diagram = _Diagram(mbs)
    extent = diagram.compute_extent()
    left, top = min(extent.left - MARGIN, 0.0), min(extent.top - MARGIN, 0.0)
    x, y = _format_number(left), _format_number(top)
    width = _format_number(extent.right + MARGIN - left)
    height = _format_number(extent.bottom + MARGIN - top)
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" class="mbs" width="{width}"'
            f' height="{height}" viewBox="{x} {y} {width} {height}">',
            f"<title>{escape(mbs.name)}</title>",
            f"<style>{STYLE}</style>",
            f'<rect class="sheet" x="{x}" y="{y}" width="{width}" height="{height}" fill="#fff"/>',
            *diagram.draw_boxes(),
            *diagram.draw_arrows(),
            *diagram.draw_body_names(),
            *diagram.draw_wires(),
            *diagram.draw_connections(),
            *diagram.draw_dots(),
            "</svg>\n",
        ]
    )


def _require_positions(mbs: Mbs) -> None:
    """Raise ConversionError if an element has no position in the diagram."""
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
        raise ConversionError(
            "no-drawing",
            f"model '{mbs.name}' does not say where in the diagram {some(missing, 3)} "
            f"{'is' if len(missing) == 1 else 'are'}",
            hint="give them graphics/x2D: convert the robot with the pass 'layout', or draw and "
            "save the model in MBSysPad",
        )


class _Diagram:
    """The positions of all elements of a diagram (px), and the labels that are drawn."""

    def __init__(self, mbs: Mbs) -> None:
        self.mbs = mbs
        self.numbers = mbs.numbers()
        self.origins: dict[str | None, XY] = {None: mbs.base.position or (0.0, 0.0)}
        """The dot of each body's origin; None is the base."""
        self.drawings: dict[str | None, Drawing] = {None: mbs.base.drawing or BASE_DRAWING}
        for body in mbs.bodies:
            assert body.drawing is not None  # by _require_positions
            self.origins[body.name] = body.joints[-1].position or (0.0, 0.0)
            self.drawings[body.name] = body.drawing
        self.boxes = {
            body_name: _compute_box(self.origins[body_name], drawing)
            for body_name, drawing in self.drawings.items()
        }
        self.points: dict[tuple[str | None, str], XY] = {}
        for body_name, owner in mbs.base_and_bodies():
            for point in owner.points:
                is_origin = point.name == ORIGIN and point.position is None
                position = self.origins[body_name] if is_origin else point.position or (0.0, 0.0)
                self.points[body_name, point.name] = position
        self.occupied = [
            Box(x - DOT_SPACE, y - DOT_SPACE, x + DOT_SPACE, y + DOT_SPACE)
            for x, y in (*self.origins.values(), *self.points.values())
        ]
        """The space of dots and of the labels that are drawn."""

    def _get_position(self, body: str | None, point: str | None) -> XY:
        """Return the position of a point of a body; None is the body's origin."""
        return self.origins[body] if point is None else self.points[body, point]

    def compute_extent(self) -> Box:
        """Compute the box around all dots and boxes."""
        corners = [
            (x + dx, y + dy)
            for x, y in self.origins.values()
            for dx in (-DOT_SPACE, DOT_SPACE)
            for dy in (-DOT_SPACE, DOT_SPACE)
        ]
        corners += [(x + dx, y) for x, y in self.points.values() for dx in (-DOT_SPACE, DOT_SPACE)]
        corners += [
            joint.position or (0.0, 0.0) for body in self.mbs.bodies for joint in body.joints
        ]
        for box in self.boxes.values():
            corners += [(box.left, box.top), (box.right, box.bottom)]
        x_positions, y_positions = zip(*corners, strict=True)
        return Box(min(x_positions), min(y_positions), max(x_positions), max(y_positions))

    def draw_boxes(self) -> Iterator[str]:
        """Draw the box of the base with its dot, then those of the bodies."""
        x, y = self.origins[None]
        base_dot = _make_tag("circle", cx=x, cy=y, r=6)
        title = _make_title(f"{self.mbs.base.name}: the base")
        yield _make_tag("g", "body base", title + self._draw_box(None) + base_dot, data_body="")
        for body in self.mbs.bodies:
            content = _make_title(_describe_body(body)) + self._draw_box(body.name)
            yield _make_tag("g", "body", content, data_body=body.name)

    def _draw_box(self, body_name: str | None) -> str:
        """Draw the box of a body in its shape."""
        drawing, box = self.drawings[body_name], self.boxes[body_name]
        if drawing.shape in ("circle", "ellipse"):
            rx, ry = box.width / 2, box.height / 2
            return _make_tag("ellipse", "box", cx=box.left + rx, cy=box.top + ry, rx=rx, ry=ry)
        if drawing.shape == "polyline" and drawing.control_points:
            x, y = self.origins[body_name]
            corners = " ".join(_format_point((x + dx, y + dy)) for dx, dy in drawing.control_points)
            return _make_tag("polygon", "box", points=corners)
        return _make_tag("rect", "box", x=box.left, y=box.top, width=box.width, height=box.height)

    def draw_arrows(self) -> Iterator[str]:
        """Draw an arrow from each body's origin to each of its points."""
        for (body_name, _), point in self.points.items():
            origin = self.origins[body_name]
            length = hypot(point[0] - origin[0], point[1] - origin[1])
            if length >= MIN_ARROW_LENGTH:
                yield _make_tag("path", "arrow", d=_make_arrow(origin, point, length))

    def draw_body_names(self) -> Iterator[str]:
        """Draw the names of the bodies, over the arrows that cross them."""
        for body_name, box in self.boxes.items():
            css_class = "body-name base" if body_name is None else "body-name"
            dx, dy = self.drawings[body_name].name_pos
            x, y = (box.left + box.right) / 2 + dx, (box.top + box.bottom) / 2 - 6 + dy
            half_width = 4.5 * len(body_name or "Base")
            self.occupied.append(Box(x - half_width, y - 12, x + half_width, y + 4))
            name_text = _make_text("Base" if body_name is None else body_name, (x, y), "label")
            yield _make_tag("g", css_class, name_text, data_body=body_name or "")

    def draw_wires(self) -> Iterator[str]:
        """Draw wires from the parent's point through the joints of each body."""
        for body in self.mbs.bodies:
            wire_start = self._get_position(body.parent, body.point)
            for joint in body.joints:
                wire_end, joint_number = joint.position or (0.0, 0.0), self.numbers[joint.name]
                middle = (wire_start[0] + wire_end[0]) / 2, (wire_start[1] + wire_end[1]) / 2
                wire_path = f"M{_format_point(wire_start)} {_make_curve(wire_start, wire_end)}"
                content = (
                    _make_title(_describe_joint(joint, joint_number))
                    + _make_tag("path", "wire", d=wire_path)
                    + self._draw_label(joint.type, f"q{joint_number}", middle)
                )
                css_class = f"joint-label {joint.nature}"
                yield _make_tag("g", css_class, content, data_joint=joint.name)
                wire_start = wire_end

    def draw_connections(self) -> Iterator[str]:
        """Draw the cuts, then the links, with labels where they overlap others least."""
        for connection in (*self.mbs.cuts, *self.mbs.links):
            if connection.is_draft:
                continue
            start = self._get_position(*connection.endpoint1)
            end = self._get_position(*connection.endpoint2)
            connection_kind, connection_name = connection.kind, connection.name
            line_path = f"M{_format_point(start)} L{_format_point(end)}"
            content = (
                _make_title(_describe_connection(connection))
                + _make_tag("path", "cut" if connection_kind in CUTS else "link", d=line_path)
                + self._draw_label(
                    connection_kind,
                    connection_name,
                    self._find_free_position(start, end, connection_kind, connection_name),
                )
            )
            yield _make_tag("g", "connection", content, data_name=connection_name)

    def _find_free_position(self, start: XY, end: XY, upper_text: str, lower_text: str) -> XY:
        """Find the position on a line where a label overlaps dots and other labels least."""

        def compute_overlap(position: XY) -> float:
            label_box = _compute_label_box(position, upper_text, lower_text)
            return sum(label_box.compute_overlap(occupied_box) for occupied_box in self.occupied)

        (x1, y1), (x2, y2) = start, end
        positions = [
            (x1 + label_share * (x2 - x1), y1 + label_share * (y2 - y1))
            for label_share in LABEL_SHARES
        ]
        return min(positions, key=compute_overlap)

    def _draw_label(self, upper_text: str, lower_text: str, position: XY) -> str:
        """Draw a label of two lines around a position."""
        self.occupied.append(_compute_label_box(position, upper_text, lower_text))
        x, y = position
        return _make_text(upper_text, (x, y - 3), "label") + _make_text(
            lower_text, (x, y + 12), "label"
        )

    def draw_dots(self) -> Iterator[str]:
        """Draw the dots of points, marked S for a sensor and F for a force, then of joints."""
        for body_name, owner in self.mbs.base_and_bodies():
            for point in owner.points:
                x, y = self.points[body_name, point.name]
                content = _make_title(_describe_point(point))
                content += _make_tag("circle", cx=x, cy=y, r=5)
                marks = "S" * (point.sensor is not None) + "F" * (point.extforce is not None)
                for index, letter in enumerate(marks):
                    content += _make_text(letter, (x + 7 + 7 * index, y + 3), "mark")
                yield _make_tag(
                    "g", "point", content, data_body=body_name or "", data_point=point.name
                )
        for body in self.mbs.bodies:
            for joint in body.joints:
                x, y = joint.position or (0.0, 0.0)
                content = _make_title(_describe_joint(joint, self.numbers[joint.name]))
                content += _make_tag("circle", cx=x, cy=y, r=5)
                yield _make_tag("g", f"joint {joint.nature}", content, data_joint=joint.name)


# --- geometry ---


def _compute_box(origin: XY, drawing: Drawing) -> Box:
    """Compute the box of a body from the position of its origin."""
    (x, y), (width, height) = drawing.position, drawing.size
    if drawing.shape == "circle":
        height = width  # both are the radius
    if drawing.shape in ("circle", "ellipse"):  # position is the centre, size the radii
        x, y = x - width, y - height
        width, height = 2 * width, 2 * height
    left, top = origin[0] + x, origin[1] + y
    return Box(left, top, left + width, top + height)


def _compute_label_box(position: XY, upper_text: str, lower_text: str) -> Box:
    """Estimate the space of a label of two lines around a position."""
    x, y = position
    half_width = 3.5 * max(len(upper_text), len(lower_text)) + 2
    return Box(x - half_width, y - 14, x + half_width, y + 16)


def _make_arrow(start: XY, end: XY, length: float) -> str:
    """Return the path of an arrow; its tip touches the dot at its end."""
    ux, uy = (end[0] - start[0]) / length, (end[1] - start[1]) / length
    arrow_tip = end[0] - 5 * ux, end[1] - 5 * uy
    left_barb, right_barb = [
        (arrow_tip[0] - 10 * ux + sign * 4.5 * uy, arrow_tip[1] - 10 * uy - sign * 4.5 * ux)
        for sign in (1, -1)
    ]
    head_path = (
        f"M{_format_point(left_barb)} L{_format_point(arrow_tip)} L{_format_point(right_barb)}"
    )
    return f"M{_format_point(start)} L{_format_point(arrow_tip)} {head_path}"


def _make_curve(start: XY, end: XY) -> str:
    """Return the curve of a wire as MBSysPad draws it, first to the left; see ``BEND_SHARE``."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = hypot(dx, dy)
    if length == 0.0:
        return f"L{_format_point(end)}"
    bend_ratio = min(BEND_SHARE * length, MAX_BEND) / length
    first_control = (start[0] + dx / 3 + bend_ratio * dy, start[1] + dy / 3 - bend_ratio * dx)
    second_control = (end[0] - dx / 3 - bend_ratio * dy, end[1] - dy / 3 + bend_ratio * dx)
    return f"C{_format_point(first_control)} {_format_point(second_control)} {_format_point(end)}"


# --- tooltips ---


def _describe_body(body: Body) -> str:
    """Return the tooltip of a body."""
    tooltip_lines = [body.name]
    if body.mass is not None:
        tooltip_lines.append(f"mass {body.mass:.6g} kg")
    if body.com is not None:
        tooltip_lines.append(f"com ({', '.join(f'{component:.6g}' for component in body.com)}) m")
    return "\n".join(tooltip_lines)


def _describe_joint(joint: MbsJoint, number: int) -> str:
    """Return the tooltip of a joint."""
    unit_name = "rad" if joint.type.startswith("R") else "m"
    initial_value = "" if joint.q is None else f", q = {joint.q:.6g} {unit_name}"
    return f"{joint.name}\n{joint.type}, q{number}, {joint.nature}{initial_value}"


def _describe_point(point: Point) -> str:
    """Return the tooltip of a point."""
    tooltip_lines = [
        point.name,
        f"({', '.join(f'{component:.6g}' for component in point.coordinates)}) m",
    ]
    if point.sensor is not None:
        tooltip_lines.append(f"sensor {point.sensor.name}")
    if point.extforce is not None:
        tooltip_lines.append(f"external force {point.extforce.name}")
    return "\n".join(tooltip_lines)


def _describe_connection(connection: Connection) -> str:
    """Return the tooltip of a cut or a link."""
    length_text = "" if connection.length is None else f", length {connection.length:.6g} m"
    return f"{connection.name}\n{connection.kind}{length_text}"


# --- SVG ---


def _make_tag(
    tag_name: str, css_class: str = "", content: str = "", **attributes: str | float
) -> str:
    """Return an SVG element; ``data_x`` is its attribute ``data-x``."""
    element_text = f'<{tag_name} class="{css_class}"' if css_class else f"<{tag_name}"
    for attribute_name, attribute_value in attributes.items():
        value_text = (
            escape(attribute_value)
            if isinstance(attribute_value, str)
            else _format_number(attribute_value)
        )
        element_text += f' {attribute_name.replace("_", "-")}="{value_text}"'
    return f"{element_text}>{content}</{tag_name}>" if content else f"{element_text}/>"


def _make_title(text: str) -> str:
    """Return a tooltip."""
    return f"<title>{escape(text)}</title>"


def _make_text(text: str, position: XY, css_class: str) -> str:
    """Return a text at a position."""
    return _make_tag("text", css_class, escape(text), x=position[0], y=position[1])


def _format_number(pixels: float) -> str:
    """Return a number of pixels with two decimals."""
    return f"{round(pixels, 2) + 0.0:.10g}"


def _format_point(point: XY) -> str:
    """Return a position for a path."""
    return f"{_format_number(point[0])},{_format_number(point[1])}"
