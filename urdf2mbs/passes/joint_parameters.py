"""Joint parameters: limits, damping, friction, springs and the like, as user models of the .mbs.

Beyond the method: an .mbs has no such properties of joints, but it has user models, which can be
edited in MBSysPad and read by user functions.  Each kind of property is one user model; its
parameters are scalars, called as the joints are.

In a Robotran project the generated joint forces apply damping, Coulomb friction, springs and soft
stops at the limits.  The pass chooses two numbers for each joint from the inertia ``I`` that the
joint moves at the start position, with all joints further out locked:

* a stop is a spring of stiffness ``I (2 pi f)^2``: a limb of length l sinks into the stop under its
  own weight by about ``g / (l (2 pi f)^2)``, however heavy the limb is;
* friction is a bristle that bends by z and slips where it would pull with more than F, the URDF's
  friction: it pulls with ``k (z + T qd)``, at most F, and ``dz/dt = qd - (|z| - F / k) sgn(z) / T``
  where ``|z| > F / k``, else ``qd``.  So friction is F in motion, and a joint that is pulled by
  less comes to rest.  ``k = I (FASTEST)^2``, and T damps the bristle: a slider of Coulomb, of
  Perzyna's viscoplastic kind, in series with a spring and a damper.

Without bristles, and in a plain .mbs, friction rises as ``tanh(qd / speed)``: ``speed`` is large
enough that the slope at rest, ``friction / speed``, does not ask for a very short time step.
"""

from __future__ import annotations

from collections.abc import Container
from math import isfinite, pi
from typing import Annotated

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs import model as mbs
from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.model import UserModel
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.ranges import Speed
from urdf2mbs.simulation import rounded
from urdf2mbs.spatial import (
    NO_INERTIA,
    ZERO,
    Sym,
    Vec,
    add,
    cross,
    dot,
    lump,
    rotate,
    rotate_inertia,
)
from urdf2mbs.urdf.model import Joint

#: The slope of friction at rest is at most this times the inertia, and a bristle swings as fast
#: (1/s).
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
    bristles: bool = True
    """Friction in a project has a state, and lets a joint rest; else it is a law of the speed."""
    friction_speed: Speed = 0.01
    """Without bristles: friction is nearly constant above this speed (rad/s or m/s); a joint
    that moves little inertia has a higher speed."""

    def run(self, conversion: Conversion) -> None:
        joints = conversion.robot.joints
        held = {
            step.joint.name: (joints.get(step.joint.name, step.joint), joint)
            for step, joint in conversion.single_coordinates()
        }
        kinds = _kinds(conversion, list(held.values()))
        models = {kind: values for kind, values in kinds.items() if values}
        switches: dict[str, float] = {}
        wanted = {*kinds["q_min"], *kinds["q_max"], *kinds["friction"]}
        inertias = _inertias(conversion, wanted) if wanted else {}
        stiff = (2 * pi * self.stop_frequency) ** 2
        if "damping" in models:
            switches["damping"] = 1.0
        if "spring_stiffness" in models:
            switches["springs"] = 1.0
        if "friction" in models:
            switches["friction"] = 1.0
            if self.bristles and conversion.settings.project is not None:
                switches["friction_time"] = TIME
                models["friction_stiffness"] = {
                    name: rounded((inertias[name] or 1.0) * FASTEST**2)
                    for name in models["friction"]
                }
            else:
                models["friction_speed"] = {
                    name: rounded(max(self.friction_speed, value / (FASTEST * inertias[name])))
                    if inertias[name] > 0.0
                    else self.friction_speed
                    for name, value in models["friction"].items()
                }
        stopped = dict.fromkeys((*kinds["q_min"], *kinds["q_max"]))
        if stopped and self.stops:
            switches |= {"stops": 1.0, "stop_speed": 1.0}
            models["stop_stiffness"] = {name: rounded(inertias[name] * stiff) for name in stopped}
        if switches:
            models = {"joint_forces": switches, **models}
        conversion.mbs.user_models += [UserModel.of(*model) for model in models.items()]
        if models:
            conversion.facts["joint-parameters"] = models
        names = {name for kind in DYNAMICS for name in models.get(kind, ())}
        conversion.simulation.used += [
            extension
            for extension in conversion.robot.extensions
            if "springStiffness" in extension.numbers and extension.reference in held
        ]
        if conversion.settings.project is None and names:
            springs = "springs" in switches
            conversion.note(
                "joint-dynamics",
                f"{'damping, friction and springs' if springs else 'damping and friction'} of "
                f"{counted(len(names), 'joint')} are in user models, but "
                "nothing applies them; a project does: 'output: {project: DIR}'",
            )


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


def _inertias(conversion: Conversion, wanted: Container[str]) -> dict[str, float]:
    """The inertia that each joint feels in a project; without a project, the inertia it moves."""
    if conversion.settings.project is None:
        return moved_inertias(conversion.mbs, wanted)
    from urdf2mbs.mbs.mass import Mass
    from urdf2mbs.project.stability import felt, reduction_of

    mass = Mass(conversion.mbs)
    inertias = felt(mass, reduction_of(mass, conversion.simulation))
    return {
        placed.joint.name: float(inertia) if isfinite(inertia) else 0.0
        for placed, inertia in zip(mass.placement.joints, inertias, strict=True)
        if placed.joint.name in wanted
    }


def moved_inertias(model: mbs.Mbs, wanted: Container[str]) -> dict[str, float]:
    """The inertia that each joint of these names moves at the initial position, with all joints
    behind it locked: kg m^2 about its axis for a turn, kg for a shift."""
    placement = place(model)
    #: Mass, centre and inertia about it, in the base, of all that hangs on each body.
    behind: dict[str | None, list[tuple[float, Vec, Sym]]] = {}
    values: dict[str, float] = {}
    end = len(placement.joints)
    for body in reversed(model.bodies):
        parts = behind.pop(body.name, [])
        if body.mass:
            pose = placement.bodies[body.name]
            centre = add(pose.xyz, rotate(pose.rot, body.com or ZERO))
            tensor = rotate_inertia(pose.rot, body.inertia or NO_INERTIA)
            parts.insert(0, (body.mass, centre, tensor))
        mass, centre, tensor = lump(parts)
        if mass:
            behind.setdefault(body.parent, []).append((mass, centre, tensor))
        first = end - len(body.joints)
        for joint, axis, origin, _ in placement.joints[first:end]:
            if joint.name not in wanted:
                continue
            values[joint.name] = mass
            if joint.type[0] == "R":
                x, y, z = axis
                xx, xy, xz, yy, yz, zz = tensor
                products = xy * x * y + xz * x * z + yz * y * z
                about = xx * x * x + yy * y * y + zz * z * z + 2 * products
                arm = (centre[0] - origin[0], centre[1] - origin[1], centre[2] - origin[2])
                arm = cross(axis, arm)
                values[joint.name] = about + mass * dot(arm, arm)
        end = first
    return values
