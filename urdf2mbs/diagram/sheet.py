"""Move layouts to their places on the sheet, and write them into the model.

On the sheet, x counts to the right and y down (px), as MBSysPad does.
"""

from __future__ import annotations

from typing import NamedTuple

import msgspec

from urdf2mbs.diagram.box_layout import Direction, Layout, PlacedChild
from urdf2mbs.diagram.nodes import Node
from urdf2mbs.diagram.sizes import SHEET_MARGIN
from urdf2mbs.mbs.model import XY, Drawing, Mbs


class SheetFrame(NamedTuple):
    """The frame of a layout on the sheet."""

    x: float
    """Of its origin (px)."""
    y: float
    """Of its origin (px)."""
    along_x: float
    """The direction of ``along``; its components are 0, 1 or -1."""
    along_y: float
    across_x: float
    """The direction of ``across``."""
    across_y: float

    def transform(self, along: float, across: float) -> XY:
        """Return a position of the layout on the sheet."""
        x = self.x + self.along_x * along + self.across_x * across
        y = self.y + self.along_y * along + self.across_y * across
        return x, y

    def place_child(self, child: PlacedChild) -> SheetFrame:
        """Return the frame of a child's layout."""
        along_x, along_y, across_x, across_y = self[2:]
        x, y = self.transform(child.along, child.across)
        mirror, direction = child.mirror, child.direction
        if direction == Direction.AHEAD:
            return SheetFrame(x, y, along_x, along_y, across_x * mirror, across_y * mirror)
        if direction == Direction.BACK:
            return SheetFrame(x, y, -along_x, -along_y, across_x * mirror, across_y * mirror)
        return SheetFrame(
            x,
            y,
            across_x * direction,
            across_y * direction,
            along_x * mirror,
            along_y * mirror,
        )


GROWS_DOWN = SheetFrame(0.0, 0.0, along_x=0.0, along_y=1.0, across_x=1.0, across_y=0.0)
GROWS_UP = SheetFrame(0.0, 0.0, along_x=0.0, along_y=-1.0, across_x=1.0, across_y=0.0)


class SheetBox(NamedTuple):
    """The edges of a box on the sheet (px)."""

    left: float
    top: float
    right: float
    bottom: float


class PlacedLayout(msgspec.Struct):
    """The layout of a body, and its frame and box on the sheet."""

    node: Node
    layout: Layout
    frame: SheetFrame
    box: SheetBox


def place_on_sheet(mbs: Mbs, base: Node, layout: Layout, frame: SheetFrame) -> None:
    """Place all bodies on the sheet, its upper left corner at the margin.

    Args:
        mbs: The model; its bodies, joints and points get their positions.
        base: The node of the base.
        layout: Its layout.
        frame: The frame of this layout; only its directions count.
    """
    placed_layouts = _place_layouts(base, layout, frame)
    # Each joint is between two boxes, so boxes bound the sheet.
    left = min(0.0, *(placed.box.left for placed in placed_layouts))
    top = min(0.0, *(placed.box.top for placed in placed_layouts))
    shift_x, shift_y = round(SHEET_MARGIN - left, 0), round(SHEET_MARGIN - top, 0)
    for placed in placed_layouts:
        _write_positions(mbs, placed, shift_x, shift_y)


def _place_layouts(base: Node, layout: Layout, frame: SheetFrame) -> list[PlacedLayout]:
    """Compute the frame and the box of each body on the sheet."""
    stack = [(base, layout, frame)]
    placed_layouts: list[PlacedLayout] = []
    while stack:
        node, layout, frame = stack.pop()
        x0, y0 = frame.transform(layout.box.along_min, layout.box.across_min)
        x1, y1 = frame.transform(layout.box.along_max, layout.box.across_max)
        box = SheetBox(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))
        placed_layouts.append(PlacedLayout(node, layout, frame, box))
        stack.extend(
            (child.node, child.layout, frame.place_child(child)) for child in layout.children
        )
    return placed_layouts


def _write_positions(mbs: Mbs, placed: PlacedLayout, shift_x: float, shift_y: float) -> None:
    """Write where a body, its joints and its points are into the model."""
    node, layout = placed.node, placed.layout
    frame = placed.frame._replace(x=placed.frame.x + shift_x, y=placed.frame.y + shift_y)
    x, y = _round(frame.transform(layout.origin, 0.0))
    left, top, right, bottom = placed.box
    drawing = _draw_box(
        SheetBox(
            round(round(left + shift_x, 1) - x, 1),
            round(round(top + shift_y, 1) - y, 1),
            round(round(right + shift_x, 1) - x, 1),
            round(round(bottom + shift_y, 1) - y, 1),
        )
    )
    if node.body is None:
        mbs.base.position, mbs.base.drawing = (x, y), drawing
    else:
        node.body.drawing = drawing
        for joint, position in zip(node.joints, layout.joints, strict=True):
            joint.position = _round(frame.transform(*position))
    for point, along, across in layout.points:
        point.position = _round(frame.transform(along, across))


def _round(position: XY) -> XY:
    """Round a position to 0.1 px."""
    return (round(position[0], 1), round(position[1], 1))


def _draw_box(box: SheetBox) -> Drawing:
    """Return a rectangle, its edges relative to the body's last joint."""
    left, top, right, bottom = box
    return Drawing(
        position=(left, top),
        size=(round(right - left, 1), round(bottom - top, 1)),
        control_points=((right, top), (right, bottom), (left, bottom), (left, top)),
    )
