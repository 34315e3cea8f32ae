"""A group and its counterpart: how far their motions and inertias are apart, and in which pose of
one in the other they agree best."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, hypot, log10, pi
from random import Random

import msgspec

from urdf2mbs.proof.groups import Group
from urdf2mbs.proof.rigid import (
    HERE,
    Frame,
    Inertia,
    across,
    between_axes,
    compose,
    cross,
    distance,
    dot,
    inertias_apart,
    inverse,
    moved,
    seen,
    spin,
    turned,
)

#: What a difference must exceed to count, relative to the scale of what is compared.
TOLERANCE = 1e-9
#: Positions at which the motion is compared, zero included.
POSITIONS = 4
_RANDOM = Random(20)
#: These positions but zero.  Each joint is compared by itself, so all can have the same ones.
AMOUNTS = [_RANDOM.uniform(-pi, pi) for _ in range(POSITIONS - 1)]


class Pair(msgspec.Struct):
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

    def placed(self) -> Frame:
        """Our group's pose in theirs, by where the joints put both at zero."""
        if self.our_before == self.their_before:
            return HERE
        return compose(inverse(self.their_before), self.our_before)

    def motion(self, at: Frame) -> float:
        """The deviation of the motions, if ``at`` is our group's pose in theirs: of the places at
        zero, and of each motion from there, seen from its group."""
        off = distance(compose(self.their_before, at), self.our_before, self.scale)
        for amount in AMOUNTS:
            q = amount if self.ours.turns else amount * self.scale
            ours, theirs = self.ours.move(q), self.theirs.move(q)
            off = max(off, distance(compose(theirs, at), compose(at, ours), self.scale))
        return off

    def inertia(self, at: Frame) -> dict[str, float]:
        ours = self.our_inertia if at is HERE else seen(self.our_inertia, at)
        return inertias_apart(ours, self.their_inertia, self.scale)

    def misfits(self, at: Frame) -> list[float]:
        """The deviation of each thing that the groups have, if ``at`` is so: of the axis of their
        joint, of mass and inertia, and of the axes of the joints that they carry."""
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


def settle(pair: Pair, placed: Frame, meant: Frame | None, tolerance: float) -> Frame:
    """The pose of a group in its counterpart, where it is not plain: of those that come into
    question, the one in which the most of what the groups have agrees.

    ``placed`` is where the joint puts it at zero, ``meant`` where its frame is by name.  Either
    may be the one that is wrong, or both: hand-made models turn a frame so that its joint's
    axis is a coordinate axis.
    """

    def agreement(at: Frame) -> float:
        # rounded: Python 3.12 adds up otherwise, and a tie goes to the first on each Python
        return -round(sum(log10(min(max(off, TOLERANCE), 1.0)) for off in pair.misfits(at)), 6)

    choice = [placed]
    if meant is not None:
        choice += [meant, _on_axis(pair, meant)]
    best = max(choice, key=agreement)
    slid = _slid(pair, _on_axis(pair, placed))
    # one thing that does not fit is itself wrong; if two do not, it is the place
    misfits, others = (sum(not off <= tolerance for off in pair.misfits(at)) for at in (best, slid))
    return slid if misfits - others >= 2 else best


def _on_axis(pair: Pair, at: Frame) -> Frame:
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


def _slid(pair: Pair, at: Frame) -> Frame:
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
