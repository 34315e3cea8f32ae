"""Vectors and matrices of expressions or numbers, with operators: ``a + b``, ``m @ v``, ``2 * v``.

A zero is the number 0, and what it takes part in costs no operation.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import repeat
from operator import add, mul, neg, sub
from typing import TYPE_CHECKING, TypeVar

from urdf2mbs_equations.graph import Scalar

if TYPE_CHECKING:
    from typing_extensions import Self


T = TypeVar("T", Scalar, "Vector")


class _Elements(tuple[T, ...]):
    """What is added and multiplied element by element."""

    __slots__ = ()

    def __add__(self, more: Self) -> Self:  # type: ignore[override]
        return type(self)(map(add, self, more))

    def __sub__(self, less: Self) -> Self:
        return type(self)(map(sub, self, less))

    def __neg__(self) -> Self:
        return type(self)(map(neg, self))  # type: ignore[arg-type]

    def __mul__(self, x: Scalar) -> Self:  # type: ignore[override]
        return type(self)(map(mul, repeat(x), self))

    __rmul__ = __mul__  # type: ignore[assignment]


class Vector(_Elements[Scalar]):
    """Three numbers."""

    __slots__ = ()

    def __matmul__(self, v: Vector) -> Scalar:
        """The scalar product."""
        return self[0] * v[0] + self[1] * v[1] + self[2] * v[2]

    def cross(self, v: Vector) -> Vector:
        (a, b, c), (x, y, z) = self, v
        return Vector((b * z - c * y, c * x - a * z, a * y - b * x))

    def turned(self, axis: int, c: Scalar, s: Scalar) -> Vector:
        """Turned about a coordinate axis by an angle given by cosine and sine."""
        if not s and c == 1:
            return self
        i, j = (axis + 1) % 3, (axis + 2) % 3
        out = list(self)
        out[i] = c * self[i] - s * self[j]
        out[j] = s * self[i] + c * self[j]
        return Vector(out)


class Matrix(_Elements[Vector]):
    """Three rows."""

    __slots__ = ()

    @staticmethod
    def of(element: Callable[[int, int], Scalar]) -> Matrix:
        """The matrix of the elements at row and column (0, 1, 2)."""
        return Matrix(Vector(element(i, j) for j in range(3)) for i in range(3))

    @property
    def T(self) -> Matrix:  # noqa: N802
        return Matrix(map(Vector, zip(*self, strict=True)))

    def __matmul__(self, v: Vector) -> Vector:
        return Vector(row @ v for row in self)

    @property
    def trace(self) -> Scalar:
        return self[0][0] + self[1][1] + self[2][2]


class Spatial(_Elements[Vector]):
    """A linear and an angular vector: of a motion, or a force and its moment."""

    __slots__ = ()

    @property
    def linear(self) -> Vector:
        return self[0]

    @property
    def angular(self) -> Vector:
        return self[1]

    def __matmul__(self, s: Spatial) -> Scalar:
        """The power of a force along a motion."""
        return self[0] @ s[0] + self[1] @ s[1]


NONE = Vector((0, 0, 0))
UNITS = Vector((1, 0, 0)), Vector((0, 1, 0)), Vector((0, 0, 1))
IDENTITY = Matrix(UNITS)
ZERO = Matrix((NONE, NONE, NONE))
STILL = Spatial((NONE, NONE))


def outer(v: Vector, w: Vector) -> Matrix:
    """The matrix v w^T."""
    return Matrix(Vector(x * y for y in w) for x in v)


class Axes(tuple[tuple[int, int], tuple[int, int], tuple[int, int]]):
    """Other names for the axes of a frame: for each new coordinate the old one and its sign."""

    __slots__ = ()

    def of(self, v: Vector) -> Vector:
        """A vector in the new axes."""
        return Vector(v[i] if sign > 0 else -v[i] for i, sign in self)

    def of_matrix(self, m: Matrix) -> Matrix:
        rows = (m[i] if sign > 0 else -m[i] for i, sign in self)
        return Matrix(map(self.of, rows))

    def after(self, first: Axes) -> Axes:
        """These names for what ``first`` has named; OWN itself if nothing changes."""
        out = Axes((first[i][0], first[i][1] * sign) for i, sign in self)
        return OWN if out == OWN else out

    @property
    def inverse(self) -> Axes:
        found = sorted((old, new, sign) for new, (old, sign) in enumerate(self))
        return Axes((new, sign) for _, new, sign in found)


OWN = Axes(((0, 1), (1, 1), (2, 1)))
