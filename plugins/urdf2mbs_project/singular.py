"""The joints that make the mass matrix singular: at every position, or at the initial one.

The mass matrix M of a tree is singular if some velocities of the independent joints, not all
zero, give no kinetic energy.  The usual reasons: a joint that moves nothing that has mass, a
joint that turns a point mass or a rod about its own axis, a floating base without mass.

A determinant cannot tell this from a very light finger on a heavy crane.  So each joint has its own
scale.  A joint without inertia moves nothing that has any, or turns what it moves about an axis
about which nothing has inertia, to rounding.  All other joints are eliminated one by one, from the
tips inwards (Cholesky's method, backwards).  A joint is singular if next to nothing is left of its
own inertia: then the regular joints behind it can move along so that nothing that has mass moves.
A follower counts as a part of its leader.

M is taken at the initial position, where a simulation starts.  A joint that is singular there
is tested at a general position, too, with fixed irregular values: det M is an analytic function of
the position, so it is zero everywhere or almost nowhere.  An inertia tensor with a negative moment
may make M singular where this test does not see it; the reader warns of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal, NamedTuple

import msgspec

from urdf2mbs.plugin import NO_INERTIA, ZERO, Body, Mbs

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array

#: A joint with no more than this part of its own inertia left is singular.  The angle 1.5708, for
#: example, is off 90 degrees by 3.7e-6, and M has the square of it.
LEFT = 1e-10
#: What an inertia about an axis may be off, relative to the moments of inertia about the base.
ROUNDING = 1e-13
#: An inertia up to this is none, relative to that of the same mass at the robot's size: some
#: exporters write 1e-35 where 0 is meant.
DUST = 1e-15
#: A speed up to this is none, each joint on its own scale; only for which joints move along.
CLEAR = 1e-6
#: The general position: multiples of the golden ratio, which are spread evenly.
GOLDEN = 0.6180339887498949


class Singular(msgspec.Struct):
    """A joint that can move without any kinetic energy."""

    joint: str
    why: Literal["moves-nothing", "no-inertia", "together"]
    """It moves nothing that has mass or inertia; or it alone acts in a direction in which what
    it moves has no inertia; or it does so together with others."""
    others: tuple[str, ...]
    """The joints behind it that must move along."""
    always: bool = True
    """At every position; else at the initial one."""


class Rule(NamedTuple):
    """A joint follows another: its position is ``multiplier`` times that of ``leader``, plus
    ``offset`` (rad or m)."""

    leader: str
    multiplier: float
    offset: float


def find_singular(mbs: Mbs, rules: Mapping[str, Rule] = {}) -> list[Singular]:
    """The joints that are singular; none of them if the mass matrix is regular.

    ``rules``: the joints that follow others, none of which follows another itself.
    """
    size, joints = size_of(mbs), mbs.joints()
    if _is_surely_regular(mbs, size):
        return []
    free = [name for name, joint in joints.items() if joint.nature != "driven"]
    moves = {name: {name: 1.0} for name in free if name not in rules}
    for name, (leader, multiplier, _) in rules.items():
        if leader in moves:
            moves[leader][name] = multiplier

    def at(values: dict[str, float]) -> list[Singular]:
        followed = {name: r.multiplier * values[r.leader] + r.offset for name, r in rules.items()}
        return singular_at(mbs, values | followed, moves, size)

    initial = {name: joint.q or 0.0 for name, joint in joints.items()}
    found = at(initial)
    if not found:
        return []
    spread = {name: 2.0 * (GOLDEN * k % 1.0) - 1.0 for k, name in enumerate(joints, start=1)}
    general = {name: spread[name] * (size if joints[name].type[0] == "T" else 1.0) for name in free}
    always = at(initial | general)
    known = {singular.joint for singular in always}
    at_start = [singular for singular in found if singular.joint not in known]
    for singular in at_start:
        singular.always = False
    return always + at_start


def size_of(mbs: Mbs) -> float:
    """A length (m) about as large as the robot."""
    lengths: list[float] = []
    for _, owner in mbs.base_and_bodies():
        lengths += getattr(owner, "com", None) or ZERO
        for point in owner.points:
            lengths += point.coordinates
    return max(map(abs, lengths), default=0.0) or 1.0


def _is_surely_regular(mbs: Mbs, size: float) -> bool:
    """Return True if the mass matrix is regular at once by what each body is, without numpy.

    Bodies between which nothing moves freely are one rigid body.  Take the free joint nearest to
    the base that has a speed: the rigid body behind it moves, and if one of its bodies resists all
    motion, there is kinetic energy.
    """
    rigid: dict[str | None, str | None] = {None: None}
    resists: dict[str | None, bool] = {}
    for body in mbs.bodies:
        moves = any(joint.nature != "driven" for joint in body.joints)
        rigid[body.name] = body.name if moves else rigid[body.parent]
        whole = rigid[body.name]
        resists[whole] = resists.get(whole, False) or _resists_all(body, size)
    resists.pop(None, None)
    return all(resists.values()) and all(map(_independent, mbs.bodies))


def _resists_all(body: Body, size: float) -> bool:
    """True if a body surely has mass, and inertia about every axis."""
    xx, xy, xz, yy, yz, zz = body.inertia or NO_INERTIA
    largest = max(map(abs, (xx, xy, xz, yy, yz, zz)))
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy)
    enough = abs(determinant) > LEFT * largest * largest * largest
    return bool(body.mass) and enough and largest > DUST * abs(body.mass or 0.0) * size * size


def _independent(body: Body) -> bool:
    """True if the joints before a body surely are independent: one, or a floating base at zero,
    whose shifts and turns are along and about the axes of one frame, each another."""
    moving = [joint.type for joint in body.joints if joint.nature != "driven"]
    return len(moving) <= 1 or (
        len(set(moving)) == len(moving) and not any(joint.q for joint in body.joints)
    )


def singular_at(
    mbs: Mbs, values: Mapping[str, float], moves: Mapping[str, Mapping[str, float]], size: float
) -> list[Singular]:
    """The singular ones of the free joints at one position (rad or m).

    ``moves``: how fast each joint moves while a free joint does so at speed 1, by the name of the
    free joint, from the base outwards; ``size`` is that of the robot (m).
    """
    import numpy as np

    from urdf2mbs_project.mass import Mass

    mass = Mass(mbs, values)
    joints = [placed.joint for placed in mass.placement.joints]
    row = {joint.name: k for k, joint in enumerate(joints)}
    free = sorted(moves, key=row.__getitem__)
    reduction = np.zeros((len(joints), len(free)))
    for k, name in enumerate(free):
        for other, speed in moves[name].items():
            reduction[row[other], k] = speed
    matrix = reduction.T @ mass.matrix @ reduction
    turns = np.array([joint.type[0] == "R" for joint in joints], float)
    moments = np.abs(mass.behind[:, [0, 1, 2], [0, 1, 2]]).sum(axis=1)
    dust = DUST * np.abs(mass.behind[:, 5, 5]) * size * size
    least = (reduction**2).T @ (turns * (ROUNDING * moments + dust))
    heavy = (reduction != 0.0).T @ np.abs(mass.behind).sum(axis=(1, 2)) > 0.0

    own = np.diag(matrix).copy()
    left = matrix.copy()
    regular: list[int] = []
    out: list[Singular] = []
    for k in reversed(range(len(free))):
        if own[k] > least[k] and left[k, k] > LEFT * own[k]:
            regular.append(k)
            left -= np.outer(left[:, k], left[k]) / left[k, k]
            continue
        why: Literal["moves-nothing", "no-inertia", "together"] = "moves-nothing"
        others: tuple[str, ...] = ()
        if heavy[k]:
            along = _along(matrix, own, k, regular) if own[k] > least[k] else []
            others = tuple(free[i] for i in sorted(along))
            why = "together" if others else "no-inertia"
        out.append(Singular(free[k], why, others))
    return out[::-1]


def _along(matrix: Array, own: Array, k: int, regular: list[int]) -> list[int]:
    """The regular joints that must move along with the singular joint ``k``."""
    import numpy as np

    scale = np.sqrt(own[regular])
    speeds = np.linalg.solve(
        matrix[np.ix_(regular, regular)] / np.outer(scale, scale),
        matrix[regular, k] / (scale * np.sqrt(own[k])),
    )
    return [i for i, speed in zip(regular, speeds, strict=True) if abs(speed) > CLEAR]
