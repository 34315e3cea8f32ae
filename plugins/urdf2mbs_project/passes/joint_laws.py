"""Joint laws: the numbers by which the code of a project applies what ``joint-parameters`` wrote.

Beyond the method.  A project applies damping, friction, springs and soft stops;
``docs/passes/joint-laws.md`` has their laws.  The pass chooses the stiffness of a stop and
of a bristle of friction from the inertia ``I`` that the joint feels at the start position, while
all other joints are free.  A stop has ``I (2 pi stop_frequency)^2``: a limb of length l sinks in
under its own weight by about ``g / (l (2 pi stop_frequency)^2)``, however heavy the limb is.  A
bristle has ``I FASTEST^2``.
"""

from __future__ import annotations

from math import isfinite, pi

from urdf2mbs.plugin import Conversion, JointModels, Pass, UserModel, rounded
from urdf2mbs_project.simulation import Simulation

#: The moved inertia would swing on the bristle at this rate (1/s).
FASTEST = 300.0
#: ``T`` of a bristle (s): it damps by 2 D I FASTEST, with D = 0.75.
TIME = 1.5 / FASTEST


class JointLaws(Pass):
    reads = ("bodies", "inertias", "joints", "couplings", "anchors", "posture")
    writes = ("forces",)

    def run(self, conversion: Conversion) -> None:
        if conversion.settings.project is None:
            return
        written = conversion.state(JointModels)
        models = written.values
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
        if limited and written.stop_frequency is not None:
            switches |= {"stops": 1.0, "stop_speed": 1.0}
            stiff = (2 * pi * written.stop_frequency) ** 2
            chosen["stop_stiffness"] = {name: rounded(inertias[name] * stiff) for name in limited}
        user_models = conversion.mbs.user_models
        if switches:
            # before the models that it switches
            at = next(n for n, model in enumerate(user_models) if model.name in models)
            user_models.insert(at, UserModel.of("joint_forces", switches))
            conversion.report["joint-parameters"] = {"joint_forces": switches, **models, **chosen}
        user_models += [UserModel.of(*model) for model in chosen.items()]


def _inertias(conversion: Conversion) -> dict[str, float]:
    """The inertia that each joint feels in a project (kg m^2, kg)."""
    from urdf2mbs_project.mass import Mass
    from urdf2mbs_project.stability import felt, reduction_of

    mass = Mass(conversion.mbs)
    inertias = felt(mass, reduction_of(mass, conversion.state(Simulation)))
    return {
        placed.joint.name: float(inertia) if isfinite(inertia) else 0.0
        for placed, inertia in zip(mass.placement.joints, inertias, strict=True)
    }
