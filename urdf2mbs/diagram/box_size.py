r"""How large the box of a body must be for its name and its points.

A layout has a frame of its own, whichever way its limb grows on the sheet: *along* counts from the
port of the parent in the direction of growth, and *across* at right angles to it.  Here is a body
that grows down the sheet; one that grows to the right is the same picture, rotated::

    across    0         offset
              |            |
    along 0   o port of the parent            the chain of joints is at across = 0
              |
              o joint
              |
         +----o--------------------------+    origin: the last joint, on the edge of the box,
         |    x point                    |    or at a distance (inset) inside
         |    x point                    |
         |    x point    NAME            |    name: at the middle of the box, and beside the
         |    x point                    |    chain, so that no wire or arrow crosses it
         |                               |
         +-------------------------------+
         <---->
         margin

If arrows or wires go from the last joint to several children, they must not cross the name either.
Then the last joint is beyond the name, a *fork* before the edge of the box with the ports::

              |
         +----|--------------------------+
         |    |                          |
         |    |          NAME            |
         |  x | x points                 |
         |    o last joint               |
         |   / \_________                |    fork
         +--o-------------o--------------+
          port          port
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

from urdf2mbs.diagram.nodes import Node
from urdf2mbs.diagram.sizes import (
    CORNER_DISTANCE,
    MAX_POINTS_ACROSS,
    MAX_POINTS_ALONG,
    MIN_BOX_HEIGHT,
    MIN_BOX_WIDTH,
    NAME_CLEARANCE,
    NAME_HEIGHT,
    POINT_PITCH,
    SECOND_COLUMN_SLOPE,
    SECOND_COLUMN_START,
)


class LocalPosition(NamedTuple):
    """A position in the frame of a layout (px)."""

    along: float
    across: float


class BoxSize(NamedTuple):
    """The least size of a box (px)."""

    length: float
    """Along the chain."""
    margin: float
    """How far the box extends beyond the chain, at the side without the name."""
    offset: float
    """From the chain to the middle of the box, at the side with the name."""


def compute_min_box(node: Node, fork: float | None, *, vertical: bool) -> BoxSize:
    """Compute the least size of the box of a body.

    Args:
        node: The body.
        fork: Distance (px) of the last joint from the edge with the ports, if arrows or wires go
            from there to several children.
        vertical: True if its limb grows up or down.
    """
    name_along, name_across = NAME_HEIGHT, node.half_name_width
    if not vertical:
        name_along, name_across = name_across, name_along
    points = place_points(node, fork, vertical=vertical)
    length, margin = 2 * (name_along + NAME_CLEARANCE), CORNER_DISTANCE
    offset = name_across + NAME_CLEARANCE
    if fork is not None:
        margin += max((point.across for point in points), default=0.0)
        length += 2 * (fork + max((-point.along for point in points), default=0.0))
    elif points:
        margin -= min(point.across for point in points)
        length = max(length, max(point.along for point in points) + CORNER_DISTANCE)
        if vertical and _has_letter(node):
            offset += POINT_PITCH
    if vertical:
        return BoxSize(max(length, MIN_BOX_HEIGHT), margin, max(offset, MIN_BOX_WIDTH / 2 - margin))
    return BoxSize(max(length, MIN_BOX_WIDTH), margin, offset)


def place_points(node: Node, fork: float | None, *, vertical: bool) -> list[LocalPosition]:
    """Place the points without children, relative to the last joint.

    They follow the chain, so their arrows are on it; those of a second column are on a line beside
    it.  If there is a fork, they are in rows before the last joint.  Twins have places for the
    points of both.

    Args:
        node: The body.
        fork: As of ``compute_min_box``.
        vertical: True if its limb grows up or down.
    """
    count = max(len(node.free_points), len(node.twin.free_points) if node.twin else 0)
    pitch_x = 2 * POINT_PITCH if count and _has_letter(node) else POINT_PITCH
    pitch_along, pitch_across = (POINT_PITCH, pitch_x) if vertical else (pitch_x, POINT_PITCH)
    if fork is not None:
        return [
            LocalPosition(
                -pitch_along * (k // MAX_POINTS_ACROSS + 1),
                (1.5 * POINT_PITCH + pitch_across * (k % MAX_POINTS_ACROSS // 2))
                * (1 if k % 2 else -1),
            )
            for k in range(count)
        ]
    columns = max(1, ceil(count / MAX_POINTS_ALONG))
    points_along = ceil(count / columns)
    if not vertical:  # the lane of a horizontal limb should be low
        return [
            LocalPosition(
                CORNER_DISTANCE + pitch_along * (k % points_along),
                -POINT_PITCH * (k // points_along),
            )
            for k in range(count)
        ]
    positions = []
    for k in range(count):
        start = CORNER_DISTANCE if k < points_along else SECOND_COLUMN_START
        along = start + POINT_PITCH * (k % points_along)
        positions.append(LocalPosition(along, -SECOND_COLUMN_SLOPE * along * (k // points_along)))
    return positions


def _has_letter(node: Node) -> bool:
    """Return True if MBSysPad writes a letter beside a point: of a sensor, or of a force."""
    points = node.free_points + node.twin.free_points if node.twin else node.free_points
    return any(point.sensor is not None or point.extforce is not None for point in points)
