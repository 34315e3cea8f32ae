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
        lumped_segments: dict[str, LumpedSegment] = {}
        for segment in conversion.segments.values():
            if segment.parent is None:
                segments[segment.link] = segment
                lumped_segments[segment.link] = LumpedSegment(segment, HERE)
                continue
            is_only_body = nothing_moves and len(segments) == 1
            must_stay = is_only_body or fits(segment.link, self.keep)
            target_segment, offset = _lump_segment(
                segment, lumped_segments[segment.parent], must_stay=must_stay
            )
            lumped_segments[segment.link] = LumpedSegment(target_segment, offset)
            if target_segment is segment:
                segments[segment.link] = segment
        conversion.regroup(segments)


class LumpedSegment(NamedTuple):
    """Where the frame of a former segment is."""

    segment: Segment
    pose: Pose
    """Of the former segment's frame in this segment's frame."""


def _lump_segment(
    segment: Segment, lumped_parent: LumpedSegment, *, must_stay: bool
) -> LumpedSegment:
    """Remove the fixed joints of a segment, and lump it with its parent if none remains.

    Args:
        segment: The segment, which is changed.
        lumped_parent: Where the frame of its parent is.
        must_stay: True if the last joint must remain.

    Returns:
        Where the frame of the segment is: in itself, or in the segment that it is lumped with.
    """
    target_segment, offset = lumped_parent
    kept_steps: list[Step] = []
    for step in segment.steps:
        step_pose = compose(offset, Pose(step.xyz, from_turns(step.turns)))
        is_last_chance = not kept_steps and step is segment.steps[-1]
        if step.joint.moves or step.measured or (is_last_chance and must_stay):
            if offset is not HERE:
                step.xyz, step.turns = step_pose.xyz, fewest_turns(step_pose.rot)
            kept_steps.append(step)
            offset = HERE
        else:
            # The links after a fixed joint are rigid with those before it.
            rigid_links = kept_steps[-1].frames if kept_steps else target_segment.parts
            rigid_links.update(
                (link, compose(step_pose, frame_pose)) for link, frame_pose in step.frames.items()
            )
            offset = step_pose
    link_poses = {link: compose(offset, link_pose) for link, link_pose in segment.parts.items()}
    if not kept_steps:
        target_segment.parts.update(link_poses)
        return LumpedSegment(target_segment, offset)
    segment.steps, segment.parts, segment.parent = kept_steps, link_poses, target_segment.link
    return LumpedSegment(segment, offset)
