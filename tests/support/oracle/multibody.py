"""A tree of frames with matter: where it is, how it moves, and its equations of motion.

Kane's form of Newton and Euler, body by body: with the Jacobians of its centre (v) and of its spin
(w), ``M = sum of m v'v + w'I w`` and ``tau = sum of m v'(a - g) + w'(I alpha + omega x I omega)``.
It shares no code with ``urdf2mbs``.  Units are m, kg, rad, s; all is in the axes of the ground.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def translation(xyz: Sequence[float] | Array) -> Array:
    """The 4x4 pose of a frame shifted by xyz (m)."""
    pose = np.eye(4)
    pose[:3, 3] = xyz
    return pose


def rotations(axes: Array, angles: Array) -> Array:
    """Rodrigues' formula: (n, 3, 3) rotations by angles (n,) about unit axes (n, 3)."""
    k = np.zeros((len(angles), 3, 3))
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -axes[:, 2], axes[:, 1], -axes[:, 0]
    k -= k.transpose(0, 2, 1)
    s, c = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + s * k + (1.0 - c) * (k @ k)


def rotation(axis: Sequence[float] | Array, angle: float) -> Array:
    """The 3x3 rotation by an angle about one unit axis."""
    return np.asarray(rotations(np.array([axis], dtype=float), np.array([float(angle)]))[0])


def symmetric(elements: Sequence[float] | Array) -> Array:
    """The matrix (3, 3) of xx, xy, xz, yy, yz, zz."""
    return np.array(elements, dtype=float)[[[0, 1, 2], [1, 3, 4], [2, 4, 5]]]


@dataclass
class Inertia:
    """Mass (kg), centre of mass (3,) and inertia (3, 3) about it, in the axes of a frame."""

    mass: float
    com: Array
    tensor: Array

    def seen_from(self, pose: Array) -> Inertia:
        """The same matter, from the frame in which this one's frame has the 4x4 ``pose``."""
        rot = pose[:3, :3]
        return Inertia(self.mass, pose[:3, 3] + rot @ self.com, rot @ self.tensor @ rot.T)


def lump(parts: Iterable[Inertia]) -> Inertia:
    """All of them as one rigid body (Steiner), about the common centre of mass."""
    parts = list(parts)
    mass = sum(part.mass for part in parts)
    com = np.zeros(3)
    if mass:
        com = np.sum([part.mass * part.com for part in parts], axis=0) / mass
    tensor = np.zeros((3, 3))
    for part in parts:
        d = part.com - com
        tensor += part.tensor + part.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Inertia(mass, com, tensor)


@dataclass
class Node:
    """A frame: a constant pose (4x4) in its parent's, then one elementary motion.

    ``kind`` is R (a turn about ``axis``), T (a shift along it) or empty (none). Matter fixed to
    the frame is in ``matter``.
    """

    name: str
    parent: int
    pose: Array
    kind: str = ""
    axis: Sequence[float] | Array = (1.0, 0.0, 0.0)
    matter: list[Inertia] = field(default_factory=list)


class Multibody:
    """A tree of nodes, each after its parent; node 0 is the ground."""

    def __init__(self, nodes: list[Node], gravity: Sequence[float] | Array) -> None:
        self.nodes = nodes
        self.gravity = np.array(gravity, dtype=float)
        self.index = {node.name: i for i, node in enumerate(nodes) if node.kind}
        self.pose = np.array([node.pose for node in nodes])
        self.axis = np.array([node.axis for node in nodes], dtype=float)
        self.turns = np.array([node.kind == "R" for node in nodes])
        self.parent = [node.parent for node in nodes]
        self.matter = [(i, part) for i, node in enumerate(nodes) for part in node.matter]
        #: (n, n): whether a node moves with a joint.
        self.moves = np.zeros((len(nodes), len(nodes)), dtype=bool)
        for i, node in enumerate(nodes[1:], start=1):
            self.moves[i] = self.moves[node.parent]
            self.moves[i, i] = bool(node.kind)

    def carried_mass(self) -> Array:
        """(n,): the mass that each joint moves (kg)."""
        return sum(
            (part.mass * self.moves[i] for i, part in self.matter), np.zeros(len(self.nodes))
        )


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
    """(6, n): of its speed, then of its spin."""


class State:
    """A multibody system at positions, velocities and accelerations (n,) of its nodes."""

    def __init__(self, system: Multibody, q: Array, qd: Any = None, qdd: Any = None) -> None:
        rest = np.zeros(len(system.nodes))
        self.system, self.q = system, q
        self.qd, self.qdd = rest if qd is None else qd, rest if qdd is None else qdd

    @cached_property
    def frames(self) -> Array:
        """(n, 4, 4): every frame after its own motion."""
        system = self.system
        local = np.zeros((len(self.q), 4, 4))
        local[:] = np.eye(4)
        local[:, :3, :3] = rotations(system.axis, np.where(system.turns, self.q, 0.0))
        local[:, :3, 3] = np.where(system.turns, 0.0, self.q)[:, None] * system.axis
        local = system.pose @ local
        for i in range(1, len(local)):
            local[i] = local[system.parent[i]] @ local[i]
        return local

    @cached_property
    def axes(self) -> Array:
        """(n, 3)"""
        return np.einsum("nij,nj->ni", self.frames[:, :3, :3], self.system.axis)

    @cached_property
    def motion(self) -> tuple[Array, Array, Array, Array]:
        """(n, 3) each: V, A, OM and OMP of every frame."""
        system, frames, axes = self.system, self.frames, self.axes
        v, a, w, dw = np.zeros((4, len(self.q), 3))
        for i in range(1, len(self.q)):
            p = system.parent[i]
            arm, own = frames[i, :3, 3] - frames[p, :3, 3], axes[i] * self.qd[i]
            bend, turn = axes[i] * self.qdd[i], _cross(w[p], own)
            v[i] = v[p] + _cross(w[p], arm)
            a[i] = a[p] + _cross(dw[p], arm) + _cross(w[p], _cross(w[p], arm))
            w[i], dw[i] = w[p], dw[p]
            if system.turns[i]:
                w[i], dw[i] = w[i] + own, dw[i] + bend + turn
            else:
                v[i], a[i] = v[i] + own, a[i] + bend + 2.0 * turn
        return v, a, w, dw

    def place(self, node: int, pose: Array | None = None) -> Place:
        """A frame with a pose (4x4) in a node's."""
        at = self.frames[node] if pose is None else self.frames[node] @ pose
        v, a, w, dw = (rates[node] for rates in self.motion)
        arm = at[:3, 3] - self.frames[node, :3, 3]
        swing = _cross(w, arm)
        turns, moved = self.system.turns[:, None], self.system.moves[node]
        shifts = np.where(turns, np.cross(self.axes, at[:3, 3] - self.frames[:, :3, 3]), self.axes)
        jacobian = np.hstack([shifts, np.where(turns, self.axes, 0.0)]) * moved[:, None]
        speed = a + _cross(dw, arm) + _cross(w, swing)
        return Place(at[:3, 3], v + swing, speed, w, dw, at[:3, :3].T, jacobian.T)

    def equations(self) -> tuple[Array, Array]:
        """M (n, n) and the forces (n,) that this motion needs (kg, kg m, kg m^2; N, N m)."""
        rows, weighted, force = [], [], np.zeros(len(self.q))
        for node, part in self.system.matter:
            at = self.place(node, translation(part.com))
            tensor = at.R.T @ part.tensor @ at.R
            shift, turn = at.J[:3], at.J[3:]
            rows += [shift, turn]
            weighted += [part.mass * shift, tensor @ turn]
            moment = tensor @ at.OMP + _cross(at.OM, tensor @ at.OM)
            force += part.mass * (at.A - self.system.gravity) @ shift + moment @ turn
        empty = np.zeros((0, len(force)))
        matrix = np.vstack([empty, *rows]).T @ np.vstack([empty, *weighted])
        return matrix, force


def opening(kind: str, length: float, one: Place, two: Place) -> tuple[Array, Array, Array]:
    """How far a cut is open (m, rad), its derivatives by the joints, and how it accelerates."""
    away, rows, speed, opens = two.P - one.P, two.J - one.J, two.V - one.V, two.A - one.A
    if kind == "ball":
        return away, rows[:3], opens
    if kind == "rod":
        size = float(np.linalg.norm(away)) or 1.0
        line = away / size
        rate = opens @ line + (speed @ speed - (speed @ line) ** 2) / size
        return np.array([size - length]), (line @ rows[:3])[None], np.array([rate])
    apart = (one.R @ two.R.T - np.eye(3))[np.triu_indices(3, 1)]
    return np.concatenate([away, apart]), rows, np.concatenate([opens, two.OMP - one.OMP])


def _cross(a: Array, b: Array) -> Array:
    """The product of two single vectors; ``np.cross`` takes ten times as long for these."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))
