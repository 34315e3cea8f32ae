"""The nearest possible inertia to one that no body can have."""

from __future__ import annotations

from math import sqrt

from urdf2mbs.plugin import Inertial, Sym, moments, principal, second_moment


def find_nearest_inertia(inertial: Inertial) -> tuple[Inertial, float]:
    """Find the nearest inertia that a body can have.

    With the second moment ``J = trace(I)/2 E - I`` about the centre of mass, a body can have an
    inertia if its pseudo-inertia ``[[J, 0], [0, m]]`` is positive semi-definite.  The nearest such
    matrix in the Frobenius norm has zero instead of each negative eigenvalue (N. J. Higham,
    "Computing a nearest symmetric positive semidefinite matrix", Linear Algebra and its
    Applications 103, 1988).  So a negative mass becomes zero, too.  The centre of mass stays.

    Returns:
        The nearest inertia, and the Frobenius norm of the change of J (kg m^2).
    """
    eigenvalues, eigenvectors = principal(second_moment(inertial.inertia))
    possible_eigenvalues = [max(eigenvalue, 0.0) for eigenvalue in eigenvalues]
    change_norm = sqrt(
        sum(eigenvalue * eigenvalue for eigenvalue in eigenvalues if eigenvalue < 0.0)
    )
    J = [  # noqa: N806
        [
            sum(
                possible_eigenvalues[index] * eigenvectors[row][index] * eigenvectors[column][index]
                for index in range(3)
            )
            for column in range(3)
        ]
        for row in range(3)
    ]
    trace = sum(possible_eigenvalues)
    nearest_tensor = (
        trace - J[0][0],
        -J[0][1],
        -J[0][2],
        trace - J[1][1],
        -J[1][2],
        trace - J[2][2],
    )
    return Inertial(max(inertial.mass, 0.0), nearest_tensor, inertial.origin), change_norm


def compute_second_moments(tensor: Sym) -> list[float]:
    """Compute the eigenvalues of the second moment J of an inertia (kg m^2)."""
    principal_moments = moments(tensor)
    return [sum(principal_moments) / 2 - moment for moment in principal_moments]
