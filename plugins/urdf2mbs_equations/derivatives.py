"""Derivatives of the joint forces by q, qd and qdd, from composite bodies.

The closed forms of Singh, Russell and Wensing (Efficient analytical derivatives of rigid-body
dynamics using spatial vector algebra, 2022), in the frames of the bodies.  Each frame sees the
others as if its own origin stood still: no force changes if everything moves on evenly.  So its own
body has an angular velocity and no velocity, and few terms are left.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from urdf2mbs_equations.dynamics import Matter, Moving, matter, motions, turning
from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import NONE, Matrix, Spatial, Vector, outer


@dataclass
class JointMotion:
    """What changes for all further out by a unit of a joint's q, of its qd, or of its qdd."""

    omega_by_q: Vector
    """The change of the angular velocity."""
    omega_by_qd: Vector
    by_q: Spatial
    """The change of the acceleration; a change of omega adds its own in each body."""
    by_qd: Spatial
    by_qdd: Spatial


@dataclass
class Composite:
    """All that a joint carries, about the origin of its frame and in its axes."""

    matter: Matter
    momentum: Vector
    """Twice the sum of dm v (kg m/s)."""
    mixed: Matrix
    """Twice the sum of dm x v^T, for the place x and the velocity v (kg m^2/s)."""
    force: Spatial
    """What its motion takes."""

    def __add__(self, more: Composite) -> Composite:
        return Composite(
            self.matter + more.matter, self.momentum + more.momentum, self.mixed + more.mixed,
            self.force + more.force,
        )  # fmt: skip

    def accelerated(self, acceleration: Spatial) -> Spatial:
        """The force that an acceleration takes."""
        (linear, angular), first = acceleration, self.matter.first
        f = self.matter.mass * linear + angular.cross(first)
        return Spatial((f, first.cross(linear) + _spread(self.matter.second) @ angular))

    def spun(self, omega: Vector) -> Spatial:
        """The force that an angular velocity more takes, as all moves: twice dm omega x v."""
        return Spatial((omega.cross(self.momentum), _spread(self.mixed).T @ omega))


@dataclass
class Wrenches:
    """What a joint's q, qd or qdd changes in the forces of joints further in, and its own force by
    the angular velocity of these."""

    by_q: Spatial
    by_qd: Spatial
    by_qdd: Spatial
    by_omega: Vector

    def of_inner(self, joint: JointMotion) -> Iterator[tuple[str, Scalar]]:
        """The derivatives of the force of a joint further in."""
        for by, force in (("q", self.by_q), ("qd", self.by_qd), ("qdd", self.by_qdd)):
            yield by, joint.by_qdd @ force

    def by_inner(self, joint: JointMotion) -> Iterator[tuple[str, Scalar]]:
        """The derivatives by a joint further in."""
        yield "q", joint.by_q @ self.by_qdd + joint.omega_by_q @ self.by_omega
        yield "qd", joint.by_qd @ self.by_qdd + joint.omega_by_qd @ self.by_omega
        yield "qdd", joint.by_qdd @ self.by_qdd

    def inward(self, frame: Frame, drift: Vector) -> Wrenches:
        """The same, as the frame before sees it."""
        by_qdd = frame.inward(self.by_qdd)
        by_omega = frame.to_parent(self.by_omega) + drift.cross(by_qdd.linear)
        return Wrenches(frame.inward(self.by_q), frame.inward(self.by_qd), by_qdd, by_omega)


def derivatives(tree: Tree) -> dict[tuple[str, int, int], Scalar]:
    """By ``q``, ``qd`` or ``qdd``, the derivatives of the force of a joint (the first number) by
    that of a joint (the second); zeros are left out."""
    moving = motions(tree, range(len(tree.frames)))
    composite = [
        _body(tree, frame, moving[frame.number], own)
        for frame, own in zip(tree.frames, matter(tree), strict=True)
    ]
    joints = [_joint_motion(frame, moving[frame.number]) for frame in tree.frames]
    drifts = [_drift(frame, moving[frame.parent].omega) for frame in tree.frames]
    out: dict[tuple[str, int, int], Scalar] = {}
    for frame in reversed(tree.frames[1:]):
        k = frame.number
        wrenches, at = _wrenches(composite[k], joints[k]), frame
        while at.number:
            i = at.number
            out |= {(by, i, k): value for by, value in wrenches.of_inner(joints[i])}
            out |= {(by, k, i): value for by, value in wrenches.by_inner(joints[i])}
            wrenches, at = wrenches.inward(at, drifts[i]), tree.frames[at.parent]
        composite[frame.parent] += _inward(frame, composite[k], drifts[k])
    return {key: value for key, value in out.items() if value}


def _body(tree: Tree, frame: Frame, moving: Moving, own: Matter) -> Composite:
    """A body alone."""
    alpha, beta, first = moving.alpha, moving.beta, own.first
    f = own.mass * alpha + beta @ first
    n = first.cross(alpha) + turning(beta, own.second)
    if frame.body is not None:
        frc, trq = tree.loads(frame)
        f, n = f - frc, n - (trq + tree.centre(frame).cross(frc))
    twice = 2.0 * moving.omega
    mixed = Matrix(map(twice.cross, own.second))
    return Composite(own, twice.cross(first), mixed, Spatial((f, n)))


def _joint_motion(frame: Frame, moving: Moving) -> JointMotion:
    axis = frame.unit
    across = moving.omega.cross(axis)
    twice, change = 2.0 * across, moving.beta @ axis
    if frame.turns:
        by_q = Spatial((moving.alpha.cross(axis), change))
        return JointMotion(across, axis, by_q, Spatial((NONE, twice)), frame.motion)
    by_q, by_qd = Spatial((change, NONE)), Spatial((twice, NONE))
    return JointMotion(NONE, NONE, by_q, by_qd, frame.motion)


def _drift(frame: Frame, omega: Vector) -> Vector:
    """Twice the velocity of a frame's origin, as the frame before it sees it."""
    own = frame.to_parent_axes(frame.qd * frame.motion.linear)
    return 2.0 * (omega.cross(frame.offset) + own)


def _wrenches(composite: Composite, joint: JointMotion) -> Wrenches:
    (linear, angular), (f, n) = joint.by_qdd, composite.force
    turned = Spatial((angular.cross(f), angular.cross(n) + linear.cross(f)))
    of_q, of_qd = composite.spun(joint.omega_by_q), composite.spun(joint.omega_by_qd)
    return Wrenches(
        turned + (composite.accelerated(joint.by_q) + of_q),
        composite.accelerated(joint.by_qd) + of_qd,
        composite.accelerated(joint.by_qdd),
        composite.momentum.cross(linear) + _spread(composite.mixed) @ angular,
    )


def _inward(frame: Frame, own: Composite, drift: Vector) -> Composite:
    """The same, as the frame before sees it."""
    turned = own.matter.turned(frame)
    rows = map(frame.to_parent, own.mixed)
    mixed = Matrix(map(frame.to_parent, Matrix(rows).T)).T
    momentum = frame.to_parent(own.momentum) + own.matter.mass * drift
    mixed += outer(frame.to_parent_axes(turned.first), drift)
    mixed += outer(frame.offset, momentum)
    return Composite(turned.shifted(frame), momentum, mixed, frame.inward(own.force))


def _spread(matrix: Matrix) -> Matrix:
    """The trace as a matrix, less a matrix: the inertia of second moments."""
    m = matrix
    sums = Vector((m[1][1] + m[2][2], m[2][2] + m[0][0], m[0][0] + m[1][1]))
    return Matrix.of(lambda i, j: sums[i] if i == j else -m[i][j])
