"""What a diagram is made of, and how large MBSysPad draws it.  All in pixels."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from math import ceil

import msgspec

from urdf2mbs.mbs.model import Body, Joint, Mbs, Point

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
_WIDE = {"ijl": 4.2, "frtI": 6.0, "_": 6.1, "mwMW": 13.4, "DGHNOQU": 10.3}
_WIDTHS = defaultdict(lambda: 9.3, {a: width for letters, width in _WIDE.items() for a in letters})
"""Widths (px) of letters in DejaVu Sans Bold, 12 px: MBSysPad's font for names."""
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
"""Start and slope of the second column of points: its arrows lie on one line."""
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
    """A body and all below it, in a frame of its own, whatever way its limb grows on the sheet:
    ``a`` runs ahead, from the parent's point over the joints into the box; ``b`` runs across."""

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
    points = mbs.points()
    leads: dict[tuple[str | None, str | None], Lead] = {}
    for body in mbs.depth_first():
        parent = found[body.parent]
        node = Node(body, body.name, body.joints, name_width=written(body.name))
        found[body.name] = node
        out.append(node)
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


def written(name: str) -> float:
    """How wide a name is written, to the next even pixel."""
    return 2.0 * ceil(sum(map(_WIDTHS.__getitem__, name)) / 2)


def room(node: Node, vertical: bool, fork: float | None = None) -> tuple[float, float, float]:
    """How long a body's box is at least, how far it reaches beyond the chain on the side without
    the name, and how far its middle is from the chain on the other side.

    ``fork`` is how far before the far edge the last joint stands, where arrows or wires go from
    there to several children.
    """
    along, across = (NAME, half_name(node)) if vertical else (half_name(node), NAME)
    places = frames(node, vertical, fork)
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


def frames(node: Node, vertical: bool, fork: float | None) -> list[tuple[float, float]]:
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
