"""The way of a cut or a link round the boxes that stand between its two points."""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heappop, heappush
from itertools import pairwise, product
from math import dist

from urdf2mbs.mbs.model import XY

CLEAR = 9.0
"""How far from a box a way turns (px)."""
MOST = 20
"""Round more boxes than this no way is looked for: the line is straight."""

Box = tuple[float, float, float, float]
"""Left, top, right, bottom (px)."""


def route(start: XY, end: XY, boxes: Sequence[Box]) -> list[XY]:
    """The corners of the shortest way that crosses no box, both ends included.

    A box that holds an end is not in the way.  The way is straight if nothing stands in it, or
    if there is no way round.  A box counts from the time on that a way has met it: these are few.
    """
    boxes = [box for box in boxes if not (_holds(box, start) or _holds(box, end))]
    walls: list[Box] = []
    way = [start, end]
    while met := [box for box in boxes if any(_crosses(a, b, box) for a, b in pairwise(way))]:
        walls += met
        way = _shortest(start, end, walls) if len(walls) <= MOST else []
        if not way:
            return [start, end]
    return way


def _shortest(start: XY, end: XY, walls: list[Box]) -> list[XY]:
    """Dijkstra's way from corner to corner; empty if there is none."""
    places = [end]
    for left, top, right, bottom in walls:
        places += product((left - CLEAR, right + CLEAR), (top - CLEAR, bottom + CLEAR))
    ways = [(0.0, [start])]
    reached: set[XY] = set()
    while ways:
        length, way = heappop(ways)
        here = way[-1]
        if here == end:
            return way
        if here in reached:
            continue
        reached.add(here)
        for place in places:
            if place not in reached and not any(_crosses(here, place, wall) for wall in walls):
                heappush(ways, (length + dist(here, place), [*way, place]))
    return []


def _holds(box: Box, place: XY) -> bool:
    return box[0] <= place[0] <= box[2] and box[1] <= place[1] <= box[3]


def _crosses(a: XY, b: XY, box: Box) -> bool:
    """True if a straight line runs through the inside of a box (Liang and Barsky)."""
    first, last = 0.0, 1.0
    for k in (0, 1):
        low, high, along = box[k] - a[k], box[k + 2] - a[k], b[k] - a[k]
        if along == 0.0:
            if not low < 0.0 < high:
                return False
        else:
            enters, leaves = sorted((low / along, high / along))
            first, last = max(first, enters), min(last, leaves)
    return first < last


def along(way: list[XY], share: float) -> XY:
    """The place at a share (0 to 1) of the length of a way."""
    left = share * sum(dist(a, b) for a, b in pairwise(way))
    for a, b in pairwise(way):
        length = dist(a, b)
        if left <= length and length > 0.0:
            break
        left -= length
    else:
        return way[-1]
    return (a[0] + left / length * (b[0] - a[0]), a[1] + left / length * (b[1] - a[1]))
