"""Compute what a robot looks like from the front, in its start pose: where limbs begin and end.

Up is up.  The robot faces the reader: its left (URDF's +y) is at the right of the picture.  A robot
whose limbs are mirror images along x instead is viewed along y.  Then names like ``left`` and
``l_`` decide which side is which, as they do for a robot that faces backwards.
"""

from __future__ import annotations

import re

import msgspec

from urdf2mbs.diagram.nodes import Node
from urdf2mbs.mbs.kinematics import compute_placement
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.spatial import Vec

MIRROR_TOLERANCE = 0.05
"""Most by which a limb may be off its partner's mirror image (share of the robot's size)."""
MAX_SIBLINGS = 24
"""If a body has more children than this, no partners are looked for among them."""
LEFT = re.compile(r"[Ll]eft|LEFT|(^|[^A-Za-z])[lL]([^A-Za-z]|$)|^L[A-Z][a-z]|(^|_)[FHRB]L(_|$)")
RIGHT = re.compile(r"[Rr]ight|RIGHT|(^|[^A-Za-z])[rR]([^A-Za-z]|$)|^R[A-Z][a-z]|(^|_)[FHRB]R(_|$)")


class LimbView(msgspec.Struct):
    """A body with all its descendants, seen from the front.

    Positions (m) are: to the right of the picture, in depth, and up.  Depth is only compared.
    """

    start: Vec
    """Where it is attached to its parent."""
    frame: Vec
    """Origin of the body's frame."""
    centre: Vec
    """Mean of its start and of the origins of all its bodies."""
    body_count: int
    depth: int
    """Number of bodies in its longest chain."""
    partner: Node | None = None
    """Its mirror image, attached to the same parent."""


class FrontView(msgspec.Struct):
    """A robot, seen from the front."""

    limbs: dict[str, LimbView]
    """By the names of the bodies with which they begin."""
    size: float
    """Of the robot, along the longest of the three axes (m)."""
    pair_count: int = 0
    """Number of limbs of two bodies or more that have a mirror image."""

    def compute_offset(self, node: Node) -> float:
        """Compute how far a limb is to the right of the picture (share of the robot's size)."""
        return self.limbs[node.name].centre[0] / self.size if self.size else 0.0


class StartPose(msgspec.Struct):
    """Positions of the bodies at the start (m), in the base."""

    starts: dict[str, Vec]
    """Where each body is attached to its parent."""
    frames: dict[str, Vec]
    """Origin of the frame of each body."""
    size: float
    """Of the robot, along the longest of the three axes."""


def compute_front_view(mbs: Mbs, nodes: list[Node]) -> FrontView:
    """Compute what a robot looks like from the front.

    Args:
        mbs: The model.
        nodes: The base, then the bodies depth first.
    """
    pose = _compute_start_pose(mbs)
    view = _view_along(nodes, pose, side_axis=1)
    if view.pair_count < _find_most_pairs(nodes, view):
        view_along_y = _view_along(nodes, pose, side_axis=0)
        view = view_along_y if view_along_y.pair_count > view.pair_count else view
    if _is_mirrored(view):
        for limb in view.limbs.values():
            limb.start, limb.frame, limb.centre = (
                (-x, y, z) for x, y, z in (limb.start, limb.frame, limb.centre)
            )
    return view


def _compute_start_pose(mbs: Mbs) -> StartPose:
    """Compute the positions of the bodies at the start."""
    placement = compute_placement(mbs)
    frames = {body.name: placement.bodies[body.name].xyz for body in mbs.bodies}
    starts: dict[str, Vec] = {}
    joints = iter(placement.joints)
    for body in mbs.bodies:
        starts[body.name], *_ = (next(joints).origin for _ in body.joints)
    columns = zip(*frames.values(), strict=True)
    size = max([max(column) - min(column) for column in columns], default=0.0)
    return StartPose(starts, frames, size)


def _view_along(nodes: list[Node], pose: StartPose, side_axis: int) -> FrontView:
    """Compute a view of a robot; the middle of the picture is at its first body.

    Args:
        nodes: The base, then the bodies depth first.
        pose: The positions of the bodies.
        side_axis: The axis of the base that is to the right of the picture: 0 is x, 1 is y.
    """
    middle = pose.frames[nodes[1].name][side_axis] if pose.frames else 0.0

    def to_picture(position: Vec) -> Vec:
        return (position[side_axis] - middle, position[1 - side_axis], position[2])

    view = FrontView({}, pose.size)
    sums: dict[str, Vec] = {}  # of the origins of all bodies of a limb
    for node in reversed(nodes[1:]):
        start, frame = to_picture(pose.starts[node.name]), to_picture(pose.frames[node.name])
        sum_x, sum_y, sum_z = frame
        body_count, depth = 1, 0
        for child in node.children:
            child_limb, child_sum = view.limbs[child.name], sums[child.name]
            sum_x, sum_y, sum_z = sum_x + child_sum[0], sum_y + child_sum[1], sum_z + child_sum[2]
            body_count += child_limb.body_count
            depth = max(depth, child_limb.depth)
        sums[node.name] = (sum_x, sum_y, sum_z)
        count = body_count + 1
        centre = (
            (sum_x + start[0]) / count,
            (sum_y + start[1]) / count,
            (sum_z + start[2]) / count,
        )
        view.limbs[node.name] = LimbView(start, frame, centre, body_count, depth + 1)
    if view.size:
        for node in nodes[1:]:
            if 2 <= len(node.children) <= MAX_SIBLINGS:
                view.pair_count += _pair_children(node, view)
    return view


def _pair_children(parent: Node, view: FrontView) -> int:
    """Pair the limbs of a body with their mirror images.

    Returns:
        The number of pairs of two bodies or more.
    """
    pair_count = 0
    siblings = [(child, view.limbs[child.name]) for child in parent.children]
    for node, limb in siblings:
        if limb.start[0] <= 0.0 and limb.centre[0] <= 0.0:
            continue  # each pair is found from its limb at the right
        least_error, best = MIRROR_TOLERANCE * view.size, None
        for partner, partner_limb in siblings:
            is_free = partner_limb is not limb and not partner_limb.partner
            if not is_free or partner_limb.body_count != limb.body_count:
                continue
            error = max(
                _compute_mirror_error(limb.start, partner_limb.start),
                0.5 * _compute_mirror_error(limb.centre, partner_limb.centre),
            )
            # A limb in the middle is no mirror image of its neighbour.
            distance = max(
                abs(limb.start[0] - partner_limb.start[0]),
                abs(limb.centre[0] - partner_limb.centre[0]),
            )
            if error <= min(least_error, distance):
                least_error, best = error, (partner, partner_limb)
        if best is not None:
            limb.partner, best[1].partner = best[0], node
            pair_count += limb.body_count > 1
    return pair_count


def _compute_mirror_error(position: Vec, partner: Vec) -> float:
    """Compute how far a position (m) is off the mirror image of another one."""
    return max(
        abs(position[0] + partner[0]),
        abs(position[1] - partner[1]),
        abs(position[2] - partner[2]),
    )


def _find_most_pairs(nodes: list[Node], view: FrontView) -> int:
    """Return a number of pairs that no view can exceed: partners have as many bodies."""
    most = 0
    for node in nodes[1:]:
        if len(node.children) > 1:
            body_counts = [view.limbs[child.name].body_count for child in node.children]
            large = [count for count in body_counts if count > 1]
            most += len(large) - len(set(large))
    return most


def _is_mirrored(view: FrontView) -> bool:
    """Return True if most limbs called left are at the left of the picture: it is a rear view."""
    votes = 0
    for limb in view.limbs.values():
        if limb.partner is not None and limb.start[0] != 0.0:
            name = limb.partner.name
            partner_side = 1 if LEFT.search(name) else -1 if RIGHT.search(name) else 0
            votes += partner_side if limb.start[0] < 0.0 else -partner_side
    return votes < 0
