"""Position, velocity, acceleration and Jacobian of a frame or an anchor point.

All vectors are in the axes of one frame, usually the base, and are computed by recursion from
there outwards (Siciliano and others, Robotics: Modelling, Planning and Control, 2009, chapters 2
and 3).  From a point to a point of the same body, with arm r::

    v' = v + w x r        a' = a + dw/dt x r + w x (w x r)

and from a frame to the frame of the next joint, with unit axis e::

    R:  w' = w + qd e     dw'/dt = dw/dt + w x qd e + qdd e
    T:  v' = v + qd e     a' = a + 2 w x qd e + qdd e
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from urdf2mbs.plugin import Connection
from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import IDENTITY, ZERO_VECTOR, Matrix, Vector


@dataclass
class Motion:
    """The motion of a point of a body, in axes of a reference frame (SI units)."""

    axes: Matrix = IDENTITY
    """The rows are the axes of the body: ``axes @ v`` transforms v into body axes."""
    position: Vector = ZERO_VECTOR
    velocity: Vector = ZERO_VECTOR
    omega: Vector = ZERO_VECTOR
    """Angular velocity (rad/s)."""
    acceleration: Vector = ZERO_VECTOR
    """Without gravity."""
    omega_dot: Vector = ZERO_VECTOR
    linear: dict[int, Vector] = field(default_factory=dict)
    """Linear Jacobian: by joint number, the velocity of the point for qd = 1."""
    angular: dict[int, Vector] = field(default_factory=dict)
    """Angular Jacobian: by joint number, the angular velocity for qd = 1."""

    def shift(self, offset: Vector) -> None:
        """Go on to a point of the body, given by its offset in body axes (m)."""
        arm = offset[0] * self.axes[0] + offset[1] * self.axes[1] + offset[2] * self.axes[2]
        w = self.omega
        self.position += arm
        self.velocity += w.cross(arm)
        self.acceleration += self.omega_dot.cross(arm) + w.cross(w.cross(arm))

    def pass_joint(self, frame: Frame, qdd: Scalar) -> None:
        """Go on to the frame of a joint whose origin is this point."""
        axis = self.axes[frame.axis]
        joint_velocity = frame.qd * axis
        coriolis = self.omega.cross(joint_velocity)
        if frame.is_revolute:
            self.omega += joint_velocity
            self.omega_dot = self.omega_dot + coriolis + qdd * axis
            self._rotate_axes(frame)
        else:
            self.velocity += joint_velocity
            self.acceleration = self.acceleration + 2.0 * coriolis + qdd * axis

    def _rotate_axes(self, frame: Frame) -> None:
        i, j = (frame.axis + 1) % 3, (frame.axis + 2) % 3
        c, s = frame.cosine, frame.sine
        axes = list(self.axes)
        axes[i], axes[j] = c * axes[i] + s * axes[j], c * axes[j] - s * axes[i]
        self.axes = Matrix(axes)

    def list_signals(self, measures: Collection[str]) -> Iterator[tuple[str, str, Scalar]]:
        """List the elements of the measured quantities.

        Args:
            measures: Signals as an .mbs names them: ``Pos``, ``Rot``, ``Vit``, ...

        Yields:
            Robotran's array, the indices of an element as text (``[1][2]``), and its value.
        """
        vectors = {
            "Pos": ("P", self.position),
            "Vit": ("V", self.velocity),
            "Om": ("OM", self.omega),
            "Acc": ("A", self.acceleration),
            "Omp": ("OMP", self.omega_dot),
        }
        for measure, (array, vector) in vectors.items():
            if measure in measures:
                for k, value in enumerate(vector, start=1):
                    yield array, f"[{k}]", value
        if "Rot" in measures:
            for row, axis in enumerate(self.axes, start=1):
                for k, value in enumerate(axis, start=1):
                    yield "R", f"[{row}][{k}]", value


class AnchorPoint(NamedTuple):
    """An anchor point of a cut, a link or a force: an end of a chain of joints."""

    joint: int
    """The number of the last joint of the point's body; 0 is the base."""
    position: Vector
    """In the frame of the body (m)."""


def list_chain(tree: Tree, number: int, start: int = 0) -> list[Frame]:
    """Return the joints from a frame (excluded) outwards to another frame."""
    frames = []
    while number != start:
        frames.append(tree.frames[number])
        number = tree.frames[number].parent
    return frames[::-1]


def compute_motion(
    tree: Tree, point: AnchorPoint, *, start: int = 0, accelerations: bool = True
) -> Motion:
    """Compute the motion of a point relative to the frame ``start``, in axes of this frame.

    Args:
        tree: The model.
        point: The point.
        start: The number of the reference frame, which is treated as at rest.
        accelerations: False to set all qdd to zero.

    Returns:
        The motion, with Jacobians for the joints from ``start`` to the point.
    """
    motion = Motion()
    origins: dict[int, Vector] = {}
    for frame in list_chain(tree, point.joint, start):
        motion.shift(frame.offset)
        jacobian = motion.angular if frame.is_revolute else motion.linear
        jacobian[frame.number] = motion.axes[frame.axis]
        origins[frame.number] = motion.position
        motion.pass_joint(frame, frame.qdd if accelerations else 0)
    motion.shift(point.position)
    for number, axis in motion.angular.items():
        motion.linear[number] = axis.cross(motion.position - origins[number])
    motion.linear = dict(sorted(motion.linear.items()))
    return motion


def find_ends(tree: Tree, connection: Connection) -> tuple[AnchorPoint, AnchorPoint]:
    """Return both ends of a cut or a link."""
    (body1, point1), (body2, point2) = connection.endpoint1, connection.endpoint2
    return (
        AnchorPoint(tree.last_joint[body1], tree.get_point(body1, point1)),
        AnchorPoint(tree.last_joint[body2], tree.get_point(body2, point2)),
    )


def find_common_ancestor(tree: Tree, first: int, second: int) -> int:
    """Return the number of the last frame that is on the chains from the base to two frames."""
    ancestors = {0}
    while first:
        ancestors.add(first)
        first = tree.frames[first].parent
    while second not in ancestors:
        second = tree.frames[second].parent
    return second


def compute_relative_motion(tree: Tree, end1: AnchorPoint, end2: AnchorPoint) -> Motion:
    """Compute the motion of the second point relative to the first body, in axes of this body.

    With p, v, a from the first point to the second, and w and dw/dt of the first body::

        v_rel = v - w x p        a_rel = a - dw/dt x p - w x (w x p) - 2 w x v_rel
    """
    start = find_common_ancestor(tree, end1.joint, end2.joint)
    first = compute_motion(tree, end1, start=start)
    second = compute_motion(tree, end2, start=start)
    p, w = second.position - first.position, first.omega
    v_rel = second.velocity - first.velocity - w.cross(p)
    w_rel = second.omega - w
    dw_rel = second.omega_dot - first.omega_dot - w.cross(w_rel)
    a_rel = second.acceleration - first.acceleration - first.omega_dot.cross(p)
    a_rel = a_rel - w.cross(w.cross(p)) - 2.0 * w.cross(v_rel)
    return Motion(
        axes=Matrix(first.axes @ axis for axis in second.axes),
        position=first.axes @ p,
        velocity=first.axes @ v_rel,
        omega=first.axes @ w_rel,
        acceleration=first.axes @ a_rel,
        omega_dot=first.axes @ dw_rel,
    )
