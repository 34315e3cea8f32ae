"""The robot as it stands before one: spine upright, limbs out to both sides and down.

From the body that the base carries, the spine goes up through the bodies of the middle.  What
leaves it sideways runs out until it is clear of all below, then turns down.  So higher limbs
stand farther out, as arms do beside legs.
"""

from __future__ import annotations

from math import ceil

import msgspec

from urdf2mbs.diagram.boxes import BACK, EDGE, FORK, GAP, NAME, Lead, Node, Plan, half_name, room
from urdf2mbs.diagram.plan import Wish, plan, put
from urdf2mbs.diagram.shape import Shape
from urdf2mbs.diagram.tree import plan_tree, ways_of
from urdf2mbs.mbs.model import Mbs

MIDDLE = 0.04
"""What is nearer to the plane of symmetry is in the middle (share of the robot's size)."""
LIMBS = 24
"""With more limbs than this at its spine, nobody would recognise a robot."""
MOST = 40.0
"""Most by which a wire is stretched (px) where one more body of the limb can run out instead."""
SHORT = 2
"""A limb of so few bodies one after the other does not turn down."""

Box = tuple[float, float, float, float]
"""Inner, outer, bottom, top (px): x counted outwards from the spine, both sides as one, so that
what is alike at both sides is drawn alike; y up from the base."""
Run = tuple[int, float, float, list[Box]]
"""How many bodies of a limb run out before it turns down, by how much more their wires are spread
than they need, how far out the middle of the last body is (px), and what the bodies take."""


class Limb(msgspec.Struct):
    """What leaves the spine."""

    lead: Lead
    side: int
    """1: the right of the picture, -1: the left."""
    height: float
    """Where it leaves the spine (share of the robot's size)."""
    depth: int
    """Bodies one after the other, at the most."""
    row: list[Node]
    """The bodies that can run out one after the other; a limb turns down at the latest where
    it branches."""
    low: float = 0.0
    high: float = 0.0
    """How far the lane in which they do reaches below and above their joints (px), once it is
    known how large they are."""

    @classmethod
    def of(cls, lead: Lead, side: int, height: float, depth: int) -> Limb:
        row = [lead.nodes[0]]
        while len(children := row[-1].children) == 1:
            row += children
        return cls(lead, side, height, depth, row)

    @property
    def node(self) -> Node:
        return self.row[0]


class Vertebra(msgspec.Struct):
    """A body of the spine and what leaves it."""

    node: Node
    ahead: list[Lead] = []
    """What stands on it, from left to right; the next body of the spine, if there is one."""
    rows: list[list[Limb]] = []
    """What leaves sideways, lowest first; in a row, one limb or one at each side."""
    lanes: list[float] = []
    """How high each row leaves (px), once it is known how large all is."""
    legs: list[Limb] = []
    """Limbs that hang straight down from the lower edge of the box, from the middle outwards."""


def spine(order: list[Node], shape: Shape) -> list[Vertebra] | None:
    """The spine, lowest body first; None where there is no shape worth following.

    There is one if at least one limb of two bodies or more has its mirror image, and all that
    the base carries is one robot, each limb at a point of its own.
    """
    base = order[0]
    if len(base.children) != 1 or not shape.pairs:
        return None
    leads = [lead for node in order[1:] for lead in node.leads]
    if any(lead.point is None or len(lead.nodes) > 1 for lead in leads):
        return None
    bones: list[Vertebra] = []
    node: Node | None = base.children[0]
    while node is not None:
        if len(node.leads) > LIMBS:
            return None
        bone, node = _vertebra(node, shape, lowest=not bones)
        bones.append(bone)
    limbs = [limb for bone in bones for row in (*bone.rows, bone.legs) for limb in row]
    if len(limbs) > LIMBS:
        return None
    if not any(limb.side > 0 and limb.depth > 1 for limb in limbs) and len(bones[-1].ahead) < 2:
        return None  # the partners are further out, as the fingers of an arm are
    for limb in limbs:
        outwards(limb.node, shape, limb.side)
    for child in (child for bone in bones for child in bone.node.children):
        partner = shape.limbs[child.name].partner
        if partner is not None and child.alike is not partner:
            _draw_alike(child, partner)
    for limb in limbs:
        rooms = [room(node, vertical=False) for node in limb.row]
        limb.low = max(low for _, low, _ in rooms)
        limb.high = max(low + 2 * aside for _, low, aside in rooms)
    return bones


def outwards(top: Node, shape: Shape, side: int) -> None:
    """Sort the children of a limb's bodies: from the middle of the robot outwards."""
    todo = [top]
    while todo:
        node = todo.pop()
        node.sort(lambda child: side * shape.aside(child))
        todo.extend(node.children)


def _draw_alike(one: Node, other: Node) -> None:
    todo = [(one, other)]
    while todo:
        one, other = todo.pop()
        if one.body is None or other.body is None or len(one.children) != len(other.children):
            continue
        one.alike, other.alike = other, one
        todo.extend(zip(one.children, other.children, strict=True))


def _vertebra(node: Node, shape: Shape, *, lowest: bool) -> tuple[Vertebra, Node | None]:
    """A body of the spine, and the next one above it."""
    bone = Vertebra(node)
    sideways, middle = [], []
    for lead in node.leads:
        limb = shape.limbs[lead.nodes[0].name]
        aside = limb.middle[0] / shape.size
        own = max(abs(limb.start[0]), abs(limb.at[0])) / shape.size
        if limb.partner is None and own <= MIDDLE and abs(aside) <= 4 * MIDDLE:
            middle.append((lead, limb))
        else:
            side = 1 if aside > 0 else -1
            sideways.append(Limb.of(lead, side, limb.start[2] / shape.size, limb.depth))
    height = shape.limbs[node.name].at[2] - MIDDLE * shape.size
    up = [pair for pair in middle if max(pair[1].at[2], pair[1].middle[2]) >= height]
    following: Node | None = None
    legs = _legs(sideways, shape) if lowest else []
    if up:
        taken = max(up, key=lambda pair: pair[1].bodies)
        middle.remove(taken)
        bone.ahead, following = [taken[0]], taken[0].nodes[0]
    elif not legs:
        rising = [limb for limb in sideways if _slope(limb, shape) > 0.7]
        bone.ahead = sorted(
            (limb.lead for limb in rising), key=lambda lead: shape.aside(lead.nodes[0])
        )
        sideways = [limb for limb in sideways if limb not in rising]
    if len(legs) != 2 or any(leg.depth <= SHORT for leg in legs):
        bone.legs = sorted(legs, key=lambda leg: abs(shape.aside(leg.node)))
        sideways = [limb for limb in sideways if limb not in legs]
        legs = []
    # what is in the middle, but has no place on the spine, goes where there are fewer
    for lead, limb in middle:
        side = 1 if sum(other.side for other in sideways) < 0 else -1
        sideways.append(Limb.of(lead, side, limb.start[2] / shape.size, limb.depth))
    sideways.sort(key=lambda limb: (limb not in legs, round(limb.height, 2)))
    bone.rows = _rows(sideways, shape)
    return bone, following


def _rows(limbs: list[Limb], shape: Shape) -> list[list[Limb]]:
    """Partners in one row; of the others, two that follow each other at different sides."""
    rows: list[list[Limb]] = []
    of = {limb.node.name: limb for limb in limbs}
    while of:
        limb = of.pop(next(iter(of)))
        partner = shape.limbs[limb.node.name].partner
        other = of.pop(partner.name, None) if partner is not None else None
        last = rows[-1] if rows else []
        if other is not None:
            other.side = -limb.side  # also if both are a little to one side
            rows.append([limb, other])
        elif len(last) == 1 and last[0].side != limb.side:
            last.append(limb)
        else:
            rows.append([limb])
    return rows


def _slope(limb: Limb, shape: Shape) -> float:
    """How steeply a limb rises, seen from the front."""
    seen = shape.limbs[limb.node.name]
    aside, rise = abs(seen.middle[0] - seen.start[0]), seen.middle[2] - seen.start[2]
    return rise / max(aside, 1e-9 * shape.size)


def _legs(limbs: list[Limb], shape: Shape) -> list[Limb]:
    """The limbs that lead down; where arms leave the same body as legs, the lower ones."""
    down = [limb for limb in limbs if _slope(limb, shape) < -0.5]
    heights = [limb.height for limb in down]
    if down and max(heights) - min(heights) > 0.15:
        down = [limb for limb in down if limb.height < (min(heights) + max(heights)) / 2]
    return down


def arrange(mbs: Mbs, order: list[Node], bones: list[Vertebra]) -> None:
    """Give everything its place; ``order`` is the base, then the bodies depth first."""
    base = order[0]
    # what runs out sideways is planned when it does
    ways = ways_of(order, 2, {bone.node.name for bone in bones})
    for node in reversed(order):
        if node.name in ways:
            plan_tree(node, ways[node.name], narrow=True)
    # the chain of the spine passes all names at one distance, and its boxes stand at the middle
    aside = max(room(node, vertical=True)[2] for node in (base, *(bone.node for bone in bones)))
    base.plan[True] = plan(base, True, [], wish=Wish(aside=aside))
    _, height, low, high = base.plan[True].box
    half = (high - low + GAP) / 2
    taken: list[Box] = [(0.0, half, -height, 0.0)]
    for bone in reversed(bones):
        bone.node.plan[True] = _grown(bone, half, aside)
    bottom = 0.0
    drawn = []
    for bone in bones:
        one = bone.node.plan[True]
        drawn.append((bone, one, bottom))
        bottom += one.box[1]
    for _, one, at in drawn:
        a0, a1, _, b1 = one.box
        taken.append((0.0, b1 - aside, at + a0, at + a1))
        for _, below, a, b, turn, _ in one.limbs:
            if turn == BACK:
                _, e1, f0, f1 = below.extent
                start = abs(b - aside)
                taken.append((start + f0, start + f1, at + a - e1, at + a))
    for bone, one, at in drawn:
        _sideways(bone, one, at, taken)
    whole = plan(base, True, base.leads, wish=Wish(aside=aside))
    put(mbs, base, (0.0, 0.0, 0.0, -1.0, 1.0, 0.0), whole)


def _grown(bone: Vertebra, half: float, aside: float) -> Plan:
    """A body of the spine with its legs, long enough for the lanes of what leaves sideways.

    ``half`` is the room that the base wants at each side of the middle, which is ``aside`` from
    the chain that carries the spine.
    """
    lanes, cursor = [], FORK - EDGE  # how high up the sides each row leaves
    for row in bone.rows:
        lanes.append(cursor + max(limb.low for limb in row))
        cursor = lanes[-1] + max(limb.high for limb in row) + GAP
    total = cursor - GAP + EDGE
    # of arrows to the side where the name is: how far up they are where the name ends
    share = (aside + half_name(bone.node)) / (2 * aside + EDGE)
    above = len(bone.ahead) > 1  # arrows come from above the name, else from below
    long = max(total, 2 * ceil(lanes[-1] * share)) if bone.rows else 0.0
    if above and bone.rows:
        long = 2 * (total + NAME)
    inside = EDGE if bone.legs else 0.0
    one = plan(bone.node, True, bone.ahead, wish=Wish(long=long, inside=inside, aside=aside))
    a0, a1, b0, b1 = one.box
    long = a1 - a0
    if bone.rows:
        start = (
            long / 2 + NAME if above else min((long - total) // 2, long / 2 // share - lanes[-1])
        )
        bone.lanes = [a0 + start + lane for lane in lanes]
    wide = max(b1 - aside, aside - b0, aside + FORK if bone.rows and above else 0.0)
    for side in (-1, 1):
        cursor = half + GAP / 2
        for limb in bone.legs:
            if limb.side != side or limb.lead.point is None:
                continue
            below = limb.node.plan[True]
            lane = cursor - below.extent[2]
            cursor = lane + below.extent[3] + GAP
            one.points.append((limb.lead.point, a0, aside + side * lane))
            one.limbs.append((limb.node, below, a0, aside + side * lane, BACK, side))
            wide = max(wide, lane + EDGE)
    one.box = (a0, a1, aside - wide, aside + wide)
    return one


def _sideways(bone: Vertebra, one: Plan, at: float, taken: list[Box]) -> None:
    """Place what leaves a body of the spine sideways, the lowest first.

    ``at`` is how high the body's own frame begins; what is placed is added to ``taken``.
    """
    _, _, b0, b1 = one.box
    edge = (b1 - b0) / 2
    for row, lane in zip(bone.rows, bone.lanes, strict=True):
        tries = [_run_out(limb, edge, at + lane, taken) for limb in row]
        partners = len(row) == 2 and row[0].node.alike is row[1].node
        for limb, (length, spread, out, boxes) in zip(row, tries, strict=True):
            if partners and tries[0][0] == tries[1][0]:
                # partners turn down at the same distance
                short = max(middle for _, _, middle, _ in tries) - out
                if short:
                    spread += short / _wires(limb, length)
                    boxes = _run(limb, length, edge, at + lane, spread)
            assert limb.lead.point is not None
            start = (b0 + b1) / 2 + limb.side * edge
            one.points.append((limb.lead.point, lane, start))
            below = limb.node.plan[False]
            one.limbs.append((limb.node, below, lane, start, limb.side, 1))
            taken += boxes


def _run_out(limb: Limb, edge: float, lane: float, taken: list[Box]) -> Run:
    """Let a limb run out until the column below its last body is clear of all that is taken.

    As few bodies run out as will do.
    """
    row = limb.row
    lengths = range(1, len(row) + 1) if limb.depth > SHORT else [len(row)]
    for length in lengths:
        spread = 0.0
        boxes = _run(limb, length, edge, lane)
        if len(boxes) > 1:
            inner, _, low, high = boxes[1]
            low, high = low - GAP, high + GAP
            beside = [outer for _, outer, bottom, top in taken if bottom < high and low < top]
            short = max(0.0, max(beside) + GAP - inner) if beside else 0.0
            spread = float(ceil(short / _wires(limb, length)))
            if spread > MOST and length < len(row):
                continue
            if spread:
                boxes = _run(limb, length, edge, lane, spread)
        a0, a1, _, _ = row[length - 1].plan[False].box
        return length, spread, boxes[0][1] - (a1 - a0) / 2, boxes
    raise AssertionError("a limb has at least one body")


def _wires(limb: Limb, length: int) -> int:
    """How many wires the bodies that run out have."""
    return sum(len(node.joints) for node in limb.row[:length])


def _run(limb: Limb, length: int, edge: float, lane: float, spread: float = 0.0) -> list[Box]:
    """Plan the bodies of a limb that run out, each wire longer by ``spread`` than it needs.

    Returns the lane that the limb takes, and the column below its last body that runs out.
    """
    row = limb.row[:length]
    turning = Wish(spread=spread, corner=True)
    last = plan(row[-1], False, [], row[-1].leads, wish=turning)
    row[-1].plan[False] = last
    start = edge
    for node in reversed(row[:-1]):
        node.plan[False] = plan(node, False, node.leads, wish=Wish(spread=spread))
        start += node.plan[False].box[1]
    top = lane + limb.high
    boxes = [(edge, start + last.box[1], lane - limb.low, top)]
    for _, below, a, b, _, _ in last.limbs:
        _, e1, f0, f1 = below.extent
        boxes.append((start + a + f0, start + a + f1, lane + b - e1, top))
    if len(boxes) > 2:
        inner, outer, low, high = zip(*boxes[1:], strict=True)
        boxes[1:] = [(min(inner), max(outer), min(low), max(high))]
    return boxes
