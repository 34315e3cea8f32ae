"""Balance: how far inside the polygon of its feet a robot's centre of mass is, seen from above."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from math import hypot
from typing import TYPE_CHECKING, NamedTuple

from urdf2mbs.plugin import (
    NO_INERTIA,
    ZERO,
    Conversion,
    Placement,
    Vec,
    add,
    dot,
    lump,
    rotate,
    some,
)
from urdf2mbs_project.places import floating
from urdf2mbs_project.simulation import Simulation

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, Mass

#: What stands sways: its centre of mass must be this part of the way from the edge to the middle.
ENOUGH = 0.2
#: A centre of mass that is less than this outside (m) is on the edge.
ROUNDING = 1e-3
#: Feet that start this part of the centre of mass's height above the lowest touch the ground soon.
LEVEL = 0.02
#: The centre of mass of what stands sways by this part of its height.
SWAY = 0.01


class Balance(NamedTuple):
    """A place in the ground is a complex number (m)."""

    share: float
    """The part of the way from the edge to the middle: 1 in the middle, 0 on the edge or where no
    three feet make a polygon, below 0 outside."""
    margin: float
    """To the nearest place on the edge (m), below 0 outside."""
    way: complex
    """From the centre of mass to this place."""


def balance(centre: complex, places: Iterable[complex]) -> Balance:
    """Of a centre of mass over the convex polygon of some places."""
    corners = polygon(places)
    middle = _middle(corners)
    share, ways = 1.0 if len(corners) > 2 else 0.0, [corners[0] - centre]
    for one, two in pairwise([*corners, corners[0]]):
        edge = two - one
        at = (centre - one) * edge.conjugate()  # along the edge, and to its left: inside
        if len(corners) > 2:
            share = min(share, at.imag / ((middle - one) * edge.conjugate()).imag)
        along = min(max(at.real / (abs(edge) ** 2 or 1.0), 0.0), 1.0)
        ways.append(one + along * edge - centre)
    way = min(ways, key=abs)
    return Balance(share, abs(way) if share > 0.0 else -abs(way), way)


def polygon(places: Iterable[complex]) -> list[complex]:
    """The corners of the convex polygon, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(places), key=lambda at: (at.real, at.imag))
    corners: list[complex] = []
    for row in (ordered, ordered[::-1]):
        chain: list[complex] = []
        for at in row:
            while len(chain) > 1 and (
                ((chain[-1] - chain[-2]).conjugate() * (at - chain[-1])).imag <= 1e-12
            ):
                chain.pop()
            chain.append(at)
        corners += chain[:-1]
    return corners or ordered


def _middle(corners: list[complex]) -> complex:
    """The centre of area of a convex polygon."""
    first, area, moment = corners[0], 0.0, 0j
    for one, two in pairwise(corners[1:]):
        twice = ((one - first).conjugate() * (two - first)).imag
        area, moment = area + twice, moment + twice * (first + one + two) / 3
    return moment / area if area else first


def balance_at(
    conversion: Conversion, placement: Placement, places: Iterable[Vec]
) -> tuple[Balance, Vec]:
    """Of the whole robot over its lowest places (m, in the base); and the balance's ``way`` (m, in
    the base)."""
    simulation = conversion.state(Simulation)
    up, (first, second) = simulation.up, simulation.across
    bodies = [(body, placement.bodies[body.name]) for body in conversion.mbs.bodies]
    _, centre, _ = lump(
        [
            (body.mass or 0.0, add(at.xyz, rotate(at.rot, body.com or ZERO)), NO_INERTIA)
            for body, at in bodies
        ]
    )
    heights = {place: dot(up, place) for place in places}
    ground = min(heights.values())
    reach = ground + max(LEVEL * (dot(up, centre) - ground), ROUNDING)
    seen = [
        complex(dot(place, first), dot(place, second))
        for place in (centre, *(place for place, height in heights.items() if height <= reach))
    ]
    found = balance(seen[0], seen[1:])
    x, y, z = (found.way.real * a + found.way.imag * b for a, b in zip(first, second, strict=True))
    return found, (x, y, z)


def warn_of_falling(conversion: Conversion, placement: Placement, places: list[Vec]) -> None:
    """Warn if the robot cannot stand on its contact points."""
    if not any(body.mass for body in conversion.mbs.bodies):
        return
    found, way = balance_at(conversion, placement, places)
    away, (x, y, z) = f"{abs(found.margin):.3g} m", (f"{round(part, 6) + 0.0:.3g}" for part in way)
    if found.margin < -ROUNDING:
        said = f"not over the contact points, but {away} beside them: the robot tips over"
        hint = "give a start position with its feet under it"
    elif found.share < ENOUGH:
        said = f"only {away} from the edge of the contact points: a robot that sways tips over"
        hint = "give a start position with its feet further apart"
    else:
        return
    hint += ", 'passes: {posture: {joints: {NAME: VALUE}}}'"
    if found.margin < -ROUNDING:
        hint += f": it must come ({x}, {y}, {z}) m nearer"
    conversion.warn("contacts-balance", f"the centre of mass is {said}", hint=hint)


def warn_of_weak_motors(
    conversion: Conversion, mass: Mass, reduction: Array, motors: Mapping[str, float]
) -> None:
    """Warn if a motor cannot hold its joint at the start, where the robot stands and sways;
    ``motors``: the largest force or torque of each (N, N m).

    The ground pushes up at each place of the stance.  These pushes balance the weight, and are the
    least that do so.
    """
    import numpy as np

    simulation, g = conversion.state(Simulation), hypot(*mass.mbs.base.gravity)
    whole = mass.behind[[placed.previous < 0 for placed in mass.placement.joints]].sum(axis=0)
    falls = any(said.code == "contacts-balance" for said in conversion.diagnostics)
    if falls or floating(mass.mbs) is None or not simulation.stance or not whole[5, 5]:
        return
    up, across = np.array(simulation.up), np.array(simulation.across)
    weight, centre = whole[5, 5] * g, whole[[2, 0, 1], [4, 5, 3]] / whole[5, 5]
    places = np.array([at for _, at in simulation.stance])
    pushed = np.array([up @ mass.point(body, at) for body, at in simulation.stance])
    shares = np.linalg.pinv(np.vstack([np.ones(len(places)), across @ places.T]))
    lever = reduction.T @ pushed.T @ shares
    lifted = reduction.T @ (mass.twists[:, None] @ mass.behind @ [0.0, 0.0, 0.0, *(g * up)]).ravel()
    needs = abs(lifted - weight * lever @ [1.0, *(across @ centre)])
    sways = SWAY * (up @ (centre - places[0]))
    needs += weight * sways * np.linalg.norm(lever[:, 1:], axis=1)
    joints = [placed.joint for placed in mass.placement.joints]
    names = [joint.name for joint in joints if joint.nature == "independent"]
    held = {held.joint.name for held in simulation.hold}
    weak = [
        f"'{name}' has {most:g} of {need:.3g} N m"
        for name, need in zip(names, needs, strict=True)
        for most in [motors.get(name, 0.0)]
        if name in held and 0.0 < most < need
    ]
    if weak:
        conversion.warn(
            "contacts-balance",
            f"motors are too weak for a robot that stands and sways: {some(weak)}",
            hint="see if the limits 'effort' are those of the joints, not those before the gears",
        )
