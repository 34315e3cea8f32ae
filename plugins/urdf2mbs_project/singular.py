"""The joints that make the mass matrix singular: at every position, or at the initial one.

The mass matrix M of a tree is singular if some velocities u of the independent joints, not all
zero, give no kinetic energy: ``u' M u = 0``.  The usual causes are a joint that moves no body with
mass, a joint that turns a point mass or a rod about its own axis, and a floating base without mass.

A determinant cannot tell a singular matrix from that of a very light finger on a heavy crane.  So
each joint is compared with its own inertia ``M[k, k]``.  First, a joint is singular if this is
rounding only.  Then Cholesky's method eliminates the joints from the tips inwards::

    M = | M_inner   c |    joint k is regular if  d > 1e-10 M[k, k],  where d is left of M[k, k];
        |   c'      d |    then M_inner := M_inner - c c' / d

If less is left, the regular joints after k can move along with it so that no mass moves, and k is
singular.  A follower moves together with its leader, as one joint.

M is taken at the initial position, where a simulation starts.  A joint that is singular there is
also tested at a general position, with fixed irregular values: det M is an analytic function of
the position, so it is zero everywhere or almost nowhere.  An inertia tensor with a negative moment
may make M singular without being found here; the reader of the URDF warns of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import msgspec

from urdf2mbs.plugin import NO_INERTIA, ZERO, Body, Mbs, MbsJoint

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, MassModel

#: A joint with no more than this share of its inertia left is singular.  The angle 1.5708, for
#: example, is off 90 degrees by 3.7e-6, and M has the square of it.
MIN_SHARE_LEFT = 1e-10
#: The rounding of an inertia about an axis, relative to the moments of inertia about the base.
ROUNDING = 1e-13
#: An inertia up to this is zero, relative to that of the same mass at the size of the robot: some
#: exporters write 1e-35 for 0.
NEGLIGIBLE_INERTIA = 1e-15
#: A regular joint moves along with a singular one if its speed is above this, each joint scaled by
#: the square root of its inertia.
MIN_SPEED = 1e-6
#: The multiples of the golden ratio have fractional parts that are spread evenly; they are the
#: general position.
GOLDEN_RATIO = 0.6180339887498949

Cause = Literal["moves-nothing", "no-inertia", "together"]


class SingularJoint(msgspec.Struct, rename={"moves_with": "others"}):
    """A joint that can move without kinetic energy."""

    joint: str
    why: Cause
    """``moves-nothing``: no body that it moves has mass or inertia; ``no-inertia``: alone, it moves
    in a direction in which these bodies have no inertia; ``together``: together with others."""
    moves_with: tuple[str, ...]
    """The joints after it that must move along."""
    always: bool = True
    """True if it is singular at every position, else at the initial one only."""


class FollowerRule(NamedTuple):
    """The rule of a follower: its position is ``multiplier`` * that of ``leader`` + ``offset``."""

    leader: str
    multiplier: float
    offset: float
    """rad or m."""


def find_singular_joints(mbs: Mbs, rules: Mapping[str, FollowerRule] = {}) -> list[SingularJoint]:
    """Find the joints that make the mass matrix singular.

    Args:
        mbs: The model.
        rules: The rules of the joints that follow others; no leader is a follower.

    Returns:
        The singular joints: those at every position first; empty if the matrix is regular.
    """
    size, joints = estimate_size(mbs), mbs.joints()
    if _is_surely_regular(mbs, size):
        return []
    free = [name for name, joint in joints.items() if joint.nature != "driven"]
    speeds = {name: {name: 1.0} for name in free if name not in rules}
    for name, rule in rules.items():
        if rule.leader in speeds:
            speeds[rule.leader][name] = rule.multiplier

    initial = {name: joint.q or 0.0 for name, joint in joints.items()}
    at_start = find_singular_joints_at(mbs, _apply_rules(rules, initial), speeds, size)
    if not at_start:
        return []
    general = initial | _choose_general_position(joints, free, size)
    at_every_position = find_singular_joints_at(mbs, _apply_rules(rules, general), speeds, size)
    names = {singular.joint for singular in at_every_position}
    only_at_start = [singular for singular in at_start if singular.joint not in names]
    for singular in only_at_start:
        singular.always = False
    return at_every_position + only_at_start


def _apply_rules(
    rules: Mapping[str, FollowerRule], positions: Mapping[str, float]
) -> dict[str, float]:
    """Return positions (rad or m) in which all followers follow."""
    followers = {
        name: rule.multiplier * positions[rule.leader] + rule.offset for name, rule in rules.items()
    }
    return {**positions, **followers}


def _choose_general_position(
    joints: Mapping[str, MbsJoint], free: list[str], size: float
) -> dict[str, float]:
    """Choose irregular positions of the free joints: in (-1, 1) rad, or times the size (m)."""
    numbers = {name: spread(k) for k, name in enumerate(joints, start=1)}
    return {name: numbers[name] * (size if joints[name].type[0] == "T" else 1.0) for name in free}


def spread(k: Any) -> Any:
    """Return an irregular number from -1 to 1, always the same for an index or array of indices."""
    return 2.0 * (GOLDEN_RATIO * k % 1.0) - 1.0


def estimate_size(mbs: Mbs) -> float:
    """Return a length (m) about as large as the robot: the largest coordinate in the model."""
    lengths: list[float] = []
    for _, owner in mbs.base_and_bodies():
        lengths += getattr(owner, "com", None) or ZERO
        for point in owner.points:
            lengths += point.coordinates
    return max(map(abs, lengths), default=0.0) or 1.0


# --- without numpy ---


def _is_surely_regular(mbs: Mbs, size: float) -> bool:
    """Return True if the bodies alone show that the mass matrix is regular, without numpy.

    Bodies without a free joint between them are one rigid body.  Of the free joints with a speed,
    take the one nearest to the base: it moves a rigid body.  If a part of this resists all motion,
    there is kinetic energy.
    """
    rigid_body: dict[str | None, str | None] = {None: None}
    resists: dict[str | None, bool] = {}
    for body in mbs.bodies:
        is_free = any(joint.nature != "driven" for joint in body.joints)
        rigid_body[body.name] = body.name if is_free else rigid_body[body.parent]
        name = rigid_body[body.name]
        resists[name] = resists.get(name, False) or _resists_all_motion(body, size)
    resists.pop(None, None)
    return all(resists.values()) and all(map(_has_independent_joints, mbs.bodies))


def _resists_all_motion(body: Body, size: float) -> bool:
    """Return True if a body surely has mass, and inertia about every axis."""
    xx, xy, xz, yy, yz, zz = body.inertia or NO_INERTIA
    largest = max(map(abs, (xx, xy, xz, yy, yz, zz)))
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy)
    has_full_rank = abs(determinant) > MIN_SHARE_LEFT * largest * largest * largest
    negligible = NEGLIGIBLE_INERTIA * abs(body.mass or 0.0) * size * size
    return bool(body.mass) and has_full_rank and largest > negligible


def _has_independent_joints(body: Body) -> bool:
    """Return True if the joints before a body surely move it in independent directions.

    This is so for one joint, and for a floating base at zero: then its joints move it along and
    about the axes of one frame, each of them once.
    """
    types = [joint.type for joint in body.joints if joint.nature != "driven"]
    return len(types) <= 1 or (
        len(set(types)) == len(types) and not any(joint.q for joint in body.joints)
    )


# --- with numpy ---


class _Inertias(NamedTuple):
    """The inertias of the free joints, each with all joints that move with it."""

    matrix: Array
    """(m, m), the mass matrix."""
    rounding: Array
    """(m,), up to which an element of the diagonal is zero."""
    moves_mass: Array
    """(m,), True if the joint moves a body that has mass or inertia."""


def find_singular_joints_at(
    mbs: Mbs,
    positions: Mapping[str, float],
    speeds: Mapping[str, Mapping[str, float]],
    size: float,
) -> list[SingularJoint]:
    """Find the free joints that are singular at one position.

    Args:
        mbs: The model.
        positions: Positions of all joints (rad or m).
        speeds: For each free joint, the speeds of all joints while it moves at speed 1.
        size: The size of the robot (m), from ``estimate_size``.

    Returns:
        The singular joints, from the base outwards.
    """
    import numpy as np

    from urdf2mbs_project.mass import MassModel

    mass = MassModel(mbs, positions)
    index = {placed.joint.name: k for k, placed in enumerate(mass.placement.joints)}
    free = sorted(speeds, key=index.__getitem__)
    reduction = np.zeros((len(index), len(free)))
    for k, name in enumerate(free):
        for moving_joint, speed in speeds[name].items():
            reduction[index[moving_joint], k] = speed

    inertias = _compute_inertias(mass, reduction, size)
    diagonal = np.diag(inertias.matrix).copy()
    remainder = inertias.matrix.copy()
    regular: list[int] = []
    singular_joints: list[SingularJoint] = []
    for k in reversed(range(len(free))):
        has_inertia = diagonal[k] > inertias.rounding[k]
        if has_inertia and remainder[k, k] > MIN_SHARE_LEFT * diagonal[k]:
            regular.append(k)
            remainder -= np.outer(remainder[:, k], remainder[k]) / remainder[k, k]
            continue
        cause: Cause = "moves-nothing"
        moves_with: tuple[str, ...] = ()
        if inertias.moves_mass[k]:
            moving = _find_joints_moving_along(inertias.matrix, k, regular) if has_inertia else []
            moves_with = tuple(free[i] for i in sorted(moving))
            cause = "together" if moves_with else "no-inertia"
        singular_joints.append(SingularJoint(free[k], cause, moves_with))
    return singular_joints[::-1]


def _compute_inertias(mass: MassModel, reduction: Array, size: float) -> _Inertias:
    """Compute the inertias of the free joints, and their rounding.

    Args:
        mass: The mass matrix (n, n) of all joints.
        reduction: (n, m), the speeds of all joints by those of the free ones.
        size: The size of the robot (m).
    """
    import numpy as np

    composite = mass.composite_inertias
    is_revolute = np.array([placed.joint.type[0] == "R" for placed in mass.placement.joints], float)
    moments = np.abs(composite[:, [0, 1, 2], [0, 1, 2]]).sum(axis=1)
    negligible = NEGLIGIBLE_INERTIA * np.abs(composite[:, 5, 5]) * size * size
    rounding = (reduction**2).T @ (is_revolute * (ROUNDING * moments + negligible))
    moves_mass = (reduction != 0.0).T @ np.abs(composite).sum(axis=(1, 2)) > 0.0
    return _Inertias(reduction.T @ mass.matrix @ reduction, rounding, moves_mass)


def _find_joints_moving_along(matrix: Array, k: int, regular: list[int]) -> list[int]:
    """Find the regular joints that must move along with the singular joint k.

    Their velocities v solve ``M_rr v = M_rk``, each joint scaled to unit inertia.
    """
    import numpy as np

    diagonal = np.diag(matrix)
    scale = np.sqrt(diagonal[regular])
    velocities = np.linalg.solve(
        matrix[np.ix_(regular, regular)] / np.outer(scale, scale),
        matrix[regular, k] / (scale * np.sqrt(diagonal[k])),
    )
    return [i for i, speed in zip(regular, velocities, strict=True) if abs(speed) > MIN_SPEED]
