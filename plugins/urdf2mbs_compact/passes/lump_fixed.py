"""Lump fixed: links joined by fixed joints become one body.

Beyond the method, whose Table A.1 makes every fixed joint a T3 driven at 0.  Mass, centre and
inertia add up by the parallel-axis theorem.  The frames of the lumped links stay, as anchor points
with the links' names, and their visuals move along.  Links fixed to the ground become part of the
ground.  If nothing moves, one link stays a body, since an .mbs needs a body.
"""

from __future__ import annotations

from typing import NamedTuple

from urdf2mbs.plugin import (
    HERE,
    Conversion,
    Pass,
    Pose,
    Segment,
    Step,
    compose,
    fewest_turns,
    fits,
    from_turns,
)


class LumpFixed(Pass):
    """Make one body of links that fixed joints join."""

    reads = ("bodies",)
    writes = ("bodies",)

    keep: list[str] = []
    """Patterns of links that stay bodies, on a T3 driven at 0, though a fixed joint holds them."""

    def run(self, conversion: Conversion) -> None:
        """Lump each segment, parents first, unless it moves or has to stay."""
        nothing_moves = not any(step.joint.moves for step in conversion.steps())
        segments: dict[str, Segment] = {}
        lumped: dict[str, Lumped] = {}
        for segment in conversion.segments.values():
            if segment.parent is None:
                segments[segment.link] = segment
                lumped[segment.link] = Lumped(segment, HERE)
                continue
            is_only_body = nothing_moves and len(segments) == 1
            must_stay = is_only_body or fits(segment.link, self.keep)
            target, offset = _lump(segment, lumped[segment.parent], must_stay=must_stay)
            lumped[segment.link] = Lumped(target, offset)
            if target is segment:
                segments[segment.link] = segment
        conversion.regroup(segments)


class Lumped(NamedTuple):
    """Where the frame of a former segment is."""

    segment: Segment
    pose: Pose
    """Of the former segment's frame in this segment's frame."""


def _lump(segment: Segment, parent: Lumped, *, must_stay: bool) -> Lumped:
    """Remove the fixed joints of a segment, and lump it with its parent if none remains.

    Args:
        segment: The segment, which is changed.
        parent: Where the frame of its parent is.
        must_stay: True if the last joint must remain.

    Returns:
        Where the frame of the segment is: in itself, or in the segment that it is lumped with.
    """
    target, offset = parent
    steps: list[Step] = []
    for step in segment.steps:
        pose = compose(offset, Pose(step.xyz, from_turns(step.turns)))
        is_last_chance = not steps and step is segment.steps[-1]
        if step.joint.moves or step.measured or (is_last_chance and must_stay):
            if offset is not HERE:
                step.xyz, step.turns = pose.xyz, fewest_turns(pose.rot)
            steps.append(step)
            offset = HERE
        else:
            # The links after a fixed joint are rigid with those before it.
            rigid_links = steps[-1].frames if steps else target.parts
            rigid_links.update((link, compose(pose, frame)) for link, frame in step.frames.items())
            offset = pose
    parts = {link: compose(offset, pose) for link, pose in segment.parts.items()}
    if not steps:
        target.parts.update(parts)
        return Lumped(target, offset)
    segment.steps, segment.parts, segment.parent = steps, parts, target.link
    return Lumped(segment, offset)
