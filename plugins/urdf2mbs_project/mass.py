"""The mass matrix of a model at one position, and how its points move, in numpy.

Twists are those of the point at the base's origin, in the base's axes: angular velocity first.
The mass matrix is that of composite rigid bodies: ``M[i, j] = S_i . I_j S_j`` for a joint j that
the joint i moves, where S is a joint's twist, and I_j the inertia (6, 6) of all that j moves
(Featherstone, Rigid Body Dynamics Algorithms, 6.2).
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
    Pose,
    Vec,
    add,
    cross,
    rotate,
    rotate_inertia,
)
from urdf2mbs.plugin import PlacedJoint as Placed
from urdf2mbs.plugin import compute_placement as place

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


class Mass:
    """The mass matrix of a model with n joints, all of them free; m, kg, rad."""

    def __init__(self, mbs: Mbs, values: Mapping[str, float] | None = None) -> None:
        """``values``: where the joints are (rad or m), if not at their initial positions."""
        self.mbs = mbs
        self.placement = place(mbs, values)
        joints = self.placement.joints
        n = len(joints)
        self.twists: Array = np.array([sum(_twist(placed), ()) for placed in joints]).reshape(n, 6)
        """The twist of each joint at speed 1, (n, 6)."""
        self.moves = np.zeros((n, n), bool)
        """``moves[i, j]``: joint i moves joint j, or is joint j."""
        for j, placed in enumerate(joints):
            if placed.previous >= 0:
                self.moves[:, j] = self.moves[:, placed.previous]
            self.moves[j, j] = True
        self.behind: Array = np.zeros((n, 6, 6))
        """The inertia of all that a joint moves."""
        for body in mbs.bodies:
            self.behind[self.placement.last_joints[body.name]] += _inertia(
                body, self.placement.bodies[body.name]
            )
        for j in range(n - 1, -1, -1):
            if joints[j].previous >= 0:
                self.behind[joints[j].previous] += self.behind[j]
        momenta = np.einsum("jab,jb->aj", self.behind, self.twists)
        upper = np.where(self.moves, self.twists @ momenta, 0.0)
        self.matrix: Array = upper + np.triu(upper, 1).T
        """(n, n), symmetric."""

    def point(self, body: str | None, at: Vec) -> Array:
        """(3, n): the velocity of a point of a body, which is ``at`` (m) in the base, by the
        velocities of the joints."""
        last = self.placement.last_joints[body]
        if last < 0:
            return np.zeros((3, len(self.twists)))
        turns, shifts = self.twists[:, :3], self.twists[:, 3:]
        return np.where(self.moves[:, last], (shifts + np.cross(turns, np.array(at))).T, 0.0)

    def turn(self, body: str | None) -> Array:
        """(3, n): the angular velocity of a body by the velocities of the joints."""
        last = self.placement.last_joints[body]
        if last < 0:
            return np.zeros((3, len(self.twists)))
        return np.where(self.moves[:, last], self.twists[:, :3].T, 0.0)


def _twist(placed: Placed) -> tuple[Vec, Vec]:
    """At speed 1: the angular velocity, and the velocity of the point at the base's origin."""
    if placed.joint.type[0] == "R":
        return placed.axis, cross(placed.origin, placed.axis)
    return ZERO, placed.axis


def _inertia(body: Body, pose: Pose) -> Array:
    """About the base's origin, (6, 6)."""
    mass = body.mass or 0.0
    x, y, z = add(pose.xyz, rotate(pose.rot, body.com or ZERO))
    arm = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    xx, xy, xz, yy, yz, zz = rotate_inertia(pose.rot, body.inertia or NO_INERTIA)
    own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return np.block([[own - mass * arm @ arm, mass * arm], [-mass * arm, mass * np.eye(3)]])
