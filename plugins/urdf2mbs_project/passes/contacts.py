"""Contacts: the ground, and the parts of a robot that may touch it.

Beyond the method.  The ground is a plane across gravity.  A body touches it by spots: corners of
its convex hull, spheres, and rims of cylinders (``urdf2mbs_project.spots``).  A body with spots
gets one anchor point at its origin with an ``extforce``; the generated code adds up the forces of
the ground at the spots.  The shapes are those that collide, or those that are seen if a link has no
others; or the centre of mass, if no shape can be read.  A floating base is raised or lowered, so
that the robot stands on its lowest spot.

``docs/passes/contacts.md`` has the contact law, and derives its numbers.  With m, a quarter of the
robot's mass, and the depth ``d = sink leg``: ``stiffness = m g / d``, ``speed = (g d)^(1/2) / (2
damping_ratio)``, ``bristle = d``, ``bristle_time = 2 damping_ratio (d / g)^(1/2)``.
"""

from __future__ import annotations

from math import dist, hypot, sqrt
from typing import Annotated

import msgspec
from msgspec import Meta

from urdf2mbs.plugin import (
    ROUNDING,
    Body,
    ConfigError,
    Conversion,
    Mbs,
    MbsSensor,
    Pass,
    Placement,
    Point,
    Pose,
    PositiveLength,
    Segment,
    UserModel,
    Vec,
    choose,
    compose,
    compute_placement,
    dot,
    fits,
    rounded,
    some,
    unit,
)
from urdf2mbs_project.balance import warn_of_falling
from urdf2mbs_project.places import find_floating_body, list_joints_to_base
from urdf2mbs_project.ranges import Coordinate, Length, Position, Speed
from urdf2mbs_project.simulation import MEASURES, Contact, Simulation, Spot
from urdf2mbs_project.spots import list_contact_spots, thin_spots

#: The pattern of all links that move and have shapes.
ALL = "*"
#: The stiffness of the ground is chosen for a robot that stands on this many spots.
STANCE_SPOTS = 4
#: The friction if the URDF states none, and the largest one.
DEFAULT_FRICTION, MAX_FRICTION = 0.8, 100.0


class Contacts(Pass):
    """Add the forces of the ground on bodies."""

    reads = ("robot", "base", "bodies", "inertias", "joints", "posture")
    writes = ("anchors", "base-position", "forces")

    links: list[str] = []
    """Patterns (``*_foot``) of the links that touch the ground; ``*``: all that move and have
    shapes."""
    roll: list[str] = []
    """Patterns of more such links, wheels and balls: only their spheres and cylinders touch."""
    points: dict[str, list[Position]] = {}
    """Link: the points of it that touch, in the link's frame (m), in place of its shapes."""
    within: Length = 0.005
    """The robot stands on what is at most this (m) above its lowest point."""
    stand: bool = True
    """Shift a floating base so that the lowest point is on the ground."""
    ground: Coordinate = 0.0
    """Height of the ground (m)."""
    sink: Annotated[float, Meta(gt=0, le=1)] = 0.001
    """The robot that stands sinks in by this part of its longest leg."""
    depth: PositiveLength | None = None
    """The robot sinks in by this (m), in place of ``sink``."""
    stiffness: Annotated[float, Meta(gt=0.0, le=1e12)] | None = None
    """Stiffness of the ground at each point (N/m), in place of ``depth``; such as the ``kp`` of
    ``<gazebo>``, which is a number of Gazebo's solver."""
    damping_ratio: Annotated[float, Meta(gt=0, le=1e3)] = 0.3
    """Damping ratio of the robot that bounces, or sways, on the ground."""
    speed: Speed | None = None
    """A point that sinks in at this speed (m/s) is pushed twice as hard; in place of
    ``damping_ratio``. A smaller speed damps more."""
    friction: Annotated[float, Meta(ge=0.0, le=100.0)] | None = None
    """Coefficient of friction, a ratio; none: the smallest that the URDF states of the links, as
    ``mu1`` of ``<gazebo>`` or ``<contact><lateral_friction>`` (at most 100), else 0.8."""

    def run(self, conversion: Conversion) -> None:
        """Add the contacts, put the robot on the ground, and add the numbers of the law."""
        if not self.links and not self.roll and not self.points:
            return
        mbs, simulation = conversion.mbs, conversion.state(Simulation)
        has_gravity = any(mbs.base.gravity)
        if has_gravity:
            x, y, z = unit(mbs.base.gravity)
            simulation.up = (0.0 - x, 0.0 - y, 0.0 - z)
        _add_contacts(conversion, self)
        if not simulation.contacts:
            message = "contacts: no link that moves has a shape that touches"
            hint = "leave 'contacts' out, or give 'points'"
            raise ConfigError("contacts-shape", message, hint=hint)
        if self.stand:
            _put_on_ground(conversion, self.ground)
        placement = compute_placement(mbs)
        spots = _compute_spot_positions(placement, simulation)
        simulation.stance = _find_lowest_spots(spots, simulation.up, self.within)
        if find_floating_body(mbs) is not None and has_gravity:
            warn_of_falling(conversion, placement, [position for _, position in spots])
        _add_law(conversion, self)
        conversion.report["contacts"] = [
            {"links": contact.links, "point": contact.point, "spots": len(contact.spots)}
            for contact in simulation.contacts
        ]


# --- the spots of bodies ---


class _TouchingBody(msgspec.Struct):
    """A body that may touch the ground, and its links that may, with their poses in it."""

    body: Body
    links: dict[str, Pose] = {}


def _add_contacts(conversion: Conversion, options: Contacts) -> None:
    """Add a contact for each body with spots, and warn of meshes that cannot be read."""
    simulation = conversion.state(Simulation)
    touching: dict[str, _TouchingBody] = {}
    for link, (segment, pose) in _choose_links(conversion, options).items():
        body = segment.body
        touching.setdefault(body.name, _TouchingBody(body)).links[link] = pose

    links_by_remedy: dict[str, list[str]] = {}
    for entry in touching.values():
        unreadable: dict[str, str] = {}
        spots_of_links = {
            link: _list_body_spots(conversion, options, link, pose, unreadable)
            for link, pose in entry.links.items()
        }
        for link, reason in unreadable.items():
            remedy = _replace_mesh(conversion, link, entry.links[link], spots_of_links)
            links_by_remedy.setdefault(remedy, []).append(f"'{link}' ({reason})")
        links = [link for link, spots in spots_of_links.items() if spots]
        if links:
            point = Point(f"{entry.body.name}_contact")
            point.extforce = MbsSensor(f"{entry.body.name}_contact_force", MEASURES)
            entry.body.points.append(point)
            spots = thin_spots([spot for spots in spots_of_links.values() for spot in spots])
            simulation.contacts.append(Contact(entry.body, links, point, spots))
    if links_by_remedy:
        text = "; ".join(f"{remedy}: {some(links)}" for remedy, links in links_by_remedy.items())
        conversion.warn("contacts-mesh", f"contacts: a link's mesh cannot be used, so {text}")


def _choose_links(conversion: Conversion, options: Contacts) -> dict[str, tuple[Segment, Pose]]:
    """Choose the links that touch the ground.

    Returns:
        For each of them its segment, and its pose in the segment's body.

    Raises:
        ConfigError: A link is named that has no body, or whose body never moves.
    """
    links, parts = conversion.robot.links, conversion.parts()
    patterns = [
        pattern for pattern in (*options.links, *options.roll, *options.points) if pattern != ALL
    ]
    chosen = set(choose(patterns, links, "contacts-links", "contacts: no link"))
    for link in sorted(chosen):
        if link not in parts:
            reason = "has no body of its own"
            hint = f"'passes: {{prune-massless: {{keep: [{link}]}}}}' makes it a body"
        elif parts[link][0] is conversion.ground:
            reason, hint = "never moves", "leave it out of 'links'"
        else:
            continue
        message = f"contacts: link '{link}' {reason}, so that no force can act on it"
        raise ConfigError("contacts-body", message, hint=hint)
    if ALL in options.links:
        chosen |= {link for link in parts if parts[link][0] is not conversion.ground}
    return {link: parts[link] for link in links if link in chosen}


def _list_body_spots(
    conversion: Conversion, options: Contacts, link: str, pose: Pose, unreadable: dict[str, str]
) -> list[Spot]:
    """List the spots of a link, in the frame of its body.

    Args:
        conversion: The robot, and the files of its meshes.
        options: The options of the pass.
        link: The name of the link.
        pose: Its pose in the body.
        unreadable: Gets the reason, by the name of the link, if a mesh cannot be read.

    Raises:
        ConfigError: The config names the link, and it has no spots.
    """
    if link in options.points:
        return [Spot(compose(pose, Pose(point)).xyz) for point in options.points[link]]
    rolls = fits(link, options.roll)
    spots = [
        spot
        for spot in list_contact_spots(conversion, link, unreadable)
        if spot.radius or not rolls
    ]
    if not spots and ALL not in options.links:
        missing, hint = "sphere or cylinder to roll on", "leave it out of 'roll'"
        if not rolls:
            missing = "shape to take points of"
            hint = f"give them (m, in its frame): 'contacts: {{points: {{{link}: [[x, y, z]]}}}}'"
        message = f"contacts: link '{link}' has no {missing}"
        raise ConfigError("contacts-shape", message, hint=hint)
    return [spot.transform(pose) for spot in spots]


def _replace_mesh(
    conversion: Conversion, link: str, pose: Pose, spots_of_links: dict[str, list[Spot]]
) -> str:
    """Replace the shape of a link whose mesh cannot be read, and describe by what.

    Args:
        conversion: The robot.
        link: The name of the link.
        pose: Its pose in the body.
        spots_of_links: The spots of each link, in the frame of the body.
    """
    if spots_of_links[link]:
        return "its other shapes touch alone"
    inertial = conversion.robot.links[link].inertial
    if inertial is not None and inertial.mass:
        spots_of_links[link] = [Spot(inertial.origin.pose.xyz).transform(pose)]
        return "its centre of mass touches instead"
    return "nothing of it touches"


# --- where the robot stands ---


def _find_lowest_spots(
    spots: list[tuple[str, Vec]], up: Vec, height: float
) -> list[tuple[str, Vec]]:
    """Find the spots that are at most a height (m) above the lowest one.

    Args:
        spots: The body of each spot, and its position (m, in the base).
        up: The direction against gravity.
        height: The height (m).
    """
    lowest = min(dot(up, position) for _, position in spots)
    return [(body, position) for body, position in spots if dot(up, position) <= lowest + height]


def _compute_spot_positions(placement: Placement, simulation: Simulation) -> list[tuple[str, Vec]]:
    """Compute the position of each spot at the start (m, in the base), with its body."""
    horizontal = simulation.horizontal_axes[0]
    spots = []
    for contact in simulation.contacts:
        pose = placement.bodies[contact.body.name]
        positions = contact.compute_positions(pose, simulation.up, horizontal)
        spots += [(contact.body.name, position) for position in positions]
    return spots


def _put_on_ground(conversion: Conversion, ground: float) -> None:
    """Shift the floating base along the vertical, so that the lowest spot is on the ground.

    Args:
        conversion: The robot.
        ground: Height of the ground (m).
    """
    body, simulation = find_floating_body(conversion.mbs), conversion.state(Simulation)
    if body is None:
        conversion.note("stand", "the base is fixed, and stays where it is, wherever the ground is")
        return
    placement = compute_placement(conversion.mbs)
    spots = _compute_spot_positions(placement, simulation)
    _, lowest = _find_lowest_spots(spots, simulation.up, 0.0)[0]
    rise = ground - dot(simulation.up, lowest)
    for placed in placement.joints:
        joint = placed.joint
        if joint in body.joints and joint.type[0] == "T" and joint.nature == "independent":
            joint.q = (joint.q or 0.0) + rise * dot(placed.axis, simulation.up)
    if abs(rise) > ROUNDING:
        shift = f"{abs(rise):.4g} m {'higher' if rise > 0.0 else 'lower'}"
        conversion.note("stand", f"the base starts {shift}, so that the robot touches the ground")


# --- the numbers of the law ---


def _add_law(conversion: Conversion, options: Contacts) -> None:
    """Add the numbers of the contact law as a user model."""
    mbs, stance = conversion.mbs, conversion.state(Simulation).stance
    gravity = hypot(*mbs.base.gravity)
    share = sum(body.mass or 0.0 for body in mbs.bodies) / STANCE_SPOTS
    stiffness, depth, speed = options.stiffness, options.depth, options.speed
    if depth is None and stiffness:
        depth = share * gravity / stiffness
    elif depth is None:
        depth = options.sink * _compute_longest_leg(mbs, stance)
    if stiffness is None:
        stiffness = rounded(share * gravity / depth) or 1000.0
    if speed is None:
        speed = rounded(sqrt(gravity * depth) / (2 * options.damping_ratio)) or 0.1
    friction = options.friction
    if friction is None:
        friction = _read_friction(conversion)
    bristle = rounded(depth) or 0.001
    time = 2.0 * options.damping_ratio * sqrt(bristle / (gravity or 9.81))
    law = {
        "ground": options.ground,
        "stiffness": stiffness,
        "speed": speed,
        "friction": friction,
        "bristle": bristle,
        "bristle_time": rounded(time),
    }
    mbs.user_models.append(UserModel.of("contact", law))


def _read_friction(conversion: Conversion) -> float:
    """Return the smallest friction that the URDF states of the links that touch the ground."""
    contacts = conversion.state(Simulation).contacts
    touching_links = {link for contact in contacts for link in contact.links}
    stated = [
        extension.numbers["mu1"]
        for extension in conversion.robot.extensions
        if extension.reference in touching_links and extension.numbers.get("mu1", -1.0) >= 0.0
    ]
    friction = min(stated, default=DEFAULT_FRICTION)
    if friction > MAX_FRICTION:
        message = f"contacts: mu1 is 100, not {friction:g} as in the URDF"
        conversion.note("contacts-most", message)
    return min(friction, MAX_FRICTION)


def _compute_longest_leg(mbs: Mbs, stance: list[tuple[str, Vec]]) -> float:
    """Compute the largest distance (m) from a spot of the stance to a joint that moves it.

    The joints of a floating base do not count.  Without other joints it is 1 m.
    """
    placement = compute_placement(mbs)
    base = find_floating_body(mbs)
    lengths = [
        dist(position, placement.joints[index].origin)
        for body, position in stance
        for index in list_joints_to_base(placement, body)
        if base is None or placement.joints[index].joint not in base.joints
    ]
    return max(lengths, default=0.0) or 1.0
