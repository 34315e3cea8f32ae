"""Joint parameters: limits, damping, friction, springs and the like, as user models of the .mbs.

Beyond the method: an .mbs has no such properties of joints, but it has user models, which can be
edited in MBSysPad and read by user functions.  Each kind of property is one user model; its
parameters are scalars, called as the joints are.

A project applies damping, friction, springs and soft stops; ``docs/passes/joint-parameters.md`` has
their laws.  The pass chooses the stiffness of a stop and of a bristle of friction from the inertia
``I`` that the joint feels at the start position, while all other joints are free.  A stop has
``I (2 pi stop_frequency)^2``: a limb of length l sinks in under its own weight by about
``g / (l (2 pi stop_frequency)^2)``, however heavy the limb is.  A bristle has ``I FASTEST^2``.
"""

from __future__ import annotations

from math import isfinite, pi
from typing import Annotated

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs import model as mbs
from urdf2mbs.mbs.model import UserModel
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs_project.simulation import rounded
from urdf2mbs.urdf.model import Joint

#: The moved inertia would swing on the bristle at this rate (1/s).
FASTEST = 300.0
#: ``T`` of a bristle (s): it damps by 2 D I FASTEST, with D = 0.75.
TIME = 1.5 / FASTEST

#: The kinds that only a project applies.
DYNAMICS = ("damping", "friction", "spring_stiffness")


class JointParameters(Pass):
    reads = ("robot", "inertias", "joints", "couplings", "posture")
    writes = ("forces",)

    stops: bool = True
    """Give joints soft stops at their limits."""
    stop_frequency: Annotated[float, msgspec.Meta(gt=0.0, le=1e3)] = 20.0
    """Stiffness of the stops, as a frequency (Hz): the moved inertia would swing on the stop so
    fast."""

    def run(self, conversion: Conversion) -> None:
        held = [(step.joint, joint) for step, joint in conversion.single_coordinates()]
        models = {kind: values for kind, values in _kinds(conversion, held).items() if values}
        in_project = conversion.settings.project is not None
        if in_project:
            models = self._apply(conversion, models)
        conversion.mbs.user_models += [UserModel.of(*model) for model in models.items()]
        if models:
            conversion.report["joint-parameters"] = models
        names = {name for kind in DYNAMICS for name in models.get(kind, ())}
        sprung = {joint.name for joint, _ in held}
        conversion.simulation.used += [
            extension
            for extension in conversion.robot.extensions
            if "springStiffness" in extension.numbers and extension.reference in sprung
        ]
        if names and not in_project:
            springs = "spring_stiffness" in models
            conversion.note(
                "joint-dynamics",
                f"{'damping, friction and springs' if springs else 'damping and friction'} of "
                f"{counted(len(names), 'joint')} are in user models, but "
                "nothing applies them; a project does: 'output: {project: DIR}'",
            )

    def _apply(
        self, conversion: Conversion, models: dict[str, dict[str, float]]
    ) -> dict[str, dict[str, float]]:
        """Add the numbers that the code of a project applies these models with."""
        limited = dict.fromkeys((*models.get("q_min", ()), *models.get("q_max", ())))
        rubbing = models.get("friction", {})
        inertias = _inertias(conversion) if limited or rubbing else {}
        switches: dict[str, float] = {}
        chosen: dict[str, dict[str, float]] = {}
        if "damping" in models:
            switches["damping"] = 1.0
        if "spring_stiffness" in models:
            switches["springs"] = 1.0
        if rubbing:
            switches |= {"friction": 1.0, "friction_time": TIME}
            chosen["friction_stiffness"] = {
                name: rounded((inertias[name] or 1.0) * FASTEST**2) for name in rubbing
            }
        if limited and self.stops:
            switches |= {"stops": 1.0, "stop_speed": 1.0}
            stiff = (2 * pi * self.stop_frequency) ** 2
            chosen["stop_stiffness"] = {name: rounded(inertias[name] * stiff) for name in limited}
        return {**({"joint_forces": switches} if switches else {}), **models, **chosen}


def _kinds(
    conversion: Conversion, joints: list[tuple[Joint, mbs.Joint]]
) -> dict[str, dict[str, float]]:
    """The values of each kind of property, by .mbs joint.  The pass ``left-out`` does not name
    these properties."""
    kinds: dict[str, dict[str, float]] = {
        kind: {}
        for kind in (
            "q_min", "q_max", "effort", "velocity", "damping", "friction",
            "spring_stiffness", "spring_reference",
            "soft_q_min", "soft_q_max", "k_position", "k_velocity",
            "calibration_rising", "calibration_falling",
        )
    }  # fmt: skip
    for joint, own in joints:
        for code, part in (
            ("limit", joint.limit), ("joint-dynamics", joint.dynamics),
            ("safety-controller", joint.safety_controller), ("calibration", joint.calibration),
        ):  # fmt: skip
            if part is not None:
                conversion.simulation.kept.setdefault(code, set()).add(joint.name)
        values: dict[str, float | None] = {}
        if joint.limit is not None:
            low, high = joint.limit.lower, joint.limit.upper
            if joint.type != "continuous" and (low is None or high is None or low < high):
                values["q_min"], values["q_max"] = low, high
            values["effort"], values["velocity"] = joint.limit.effort, joint.limit.velocity
        if joint.dynamics is not None:
            values["damping"] = joint.dynamics.damping or None
            values["friction"] = joint.dynamics.friction or None
            if joint.dynamics.spring_stiffness:
                values["spring_stiffness"] = joint.dynamics.spring_stiffness
                values["spring_reference"] = joint.dynamics.spring_reference
        if joint.safety_controller is not None:
            safety = joint.safety_controller
            if safety.soft_lower_limit < safety.soft_upper_limit:
                values["soft_q_min"] = safety.soft_lower_limit
                values["soft_q_max"] = safety.soft_upper_limit
            values["k_position"], values["k_velocity"] = safety.k_position, safety.k_velocity
        if joint.calibration is not None:
            values["calibration_rising"] = joint.calibration.rising
            values["calibration_falling"] = joint.calibration.falling
        for kind, value in values.items():
            if value is not None and isfinite(value):
                kinds[kind][own.name] = float(value)
    return kinds


def _inertias(conversion: Conversion) -> dict[str, float]:
    """The inertia that each joint feels in a project (kg m^2, kg)."""
    from urdf2mbs.mbs.mass import Mass
    from urdf2mbs_project.code.stability import felt, reduction_of

    mass = Mass(conversion.mbs)
    inertias = felt(mass, reduction_of(mass, conversion.simulation))
    return {
        placed.joint.name: float(inertia) if isfinite(inertia) else 0.0
        for placed, inertia in zip(mass.placement.joints, inertias, strict=True)
    }
