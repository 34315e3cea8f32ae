"""Lay out a body with all its descendants, none in the way of another.

The layouts of the children are known, and only moved.  The box of the body grows until each child
is straight ahead of its port, so no wire is longer than a joint needs.  This is a body with two
children ahead and one at each side, in the frame of ``box_size``::

                    o port of the parent
                    |
                    o joint
                    |
               +----o--------------+  along_min
      child    |                   |
      <----o---o port     NAME     |
               |              port o---o---->  child
               |                   |
               +----o---------o----+  along_max
        across_min  |         |  across_max
                    o         o
                    |         |
                  child     child
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from math import ceil
from typing import NamedTuple

import msgspec

from urdf2mbs.diagram.box_size import LocalPosition, compute_min_box, place_points
from urdf2mbs.diagram.nodes import Node, Port
from urdf2mbs.diagram.sizes import (
    COLUMN_PITCH,
    CORNER_DISTANCE,
    FAN_SLOPE,
    FORK_LENGTH,
    HORIZONTAL_SPACING,
    LIMB_GAP,
    NAME_HEIGHT,
    VERTICAL_SPACING,
)
from urdf2mbs.mbs.model import Point


class Direction(IntEnum):
    """The direction in which a limb grows, relative to its parent's."""

    MINUS = -1
    """To the side of negative ``across``."""
    AHEAD = 0
    PLUS = 1
    """To the side of positive ``across``."""
    BACK = 2


class Rectangle(NamedTuple):
    """A rectangle in the frame of a layout (px)."""

    along_min: float
    along_max: float
    across_min: float
    across_max: float


class PlacedPoint(NamedTuple):
    """A point of a body, in the frame of the body's layout (px)."""

    point: Point
    along: float
    across: float


class PlacedChild(NamedTuple):
    """A child, and where its layout begins in the frame of its parent's layout (px)."""

    node: Node
    layout: Layout
    along: float
    across: float
    direction: Direction
    mirror: int = 1
    """-1 if the child is drawn mirrored."""


class Layout(msgspec.Struct):
    """A body and all its descendants, in a frame of its own (px); see ``box_size``."""

    vertical: bool
    """True if the limb grows up or down, False if to the left or right."""
    joints: list[LocalPosition]
    origin: float
    """``along`` of the body's frame: of its last joint, or of the symbol of the base."""
    box: Rectangle
    points: list[PlacedPoint]
    children: list[PlacedChild]
    extent: Rectangle
    """Of the whole layout, from the port of the parent on."""


class PortSides(NamedTuple):
    """The ports of a body by the edge of its box on which they are."""

    ahead: Sequence[Port] = ()
    minus: Sequence[Port] = ()
    plus: Sequence[Port] = ()


class LayoutRequest(msgspec.Struct):
    """What the surroundings of a body require of its layout (px)."""

    extra_wire: float = 0.0
    """Added to each wire of the chain."""
    min_length: float = 0.0
    """Of the box, along the chain."""
    inset: float = 0.0
    """Distance of the last joint from the edge of the box where the chain enters."""
    min_offset: float = 0.0
    """Of the middle of the box from the chain."""
    centre_lone_child: bool = False
    """A lone child at a side is at the middle, even if it then is beside the wire, too."""


NO_REQUEST = LayoutRequest()


def lay_out_box(
    node: Node, sides: PortSides, request: LayoutRequest = NO_REQUEST, *, vertical: bool
) -> Layout:
    """Lay out a body with all its descendants.

    Args:
        node: The body; its children have their layouts.
        sides: Which children are ahead, and which at the sides.
        request: What the surroundings require.
        vertical: True if the limb grows up or down.
    """
    has_child_at_origin = any(port.point is None for port in sides.ahead)
    several_fork = FORK_LENGTH if len(sides.ahead) > 1 else None
    fork = 0.0 if has_child_at_origin else several_fork
    min_box = compute_min_box(node, fork, vertical=vertical)
    draft = _Draft(
        node=node,
        vertical=vertical,
        request=request,
        fork=fork,
        length=max(min_box.length, request.min_length),
        margin=min_box.margin,
        offset=max(min_box.offset, request.min_offset),
        # The name keeps off children at one side only.
        name_side=Direction.MINUS if sides.plus and not sides.minus else Direction.PLUS,
    )
    draft.place_chain()
    draft.place_free_points()
    front = _place_side_by_side(sides.ahead, vertical=vertical)
    chain_lane = draft.find_chain_lane(front)
    draft.widen_for_front(front, chain_lane)
    draft.place_at_sides(
        [
            SideRow(direction, _place_side_by_side(ports, vertical=not vertical))
            for direction, ports in ((Direction.MINUS, sides.minus), (Direction.PLUS, sides.plus))
            if ports
        ]
    )
    draft.place_ahead(front, chain_lane)
    return draft.finish()


# --- limbs side by side ---


class ChildLane(NamedTuple):
    """A child among others side by side."""

    node: Node
    layout: Layout
    position: float
    """Of its chain, counted from where the first limb begins (px)."""


class PortLane(NamedTuple):
    """A port, and the lanes of its children."""

    point: Point | None
    position: float
    """Of the port, counted from where the first limb begins (px)."""
    fan: float
    """How far ahead of the port the layouts of its children begin (px)."""
    children: list[ChildLane]


class Row(NamedTuple):
    """Ports with their limbs side by side."""

    ports: list[PortLane]
    width: float
    """Of all limbs (px)."""


class SideRow(NamedTuple):
    """A row at a side of a box."""

    direction: Direction
    row: Row


def _place_side_by_side(ports: Sequence[Port], *, vertical: bool) -> Row:
    """Place limbs side by side.

    Args:
        ports: The ports, in order.
        vertical: True if the limbs grow up or down.
    """
    lanes: list[PortLane] = []
    edge = 0.0
    for port in ports:
        children = []
        for child in port.children:
            layout = child.layouts[vertical]
            extent = layout.extent
            children.append(ChildLane(child, layout, edge - extent.across_min))
            edge += extent.across_max - extent.across_min + LIMB_GAP
        position, fan = children[0].position, 0.0
        if len(children) > 1:
            # Wires from one port fan out until they keep off each other.
            first, last = position, children[-1].position
            position = float(round((first + last) / 2))
            fan = float(ceil(FAN_SLOPE * max(position - first, last - position)))
        lanes.append(PortLane(port.point, position, fan, children))
    return Row(lanes, max(edge - LIMB_GAP, 0.0))


# --- one body ---


class _Draft(msgspec.Struct):
    """A layout in the making: ``lay_out_box`` calls the methods in order."""

    node: Node
    vertical: bool
    request: LayoutRequest
    fork: float | None
    """Distance of the last joint from the edge with the ports, if there are several."""
    length: float
    """Of the box; at least this."""
    margin: float
    """How far the box extends beyond the chain, at the side without the name; at least this."""
    offset: float
    """From the chain to the middle of the box; at least this."""
    name_side: Direction
    """The side of the chain at which the name is."""
    joints: list[LocalPosition] = []
    origin: float = 0.0
    points: list[PlacedPoint] = []
    children: list[PlacedChild] = []
    # The box.
    along_min: float = 0.0
    along_max: float = 0.0
    across_min: float = 0.0
    across_max: float = 0.0
    # The extent of all.
    extent_along_max: float = 0.0
    extent_across_min: float = 0.0
    extent_across_max: float = 0.0

    def place_chain(self) -> None:
        """Place the joints, and the box along the chain."""
        inset = self.request.inset if self.fork is None else self.length - self.fork
        self.origin = inset
        if self.node.joints:
            self._place_joints(inset)
        self.along_min = self.origin - inset
        self.along_max = self.along_min + self.length
        self.extent_along_max = self.along_max

    def _place_joints(self, inset: float) -> None:
        """Place the joints so that the chain is as long as that of the twin, if it can be.

        A chain that would be stretched too much makes the box longer instead.
        """
        is_folded = self.vertical and self.fork is None
        cells = _fold_chain(len(self.node.joints), is_folded=is_folded)
        rows, extra = cells[-1].row, self.request.extra_wire
        spacing = VERTICAL_SPACING if self.vertical else HORIZONTAL_SPACING
        first, pitch = spacing.first + extra, spacing.pitch + extra
        natural_end = first + pitch * (rows - 1)
        end = natural_end
        twin = self.node.twin
        if twin is not None and twin.joints:
            twin_rows = _fold_chain(len(twin.joints), is_folded=is_folded)[-1].row
            end = max(end, first + pitch * (twin_rows - 1))
        max_end = rows * (spacing.max_pitch + extra)
        if self.fork is not None:
            end = max(end, inset + VERTICAL_SPACING.first)
        elif end > max_end:
            self.length += end - max_end
            end = max_end
        if end > natural_end:
            pitch = end // rows
            first = end - pitch * (rows - 1)
        self.origin = end
        self.joints = [
            LocalPosition(
                first + pitch * (cell.row - 1), self.name_side * COLUMN_PITCH * cell.column
            )
            for cell in cells
        ]

    def place_free_points(self) -> None:
        """Place the points without children inside the box."""
        positions = place_points(self.node, self.fork, vertical=self.vertical)
        self.points = [
            PlacedPoint(point, self.origin + position.along, self.name_side * position.across)
            for point, position in zip(self.node.free_points, positions, strict=False)
        ]

    def find_chain_lane(self, front: Row) -> float:
        """Find where the chain is among the limbs ahead of the box.

        Args:
            front: The limbs ahead.

        Returns:
            A position as of ``PortLane``.
        """
        if not front.ports:
            return 0.0
        at_origin = [port.position for port in front.ports if port.point is None]
        if at_origin:
            return at_origin[0]
        first, last = front.ports[0].position, front.ports[-1].position
        # Several ports are centred at the middle of the box, a single one is ahead of the chain.
        return first if self.fork is None else (first + last) / 2 - self.offset

    def widen_for_front(self, front: Row, chain_lane: float) -> None:
        """Compute how wide the box and the limbs ahead of it are.

        Args:
            front: The limbs ahead.
            chain_lane: Where the chain is among them.
        """
        across_min, across_max = -self.margin, self.margin + 2 * self.offset
        if front.ports:
            first, last = front.ports[0].position, front.ports[-1].position
            across_min = min(across_min, first - chain_lane - CORNER_DISTANCE)
            across_max = max(
                across_max, last - chain_lane + CORNER_DISTANCE, 2 * self.offset - across_min
            )
        if self.name_side == Direction.MINUS:
            across_min, across_max = -across_max, -across_min
        self.across_min, self.across_max = across_min, across_max
        second_column = [
            joint.across + self.name_side * CORNER_DISTANCE for joint in self.joints if joint.across
        ]
        self.extent_across_min = min(across_min, -chain_lane, *second_column)
        self.extent_across_max = max(across_max, front.width - chain_lane, *second_column)

    def place_at_sides(self, side_rows: list[SideRow]) -> None:
        """Place the limbs at the sides, and make the box long enough for them."""
        is_centred = self.request.centre_lone_child
        for direction, row in side_rows:
            last = row.ports[-1].position + _compute_shift(row)
            if is_centred and len(row.ports) == 1:
                last = CORNER_DISTANCE
            if direction == self.name_side:
                # The name, which is between the chain and the ports, is farther ahead than they.
                half_name = NAME_HEIGHT if self.vertical else self.node.half_name_width
                self.along_max = max(self.along_max, self.along_min + 2 * (last + half_name))
            self.along_max = max(self.along_max, self.along_min + last + CORNER_DISTANCE)
        for direction, row in side_rows:
            begin = self.along_min + _compute_shift(row)
            if is_centred and len(row.ports) == 1:
                begin = (self.along_min + self.along_max) / 2 - row.ports[0].position
            for port in row.ports:
                self._place_at_side(port, begin, direction)

    def _place_at_side(self, port: PortLane, begin: float, direction: Direction) -> None:
        """Place a port at a side of the box, and its limbs.

        Args:
            port: The port.
            begin: Where the row of limbs at this side begins.
            direction: The side.
        """
        edge = self.across_min if direction < 0 else self.across_max
        if port.point is not None:
            self.points.append(PlacedPoint(port.point, port.position + begin, edge))
        for node, layout, position in port.children:
            across = edge + direction * port.fan
            self.children.append(PlacedChild(node, layout, position + begin, across, direction))
            tip = edge + direction * (port.fan + layout.extent.along_max)
            self.extent_across_min = min(self.extent_across_min, tip)
            self.extent_across_max = max(self.extent_across_max, tip)
            end = position + begin + layout.extent.across_max
            self.extent_along_max = max(self.extent_along_max, end)

    def place_ahead(self, front: Row, chain_lane: float) -> None:
        """Place the limbs ahead of the box."""
        self.extent_along_max = max(self.extent_along_max, self.along_max)
        for port in front.ports:
            if port.point is not None:
                across = port.position - chain_lane
                self.points.append(PlacedPoint(port.point, self.along_max, across))
            for node, layout, position in port.children:
                along, across = self.along_max + port.fan, position - chain_lane
                self.children.append(PlacedChild(node, layout, along, across, Direction.AHEAD))
                end = along + layout.extent.along_max
                self.extent_along_max = max(self.extent_along_max, end)

    def finish(self) -> Layout:
        """Return the layout."""
        return Layout(
            vertical=self.vertical,
            joints=self.joints,
            origin=self.origin,
            box=Rectangle(self.along_min, self.along_max, self.across_min, self.across_max),
            points=self.points,
            children=self.children,
            extent=Rectangle(
                0.0, self.extent_along_max, self.extent_across_min, self.extent_across_max
            ),
        )


def _compute_shift(row: Row) -> float:
    """Compute how far a row at a side must be shifted so that its first port is a fork away."""
    return max(0.0, FORK_LENGTH - row.ports[0].position)


class ChainCell(NamedTuple):
    """Where a joint is in a chain."""

    row: int
    """1 is the first."""
    column: int


def _fold_chain(count: int, *, is_folded: bool) -> list[ChainCell]:
    """Place the joints of a chain in rows and columns; the last joint is in column 0.

    A folded chain of five joints or more makes turns, each of four joints in two rows::

        1 -- 2
             |
        4 -- 3
        |
        5

    Args:
        count: Number of joints.
        is_folded: Whether a long chain is folded.
    """
    cells: list[ChainCell] = []
    while is_folded and count - len(cells) > 4:
        row = len(cells) // 2 + 1
        cells += [
            ChainCell(row, 0),
            ChainCell(row, 1),
            ChainCell(row + 1, 1),
            ChainCell(row + 1, 0),
        ]
    row = cells[-1].row if cells else 0
    return cells + [ChainCell(row + k, 0) for k in range(1, count - len(cells) + 1)]
