"""Time step: the longest step that a Runge-Kutta integrator can take with this robot.

Beyond the method.  The model is linearised at the start position, with all stops hit and all feet
on the ground.  ``TIME_STEP`` is the part ``PART`` of the longest step with which all eigenvalues
are stable: the robot moves away from the start, and a step must be accurate, too.  Within the step
in which a joint hits a stop, Runge and Kutta's method is of the second order only, so that robots
with stops take ``HITTING`` at most.  No force is softened for a longer step: the runtime of
urdf2mbs takes steps of its own, and a warning names what makes this one shorter than ``SHORTEST``.
``docs/passes/time-step.md`` derives all this.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import floor, hypot, log10, sqrt
from typing import TYPE_CHECKING

from urdf2mbs.plugin import Conversion, Pass
from urdf2mbs_project.places import point_at
from urdf2mbs_project.simulation import Simulation, numbers_of

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, Mass
    from urdf2mbs_project.stability import Slope

#: The step is this part of the longest stable one.
PART = 0.4
#: The longest step of joints with stops, and the one below which a warning is given (s).
HITTING, SHORTEST = 1e-4, 1e-5
#: Computing time (s) of a step of RK4 for each joint: MBsysC of 2017 with -O3 needs 1.1 to 1.5e-6 s
#: for robots of 18 to 38 joints without loops.
TIME_OF_STEP = 1.3e-6
#: The user models that the forces of a project depend on.
NUMBERS = (
    "joint_forces", "damping", "friction_stiffness", "stop_stiffness", "spring_stiffness",
    "hold_stiffness", "hold_damping", "contact", "link_stiffness", "link_damping",
)  # fmt: skip
#: By kind of slope, how it is called.
NAMES = {
    "damping": "the damping of joint '{}'", "friction": "the friction of joint '{}'",
    "stop": "the stop of joint '{}'", "hold": "the hold of joint '{}'",
    "contact": "the ground's push on '{}'", "slip": "the ground's friction on '{}'",
    "spring": "the spring '{}'",
}  # fmt: skip

Models = dict[str, dict[str, float]]


class TimeStep(Pass):
    reads = ("base", "bodies", "inertias", "joints", "couplings", "anchors", "posture", "forces")
    writes = ("forces",)

    def run(self, conversion: Conversion) -> None:
        if not conversion.mbs.bodies or conversion.settings.project is None:
            return
        from urdf2mbs_project.mass import Mass
        from urdf2mbs_project.stability import fastest, reduction_of

        simulation = conversion.state(Simulation)
        mass = Mass(conversion.mbs)
        reduction = reduction_of(mass, simulation)
        reduced = reduction.T @ mass.matrix @ reduction
        models = numbers_of(conversion.mbs, NUMBERS)
        slopes = list(_slopes(conversion, mass, reduction, models))
        mode = fastest(reduced, slopes)
        if "stop_stiffness" in models:
            simulation.time_step, simulation.shortened_by = HITTING, "joints that hit their stops"
        if mode.step * PART < simulation.time_step:
            worst = slopes[int(mode.shares.argmax())]
            simulation.shortened_by = NAMES[worst.kind].format(worst.name)
            simulation.time_step = _round_down(mode.step * PART)
            conversion.note(
                "time-step",
                f"TIME_STEP is {simulation.time_step:g} s, as {simulation.shortened_by} needs so "
                "short a step",
            )
            if simulation.time_step < SHORTEST:
                _warn_of_short_step(conversion, _describe_slope(worst, mass, reduction))


def _slopes(
    conversion: Conversion, mass: Mass, reduction: Array, models: Models
) -> Iterator[Slope]:
    """The forces of the generated code, by the velocities of the independent joints."""
    import numpy as np

    from urdf2mbs_project.stability import Slope, felt

    index = {placed.joint.name: k for k, placed in enumerate(mass.placement.joints)}
    for name, value in models.get("damping", {}).items():
        yield Slope("damping", name, reduction[index[name]], 0.0, value)
    for name, value in models.get("friction_stiffness", {}).items():
        damping = value * models["joint_forces"]["friction_time"]
        yield Slope("friction", name, reduction[index[name]], value, damping)
    feels = felt(mass, reduction)
    for name, value in models.get("stop_stiffness", {}).items():
        # at stop_speed it goes in by speed / frequency
        damping = sqrt(min(feels[index[name]], 1e300) * value)
        yield Slope("stop", name, reduction[index[name]], 2.0 * value, damping)
    for name, value in models.get("spring_stiffness", {}).items():
        yield Slope("spring", name, reduction[index[name]], max(value, 0.0), 0.0)
    for name, value in models.get("hold_stiffness", {}).items():
        yield Slope("hold", name, reduction[index[name]], value, models["hold_damping"][name])
    stance = conversion.state(Simulation).stance
    if stance:
        law = models["contact"]
        up = np.array(conversion.state(Simulation).up)
        total = sum(body.mass or 0.0 for body in mass.mbs.bodies)
        share = total * hypot(*mass.mbs.base.gravity) / len(stance)
        _, _, plane = np.linalg.svd(up[None])
        for body, at in stance:
            moved = mass.point(body, at) @ reduction
            yield Slope("contact", body, up @ moved, law["stiffness"], share / law["speed"])
            stiffness = share / law["bristle"]
            damping = stiffness * law["bristle_time"]
            for way in plane[1:]:
                yield Slope("slip", body, way @ moved, stiffness, damping)
    for link in conversion.state(Simulation).springs:
        (one, here), (two, there) = (
            (at, mass.point(end[0], at))
            for end in (link.endpoint1, link.endpoint2)
            for at in [point_at(mass.placement, mass.mbs, *end)]
        )
        way = np.array(two) - np.array(one)
        row = way / np.linalg.norm(way) @ (there - here) @ reduction
        yield Slope("spring", link.name, row, models["link_stiffness"][link.name],
                    models["link_damping"][link.name])  # fmt: skip


def _describe_slope(slope: Slope, mass: Mass, reduction: Array) -> str:
    """Name a force; of a joint's, also its size and the inertia that the joint feels."""
    from urdf2mbs_project.stability import felt

    name = NAMES[slope.kind].format(slope.name)
    joints = [placed.joint for placed in mass.placement.joints]
    index = next((k for k, joint in enumerate(joints) if joint.name == slope.name), None)
    if index is None:
        return name
    turns = joints[index].type.startswith("R")
    force, inertia, unit = ("N m", "kg m^2", "rad") if turns else ("N", "kg", "m")
    sizes = []
    if slope.stiffness:
        sizes.append(f"{slope.stiffness:.3g} {force}/{unit}")
    if slope.damping:
        sizes.append(f"{slope.damping:.3g} {force} s/{unit}")
    feels = felt(mass, reduction)[index]
    return f"{name} ({' and '.join(sizes)}, where the joint feels {feels:.2g} {inertia})"


def _warn_of_short_step(conversion: Conversion, reason: str) -> None:
    """Say what a short step costs, and which force needs it."""
    time_step = conversion.state(Simulation).time_step
    n_steps = 1.0 / time_step
    seconds = n_steps * TIME_OF_STEP * len(conversion.mbs.numbers())
    conversion.warn(
        "time-step-short",
        f"TIME_STEP is only {time_step:g} s, because of {reason}: 1 s of motion takes "
        f"{n_steps:.2g} steps of RK4, about {_describe_duration(seconds)} of computing in C, and "
        "far longer in Python",
        hint="see if the robot's file states a likely number, and a likely inertia; 'urdf2mbs "
        "simulate' chooses its own steps",
    )


def _describe_duration(seconds: float) -> str:
    """Return a time to one digit, in seconds, minutes or hours."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{float(f'{seconds / size:.1g}'):g} {unit}"
    return f"{float(f'{seconds:.1g}'):g} s"


def _round_down(value: float) -> float:
    """To two significant digits."""
    digit = 10.0 ** (floor(log10(value)) - 1)
    return float(f"{floor(value / digit * (1 + 1e-9)) * digit:.1e}")
