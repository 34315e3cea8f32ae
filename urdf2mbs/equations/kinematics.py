"""Where a frame or a point is, how it moves, and what each joint adds to that.

All in the axes of one frame, most often the ground's, by recursion from there outwards
(Siciliano and others, Robotics: Modelling, Planning and Control, 2009, chapters 2 and 3).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.tree import NONE, Frame, Tree, Vector
from urdf2mbs.mbs.model import Connection


@dataclass
class Motion:
    """Of a point fixed to a frame, in the axes of the frame that it is seen from (SI units)."""

    axes: tuple[Vector, Vector, Vector]
    """The frame's x, y and z axis: the columns of the rotation from the frame."""
    position: Vector
    velocity: Vector
    spin: Vector
    acceleration: Vector
    """Without gravity."""
    spin_rate: Vector
    linear: dict[int, Vector] = field(default_factory=dict)
    """By joint number, the velocity for a unit rate of the joint."""
    angular: dict[int, Vector] = field(default_factory=dict)

    def measured(self, measures: Collection[str]) -> Iterator[tuple[str, str, Expr]]:
        """Robotran's name of each quantity among the measures, a place in it, and its value."""
        for name, measure, vector in (
            ("P", "Pos", self.position), ("V", "Vit", self.velocity), ("OM", "Om", self.spin),
            ("A", "Acc", self.acceleration), ("OMP", "Omp", self.spin_rate),
        ):  # fmt: skip
            if measure in measures:
                for k, value in enumerate(vector, start=1):
                    yield name, f"[{k}]", value
        if "Rot" in measures:
            for row, axis in enumerate(self.axes, start=1):
                for k, value in enumerate(axis, start=1):
                    yield "R", f"[{row}][{k}]", value


UNIT: tuple[Vector, Vector, Vector] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


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
    graph = tree.graph
    axes = UNIT
    position = velocity = spin = acceleration = spin_rate = NONE
    turning: list[tuple[int, Vector, Vector]] = []
    linear: dict[int, Vector] = {}
    angular: dict[int, Vector] = {}

    def shift(offset: Vector) -> None:
        nonlocal position, velocity, acceleration
        arm = combine(tree, axes, offset)
        position = tree.plus(position, arm)
        velocity = tree.plus(velocity, tree.cross(spin, arm))
        turning = tree.cross(spin, tree.cross(spin, arm))
        acceleration = tree.plus(acceleration, tree.plus(tree.cross(spin_rate, arm), turning))

    for frame in chain(tree, number, start):
        k, axis = frame.number, frame.axis
        shift(frame.offset)
        own = axes[axis]
        rate = tree.times(frame.qd, own)
        qdd = tree.times(frame.qdd, own) if accelerations else NONE
        across = tree.cross(spin, rate)
        if frame.turns:
            turning.append((k, own, position))
            angular[k] = own
            spin = tree.plus(spin, rate)
            spin_rate = tree.plus(tree.plus(spin_rate, across), qdd)
            i, j = (axis + 1) % 3, (axis + 2) % 3
            c, s = frame.cos, frame.sin
            turned = list(axes)
            turned[i] = tree.plus(tree.times(c, axes[i]), tree.times(s, axes[j]))
            turned[j] = tree.minus(tree.times(c, axes[j]), tree.times(s, axes[i]))
            axes = (turned[0], turned[1], turned[2])
        else:
            linear[k] = own
            velocity = tree.plus(velocity, rate)
            twice = tree.times(graph.constant(2.0), across)
            acceleration = tree.plus(tree.plus(acceleration, twice), qdd)
    shift(at)
    for k, own, origin in turning:
        linear[k] = tree.cross(own, tree.minus(position, origin))
    return Motion(
        axes, position, velocity, spin, acceleration, spin_rate,
        dict(sorted(linear.items())), dict(sorted(angular.items())),
    )  # fmt: skip


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
    p = tree.minus(b.position, a.position)
    across = tree.cross(a.spin, p)
    v = tree.minus(tree.minus(b.velocity, a.velocity), across)
    w = tree.minus(b.spin, a.spin)
    rate = tree.minus(b.spin_rate, a.spin_rate)
    rate = tree.minus(rate, tree.cross(a.spin, w))
    # b = a + w' x p + w x (w x p) + 2 w x v + what is seen
    seen = tree.minus(b.acceleration, a.acceleration)
    seen = tree.minus(seen, tree.cross(a.spin_rate, p))
    seen = tree.minus(seen, tree.cross(a.spin, across))
    seen = tree.minus(seen, tree.times(tree.graph.constant(2.0), tree.cross(a.spin, v)))
    x, y, z = (into(tree, a.axes, axis) for axis in b.axes)
    return Motion(
        (x, y, z), into(tree, a.axes, p), into(tree, a.axes, v), into(tree, a.axes, w),
        into(tree, a.axes, seen), into(tree, a.axes, rate),
    )  # fmt: skip


def combine(tree: Tree, axes: tuple[Vector, Vector, Vector], v: Vector) -> Vector:
    """A vector given in a frame, in the axes that the frame's own are given in."""
    parts = [tree.times(x, axis) for x, axis in zip(v, axes, strict=True)]
    return tree.plus(tree.plus(parts[0], parts[1]), parts[2])


def into(tree: Tree, axes: tuple[Vector, Vector, Vector], v: Vector) -> Vector:
    """The other way: a vector in the axes of a frame."""
    return tree.dot(axes[0], v), tree.dot(axes[1], v), tree.dot(axes[2], v)
