"""Align frames: each body's frame is chosen so that its joint's axis is a coordinate axis.

Beyond the method, whose Table A.2 turns the frame before a joint and turns it back after.
Anything constant in a body can be expressed in any frame, so turning back is never needed:
centre, inertia, points, visuals and the joints that follow are expressed in the frame that the
joint leaves.  The turns ``D`` before a joint must bring a coordinate axis ``e_k`` onto the
joint's direction ``u``: none if u is +x, +y or +z; one if u has a zero component or is a
negative axis; two otherwise.  Which k, and a turn about u itself, are free.  They are chosen
for the whole tree, so that a body's choice serves all that it carries: candidate frames from
the base outwards, their costs from the tips back (dynamic programming).  The joint's
coordinate stays the URDF's: same zero, same sign.
"""

from __future__ import annotations

from math import atan2, hypot, pi
from typing import Literal, NamedTuple

import msgspec

from urdf2mbs.conversion import Conversion, Step
from urdf2mbs.hookspecs import Pass
from urdf2mbs.spatial import (
    IDENTITY,
    ROUNDING,
    Pose,
    Rot,
    Turn,
    Vec,
    axis_turns,
    direction,
    fewest_turns,
    from_turn,
    from_turns,
    multiply,
    rotate,
    transpose,
)
from urdf2mbs.urdf.model import Joint

AXES: tuple[Vec, Vec, Vec] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
#: How many turns more than the fewest a joint may take for the sake of what it carries.
EXTRA = 1


class Options(msgspec.Struct, forbid_unknown_fields=True):
    axes: Literal["x", "y", "z", "any"] = "any"
    """The coordinate axis that joints act about or along."""
    candidates: int = 6
    """How many frames are considered for each body; more may find fewer joints."""
    tolerance: float = ROUNDING
    """Up to this (rad) a direction off a coordinate axis or plane counts as on it.  The default
    is rounding; 1e-9 also takes angles written as 1.570796327, and says how far off each is."""


class _Choice(NamedTuple):
    """One way to place a joint: the turns before it, the axis it then acts on (1, 2, 3), and
    the rotation of the old frame (the link's) in the one that is left after."""

    turns: tuple[Turn, ...]
    k: int
    old: Rot
    after: tuple[Turn, ...] = ()
    """Turns after the joint: only after a floating one, whose own frame is not free."""

    @property
    def cost(self) -> int:
        return len(self.turns) + len(self.after)


class _Node:
    """A step of the tree, and the frames considered for it."""

    def __init__(self, step: Step, parent: int) -> None:
        self.step = step
        self.parent = parent
        self.children: list[int] = []
        self.rot = from_turns(step.turns)
        self.axis = direction(step.axis) if step.joint.moves else AXES[0]
        self.frames: list[Rot] = []
        """Rotations of the link's frame in the frames considered."""
        self.choices: list[dict[int, _Choice]] = []
        """For each frame of the parent: which of the own frames can follow, and how."""
        self.reach: list[int] = []
        """The fewest turns from the base to each frame, this branch alone."""


def run(conversion: Conversion, options: Options) -> None:
    nodes = _nodes(conversion)
    ks = (1, 2, 3) if options.axes == "any" else ("xyz".index(options.axes) + 1,)
    for node in nodes[1:]:
        _consider(node, nodes, ks, options)
    chosen = _cheapest(nodes)
    for node, frame in zip(nodes[1:], chosen[1:], strict=True):
        before = chosen[node.parent]
        choice = node.choices[before][frame]
        step = node.step
        _tell(conversion, node, choice, nodes[node.parent].frames[before])
        step.xyz = rotate(nodes[node.parent].frames[before], step.xyz)
        step.turns, step.after = choice.turns, choice.after
        step.axis = AXES[choice.k - 1]
        step.frames = _turned(choice.old, step.frames)
    last = {id(node.step): node.frames[frame] for node, frame in zip(nodes, chosen, strict=True)}
    for segment in conversion.segments.values():
        if segment.steps:
            segment.parts = _turned(last[id(segment.steps[-1])], segment.parts)


def _turned(rot: Rot, frames: dict[str, Pose]) -> dict[str, Pose]:
    return {
        link: Pose(rotate(rot, pose.xyz), multiply(rot, pose.rot)) for link, pose in frames.items()
    }


def _tell(conversion: Conversion, node: _Node, choice: _Choice, old: Rot) -> None:
    if node.step.joint.type in ("fixed", "floating", "planar"):
        return
    meant = rotate(multiply(old, node.rot), node.axis)
    got = rotate(from_turns(choice.turns), AXES[choice.k - 1])
    off = max(abs(a - b) for a, b in zip(meant, got, strict=True))
    if off > ROUNDING:
        conversion.note(
            "axis-aligned",
            f"joint '{node.step.joint.name}': its axis is {off:.1e} rad off a coordinate "
            "axis or plane of its body, and is taken to lie on it",
            joint=node.step.joint.name,
        )


def _nodes(conversion: Conversion) -> list[_Node]:
    """All steps, parents first; node 0 is the ground, whose frame is its link's."""
    ground = _Node(Step.of(Joint("", "fixed", "", "")), -1)
    ground.frames, ground.reach = [IDENTITY], [0]
    nodes = [ground]
    ends = {conversion.ground.link: 0}
    for segment in conversion.segments.values():
        if segment.parent is None:
            continue
        at = ends[segment.parent]
        for step in segment.steps:
            nodes.append(_Node(step, at))
            nodes[at].children.append(len(nodes) - 1)
            at = len(nodes) - 1
        ends[segment.link] = at
    return nodes


def _consider(node: _Node, nodes: list[_Node], ks: tuple[int, ...], options: Options) -> None:
    """Fill a node's candidate frames and how each follows from the parent's."""
    parent = nodes[node.parent]
    carried = [nodes[child] for child in node.children]
    found: dict[tuple[int, ...], int] = {}
    frames: list[Rot] = []
    reach: list[int] = []
    best: list[int] = []
    rows: list[dict[int, _Choice]] = []
    for before, old in zip(parent.reach, parent.frames, strict=True):
        row: dict[int, _Choice] = {}
        for choice in _ways(node, old, carried, ks, options.tolerance):
            key = tuple(round(c * 1e9) for c in choice.old)
            index = found.setdefault(key, len(frames))
            if index == len(frames):
                frames.append(choice.old)
                reach.append(before + choice.cost)
            reach[index] = min(reach[index], before + choice.cost)
            # a frame reached in two ways is the same only to the rounding of the key
            if index not in row or choice.cost < row[index].cost:
                row[index] = choice
        rows.append(row)
        best.append(min(row, key=lambda index: row[index].cost))
    if len(frames) > options.candidates:
        # what a frame costs so far and one generation ahead; every frame of the parent keeps one
        ahead = [
            reach[index] + sum(_fewest(rotate(multiply(frame, c.rot), c.axis)) for c in carried)
            for index, frame in enumerate(frames)
        ]
        order = sorted(range(len(frames)), key=lambda index: ahead[index])
        kept = sorted({*best, *order[: options.candidates]})
        place = {index: new for new, index in enumerate(kept)}
        frames = [frames[index] for index in kept]
        reach = [reach[index] for index in kept]
        rows = [{place[i]: c for i, c in row.items() if i in place} for row in rows]
    node.frames, node.reach, node.choices = frames, reach, rows


def _fewest(u: Vec) -> int:
    """The fewest turns that bring a coordinate axis onto a direction."""
    zeros = sum(abs(c) <= ROUNDING for c in u)
    return 2 - zeros if zeros < 2 else int(sum(u) < 0.0)


def _ways(
    node: _Node, old: Rot, carried: list[_Node], ks: tuple[int, ...], small: float
) -> list[_Choice]:
    """How to place a joint after a frame in which the parent link's frame is ``old``."""
    rot = multiply(old, node.rot)
    kind = node.step.joint.type
    if kind == "fixed":
        return [_Choice((), 1, rot)]
    if kind == "planar":  # its coordinates name axes, so its frame is not free
        turns, k = axis_turns(node.axis)
        before = fewest_turns(multiply(rot, from_turns(turns)))
        return [_Choice(before, k, multiply(transpose(from_turns(before)), rot))]
    seen = [rotate(child.rot, child.axis) for child in carried if child.step.joint.moves]
    if kind == "floating":
        before = fewest_turns(rot)
        held = multiply(transpose(from_turns(before)), rot)
        ways = {
            turn: _Choice(before, 1, multiply(transpose(from_turn(turn)), held), (turn,))
            for k in (1, 2, 3)
            for w in seen
            for turn in _quarters(k, w[k % 3], w[(k + 1) % 3])
        }
        return [_Choice(before, 1, held), *ways.values()]

    u = rotate(rot, node.axis)
    across, up = _across(u)
    seen = [*AXES, *(rotate(rot, w) for w in seen)]
    found: dict[tuple[tuple[int, int], ...], _Choice] = {}
    for k in ks:
        placed = _columns(k, u, across, up)
        for w in seen:
            p = w[0] * across[0] + w[1] * across[1] + w[2] * across[2]
            q = w[0] * up[0] + w[1] * up[1] + w[2] * up[2]
            for turn in _quarters(k, p, q):
                turns = fewest_turns(multiply(placed, from_turn(turn)), small)
                key = tuple((axis, round(angle * 1e9)) for axis, angle in turns)
                if key not in found:
                    found[key] = _Choice(turns, k, multiply(transpose(from_turns(turns)), rot))
    ways_by_cost = sorted(found.values(), key=lambda choice: choice.cost)
    if not carried:
        return ways_by_cost[:1]
    return [choice for choice in ways_by_cost if choice.cost <= ways_by_cost[0].cost + EXTRA]


def _quarters(k: int, p: float, q: float) -> list[Turn]:
    """The turns about axis k that put a direction (p, q) across it onto a coordinate axis."""
    if hypot(p, q) <= ROUNDING:
        return []
    return [(k, atan2(q, p) + quarter * pi / 2) for quarter in range(-2, 2)]


def _across(u: Vec) -> tuple[Vec, Vec]:
    """Two directions that make a right-handed frame (u, across, up) with u."""
    x, y, z = u
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        across = (0.0, -z, y)
    elif abs(y) <= abs(z):
        across = (z, 0.0, -x)
    else:
        across = (-y, x, 0.0)
    length = hypot(*across)
    a, b, c = across[0] / length, across[1] / length, across[2] / length
    return (a, b, c), (y * c - z * b, z * a - x * c, x * b - y * a)


def _columns(k: int, u: Vec, one: Vec, two: Vec) -> Rot:
    """The rotation that takes e_k to u, and the two axes after it to the other two."""
    x, y, z = ((u, one, two), (two, u, one), (one, two, u))[k - 1]
    return (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])


def _cheapest(nodes: list[_Node]) -> list[int]:
    """For each node the frame that makes the whole tree cheapest."""
    cost: list[list[float]] = [[0.0] * len(node.frames) for node in nodes]
    pick: list[list[int]] = [[] for _ in nodes]
    for number in range(len(nodes) - 1, 0, -1):
        node = nodes[number]
        for row, choices in enumerate(node.choices):
            frame = min(choices, key=lambda f: choices[f].cost + cost[number][f])
            pick[number].append(frame)
            cost[node.parent][row] += choices[frame].cost + cost[number][frame]
    chosen = [0] * len(nodes)
    for number in range(1, len(nodes)):
        chosen[number] = pick[number][chosen[nodes[number].parent]]
    return chosen


PASS = Pass("align-frames", run, Options, needs=("bodies",), gives=("aligned",))
