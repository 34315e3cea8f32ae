"""How a body is drawn with all that hangs on it, none in the way of another.

The box of a body grows until each child stands straight before its point: so no wire is longer
than a joint needs.  The box's middle, where its name is, stands beside the chain of joints: so no
arrow crosses the name.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import msgspec

from urdf2mbs.diagram import boxes
from urdf2mbs.diagram.boxes import Lead, Node, Plan, frames, half_name, room
from urdf2mbs.mbs.model import XY, Drawing, Mbs, Point


class Wish(msgspec.Struct):
    """What the diagram around a body asks of it (px)."""

    spread: float = 0.0
    """Added to each wire of the chain."""
    long: float = 0.0
    """The least length of the box."""
    inside: float = 0.0
    """How far in the last joint stands."""
    aside: float = 0.0
    """The least distance of the box's middle from the chain."""
    corner: bool = False
    """A lone child at a side stands at the middle, even if it then reaches back beside the wire."""


NOTHING = Wish()


def plan(
    node: Node, vertical: bool, ahead: Sequence[Lead], minus: Sequence[Lead] = (),
    plus: Sequence[Lead] = (), wish: Wish = NOTHING,
) -> Plan:  # fmt: skip
    """A body with its children ahead, or at its sides of negative and positive ``b``; the plans of
    the children are made."""
    draft = _Draft(node, vertical, ahead, wish, mirror=-1 if plus and not minus else 1)
    draft.put_ahead()
    draft.put_aside([(side, leads) for side, leads in ((-1, minus), (1, plus)) if leads])
    return draft.finish()


class _Draft:
    """A plan that is being made.  The edges of the box are a0, a1, b0, b1; ``low``, ``high`` and
    ``far`` are those of all."""

    def __init__(
        self, node: Node, vertical: bool, ahead: Sequence[Lead], wish: Wish, mirror: int
    ) -> None:
        self.node, self.vertical, self.ahead, self.wish = node, vertical, ahead, wish
        self.mirror = mirror
        """-1 where the name is at the side of negative b: it keeps off the children."""
        self.in_front = any(lead.point is None for lead in ahead)
        """A child runs on from the body's own frame."""
        fork = 0.0 if self.in_front else boxes.FORK if len(ahead) > 1 else None
        self.fork = fork
        """How far before the far edge the last joint stands, where arrows go to several points."""
        least, self.beyond, aside = room(node, vertical, fork)
        self.long, self.aside = max(least, wish.long), max(aside, wish.aside)
        # beyond the name, so that no arrow crosses it
        inside = wish.inside if fork is None else self.long - fork
        self.end, self.joints = inside, list[tuple[float, float]]()
        if node.joints:
            self._put_joints(inside)
        self.a0 = self.end - inside
        self.a1 = self.far = self.a0 + self.long
        self.limbs: list[tuple[Node, Plan, float, float, int, int]] = []
        self.points = [
            (point, self.end + a, mirror * b)
            for point, (a, b) in zip(node.frames, frames(node, vertical, fork), strict=False)
        ]

    def _put_joints(self, inside: float) -> None:
        """The chain of joints, as long as that of the body's partner."""
        folded = self.vertical and self.fork is None
        places = _chain(len(self.node.joints), folded)
        rows, spread = places[-1][0], self.wish.spread
        pitch = (boxes.JOINT if self.vertical else boxes.JOINT_ACROSS) + spread
        first = (boxes.LEAD if self.vertical else boxes.JOINT_ACROSS) + spread
        end = natural = first + pitch * (rows - 1)
        partner = self.node.alike
        if partner is not None and partner.joints:
            end = max(end, first + pitch * (_chain(len(partner.joints), folded)[-1][0] - 1))
        most = rows * ((boxes.FAR if self.vertical else boxes.FAR_ACROSS) + spread)
        if self.fork is not None:
            end = max(end, inside + boxes.LEAD)
        elif end > most:
            self.long += end - most  # rather a longer box than longer wires
            end = most
        if end > natural:
            pitch = end // rows
            first = end - pitch * (rows - 1)
        self.end = end
        self.joints = [
            (first + pitch * (row - 1), self.mirror * boxes.FOLD * column) for row, column in places
        ]

    def put_ahead(self) -> None:
        """The children ahead, and how wide the box is for them."""
        b0, b1 = -self.beyond, self.beyond + 2 * self.aside
        self.front, length = _lanes(self.ahead, self.vertical)
        centre = 0.0
        if self.front:
            first, last = self.front[0][1], self.front[-1][1]
            centre = first
            if self.in_front:
                centre = next(start for point, start, _, _ in self.front if point is None)
            elif self.fork is not None:
                centre = (first + last) / 2 - self.aside
            b0 = min(b0, first - centre - boxes.EDGE)
            b1 = max(b1, last - centre + boxes.EDGE, 2 * self.aside - b0)
        if self.mirror < 0:
            b0, b1 = -b1, -b0
        turns = [b + self.mirror * boxes.EDGE for _, b in self.joints if b]
        self.b0, self.b1, self.centre = b0, b1, centre
        self.low, self.high = min(b0, -centre, *turns), max(b1, length - centre, *turns)

    def put_aside(self, sides: list[tuple[int, Sequence[Lead]]]) -> None:
        """The children at the sides, and how long the box is for them."""
        a0, lone = self.a0, self.wish.corner
        rows: list[tuple[int, list[_Lane], float]] = []
        for side, leads in sides:
            lanes, _ = _lanes(leads, not self.vertical)
            move = max(0.0, boxes.FORK - lanes[0][1])
            last = boxes.EDGE if lone and len(leads) == 1 else lanes[-1][1] + move
            if side == self.mirror:
                # not farther ahead than the name, which stands between
                name = boxes.NAME if self.vertical else half_name(self.node)
                self.a1 = max(self.a1, a0 + 2 * (last + name))
            self.a1 = max(self.a1, a0 + last + boxes.EDGE)
            rows.append((side, lanes, a0 + move))
        for side, lanes, move in rows:
            if lone and len(lanes) == 1:
                move = (a0 + self.a1) / 2 - lanes[0][1]
            edge = self.b0 if side < 0 else self.b1
            for point, start, fan, group in lanes:
                if point is not None:
                    self.points.append((point, start + move, edge))
                for child, drawn, lane in group:
                    self.limbs.append((child, drawn, lane + move, edge + side * fan, side, 1))
                    tip = edge + side * (fan + drawn.extent[1])
                    self.low, self.high = min(self.low, tip), max(self.high, tip)
                    self.far = max(self.far, lane + move + drawn.extent[3])

    def finish(self) -> Plan:
        a1 = self.a1
        self.far = max(self.far, a1)
        for point, start, fan, group in self.front:
            if point is not None:
                self.points.append((point, a1, start - self.centre))
            for child, drawn, lane in group:
                self.limbs.append((child, drawn, a1 + fan, lane - self.centre, boxes.AHEAD, 1))
                self.far = max(self.far, a1 + fan + drawn.extent[1])
        return Plan(
            self.vertical, self.joints, self.end, (self.a0, a1, self.b0, self.b1), self.points,
            self.limbs, (0.0, self.far, self.low, self.high),
        )  # fmt: skip


def _chain(count: int, folded: bool) -> list[tuple[int, int]]:
    """Row (from 1) and column of each joint of a chain; the last joint stands in column 0.

    Five joints or more are folded: four stand in two rows, there and back.
    """
    places: list[tuple[int, int]] = []
    while folded and count - len(places) > 4:
        row = len(places) // 2 + 1
        places += [(row, 0), (row, 1), (row + 1, 1), (row + 1, 0)]
    row = places[-1][0] if places else 0
    return places + [(row + k, 0) for k in range(1, count - len(places) + 1)]


_Lane = tuple[Point | None, float, float, list[tuple[Node, Plan, float]]]
"""A point and where it is; how far ahead what it carries begins, and the lane of each."""


def _lanes(leads: Sequence[Lead], vertical: bool) -> tuple[list[_Lane], float]:
    """Limbs side by side, the first one from 0 on; and where the last one ends."""
    lanes: list[_Lane] = []
    cursor = 0.0
    for lead in leads:
        group = []
        for child in lead.nodes:
            drawn = child.plan[vertical]
            _, _, low, high = drawn.extent
            group.append((child, drawn, cursor - low))
            cursor += high - low + boxes.GAP
        start, fan = group[0][2], 0.0
        if len(group) > 1:
            # the wires keep off one another
            first, last = start, group[-1][2]
            start = float(round((first + last) / 2))
            fan = float(ceil(boxes.FAN * max(start - first, last - start)))
        lanes.append((lead.point, start, fan, group))
    return lanes, max(cursor - boxes.GAP, 0.0)


Way = tuple[float, float, float, float, float, float]
"""A frame on the sheet: x, y where it begins; x, y of the direction of ``a``; of that of ``b``."""


def put(mbs: Mbs, base: Node, way: Way, whole: Plan) -> None:
    """Give everything its place on the sheet, the upper left corner at the margin."""
    todo = [(base, whole, way)]
    placed: list[tuple[Node, Plan, Way, tuple[float, float, float, float]]] = []
    left = top = 0.0
    while todo:
        node, drawn, way = todo.pop()
        x, y, ax, ay, bx, by = way
        a0, a1, b0, b1 = drawn.box
        x0, x1 = sorted((x + ax * a0 + bx * b0, x + ax * a1 + bx * b1))
        y0, y1 = sorted((y + ay * a0 + by * b0, y + ay * a1 + by * b1))
        placed.append((node, drawn, way, (x0, y0, x1, y1)))
        left, top = min(left, x0), min(top, y0)  # joints stand between two boxes
        for child, below, a, b, turn, mirror in drawn.limbs:
            u, v = x + ax * a + bx * b, y + ay * a + by * b
            if turn == boxes.AHEAD:
                along = (ax, ay, bx * mirror, by * mirror)
            elif turn == boxes.BACK:
                along = (-ax, -ay, bx * mirror, by * mirror)
            else:
                along = (bx * turn, by * turn, ax * mirror, ay * mirror)
            todo.append((child, below, (u, v, *along)))
    dx, dy = round(boxes.MARGIN - left, 0), round(boxes.MARGIN - top, 0)

    for node, drawn, (x, y, ax, ay, bx, by), box in placed:
        way = (x + dx, y + dy, ax, ay, bx, by)
        here = _place(way, drawn.origin, 0.0)
        sides = zip(box, (dx, dy, dx, dy), (*here, *here), strict=True)
        drawing = _box(*[round(round(side + moved, 1) - start, 1) for side, moved, start in sides])
        if node.body is None:
            mbs.base.position, mbs.base.drawing = here, drawing
        else:
            node.body.drawing = drawing
            for joint, (a, b) in zip(node.joints, drawn.joints, strict=True):
                joint.position = _place(way, a, b)
        for point, a, b in drawn.points:
            point.position = _place(way, a, b)


def _place(way: Way, a: float, b: float) -> XY:
    x, y, ax, ay, bx, by = way
    return (round(x + ax * a + bx * b, 1), round(y + ay * a + by * b, 1))


def _box(left: float, top: float, right: float, bottom: float) -> Drawing:
    """A rectangle, relative to its joint."""
    return Drawing(
        position=(left, top),
        size=(round(right - left, 1), round(bottom - top, 1)),
        control_points=((right, top), (right, bottom), (left, bottom), (left, top)),
    )
