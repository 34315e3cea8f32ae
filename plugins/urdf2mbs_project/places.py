"""Places of a model's points, the joints that move a body, and the body that floats."""

from __future__ import annotations

from urdf2mbs.plugin import Body, Mbs, Placement, Vec, add, rotate


def point_at(placement: Placement, mbs: Mbs, body: str | None, point: str | None) -> Vec:
    """The place of an anchor point (m, in the base); None is the body's own frame."""
    pose = placement.bodies[body]
    if point is None:
        return pose.xyz
    return add(pose.xyz, rotate(pose.rot, mbs.points()[body, point].coordinates))


def way(placement: Placement, body: str | None) -> list[int]:
    """Indices of the joints that move a body, from the body to the base."""
    indices: list[int] = []
    at = placement.last_joints[body]
    while at >= 0:
        indices.append(at)
        at = placement.joints[at].previous
    return indices


def floating(mbs: Mbs) -> Body | None:
    """The body that floats in the world: three free shifts are between it and the base."""
    for body in mbs.bodies:
        shifts = [j for j in body.joints if j.type[0] == "T" and j.nature == "independent"]
        if body.parent is None and len(shifts) == 3:
            return body
    return None
