r"""Cuts: the equations h(q) = 0 that close the loops of a model.

A ``rod`` keeps the distance of two points, a ``ball`` keeps two points together, and a ``solid``
also keeps the axes of their bodies parallel.  All vectors are in axes of the last frame that is on
both chains of joints from the base to the points, so joints closer to the base have no effect::

    base --- o --- start --- o --- o --- point of end 1
                      \                       | cut
                       o --- o --- o --- point of end 2

For an equation h with Jacobian J, the generated functions compute h, J, and the part of the second
derivative that remains for qdd = 0 (Robotran's ``jdqd``)::

    h'' = J qdd + jdqd

As in Robotran, an equation is left out if its Jacobian is structurally zero: if no joint between
start and the points can change it, where sums of nonzero terms are assumed not to cancel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

from urdf2mbs.plugin import Connection, Mbs
from urdf2mbs_equations.graph import Expr, Scalar
from urdf2mbs_equations.kinematics import (
    AnchorPoint,
    Motion,
    compute_motion,
    find_common_ancestor,
    find_ends,
)
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import ZERO_VECTOR, Vector

#: The kinds of cuts, in the order of Robotran's equations; within a kind, the order of the file.
KINDS = ("ball", "rod", "solid")
#: A gap up to this (m, m^2 or 1) is a rounding of zero.
CLOSED = 1e-6


@dataclass
class Equation:
    """One equation h = 0."""

    direction: str
    """``along x``, ``about x``, or ``along the rod``."""
    value: Scalar
    """h: m for a ball, m^2 for a rod, 1 for a rotation of a solid."""
    jacobian: dict[int, Scalar]
    """dh/dq by joint number."""
    jdqd: Scalar
    is_movable: bool
    """False if the Jacobian is structurally zero: Robotran leaves the equation out."""


@dataclass
class Constraint(Equation):
    """An equation of a cut."""

    cut: Connection
    start: Frame
    """The last frame that is on both chains: ``value`` is in its axes."""


def list_constraints(tree: Tree) -> list[Constraint]:
    """Return the equations of all cuts that Robotran writes, in its order."""
    return [constraint for constraint in iterate_constraints(tree) if constraint.is_movable]


def count_equations(mbs: Mbs) -> int:
    """Return the number of equations of all cuts."""
    return len(list_constraints(Tree(mbs)))


def drops_row(mbs: Mbs) -> bool:
    """Return True if Robotran leaves out an equation, as that of a ball in a planar loop."""
    return not all(constraint.is_movable for constraint in iterate_constraints(Tree(mbs)))


def find_constant_gaps(mbs: Mbs) -> Iterator[tuple[str, str]]:
    """Find the cuts that can never close, since no joint changes one of their equations.

    Yields:
        The name of a cut, and a message about one of its equations.
    """
    tree, at_start = Tree(mbs), Tree(mbs, at_start=True)
    for constraint, number in zip(
        iterate_constraints(tree), iterate_constraints(at_start), strict=True
    ):
        assert not isinstance(number.value, Expr)  # at the start position, all data are numbers
        gap = abs(number.value)
        changes = any(x and tree.frames[k].is_variable for k, x in constraint.jacobian.items())
        if gap > CLOSED and not changes:
            yield constraint.cut.name, _describe_gap(constraint, gap)


def _describe_gap(constraint: Constraint, gap: float) -> str:
    start, name, direction = constraint.start, constraint.cut.name, constraint.direction
    axes = f"'{start.body.name}'" if start.body else "the ground"
    if direction == "along the rod":
        reason = "its ends are not as far apart as it is long"
    elif direction.startswith("along"):
        reason = f"its ends are {gap:.3g} m apart {direction} of {axes}"
    else:
        reason = f"its bodies are turned {direction} of {axes} (sine {gap:.3g})"
    return f"cut '{name}' can never close: {reason}, and no joint changes that"


def iterate_constraints(tree: Tree) -> Iterator[Constraint]:
    """Iterate over the equations of all cuts, those that Robotran leaves out included."""
    n_rods = 0
    cuts = [cut for kind in KINDS for cut in tree.mbs.cuts if cut.kind == kind]
    for cut in cuts:
        if cut.is_draft:
            continue
        end1, end2 = find_ends(tree, cut)
        start = find_common_ancestor(tree, end1.joint, end2.joint)
        first = compute_motion(tree, end1, start=start, accelerations=False)
        second = compute_motion(tree, end2, start=start, accelerations=False)
        structure = _find_structure(tree, end1, start).unite(_find_structure(tree, end2, start))
        if cut.kind == "rod":
            n_rods += 1
            length = tree.get_parameter(cut.length, f"lrod[{n_rods}]")
            equations = [_make_rod(first, second, length, structure)]
        else:
            equations = _make_ball(first, second, structure)
            if cut.kind == "solid":
                equations += _make_parallel_axes(first, second, structure)
        for equation in equations:
            yield Constraint(**vars(equation), cut=cut, start=tree.frames[start])


def _subtract_jacobians(left: dict[int, Vector], right: dict[int, Vector]) -> dict[int, Vector]:
    return {
        k: left.get(k, ZERO_VECTOR) - right.get(k, ZERO_VECTOR) for k in sorted({*left, *right})
    }


def _make_rod(first: Motion, second: Motion, length: Scalar, structure: Structure) -> Equation:
    """Return the equation of a rod.

    With d from the first point to the second, v and a its derivatives::

    h = (d . d - length^2) / 2      J = d^T (J2 - J1)      jdqd = v . v + d . a
    """
    d = second.position - first.position
    v = second.velocity - first.velocity
    value = 0.5 * (d @ d - length * length)
    difference = _subtract_jacobians(second.linear, first.linear)
    jacobian = {k: d @ column for k, column in difference.items()}
    jdqd = v @ v + d @ (second.acceleration - first.acceleration)
    is_movable = bool(structure.position & structure.linear)
    return Equation("along the rod", value, jacobian, jdqd, is_movable)


def _make_ball(first: Motion, second: Motion, structure: Structure) -> list[Equation]:
    """Return the equations of a ball: h = the first point minus the second."""
    gaps = first.position - second.position
    jdqd = first.acceleration - second.acceleration
    jacobian = _subtract_jacobians(first.linear, second.linear)
    return _split("along", gaps, jacobian, jdqd, structure.linear)


def _make_parallel_axes(first: Motion, second: Motion, structure: Structure) -> list[Equation]:
    """Return the equations of a solid that keep the axes of both bodies parallel.

    h is the elements (3,2), (1,3) and (2,1) of R1 R2^T, where the columns of R1 and R2 are the axes
    of the bodies.  As in Robotran, J is the difference of the angular Jacobians, which is dh/dq
    only where h = 0.
    """
    axes1, axes2 = first.axes.T, second.axes.T
    sines = Vector(axes1[i - 1] @ axes2[i - 2] for i in range(3))
    jdqd = first.omega_dot - second.omega_dot
    jacobian = _subtract_jacobians(first.angular, second.angular)
    return _split("about", sines, jacobian, jdqd, structure.angular)


def _split(
    preposition: str,
    values: Vector,
    jacobian: dict[int, Vector],
    jdqd: Vector,
    movable_axes: set[int],
) -> list[Equation]:
    """Split a vector equation into its equations along or about x, y and z."""
    return [
        Equation(
            f"{preposition} {axis}",
            values[i],
            {k: column[i] for k, column in jacobian.items()},
            jdqd[i],
            i in movable_axes,
        )
        for i, axis in enumerate("xyz")
    ]


class Structure(NamedTuple):
    """The coordinates (0, 1, 2) of a point and of its Jacobians that are not structurally zero."""

    position: set[int]
    linear: set[int]
    """Of the linear Jacobian, for any joint of the chain."""
    angular: set[int]

    def unite(self, structure: Structure) -> Structure:
        """Return the coordinates that are nonzero in one of two structures."""
        return Structure(*(a | b for a, b in zip(self, structure, strict=True)))


def _find_structure(tree: Tree, point: AnchorPoint, start: int) -> Structure:
    """Find the structure of a point in axes of the frame ``start``, from the point inwards.

    A rotation about axis k mixes the coordinates i and j of everything farther out; a translation
    adds its coordinate.  A revolute joint moves the point along (joint axis) x (position of the
    point relative to the joint).  A joint that never moves rotates by its angle and moves nothing.
    """
    structure = Structure({i for i in range(3) if point.position[i]}, set(), set())
    rotations: list[tuple[set[int], set[int]]] = []
    """Coordinates of the axis of each revolute joint, and of the position farther out."""
    number = point.joint
    while number != start:
        frame = tree.frames[number]
        i, j = (frame.axis + 1) % 3, (frame.axis + 2) % 3
        if frame.is_variable and frame.is_revolute:
            rotations.append(({frame.axis}, set(structure.position)))
        elif frame.is_variable:
            structure.linear.add(frame.axis)
        for coordinates in chain(structure, *rotations) if frame.sine else ():
            mixed = {i + j - k for k in coordinates if k != frame.axis}
            if not frame.cosine:
                coordinates.difference_update((i, j))
            coordinates.update(mixed)
        structure.position.update(k for k in range(3) if frame.offset[k])
        number = frame.parent
    for axis, position in rotations:
        structure.angular.update(axis)
        structure.linear.update(3 - i - j for i in axis for j in position if i != j)
    return structure
