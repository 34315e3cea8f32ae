"""Inertias that a body can have.

The second moment about the centre of mass, ``J = trace(I)/2 - I`` (the integral of r r^T dm),
of a body of positive mass is positive semi-definite, and any such J is some body's: just then
is the 4 x 4 pseudo-inertia ``[[J, 0], [0, m]]`` (P. M. Wensing, S. Kim, J.-J. Slotine, "Linear
Matrix Inequalities for Physically-Consistent Inertial Parameter Identification", IEEE Robotics
and Automation Letters 3(1), 2018).  In principal moments: none is above the sum of the others.
"""

from __future__ import annotations

from math import hypot

import msgspec

from urdf2mbs.spatial import Sym

#: A principal moment may be below zero by this share of the trace.
PSD_TOLERANCE = 1e-9
#: The largest principal moment may be above the sum of the others by this share of the trace.
TRIANGLE_TOLERANCE = 1e-6
#: m^2; times the mass, the remainder that rounding may leave of a zero (iCub has -5e-20 kg m^2).
NOISE = 1e-15
#: An element of a scaled matrix below this is zero.
NEGLIGIBLE = 1e-17
#: Sweeps of Jacobi's method, which converges quadratically: a few suffice.
MAX_SWEEPS = 10

#: A 3 x 3 matrix, by rows.
Rows = list[list[float]]


class Fault(msgspec.Struct, frozen=True):
    """The reason why no body can have an inertia."""

    code: str
    """``inertia-indefinite`` or ``inertia-triangle``."""
    moments: tuple[float, float, float]
    """Principal moments, ascending (kg m^2)."""


def find_fault(tensor: Sym, mass: float) -> Fault | None:
    """Return the fault of an inertia; None if a body can have it.

    Args:
        tensor: The inertia about the centre of mass (kg m^2).
        mass: The mass (kg).
    """
    if _is_surely_positive(second_moment(tensor)):
        return None  # nearly every body, and no eigenvalue is needed
    smallest, middle, largest = principal_moments = moments(tensor)
    trace = smallest + middle + largest
    if smallest < -NOISE * abs(mass) - PSD_TOLERANCE * abs(trace):
        return Fault("inertia-indefinite", principal_moments)
    if largest - smallest - middle > NOISE * abs(mass) + TRIANGLE_TOLERANCE * abs(trace):
        return Fault("inertia-triangle", principal_moments)
    return None


def second_moment(tensor: Sym) -> Sym:
    """Return the second moment ``J = trace(I)/2 - I`` of an inertia (kg m^2)."""
    xx, xy, xz, yy, yz, zz = tensor
    half_trace = (xx + yy + zz) / 2
    return (half_trace - xx, -xy, -xz, half_trace - yy, -yz, half_trace - zz)


def moments(tensor: Sym) -> tuple[float, float, float]:
    """Return the principal moments of an inertia, ascending (kg m^2)."""
    smallest, middle, largest = sorted(principal(tensor)[0])
    return smallest, middle, largest


def principal(tensor: Sym) -> tuple[list[float], Rows]:
    """Return the eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's method.

    Each rotation ``A <- R^T A R`` in a plane (p, q) makes the element A[p][q] zero (Golub and Van
    Loan, Matrix Computations, section 8.5).  Each eigenvalue is as exact as the largest element of
    the matrix allows.

    Returns:
        The three eigenvalues, and the eigenvectors as the columns of a 3 x 3 matrix.
    """
    largest_element = max(map(abs, tensor)) or 1.0
    xx, xy, xz, yy, yz, zz = (component / largest_element for component in tensor)
    matrix = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for _ in range(MAX_SWEEPS):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(matrix[p][q]) >= NEGLIGIBLE:
                _rotate(matrix, vectors, p, q)
    return [matrix[index][index] * largest_element for index in range(3)], vectors


def _rotate(matrix: Rows, vectors: Rows, p: int, q: int) -> None:
    """Make the element (p, q) of a symmetric matrix zero by a rotation, which the vectors follow.

    With t the tangent of the angle: t^2 + 2 theta t - 1 = 0, of which the smaller root is taken.
    """
    theta = (matrix[q][q] - matrix[p][p]) / (2 * matrix[p][q])
    tangent = (1.0 if theta >= 0 else -1.0) / (abs(theta) + hypot(theta, 1.0))
    cosine = 1.0 / hypot(tangent, 1.0)
    sine = tangent * cosine
    for rows in (matrix, vectors):  # A R
        for row in rows:
            row[p], row[q] = cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]
    row_p, row_q = matrix[p], matrix[q]  # R^T (A R)
    for column in range(3):
        row_p[column], row_q[column] = (
            cosine * row_p[column] - sine * row_q[column],
            sine * row_p[column] + cosine * row_q[column],
        )


def _is_surely_positive(tensor: Sym) -> bool:
    """Return True if a symmetric matrix is positive definite beyond rounding, by its minors."""
    xx, xy, xz, yy, yz, zz = tensor
    leading_minor = xx * yy - xy * xy
    determinant = leading_minor * zz - xx * yz * yz - yy * xz * xz + 2 * xy * xz * yz
    return (
        xx > 0.0
        and leading_minor > 1e-12 * xx * yy
        and determinant > 1e-12 * leading_minor * abs(zz)
    )
