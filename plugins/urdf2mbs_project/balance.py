"""Balance: how far inside the polygon of its feet a robot's centre of mass is, seen from above.

A position in the ground plane is a complex number (m), whose parts are the coordinates along the
two horizontal axes of the simulation.  So ``a.conjugate() * b`` has the scalar product of two
directions as its real part, and their vector product as its imaginary part.
"""

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
from urdf2mbs_project.places import find_floating_body
from urdf2mbs_project.simulation import Simulation

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, MassModel

#: A robot that stands sways, so its centre of mass must be at least this share inside its feet.
MIN_SHARE = 0.2
#: A centre of mass that is less than this outside (m) counts as on the edge.
ROUNDING = 1e-3
#: Feet that start up to this above the lowest one touch the ground soon, relative to the height of
#: the centre of mass.
TOUCH_HEIGHT = 0.02
#: The centre of mass of a robot that stands sways by this, relative to its height.
SWAY = 0.01


class Balance(NamedTuple):
    """The place of a centre of mass in the polygon of the feet.

    With o the centre of mass, and a and b the distances of o and of the middle from an edge::

        +----------------+
        |                |      share   = a / b, for the edge at which it is the smallest
        |  b   + middle  |
        |      |         |      margin  = distance from o to the nearest edge
        |    o |         |
        |    | a         |      to_edge = from o to the nearest point of this edge
        +----------------+
    """

    share: float
    """1 in the middle, 0 on the edge or if the feet make no polygon, below 0 outside."""
    margin: float
    """Distance to the nearest edge (m), below 0 outside."""
    to_edge: complex
    """From the centre of mass to the nearest point of the edge (m)."""


def compute_balance(centre_of_mass: complex, feet: Iterable[complex]) -> Balance:
    """Compute where a centre of mass is in the convex polygon of the feet.

    Args:
        centre_of_mass: Its position in the ground plane (m).
        feet: Positions in the ground plane (m), at least one.
    """
    corners = find_polygon(feet)
    middle = _compute_centroid(corners)
    share = 1.0 if len(corners) > 2 else 0.0
    to_edges = [corners[0] - centre_of_mass]
    for start, end in pairwise([*corners, corners[0]]):
        edge = end - start
        # Its real part is along the edge; its imaginary part to the left of it, that is inside.
        offset = edge.conjugate() * (centre_of_mass - start)
        if len(corners) > 2:
            share = min(share, offset.imag / (edge.conjugate() * (middle - start)).imag)
        fraction = min(max(offset.real / (abs(edge) ** 2 or 1.0), 0.0), 1.0)
        to_edges.append(start + fraction * edge - centre_of_mass)
    to_edge = min(to_edges, key=abs)
    return Balance(share, abs(to_edge) if share > 0.0 else -abs(to_edge), to_edge)


def find_polygon(points: Iterable[complex]) -> list[complex]:
    """Return the corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points), key=lambda point: (point.real, point.imag))
    corners: list[complex] = []
    for row in (ordered, ordered[::-1]):
        chain: list[complex] = []
        for point in row:
            while len(chain) > 1 and not _turns_left(chain[-2], chain[-1], point):
                chain.pop()
            chain.append(point)
        corners += chain[:-1]
    return corners or ordered


def _turns_left(first: complex, second: complex, third: complex) -> bool:
    """Return True if the path through three points turns left at the second one."""
    return ((second - first).conjugate() * (third - second)).imag > 1e-12


def _compute_centroid(corners: list[complex]) -> complex:
    """Compute the centroid of a convex polygon, as that of its triangles from the first corner."""
    first, area, moment = corners[0], 0.0, 0j
    for second, third in pairwise(corners[1:]):
        triangle = ((second - first).conjugate() * (third - first)).imag
        area += triangle
        moment += triangle * (first + second + third) / 3
    return moment / area if area else first


def compute_robot_balance(
    conversion: Conversion, placement: Placement, spots: Iterable[Vec]
) -> tuple[Balance, Vec]:
    """Compute the balance of the robot over its lowest contact spots.

    Args:
        conversion: The robot as an .mbs, with the directions of its simulation.
        placement: Its bodies at the position.
        spots: Positions where it may touch the ground (m, in the base), at least one.

    Returns:
        The balance, and its ``to_edge`` as a vector (m, in the base).
    """
    simulation = conversion.state(Simulation)
    up, (first_axis, second_axis) = simulation.up, simulation.horizontal_axes
    masses = []
    for body in conversion.mbs.bodies:
        pose = placement.bodies[body.name]
        centre = add(pose.xyz, rotate(pose.rot, body.com or ZERO))
        masses.append((body.mass or 0.0, centre, NO_INERTIA))
    _, centre_of_mass, _ = lump(masses)

    heights = {spot: dot(up, spot) for spot in spots}
    ground = min(heights.values())
    touch_height = max(TOUCH_HEIGHT * (dot(up, centre_of_mass) - ground), ROUNDING)
    feet = [spot for spot, height in heights.items() if height <= ground + touch_height]
    projected = [
        complex(dot(point, first_axis), dot(point, second_axis))
        for point in (centre_of_mass, *feet)
    ]
    balance = compute_balance(projected[0], projected[1:])
    x, y, z = (
        balance.to_edge.real * first + balance.to_edge.imag * second
        for first, second in zip(first_axis, second_axis, strict=True)
    )
    return balance, (x, y, z)


def warn_of_falling(conversion: Conversion, placement: Placement, spots: list[Vec]) -> None:
    """Warn if the robot cannot stand on its contact spots (m, in the base)."""
    if not any(body.mass for body in conversion.mbs.bodies):
        return
    balance, to_edge = compute_robot_balance(conversion, placement, spots)
    distance = f"{abs(balance.margin):.3g} m"
    if balance.margin < -ROUNDING:
        problem = f"not over the contact points, but {distance} beside them: the robot tips over"
        hint = "give a start position with its feet under it"
    elif balance.share < MIN_SHARE:
        problem = (
            f"only {distance} from the edge of the contact points: a robot that sways tips over"
        )
        hint = "give a start position with its feet further apart"
    else:
        return
    hint += ", 'passes: {posture: {joints: {NAME: VALUE}}}'"
    if balance.margin < -ROUNDING:
        x, y, z = (f"{round(component, 6) + 0.0:.3g}" for component in to_edge)
        hint += f": it must come ({x}, {y}, {z}) m nearer"
    conversion.warn("contacts-balance", f"the centre of mass is {problem}", hint=hint)


def warn_of_weak_motors(
    conversion: Conversion, mass: MassModel, reduction: Array, efforts: Mapping[str, float]
) -> None:
    """Warn of motors that cannot hold their joints while the robot stands and sways.

    Args:
        conversion: The robot, with the spots on which it stands.
        mass: Its mass matrix at the start position.
        reduction: (n, m), from ``compute_reduction``.
        efforts: The largest force or torque of each motor (N, N m), by joint.
    """
    falls = any(diagnostic.code == "contacts-balance" for diagnostic in conversion.diagnostics)
    simulation = conversion.state(Simulation)
    floats = find_floating_body(mass.mbs) is not None
    if falls or not floats or not simulation.stance or not mass.compute_total_inertia()[5, 5]:
        return
    required = _compute_holding_forces(simulation, mass, reduction)
    joints = [placed.joint for placed in mass.placement.joints]
    names = [joint.name for joint in joints if joint.nature == "independent"]
    held_joints = {held.joint.name for held in simulation.hold}
    weak = []
    for name, force in zip(names, required, strict=True):
        effort = efforts.get(name, 0.0)
        if name in held_joints and 0.0 < effort < force:
            weak.append(f"'{name}' has {effort:g} of {force:.3g} N m")
    if weak:
        conversion.warn(
            "contacts-balance",
            f"motors are too weak for a robot that stands and sways: {some(weak)}",
            hint="see if the limits 'effort' are those of the joints, not those before the gears",
        )


def _compute_holding_forces(simulation: Simulation, mass: MassModel, reduction: Array) -> Array:
    """Compute the forces (N, N m) that hold the independent joints while the robot sways.

    The ground pushes up with the force f_i at each spot of the stance.  These forces balance the
    weight: ``sum f_i = m g`` and ``sum f_i p_i = m g c``, with p_i the spots and c the centre of
    mass in the ground plane.  Of all such forces the smallest are taken (by least squares).

    Returns:
        (m,), the force for the start position, plus that for a sway in its worst direction.
    """
    import numpy as np

    up, horizontal = np.array(simulation.up), np.array(simulation.horizontal_axes)
    gravity = hypot(*mass.mbs.base.gravity)
    total = mass.compute_total_inertia()
    weight = total[5, 5] * gravity
    # The inertia has the block m [c], whose elements are the components of m c.
    centre_of_mass = total[[2, 0, 1], [4, 5, 3]] / total[5, 5]
    spots = np.array([position for _, position in simulation.stance])
    rises = np.array(
        [up @ mass.compute_point_jacobian(body, position) for body, position in simulation.stance]
    )
    shares = np.linalg.pinv(np.vstack([np.ones(len(spots)), horizontal @ spots.T]))
    # Forces at the joints for the parts (1, c) of the weight that the ground carries.
    carried = reduction.T @ rises.T @ shares
    upward = [0.0, 0.0, 0.0, *(gravity * up)]
    powers = mass.twists[:, None] @ mass.composite_inertias @ upward
    lifting = reduction.T @ powers.ravel()
    forces: Array = abs(lifting - weight * carried @ [1.0, *(horizontal @ centre_of_mass)])
    sway = SWAY * (up @ (centre_of_mass - spots[0]))
    forces += weight * sway * np.linalg.norm(carried[:, 1:], axis=1)
    return forces
