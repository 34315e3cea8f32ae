"""Align frames: turn each body's frame so that a coordinate axis lies along its joint's axis.

Beyond the method.  The method's Table A.2 turns the frame before a joint, and turns it back after
the joint.  Turning back is never needed: whatever is constant in a body can be written in any
frame.  So centre, inertia, points, visuals and the next joints are written in the frame that the
joint leaves.  The turns before a joint bring a coordinate axis onto the joint's direction ``u``.
No turn is needed if u is +x, +y or +z.  One turn is needed if u has a zero component or is a
negative axis, else two.  The joint's coordinate stays the URDF's: same zero, same sign.

Each body's frame may have any angle about its own joint's axis.  As by Denavit and Hartenberg, the
second axis of the frame points toward the axis of the joint before; if the two are parallel, toward
the second axis of the frame before.  Four quarter turns about the joint's axis are free: dynamic
programming, from the tips of the tree to the base, finds those with the fewest turns in all.
"""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

from urdf2mbs.plugin import (
    IDENTITY,
    ROUNDING,
    Conversion,
    Pass,
    Pose,
    Rot,
    Step,
    Tolerance,
    Vec,
    axis_turns,
    cross,
    direction,
    dot,
    drop_rounding,
    fewest_turns,
    from_turns,
    multiply,
    rotate,
    transpose,
    unit,
)
from urdf2mbs.plugin import UrdfJoint as Joint

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class AlignFrames(Pass):
    reads = ("bodies",)
    writes = ("bodies",)

    tolerance: Tolerance = ROUNDING
    """A direction counts as on a coordinate axis or plane if it is at most this (rad) off.  The
    default is rounding; 1e-9 also takes angles written as 1.570796327, and says how far off they
    are."""

    def run(self, conversion: Conversion) -> None:
        places = _walk(conversion, self.tolerance)
        frames = [place.frame for place in places if place.step.joint.moves]
        for frame in reversed(frames):
            frame.count_turns(self.tolerance)
        for place in places:
            place.step.turns = ()
        for frame in frames:
            frame.choose(self.tolerance)
            if frame.step.joint.type != "floating":
                _lay_axis(conversion, frame)
        conversion.aligned = True
        conversion.report["align-frames"] = {"driven": sum(len(one.step.turns) for one in frames)}
        _write(conversion, places)


class _Frame:
    """The frame behind a moving joint; or the ground's, which cannot be turned."""

    def __init__(self, step: Step, before: _Frame | None, rot: Rot, small: float) -> None:
        self.step = step
        """The joint that moves the frame."""
        self.before = before or self
        self.rot = rot
        """The frame of the URDF's link, as seen from that of the link before, at zero."""
        self.candidates = [IDENTITY]
        """The frames to choose from, as seen from the frame of the URDF's link."""
        if step.joint.type == "planar":
            self.candidates = [from_turns(axis_turns(step.axis)[0])]
        elif step.joint.type not in ("fixed", "floating"):
            self.candidates = self._along_joint(direction(step.axis), small)
        self.costs = [0] * len(self.candidates)
        """For each candidate, the fewest turns of all joints behind."""
        self.best: list[int] = []
        """For each candidate of the frame before, the number of the best candidate here."""
        self.chosen = 0
        """The number of the candidate that is chosen."""
        self.held = IDENTITY
        """The frame of the URDF's link, as seen from the chosen frame."""

    def _along_joint(self, axis: Vec, small: float) -> list[Rot]:
        """The four frames whose x is the joint's axis, and whose y or z is on the line toward the
        first axis of the frame before, or toward its second axis."""
        a, b, _, d, e, _, g, h, _ = multiply(transpose(self.rot), self.before.candidates[0])
        across = _across((a, d, g), axis, small) or _across((b, e, h), axis, small)
        assert across is not None  # the joint is parallel to one of the two axes at most
        (x, y, z), (p, q, r) = across, cross(axis, across)
        pairs = (
            ((x, y, z), (p, q, r)), ((p, q, r), (-x, -y, -z)),
            ((-x, -y, -z), (-p, -q, -r)), ((-p, -q, -r), (x, y, z)),
        )  # fmt: skip
        return [transpose((*axis, *second, *third)) for second, third in pairs]

    def count_turns(self, small: float) -> None:
        """Add to each candidate of the frame before the fewest turns of this branch."""
        for number, frame in enumerate(self.before.candidates):
            back = multiply(transpose(frame), self.rot)
            counts = [
                cost + self._turns(multiply(back, own), small)
                for own, cost in zip(self.candidates, self.costs, strict=True)
            ]
            self.before.costs[number] += min(counts)
            self.best.append(counts.index(min(counts)))

    def _turns(self, rot: Rot, small: float) -> int:
        """The number of turns of a rotation after which the axes may be renumbered."""
        if self.step.joint.type == "floating":
            return len(fewest_turns(rot))
        # two turns leave some element zero, one turn leaves one axis where it is
        rows = rot[:3], rot[3:6], rot[6:]
        zeros = [sum(abs(c) <= small for c in row) for row in rows]
        if not any(zeros):
            return 3
        still = sum(n == 2 and sum(row) > 0.0 for n, row in zip(zeros, rows, strict=True))
        return (2, 1, 1, 0)[still]

    def choose(self, small: float) -> None:
        """Give the joint its turns; the joints before it must have theirs."""
        before = self.before
        self.chosen = self.best[before.chosen]
        rot = multiply(before.held, self.rot)
        frame = multiply(rot, self.candidates[self.chosen])
        if self.step.joint.type == "floating":  # its axes are those of the URDF
            self.step.turns = fewest_turns(frame)
        else:
            ways = (fewest_turns(_renumber(frame, by), small) for by in range(3))
            self.step.turns = min(ways, key=len)
        self.held = multiply(transpose(from_turns(self.step.turns)), rot)


class _Place(NamedTuple):
    """A step, and the frames behind it and before it."""

    step: Step
    frame: _Frame
    rot: Rot
    """The frame that the URDF has behind the step, as seen from that of ``frame``'s link."""
    before: _Frame
    rot_before: Rot


def _walk(conversion: Conversion, small: float) -> list[_Place]:
    """All steps, those nearer to the ground first."""
    ground = _Frame(Step.of(Joint("", "fixed", "", conversion.ground.link)), None, IDENTITY, small)
    ends = {conversion.ground.link: (ground, IDENTITY)}
    places: list[_Place] = []
    for link, segment in conversion.segments.items():
        if segment.parent is None:
            continue
        frame, rot = ends[segment.parent]
        for step in segment.steps:
            before, rot_before = frame, rot
            rot = multiply(rot, from_turns(step.turns))
            if step.joint.moves:
                frame, rot = _Frame(step, before, rot, small), IDENTITY
            places.append(_Place(step, frame, rot, before, rot_before))
        ends[link] = frame, rot
    return places


def _write(conversion: Conversion, places: list[_Place]) -> None:
    """Write all that is constant in a body in its new frame."""
    after: dict[int, Rot] = {}
    for step, frame, rot, before, rot_before in places:
        step.xyz = drop_rounding(rotate(multiply(before.held, rot_before), step.xyz))
        after[id(step)] = multiply(frame.held, rot)
        step.frames = _turn(after[id(step)], step.frames)
    for segment in conversion.segments.values():
        if segment.steps:
            segment.parts = _turn(after[id(segment.steps[-1])], segment.parts)


def _turn(rot: Rot, frames: dict[str, Pose]) -> dict[str, Pose]:
    return {
        link: Pose(drop_rounding(rotate(rot, pose.xyz)), multiply(rot, pose.rot))
        for link, pose in frames.items()
    }


def _lay_axis(conversion: Conversion, frame: _Frame) -> None:
    """Take the coordinate axis nearest to the joint's axis for it, and note how far off it is."""
    step = frame.step
    meant = rotate(frame.held, unit(step.axis))
    step.axis = max(AXES, key=lambda axis: dot(axis, meant))
    off = max(abs(a - b) for a, b in zip(meant, step.axis, strict=True))
    if off > ROUNDING:
        conversion.note(
            "axis-aligned",
            f"joint '{step.joint.name}': its axis is {off:.1e} rad off a coordinate "
            "axis or plane of its body, and is taken to lie on it",
            joint=step.joint.name,
        )


def _across(v: Vec, axis: Vec, small: float) -> Vec | None:
    """The direction of the part of v at right angles to the axis; None if v is along the axis."""
    for _ in range(2):  # if v is nearly along the axis, the second round removes the rounding
        along = dot(v, axis)
        x, y, z = (part - along * a for part, a in zip(v, axis, strict=True))
        length = hypot(x, y, z)
        if length <= small:
            return None
        v = (x / length, y / length, z / length)
    return v


def _renumber(rot: Rot, by: int) -> Rot:
    """The same frame with its axes renumbered: x, y, z become y, z, x if ``by`` is 1, and so on."""
    a, b, c, d, e, f, g, h, i = rot
    return (rot, (c, a, b, f, d, e, i, g, h), (b, c, a, e, f, d, h, i, g))[by]
