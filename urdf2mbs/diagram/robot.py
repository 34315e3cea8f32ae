"""Draw a robot as if it faced the reader: spine upright, limbs to the sides and down.

From the body that the base carries, the spine goes up through the bodies of the middle.  A limb at
its side first runs horizontally, in a *lane*, until it is clear of everything below; then it turns
down, in a *column*.  So higher limbs are farther out, as arms are beside legs::

      +------+      +-----------+      +------+
      | hand |--arm-|   chest   |-arm--| hand |       lanes
      +------+      +-----o-----+      +------+
         |                | spine          |
       finger             |              finger       columns
            +-----+ +-----o-----+ +-----+
            | leg |-|  pelvis   |-| leg |
            +-----+ +-----o-----+ +-----+
               |          |          |
              foot    +---o--+      foot
                      | Base |
                      +------+

The spine is one layout that grows up (see ``box_layout``): its chains of joints are one line, which
passes all names at the same distance, the *offset*.
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import msgspec

from urdf2mbs.diagram.box_layout import (
    Direction,
    Layout,
    LayoutRequest,
    PlacedChild,
    PlacedPoint,
    PortSides,
    Rectangle,
    lay_out_box,
)
from urdf2mbs.diagram.box_size import compute_min_box
from urdf2mbs.diagram.nodes import Node
from urdf2mbs.diagram.sheet import GROWS_UP, place_on_sheet
from urdf2mbs.diagram.sizes import CORNER_DISTANCE, FORK_LENGTH, LIMB_GAP, NAME_HEIGHT
from urdf2mbs.diagram.spine import SHORT_DEPTH, Limb, Vertebra
from urdf2mbs.diagram.tree import find_orientations, lay_out_tree
from urdf2mbs.mbs.model import Mbs

MAX_EXTRA_WIRE = 40.0
"""Most by which wires are stretched (px), if one more body of the limb can run out instead."""


class Region(NamedTuple):
    """A part of the sheet that is occupied (px).

    Both sides are one, so that limbs that are alike at both sides are drawn alike.
    """

    inner: float
    """From the spine outwards."""
    outer: float
    bottom: float
    """From the base up."""
    top: float


class PlacedVertebra(msgspec.Struct):
    """A vertebra with its layout."""

    vertebra: Vertebra
    layout: Layout
    bottom: float
    """Where its layout begins (px), from the base up."""

    @property
    def half_width(self) -> float:
        """Half of the width (px) of its box."""
        return (self.layout.box.across_max - self.layout.box.across_min) / 2


class LimbRun(NamedTuple):
    """How a limb runs out to a side before it turns down."""

    length: int
    """Number of bodies in the lane."""
    extra_wire: float
    """How much longer each of their wires is than it needs to be (px)."""
    turn: float
    """From the spine to the middle of the last body in the lane (px)."""
    regions: list[Region]
    """The occupied regions: the lane, then the column, if there is one."""


def arrange_robot(mbs: Mbs, nodes: list[Node], spine: list[Vertebra]) -> None:
    """Place a robot in the diagram as if it faced the reader.

    Args:
        mbs: The model.
        nodes: The base, then the bodies depth first.
        spine: The spine, lowest body first.
    """
    base = nodes[0]
    # The horizontal bodies of limbs are laid out later, when it is known which these are.
    orientations = find_orientations(nodes, 2, {vertebra.node.name for vertebra in spine})
    for node in reversed(nodes):
        if node.name in orientations:
            lay_out_tree(node, orientations[node.name], narrow=True)
    offset = max(
        compute_min_box(node, None, vertical=True).offset
        for node in (base, *(vertebra.node for vertebra in spine))
    )
    request = LayoutRequest(min_offset=offset)
    base_box = lay_out_box(base, PortSides(), request, vertical=True).box
    base_half_width = (base_box.across_max - base_box.across_min + LIMB_GAP) / 2
    for vertebra in reversed(spine):
        vertebra.node.layouts[True] = _lay_out_vertebra(vertebra, base_half_width, offset)
    occupied = [Region(0.0, base_half_width, -base_box.along_max, 0.0)]
    placed_spine = _stack(spine)
    for placed in placed_spine:
        occupied += _list_regions(placed, offset)
    for placed in placed_spine:
        _place_side_limbs(placed, occupied)
    layout = lay_out_box(base, PortSides(ahead=base.ports), request, vertical=True)
    place_on_sheet(mbs, base, layout, GROWS_UP)


# --- the spine ---


def _lay_out_vertebra(vertebra: Vertebra, base_half_width: float, offset: float) -> Layout:
    """Lay out a body of the spine, with its legs, and long enough for the limbs at its sides.

    Args:
        vertebra: The vertebra; its ``lane_heights`` are set.
        base_half_width: What the base needs at each side of the middle (px); legs are beside it.
        offset: From the chain of the spine to the middle of the boxes (px).
    """
    stack = _stack_lanes(vertebra, offset)
    request = LayoutRequest(
        min_length=stack.compute_min_length(),
        inset=CORNER_DISTANCE if vertebra.legs else 0.0,
        min_offset=offset,
    )
    layout = lay_out_box(vertebra.node, PortSides(ahead=vertebra.ahead), request, vertical=True)
    along_min, along_max, across_min, across_max = layout.box
    if stack.lanes:
        begin = along_min + stack.compute_begin(along_max - along_min)
        vertebra.lane_heights = [begin + lane for lane in stack.lanes]
    half_width = max(across_max - offset, offset - across_min)
    if stack.lanes and stack.is_above_name:
        half_width = max(half_width, offset + FORK_LENGTH)
    for side in (-1, 1):
        legs = [leg for leg in vertebra.legs if leg.side == side]
        half_width = max(half_width, _place_legs(layout, legs, base_half_width, offset))
    layout.box = Rectangle(along_min, along_max, offset - half_width, offset + half_width)
    return layout


class LaneStack(NamedTuple):
    """The lanes at the sides of a vertebra, one above the other.

    The arrows from the last joint to the ports at the sides must not cross the name, which is at
    half the height of the box.  If several limbs are on top of the box, the last joint is above the
    name, and so are all lanes.  Otherwise it is at the lower edge; then the highest arrow passes
    below the end of the name, at the ``name_share`` of its height::

        +---------------+
        |               |
        |    NAME       o highest port
        |          . `  |
        |     . `       |
        +--o------------+
    """

    lanes: list[float]
    """The height of each lane, counted from the lowest possible position (px)."""
    height: float
    """Of all lanes together (px)."""
    name_share: float
    is_above_name: bool

    def compute_min_length(self) -> float:
        """Compute the least height of the box (px)."""
        if not self.lanes:
            return 0.0
        if self.is_above_name:
            return 2 * (self.height + NAME_HEIGHT)
        return max(self.height, 2 * ceil(self.lanes[-1] * self.name_share))

    def compute_begin(self, length: float) -> float:
        """Compute where the lanes begin (px), from the lower edge of a box of a length."""
        if self.is_above_name:
            return length / 2 + NAME_HEIGHT
        return min((length - self.height) // 2, length / 2 // self.name_share - self.lanes[-1])


def _stack_lanes(vertebra: Vertebra, offset: float) -> LaneStack:
    """Stack the lanes of the limbs at the sides of a vertebra.

    Args:
        vertebra: The vertebra.
        offset: From the chain of the spine to the middle of the boxes (px).
    """
    lanes: list[float] = []
    top = FORK_LENGTH - CORNER_DISTANCE
    for row in vertebra.rows:
        lanes.append(top + max(limb.lane_below for limb in row))
        top = lanes[-1] + max(limb.lane_above for limb in row) + LIMB_GAP
    return LaneStack(
        lanes=lanes,
        height=top - LIMB_GAP + CORNER_DISTANCE,
        name_share=(offset + vertebra.node.half_name_width) / (2 * offset + CORNER_DISTANCE),
        is_above_name=len(vertebra.ahead) > 1,
    )


def _place_legs(layout: Layout, legs: list[Limb], base_half_width: float, offset: float) -> float:
    """Place the legs at one side of the lowest vertebra, from the middle outwards.

    Args:
        layout: The layout of the vertebra.
        legs: The legs at this side.
        base_half_width: What the base needs at each side of the middle (px).
        offset: From the chain of the spine to the middle of the boxes (px).

    Returns:
        The half width of the box (px) that they need.
    """
    half_width, edge = 0.0, base_half_width + LIMB_GAP / 2
    along = layout.box.along_min
    for leg in legs:
        if leg.port.point is None:
            continue
        leg_layout = leg.node.layouts[True]
        lane = edge - leg_layout.extent.across_min
        edge = lane + leg_layout.extent.across_max + LIMB_GAP
        across = offset + leg.side * lane
        layout.points.append(PlacedPoint(leg.port.point, along, across))
        layout.children.append(
            PlacedChild(leg.node, leg_layout, along, across, Direction.BACK, mirror=leg.side)
        )
        half_width = max(half_width, lane + CORNER_DISTANCE)
    return half_width


def _stack(spine: list[Vertebra]) -> list[PlacedVertebra]:
    """Place the bodies of the spine one on the other."""
    placed_spine = []
    bottom = 0.0
    for vertebra in spine:
        layout = vertebra.node.layouts[True]
        placed_spine.append(PlacedVertebra(vertebra, layout, bottom))
        bottom += layout.box.along_max
    return placed_spine


def _list_regions(placed: PlacedVertebra, offset: float) -> list[Region]:
    """List the regions that a vertebra and its legs occupy.

    Args:
        placed: The vertebra.
        offset: From the chain of the spine to the middle of the boxes (px).
    """
    box, bottom = placed.layout.box, placed.bottom
    regions = [Region(0.0, box.across_max - offset, bottom + box.along_min, bottom + box.along_max)]
    for child in placed.layout.children:
        if child.direction == Direction.BACK:
            extent = child.layout.extent
            lane = abs(child.across - offset)
            top = bottom + child.along
            regions.append(
                Region(
                    lane + extent.across_min, lane + extent.across_max, top - extent.along_max, top
                )
            )
    return regions


# --- the limbs at the sides ---


def _place_side_limbs(placed: PlacedVertebra, occupied: list[Region]) -> None:
    """Place the limbs at the sides of a vertebra, the lowest first.

    Args:
        placed: The vertebra.
        occupied: The occupied regions; those of the limbs are added.
    """
    layout, half_width = placed.layout, placed.half_width
    middle = (layout.box.across_min + layout.box.across_max) / 2
    for row, lane_height in zip(placed.vertebra.rows, placed.vertebra.lane_heights, strict=True):
        height = placed.bottom + lane_height
        runs = [_find_run(limb, half_width, height, occupied) for limb in row]
        for limb, run in zip(row, _align_turns(row, runs, half_width, height), strict=True):
            assert limb.port.point is not None
            across = middle + limb.side * half_width
            layout.points.append(PlacedPoint(limb.port.point, lane_height, across))
            direction = Direction.PLUS if limb.side > 0 else Direction.MINUS
            limb_layout = limb.node.layouts[False]
            layout.children.append(
                PlacedChild(limb.node, limb_layout, lane_height, across, direction)
            )
            occupied += run.regions


def _align_turns(row: list[Limb], runs: list[LimbRun], edge: float, height: float) -> list[LimbRun]:
    """Make partners turn down at the same distance from the spine.

    Args:
        row: The limbs of a row.
        runs: How each runs out.
        edge: Where the box of the vertebra ends (px), from the spine.
        height: Of the lane (px), from the base.
    """
    are_partners = len(row) == 2 and row[0].node.twin is row[1].node
    if not are_partners or runs[0].length != runs[1].length:
        return runs
    farthest_turn = max(run.turn for run in runs)
    aligned = []
    for limb, run in zip(row, runs, strict=True):
        missing = farthest_turn - run.turn
        if missing:
            extra_wire = run.extra_wire + missing / _count_wires(limb, run.length)
            regions = _lay_out_run(limb, run.length, edge, height, extra_wire)
            run = run._replace(extra_wire=extra_wire, regions=regions)
        aligned.append(run)
    return aligned


def _find_run(limb: Limb, edge: float, height: float, occupied: list[Region]) -> LimbRun:
    """Let a limb run out until the column below its last body is clear of all occupied regions.

    As few bodies as possible run out.

    Args:
        limb: The limb.
        edge: Where the box of the vertebra ends (px), from the spine.
        height: Of the lane (px), from the base.
        occupied: The occupied regions.
    """
    min_length = 1 if limb.depth > SHORT_DEPTH else len(limb.chain)
    for length in range(min_length, len(limb.chain) + 1):
        extra_wire = 0.0
        regions = _lay_out_run(limb, length, edge, height)
        if len(regions) > 1:
            missing = _compute_missing_distance(regions[1], occupied)
            extra_wire = float(ceil(missing / _count_wires(limb, length)))
            if extra_wire > MAX_EXTRA_WIRE and length < len(limb.chain):
                continue
            if extra_wire:
                regions = _lay_out_run(limb, length, edge, height, extra_wire)
        last_box = limb.chain[length - 1].layouts[False].box
        turn = regions[0].outer - (last_box.along_max - last_box.along_min) / 2
        return LimbRun(length, extra_wire, turn, regions)
    raise AssertionError("a limb has at least one body")


def _compute_missing_distance(column: Region, occupied: list[Region]) -> float:
    """Compute how much farther out (px) a column must be to be clear of occupied regions."""
    bottom, top = column.bottom - LIMB_GAP, column.top + LIMB_GAP
    beside = [region.outer for region in occupied if region.bottom < top and bottom < region.top]
    return max(0.0, max(beside) + LIMB_GAP - column.inner) if beside else 0.0


def _count_wires(limb: Limb, length: int) -> int:
    """Count the wires of the first bodies of a limb."""
    return sum(len(node.joints) for node in limb.chain[:length])


def _lay_out_run(
    limb: Limb, length: int, edge: float, height: float, extra_wire: float = 0.0
) -> list[Region]:
    """Lay out the bodies of a limb that run out.

    Args:
        limb: The limb.
        length: Number of bodies in the lane.
        edge: Where the box of the vertebra ends (px), from the spine.
        height: Of the lane (px), from the base.
        extra_wire: How much longer each wire is than it needs to be (px).

    Returns:
        The lane, then the column of the limbs below its last body, if there are any.
    """
    *inner_bodies, last_body = limb.chain[:length]
    request = LayoutRequest(extra_wire=extra_wire, centre_lone_child=True)
    last = lay_out_box(last_body, PortSides(minus=last_body.ports), request, vertical=False)
    last_body.layouts[False] = last
    start = edge
    for node in reversed(inner_bodies):
        request = LayoutRequest(extra_wire=extra_wire)
        layout = lay_out_box(node, PortSides(ahead=node.ports), request, vertical=False)
        node.layouts[False] = layout
        start += layout.box.along_max
    top = height + limb.lane_above
    lane = Region(edge, start + last.box.along_max, height - limb.lane_below, top)
    columns = [
        Region(
            start + child.along + child.layout.extent.across_min,
            start + child.along + child.layout.extent.across_max,
            height + child.across - child.layout.extent.along_max,
            top,
        )
        for child in last.children
    ]
    if not columns:
        return [lane]
    inner, outer, bottom, top_edges = zip(*columns, strict=True)
    return [lane, Region(min(inner), max(outer), min(bottom), max(top_edges))]
