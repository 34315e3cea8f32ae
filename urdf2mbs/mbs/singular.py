"""The joints that make the mass matrix singular: at every position, or at the initial one.

The mass matrix M of a tree is singular if some velocities of the independent joints, not all
zero, give no kinetic energy.  The usual reasons: a joint that moves nothing that has mass, a
joint that turns a point mass or a rod about its own axis, a floating base without mass.

A determinant cannot tell this from a very light finger on a heavy crane.  So no inertia is
compared with another one here.  All that counts of a body is which wrenches it *resists*, F(b):
the range of its 6x6 inertia.  A body with mass resists forces at its centre of mass, and
torques in the range of its inertia tensor; so a point mass resists no torque, and a rod none
about its axis.  From the tips inwards, for each joint with the motion S (a twist):

* F, what is resisted behind the joint, is the sum of what the body there resists and of what
  each joint that it carries passes on;
* the joint is singular if no wrench in F does work along S: f . S = 0 for all f in F;
* it passes on the wrenches in F that do no work along S.

**M is singular if and only if this test finds a singular joint.** Let W be the twists of a body
for which its branch can be moved without kinetic energy, if the velocities of the joints behind
it are chosen to suit.  We show W = F' (the complement of F: the twists on which all of F does no
work), by induction from the tips.  The body has no energy if its twist V is in the null space of
its inertia, the complement of its range, as the inertia is symmetric and positive semidefinite.
A child's twist is V + S qd, so its branch has no energy for some qd if V is in W_c + span S,
which is F_c' + span S by assumption: the complement of those f in F_c with f . S = 0.  V must be
in all of these, and the intersection of complements is the complement of the sum.  Now let
velocities without energy be given, and take a joint that moves and has no moving joint before it:
its twist S qd is in W = F', so it is singular.  Conversely, if S is in F' = W for a joint, its
motion costs no energy, with suitable motions of the joints behind it and none elsewhere.

This holds at one position.  det M is an analytic function of the position (sines, cosines and
polynomials), so it is zero everywhere or almost nowhere.  We test two positions:

* a general one, with fixed irregular values: if M is singular there, it is at every position
  (the exceptions have measure zero, and our values are none of them);
* the initial one, where a simulation starts: a stretched chain of point masses, for example,
  is singular there and nowhere near.

**Couplings** (a joint follows another: q_f = m q_l + b) leave fewer velocities, so that M can only
become regular by them.  The velocities without energy that belong to the singular joints are a
basis of all there are: each has the speed 1 of its own joint, and 0 of the other singular ones.
What remains are the combinations that obey qd_f = m qd_l, a system with an unknown for each
singular joint.

Both are tested twice: exactly, up to rounding, and up to ``NEARLY``, since the square of what
parallel axes are off by 1.5708 for 90 degrees is lost in doubles.

Other single positions are not tested: the 90 degrees of R2 in a floating base, for one.  An
inertia tensor with a negative moment may make M singular although all wrenches are resisted;
the reader warns of these.  Driven joints do not count: their rows are not solved for.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice, product
from math import sqrt
from typing import Literal, NamedTuple

import msgspec

from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs.spatial import NO_INERTIA, ZERO, Pose, Vec, compose, cross, rotate

#: A wrench (torque, force) or a twist (angular velocity, velocity of the point at the origin),
#: in the base's axes, lengths relative to the robot's size.
Six = tuple[float, float, float, float, float, float]

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ALL: list[Six] = [(*axis, *ZERO) for axis in AXES] + [(*ZERO, *axis) for axis in AXES]
#: What a computed zero may be off, relative to the robot's size, or to the largest moment.
ROUNDING = 1e-11
#: Up to this a number counts as nearly zero, as M has its square.  The angle 1.5708, for example,
#: is off 90 degrees by 3.7e-6.
NEARLY = 1e-5
#: An inertia up to this is none, relative to that of the same mass at the robot's size: some
#: exporters write 1e-35 where 0 is meant.
DUST = 1e-15
#: A computed speed up to this is none; only for which joints move along.
CLEAR = 1e-9
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
    nearly: bool = False
    """Only up to ``NEARLY``: as good as singular in doubles."""


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
    size = _size(mbs)
    whole = {body.name for body in mbs.bodies if body.mass and len(_torques(body, size)) == 3}
    if all(body.name in whole and _independent(body) for body in mbs.bodies):
        return []
    numbers = mbs.numbers()
    initial: dict[str, float] = {}
    general: dict[str, float] = {}
    for body in mbs.bodies:
        for joint in body.joints:
            initial[joint.name] = general[joint.name] = joint.q or 0.0
            if joint.nature != "driven":
                spread = 2.0 * (GOLDEN * numbers[joint.name] % 1.0) - 1.0
                general[joint.name] = spread * (size if joint.type[0] == "T" else 1.0)
    for values in (initial, general):
        for name, rule in rules.items():
            values[name] = rule.multiplier * values[rule.leader] + rule.offset
    # what is singular is nearly singular, too
    doubtful = [
        values for values in (general, initial) if _Position(mbs, values, size, whole, NEARLY).found
    ]
    out: list[Singular] = []
    for small, values in product((ROUNDING, NEARLY), doubtful):
        known = {singular.joint for singular in out}
        for singular in _Position(mbs, values, size, whole, small).singular(rules):
            if singular.joint not in known:
                singular.always, singular.nearly = values is general, small == NEARLY
                out.append(singular)
    return out


def _independent(body: Body) -> bool:
    """True if the joints before a body surely are independent: one, or a floating base at zero,
    whose shifts and turns are along and about the axes of one frame, each another."""
    moving = [joint.type for joint in body.joints if joint.nature != "driven"]
    return len(moving) <= 1 or (
        len(set(moving)) == len(moving) and not any(joint.q for joint in body.joints)
    )


class _Position:
    """The robot at one position: the twists of its joints, and the wrenches that the inertia behind
    each resists."""

    def __init__(
        self, mbs: Mbs, values: Mapping[str, float], size: float, whole: set[str], small: float
    ) -> None:
        self._small = small
        self._size = size
        self._bodies = mbs.bodies
        self._twists: dict[str, list[tuple[Joint, Six]]] = {}
        self._behind: dict[str, list[Six]] = {}
        """For each joint, an orthonormal basis of F, what is resisted behind it."""
        self.found: list[tuple[str, str]] = []
        """The singular joints and their bodies, from the tips inwards."""
        placement = place(mbs, values)
        joints = iter(placement.joints)
        for body in mbs.bodies:
            self._twists[body.name] = [
                (placed.joint, _scaled(placed.twist, size))
                for placed in islice(joints, len(body.joints))
                if placed.joint.nature != "driven"
            ]
        passed: dict[str | None, list[Six]] = {body.name: [] for body in mbs.bodies}
        passed[None] = []
        for body in reversed(mbs.bodies):
            if body.name in whole:
                felt = ALL
            else:
                own = _resisted(body, placement.bodies[body.name], size)
                felt = _basis(own + passed[body.name], small)
            for joint, twist in reversed(self._twists[body.name]):
                self._behind[joint.name] = felt
                most = max(felt, key=lambda f: abs(_work(f, twist)), default=None)
                if most is None or abs(_work(most, twist)) <= small * _length(twist):
                    self.found.append((body.name, joint.name))
                elif joint is not self._twists[body.name][0][0] or body.parent not in whole:
                    rest = [f for f in felt if f is not most]
                    share = _work(most, twist)
                    felt = _basis([_minus(f, _work(f, twist) / share, most) for f in rest], small)
            if body.parent not in whole:
                passed[body.parent] += felt

    def singular(self, rules: Mapping[str, Rule]) -> list[Singular]:
        out: list[Singular] = []
        for joint, speeds in self._free(rules).items():
            others = tuple(name for name in speeds if name != joint)
            why: Literal["moves-nothing", "no-inertia", "together"] = "no-inertia"
            if not self._behind[joint]:
                why, others = "moves-nothing", ()
            elif others:
                why = "together"
            out.append(Singular(joint, why, others))
        return out

    def _free(self, rules: Mapping[str, Rule]) -> dict[str, dict[str, float]]:
        """The speeds of a motion without energy that obeys the rules, for each joint that is
        singular (lengths relative to the robot's size)."""
        motions = {
            joint: {joint: 1.0, **self._moving_along(body, joint)}
            for body, joint in reversed(self.found)
        }
        length = {
            joint.name: self._size if joint.type[0] == "T" else 1.0
            for twists in self._twists.values()
            for joint, _ in twists
        }
        # Gaussian elimination: each rule takes the joint that breaks it the most out of the rest
        for follower, rule in rules.items():
            m = rule.multiplier * length.get(rule.leader, 1.0) / length[follower]
            off = {
                joint: speeds.get(follower, 0.0) - m * speeds.get(rule.leader, 0.0)
                for joint, speeds in motions.items()
            }
            taken = max(off, key=lambda joint: abs(off[joint]), default="")
            if not taken or abs(off[taken]) <= CLEAR * max(1.0, abs(m)):
                continue
            pivot = motions.pop(taken)
            for joint, speeds in motions.items():
                share = off[joint] / off[taken]
                for name, speed in pivot.items() if share else ():
                    speeds[name] = speeds.get(name, 0.0) - share * speed
        return {
            joint: {name: speed for name, speed in speeds.items() if abs(speed) > CLEAR}
            for joint, speeds in motions.items()
        }

    def _moving_along(self, body: str, joint: str) -> dict[str, float]:
        """The joints behind a singular one that undo its motion, with their speeds."""
        still: Six = (*ZERO, *ZERO)
        moving: dict[str, float] = {}
        twists: dict[str | None, Six] = {}
        for each in self._bodies:
            if each.name != body and each.parent not in twists:
                continue
            twist = twists.get(each.parent, still)
            for own, along in self._twists[each.name]:
                if own.name == joint:
                    twist = along
                elif twist != still and self._behind[own.name]:
                    # the wrenches resisted here must do no work
                    f = max(self._behind[own.name], key=lambda f: abs(_work(f, along)))
                    share = _work(f, along)
                    if abs(share) > self._small * _length(along):
                        speed = _work(f, twist) / share
                        if abs(speed) > CLEAR * _length(twist):
                            moving[own.name] = -speed
                        twist = _minus(twist, speed, along)
                        if _length(twist) <= CLEAR:
                            twist = still
            if twist != still:
                twists[each.name] = twist
        return moving


def _size(mbs: Mbs) -> float:
    """A length (m) about as large as the robot."""
    lengths: list[float] = []
    for body in mbs.bodies:
        lengths += body.com or ZERO
    for _, owner in mbs.owners():
        for point in owner.points:
            lengths += point.coordinates
    return max(map(abs, lengths), default=0.0) or 1.0


def _scaled(twist: tuple[Vec, Vec], size: float) -> Six:
    """Lengths relative to the robot's size; the speed of a shift stays 1."""
    turn, (x, y, z) = twist
    return (*turn, x / size, y / size, z / size) if turn != ZERO else (*ZERO, x, y, z)


def _torques(body: Body, size: float) -> list[Vec]:
    """An orthonormal basis of the torques (in body axes) that a body resists."""
    xx, xy, xz, yy, yz, zz = body.inertia or NO_INERTIA
    largest = max(map(abs, (xx, xy, xz, yy, yz, zz)))
    if largest <= DUST * abs(body.mass or 0.0) * size * size:
        return []
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy)
    # the last step below is at least a third of the determinant
    if abs(determinant) > 10.0 * ROUNDING * largest * largest * largest:
        return list(AXES)
    columns = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    basis = _basis([(x / largest, y / largest, z / largest, *ZERO) for x, y, z in columns])
    return [(x, y, z) for x, y, z, *_ in basis]


def _resisted(body: Body, pose: Pose, size: float) -> list[Six]:
    """The wrenches that a body resists by itself."""
    out: list[Six] = [(*rotate(pose.rot, torque), *ZERO) for torque in _torques(body, size)]
    if body.mass:
        x, y, z = compose(pose, Pose(body.com or ZERO)).xyz
        centre = (x / size, y / size, z / size)
        out += [(*cross(centre, axis), *axis) for axis in AXES]
    return out


def _basis(vectors: list[Six], small: float = ROUNDING) -> list[Six]:
    """An orthonormal basis of what the vectors span, by Gram and Schmidt, the longest first."""
    out: list[Six] = []
    left = [v for v in vectors if v != (*ZERO, *ZERO)]
    while left and len(out) < 6:
        longest = max(left, key=_length)
        length = _length(longest)
        if length <= small:
            break
        a, b, c, d, e, f = longest
        unit = (a / length, b / length, c / length, d / length, e / length, f / length)
        for done in out:  # once more, for the digits that the first time has lost
            unit = _minus(unit, _work(done, unit), done)
        out.append(unit)
        left = [_minus(v, _work(unit, v), unit) for v in left if v is not longest]
    return out


def _work(one: Six, two: Six) -> float:
    a, b, c, d, e, f = one
    p, q, r, s, t, u = two
    return a * p + b * q + c * r + d * s + e * t + f * u


def _length(v: Six) -> float:
    a, b, c, d, e, f = v
    return sqrt(a * a + b * b + c * c + d * d + e * e + f * f)


def _minus(v: Six, factor: float, other: Six) -> Six:
    a, b, c, d, e, f = v
    p, q, r, s, t, u = other
    return (
        a - factor * p, b - factor * q, c - factor * r,
        d - factor * s, e - factor * t, f - factor * u,
    )  # fmt: skip
