"""Inverse dynamics and the mass matrix, in body frames.

The joint forces come from the recursive Newton-Euler method (Luh, Walker and Paul, 1980), the mass
matrix from composite rigid bodies (Walker and Orin, 1982); both are in Featherstone, Rigid Body
Dynamics Algorithms, 2008, chapters 5 and 6.  As in Robotran (Samin and Fisette, Symbolic Modeling
of Multibody Systems, 2003), a body's angular motion is used as one matrix::

    beta = [dw/dt]x + [w]x [w]x          alpha = a - g

so that a point r of the body accelerates by ``alpha + beta r``, gravity subtracted.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import (
    IDENTITY,
    ZERO_MATRIX,
    ZERO_SPATIAL,
    ZERO_VECTOR,
    Matrix,
    Spatial,
    Vector,
    outer,
)


@dataclass
class BodyMotion:
    """The motion of a frame, in its own axes; the names are Robotran's."""

    omega: Vector
    """Angular velocity (rad/s)."""
    omega_dot: Vector
    alpha: Vector
    """Acceleration of the origin minus gravity (m/s^2)."""
    beta: Matrix
    """``[omega_dot]x + [omega]x [omega]x`` (1/s^2)."""


def compute_joint_forces(tree: Tree, accelerated: Collection[int]) -> list[Scalar]:
    """Compute the joint forces that a motion requires (inverse dynamics).

    From the leaves to the base, with S the motion subspace of joint i (Featherstone, 5.3)::

        f_i = f_body,i + sum of f_k over the children k, transformed to frame i
        Q_i = S_i^T f_i

    Args:
        tree: The model.
        accelerated: Numbers of the joints whose qdd is used; it is 0 for all others.

    Returns:
        The forces (N or Nm) by joint number; index 0 is 0.
    """
    frames = tree.frames
    motions, second_moments = compute_body_motions(tree, accelerated), _shift_second_moments(tree)
    subtree_forces = [ZERO_SPATIAL] * len(frames)
    joint_forces: list[Scalar] = [0] * len(frames)
    for frame in reversed(frames[1:]):
        k = frame.number
        force = _compute_body_force(tree, frame, motions[k], second_moments[k]) + subtree_forces[k]
        joint_forces[k] = frame.project_on_joint(force)
        subtree_forces[frame.parent] += frame.transform_force_to_parent(force)
    return joint_forces


def compute_body_motions(tree: Tree, accelerated: Collection[int]) -> list[BodyMotion]:
    """Compute the motion of each frame, from the base to the leaves.

    With p the offset, e the axis of the joint, and everything rotated to axes of the frame::

        R:  w = w' + qd e     dw/dt = dw'/dt + w' x qd e + qdd e     alpha = alpha' + beta' p
        T:  w = w'            dw/dt = dw'/dt         alpha = alpha' + beta' p + 2 w x qd e + qdd e

    Args:
        tree: The model.
        accelerated: Numbers of the joints whose qdd is used; it is 0 for all others.

    Returns:
        The motions by joint number; index 0 is the base.
    """
    motions = [BodyMotion(ZERO_VECTOR, ZERO_VECTOR, -tree.get_gravity(), ZERO_MATRIX)]
    for frame in tree.frames[1:]:
        parent, axis = motions[frame.parent], frame.joint_axis
        qd, qdd = frame.qd, frame.qdd if frame.number in accelerated else 0
        alpha = parent.alpha + parent.beta @ frame.offset
        omega = frame.rotate_to_child(parent.omega)
        omega_dot = frame.rotate_to_child(parent.omega_dot)
        if frame.is_revolute:
            omega_dot = omega_dot + omega.cross(qd * axis) + qdd * axis
            omega = omega + qd * axis
            alpha = frame.rotate_to_child(alpha)
            beta = _compute_beta(omega, omega_dot)
        else:
            alpha = frame.rotate_to_child(alpha) + (omega.cross(2.0 * qd * axis) + qdd * axis)
            beta = frame.axes_in_parent.permute_matrix(parent.beta)
        motions.append(BodyMotion(omega, omega_dot, alpha, beta))
    return motions


def _compute_beta(omega: Vector, omega_dot: Vector) -> Matrix:
    """Return ``[omega_dot]x + [omega]x [omega]x`` (1/s^2)."""
    xx, yy, zz = (component * component for component in omega)
    xy, xz, yz = omega[0] * omega[1], omega[0] * omega[2], omega[1] * omega[2]
    return Matrix(
        (
            Vector((-(yy + zz), xy - omega_dot[2], xz + omega_dot[1])),
            Vector((xy + omega_dot[2], -(xx + zz), yz - omega_dot[0])),
            Vector((xz - omega_dot[1], yz + omega_dot[0], -(xx + yy))),
        )
    )


def _shift_second_moments(tree: Tree) -> list[Matrix]:
    """Return the second moments of mass about the centres of mass, moved inwards where possible.

    Mass on the axis of a revolute joint does not move with the joint, so the second moment along
    the axis may be part of the parent body; of a prismatic joint, all second moments may.  This
    saves operations where the parent has second moments of its own.

    Returns:
        By joint number, sum of dm x x^T (kg m^2), in axes of the frame.
    """
    frames = tree.frames
    moments = [_compute_second_moment(tree, frame) for frame in frames]
    for frame in reversed(frames[1:]):
        k, axis, parent = frame.number, frame.axis, frame.parent
        if parent and any(moments[parent][i][i] for i in range(3)):
            if frame.is_revolute:
                unit = frame.joint_axis
                moved = outer(unit, unit) * moments[k][axis][axis]
            else:
                moved = moments[k]
            moments[parent] += frame.parent_axes.permute_matrix(moved)
            moments[k] -= moved
    return moments


def _compute_second_moment(tree: Tree, frame: Frame) -> Matrix:
    """Return sum of dm x x^T about the centre of mass: ``trace(I) / 2 - I`` for the inertia I."""
    inertia = tree.get_inertia(frame)
    return 0.5 * inertia.trace * IDENTITY - inertia


def _compute_body_force(
    tree: Tree, frame: Frame, motion: BodyMotion, second_moment: Matrix
) -> Spatial:
    """Return force and moment about the origin that the motion of a body requires.

    With the centre of mass c, the external force frc at c and the external torque trq::

        f = m (alpha + beta c) - frc      n = sum of dm x (beta x) + c x f - trq
    """
    if frame.body is None:
        return ZERO_SPATIAL
    mass, centre = tree.get_mass(frame), tree.get_centre(frame)
    external_force, external_torque = tree.get_external_force(frame)
    f = mass * (motion.alpha + motion.beta @ centre) - external_force
    moment = compute_moment(motion.beta, second_moment)
    return Spatial((f, moment + centre.cross(f) - external_torque))


def compute_moment(beta: Matrix, second_moment: Matrix) -> Vector:
    """Return the sum of ``dm x x (beta x)``, where K is the second moment, sum of dm x x^T.

    With the indices i, j, k cyclic::

        n_i = beta_kj K_jj - beta_jk K_kk + K_jk (beta_kk - beta_jj) + K_ij beta_ki - K_ik beta_ji
    """

    def compute_component(i: int) -> Scalar:
        j, k = (i + 1) % 3, (i + 2) % 3
        return (
            beta[k][j] * second_moment[j][j]
            - beta[j][k] * second_moment[k][k]
            + second_moment[j][k] * (beta[k][k] - beta[j][j])
            + second_moment[i][j] * beta[k][i]
            - second_moment[i][k] * beta[j][i]
        )

    return Vector(map(compute_component, range(3)))


@dataclass
class MassMoments:
    """Mass and moments of bodies about the origin of a frame, in its axes."""

    mass: Scalar
    """Sum of dm (kg)."""
    first: Vector
    """Sum of dm x (kg m)."""
    second: Matrix
    """Sum of dm x x^T (kg m^2)."""

    def __add__(self, moments: MassMoments) -> MassMoments:
        return MassMoments(
            self.mass + moments.mass, self.first + moments.first, self.second + moments.second
        )

    def rotate_to_zero(self, frame: Frame) -> MassMoments:
        """Rotate from the axes of a frame to those that it has at q = 0.

        With s and c the sine and cosine, and i, j, k cyclic with k the axis of the joint::

            u = s (K_ii - K_jj) + 2 c K_ij
            K'_ii = K_ii - s u      K'_jj = K_jj + s u      K'_ij = c u - K_ij
            K'_ik = c K_ik - s K_jk      K'_jk = s K_ik + c K_jk
        """
        s, c, k = frame.sine, frame.cosine, frame.axis
        if not s and c == 1:
            return self
        i, j = (k + 1) % 3, (k + 2) % 3
        K = [list(row) for row in self.second]  # noqa: N806
        (ii, ij), (jj, ik, jk) = (K[i][i], K[i][j]), (K[j][j], K[i][k], K[j][k])
        u = s * (ii - jj) + 2.0 * c * ij
        K[i][i], K[j][j] = ii - s * u, jj + s * u
        K[i][j] = K[j][i] = c * u - ij
        K[i][k] = K[k][i] = c * ik - s * jk
        K[j][k] = K[k][j] = s * ik + c * jk
        return MassMoments(self.mass, frame.rotate_to_zero(self.first), Matrix(map(Vector, K)))

    def shift_to_parent(self, frame: Frame) -> MassMoments:
        """Transform to the parent frame, from axes that the frame has at q = 0.

        With p the offset, h the first moment and b = h + m p / 2::

            h' = h + m p          K' = K + p b^T + b p^T
        """
        p, first = frame.offset, frame.permute_to_parent(self.first)
        half_shift = 0.5 * self.mass * p
        b, twice = first + half_shift, 2.0 * p

        def compute_change(i: int, j: int) -> Scalar:
            if i == j:
                return twice[i] * b[i]
            i, j = (i, j) if j == (i + 1) % 3 else (j, i)
            return p[i] * b[j] + p[j] * b[i]

        second = frame.parent_axes.permute_matrix(self.second)
        second += Matrix.from_elements(compute_change)
        return MassMoments(self.mass, b + half_shift, second)


def compute_mass_moments(tree: Tree) -> list[MassMoments]:
    """Return the mass moments of each body, by joint number."""
    moments = []
    for frame in tree.frames:
        mass, centre = tree.get_mass(frame), tree.get_centre(frame)
        first = mass * centre
        second = _compute_second_moment(tree, frame) + outer(first, centre)
        moments.append(MassMoments(mass, first, second))
    return moments


#: Elements of a mass matrix with row <= column, by joint numbers; zeros are left out.
UpperTriangle = dict[tuple[int, int], Scalar]


def compute_mass_matrix(tree: Tree) -> UpperTriangle:
    """Compute the mass matrix from composite rigid bodies (Featherstone, 6.2).

    The composite body of joint k is everything that moves with it, with inertia I_k.  Column k is
    the force that qdd_k = 1 requires, transformed to each ancestor i::

        F_k = I_k S_k          M_ik = S_i^T F_k
    """
    composite = compute_mass_moments(tree)
    matrix: UpperTriangle = {}
    for frame in reversed(tree.frames[1:]):
        k, axis = frame.number, frame.axis
        moments = composite[k]
        at_zero = moments.rotate_to_zero(frame)
        if frame.is_revolute:
            # The moment about the axis is the same in axes of the frame, with fewer operations.
            n = [-element for element in at_zero.second[axis]]
            n[axis] = moments.second[axis - 2][axis - 2] + moments.second[axis - 1][axis - 1]
            force = Spatial((frame.joint_axis.cross(at_zero.first), Vector(n)))
        else:
            force = Spatial(
                (moments.mass * frame.joint_axis, moments.first.cross(frame.joint_axis))
            )
        matrix[k, k] = frame.project_on_joint(force)
        _fill_column(tree, frame, force, matrix)
        composite[frame.parent] += at_zero.shift_to_parent(frame)
    return {key: value for key, value in matrix.items() if value}


def _fill_column(tree: Tree, frame: Frame, force: Spatial, matrix: UpperTriangle) -> None:
    """Fill a column above the diagonal.

    Args:
        tree: The model.
        frame: The frame of the column's joint.
        force: F_k of ``compute_mass_matrix``, in axes that the frame has at q = 0.
        matrix: Gets the elements.
    """
    column = frame.number
    f, n = frame.permute_to_parent(force.linear), frame.permute_to_parent(force.angular)
    force = Spatial((f, n + frame.offset.cross(f)))
    ancestor = tree.frames[frame.parent]
    while ancestor.number:
        matrix[ancestor.number, column] = ancestor.project_on_joint(force)
        force = ancestor.transform_force_to_parent(force)
        ancestor = tree.frames[ancestor.parent]
