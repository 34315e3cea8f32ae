"""The joints that make the mass matrix singular: at every position, or at the initial one.

The mass matrix M of a tree is singular if some velocities of the independent joints, not all
zero, give no kinetic energy.  The usual reasons: a joint that moves nothing that has mass, a
joint that turns a point mass or a rod about its own axis, a floating base without mass.

A determinant cannot tell this from a very light finger on a heavy crane.  So no inertia is
compared with another one here.  All that counts of a body is which wrenches it *resists*: the
range of its 6x6 inertia.  A body with mass resists forces at its centre of mass, and torques in
the range of its inertia tensor; so a point mass resists no torque, and a rod none about its axis.

Velocities give no energy if and only if no resisted wrench does work along its body's twist, as an
inertia is symmetric and positive semidefinite.  This is a linear system: a row for each resisted
wrench, a column for each joint.  M is singular if and only if a column depends on others.  From
the tips inwards, a joint is singular if its column depends on the columns of the regular joints
before it; these joints must move along.  **Couplings** (a joint follows another:
q_f = m q_l + b) are rows, too: qd_f - m qd_l = 0.

A body that resists all wrenches stands still in every motion without energy.  So the tree falls
apart there, and each part is a small system of its own; couplings hold the parts together.

This holds at one position.  det M is an analytic function of the position (sines, cosines and
polynomials), so it is zero everywhere or almost nowhere.  We test two positions:

* a general one, with fixed irregular values: if M is singular there, it is at every position
  (the exceptions have measure zero, and our values are none of them);
* the initial one, where a simulation starts: a stretched chain of point masses, for example,
  is singular there and nowhere near.

Both are tested twice: exactly, up to rounding, and up to ``NEARLY``, since the square of what
parallel axes are off by 1.5708 for 90 degrees is lost in doubles.

Other single positions are not tested: the 90 degrees of R2 in a floating base, for one.  An
inertia tensor with a negative moment may make M singular although all wrenches are resisted;
the reader warns of these.  Driven joints do not count: their rows are not solved for.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any, Literal, NamedTuple

import msgspec

from urdf2mbs.mbs.kinematics import Placement, place
from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs.spatial import NO_INERTIA, ZERO, Pose, compose

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
#: A part of more bodies is not tested: its system would take too much memory.
LARGEST = 500


class TooLargeError(Exception):
    """The robot has too many bodies, one after another, that do not resist all wrenches."""


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

    ``rules``: the joints that follow others, none of which follows another itself.  Raises
    TooLargeError.
    """
    if not any(body.mass or body.inertia for body in mbs.bodies):
        moving = [j.name for j in mbs.joints().values() if j.nature != "driven"]
        return [Singular(name, "moves-nothing", ()) for name in moving if name not in rules]
    size = _size(mbs)
    whole = {body.name for body in mbs.bodies if _resists_all(body, size)}
    parts: dict[str, list[Body]] = {}
    part_of: dict[str | None, str] = {}
    for body in mbs.bodies:
        apart = not rules and (body.parent is None or body.parent in whole)
        part_of[body.name] = body.name if apart else part_of.get(body.parent, "")
        parts.setdefault(part_of[body.name], []).append(body)
    doubtful = [
        bodies
        for bodies in parts.values()
        if not all(body.name in whole and _independent(body) for body in bodies)
    ]
    if not doubtful:
        return []
    if max(map(len, doubtful)) > LARGEST:
        raise TooLargeError
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
    positions = [(True, place(mbs, general)), (False, place(mbs, initial))]
    out: list[Singular] = []
    for small, (always, placement) in product((ROUNDING, NEARLY), positions):
        known = {singular.joint for singular in out}
        for bodies in doubtful:
            for singular in _singular(bodies, placement, size, rules, small):
                if singular.joint not in known:
                    singular.always, singular.nearly = always, small == NEARLY
                    out.append(singular)
    return out


def _size(mbs: Mbs) -> float:
    """A length (m) about as large as the robot."""
    lengths: list[float] = []
    for _, owner in mbs.owners():
        lengths += getattr(owner, "com", None) or ZERO
        for point in owner.points:
            lengths += point.coordinates
    return max(map(abs, lengths), default=0.0) or 1.0


def _has_inertia(body: Body, size: float) -> bool:
    largest = max(map(abs, body.inertia or NO_INERTIA))
    return largest > DUST * abs(body.mass or 0.0) * size * size


def _resists_all(body: Body, size: float) -> bool:
    """True if a body surely resists all wrenches."""
    xx, xy, xz, yy, yz, zz = body.inertia or NO_INERTIA
    largest = max(map(abs, (xx, xy, xz, yy, yz, zz)))
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy)
    enough = abs(determinant) > 10.0 * ROUNDING * largest * largest * largest
    return bool(body.mass) and enough and _has_inertia(body, size)


def _independent(body: Body) -> bool:
    """True if the joints before a body surely are independent: one, or a floating base at zero,
    whose shifts and turns are along and about the axes of one frame, each another."""
    moving = [joint.type for joint in body.joints if joint.nature != "driven"]
    return len(moving) <= 1 or (
        len(set(moving)) == len(moving) and not any(joint.q for joint in body.joints)
    )


def _resisted(body: Body, pose: Pose, size: float) -> Any:
    """The wrenches that a body resists, (k, 6): torque and force in the base's axes, at its origin,
    lengths relative to the robot's size."""
    import numpy as np

    wrenches = np.zeros((0, 6))
    if _has_inertia(body, size):
        xx, xy, xz, yy, yz, zz = body.inertia or NO_INERTIA
        moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        axes = np.reshape(pose.rot, (3, 3)) @ axes
        kept = np.abs(moments) > ROUNDING * np.abs(moments).max()
        wrenches = np.hstack([axes.T[kept], np.zeros((kept.sum(), 3))])
    if body.mass:
        centre = np.array(compose(pose, Pose(body.com or ZERO)).xyz) / size
        forces = np.hstack([np.cross(centre, np.eye(3)), np.eye(3)])
        wrenches = np.vstack([wrenches, forces])
    return wrenches


def _singular(
    bodies: list[Body], placement: Placement, size: float, rules: Mapping[str, Rule], small: float
) -> list[Singular]:
    """The singular joints of a part of the tree whose first body hangs on what stands still."""
    import numpy as np

    joints: list[Joint] = []
    twists: list[Any] = []
    ways: dict[str | None, list[int]] = {}
    for body in bodies:
        way = ways[body.name] = list(ways.get(body.parent, ()))
        first = placement.last[body.name] + 1 - len(body.joints)
        for placed in placement.joints[first : first + len(body.joints)]:
            if placed.joint.nature != "driven":
                way.append(len(joints))
                joints.append(placed.joint)
                turn, shift = map(np.array, placed.twist)
                twists.append(np.hstack([turn, shift / size if turn.any() else shift]))
    column = {joint.name: number for number, joint in enumerate(joints)}
    blocks: list[Any] = []
    heavy: set[int] = set()
    for body in bodies:
        wrenches = _resisted(body, placement.bodies[body.name], size)
        block = np.zeros((len(wrenches), len(joints)))
        for number in ways[body.name]:
            block[:, number] = wrenches @ twists[number]
        blocks.append(block)
        heavy.update(ways[body.name] if len(wrenches) else ())
    lengths = {joint.name: size if joint.type[0] == "T" else 1.0 for joint in joints}
    coupled = np.zeros((len(rules), len(joints)))
    for row, (follower, rule) in zip(coupled, rules.items(), strict=True):
        row[column[follower]] = lengths[follower]
        if rule.leader in column:
            row[column[rule.leader]] = -rule.multiplier * lengths[rule.leader]
        row /= np.abs(row).max()
    system = np.vstack([*blocks, coupled])

    regular: list[int] = []
    basis = np.zeros((len(system), 0))
    out: list[Singular] = []
    for number in reversed(range(len(joints))):
        rest = system[:, number]
        for _ in range(2):  # once more, for the digits that the first time has lost
            rest = rest - basis @ (basis.T @ rest)
        left = np.linalg.norm(rest)
        scale = np.linalg.norm(system[:, number])
        if left > small * scale and scale > small * np.linalg.norm(twists[number]):
            regular.insert(0, number)
            basis = np.column_stack([basis, rest / left])
            continue
        others: tuple[str, ...] = ()
        why: Literal["moves-nothing", "no-inertia", "together"] = "moves-nothing"
        if number in heavy:
            speeds = np.linalg.lstsq(system[:, regular], system[:, number], rcond=None)[0]
            others = tuple(
                joints[k].name for k, v in zip(regular, speeds, strict=True) if abs(v) > CLEAR
            )
            why = "together" if others else "no-inertia"
        out.insert(0, Singular(joints[number].name, why, others))
    return out
