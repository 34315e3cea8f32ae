"""What a diagram is made of, and how large MBSysPad draws it: boxes, wires, lanes.

A body is planned in a frame of its own, whatever way its limb grows on the sheet: ``a`` runs
ahead, from the parent's point over the joints into the box; ``b`` runs across.  All in pixels.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from math import ceil

import msgspec

from urdf2mbs.mbs.model import XY, Body, Drawing, Joint, Mbs, Point

MARGIN = 20.0
"""Round the whole diagram."""
JOINT = 40.0
"""From joint to joint down a chain: the least that leaves room for a label."""
JOINT_ACROSS = 50.0
"""The same for a chain that runs to the left or to the right: labels are wider than high."""
FOLD = 62.0
"""From one column of a folded chain to the other: labels keep off one another."""
LEAD = 45.0
"""From a point on the edge of a box to the first joint of the child."""
CHARACTER = {"ijl": 4.2, "frtI": 6.0, "_": 6.1, "mwMW": 13.4, "DGHNOQU": 10.3}
"""How wide characters are of a body's name, which MBSysPad writes in DejaVu Sans Bold, 12 px."""
OTHER = 9.3
"""Those that are not in ``CHARACTER``."""
NAME = 16.0
"""A name is written 3 to 16 px above the middle of its box."""
AIR = 9.0
"""Between a name and what passes it."""
WIDTH, HEIGHT = 90.0, 60.0
"""The least size of a box."""
FAR = 70.0
"""From joint to joint, at most, where a chain is stretched to stand beside a longer one."""
FAR_ACROSS = 90.0
GAP = 30.0
"""Between one limb and the next."""
FRAME = 16.0
"""From one to the next of the points that are only frames, inside the box."""
ROW, COLUMN = 8, 16
"""So many of them stand in a row across the chain at most, and so many along the chain."""
RAY, SLOPE = 110.0, 0.16
"""Where a second column of them begins, and how far it goes aside for each pixel ahead: so its
arrows lie on one ray, clear of the first column."""
EDGE = 15.0
"""From the corner of a box to the first point on its edge."""
FORK = 40.0
"""From the last joint, with its label, to the points of several children."""
FAN = 0.5
"""Wires from one point to several children: how far they go ahead for each pixel aside."""


AHEAD, BACK = 0, 2
"""Which way a child runs from its parent's box; -1 and 1 are the sides."""


class Lead(msgspec.Struct):
    """A point, and the bodies that it carries."""

    point: Point | None
    """None is the parent's own frame."""
    nodes: list[Node] = []


class Node(msgspec.Struct):
    """A body of the diagram, or the base (``body`` None), and all that hangs on it."""

    body: Body | None
    name: str = ""
    joints: list[Joint] = []
    leads: list[Lead] = []
    children: list[Node] = []
    """The bodies of all leads."""
    name_width: float = 0.0
    frames: list[Point] = []
    """Points that carry nothing."""
    alike: Node | None = None
    """Its partner in the mirror, beside which it is drawn alike."""
    plan: dict[bool, Plan] = {}
    """As it is drawn when its limb runs up or down (True), to the left or right (False)."""

    def sort(self, place: Callable[[Node], float]) -> None:
        """Put the leads in the order of the places of their first bodies."""
        if len(self.leads) > 1:
            self.leads.sort(key=lambda lead: round(place(lead.nodes[0]), 2))
            self.children = [node for lead in self.leads for node in lead.nodes]


class Plan(msgspec.Struct):
    """A body and all below it, in the body's own frame."""

    vertical: bool
    joints: list[tuple[float, float]]
    """``a`` and ``b`` of each joint."""
    origin: float
    """``a`` of the body's frame: the last joint, or where the base's symbol stands."""
    box: tuple[float, float, float, float]
    """a0, a1, b0, b1."""
    points: list[tuple[Point, float, float]]
    """Where the body's points are."""
    limbs: list[tuple[Node, Plan, float, float, int, int]]
    """Each child and its plan; where its frame begins; where it runs: ahead (0), to the side
    of negative (-1) or positive b (1), or back (2); 1, or -1 where it is mirrored."""
    extent: tuple[float, float, float, float]
    """a0, a1, b0, b1 of all, children included."""


def nodes(mbs: Mbs) -> list[Node]:
    """The base, then the bodies depth first, linked to one another."""
    base = Node(None, name_width=written("Base"))
    out = [base]
    found: dict[str | None, Node] = {None: base}
    points: dict[tuple[str | None, str | None], Point] = {}
    for point in mbs.base.points:
        points[None, point.name] = point
    leads: dict[tuple[str | None, str | None], Lead] = {}
    for body in mbs.depth_first():
        parent = found[body.parent]
        node = Node(body, body.name, body.joints, name_width=written(body.name))
        found[body.name] = node
        out.append(node)
        for point in body.points:
            points[body.name, point.name] = point
        at = points.get((body.parent, body.point))
        key = (body.parent, None if at is None else body.point)
        if key not in leads:
            leads[key] = Lead(at)
            parent.leads.append(leads[key])
        leads[key].nodes.append(node)
        parent.children.append(node)
    for node in out:
        node.frames = mbs.base.points if node.body is None else node.body.points
        if node.leads:
            carrying = {id(lead.point) for lead in node.leads}
            node.frames = [point for point in node.frames if id(point) not in carrying]
    return out


_WIDTHS = defaultdict(
    lambda: OTHER, {letter: width for letters, width in CHARACTER.items() for letter in letters}
)


def written(name: str) -> float:
    """How wide a name is written, to the next even pixel."""
    return 2.0 * ceil(sum(map(_WIDTHS.__getitem__, name)) / 2)


def plan(
    node: Node,
    vertical: bool,
    ahead: Sequence[Lead],
    minus: Sequence[Lead] = (),
    plus: Sequence[Lead] = (),
    *,
    spread: float = 0.0,
    long: float = 0.0,
    inside: float = 0.0,
    aside: float = 0.0,
    corner: bool = False,
    reach: float = 0.0,
) -> Plan:
    """A body with its children ahead or at its sides, none in the way of another.

    The box grows until each child stands straight before its point: so no wire is longer
    than a joint needs.  The box's middle, where its name is, stands beside the chain, at
    positive b: so no arrow crosses the name.  ``aside`` is the least distance of the two.

    ``spread`` is added to each wire of the chain; ``long`` is the least length of the box;
    ``inside`` is how far in the last joint stands.  At a ``corner``, a lone child at a side
    stands at the middle, even if it then reaches back beside the wire.  ``reach`` makes the box
    longer, and puts the children at its sides so much farther ahead.
    """
    in_front = any(lead.point is None for lead in ahead)
    fork = 0.0 if in_front else FORK if len(ahead) > 1 else None
    least, low, own_aside = room(node, vertical, fork)
    long, aside = max(least, long), max(aside, own_aside)
    if fork is not None:
        inside = long - fork  # beyond the name, so that no arrow crosses it
    own = len(node.joints)
    # the name keeps off the side where children leave
    mirror = -1 if plus and not minus else 1
    end, joints, folded = inside, [], vertical and fork is None
    if own:
        places = _chain(own, folded)
        rows = places[-1][0]
        pitch = (JOINT if vertical else JOINT_ACROSS) + spread
        first = (LEAD if vertical else JOINT_ACROSS) + spread
        end = natural = first + pitch * (rows - 1)
        if node.alike is not None and node.alike.joints:
            end = max(end, first + pitch * (_chain(len(node.alike.joints), folded)[-1][0] - 1))
        most = rows * ((FAR if vertical else FAR_ACROSS) + spread)
        if fork is not None:
            end = max(end, inside + LEAD)
        elif end > most:
            long += end - most  # rather a longer box than longer wires
            end = most
        if end > natural:
            pitch = end // rows
            first = end - pitch * (rows - 1)
        joints = [(first + pitch * (row - 1), mirror * FOLD * column) for row, column in places]
    a0 = end - inside
    a1 = a0 + long

    limbs: list[tuple[Node, Plan, float, float, int, int]] = []
    points = [
        (point, end + a, mirror * b)
        for point, (a, b) in zip(node.frames, _frames(node, vertical, fork), strict=False)
    ]
    b0, b1 = -low, low + 2 * aside
    front, length = _lanes(ahead, vertical)
    centre = 0.0
    if front:
        centre = front[0][1]
        if in_front:
            centre = next(start for point, start, _, _ in front if point is None)
        elif fork is not None:
            centre = (front[0][1] + front[-1][1]) / 2 - aside
        b0 = min(b0, front[0][1] - centre - EDGE)
        b1 = max(b1, front[-1][1] - centre + EDGE, 2 * aside - b0)
    if mirror < 0:
        b0, b1 = -b1, -b0
    turns = [b + mirror * EDGE for _, b in joints if b]
    low, high = min(b0, -centre, *turns), max(b1, length - centre, *turns)

    far = a1
    sides: list[tuple[int, list[_Lane], float]] = []
    for side, leads in ((-1, minus), (1, plus)):
        if not leads:
            continue
        lanes, _ = _lanes(leads, not vertical)
        move = max(0.0, FORK - lanes[0][1])
        last = EDGE if corner and len(leads) == 1 else lanes[-1][1] + move
        if side == mirror:
            # not farther ahead than the name, which stands between
            a1 = max(a1, a0 + 2 * (last + (NAME if vertical else half_name(node))))
        a1 = max(a1, a0 + last + EDGE)
        sides.append((side, lanes, a0 + move))
    a1 += reach
    for side, lanes, move in sides:
        move += reach
        if corner and len(lanes) == 1:
            move = (a0 + a1 + reach) / 2 - lanes[0][1]  # one alone leaves at the middle
        edge = b0 if side < 0 else b1
        for point, start, fan, group in lanes:
            if point is not None:
                points.append((point, start + move, edge))
            for child, drawn, lane in group:
                limbs.append((child, drawn, lane + move, edge + side * fan, side, 1))
                tip = edge + side * (fan + drawn.extent[1])
                low, high = min(low, tip), max(high, tip)
                far = max(far, lane + move + drawn.extent[3])
    far = max(far, a1)
    for point, start, fan, group in front:
        if point is not None:
            points.append((point, a1, start - centre))
        for child, drawn, lane in group:
            limbs.append((child, drawn, a1 + fan, lane - centre, AHEAD, 1))
            far = max(far, a1 + fan + drawn.extent[1])
    return Plan(vertical, joints, end, (a0, a1, b0, b1), points, limbs, (0.0, far, low, high))


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


_Lane = tuple[Point | None, float, float, list[tuple[Node, "Plan", float]]]
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
            cursor += high - low + GAP
        start, fan = group[0][2], 0.0
        if len(group) > 1:
            # the wires keep off one another
            first, last = start, group[-1][2]
            start = float(round((first + last) / 2))
            fan = float(ceil(FAN * max(start - first, last - start)))
        lanes.append((lead.point, start, fan, group))
    return lanes, max(cursor - GAP, 0.0)


def room(node: Node, vertical: bool, fork: float | None = None) -> tuple[float, float, float]:
    """How long a body's box is at least, how far it reaches beyond the chain on the side without
    the name, and how far its middle is from the chain on the other side.

    ``fork`` is how far before the far edge the last joint stands, where arrows or wires go from
    there to several children.
    """
    along, across = (NAME, half_name(node)) if vertical else (half_name(node), NAME)
    places = _frames(node, vertical, fork)
    long, low, aside = 2 * (along + AIR), EDGE, across + AIR
    if fork is not None:
        low += max((b for _, b in places), default=0.0)
        long += 2 * (fork + max((-a for a, _ in places), default=0.0))
    elif places:
        low -= min(b for _, b in places)
        long = max(long, max(a for a, _ in places) + EDGE)
        if vertical and _marked(node):
            aside += FRAME
    if vertical:
        return max(long, HEIGHT), low, max(aside, WIDTH / 2 - low)
    return max(long, WIDTH), low, aside


def half_name(node: Node) -> float:
    """Half as wide (px) as a body's name, or its partner's if longer, is written."""
    return max(node.name_width, (node.alike or node).name_width) / 2


def _marked(node: Node) -> bool:
    """Whether the letter of a sensor or of an external force stands at the right of a point."""
    frames = node.frames + node.alike.frames if node.alike else node.frames
    return any(point.sensor is not None or point.extforce is not None for point in frames)


def _frames(node: Node, vertical: bool, fork: float | None) -> list[tuple[float, float]]:
    """Where the points that are only frames stand, ahead of the last joint and across.

    They follow the chain, and so their arrows lie on it; those of a further column lie on a ray
    beside.  Where arrows to several children leave, they stand in rows behind the joint.
    """
    count = max(len(node.frames), len(node.alike.frames) if node.alike else 0)
    wide = 2 * FRAME if count and _marked(node) else FRAME
    ahead, across = (FRAME, wide) if vertical else (wide, FRAME)
    if fork is not None:
        return [
            (
                -ahead * (k // ROW + 1),
                (1.5 * FRAME + across * (k % ROW // 2)) * (1 if k % 2 else -1),
            )
            for k in range(count)
        ]
    row = ceil(count / max(1, ceil(count / COLUMN)))
    if not vertical:  # lanes of limbs that run out are to be low
        return [(EDGE + ahead * (k % row), -FRAME * (k // row)) for k in range(count)]
    starts = [EDGE if k < row else RAY for k in range(count)]
    along = [start + FRAME * (k % row) for k, start in enumerate(starts)]
    return [(a, -SLOPE * a * (k // row)) for k, a in enumerate(along)]


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
        x0, x1 = x + ax * a0 + bx * b0, x + ax * a1 + bx * b1
        y0, y1 = y + ay * a0 + by * b0, y + ay * a1 + by * b1
        if x0 > x1:
            x0, x1 = x1, x0
        if y0 > y1:
            y0, y1 = y1, y0
        placed.append((node, drawn, way, (x0, y0, x1, y1)))
        left, top = min(left, x0), min(top, y0)  # joints stand between two boxes
        for child, below, a, b, turn, mirror in drawn.limbs:
            u, v = x + ax * a + bx * b, y + ay * a + by * b
            if turn == AHEAD:
                along = (ax, ay, bx * mirror, by * mirror)
            elif turn == BACK:
                along = (-ax, -ay, bx * mirror, by * mirror)
            else:
                along = (bx * turn, by * turn, ax * mirror, ay * mirror)
            todo.append((child, below, (u, v, *along)))
    dx, dy = round(MARGIN - left, 0), round(MARGIN - top, 0)

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
