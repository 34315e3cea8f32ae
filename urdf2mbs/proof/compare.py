"""Is an .mbs the same robot as a URDF?  The proof, by a second route.

The .mbs is walked joint by joint, each an elementary shift or turn along a current axis; the
URDF by Rodrigues' formula, with quaternions for its roll, pitch and yaw.  Neither shares a line
with the passes, nor with ``spatial``.

What is compared are the *rigid groups*: all that no moving joint separates.

* Motion: at several random positions, zero included, each group must stand on the group before
  it where its counterpart stands, up to one constant pose between a group and its counterpart.
  Every pose in the world is a product of these.
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

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from math import asin, atan2, cos, dist, hypot, isfinite, log10, pi, sin, sqrt
from random import Random
from sys import float_info
from typing import Any

import msgspec

from urdf2mbs.conversion import NOTHING_HEAVY, LinkFrame
from urdf2mbs.diagnostics import Difference
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.spatial import Sym, Vec, fewest_turns
from urdf2mbs.urdf.model import Joint, Origin, Robot

#: What a difference must exceed to count, relative to the scale of what is compared.
TOLERANCE = 1e-9
#: Positions at which the motion is compared, zero included.
POSITIONS = 4
#: Components of a unit axis up to this are zero for a conversion (it says so in a note).
ALIGNED = 1e-9
#: A floating joint's coordinates, where the .mbs does not have them in another order.
SIX = ("T1", "T2", "T3", "R1", "R2", "R3")

#: A frame: a rotation matrix row by row, then the origin (m).
Frame = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float
]  # fmt: skip
#: Mass (kg), centre (m), and inertia about it (kg m^2), in some frame.
Inertia = tuple[float, Vec, Sym]

HERE: Frame = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
ORIGIN: Vec = (0.0, 0.0, 0.0)
X, Y, Z = AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


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
    positions: int = POSITIONS

    @property
    def same(self) -> bool:
        return not self.differences


def compare(
    robot: Robot,
    mbs: Mbs,
    joints: Mapping[str, tuple[str, ...]],
    *,
    frames: Mapping[str, LinkFrame] | None = None,
    frozen: Mapping[str, str] | None = None,
    orders: Mapping[str, tuple[str, ...]] | None = None,
    gravity: Vec = (0.0, 0.0, -9.81),
    tolerance: float = TOLERANCE,
) -> Comparison:
    """Compare a URDF with an .mbs.

    ``joints`` maps each moving URDF joint to the .mbs joints that move with its coordinates
    (one; three of a planar joint: two shifts and the turn; six of a floating one: T1 T2 T3 R1
    R2 R3, or as ``orders`` has them).  ``frames`` says where link frames are meant to be, as far
    as that is known; without it only the physics is compared.  ``frozen`` joints are held at
    zero on the URDF's side; nothing that they move may have mass.
    """
    return _Comparing(robot, mbs, frames, tolerance).compare(
        joints, frozen or {}, orders or {}, gravity
    )


class _Group(msgspec.Struct):
    """A rigid group: how it hangs on its parent group, and what is in it."""

    parent: int
    before: Frame
    """Where its joint stands in the parent group; the group's own frame is the one after it."""
    turns: bool
    axis: Vec
    """Along or about which it moves, in both frames."""
    move: Callable[[float], Frame]
    coordinate: str
    joint: str
    reach: float
    """How far out (m) its joint is in the parent group, and what it has is in it."""
    inertias: list[tuple[str, Inertia]] = []
    """Of each link or body."""


class _Side(msgspec.Struct):
    """One of the two descriptions, as rigid groups; group 0 is the ground."""

    groups: list[_Group]
    frames: dict[str, tuple[int, Frame]]
    """Link (URDF) or body and joint (.mbs) frames: their group and pose in it."""
    created: dict[str, int]
    """The group that each coordinate moves."""

    def add(
        self,
        parent: int,
        before: Frame,
        turns: bool,
        axis: Vec,
        move: Callable[[float], Frame],
        coordinate: str,
        joint: str,
    ) -> int:
        reach = max(abs(before[9]), abs(before[10]), abs(before[11]))
        if reach > self.groups[parent].reach:
            self.groups[parent].reach = reach
        group = _Group(parent, before, turns, axis, move, coordinate, joint, reach)
        self.groups.append(group)
        self.created[coordinate] = len(self.groups) - 1
        return len(self.groups) - 1

    def put(self, name: str, group: int, inertia: Inertia) -> None:
        x, y, z = inertia[1]
        reach = max(abs(x), abs(y), abs(z))
        if reach > self.groups[group].reach:
            self.groups[group].reach = reach
        self.groups[group].inertias.append((name, inertia))

    def mass(self) -> float:
        """kg, of all groups but the ground."""
        return sum(i[0] for group in self.groups[1:] for _, i in group.inertias)

    def world(self) -> list[Frame]:
        """The pose of every group at zero."""
        out = [HERE]
        for group in self.groups[1:]:
            out.append(_compose(out[group.parent], group.before))
        return out


def _side(root: str) -> _Side:
    ground = _Group(0, HERE, False, X, lambda _: HERE, "", "", 0.0)
    return _Side([ground], {root: (0, HERE)}, {})


class _Pair(msgspec.Struct):
    """A group of the URDF and its counterpart in the .mbs, and where their joints stand, both
    seen from the .mbs's parent group."""

    ours: _Group
    theirs: _Group
    our_before: Frame
    their_before: Frame
    our_inertia: Inertia
    their_inertia: Inertia
    scale: float
    """m."""
    carried: list[tuple[_Group, _Group]]
    """The groups that hang on them."""
    moves: list[tuple[Frame, Frame]]
    """The joint's motion at the random positions."""

    def motion(self, at: Frame) -> float:
        """How far the motions are apart, if ``at`` is our group's pose in theirs."""
        off = _distance(
            _compose(self.their_before, at) if at is not HERE else self.their_before,
            self.our_before,
            self.scale,
        )
        for our_move, their_move in self.moves:
            ours = _compose(self.our_before, our_move)
            theirs = _compose(self.their_before, their_move)
            if at is not HERE:
                theirs = _compose(theirs, at)
            off = max(off, _distance(theirs, ours, self.scale))
        return off

    def inertia(self, at: Frame) -> dict[str, float]:
        ours = self.our_inertia if at is HERE else _seen(self.our_inertia, at)
        return _apart(ours, self.their_inertia, self.scale)

    def misfits(self, at: Frame) -> list[float]:
        """How far each thing that the groups have is apart, if ``at`` is so: the axis of their
        joint, what they weigh, and the axes of the joints that they carry."""
        ours, theirs = self.ours, self.theirs
        found = [
            _between_axes(at, ours.axis, HERE, theirs.axis, ours.turns, self.scale),
            *self.inertia(at).values(),
        ]
        for mine, other in self.carried:
            before = _compose(at, mine.before)
            found.append(
                _between_axes(before, mine.axis, other.before, other.axis, mine.turns, self.scale)
            )
        return found


class _Comparing:
    """One comparison in the making."""

    def __init__(
        self, robot: Robot, mbs: Mbs, frames: Mapping[str, LinkFrame] | None, tolerance: float
    ) -> None:
        self.robot = robot
        self.mbs = mbs
        self.tolerance = tolerance
        self.frames = frames or {}
        self.found: list[Difference] = []
        self.elsewhere: list[Difference] = []
        self.largest = {"gravity": 0.0, "motion": 0.0, "mass": 0.0, "centre": 0.0, "inertia": 0.0}
        if frames is not None:
            self.largest["frame"] = 0.0

    def compare(
        self,
        joints: Mapping[str, tuple[str, ...]],
        frozen: Mapping[str, str],
        orders: Mapping[str, tuple[str, ...]],
        gravity: Vec,
    ) -> Comparison:
        self._gravity(gravity)
        self._left_out(frozen)
        names, held = self._coordinates(joints, frozen, orders)
        one = self.one = _urdf_side(self.robot, names, held, orders)
        two = self.two = _mbs_side(self.mbs, set(names.values()))
        #: Each group's counterpart, parents first: there is one for each.
        self.pairs = {0: 0}
        for own, number in one.created.items():
            self.pairs[number] = two.created[names[own]]
        size = max(group.reach for side in (one, two) for group in side.groups)
        #: m; a joint at the very place of the one before it has the rounding of what is there.
        self.floor = 1e-4 * size or 1.0
        #: Each group's pose in its counterpart.
        self.apart: dict[int, Frame] = {0: HERE}
        self._groups()
        self._frames()
        self._points()
        for listed in (self.found, self.elsewhere):
            listed.sort(key=lambda difference: -difference.size)
        return Comparison(
            self.found, self.elsewhere, self.largest, len(one.groups), one.mass(), two.mass()
        )

    def _differ(self, kind: str, message: str, size: float = 1.0, **more: Any) -> None:
        self.found.append(Difference(kind, message, min(size, 1.0), **more))

    def _beyond(self, off: float) -> bool:
        """Whether a deviation is a difference; so is one that is not a number."""
        return not off <= self.tolerance

    def _gravity(self, gravity: Vec) -> None:
        own = self.mbs.base.gravity
        off = _most(gravity, own, max(map(abs, (*gravity, *own))) or 1.0)
        self.largest["gravity"] = off
        if self._beyond(off):
            told = f"gravity is {_short(own)}, and should be {_short(gravity)} m/s^2"
            self._differ("gravity", told, off, urdf=gravity, mbs=own)

    def _left_out(self, frozen: Mapping[str, str]) -> None:
        """What is left out as weighing nothing must weigh nothing; a pass that has another
        reason for it (joints locked on purpose, say) answers for it itself."""
        useful = carriers(self.robot) if frozen else set()
        for name, why in frozen.items():
            joint = self.robot.joints[name]
            if why == NOTHING_HEAVY and joint.child in useful:
                self._differ(
                    "joint-missing",
                    f"joint '{name}' is left out, and it moves what has mass",
                    link=joint.child, joint=name,
                )  # fmt: skip

    def _coordinates(
        self,
        joints: Mapping[str, tuple[str, ...]],
        frozen: Mapping[str, str],
        orders: Mapping[str, tuple[str, ...]],
    ) -> tuple[dict[str, str], dict[str, float]]:
        """The URDF's coordinates that move in the .mbs too, under its names; and those that are
        held there, with the value.  What differs in this is told, and does not move below."""
        known = {joint.name: joint for body in self.mbs.bodies for joint in body.joints}
        names: dict[str, str] = {}
        held: dict[str, float] = {}
        taken: set[str] = set()
        for joint in self.robot.joints.values():
            if not joint.moves or joint.name in frozen:
                continue
            where: dict[str, Any] = {"link": joint.child, "joint": joint.name}
            ours = _own_coordinates(joint, orders.get(joint.name, SIX))
            theirs = joints.get(joint.name, ())
            if len(theirs) != len(ours) or not known.keys() >= set(theirs):
                told = f"joint '{joint.name}' ({joint.type}) is not in the .mbs"
                self._differ("joint-missing", told, **where)
                continue
            for (own, kind), name in zip(ours, theirs, strict=True):
                nature = known[name].nature
                # what follows another joint, or closes a loop, moves without being independent
                follows = joint.mimic is not None or (nature == "dependent" and self.mbs.cuts)
                if nature != "independent" and not follows:
                    told = f"joint '{name}' is {nature}, and should be independent"
                    self._differ("nature", told, urdf="independent", mbs=nature, **where)
                if name in taken:
                    told = f"joint '{name}' is given for '{joint.name}' and for another joint"
                    self._differ("joint-missing", told, **where)
                elif nature == "driven" and not follows:
                    held[own] = known[name].q or 0.0
                elif known[name].type[0] != kind[0]:
                    does = "shifts" if kind[0] == "R" else "turns"
                    told = f"joint '{name}' is a {known[name].type}: it {does}, and should not"
                    self._differ("type", told, urdf=joint.type, mbs=known[name].type, **where)
                else:
                    names[own] = name
                taken.add(name)
        for body in self.mbs.bodies:
            for extra in body.joints:
                if extra.nature != "driven" and extra.name not in taken:
                    told = f"joint '{extra.name}' of body '{body.name}' moves in the .mbs only"
                    self._differ("joint-extra", told, link=body.name, joint=extra.name)
        return names, held

    # --- group by group ---

    def _groups(self) -> None:
        """Compare how each group moves on the one before it, and what moves.

        Joint by joint, so that each difference is named where it arises: all poses are products
        of these, hence equal if they are.
        """
        one, two, pairs = self.one, self.two, self.pairs
        random = Random(20)
        leader: dict[int, str] = {}
        for name, (number, _) in one.frames.items():
            leader.setdefault(number, name)
        carried: dict[int, list[tuple[_Group, _Group]]] = {number: [] for number in pairs}
        hangs: set[int] = set()
        for mine, other in pairs.items():
            if mine:
                ours, theirs = one.groups[mine], two.groups[other]
                if theirs.parent == pairs[ours.parent]:
                    carried[ours.parent].append((ours, theirs))
                else:
                    hangs.add(mine)
        world = two.world() if hangs else []
        for mine, other in pairs.items():
            if not mine:
                continue  # what is fixed to the ground needs no inertia
            ours, theirs = one.groups[mine], two.groups[other]
            before = theirs.before
            if mine in hangs:
                before = _compose(_inverse(world[pairs[ours.parent]]), world[other])
            scale = max(ours.reach, theirs.reach) + self.floor
            moves = []
            for _ in range(POSITIONS - 1):
                q = random.uniform(-pi, pi) * (1.0 if ours.turns else scale)
                moves.append((ours.move(q), theirs.move(q)))
            pair = _Pair(
                ours, theirs, _compose(self.apart[ours.parent], ours.before), before,
                _merge(ours.inertias), _merge(theirs.inertias), scale, carried[mine], moves,
            )  # fmt: skip
            link = leader.get(mine)
            if mine in hangs:
                told = f"joint '{ours.joint}' stands after another joint in the .mbs"
                child = self.robot.joints[ours.joint].child
                if not self.found or self.found[-1].message != told:  # once for all coordinates
                    self._differ("parent", told, link=child, joint=ours.joint)
            self.apart[mine] = self._place(pair, other, link, mine in hangs)
            self._inertia(pair, self.apart[mine])

    def _place(self, pair: _Pair, other: int, link: str | None, hangs: bool) -> Frame:
        """The constant pose of a group in its counterpart; tells what of the motion differs."""
        at = self.frames.get(link) if link is not None else None
        meant: Frame | None = None
        if at is not None:
            group, anchor = self.two.frames.get(at.joint or at.body or "", (-1, HERE))
            if group == other:
                meant = _compose(anchor, (*at.pose.rot, *at.pose.xyz))
                if meant == HERE:
                    meant = HERE
        placed = HERE
        place = meant
        if place is None:
            place = placed = _compose(_inverse(pair.their_before), pair.our_before)
        motion = 0.0 if hangs else pair.motion(place)
        plain = meant is not None or max(pair.inertia(place).values()) <= self.tolerance
        if self._beyond(motion) or not plain:
            placed = _compose(_inverse(pair.their_before), pair.our_before)
            place = _settle(pair, placed, meant, self.tolerance)
            motion = 0.0 if hangs else pair.motion(place)
        self.largest["motion"] = max(self.largest["motion"], motion)
        if self._beyond(motion):
            self._tell_motion(pair, placed, place, motion)
        return place

    def _tell_motion(self, pair: _Pair, placed: Frame, place: Frame, motion: float) -> None:
        """Name a difference in motion: a joint's zero, a link put elsewhere, or an axis."""
        ours, theirs, name = pair.ours, pair.theirs, pair.ours.joint
        link = self.robot.joints[name].child
        where: dict[str, Any] = {"link": link, "joint": name}
        off = _distance(placed, place, pair.scale)
        a, b = _turned(pair.their_before, theirs.axis), _turned(pair.our_before, ours.axis)
        tilt = _angle(a, b)
        if off <= self.tolerance:
            if self._beyond(tilt):
                back = _inverse(self.apart[ours.parent])
                a, b = _turned(back, a), _turned(back, b)
                told = f"its axis is {_short(a)} in the .mbs, and should be {_short(b)}"
                told += f": {tilt:.6g} rad off"
            else:
                a, b = pair.their_before[9:], pair.our_before[9:]
                told = f"its axis is {_most(a, b):.3g} m beside where it should be"
            self._differ("axis", f"joint '{name}': {told}", motion, urdf=b, mbs=a, **where)
            return
        # the link, seen from where it should be; how much of it is the joint's own motion?
        away = _compose(_inverse(placed), place)
        if ours.turns:
            amount = _about(away, ours.axis)
            rest = _compose(away, _spin(ours.axis, -amount))
        else:
            amount = sum(p * q for p, q in zip(away[9:], ours.axis, strict=True))
            rest = _compose(away, _shift(ours.axis, -amount))
        left = _distance(rest, HERE, pair.scale)
        if left <= max(self.tolerance, 1e-3 * off):
            unit = "rad" if ours.turns else "m"
            told = f"joint '{name}': its zero is the URDF's {amount:.6g} {unit}"
            if self._beyond(left):
                told += f", and link '{link}' is {_told(rest)}"
            self._differ("zero", told, off, urdf=0.0, mbs=amount, **where)
            return
        told = f"link '{link}': joint '{name}' puts it elsewhere, {_told(away)}"
        driven = self._driven_before(theirs.joint)
        if driven:
            told += f" (driven before it: {driven})"
        if self._beyond(tilt):
            told += f"; its axis is {tilt:.3g} rad off"
        self._differ("frame", told, off, **where)

    def _driven_before(self, name: str) -> str:
        """What is driven in a body before one of its joints."""
        told: list[str] = []
        for body in self.mbs.bodies:
            told.clear()
            for joint in body.joints:
                if joint.name == name:
                    return ", ".join(told)
                if joint.nature != "driven":
                    told.clear()
                elif joint.q:
                    told.append(f"{joint.type} {joint.q:.6g}")
        return ""

    def _inertia(self, pair: _Pair, place: Frame) -> None:
        """Compare what a pair of groups weighs, where, and how it resists turning."""
        apart = pair.inertia(place)
        for kind, off in apart.items():
            self.largest[kind] = max(self.largest[kind], off)
        most = max(apart.values())
        if not self._beyond(most):
            return
        joint = pair.ours.joint
        link = self.robot.joints[joint].child
        lost = self._lost(pair)
        for name in lost:
            mass = dict(pair.ours.inertias)[name][0]
            told = f"link '{name}': its {_short(mass)} kg are not in the .mbs"
            self._differ(
                "mass", told, mass / (pair.our_inertia[0] or 1.0),
                link=name, joint=joint, urdf=mass, mbs=0.0,
            )  # fmt: skip
        before = len(self.found)
        for names, ours, theirs in self._parts(pair, lost):
            ours = _seen(ours, place)
            names = names or [link]
            who = f"link{'s' * (len(names) > 1)} " + " + ".join(f"'{name}'" for name in names[:3])
            if len(names) > 3:
                who += f" and {len(names) - 3} more"
            for index, (kind, off) in enumerate(_apart(ours, theirs, pair.scale).items()):
                if self._beyond(off):
                    a, b = ours[index], theirs[index]
                    told = f"{who}: {kind} is {_short(b)} in the .mbs, and should be {_short(a)}"
                    self._differ(kind, told, off, link=names[0], joint=joint, urdf=a, mbs=b)
        if not lost and len(self.found) == before:  # only in sum, as where two were exchanged
            self._differ("inertia", f"link '{link}': inertia", most, link=link, joint=joint)

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
        whole = [(names, _merge(ours), pair.their_inertia)]
        bodies: dict[str, list[tuple[str, Inertia]]] = {}
        for name, inertia in ours:
            bodies.setdefault(self._body(name) or "", []).append((name, inertia))
        theirs = dict(pair.theirs.inertias)
        if "" in bodies or not bodies.keys() >= theirs.keys():
            return whole
        nothing = _merge([])
        return [
            ([name for name, _ in links], _merge(links), theirs.get(body, nothing))
            for body, links in bodies.items()
        ]

    # --- frames and points ---

    def _frames(self) -> None:
        """Compare where each link's frame is with where it is said to be."""
        for link, at in self.frames.items():
            if link not in self.one.frames:
                continue
            group, pose = self.one.frames[link]
            name = at.joint or at.body or ""
            other, theirs = self.two.frames.get(name, (-1, HERE))
            if self.pairs[group] != other:
                told = "moves with another body" if other >= 0 else f"there is no '{name}'"
                self.elsewhere.append(Difference("frame", f"link '{link}': {told}", link=link))
                continue
            if at.pose.xyz != ORIGIN or at.pose.rot != HERE[:9]:
                theirs = _compose(theirs, (*at.pose.rot, *at.pose.xyz))
            ours = self.apart[group]
            if pose is not HERE:
                ours = _compose(ours, pose)
            off = _distance(ours, theirs, self._scale(group))
            if off > self.largest["frame"]:
                self.largest["frame"] = off
            if self._beyond(off):
                told = _told(_compose(_inverse(ours), theirs))
                self.elsewhere.append(
                    Difference("frame", f"link '{link}': its frame is {told}", off, link=link)
                )

    def _points(self) -> None:
        """Compare the anchor points named after links that are rigid with the point's body."""
        at: dict[tuple[int, str], list[tuple[str | None, Vec]]] = {}
        for body, points in (
            (None, self.mbs.base.points),
            *((body.name, body.points) for body in self.mbs.bodies),
        ):
            group, _ = self.two.frames[body or ""]
            for point in points:
                at.setdefault((group, point.name), []).append((body, point.coordinates))
        plain = _one_spelling(self.one.frames)
        for link, (group, pose) in self.one.frames.items():
            for body, xyz in at.get((self.pairs[group], plain.get(link, "")), ()):
                ours = _moved(self.apart[group], pose[9:])
                theirs = _moved(self.two.frames[body or ""][1], xyz)
                off = _most(ours, theirs, self._scale(group))
                if self._beyond(off):
                    told = f"link '{link}': point '{plain[link]}' of body '{body}' is "
                    told += f"{dist(ours, theirs):.3g} m off its frame"
                    self.elsewhere.append(Difference("point", told, min(off, 1.0), link=link))

    def _scale(self, group: int) -> float:
        other = self.two.groups[self.pairs[group]]
        return max(self.one.groups[group].reach, other.reach) + self.floor


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
    u, e = _turned(at, pair.ours.axis), pair.theirs.axis
    n = _cross(u, e)
    sine = hypot(*n)
    if sine > 0.0:
        turn = _spin((n[0] / sine, n[1] / sine, n[2] / sine), atan2(sine, _dot(u, e)))
        at = (*_compose(turn, at)[:9], *at[9:])
    if pair.ours.turns:
        along = _dot(at[9:], e)
        at = (*at[:9], along * e[0], along * e[1], along * e[2])
    return at


def _slid(pair: _Pair, at: Frame) -> Frame:
    """A pose moved along, and turned about, the joint's axis so that the first of centre and
    anchors that tells agrees."""
    e = pair.theirs.axis
    points = [(pair.our_inertia[1], pair.their_inertia[1])] if pair.our_inertia[0] else []
    points += [(mine.before[9:], other.before[9:]) for mine, other in pair.carried]
    if pair.ours.turns:
        for a, b in points:
            p, q = _across(_moved(at, a), e), _across(b, e)
            if min(hypot(*p), hypot(*q)) > 1e-3 * pair.scale:
                angle = atan2(_dot(_cross(p, q), e), _dot(p, q))
                at = _compose(_spin(e, angle), at)
                break
    for a, b in points[:1]:
        p = _moved(at, a)
        d = (b[0] - p[0], b[1] - p[1], b[2] - p[2])
        if pair.ours.turns:
            along = _dot(d, e)
            d = (along * e[0], along * e[1], along * e[2])
        at = (*at[:9], at[9] + d[0], at[10] + d[1], at[11] + d[2])
    return at


def carriers(robot: Robot) -> set[str]:
    """The links that have mass or carry what has."""
    useful = {link.name for link in robot.links.values() if not link.massless}
    for joint in reversed(robot.depth_first()):
        if joint.child in useful:
            useful.add(joint.parent)
    return useful


def _one_spelling(links: Iterable[str]) -> dict[str, str]:
    """The point's name that each link has to itself, if there is one."""
    spelt = {
        link: link if link.isascii() and link.isidentifier() else identifiers([link])[0]
        for link in links
    }
    count: dict[str, int] = {}
    for name in spelt.values():
        count[name] = count.get(name, 0) + 1
    return {link: name for link, name in spelt.items() if count[name] == 1}


def _merge(parts: list[tuple[str, Inertia]]) -> Inertia:
    """Several inertias in one frame as one, by the parallel-axis theorem."""
    inertias = [inertia for _, inertia in parts]
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
    return mass, (x, y, z), (xx, xy, xz, yy, yz, zz)


def _apart(ours: Inertia, theirs: Inertia, scale: float) -> dict[str, float]:
    """How far two inertias are apart, each part relative to its own scale.

    An inertia is not asked to be finer than 1e-15 of what its mass has at ``scale``: lumping
    point masses leaves that much dust.
    """
    heaviest = max(abs(ours[0]), abs(theirs[0]))
    tensor = max(map(abs, (*ours[2], *theirs[2]))) + 1e-6 * heaviest * scale * scale
    return {
        "mass": _most(ours[:1], theirs[:1], heaviest or 1.0),
        "centre": _most(ours[1], theirs[1], scale) if heaviest else 0.0,  # else it has none
        "inertia": _most(ours[2], theirs[2], tensor or 1.0),
    }


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


# --- the URDF's side: Rodrigues' formula -----------------------------------------------------


def _urdf_side(
    robot: Robot,
    moving: Mapping[str, str],
    held: Mapping[str, float],
    orders: Mapping[str, tuple[str, ...]],
) -> _Side:
    side = _side(robot.root())
    frames = side.frames
    for joint in robot.depth_first():
        group, at = frames[joint.parent]
        at = _at_origin(at, joint.origin)
        if joint.moves:
            order = orders.get(joint.name, SIX)
            for (own, kind), axis in zip(
                _own_coordinates(joint, order), _own_axes(joint, order), strict=True
            ):
                turns = kind[0] == "R"
                move = partial(_spin if turns else _shift, axis)
                if own in moving:
                    group = side.add(group, at, turns, axis, move, own, joint.name)
                    at = HERE
                elif held.get(own):
                    at = _compose(at, move(held[own]))
        frames[joint.child] = (group, at)
    for name, link in robot.links.items():
        if link.inertial is not None:
            group, at = frames[name]
            at = _at_origin(at, link.inertial.origin)
            side.put(name, group, _seen((link.inertial.mass, ORIGIN, link.inertial.inertia), at))
    return side


def _at_origin(at: Frame, origin: Origin) -> Frame:
    if origin.rpy != ORIGIN:
        return _compose(at, (*_from_quaternion(origin.rpy), *origin.xyz))
    if origin.xyz != ORIGIN:
        return (*at[:9], *_moved(at, origin.xyz))
    return at


def _own_coordinates(joint: Joint, order: tuple[str, ...]) -> list[tuple[str, str]]:
    """A joint's coordinates, and whether each is a T or an R."""
    if joint.type == "floating":
        return [(f"{joint.name}[{kind}]", kind) for kind in order]
    if joint.type == "planar":
        return [(f"{joint.name}[{k}]", "TTR"[k]) for k in range(3)]
    return [(joint.name, "T" if joint.type == "prismatic" else "R")]


def _own_axes(joint: Joint, order: tuple[str, ...]) -> list[Vec]:
    if joint.type == "floating":
        return [AXES[int(kind[1]) - 1] for kind in order]
    axis = _direction(joint.axis)
    return [*in_plane(axis), axis] if joint.type == "planar" else [axis]


def _direction(axis: Vec) -> Vec:
    largest = max(map(abs, axis))
    x, y, z = (c / largest for c in axis)
    length = sqrt(x * x + y * y + z * z)
    x, y, z = (0.0 if abs(c / length) <= ALIGNED else c for c in (x, y, z))
    length = sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length)


def in_plane(axis: Vec) -> tuple[Vec, Vec]:
    """The two directions in which a planar joint of a unit axis shifts; URDF leaves them open."""
    x, y, z = axis
    if x == 0.0 and y != 0.0:
        u = (0.0, -z, y)
    elif y == 0.0 and z != 0.0:
        u = (z, 0.0, -x)
    else:
        u = (-y / hypot(x, y), x / hypot(x, y), 0.0)
    return u, _cross(axis, u)


def _shift(u: Vec, q: float) -> Frame:
    return (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, q * u[0], q * u[1], q * u[2])


def _spin(u: Vec, q: float) -> Frame:
    """Rodrigues: R = 1 + sin(q) K + (1 - cos(q)) K^2, K the cross product with the unit axis."""
    x, y, z = u
    s, c = sin(q), 1.0 - cos(q)
    return (
        1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y,
        c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x,
        c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y),
        0.0, 0.0, 0.0,
    )  # fmt: skip


def _from_quaternion(
    rpy: Vec,
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Roll, pitch, yaw to a rotation by way of the quaternion, as urdfdom does it."""
    cr, cp, cy = (cos(angle / 2) for angle in rpy)
    sr, sp, sy = (sin(angle / 2) for angle in rpy)
    x = sr * cp * cy - cr * sp * sy
    y = cr * sp * cy + sr * cp * sy
    z = cr * cp * sy - sr * sp * cy
    w = cr * cp * cy + sr * sp * sy
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


# --- the .mbs's side: elementary joints ------------------------------------------------------


def _mbs_side(mbs: Mbs, moving: set[str]) -> _Side:
    side = _side("")
    frames = side.frames
    points: dict[tuple[str | None, str], Vec] = {
        (None, point.name): point.coordinates for point in mbs.base.points
    } | {(body.name, point.name): point.coordinates for body in mbs.bodies for point in body.points}
    for body in mbs.bodies:
        group, at = frames[body.parent or ""]
        if body.point is not None:
            at = (*at[:9], *_moved(at, points[body.parent, body.point]))
        for joint in body.joints:
            if joint.name in moving:
                # its position at start is where it starts from, not where it is held
                kind = joint.type
                group = side.add(
                    group, at, kind[0] == "R", AXES[int(kind[1]) - 1],
                    partial(_stepped, HERE, kind), joint.name, joint.name,
                )  # fmt: skip
                at = HERE
            elif joint.nature == "driven" and joint.q:
                at = _stepped(at, joint.type, joint.q)
            frames[joint.name] = (group, at)
        frames[body.name] = (group, at)
        if body.mass or body.inertia:
            tensor = body.inertia or (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            side.put(body.name, group, _seen((body.mass or 0.0, body.com or ORIGIN, tensor), at))
    return side


def _stepped(at: Frame, kind: str, q: float) -> Frame:
    """A frame after one joint: T1 T2 T3 shift along, R1 R2 R3 turn about its current axes."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, x, y, z = at
    if kind == "T1":
        return (*at[:9], x + q * a11, y + q * a21, z + q * a31)
    if kind == "T2":
        return (*at[:9], x + q * a12, y + q * a22, z + q * a32)
    if kind == "T3":
        return (*at[:9], x + q * a13, y + q * a23, z + q * a33)
    c, s = cos(q), sin(q)
    if kind == "R1":
        return (
            a11, c * a12 + s * a13, c * a13 - s * a12,
            a21, c * a22 + s * a23, c * a23 - s * a22,
            a31, c * a32 + s * a33, c * a33 - s * a32, x, y, z,
        )  # fmt: skip
    if kind == "R2":
        return (
            c * a11 - s * a13, a12, c * a13 + s * a11,
            c * a21 - s * a23, a22, c * a23 + s * a21,
            c * a31 - s * a33, a32, c * a33 + s * a31, x, y, z,
        )  # fmt: skip
    return (
        c * a11 + s * a12, c * a12 - s * a11, a13,
        c * a21 + s * a22, c * a22 - s * a21, a23,
        c * a31 + s * a32, c * a32 - s * a31, a33, x, y, z,
    )  # fmt: skip


# --- vectors, frames and inertias ------------------------------------------------------------


def _dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vec, b: Vec) -> Vec:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _across(v: Vec, e: Vec) -> Vec:
    """The part of a vector that is normal to a unit axis."""
    along = _dot(v, e)
    return (v[0] - along * e[0], v[1] - along * e[1], v[2] - along * e[2])


def _angle(a: Vec, b: Vec) -> float:
    """Between two unit vectors (rad)."""
    return 2.0 * asin(min(1.0, hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / 2.0))


def _about(frame: Frame, axis: Vec) -> float:
    """How far (rad) a frame is turned about an axis."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33 = frame[:9]
    sine = _dot((a32 - a23, a13 - a31, a21 - a12), axis) / 2.0
    return atan2(sine, (a11 + a22 + a33 - 1.0) / 2.0)


def _between_axes(at: Frame, u: Vec, other: Frame, v: Vec, turns: bool, scale: float) -> float:
    """How far apart two joint axes are: their directions, and of two that turn their places."""
    a, b = _turned(at, u), _turned(other, v)
    off = _most(a, b)
    if turns:
        d = (at[9] - other[9], at[10] - other[10], at[11] - other[11])
        off = worst((off, hypot(*_cross(d, b)) / scale))
    return off


def _most(a: Iterable[float], b: Iterable[float], scale: float = 1.0) -> float:
    """The largest difference between two lists of numbers, relative to ``scale``."""
    return worst(abs(p - q) / scale for p, q in zip(a, b, strict=True))


def worst(offs: Iterable[float]) -> float:
    """The largest of some deviations; the largest double if one is infinite or not a number.

    ``max`` alone passes over what is not a number, or not, by where it stands.
    """
    offs = tuple(offs)
    # no deviation is negative, so the sum is finite only if each of them is
    return max(offs) if isfinite(sum(offs)) else float_info.max


def _compose(a: Frame, b: Frame) -> Frame:
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


def _inverse(a: Frame) -> Frame:
    a11, a12, a13, a21, a22, a23, a31, a32, a33, x, y, z = a
    return (
        a11, a21, a31, a12, a22, a32, a13, a23, a33,
        -(a11 * x + a21 * y + a31 * z),
        -(a12 * x + a22 * y + a32 * z),
        -(a13 * x + a23 * y + a33 * z),
    )  # fmt: skip


def _turned(frame: Frame, v: Vec) -> Vec:
    """A direction given in a frame, from where the frame is given."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, _, _, _ = frame
    x, y, z = v
    return (
        a11 * x + a12 * y + a13 * z,
        a21 * x + a22 * y + a23 * z,
        a31 * x + a32 * y + a33 * z,
    )


def _moved(frame: Frame, v: Vec) -> Vec:
    """A point given in a frame, from where the frame is given."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = frame
    x, y, z = v
    return (
        ax + a11 * x + a12 * y + a13 * z,
        ay + a21 * x + a22 * y + a23 * z,
        az + a31 * x + a32 * y + a33 * z,
    )


def _distance(a: Frame, b: Frame, scale: float) -> float:
    """How far two frames are apart: the larger of the turn (rad) and the shift over ``scale``."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = a
    b11, b12, b13, b21, b22, b23, b31, b32, b33, bx, by, bz = b
    return worst((
        abs(a11 - b11), abs(a12 - b12), abs(a13 - b13),
        abs(a21 - b21), abs(a22 - b22), abs(a23 - b23),
        abs(a31 - b31), abs(a32 - b32), abs(a33 - b33),
        abs(ax - bx) / scale, abs(ay - by) / scale, abs(az - bz) / scale,
    ))  # fmt: skip


def _seen(inertia: Inertia, frame: Frame) -> Inertia:
    """An inertia given in a frame, from where the frame is given: R I R^T."""
    mass, centre, (xx, xy, xz, yy, yz, zz) = inertia
    a11, a12, a13, a21, a22, a23, a31, a32, a33, _, _, _ = frame
    p11, p12, p13 = (
        a11 * xx + a12 * xy + a13 * xz,
        a11 * xy + a12 * yy + a13 * yz,
        a11 * xz + a12 * yz + a13 * zz,
    )
    p21, p22, p23 = (
        a21 * xx + a22 * xy + a23 * xz,
        a21 * xy + a22 * yy + a23 * yz,
        a21 * xz + a22 * yz + a23 * zz,
    )
    p31, p32, p33 = (
        a31 * xx + a32 * xy + a33 * xz,
        a31 * xy + a32 * yy + a33 * yz,
        a31 * xz + a32 * yz + a33 * zz,
    )
    return (
        mass,
        _moved(frame, centre),
        (
            p11 * a11 + p12 * a12 + p13 * a13,
            p11 * a21 + p12 * a22 + p13 * a23,
            p11 * a31 + p12 * a32 + p13 * a33,
            p21 * a21 + p22 * a22 + p23 * a23,
            p21 * a31 + p22 * a32 + p23 * a33,
            p31 * a31 + p32 * a32 + p33 * a33,
        ),
    )
