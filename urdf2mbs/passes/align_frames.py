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

from collections.abc import Iterable
from math import atan2, hypot, inf, pi
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
        search = _Search(self)
        nodes, steps = _tree(conversion)
        if search.flip:
            search.weight = len(nodes)
        for node in reversed(nodes):
            _collect_wanted(node, search)
        for node in nodes:
            _consider(node, nodes[node.parent], search)
        for node in reversed(nodes[1:]):
            _count(node, nodes[node.parent], search)
        old = _choose(conversion, nodes, search)
        conversion.facts["align-frames"] = {
            "driven": sum(
                len(step.turns) + len(step.after) for step, *_ in steps if step.joint.moves
            ),
            "bound": _Bound(nodes, search, self).turns if search.any else None,
        }

        last: dict[int, Rot] = {}
        for step, here, offset, before, offset_before in steps:
            step.xyz = rotate(multiply(old[before], offset_before), step.xyz)
            if not step.joint.moves:
                step.turns = ()
            last[id(step)] = multiply(old[here], offset)
            step.frames = _turned(last[id(step)], step.frames)
        for segment in conversion.segments.values():
            if segment.steps:
                segment.parts = _turned(last[id(segment.steps[-1])], segment.parts)


class _Node:
    """A joint that moves, and the frames to choose from for the link behind it.

    Node 0 is the ground.  A frame is a rotation in the link's own frame.
    """

    def __init__(self, step: Step | None, parent: int, rot: Rot) -> None:
        self.step = step
        self.parent = parent
        self.rot = rot
        """The link's frame in that of the parent node's link, at zero."""
        self.kind = step.joint.type if step is not None else "ground"
        self.axis = direction(step.axis) if step is not None else X
        self.along = rotate(rot, self.axis)
        """The joint's axis in the frame of the parent node's link, at zero."""
        self.children: list[_Node] = []
        self.wanted: list[tuple[Vec, int]] = []
        """Directions at right angles to the axis.  Joints behind this one need fewer turns if its
        frame has a coordinate axis in such a direction; the number says how many joints."""
        self.frames: list[list[Rot]] = []
        """The frames to choose from.  Those that differ by quarter turns only are in one list."""
        self.costs: list[list[int]] = []
        """For each frame, the fewest turns that all joints behind it need."""
        self.picks: list[list[tuple[int, int]]] = []
        """For each frame of the parent, the best one here; empty at a tip."""

    @property
    def turns_freely(self) -> bool:
        """Whether its frame may be turned about its axis at will."""
        return self.kind not in ("ground", "floating", "planar")

    @property
    def is_tip(self) -> bool:
        return self.turns_freely and not self.children


class _Search:
    """What the options make of the search.

    With any axis allowed, frames that differ by a cyclic exchange of x, y and z are as good as
    one another for all that follows.  So only those are considered that have the joint's axis
    first, and the turns before it are counted up to an exchange.
    """

    def __init__(self, options: AlignFrames) -> None:
        self.small = options.tolerance
        self.any = options.axes == "any"
        self.ks = (1, 2, 3) if self.any else ("xyz".index(options.axes) + 1,)
        self.candidates = max(options.candidates, 1)
        self.flip = options.flip
        self.weight = 1
        """What a turn costs; a joint that counts the other way round costs one.  So the fewest
        turns come first, and then the fewest such joints."""

    def frames(self, axis: Vec, across: Vec) -> list[Rot]:
        """The frames with an axis along ``axis``, and others along and across ``across``; then
        those of a joint that counts the other way round."""
        frames = _quarters(self.ks[0], axis, across)
        return [*frames, *_quarters(self.ks[0], _back(axis), across)] if self.flip else frames

    def least(self, u: Vec) -> int:
        """The fewest turns that bring a coordinate axis onto a direction."""
        zeros = self._zeros(u)
        return 2 - zeros if zeros < 2 else int(sum(u) < 0.0 and not self.flip)

    def aligned(self, u: Vec) -> bool:
        """Whether a direction is along a coordinate axis."""
        return self._zeros(u) >= 2

    def least_cost(self, u: Vec) -> int:
        """What they cost, with what it costs to count the other way round."""
        least = self.least(u)
        return self.weight * least + int(self.flip and not least and sum(u) < 0.0)

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
        ones = (
            (one == 2 and a + b + c > 0.0)
            + (two == 2 and d + e + f > 0.0)
            + (three == 2 and g + h + i > 0.0)
        )
        return (2, 1, 1, 0)[ones]

    def turns_in_all_quarters(self, rot: Rot) -> int | None:
        """The same, if it does not change with quarter turns before and after; else None."""
        if min(map(abs, rot)) > self.small:
            return 3
        zeros = self._zeros(rot[:3]), self._zeros(rot[3:6]), self._zeros(rot[6:])
        return 2 if self.any and 2 not in zeros else None

    def _zeros(self, u: Vec) -> int:
        """How many components of a direction are zero."""
        x, y, z = u
        small = self.small
        return (abs(x) <= small) + (abs(y) <= small) + (abs(z) <= small)

    def fewest(self, rot: Rot) -> tuple[tuple[Turn, ...], int]:
        """The turns themselves, and the axis (1, 2, 3) that ends up on the joint's."""
        ways = ((fewest_turns(_exchange(rot, k - self.ks[0]), self.small), k) for k in self.ks)
        return min(ways, key=lambda way: len(way[0]))


def _turned(rot: Rot, frames: dict[str, Pose]) -> dict[str, Pose]:
    return {
        link: Pose(rotate(rot, pose.xyz), multiply(rot, pose.rot)) for link, pose in frames.items()
    }


def _tree(conversion: Conversion) -> tuple[list[_Node], list[tuple[Step, int, Rot, int, Rot]]]:
    """All joints that move, parents first.  And all steps, each with the node whose frame its
    own link is in and the link's rotation in it, then the same of the link before."""
    nodes = [_Node(None, 0, IDENTITY)]
    steps: list[tuple[Step, int, Rot, int, Rot]] = []
    ends = {conversion.ground.link: (0, IDENTITY)}
    for segment in conversion.segments.values():
        if segment.parent is None:
            continue
        at, offset = ends[segment.parent]
        for step in segment.steps:
            before = at, offset
            offset = multiply(offset, from_turns(step.turns))
            if step.joint.moves:
                nodes.append(_Node(step, at, offset))
                nodes[at].children.append(nodes[-1])
                at, offset = len(nodes) - 1, IDENTITY
            steps.append((step, at, offset, *before))
        ends[segment.link] = at, offset
    return nodes, steps


def _collect_wanted(node: _Node, search: _Search) -> None:
    if not node.turns_freely or not node.children:
        return
    directions = _Directions(node.axis, search.small)
    for child in node.children:
        if child.kind == "floating":
            continue
        across = _across(child.along, node.axis, search.small)
        if across is not None:
            directions.add(across, 1)
        # two turns are enough between two frames if an axis of one is at right angles to an
        # axis of the other
        for wanted, count in child.wanted:
            for one in (wanted, cross(child.axis, wanted)):
                across = _across(rotate(child.rot, one), node.axis, search.small)
                if across is not None:
                    directions.add(across, count)
    node.wanted = directions.most(search.candidates)


def _consider(node: _Node, parent: _Node, search: _Search) -> None:
    """List the frames to choose from for a node."""
    if node.kind == "ground":
        node.frames = [[IDENTITY]]
    elif node.kind == "floating":
        node.frames = [[frame] for frame in _free_frames(node, search)]
    elif node.kind == "planar":  # its three coordinates are along given axes
        turns, k = axis_turns(node.axis)
        node.frames = [[_exchange(from_turns(turns), search.ks[0] - k)]]
    elif node.children or not search.any:
        node.frames = [
            search.frames(node.axis, across) for across in _considered(node, parent, search)
        ]
    # where joints may be flipped, the last four of eight frames flip this one
    node.costs = [[int(place > 3) for place in range(len(frames))] for frames in node.frames]


def _considered(node: _Node, parent: _Node, search: _Search) -> list[Vec]:
    """Directions at right angles to the joint's axis: a frame is tried for each, with a
    coordinate axis in that direction."""
    back = transpose(node.rot)
    directions = _Directions(node.axis, search.small)

    def add(axes: Iterable[Vec]) -> None:
        for one in axes:
            across = _across(rotate(back, one), node.axis, search.small)
            if across is not None:
                directions.add(across)

    room = search.candidates
    if parent.turns_freely:
        add([parent.axis])
        if not directions.vectors:  # parallel
            add(_axes(parent))
    else:
        add(_axes(parent))
        room = max(room, len(directions.vectors))
    for wanted, _ in node.wanted:
        directions.add(wanted)
    if len(directions.vectors) < room:
        add(_axes(parent))
    return directions.vectors[:room]


def _axes(node: _Node) -> list[Vec]:
    """The coordinate axes of all frames to choose from."""
    return [
        (frames[0][i], frames[0][i + 3], frames[0][i + 6])
        for frames in node.frames
        for i in range(3)
    ]


def _free_frames(node: _Node, search: _Search) -> list[Rot]:
    """Frames for the link behind a floating joint.

    The joint's own frame is given, as its coordinates are along fixed axes.  But a turn after the
    joint costs one driven joint, and may save one at each of several joints that follow.
    """
    seen: dict[tuple[int, ...], tuple[Vec, int]] = {}
    for child in node.children:
        if child.kind != "floating":
            u = child.along
            key = tuple(round(c * 1e9) for c in u)
            seen[key] = u, seen.get(key, (u, 0))[1] + 1
    most = sorted(seen.values(), key=lambda pair: -pair[1])[: search.candidates]
    ways: list[tuple[Turn, ...]] = [()]
    for (x, y, z), _ in most:
        for k, p, q in ((1, y, z), (2, z, x), (3, x, y)):
            if hypot(p, q) > search.small:
                ways += [((k, atan2(q, p) + quarter * pi / 2),) for quarter in range(-2, 2)]
        ways += [axis_turns((x, y, z))[0], axis_turns((-x, -y, -z))[0]]
    frames = {turns: from_turns(turns) for turns in ways}
    costs = {
        turns: len(turns)
        + sum(count * search.least(rotate(transpose(frame), u)) for u, count in most)
        for turns, frame in frames.items()
    }
    worth = [turns for turns in frames if costs[turns] <= costs[()]]
    worth.sort(key=lambda turns: costs[turns])
    return [frames[turns] for turns in {**dict.fromkeys(worth[: search.candidates]), (): None}]


def _count(node: _Node, parent: _Node, search: _Search) -> None:
    """Add to each frame of the parent the fewest turns of this branch."""
    tip = search.any and node.is_tip
    lows = [min(costs) for costs in node.costs]
    for group, frames in enumerate(parent.frames):
        best = [99 * search.weight] * len(frames)
        pick = [(0, 0)] * len(frames)
        if tip:
            u = rotate(transpose(frames[0]), node.along)
            best = [search.least_cost(u)] * len(frames)
            if search.aligned(u):  # then it depends on the sign
                best = [search.least_cost(rotate(transpose(one), node.along)) for one in frames]
        elif node.kind == "floating":
            for row, frame in enumerate(frames):
                own = len(fewest_turns(multiply(transpose(frame), node.rot)))
                best[row], pick[row] = min(
                    (
                        search.weight * (own + len(fewest_turns(after))) + node.costs[number][0],
                        (number, 0),
                    )
                    for number, (after,) in enumerate(node.frames)
                )
        else:
            before = [multiply(transpose(frames[0]), node.rot)]
            for number, own_frames in enumerate(node.frames):
                costs, low = node.costs[number], lows[number]
                if low >= max(best):
                    continue
                same = search.turns_in_all_quarters(multiply(before[0], own_frames[0]))
                if same is not None:
                    lowest = search.weight * same + low
                    for row, least in enumerate(best):
                        if lowest < least:
                            best[row], pick[row] = lowest, (number, costs.index(low))
                    continue
                if len(before) < len(frames):
                    before = [multiply(transpose(one), node.rot) for one in frames]
                for row, rot in enumerate(before):
                    for quarter, frame in enumerate(own_frames):
                        if costs[quarter] < best[row]:
                            turns = search.turns(multiply(rot, frame))
                            total = costs[quarter] + search.weight * turns
                            if total < best[row]:
                                best[row], pick[row] = total, (number, quarter)
        node.picks.append([] if tip else pick)
        parent.costs[group] = [a + b for a, b in zip(parent.costs[group], best, strict=True)]


def _choose(conversion: Conversion, nodes: list[_Node], search: _Search) -> list[Rot]:
    """Give each step its turns, from the base outwards; the result is the rotation of each
    node's link in its body's new frame."""
    old = [IDENTITY]
    chosen = [(0, 0)]
    for node in nodes[1:]:
        rot = multiply(old[node.parent], node.rot)
        group, row = chosen[node.parent]
        pick = node.picks[group][row] if node.picks[group] else None
        step = node.step
        assert step is not None
        if node.kind == "floating":
            assert pick is not None
            step.turns, k = fewest_turns(rot), 1
            step.after = fewest_turns(node.frames[pick[0]][0])
        elif pick is None:
            step.turns, k = _last_turns(node, rot, search)
        else:
            step.turns, k = search.fewest(multiply(rot, node.frames[pick[0]][pick[1]]))
        chosen.append(pick or (0, 0))
        held = multiply(transpose(from_turns(step.turns)), rot)
        along = AXES[k - 1]
        step.flipped = search.flip and node.turns_freely and dot(rotate(held, node.axis), along) < 0
        _tell(conversion, step, held, _back(along) if step.flipped else along)
        step.axis = along
        old.append(multiply(transpose(from_turns(step.after)), held) if step.after else held)
    return old


def _last_turns(node: _Node, rot: Rot, search: _Search) -> tuple[tuple[Turn, ...], int]:
    """The turns before a joint that carries no other."""
    least = search.least(rotate(rot, node.axis))
    shortest: tuple[tuple[Turn, ...], int] | None = None
    back = transpose(rot)
    for seen in AXES:
        across = _across(rotate(back, seen), node.axis, search.small)
        if across is not None:
            for frame in search.frames(node.axis, across):
                way = search.fewest(multiply(rot, frame))
                if shortest is None or len(way[0]) < len(shortest[0]):
                    shortest = way
                    if len(way[0]) <= least:
                        return shortest
    assert shortest is not None
    return shortest


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

    def __init__(self, nodes: list[_Node], search: _Search, options: AlignFrames) -> None:
        self._search = search
        # frames made from directions that are nearly along one another have more rounding
        coarse = msgspec.structs.replace(options, tolerance=10 * options.tolerance)
        self._turns = _Search(coarse).turns
        self._best: dict[int, int] = {}
        self._where: dict[int, list[Rot]] = {}
        """The frames at which a node's best is reached, if these are few."""
        for node in reversed(nodes):
            if node.turns_freely:
                self._best[id(node)], self._where[id(node)] = self._about(node, node.axis)
            elif node.kind == "floating":
                self._best[id(node)] = self._floating(node)
            elif node.kind == "planar":
                self._best[id(node)] = self._behind(node, node.frames[0][0])
            else:
                self.turns = self._behind(node, IDENTITY)

    def _behind(self, node: _Node, frame: Rot, *, missed: bool = True, most: float = inf) -> int:
        """The fewest turns behind a node, if its frame is this one; if these are more than
        ``most``, any number above that.

        ``missed`` False leaves out the turns that are missed (see above), as too many frames
        would have to be tried for them.
        """
        back = transpose(frame)
        free = [
            (child, self._search.least(rotate(back, child.along)))
            for child in node.children
            if child.turns_freely
        ]
        count = sum(self._best[id(child)] for child in node.children)
        count += sum(least for _, least in free)
        for child, least in free if missed and count <= most else ():
            good = self._where[id(child)]
            if good:
                before = multiply(back, child.rot)
                count += all(self._turns(multiply(before, one)) > least for one in good)
        return count

    def _about(self, node: _Node, axis: Vec) -> tuple[int, list[Rot]]:
        """The fewest turns behind a node, over all its frames with this axis, and the frames that
        need no more.  The list is empty where almost every frame does."""
        if not node.children:
            return 0, []
        small = self._search.small
        directions = _Directions(axis, small)
        for child in node.children:
            if not child.turns_freely:
                continue
            across = _across(child.along, axis, small)
            if across is not None:
                directions.add(across)
        # from joint to joint there may be more and more of these
        inner = [(c, frame) for c in node.children for frame in self._where.get(id(c), ())]
        exact = len(inner) <= MOST_FRAMES
        for child, frame in inner if exact else ():
            for i in range(3):
                one = (frame[i], frame[i + 3], frame[i + 6])
                across = _across(rotate(child.rot, one), axis, small)
                if across is not None:
                    directions.add(across)
        if len(node.children) > MOST_JOINTS:
            return self._many(node), []
        one_other = _across((0.3716, -0.7411, 0.5309), axis, small)
        assert one_other is not None
        elsewhere = self._behind(node, self._search.frames(axis, one_other)[0], missed=exact)
        few = [
            frame for across in directions.vectors for frame in self._search.frames(axis, across)
        ]
        best, counts = elsewhere, []
        for frame in few:
            counts.append(self._behind(node, frame, missed=exact, most=best))
            best = min(best, counts[-1])
        if elsewhere == best or not exact:
            return best, []
        return best, [frame for frame, count in zip(few, counts, strict=True) if count == best]

    def _many(self, node: _Node) -> int:
        """The same bound for a node with many joints.  A frame has three axes, so at most three
        directions of joints are on one; each joint in another direction takes a turn."""
        lines: dict[tuple[float, ...], int] = {}
        for child in node.children:
            if child.turns_freely:
                u = child.along
                key = tuple(round(c / (10 * max(self._search.small, 1e-10))) for c in u)
                key = max(key, tuple(-c for c in key))
                lines[key] = lines.get(key, 0) + 1
        rest = sum(sorted(lines.values(), reverse=True)[3:])
        return rest + sum(self._best[id(child)] for child in node.children)

    def _floating(self, node: _Node) -> int:
        """The same for a floating joint, after which there are no turns, one about an axis, or
        more.  Two bring the direction of some joint onto an axis; else each joint takes a turn."""
        own = [child for child in node.children if child.turns_freely]
        best = self._behind(node, IDENTITY)
        if len(own) > MOST_JOINTS:
            return min(best, 1 + self._many(node))
        further = sum(self._best[id(child)] for child in node.children)
        if best > 1 + further:
            best = min(best, *(1 + self._about(node, axis)[0] for axis in AXES))
        if best > 2 + further:
            lines = dict.fromkeys(child.along for child in own)
            best = min(best, 2 + len(own) + further, *(2 + self._about(node, u)[0] for u in lines))
        return best


class _Directions:
    """Directions at right angles to an axis; those a quarter turn apart count as one."""

    def __init__(self, axis: Vec, small: float) -> None:
        # directions count as one up to ten times the tolerance of their components
        self._quarter = max(round(pi / 2 / (10 * small)), 1)
        x, y, z = map(abs, axis)
        smallest = X if x <= y and x <= z else Y if y <= z else Z
        self._one = cross(axis, smallest)
        self._two = cross(axis, self._one)
        self._counts: dict[int, int] = {}
        self.vectors: list[Vec] = []

    def add(self, across: Vec, count: int = 1) -> None:
        angle = atan2(dot(across, self._two), dot(across, self._one))
        key = round(angle / (pi / 2) * self._quarter) % self._quarter
        if key not in self._counts:
            self.vectors.append(across)
        self._counts[key] = self._counts.get(key, 0) + count

    def most(self, number: int) -> list[tuple[Vec, int]]:
        """Those that were added most often, and how often."""
        pairs = zip(self.vectors, self._counts.values(), strict=True)
        return sorted(pairs, key=lambda pair: -pair[1])[:number]


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
    return [_exchange(_columns(axis, one, two), k - 1) for one, two in pairs]


def _back(v: Vec) -> Vec:
    return (-v[0], -v[1], -v[2])


def _columns(x: Vec, y: Vec, z: Vec) -> Rot:
    return (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])


def _exchange(rot: Rot, by: int) -> Rot:
    """The same frame with its axes renumbered: x, y, z become y, z, x if ``by`` is 1, and so on."""
    a, b, c, d, e, f, g, h, i = rot
    if by % 3 == 1:
        return (c, a, b, f, d, e, i, g, h)
    if by % 3 == 2:
        return (b, c, a, e, f, d, h, i, g)
    return rot
