"""The robot as it stands before one: spine upright, limbs out to both sides and down.

The robot is seen from the front in its start pose: up is up, and its left is at the right, as
when somebody faces you.  From the body that the base carries, the spine goes up through the
bodies of the middle.  What leaves it sideways is a limb.  It runs out until it is clear of all
below, then turns down.  Higher limbs stand farther out, as arms do beside legs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import zip_longest

from urdf2mbs.arrange.boxes import AHEAD, BACK, EDGE, GAP, Lead, Node, Plan, Way, box_size, plan, put
from urdf2mbs.arrange.tree import plan_tree
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.spatial import HERE, ZERO, Pose, Vec, add, from_turn, multiply, rotate

ON_PLANE = 0.04
"""What is nearer to the plane of symmetry is in the middle (share of the robot's size)."""
ALIKE = 0.05
"""How far a limb may be off its partner's mirror image (share of the robot's size)."""
LIMBS = 24
"""More limbs than this at the spine are not a robot that one would recognise."""
SPREAD = 25.0
"""A wire may be so much longer (px) before one more body runs out."""
SHORT = 2
"""A limb of so few bodies one after the other does not turn down."""


@dataclass
class Limb:
    """What leaves the spine at one point, and where it is in the start pose (m)."""

    lead: Lead
    start: Vec
    middle: Vec
    """The mean of all its frames."""
    bodies: int
    depth: int
    """Bodies one after the other, at the most."""
    side: int = 0
    """1: its left, drawn at the right; -1: its right; 0: neither."""

    @property
    def node(self) -> Node:
        return self.lead.nodes[0]


@dataclass
class Vertebra:
    """A body of the spine and the limbs that leave it."""

    node: Node
    ahead: list[Limb] = field(default_factory=list)
    sideways: list[Limb] = field(default_factory=list)
    legs: list[Limb] = field(default_factory=list)
    """Limbs that hang straight down from the lower edge of the box."""


Box = tuple[float, float, float, float]
"""Inner, outer, bottom, top (px): x counted outwards from the spine, both sides as one, so that
what is alike at both sides is drawn alike; y up from the base."""


def spine(order: list[Node]) -> list[Vertebra] | None:
    """The spine, lowest body first; None where there is no shape worth following.

    There is one if at least one limb of two bodies or more has its mirror image, and all that
    the base carries is one robot.
    """
    base = order[0]
    if len(base.children) != 1 or any(len(lead.nodes) > 1 for n in order for lead in n.leads):
        return None
    if any(lead.point is None for node in order[1:] for lead in node.leads):
        return None
    frames, starts = _pose(order)
    size = _size([at.xyz for at in frames.values()])
    if size == 0.0:
        return None
    below = _below(order, frames)
    found: list[tuple[int, list[Vertebra]]] = []
    for axis in (1, 0):
        bones = _spine(base.children[0], axis, size, frames, starts, below)
        pairs = sum(_pairs(bone.sideways + bone.legs, axis, size) for bone in bones)
        found.append((pairs, bones))
    pairs, bones = max(found, key=lambda one: one[0])
    limbs = sum(len(bone.sideways) + len(bone.legs) for bone in bones)
    return bones if pairs and limbs <= LIMBS else None


def _pose(order: list[Node]) -> tuple[dict[int, Pose], dict[int, Vec]]:
    """Each body's frame, and where its parent's point is, in the start pose."""
    frames: dict[int, Pose] = {id(order[0]): HERE}
    starts: dict[int, Vec] = {}
    for node in order:
        here = frames[id(node)]
        for lead in node.leads:
            shift = ZERO if lead.point is None else lead.point.coordinates
            at = add(here.xyz, rotate(here.rot, shift))
            for child in lead.nodes:
                starts[id(child)] = at
                xyz, rot = at, here.rot
                for joint in child.body.joints if child.body is not None else ():
                    k, q = int(joint.type[1]), joint.q or 0.0
                    if joint.type[0] == "R":
                        rot = multiply(rot, from_turn((k, q)))
                    else:
                        along = (q * (k == 1), q * (k == 2), q * (k == 3))
                        xyz = add(xyz, rotate(rot, along))
                frames[id(child)] = Pose(xyz, rot)
    return frames, starts


def _size(places: list[Vec]) -> float:
    return max(max(at[k] for at in places[1:]) - min(at[k] for at in places[1:]) for k in range(3))


def _below(order: list[Node], frames: dict[int, Pose]) -> dict[int, tuple[int, int, Vec]]:
    """Of each body with all below it: bodies, depth, and the sum of their places."""
    below: dict[int, tuple[int, int, Vec]] = {}
    for node in reversed(order):
        bodies, depth, total = 1, 0, frames[id(node)].xyz
        for child in node.children:
            more, deep, places = below[id(child)]
            bodies, depth, total = bodies + more, max(depth, deep), add(total, places)
        below[id(node)] = (bodies, depth + 1, total)
    return below


def _spine(
    root: Node,
    axis: int,
    size: float,
    frames: dict[int, Pose],
    starts: dict[int, Vec],
    below: dict[int, tuple[int, int, Vec]],
) -> list[Vertebra]:
    middle = frames[id(root)].xyz[axis]
    near = ON_PLANE * size
    bones: list[Vertebra] = []
    node: Node | None = root
    while node is not None:
        bone = Vertebra(node)
        bones.append(bone)
        limbs = []
        for lead in node.leads:
            child = lead.nodes[0]
            bodies, depth, (x, y, z) = below[id(child)]
            start = starts[id(child)]
            # the place where it leaves counts as one of its own
            mean = (
                (x + start[0]) / (bodies + 1), (y + start[1]) / (bodies + 1),
                (z + start[2]) / (bodies + 1),
            )  # fmt: skip
            limb = Limb(lead, start, mean, bodies, depth)
            aside = mean[axis] - middle
            limb.side = 0 if abs(aside) <= near else 1 if aside > 0 else -1
            limbs.append(limb)
        height = frames[id(node)].xyz[2]
        up = [limb for limb in limbs if limb.side == 0 and limb.middle[2] >= height - near]
        node = None
        if up:
            next_ = max(up, key=lambda limb: limb.bodies)
            bone.ahead.append(next_)
            limbs.remove(next_)
            node = next_.node
        if node is None:
            rising = [limb for limb in limbs if limb.side and _steep(limb, axis) > 0.7]
            bone.ahead = sorted(bone.ahead + rising, key=lambda limb: limb.middle[axis])
            limbs = [limb for limb in limbs if limb not in rising]
        down = [limb for limb in limbs if limb.side and _steep(limb, axis) < -0.5]
        _sort(bone, limbs, down if len(bones) == 1 else [], axis, size)
    return bones


def _steep(limb: Limb, axis: int) -> float:
    """The slope at which a limb rises, seen from the front."""
    rise, aside = limb.middle[2] - limb.start[2], abs(limb.middle[axis] - limb.start[axis])
    return rise / max(aside, 1e-9)


def _sort(bone: Vertebra, limbs: list[Limb], down: list[Limb], axis: int, size: float) -> None:
    """Which limbs leave sideways and which hang down; lowest lanes first."""
    if down:
        low, high = min(x.start[2] for x in down), max(x.start[2] for x in down)
        if high - low > 0.15 * size:  # arms and legs leave the same body
            down = [limb for limb in down if limb.start[2] < (low + high) / 2]
    sides = [sum(limb.side == side for limb in down) for side in (-1, 1)]
    if sides != [1, 1] or any(limb.depth <= SHORT for limb in down):
        bone.legs = sorted(down, key=lambda limb: abs(limb.middle[axis]))
        down = []
    count = {-1: 0, 1: 0}
    for limb in limbs:
        count[limb.side or 1] += 1 if limb.side else 0
    for limb in limbs:
        if limb.side == 0:
            limb.side = -1 if count[-1] < count[1] else 1
            count[limb.side] += 1
    legs = {id(limb) for limb in bone.legs}
    first = {id(limb) for limb in down}
    bone.sideways = sorted(
        (limb for limb in limbs if id(limb) not in legs),
        key=lambda limb: (id(limb) not in first, round(limb.start[2] / size, 2)),
    )


def _pairs(limbs: list[Limb], axis: int, size: float) -> int:
    """How many limbs of two bodies or more have a mirror image."""
    pairs = 0
    for one in limbs:
        for other in limbs:
            if one.side == 1 and other.side == -1 and one.bodies == other.bodies > 1:
                mirrored = list(other.start)
                mirrored[axis] = -mirrored[axis]
                off = max(abs(a - b) for a, b in zip(one.start, mirrored, strict=True))
                pairs += off <= ALIKE * size
    return pairs


def arrange(mbs: Mbs, order: list[Node], bones: list[Vertebra]) -> None:
    """Give everything its place; ``order`` is the base, then the bodies depth first."""
    base, root = order[0], bones[0].node
    for node in reversed(order):
        if node is not base:
            plan_tree(node)
    base.plan[True] = plan(base, True, [])
    half = base.plan[True].box[3] + GAP / 2
    taken: list[Box] = [(0.0, half, -base.plan[True].box[1], 0.0)]
    bottom = 0.0
    drawn = []
    for bone in bones:
        one = _vertebra(bone, half)
        drawn.append((bone, one, bottom))
        bottom += one.box[1]
    for _, one, at in drawn:
        a0, a1, _, b1 = one.box
        taken.append((0.0, b1, at + a0, at + a1))
        for _, below, a, b, turn, _ in one.limbs:
            if turn == BACK:
                _, e1, f0, f1 = below.extent
                taken.append((abs(b) + f0, abs(b) + f1, at + a - e1, at + a))
    for bone, one, at in drawn:
        _sideways(bone, one, at, taken)
        bone.node.plan[True] = one
    for bone, one, _ in drawn:
        one.limbs = [
            (node, node.plan[True] if turn == AHEAD else below, a, b, turn, mirror)
            for node, below, a, b, turn, mirror in one.limbs
        ]
    root_first = plan(base, True, base.leads)
    put(mbs, base, Way(0.0, 0.0, (0.0, -1.0), (1.0, 0.0)), root_first)


def _vertebra(bone: Vertebra, half: float) -> Plan:
    """A body of the spine with its legs, long enough for the lanes of what leaves sideways.

    ``half`` is the room that the base wants at each side of the chain that carries the spine.
    """
    rooms = [_room([limb for limb in bone.sideways if limb.side == side]) for side in (-1, 1)]
    one = plan(bone.node, True, [limb.lead for limb in bone.ahead], long=max(rooms))
    a0, a1, b0, b1 = one.box
    for side in (-1, 1):
        cursor = half + GAP / 2
        for limb in bone.legs:
            if limb.side != side or limb.lead.point is None:
                continue
            below = limb.node.plan[True]
            lane = side * (cursor - below.extent[2])
            cursor = abs(lane) + below.extent[3] + GAP
            one.points.append((limb.lead.point, a0, lane))
            one.limbs.append((limb.node, below, a0, lane, BACK, side))
            b0, b1 = min(b0, lane - EDGE), max(b1, lane + EDGE)
    wide = max(b1, -b0)
    one.box = (a0, a1, -wide, wide)
    return one


def _room(limbs: list[Limb]) -> float:
    """How long the side of a box must be for the lanes of these limbs."""
    return sum(_lane(limb) for limb in limbs) + GAP * (len(limbs) - 1) + 2 * EDGE if limbs else 0.0


def _lane(limb: Limb) -> float:
    """The height of the lane in which a limb runs out."""
    return max(height for _, height in map(box_size, _row(limb)))


def _row(limb: Limb) -> list[Node]:
    """The bodies that can run out one after the other; a limb turns down at the latest where
    it branches."""
    row = [limb.node]
    while len(row[-1].children) == 1:
        row.append(row[-1].children[0])
    return row


def _sideways(bone: Vertebra, one: Plan, at: float, taken: list[Box]) -> None:
    """Place what leaves a body of the spine sideways, the lowest first.

    ``at`` is how high the body's own frame begins; what is placed is added to ``taken``.
    """
    a0, a1, _, edge = one.box
    sides = [[limb for limb in bone.sideways if limb.side == side] for side in (1, -1)]
    lanes = {}
    for limbs in sides:
        cursor = (a0 + a1 - _room(limbs)) / 2 + EDGE
        for limb in limbs:
            lanes[limb.node.name] = cursor + _lane(limb) / 2
            cursor += _lane(limb) + GAP
    for pair in zip_longest(*sides):
        limbs = [limb for limb in pair if limb is not None]
        tries = [_run_out(limb, edge, at + lanes[limb.node.name], taken) for limb in limbs]
        column = max(middle for _, middle in tries)
        for limb, (length, middle) in zip(limbs, tries, strict=True):
            if [t[0] for t in tries] == [length] * 2:
                # partners turn down at the same distance
                _run(limb, length, (column - middle) / _wires(limb, length))
            lane, lead = lanes[limb.node.name], limb.lead
            assert lead.point is not None
            one.points.append((lead.point, lane, limb.side * edge))
            below = limb.node.plan[False]
            one.limbs.append((limb.node, below, lane, limb.side * edge, limb.side, 1))
            taken.extend(_boxes(limb, length, edge, at + lane))


def _run_out(limb: Limb, edge: float, lane: float, taken: list[Box]) -> tuple[int, float]:
    """How many bodies of a limb run out before it turns down, and where the last one's middle is.

    As few as will do: the column below the last one must be clear of all that is taken.
    """
    row = _row(limb)
    lengths = range(1, len(row) + 1) if limb.depth > SHORT else [len(row)]
    for length in lengths:
        _run(limb, length, 0.0)
        lane_box, *column = _boxes(limb, length, edge, lane)
        if column:
            inner, _, low, high = column[0]
            clear = max(
                (b[1] + GAP for b in taken if b[2] < high + GAP and low - GAP < b[3]), default=0.0
            )
            short = max(0.0, clear - inner)
            spread = short / _wires(limb, length)
            if spread > SPREAD and length < len(row):
                continue
            _run(limb, length, spread)
            lane_box = _boxes(limb, length, edge, lane)[0]
        a0, a1, _, _ = row[length - 1].plan[False].box
        return length, lane_box[1] - (a1 - a0) / 2
    raise AssertionError("a limb has at least one body")


def _wires(limb: Limb, length: int) -> int:
    """How many wires the bodies that run out have."""
    return sum(len(node.body.joints) for node in _row(limb)[:length] if node.body is not None)


def _run(limb: Limb, length: int, spread: float) -> None:
    """Plan the bodies of a limb that run out, each wire longer by ``spread`` than it needs."""
    row = _row(limb)[:length]
    row[-1].plan[False] = plan(row[-1], False, [], row[-1].leads, spread=spread)
    for node in reversed(row[:-1]):
        node.plan[False] = plan(node, False, node.leads, spread=spread)


def _boxes(limb: Limb, length: int, edge: float, lane: float) -> list[Box]:
    """The lane that a limb takes, and the column below its last body that runs out."""
    row = _row(limb)[:length]
    start = edge + sum(node.plan[False].box[1] for node in row[:-1])
    last = row[-1].plan[False]
    half = _lane(limb) / 2
    boxes = [(edge, start + last.box[1], lane - half, lane + half)]
    for _, below, a, b, _, _ in last.limbs:
        _, e1, f0, f1 = below.extent
        boxes.append((start + a + f0, start + a + f1, lane + b - e1, lane + half))
    if len(boxes) > 2:
        inner, outer, low, high = zip(*boxes[1:], strict=True)
        boxes[1:] = [(min(inner), max(outer), min(low), max(high))]
    return boxes
