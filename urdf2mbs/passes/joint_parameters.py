"""Joint parameters: limits, damping, friction, springs and the like, as user models of the .mbs.

Beyond the method: an .mbs has no such properties of joints, but it has user models, which can be
edited in MBSysPad and read by user functions.  Each kind of property is one user model; its
parameters are scalars with the names of the joints.

A project applies them: the pass ``joint-laws`` adds what its code needs.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import Annotated, Literal

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import UserModel
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.states import JointModels, Placed
from urdf2mbs.urdf.model import RATES, Dynamics, Joint, Limit, SafetyController

#: The user models, in the order in which they are written.
KINDS = (
    "q_min",
    "q_max",
    "effort",
    *RATES,
    "damping",
    "friction",
    "spring_stiffness",
    "spring_reference",
    "soft_q_min",
    "soft_q_max",
    "k_position",
    "k_velocity",
    "calibration_rising",
    "calibration_falling",
)
#: The kinds that only a project applies.
DYNAMICS = ("damping", "friction", "spring_stiffness")

#: The value of each kind of property that a joint has; None if an attribute is missing.
Properties = Iterator[tuple[str, float | None]]


class JointParameters(Pass):
    """Write limits, damping, friction and other properties of joints as user models."""

    reads = ("robot", "bodies", "joints")
    writes = ("forces",)

    stops: bool = True
    """Give joints soft stops at their limits, in a project."""
    stop_frequency: Annotated[float, msgspec.Meta(gt=0.0, le=1e3)] = 20.0
    """Stiffness of the stops, as the frequency (Hz) at which the moved inertia would oscillate on
    the stop."""
    zero_limits: Literal["free", "locked"] = "free"
    """What limits mean of which lower and upper are equal, as 0 and 0, or both missing: ``free``, a
    joint without limits, as many files mean it; ``locked``, a joint that stays there, as URDF
    defines it."""

    def run(self, conversion: Conversion) -> None:
        """Write a user model for each kind of property that a joint has."""
        models = _collect_values(conversion, is_zero_locked=self.zero_limits == "locked")
        joint_models = conversion.state(JointModels)
        joint_models.values = models
        joint_models.stop_frequency = self.stop_frequency if self.stops else None
        conversion.mbs.user_models += [UserModel.of(*model) for model in models.items()]
        if models:
            conversion.report["joint-parameters"] = models
        _mark_as_placed(conversion)
        if conversion.settings.project is None:
            _note_unapplied_dynamics(conversion, models)


def _collect_values(conversion: Conversion, *, is_zero_locked: bool) -> dict[str, dict[str, float]]:
    """Collect the finite values of each kind of property, by .mbs joint.

    Args:
        conversion: The robot as a URDF and as an .mbs.
        is_zero_locked: True if equal limits lock a joint.
    """
    values: dict[str, dict[str, float]] = {kind: {} for kind in KINDS}
    for step, mbs_joint in conversion.single_coordinates():
        for kind, value in _list_properties(step.joint, is_zero_locked=is_zero_locked):
            if value is not None and isfinite(value):
                values[kind][mbs_joint.name] = float(value)
    return {kind: by_joint for kind, by_joint in values.items() if by_joint}


def _list_properties(joint: Joint, *, is_zero_locked: bool) -> Properties:
    """List the properties of a URDF joint, by kind."""
    if joint.limit is not None:
        if joint.type != "continuous":
            yield from _list_limits(joint.limit, is_zero_locked=is_zero_locked)
        for kind in ("effort", *RATES):
            yield kind, getattr(joint.limit, kind)
    if joint.dynamics is not None:
        yield from _list_dynamics(joint.dynamics)
    if joint.safety_controller is not None:
        yield from _list_safety(joint.safety_controller)
    if joint.calibration is not None:
        yield "calibration_rising", joint.calibration.rising
        yield "calibration_falling", joint.calibration.falling


def _list_limits(limit: Limit, *, is_zero_locked: bool) -> Properties:
    """List lower and upper limit, unless they leave no room and that means no limits."""
    lower, upper = limit.lower, limit.upper
    has_room = lower is None or upper is None or lower < upper
    if has_room or (is_zero_locked and limit.is_single):
        yield "q_min", lower
        yield "q_max", upper


def _list_dynamics(dynamics: Dynamics) -> Properties:
    """List damping, friction and spring, without those that are zero."""
    yield "damping", dynamics.damping or None
    yield "friction", dynamics.friction or None
    if dynamics.spring_stiffness:
        yield "spring_stiffness", dynamics.spring_stiffness
        yield "spring_reference", dynamics.spring_reference


def _list_safety(safety: SafetyController) -> Properties:
    """List the soft limits, unless they leave no room, and the gains."""
    if safety.soft_lower_limit < safety.soft_upper_limit:
        yield "soft_q_min", safety.soft_lower_limit
        yield "soft_q_max", safety.soft_upper_limit
    yield "k_position", safety.k_position
    yield "k_velocity", safety.k_velocity


def _mark_as_placed(conversion: Conversion) -> None:
    """Record the properties that user models hold, so that ``left-out`` does not name them."""
    placed = conversion.state(Placed)
    joints = [step.joint for step, _ in conversion.single_coordinates()]
    for joint in joints:
        for code, element in (
            ("limit", joint.limit),
            ("joint-dynamics", joint.dynamics),
            ("safety-controller", joint.safety_controller),
            ("calibration", joint.calibration),
        ):
            if element is not None:
                placed.joints.setdefault(code, set()).add(joint.name)
    names = {joint.name for joint in joints}
    placed.elements += [
        extension
        for extension in conversion.robot.extensions
        if "springStiffness" in extension.numbers and extension.reference in names
    ]


def _note_unapplied_dynamics(conversion: Conversion, models: dict[str, dict[str, float]]) -> None:
    """Note damping, friction and springs that only a project would apply."""
    names = {name for kind in DYNAMICS for name in models.get(kind, ())}
    if names:
        has_springs = "spring_stiffness" in models
        kinds = "damping, friction and springs" if has_springs else "damping and friction"
        conversion.note(
            "joint-dynamics",
            f"{kinds} of {counted(len(names), 'joint')} are in user models, but nothing applies "
            "them; a project does: 'output: {project: DIR}'",
        )
