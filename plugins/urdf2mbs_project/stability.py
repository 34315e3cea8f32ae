"""The longest step that Runge and Kutta's method can take with a linearised model.

Near the start position, the velocities u of the independent joints follow
``M u' + D u + K x = 0`` with ``u = x'``.  K and D are sums over springs and dampers: one that acts
on the coordinate ``r . x`` adds ``stiffness r r'`` to K and ``damping r r'`` to D.  The method of
fourth order multiplies a mode of the eigenvalue s by ``R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24`` in
each step, z = s h, and the mode dies out as long as ``|R(z)| <= 1``: up to z = -2.785 on the real
axis, and up to 2.828 on the imaginary one (Hairer and Wanner, Solving Ordinary Differential
Equations II, IV.2).
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np

from urdf2mbs.plugin import Connection
from urdf2mbs_project.mass import MassModel
from urdf2mbs_project.places import compute_point_position
from urdf2mbs_project.simulation import Simulation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: A direction counts as massless if its eigenvalue of the scaled mass matrix is below this,
#: relative to the largest one.
MASSLESS = 1e-13
#: An eigenvalue is zero up to this, relative to the largest one.
ZERO_RATE = 1e-9
#: Halvings of the interval in which the longest step is sought: enough for all digits.
BISECTIONS = 50
#: |R(z)| may be above 1 by this, by rounding.
AMPLIFICATION_ROUNDING = 1e-12


class SpringDamper(msgspec.Struct):
    """A linearised force, which grows with a coordinate of the model and with its rate."""

    kind: str
    """``damping``, ``friction``, ``stop``, ``hold``, ``contact``, ``slip`` or ``spring``."""
    name: str
    """The name of the joint, of the body that touches the ground, or of the spring."""
    jacobian_row: Array
    """(m,), the rate of the coordinate by the velocities of the independent joints."""
    stiffness: float
    """N m/rad or N/m."""
    damping: float
    """N m s/rad or N s/m."""


class Mode(NamedTuple):
    """The mode that limits the step."""

    step: float
    """The longest stable step (s); infinite if no mode limits it."""
    eigenvalue: complex
    """1/s."""
    shares: Array
    """The share of each spring and damper in the force of the mode, relative to the largest."""


def compute_reduction(mass: MassModel, simulation: Simulation) -> Array:
    """Compute how the independent joints move all joints.

    A joint that is driven does not move: the joint that it follows does not feel it.

    Returns:
        (n, m), the velocities of all n joints by those of the m independent ones.
    """
    joints = [placed.joint for placed in mass.placement.joints]
    index = {joint.name: k for k, joint in enumerate(joints)}
    independent = [k for k, joint in enumerate(joints) if joint.nature == "independent"]
    dependent = [k for k, joint in enumerate(joints) if joint.nature == "dependent"]
    reduction = np.zeros((len(joints), len(independent)))
    reduction[independent, range(len(independent))] = 1.0
    rows = [row for cut in mass.mbs.cuts for row in compute_constraint_rows(mass, cut)]
    for coupling in simulation.couplings:
        row = np.zeros(len(joints))
        row[index[coupling.follower.name]] = 1.0
        row[index[coupling.leader.name]] = -coupling.multiplier
        rows.append(row)
    if rows:
        # J_dependent v = -J_independent u, in the sense of least squares.
        jacobian = np.array(rows)
        reduction[dependent] = np.linalg.lstsq(
            jacobian[:, dependent], -jacobian[:, independent], rcond=None
        )[0]
    return reduction


def compute_constraint_rows(mass: MassModel, cut: Connection) -> list[Array]:
    """Compute the rows (n,) of the constraint Jacobian that a cut adds.

    Returns:
        One row for the length of a rod; three for the distance between the ends of a ball, along
        the axes of the base; of a solid, three more for the rotation of the second body against
        the first.
    """
    positions = [
        compute_point_position(mass.placement, mass.mbs, *end)
        for end in (cut.endpoint1, cut.endpoint2)
    ]
    first_body, second_body = cut.endpoint1[0], cut.endpoint2[0]
    first = mass.compute_point_jacobian(first_body, positions[0])
    second = mass.compute_point_jacobian(second_body, positions[1])
    translation = second - first
    if cut.kind == "rod":
        rod = np.array(positions[1]) - np.array(positions[0])
        # The direction of a rod without length is not defined: any one does.
        direction = rod / np.linalg.norm(rod) if rod.any() else np.eye(3)[0]
        return [direction @ translation]
    if cut.kind == "solid":
        first = mass.compute_rotation_jacobian(first_body)
        second = mass.compute_rotation_jacobian(second_body)
        return [*translation, *(second - first)]
    return [*translation]


def compute_effective_inertias(mass: MassModel, reduction: Array) -> Array:
    """Compute the inertia that a force at each joint has to move while all joints are free.

    It is ``1 / (M^-1)_ii``, with the reduced mass matrix M.

    Args:
        mass: The mass matrix.
        reduction: (n, m), from ``compute_reduction``.

    Returns:
        (n,), in kg m^2 or kg; infinite for a joint that does not move.
    """
    basis = _find_unit_mass_basis(reduction.T @ mass.matrix @ reduction)
    mobility = ((reduction @ basis) ** 2).sum(axis=1)
    inertias: Array = np.full(len(reduction), inf)
    np.divide(1.0, mobility, out=inertias, where=mobility > 0.0)
    return inertias


def _find_unit_mass_basis(mass_matrix: Array) -> Array:
    """Find velocities (m, k) in which the mass matrix is the unit matrix, without massless ones."""
    # Scaling each joint to unit inertia keeps a light finger from vanishing beside a heavy arm.
    scale = np.sqrt(np.maximum(np.diag(mass_matrix), 0.0))
    scale[scale == 0.0] = 1.0
    eigenvalues, vectors = np.linalg.eigh(mass_matrix / np.outer(scale, scale))
    has_mass = eigenvalues > MASSLESS * max(eigenvalues, default=0.0)
    basis: Array = vectors[:, has_mass] / np.sqrt(eigenvalues[has_mass]) / scale[:, None]
    return basis


def find_fastest_mode(mass_matrix: Array, forces: list[SpringDamper]) -> Mode:
    """Find the mode that needs the shortest step.

    Massless directions are left out: Robotran cannot solve for their accelerations.

    Args:
        mass_matrix: (m, m), for the m independent joints.
        forces: The springs and dampers of the linearised model.
    """
    unlimited = Mode(inf, 0j, np.zeros(len(forces)))
    basis = _find_unit_mass_basis(mass_matrix)
    if not forces or not basis.size:
        return unlimited
    rows = np.array([force.jacobian_row for force in forces]) @ basis
    stiffness = np.array([force.stiffness for force in forces])
    damping = np.array([force.damping for force in forces])
    # With unit masses, (x, u)' = ((0, 1), (-K, -D)) (x, u).
    n = rows.shape[1]
    system = np.zeros((2 * n, 2 * n))
    system[:n, n:] = np.eye(n)
    system[n:, :n] = -(rows.T * stiffness) @ rows
    system[n:, n:] = -(rows.T * damping) @ rows
    eigenvalues, vectors = np.linalg.eig(system)
    steps = compute_longest_steps(eigenvalues)
    k = int(np.argmin(steps))
    if steps[k] == inf:
        return unlimited
    motion = rows @ vectors[:n, k]
    shares = np.abs((eigenvalues[k] * damping + stiffness) * motion * motion.conj())
    return Mode(float(steps[k]), complex(eigenvalues[k]), shares / max(shares.max(), 1e-300))


def compute_longest_steps(eigenvalues: Array) -> Array:
    """Compute the longest stable step (s) for each eigenvalue (1/s); infinite for zero.

    Along the ray of an eigenvalue in the left half-plane, ``|R(z)| = 1`` is crossed once between
    |z| = 2 and |z| = 4, where bisection finds it.
    """
    size = np.abs(eigenvalues)
    is_zero = size <= ZERO_RATE * max(size, default=0.0)
    # A damped model cannot grow: a real part above zero is rounding.
    damped = -np.abs(eigenvalues.real) + 1j * eigenvalues.imag
    direction = np.where(is_zero, -1.0, damped) / np.where(is_zero, 1.0, size)
    low, high = np.full(len(eigenvalues), 2.0), np.full(len(eigenvalues), 4.0)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        z = middle * direction
        amplification = np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4))))
        is_stable = amplification <= 1.0 + AMPLIFICATION_ROUNDING
        low, high = np.where(is_stable, middle, low), np.where(is_stable, high, middle)
    return np.where(is_zero, inf, low / np.where(is_zero, 1.0, size))
