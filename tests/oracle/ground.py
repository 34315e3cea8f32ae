"""The ground: a push along the normal that grows with depth and rate, and friction.

The ground pushes with ``stiffness depth (1 + rate / speed)``, never pulls, and rubs against the
slip with ``friction`` times the push, by a bristle that bends with the slip.  Friction and height
are those asked for; the other numbers, which urdf2mbs chooses, are those of the .mbs.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from oracle.case import Case
from urdf2mbs.spatial import ZERO, rotate
from urdf2mbs.urdf.model import Cylinder, Sphere
from urdf2mbs_project.simulation import CONTACT_STATES

#: Depth (m), rate and slip, in parts of the law's speeds.
STATES = ((-0.1, 0.0, 1.0), (0.01, 0.0, 0.0), (0.02, 0.5, 40.0), (0.03, -0.5, 0.5), (0.01, -2, 1))


def prove(case: Case) -> None:
    options = case.asked.get("contacts")
    contacts = {c.point.extforce.name: c.link for c in case.simulation.contacts if c.point.extforce}
    patterns = (*options.links, *options.roll, *options.points) if options else ()
    rolling: dict[str, tuple[float, Any]] = {}
    wanted = [n for n in case.robot.links if any(fnmatchcase(n, pattern) for pattern in patterns)]
    for link in wanted:
        forces = [force for force, of in contacts.items() if of == link]
        meant = options.points.get(link)
        if any(fnmatchcase(link, pattern) for pattern in options.roll):
            shapes = _round(case, link)
            meant = [part.origin.pose.xyz for part in shapes]
            for force, part in zip(forces, shapes, strict=False):
                rolling[force] = part.geometry.radius, _axis(case, link, force, part)
        _prove_places(case, link, forces, meant)
    if wanted:
        friction = options.friction
        if friction is None:  # the URDF's, of the link with the least
            stated = [e.numbers for e in case.robot.extensions if e.reference in wanted]
            numbers = [of["mu1"] for of in stated if of.get("mu1", -1.0) >= 0.0]
            friction = min(*numbers, 100.0) if numbers else 0.8
        law = {"ground": options.ground, "friction": friction}
        case.compare("contact law", [*law.values()], [case.get("contact", k) for k in law], "", 1.0)
    up = -np.array(case.gravity) if any(case.gravity) else np.array((0.0, 0.0, 1.0))
    bristles = case.data.user_model.get(CONTACT_STATES, {}).get("slip", [])
    for k, force in enumerate(contacts):
        own = bristles[2 * k : 2 * k + 2]
        _prove_law(case, force, up / np.linalg.norm(up), own, *rolling.get(force, (0.0, ZERO)))


def _round(case: Case, link: str) -> list[Any]:
    """The spheres and cylinders of a link."""
    element = case.robot.links[link]
    parts = [*(element.collisions or element.visuals)]
    return [part for part in parts if isinstance(part.geometry, Sphere | Cylinder)]


def _axis(case: Case, link: str, force: str, part: Any) -> Any:
    """The direction of a cylinder's axis in the body; zero for a sphere."""
    case.go(1)
    own = rotate(part.origin.pose.rot, (0.0, 0.0, float(isinstance(part.geometry, Cylinder))))
    return case.in_mbs(force).R @ case.on_link(link).R.T @ np.array(own)


def _prove_places(case: Case, link: str, forces: list[str], meant: Any) -> None:
    """The contact points are where they were asked for; without that, they move with the link."""
    if not forces or (meant and len(meant) != len(forces)):
        case.differ(f"link '{link}'", f"has {len(forces)} contact points")
        return
    for force, at in zip(forces, meant or [None] * len(forces), strict=True):
        what = f"contact '{force}'"
        if at is not None:
            body, point = case.points[force]
            case.compare_place(what, (body, point.name), link, at)
            continue
        places = []
        for state in (1, 2):
            case.go(state)
            here = case.on_link(link)
            places.append(here.R @ (case.in_mbs(force).P - here.P))
        case.compare(f"{what}, seen from its link", places[0], places[1], "m", case.size)


def _prove_law(
    case: Case, force: str, up: Any, bristle: list[int], radius: float, axis: Any
) -> None:
    """``bristle``: the places of its two numbers in ux.  ``radius``: of a ball, or of a wheel with
    an axis in the body, whose lowest point touches."""
    names = ("ground", "stiffness", "speed", "friction", "bristle", "bristle_time")
    ground, stiffness, speed, friction, length, time = (case.get("contact", n) for n in names)
    axes = _axes(case, force, up, bristle)
    most = friction * length
    for depth, rate, fast in STATES:
        across = np.cross(case.random.uniform(-1.0, 1.0, 3), up)
        way = across / np.linalg.norm(across)
        normal = stiffness * max(depth, 0.0) * max(1.0 + rate, 0.0)
        bent = case.random.uniform(-1.0, 1.0, 2) @ axes * 2.0 * most
        case.data.ux[bristle] = axes @ bent
        sliding = fast * most / time * way
        pull = _shortened(bent + time * sliding, most) / length
        rot, spin = np.linalg.qr(case.random.normal(size=(3, 3)))[0], case.random.normal(size=3)
        own = np.array(axis) @ rot
        arm = -radius * (up - (up @ own) * own) / np.linalg.norm(up - (up @ own) * own)
        push = normal * (up - pull)
        should = [*push, *np.cross(arm, push), *case.points[force][1].coordinates]
        at = (ground - depth) * up + across - arm
        velocity = sliding - rate * speed * up - np.cross(spin, arm)
        found = case.external(force, at, velocity, axes=rot, spin=spin)
        case.compare(f"contact '{force}'", should, found, "N, N m, m")
        kept, moves = (_shortened(bent, most), sliding) if normal else (0.0 * bent, 0.0 * bent)
        rates = axes @ (moves - (bent - kept) / time)
        case.compare(f"bristle of '{force}'", rates, case.data.uxd[bristle], "m/s")


def _axes(case: Case, force: str, up: Any, bristle: list[int]) -> Any:
    """(2, 3): the directions of a bristle's two numbers, along the ground."""
    ground, friction, length = (case.get("contact", n) for n in ("ground", "friction", "bristle"))
    axes = np.zeros((2, 3))
    for k in range(2):
        case.data.ux[bristle] = np.eye(2)[k] * friction * length / 2
        push = case.external(force, (ground - 0.01) * up, ZERO)[:3]
        normal = push @ up
        axes[k] = 2.0 / friction * (up - push / normal) if normal else ZERO
    together = np.array([up, *axes])
    case.compare(f"axes of the bristle of '{force}'", np.eye(3), together @ together.T, "")
    return axes


def _shortened(vector: Any, most: float) -> Any:
    size = np.linalg.norm(vector)
    return vector * (most / size if size > most else 1.0)
