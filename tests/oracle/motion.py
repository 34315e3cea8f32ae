"""A robot's rigid groups at a state: where each is, how it moves, and its equations of motion.

Kane's form of Newton and Euler, each group by itself: with the Jacobians of its centre (v) and of
its spin (w), ``M = sum of m v'v + w'I w`` and ``c = sum of m v'(a - g) + w'(I alpha + omega x I
omega)``, where a and alpha are the accelerations at ``qdd = 0``.  Joints count from 1, as
Robotran's do; all is in the axes of the base (m, kg, s, rad).
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs.mbs.model import Connection, Mbs
from urdf2mbs.proof.groups import Side
from urdf2mbs.proof.rigid import HERE, Frame, merge
from urdf2mbs.spatial import ZERO, Vec


class Place(NamedTuple):
    """A frame that moves, by Robotran's names."""

    P: Any
    V: Any
    A: Any
    OM: Any
    OMP: Any
    R: Any
    """The rows are the axes of the frame."""
    J: Any
    """(6, n + 1): of its speed, then of its spin."""


class Motion:
    """The rigid groups of one side at a state; ``moved`` gives another."""

    def __init__(self, side: Side, numbers: Mapping[str, int], size: int) -> None:
        """``numbers``: Robotran's number of the joint that each coordinate is; ``size``: one more
        than there are joints."""
        self.side, self.size = side, size
        self.numbers = [0, *(numbers[group.coordinate] for group in side.groups[1:])]
        self.inertias = [merge(group.inertias) for group in side.groups]
        self.places: list[Place] = []

    def moved(self, q: Any, qd: Any) -> Motion:
        """At positions and velocities; accelerations are those at ``qdd = 0``."""
        out, still = copy(self), np.zeros(3)
        out.places = [Place(still, still, still, still, still, np.eye(3), np.zeros((6, self.size)))]
        for number, group in zip(self.numbers[1:], self.side.groups[1:], strict=True):
            before = out._ahead(out.places[group.parent], group.before)
            after = out._ahead(before, group.move(q[number]))
            axis = before.R.T @ group.axis
            along, spin = (0.0, 1.0) if group.turns else (1.0, 0.0)
            after.J[:3, number] += along * axis
            after.J[3:, number] += spin * axis
            rate = _cross(before.OM, axis) * qd[number]
            out.places.append(
                after._replace(
                    V=after.V + along * axis * qd[number], A=after.A + 2.0 * along * rate,
                    OM=after.OM + spin * axis * qd[number], OMP=after.OMP + spin * rate,
                )
            )  # fmt: skip
        return out

    def _ahead(self, at: Place, frame: Frame) -> Place:
        """A frame that is seen from another, and fixed to it."""
        if frame is HERE:
            return at._replace(J=at.J.copy())
        x, y, z = arm = at.R.T @ frame[9:]
        jacobian = at.J.copy()
        jacobian[:3] += np.array(((0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0))) @ at.J[3:]
        turning = _cross(at.OM, arm)
        pull = at.A + _cross(at.OMP, arm) + _cross(at.OM, turning)
        turn = np.reshape(frame[:9], (3, 3)).T @ at.R
        return Place(at.P + arm, at.V + turning, pull, at.OM, at.OMP, turn, jacobian)

    def on(self, name: str | None, at: Vec, qdd: Any = None) -> Place:
        """A place (m) on a link or body, in the axes of this one."""
        group, frame = self.side.frames[name or ""]
        return self.fixed(group, frame, at, qdd)

    def fixed(self, group: int, frame: Frame, at: Vec, qdd: Any = None) -> Place:
        """A place (m) in a frame of a group."""
        out = self._ahead(self._ahead(self.places[group], frame), (*HERE[:9], *at))
        if qdd is None:
            return out
        return out._replace(A=out.A + out.J[:3] @ qdd, OMP=out.OMP + out.J[3:] @ qdd)

    def end(self, mbs: Mbs, end: tuple[str | None, str | None], qdd: Any = None) -> Place:
        """A point of a body of the .mbs, by their names; no point: the body's own frame."""
        return self.on(end[0], mbs.points()[end].coordinates if end[1] else ZERO, qdd)

    def opening(self, mbs: Mbs, cut: Connection, qdd: Any = None) -> tuple[Any, Any, Any]:
        """How far a cut is open (m, rad), its derivatives by the joints, and how it accelerates."""
        one, two = (self.end(mbs, end, qdd) for end in (cut.endpoint1, cut.endpoint2))
        away, rows, speed, opens = two.P - one.P, two.J - one.J, two.V - one.V, two.A - one.A
        if cut.kind == "ball":
            return away, rows[:3], opens
        if cut.kind == "rod":
            length = float(np.linalg.norm(away)) or 1.0
            line = away / length
            rate = opens @ line + (speed @ speed - (speed @ line) ** 2) / length
            gap = np.array([length - (cut.length or 0.0)])
            return gap, (line @ rows[:3])[None], np.array([rate])
        apart = (one.R @ two.R.T - np.eye(3))[np.triu_indices(3, 1)]
        return np.concatenate([away, apart]), rows, np.concatenate([opens, two.OMP - one.OMP])

    def equations(self, gravity: Vec) -> tuple[Any, Any]:
        """M (kg m^2, kg m, kg) and c (N m, N)."""
        matrix, bias = np.zeros((self.size, self.size)), np.zeros(self.size)
        for group, (mass, centre, (xx, xy, xz, yy, yz, zz)) in enumerate(self.inertias[1:], 1):
            at = self.fixed(group, HERE, centre)
            tensor = at.R.T @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ at.R
            matrix += mass * at.J[:3].T @ at.J[:3] + at.J[3:].T @ tensor @ at.J[3:]
            moment = tensor @ at.OMP + _cross(at.OM, tensor @ at.OM)
            bias += mass * ((at.A - gravity) @ at.J[:3]) + moment @ at.J[3:]
        return matrix, bias


def _cross(a: Any, b: Any) -> Any:
    """The vector product: numpy's own takes ten times as long for two vectors."""
    (x, y, z), (u, v, w) = a, b
    return np.array((y * w - z * v, z * u - x * w, x * v - y * u))
