"""Vectors, frames and inertias, for the proof alone: it shares no line with ``spatial``."""

from __future__ import annotations

from collections.abc import Sequence
from math import asin, atan2, cos, hypot, isfinite, sin
from sys import float_info

from urdf2mbs.spatial import Sym, Vec

#: A frame: a rotation matrix row by row, then the origin (m).
Frame = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float
]  # fmt: skip
#: Mass (kg), centre (m), and inertia about it (kg m^2), in some frame.
Inertia = tuple[float, Vec, Sym]

HERE: Frame = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
ORIGIN: Vec = (0.0, 0.0, 0.0)
#: The rotation of a frame that is not turned.
UNTURNED = HERE[:9]
NOTHING: Inertia = (0.0, ORIGIN, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
X, Y, Z = AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def shift(u: Vec, q: float) -> Frame:
    """A shift by ``q`` (m) along a unit vector."""
    return (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, q * u[0], q * u[1], q * u[2])


def spin(u: Vec, q: float) -> Frame:
    """Rodrigues: R = 1 + sin(q) K + (1 - cos(q)) K^2, K the cross product with the unit axis."""
    x, y, z = u
    s, c = sin(q), 1.0 - cos(q)
    return (
        1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y,
        c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x,
        c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y),
        0.0, 0.0, 0.0,
    )  # fmt: skip


def dot(a: Vec, b: Vec) -> float:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec, b: Vec) -> Vec:
    """The vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def across(v: Vec, e: Vec) -> Vec:
    """The part of a vector that is normal to a unit axis."""
    along = dot(v, e)
    return (v[0] - along * e[0], v[1] - along * e[1], v[2] - along * e[2])


def angle(a: Vec, b: Vec) -> float:
    """Between two unit vectors (rad)."""
    return 2.0 * asin(min(1.0, hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / 2.0))


def about(frame: Frame, axis: Vec) -> float:
    """The turn (rad) of a frame about an axis."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33 = frame[:9]
    sine = dot((a32 - a23, a13 - a31, a21 - a12), axis) / 2.0
    return atan2(sine, (a11 + a22 + a33 - 1.0) / 2.0)


def between_axes(at: Frame, u: Vec, other: Frame, v: Vec, turns: bool, scale: float) -> float:
    """The deviation of two joint axes: of their directions, and of the places of turning axes."""
    a, b = turned(at, u), turned(other, v)
    off = most(a, b)
    if turns:
        d = (at[9] - other[9], at[10] - other[10], at[11] - other[11])
        off = worst((off, hypot(*cross(d, b)) / scale))
    return off


def most(a: Sequence[float], b: Sequence[float], scale: float = 1.0) -> float:
    """The largest difference between two lists of numbers, relative to ``scale``."""
    if a == b and isfinite(sum(a)):
        return 0.0
    return worst([abs(p - q) / scale for p, q in zip(a, b, strict=True)])


def worst(offs: Sequence[float]) -> float:
    """The largest of some deviations; the largest double if one is infinite or not a number.

    ``max`` alone passes over what is not a number, or not, by where it stands.
    """
    # no deviation is negative, so the sum is finite only if each of them is
    return max(offs) if isfinite(sum(offs)) else float_info.max


def compose(a: Frame, b: Frame) -> Frame:
    """The frame ``b``, which is seen from ``a``, as seen from where ``a`` is."""
    if a is HERE:
        return b
    if b is HERE:
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


def inverse(a: Frame) -> Frame:
    """The frame from which ``a`` is seen, as seen from ``a``."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, x, y, z = a
    return (
        a11, a21, a31, a12, a22, a32, a13, a23, a33,
        -(a11 * x + a21 * y + a31 * z),
        -(a12 * x + a22 * y + a32 * z),
        -(a13 * x + a23 * y + a33 * z),
    )  # fmt: skip


def turned(frame: Frame, v: Vec) -> Vec:
    """A direction given in a frame, from where the frame is given."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, _, _, _ = frame
    x, y, z = v
    return (a11 * x + a12 * y + a13 * z, a21 * x + a22 * y + a23 * z, a31 * x + a32 * y + a33 * z)


def moved(frame: Frame, v: Vec) -> Vec:
    """A point given in a frame, from where the frame is given."""
    if frame is HERE:
        return v
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = frame
    x, y, z = v
    return (
        ax + a11 * x + a12 * y + a13 * z,
        ay + a21 * x + a22 * y + a23 * z,
        az + a31 * x + a32 * y + a33 * z,
    )


def distance(a: Frame, b: Frame, scale: float) -> float:
    """The deviation of two frames: the larger of the turn (rad) and the shift over ``scale``."""
    if a == b and isfinite(sum(a)):
        return 0.0  # as most of one robot are, bit by bit
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = a
    b11, b12, b13, b21, b22, b23, b31, b32, b33, bx, by, bz = b
    return worst((
        abs(a11 - b11), abs(a12 - b12), abs(a13 - b13),
        abs(a21 - b21), abs(a22 - b22), abs(a23 - b23),
        abs(a31 - b31), abs(a32 - b32), abs(a33 - b33),
        abs(ax - bx) / scale, abs(ay - by) / scale, abs(az - bz) / scale,
    ))  # fmt: skip


def seen(inertia: Inertia, frame: Frame) -> Inertia:
    """An inertia given in a frame, from where the frame is given: R I R^T."""
    if frame is HERE:
        return inertia
    mass, centre, (xx, xy, xz, yy, yz, zz) = inertia
    if frame[:9] == UNTURNED:
        return mass, moved(frame, centre), inertia[2]
    rows = frame[:3], frame[3:6], frame[6:9]
    one, two, three = (
        (dot(row, (xx, xy, xz)), dot(row, (xy, yy, yz)), dot(row, (xz, yz, zz))) for row in rows
    )
    x, y, z = rows
    turned_tensor = (
        dot(one, x), dot(one, y), dot(one, z), dot(two, y), dot(two, z), dot(three, z)
    )  # fmt: skip
    return mass, moved(frame, centre), turned_tensor


def merge(parts: list[tuple[str, Inertia]]) -> Inertia:
    """Several inertias in one frame as one, by the parallel-axis theorem."""
    if not parts:
        return NOTHING
    if len(parts) == 1:
        return parts[0][1]
    inertias = [inertia for _, inertia in parts]
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
    return mass, (x, y, z), (xx, xy, xz, yy, yz, zz)


def inertias_apart(ours: Inertia, theirs: Inertia, scale: float) -> dict[str, float]:
    """The deviation of two inertias, each part relative to its own scale.

    An inertia is not asked to be finer than 1e-15 of what its mass has at ``scale``: lumping
    point masses leaves that much dust.
    """
    if ours == theirs and isfinite(ours[0] + sum(ours[1]) + sum(ours[2])):
        return {"mass": 0.0, "centre": 0.0, "inertia": 0.0}
    heaviest = max(abs(ours[0]), abs(theirs[0]))
    tensor = max(map(abs, (*ours[2], *theirs[2]))) + 1e-6 * heaviest * scale * scale
    return {
        "mass": most(ours[:1], theirs[:1], heaviest or 1.0),
        "centre": most(ours[1], theirs[1], scale) if heaviest else 0.0,  # else it has none
        "inertia": most(ours[2], theirs[2], tensor or 1.0),
    }
