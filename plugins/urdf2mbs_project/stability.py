"""The longest step that Runge and Kutta's method can take with a model that is linearised.

Near the start position the velocities u of the independent joints follow
``M u' + D u + K x = 0`` with ``u = x'``.  K and D are sums of slopes: a force that grows with a
coordinate ``r . x`` by ``stiffness`` and with its rate by ``damping`` adds ``stiffness r r'`` and
``damping r r'``.  The method of fourth order multiplies a mode of the eigenvalue s by
``R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24`` in each step, z = s h, and the mode dies out as long as
``|R(z)| <= 1``: up to z = -2.785 on the real axis, and up to 2.828 on the imaginary one (Hairer and
Wanner, Solving Ordinary Differential Equations II, IV.2).
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np

from urdf2mbs.plugin import Connection
from urdf2mbs_project.mass import Mass
from urdf2mbs_project.places import point_at
from urdf2mbs_project.simulation import Simulation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: Directions in which next to nothing has mass are none, in parts of the largest.
MASSLESS = 1e-13


class Slope(msgspec.Struct):
    """A force that grows with a coordinate of the model and with its rate."""

    kind: str
    """What makes the force: ``damping``, ``friction``, ``stop``, ``hold``, ``contact``, ``slip``
    or ``spring``."""
    name: str
    """The joint's, the foot's, or the spring's."""
    row: Array
    """The coordinate's rate by the velocities of the independent joints."""
    stiffness: float
    """N m/rad or N/m."""
    damping: float
    """N m s/rad or N s/m."""


class Mode(NamedTuple):
    """The mode that bounds the step."""

    step: float
    """The longest stable step (s)."""
    rate: complex
    """Its eigenvalue (1/s)."""
    shares: Array
    """What each slope adds to the force of this mode, in parts of the largest."""


def reduction_of(mass: Mass, simulation: Simulation) -> Array:
    """(n, m): the velocities of all n joints by those of the m independent ones.

    A joint that is driven stands still: what it follows does not feel it.
    """
    joints = [placed.joint for placed in mass.placement.joints]
    index = {joint.name: k for k, joint in enumerate(joints)}
    independent = [k for k, joint in enumerate(joints) if joint.nature == "independent"]
    dependent = [k for k, joint in enumerate(joints) if joint.nature == "dependent"]
    reduction = np.zeros((len(joints), len(independent)))
    reduction[independent, range(len(independent))] = 1.0
    rows = [row for cut in mass.mbs.cuts for row in closing_rows(mass, cut)]
    for coupling in simulation.couplings:
        row = np.zeros(len(joints))
        row[index[coupling.follower.name]] = 1.0
        row[index[coupling.leader.name]] = -coupling.multiplier
        rows.append(row)
    if rows:
        jacobian = np.array(rows)
        reduction[dependent] = np.linalg.lstsq(
            jacobian[:, dependent], -jacobian[:, independent], rcond=None
        )[0]
    return reduction


def closing_rows(mass: Mass, cut: Connection) -> list[Array]:
    """The derivatives of a cut's constraints by the joints: of a rod its length, of others the way
    from one end to the other, and of a solid also the turn."""
    here, there = (
        point_at(mass.placement, mass.mbs, *end) for end in (cut.endpoint1, cut.endpoint2)
    )
    first, second = cut.endpoint1[0], cut.endpoint2[0]
    apart = mass.point(second, there) - mass.point(first, here)
    if cut.kind == "rod":
        way = np.array(there) - np.array(here)
        return [(way / np.linalg.norm(way) if way.any() else np.eye(3)[0]) @ apart]
    return [*apart, *(mass.turn(second) - mass.turn(first) if cut.kind == "solid" else ())]


def felt(mass: Mass, reduction: Array) -> Array:
    """The inertia that each joint feels while all others are free, ``1 / (M^-1)_ii`` of the
    reduced M; infinite for one that does not move."""
    basis = _unit_mass(reduction.T @ mass.matrix @ reduction)
    mobility = ((reduction @ basis) ** 2).sum(axis=1)
    inertias: Array = np.full(len(reduction), inf)
    np.divide(1.0, mobility, out=inertias, where=mobility > 0.0)
    return inertias


def _unit_mass(mass: Array) -> Array:
    """Velocities (columns) for which the mass matrix is the unit matrix; those without mass are
    left out."""
    scale = np.sqrt(np.maximum(np.diag(mass), 0.0))
    scale[scale == 0.0] = 1.0
    values, vectors = np.linalg.eigh(mass / np.outer(scale, scale))
    solid = values > MASSLESS * max(values, default=0.0)
    basis: Array = vectors[:, solid] / np.sqrt(values[solid]) / scale[:, None]
    return basis


def fastest(mass: Array, slopes: list[Slope]) -> Mode:
    """The mode for which the step must be shortest.

    ``mass`` is (m, m), for the m independent joints.  A direction without mass is left out:
    Robotran cannot solve for it.
    """
    none = Mode(inf, 0j, np.zeros(len(slopes)))
    basis = _unit_mass(mass)
    if not slopes or not basis.size:
        return none
    rows = np.array([slope.row for slope in slopes]) @ basis
    stiffness = np.array([slope.stiffness for slope in slopes])
    damping = np.array([slope.damping for slope in slopes])
    n = rows.shape[1]
    system = np.zeros((2 * n, 2 * n))
    system[:n, n:] = np.eye(n)
    system[n:, :n] = -(rows.T * stiffness) @ rows
    system[n:, n:] = -(rows.T * damping) @ rows
    rates, shapes = np.linalg.eig(system)
    steps = longest_steps(rates)
    k = int(np.argmin(steps))
    if steps[k] == inf:
        return none
    moved = rows @ shapes[:n, k]
    shares = np.abs((rates[k] * damping + stiffness) * moved * moved.conj())
    return Mode(float(steps[k]), complex(rates[k]), shares / max(shares.max(), 1e-300))


def longest_steps(rates: Array) -> Array:
    """For each eigenvalue (1/s) the longest step (s) with ``|R(s h)| <= 1``; infinite for 0."""
    size = np.abs(rates)
    still = size <= 1e-9 * max(size, default=0.0)
    # a rounding on the side of growth is none
    way = np.where(still, -1.0, -np.abs(rates.real) + 1j * rates.imag) / np.where(still, 1.0, size)
    low, high = np.full(len(rates), 2.0), np.full(len(rates), 4.0)
    for _ in range(50):
        middle = (low + high) / 2
        z = middle * way
        stable = np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))) <= 1.0 + 1e-12
        low, high = np.where(stable, middle, low), np.where(stable, high, middle)
    return np.where(still, inf, low / np.where(still, 1.0, size))
