"""What a robot looks like from the front, in its start pose: where limbs begin and lead to.

Up is up.  The robot faces you: its left (URDF's y) is at the right.  A robot whose limbs are
mirror images along x instead is looked at along y; names like ``left`` and ``l_`` then, and
where a robot faces backwards, say which side is which.
"""

from __future__ import annotations

import re

import msgspec

from urdf2mbs.diagram.boxes import Node
from urdf2mbs.mbs.kinematics import compute_placement
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.spatial import Vec

ALIKE = 0.05
"""How far a limb may be off its partner's mirror image (share of the robot's size)."""
SIBLINGS = 24
"""Among more limbs of one body no partners are looked for."""
LEFT = re.compile(r"[Ll]eft|LEFT|(^|[^A-Za-z])[lL]([^A-Za-z]|$)|^L[A-Z][a-z]|(^|_)[FHRB]L(_|$)")
RIGHT = re.compile(r"[Rr]ight|RIGHT|(^|[^A-Za-z])[rR]([^A-Za-z]|$)|^R[A-Z][a-z]|(^|_)[FHRB]R(_|$)")


class Limb(msgspec.Struct):
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


def look(mbs: Mbs, order: list[Node]) -> Shape:
    """The robot's shape; ``order`` is the base, then the bodies depth first."""
    placement = compute_placement(mbs)
    places = {body.name: placement.bodies[body.name].xyz for body in mbs.bodies}
    starts: dict[str, Vec] = {}
    """Where each body leaves its parent."""
    joints = iter(placement.joints)
    for body in mbs.bodies:
        starts[body.name], *_ = (next(joints).origin for _ in body.joints)
    columns = zip(*places.values(), strict=True)
    size = max([max(column) - min(column) for column in columns], default=0.0)
    best = _seen(order, starts, places, 1, size)
    if best.pairs < _most_pairs(order, best):
        along_y = _seen(order, starts, places, 0, size)
        best = along_y if along_y.pairs > best.pairs else best
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


def _seen(
    order: list[Node], starts: dict[str, Vec], places: dict[str, Vec], axis: int, size: float
) -> Shape:
    """The shape, where ``axis`` (0: x, 1: y) runs aside, from the first body."""
    limbs: dict[str, Limb] = {}
    sums: dict[str, Vec] = {}
    middle = places[order[1].name][axis] if places else 0.0
    for node in reversed(order[1:]):
        name = node.name
        start, at = starts[name], places[name]
        x, y, z = start = (start[axis] - middle, start[1 - axis], start[2])
        a, b, c = at = (at[axis] - middle, at[1 - axis], at[2])
        bodies, depth = 1, 0
        for child in node.children:
            below, (d, e, f) = limbs[child.name], sums[child.name]
            a, b, c = a + d, b + e, c + f
            bodies, depth = bodies + below.bodies, max(depth, below.depth)
        sums[name] = (a, b, c)
        mean = ((a + x) / (bodies + 1), (b + y) / (bodies + 1), (c + z) / (bodies + 1))
        limbs[name] = Limb(start, at, mean, bodies, depth + 1)
    shape = Shape(limbs, size, 0)
    if size:
        shape.pairs = _find_partners(order, shape)
    return shape


def _find_partners(order: list[Node], shape: Shape) -> int:
    """Link each limb to its mirror image; counts those of two bodies or more."""
    limbs, pairs = shape.limbs, 0
    for node in order[1:]:
        if not 2 <= len(node.children) <= SIBLINGS:
            continue
        siblings = [(child, limbs[child.name]) for child in node.children]
        for one, mine in siblings:
            if mine.start[0] <= 0.0 and mine.middle[0] <= 0.0:
                continue
            best, found = ALIKE * shape.size, None
            for candidate, its in siblings:
                if its is mine or its.partner or its.bodies != mine.bodies:
                    continue
                off = max(_off(mine.start, its.start), 0.5 * _off(mine.middle, its.middle))
                apart = max(abs(mine.start[0] - its.start[0]), abs(mine.middle[0] - its.middle[0]))
                if off <= min(best, apart):
                    best, found = off, (candidate, its)
            if found is not None:
                mine.partner, found[1].partner = found[0], one
                pairs += mine.bodies > 1
    return pairs


def _most_pairs(order: list[Node], shape: Shape) -> int:
    """No view shows more: partners are on one parent and have as many bodies."""
    most = 0
    for node in order[1:]:
        if len(node.children) > 1:
            bodies = [shape.limbs[child.name].bodies for child in node.children]
            large = [count for count in bodies if count > 1]
            most += len(large) - len(set(large))
    return most


def _off(one: Vec, other: Vec) -> float:
    """How far one place is off the other's mirror image."""
    return max(abs(one[0] + other[0]), abs(one[1] - other[1]), abs(one[2] - other[2]))
