"""Vectors, frames and inertias of the proof.  It shares no line with ``spatial``.

A *frame* A_B is the pose of a frame B in a frame A: a rotation matrix R and an origin p.  It
transforms coordinates of B into those of A, ``v_A = R v_B + p``, and frames are composed like
homogeneous matrices, ``A_C = A_B B_C``.

A *deviation* is a difference relative to a scale.  It is never negative, and never NaN: whatever is
not a finite number deviates by the largest float.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import asin, atan2, cos, hypot, isfinite, sin
from sys import float_info
from typing import NamedTuple

from urdf2mbs.spatial import Sym, Vec

#: A rotation matrix row by row, then the origin (m).
Frame = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float
]  # fmt: skip

IDENTITY: Frame = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
IDENTITY_ROTATION = IDENTITY[:9]
ORIGIN: Vec = (0.0, 0.0, 0.0)
X, Y, Z = AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Inertia(NamedTuple):
    """The inertia of one or several rigid bodies, in some frame."""

    mass: float
    """kg."""
    centre: Vec
    """The centre of mass (m)."""
    tensor: Sym
    """``xx, xy, xz, yy, yz, zz`` about the centre of mass (kg m^2)."""


class Line(NamedTuple):
    """The axis of a joint, as a line in space."""

    point: Vec
    """Any point of it (m)."""
    direction: Vec
    """Of length 1."""


NO_INERTIA = Inertia(0.0, ORIGIN, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


# --- vectors ---


def dot(a: Vec, b: Vec) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec, b: Vec) -> Vec:
    """Return the vector product a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def reject_from_axis(vector: Vec, axis: Vec) -> Vec:
    """Return the component of a vector that is normal to a unit axis."""
    length = dot(vector, axis)
    return (
        vector[0] - length * axis[0],
        vector[1] - length * axis[1],
        vector[2] - length * axis[2],
    )


def compute_angle(a: Vec, b: Vec) -> float:
    """Compute the angle (rad) between two unit vectors, ``2 asin(|a - b| / 2)``.

    Unlike ``acos(a . b)`` it keeps all digits of a small angle.
    """
    return 2.0 * asin(min(1.0, hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / 2.0))


# --- frames ---


def compute_translation(axis: Vec, length: float) -> Frame:
    """Compute the frame of a shift by a length (m) along a unit axis."""
    return (*IDENTITY_ROTATION, length * axis[0], length * axis[1], length * axis[2])


def compute_rotation(axis: Vec, angle: float) -> Frame:
    """Compute the frame of a rotation by an angle (rad) about a unit axis.

    Rodrigues' formula: ``R = 1 + sin(angle) K + (1 - cos(angle)) K^2``, with K the matrix of the
    cross product, ``K v = axis x v``.
    """
    x, y, z = axis
    s, c = sin(angle), 1.0 - cos(angle)
    row_x = (1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y)
    row_y = (c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x)
    row_z = (c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y))
    return (*row_x, *row_y, *row_z, 0.0, 0.0, 0.0)


def compute_angle_about(frame: Frame, axis: Vec) -> float:
    """Compute the angle (rad) by which a frame is rotated about a unit axis.

    With R the rotation matrix, ``2 sin(angle) axis`` is the vector of ``R - R^T``, and
    ``1 + 2 cos(angle)`` is the trace of R.
    """
    a11, a12, a13, a21, a22, a23, a31, a32, a33 = frame[:9]
    sine = dot((a32 - a23, a13 - a31, a21 - a12), axis) / 2.0
    return atan2(sine, (a11 + a22 + a33 - 1.0) / 2.0)


def compose(a: Frame, b: Frame) -> Frame:
    """Return the product ``a b``: ``b`` is given in ``a``, and the result where ``a`` is given."""
    if a is IDENTITY:
        return b
    if b is IDENTITY:
        return a
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = a
    b11, b12, b13, b21, b22, b23, b31, b32, b33, bx, by, bz = b
    return (
        a11 * b11 + a12 * b21 + a13 * b31,
        a11 * b12 + a12 * b22 + a13 * b32,
        a11 * b13 + a12 * b23 + a13 * b33,
        a21 * b11 + a22 * b21 + a23 * b31,
        a21 * b12 + a22 * b22 + a23 * b32,
        a21 * b13 + a22 * b23 + a23 * b33,
        a31 * b11 + a32 * b21 + a33 * b31,
        a31 * b12 + a32 * b22 + a33 * b32,
        a31 * b13 + a32 * b23 + a33 * b33,
        ax + a11 * bx + a12 * by + a13 * bz,
        ay + a21 * bx + a22 * by + a23 * bz,
        az + a31 * bx + a32 * by + a33 * bz,
    )


def inverse(frame: Frame) -> Frame:
    """Return the inverse: the rotation ``R^T``, and the origin ``-R^T p``."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, x, y, z = frame
    origin = (
        -(a11 * x + a21 * y + a31 * z),
        -(a12 * x + a22 * y + a32 * z),
        -(a13 * x + a23 * y + a33 * z),
    )
    return (a11, a21, a31, a12, a22, a32, a13, a23, a33, *origin)


def rotate(frame: Frame, direction: Vec) -> Vec:
    """Return ``R v``: a direction given in a frame, in the axes where the frame is given."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, _, _, _ = frame
    x, y, z = direction
    return (a11 * x + a12 * y + a13 * z, a21 * x + a22 * y + a23 * z, a31 * x + a32 * y + a33 * z)


def transform_point(frame: Frame, point: Vec) -> Vec:
    """Return ``R v + p``: a point given in a frame, where the frame is given (m)."""
    if frame is IDENTITY:
        return point
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = frame
    x, y, z = point
    return (
        ax + a11 * x + a12 * y + a13 * z,
        ay + a21 * x + a22 * y + a23 * z,
        az + a31 * x + a32 * y + a33 * z,
    )


# --- inertias ---


def transform_inertia(inertia: Inertia, frame: Frame) -> Inertia:
    """Return an inertia given in a frame, where the frame is given: the tensor is ``R I R^T``."""
    if frame is IDENTITY:
        return inertia
    mass, centre, (xx, xy, xz, yy, yz, zz) = inertia
    if frame[:9] == IDENTITY_ROTATION:
        return Inertia(mass, transform_point(frame, centre), inertia.tensor)
    x, y, z = frame[:3], frame[3:6], frame[6:9]  # the rows of R
    product_x, product_y, product_z = (  # the rows of R I
        (dot(row, (xx, xy, xz)), dot(row, (xy, yy, yz)), dot(row, (xz, yz, zz)))
        for row in (x, y, z)
    )
    tensor = (
        dot(product_x, x),
        dot(product_x, y),
        dot(product_x, z),
        dot(product_y, y),
        dot(product_y, z),
        dot(product_z, z),
    )
    return Inertia(mass, transform_point(frame, centre), tensor)


def sum_inertias(inertias: Sequence[Inertia]) -> Inertia:
    """Return the sum of inertias that are given in one frame.

    With d the vector from the common centre of mass to that of a body, the parallel-axis theorem
    adds ``m (d . d 1 - d d^T)`` to the tensor of the body.
    """
    if not inertias:
        return NO_INERTIA
    if len(inertias) == 1:
        return inertias[0]
    mass = sum(m for m, _, _ in inertias)
    x, y, z = (sum(m * c[k] for m, c, _ in inertias) / (mass or 1.0) for k in range(3))
    xx = xy = xz = yy = yz = zz = 0.0
    for m, (cx, cy, cz), tensor in inertias:
        dx, dy, dz = cx - x, cy - y, cz - z
        xx += tensor[0] + m * (dy * dy + dz * dz)
        xy += tensor[1] - m * dx * dy
        xz += tensor[2] - m * dx * dz
        yy += tensor[3] + m * (dx * dx + dz * dz)
        yz += tensor[4] - m * dy * dz
        zz += tensor[5] + m * (dx * dx + dy * dy)
    return Inertia(mass, (x, y, z), (xx, xy, xz, yy, yz, zz))


# --- deviations ---


def find_largest(deviations: Sequence[float]) -> float:
    """Return the largest deviation; the largest float if one of them is not a finite number.

    ``max`` alone ignores a NaN, or not, depending on its position.
    """
    # No deviation is negative, so the sum is finite only if each of them is.
    return max(deviations) if isfinite(sum(deviations)) else float_info.max


def compute_deviation(a: Sequence[float], b: Sequence[float], scale: float = 1.0) -> float:
    """Compute the largest difference between the elements of two vectors, relative to a scale."""
    if a == b and isfinite(sum(a)):
        return 0.0
    return find_largest([abs(p - q) / scale for p, q in zip(a, b, strict=True)])


def compute_frame_deviation(a: Frame, b: Frame, scale: float) -> float:
    """Compute the deviation of two frames: of their rotations (rad), or of their origins.

    Args:
        a: A frame.
        b: Another one, given in the same frame.
        scale: Length (m) to which the distance of the origins is relative.
    """
    if a == b and isfinite(sum(a)):
        return 0.0  # as of most frames of a robot that was converted
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = a
    b11, b12, b13, b21, b22, b23, b31, b32, b33, bx, by, bz = b
    deviations = (
        abs(a11 - b11),
        abs(a12 - b12),
        abs(a13 - b13),
        abs(a21 - b21),
        abs(a22 - b22),
        abs(a23 - b23),
        abs(a31 - b31),
        abs(a32 - b32),
        abs(a33 - b33),
        abs(ax - bx) / scale,
        abs(ay - by) / scale,
        abs(az - bz) / scale,
    )
    return find_largest(deviations)


def place_axis(frame: Frame, axis: Vec) -> Line:
    """Return the line of an axis that passes through the origin of a frame."""
    return Line(frame[9:], rotate(frame, axis))


def compute_axis_deviation(a: Line, b: Line, scale: float, *, revolute: bool) -> float:
    """Compute the deviation of two joint axes: of their directions, and of where they are.

    Args:
        a: An axis.
        b: Another one, in the same frame.
        scale: Length (m) to which the distance of the lines is relative.
        revolute: True for axes of rotation.  Those of a shift have no place.
    """
    deviation = compute_deviation(a.direction, b.direction)
    if not revolute:
        return deviation
    offset = (a.point[0] - b.point[0], a.point[1] - b.point[1], a.point[2] - b.point[2])
    return find_largest((deviation, hypot(*cross(offset, b.direction)) / scale))


def compare_inertias(a: Inertia, b: Inertia, scale: float) -> dict[str, float]:
    """Compute the deviations of ``mass``, ``centre`` and ``inertia``, each on its own scale.

    Masses are compared relative to the larger mass, centres relative to ``scale``, and tensors
    relative to their largest element.  To this 1e-6 of the tensor of a point mass at ``scale`` is
    added, since the sum of point masses has rounding errors of that origin.

    Args:
        a: An inertia.
        b: Another one, in the same frame.
        scale: Size of the bodies (m).
    """
    if a == b and isfinite(a.mass + sum(a.centre) + sum(a.tensor)):
        return {"mass": 0.0, "centre": 0.0, "inertia": 0.0}
    mass = max(abs(a.mass), abs(b.mass))
    moment = _find_largest_element((*a.tensor, *b.tensor)) + 1e-6 * mass * scale * scale
    return {
        "mass": compute_deviation((a.mass,), (b.mass,), mass or 1.0),
        "centre": compute_deviation(a.centre, b.centre, scale) if mass else 0.0,
        "inertia": compute_deviation(a.tensor, b.tensor, moment or 1.0),
    }


def _find_largest_element(numbers: Iterable[float]) -> float:
    """Return the largest absolute value."""
    return max(map(abs, numbers))
