"""Rotations, poses and inertia tensors, for all but the proof, which has its own.

Plain Python on tuples: for one 3x3 product this is about three times as fast as numpy, and
importing numpy would cost more than a whole conversion.

Conventions
-----------
* ``Vec``: 3 floats, metres or a direction.
* ``Rot``: 9 floats, a rotation matrix row by row.  ``R`` takes coordinates in the rotated frame to
  coordinates in the frame that it is rotated from: ``v_parent = R v_child``.
* ``Sym``: 6 floats ``(xx, xy, xz, yy, yz, zz)``, a symmetric tensor, kg m^2.  The off-diagonal
  elements are the tensor's own (not the products of inertia with the other sign), as in URDF and
  in .mbs alike.
* Angles are in radians.
* ``Rx``, ``Ry``, ``Rz``: the elementary rotations about x, y and z.

Elements of matrices are named as in formulas: ``r12`` is row 1, column 2 of ``R``.
"""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from typing import NamedTuple, TypeVar

Vec = tuple[float, float, float]
Rot = tuple[float, float, float, float, float, float, float, float, float]
Sym = tuple[float, float, float, float, float, float]
#: A rotation about one coordinate axis: the axis (1, 2 or 3) and the angle in rad.
Turn = tuple[int, float]
#: Mass (kg), centre of mass (m) and inertia about it (kg m^2), all in one frame.
MassProperties = tuple[float, Vec, Sym]

_Components = TypeVar("_Components", Vec, Sym)

ZERO: Vec = (0.0, 0.0, 0.0)
IDENTITY: Rot = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
NO_INERTIA: Sym = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
#: Elements of a computed rotation up to this are rounding.
ROUNDING = 1e-12
#: A component of a unit axis up to this counts as zero; no other stated number is ever rounded.
ALIGNED = 1e-9


class Pose(NamedTuple):
    """The pose of a frame in another one: its origin (m) and its rotation."""

    xyz: Vec = ZERO
    rot: Rot = IDENTITY


#: The pose of a frame in itself.
HERE = Pose()


# --- rotations from and to angles ---


def from_rpy(rpy: Vec) -> Rot:
    """Compute the rotation of URDF's roll, pitch and yaw about fixed axes.

    ``R = Rz(yaw) Ry(pitch) Rx(roll)``.

    Args:
        rpy: Roll, pitch and yaw (rad).

    Returns:
        The rotation; exactly ``IDENTITY`` if all angles are zero.
    """
    if rpy == ZERO:
        return IDENTITY
    roll, pitch, yaw = rpy
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    row1 = (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr)
    row2 = (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr)
    row3 = (-sp, cp * sr, cp * cr)
    return (*row1, *row2, *row3)


def from_quaternion(x: float, y: float, z: float, w: float) -> Rot:
    """Compute the rotation of a quaternion of any length but zero; ``w`` is its real part."""
    length = hypot(x, y, z, w)
    x, y, z, w = x / length, y / length, z / length, w / length
    row1 = (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w))
    row2 = (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w))
    row3 = (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y))
    return (*row1, *row2, *row3)


def from_turn(turn: Turn) -> Rot:
    """Compute the elementary rotation of a turn: ``Rx``, ``Ry`` or ``Rz`` of its angle."""
    axis, angle = turn
    c, s = cos(angle), sin(angle)
    if axis == 1:
        return (1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
    if axis == 2:
        return (c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
    return (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def from_turns(turns: tuple[Turn, ...]) -> Rot:
    """Compute the product of turns, each about an axis of the frame rotated by those before."""
    rot = IDENTITY
    for turn in turns:
        rot = multiply(rot, from_turn(turn))
    return rot


def rpy_turns(rpy: Vec) -> tuple[Turn, ...]:
    """Return the rotation of ``from_rpy`` as turns about current axes.

    Roll, pitch and yaw about fixed axes are yaw, pitch and roll about current axes: this needs no
    formula, has no singularity, and keeps the very numbers that the URDF states.

    Args:
        rpy: Roll, pitch and yaw (rad).

    Returns:
        The turns of the angles that are not zero.
    """
    if rpy == ZERO:
        return ()
    roll, pitch, yaw = rpy
    return tuple((axis, angle) for axis, angle in ((3, yaw), (2, pitch), (1, roll)) if angle != 0.0)


def to_xyz_angles(rot: Rot) -> Vec:
    """Compute angles with ``R = Rx(alpha) Ry(beta) Rz(gamma)``.

    The method's formula divides two vanishing numbers at roll = +-90 deg.  This one is exact
    everywhere, beta = +-90 deg included, where only alpha plus or minus gamma is defined: gamma is
    read from ``Rx(-alpha) R``, so it fits any alpha.

    Returns:
        Alpha, beta and gamma (rad).
    """
    _, _, r13, r21, r22, r23, r31, r32, r33 = rot
    alpha = atan2(-r23, r33)
    beta = atan2(r13, hypot(r23, r33))
    ca, sa = cos(alpha), sin(alpha)
    gamma = atan2(ca * r21 + sa * r31, ca * r22 + sa * r32)
    return (alpha, beta, gamma)


# --- algebra ---


def multiply(a: Rot, b: Rot) -> Rot:
    """Compute the matrix product ``a b``: the rotation b, given in the frame a."""
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
    """Return the transpose of a rotation, which is its inverse."""
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = rot
    return (r11, r21, r31, r12, r22, r32, r13, r23, r33)


def rotate(rot: Rot, v: Vec) -> Vec:
    """Compute ``R v``: a vector of the rotated frame, in the axes of the frame around it."""
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = rot
    x, y, z = v
    return (r11 * x + r12 * y + r13 * z, r21 * x + r22 * y + r23 * z, r31 * x + r32 * y + r33 * z)


def add(a: Vec, b: Vec) -> Vec:
    """Compute the sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def dot(a: Vec, b: Vec) -> float:
    """Compute the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec, b: Vec) -> Vec:
    """Compute the vector product ``a x b``."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(axis: Vec) -> Vec:
    """Scale an axis to length 1, however long or short it is; it must not be zero."""
    x, y, z = axis
    # The square of a very long or short axis would overflow or vanish.
    largest = max(abs(x), abs(y), abs(z))
    x, y, z = x / largest, y / largest, z / largest
    length = hypot(x, y, z)
    return (x / length, y / length, z / length)


def direction(axis: Vec) -> Vec:
    """Scale an axis to length 1, and set its components up to ``ALIGNED`` to zero."""
    x, y, z = (0.0 if abs(component) <= ALIGNED else component for component in unit(axis))
    return (x, y, z)  # The length changes by less than its rounding, as 1 + 1e-18 is 1.


def compose(outer: Pose, inner: Pose) -> Pose:
    """Compute the product of two poses, ``outer inner``.

    Args:
        outer: Pose of a frame B in a frame A.
        inner: Pose of a frame C in B.

    Returns:
        Pose of C in A.
    """
    if outer is HERE:
        return inner
    return Pose(add(outer.xyz, rotate(outer.rot, inner.xyz)), multiply(outer.rot, inner.rot))


def inverse(pose: Pose) -> Pose:
    """Invert a pose: from the pose of a frame B in A, compute the pose of A in B."""
    rotation = transpose(pose.rot)
    x, y, z = rotate(rotation, pose.xyz)
    return Pose((-x, -y, -z), rotation)


# --- inertias ---


def rotate_inertia(rot: Rot, tensor: Sym) -> Sym:
    """Compute ``R T R^T``: a tensor of the rotated frame, in the axes of the frame around it."""
    if rot == IDENTITY:
        return tensor
    xx, xy, xz, yy, yz, zz = tensor
    full = multiply(multiply(rot, (xx, xy, xz, xy, yy, yz, xz, yz, zz)), transpose(rot))
    # Rounding makes the product slightly asymmetric.
    xy, xz, yz = (full[1] + full[3]) / 2, (full[2] + full[6]) / 2, (full[5] + full[7]) / 2
    return (full[0], xy, xz, full[4], yz, full[8])


def lump(parts: list[MassProperties]) -> MassProperties:
    """Compute the mass properties of rigid parts together, by Steiner's parallel-axis theorem.

    With r from the common centre of mass to that of a part of mass m and inertia I, the inertia is
    the sum of ``I + m (r.r E - r r^T)``, where E is the identity.

    Args:
        parts: The mass properties of each part, in one frame.

    Returns:
        Those of all, in this frame; the centre is the origin if the mass is zero.
    """
    if len(parts) == 1:
        return parts[0]
    total = cx = cy = cz = 0.0
    for mass, _, _ in parts:
        total += mass
    if total != 0.0:
        for mass, (x, y, z), _ in parts:
            cx, cy, cz = cx + mass * x / total, cy + mass * y / total, cz + mass * z / total
    xx = xy = xz = yy = yz = zz = 0.0
    for mass, (x, y, z), inertia in parts:
        x, y, z = x - cx, y - cy, z - cz
        xx += inertia[0] + mass * (y * y + z * z)
        xy += inertia[1] - mass * x * y
        xz += inertia[2] - mass * x * z
        yy += inertia[3] + mass * (x * x + z * z)
        yz += inertia[4] - mass * y * z
        zz += inertia[5] + mass * (x * x + y * y)
    return total, (cx, cy, cz), (xx, xy, xz, yy, yz, zz)


def drop_rounding(values: _Components) -> _Components:
    """Set computed components to zero that are only rounding.

    Args:
        values: The components of a vector, or of an inertia.

    Returns:
        The components, where those below ``ROUNDING`` times the largest one are 0.0.
    """
    limit = ROUNDING * max(map(abs, values))
    return tuple(0.0 if abs(value) < limit else value for value in values)  # type: ignore[return-value]


# --- rotations as turns about coordinate axes ---


def fewest_turns(rot: Rot, tolerance: float = ROUNDING) -> tuple[Turn, ...]:
    """Decompose a rotation into the fewest turns about current coordinate axes.

    * No turn: the identity.
    * One turn: an axis stays, so its row and its column are those of the identity.
    * Two turns, ``R_a R_b``: the element (a, b) is zero, with a and b different.  Then row a is
      that of ``R_b``, as ``R_a`` leaves axis a, and column b is that of ``R_a``.
    * Three turns otherwise: yaw, pitch, roll.

    Args:
        rot: The rotation.
        tolerance: An element or an angle (rad) up to this counts as zero.

    Returns:
        The turns, in their order.
    """
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = rot
    # One turn.
    if abs(r12) <= tolerance and abs(r13) <= tolerance and r11 > 0:
        return _turn_unless_zero(1, r32, r22, tolerance)
    if abs(r12) <= tolerance and abs(r32) <= tolerance and r22 > 0:
        return _turn_unless_zero(2, r13, r33, tolerance)
    if abs(r13) <= tolerance and abs(r23) <= tolerance and r33 > 0:
        return _turn_unless_zero(3, r21, r11, tolerance)
    # Two turns.
    if abs(r12) <= tolerance:
        return _turn_unless_zero(1, r32, r22, tolerance) + _turn_unless_zero(2, r13, r11, tolerance)
    if abs(r13) <= tolerance:
        first = _turn_unless_zero(1, -r23, r33, tolerance)
        return first + _turn_unless_zero(3, -r12, r11, tolerance)
    if abs(r21) <= tolerance:
        first = _turn_unless_zero(2, -r31, r11, tolerance)
        return first + _turn_unless_zero(1, -r23, r22, tolerance)
    if abs(r23) <= tolerance:
        return _turn_unless_zero(2, r13, r33, tolerance) + _turn_unless_zero(3, r21, r22, tolerance)
    if abs(r31) <= tolerance:
        return _turn_unless_zero(3, r21, r11, tolerance) + _turn_unless_zero(1, r32, r33, tolerance)
    if abs(r32) <= tolerance:
        first = _turn_unless_zero(3, -r12, r22, tolerance)
        return first + _turn_unless_zero(2, -r31, r33, tolerance)
    # Three turns.
    pitch = atan2(-r31, hypot(r11, r21))
    yaw = atan2(r21, r11)
    cy, sy = cos(yaw), sin(yaw)
    roll = atan2(sy * r13 - cy * r23, cy * r22 - sy * r12)
    return ((3, yaw), (2, pitch), (1, roll))


def _turn_unless_zero(axis: int, sine: float, cosine: float, tolerance: float) -> tuple[Turn, ...]:
    """Return the turn about a coordinate axis; none if its angle is up to the tolerance (rad)."""
    angle = atan2(sine, cosine)
    return ((axis, angle),) if abs(angle) > tolerance else ()


def axis_turns(axis: Vec) -> tuple[tuple[Turn, ...], int]:
    """Find turns that bring a coordinate axis onto the axis of a joint.

    The method's Table A.2, its last row corrected: ``-atan2(z, hypot(x, y))`` about y.

    Args:
        axis: The joint's axis, of any length; components up to ``ALIGNED`` count as zero.

    Returns:
        The turns (none, one or two), and the coordinate axis (1, 2 or 3) that they bring there.
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
