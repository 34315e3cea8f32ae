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
* the other axes of the frame before, if the joint before is parallel or cannot be turned.

The pass tries each of these angles with 0, 1, 2 and 3 quarter turns more.  Dynamic programming,
from the tips of the tree to the base, finds the choice with the fewest turns in all.

A turn may also stand where several joints branch off, once for all of them: after a moving joint,
or at a fixed joint, whose links are then a body of their own again, on a T3 driven at 0.  The pass
searches a second time with these turns, and takes them if the robot then has fewer joints.  Since
all frames of ``faithful`` are among those of the second search, no robot has more joints.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from math import atan2, hypot, pi
from typing import Annotated, Literal, NamedTuple

import msgspec

from urdf2mbs.conversion import Conversion, Segment, Step
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import Body
from urdf2mbs.ranges import Tolerance
from urdf2mbs.spatial import (
    IDENTITY,
    ROUNDING,
    Pose,
    Rot,
    Turn,
    Vec,
    add,
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

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


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

    def run(self, conversion: Conversion) -> None:
        tree = _Tree(conversion)
        search = _Search(self, tree.nodes)
        if search.joints() > 0:
            more = _Tree(conversion, branching=True)
            if len(more.nodes) > len(tree.nodes):
                second = _Search(self, more.nodes, branching=True)
                if second.joints() < search.joints():
                    tree, search = more, second
        for step in conversion.steps():
            if not step.joint.moves:
                step.turns = ()
        for node in tree.nodes[1:]:
            search.choose(node, conversion)
        tree.split()
        steps = [place.step for place in tree.places]
        conversion.facts["align-frames"] = {
            "driven": sum(len(step.turns) + len(step.after) for step in steps)
        }

        after: dict[int, Rot] = {}
        for step, node, offset, before, offset_before in tree.places:
            step.xyz = drop_rounding(rotate(multiply(before.held, offset_before), step.xyz))
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
    """A joint that moves, or a place where all that branches off may be turned at once; and the
    possible frames of the link behind.

    The first node is the ground.  A frame is a rotation in the link's own frame.
    """

    def __init__(self, kind: str, step: Step, parent: _Node | None, rot: Rot) -> None:
        self.kind = kind
        """The type of the joint, or ``ground``, or ``after`` for turns after the joint."""
        self.step = step
        self.parent = parent or self
        self.rot = rot
        """The link's frame in the frame of the parent node's link, at zero."""
        self.body = False
        """True if a turn here makes a body of links that would be part of another body."""
        self.exact = False
        """True if a floating joint is behind: the axes of the frame may not be exchanged."""
        self.turns_freely = kind not in ("ground", "floating", "planar", "after", "fixed")
        """True if the frame may be turned about the joint's axis at will."""
        self.axis = direction(step.axis)
        self.along = rotate(rot, self.axis)
        """The joint's axis in the frame of the parent node's link, at zero."""
        self.children: list[_Node] = []
        if parent:
            parent.children.append(self)
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

    def carried(self) -> list[tuple[_Node, Rot]]:
        """The joints that branch off, and the rotation of the link before them in this link."""
        found = [(child, IDENTITY) for child in self.children]
        for node, rot in found:  # grows
            if node.kind in ("after", "fixed"):
                found += [(child, multiply(rot, node.rot)) for child in node.children]
        return [(node, rot) for node, rot in found if node.kind not in ("after", "fixed")]


class _Place(NamedTuple):
    """A step, the node of its frame, the frame's rotation in the node's link; and before it."""

    step: Step
    node: _Node
    offset: Rot
    before: _Node
    offset_before: Rot


class _Tree:
    """All joints that move, parents first; and all steps.

    With ``branching`` there is also a node for the turns at each place where joints branch off.
    """

    def __init__(self, conversion: Conversion, branching: bool = False) -> None:
        self.conversion = conversion
        self.branching = branching
        self.above = {joint.child: joint for joint in conversion.robot.joints.values()}
        self.nodes: list[_Node] = []
        self.places: list[_Place] = []
        ground = Step.of(Joint("", "fixed", "", conversion.ground.link))
        self.origins = {ground.joint.child: (self._add("ground", ground, None, IDENTITY), IDENTITY)}
        """For each segment the node and the rotation that its first step starts from."""
        carried: dict[str, list[Segment]] = {link: [] for link in conversion.segments}
        for segment in conversion.segments.values():
            if segment.parent is not None:
                carried[segment.parent].append(segment)
        for link, segment in conversion.segments.items():
            node, offset = self.origins[link]
            for step in segment.steps:
                branches = len(carried[link]) if step is segment.steps[-1] else 1
                node, offset = self._walk(step, node, offset, branches)
            for child in carried[link]:
                self.origins[child.link] = node, offset
            if branching and len(carried[link]) > 1:
                self._branch(segment, carried[link])

    def _add(self, kind: str, step: Step, parent: _Node | None, rot: Rot) -> _Node:
        self.nodes.append(_Node(kind, step, parent, rot))
        return self.nodes[-1]

    def _walk(self, step: Step, node: _Node, offset: Rot, branches: int) -> tuple[_Node, Rot]:
        """Go one step on."""
        before, offset_before = node, offset
        offset = multiply(offset, from_turns(step.turns))
        branching = self.branching and branches > 1
        if step.joint.moves:
            node, offset = self._add(step.joint.type, step, node, offset), IDENTITY
            if branching or (step.joint.type == "floating" and branches):
                node = self._add("after", step, node, IDENTITY)
        elif branching and step.turns:
            node, offset = self._add("fixed", step, node, offset), IDENTITY
        self.places.append(_Place(step, node, offset, before, offset_before))
        return node, offset

    def _branch(self, segment: Segment, carried: list[Segment]) -> None:
        """Add a node for each fixed joint in a segment behind which several joints branch off."""
        ways = [self._way(child.steps[0].joint.parent, segment) for child in carried]
        counts = Counter(link for way in ways for link in way)
        found: dict[str, tuple[_Node, Rot]] = {}
        for child, way in zip(carried, ways, strict=True):
            for link in reversed(way):
                if counts[link] < 2 or not any(self.above[link].origin.rpy):
                    continue
                if link not in found:
                    before, offset = self.origins[child.link]
                    rot = segment.parts[link].rot
                    step = Step.of(self.above[link])
                    node = self._add("fixed", step, before, multiply(offset, rot))
                    node.body = True
                    found[link] = node, transpose(rot)
                    self.places.append(_Place(step, *found[link], before, offset))
                self.origins[child.link] = found[link]

    def _way(self, link: str, segment: Segment) -> list[str]:
        """The links from a link of a segment back to its first link, which is left out."""
        way: list[str] = []
        while link in self.above and self.above[link].parent in segment.parts:
            way.append(link)
            link = self.above[link].parent
        return way

    def split(self) -> None:
        """Make bodies of the links behind the fixed joints that have turns."""
        for step, node, *_ in self.places:
            if not (node.body and step is node.step and step.turns):
                continue
            link = step.joint.child
            owner, (step.xyz, _) = self.conversion.parts()[link]
            x, y, z = step.xyz
            body = Segment(link, owner.link, [step], {}, Body(link))
            for part in [part for part in owner.parts if link in self._way(part, owner)]:
                at, rot = owner.parts.pop(part)
                body.parts[part] = Pose(add(at, (-x, -y, -z)), rot)
            segments: dict[str, Segment] = {}
            for name, segment in self.conversion.segments.items():
                segments[name] = segment
                if segment is owner:
                    segments[link] = body
                elif segment.parent == owner.link and segment.steps[0].joint.parent in body.parts:
                    segment.parent = link
                    segment.steps[0].xyz = add(segment.steps[0].xyz, (-x, -y, -z))
            self.conversion.regroup(segments)


class _Search:
    """The search for the frames that need the fewest turns.

    With any axis allowed, frames that differ by a cyclic exchange of x, y and z are equally good
    for all joints behind.  So the search considers only frames whose x is the joint's axis, and
    counts the turns before the joint up to an exchange.  A floating joint behind is the exception:
    its axes are those of its own frame.
    """

    def __init__(
        self, options: AlignFrames, nodes: Sequence[_Node] = (), branching: bool = False
    ) -> None:
        self.small = options.tolerance
        self.any = options.axes == "any"
        self.k = 1 if self.any else "xyz".index(options.axes) + 1
        self.candidates = options.candidates
        self.nodes = nodes
        self.branching = branching
        for node in reversed(nodes):
            node.exact = any(child.kind == "floating" or child.exact for child in node.children)
            self.collect_wanted(node)
        for node in nodes:
            self.list_frames(node)
        for node in reversed(nodes[1:]):
            self.count(node)

    def joints(self) -> int:
        """The number of driven joints of the best choice: turns, and fixed joints kept."""
        return self.nodes[0].costs[0]

    # --- turns ---

    def zeros(self, u: tuple[float, ...]) -> int:
        """The number of components of a direction that are zero."""
        x, y, z = u
        small = self.small
        return (abs(x) <= small) + (abs(y) <= small) + (abs(z) <= small)

    def least(self, u: Vec) -> int:
        """The fewest turns that bring a coordinate axis onto a direction."""
        zeros = self.zeros(u)
        return 2 - zeros if zeros < 2 else int(sum(u) < 0.0)

    def turns(self, rot: Rot, exact: bool = False) -> int:
        """The number of turns of a rotation; with any axis allowed, up to an exchange of axes."""
        if exact or not self.any:
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

    def fewest(self, rot: Rot, exact: bool = False) -> tuple[Turn, ...]:
        """The fewest turns of a rotation; with any axis allowed, up to an exchange of axes."""
        ways = range(1 if exact or not self.any else 3)
        return min((fewest_turns(_exchange(rot, by), self.small) for by in ways), key=len)

    # --- the frames to choose from ---

    def frames(self, axis: Vec, across: Vec) -> list[Rot]:
        """The four frames with an axis along ``axis`` and another axis on the line ``across``."""
        up = cross(axis, across)
        back, left = _back(across), _back(up)
        pairs = ((across, up), (up, back), (back, left), (left, across))
        return [_exchange(transpose((*axis, *y, *z)), self.k - 1) for y, z in pairs]

    def collect_wanted(self, node: _Node) -> None:
        """Find the directions in which the joints behind a node want an axis of its frame."""
        if not node.turns_freely:
            return
        directions = _Directions(node.axis, self.small)
        for child, before in node.carried():
            if child.kind == "floating":
                continue
            rot = multiply(before, child.rot)
            directions.add(rotate(before, child.along))
            # two turns between two frames are enough if an axis of the first frame is at right
            # angles to an axis of the second frame
            for wanted, count in child.wanted:
                directions.add(rotate(rot, wanted), count)
                directions.add(rotate(rot, cross(child.axis, wanted)), count)
        pairs = zip(directions.vectors, directions.counts.values(), strict=True)
        node.wanted = sorted(pairs, key=lambda pair: -pair[1])[: self.candidates]

    def list_frames(self, node: _Node) -> None:
        """List the frames to choose from for a node."""
        if node.kind == "ground" or node.kind == "floating":
            node.frames = [IDENTITY]
        elif node.kind in ("after", "fixed"):
            back = transpose(node.rot)
            # all of a joint that moves; the lists of nested fixed joints would grow
            most = 24 * (self.candidates + 1)
            known = [multiply(back, frame) for frame in node.parent.frames[:most]]
            node.frames = list(dict.fromkeys([*self._branching_frames(node), *known]))
        elif node.kind == "planar":  # its three coordinates are along given axes
            turns, k = axis_turns(node.axis)
            ways = range(3 if node.exact and self.any else 1)
            node.frames = [_exchange(from_turns(turns), self.k - k + by) for by in ways]
        elif node.children or not self.any:
            node.frames = [
                _exchange(frame, by)
                for across in self._consider(node)
                for by in range(3 if node.exact and self.any else 1)
                for frame in self.frames(node.axis, across)
            ]
        node.costs = [0] * len(node.frames)

    def _consider(self, node: _Node) -> list[Vec]:
        """Directions at right angles to the joint's axis.  The search tries a frame with a
        coordinate axis in each direction."""
        parent, back = node.parent, transpose(node.rot)
        directions = _Directions(node.axis, self.small)
        if parent.turns_freely:
            directions.add(rotate(back, parent.axis))
        if not directions.vectors:  # the parent's axis is parallel, or the parent cannot turn
            # frames that differ by quarter turns have the same axes
            group = 4 if parent.turns_freely else 1
            for frame in parent.frames[::group]:
                for i in range(3):
                    directions.add(rotate(back, (frame[i], frame[i + 3], frame[i + 6])))
        for wanted, _ in node.wanted:
            directions.add(wanted)
        found = directions.vectors[: self.candidates]
        if self.branching:  # the frame of ``faithful``
            turns, k = axis_turns(node.axis)
            found.append(rotate(from_turns(turns), AXES[k % 3]))
        return found

    def _branching_frames(self, node: _Node) -> list[Rot]:
        """Frames for a link where joints branch off: the link's own, and turned frames.

        A turn costs one driven joint, and may save a driven joint at each of the joints behind.
        """
        lines: dict[tuple[int, ...], list[Vec]] = {}
        for child, rot in node.carried():
            if child.kind != "floating":
                along = rotate(rot, child.along)
                lines.setdefault(tuple(round(c * 1e9) for c in along), []).append(along)
        most = sorted(lines.values(), key=len, reverse=True)[: self.candidates]
        ways: list[tuple[Turn, ...]] = [()]
        for *_, (x, y, z) in most:
            for k, p, q in ((1, y, z), (2, z, x), (3, x, y)):
                if hypot(p, q) > self.small:
                    ways += [((k, atan2(q, p) + quarter * pi / 2),) for quarter in range(-2, 2)]
            ways.append(axis_turns((x, y, z))[0])
        frames = {turns: from_turns(turns) for turns in ways}
        costs = {
            turns: len(turns)
            + sum(len(alike) * self.least(rotate(transpose(frame), alike[-1])) for alike in most)
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
                cost = self.least(rotate(back, node.along))
            parent.costs[number] += cost

    def _best(self, node: _Node, before: Rot) -> tuple[int, int]:
        """The cost of a node's best frame, and the frame's number.

        ``before`` is the rotation of the node's link in the parent's frame.
        """
        if node.kind == "floating":
            return node.costs[0] + len(fewest_turns(before)), 0
        best, pick = sys.maxsize, 0
        for number, (frame, cost) in enumerate(zip(node.frames, node.costs, strict=True)):
            if cost < best:
                turns = self.turns(multiply(before, frame), node.exact)
                cost += turns + (node.body and turns > 0)
                if cost < best:
                    best, pick = cost, number
        return best, pick

    def choose(self, node: _Node, conversion: Conversion) -> None:
        """Give a joint its turns; the joints before it must have theirs."""
        step = node.step
        rot = multiply(node.parent.held, node.rot)
        if node.picks:
            node.chosen = node.picks[node.parent.chosen]
        if node.kind == "floating":
            turns = fewest_turns(rot)
        elif node.frames:
            turns = self.fewest(multiply(rot, node.frames[node.chosen]), node.exact)
        else:
            ways = (
                self.fewest(multiply(rot, frame))
                for axis in AXES
                if (across := _across(rotate(transpose(rot), axis), node.axis, self.small))
                for frame in self.frames(node.axis, across)
            )
            turns = min(ways, key=len)
        node.held = multiply(transpose(from_turns(turns)), rot) if turns else rot
        if node.kind == "after":
            step.after = turns
            return
        step.turns = turns
        if not node.turns_freely and node.kind != "planar":
            return
        axis = rotate(node.held, node.axis)
        along = max(AXES, key=lambda one: abs(dot(axis, one)))
        _note_axis_off(conversion, step, node.held, along)
        step.axis = along


def _note_axis_off(conversion: Conversion, step: Step, held: Rot, axis: Vec) -> None:
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
        self._one = cross(axis, min(AXES, key=lambda across: abs(dot(across, axis))))
        self._two = cross(axis, self._one)
        self.counts: Counter[int] = Counter()
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
        self.counts[key] += count


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
