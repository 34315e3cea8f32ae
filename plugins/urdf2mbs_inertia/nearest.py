"""The inertia nearest to one that no body can have."""

from __future__ import annotations

from math import sqrt

from urdf2mbs.plugin import Inertial, Sym, moments, principal, second_moment


def nearest(inertial: Inertial) -> tuple[Inertial, float]:
    """The nearest inertia that a body can have, and by how much it moved (kg m^2).

    Mass below zero becomes zero, and so does each negative eigenvalue of J: of all positive
    semi-definite matrices that one is the nearest to the pseudo-inertia about the centre of mass
    in the Frobenius norm (N. J. Higham, "Computing a nearest symmetric positive semidefinite
    matrix", Linear Algebra and its Applications 103, 1988).  The centre of mass stays.  "Moved"
    is the Frobenius norm of the change of J.
    """
    values, axes = principal(second_moment(inertial.inertia))
    kept = [max(value, 0.0) for value in values]
    moved = sqrt(sum(value * value for value in values if value < 0.0))
    j = [
        [sum(kept[k] * axes[p][k] * axes[q][k] for k in range(3)) for q in range(3)]
        for p in range(3)
    ]
    trace = sum(kept)
    tensor = (trace - j[0][0], -j[0][1], -j[0][2], trace - j[1][1], -j[1][2], trace - j[2][2])
    return Inertial(max(inertial.mass, 0.0), tensor, inertial.origin), moved


def second_moments(tensor: Sym) -> list[float]:
    """Eigenvalues of J (kg m^2)."""
    stated = moments(tensor)
    return [sum(stated) / 2 - moment for moment in stated]
