"""Joint laws: add the numbers by which the code of a project applies the joints' parameters.

Beyond the method.  A project applies the damping, friction, springs and limits that
``joint-parameters`` has added; ``docs/passes/joint-laws.md`` has their laws.  The pass chooses the
stiffness of a stop and of a bristle of friction from the effective inertia ``I``, which the joint
feels at the start position while all others are free.  A stop has ``I (2 pi stop_frequency)^2``: a
limb of length l sinks in under its own weight by about ``g / (l (2 pi stop_frequency)^2)``, however
heavy the limb is.  A bristle has ``I BRISTLE_RATE^2``.
"""

from __future__ import annotations

from math import isfinite, pi

from urdf2mbs.plugin import Conversion, JointModels, Pass, UserModel, rounded
from urdf2mbs_project.simulation import Simulation

#: The rate (1/s) at which the effective inertia would swing on the bristle.
BRISTLE_RATE = 300.0
#: The time constant T of a bristle (s): it damps by ``T stiffness = 2 D I BRISTLE_RATE``, with the
#: damping ratio D = 0.75.
BRISTLE_TIME = 1.5 / BRISTLE_RATE


class JointLaws(Pass):
    """Add the numbers of the joints' force laws."""

    reads = ("bodies", "inertias", "joints", "couplings", "anchors", "posture")
    writes = ("forces",)

    def run(self, conversion: Conversion) -> None:
        """Add the user models that switch the laws on, and those of stops and bristles."""
        if conversion.settings.project is None:
            return
        joint_models = conversion.state(JointModels)
        values = joint_models.values
        limited = dict.fromkeys((*values.get("q_min", ()), *values.get("q_max", ())))
        friction = values.get("friction", {})
        inertias = _compute_inertias(conversion) if limited or friction else {}
        switches: dict[str, float] = {}
        chosen: dict[str, dict[str, float]] = {}
        if "damping" in values:
            switches["damping"] = 1.0
        if "spring_stiffness" in values:
            switches["springs"] = 1.0
        if friction:
            switches |= {"friction": 1.0, "friction_time": BRISTLE_TIME}
            chosen["friction_stiffness"] = {
                name: rounded((inertias[name] or 1.0) * BRISTLE_RATE**2) for name in friction
            }
        if limited and joint_models.stop_frequency is not None:
            switches |= {"stops": 1.0, "stop_speed": 1.0}
            squared_rate = (2 * pi * joint_models.stop_frequency) ** 2
            chosen["stop_stiffness"] = {
                name: rounded(inertias[name] * squared_rate) for name in limited
            }
        user_models = conversion.mbs.user_models
        if switches:
            # They come before the models that they switch on.
            first = next(n for n, model in enumerate(user_models) if model.name in values)
            user_models.insert(first, UserModel.of("joint_forces", switches))
            conversion.report["joint-parameters"] = {"joint_forces": switches, **values, **chosen}
        user_models += [UserModel.of(name, numbers) for name, numbers in chosen.items()]


def _compute_inertias(conversion: Conversion) -> dict[str, float]:
    """Compute the effective inertia of each joint (kg m^2 or kg); 0 if it does not move."""
    from urdf2mbs_project.mass import MassModel
    from urdf2mbs_project.stability import compute_effective_inertias, compute_reduction

    mass = MassModel(conversion.mbs)
    reduction = compute_reduction(mass, conversion.state(Simulation))
    inertias = compute_effective_inertias(mass, reduction)
    return {
        placed.joint.name: float(inertia) if isfinite(inertia) else 0.0
        for placed, inertia in zip(mass.placement.joints, inertias, strict=True)
    }
