"""What a robot looks like from the front, in its start pose: where limbs begin and lead to.

Up is up.  The robot faces you: its left (URDF's y) is at the right.  A robot whose limbs are
mirror images along x instead is looked at along y; names like ``left`` and ``l_`` then, and
where a robot faces backwards, say which side is which.
"""

from __future__ import annotations

import re

import msgspec

from urdf2mbs.diagram.boxes import Node
from urdf2mbs.spatial import HERE, ZERO, Pose, Vec, add, from_turn, multiply, rotate

ALIKE = 0.05
"""How far a limb may be off its partner's mirror image (share of the robot's size)."""
SIBLINGS = 24
"""Among more limbs of one body no partners are looked for."""
LEFT = re.compile(r"[Ll]eft|LEFT|(^|[^A-Za-z])[lL]([^A-Za-z]|$)|^L[A-Z][a-z]|(^|_)[FHRB]L(_|$)")
RIGHT = re.compile(r"[Rr]ight|RIGHT|(^|[^A-Za-z])[rR]([^A-Za-z]|$)|^R[A-Z][a-z]|(^|_)[FHRB]R(_|$)")


class Limb(msgspec.Struct, gc=False):
    """A body and all below it: lengths in m, seen from the front (aside, away, up)."""

    start: Vec
    """Where it leaves its parent."""
    at: Vec
    """The body's frame."""
    middle: Vec
    """The mean of its start and of all its bodies' frames."""
    bodies: int
    depth: int
    """Bodies one after the other, at the most."""
    partner: Node | None = None
    """Its mirror image, beside it on the same parent."""


class Shape(msgspec.Struct):
    limbs: dict[str, Limb]
    """By the name of the body with which a limb begins."""
    size: float
    """Of the robot, along the longest of the three axes (m)."""
    pairs: int
    """Limbs of two bodies or more that have a mirror image."""

    def aside(self, node: Node) -> float:
        """How far a limb is to the right of the picture, as a share of the robot's size."""
        return self.limbs[node.name].middle[0] / self.size if self.size else 0.0


def look(order: list[Node]) -> Shape:
    """The robot's shape; ``order`` is the base, then the bodies depth first."""
    frames, starts = _pose(order)
    places = [frames[node.name].xyz for node in order[1:]] or [ZERO]
    size = max(max(at[k] for at in places) - min(at[k] for at in places) for k in range(3))
    middle = places[0]
    best: Shape | None = None
    for axis in (1, 0):
        seen = Shape(_limbs(order, frames, starts, axis, middle[axis]), size, 0)
        if size:
            seen.pairs = _find_partners(order, seen)
        if best is None or seen.pairs > best.pairs:
            best = seen
    assert best is not None
    votes = 0
    for limb in best.limbs.values():
        if limb.partner is not None and limb.start[0] != 0.0:
            name = limb.partner.name
            other = 1 if LEFT.search(name) else -1 if RIGHT.search(name) else 0
            votes += other if limb.start[0] < 0.0 else -other
    if votes < 0:
        for limb in best.limbs.values():
            for what in ("start", "at", "middle"):
                x, y, z = getattr(limb, what)
                setattr(limb, what, (-x, y, z))
    return best


def _pose(order: list[Node]) -> tuple[dict[str, Pose], dict[str, Vec]]:
    """Each body's frame, and where its parent's point is, in the start pose."""
    frames: dict[str, Pose] = {"": HERE}
    starts: dict[str, Vec] = {}
    for node in order:
        here = frames[node.name]
        for lead in node.leads:
            shift = ZERO if lead.point is None else lead.point.coordinates
            start = add(here.xyz, rotate(here.rot, shift))
            for child in lead.nodes:
                xyz, rot = start, here.rot
                for joint in child.joints:
                    k, q = int(joint.type[1]), joint.q or 0.0
                    if q == 0.0:
                        continue
                    if joint.type[0] == "R":
                        rot = multiply(rot, from_turn((k, q)))
                    else:
                        along = (q * (k == 1), q * (k == 2), q * (k == 3))
                        xyz = add(xyz, rotate(rot, along))
                frames[child.name], starts[child.name] = Pose(xyz, rot), start
    return frames, starts


def _limbs(
    order: list[Node], frames: dict[str, Pose], starts: dict[str, Vec], axis: int, middle: float
) -> dict[str, Limb]:
    def seen(at: Vec) -> Vec:
        return (at[axis] - middle, at[1 - axis], at[2])

    limbs: dict[str, Limb] = {}
    sums: dict[str, Vec] = {}
    for node in reversed(order[1:]):
        start, at = seen(starts[node.name]), seen(frames[node.name].xyz)
        total, bodies, depth = at, 1, 0
        for child in node.children:
            below = limbs[child.name]
            total = add(total, sums[child.name])
            bodies, depth = bodies + below.bodies, max(depth, below.depth)
        sums[node.name] = total
        x, y, z = add(total, start)
        mean = (x / (bodies + 1), y / (bodies + 1), z / (bodies + 1))
        limbs[node.name] = Limb(start, at, mean, bodies, depth + 1)
    return limbs


def _find_partners(order: list[Node], shape: Shape) -> int:
    """Link each limb to its mirror image; counts those of two bodies or more."""
    limbs, pairs = shape.limbs, 0
    for node in order[1:]:
        children = node.children
        if len(children) > SIBLINGS:
            continue
        for one in children:
            mine = limbs[one.name]
            if mine.start[0] <= 0.0 and mine.middle[0] <= 0.0:
                continue
            best, other = ALIKE * shape.size, None
            for candidate in children:
                its = limbs[candidate.name]
                if candidate is one or its.partner or its.bodies != mine.bodies:
                    continue
                off = max(_off(mine.start, its.start), 0.5 * _off(mine.middle, its.middle))
                apart = max(abs(mine.start[0] - its.start[0]), abs(mine.middle[0] - its.middle[0]))
                if off <= min(best, apart):
                    best, other = off, candidate
            if other is not None:
                mine.partner, limbs[other.name].partner = other, one
                pairs += mine.bodies > 1
    return pairs


def _off(one: Vec, other: Vec) -> float:
    """How far one place is off the other's mirror image."""
    return max(abs(one[0] + other[0]), abs(one[1] - other[1]), abs(one[2] - other[2]))
