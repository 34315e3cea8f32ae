"""Hold gains: stiffness and damping of the controller that holds the start position.

Beyond the method.  The gains follow the inertia I that each joint carries at the start position:
``stiffness = I (2 pi frequency)^2`` and ``damping = 2 damping_ratio (I stiffness)^(1/2)``, the
numbers of an oscillator with one degree of freedom.  A light foot below a heavy robot would ask for
a very short time step, so that both are bounded by the inertia that the joint feels while all
others are free.  ``docs/passes/hold-gains.md`` says what a joint carries.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

from urdf2mbs.plugin import Conversion, Pass, UserModel, rounded
from urdf2mbs_project.balance import warn_of_weak_motors
from urdf2mbs_project.places import floating, way
from urdf2mbs_project.simulation import Simulation, numbers_of

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, Mass

#: The largest damping (1/s) and stiffness (1/s^2), in parts of the inertia that a joint feels.
MAX_DAMPING, MAX_STIFFNESS = 3000.0, 1e8


class HoldGains(Pass):
    reads = ("base", "bodies", "inertias", "joints", "couplings", "anchors", "posture", "forces")
    writes = ("forces",)

    def run(self, conversion: Conversion) -> None:
        simulation = conversion.state(Simulation)
        if not conversion.mbs.bodies or not simulation.hold:
            return
        from urdf2mbs_project.mass import Mass
        from urdf2mbs_project.stability import felt, reduction_of

        mass = Mass(conversion.mbs)
        reduction = reduction_of(mass, simulation)
        carried = _carried_inertias(simulation, mass, reduction)
        feels = felt(mass, reduction)
        holding = {held.joint.name: held for held in simulation.hold}
        stiffness: dict[str, float] = {}
        damping: dict[str, float] = {}
        for index, placed in enumerate(mass.placement.joints):
            held = holding.get(placed.joint.name)
            if held is None:
                continue
            inertia, k, d = carried[index], held.stiffness, held.damping
            if k is None:
                wanted = inertia * (2 * pi * held.frequency) ** 2
                k = rounded(min(wanted, MAX_STIFFNESS * float(feels[index])))
            if d is None:
                wanted = 2 * held.damping_ratio * sqrt(inertia * k)
                d = rounded(min(wanted, MAX_DAMPING * float(feels[index])))
            stiffness[held.joint.name], damping[held.joint.name] = k, d
        conversion.mbs.user_models += [
            UserModel.of("hold", {"on": 1.0}),
            UserModel.of("hold_stiffness", stiffness),
            UserModel.of("hold_damping", damping),
        ]
        motors = numbers_of(conversion.mbs, ["effort"]).get("effort", {})
        warn_of_weak_motors(conversion, mass, reduction, motors)


def _carried_inertias(simulation: Simulation, mass: Mass, reduction: Array) -> list[float]:
    """Return the inertia that each joint carries (kg m^2 or kg), with all that follows it.

    It is that of all bodies behind the joint, with all further joints locked.  A joint of a leg,
    between a floating base and the ground, carries at least its share of the rest of the robot.
    """
    feet = {body for body, _ in simulation.stance}
    reduced = reduction.T @ mass.matrix @ reduction
    whole = mass.behind[[placed.previous < 0 for placed in mass.placement.joints]].sum(axis=0)
    floats = floating(mass.mbs) is not None
    carried: list[float] = []
    for index, twist in enumerate(mass.twists):
        inertia = float(reduction[index] @ reduced @ reduction[index])
        standing = sum(index in way(mass.placement, foot) for foot in feet)
        if standing and floats:
            rest = float(twist @ (whole - mass.behind[index]) @ twist)
            inertia = max(inertia, rest * standing / len(feet))
        carried.append(inertia)
    return carried
