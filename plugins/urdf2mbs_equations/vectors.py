"""Vectors and matrices of expressions or numbers, with operators: ``a + b``, ``m @ v``, ``2 * v``.

An element that is always zero is the number 0: sums and products with it cost no operation.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import repeat
from operator import add, mul, neg, sub
from typing import TYPE_CHECKING, TypeVar

from urdf2mbs_equations.graph import Scalar

if TYPE_CHECKING:
    from typing_extensions import Self


Element = TypeVar("Element", Scalar, "Vector")


class _Elementwise(tuple[Element, ...]):
    """A tuple with sums, differences and multiples element by element."""

    __slots__ = ()

    def __add__(self, terms: Self) -> Self:  # type: ignore[override]
        return type(self)(map(add, self, terms))

    def __sub__(self, terms: Self) -> Self:
        return type(self)(map(sub, self, terms))

    def __neg__(self) -> Self:
        return type(self)(map(neg, self))  # type: ignore[arg-type]

    def __mul__(self, factor: Scalar) -> Self:  # type: ignore[override]
        return type(self)(map(mul, repeat(factor), self))

    __rmul__ = __mul__  # type: ignore[assignment]


class Vector(_Elementwise[Scalar]):
    """A vector with three components."""

    __slots__ = ()

    def __matmul__(self, vector: Vector) -> Scalar:
        """Return the scalar product."""
        return self[0] * vector[0] + self[1] * vector[1] + self[2] * vector[2]

    def cross(self, vector: Vector) -> Vector:
        """Return the vector product."""
        (a, b, c), (x, y, z) = self, vector
        return Vector((b * z - c * y, c * x - a * z, a * y - b * x))

    def rotate(self, axis: int, cosine: Scalar, sine: Scalar) -> Vector:
        """Rotate about a coordinate axis (0, 1, 2) by the angle with this cosine and sine."""
        if not sine and cosine == 1:
            return self
        i, j = (axis + 1) % 3, (axis + 2) % 3
        rotated = list(self)
        rotated[i] = cosine * self[i] - sine * self[j]
        rotated[j] = sine * self[i] + cosine * self[j]
        return Vector(rotated)


class Matrix(_Elementwise[Vector]):
    """A 3x3 matrix, as three rows."""

    __slots__ = ()

    @staticmethod
    def from_elements(element: Callable[[int, int], Scalar]) -> Matrix:
        """Return the matrix of the elements by row and column (0, 1, 2)."""
        return Matrix(Vector(element(i, j) for j in range(3)) for i in range(3))

    @property
    def T(self) -> Matrix:  # noqa: N802
        """The transpose."""
        return Matrix(map(Vector, zip(*self, strict=True)))

    def __matmul__(self, vector: Vector) -> Vector:
        return Vector(row @ vector for row in self)

    @property
    def trace(self) -> Scalar:
        """The sum of the diagonal elements."""
        return self[0][0] + self[1][1] + self[2][2]


class Spatial(_Elementwise[Vector]):
    """A linear and an angular vector: velocities, accelerations, or a force and its moment."""

    __slots__ = ()

    @property
    def linear(self) -> Vector:
        """The linear vector: a velocity, an acceleration or a force."""
        return self[0]

    @property
    def angular(self) -> Vector:
        """The angular vector: an angular velocity or acceleration, or a moment."""
        return self[1]

    def __matmul__(self, spatial: Spatial) -> Scalar:
        """Return the power of a force along a motion."""
        return self[0] @ spatial[0] + self[1] @ spatial[1]


ZERO_VECTOR = Vector((0, 0, 0))
UNIT_VECTORS = Vector((1, 0, 0)), Vector((0, 1, 0)), Vector((0, 0, 1))
IDENTITY = Matrix(UNIT_VECTORS)
ZERO_MATRIX = Matrix((ZERO_VECTOR, ZERO_VECTOR, ZERO_VECTOR))
ZERO_SPATIAL = Spatial((ZERO_VECTOR, ZERO_VECTOR))


def outer(left: Vector, right: Vector) -> Matrix:
    """Return the matrix ``left right^T``."""
    return Matrix(Vector(x * y for y in right) for x in left)


class AxisPermutation(tuple[tuple[int, int], tuple[int, int], tuple[int, int]]):
    """A right-handed exchange of the axes of a frame: for each new axis, the old one and its sign.

    ``((1, 1), (0, -1), (2, 1))``: the new x axis is the old y axis, the new y axis is the opposite
    of the old x axis.  In the equations, this rotation costs no operation.
    """

    __slots__ = ()

    def permute(self, vector: Vector) -> Vector:
        """Return a vector, given in the old axes, in the new axes."""
        return Vector(vector[i] if sign > 0 else -vector[i] for i, sign in self)

    def permute_matrix(self, matrix: Matrix) -> Matrix:
        """Return a tensor, given in the old axes, in the new axes."""
        rows = (matrix[i] if sign > 0 else -matrix[i] for i, sign in self)
        return Matrix(map(self.permute, rows))

    def compose(self, first: AxisPermutation) -> AxisPermutation:
        """Return the permutation that applies ``first``, then this one.

        The result is the object ``SAME_AXES`` if nothing changes.
        """
        composed = AxisPermutation((first[i][0], first[i][1] * sign) for i, sign in self)
        return SAME_AXES if composed == SAME_AXES else composed

    @property
    def inverse(self) -> AxisPermutation:
        """The permutation from the new axes to the old ones."""
        inverted = sorted((old, new, sign) for new, (old, sign) in enumerate(self))
        return AxisPermutation((new, sign) for _, new, sign in inverted)


SAME_AXES = AxisPermutation(((0, 1), (1, 1), (2, 1)))
