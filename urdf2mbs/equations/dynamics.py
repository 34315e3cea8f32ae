"""Inverse dynamics and the mass matrix, in the frames of the bodies.

Forces by the recursive Newton-Euler method (Luh, Walker and Paul, 1980), the mass matrix by
composite bodies (Walker and Orin, 1982; both in Featherstone, Rigid Body Dynamics Algorithms,
2008, chapters 5 and 6).  What is particular is in ``docs/how-equations-are-made.md``.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from urdf2mbs.equations.columns import Columns
from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.tree import (
    NONE,
    Frame,
    Matrix,
    Tree,
    Vector,
    along,
    relabel_matrix,
)


@dataclass
class Moving:
    """How a frame moves, in its own axes."""

    spin: Vector
    """(rad/s)"""
    spin_rate: Vector
    pull: Vector
    """The acceleration of the origin, less gravity (m/s^2)."""
    field: Matrix
    """The matrix A with A r = spin_rate x r + spin x (spin x r) (1/s^2)."""


def joint_forces(tree: Tree, accelerated: Collection[int]) -> list[Expr]:
    """The joint forces (N or Nm) by joint number (index 0 is 0), for q, qd and the qdd of some
    joints.

    Inwards go the force and the torque about a frame's origin that all further out needs.
    """
    moving, moments = motions(tree, accelerated), _second_moments(tree)
    frames = tree.frames
    out = [0] * len(frames)
    force: list[Vector] = [NONE] * len(frames)
    torque: list[Vector] = [NONE] * len(frames)
    for frame in reversed(frames[1:]):
        k = frame.number
        own, moment = _body(tree, frame, moving[k], moments[k])
        f, n = tree.plus(own, force[k]), tree.plus(moment, torque[k])
        out[k] = n[frame.axis] if frame.turns else f[frame.axis]
        f, n = tree.inward(frame, f), tree.inward(frame, n)
        n = tree.plus(n, tree.cross(frame.offset, f))
        force[frame.parent] = tree.plus(force[frame.parent], f)
        torque[frame.parent] = tree.plus(torque[frame.parent], n)
    return out


def motions(tree: Tree, accelerated: Collection[int]) -> list[Moving]:
    """How each frame moves for q, qd and the qdd of some joints."""
    graph = tree.graph
    add, mul = graph.add, graph.mul
    gravity = tree.gravity()
    out = [Moving(NONE, NONE, (-gravity[0], -gravity[1], -gravity[2]), [[0] * 3 for _ in "xyz"])]
    for frame in tree.frames[1:]:
        before, axis = out[frame.parent], frame.axis
        qdd = frame.qdd if frame.number in accelerated else 0
        a = tree.plus(before.pull, multiply(tree, before.field, frame.offset))
        if frame.turns:
            w = tree.outward(frame, before.spin)
            rate = tree.outward(frame, before.spin_rate)
            i, j = (axis + 1) % 3, (axis + 2) % 3
            turned = list(rate)
            # w x (axis qd)
            turned[i] = add(rate[i], mul(w[j], frame.qd))
            turned[j] = add(rate[j], -mul(w[i], frame.qd))
            turned[axis] = add(rate[axis], qdd)
            w = tree.plus(w, along(axis, frame.qd))
            rate = (turned[0], turned[1], turned[2])
            a = tree.outward(frame, a)
            field = _field(tree, w, rate)
        else:
            w, rate = tree.behind(frame, before.spin), tree.behind(frame, before.spin_rate)
            a, field = tree.behind(frame, a), relabel_matrix(before.field, frame.change)
            coriolis = tree.cross(w, along(axis, mul(graph.constant(2.0), frame.qd)))
            a = tree.plus(a, tree.plus(coriolis, along(axis, qdd)))
        out.append(Moving(w, rate, a, field))
    return out


def multiply(tree: Tree, matrix: Matrix, v: Vector) -> Vector:
    x, y, z = (tree.dot((row[0], row[1], row[2]), v) for row in matrix)
    return x, y, z


def _field(tree: Tree, w: Vector, rate: Vector) -> Matrix:
    """The matrix A with A r = rate x r + w x (w x r), all in the axes of one frame (1/s^2)."""
    add, mul = tree.graph.add, tree.graph.mul
    xx, yy, zz = (mul(x, x) for x in w)
    xy, xz, yz = mul(w[0], w[1]), mul(w[0], w[2]), mul(w[1], w[2])
    return [
        [-add(yy, zz), add(xy, -rate[2]), add(xz, rate[1])],
        [add(xy, rate[2]), -add(xx, zz), add(yz, -rate[0])],
        [add(xz, -rate[1]), add(yz, rate[0]), -add(xx, yy)],
    ]


def _second_moments(tree: Tree) -> list[Matrix]:
    """Of each body, about its centre of mass, in its frame's axes: the sum of dm x x^T (kg m^2).

    What lies along the axis of a turn moves as the frame before it does, and is counted there.
    """
    add, frames = tree.graph.add, tree.frames
    out = [_second_moment(tree, frame) for frame in frames]
    for frame in reversed(frames[1:]):
        own, before = out[frame.number], out[frame.parent]
        if not any(before[i][i] for i in range(3)) or not frame.parent:
            continue
        if frame.turns:
            axis, there = frame.axis, frame.change[frame.axis][0]
            before[there][there] = add(before[there][there], own[axis][axis])
            own[axis][axis] = 0
        else:
            out[frame.parent] = add_matrices(tree, before, relabel_matrix(own, frame.back))
            out[frame.number] = [[0] * 3 for _ in "xyz"]
    return out


def _second_moment(tree: Tree, frame: Frame) -> Matrix:
    add, inertia = tree.graph.add, tree.inertia(frame)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    half = tree.graph.mul(tree.graph.constant(0.5), add(add(xx, yy), zz))
    return [
        [add(half, -xx), -xy, -xz],
        [-xy, add(half, -yy), -yz],
        [-xz, -yz, add(half, -zz)],
    ]


def _body(tree: Tree, frame: Frame, moving: Moving, moments: Matrix) -> tuple[Vector, Vector]:
    """Force and moment about the frame's origin that a body needs, less what acts on it."""
    if frame.body is None:
        return NONE, NONE
    mass, centre = tree.mass(frame), tree.centre(frame)
    frc, trq = tree.loads(frame)
    f = tree.times(mass, tree.plus(moving.pull, multiply(tree, moving.field, centre)))
    f = tree.minus(f, frc)
    n = turning(tree, moving.field, moments)
    return f, tree.minus(tree.plus(n, tree.cross(centre, f)), trq)


def inertial_force(
    tree: Tree, frame: Frame, moving: Moving, mass: Expr, first: Vector, second: Matrix
) -> tuple[Vector, Vector]:
    """The same for mass, first and second moments about the frame's origin."""
    f = tree.plus(tree.times(mass, moving.pull), multiply(tree, moving.field, first))
    n = tree.plus(tree.cross(first, moving.pull), turning(tree, moving.field, second))
    if frame.body is None:
        return f, n
    frc, trq = tree.loads(frame)
    return tree.minus(f, frc), tree.minus(n, tree.plus(trq, tree.cross(tree.centre(frame), frc)))


def turning(tree: Tree, field: Matrix, moments: Matrix) -> Vector:
    """The sum of dm x x A x, by the elements of A and of the second moments."""
    add, mul = tree.graph.add, tree.graph.mul
    n = []
    for x in range(3):
        y, z = (x + 1) % 3, (x + 2) % 3
        term = add(mul(field[z][y], moments[y][y]), -mul(field[y][z], moments[z][z]))
        term = add(term, mul(moments[y][z], add(field[z][z], -field[y][y])))
        term = add(term, mul(moments[x][y], field[z][x]))
        n.append(add(term, -mul(moments[x][z], field[y][x])))
    return n[0], n[1], n[2]


def mass_matrix(tree: Tree) -> dict[tuple[int, int], Expr]:
    """The elements of the mass matrix with row <= column, by joint number, zeros left out."""
    add, frames = tree.graph.add, tree.frames
    mass, first, second = matter(tree)
    columns = Columns(tree)
    matrix: dict[tuple[int, int], Expr] = {}
    for frame in reversed(frames[1:]):
        k, axis = frame.number, frame.axis
        m, h, s = mass[k], first[k], second[k]
        if frame.turns:
            h, s = tree.turn(axis, frame.cos, frame.sin, h), turn_moments(tree, frame, s)
            i, j = (axis + 1) % 3, (axis + 2) % 3
            f = tree.cross(along(axis, 1), h)
            moment = [0, 0, 0]
            moment[axis] = add(second[k][i][i], second[k][j][j])
            moment[i], moment[j] = -s[i][axis], -s[j][axis]
            n = (moment[0], moment[1], moment[2])
            matrix[k, k] = n[axis]
        else:
            f = along(axis, m)
            n = tree.cross(h, along(axis, 1))
            matrix[k, k] = m
        h, s = tree.before(frame, h), relabel_matrix(s, frame.back)
        columns.carry(frame, tree.before(frame, f), tree.before(frame, n), matrix)
        parent, offset = frame.parent, frame.offset
        h, s = shift_moments(tree, m, h, s, offset)
        mass[parent] = add(mass[parent], m)
        first[parent] = tree.plus(first[parent], h)
        second[parent] = add_matrices(tree, second[parent], s)
    return {key: value for key, value in matrix.items() if value}


def matter(tree: Tree) -> tuple[list[Expr], list[Vector], list[Matrix]]:
    """Mass, first and second moments of each body about its frame's origin, in its axes."""
    add, mul = tree.graph.add, tree.graph.mul
    mass: list[Expr] = []
    first: list[Vector] = []
    second: list[Matrix] = []
    for frame in tree.frames:
        m, c, about = tree.mass(frame), tree.centre(frame), _second_moment(tree, frame)
        h = tree.times(m, c)
        mass.append(m)
        first.append(h)
        second.append([[add(about[i][j], mul(h[i], c[j])) for j in range(3)] for i in range(3)])
    return mass, first, second


def add_matrices(tree: Tree, a: Matrix, b: Matrix) -> Matrix:
    add = tree.graph.add
    return [[add(x, y) for x, y in zip(r, s, strict=True)] for r, s in zip(a, b, strict=True)]


def outer(tree: Tree, v: Vector, w: Vector) -> Matrix:
    """The matrix v w^T."""
    return [[tree.graph.mul(x, y) for y in w] for x in v]


def turn_moments(tree: Tree, frame: Frame, second: Matrix) -> Matrix:
    """Second moments given in the frame behind a turn, in the axes of the frame before it."""
    add, mul = tree.graph.add, tree.graph.mul
    s, c, k = frame.sin, frame.cos, frame.axis
    if s == 0 and c == 1:
        return second
    i, j = (k + 1) % 3, (k + 2) % 3
    out = [row[:] for row in second]
    twice = mul(tree.graph.constant(2.0), c)
    u = add(mul(s, add(second[i][i], -second[j][j])), mul(twice, second[i][j]))
    su = mul(s, u)
    out[i][i] = add(second[i][i], -su)
    out[j][j] = add(second[j][j], su)
    out[i][j] = out[j][i] = add(mul(c, u), -second[i][j])
    out[i][k] = out[k][i] = add(mul(c, second[i][k]), -mul(s, second[j][k]))
    out[j][k] = out[k][j] = add(mul(s, second[i][k]), mul(c, second[j][k]))
    return out


def shift_moments(
    tree: Tree, mass: Expr, first: Vector, second: Matrix, offset: Vector
) -> tuple[Vector, Matrix]:
    """First and second moments about a frame's origin, about the origin of the frame before it,
    whose axes all here have."""
    add, mul = tree.graph.add, tree.graph.mul
    moved = tree.times(mul(tree.graph.constant(0.5), mass), offset)
    middle = tree.plus(first, moved)
    out = [row[:] for row in second]
    twice = tree.times(tree.graph.constant(2.0), offset)
    for i in range(3):
        j = (i + 1) % 3
        out[i][i] = add(second[i][i], mul(twice[i], middle[i]))
        mixed = add(mul(offset[i], middle[j]), mul(offset[j], middle[i]))
        out[i][j] = out[j][i] = add(second[i][j], mixed)
    return tree.plus(middle, moved), out
