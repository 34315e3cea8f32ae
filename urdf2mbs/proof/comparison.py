"""Two sides of a robot, group by group: how each moves, what each weighs, where its frames are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from math import dist
from typing import Any

from urdf2mbs.mbs.model import Base, Body, LinkFrame, Mbs
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.proof import rigid
from urdf2mbs.proof.groups import Group, Side
from urdf2mbs.proof.pair import POSITIONS, Pair, settle
from urdf2mbs.proof.rigid import HERE, ORIGIN, UNTURNED, Frame, Inertia
from urdf2mbs.proof.shapes import (
    Solid,
    describe_deviation,
    find_nearest,
    solid_of_shape,
    solids_of_visual,
)
from urdf2mbs.proof.urdf_side import at_origin
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.spatial import fewest_turns
from urdf2mbs.urdf.model import Robot

#: Why a shape that is elsewhere makes no other robot.
MASSLESS_SHAPE = "a shape has no mass"
#: Why a visual is not compared.
NOT_DRAWN = "the .mbs has no shape of their kind and size there"


class Comparison:
    """Compares two robots, group by group."""

    def __init__(
        self, one: Side, two: Side, names: Mapping[str, str], frames: Mapping[str, LinkFrame],
        tolerance: float,
    ) -> None:  # fmt: skip
        """``names`` maps the coordinates that move on both sides; ``frames`` says where links are
        meant to be."""
        self.one, self.two = one, two
        self.frames = frames
        self.tolerance = tolerance
        self.found: list[Difference] = []
        self.elsewhere: list[Difference] = []
        self.largest = dict.fromkeys(("gravity", "motion", "mass", "centre", "inertia"), 0.0)
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

    def _differ(self, kind: str, message: str, size: float, **more: Any) -> None:
        self.found.append(Difference(kind, message, size, **more))

    def _beyond(self, off: float) -> bool:
        """True if a deviation is a difference; NaN is a difference."""
        return not off <= self.tolerance

    def proof(self, but_for: dict[str, str], not_compared: dict[str, str]) -> Proof:
        """The result of the comparison."""
        proof = Proof(
            same=True, positions=POSITIONS, groups=len(self.one.groups), largest=self.largest,
            differences=[], frames=sorted(self.elsewhere, key=lambda found: -found.size),
            urdf_mass=self.one.mass, mbs_mass=self.two.mass,
            but_for=but_for, not_compared=not_compared,
        )  # fmt: skip
        proof.differ(self.found)
        return proof

    def compare_gravity(self) -> None:
        """Compare gravity, relative to its largest component."""
        ours, theirs = self.one.gravity, self.two.gravity
        off = rigid.most(ours, theirs, max(map(abs, (*ours, *theirs))) or 1.0)
        self.largest["gravity"] = off
        if self._beyond(off):
            said = f"gravity is {_short(theirs)}, and should be {_short(ours)} m/s^2"
            self._differ("gravity", said, off, urdf=ours, mbs=theirs)

    # --- group by group ---

    def compare_groups(self) -> None:
        """Compare the motion of each group on the group before it, and its mass and inertia.

        Each joint is compared by itself, so each difference is named where it arises.  All poses
        are products of the joints' poses.
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
                before = rigid.compose(rigid.inverse(world[pairs[ours.parent]]), world[other])
            pair = Pair(
                ours, theirs, rigid.compose(self.apart[ours.parent], ours.before), before,
                rigid.merge(ours.inertias), rigid.merge(theirs.inertias), self.scales[mine],
                partial(self._carried, mine),
            )  # fmt: skip
            link = leader.get(mine)
            if hangs:
                told = f"joint '{ours.joint}' stands after another joint in the .mbs"
                if not self.found or self.found[-1].message != told:  # once for all coordinates
                    self._differ("parent", told, 1.0, link=ours.child, joint=ours.joint)
            self.apart[mine] = self._place(pair, other, link, hangs)
            self._inertia(pair, self.apart[mine])

    def _carried(self, mine: int) -> list[tuple[Group, Group]]:
        """The pairs of groups that hang on a pair."""
        groups, other = self.two.groups, self.pairs[mine]
        pairs = [(self.one.groups[n], groups[self.pairs[n]]) for n in self.one.groups[mine].carries]
        return [(ours, theirs) for ours, theirs in pairs if theirs.parent == other]

    def _place(self, pair: Pair, other: int, link: str | None, hangs: bool) -> Frame:
        """The constant pose of a group in its counterpart; tells what of the motion differs."""
        at = self.frames.get(link) if link is not None else None
        meant: Frame | None = None
        if at is not None:
            group, pose = self._meant(at)
            if group == other:
                meant = HERE if pose == HERE else pose
        place = pair.placed() if meant is None else meant
        motion = 0.0 if hangs else pair.motion(place)
        plain = meant is not None or max(pair.inertia(place).values()) <= self.tolerance
        if self._beyond(motion) or not plain:
            place = settle(pair, pair.placed(), meant, self.tolerance)
            motion = 0.0 if hangs else pair.motion(place)
        self.largest["motion"] = max(self.largest["motion"], motion)
        if self._beyond(motion):
            self._tell_motion(pair, place, motion)
        return place

    def _tell_motion(self, pair: Pair, place: Frame, motion: float) -> None:
        """Name a difference in motion: a joint's zero, a link put elsewhere, or an axis."""
        ours, theirs, name = pair.ours, pair.theirs, pair.ours.joint
        link = ours.child
        where: dict[str, Any] = {"link": link, "joint": name}
        placed = pair.placed()
        off = rigid.distance(placed, place, pair.scale)
        a = rigid.turned(pair.their_before, theirs.axis)
        b = rigid.turned(pair.our_before, ours.axis)
        tilt = rigid.angle(a, b)
        if off <= self.tolerance:
            if self._beyond(tilt):
                back = rigid.inverse(self.apart[ours.parent])
                a, b = rigid.turned(back, a), rigid.turned(back, b)
                told = f"its axis is {_short(a)} in the .mbs, and should be {_short(b)}"
                told += f": {tilt:.6g} rad off"
            else:
                a, b = pair.their_before[9:], pair.our_before[9:]
                told = f"its axis is {rigid.most(a, b):.3g} m beside where it should be"
            self._differ("axis", f"joint '{name}': {told}", motion, urdf=b, mbs=a, **where)
            return
        # the link, seen from where it should be; how much of it is the joint's own motion?
        away = rigid.compose(rigid.inverse(placed), place)
        if ours.turns:
            amount = rigid.about(away, ours.axis)
            rest = rigid.compose(away, rigid.spin(ours.axis, -amount))
        else:
            amount = sum(p * q for p, q in zip(away[9:], ours.axis, strict=True))
            rest = rigid.compose(away, rigid.shift(ours.axis, -amount))
        left = rigid.distance(rest, HERE, pair.scale)
        if left <= max(self.tolerance, 1e-3 * off):
            unit = "rad" if ours.turns else "m"
            told = f"joint '{name}': its zero is the URDF's {amount:.6g} {unit}"
            if self._beyond(left):
                told += f", and link '{link}' is {_in_words(rest)}"
            self._differ("zero", told, off, urdf=0.0, mbs=amount, **where)
            return
        told = f"link '{link}': joint '{name}' puts it elsewhere, {_in_words(away)}"
        if theirs.held:
            told += f" (driven before it: {', '.join(theirs.held)})"
        if self._beyond(tilt):
            told += f"; its axis is {tilt:.3g} rad off"
        self._differ("frame", told, off, **where)

    def _inertia(self, pair: Pair, place: Frame) -> None:
        """Compare what a pair of groups weighs, where, and how it resists turning."""
        apart = pair.inertia(place)
        for kind, off in apart.items():
            self.largest[kind] = max(self.largest[kind], off)
        most = max(apart.values())
        if not self._beyond(most):
            return
        joint = pair.ours.joint
        link = pair.ours.child
        lost = self._lost(pair)
        before = len(self.found)
        for name in lost:
            mass = dict(pair.ours.inertias)[name][0]
            told = f"link '{name}': its {_short(mass)} kg are not in the .mbs"
            self._differ(
                "mass", told, mass / (pair.our_inertia[0] or 1.0),
                link=name, joint=joint, urdf=mass, mbs=0.0,
            )  # fmt: skip
        for names, ours, theirs in self._parts(pair, lost):
            ours = rigid.seen(ours, place)
            names = names or [link]
            who = ("link " if len(names) == 1 else "links ") + " + ".join(
                f"'{name}'" for name in names[:3]
            )
            if len(names) > 3:
                who += f" and {len(names) - 3} more"
            offs = rigid.inertias_apart(ours, theirs, pair.scale)
            for index, (kind, off) in enumerate(offs.items()):
                if self._beyond(off):
                    a, b = ours[index], theirs[index]
                    told = f"{who}: {kind} is {_short(b)} in the .mbs, "
                    told += f"and should be {_short(a)}"
                    self._differ(kind, told, off, link=names[0], joint=joint, urdf=a, mbs=b)
        if len(self.found) == before:  # only in sum, as where two were exchanged
            self._differ("inertia", f"link '{link}': inertia", most, link=link, joint=joint)

    def _lost(self, pair: Pair) -> list[str]:
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

    def _parts(self, pair: Pair, lost: list[str]) -> list[tuple[list[str], Inertia, Inertia]]:
        """A pair of groups, body by body if it is known which link is in which: links, their
        inertia, and the body's."""
        ours = [(name, i) for name, i in pair.ours.inertias if name not in lost]
        names = [name for name, _ in ours]
        whole = [(names, rigid.merge(ours), pair.their_inertia)]
        bodies: dict[str, list[tuple[str, Inertia]]] = {}
        for name, inertia in ours:
            bodies.setdefault(self._body(name) or "", []).append((name, inertia))
        theirs = dict(pair.theirs.inertias)
        if "" in bodies or not bodies.keys() >= theirs.keys():
            return whole
        nothing = rigid.merge([])
        return [
            ([name for name, _ in links], rigid.merge(links), theirs.get(body, nothing))
            for body, links in bodies.items()
        ]

    # --- frames and points ---

    def _meant(self, at: LinkFrame) -> tuple[int, Frame]:
        """The group in the .mbs that a link's frame should be in (-1: there is none), and the
        pose in this group."""
        nowhere = (-1, HERE)
        if at.joint is not None:
            group, pose = self.two.after.get(at.joint, nowhere)
        else:
            group, pose = self.two.frames.get(at.body or "", nowhere)
        if at.pose.xyz != ORIGIN or at.pose.rot != UNTURNED:
            pose = rigid.compose(pose, (*at.pose.rot, *at.pose.xyz))
        return group, pose

    def compare_frames(self) -> None:
        """Compare where each link's frame is with where it is said to be."""
        for link, at in self.frames.items():
            if link not in self.one.frames:
                continue
            group, pose = self.one.frames[link]
            other, theirs = self._meant(at)
            if self.pairs[group] != other:
                name = at.joint or at.body or ""
                told = "moves with another body" if other >= 0 else f"there is no '{name}'"
                self.elsewhere.append(Difference("frame", f"link '{link}': {told}", link=link))
                continue
            ours = rigid.compose(self.apart[group], pose)
            off = rigid.distance(ours, theirs, self.scales[group])
            self.largest["frame"] = max(self.largest.get("frame", 0.0), off)
            if self._beyond(off):
                told = _in_words(rigid.compose(rigid.inverse(ours), theirs))
                self.elsewhere.append(
                    Difference("frame", f"link '{link}': its frame is {told}", off, link=link)
                )

    def compare_points(self, mbs: Mbs) -> None:
        """Compare the anchor points named after links that are rigid with the point's body."""
        links = _one_spelling(self.one.frames)
        for (body, _), point in mbs.points().items():
            other, at = self.two.frames[body or ""]
            link = links.get(point.name)
            if link is None:
                continue
            group, pose = self.one.frames[link]
            if self.pairs[group] != other:
                continue
            ours = rigid.moved(self.apart[group], pose[9:])
            theirs = rigid.moved(at, point.coordinates)
            off = rigid.most(ours, theirs, self.scales[group])
            if self._beyond(off):
                told = f"link '{link}': point '{point.name}' of body '{body}' is "
                told += f"{dist(ours, theirs):.3g} m off its frame"
                self.elsewhere.append(Difference("point", told, off, link=link))

    def compare_shapes(self, robot: Robot, mbs: Mbs) -> tuple[dict[str, str], dict[str, str]]:
        """Compare where the shapes of an .mbs are with the visuals of the URDF.

        Args:
            robot: The robot of the URDF.
            mbs: The model whose shapes are compared; its bodies are those of the .mbs.

        Returns:
            Visuals that are elsewhere, and links with visuals that the .mbs does not have, each
            with the reason.
        """
        drawn: dict[int, list[Solid]] = {}
        holders: list[Base | Body] = [mbs.base, *mbs.bodies]
        for holder in holders:
            name = holder.name if isinstance(holder, Body) else ""
            group, frame = self.two.frames.get(name, (-1, HERE))
            solids = (solid_of_shape(shape, frame) for shape in holder.shapes)
            drawn.setdefault(group, []).extend(solid for solid in solids if solid is not None)
        elsewhere: dict[str, str] = {}
        missing: dict[str, str] = {}
        for link, (group, pose) in self.one.frames.items():
            scale = self.scales[group]
            for visual in robot.links[link].visuals:
                frame = rigid.compose(self.apart[group], at_origin(pose, visual.origin))
                for solid in solids_of_visual(visual.geometry, frame):
                    nearest = find_nearest(solid, drawn.get(self.pairs[group], []), scale)
                    if nearest is None:
                        missing[f"visuals of link '{link}'"] = NOT_DRAWN
                    elif deviation := describe_deviation(solid, nearest, scale):
                        elsewhere[f"visual of link '{link}' {deviation}"] = MASSLESS_SHAPE
        return elsewhere, missing


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


def _in_words(apart: Frame) -> str:
    """A frame in words: the turns that lead to it (rad), and its shift (m)."""
    turns = ", ".join(
        f"{angle:.6g} about {'xyz'[k - 1]}" for k, angle in fewest_turns(apart[:9], 1e-10)
    )
    most = max(map(abs, apart[9:]))
    shift = ", ".join(f"{c if abs(c) > 1e-9 * most else 0.0:.6g}" for c in apart[9:])
    parts = [f"turned by {turns}"] * bool(turns) + [f"shifted by ({shift})"] * (most > 1e-12)
    return " and ".join(parts) or "slightly off"
