"""Stance: the links that are a robot's feet, and a start position with the feet under it.

A foot is what is called so at the end of a limb.  Where nothing is, feet are the ends of the limbs
that reach the ground.  Wheels and a trunk are no feet: such a robot rests on the ground.

A knee that cannot be straight starts in the middle of its limits.  Then the hip bends, too, until
the foot is under it, and the ankle, until the sole is as level as with all joints at zero.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import product
from math import atan2
from typing import NamedTuple

from urdf2mbs.mbs.kinematics import Placed, Placement, place
from urdf2mbs.messages.diagnostics import some
from urdf2mbs.plugin import Conversion, Step
from urdf2mbs.spatial import HERE, ZERO, Vec, add, compose, cross, dot, rotate, transpose
from urdf2mbs.urdf.model import Geometry, Link
from urdf2mbs_project.passes.contacts import spots_of
from urdf2mbs_project.passes.posture import limits_of
from urdf2mbs_project.places import floating, way
from urdf2mbs_project.simulation import Simulation

#: What a foot is called, as a part of a link's name.
FOOT = re.compile(r"(?i:foot|feet|(?<![a-z])(toe|sole)(?![a-z]))|(?<=[a-z])(Toe|Sole)(?![a-z])")
#: How far a foot may be above the ground, as a part of the robot's height.
LEVEL = 0.01
#: The axes of a leg's plane have a product above this.
PARALLEL = 0.99
#: Hip and ankle take turns.
TURNS = 5


class Stance(NamedTuple):
    feet: list[str]
    """The links on which the robot stands."""
    joints: dict[str, float]
    """Where joints start that do not start at zero, by the names of the URDF (rad or m)."""
    why_not: str = ""
    """Why what floats has no feet."""
    rests: bool = False
    """True if something else reaches the ground: a wheel, or the trunk."""
    points: Mapping[str, list[Vec]] = {}
    """Of feet whose shape was not found: the corners of a box that has their inertia, in the
    link's frame (m)."""


def find_stance(conversion: Conversion, middle: Mapping[str, float]) -> Stance:
    """``middle``: where joints start that cannot be at zero (rad or m), by the URDF's names."""
    joints = dict(middle)
    if not (conversion.base.floating or conversion.base.reason == "own joint"):
        return Stance([], joints)
    steps = {joint.name: step for step, joint in conversion.single_coordinates()}
    values = {name: joint.q or 0.0 for name, joint in conversion.mbs.joints().items()}
    values |= {
        name: middle[step.joint.name] for name, step in steps.items() if step.joint.name in middle
    }
    ends = _ends(conversion)
    why_not, rests = "", False
    chosen = [body for body, links in ends.items() if any(map(_is_foot, links))]
    if not chosen:
        why_not, rests, chosen = _touching(conversion, ends, values)
    for body in chosen:
        for name, q in _bend(conversion, body, ends[body], steps, values, middle).items():
            values[name] = joints[steps[name].joint.name] = float(f"{q:.3g}")
    placement = place(conversion.mbs, values)
    heights, points, feet = _lowest(conversion, placement), dict[str, list[Vec]](), list[str]()
    for body in chosen:
        soles = _soles(conversion, ends[body], heights)
        if not soles:
            named = (conversion.robot.links[link] for link in ends[body] if _is_foot(link))
            foot = max(named, key=lambda link: link.inertial.mass if link.inertial else 0.0)
            at = compose(placement.bodies[body], conversion.parts()[foot.name][1])
            up = rotate(transpose(at.rot), conversion.state(Simulation).up)
            soles, points[foot.name] = [foot.name], _lowest_face(foot, up)
        feet += soles
    return Stance(feet, joints, why_not, rests, points)


# --- feet ---


def _is_foot(link: str) -> bool:
    return FOOT.search(link) is not None


def _ends(conversion: Conversion) -> dict[str, list[str]]:
    """The links of each body with which a limb ends."""
    root = floating(conversion.mbs)
    inner = {body.parent for body in conversion.mbs.bodies} | {root.name if root else None}
    ends: dict[str, list[str]] = {}
    for link, (segment, _) in conversion.parts().items():
        if segment is not conversion.ground and segment.body.name not in inner:
            ends.setdefault(segment.body.name, []).append(link)
    return ends


def _lowest(conversion: Conversion, placement: Placement) -> dict[str, float]:
    """How high the lowest point is of each link whose shapes are found (m)."""
    up = conversion.state(Simulation).up
    heights: dict[str, float] = {}
    for link, (segment, pose) in conversion.parts().items():
        if segment is not conversion.ground:
            at = compose(placement.bodies[segment.body.name], pose)
            level = conversion.state(Simulation).across[0]
            spots = spots_of(conversion, link)
            if spots:
                heights[link] = min(dot(up, one.place(at, up, level)) for one in spots)
    return heights


def _lowest_face(foot: Link, up: Vec) -> list[Vec]:
    """Of the box that has a link's inertia; the link's origin where it has no mass (m)."""
    import numpy as np

    if foot.inertial is None or not foot.inertial.mass:
        return [ZERO]
    xx, xy, xz, yy, yz, zz = foot.inertial.inertia
    moments, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    squares = np.maximum(moments.sum() - 2.0 * moments, 0.0) * 6.0 / foot.inertial.mass
    centre, rot = foot.inertial.origin.pose
    sides = np.reshape(rot, (3, 3)) @ axes * np.sqrt(squares) / 2.0
    corners = [sides @ signs + centre for signs in product((-1.0, 1.0), repeat=3)]
    lowest = sorted(corners, key=lambda corner: float(corner @ up))[:4]
    return [(round(x, 4), round(y, 4), round(z, 4)) for x, y, z in np.array(lowest).tolist()]


def _touching(
    conversion: Conversion, ends: dict[str, list[str]], values: dict[str, float]
) -> tuple[str, bool, list[str]]:
    """The ends of limbs that reach the ground; or why they are no feet, and if the robot rests."""
    if any(said.code == "base-guessed" for said in conversion.diagnostics):
        return "nobody knows if its base floats", False, []
    placement, parts = place(conversion.mbs, values), conversion.parts()
    heights, up = _lowest(conversion, placement), conversion.state(Simulation).up
    frames = {body: dot(up, pose.xyz) for body, pose in placement.bodies.items() if body}
    ground = min(heights.values(), default=min(frames.values(), default=0.0))
    level = ground + LEVEL * (max(frames.values(), default=0.0) - ground)
    for body, links in ends.items():
        if frames[body] <= level and not heights.keys() & set(links):
            return f"no shape was found of {some(map(repr, links), 3)}", False, []
    chosen: dict[str, None] = {}
    for link in (link for link, height in heights.items() if height <= level):
        segment = parts[link][0]
        if segment.body.name not in ends:
            return f"'{link}' reaches the ground, and is not the end of a limb", True, []
        if [step.joint.type for step in segment.steps if step.joint.moves][-1:] == ["continuous"]:
            return f"'{link}' is a wheel", True, []
        chosen[segment.body.name] = None
    return "", False, list(chosen)


def shapes(link: Link) -> list[Geometry]:
    return [*(v.geometry for v in link.visuals), *(c.geometry for c in link.collisions)]


def _soles(conversion: Conversion, links: list[str], heights: dict[str, float]) -> list[str]:
    """The links on which a limb stands: those called a foot, and those that collide, first."""
    robot = conversion.robot.links
    feet = [link for link in links if _is_foot(link) and shapes(robot[link])]
    known = [link for link in feet or links if link in heights]
    known = [link for link in known if robot[link].collisions] or known
    lowest = min((heights[link] for link in known), default=0.0)
    return [link for link in known if heights[link] <= lowest + LEVEL]


# --- legs ---


def _bend(
    conversion: Conversion, body: str, links: list[str], steps: Mapping[str, Step],
    values: dict[str, float], knees: Mapping[str, float],
) -> dict[str, float]:  # fmt: skip
    """Where hip and ankle go (rad), by the names of the .mbs, if a knee of the leg is bent."""
    pose = next((conversion.parts()[link][1] for link in links if _is_foot(link)), HERE)
    bent: dict[str, float] = {}
    for _ in range(TURNS):
        placement = place(conversion.mbs, values | bent)
        leg = [
            placed
            for placed in (placement.joints[k] for k in reversed(way(placement, body)))
            if placed.joint.name in steps and placed.joint.type[0] == "R"
        ]
        knee = next((one for one in leg if steps[one.joint.name].joint.name in knees), None)
        if knee is None:
            break
        plane = [one for one in leg if abs(dot(one.axis, knee.axis)) > PARALLEL]
        hip, ankle = plane[0], plane[-1]
        if hip is knee:
            break
        foot = compose(placement.bodies[body], pose).xyz
        turns = {hip.joint.name: _turn_down(conversion, hip, foot)}
        if ankle is not knee:
            turns[ankle.joint.name] = -sum(
                dot(one.axis, ankle.axis) * (values | bent)[one.joint.name] for one in plane
            )
        for name, turn in turns.items():
            low, high = limits_of(steps[name])
            bent[name] = min(max((values | bent)[name] + turn, low), high)
    return bent


def _turn_down(conversion: Conversion, hip: Placed, foot: Vec) -> float:
    """By how much a joint must turn (rad) so that the foot is below its axis."""
    x, y, z = conversion.state(Simulation).up
    down = (-x, -y, -z)
    leg = add(foot, (-hip.origin[0], -hip.origin[1], -hip.origin[2]))
    across = cross(hip.axis, leg)
    return atan2(dot(cross(leg, down), hip.axis), dot(cross(hip.axis, down), across))
