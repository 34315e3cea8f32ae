"""Where a frame or a point is, how it moves, and what each joint adds to that.

All in the axes of one frame, most often the ground's, by recursion from there outwards
(Siciliano and others, Robotics: Modelling, Planning and Control, 2009, chapters 2 and 3).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from urdf2mbs.plugin import Connection
from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import IDENTITY, NONE, Matrix, Vector


@dataclass
class Motion:
    """Of a point fixed to a frame, in the axes of the frame that it is seen from (SI units)."""

    axes: Matrix = IDENTITY
    """The rows are the frame's x, y and z axis: ``axes @ v`` is v in the axes of the frame."""
    position: Vector = NONE
    velocity: Vector = NONE
    omega: Vector = NONE
    acceleration: Vector = NONE
    """Without gravity."""
    omega_dot: Vector = NONE
    linear: dict[int, Vector] = field(default_factory=dict)
    """By joint number, the velocity for a unit rate of the joint."""
    angular: dict[int, Vector] = field(default_factory=dict)

    def shift(self, offset: Vector) -> None:
        """Go on to a point of the frame, given in its axes."""
        arm = offset[0] * self.axes[0] + offset[1] * self.axes[1] + offset[2] * self.axes[2]
        w = self.omega
        self.position += arm
        self.velocity += w.cross(arm)
        self.acceleration += self.omega_dot.cross(arm) + w.cross(w.cross(arm))

    def pass_joint(self, frame: Frame, qdd: Scalar) -> None:
        """Go on to the frame behind a joint at this place."""
        axis = self.axes[frame.axis]
        rate = frame.qd * axis
        across = self.omega.cross(rate)
        if frame.turns:
            self.omega += rate
            self.omega_dot = self.omega_dot + across + qdd * axis
            i, j, c, s = (frame.axis + 1) % 3, (frame.axis + 2) % 3, frame.cos, frame.sin
            axes = list(self.axes)
            x, y = axes[i], axes[j]
            axes[i], axes[j] = c * x + s * y, c * y - s * x
            self.axes = Matrix(axes)
        else:
            self.velocity += rate
            self.acceleration = self.acceleration + 2.0 * across + qdd * axis

    def measured(self, measures: Collection[str]) -> Iterator[tuple[str, str, Scalar]]:
        """Robotran's name of each quantity among the measures, a place in it, and its value."""
        for name, measure, vector in (
            ("P", "Pos", self.position), ("V", "Vit", self.velocity), ("OM", "Om", self.omega),
            ("A", "Acc", self.acceleration), ("OMP", "Omp", self.omega_dot),
        ):  # fmt: skip
            if measure in measures:
                for k, value in enumerate(vector, start=1):
                    yield name, f"[{k}]", value
        if "Rot" in measures:
            for row, axis in enumerate(self.axes, start=1):
                for k, value in enumerate(axis, start=1):
                    yield "R", f"[{row}][{k}]", value


def chain(tree: Tree, number: int, start: int = 0) -> list[Frame]:
    """The joints from one frame out to another."""
    out = []
    while number != start:
        out.append(tree.frames[number])
        number = tree.frames[number].parent
    return out[::-1]


def motion(
    tree: Tree, number: int, at: Vector = NONE, *, start: int = 0, accelerations: bool = True
) -> Motion:
    """The motion of a point ``at`` in the frame behind a joint, seen from the frame ``start`` and
    in its axes, as if this frame stood still; ``accelerations`` False takes all qdd as 0."""
    out = Motion()
    origins: dict[int, Vector] = {}
    for frame in chain(tree, number, start):
        k = frame.number
        out.shift(frame.offset)
        moved = out.angular if frame.turns else out.linear
        moved[k], origins[k] = out.axes[frame.axis], out.position
        out.pass_joint(frame, frame.qdd if accelerations else 0)
    out.shift(at)
    for k, axis in out.angular.items():
        out.linear[k] = axis.cross(out.position - origins[k])
    out.linear = dict(sorted(out.linear.items()))
    return out


#: The number of a body's last joint, and a point in the frame behind this joint (m).
End = tuple[int, Vector]


def ends(tree: Tree, connection: Connection) -> tuple[End, End]:
    """Both ends of a cut or a link."""
    (body1, point1), (body2, point2) = connection.endpoint1, connection.endpoint2
    return (
        (tree.last[body1], tree.point(body1, point1)),
        (tree.last[body2], tree.point(body2, point2)),
    )


def common(tree: Tree, a: int, b: int) -> int:
    """The number of the frame from which the ways to two frames part."""
    inwards = {0}
    while a:
        inwards.add(a)
        a = tree.frames[a].parent
    while b not in inwards:
        b = tree.frames[b].parent
    return b


def relative(tree: Tree, end1: End, end2: End) -> Motion:
    """The motion of the second point as seen from the first body, in the axes of this body."""
    start = common(tree, end1[0], end2[0])
    a = motion(tree, *end1, start=start)
    b = motion(tree, *end2, start=start)
    p, w = b.position - a.position, a.omega
    v = b.velocity - a.velocity - w.cross(p)
    turning = b.omega - w
    rate = b.omega_dot - a.omega_dot - w.cross(turning)
    # b = a + w' x p + w x (w x p) + 2 w x v + what is seen
    seen = b.acceleration - a.acceleration - a.omega_dot.cross(p)
    seen = seen - w.cross(w.cross(p)) - 2.0 * w.cross(v)
    axes = Matrix(a.axes @ axis for axis in b.axes)
    position, velocity, omega, acceleration, omega_dot = (
        a.axes @ x for x in (p, v, turning, seen, rate)
    )
    return Motion(axes, position, velocity, omega, acceleration, omega_dot)
