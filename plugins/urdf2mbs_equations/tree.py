"""The tree of joints that a model is, as expressions: where each joint stands, what it carries.

Each joint has a frame behind it.  Masses, centres, inertias and points are symbols that are
read from the data, as Robotran's own equations do, wherever they are more than a rounding of
zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from urdf2mbs.plugin import Body, Mbs
from urdf2mbs.plugin import MbsJoint as Joint
from urdf2mbs_equations.graph import Expr, Graph, Scalar, cosine, sine
from urdf2mbs_equations.vectors import NONE, OWN, UNITS, Axes, Matrix, Spatial, Vector


@dataclass
class Frame:
    """A joint and the frame behind it."""

    number: int
    """The joint's, 1, 2, ... as Robotran counts."""
    joint: Joint
    parent: int
    """The number of the joint before; 0 is the ground."""
    axis: int
    """0, 1 or 2, in the frame's own axes."""
    turns: bool
    q: Scalar
    """The position (rad, m), its rate and its acceleration."""
    qd: Scalar
    qdd: Scalar
    labels: Axes
    """The frame's axes, of those of the file."""
    change: Axes
    """The frame's axes, of those of the frame before, where the joint is at zero."""
    offset: Vector
    """Where the frame is in the frame before (m): a point, and a shift by q."""
    body: Body | None = None
    """The body whose frame this is."""

    def __post_init__(self) -> None:
        self.sin: Scalar = sine(self.q) if self.turns else 0
        self.cos: Scalar = cosine(self.q) if self.turns else 1
        self.back = self.change.inverse
        if not self.turns:
            self.offset += self.to_parent_axes(self.unit * self.q)

    @property
    def unit(self) -> Vector:
        """Along the axis."""
        return UNITS[self.axis]

    @property
    def motion(self) -> Spatial:
        """Of the frame for a unit rate of the joint."""
        return Spatial((NONE, self.unit) if self.turns else (self.unit, NONE))

    @property
    def moves(self) -> bool:
        """False if the position of the joint is a number of the equations."""
        return isinstance(self.q, Expr)

    def along(self, force: Spatial) -> Scalar:
        """The part of a force and its moment that the joint feels."""
        return (force.angular if self.turns else force.linear)[self.axis]

    def to_child_axes(self, v: Vector) -> Vector:
        """A vector in the axes of the frame before, in those behind the joint if this is at
        zero."""
        return v if self.change is OWN else self.change.of(v)

    def to_parent_axes(self, v: Vector) -> Vector:
        """A vector in the axes behind the joint if this is at zero, in those of the frame
        before."""
        return v if self.change is OWN else self.back.of(v)

    def to_child(self, v: Vector) -> Vector:
        """A vector in the axes of the frame before, in those of this frame."""
        v = self.to_child_axes(v)
        return v.turned(self.axis, self.cos, -self.sin) if self.turns else v

    def to_parent(self, v: Vector) -> Vector:
        """A vector in the axes of this frame, in those of the frame before."""
        return self.to_parent_axes(self.turned(v))

    def turned(self, v: Vector) -> Vector:
        """A vector in the axes of this frame, in those that it has if the joint is at zero."""
        return v.turned(self.axis, self.cos, self.sin) if self.turns else v

    def inward(self, force: Spatial) -> Spatial:
        """A force and its moment about the origin of this frame, about the origin of the frame
        before."""
        f, n = self.to_parent(force.linear), self.to_parent(force.angular)
        return Spatial((f, n + self.offset.cross(f)))


class Tree:
    """All frames of a model, ``frames[0]`` being the ground's, in one graph."""

    def __init__(
        self,
        mbs: Mbs,
        *,
        fold: bool = False,
        still: bool = False,
        labels: Mapping[int, Axes] | None = None,
    ) -> None:
        """``fold`` makes numbers of the model's data; ``still`` makes numbers of all, at the start
        position."""
        self.mbs = mbs
        self.graph = Graph()
        self.fold, self.still = fold or still, still
        self.last: dict[str | None, int] = {None: 0}
        """The number of each body's last joint."""
        points = mbs.points()
        self.points = {place: number for number, place in enumerate(points, start=1)}
        """The number of each point, as Robotran counts: in the order of the file, base first."""
        self.coordinates = {place: clean(point.coordinates) for place, point in points.items()}
        self.frames = [Frame(0, Joint("", "T1"), 0, 0, False, 0, 0, 0, OWN, OWN, NONE)]
        for body in mbs.bodies:
            parent, offset = self.last[body.parent], self.point(body.parent, body.point)
            for joint in body.joints:
                number, turns = len(self.frames), joint.type[0] == "R"
                own = (labels or {}).get(number, OWN)
                change = own.after(self.frames[parent].labels.inverse)
                axis = [i for i, _ in own].index(int(joint.type[1]) - 1)
                self.frames.append(
                    Frame(number, joint, parent, axis, turns, *self._motion(joint, number),
                          own, change, offset)
                )  # fmt: skip
                parent, offset = number, NONE
            self.last[body.name] = parent
            self.frames[parent].body = body

    def _motion(self, joint: Joint, number: int) -> tuple[Scalar, Scalar, Scalar]:
        if self.still or is_fixed(joint):
            return joint.q or 0.0, 0, 0
        kept = ("q", "qd", "qdd") if joint.symbols is None else joint.symbols
        symbol = self.graph.symbol
        q, qd, qdd = (
            symbol(f"{name}[{number}]") if name in kept else 0 for name in ("q", "qd", "qdd")
        )
        return q, qd, qdd

    def parameter(self, value: float | None, name: str) -> Scalar:
        """A number of the file: a symbol if it is not zero, or with ``fold`` the number."""
        return self.graph.symbol(name) if value and not self.fold else value or 0

    def point(self, body: str | None, point: str | None) -> Vector:
        """The coordinates of a point in its body's frame (m)."""
        if point is None:
            return NONE
        number = self.points[body, point]
        at = Vector(
            self.parameter(value, f"dpt[{k}][{number}]")
            for k, value in enumerate(self.coordinates[body, point], start=1)
        )
        return self.frames[self.last[body]].labels.of(at)

    def gravity(self) -> Vector:
        """In the axes of the base (m/s^2): three symbols, as it may change its direction."""
        values = enumerate(self.mbs.base.gravity, start=1)
        return Vector(value if self.fold else self.graph.symbol(f"g[{k}]") for k, value in values)

    def mass(self, frame: Frame) -> Scalar:
        """Of the frame's body (kg)."""
        body = frame.body
        return 0 if body is None else self.parameter(body.mass, f"m[{frame.number}]")

    def centre(self, frame: Frame) -> Vector:
        """The centre of mass in the frame (m)."""
        if frame.body is None or frame.body.com is None:
            return NONE
        values = enumerate(clean(frame.body.com), start=1)
        return frame.labels.of(
            Vector(self.parameter(value, f"l[{k}][{frame.number}]") for k, value in values)
        )

    def inertia(self, frame: Frame) -> Matrix:
        """About the centre of mass, in the frame's axes (kg m^2)."""
        given = frame.body and frame.body.inertia
        xx, xy, xz, yy, yz, zz = (
            self.parameter(value, f"In[{k}][{frame.number}]")
            for k, value in zip((1, 2, 3, 5, 6, 9), clean(given or (0.0,) * 6), strict=True)
        )
        rows = Vector((xx, xy, xz)), Vector((xy, yy, yz)), Vector((xz, yz, zz))
        return frame.labels.of_matrix(Matrix(rows))

    def loads(self, frame: Frame) -> Spatial:
        """Force and torque on a body at its centre of mass (N, Nm), in the frame's axes."""
        frc, trq = (
            Vector(self.graph.symbol(f"{name}[{k}][{frame.number}]") for k in (1, 2, 3))
            for name in ("frc", "trq")
        )
        return Spatial((frame.labels.of(frc), frame.labels.of(trq)))


#: A number this many times smaller than the largest beside it is a rounding of zero.
ROUNDING = 1e-15


def clean(numbers: Sequence[float]) -> list[float]:
    """Coordinates or elements of a tensor, zero where they are but a rounding of it.

    A frame that was turned by 90 degrees leaves 1e-17 where zero was.
    """
    least = ROUNDING * max(abs(x) for x in numbers)
    return [x if abs(x) > least else 0.0 for x in numbers]


def is_fixed(joint: Joint) -> bool:
    """Whether a joint never moves: driven, and of its symbols only the position is kept."""
    return joint.nature == "driven" and joint.symbols == ("q",)
