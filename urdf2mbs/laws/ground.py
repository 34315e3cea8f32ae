"""The ground: a push along the normal that grows with depth and rate, and friction.

``up`` is against gravity.  The ground pushes with ``stiffness depth (1 + rate / speed)``, never
pulls, and rubs against the slip with ``friction`` times the push.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from math import cos, hypot, sqrt
from typing import Any

import numpy as np

from urdf2mbs.laws.case import Case
from urdf2mbs.proof.rigid import spin, turned
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf.model import Box, Cylinder, Mesh, Sphere

#: How friction rises with slip, in parts of ``slip_speed``: 1 far above it, and 0 at rest.
RISE = np.tanh


def prove(case: Case) -> None:
    options = case.asked.get("contacts")
    contacts: dict[str, str] = {
        c.point.extforce.name: c.link
        for c in case.simulation.contacts if c.point.extforce is not None
    }  # fmt: skip
    wanted = options and [
        link for link in case.robot.links
        if any(fnmatchcase(link, p) for p in (*options.links, *options.points))
    ]  # fmt: skip
    for link in [link for link in wanted or () if link not in contacts.values()]:
        case.differ(f"link '{link}'", "it has no contact point", kind="anchors")
    for force, link in contacts.items():
        if link not in (wanted or ()):
            case.unproven[f"contact '{force}'"] = "of a plugin"
    if not contacts:
        return
    gravity = np.array(case.conversion.settings.config.gravity)
    up = -gravity / (np.linalg.norm(gravity) or -1.0) if gravity.any() else np.array((0.0, 0.0, 1.0))
    for link in wanted or ():
        _prove_points(case, link, [f for f, of in contacts.items() if of == link], up, options)
    for force in contacts:
        _prove_law(case, force, up)
    if options:
        _prove_choices(case, options, contacts)


def law(case: Case, up: Any, at: Any, speed: Any) -> Any:
    """The force (N) of the ground on a point at a place (m) with a speed (m/s)."""
    number = {k: case.code.get("contact", k) or 0.0 for k in _LAW}
    depth, rise = number["ground"] - up @ at, up @ speed
    slip = speed - rise * up
    normal = number["stiffness"] * depth * (1.0 - rise / number["speed"])
    if depth <= 0.0 or normal <= 0.0:
        return np.zeros(3)
    fast = float(np.linalg.norm(slip))
    rub = number["friction"] * normal * RISE(fast / number["slip_speed"]) / (fast or 1.0)
    return normal * up - rub * slip


_LAW = ("ground", "stiffness", "speed", "friction", "slip_speed")


def _prove_law(case: Case, force: str, up: Any) -> None:
    _, point = case.points[force]
    ground = case.code.get("contact", "ground") or 0.0
    slow = case.code.get("contact", "speed") or 1.0
    slip = case.code.get("contact", "slip_speed") or 1.0
    for depth, rate, fast in ((-0.1, 0.0, 1.0), (0.01, 0.0, 0.0), (0.02, 0.5, 40.0),
                              (0.03, -0.5, 0.5), (0.01, -2.0, 1.0)):  # fmt: skip
        across = np.cross(case.random.uniform(-1.0, 1.0, 3), up)
        at = (ground - depth) * up + across
        speed = -rate * slow * up + fast * slip * across / np.linalg.norm(across)
        given = case.code.external(force, at, speed, 0.0)
        should = [*law(case, up, at, speed), 0.0, 0.0, 0.0]
        case.compare(f"contact '{force}': its force", should, given[:6], 0.0, "N")
        case.compare(f"contact '{force}': where it acts", point.coordinates, given[6:], 1.0, "m")


def _prove_points(case: Case, link: str, forces: list[str], up: Any, options: Any) -> None:
    """The contact points of a link are those that were asked for, or the lowest of its shapes."""
    places = []
    for force in forces:
        places.append(case.on_its_link(force, link))
        if places[-1] is None:
            case.differ(f"contact '{force}'", f"it does not move with link '{link}'", kind="anchors")
            return
    if link in options.points:
        should = options.points[link]
        if len(should) != len(places):
            said = f"it has {len(places)} contact points, and should have {len(should)}"
            case.differ(f"link '{link}'", said, kind="anchors")
        for meant, place in zip(should, places, strict=False):
            case.compare(f"link '{link}': its contact", meant, place, case.size, "m", "anchors")
        return
    shapes = case.robot.links[link].collisions or case.robot.links[link].visuals
    if any(isinstance(shape.geometry, Mesh) for shape in shapes):
        case.unproven[f"contacts of link '{link}'"] = "points of a mesh"
        return
    case.go(0)
    at = case.on_link(link, (0.0, 0.0, 0.0))
    down: Vec = tuple(-at.axes.T @ up)
    lowest = [(_reach(shape, down), _count(shape, down)) for shape in shapes]
    deepest = max(reach for reach, _ in lowest)
    count = sum(number for reach, number in lowest if reach >= deepest - options.within)
    depths = [float(np.dot(place, down)) for place in places]
    case.compare(f"link '{link}': its contacts", count, len(places), 1.0, "", "anchors")
    what = f"link '{link}': its lowest contact"
    case.compare(what, deepest, max(depths), case.size, "m down", "anchors")
    for force, place in zip(forces, places, strict=True):
        if not any(_inside(shape, place, case.size) for shape in shapes):
            case.differ(f"contact '{force}'", f"it is on no shape of link '{link}'", kind="anchors")
    spread = len({tuple(np.round(place / case.size, 6)) for place in places})
    case.compare(f"link '{link}': contacts at other places", count, spread, 1.0, "", "anchors")


def _local(shape: Any, v: Vec) -> Vec:
    """A direction of the link in the axes of a shape."""
    for axis, angle in zip(np.eye(3)[::-1], shape.origin.rpy[::-1], strict=True):
        v = turned(spin(tuple(axis), -angle), v)
    return v


def _reach(shape: Any, down: Vec) -> float:
    """How far down a shape reaches, from the link's origin (m)."""
    x, y, z = _local(shape, down)
    own, form = float(np.dot(shape.origin.xyz, down)), shape.geometry
    if isinstance(form, Sphere):
        return own + form.radius
    if isinstance(form, Box):
        return own + sum(abs(c) * size / 2 for c, size in zip((x, y, z), form.size, strict=True))
    return own + abs(z) * form.length / 2 + hypot(x, y) * form.radius


def _count(shape: Any, down: Vec) -> int:
    """How many points a shape touches the ground with."""
    if isinstance(shape.geometry, Cylinder):
        return 4 if abs(_local(shape, down)[2]) > cos(np.pi / 4) else 2
    return 4 if isinstance(shape.geometry, Box) else 1


def _inside(shape: Any, place: Any, size: float) -> bool:
    x, y, z = map(abs, _local(shape, tuple(place - shape.origin.xyz)))
    form, slack = shape.geometry, 1e-6 * size
    if isinstance(form, Sphere):
        return hypot(x, y, z) <= form.radius + slack
    if isinstance(form, Box):
        return all(c <= own / 2 + slack for c, own in zip((x, y, z), form.size, strict=True))
    return hypot(x, y) <= form.radius + slack and z <= form.length / 2 + slack


def _prove_choices(case: Case, options: Any, contacts: dict[str, str]) -> None:
    """Compare the numbers of the law with those asked for, or with what they follow from."""
    get, what = case.code.get, "contact law: {}"
    case.compare(what.format("ground"), options.ground, get("contact", "ground"), 1.0, "m", "forces")
    friction = get("contact", "friction")
    case.compare(what.format("friction"), options.friction, friction, 0.0, "", "forces")
    case.choice(what.format("slip_speed"), get("contact", "slip_speed"), options.slip_speed, -1)
    g = hypot(*case.conversion.settings.config.gravity)
    share = sum(inertia[0] for inertia in case.ours.inertias[1:]) / len(contacts)
    depth, stiffness = options.depth, options.stiffness
    if depth is None:
        depth = share * g / stiffness if stiffness else options.sink * _leg(case, contacts)
    if not depth:
        case.unproven["stiffness of the ground"] = "legs that shift"
        return
    stiff = stiffness or share * g / depth or 1000.0
    case.choice(what.format("stiffness"), get("contact", "stiffness"), stiff, 1)
    speed = options.speed or sqrt(g * depth) / (2 * options.damping_ratio) or 0.1
    case.choice(what.format("speed"), get("contact", "speed"), speed, -1)


def _leg(case: Case, contacts: dict[str, str]) -> float:
    """The largest distance (m) from a contact to the joints that move it, without those of a
    floating base; 0 where such a joint shifts."""
    case.go(0)
    parents = {body.name: body for body in case.mbs.bodies}
    longest = 0.0
    for force in contacts:
        name, point = case.points[force]
        foot = case.in_mbs(name, point.coordinates).at
        while name is not None:
            body = parents[name]
            base = body.parent is None and sum(j.type[0] == "T" for j in body.joints) == 3
            for joint in () if base else body.joints:
                if joint.type[0] == "T" and joint.nature != "driven":
                    return 0.0
                group, frame = case.theirs.side.after[joint.name]
                here = case.theirs.place(group, frame, np.zeros(case.theirs.size)).at
                longest = max(longest, float(np.linalg.norm(foot - here)))
            name = body.parent
    return longest or 1.0
