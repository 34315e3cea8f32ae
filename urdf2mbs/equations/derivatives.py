"""Derivatives of the joint forces by q, qd and qdd, from composite bodies.

The closed forms of Singh, Russell and Wensing (Efficient analytical derivatives of rigid-body
dynamics using spatial vector algebra, 2022), in the frames of the bodies.  Each frame sees the
others as if its own origin stood still: no force changes if everything moves on evenly.  So its own
body has a spin and no velocity, and few terms are left.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from urdf2mbs.equations.dynamics import (
    Moving,
    add_matrices,
    inertial_force,
    matter,
    motions,
    multiply,
    outer,
    shift_moments,
    turn_moments,
)
from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.tree import NONE, Frame, Matrix, Tree, Vector, along, relabel_matrix

#: A linear vector and an angular one about the origin of a frame, in its axes.
Spatial = tuple[Vector, Vector]


@dataclass
class Unit:
    """What changes for all further out by a unit of a joint's q, of its qd, or of its qdd."""

    spin_by_q: Vector
    spin_by_qd: Vector
    by_q: Spatial
    """The acceleration; with what the change of spin adds in each body, this is all."""
    by_qd: Spatial
    by_qdd: Spatial


@dataclass
class Carried:
    """All that a joint carries."""

    mass: Expr
    first: Vector
    second: Matrix
    momentum: Vector
    """Twice the sum of dm v (kg m/s)."""
    mixed: Matrix
    """Twice the sum of dm x v^T, for the place x and the velocity v (kg m^2/s)."""
    force: Spatial
    """What its motion takes."""


@dataclass
class Felt:
    """What a joint's q, qd or qdd changes in the forces of joints further in, and its own force by
    the spin of these."""

    by_q: Spatial
    by_qd: Spatial
    by_qdd: Spatial
    by_spin: Vector


def derivatives(tree: Tree) -> dict[tuple[str, int, int], Expr]:
    """By ``q``, ``qd`` or ``qdd``, the derivatives of the force of a joint (the first number) by
    that of a joint (the second); zeros are left out."""
    moving, matters = motions(tree, range(len(tree.frames))), zip(*matter(tree), strict=True)
    carried = [
        _body(tree, frame, moving[frame.number], *matter)
        for frame, matter in zip(tree.frames, matters, strict=True)
    ]
    units = [_unit(tree, frame, moving[frame.number]) for frame in tree.frames]
    drifts = [_drift(tree, frame, moving[frame.parent].spin) for frame in tree.frames]
    out: dict[tuple[str, int, int], Expr] = {}
    for frame in reversed(tree.frames[1:]):
        k = frame.number
        felt, at = _felt(tree, carried[k], units[k]), frame
        while at.number:
            i = at.number
            out |= {(by, i, k): value for by, value in _inner(tree, felt, units[i])}
            out |= {(by, k, i): value for by, value in _outer(tree, felt, units[i])}
            felt, at = _inward(tree, at, felt, drifts[i]), tree.frames[at.parent]
        _gather(tree, frame, carried, drifts[k])
    return {key: value for key, value in out.items() if value}


def _body(
    tree: Tree, frame: Frame, moving: Moving, mass: Expr, first: Vector, second: Matrix
) -> Carried:
    twice = tree.times(tree.graph.constant(2.0), moving.spin)
    force = inertial_force(tree, frame, moving, mass, first, second)
    mixed = [list(tree.cross(twice, (x, y, z))) for x, y, z in second]
    return Carried(mass, first, second, tree.cross(twice, first), mixed, force)


def _unit(tree: Tree, frame: Frame, moving: Moving) -> Unit:
    axis = along(frame.axis, 1)
    across = tree.cross(moving.spin, axis)
    twice, change = tree.times(tree.graph.constant(2.0), across), multiply(tree, moving.field, axis)
    if frame.turns:
        by_q = tree.cross(moving.pull, axis), change
        return Unit(across, axis, by_q, (NONE, twice), (NONE, axis))
    return Unit(NONE, NONE, (change, NONE), (twice, NONE), (axis, NONE))


def _drift(tree: Tree, frame: Frame, spin: Vector) -> Vector:
    """Twice the velocity of a frame's origin, as the frame before it sees it."""
    own = NONE if frame.turns else tree.before(frame, along(frame.axis, frame.qd))
    velocity = tree.plus(tree.cross(spin, frame.offset), own)
    return tree.times(tree.graph.constant(2.0), velocity)


def _felt(tree: Tree, carried: Carried, unit: Unit) -> Felt:
    mixed, (linear, angular), (f, n) = _spread(tree, carried.mixed), unit.by_qdd, carried.force
    turned = tree.cross(angular, f), tree.plus(tree.cross(angular, n), tree.cross(linear, f))
    of_q, of_qd = (_spun(tree, carried, s) for s in (unit.spin_by_q, unit.spin_by_qd))
    return Felt(
        _plus(tree, turned, _plus(tree, _moved(tree, carried, unit.by_q), of_q)),
        _plus(tree, _moved(tree, carried, unit.by_qd), of_qd),
        _moved(tree, carried, unit.by_qdd),
        tree.plus(tree.cross(carried.momentum, linear), multiply(tree, mixed, angular)),
    )


def _moved(tree: Tree, carried: Carried, acceleration: Spatial) -> Spatial:
    """The force that takes an acceleration more."""
    (linear, angular), h = acceleration, carried.first
    f = tree.plus(tree.times(carried.mass, linear), tree.cross(angular, h))
    moment = multiply(tree, _spread(tree, carried.second), angular)
    return f, tree.plus(tree.cross(h, linear), moment)


def _spun(tree: Tree, carried: Carried, spin: Vector) -> Spatial:
    """The force that takes a spin more, as all moves: twice dm spin x v."""
    rows = _spread(tree, carried.mixed)
    columns = [[row[i] for row in rows] for i in range(3)]
    return tree.cross(spin, carried.momentum), multiply(tree, columns, spin)


def _inner(tree: Tree, felt: Felt, unit: Unit) -> Iterator[tuple[str, Expr]]:
    """The derivatives of the force of a joint further in."""
    for by, force in (("q", felt.by_q), ("qd", felt.by_qd), ("qdd", felt.by_qdd)):
        yield by, _work(tree, unit.by_qdd, force)


def _outer(tree: Tree, felt: Felt, unit: Unit) -> Iterator[tuple[str, Expr]]:
    """The derivatives by a joint further in."""
    add, dot = tree.graph.add, tree.dot
    turned = dot(unit.spin_by_q, felt.by_spin), dot(unit.spin_by_qd, felt.by_spin)
    yield "q", add(_work(tree, unit.by_q, felt.by_qdd), turned[0])
    yield "qd", add(_work(tree, unit.by_qd, felt.by_qdd), turned[1])
    yield "qdd", _work(tree, unit.by_qdd, felt.by_qdd)


def _inward(tree: Tree, frame: Frame, felt: Felt, drift: Vector) -> Felt:
    """The same, as the frame before sees it."""
    by_qdd = _carry(tree, frame, felt.by_qdd)
    by_spin = tree.plus(tree.inward(frame, felt.by_spin), tree.cross(drift, by_qdd[0]))
    return Felt(_carry(tree, frame, felt.by_q), _carry(tree, frame, felt.by_qd), by_qdd, by_spin)


def _carry(tree: Tree, frame: Frame, force: Spatial) -> Spatial:
    f, n = tree.inward(frame, force[0]), tree.inward(frame, force[1])
    return f, tree.plus(n, tree.cross(frame.offset, f))


def _gather(tree: Tree, frame: Frame, carried: list[Carried], drift: Vector) -> None:
    """Add what a joint carries to what the one before it carries."""
    own, before, offset = carried[frame.number], carried[frame.parent], frame.offset
    h, second, mixed = tree.inward(frame, own.first), own.second, own.mixed
    if frame.turns:
        second, mixed = turn_moments(tree, frame, second), _turn(tree, frame, mixed)
    second, mixed = relabel_matrix(second, frame.back), relabel_matrix(mixed, frame.back)
    momentum = tree.plus(tree.inward(frame, own.momentum), tree.times(own.mass, drift))
    mixed = add_matrices(tree, mixed, outer(tree, h, drift))
    mixed = add_matrices(tree, mixed, outer(tree, offset, momentum))
    first, second = shift_moments(tree, own.mass, h, second, offset)
    before.mass = tree.graph.add(before.mass, own.mass)
    before.first = tree.plus(before.first, first)
    before.second = add_matrices(tree, before.second, second)
    before.momentum = tree.plus(before.momentum, momentum)
    before.mixed = add_matrices(tree, before.mixed, mixed)
    before.force = _plus(tree, before.force, _carry(tree, frame, own.force))


def _plus(tree: Tree, a: Spatial, b: Spatial) -> Spatial:
    return tree.plus(a[0], b[0]), tree.plus(a[1], b[1])


def _work(tree: Tree, motion: Spatial, force: Spatial) -> Expr:
    return tree.graph.add(tree.dot(motion[0], force[0]), tree.dot(motion[1], force[1]))


def _turn(tree: Tree, frame: Frame, matrix: Matrix) -> Matrix:
    """A matrix given in the frame behind a turn, in the axes of the frame before it."""
    for _ in range(2):
        rows = [tree.turn(frame.axis, frame.cos, frame.sin, (x, y, z)) for x, y, z in matrix]
        matrix = [[row[i] for row in rows] for i in range(3)]
    return matrix


def _spread(tree: Tree, matrix: Matrix) -> Matrix:
    """The trace as a matrix, less a matrix: the inertia of second moments."""
    out = [[-x for x in row] for row in matrix]
    for i in range(3):
        out[i][i] = tree.graph.add(matrix[i - 2][i - 2], matrix[i - 1][i - 1])
    return out
