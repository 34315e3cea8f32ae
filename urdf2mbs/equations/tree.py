"""The tree of joints that a model is, as expressions: where each joint stands, what it carries.

Each joint has a frame behind it.  Masses, centres, inertias and points are symbols that are
read from the data, as Robotran's own equations do, wherever they are more than a rounding of
zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar, cast

from urdf2mbs.equations.graph import Expr, Graph, Op
from urdf2mbs.mbs.model import Body, Joint, Mbs

#: Three expressions; most often the coordinates of a vector.
Vector = tuple[Expr, Expr, Expr]
#: The elements of a symmetric matrix, as rows.
Matrix = list[list[Expr]]

NONE: Vector = (0, 0, 0)

#: Other axes of a frame: for each coordinate, which it was in the old axes, and its sign.
Labels = tuple[tuple[int, int], tuple[int, int], tuple[int, int]]
OWN: Labels = ((0, 1), (1, 1), (2, 1))


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
    q: Expr
    qd: Expr
    qdd: Expr
    sin: Expr
    cos: Expr
    offset: Vector
    """Where the frame behind the joint is in the frame before it (m): a point, a shift by q."""
    labels: Labels = OWN
    """The frame's axes, of those of the file."""
    change: Labels = OWN
    """The frame's axes, of those of the frame before, where the joint is at zero."""
    back: Labels = OWN
    """The other way."""
    body: Body | None = None
    """The body whose frame this is."""


class Tree:
    """All frames of a model, ``frames[0]`` being the ground's, in one graph."""

    def __init__(
        self,
        mbs: Mbs,
        *,
        fold: bool = False,
        still: bool = False,
        labels: Mapping[int, Labels] | None = None,
    ) -> None:
        """``fold`` makes numbers of the model's data; ``still`` makes numbers of all, at the start
        position."""
        self.mbs = mbs
        self.graph = graph = Graph()
        self.fold, self.still = fold or still, still
        self.last: dict[str | None, int] = {None: 0}
        """The number of each body's last joint."""
        points = mbs.points()
        self.points = {place: number for number, place in enumerate(points, start=1)}
        """The number of each point, as Robotran counts: in the order of the file, base first."""
        self.coordinates = {place: clean(point.coordinates) for place, point in points.items()}
        labels = labels or {}
        ground = Joint("", "T1")
        self.frames = [Frame(0, ground, 0, 0, False, 0, 0, 0, 0, 1, NONE)]
        for body in mbs.bodies:
            parent = self.last[body.parent]
            start = self.point(body.parent, body.point)
            for joint in body.joints:
                number = len(self.frames)
                q, qd, qdd = self._motion(joint, number)
                turns = joint.type[0] == "R"
                own, before = labels.get(number, OWN), self.frames[parent].labels
                axis = [i for i, _ in own].index(int(joint.type[1]) - 1)
                sine, cosine = (graph.sin(q), graph.cos(q)) if turns else (0, 1)
                frame = Frame(number, joint, parent, axis, turns, q, qd, qdd, sine, cosine, start)
                frame.labels, frame.change = own, chain_labels(own, invert_labels(before))
                frame.back = invert_labels(frame.change)
                self.frames.append(frame)
                if not turns:
                    frame.offset = self.plus(start, self.before(frame, along(axis, q)))
                parent, start = number, NONE
            self.last[body.name] = parent
            self.frames[parent].body = body

    def _motion(self, joint: Joint, number: int) -> tuple[Expr, Expr, Expr]:
        graph = self.graph
        if self.still or is_fixed(joint):
            return graph.constant(joint.q or 0.0), 0, 0
        kept = ("q", "qd", "qdd") if joint.symbols is None else joint.symbols
        q, qd, qdd = (
            graph.symbol(f"{name}[{number}]") if name in kept else 0 for name in ("q", "qd", "qdd")
        )
        return q, qd, qdd

    def moves(self, frame: Frame) -> bool:
        """True if the position of a joint is not a number of the equations."""
        return self.graph.op[abs(frame.q)] != Op.CONST

    def parameter(self, value: float | None, name: str) -> Expr:
        """A number of the file: a symbol if it is not zero, or with ``fold`` the number."""
        if not value:
            return 0
        return self.graph.constant(value) if self.fold else self.graph.symbol(name)

    def point(self, body: str | None, point: str | None) -> Vector:
        """The coordinates of a point in its body's frame (m)."""
        if point is None:
            return NONE
        number = self.points[body, point]
        x, y, z = (
            self.parameter(value, f"dpt[{k}][{number}]")
            for k, value in enumerate(self.coordinates[body, point], start=1)
        )
        return relabel((x, y, z), self.frames[self.last[body]].labels)

    def gravity(self) -> Vector:
        x, y, z = (
            self.parameter(value, f"g[{k}]")
            for k, value in enumerate(self.mbs.base.gravity, start=1)
        )
        return x, y, z

    def mass(self, frame: Frame) -> Expr:
        body = frame.body
        return 0 if body is None else self.parameter(body.mass, f"m[{frame.number}]")

    def centre(self, frame: Frame) -> Vector:
        """The centre of mass in the frame (m)."""
        given = (0.0, 0.0, 0.0)
        if frame.body is not None and frame.body.com is not None:
            given = clean(frame.body.com)
        x, y, z = (
            self.parameter(value, f"l[{k}][{frame.number}]")
            for k, value in enumerate(given, start=1)
        )
        return relabel((x, y, z), frame.labels)

    def inertia(self, frame: Frame) -> Matrix:
        """About the centre of mass, in the frame's axes (kg m^2)."""
        given = (0.0,) * 6
        if frame.body is not None and frame.body.inertia is not None:
            given = clean(frame.body.inertia)
        xx, xy, xz, yy, yz, zz = (
            self.parameter(value, f"In[{k}][{frame.number}]")
            for k, value in zip((1, 2, 3, 5, 6, 9), given, strict=True)
        )
        return relabel_matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], frame.labels)

    def loads(self, frame: Frame) -> tuple[Vector, Vector]:
        """Force and torque on a body at its centre of mass (N, Nm), in the frame's axes."""
        symbol, number = self.graph.symbol, frame.number
        fx, fy, fz = (symbol(f"frc[{k}][{number}]") for k in (1, 2, 3))
        mx, my, mz = (symbol(f"trq[{k}][{number}]") for k in (1, 2, 3))
        return relabel((fx, fy, fz), frame.labels), relabel((mx, my, mz), frame.labels)

    # --- vectors ---------------------------------------------------------------------------

    def plus(self, v: Vector, w: Vector) -> Vector:
        add = self.graph.add
        return add(v[0], w[0]), add(v[1], w[1]), add(v[2], w[2])

    def minus(self, v: Vector, w: Vector) -> Vector:
        return self.plus(v, (-w[0], -w[1], -w[2]))

    def times(self, s: Expr, v: Vector) -> Vector:
        mul = self.graph.mul
        return mul(s, v[0]), mul(s, v[1]), mul(s, v[2])

    def dot(self, v: Vector, w: Vector) -> Expr:
        add, mul = self.graph.add, self.graph.mul
        return add(add(mul(v[0], w[0]), mul(v[1], w[1])), mul(v[2], w[2]))

    def cross(self, v: Vector, w: Vector) -> Vector:
        add, mul = self.graph.add, self.graph.mul
        return (
            add(mul(v[1], w[2]), -mul(v[2], w[1])),
            add(mul(v[2], w[0]), -mul(v[0], w[2])),
            add(mul(v[0], w[1]), -mul(v[1], w[0])),
        )

    def behind(self, frame: Frame, v: Vector) -> Vector:
        """A vector in the axes of the frame before a joint, in those behind it if this is at
        zero."""
        return v if frame.change is OWN else relabel(v, frame.change)

    def before(self, frame: Frame, v: Vector) -> Vector:
        """The other way."""
        return v if frame.change is OWN else relabel(v, frame.back)

    def outward(self, frame: Frame, v: Vector) -> Vector:
        """A vector given in the frame before a joint, in the frame behind it."""
        v = self.behind(frame, v)
        return self.turn(frame.axis, frame.cos, -frame.sin, v) if frame.turns else v

    def inward(self, frame: Frame, v: Vector) -> Vector:
        """A vector given in the frame behind a joint, in the frame before it."""
        if frame.turns:
            v = self.turn(frame.axis, frame.cos, frame.sin, v)
        return self.before(frame, v)

    def turn(self, axis: int, c: Expr, s: Expr, v: Vector) -> Vector:
        """A vector, turned about a coordinate axis by an angle given by cosine and sine."""
        if s == 0 and c == 1:
            return v
        add, mul = self.graph.add, self.graph.mul
        i, j = (axis + 1) % 3, (axis + 2) % 3
        out = list(v)
        out[i] = add(mul(c, v[i]), -mul(s, v[j]))
        out[j] = add(mul(s, v[i]), mul(c, v[j]))
        return out[0], out[1], out[2]


#: A number this many times smaller than the largest beside it is a rounding of zero.
ROUNDING = 1e-15

Numbers = TypeVar("Numbers", bound=tuple[float, ...])


def clean(numbers: Numbers) -> Numbers:
    """Coordinates or elements of a tensor, zero where they are but a rounding of it.

    A frame that was turned by 90 degrees leaves 1e-17 where zero was.
    """
    least = ROUNDING * max(abs(x) for x in numbers)
    return cast("Numbers", tuple(x if abs(x) > least else 0.0 for x in numbers))


def is_fixed(joint: Joint) -> bool:
    """Whether a joint never moves: driven, and of its symbols only the position is kept."""
    return joint.nature == "driven" and joint.symbols == ("q",)


def along(axis: int, x: Expr) -> Vector:
    """A vector along a coordinate axis."""
    out = [0, 0, 0]
    out[axis] = x
    return out[0], out[1], out[2]


def relabel(v: Vector, labels: Labels) -> Vector:
    """A vector in other axes."""
    (i, a), (j, b), (k, c) = labels
    return a * v[i], b * v[j], c * v[k]


def relabel_matrix(matrix: Matrix, labels: Labels) -> Matrix:
    return [[a * b * matrix[i][j] for j, b in labels] for i, a in labels]


def chain_labels(labels: Labels, first: Labels) -> Labels:
    """Other axes than those that ``first`` makes; OWN itself if nothing changes."""
    (i, a), (j, b), (k, c) = ((first[index][0], first[index][1] * sign) for index, sign in labels)
    out = (i, a), (j, b), (k, c)
    return OWN if out == OWN else out


def invert_labels(labels: Labels) -> Labels:
    (_, i, a), (_, j, b), (_, k, c) = sorted(
        (index, new, sign) for new, (index, sign) in enumerate(labels)
    )
    return (i, a), (j, b), (k, c)
