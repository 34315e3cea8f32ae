"""The ground: a push along the normal that grows with depth and rate, and friction.

The ground pushes with ``stiffness depth (1 + rate / speed)``, never pulls, and rubs against the
slip with ``friction`` times the push.  Friction and height are those asked for; the other numbers,
which urdf2mbs chooses, are those of the .mbs.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from urdf2mbs.laws.case import Case
from urdf2mbs.spatial import ZERO

#: How friction rises with slip, in parts of ``slip_speed``: 1 far above it, and 0 at rest.
RISE = np.tanh
#: Depth (m), rate and slip, in parts of the law's speeds.
STATES = ((-0.1, 0.0, 1.0), (0.01, 0.0, 0.0), (0.02, 0.5, 40.0), (0.03, -0.5, 0.5), (0.01, -2, 1))


def prove(case: Case) -> None:
    options = case.asked.get("contacts")
    contacts = {c.point.extforce.name: c.link for c in case.simulation.contacts if c.point.extforce}
    patterns = (*options.links, *options.points) if options else ()
    wanted = [n for n in case.robot.links if any(fnmatchcase(n, pattern) for pattern in patterns)]
    for link in wanted:
        forces = [force for force, of in contacts.items() if of == link]
        _prove_places(case, link, forces, options.points.get(link))
    case.unproven |= {f"force '{f}'": "of a plugin" for f, n in contacts.items() if n not in wanted}
    if wanted:
        law = {"ground": options.ground, "friction": options.friction}
        case.compare("contact law", [*law.values()], [case.get("contact", k) for k in law], "", 1.0)
    up = -np.array(case.gravity) if any(case.gravity) else np.array((0.0, 0.0, 1.0))
    for force in contacts:
        _prove_law(case, force, up / np.linalg.norm(up))


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


def _prove_law(case: Case, force: str, up: Any) -> None:
    names = ("ground", "stiffness", "speed", "friction", "slip_speed")
    ground, stiffness, speed, friction, slip = (case.get("contact", name) for name in names)
    for depth, rate, fast in STATES:
        across = np.cross(case.random.uniform(-1.0, 1.0, 3), up)
        slips = fast * across / np.linalg.norm(across)
        normal = stiffness * max(depth, 0.0) * max(1.0 + rate, 0.0)
        rub = friction * normal * RISE(fast) / (fast or 1.0)
        should = [*(normal * up - rub * slips), *ZERO, *case.points[force][1].coordinates]
        at, velocity = (ground - depth) * up + across, slip * slips - rate * speed * up
        case.compare(f"contact '{force}'", should, case.external(force, at, velocity), "N, N m, m")
