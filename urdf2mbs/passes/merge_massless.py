"""Merge massless: the joints of a massless link go to the body behind it, as one chain.

Beyond the method, where only what has nothing at all between its joints is chained.  A shift
between two joints may be moved to where it costs nothing: a shift commutes with a prismatic
joint, and with a turn about its own direction.  So what lies along the first joint's axis goes
before it, into the anchor point, and what lies along the second's goes after it, into the body,
whose frame then no longer stands where the link's does (the report says where).
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion, Segment, Step
from urdf2mbs.hookspecs import NoOptions, Pass
from urdf2mbs.spatial import (
    HERE,
    ROUNDING,
    ZERO,
    Pose,
    Vec,
    add,
    direction,
    from_turns,
    rotate,
    transpose,
)


def run(conversion: Conversion, options: NoOptions) -> None:
    children: dict[str, list[Segment]] = {}
    for segment in conversion.segments.values():
        if segment.parent is not None:
            children.setdefault(segment.parent, []).append(segment)
    gone: set[str] = set()
    # from the tips back: a body takes the joints of the massless one before it, and so on
    for segment in reversed(list(conversion.segments.values())):
        behind = children.get(segment.link, [])
        if segment.parent is None or len(behind) != 1 or not _bare(segment, conversion):
            continue
        body = behind[0]
        if _join(segment, body, children.get(body.link, [])):
            body.parent = segment.parent
            siblings = children[segment.parent]
            siblings[siblings.index(segment)] = body
            gone.add(segment.link)
    if gone:
        conversion.segments = {
            link: segment for link, segment in conversion.segments.items() if link not in gone
        }
        conversion.mbs.bodies = [
            s.body for s in conversion.segments.values() if s.parent is not None
        ]


def _bare(segment: Segment, conversion: Conversion) -> bool:
    """Nothing but the frame of one massless link: no mass, visual or further frame."""
    link = conversion.robot.links[segment.link]
    return list(segment.parts) == [segment.link] and link.massless and not link.visuals


def _join(segment: Segment, body: Segment, carried: list[Segment]) -> bool:
    """Put the segment's joints before the body's, if all that lies between can be moved."""
    last, first = segment.steps[-1], body.steps[0]
    if not (last.joint.moves and first.joint.moves):
        return False
    after: Vec = ZERO
    if first.xyz != ZERO:
        parted = _part(last, first)
        # only into the body itself, and only out to the anchor point
        if parted is None:
            return False
        before, after = parted
        if before != ZERO and len(segment.steps) > 1:
            return False
        if after != ZERO and len(body.steps) > 1:
            return False
        last.xyz = add(last.xyz, rotate(from_turns(last.turns), before))
        first.xyz = ZERO
        if after != ZERO:
            shift = rotate(transpose(from_turns(first.turns)), after)
            body.parts = {
                link: Pose(add(shift, pose.xyz), pose.rot) for link, pose in body.parts.items()
            }
            for child in carried:
                child.steps[0].xyz = add(shift, child.steps[0].xyz)
        back = Pose((-before[0], -before[1], -before[2]))
    else:
        back = HERE
    last.frames = {segment.link: back}
    body.steps = segment.steps + body.steps
    return True


def _part(last: Step, first: Step) -> tuple[Vec, Vec] | None:
    """The shift between two joints as one that commutes with the first of them and one that
    commutes with the second, both in the frame between; None where it is no such sum."""
    shift = first.xyz
    if last.joint.type == "prismatic":
        return shift, ZERO
    if first.joint.type == "prismatic":
        return ZERO, shift
    if {last.joint.type, first.joint.type} & {"floating", "planar"}:
        return None
    u = direction(last.axis)
    v = rotate(from_turns(first.turns), direction(first.axis))
    # least squares for shift = a u + b v
    uv = sum(p * q for p, q in zip(u, v, strict=True))
    su = sum(p * q for p, q in zip(shift, u, strict=True))
    sv = sum(p * q for p, q in zip(shift, v, strict=True))
    det = 1.0 - uv * uv
    a, b = ((su - uv * sv) / det, (sv - uv * su) / det) if det > 1e-6 else (su, 0.0)
    x, y, z = (s - a * p - b * q for s, p, q in zip(shift, u, v, strict=True))
    if max(abs(x), abs(y), abs(z)) > ROUNDING * max(map(abs, shift)):
        return None
    return (a * u[0], a * u[1], a * u[2]), (b * v[0], b * v[1], b * v[2])


PASS = Pass("merge-massless", run, needs=("bodies",), gives=("merged",))
