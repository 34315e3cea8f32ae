"""A robot's rigid groups at a state: where each is, how it moves, and its equations of motion.

Kane's form of Newton and Euler, each group by itself: with the Jacobians of its centre (v) and of
its spin (w), ``M = sum of m v'v + w'I w`` and ``c = sum of m v'(a - g) + w'(I alpha + omega x I
omega)``, where a and alpha are the accelerations at ``qdd = 0``.  The generated equations go
another way, and share no line with this one.  Arrays count joints from 1, as Robotran does.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs.proof.groups import Side
from urdf2mbs.proof.rigid import Frame, merge
from urdf2mbs.spatial import Vec


class Place(NamedTuple):
    """A frame in a group, and how it moves; all in the axes of the base."""

    at: Any
    """m"""
    axes: Any
    """The columns are the axes of the frame."""
    speed: Any
    """m/s"""
    acceleration: Any
    """m/s^2"""
    jacobian: Any
    """(6, n + 1): of the speed, then of the spin."""
    spin: Any
    """rad/s"""
    spin_rate: Any
    """rad/s^2"""


class Motion:
    """The rigid groups of one side at a state; ``moved`` gives another."""

    def __init__(self, side: Side, numbers: Mapping[str, int], size: int) -> None:
        """``numbers``: Robotran's number of the joint that each coordinate is; ``size``: one more
        than there are joints."""
        self.side, self.size = side, size
        self.numbers = [0, *(numbers[group.coordinate] for group in side.groups[1:])]
        self.fixed = [_matrix(group.before) for group in side.groups]
        self.inertias = [merge(group.inertias) for group in side.groups]

    def moved(self, q: Any, qd: Any) -> Motion:
        """At positions and velocities; ``still`` are the accelerations at ``qdd = 0``."""
        out = copy(self)
        out._move(q, qd)
        return out

    def _move(self, q: Any, qd: Any) -> None:
        count = len(self.side.groups)
        self.axes = np.tile(np.eye(3), (count, 1, 1))
        self.origins, self.spins, self.speeds, self.still, self.still_spins = np.zeros(
            (5, count, 3)
        )
        self.jacobians = np.zeros((count, 6, self.size))
        for k, group in enumerate(self.side.groups[1:], start=1):
            before, number = group.parent, self.numbers[k]
            (turn, shift), (own_turn, own_shift) = self.fixed[k], _matrix(group.move(q[number]))
            stands = self.axes[before] @ turn
            axis = stands @ group.axis
            arm = self.axes[before] @ shift + stands @ own_shift
            omega, alpha = self.spins[before], self.still_spins[before]
            jacobian = self.jacobians[k]
            jacobian[:] = self.jacobians[before]
            jacobian[:3] += _lever(arm) @ jacobian[3:]
            jacobian[3 if group.turns else 0 :, number][:3] += axis
            self.axes[k], self.origins[k] = stands @ own_turn, self.origins[before] + arm
            self.spins[k], self.speeds[k] = jacobian[3:] @ qd, jacobian[:3] @ qd
            coriolis = _cross(omega, axis) * qd[number]
            self.still[k] = self.still[before] + _cross(alpha, arm) + _cross(
                omega, _cross(omega, arm)
            ) + (0.0 if group.turns else 2.0) * coriolis  # fmt: skip
            self.still_spins[k] = alpha + (1.0 if group.turns else 0.0) * coriolis

    def place(self, group: int, frame: Frame, qdd: Any) -> Place:
        """A frame of a group."""
        turn, shift = _matrix(frame)
        arm, omega, jacobian = self.axes[group] @ shift, self.spins[group], self.jacobians[group]
        alpha = self.still_spins[group] + jacobian[3:] @ qdd
        acceleration = self.still[group] + jacobian[:3] @ qdd
        jacobian = jacobian.copy()
        jacobian[:3] += _lever(arm) @ jacobian[3:]
        return Place(
            self.origins[group] + arm, self.axes[group] @ turn,
            self.speeds[group] + _cross(omega, arm),
            acceleration + _cross(alpha, arm) + _cross(omega, _cross(omega, arm)),
            jacobian, omega, alpha,
        )  # fmt: skip

    def on(self, name: str | None, at: Vec, qdd: Any) -> Place:
        """A place (m) on a link or body, in the axes of this one."""
        group, (*turn, x, y, z) = self.side.frames[name or ""]
        shift = np.array((x, y, z)) + np.array(turn).reshape(3, 3) @ at
        return self.place(group, (*turn, *shift), qdd)  # type: ignore[arg-type]

    def equations(self, gravity: Vec) -> tuple[Any, Any]:
        """M (kg m^2, kg m, kg) and c (N m, N)."""
        matrix, bias = np.zeros((self.size, self.size)), np.zeros(self.size)
        for k, (mass, centre, (xx, xy, xz, yy, yz, zz)) in enumerate(self.inertias[1:], start=1):
            axes, jacobian, omega = self.axes[k], self.jacobians[k], self.spins[k]
            tensor = axes @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ axes.T
            arm, alpha = axes @ centre, self.still_spins[k]
            turns = jacobian[3:]
            shifts = jacobian[:3] + _lever(arm) @ turns
            pull = self.still[k] + _cross(alpha, arm) + _cross(omega, _cross(omega, arm)) - gravity
            matrix += mass * shifts.T @ shifts + turns.T @ tensor @ turns
            moment = tensor @ alpha + _cross(omega, tensor @ omega)
            bias += mass * (pull @ shifts) + moment @ turns
        return matrix, bias


def _matrix(frame: Frame) -> tuple[Any, Any]:
    return np.array(frame[:9]).reshape(3, 3), np.array(frame[9:])


def _lever(arm: Any) -> Any:
    """The matrix that gives the speed at the end of an arm, of a spin."""
    x, y, z = arm
    return np.array(((0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0)))


def _cross(a: Any, b: Any) -> Any:
    """The vector product: numpy's own takes ten times as long for two vectors."""
    (x, y, z), (u, v, w) = a, b
    return np.array((y * w - z * v, z * u - x * w, x * v - y * u))
