"""The differences between two robots, in words: which joint, link or body has which error.

``comparison`` computes how large a deviation is; the functions here find its cause, and word it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from urdf2mbs.mbs.model import LinkFrame
from urdf2mbs.proof.groups import Group
from urdf2mbs.proof.pair import GroupPair
from urdf2mbs.proof.rigid import (
    IDENTITY,
    NO_INERTIA,
    Frame,
    Inertia,
    compare_inertias,
    compose,
    compute_angle,
    compute_angle_about,
    compute_deviation,
    compute_frame_deviation,
    compute_rotation,
    compute_translation,
    dot,
    inverse,
    rotate,
    sum_inertias,
    transform_inertia,
)
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.spatial import Vec, fewest_turns

#: If the motion of a joint explains a displacement but for this share, its zero is wrong.
ZERO_SHARE = 1e-3
#: A link and a body whose mass and centre deviate by less, relatively, are probably the same.
NEARLY = 1e-3


def explain_gravity(urdf: Vec, mbs: Vec, deviation: float) -> Difference:
    """Describe a difference of gravity (m/s^2)."""
    message = f"gravity is {format_value(mbs)} in the .mbs; expected {format_value(urdf)} m/s^2"
    return Difference("gravity", message, deviation, urdf=urdf, mbs=mbs)


def explain_parent(group: Group) -> Difference:
    """Describe a joint that is attached to another group in the .mbs."""
    message = f"joint '{group.joint}' has another parent joint in the .mbs"
    return Difference("parent", message, 1.0, link=group.child, joint=group.joint)


# --- motion ---


def explain_motion(
    pair: GroupPair, relative_pose: Frame, deviation: float, tolerance: float
) -> Difference:
    """Find why two groups move differently.

    Either the axis of the joint is wrong, or its zero, or the child is displaced otherwise.

    Args:
        pair: The two groups.
        relative_pose: Pose X of the URDF's group in the .mbs's group.
        deviation: By how much they move differently.
        tolerance: A larger deviation is a difference.
    """
    zero_pose = pair.compute_zero_pose()
    size = compute_frame_deviation(zero_pose, relative_pose, pair.scale)
    if size <= tolerance:
        return _explain_axis(pair, deviation, tolerance)
    # With both joints at zero: the child in the .mbs, in the frame where it should be.
    displacement = compose(inverse(zero_pose), relative_pose)
    return _explain_zero(pair, displacement, size, tolerance) or _explain_displacement(
        pair, displacement, size, tolerance
    )


def _explain_axis(pair: GroupPair, deviation: float, tolerance: float) -> Difference:
    """Describe a joint axis that has a wrong direction, or that is in a wrong place."""
    mbs = rotate(pair.mbs_joint_frame, pair.mbs.axis)
    urdf = rotate(pair.urdf_joint_frame, pair.urdf.axis)
    angle = compute_angle(mbs, urdf)
    if not angle <= tolerance:
        to_urdf = inverse(pair.parent_pose)
        mbs, urdf = rotate(to_urdf, mbs), rotate(to_urdf, urdf)
        message = f"axis is {format_value(mbs)} in the .mbs; expected {format_value(urdf)}"
        message += f" ({angle:.6g} rad off)"
    else:
        mbs, urdf = pair.mbs_joint_frame[9:], pair.urdf_joint_frame[9:]
        message = f"axis is displaced by {compute_deviation(mbs, urdf):.3g} m in the .mbs"
    return Difference(
        "axis",
        f"joint '{pair.urdf.joint}': {message}",
        deviation,
        link=pair.urdf.child,
        joint=pair.urdf.joint,
        urdf=urdf,
        mbs=mbs,
    )


def _explain_zero(
    pair: GroupPair, displacement: Frame, size: float, tolerance: float
) -> Difference | None:
    """Describe a joint whose zero is at another position; None if this is not the cause."""
    urdf = pair.urdf
    if urdf.revolute:
        amount, unit = compute_angle_about(displacement, urdf.axis), "rad"
        back = compute_rotation(urdf.axis, -amount)
    else:
        amount, unit = dot(displacement[9:], urdf.axis), "m"
        back = compute_translation(urdf.axis, -amount)
    remainder = compose(displacement, back)
    deviation = compute_frame_deviation(remainder, IDENTITY, pair.scale)
    if not deviation <= max(tolerance, ZERO_SHARE * size):
        return None
    message = f"joint '{urdf.joint}': zero is at {amount:.6g} {unit} of the URDF"
    if not deviation <= tolerance:
        message += f", and link '{urdf.child}' is {describe_displacement(remainder)}"
    return Difference(
        "zero", message, size, link=urdf.child, joint=urdf.joint, urdf=0.0, mbs=amount
    )


def _explain_displacement(
    pair: GroupPair, displacement: Frame, size: float, tolerance: float
) -> Difference:
    """Describe a joint that puts its child in a wrong place."""
    urdf, mbs = pair.urdf, pair.mbs
    message = f"link '{urdf.child}' is displaced after joint '{urdf.joint}': "
    message += describe_displacement(displacement)
    if mbs.driven_before:
        message += f" (driven before it: {', '.join(mbs.driven_before)})"
    angle = compute_angle(
        rotate(pair.mbs_joint_frame, mbs.axis), rotate(pair.urdf_joint_frame, urdf.axis)
    )
    if not angle <= tolerance:
        message += f"; the axis is {angle:.3g} rad off"
    return Difference("frame", message, size, link=urdf.child, joint=urdf.joint)


# --- inertia ---


class BodyPair(NamedTuple):
    """A body of the .mbs, and the links whose inertia it should have."""

    links: list[str]
    urdf: Inertia
    mbs: Inertia
    extra_body: str = ""
    """The name of a body that has no link; empty for other bodies."""


def explain_inertia(
    pair: GroupPair,
    relative_pose: Frame,
    frames: Mapping[str, LinkFrame],
    tolerance: float,
) -> list[Difference]:
    """Find which links or bodies make the inertias of two groups differ.

    Args:
        pair: The two groups.
        relative_pose: Pose X of the URDF's group in the .mbs's group.
        frames: Where the frame of each link should be, as far as it is known.
        tolerance: A larger deviation is a difference.
    """
    lost_links = _find_lost_links(pair, frames, tolerance)
    differences = [_explain_lost_mass(pair, link) for link in lost_links]
    for body_pair in _pair_bodies(pair, relative_pose, frames, lost_links):
        if body_pair.extra_body:
            differences.append(_explain_extra_body(pair, body_pair))
        else:
            narrowed = _narrow_to_link(pair, body_pair, relative_pose, tolerance)
            differences += _explain_body(pair, narrowed, relative_pose, tolerance)
    if differences:
        return differences
    # Only the sum differs: for example, two links were exchanged.
    link = pair.urdf.child
    size = max(pair.compute_inertia_deviations(relative_pose).values())
    return [
        Difference("inertia", f"link '{link}': inertia", size, link=link, joint=pair.urdf.joint)
    ]


def _find_lost_links(
    pair: GroupPair, frames: Mapping[str, LinkFrame], tolerance: float
) -> list[str]:
    """Find the links whose mass the .mbs lacks: all without a body, or a single one of them."""
    missing_mass = pair.urdf_inertia.mass - pair.mbs_inertia.mass
    margin = tolerance * pair.urdf_inertia.mass
    if missing_mass <= margin:
        return []
    masses = {name: inertia.mass for name, inertia in pair.urdf.inertias.items() if inertia.mass}
    bodiless = [name for name in masses if not _get_body(name, frames)]
    if bodiless and abs(sum(masses[name] for name in bodiless) - missing_mass) <= margin:
        return bodiless
    return [name for name, mass in masses.items() if abs(mass - missing_mass) <= margin][:1]


def _get_body(link: str, frames: Mapping[str, LinkFrame]) -> str | None:
    """Return the body that should have the inertia of a link; None if it is not known."""
    frame = frames.get(link)
    return None if frame is None or frame.joint is not None else frame.body


def _pair_bodies(
    pair: GroupPair,
    relative_pose: Frame,
    frames: Mapping[str, LinkFrame],
    lost_links: list[str],
) -> list[BodyPair]:
    """Pair the bodies of a group with their links: by name, or else by inertia."""
    inertias = {
        name: inertia for name, inertia in pair.urdf.inertias.items() if name not in lost_links
    }
    links_of_body: dict[str, list[str]] = {}
    for name in inertias:
        links_of_body.setdefault(_get_body(name, frames) or "", []).append(name)
    bodies = pair.mbs.inertias
    if "" in links_of_body or not links_of_body.keys() >= bodies.keys():
        return _pair_by_inertia(pair, relative_pose, inertias)
    return [
        BodyPair(
            links, sum_inertias([inertias[name] for name in links]), bodies.get(body, NO_INERTIA)
        )
        for body, links in links_of_body.items()
    ]


def _pair_by_inertia(
    pair: GroupPair, relative_pose: Frame, inertias: Mapping[str, Inertia]
) -> list[BodyPair]:
    """Pair bodies with links of about the same mass and centre; all others together.

    Args:
        pair: The two groups.
        relative_pose: Pose X of the URDF's group in the .mbs's group.
        inertias: The inertias of the links that are not lost, in the URDF's group.
    """
    links, bodies = dict(inertias), dict(pair.mbs.inertias)
    body_pairs = []
    for link, inertia in inertias.items():
        urdf = transform_inertia(inertia, relative_pose)
        deviations = {
            body: max(compare_inertias(urdf, mbs, pair.scale)[kind] for kind in ("mass", "centre"))
            for body, mbs in bodies.items()
        }
        nearest = min(deviations, key=deviations.__getitem__, default="")
        if deviations and deviations[nearest] <= NEARLY:
            body_pairs.append(BodyPair([link], inertia, bodies.pop(nearest)))
            del links[link]
    has_only_extra = not any(inertia.mass for inertia in links.values())
    if has_only_extra and all(mbs.mass for mbs in bodies.values()):
        body_pairs += [BodyPair([], NO_INERTIA, mbs, body) for body, mbs in bodies.items()]
    else:
        urdf_sum, mbs_sum = sum_inertias([*links.values()]), sum_inertias([*bodies.values()])
        body_pairs.append(BodyPair([*links], urdf_sum, mbs_sum))
    return body_pairs


def _explain_extra_body(pair: GroupPair, body_pair: BodyPair) -> Difference:
    """Describe a body whose mass the URDF lacks."""
    mass, body = body_pair.mbs.mass, body_pair.extra_body
    message = f"body '{body}': mass of {format_value(mass)} kg is in the .mbs only"
    share = mass / (pair.mbs_inertia.mass or 1.0)
    link, joint = pair.urdf.child, pair.urdf.joint
    return Difference("mass", message, share, link=link, joint=joint, urdf=0.0, mbs=mass, body=body)


def _narrow_to_link(
    pair: GroupPair, body_pair: BodyPair, relative_pose: Frame, tolerance: float
) -> BodyPair:
    """Narrow a body to the one link whose wrong mass explains its inertia, if there is one.

    The body is the sum of several links.  The tensor of the link may be that of its wrong mass, or
    as it should be.
    """
    missing_mass = body_pair.mbs.mass - body_pair.urdf.mass
    if len(body_pair.links) < 2 or abs(missing_mass) <= tolerance * body_pair.urdf.mass:
        return body_pair
    for link in body_pair.links:
        expected = pair.urdf.inertias[link]
        mass = expected.mass + missing_mass
        if expected.mass <= 0.0 or mass < 0.0:
            continue
        bound = max(tolerance, NEARLY * abs(missing_mass) / max(mass, expected.mass))
        remaining = [pair.urdf.inertias[each] for each in body_pair.links if each != link]
        for factor in (1.0, mass / expected.mass):
            xx, xy, xz, yy, yz, zz = (factor * c for c in expected.tensor)
            wrong = Inertia(mass, expected.centre, (xx, xy, xz, yy, yz, zz))
            total = transform_inertia(sum_inertias([wrong, *remaining]), relative_pose)
            if max(compare_inertias(total, body_pair.mbs, pair.scale).values()) <= bound:
                lighter = transform_inertia(expected._replace(mass=mass), relative_pose)
                return BodyPair([link], expected, lighter)
    return body_pair


def _explain_lost_mass(pair: GroupPair, link: str) -> Difference:
    """Describe a link whose mass is not in the .mbs."""
    mass = pair.urdf.inertias[link].mass
    return Difference(
        "mass",
        f"link '{link}': mass of {format_value(mass)} kg is missing in the .mbs",
        mass / (pair.urdf_inertia.mass or 1.0),
        link=link,
        joint=pair.urdf.joint,
        urdf=mass,
        mbs=0.0,
    )


def _explain_body(
    pair: GroupPair, body_pair: BodyPair, relative_pose: Frame, tolerance: float
) -> list[Difference]:
    """Describe the mass, centre of mass and inertia tensor of a body that are wrong."""
    urdf, mbs = transform_inertia(body_pair.urdf, relative_pose), body_pair.mbs
    links = body_pair.links or [pair.urdf.child]
    differences = []
    deviations = compare_inertias(urdf, mbs, pair.scale)
    for index, (kind, deviation) in enumerate(deviations.items()):
        if not deviation <= tolerance:
            message = f"{_name_links(links)}: {kind} is {format_value(mbs[index])} in the .mbs; "
            message += f"expected {format_value(urdf[index])}"
            differences.append(
                Difference(
                    kind,
                    message,
                    deviation,
                    link=links[0],
                    joint=pair.urdf.joint,
                    urdf=urdf[index],
                    mbs=mbs[index],
                )
            )
    return differences


def _name_links(links: Sequence[str]) -> str:
    """Return the names of links whose inertias are summed: ``links 'a' + 'b'``."""
    names = " + ".join(f"'{link}'" for link in links[:3])
    more = f" and {len(links) - 3} more" if len(links) > 3 else ""
    return f"{'link' if len(links) == 1 else 'links'} {names}{more}"


# --- frames and points ---


def explain_missing_frame(link: str, frame: LinkFrame, *, is_present: bool) -> Difference:
    """Describe a link whose frame is in another group, or in no body of the .mbs."""
    name = frame.joint or frame.body or ""
    cause = "moves with another body" if is_present else f"no body or joint '{name}' in the .mbs"
    return Difference("frame", f"link '{link}': {cause}", link=link)


def explain_frame(link: str, displacement: Frame, deviation: float) -> Difference:
    """Describe a link whose frame is displaced in the .mbs."""
    message = f"link '{link}': frame is {describe_displacement(displacement)}"
    return Difference("frame", message, deviation, link=link)


def describe_displacement(displacement: Frame) -> str:
    """Return a displacement in words: its rotations (rad) about axes, and its shift (m)."""
    rotations = ", ".join(
        f"{angle:.6g} about {'xyz'[axis - 1]}"
        for axis, angle in fewest_turns(displacement[:9], 1e-10)
    )
    largest = max(map(abs, displacement[9:]))
    shift = ", ".join(f"{c if abs(c) > 1e-9 * largest else 0.0:.6g}" for c in displacement[9:])
    parts = [f"rotated by {rotations}"] if rotations else []
    if largest > 1e-12:
        parts.append(f"shifted by ({shift})")
    return " and ".join(parts) or "slightly off"


def format_value(value: Any) -> str:
    """Return a number, or a tuple of numbers, with 9 digits."""
    if isinstance(value, tuple):
        return "(" + ", ".join(f"{c:.9g}" for c in value) + ")"
    return f"{value:.9g}"
