r"""Mass matrix and bias of a robot, in the coordinates that MuJoCo has.

The equations of motion are ``M(q) qdd + c(q, qd) = tau``, with the bias c of gravity and inertia.
With the Jacobians of each link's centre of mass, all in world axes,

    M = \sum m J_v^T J_v + J_w^T I J_w
    c = \sum m J_v^T (a - g) + J_w^T (I alpha + w x I w)

where a and alpha are the accelerations with ``qdd = 0`` (Featherstone, Rigid Body Dynamics
Algorithms, 2008, section 2.14).  It shares no line with the generator of equations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from urdf2mbs.plugin import Link, Robot, UrdfJoint, Vec

Array = npt.NDArray[np.float64]
_AXES = np.eye(3)


class Motion(NamedTuple):
    """A frame in the world, and how it moves; lengths in m, angles in rad."""

    rotation: Array
    """(3, 3)"""
    position: Array
    """(3,)"""
    angular: Array
    """(3, n): angular velocity for unit velocities, as is ``linear`` of the origin."""
    linear: Array
    spin: Array
    """(3,): angular acceleration without accelerations of the joints, as is ``acceleration``."""
    acceleration: Array


class Dynamics(NamedTuple):
    """Mass matrix (n, n), bias (n,), and the poses of the links."""

    mass_matrix: Array
    bias: Array
    links: dict[str, Motion]


class Coordinates(NamedTuple):
    """The coordinates of a URDF joint: where its velocities begin, and its position.

    A ball has three angles x-y-z (rad), and the angular velocity in the axes of the child; a free
    joint three shifts (m) before, and their velocity in the axes of the world.
    """

    first: int
    values: Sequence[float]


def compute_dynamics(
    robot: Robot,
    coordinates: Mapping[str, Coordinates],
    velocity: Array,
    gravity: Vec,
) -> Dynamics:
    """Compute mass matrix and bias of a robot.

    Args:
        robot: The robot; a ball joint is three hinges of it, ``NAME_R1`` to ``NAME_R3``.
        coordinates: By URDF joint; a ball joint has those of its last hinge, and the others none.
        velocity: (n,), in m/s and rad/s.
        gravity: m/s^2.
    """
    n = len(velocity)
    nothing, still = np.zeros((3, n)), np.zeros(3)
    links = {robot.root(): Motion(np.eye(3), still, nothing, nothing, still, still)}
    for joint in robot.depth_first():
        links[joint.child] = _move(links[joint.parent], joint, coordinates, velocity)
    mass_matrix, bias = np.zeros((n, n)), np.zeros(n)
    for name, link in robot.links.items():
        if link.inertial is not None:
            _add_link(link, links[name], np.array(gravity), velocity, (mass_matrix, bias))
    return Dynamics(mass_matrix, bias, links)


def _move(
    parent: Motion,
    joint: UrdfJoint,
    coordinates: Mapping[str, Coordinates],
    velocity: Array,
) -> Motion:
    """Return the motion of a joint's child link."""
    frame = _shift(parent, np.array(joint.origin.xyz), velocity)
    frame = frame._replace(rotation=frame.rotation @ np.reshape(joint.origin.pose.rot, (3, 3)))
    if joint.name not in coordinates:
        return frame
    first, values = coordinates[joint.name]
    if len(values) == 1:
        axis = np.array(joint.axis)
        axis = frame.rotation @ (axis / np.linalg.norm(axis))
        if joint.type == "prismatic":
            return _slide(frame, axis[:, None], values, first, velocity)
        rotation = rotate_about(axis, values[0]) @ frame.rotation
        return _turn(frame, axis[:, None], rotation, first, velocity)
    *shift, x, y, z = values
    if shift:
        # MuJoCo has this velocity in the world, and the parent of a free joint is the world
        moved = _slide(frame, _AXES, frame.rotation @ np.array(shift), first, velocity)
        frame, first = moved, first + 3
    turns = [rotate_about(axis, angle) for axis, angle in zip(_AXES, (x, y, z), strict=True)]
    rotation = frame.rotation @ turns[0] @ turns[1] @ turns[2]
    return _turn(frame, rotation, rotation, first, velocity)


def _shift(frame: Motion, point: Array, velocity: Array) -> Motion:
    """Return a frame at a point (3,) of a frame, in its axes (m)."""
    arm = frame.rotation @ point
    angular_velocity = frame.angular @ velocity
    return frame._replace(
        position=frame.position + arm,
        linear=frame.linear - _cross(arm) @ frame.angular,
        acceleration=frame.acceleration
        + np.cross(frame.spin, arm)
        + np.cross(angular_velocity, np.cross(angular_velocity, arm)),
    )


def _slide(frame: Motion, axes: Array, values: Any, first: int, velocity: Array) -> Motion:
    """Return a frame that has slid along axes (3, k) of the world, which turn with the parent."""
    arm = axes @ np.array(values)
    moved = _shift(frame, frame.rotation.T @ arm, velocity)
    linear = moved.linear.copy()
    k = axes.shape[1]
    linear[:, first : first + k] += axes
    slip = axes @ velocity[first : first + k]
    coriolis = 2.0 * np.cross(frame.angular @ velocity, slip)
    return moved._replace(linear=linear, acceleration=moved.acceleration + coriolis)


def _turn(frame: Motion, axes: Array, rotation: Array, first: int, velocity: Array) -> Motion:
    """Return a frame that turns about axes (3, k) of the world."""
    angular = frame.angular.copy()
    k = axes.shape[1]
    angular[:, first : first + k] += axes
    turn = axes @ velocity[first : first + k]
    spin = frame.spin + np.cross(frame.angular @ velocity, turn)
    return frame._replace(rotation=rotation, angular=angular, spin=spin)


def _add_link(
    link: Link, motion: Motion, gravity: Array, velocity: Array, sums: tuple[Array, Array]
) -> None:
    """Add the inertia of a link to the mass matrix and the bias."""
    inertial = link.inertial
    assert inertial is not None
    mass_matrix, bias = sums
    centre = _shift(motion, np.array(inertial.origin.xyz), velocity)
    xx, xy, xz, yy, yz, zz = inertial.inertia
    axes = motion.rotation @ np.reshape(inertial.origin.pose.rot, (3, 3))
    inertia = axes @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ axes.T
    mass_matrix += inertial.mass * centre.linear.T @ centre.linear
    mass_matrix += centre.angular.T @ inertia @ centre.angular
    angular_velocity = centre.angular @ velocity
    bias += centre.linear.T @ (inertial.mass * (centre.acceleration - gravity))
    gyroscopic = np.cross(angular_velocity, inertia @ angular_velocity)
    bias += centre.angular.T @ (inertia @ centre.spin + gyroscopic)


def rotate_about(axis: Array, angle: float) -> Array:
    """Return the rotation (3, 3) about a unit vector (3,) by an angle (rad): Rodrigues' formula."""
    cross = _cross(axis)
    rotation: Array = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return rotation


def _cross(vector: Array) -> Array:
    """Return the matrix (3, 3) of a cross product."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
