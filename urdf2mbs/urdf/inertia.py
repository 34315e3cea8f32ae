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

#: How far, as a share of the trace, a principal moment may be below zero, and the largest
#: above the sum of the two others.
PSD_TOLERANCE = 1e-9
TRIANGLE_TOLERANCE = 1e-6
#: m^2; times the mass, what rounding may leave of a zero (iCub has -5e-20 kg m^2).
NOISE = 1e-15

Rows = list[list[float]]


class Fault(msgspec.Struct, frozen=True):
    """The reason why no body can have an inertia."""

    code: str
    """``inertia-indefinite`` or ``inertia-triangle``."""
    moments: tuple[float, float, float]
    """Principal moments, ascending (kg m^2)."""


def find_fault(tensor: Sym, mass: float) -> Fault | None:
    """The fault of an inertia (kg m^2, about the centre of mass); None if a body can have it."""
    if _is_surely_positive(second_moment(tensor)):
        return None  # nearly every body, and no eigenvalue is needed
    small, middle, large = stated = moments(tensor)
    trace = small + middle + large
    if small < -NOISE * abs(mass) - PSD_TOLERANCE * abs(trace):
        return Fault("inertia-indefinite", stated)
    if large - small - middle > NOISE * abs(mass) + TRIANGLE_TOLERANCE * abs(trace):
        return Fault("inertia-triangle", stated)
    return None


def second_moment(tensor: Sym) -> Sym:
    """J of an inertia (kg m^2)."""
    xx, xy, xz, yy, yz, zz = tensor
    half = (xx + yy + zz) / 2
    return (half - xx, -xy, -xz, half - yy, -yz, half - zz)


def moments(tensor: Sym) -> tuple[float, float, float]:
    """Principal moments, ascending (kg m^2)."""
    small, middle, large = sorted(principal(tensor)[0])
    return small, middle, large


def principal(tensor: Sym) -> tuple[list[float], Rows]:
    """Eigenvalues of a symmetric matrix, and its eigenvectors as the columns of a 3 x 3 matrix,
    by Jacobi's method (Golub and Van Loan, Matrix Computations, 8.5): each value as exact as
    the largest element allows."""
    size = max(map(abs, tensor)) or 1.0
    xx, xy, xz, yy, yz, zz = (value / size for value in tensor)
    a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for _ in range(10):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(a[p][q]) < 1e-17:
                continue
            theta = (a[q][q] - a[p][p]) / (2 * a[p][q])
            t = (1.0 if theta >= 0 else -1.0) / (abs(theta) + hypot(theta, 1.0))
            c = 1.0 / hypot(t, 1.0)
            s = t * c
            for rows in (a, axes):
                for k in range(3):
                    rows[k][p], rows[k][q] = (
                        c * rows[k][p] - s * rows[k][q],
                        s * rows[k][p] + c * rows[k][q],
                    )
            for k in range(3):
                a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
    return [a[k][k] * size for k in range(3)], axes


def _is_surely_positive(tensor: Sym) -> bool:
    """True if a symmetric matrix is positive definite beyond rounding (Sylvester's minors)."""
    xx, xy, xz, yy, yz, zz = tensor
    minor = xx * yy - xy * xy
    determinant = minor * zz - xx * yz * yz - yy * xz * xz + 2 * xy * xz * yz
    return xx > 0.0 and minor > 1e-12 * xx * yy and determinant > 1e-12 * minor * abs(zz)
