"""Align frames: turn each body's frame so that a coordinate axis lies along its joint's axis.

Beyond the method.  The method's Table A.2 turns the frame before a joint, and turns it back after
the joint.  Turning back is never needed: whatever is constant in a body can be written in any
frame.  So centre, inertia, points, visuals and the next joints are written in the frame that the
joint leaves.  The turns before a joint bring a coordinate axis onto the joint's direction ``u``.
No turn is needed if u is +x, +y or +z.  One turn is needed if u has a zero component or is a
negative axis, else two.  The joint's coordinate stays the URDF's: same zero, same sign.

Each body's frame may have any angle about its own joint's axis.  The pass tries the angles that
put a coordinate axis of the frame in line with

* the axis of the joint before: then this joint needs the fewest turns;
* the axes of the joints that the body carries, and of the joints behind parallel joints: then
  those joints need fewer turns;
* the other axes of the frame before.

The pass tries each of these angles with 0, 1, 2 and 3 quarter turns more.  Dynamic programming,
from the tips of the tree to the base, finds the choice with the fewest turns in all.
"""

from __future__ import annotations

from collections import Counter
from math import atan2, hypot, pi
from typing import Annotated, Literal

import msgspec

from urdf2mbs.conversion import Conversion, Step
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.ranges import Tolerance
from urdf2mbs.spatial import (
    IDENTITY,
    ROUNDING,
    Pose,
    Rot,
    Turn,
    Vec,
    axis_turns,
    cross,
    direction,
    dot,
    drop_rounding,
    fewest_turns,
    from_turns,
    multiply,
    rotate,
    transpose,
    unit,
)
from urdf2mbs.urdf.model import Joint

X, Y, Z = AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class AlignFrames(Pass):
    reads = ("robot", "bodies")
    writes = ("bodies",)

    axes: Literal["x", "y", "z", "any"] = "any"
    """The coordinate axis that joints act about or along."""
    candidates: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 12
    """The number of frames considered for each body, quarter turns not counted."""
    tolerance: Tolerance = ROUNDING
    """A direction counts as on a coordinate axis or plane if it is at most this (rad) off.  The
    default is rounding; 1e-9 also takes angles written as 1.570796327, and says how far off they
    are."""
    flip: bool = False
    """Let a joint count the other way round if this saves a driven joint.  The joint is then called
    NAME_flipped, and its coordinate is minus the URDF's."""

    def run(self, conversion: Conversion) -> None:
        nodes, steps = _tree(conversion)
        search = _Search(self, len(nodes))
        for node in reversed(nodes):
            search.collect_wanted(node)
        for node in nodes:
            search.list_frames(node)
        for node in reversed(nodes[1:]):
            search.count(node)
        for node in nodes[1:]:
            search.choose(node, conversion)
        conversion.facts["align-frames"] = {
            "driven": sum(
                len(step.turns) + len(step.after) for step, *_ in steps if step.joint.moves
            )
        }

        after: dict[int, Rot] = {}
        for step, node, offset, before, offset_before in steps:
            step.xyz = drop_rounding(rotate(multiply(before.held, offset_before), step.xyz))
            if not step.joint.moves:
                step.turns = ()
            after[id(step)] = multiply(node.held, offset)
            step.frames = _turn(after[id(step)], step.frames)
        for segment in conversion.segments.values():
            if segment.steps:
                segment.parts = _turn(after[id(segment.steps[-1])], segment.parts)


def _turn(rot: Rot, frames: dict[str, Pose]) -> dict[str, Pose]:
    return {
        link: Pose(drop_rounding(rotate(rot, pose.xyz)), multiply(rot, pose.rot))
        for link, pose in frames.items()
    }


class _Node:
    """A joint that moves, and the possible frames of the link behind the joint.

    The first node is the ground.  A frame is a rotation in the link's own frame.
    """

    def __init__(self, step: Step, parent: _Node | None, rot: Rot) -> None:
        self.step = step
        self.parent = parent or self
        self.rot = rot
        """The link's frame in the frame of the parent node's link, at zero."""
        self.kind = step.joint.type if parent else "ground"
        self.turns_freely = self.kind not in ("ground", "floating", "planar")
        """True if the frame may be turned about the joint's axis at will."""
        self.axis = direction(step.axis)
        self.along = rotate(rot, self.axis)
        """The joint's axis in the frame of the parent node's link, at zero."""
        self.children: list[_Node] = []
        self.wanted: list[tuple[Vec, int]] = []
        """Directions at right angles to the axis, and for each the number of joints behind this
        joint that need fewer turns if the frame has a coordinate axis in this direction."""
        self.frames: list[Rot] = []
        """The possible frames; frames that differ by quarter turns stand together.  A joint that
        carries no other joint has none, if any axis will do."""
        self.costs: list[int] = []
        """For each frame, the fewest turns that all joints behind it need."""
        self.picks: list[int] = []
        """For each frame of the parent, the number of the best frame here."""
        self.chosen = 0
        """The number of the chosen frame."""
        self.held = IDENTITY
        """The rotation of the link in its body's new frame."""


def _tree(
    conversion: Conversion,
) -> tuple[list[_Node], list[tuple[Step, _Node, Rot, _Node, Rot]]]:
    """All joints that move, parents first; and all steps.

    A step stands with the node that its link belongs to and the link's rotation in the node's
    link, then with the same two of the link before the step.
    """
    ground = conversion.ground.link
    nodes = [_Node(Step.of(Joint("", "fixed", "", ground)), None, IDENTITY)]
    steps: list[tuple[Step, _Node, Rot, _Node, Rot]] = []
    ends = {ground: (nodes[0], IDENTITY)}
    for segment in conversion.segments.values():
        if segment.parent is None:
            continue
        node, offset = ends[segment.parent]
        for step in segment.steps:
            before = node, offset
            offset = multiply(offset, from_turns(step.turns))
            if step.joint.moves:
                nodes.append(_Node(step, node, offset))
                node.children.append(nodes[-1])
                node, offset = nodes[-1], IDENTITY
            steps.append((step, node, offset, *before))
        ends[segment.link] = node, offset
    return nodes, steps


class _Search:
    """The search for the frames that need the fewest turns.

    With any axis allowed, frames that differ by a cyclic exchange of x, y and z are equally good
    for all joints behind.  So the search considers only frames whose x is the joint's axis, and
    counts the turns before the joint up to an exchange.
    """

    def __init__(self, options: AlignFrames, joints: int) -> None:
        self.small = options.tolerance
        self.any = options.axes == "any"
        self.ks = (1, 2, 3) if self.any else ("xyz".index(options.axes) + 1,)
        self.candidates = options.candidates
        self.flip = options.flip
        self.weight = joints if self.flip else 1
        """The cost of a turn; a flipped joint costs 1.  So the search saves turns first, and then
        flipped joints."""

    # --- turns ---

    def zeros(self, u: tuple[float, ...]) -> int:
        """The number of components of a direction that are zero."""
        x, y, z = u
        small = self.small
        return (abs(x) <= small) + (abs(y) <= small) + (abs(z) <= small)

    def least(self, u: Vec) -> int:
        """The fewest turns that bring a coordinate axis onto a direction."""
        zeros = self.zeros(u)
        return 2 - zeros if zeros < 2 else int(sum(u) < 0.0 and not self.flip)

    def turns(self, rot: Rot) -> int:
        """The number of turns of a rotation; with any axis allowed, up to an exchange of axes."""
        if not self.any:
            return len(fewest_turns(rot, self.small))
        # two turns leave some element zero, one turn some element one
        a, b, c, d, e, f, g, h, i = rot
        small = self.small
        one = (abs(a) <= small) + (abs(b) <= small) + (abs(c) <= small)
        two = (abs(d) <= small) + (abs(e) <= small) + (abs(f) <= small)
        three = (abs(g) <= small) + (abs(h) <= small) + (abs(i) <= small)
        if not (one or two or three):
            return 3
        ones = (one == 2 and a + b + c > 0.0) + (two == 2 and d + e + f > 0.0)
        return (2, 1, 1, 0)[ones + (three == 2 and g + h + i > 0.0)]

    def fewest(self, rot: Rot) -> tuple[tuple[Turn, ...], int]:
        """The fewest turns of a rotation, and the axis (1, 2, 3) that ends up on the joint's."""
        ways = ((fewest_turns(_exchange(rot, k - self.ks[0]), self.small), k) for k in self.ks)
        return min(ways, key=lambda way: len(way[0]))

    # --- the frames to choose from ---

    def frames(self, axis: Vec, across: Vec) -> list[Rot]:
        """The four frames with an axis along ``axis`` and another axis on the line ``across``; with
        ``flip``, then the four frames of the flipped joint."""
        return [
            frame
            for along in ((axis, _back(axis)) if self.flip else (axis,))
            for frame in _quarters(self.ks[0], along, across)
        ]

    def collect_wanted(self, node: _Node) -> None:
        """Find the directions in which the joints behind a node want an axis of its frame."""
        if not node.turns_freely or not node.children:
            return
        directions = _Directions(node.axis, self.small)
        for child in node.children:
            if child.kind == "floating":
                continue
            directions.add(child.along)
            # two turns between two frames are enough if an axis of the first frame is at right
            # angles to an axis of the second frame
            for wanted, count in child.wanted:
                directions.add(rotate(child.rot, wanted), count)
                directions.add(rotate(child.rot, cross(child.axis, wanted)), count)
        pairs = zip(directions.vectors, directions.counts.values(), strict=True)
        node.wanted = sorted(pairs, key=lambda pair: -pair[1])[: self.candidates]

    def list_frames(self, node: _Node) -> None:
        """List the frames to choose from for a node."""
        if node.kind == "ground":
            node.frames = [IDENTITY]
        elif node.kind == "floating":
            node.frames = self._free_frames(node)
        elif node.kind == "planar":  # its three coordinates are along given axes
            turns, k = axis_turns(node.axis)
            node.frames = [_exchange(from_turns(turns), self.ks[0] - k)]
        elif node.children or not self.any:
            node.frames = [
                frame for across in self._consider(node) for frame in self.frames(node.axis, across)
            ]
        # with flip, the last four of eight frames flip this joint
        node.costs = [
            int(node.turns_freely and number % 8 > 3 and self.flip)
            for number in range(len(node.frames))
        ]

    def _consider(self, node: _Node) -> list[Vec]:
        """Directions at right angles to the joint's axis.  The search tries a frame with a
        coordinate axis in each direction."""
        parent, back = node.parent, transpose(node.rot)
        # frames that differ by quarter turns have the same axes
        group = 1 if not parent.turns_freely else 8 if self.flip else 4
        axes = [
            rotate(back, (frame[i], frame[i + 3], frame[i + 6]))
            for frame in parent.frames[::group]
            for i in range(3)
        ]
        directions = _Directions(node.axis, self.small)
        room = self.candidates
        if parent.turns_freely:
            directions.add(rotate(back, parent.axis))
        if not directions.vectors:  # the parent's axis is parallel, or the parent cannot turn
            for axis in axes:
                directions.add(axis)
        if not parent.turns_freely:
            room = max(room, len(directions.vectors))
        for wanted, _ in node.wanted:
            directions.add(wanted)
        if len(directions.vectors) < room:
            for axis in axes:
                directions.add(axis)
        return directions.vectors[:room]

    def _free_frames(self, node: _Node) -> list[Rot]:
        """Frames for the link behind a floating joint.

        The joint's own frame is fixed: its coordinates are along given axes.  A turn after the
        joint costs one driven joint, and may save a driven joint at each of the joints behind.
        """
        lines: dict[tuple[int, ...], Vec] = {}
        counts: Counter[tuple[int, ...]] = Counter()
        for child in node.children:
            if child.kind != "floating":
                key = tuple(round(c * 1e9) for c in child.along)
                lines[key] = child.along
                counts[key] += 1
        most = [(lines[key], count) for key, count in counts.most_common(self.candidates)]
        ways: list[tuple[Turn, ...]] = [()]
        for (x, y, z), _ in most:
            for k, p, q in ((1, y, z), (2, z, x), (3, x, y)):
                if hypot(p, q) > self.small:
                    ways += [((k, atan2(q, p) + quarter * pi / 2),) for quarter in range(-2, 2)]
            ways += [axis_turns((x, y, z))[0], axis_turns((-x, -y, -z))[0]]
        frames = {turns: from_turns(turns) for turns in ways}
        costs = {
            turns: len(turns)
            + sum(count * self.least(rotate(transpose(frame), u)) for u, count in most)
            for turns, frame in frames.items()
        }
        worth = sorted(
            (turns for turns in frames if costs[turns] <= costs[()]), key=costs.__getitem__
        )
        return [frames[turns] for turns in {**dict.fromkeys(worth[: self.candidates]), (): None}]

    # --- the best choice ---

    def count(self, node: _Node) -> None:
        """Add to each frame of the parent the fewest turns of this branch."""
        parent = node.parent
        for number, frame in enumerate(parent.frames):
            back = transpose(frame)
            if node.frames:
                cost, pick = self._best(node, multiply(back, node.rot))
                node.picks.append(pick)
            else:
                u = rotate(back, node.along)
                least = self.least(u)
                cost = self.weight * least + int(self.flip and not least and sum(u) < 0.0)
            parent.costs[number] += cost

    def _best(self, node: _Node, before: Rot) -> tuple[int, int]:
        """The cost of a node's best frame, and the frame's number.

        ``before`` is the rotation of the node's link in the parent's frame.
        """
        own = len(fewest_turns(before))
        best, pick = min(node.costs) + 99 * self.weight, 0
        for number, (frame, cost) in enumerate(zip(node.frames, node.costs, strict=True)):
            if cost < best:
                turns = (
                    own + len(fewest_turns(frame)) if node.kind == "floating"
                    else self.turns(multiply(before, frame))
                )  # fmt: skip
                if cost + self.weight * turns < best:
                    best, pick = cost + self.weight * turns, number
        return best, pick

    def choose(self, node: _Node, conversion: Conversion) -> None:
        """Give a joint its turns; the joints before it must have theirs."""
        step, k = node.step, 1
        rot = multiply(node.parent.held, node.rot)
        if node.picks:
            node.chosen = node.picks[node.parent.chosen]
        if node.kind == "floating":
            step.turns = fewest_turns(rot)
            step.after = fewest_turns(node.frames[node.chosen])
        elif node.frames:
            step.turns, k = self.fewest(multiply(rot, node.frames[node.chosen]))
        else:
            ways = (
                self.fewest(multiply(rot, frame))
                for axis in AXES
                if (across := _across(rotate(transpose(rot), axis), node.axis, self.small))
                for frame in self.frames(node.axis, across)
            )
            step.turns, k = min(ways, key=lambda way: len(way[0]))
        held = multiply(transpose(from_turns(step.turns)), rot)
        along = AXES[k - 1]
        step.flipped = self.flip and node.turns_freely and dot(rotate(held, node.axis), along) < 0
        _note_axis_off(conversion, step, held, _back(along) if step.flipped else along)
        step.axis = along
        node.held = multiply(transpose(from_turns(step.after)), held) if step.after else held


def _note_axis_off(conversion: Conversion, step: Step, held: Rot, axis: Vec) -> None:
    if step.joint.type == "floating":
        return
    meant = rotate(held, unit(step.axis))
    off = max(abs(a - b) for a, b in zip(meant, axis, strict=True))
    if off > ROUNDING:
        conversion.note(
            "axis-aligned",
            f"joint '{step.joint.name}': its axis is {off:.1e} rad off a coordinate "
            "axis or plane of its body, and is taken to lie on it",
            joint=step.joint.name,
        )


class _Directions:
    """Directions at right angles to an axis; directions a quarter turn apart count as one."""

    def __init__(self, axis: Vec, small: float) -> None:
        self._axis, self._small = axis, small
        # directions count as one if they differ by up to ten times the tolerance
        self._quarter = max(round(pi / 2 / (10 * small)), 1)
        x, y, z = map(abs, axis)
        smallest = X if x <= y and x <= z else Y if y <= z else Z
        self._one = cross(axis, smallest)
        self._two = cross(axis, self._one)
        self.counts: dict[int, int] = {}
        """The number of joints for each direction, in the order of ``vectors``."""
        self.vectors: list[Vec] = []

    def add(self, v: Vec, count: int = 1) -> None:
        """Add the direction of the part of ``v`` at right angles to the axis, if it has one."""
        across = _across(v, self._axis, self._small)
        if across is None:
            return
        angle = atan2(dot(across, self._two), dot(across, self._one))
        key = round(angle / (pi / 2) * self._quarter) % self._quarter
        if key not in self.counts:
            self.vectors.append(across)
        self.counts[key] = self.counts.get(key, 0) + count


def _across(v: Vec, axis: Vec, small: float) -> Vec | None:
    """The direction of the part of v at right angles to the axis; None if v is along the axis."""
    a, b, c = axis
    x, y, z = v
    for _ in range(2):  # if v is nearly along the axis, the second round removes the rounding
        along = x * a + y * b + z * c
        x, y, z = x - along * a, y - along * b, z - along * c
        length = hypot(x, y, z)
        if length <= small:
            return None
        x, y, z = x / length, y / length, z / length
    return (x, y, z)


def _quarters(k: int, axis: Vec, across: Vec) -> list[Rot]:
    """The frames with axis k along ``axis`` and another axis on the line ``across``."""
    up = cross(axis, across)
    back, left = _back(across), _back(up)
    pairs = ((across, up), (up, back), (back, left), (left, across))
    return [_exchange(transpose((*axis, *one, *two)), k - 1) for one, two in pairs]


def _back(v: Vec) -> Vec:
    return (-v[0], -v[1], -v[2])


def _exchange(rot: Rot, by: int) -> Rot:
    """The same frame with its axes renumbered: x, y, z become y, z, x if ``by`` is 1, and so on."""
    a, b, c, d, e, f, g, h, i = rot
    if by % 3 == 1:
        return (c, a, b, f, d, e, i, g, h)
    if by % 3 == 2:
        return (b, c, a, e, f, d, h, i, g)
    return rot
