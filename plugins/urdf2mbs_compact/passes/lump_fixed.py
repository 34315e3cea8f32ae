"""Lump fixed: links joined by fixed joints become one body.

Beyond the method, whose Table A.1 makes every fixed joint a T3 driven at 0.  Mass, centre and
inertia add up by the parallel-axis theorem.  The frames of the lumped links stay, as anchor points
under the links' names, and their visuals move along.  Links fixed to the ground become part of the
ground.  If nothing moves, one link stays a body, since an .mbs needs a body.
"""

from __future__ import annotations

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
    reads = ("bodies",)
    writes = ("bodies",)

    keep: list[str] = []
    """Patterns of links that stay bodies, on a T3 driven at 0, though a fixed joint holds them."""

    def run(self, conversion: Conversion) -> None:
        kept: dict[str, Segment] = {}
        moved: dict[str, tuple[Segment, Pose]] = {}
        """Where each old segment's frame is now."""
        still = not any(step.joint.moves for step in conversion.steps())
        for segment in conversion.segments.values():
            if segment.parent is None:
                kept[segment.link] = segment
                moved[segment.link] = (segment, HERE)
                continue
            holder, offset = moved[segment.parent]
            steps: list[Step] = []
            for step in segment.steps:
                pose = compose(offset, Pose(step.xyz, from_turns(step.turns)))
                carried = {link: compose(pose, at) for link, at in step.frames.items()}
                needed = not steps and step is segment.steps[-1]
                stays = needed and (fits(segment.link, self.keep) or (still and len(kept) == 1))
                if step.joint.moves or step.measured or stays:
                    if offset is not HERE:
                        step.xyz, step.turns = pose.xyz, fewest_turns(pose.rot)
                    steps.append(step)
                    offset = HERE
                else:
                    # the frames after a fixed joint move with the frame before it
                    (steps[-1].frames if steps else holder.parts).update(carried)
                    offset = pose
            parts = {link: compose(offset, at) for link, at in segment.parts.items()}
            if steps:
                segment.steps, segment.parts, segment.parent = steps, parts, holder.link
                kept[segment.link] = segment
                moved[segment.link] = (segment, offset)
            else:
                holder.parts.update(parts)
                moved[segment.link] = (holder, offset)
        conversion.regroup(kept)
