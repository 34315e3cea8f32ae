"""Find the feet of a robot, and the soles on which they stand.

A foot is an end link of a limb whose name says so.  If no name does, the feet are the ends of
limbs that touch the ground with all joints at their start.  A robot that touches the ground with
a wheel or its trunk has no feet: it rests on the ground.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

from urdf2mbs.plugin import (
    ZERO,
    Conversion,
    Geometry,
    Link,
    Placement,
    Pose,
    Segment,
    Vec,
    compose,
    compute_placement,
    dot,
    some,
)
from urdf2mbs_project.places import find_floating_body
from urdf2mbs_project.simulation import Simulation
from urdf2mbs_project.spots import list_contact_spots

#: Part of the name of a foot.  "toe" and "sole" must be words (l_toe, RightToe): "mistletoe" and
#: "console" contain them, too.
FOOT_NAME = re.compile(
    r"(?i:foot|feet|(?<![a-z])(toe|sole)(?![a-z]))|(?<=[a-z])(Toe|Sole)(?![a-z])"
)
#: A link touches the ground up to this height above it, relative to the height of the robot.
TOUCH_HEIGHT = 0.01
#: Links of one foot are soles up to this height (m) above its lowest one.
SOLE_HEIGHT = 0.01
#: Corners of a box are equally low up to this height (m) above the lowest one.
LEVEL_HEIGHT = 1e-4


class LimbEnd(NamedTuple):
    """The last body of a limb, and the links that are rigid with it."""

    body: str
    links: list[str]


class FootSearch(NamedTuple):
    """The limb ends that are feet; without feet, the reason."""

    limb_ends: list[LimbEnd]
    why_no_feet: str = ""
    rests_on_ground: bool = False


def is_foot_name(link_name: str) -> bool:
    """Return True if the name of a link says that it is a foot."""
    return FOOT_NAME.search(link_name) is not None


def find_feet(conversion: Conversion, positions: Mapping[str, float]) -> FootSearch:
    """Find the limb ends that are feet, by their names, or else by their heights.

    Args:
        conversion: The robot as a URDF and as an .mbs.
        positions: Positions (rad or m) of all joints, by the names of the .mbs.
    """
    limb_ends = _find_limb_ends(conversion)
    named_feet = [end for end in limb_ends if any(map(is_foot_name, end.links))]
    if named_feet:
        return FootSearch(named_feet)
    return _find_touching_feet(conversion, limb_ends, positions)


def _find_limb_ends(conversion: Conversion) -> list[LimbEnd]:
    """Find the bodies without a child body; a base that floats alone is not a limb."""
    floating_body = find_floating_body(conversion.mbs)
    inner_bodies = {body.parent for body in conversion.mbs.bodies}
    if floating_body is not None:
        inner_bodies.add(floating_body.name)
    limb_ends: dict[str, LimbEnd] = {}
    for link_name, (segment, _) in conversion.parts().items():
        if segment is not conversion.ground and segment.body.name not in inner_bodies:
            body = segment.body.name
            limb_ends.setdefault(body, LimbEnd(body, [])).links.append(link_name)
    return list(limb_ends.values())


def _find_touching_feet(
    conversion: Conversion, limb_ends: list[LimbEnd], positions: Mapping[str, float]
) -> FootSearch:
    """Find the limb ends that touch the ground; none if another link touches it, too.

    Args:
        conversion: The robot as a URDF and as an .mbs.
        limb_ends: All limb ends of the robot.
        positions: Positions (rad or m) of all joints, by the names of the .mbs.
    """
    placement = compute_placement(conversion.mbs, positions)
    link_heights = compute_link_heights(conversion, placement)
    if any(diagnostic.code == "base-guessed" for diagnostic in conversion.diagnostics):
        return FootSearch([], "nobody knows if its base floats", bool(link_heights))

    up = conversion.state(Simulation).up
    body_heights = {body: dot(up, pose.xyz) for body, pose in placement.bodies.items() if body}
    top = max(body_heights.values(), default=0.0)
    # The ground is at the lowest point of all shapes; without shapes, at the lowest body's origin.
    ground = min(link_heights.values(), default=min(body_heights.values(), default=0.0))
    touch_height = ground + TOUCH_HEIGHT * (top - ground)

    for end in limb_ends:
        has_shape = not link_heights.keys().isdisjoint(end.links)
        if body_heights[end.body] <= touch_height and not has_shape:
            return FootSearch([], f"no shape was found of {some(map(repr, end.links), 3)}")

    end_of_body = {end.body: end for end in limb_ends}
    parts = conversion.parts()
    feet: dict[str, LimbEnd] = {}
    for link_name, height in link_heights.items():
        if height <= touch_height:
            segment, _ = parts[link_name]
            why_not = _explain_no_foot(link_name, segment, end_of_body)
            if why_not:
                return FootSearch([], why_not, rests_on_ground=True)
            feet[segment.body.name] = end_of_body[segment.body.name]
    return FootSearch(list(feet.values()))


def _explain_no_foot(link_name: str, segment: Segment, end_of_body: Mapping[str, LimbEnd]) -> str:
    """Return why a link that touches the ground is not a foot; empty if it is one."""
    if segment.body.name not in end_of_body:
        return f"'{link_name}' reaches the ground, and is not the end of a limb"
    moving_types = [step.joint.type for step in segment.steps if step.joint.moves]
    if moving_types and moving_types[-1] == "continuous":
        return f"'{link_name}' is a wheel"
    return ""


# --- shapes ---


def list_geometries(link: Link) -> list[Geometry]:
    """List the shapes of a link: those that are seen, then those that collide."""
    visuals = [visual.geometry for visual in link.visuals]
    return visuals + [collision.geometry for collision in link.collisions]


def compute_link_pose(conversion: Conversion, placement: Placement, link_name: str) -> Pose:
    """Compute the pose of a link that is part of a body, in the base (m)."""
    segment, pose_in_body = conversion.parts()[link_name]
    return compose(placement.bodies[segment.body.name], pose_in_body)


def compute_link_heights(conversion: Conversion, placement: Placement) -> dict[str, float]:
    """Compute the height (m) of the lowest point of each moving link with a readable shape."""
    simulation = conversion.state(Simulation)
    horizontal = simulation.horizontal_axes[0]
    heights: dict[str, float] = {}
    for link_name, (segment, pose_in_body) in conversion.parts().items():
        if segment is conversion.ground:
            continue
        spots = list_contact_spots(conversion, link_name)
        if spots:
            pose = compose(placement.bodies[segment.body.name], pose_in_body)
            points = [spot.compute_position(pose, simulation.up, horizontal) for spot in spots]
            heights[link_name] = min(dot(simulation.up, point) for point in points)
    return heights


def find_soles(
    conversion: Conversion, limb_end: LimbEnd, heights: Mapping[str, float]
) -> list[str]:
    """Find the links at the end of a limb on which it stands.

    Links called a foot go before others, and links that collide before those that are only seen.

    Args:
        conversion: The robot as a URDF and as an .mbs.
        limb_end: The end of the limb.
        heights: Height (m) of the lowest point of each link with a readable shape.

    Returns:
        The lowest of these links; empty if the shape of none can be read.
    """
    links = conversion.robot.links
    feet = [name for name in limb_end.links if is_foot_name(name) and list_geometries(links[name])]
    readable = [name for name in feet or limb_end.links if name in heights]
    candidates = [name for name in readable if links[name].collisions] or readable
    lowest = min((heights[name] for name in candidates), default=0.0)
    return [name for name in candidates if heights[name] <= lowest + SOLE_HEIGHT]


def find_heaviest_foot(conversion: Conversion, limb_end: LimbEnd) -> Link:
    """Find the heaviest link at the end of a limb that is called a foot."""
    feet = [conversion.robot.links[name] for name in limb_end.links if is_foot_name(name)]
    return max(feet, key=lambda link: link.inertial.mass if link.inertial else 0.0)


def compute_lowest_face(foot: Link, up: Vec) -> list[Vec]:
    """Compute the lowest face of the uniform box that has the inertia of a link.

    A box of mass m and sides s has the principal moments ``I_x = m/12 (s_y^2 + s_z^2)``, and so
    on.  Their sum is ``m/6 (s_x^2 + s_y^2 + s_z^2)``, so ``s_x^2 = 6/m (I_x + I_y + I_z - 2 I_x)``.

    Args:
        foot: The link.
        up: Direction against gravity, in the frame of the link.

    Returns:
        Its corners (m, link frame), to 0.1 mm and each once: a sheet, a bar or a point has fewer
        than four.  The origin alone for a link without mass.
    """
    import numpy as np  # only here: most robots have shapes, and the import takes long

    if foot.inertial is None or not foot.inertial.mass:
        return [ZERO]
    xx, xy, xz, yy, yz, zz = foot.inertial.inertia
    moments, principal_axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    # A square below 0 is an inertia that no body has (triangle inequality); its side becomes 0.
    squared_sides = np.maximum(moments.sum() - 2.0 * moments, 0.0) * 6.0 / foot.inertial.mass
    centre, rotation = foot.inertial.origin.pose
    half_sides = np.reshape(rotation, (3, 3)) @ principal_axes * np.sqrt(squared_sides) / 2.0
    box = [half_sides @ signs + centre for signs in product((-1.0, 1.0), repeat=3)]
    corners = np.unique(np.round(box, 4) + 0.0, axis=0)
    heights = corners @ up
    n_level = int((heights < heights.min() + LEVEL_HEIGHT).sum())
    n_lowest = max(len(corners) // 2, n_level)
    lowest = corners[np.argsort(heights, kind="stable")[:n_lowest]]
    return [(x, y, z) for x, y, z in lowest.tolist()]
