"""A tidy tree: every parent at the middle above its children, all wires straight.

Children stand side by side, each below its own point on the parent's edge, which is as long as
that takes.  Where many children hang on one body, they run to its two sides instead, one below
the other: that is a comb, and takes less room.
"""

from __future__ import annotations

from collections.abc import Container

from urdf2mbs.diagram.boxes import Lead, Node, Plan
from urdf2mbs.diagram.plan import plan, put
from urdf2mbs.diagram.shape import Shape
from urdf2mbs.mbs.model import Mbs

MANY = 4
"""From so many points that carry children on, a comb is tried."""
BETTER = 0.75
"""A comb is taken where its width and height together are at most this share of the tree's."""
BETTER_NARROW = 0.9
"""The same in a limb, where width counts twice."""
UP = 0.25
"""A tree grows up where its bodies are on average so far above the first one (share of the
robot's size)."""
UPRIGHT, BOTH = (True,), (True, False)
"""A limb is planned upright, or upright and lying."""


def arrange(mbs: Mbs, order: list[Node], shape: Shape) -> None:
    """Give everything its place; ``order`` is the base, then the bodies depth first."""
    rises = [shape.limbs[n.name].at[2] - shape.limbs[order[1].name].start[2] for n in order[1:]]
    up = bool(rises) and sum(rises) / len(rises) > UP * shape.size
    for node in order:
        node.sort(shape.aside)
    ways = ways_of(order, MANY)
    for node in reversed(order):
        plan_tree(node, ways.get(node.name, UPRIGHT))
    way = (0.0, 0.0, 0.0, -1.0 if up else 1.0, 1.0, 0.0)
    put(mbs, order[0], way, order[0].plan[True])


def ways_of(
    order: list[Node], many: int, apart: Container[str] = ()
) -> dict[str, tuple[bool, ...]]:
    """Which plans of each body can be needed, but for the base and the bodies ``apart``.

    Below a body with so many points that carry children, limbs may lie: a comb's limbs run across.
    """
    ways: dict[str, tuple[bool, ...]] = {}
    for node in order:
        own = ways.get(node.name, UPRIGHT)
        if node.name not in apart and sum(lead.point is not None for lead in node.leads) >= many:
            own = BOTH
        ways |= {child.name: own for child in node.children if child.name not in apart}
    return ways


def plan_tree(node: Node, ways: tuple[bool, ...] = BOTH, *, narrow: bool = False) -> None:
    """Plan a body whose children are planned; ``narrow`` where width counts more than height."""
    comb_too = all(lead.point is not None for lead in node.leads)
    for vertical in ways:
        best = plan(node, vertical, node.leads)
        combs = []
        if comb_too and len(node.leads) >= MANY:
            combs.append(plan(node, vertical, [], *halves(node.leads, not vertical)))
        if comb_too and narrow and len(node.leads) > vertical:
            combs.append(plan(node, vertical, [], [], node.leads))
        for comb in combs:
            if _cost(comb, narrow) < (BETTER_NARROW if narrow else BETTER) * _cost(best, narrow):
                best = comb
        node.plan[vertical] = best


def _cost(one: Plan, narrow: bool) -> float:
    a0, a1, b0, b1 = one.extent
    width, height = (b1 - b0, a1 - a0) if one.vertical else (a1 - a0, b1 - b0)
    return (2 if narrow else 1) * width + height


def halves(leads: list[Lead], vertical: bool) -> tuple[list[Lead], list[Lead]]:
    """Two parts, in order, that take about the same room."""
    room = []
    for lead in leads:
        extents = [node.plan[vertical].extent for node in lead.nodes]
        room.append(sum(high - low for _, _, low, high in extents))
    total, so_far = sum(room), 0.0
    for index, size in enumerate(room):
        if so_far + size / 2 >= total / 2:
            return leads[:index], leads[index:]
        so_far += size
    return leads, []
