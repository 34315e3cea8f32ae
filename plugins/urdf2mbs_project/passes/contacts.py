"""Contacts: points that touch the ground, each with an external force.

Beyond the method.  At the start position the lowest points of a link's collision shapes (visual
ones where there are none) become anchor points with an ``extforce``.  Of a link that rolls, the
centre becomes the anchor point, and the force acts at the lowest point of its sphere or cylinder.
A floating base is raised or lowered, so that the robot stands on the lowest of these points.

``docs/passes/contacts.md`` has the contact law, and derives its numbers.  With the mass m that each
point carries and the depth ``d = sink leg``: ``stiffness = m g / d``, ``speed = (g d)^(1/2) / (2
damping_ratio)``, ``bristle = d``, ``bristle_time = 2 (d / g)^(1/2)``; or the URDF's ``kp``, and its
``kd`` where this damps more.
"""

from __future__ import annotations

from math import dist, hypot, inf, sqrt
from typing import Annotated, Any

from msgspec import Meta

from urdf2mbs.conversion import Conversion, Segment, choose, fits
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.model import Mbs, Point, Sensor, UserModel
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.ranges import PositiveLength, rounded
from urdf2mbs.spatial import ROUNDING, Pose, Vec, add, compose, dot, rotate, transpose, unit
from urdf2mbs.urdf import model as urdf
from urdf2mbs_meshes.files import files_of
from urdf2mbs_project.balance import warn_of_falling
from urdf2mbs_project.places import floating, point_at, way
from urdf2mbs_project.ranges import Coordinate, Length, Place, Speed
from urdf2mbs_project.simulation import MEASURES, Contact, Simulation


class Contacts(Pass):
    reads = ("robot", "base", "bodies", "inertias", "joints", "posture")
    writes = ("anchors", "posture", "forces")

    links: list[str] = []
    """Patterns (``*_foot``) of the links that touch the ground."""
    roll: list[str] = []
    """Patterns of the links that roll, wheels and balls: the lowest point of their sphere or
    cylinder touches the ground, wherever they have turned."""
    points: dict[str, list[Place]] = {}
    """Link: its contact points, in the link's frame (m), in place of the lowest points of its
    shapes."""
    within: Length = 0.005
    """A shape of a link counts if its lowest point is at most this (m) above the link's lowest
    point."""
    stand: bool = True
    """Shift a floating base so that the lowest contact point is on the ground."""
    ground: Coordinate = 0.0
    """Height of the ground (m)."""
    sink: Annotated[float, Meta(gt=0, le=1)] = 0.001
    """The robot that stands on all points sinks in by this part of its longest leg, if neither the
    URDF nor the config has a stiffness."""
    depth: PositiveLength | None = None
    """The robot sinks in by this (m), in place of ``sink``."""
    stiffness: Annotated[float, Meta(gt=0.0, le=1e12)] | None = None
    """Stiffness of the ground at each point (N/m), in place of ``depth``; none: the smallest that
    the URDF states of the links, as ``kp`` of ``<gazebo>``."""
    damping_ratio: Annotated[float, Meta(gt=0, le=1e3)] = 1.0
    """Damping ratio of the robot that bounces on the ground with all points."""
    speed: Speed | None = None
    """A point that sinks in at this speed (m/s) is pushed twice as hard; in place of
    ``damping_ratio``. A smaller speed damps more. None: the damping of ``damping_ratio``, or
    ``kd`` of ``<gazebo>`` if that is more."""
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
        up = simulation.up
        placement = place(mbs)
        places: list[Vec] = []
        for link, (segment, pose) in _choose_links(conversion, self).items():
            body = placement.bodies[segment.body.name]
            at = compose(body, pose)
            round_ones = _round(conversion, link) if fits(link, self.roll) else []
            corners = [centre for centre, *_ in round_ones] or self.points.get(link)
            corners = corners or lowest_points(conversion, link, at, self.within)
            if not corners:
                raise ConfigError(
                    "contacts-shape", f"contacts: link '{link}' has no shape to take points of",
                    hint="give them (m, in its frame): "
                    f"'contacts: {{points: {{{link}: [[x, y, z]]}}}}'",
                )  # fmt: skip
            for number, corner in enumerate(corners, start=1):
                name = f"{link}_contact_{number}"
                point = Point(name, compose(pose, Pose(corner)).xyz)
                point.extforce = Sensor(f"{name}_force", MEASURES)
                segment.body.points.append(point)
                contact = Contact(link, point)
                if round_ones:
                    _, contact.radius, axis = round_ones[number - 1]
                    contact.axis = rotate(pose.rot, axis)
                simulation.contacts.append(contact)
                places.append(add(add(at.xyz, rotate(at.rot, corner)), contact.arm(body.rot, up)))
        if self.stand:
            _stand(conversion, self.ground - min(dot(up, place) for place in places))
        if floating(mbs) is not None and any(g):
            warn_of_falling(conversion, placement, places)
        _add_law(conversion, self)
        conversion.report["contacts"] = [
            {"link": contact.link, "point": contact.point} for contact in simulation.contacts
        ]


def _choose_links(conversion: Conversion, options: Contacts) -> dict[str, tuple[Segment, Pose]]:
    """The links that touch the ground, each with its body and its pose in the body."""
    links = conversion.robot.links
    patterns = (*options.links, *options.roll, *options.points)
    chosen = choose(patterns, links, "contacts-links", "contacts: no link")
    parts = conversion.parts()
    for link in chosen:
        if link not in parts or parts[link][0] is conversion.ground:
            why = "never moves" if link in parts else "has no body of its own"
            raise ConfigError(
                "contacts-body", f"contacts: link '{link}' {why}, so that no force can act on it",
                hint="leave it out of 'links'" if link in parts
                else f"'passes: {{prune-massless: {{keep: [{link}]}}}}' makes it a body",
            )  # fmt: skip
    return {link: parts[link] for link in links if link in chosen}


def _stand(conversion: Conversion, rise: float) -> None:
    """Shift the floating base along the vertical."""
    body = floating(conversion.mbs)
    if body is None:
        conversion.note("stand", "the base is fixed, and stays where it is, wherever the ground is")
        return
    for placed in place(conversion.mbs).joints:
        joint = placed.joint
        if joint in body.joints and joint.type[0] == "T" and joint.nature == "independent":
            up = dot(placed.axis, conversion.state(Simulation).up)
            joint.q = (joint.q or 0.0) + rise * up
    if abs(rise) > ROUNDING:
        way = f"{abs(rise):.4g} m {'higher' if rise > 0.0 else 'lower'}"
        conversion.note("stand", f"the base starts {way}, so that the robot touches the ground")


def _add_law(conversion: Conversion, options: Contacts) -> None:
    """Add the numbers of the contact law as a user model."""
    mbs = conversion.mbs
    g = hypot(*mbs.base.gravity)
    share = sum(body.mass or 0.0 for body in mbs.bodies) / len(
        conversion.state(Simulation).contacts
    )
    stated = _stated(conversion)
    stiffness, depth, speed = options.stiffness, options.depth, options.speed
    if stiffness is None and depth is None:
        stiffness = stated.get("kp")
    if depth is None:
        depth = share * g / stiffness if stiffness else options.sink * _longest_leg(mbs)
    if stiffness is None:
        stiffness = rounded(share * g / depth) or 1000.0
    if speed is None:
        speed = rounded(sqrt(g * depth) / (2 * options.damping_ratio)) or 0.1
        if "kd" in stated:
            speed = min(speed, rounded(share * g / stated["kd"]) or speed)
    friction = stated.get("mu1", 0.8) if options.friction is None else options.friction
    law = {
        "ground": options.ground, "stiffness": stiffness, "speed": speed,
        "friction": friction, "bristle": rounded(depth) or 0.001,
    }  # fmt: skip
    law["bristle_time"] = rounded(2.0 * sqrt(law["bristle"] / (g or 9.81)))
    mbs.user_models.append(UserModel.of("contact", law))


def _stated(conversion: Conversion) -> dict[str, float]:
    """Friction, stiffness and damping of the ground, by the names of ``<gazebo>``: the smallest
    numbers that the URDF states of the links that touch the ground."""
    touching = {contact.link for contact in conversion.state(Simulation).contacts}
    most = {"mu1": 100.0, "kp": 1e12, "kd": 1e12}
    stated: dict[str, float] = {}
    for extension in conversion.robot.extensions:
        for name in most:
            number = extension.numbers.get(name, -1.0)
            if extension.reference in touching and (name == "mu1" or number) and number >= 0.0:
                stated[name] = min(stated.get(name, inf), number)
    for name in most:
        if stated.get(name, 0.0) > most[name]:
            said = f"contacts: {name} is {most[name]:g}, not {stated[name]:g} as in the URDF"
            conversion.note("contacts-most", said)
            stated[name] = most[name]
    return stated


def _longest_leg(mbs: Mbs) -> float:
    """The largest distance (m) from a contact point to the joints that move it, without those of
    a floating base; 1 m where it has no others."""
    placement = place(mbs)
    base = floating(mbs)
    lengths = [
        dist(point_at(placement, mbs, body.name, point.name), placement.joints[index].origin)
        for body in mbs.bodies
        for point in body.points
        if point.extforce is not None
        for index in way(placement, body.name)
        if base is None or placement.joints[index].joint not in base.joints
    ]
    return max(lengths, default=0.0) or 1.0


# --- the lowest points of shapes ---


def _round(conversion: Conversion, link: str) -> list[tuple[Vec, float, Vec]]:
    """The spheres and cylinders of a link: centre (m) and radius (m), and the axis of a cylinder,
    in the link's frame."""
    element = conversion.robot.links[link]
    found: list[tuple[Vec, float, Vec]] = []
    for part in element.collisions or element.visuals:
        if isinstance(part.geometry, urdf.Sphere | urdf.Cylinder):
            wheel = isinstance(part.geometry, urdf.Cylinder)
            axis = rotate(part.origin.pose.rot, (0.0, 0.0, float(wheel)))
            found.append((part.origin.pose.xyz, part.geometry.radius, axis))
    if not found:
        raise ConfigError(
            "contacts-shape", f"contacts: link '{link}' has no sphere or cylinder to roll on",
            hint="leave it out of 'roll'",
        )  # fmt: skip
    return found


def lowest_points(conversion: Conversion, link: str, at: Pose, within: float) -> list[Vec]:
    """In the link's frame (m); ``at`` is where the link is at the start position.

    A link without shapes that can be read has none.
    """
    x, y, z = rotate(transpose(at.rot), conversion.state(Simulation).up)
    down = (-x, -y, -z)
    element = conversion.robot.links[link]
    lowest: list[list[Vec]] = []
    for part in element.collisions or element.visuals:
        pose = part.origin.pose
        local = rotate(transpose(pose.rot), down)
        points = _lowest_of(conversion, link, part.geometry, local)
        if points:
            lowest.append([add(pose.xyz, rotate(pose.rot, point)) for point in points])
    deepest = max((dot(down, point) for points in lowest for point in points), default=0.0)
    return [
        point
        for points in lowest
        if max(dot(down, point) for point in points) >= deepest - within
        for point in points
    ]


def _lowest_of(conversion: Conversion, link: str, shape: urdf.Geometry, down: Vec) -> list[Vec]:
    """The points of a shape that reach furthest down, in the shape's own frame (m)."""
    if isinstance(shape, urdf.Sphere):
        x, y, z = down
        return [(shape.radius * x, shape.radius * y, shape.radius * z)]
    if isinstance(shape, urdf.Box):
        return _box_face(shape.size, down)
    if isinstance(shape, urdf.Cylinder):
        return _cylinder(shape, down)
    return _mesh_face(conversion, link, shape, down)


def _box_face(size: Vec, down: Vec) -> list[Vec]:
    """The corners of the face that points down the most, in order round it."""
    k = max(range(3), key=lambda axis: abs(down[axis]))
    one, two = (k + 1) % 3, (k + 2) % 3
    corners: list[Vec] = []
    for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
        corner = [0.0, 0.0, 0.0]
        corner[k] = size[k] / 2 if down[k] > 0 else -size[k] / 2
        corner[one], corner[two] = a * size[one] / 2, b * size[two] / 2
        corners.append((corner[0], corner[1], corner[2]))
    return corners


def _cylinder(shape: urdf.Cylinder, down: Vec) -> list[Vec]:
    """Four points of the lower rim where the axis is steep; else the ends of the lowest line."""
    r, half = shape.radius, shape.length / 2
    x, y, z = down
    if abs(z) > sqrt(0.5):
        end = half if z > 0 else -half
        return [(r, 0.0, end), (0.0, r, end), (-r, 0.0, end), (0.0, -r, end)]
    across = hypot(x, y)
    return [(r * x / across, r * y / across, half), (r * x / across, r * y / across, -half)]


def _mesh_face(conversion: Conversion, link: str, mesh: urdf.Mesh, down: Vec) -> list[Vec]:
    """Of the lowest vertices, the outermost one in each quarter of the plane."""
    vertices = _vertices(conversion, link, mesh)
    if vertices is None:
        return []
    import numpy as np

    d = np.array(down)
    depth = vertices @ d
    size = float(np.ptp(vertices, axis=0).max())
    near = vertices[depth >= depth.max() - 0.02 * size]
    # two horizontal directions, the first along an axis of the mesh if that is horizontal
    k = int(np.argmax(np.abs(d)))
    one = np.eye(3)[(k + 1) % 3]
    one -= d * (one @ d)
    two = np.cross(d, one)
    # a place counts as a part of the span, so that the two need not have the length 1
    spans = [max(float(np.ptp(near @ axis)), 1e-9) for axis in (one, two)]
    corners: list[Vec] = []
    for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
        index = int(np.argmax(a * (near @ one) / spans[0] + b * (near @ two) / spans[1]))
        corner: Vec = tuple(float(c) for c in near[index])  # type: ignore[assignment]
        if corner not in corners:
            corners.append(corner)
    return corners


def _vertices(conversion: Conversion, link: str, mesh: urdf.Mesh) -> Any:
    """The vertices of a mesh file, scaled (m), as rows; None, with a warning, without a mesh."""
    from urdf2mbs_meshes.model import MeshError
    from urdf2mbs_meshes.reader import read

    path = files_of(conversion).resolve(mesh.filename)
    problem = "it was not found"
    try:
        if path is not None:
            import numpy as np

            rows = [part.points for part in read(path).parts]
            return np.concatenate(rows).astype(float) * np.array(mesh.scale)
    except MeshError as error:
        problem = str(error)
    conversion.warn(
        "contacts-mesh", f"contacts: mesh '{mesh.filename}' cannot be used: {problem}", link=link
    )
    return None
