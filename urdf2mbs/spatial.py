"""Rotations, poses and inertia tensors: the only trigonometry of the project.

Plain Python on tuples: for one 3x3 product this is about three times as fast as
numpy, and importing numpy would cost more than a whole conversion.

Conventions
-----------
* ``Vec``: 3 floats, metres or a direction.
* ``Rot``: 9 floats, a rotation matrix row by row.  ``R`` takes coordinates in the
  turned frame to coordinates in the frame it is turned from: ``v_parent = R v_child``.
* ``Sym``: 6 floats ``(xx, xy, xz, yy, yz, zz)``, a symmetric tensor, kg m^2.  The
  off-diagonal elements are the tensor's own (not the products of inertia with the
  other sign), as in URDF and in .mbs alike.
* angles in radians.
"""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from typing import NamedTuple, TypeVar

Vec = tuple[float, float, float]
Rot = tuple[float, float, float, float, float, float, float, float, float]
Sym = tuple[float, float, float, float, float, float]
#: A turn about one coordinate axis: the axis (1, 2 or 3) and the angle in rad.
Turn = tuple[int, float]

_Numbers = TypeVar("_Numbers", Vec, Sym)

ZERO: Vec = (0.0, 0.0, 0.0)
IDENTITY: Rot = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
NO_INERTIA: Sym = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Pose(NamedTuple):
    """A frame seen from another one: its origin (m) and its rotation."""

    xyz: Vec = ZERO
    rot: Rot = IDENTITY


HERE = Pose()


def from_rpy(rpy: Vec) -> Rot:
    """URDF's fixed-frame roll, pitch, yaw: ``R = Rz(yaw) Ry(pitch) Rx(roll)``."""
    if rpy == ZERO:
        return IDENTITY
    r, p, y = rpy
    cr, sr, cp, sp, cy, sy = cos(r), sin(r), cos(p), sin(p), cos(y), sin(y)
    return (
        cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,
        sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
        -sp, cp * sr, cp * cr,
    )  # fmt: skip


def from_quaternion(x: float, y: float, z: float, w: float) -> Rot:
    """The rotation of a quaternion of any length but zero; w is its real part."""
    length = hypot(x, y, z, w)
    x, y, z, w = x / length, y / length, z / length, w / length
    return (
        1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
    )  # fmt: skip


def from_turn(turn: Turn) -> Rot:
    """The elementary rotation by an angle about x (1), y (2) or z (3)."""
    k, angle = turn
    c, s = cos(angle), sin(angle)
    if k == 1:
        return (1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
    if k == 2:
        return (c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
    return (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def from_turns(turns: tuple[Turn, ...]) -> Rot:
    """Turns one after the other, each about an axis of the frame turned so far."""
    rot = IDENTITY
    for turn in turns:
        rot = multiply(rot, from_turn(turn))
    return rot


def rpy_turns(rpy: Vec) -> tuple[Turn, ...]:
    """The same rotation as ``from_rpy``, as turns about current axes; zero angles left out.

    Fixed-frame roll, pitch, yaw are current-frame yaw, pitch, roll: no formula, no
    singularity, and the angles stay the very numbers that the URDF states.
    """
    if rpy == ZERO:
        return ()
    r, p, y = rpy
    return tuple((k, angle) for k, angle in ((3, y), (2, p), (1, r)) if angle != 0.0)


def to_xyz_angles(rot: Rot) -> Vec:
    """Angles (alpha, beta, gamma) with ``R = Rx(alpha) Ry(beta) Rz(gamma)``.

    The method's formula divides two vanishing numbers at roll = +-90 deg; this one is
    exact everywhere, beta = +-90 deg included: gamma is read off after alpha has been
    undone, so the two stay consistent where only their sum is defined.
    """
    _, _, r13, r21, r22, r23, r31, r32, r33 = rot
    alpha = atan2(-r23, r33)
    beta = atan2(r13, hypot(r23, r33))
    ca, sa = cos(alpha), sin(alpha)
    gamma = atan2(ca * r21 + sa * r31, ca * r22 + sa * r32)
    return (alpha, beta, gamma)


def multiply(a: Rot, b: Rot) -> Rot:
    """Matrix product ``a b``: the frame b, given in the frame a."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33 = a
    b11, b12, b13, b21, b22, b23, b31, b32, b33 = b
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
    )


def transpose(rot: Rot) -> Rot:
    """The inverse rotation."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33 = rot
    return (a11, a21, a31, a12, a22, a32, a13, a23, a33)


def rotate(rot: Rot, v: Vec) -> Vec:
    """``R v``: the vector v, given in the turned frame, seen from the outer one."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33 = rot
    x, y, z = v
    return (a11 * x + a12 * y + a13 * z, a21 * x + a22 * y + a23 * z, a31 * x + a32 * y + a33 * z)


def add(a: Vec, b: Vec) -> Vec:
    """The sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def dot(a: Vec, b: Vec) -> float:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec, b: Vec) -> Vec:
    """The vector product a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def compose(outer: Pose, inner: Pose) -> Pose:
    """The frame ``inner``, given in ``outer``, seen from where ``outer`` is given."""
    if outer is HERE:
        return inner
    return Pose(add(outer.xyz, rotate(outer.rot, inner.xyz)), multiply(outer.rot, inner.rot))


def inverse(pose: Pose) -> Pose:
    """The outer frame seen from the inner one."""
    back = transpose(pose.rot)
    x, y, z = rotate(back, pose.xyz)
    return Pose((-x, -y, -z), back)


def rotate_inertia(rot: Rot, tensor: Sym) -> Sym:
    """``R T R^T``: a tensor given in the turned frame, in the axes of the outer one."""
    if rot == IDENTITY:
        return tensor
    xx, xy, xz, yy, yz, zz = tensor
    full = multiply(multiply(rot, (xx, xy, xz, xy, yy, yz, xz, yz, zz)), transpose(rot))
    xy, xz, yz = (full[1] + full[3]) / 2, (full[2] + full[6]) / 2, (full[5] + full[7]) / 2
    return (full[0], xy, xz, full[4], yz, full[8])


def lump(parts: list[tuple[float, Vec, Sym]]) -> tuple[float, Vec, Sym]:
    """Mass (kg), centre (m) and inertia about it (kg m^2) of rigid parts, each given so, all
    in one frame: Steiner's parallel-axis theorem."""
    if len(parts) == 1:
        return parts[0]
    mass = cx = cy = cz = 0.0
    for m, _, _ in parts:
        mass += m
    if mass != 0.0:
        for m, (x, y, z), _ in parts:
            cx, cy, cz = cx + m * x / mass, cy + m * y / mass, cz + m * z / mass
    xx = xy = xz = yy = yz = zz = 0.0
    for m, (x, y, z), own in parts:
        x, y, z = x - cx, y - cy, z - cz
        xx += own[0] + m * (y * y + z * z)
        xy += own[1] - m * x * y
        xz += own[2] - m * x * z
        yy += own[3] + m * (x * x + z * z)
        yz += own[4] - m * y * z
        zz += own[5] + m * (x * x + y * y)
    return mass, (cx, cy, cz), (xx, xy, xz, yy, yz, zz)


#: Elements of a computed rotation up to this are rounding.
ROUNDING = 1e-12


def drop_rounding(values: _Numbers) -> _Numbers:
    """Computed components of a vector or an inertia; those that are only rounding are 0.0.

    Rounding is below ``ROUNDING`` times the largest component.
    """
    small = ROUNDING * max(map(abs, values))
    return tuple(0.0 if abs(c) < small else c for c in values)  # type: ignore[return-value]


def fewest_turns(rot: Rot, small: float = ROUNDING) -> tuple[Turn, ...]:
    """A rotation as the fewest turns about current coordinate axes.

    None for the identity; one if an axis stays; two, ``R_a R_b``, if the element (a, b)
    off the diagonal is zero (row a is then row a of ``R_b`` and column b is column b of
    ``R_a``); else yaw, pitch, roll.  Elements up to ``small`` count as zero.
    """
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = rot
    if abs(r12) <= small and abs(r13) <= small and r11 > 0:
        return _turn(1, r32, r22, small)
    if abs(r12) <= small and abs(r32) <= small and r22 > 0:
        return _turn(2, r13, r33, small)
    if abs(r13) <= small and abs(r23) <= small and r33 > 0:
        return _turn(3, r21, r11, small)
    if abs(r12) <= small:
        return _turn(1, r32, r22, small) + _turn(2, r13, r11, small)
    if abs(r13) <= small:
        return _turn(1, -r23, r33, small) + _turn(3, -r12, r11, small)
    if abs(r21) <= small:
        return _turn(2, -r31, r11, small) + _turn(1, -r23, r22, small)
    if abs(r23) <= small:
        return _turn(2, r13, r33, small) + _turn(3, r21, r22, small)
    if abs(r31) <= small:
        return _turn(3, r21, r11, small) + _turn(1, r32, r33, small)
    if abs(r32) <= small:
        return _turn(3, -r12, r22, small) + _turn(2, -r31, r33, small)
    pitch = atan2(-r31, hypot(r11, r21))
    yaw = atan2(r21, r11)
    cy, sy = cos(yaw), sin(yaw)
    roll = atan2(sy * r13 - cy * r23, cy * r22 - sy * r12)
    return ((3, yaw), (2, pitch), (1, roll))


def _turn(k: int, sine: float, cosine: float, small: float) -> tuple[Turn, ...]:
    angle = atan2(sine, cosine)
    return ((k, angle),) if abs(angle) > small else ()


#: A component of a unit axis up to this counts as zero; no other stated number is ever rounded.
ALIGNED = 1e-9


def axis_turns(axis: Vec) -> tuple[tuple[Turn, ...], int]:
    """The turns that bring a coordinate axis onto ``axis``, and which axis that is.

    The method's Table A.2, its last row corrected: ``-atan2(z, hypot(x, y))`` about y.
    """
    x, y, z = unit(axis)
    no_x, no_y, no_z = abs(x) <= ALIGNED, abs(y) <= ALIGNED, abs(z) <= ALIGNED
    if no_y and no_z:
        return (((3, pi),) if x < 0 else ()), 1
    if no_x and no_z:
        return (((1, pi),) if y < 0 else ()), 2
    if no_x and no_y:
        return (((2, pi),) if z < 0 else ()), 3
    if no_x:
        return ((1, atan2(z, y)),), 2
    if no_y:
        return ((2, atan2(x, z)),), 3
    if no_z:
        return ((3, atan2(y, x)),), 1
    return ((3, atan2(y, x)), (2, -atan2(z, hypot(x, y)))), 1


def unit(axis: Vec) -> Vec:
    """The axis at length 1, however long or short it was."""
    x, y, z = axis
    largest = max(abs(x), abs(y), abs(z))
    x, y, z = x / largest, y / largest, z / largest
    length = hypot(x, y, z)
    return (x / length, y / length, z / length)


def direction(axis: Vec) -> Vec:
    """The axis at length 1, its components up to ``ALIGNED`` taken as zero."""
    x, y, z = (0.0 if abs(c) <= ALIGNED else c for c in unit(axis))
    return (x, y, z)  # still of length 1: what was taken off is less than its rounding
