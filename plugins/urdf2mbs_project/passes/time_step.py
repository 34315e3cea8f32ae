"""Time step: choose the longest step that a Runge-Kutta integrator can take with this robot.

Beyond the method.  Each force of the generated code becomes a spring and a damper at the start
position, as if all joints were at their stops and all feet on the ground::

    force          stiffness             damping
    damping        -                     damping
    friction       bristle               bristle * bristle time
    stop           2 stop                (effective inertia * stop)^(1/2)
    spring         spring                -
    hold           hold                  hold
    contact        ground                share of the weight / speed
    slip           share / bristle       stiffness * bristle time
    link           link                  link

``urdf2mbs_project.stability`` finds the longest step with which all modes of this model are stable.
``TIME_STEP`` is ``STABLE_SHARE`` of it: the robot moves away from the start, and a step must be
accurate, too.  In the step in which a joint hits a stop, Runge and Kutta's method is of the second
order only, so that robots with stops take ``MAX_STEP_WITH_STOPS`` at most.  No force is softened
for a longer step: the runtime of urdf2mbs chooses its own steps, and a warning names the force that
makes this one shorter than ``MIN_STEP``.  ``docs/passes/time-step.md`` derives all this.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import floor, hypot, log10, sqrt
from typing import TYPE_CHECKING

from urdf2mbs.plugin import Conversion, Pass
from urdf2mbs_project.places import compute_point_position
from urdf2mbs_project.simulation import Simulation, read_parameters

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, MassModel
    from urdf2mbs_project.stability import SpringDamper

#: The step, relative to the longest stable one.
STABLE_SHARE = 0.4
#: The longest step (s) of robots with stops.
MAX_STEP_WITH_STOPS = 1e-4
#: A step (s) below this gets a warning.
MIN_STEP = 1e-5
#: Computing time (s) of a step of RK4 for each joint: MBsysC of 2017 with -O3 needs 1.1 to 1.5e-6 s
#: for robots of 18 to 38 joints without loops.
COMPUTING_TIME = 1.3e-6
#: The effective inertia (kg m^2 or kg) of a locked joint, in place of an infinite one.
MAX_INERTIA = 1e300
#: The user models that the forces of a project depend on.
FORCE_MODELS = (
    "joint_forces",
    "damping",
    "friction_stiffness",
    "stop_stiffness",
    "spring_stiffness",
    "hold_stiffness",
    "hold_damping",
    "contact",
    "link_stiffness",
    "link_damping",
)
#: The texts by which a message names a force, by its kind.
FORCE_TEXTS = {
    "damping": "the damping of joint '{}'",
    "friction": "the friction of joint '{}'",
    "stop": "the stop of joint '{}'",
    "hold": "the hold of joint '{}'",
    "contact": "the ground's push on '{}'",
    "slip": "the ground's friction on '{}'",
    "spring": "the spring '{}'",
}

Numbers = Mapping[str, float]


class TimeStep(Pass):
    """Choose the time step of a project."""

    reads = ("base", "bodies", "inertias", "joints", "couplings", "anchors", "posture", "forces")
    writes = ("forces",)

    def run(self, conversion: Conversion) -> None:
        """Set the time step, and warn if it is short."""
        if not conversion.mbs.bodies or conversion.settings.project is None:
            return
        from urdf2mbs_project.mass import MassModel
        from urdf2mbs_project.stability import compute_reduction, find_fastest_mode

        simulation = conversion.state(Simulation)
        mass = MassModel(conversion.mbs)
        reduction = compute_reduction(mass, simulation)
        reduced = reduction.T @ mass.matrix @ reduction
        models = read_parameters(conversion.mbs, FORCE_MODELS)
        forces = linearise_forces(simulation, mass, reduction, models)
        mode = find_fastest_mode(reduced, forces)
        if "stop_stiffness" in models:
            simulation.time_step = MAX_STEP_WITH_STOPS
            simulation.shortened_by = "joints that hit their stops"
        if mode.step * STABLE_SHARE >= simulation.time_step:
            return
        force = forces[int(mode.shares.argmax())]
        simulation.shortened_by = FORCE_TEXTS[force.kind].format(force.name)
        simulation.time_step = round_to_two_digits_below(mode.step * STABLE_SHARE)
        message = (
            f"TIME_STEP is {simulation.time_step:g} s, as {simulation.shortened_by} needs so "
            "short a step"
        )
        conversion.note("time-step", message)
        if simulation.time_step < MIN_STEP:
            _warn_of_short_step(conversion, _describe_force(force, mass, reduction))


# --- the forces of the generated code, as springs and dampers ---


def linearise_forces(
    simulation: Simulation, mass: MassModel, reduction: Array, models: Mapping[str, Numbers]
) -> list[SpringDamper]:
    """Return the forces of the generated code as springs and dampers.

    Args:
        simulation: The contacts, springs and directions of the project.
        mass: The mass matrix at the start position.
        reduction: (n, m), from ``compute_reduction``.
        models: The numbers of the user models, see ``FORCE_MODELS``.
    """
    return [
        *_linearise_joint_forces(mass, reduction, models),
        *_linearise_contacts(simulation, mass, reduction, models.get("contact", {})),
        *_linearise_links(simulation, mass, reduction, models),
    ]


def _linearise_joint_forces(
    mass: MassModel, reduction: Array, models: Mapping[str, Numbers]
) -> Iterator[SpringDamper]:
    """Yield the forces in joints, with all stops hit."""
    from urdf2mbs_project.stability import SpringDamper, compute_effective_inertias

    index = {placed.joint.name: k for k, placed in enumerate(mass.placement.joints)}
    rows = {name: reduction[k] for name, k in index.items()}
    for name, damping in models.get("damping", {}).items():
        yield SpringDamper("damping", name, rows[name], 0.0, damping)
    for name, stiffness in models.get("friction_stiffness", {}).items():
        damping = stiffness * models["joint_forces"]["friction_time"]
        yield SpringDamper("friction", name, rows[name], stiffness, damping)
    inertias = compute_effective_inertias(mass, reduction)
    for name, stiffness in models.get("stop_stiffness", {}).items():
        # F = stiffness depth (1 + rate / stop_speed).  A joint that hits at stop_speed goes in by
        # stop_speed (I / stiffness)^(1/2): there dF/dq = 2 stiffness, dF/dqd = (I stiffness)^(1/2).
        damping = sqrt(min(inertias[index[name]], MAX_INERTIA) * stiffness)
        yield SpringDamper("stop", name, rows[name], 2.0 * stiffness, damping)
    for name, stiffness in models.get("spring_stiffness", {}).items():
        yield SpringDamper("spring", name, rows[name], max(stiffness, 0.0), 0.0)
    for name, stiffness in models.get("hold_stiffness", {}).items():
        yield SpringDamper("hold", name, rows[name], stiffness, models["hold_damping"][name])


def _linearise_contacts(
    simulation: Simulation, mass: MassModel, reduction: Array, law: Numbers
) -> Iterator[SpringDamper]:
    """Yield the push and the friction of the ground at each spot of the stance.

    Each spot carries the same share of the weight.
    """
    import numpy as np

    from urdf2mbs_project.stability import SpringDamper

    if not simulation.stance:
        return
    up = np.array(simulation.up)
    total_mass = sum(body.mass or 0.0 for body in mass.mbs.bodies)
    share = total_mass * hypot(*mass.mbs.base.gravity) / len(simulation.stance)
    friction_stiffness = share / law["bristle"]
    friction_damping = friction_stiffness * law["bristle_time"]
    # The right singular vectors of a row are its direction, then those across it.
    _, _, directions = np.linalg.svd(up[None])
    for body, position in simulation.stance:
        jacobian = mass.compute_point_jacobian(body, position) @ reduction
        row = up @ jacobian
        yield SpringDamper("contact", body, row, law["stiffness"], share / law["speed"])
        for horizontal in directions[1:]:
            row = horizontal @ jacobian
            yield SpringDamper("slip", body, row, friction_stiffness, friction_damping)


def _linearise_links(
    simulation: Simulation, mass: MassModel, reduction: Array, models: Mapping[str, Numbers]
) -> Iterator[SpringDamper]:
    """Yield the springs between two points."""
    import numpy as np

    from urdf2mbs_project.stability import SpringDamper

    for link in simulation.springs:
        endpoints = (link.endpoint1, link.endpoint2)
        start, end = (
            compute_point_position(mass.placement, mass.mbs, *endpoint) for endpoint in endpoints
        )
        start_jacobian = mass.compute_point_jacobian(link.endpoint1[0], start)
        end_jacobian = mass.compute_point_jacobian(link.endpoint2[0], end)
        vector = np.array(end) - np.array(start)
        row = vector / np.linalg.norm(vector) @ (end_jacobian - start_jacobian) @ reduction
        stiffness, damping = models["link_stiffness"][link.name], models["link_damping"][link.name]
        yield SpringDamper("spring", link.name, row, stiffness, damping)


# --- messages ---


def _describe_force(force: SpringDamper, mass: MassModel, reduction: Array) -> str:
    """Name a force; that of a joint with its size and the inertia that the joint feels."""
    from urdf2mbs_project.stability import compute_effective_inertias

    text = FORCE_TEXTS[force.kind].format(force.name)
    joints = [placed.joint for placed in mass.placement.joints]
    index = next((k for k, joint in enumerate(joints) if joint.name == force.name), None)
    if index is None:
        return text
    is_revolute = joints[index].type.startswith("R")
    unit, inertia_unit, angle = ("N m", "kg m^2", "rad") if is_revolute else ("N", "kg", "m")
    sizes = []
    if force.stiffness:
        sizes.append(f"{force.stiffness:.3g} {unit}/{angle}")
    if force.damping:
        sizes.append(f"{force.damping:.3g} {unit} s/{angle}")
    inertia = compute_effective_inertias(mass, reduction)[index]
    return f"{text} ({' and '.join(sizes)}, where the joint feels {inertia:.2g} {inertia_unit})"


def _warn_of_short_step(conversion: Conversion, reason: str) -> None:
    """Warn of a short step: its cost, and the force that needs it."""
    time_step = conversion.state(Simulation).time_step
    n_steps = 1.0 / time_step
    seconds = n_steps * COMPUTING_TIME * len(conversion.mbs.numbers())
    message = (
        f"TIME_STEP is only {time_step:g} s, because of {reason}: 1 s of motion takes "
        f"{n_steps:.2g} steps of RK4, about {describe_duration(seconds)} of computing in C, and "
        "far longer in Python"
    )
    hint = (
        "see if the robot's file states a likely number, and a likely inertia; 'urdf2mbs "
        "simulate' chooses its own steps"
    )
    conversion.warn("time-step-short", message, hint=hint)


def describe_duration(seconds: float) -> str:
    """Return a time to one digit, in seconds, minutes or hours."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{float(f'{seconds / size:.1g}'):g} {unit}"
    return f"{float(f'{seconds:.1g}'):g} s"


def round_to_two_digits_below(value: float) -> float:
    """Round a number down to two significant digits."""
    digit = 10.0 ** (floor(log10(value)) - 1)
    # A number that is off its own two digits by rounding only keeps them.
    return float(f"{floor(value / digit * (1 + 1e-9)) * digit:.1e}")
