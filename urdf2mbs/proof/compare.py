"""Is an .mbs the same robot as a URDF?  The proof, by a second route.

The .mbs is walked joint by joint, each an elementary shift or turn along a current axis; the
URDF by Rodrigues' formula, with quaternions for its roll, pitch and yaw.  Neither shares a line
with the passes, nor with ``spatial``.

What is compared are the *rigid groups*: all that no moving joint separates.

* Motion: at several random positions, zero included, each group must stand on the group before
  it where its counterpart stands, up to one constant pose between a group and its counterpart.
  Every pose in the world is a product of these.  So the place at zero is compared, and then
  how the joint goes on from there, seen from the group that it moves.
* Inertia: seen through that constant pose, mass, centre and inertia must be equal.
* Frames: each link's frame, and the anchor point of its name, must be where they are said to be.

Why this suffices: where the same inertias move the same way at every position, the kinetic
energy is the same function of positions and velocities, and with equal gravity so is the
potential energy; Lagrange's equations, hence the equations of motion, are then the same.
A joint's pose is a product of sines and cosines of its position, so two that agree at random
positions but differ elsewhere have probability zero.

Everything is relative to its own scale: a shift to the reach of the two groups it is between, a
mass to that mass, an inertia to that inertia.  So a finger's error counts on a crane.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import lru_cache, partial
from math import atan2, dist, hypot, log10, pi
from random import Random
from typing import Any

import msgspec

from urdf2mbs.conversion import Compared, LinkFrame
from urdf2mbs.mbs.model import Body, Mbs, UserModel
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.messages.diagnostics import Difference, counted
from urdf2mbs.proof.coordinates import coordinates
from urdf2mbs.proof.groups import Group, Side
from urdf2mbs.proof.mbs_side import mbs_side
from urdf2mbs.proof.parameters import compare_parameters
from urdf2mbs.proof.rigid import (
    HERE,
    ORIGIN,
    UNTURNED,
    Frame,
    Inertia,
    about,
    across,
    angle,
    between_axes,
    compose,
    cross,
    distance,
    dot,
    inertias_apart,
    inverse,
    merge,
    most,
    moved,
    seen,
    shift,
    spin,
    turned,
    worst,
)
from urdf2mbs.proof.urdf_side import carriers, urdf_side
from urdf2mbs.spatial import Vec, fewest_turns
from urdf2mbs.urdf.model import Robot

#: What a difference must exceed to count, relative to the scale of what is compared.
TOLERANCE = 1e-9
#: Positions at which the motion is compared, zero included.
POSITIONS = 4
_RANDOM = Random(20)
#: These positions but zero.  Each joint is compared by itself, so all can have the same ones.
AMOUNTS = [_RANDOM.uniform(-pi, pi) for _ in range(POSITIONS - 1)]


class Comparison(msgspec.Struct):
    """What ``compare`` found."""

    differences: list[Difference]
    """By size, the largest first."""
    frames: list[Difference]
    """Link frames that are elsewhere in the .mbs; a matter of convention, not of physics."""
    largest: dict[str, float]
    """The largest relative deviation of each kind, differences or not."""
    groups: int
    """Rigid groups, the ground among them."""
    urdf_mass: float
    """kg, of all that can move."""
    mbs_mass: float
    """kg, of all that can move."""
    but_for: dict[str, str]
    """What is not as in the URDF, known, and no difference by itself: each thing, and why."""
    not_compared: dict[str, str]
    """What Robotran reads and nothing here compares: each thing, and why."""
    compared: list[Compared]
    """Group by group, the ground left out."""
    positions: int = POSITIONS

    @property
    def same(self) -> bool:
        return not self.differences


def compare(
    robot: Robot,
    mbs: Mbs,
    joints: Mapping[str, Sequence[str]],
    *,
    frames: Mapping[str, LinkFrame] | None = None,
    frozen: Mapping[str, str] | None = None,
    orders: Mapping[str, tuple[str, ...]] | None = None,
    weightless: Collection[str] = (),
    driven: Collection[str] = (),
    models: Sequence[UserModel] | None = None,
    gravity: Vec = (0.0, 0.0, -9.81),
    tolerance: float = TOLERANCE,
) -> Comparison:
    """Compare a URDF with an .mbs.

    ``joints`` maps each moving URDF joint to the .mbs joints that move with its coordinates
    (one; three of a planar joint: two shifts and the turn; six of a floating one: T1 T2 T3 R1
    R2 R3, or as ``orders`` has them).  ``frames`` says where link frames are meant to be, as far
    as that is known; without it only the physics is compared.  ``frozen`` joints are held at
    zero on the URDF's side; those of them that are ``weightless`` may move no mass.  ``driven``
    are the .mbs joints that are driven on purpose, though the URDF has them follow others;
    ``models`` the user models as they should be, where that is known.
    """
    frozen, orders = frozen or {}, orders or {}
    known = coordinates(robot, mbs, joints, frozen, orders, driven)
    more, missing, not_compared = compare_parameters(robot, mbs, joints, frozen, models)
    framed = {at.joint for at in (frames or {}).values() if at.joint is not None}
    comparing = Comparing(
        urdf_side(robot, known.names, known.held, orders),
        mbs_side(mbs, set(known.names.values()), framed),
        known.names, {joint.name: joint.child for joint in robot.joints.values()},
        tolerance, frames=frames, bodies=mbs.bodies,
    )  # fmt: skip
    comparing.found += [*known.differences, *more, *_heavy(robot, weightless)]
    comparing.compare_gravity(gravity, mbs.base.gravity)
    comparing.compare_groups()
    comparing.compare_frames()
    comparing.compare_points(mbs)
    return comparing.comparison(
        (urdf_mass(robot), mbs_mass(mbs)),
        {f"joint '{name}'": f"held at zero: {why}" for name, why in frozen.items()}
        | known.but_for | missing,
        known.not_compared | not_compared,
    )  # fmt: skip


def _heavy(robot: Robot, weightless: Collection[str]) -> list[Difference]:
    """What is left out as moving nothing that has mass, and moves what has mass."""
    useful = carriers(robot) if weightless else set()
    return [
        Difference(
            "joint-missing", f"joint '{name}' is left out, and it moves what has mass",
            link=robot.joints[name].child, joint=name,
        )
        for name in weightless
        if robot.joints[name].child in useful
    ]  # fmt: skip


_Move = Callable[[float], Frame]


class _Moves(msgspec.Struct, frozen=True, gc=False):
    """How a joint goes on from where it stands, at the random positions."""

    frames: list[tuple[Frame, Frame]]
    """Ours and theirs."""
    apart: float
    """How far they are apart, the largest, if both groups have the same frame."""


@lru_cache(maxsize=256)
def _moves(ours: _Move, theirs: _Move, far: float) -> _Moves:
    """The motions of two joints: most turn about the same few axes, so they are kept.  ``far`` is
    what an amount of 1 stands for: 1 rad for a turn, the groups' scale (m) for a shift."""
    frames = [(ours(far * q), theirs(far * q)) for q in AMOUNTS]
    return _Moves(frames, max(distance(a, b, far) for a, b in frames))


class _Pair(msgspec.Struct, gc=False):
    """A group of the URDF and its counterpart in the .mbs, and where their joints stand, both
    seen from the .mbs's parent group."""

    ours: Group
    theirs: Group
    our_before: Frame
    their_before: Frame
    our_inertia: Inertia
    their_inertia: Inertia
    scale: float
    """m."""
    carried: Callable[[], list[tuple[Group, Group]]]
    """Gives the groups that hang on them."""
    moves: _Moves

    def placed(self) -> Frame:
        """Our group's pose in theirs, by where the joints put both at zero."""
        if self.our_before == self.their_before:
            return HERE
        return compose(inverse(self.their_before), self.our_before)

    def motion(self, at: Frame) -> float:
        """How far the motions are apart, if ``at`` is our group's pose in theirs: where the groups
        are at zero, and how each goes on from there, seen from itself."""
        off = distance(compose(self.their_before, at), self.our_before, self.scale)
        if at is HERE:
            return max(off, self.moves.apart)
        for ours, theirs in self.moves.frames:
            off = max(off, distance(compose(theirs, at), compose(at, ours), self.scale))
        return off

    def inertia(self, at: Frame) -> dict[str, float]:
        ours = self.our_inertia if at is HERE else seen(self.our_inertia, at)
        return inertias_apart(ours, self.their_inertia, self.scale)

    def misfits(self, at: Frame) -> list[float]:
        """How far each thing that the groups have is apart, if ``at`` is so: the axis of their
        joint, what they weigh, and the axes of the joints that they carry."""
        ours, theirs = self.ours, self.theirs
        found = [
            between_axes(at, ours.axis, HERE, theirs.axis, ours.turns, self.scale),
            *self.inertia(at).values(),
        ]
        for mine, other in self.carried():
            before = compose(at, mine.before)
            found.append(
                between_axes(before, mine.axis, other.before, other.axis, mine.turns, self.scale)
            )
        return found


class Comparing:
    """One comparison in the making, of two sides whose groups are matched."""

    def __init__(
        self,
        one: Side,
        two: Side,
        names: Mapping[str, str],
        children: Mapping[str, str],
        tolerance: float,
        *,
        called: tuple[str, str, str] = ("the URDF", "the .mbs", "link"),
        frames: Mapping[str, LinkFrame] | None = None,
        bodies: Sequence[Body] = (),
    ) -> None:
        """``names`` maps the coordinates that move on both sides, ``children`` each joint to the
        link (URDF) or body that it moves.  ``called`` is how messages call the two sides, and what
        a part of them is; ``bodies`` are those of the second side, if it is an .mbs.
        """
        self.one, self.two = one, two
        self.children = children
        self.tolerance = tolerance
        self.called = called
        self.frames = frames or {}
        self.bodies = bodies
        self.hanging: dict[int, list[tuple[Group, Group]]] | None = None
        self.found: list[Difference] = []
        self.elsewhere: list[Difference] = []
        self.compared: list[Compared] = []
        self.largest = {"gravity": 0.0, "motion": 0.0, "mass": 0.0, "centre": 0.0, "inertia": 0.0}
        if frames is not None:
            self.largest["frame"] = 0.0
        #: Each group's counterpart, parents first: there is one for each.
        self.pairs = [0, *[two.created[names[own]] for own in one.created]]
        size = max(group.reach for side in (one, two) for group in side.groups)
        #: m; a joint at the very place of the one before it has the rounding of what is there.
        floor = 1e-4 * size or 1.0
        #: m, of each pair of groups.
        self.scales = [
            max(ours.reach, two.groups[other].reach) + floor
            for ours, other in zip(one.groups, self.pairs, strict=True)
        ]
        #: Each group's pose in its counterpart.
        self.apart: list[Frame] = [HERE] * len(one.groups)

    def _differ(self, kind: str, message: str, size: float = 1.0, **more: Any) -> None:
        self.found.append(Difference(kind, message, min(size, 1.0), **more))

    def _beyond(self, off: float) -> bool:
        """Whether a deviation is a difference; so is one that is not a number."""
        return not off <= self.tolerance

    def compare_gravity(self, ours: Vec, theirs: Vec) -> None:
        off = most(ours, theirs, max(map(abs, (*ours, *theirs))) or 1.0)
        self.largest["gravity"] = off
        if self._beyond(off):
            said = f"gravity is {_short(theirs)}, and should be {_short(ours)} m/s^2"
            self._differ("gravity", said, off, urdf=ours, mbs=theirs)

    def comparison(
        self, masses: tuple[float, float], but_for: dict[str, str], not_compared: dict[str, str]
    ) -> Comparison:
        """What came of it; ``masses`` (kg) are of all that can move on the two sides."""
        for differences in (self.found, self.elsewhere):
            differences.sort(key=lambda difference: -difference.size)
        return Comparison(
            self.found, self.elsewhere, self.largest, len(self.one.groups), *masses,
            but_for, not_compared, self.compared,
        )  # fmt: skip

    # --- group by group ---

    def compare_groups(self) -> None:
        """Compare how each group moves on the one before it, and what moves.

        Joint by joint, so that each difference is named where it arises: all poses are products
        of these, hence equal if they are.
        """
        one, two, pairs = self.one, self.two, self.pairs
        leader = {number: link for link, (number, _) in reversed(one.frames.items())}
        world: list[Frame] = []
        # what is fixed to the ground needs no inertia
        for mine, other in enumerate(pairs[1:], start=1):
            ours, theirs = one.groups[mine], two.groups[other]
            before = theirs.before
            hangs = theirs.parent != pairs[ours.parent]
            if hangs:
                world = world or two.world()
                before = compose(inverse(world[pairs[ours.parent]]), world[other])
            scale = self.scales[mine]
            moves = _moves(ours.move, theirs.move, 1.0 if ours.turns else scale)
            pair = _Pair(
                ours, theirs, compose(self.apart[ours.parent], ours.before), before,
                merge(ours.inertias), merge(theirs.inertias), scale,
                partial(self._carried, mine), moves,
            )  # fmt: skip
            link = leader.get(mine)
            if hangs:
                told = f"joint '{ours.joint}' stands after another joint in {self.called[1]}"
                child = self.children[ours.joint]
                if not self.found or self.found[-1].message != told:  # once for all coordinates
                    self._differ("parent", told, link=child, joint=ours.joint)
            self.apart[mine], motion = self._place(pair, other, link, hangs)
            self.compared.append(
                Compared(
                    ours.coordinate, theirs.coordinate, ours.joint,
                    one.groups[ours.parent].coordinate, ours.turns, ours.axis, ours.before,
                    *pair.our_inertia,
                    worst((motion, self._inertia(pair, self.apart[mine]))),
                )
            )  # fmt: skip

    def _carried(self, mine: int) -> list[tuple[Group, Group]]:
        """The pairs of groups that hang on a pair: asked for only where something differs."""
        if self.hanging is None:
            self.hanging = {}
            for number, other in enumerate(self.pairs[1:], start=1):
                ours, theirs = self.one.groups[number], self.two.groups[other]
                if theirs.parent == self.pairs[ours.parent]:
                    self.hanging.setdefault(ours.parent, []).append((ours, theirs))
        return self.hanging.get(mine, [])

    def _place(self, pair: _Pair, other: int, link: str | None, hangs: bool) -> tuple[Frame, float]:
        """The constant pose of a group in its counterpart, and how far their motions are apart;
        tells what of the motion differs."""
        at = self.frames.get(link) if link is not None else None
        meant: Frame | None = None
        if at is not None:
            group, pose = self._said(at)
            if group == other:
                meant = HERE if pose == HERE else pose
        place = pair.placed() if meant is None else meant
        motion = 0.0 if hangs else pair.motion(place)
        plain = meant is not None or max(pair.inertia(place).values()) <= self.tolerance
        if self._beyond(motion) or not plain:
            place = _settle(pair, pair.placed(), meant, self.tolerance)
            motion = 0.0 if hangs else pair.motion(place)
        self.largest["motion"] = max(self.largest["motion"], motion)
        if self._beyond(motion):
            self._tell_motion(pair, place, motion)
        return place, motion

    def _tell_motion(self, pair: _Pair, place: Frame, motion: float) -> None:
        """Name a difference in motion: a joint's zero, a link put elsewhere, or an axis."""
        ours, theirs, name = pair.ours, pair.theirs, pair.ours.joint
        link = self.children[name]
        where: dict[str, Any] = {"link": link, "joint": name}
        placed = pair.placed()
        off = distance(placed, place, pair.scale)
        a, b = turned(pair.their_before, theirs.axis), turned(pair.our_before, ours.axis)
        tilt = angle(a, b)
        if off <= self.tolerance:
            if self._beyond(tilt):
                back = inverse(self.apart[ours.parent])
                a, b = turned(back, a), turned(back, b)
                told = f"its axis is {_short(a)} in {self.called[1]}, and should be {_short(b)}"
                told += f": {tilt:.6g} rad off"
            else:
                a, b = pair.their_before[9:], pair.our_before[9:]
                told = f"its axis is {most(a, b):.3g} m beside where it should be"
            self._differ("axis", f"joint '{name}': {told}", motion, urdf=b, mbs=a, **where)
            return
        # the link, seen from where it should be; how much of it is the joint's own motion?
        away = compose(inverse(placed), place)
        if ours.turns:
            amount = about(away, ours.axis)
            rest = compose(away, spin(ours.axis, -amount))
        else:
            amount = sum(p * q for p, q in zip(away[9:], ours.axis, strict=True))
            rest = compose(away, shift(ours.axis, -amount))
        left = distance(rest, HERE, pair.scale)
        if left <= max(self.tolerance, 1e-3 * off):
            unit = "rad" if ours.turns else "m"
            told = f"joint '{name}': its zero is {self.called[0]}'s {amount:.6g} {unit}"
            if self._beyond(left):
                told += f", and {self.called[2]} '{link}' is {_told(rest)}"
            self._differ("zero", told, off, urdf=0.0, mbs=amount, **where)
            return
        told = f"{self.called[2]} '{link}': joint '{name}' puts it elsewhere, {_told(away)}"
        driven = self._driven_before(theirs.joint)
        if driven:
            told += f" (driven before it: {driven})"
        if self._beyond(tilt):
            told += f"; its axis is {tilt:.3g} rad off"
        self._differ("frame", told, off, **where)

    def _driven_before(self, name: str) -> str:
        """What is driven in a body before one of its joints."""
        told: list[str] = []
        for body in self.bodies:
            told.clear()
            for joint in body.joints:
                if joint.name == name:
                    return ", ".join(told)
                if joint.nature != "driven":
                    told.clear()
                elif joint.q:
                    told.append(f"{joint.type} {joint.q:.6g}")
        return ""

    def _inertia(self, pair: _Pair, place: Frame) -> float:
        """Compare what a pair of groups weighs, where, and how it resists turning; gives how far
        they are apart."""
        apart = pair.inertia(place)
        most = max(apart.values())
        if most == 0.0:
            return most
        for kind, off in apart.items():
            self.largest[kind] = max(self.largest[kind], off)
        if not self._beyond(most):
            return most
        joint = pair.ours.joint
        link = self.children[joint]
        lost = self._lost(pair)
        for name in lost:
            mass = dict(pair.ours.inertias)[name][0]
            told = f"{self.called[2]} '{name}': its {_short(mass)} kg are not in {self.called[1]}"
            self._differ(
                "mass", told, mass / (pair.our_inertia[0] or 1.0),
                link=name, joint=joint, urdf=mass, mbs=0.0,
            )  # fmt: skip
        before = len(self.found)
        for names, ours, theirs in self._parts(pair, lost):
            ours = seen(ours, place)
            names = names or [link]
            who = (
                counted(len(names), self.called[2]).split()[1]
                + " "
                + " + ".join(f"'{name}'" for name in names[:3])
            )
            if len(names) > 3:
                who += f" and {len(names) - 3} more"
            for index, (kind, off) in enumerate(inertias_apart(ours, theirs, pair.scale).items()):
                if self._beyond(off):
                    a, b = ours[index], theirs[index]
                    told = f"{who}: {kind} is {_short(b)} in {self.called[1]}, "
                    told += f"and should be {_short(a)}"
                    self._differ(kind, told, off, link=names[0], joint=joint, urdf=a, mbs=b)
        if not lost and len(self.found) == before:  # only in sum, as where two were exchanged
            self._differ(
                "inertia", f"{self.called[2]} '{link}': inertia", most, link=link, joint=joint
            )
        return most

    def _lost(self, pair: _Pair) -> list[str]:
        """The links of a group whose mass is just what the .mbs has too little."""
        heavy = [(name, inertia[0]) for name, inertia in pair.ours.inertias if inertia[0]]
        lack = pair.our_inertia[0] - pair.their_inertia[0]
        enough = self.tolerance * pair.our_inertia[0]
        if lack <= enough:
            return []
        bodiless = [(name, mass) for name, mass in heavy if not self._body(name)]
        if bodiless and abs(sum(mass for _, mass in bodiless) - lack) <= enough:
            return [name for name, _ in bodiless]
        return [name for name, mass in heavy if abs(mass - lack) <= enough][:1]

    def _body(self, link: str) -> str | None:
        """The body that a link's inertia should be in, as far as that is known."""
        at = self.frames.get(link)
        return None if at is None or at.joint is not None else at.body

    def _parts(self, pair: _Pair, lost: list[str]) -> list[tuple[list[str], Inertia, Inertia]]:
        """A pair of groups, body by body if it is known which link is in which: links, their
        inertia, and the body's."""
        ours = [(name, i) for name, i in pair.ours.inertias if name not in lost]
        names = [name for name, _ in ours]
        whole = [(names, merge(ours), pair.their_inertia)]
        bodies: dict[str, list[tuple[str, Inertia]]] = {}
        for name, inertia in ours:
            bodies.setdefault(self._body(name) or "", []).append((name, inertia))
        theirs = dict(pair.theirs.inertias)
        if "" in bodies or not bodies.keys() >= theirs.keys():
            return whole
        nothing = merge([])
        return [
            ([name for name, _ in links], merge(links), theirs.get(body, nothing))
            for body, links in bodies.items()
        ]

    # --- frames and points ---

    def _said(self, at: LinkFrame) -> tuple[int, Frame]:
        """Where a link's frame is said to be: the group in the .mbs, -1 if there is none, and the
        pose in it."""
        nowhere = (-1, HERE)
        if at.joint is not None:
            group, pose = self.two.after.get(at.joint, nowhere)
        else:
            group, pose = self.two.frames.get(at.body or "", nowhere)
        if at.pose.xyz != ORIGIN or at.pose.rot != UNTURNED:
            pose = compose(pose, (*at.pose.rot, *at.pose.xyz))
        return group, pose

    def compare_frames(self) -> None:
        """Compare where each link's frame is with where it is said to be."""
        for link, at in self.frames.items():
            if link not in self.one.frames:
                continue
            group, pose = self.one.frames[link]
            other, theirs = self._said(at)
            if self.pairs[group] != other:
                name = at.joint or at.body or ""
                told = "moves with another body" if other >= 0 else f"there is no '{name}'"
                self.elsewhere.append(Difference("frame", f"link '{link}': {told}", link=link))
                continue
            ours = compose(self.apart[group], pose)
            off = distance(ours, theirs, self.scales[group])
            if off > self.largest["frame"]:
                self.largest["frame"] = off
            if self._beyond(off):
                told = _told(compose(inverse(ours), theirs))
                self.elsewhere.append(
                    Difference("frame", f"link '{link}': its frame is {told}", off, link=link)
                )

    def compare_points(self, mbs: Mbs) -> None:
        """Compare the anchor points named after links that are rigid with the point's body."""
        links = _one_spelling(self.one.frames)
        for body, points in (
            (None, mbs.base.points),
            *((body.name, body.points) for body in mbs.bodies),
        ):
            other, at = self.two.frames[body or ""]
            for point in points:
                link = links.get(point.name)
                if link is None:
                    continue
                group, pose = self.one.frames[link]
                if self.pairs[group] != other:
                    continue
                ours = moved(self.apart[group], pose[9:])
                theirs = moved(at, point.coordinates)
                off = most(ours, theirs, self.scales[group])
                if self._beyond(off):
                    told = f"link '{link}': point '{point.name}' of body '{body}' is "
                    told += f"{dist(ours, theirs):.3g} m off its frame"
                    self.elsewhere.append(Difference("point", told, min(off, 1.0), link=link))


def urdf_mass(robot: Robot) -> float:
    """kg, of all links behind a joint that moves."""
    moving: set[str] = set()
    for joint in robot.depth_first():
        if joint.moves or joint.parent in moving:
            moving.add(joint.child)
    return sum(
        i.mass for name in robot.links if name in moving and (i := robot.links[name].inertial)
    )


def mbs_mass(mbs: Mbs) -> float:
    """kg, of all bodies behind a joint that is not driven."""
    moving: set[str | None] = set()
    for body in mbs.bodies:
        if body.parent in moving or any(joint.nature != "driven" for joint in body.joints):
            moving.add(body.name)
    return sum(body.mass or 0.0 for body in mbs.bodies if body.name in moving)


def _settle(pair: _Pair, placed: Frame, meant: Frame | None, tolerance: float) -> Frame:
    """The pose of a group in its counterpart, where it is not plain: of those that come into
    question, the one in which the most of what the groups have agrees.

    ``placed`` is where the joint puts it at zero, ``meant`` where its frame is by name.  Either
    may be the one that is wrong, or both: hand-made models turn a frame so that its joint's
    axis is a coordinate axis.
    """

    def agreement(at: Frame) -> float:
        return -sum(log10(min(max(off, TOLERANCE), 1.0)) for off in pair.misfits(at))

    choice = [placed]
    if meant is not None:
        choice += [meant, _on_axis(pair, meant)]
    best = max(choice, key=agreement)
    slid = _slid(pair, _on_axis(pair, placed))
    # one thing that does not fit is itself wrong; if two do not, it is the place
    misfits, others = (sum(not off <= tolerance for off in pair.misfits(at)) for at in (best, slid))
    return slid if misfits - others >= 2 else best


def _on_axis(pair: _Pair, at: Frame) -> Frame:
    """The pose nearest to ``at`` in which the groups have the same axis."""
    u, e = turned(at, pair.ours.axis), pair.theirs.axis
    n = cross(u, e)
    sine = hypot(*n)
    if sine > 0.0:
        turn = spin((n[0] / sine, n[1] / sine, n[2] / sine), atan2(sine, dot(u, e)))
        at = (*compose(turn, at)[:9], *at[9:])
    if pair.ours.turns:
        along = dot(at[9:], e)
        at = (*at[:9], along * e[0], along * e[1], along * e[2])
    return at


def _slid(pair: _Pair, at: Frame) -> Frame:
    """A pose moved along, and turned about, the joint's axis so that the first of centre and
    anchors that tells agrees."""
    e = pair.theirs.axis
    points = [(pair.our_inertia[1], pair.their_inertia[1])] if pair.our_inertia[0] else []
    points += [(mine.before[9:], other.before[9:]) for mine, other in pair.carried()]
    if pair.ours.turns:
        for a, b in points:
            p, q = across(moved(at, a), e), across(b, e)
            if min(hypot(*p), hypot(*q)) > 1e-3 * pair.scale:
                angle = atan2(dot(cross(p, q), e), dot(p, q))
                at = compose(spin(e, angle), at)
                break
    for a, b in points[:1]:
        p = moved(at, a)
        d = (b[0] - p[0], b[1] - p[1], b[2] - p[2])
        if pair.ours.turns:
            along = dot(d, e)
            d = (along * e[0], along * e[1], along * e[2])
        at = (*at[:9], at[9] + d[0], at[10] + d[1], at[11] + d[2])
    return at


def _one_spelling(links: Iterable[str]) -> dict[str, str | None]:
    """The link that each point's name stands for; None where it may stand for several."""
    found: dict[str, str | None] = {}
    for link in links:
        name = link if link.isascii() and link.isidentifier() else identifiers([link])[0]
        found[name] = None if name in found else link
    return found


def _short(value: Any) -> str:
    if isinstance(value, tuple):
        return "(" + ", ".join(f"{c:.9g}" for c in value) + ")"
    return f"{value:.9g}"


def _told(apart: Frame) -> str:
    """A frame in words: the turns that lead to it (rad), and its shift (m)."""
    turns = ", ".join(
        f"{angle:.6g} about {'xyz'[k - 1]}" for k, angle in fewest_turns(apart[:9], 1e-10)
    )
    most = max(map(abs, apart[9:]))
    shift = ", ".join(f"{c if abs(c) > 1e-9 * most else 0.0:.6g}" for c in apart[9:])
    parts = [f"turned by {turns}"] * bool(turns) + [f"shifted by ({shift})"] * (most > 1e-12)
    return " and ".join(parts) or "slightly off"
