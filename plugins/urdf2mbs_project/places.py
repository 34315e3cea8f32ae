"""Positions of a model's points, the joints that move a body, and the body that floats."""

from __future__ import annotations

from urdf2mbs.plugin import Body, Mbs, Placement, Vec, add, rotate


def compute_point_position(
    placement: Placement, mbs: Mbs, body: str | None, point: str | None
) -> Vec:
    """Compute the position of an anchor point (m, in the base).

    Args:
        placement: The bodies at their current poses.
        mbs: The model.
        body: The name of the body; None for the base.
        point: The name of its anchor point; None for the origin of the body.
    """
    pose = placement.bodies[body]
    if point is None:
        return pose.xyz
    return add(pose.xyz, rotate(pose.rot, mbs.points()[body, point].coordinates))


def list_joints_to_base(placement: Placement, body: str | None) -> list[int]:
    """List the indices of the joints that move a body, from the body to the base."""
    indices: list[int] = []
    index = placement.last_joints[body]
    while index >= 0:
        indices.append(index)
        index = placement.joints[index].previous
    return indices


def find_floating_body(mbs: Mbs) -> Body | None:
    """Find the body that floats: three independent prismatic joints attach it to the base."""
    for body in mbs.bodies:
        translations = [
            joint for joint in body.joints if joint.type[0] == "T" and joint.nature == "independent"
        ]
        if body.parent is None and len(translations) == 3:
            return body
    return None
