"""Inverse dynamics and the mass matrix, in the frames of the bodies.

Forces by the recursive Newton-Euler method (Luh, Walker and Paul, 1980), the mass matrix by
composite bodies (Walker and Orin, 1982; both in Featherstone, Rigid Body Dynamics Algorithms,
2008, chapters 5 and 6).  What is particular is in ``docs/how-equations-are-made.md``.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import (
    IDENTITY,
    NONE,
    STILL,
    ZERO,
    Matrix,
    Spatial,
    Vector,
    outer,
)


@dataclass
class Moving:
    """How a frame moves, in its own axes.  The names are Robotran's."""

    omega: Vector
    """The angular velocity (rad/s)."""
    omega_dot: Vector
    alpha: Vector
    """The acceleration of the origin, less gravity (m/s^2)."""
    beta: Matrix
    """beta r = omega_dot x r + omega x (omega x r), for any r of the frame (1/s^2)."""


def joint_forces(tree: Tree, accelerated: Collection[int]) -> list[Scalar]:
    """The joint forces (N or Nm) by joint number (index 0 is 0), for q, qd and the qdd of some
    joints.

    Inwards go the force and the torque about a frame's origin that all further out needs.
    """
    frames = tree.frames
    moving, moments = motions(tree, accelerated), _second_moments(tree)
    needed = [STILL] * len(frames)
    out: list[Scalar] = [0] * len(frames)
    for frame in reversed(frames[1:]):
        k = frame.number
        force = _force(tree, frame, moving[k], moments[k]) + needed[k]
        out[k] = frame.along(force)
        needed[frame.parent] += frame.inward(force)
    return out


def motions(tree: Tree, accelerated: Collection[int]) -> list[Moving]:
    """How each frame moves for q, qd and the qdd of some joints."""
    out = [Moving(NONE, NONE, -tree.gravity(), ZERO)]
    for frame in tree.frames[1:]:
        before, axis = out[frame.parent], frame.unit
        qd, qdd = frame.qd, frame.qdd if frame.number in accelerated else 0
        alpha = before.alpha + before.beta @ frame.offset
        omega, omega_dot = frame.to_child(before.omega), frame.to_child(before.omega_dot)
        if frame.turns:
            omega_dot = omega_dot + omega.cross(qd * axis) + qdd * axis
            omega = omega + qd * axis
            alpha = frame.to_child(alpha)
            beta = _beta(omega, omega_dot)
        else:
            alpha = frame.to_child(alpha) + (omega.cross(2.0 * qd * axis) + qdd * axis)
            beta = frame.change.of_matrix(before.beta)
        out.append(Moving(omega, omega_dot, alpha, beta))
    return out


def _beta(w: Vector, rate: Vector) -> Matrix:
    """The matrix A with A r = rate x r + w x (w x r), all in the axes of one frame (1/s^2)."""
    xx, yy, zz = (x * x for x in w)
    xy, xz, yz = w[0] * w[1], w[0] * w[2], w[1] * w[2]
    return Matrix(
        (
            Vector((-(yy + zz), xy - rate[2], xz + rate[1])),
            Vector((xy + rate[2], -(xx + zz), yz - rate[0])),
            Vector((xz - rate[1], yz + rate[0], -(xx + yy))),
        )
    )


def _second_moments(tree: Tree) -> list[Matrix]:
    """Of each body, about its centre of mass, in its frame's axes: the sum of dm x x^T (kg m^2).

    What lies along the axis of a turn moves as the frame before it does, and is counted there.
    """
    frames = tree.frames
    out = [_second_moment(tree, frame) for frame in frames]
    for frame in reversed(frames[1:]):
        k, axis, parent = frame.number, frame.axis, frame.parent
        if parent and any(out[parent][i][i] for i in range(3)):
            moved = outer(frame.unit, frame.unit) * out[k][axis][axis] if frame.turns else out[k]
            out[parent] += frame.back.of_matrix(moved)
            out[k] -= moved
    return out


def _second_moment(tree: Tree, frame: Frame) -> Matrix:
    inertia = tree.inertia(frame)
    return 0.5 * inertia.trace * IDENTITY - inertia


def _force(tree: Tree, frame: Frame, moving: Moving, moments: Matrix) -> Spatial:
    """Force and moment about the frame's origin that a body needs, less what acts on it."""
    if frame.body is None:
        return STILL
    mass, centre = tree.mass(frame), tree.centre(frame)
    frc, trq = tree.loads(frame)
    f = mass * (moving.alpha + moving.beta @ centre) - frc
    return Spatial((f, turning(moving.beta, moments) + centre.cross(f) - trq))


def turning(beta: Matrix, moments: Matrix) -> Vector:
    """The sum of dm x x (beta x), by the elements of beta and of the second moments."""

    def about(x: int) -> Scalar:
        y, z = (x + 1) % 3, (x + 2) % 3
        return (
            beta[z][y] * moments[y][y]
            - beta[y][z] * moments[z][z]
            + moments[y][z] * (beta[z][z] - beta[y][y])
            + moments[x][y] * beta[z][x]
            - moments[x][z] * beta[y][x]
        )

    return Vector(map(about, range(3)))


@dataclass
class Matter:
    """Some matter in a frame: the sums of dm (kg), dm x (kg m) and dm x x^T (kg m^2)."""

    mass: Scalar
    first: Vector
    second: Matrix

    def __add__(self, more: Matter) -> Matter:
        return Matter(self.mass + more.mass, self.first + more.first, self.second + more.second)

    def turned(self, frame: Frame) -> Matter:
        """The same in the axes that the frame has if its joint is at zero."""
        s, c, k = frame.sin, frame.cos, frame.axis
        if not s and c == 1:
            return self
        i, j = (k + 1) % 3, (k + 2) % 3
        out = [list(row) for row in self.second]
        (ii, ij), (jj, ik, jk) = (out[i][i], out[i][j]), (out[j][j], out[i][k], out[j][k])
        u = s * (ii - jj) + 2.0 * c * ij
        out[i][i], out[j][j] = ii - s * u, jj + s * u
        out[i][j] = out[j][i] = c * u - ij
        out[i][k] = out[k][i] = c * ik - s * jk
        out[j][k] = out[k][j] = s * ik + c * jk
        return Matter(self.mass, frame.turned(self.first), Matrix(map(Vector, out)))

    def shifted(self, frame: Frame) -> Matter:
        """The same about the origin of the frame before, in its axes; it was ``turned``."""
        offset, first = frame.offset, frame.to_parent_axes(self.first)
        moved = 0.5 * self.mass * offset
        middle, twice = first + moved, 2.0 * offset

        def added(i: int, j: int) -> Scalar:
            if i == j:
                return twice[i] * middle[i]
            i, j = (i, j) if j == (i + 1) % 3 else (j, i)
            return offset[i] * middle[j] + offset[j] * middle[i]

        second = frame.back.of_matrix(self.second) + Matrix.of(added)
        return Matter(self.mass, middle + moved, second)


def matter(tree: Tree) -> list[Matter]:
    """Of each body about its frame's origin, in its axes."""
    out = []
    for frame in tree.frames:
        mass, centre = tree.mass(frame), tree.centre(frame)
        first = mass * centre
        out.append(Matter(mass, first, _second_moment(tree, frame) + outer(first, centre)))
    return out


def mass_matrix(tree: Tree) -> dict[tuple[int, int], Scalar]:
    """The elements of the mass matrix with row <= column, by joint number, zeros left out."""
    composite = matter(tree)
    matrix: dict[tuple[int, int], Scalar] = {}
    for frame in reversed(tree.frames[1:]):
        k, axis = frame.number, frame.axis
        own = composite[k]
        turned = own.turned(frame)
        if frame.turns:
            # the moment about the axis is the same before the turn, and takes fewer operations
            moment = [-x for x in turned.second[axis]]
            moment[axis] = own.second[axis - 2][axis - 2] + own.second[axis - 1][axis - 1]
            force = Spatial((frame.unit.cross(turned.first), Vector(moment)))
        else:
            force = Spatial((own.mass * frame.unit, own.first.cross(frame.unit)))
        matrix[k, k] = frame.along(force)
        _carry(tree, frame, force, matrix)
        composite[frame.parent] += turned.shifted(frame)
    return {key: value for key, value in matrix.items() if value}


def _carry(tree: Tree, frame: Frame, force: Spatial, matrix: dict[tuple[int, int], Scalar]) -> None:
    """Fill the column of a joint from force and moment about its origin, in the axes that its
    frame has where the joint is at zero."""
    column = frame.number
    f, n = frame.to_parent_axes(force.linear), frame.to_parent_axes(force.angular)
    force = Spatial((f, n + frame.offset.cross(f)))
    frame = tree.frames[frame.parent]
    while frame.number:
        matrix[frame.number, column] = frame.along(force)
        force = frame.inward(force)
        frame = tree.frames[frame.parent]
