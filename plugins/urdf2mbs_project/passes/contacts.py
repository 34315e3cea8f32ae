"""Contacts: the ground, and the parts of a robot that may touch it.

Beyond the method.  The ground is a plane across gravity.  A rigid body touches a plane by the
corners of its convex hull, by its spheres, and by the rims of its cylinders: these are its spots.
A body that has spots gets one anchor point at its origin with an ``extforce``; the generated code
adds up what the ground does at the spots.  Shapes are those of collision, or visual ones where a
link has no others; or the centre of mass, where none can be read.  A floating base is raised or
lowered, so that the robot stands on its lowest spot.

``docs/passes/contacts.md`` has the contact law, and derives its numbers.  With m, a quarter of the
robot's mass, and the depth ``d = sink leg``: ``stiffness = m g / d``, ``speed = (g d)^(1/2) / (2
damping_ratio)``, ``bristle = d``, ``bristle_time = 2 damping_ratio (d / g)^(1/2)``.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from math import dist, hypot, pi, sqrt
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta

from urdf2mbs.plugin import (
    ROUNDING,
    ZERO,
    Body,
    ConfigError,
    Conversion,
    Mbs,
    Pass,
    Point,
    Pose,
    PositiveLength,
    Segment,
    UserModel,
    Vec,
    choose,
    compose,
    dot,
    fits,
    rounded,
    some,
    unit,
    urdf,
)
from urdf2mbs.plugin import MbsSensor as Sensor
from urdf2mbs.plugin import compute_placement as place
from urdf2mbs_meshes.files import get_mesh_files
from urdf2mbs_project.balance import warn_of_falling
from urdf2mbs_project.places import floating, way
from urdf2mbs_project.ranges import Coordinate, Length, Place, Speed
from urdf2mbs_project.simulation import MEASURES, Contact, Simulation, Spot

#: A hull leaves out corners that are no further outside it than this (m), and than this part of
#: the body's size.
FINE, PART = 0.003, 0.05
#: The pattern of all links that move and have shapes.
ALL = "*"
#: So many points of a rim touch.
RIM = 8
#: The ground is for a robot that stands on so many spots.
FEET = 4


class Contacts(Pass):
    reads = ("robot", "base", "bodies", "inertias", "joints", "posture")
    writes = ("anchors", "base-position", "forces")

    links: list[str] = []
    """Patterns (``*_foot``) of the links that touch the ground; ``*``: all that move and have
    shapes."""
    roll: list[str] = []
    """Patterns of more such links, wheels and balls: only their spheres and cylinders touch."""
    points: dict[str, list[Place]] = {}
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
        if not self.links and not self.roll and not self.points:
            return
        mbs, simulation = conversion.mbs, conversion.state(Simulation)
        g = mbs.base.gravity
        if any(g):
            x, y, z = unit(g)
            simulation.up = (0.0 - x, 0.0 - y, 0.0 - z)
        bodies: dict[str, tuple[Body, list[tuple[str, Pose]]]] = {}
        lost: dict[str, str] = {}
        instead: dict[str, list[str]] = {}
        for link, (segment, pose) in _choose_links(conversion, self).items():
            bodies.setdefault(segment.body.name, (segment.body, []))[1].append((link, pose))
        for body, parts in bodies.values():
            found = {link: _spots(conversion, self, link, pose, lost) for link, pose in parts}
            for link, pose in parts:
                if link in lost:
                    inertial, what = conversion.robot.links[link].inertial, "nothing of it touches"
                    if found[link]:
                        what = "its other shapes touch alone"
                    elif inertial is not None and inertial.mass:
                        found[link] = [Spot(inertial.origin.pose.xyz).moved(pose)]
                        what = "its centre of mass stands in"
                    instead.setdefault(what, []).append(f"'{link}' ({lost[link]})")
            links = [link for link, spots in found.items() if spots]
            if links:
                spots = thin([spot for spots in found.values() for spot in spots])
                point = Point(f"{body.name}_contact")
                point.extforce = Sensor(f"{body.name}_contact_force", MEASURES)
                body.points.append(point)
                simulation.contacts.append(Contact(body, links, point, spots))
        if instead:
            said = "; ".join(f"{what}: {some(links)}" for what, links in instead.items())
            conversion.warn("contacts-mesh", f"contacts: a link's mesh cannot be used, so {said}")
        if not simulation.contacts:
            raise ConfigError(
                "contacts-shape", "contacts: no link that moves has a shape that touches",
                hint="leave 'contacts' out, or give 'points'",
            )  # fmt: skip
        if self.stand:
            _stand(conversion, self.ground)
        simulation.stance = _stance(mbs, simulation, self.within)
        if floating(mbs) is not None and any(g):
            warn_of_falling(conversion, place(mbs), [at for _, at in _places(mbs, simulation)])
        _add_law(conversion, self)
        conversion.report["contacts"] = [
            {"links": contact.links, "point": contact.point, "spots": len(contact.spots)}
            for contact in simulation.contacts
        ]


def _choose_links(conversion: Conversion, options: Contacts) -> dict[str, tuple[Segment, Pose]]:
    """The links that touch the ground, each with its body and its pose in the body."""
    links, parts = conversion.robot.links, conversion.parts()
    patterns = [p for p in (*options.links, *options.roll, *options.points) if p != ALL]
    chosen = set(choose(patterns, links, "contacts-links", "contacts: no link"))
    for link in sorted(chosen):
        if link not in parts or parts[link][0] is conversion.ground:
            why = "never moves" if link in parts else "has no body of its own"
            raise ConfigError(
                "contacts-body", f"contacts: link '{link}' {why}, so that no force can act on it",
                hint="leave it out of 'links'" if link in parts
                else f"'passes: {{prune-massless: {{keep: [{link}]}}}}' makes it a body",
            )  # fmt: skip
    if ALL in options.links:
        chosen |= {link for link in parts if parts[link][0] is not conversion.ground}
    return {link: parts[link] for link in links if link in chosen}


def _spots(
    conversion: Conversion, options: Contacts, link: str, pose: Pose, lost: dict[str, str]
) -> list[Spot]:
    """What of a link may touch, in its body's frame; ``pose`` is the link's in the body.

    Raises ConfigError where a link that was named has nothing.
    """
    if link in options.points:
        return [Spot(compose(pose, Pose(at)).xyz) for at in options.points[link]]
    rolls = fits(link, options.roll)
    spots = [spot for spot in spots_of(conversion, link, lost) if spot.radius or not rolls]
    if not spots and ALL not in options.links:
        what, hint = "sphere or cylinder to roll on", "leave it out of 'roll'"
        if not rolls:
            what = "shape to take points of"
            hint = f"give them (m, in its frame): 'contacts: {{points: {{{link}: [[x, y, z]]}}}}'"
        raise ConfigError("contacts-shape", f"contacts: link '{link}' has no {what}", hint=hint)
    return [spot.moved(pose) for spot in spots]


def _stance(mbs: Mbs, simulation: Simulation, within: float) -> list[tuple[str, Vec]]:
    """Where the robot stands: the bodies, and the places (m, in the base), of its lowest spots."""
    places, up = _places(mbs, simulation), simulation.up
    lowest = min(dot(up, at) for _, at in places)
    return [(body, at) for body, at in places if dot(up, at) <= lowest + within]


def _places(mbs: Mbs, simulation: Simulation) -> list[tuple[str, Vec]]:
    """Each spot's body, and where it is at the start (m, in the base)."""
    placement = place(mbs)
    return [
        (contact.body.name, at)
        for contact in simulation.contacts
        for at in contact.places(
            placement.bodies[contact.body.name], simulation.up, simulation.across[0]
        )
    ]


def _stand(conversion: Conversion, ground: float) -> None:
    """Shift the floating base along the vertical."""
    body, simulation = floating(conversion.mbs), conversion.state(Simulation)
    if body is None:
        conversion.note("stand", "the base is fixed, and stays where it is, wherever the ground is")
        return
    rise = ground - dot(simulation.up, _stance(conversion.mbs, simulation, 0.0)[0][1])
    for placed in place(conversion.mbs).joints:
        joint = placed.joint
        if joint in body.joints and joint.type[0] == "T" and joint.nature == "independent":
            joint.q = (joint.q or 0.0) + rise * dot(placed.axis, simulation.up)
    if abs(rise) > ROUNDING:
        way = f"{abs(rise):.4g} m {'higher' if rise > 0.0 else 'lower'}"
        conversion.note("stand", f"the base starts {way}, so that the robot touches the ground")


def _add_law(conversion: Conversion, options: Contacts) -> None:
    """Add the numbers of the contact law as a user model."""
    mbs, stance = conversion.mbs, conversion.state(Simulation).stance
    g = hypot(*mbs.base.gravity)
    share = sum(body.mass or 0.0 for body in mbs.bodies) / FEET
    stiffness, depth, speed = options.stiffness, options.depth, options.speed
    if depth is None:
        depth = share * g / stiffness if stiffness else options.sink * _longest_leg(mbs, stance)
    if stiffness is None:
        stiffness = rounded(share * g / depth) or 1000.0
    if speed is None:
        speed = rounded(sqrt(g * depth) / (2 * options.damping_ratio)) or 0.1
    friction = _stated_friction(conversion) if options.friction is None else options.friction
    law = {
        "ground": options.ground, "stiffness": stiffness, "speed": speed,
        "friction": friction, "bristle": rounded(depth) or 0.001,
    }  # fmt: skip
    time = 2.0 * options.damping_ratio * sqrt(law["bristle"] / (g or 9.81))
    law["bristle_time"] = rounded(time)
    mbs.user_models.append(UserModel.of("contact", law))


def _stated_friction(conversion: Conversion) -> float:
    """The smallest friction that the URDF states of the links that touch the ground; else 0.8."""
    touching = {link for one in conversion.state(Simulation).contacts for link in one.links}
    stated = [
        extension.numbers["mu1"]
        for extension in conversion.robot.extensions
        if extension.reference in touching and extension.numbers.get("mu1", -1.0) >= 0.0
    ]
    least = min(stated, default=0.8)
    if least > 100.0:
        said = f"contacts: mu1 is 100, not {least:g} as in the URDF"
        conversion.note("contacts-most", said)
    return min(least, 100.0)


def _longest_leg(mbs: Mbs, stance: list[tuple[str, Vec]]) -> float:
    """The largest distance (m) from where the robot stands to the joints that move it, without
    those of a floating base; 1 m where it has no others."""
    placement = place(mbs)
    base = floating(mbs)
    lengths = [
        dist(at, placement.joints[index].origin)
        for body, at in stance
        for index in way(placement, body)
        if base is None or placement.joints[index].joint not in base.joints
    ]
    return max(lengths, default=0.0) or 1.0


# --- the spots of shapes ---


def spots_of(conversion: Conversion, link: str, lost: dict[str, str] | None = None) -> list[Spot]:
    """What of a link's shapes may touch a plane, in the link's frame; ``lost``: why a shape cannot
    be read, by link."""
    from urdf2mbs_meshes.model import MeshError

    element, spots = conversion.robot.links[link], list[Spot]()
    for part in element.collisions or element.visuals:
        try:
            found = _spots_of_shape(conversion, part.geometry)
        except MeshError as error:
            if lost is not None:
                lost[link] = str(error)
        else:
            spots += [spot.moved(part.origin.pose) for spot in found]
    return spots


def _spots_of_shape(conversion: Conversion, shape: urdf.Geometry) -> list[Spot]:
    if isinstance(shape, urdf.Sphere):
        return [Spot(ZERO, shape.radius)]
    if isinstance(shape, urdf.Box):
        x, y, z = (size / 2 for size in shape.size)
        return [Spot((a, b, c)) for a in (-x, x) for b in (-y, y) for c in (-z, z)]
    if isinstance(shape, urdf.Capsule):
        end = shape.length / 2
        return [Spot((0.0, 0.0, z), shape.radius) for z in (-end, end)]
    if isinstance(shape, urdf.Cylinder):
        ends = ((0.0, 0.0, end * shape.length / 2) for end in (-1, 1))
        turns = [2 * pi * k / RIM for k in range(RIM)]
        return [Spot(end, shape.radius, (0.0, 0.0, 1.0), turn) for end in ends for turn in turns]
    return [Spot(at) for at in _corners_of(conversion, shape)]


def thin(spots: list[Spot]) -> list[Spot]:
    """Return the spheres, the rims, and those points that the hull needs, each once.

    Places are rounded to a nanometre: two spots in one place would make the ground twice as stiff.
    """
    points = _corners([spot.at for spot in spots if not spot.radius])
    rounded = (
        spot._replace(at=(round(spot.at[0], 9), round(spot.at[1], 9), round(spot.at[2], 9)))
        for spot in (*(spot for spot in spots if spot.radius), *map(Spot, points))
    )
    return list(dict.fromkeys(rounded))


def _corners(points: Any) -> list[Vec]:
    """Of points (m) those corners of the hull that stick out of the others by more than ``FINE``,
    each along its own normal; of flat ones, the corners of the box around them."""
    import numpy as np

    corners = np.asarray(points, float)
    if len(points) > 8:
        from scipy.spatial import ConvexHull, QhullError

        corners = np.round(corners, 9)
        corners = corners[np.lexsort(corners.T[::-1])]  # np.unique takes twice as long
        corners = corners[np.append(True, np.diff(corners, axis=0).any(axis=1))]
        fine = min(FINE, PART * float(np.ptp(corners, axis=0).max()))
        try:
            hull = ConvexHull(corners)
            normals = np.zeros_like(corners)
            for corner in hull.simplices.T:
                np.add.at(normals, corner, hull.equations[:, :3])
            corners, normals = corners[hull.vertices], normals[hull.vertices]
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            chosen: list[int] = []
            own, reached = (corners * normals).sum(axis=1), -np.inf
            while not chosen or (own - reached).max() > fine:
                chosen.append(int(np.argmax(np.round(own - reached, 9))))
                reached = np.maximum(reached, normals @ corners[chosen[-1]])
            corners = corners[sorted(chosen)]
        except QhullError:
            low, high = corners.min(axis=0), corners.max(axis=0)
            corners = np.unique(np.array([*product(*zip(low, high, strict=True))]), axis=0)
    return [tuple(map(float, at)) for at in corners]  # type: ignore[misc]


def _corners_of(conversion: Conversion, mesh: urdf.Mesh) -> tuple[Vec, ...]:
    """The corners of a mesh file, scaled (m).  Raises MeshError."""
    from urdf2mbs_meshes.model import MeshError

    path = get_mesh_files(conversion).find(mesh.filename)
    if path is None:
        raise MeshError("it was not found")
    return _corners_in(path, path.stat().st_mtime_ns, mesh.scale)


@lru_cache(maxsize=256)
def _corners_in(path: Path, changed: int, scale: Vec) -> tuple[Vec, ...]:
    """Kept, as init and several passes ask for each mesh."""
    import numpy as np

    from urdf2mbs_meshes.reader import read_mesh

    rows = [part.points for part in read_mesh(path).parts]
    return tuple(_corners(np.concatenate(rows).astype(float) * np.array(scale)))
