"""Merge massless: the joints of a massless link go to the body after it, as one chain.

Beyond the method, which chains only joints with nothing between them.  A shift between two joints
may move to a place where it costs nothing, since it commutes with a prismatic joint, and with a
rotation about its own direction.  So the part of the shift along the first joint's axis goes
before this joint, into the anchor point; the part along the second joint's axis goes after this
joint, into the body::

    URDF    R(u) ------------ shift a u + b v ------------ R(v)
                              massless link
    .mbs    shift a u --- R(u) R(v) --- shift b v
            anchor point                body

Then the body's frame is not at the link's frame; the report has its pose.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

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

#: Axes are parallel if the squared sine of their angle is below this.
PARALLEL = 1e-6


class MergeMassless(Pass):
    """Give the joints of massless links to the bodies after them."""

    reads = ("robot", "bodies")
    writes = ("bodies",)

    def run(self, conversion: Conversion) -> None:
        """Merge from the base outwards: a body gets the joints of the massless one before it."""
        children: dict[str, dict[str, Segment]] = {link: {} for link in conversion.segments}
        for segment in conversion.segments.values():
            if segment.parent is not None:
                children[segment.parent][segment.link] = segment
        merged_links: set[str] = set()
        for segment in conversion.segments.values():
            if segment.parent is None or len(children[segment.link]) != 1:
                continue
            (body,) = children[segment.link].values()
            if _is_bare_link(segment, conversion) and _merge_segment(
                segment, body, children[body.link]
            ):
                siblings = children[segment.parent]
                del siblings[segment.link]
                siblings[body.link] = body
                body.parent = segment.parent
                merged_links.add(segment.link)
        if merged_links:
            segments = conversion.segments.items()
            conversion.regroup(
                {link: segment for link, segment in segments if link not in merged_links}
            )


def _is_bare_link(segment: Segment, conversion: Conversion) -> bool:
    """Return True if a segment is one massless link, without visual and other links' frames."""
    link = conversion.robot.links[segment.link]
    return list(segment.parts) == [segment.link] and link.massless and not link.visuals


def _merge_segment(segment: Segment, body: Segment, children: dict[str, Segment]) -> bool:
    """Put the joints of a segment before those of a body, if the shift between can be moved.

    Args:
        segment: The segment of a massless link.
        body: The only segment that is attached to it.
        children: The segments that are attached to the body.

    Returns:
        False if the shift cannot be moved; then nothing is changed.
    """
    last_step, first_step = segment.steps[-1], body.steps[0]
    split = _choose_split(segment, body)
    if split is None:
        return False
    if split.before != ZERO:
        last_step.xyz = add(last_step.xyz, rotate(from_turns(last_step.turns), split.before))
    if split.after != ZERO:
        shift = rotate(transpose(from_turns(first_step.turns)), split.after)
        body.parts = {
            link: Pose(add(shift, pose.xyz), pose.rot) for link, pose in body.parts.items()
        }
        for child in children.values():
            child.steps[0].xyz = add(shift, child.steps[0].xyz)
    first_step.xyz = ZERO
    # The frame after the last joint was displaced by ``split.before``, but not the link's frame.
    (link_pose,) = segment.parts.values()
    x, y, z = split.before
    last_step.frames = {segment.link: Pose(add(link_pose.xyz, (-x, -y, -z)), link_pose.rot)}
    segment.steps.extend(body.steps)
    body.steps = segment.steps
    return True


class Split(NamedTuple):
    """A shift between two joints, in two parts (m), in the frame between the joints."""

    before: Vec
    """The part that may go before the first joint."""
    after: Vec
    """The part that may go after the second joint."""


def _choose_split(segment: Segment, body: Segment) -> Split | None:
    """Choose how to split the shift before a body's first joint; None if it cannot be moved.

    A part goes out to the anchor point, or into the body itself, and never between two joints.
    """
    last_step, first_step = segment.steps[-1], body.steps[0]
    if first_step.xyz == ZERO:
        return Split(ZERO, ZERO)
    for split in _list_splits(last_step, first_step):
        fits_before = split.before == ZERO or len(segment.steps) == 1
        fits_after = split.after == ZERO or len(body.steps) == 1
        if fits_before and fits_after:
            return split
    return None


def _list_splits(last_step: Step, first_step: Step) -> Iterator[Split]:
    """List the splits of the shift between two joints.

    With u and v the axes of the joints, both parts are found by least squares for
    ``shift = a u + b v``, whose normal equations are ``a + (u.v) b = shift.u`` and
    ``(u.v) a + b = shift.v``.

    Args:
        last_step: The joint before the shift.
        first_step: The joint after it, which begins with the shift.
    """
    shift = first_step.xyz
    u = direction(last_step.axis)
    v = rotate(from_turns(first_step.turns), direction(first_step.axis))
    if _commutes(shift, first_step, v):
        yield Split(ZERO, shift)
    if _commutes(shift, last_step, u):
        yield Split(shift, ZERO)
    if {last_step.joint.type, first_step.joint.type} & {"prismatic", "floating"}:
        return
    u_dot_v, shift_dot_u, shift_dot_v = dot(u, v), dot(shift, u), dot(shift, v)
    determinant = 1.0 - u_dot_v * u_dot_v
    if determinant < PARALLEL:
        return
    a, b = (
        (shift_dot_u - u_dot_v * shift_dot_v) / determinant,
        (shift_dot_v - u_dot_v * shift_dot_u) / determinant,
    )
    residual = (
        shift_component - a * u_component - b * v_component
        for shift_component, u_component, v_component in zip(shift, u, v, strict=True)
    )
    if max(map(abs, residual)) <= ROUNDING * max(map(abs, shift)):
        yield Split((a * u[0], a * u[1], a * u[2]), (b * v[0], b * v[1], b * v[2]))


def _commutes(shift: Vec, step: Step, axis: Vec) -> bool:
    """Return True if a shift before a joint's motion is the same as the shift after the motion."""
    if step.joint.type in ("prismatic", "floating"):
        return step.joint.type == "prismatic"
    return max(map(abs, cross(shift, axis))) <= ROUNDING * max(map(abs, shift))
