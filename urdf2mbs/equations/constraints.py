"""Cuts: the equations that close the loops of a model, h = 0.

A ``rod`` keeps the distance of two points, a ``ball`` keeps them together, a ``solid`` also
keeps the axes of their bodies parallel.  All is seen from the frame from which the ways to
both ends part: nothing further in can matter.
"""

from __future__ import annotations

from dataclasses import dataclass

from urdf2mbs.equations.forces import common, ends
from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.kinematics import Motion, motion
from urdf2mbs.equations.tree import NONE, Tree, Vector
from urdf2mbs.mbs.model import Connection

#: The order of Robotran's equations; within a kind, that of the file.
ORDER = ("ball", "rod", "solid")
EQUATIONS = {"ball": 3, "rod": 1, "solid": 6}


@dataclass
class Constraint:
    """One equation: h, its derivatives by the joints, and what is left of h'' at qdd = 0."""

    value: Expr
    jacobian: dict[int, Expr]
    jdqd: Expr


def constraints(tree: Tree) -> list[Constraint]:
    """The equations of all cuts, in their order."""
    out: list[Constraint] = []
    rods = 0
    for kind in ORDER:
        for cut in tree.mbs.cuts:
            if cut.kind != kind:
                continue
            one, two = _both(tree, cut)
            if kind == "rod":
                rods += 1
                out.append(_rod(tree, one, two, tree.parameter(cut.length, f"lrod[{rods}]")))
                continue
            out += _ball(tree, one, two)
            if kind == "solid":
                out += _parallel(tree, one, two)
    return out


def _both(tree: Tree, cut: Connection) -> tuple[Motion, Motion]:
    (last1, at1), (last2, at2) = ends(tree, cut)
    start = common(tree, last1, last2)
    return (
        motion(tree, last1, at1, start=start, accelerations=False),
        motion(tree, last2, at2, start=start, accelerations=False),
    )


def _difference(tree: Tree, one: dict[int, Vector], two: dict[int, Vector]) -> dict[int, Vector]:
    return {k: tree.minus(two.get(k, NONE), one.get(k, NONE)) for k in sorted({*one, *two})}


def _rod(tree: Tree, one: Motion, two: Motion, length: Expr) -> Constraint:
    """Half the difference of the squares of distance and length."""
    graph = tree.graph
    d = tree.minus(two.position, one.position)
    v = tree.minus(two.velocity, one.velocity)
    a = tree.minus(two.acceleration, one.acceleration)
    half = graph.constant(0.5)
    value = graph.mul(half, graph.sub(tree.dot(d, d), graph.mul(length, length)))
    linear = _difference(tree, one.linear, two.linear)
    jacobian = {k: tree.dot(d, column) for k, column in linear.items()}
    return Constraint(value, jacobian, graph.add(tree.dot(v, v), tree.dot(d, a)))


def _ball(tree: Tree, one: Motion, two: Motion) -> list[Constraint]:
    d = tree.minus(two.position, one.position)
    a = tree.minus(two.acceleration, one.acceleration)
    linear = _difference(tree, one.linear, two.linear)
    return [
        Constraint(d[i], {k: column[i] for k, column in linear.items()}, a[i]) for i in range(3)
    ]


def _parallel(tree: Tree, one: Motion, two: Motion) -> list[Constraint]:
    """An axis of the one body at right angles to another of the other: yz, zx and xy."""
    graph = tree.graph
    angular = _difference(tree, one.angular, two.angular)
    out = []
    for i in range(3):
        a, b = one.axes[(i + 1) % 3], two.axes[(i + 2) % 3]
        normal = tree.cross(b, a)
        # (a b)' = (w2 - w1) (b x a)
        jacobian = {k: tree.dot(column, normal) for k, column in angular.items()}
        a1, b1 = tree.cross(one.spin, a), tree.cross(two.spin, b)
        a2 = tree.plus(tree.cross(one.spin_rate, a), tree.cross(one.spin, a1))
        b2 = tree.plus(tree.cross(two.spin_rate, b), tree.cross(two.spin, b1))
        mixed = graph.mul(graph.constant(2.0), tree.dot(a1, b1))
        rest = graph.add(graph.add(tree.dot(a2, b), tree.dot(a, b2)), mixed)
        out.append(Constraint(tree.dot(a, b), jacobian, rest))
    return out
