"""Merge massless: the joints of a massless link go to the body behind it, as one chain.

Beyond the method, which chains only joints with nothing between them.  A shift between two joints
may move to a place where it costs nothing: a shift commutes with a prismatic joint, and with a turn
about the direction of the shift.  So the part of the shift along the first joint's axis goes before
this joint, into the anchor point.  The part along the second joint's axis goes after this joint,
into the body.  Then the body's frame is not at the link's frame; the report has its place.
"""

from __future__ import annotations

from collections.abc import Iterator

from urdf2mbs.plugin import (
    ROUNDING,
    ZERO,
    Conversion,
    Pass,
    Pose,
    Segment,
    Step,
    Vec,
    add,
    cross,
    direction,
    dot,
    from_turns,
    rotate,
    transpose,
)


class MergeMassless(Pass):
    reads = ("robot", "bodies")
    writes = ("bodies",)

    def run(self, conversion: Conversion) -> None:
        children: dict[str, dict[str, Segment]] = {link: {} for link in conversion.segments}
        for segment in conversion.segments.values():
            if segment.parent is not None:
                children[segment.parent][segment.link] = segment
        gone: set[str] = set()
        # from the base outwards: a body takes the joints of the massless one before it, and so on
        for segment in conversion.segments.values():
            if segment.parent is None or len(children[segment.link]) != 1:
                continue
            (body,) = children[segment.link].values()
            if _bare(segment, conversion) and _join(segment, body, children[body.link]):
                siblings = children[segment.parent]
                del siblings[segment.link]
                siblings[body.link] = body
                body.parent = segment.parent
                gone.add(segment.link)
        if gone:
            conversion.regroup(
                {link: segment for link, segment in conversion.segments.items() if link not in gone}
            )


def _bare(segment: Segment, conversion: Conversion) -> bool:
    """True if the segment is a massless link alone: no visual, and no other link's frame."""
    link = conversion.robot.links[segment.link]
    return list(segment.parts) == [segment.link] and link.massless and not link.visuals


def _join(segment: Segment, body: Segment, carried: dict[str, Segment]) -> bool:
    """Put the segment's joints before the body's, if all that lies between can be moved."""
    last, first = segment.steps[-1], body.steps[0]
    before, after = ZERO, ZERO
    if first.xyz != ZERO:
        for before, after in _splits(last, first):
            # only out to the anchor point, and only into the body itself
            if (before == ZERO or len(segment.steps) == 1) and (
                after == ZERO or len(body.steps) == 1
            ):
                break
        else:
            return False
    if before != ZERO:
        last.xyz = add(last.xyz, rotate(from_turns(last.turns), before))
    if after != ZERO:
        shift = rotate(transpose(from_turns(first.turns)), after)
        body.parts = {
            link: Pose(add(shift, pose.xyz), pose.rot) for link, pose in body.parts.items()
        }
        for child in carried.values():
            child.steps[0].xyz = add(shift, child.steps[0].xyz)
    first.xyz = ZERO
    # where the link's frame is in the frame after its joint, which `before` has displaced
    (pose,) = segment.parts.values()
    x, y, z = add(pose.xyz, (-before[0], -before[1], -before[2]))
    last.frames = {segment.link: Pose((x, y, z), pose.rot)}
    segment.steps.extend(body.steps)
    body.steps = segment.steps
    return True


def _splits(last: Step, first: Step) -> Iterator[tuple[Vec, Vec]]:
    """The ways to split the shift between two joints in two: a part that may go before the first
    joint, and one that may go after the second.  Both are in the frame between the joints."""
    shift = first.xyz
    u = direction(last.axis)
    v = rotate(from_turns(first.turns), direction(first.axis))
    if _commutes(shift, first, v):
        yield ZERO, shift
    if _commutes(shift, last, u):
        yield shift, ZERO
    if {last.joint.type, first.joint.type} & {"prismatic", "floating"}:
        return
    # least squares for shift = a u + b v
    uv, su, sv = dot(u, v), dot(shift, u), dot(shift, v)
    det = 1.0 - uv * uv
    if det < 1e-6:
        return
    a, b = (su - uv * sv) / det, (sv - uv * su) / det
    x, y, z = (s - a * p - b * q for s, p, q in zip(shift, u, v, strict=True))
    if max(abs(x), abs(y), abs(z)) <= ROUNDING * max(map(abs, shift)):
        yield (a * u[0], a * u[1], a * u[2]), (b * v[0], b * v[1], b * v[2])


def _commutes(shift: Vec, step: Step, axis: Vec) -> bool:
    """True if a shift before the joint's motion is the same as the shift after the motion."""
    if step.joint.type in ("prismatic", "floating"):
        return step.joint.type == "prismatic"
    return max(map(abs, cross(shift, axis))) <= ROUNDING * max(map(abs, shift))
