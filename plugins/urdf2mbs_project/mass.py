"""The mass matrix of a model at one position, and the Jacobians of its points, in numpy.

A twist is that of the point at the base's origin, in the axes of the base, angular velocity first.
The mass matrix follows from composite rigid bodies: ``M[i, j] = S_i . I_j S_j`` where joint i moves
joint j, S_i is the twist of joint i at unit speed, and I_j (6, 6) the inertia of all bodies that
joint j moves (Featherstone, Rigid Body Dynamics Algorithms, 6.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from urdf2mbs.plugin import (
    NO_INERTIA,
    ZERO,
    Body,
    Mbs,
    PlacedJoint,
    Pose,
    Vec,
    add,
    compute_placement,
    cross,
    rotate,
    rotate_inertia,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


class MassModel:
    """The mass matrix of a model with n joints, all of them free (m, kg, rad).

    Attributes:
        mbs: The model.
        placement: Its joints and bodies at the position.
        twists: (n, 6), the twist of each joint at unit speed.
        moves: (n, n), True in ``[i, j]`` if joint i moves joint j, or is joint j.
        composite_inertias: (n, 6, 6), the inertia of all bodies that a joint moves.
        matrix: (n, n), the mass matrix, symmetric.
    """

    def __init__(self, mbs: Mbs, positions: Mapping[str, float] | None = None) -> None:
        """Compute the mass matrix.

        Args:
            mbs: The model.
            positions: Positions of all joints (rad or m); None for their initial positions.
        """
        self.mbs = mbs
        self.placement = compute_placement(mbs, positions)
        joints = self.placement.joints
        n = len(joints)
        twists = [sum(_compute_unit_twist(placed), ()) for placed in joints]
        self.twists: Array = np.array(twists).reshape(n, 6)
        self.moves = np.zeros((n, n), bool)
        for j, placed in enumerate(joints):
            if placed.previous >= 0:
                self.moves[:, j] = self.moves[:, placed.previous]
            self.moves[j, j] = True
        self.composite_inertias: Array = np.zeros((n, 6, 6))
        for body in mbs.bodies:
            last_joint = self.placement.last_joints[body.name]
            inertia = _compute_spatial_inertia(body, self.placement.bodies[body.name])
            self.composite_inertias[last_joint] += inertia
        for j in range(n - 1, -1, -1):
            if joints[j].previous >= 0:
                self.composite_inertias[joints[j].previous] += self.composite_inertias[j]
        momenta = np.einsum("jab,jb->aj", self.composite_inertias, self.twists)
        upper = np.where(self.moves, self.twists @ momenta, 0.0)
        self.matrix: Array = upper + np.triu(upper, 1).T

    def compute_total_inertia(self) -> Array:
        """Compute the inertia (6, 6) of all bodies of the robot, about the base's origin."""
        first_joints = [placed.previous < 0 for placed in self.placement.joints]
        total: Array = self.composite_inertias[first_joints].sum(axis=0)
        return total

    def compute_point_jacobian(self, body: str | None, position: Vec) -> Array:
        """Compute the Jacobian of a point's velocity.

        Args:
            body: The body that has the point; None for the base.
            position: The point (m, in the base).

        Returns:
            (3, n), the velocity (m/s, in the base) at unit speed of each joint.
        """
        last_joint = self.placement.last_joints[body]
        if last_joint < 0:
            return np.zeros((3, len(self.twists)))
        angular, linear = self.twists[:, :3], self.twists[:, 3:]
        velocities = (linear + np.cross(angular, np.array(position))).T
        return np.where(self.moves[:, last_joint], velocities, 0.0)

    def compute_rotation_jacobian(self, body: str | None) -> Array:
        """Compute the Jacobian of a body's angular velocity.

        Returns:
            (3, n), the angular velocity (rad/s, in the base) at unit speed of each joint.
        """
        last_joint = self.placement.last_joints[body]
        if last_joint < 0:
            return np.zeros((3, len(self.twists)))
        return np.where(self.moves[:, last_joint], self.twists[:, :3].T, 0.0)


def _compute_unit_twist(placed: PlacedJoint) -> tuple[Vec, Vec]:
    """Return the twist of a joint at unit speed: angular, then linear velocity."""
    if placed.joint.type[0] == "R":
        return placed.axis, cross(placed.origin, placed.axis)
    return ZERO, placed.axis


def _compute_spatial_inertia(body: Body, pose: Pose) -> Array:
    """Compute the inertia (6, 6) of a body about the base's origin (Featherstone, chapter 2).

    With c the centre of mass and [c] the matrix of the product ``c x``, it is
    ``[[I - m [c] [c], m [c]], [-m [c], m 1]]``.
    """
    mass = body.mass or 0.0
    x, y, z = add(pose.xyz, rotate(pose.rot, body.com or ZERO))
    cross_matrix = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    xx, xy, xz, yy, yz, zz = rotate_inertia(pose.rot, body.inertia or NO_INERTIA)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return np.block(
        [
            [inertia - mass * cross_matrix @ cross_matrix, mass * cross_matrix],
            [-mass * cross_matrix, mass * np.eye(3)],
        ]
    )
