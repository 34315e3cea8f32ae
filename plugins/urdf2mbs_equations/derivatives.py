"""Derivatives of the joint forces by q, qd and qdd, from composite rigid bodies.

These are the closed forms of Singh, Russell and Wensing (Efficient analytical derivatives of
rigid-body dynamics using spatial vector algebra, 2022), in body frames.  Each frame describes all
bodies relative to an observer who moves with the velocity of its origin, without rotation.  Forces
do not depend on a constant velocity of the observer, and the frame's own body has an angular
velocity only, so few terms are left.

A change of q displaces the whole subtree of the joint by the twist S dq, with S the motion
subspace.  S moves with the axis of the joint; with its derivatives, the subtree changes by::

    displacement   S dq
    velocity       S' dq + S dqd              of which only the angular part dw changes forces
    acceleration   S'' dq + 2 S' dqd + S dqdd = (a, b), linear and angular

The force of a composite body changes with the velocities v of its parts.  With mass m, first moment
h, second moment K, and

    P = 2 sum of dm v      N = 2 sum of dm x v^T      spread(A) = trace(A) 1 - A

an acceleration (a, b) and an angular velocity dw require the force f and the moment n::

    (a, b):  f = m a + b x h      n = h x a + spread(K) b
    dw:      f = dw x P           n = spread(N)^T dw
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from urdf2mbs_equations.dynamics import (
    BodyMotion,
    MassMoments,
    compute_body_motions,
    compute_mass_moments,
    compute_moment,
)
from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import ZERO_VECTOR, Matrix, Spatial, Vector, outer


@dataclass
class JointVariation:
    """The change of motion of a joint's subtree for a unit of its q, its qd, or its qdd."""

    omega_by_q: Vector
    """Change of the angular velocity."""
    omega_by_qd: Vector
    by_q: Spatial
    """Change of the acceleration, without the part of the changed angular velocity."""
    by_qd: Spatial
    by_qdd: Spatial


@dataclass
class CompositeBody:
    """Everything that moves with a joint, about the origin of its frame and in its axes."""

    moments: MassMoments
    momentum: Vector
    """P: twice the sum of dm v (kg m/s)."""
    mixed: Matrix
    """N: twice the sum of dm x v^T, with position x and velocity v (kg m^2/s)."""
    force: Spatial
    """The force that its motion requires."""

    def __add__(self, body: CompositeBody) -> CompositeBody:
        return CompositeBody(
            self.moments + body.moments,
            self.momentum + body.momentum,
            self.mixed + body.mixed,
            self.force + body.force,
        )

    def compute_inertial_force(self, acceleration: Spatial) -> Spatial:
        """Return I a: the force that an acceleration requires."""
        (linear, angular), first = acceleration, self.moments.first
        f = self.moments.mass * linear + angular.cross(first)
        return Spatial((f, first.cross(linear) + _spread(self.moments.second) @ angular))

    def compute_gyroscopic_force(self, omega: Vector) -> Spatial:
        """Return the force that an additional angular velocity requires: 2 dm omega x v."""
        return Spatial((omega.cross(self.momentum), _spread(self.mixed).T @ omega))


@dataclass
class ForceVariation:
    """The change of the force of a joint's subtree, in a frame between the base and the joint."""

    by_q: Spatial
    """For a unit of the joint's q."""
    by_qd: Spatial
    by_qdd: Spatial
    by_omega: Vector
    """Change of the joint's own force for a unit angular velocity of the frame."""

    def list_column_elements(self, ancestor: JointVariation) -> Iterator[tuple[str, Scalar]]:
        """List the derivatives of an ancestor's force by q, qd and qdd of the joint."""
        for variable, force in (("q", self.by_q), ("qd", self.by_qd), ("qdd", self.by_qdd)):
            yield variable, ancestor.by_qdd @ force

    def list_row_elements(self, ancestor: JointVariation) -> Iterator[tuple[str, Scalar]]:
        """List the derivatives of the joint's force by q, qd and qdd of an ancestor."""
        yield "q", ancestor.by_q @ self.by_qdd + ancestor.omega_by_q @ self.by_omega
        yield "qd", ancestor.by_qd @ self.by_qdd + ancestor.omega_by_qd @ self.by_omega
        yield "qdd", ancestor.by_qdd @ self.by_qdd

    def transform_to_parent(self, frame: Frame, drift: Vector) -> ForceVariation:
        """Transform from a frame to its parent; ``drift`` is that of ``_compute_drift``."""
        by_qdd = frame.transform_force_to_parent(self.by_qdd)
        by_omega = frame.rotate_to_parent(self.by_omega) + drift.cross(by_qdd.linear)
        return ForceVariation(
            frame.transform_force_to_parent(self.by_q),
            frame.transform_force_to_parent(self.by_qd),
            by_qdd,
            by_omega,
        )


def compute_derivatives(tree: Tree) -> dict[tuple[str, int, int], Scalar]:
    """Compute the derivatives of the joint forces.

    Returns:
        By ``q``, ``qd`` or ``qdd``, number of the force's joint (row) and number of the variable's
        joint (column); zeros are left out.
    """
    motions = compute_body_motions(tree, range(len(tree.frames)))
    bodies = [
        _make_body(tree, frame, motions[frame.number], moments)
        for frame, moments in zip(tree.frames, compute_mass_moments(tree), strict=True)
    ]
    joints = [_vary_joint(frame, motions[frame.number]) for frame in tree.frames]
    drifts = [_compute_drift(frame, motions[frame.parent].omega) for frame in tree.frames]
    derivatives: dict[tuple[str, int, int], Scalar] = {}
    for frame in reversed(tree.frames[1:]):
        k = frame.number
        force, ancestor = _vary_force(bodies[k], joints[k]), frame
        while ancestor.number:
            i = ancestor.number
            for variable, value in force.list_column_elements(joints[i]):
                derivatives[variable, i, k] = value
            for variable, value in force.list_row_elements(joints[i]):
                derivatives[variable, k, i] = value
            force = force.transform_to_parent(ancestor, drifts[i])
            ancestor = tree.frames[ancestor.parent]
        bodies[frame.parent] += _transform_to_parent(frame, bodies[k], drifts[k])
    return {key: value for key, value in derivatives.items() if value}


def _make_body(tree: Tree, frame: Frame, motion: BodyMotion, moments: MassMoments) -> CompositeBody:
    """Return a single body as a composite body."""
    alpha, beta, first = motion.alpha, motion.beta, moments.first
    f = moments.mass * alpha + beta @ first
    n = first.cross(alpha) + compute_moment(beta, moments.second)
    if frame.body is not None:
        frc, trq = tree.get_external_force(frame)
        f, n = f - frc, n - (trq + tree.get_centre(frame).cross(frc))
    twice = 2.0 * motion.omega
    mixed = Matrix(map(twice.cross, moments.second))
    return CompositeBody(moments, twice.cross(first), mixed, Spatial((f, n)))


def _vary_joint(frame: Frame, motion: BodyMotion) -> JointVariation:
    """Return the change of motion for a unit of q, qd and qdd.

    The derivatives of the motion subspace S, with the joint axis e::

        R:  S = (0, e)      S' = (0, w x e)      S'' = (alpha x e, beta e)
        T:  S = (e, 0)      S' = (w x e, 0)      S'' = (beta e, 0)
    """
    axis = frame.joint_axis
    omega_change = motion.omega.cross(axis)
    coriolis, by_position = 2.0 * omega_change, motion.beta @ axis
    if frame.is_revolute:
        by_q = Spatial((motion.alpha.cross(axis), by_position))
        by_qd = Spatial((ZERO_VECTOR, coriolis))
        return JointVariation(omega_change, axis, by_q, by_qd, frame.motion_subspace)
    by_q, by_qd = Spatial((by_position, ZERO_VECTOR)), Spatial((coriolis, ZERO_VECTOR))
    return JointVariation(ZERO_VECTOR, ZERO_VECTOR, by_q, by_qd, frame.motion_subspace)


def _compute_drift(frame: Frame, parent_omega: Vector) -> Vector:
    """Return twice the velocity of a frame's origin relative to that of its parent."""
    joint_velocity = frame.permute_to_parent(frame.qd * frame.motion_subspace.linear)
    return 2.0 * (parent_omega.cross(frame.offset) + joint_velocity)


def _vary_force(body: CompositeBody, joint: JointVariation) -> ForceVariation:
    """Return the change of the force of a composite body for a unit of its joint's q, qd, qdd.

    A change of q also rotates the force with the subtree.
    """
    (linear, angular), (f, n) = joint.by_qdd, body.force
    rotated_force = Spatial((angular.cross(f), angular.cross(n) + linear.cross(f)))
    of_omega_by_q = body.compute_gyroscopic_force(joint.omega_by_q)
    of_omega_by_qd = body.compute_gyroscopic_force(joint.omega_by_qd)
    return ForceVariation(
        rotated_force + (body.compute_inertial_force(joint.by_q) + of_omega_by_q),
        body.compute_inertial_force(joint.by_qd) + of_omega_by_qd,
        body.compute_inertial_force(joint.by_qdd),
        body.momentum.cross(linear) + _spread(body.mixed) @ angular,
    )


def _transform_to_parent(frame: Frame, body: CompositeBody, drift: Vector) -> CompositeBody:
    """Transform a composite body to the parent frame.

    With R the rotation, p the offset, d the drift, m and h mass and first moment::

        P' = R P + m d          N' = R N R^T + R h d^T + p P'^T
    """
    at_zero = body.moments.rotate_to_zero(frame)
    rows = map(frame.rotate_to_parent, body.mixed)
    mixed = Matrix(map(frame.rotate_to_parent, Matrix(rows).T)).T
    momentum = frame.rotate_to_parent(body.momentum) + body.moments.mass * drift
    mixed += outer(frame.permute_to_parent(at_zero.first), drift)
    mixed += outer(frame.offset, momentum)
    moments = at_zero.shift_to_parent(frame)
    return CompositeBody(moments, momentum, mixed, frame.transform_force_to_parent(body.force))


def _spread(matrix: Matrix) -> Matrix:
    """Return ``trace(A) 1 - A``: the inertia, if A is the second moment of mass."""
    diagonal = Vector(
        (
            matrix[1][1] + matrix[2][2],
            matrix[2][2] + matrix[0][0],
            matrix[0][0] + matrix[1][1],
        )
    )
    return Matrix.from_elements(lambda i, j: diagonal[i] if i == j else -matrix[i][j])
