"""Align frames: each body's frame is chosen so that its joint's axis is a coordinate axis.

Beyond the method, whose Table A.2 turns the frame before a joint and turns it back after.
Anything constant in a body can be expressed in any frame, so turning back is never needed:
centre, inertia, points, visuals and the joints that follow are expressed in the frame that the
joint leaves.  The turns before a joint must bring a coordinate axis onto the joint's direction
``u``: none if u is +x, +y or +z; one if u has a zero component or is a negative axis; two
otherwise.  The joint's coordinate stays the URDF's: same zero, same sign.

One thing is free: how far a body's frame is turned about its joint's own axis.  The pass tries
the turns that put a coordinate axis of the frame in line with one of these:

* the axis of the joint before: then this joint needs the fewest turns;
* the axes of the joints that the body carries, or that follow on joints parallel to its own:
  then those joints need fewer;
* the other axes of the frame before.

Each is tried with 0, 1, 2 and 3 quarter turns more.  Dynamic programming, from the tips of the
tree back to the base, finds the choice with the fewest turns in all.
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
    """How many frames, quarter turns not counted, are considered for each body."""
    tolerance: Tolerance = ROUNDING
    """Up to this (rad) a direction off a coordinate axis or plane counts as on it.  The default
    is rounding; 1e-9 also takes angles written as 1.570796327, and says how far off each is."""
    flip: bool = False
    """Let a joint count the other way round where that saves a driven joint; it is then called
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
            ),
            "bound": _Bound(self).fewest(nodes) if search.any else None,
        }

        after: dict[int, Rot] = {}
        for step, node, offset, before, offset_before in steps:
            step.xyz = rotate(multiply(before.held, offset_before), step.xyz)
            if not step.joint.moves:
                step.turns = ()
            after[id(step)] = multiply(node.held, offset)
            step.frames = _turned(after[id(step)], step.frames)
        for segment in conversion.segments.values():
            if segment.steps:
                segment.parts = _turned(after[id(segment.steps[-1])], segment.parts)


def _turned(rot: Rot, frames: dict[str, Pose]) -> dict[str, Pose]:
    return {
        link: Pose(rotate(rot, pose.xyz), multiply(rot, pose.rot)) for link, pose in frames.items()
    }


class _Node:
    """A joint that moves, and the frames to choose from for the link behind it.

    The first node is the ground.  A frame is a rotation in the link's own frame.
    """

    def __init__(self, step: Step, parent: _Node | None, rot: Rot) -> None:
        self.step = step
        self.parent = parent or self
        self.rot = rot
        """The link's frame in that of the parent node's link, at zero."""
        self.kind = step.joint.type if parent else "ground"
        self.turns_freely = self.kind not in ("ground", "floating", "planar")
        """True if the frame may be turned about the joint's axis at will."""
        self.axis = direction(step.axis)
        self.along = rotate(rot, self.axis)
        """The joint's axis in the frame of the parent node's link, at zero."""
        self.children: list[_Node] = []
        self.wanted: list[tuple[Vec, int]] = []
        """Directions at right angles to the axis.  Joints behind this one need fewer turns if its
        frame has a coordinate axis in such a direction; the number says how many joints."""
        self.frames: list[Rot] = []
        """The frames to choose from; none for a joint that carries no other, if any axis will do.
        Those that differ by quarter turns stand together."""
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
    """All joints that move, parents first.  And all steps, each with the node whose frame its
    own link is in and the link's rotation in it, then the same of the link before."""
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

    With any axis allowed, frames that differ by a cyclic exchange of x, y and z are as good as
    one another for all that follows.  So only those are considered that have the joint's axis
    first, and the turns before it are counted up to an exchange.
    """

    def __init__(self, options: AlignFrames, joints: int = 1) -> None:
        self.small = options.tolerance
        self.any = options.axes == "any"
        self.ks = (1, 2, 3) if self.any else ("xyz".index(options.axes) + 1,)
        self.candidates = options.candidates
        self.flip = options.flip
        self.weight = joints if self.flip else 1
        """What a turn costs; a joint that counts the other way round costs one.  So the fewest
        turns come first, and then the fewest such joints."""

    # --- turns ---

    def zeros(self, u: tuple[float, ...]) -> int:
        """How many components of a direction are zero."""
        x, y, z = u
        small = self.small
        return (abs(x) <= small) + (abs(y) <= small) + (abs(z) <= small)

    def least(self, u: Vec) -> int:
        """The fewest turns that bring a coordinate axis onto a direction."""
        zeros = self.zeros(u)
        return 2 - zeros if zeros < 2 else int(sum(u) < 0.0 and not self.flip)

    def turns(self, rot: Rot) -> int:
        """How many turns a rotation takes; with any axis allowed, up to an exchange of axes."""
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
        """The turns themselves, and the axis (1, 2, 3) that ends up on the joint's."""
        ways = ((fewest_turns(_exchange(rot, k - self.ks[0]), self.small), k) for k in self.ks)
        return min(ways, key=lambda way: len(way[0]))

    # --- the frames to choose from ---

    def frames(self, axis: Vec, across: Vec) -> list[Rot]:
        """The frames with an axis along ``axis``, and others along and across ``across``; then
        those of a joint that counts the other way round."""
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
            # two turns are enough between two frames if an axis of one is at right angles to an
            # axis of the other
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
                frame
                for across in self._considered(node)
                for frame in self.frames(node.axis, across)
            ]
        # where joints may be flipped, the last four of eight frames flip this one
        node.costs = [
            int(node.turns_freely and number % 8 > 3 and self.flip)
            for number in range(len(node.frames))
        ]

    def _considered(self, node: _Node) -> list[Vec]:
        """Directions at right angles to the joint's axis: a frame is tried for each, with a
        coordinate axis in that direction."""
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
        if not directions.vectors:  # the parent's axis is parallel, or given
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

        The joint's own frame is given, as its coordinates are along fixed axes.  But a turn after
        the joint costs one driven joint, and may save one at each of several joints that follow.
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
        """What the best frame of a node costs, and its number; ``before``: the rotation of the
        node's link in the frame of the parent."""
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
        """Give a joint its turns, once those before it have theirs."""
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
        _tell(conversion, step, held, _back(along) if step.flipped else along)
        step.axis = along
        node.held = multiply(transpose(from_turns(step.after)), held) if step.after else held


def _tell(conversion: Conversion, step: Step, held: Rot, axis: Vec) -> None:
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


# --- a lower bound: how few turns there could be ---


#: The bound looks at the best frames of the joints behind, if they are no more than this.
MOST_FRAMES = 150
#: For a body with more joints than this, the bound counts only how many directions they have.
MOST_JOINTS = 40


class _Bound:
    """How many turns no choice of frames can do without.

    With u for a joint's direction in the frame before it, ``least(u)`` turns are needed; with one
    turn more, about u itself, the frame behind can have any angle about u.  So the fewest turns
    behind a frame are the sum, over the joints that its body carries, of

        least(u) + best + missed,

    where best is the same sum for the joint's own frame at its best angle, and missed is one if
    ``least(u)`` turns reach no such angle.  This changes with a frame's angle only at a few
    angles: where a u comes to a coordinate axis or plane, or where an axis of one of the best
    frames of a joint behind does, so that fewer turns reach it.  These, and one other angle for
    all others, are all to look at.

    Where most angles are best, or too many to follow, missed is taken as zero; where a body
    carries too many joints, all but three directions are taken to need one turn.  The turns before
    a floating or planar joint that is not on the ground are not counted.  So the bound may be too
    low, never too high.
    """

    def __init__(self, options: AlignFrames) -> None:
        self._search = _Search(options)
        # frames made from directions that are nearly along one another have more rounding
        self._coarse = _Search(options)
        self._coarse.small *= 10
        self._best: dict[_Node, int] = {}
        self._where: dict[_Node, list[Rot]] = {}
        """The frames at which a node's best is reached, if these are few."""

    def fewest(self, nodes: list[_Node]) -> int:
        """The bound for a tree, parents first."""
        for node in reversed(nodes):
            if node.turns_freely:
                self._best[node], self._where[node] = self._about(node, node.axis)
            elif node.kind == "floating":
                self._best[node] = self._floating(node)
            else:
                self._best[node] = self._behind(node, node.frames[0])
        return self._best[nodes[0]]

    def _behind(self, node: _Node, frame: Rot) -> int:
        """The fewest turns behind a node, if its frame is this one."""
        back = transpose(frame)
        count = self._further(node)
        for child in node.children:
            if child.turns_freely:
                least = self._search.least(rotate(back, child.along))
                count += least
                if self._where[child]:
                    before = multiply(back, child.rot)
                    turns = (self._coarse.turns(multiply(before, f)) for f in self._where[child])
                    count += all(number > least for number in turns)
        return count

    def _further(self, node: _Node) -> int:
        """The fewest turns behind the joints that a node's body carries."""
        return sum(self._best[child] for child in node.children)

    def _about(self, node: _Node, axis: Vec) -> tuple[int, list[Rot]]:
        """The fewest turns behind a node, over all its frames with this axis, and the frames that
        need no more.  The list is empty where almost every frame does, and where they are many."""
        if not node.children:
            return 0, []
        if len(node.children) > MOST_JOINTS:
            return self._many(node), []
        small = self._search.small
        directions = _Directions(axis, small)
        for child in node.children:
            if child.turns_freely:
                directions.add(child.along)
                for frame in self._where[child]:
                    for i in range(3):
                        directions.add(rotate(child.rot, (frame[i], frame[i + 3], frame[i + 6])))
        elsewhere = _across((0.3716, -0.7411, 0.5309), axis, small)
        assert elsewhere is not None
        best = most = self._behind(node, self._search.frames(axis, elsewhere)[0])
        where: list[Rot] = []
        for across in directions.vectors:
            for frame in self._search.frames(axis, across):
                count = self._behind(node, frame)
                if count < best:
                    best, where = count, []
                if count == best < most:
                    where.append(frame)
        return best, where if len(where) <= MOST_FRAMES else []

    def _many(self, node: _Node) -> int:
        """The same bound for a node with many joints.  A frame has three axes, so at most three
        directions of joints are on one; each joint in another direction takes a turn."""
        lines: Counter[tuple[int, ...]] = Counter()
        for child in node.children:
            if child.turns_freely:
                key = tuple(round(c / (10 * max(self._search.small, 1e-10))) for c in child.along)
                lines[max(key, tuple(-c for c in key))] += 1
        return sum(sorted(lines.values())[:-3]) + self._further(node)

    def _floating(self, node: _Node) -> int:
        """The same for a floating joint, after which there are no turns, one about an axis, or
        more.  Two bring the direction of some joint onto an axis; else each joint takes a turn."""
        own = [child.along for child in node.children if child.turns_freely]
        best, further = self._behind(node, IDENTITY), self._further(node)
        if len(own) > MOST_JOINTS:
            return min(best, 1 + self._many(node))
        if best > 1 + further:
            best = min(best, *(1 + self._about(node, axis)[0] for axis in AXES))
        if best > 2 + further:
            lines = dict.fromkeys(own)
            best = min(best, 2 + len(own) + further, *(2 + self._about(node, u)[0] for u in lines))
        return best


class _Directions:
    """Directions at right angles to an axis; those a quarter turn apart count as one."""

    def __init__(self, axis: Vec, small: float) -> None:
        self._axis, self._small = axis, small
        # directions count as one up to ten times the tolerance of their components
        self._quarter = max(round(pi / 2 / (10 * small)), 1)
        x, y, z = map(abs, axis)
        smallest = X if x <= y and x <= z else Y if y <= z else Z
        self._one = cross(axis, smallest)
        self._two = cross(axis, self._one)
        self.counts: dict[int, int] = {}
        """How often each was added, in the order of ``vectors``."""
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
    """The direction of the part of v at right angles to the axis; None if v is along it."""
    a, b, c = axis
    x, y, z = v
    for _ in range(2):  # the second time removes the rounding of the first, if v is nearly along
        along = x * a + y * b + z * c
        x, y, z = x - along * a, y - along * b, z - along * c
        length = hypot(x, y, z)
        if length <= small:
            return None
        x, y, z = x / length, y / length, z / length
    return (x, y, z)


def _quarters(k: int, axis: Vec, across: Vec) -> list[Rot]:
    """The frames with axis k along ``axis`` and another axis on the line ``across`` it."""
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
