"""Hold gains: choose stiffness and damping of the controller that holds the start position.

Beyond the method.  The gains follow the inertia I that each joint carries at the start position:
``stiffness = I (2 pi frequency)^2`` and ``damping = 2 damping_ratio (I stiffness)^(1/2)``, the
numbers of an oscillator with one degree of freedom.  A light foot below a heavy robot would need a
very short time step, so both are limited by the effective inertia, which the joint feels while all
others are free.  ``docs/passes/hold-gains.md`` says what a joint carries.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

from urdf2mbs.plugin import Conversion, Pass, UserModel, rounded
from urdf2mbs_project.balance import warn_of_weak_motors
from urdf2mbs_project.places import find_floating_body, list_joints_to_base
from urdf2mbs_project.simulation import Held, Simulation, read_parameters

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, MassModel

#: The largest damping (1/s) and stiffness (1/s^2), relative to the effective inertia of a joint.
MAX_DAMPING, MAX_STIFFNESS = 3000.0, 1e8


class HoldGains(Pass):
    """Choose the gains of the controller that holds the start position."""

    reads = ("base", "bodies", "inertias", "joints", "couplings", "anchors", "posture", "forces")
    writes = ("forces",)

    def run(self, conversion: Conversion) -> None:
        """Add the gains as user models, and warn of motors that are too weak."""
        simulation = conversion.state(Simulation)
        if not conversion.mbs.bodies or not simulation.hold:
            return
        from urdf2mbs_project.mass import MassModel
        from urdf2mbs_project.stability import compute_effective_inertias, compute_reduction

        mass = MassModel(conversion.mbs)
        reduction = compute_reduction(mass, simulation)
        carried_inertias = _compute_carried_inertias(simulation, mass, reduction)
        effective_inertias = compute_effective_inertias(mass, reduction)
        held_joints = {held.joint.name: held for held in simulation.hold}
        stiffness: dict[str, float] = {}
        damping: dict[str, float] = {}
        for index, placed in enumerate(mass.placement.joints):
            name = placed.joint.name
            if name in held_joints:
                stiffness[name], damping[name] = _choose_gains(
                    held_joints[name], carried_inertias[index], float(effective_inertias[index])
                )
        conversion.mbs.user_models += [
            UserModel.of("hold", {"on": 1.0}),
            UserModel.of("hold_stiffness", stiffness),
            UserModel.of("hold_damping", damping),
        ]
        efforts = read_parameters(conversion.mbs, ["effort"]).get("effort", {})
        warn_of_weak_motors(conversion, mass, reduction, efforts)


def _choose_gains(held: Held, carried: float, effective: float) -> tuple[float, float]:
    """Choose the stiffness (N m/rad, N/m) and damping (N m s/rad, N s/m) of a joint.

    Args:
        held: The joint, and what the config says of its gains.
        carried: The inertia that it carries (kg m^2 or kg).
        effective: Its effective inertia (kg m^2 or kg).
    """
    stiffness, damping = held.stiffness, held.damping
    if stiffness is None:
        unlimited = carried * (2 * pi * held.frequency) ** 2
        stiffness = rounded(min(unlimited, MAX_STIFFNESS * effective))
    if damping is None:
        unlimited = 2 * held.damping_ratio * sqrt(carried * stiffness)
        damping = rounded(min(unlimited, MAX_DAMPING * effective))
    return stiffness, damping


def _compute_carried_inertias(
    simulation: Simulation, mass: MassModel, reduction: Array
) -> list[float]:
    """Compute the inertia that each joint carries (kg m^2 or kg), with all that follow it.

    It is that of all bodies that the joint moves, with all further joints locked.  A joint of a
    leg, between a floating base and the ground, carries at least its share of the rest of the
    robot.
    """
    feet = {body for body, _ in simulation.stance}
    reduced = reduction.T @ mass.matrix @ reduction
    total = mass.compute_total_inertia()
    floats = find_floating_body(mass.mbs) is not None
    inertias: list[float] = []
    for index, twist in enumerate(mass.twists):
        inertia = float(reduction[index] @ reduced @ reduction[index])
        n_moved_feet = sum(index in list_joints_to_base(mass.placement, foot) for foot in feet)
        if n_moved_feet and floats:
            rest = float(twist @ (total - mass.composite_inertias[index]) @ twist)
            inertia = max(inertia, rest * n_moved_feet / len(feet))
        inertias.append(inertia)
    return inertias
