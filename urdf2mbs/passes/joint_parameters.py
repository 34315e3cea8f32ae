"""Joint parameters: limits, damping, friction, springs and the like, as user models of the .mbs.

Beyond the method: an .mbs has no such properties of joints, but it has user models, which can be
edited in MBSysPad and read by user functions.  Each kind of property is one user model; its
parameters are scalars, called as the joints are.

A project applies them: the pass ``joint-laws`` adds what its code needs.
"""

from __future__ import annotations

from math import isfinite
from typing import Annotated, Literal

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs import model as mbs
from urdf2mbs.mbs.model import UserModel
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.states import JointModels, Placed
from urdf2mbs.urdf.model import RATES, Joint

#: The kinds that only a project applies.
DYNAMICS = ("damping", "friction", "spring_stiffness")


class JointParameters(Pass):
    reads = ("robot", "bodies", "joints")
    writes = ("forces",)

    stops: bool = True
    """Give joints soft stops at their limits, in a project."""
    stop_frequency: Annotated[float, msgspec.Meta(gt=0.0, le=1e3)] = 20.0
    """Stiffness of the stops, as a frequency (Hz): the moved inertia would swing on the stop so
    fast."""
    zero_limits: Literal["free", "locked"] = "free"
    """What limits mean of which lower and upper are equal, as 0 and 0, or both missing: ``free``, a
    joint without limits, as many files mean it; ``locked``, a joint that stays there, as URDF
    defines it."""

    def run(self, conversion: Conversion) -> None:
        held = [(step.joint, joint) for step, joint in conversion.single_coordinates()]
        kinds = _kinds(conversion, held, locked=self.zero_limits == "locked")
        models = {kind: values for kind, values in kinds.items() if values}
        written = conversion.state(JointModels)
        written.values = models
        written.stop_frequency = self.stop_frequency if self.stops else None
        conversion.mbs.user_models += [UserModel.of(*model) for model in models.items()]
        if models:
            conversion.report["joint-parameters"] = models
        names = {name for kind in DYNAMICS for name in models.get(kind, ())}
        sprung = {joint.name for joint, _ in held}
        conversion.state(Placed).elements += [
            extension
            for extension in conversion.robot.extensions
            if "springStiffness" in extension.numbers and extension.reference in sprung
        ]
        if names and conversion.settings.project is None:
            springs = "spring_stiffness" in models
            conversion.note(
                "joint-dynamics",
                f"{'damping, friction and springs' if springs else 'damping and friction'} of "
                f"{counted(len(names), 'joint')} are in user models, but "
                "nothing applies them; a project does: 'output: {project: DIR}'",
            )


def _kinds(
    conversion: Conversion, joints: list[tuple[Joint, mbs.Joint]], *, locked: bool
) -> dict[str, dict[str, float]]:
    """Return the values of each kind of property, by .mbs joint.

    The pass ``left-out`` does not name these properties.

    Args:
        conversion: The robot as a URDF and as an .mbs.
        joints: The joints of the URDF with one coordinate, and those of the .mbs.
        locked: True if limits from 0 to 0 are limits.
    """
    kinds: dict[str, dict[str, float]] = {
        kind: {}
        for kind in (
            "q_min", "q_max", "effort", *RATES, "damping", "friction", "spring_stiffness",
            "spring_reference", "soft_q_min", "soft_q_max", "k_position", "k_velocity",
            "calibration_rising", "calibration_falling",
        )
    }  # fmt: skip
    placed = conversion.state(Placed).joints
    for joint, own in joints:
        limit, dynamics, calibration = joint.limit, joint.dynamics, joint.calibration
        safety = joint.safety_controller
        for code, part in (
            ("limit", limit), ("joint-dynamics", dynamics), ("safety-controller", safety),
            ("calibration", calibration),
        ):  # fmt: skip
            if part is not None:
                placed.setdefault(code, set()).add(joint.name)
        values: dict[str, float | None] = {}
        if limit is not None:
            low, high = limit.lower, limit.upper
            has_room = low is None or high is None or low < high or (locked and limit.is_single)
            if joint.type != "continuous" and has_room:
                values |= {"q_min": low, "q_max": high}
            values |= {kind: getattr(limit, kind) for kind in ("effort", *RATES)}
        if dynamics is not None:
            values |= {"damping": dynamics.damping or None, "friction": dynamics.friction or None}
            if stiffness := dynamics.spring_stiffness:
                values |= {"spring_stiffness": stiffness}
                values |= {"spring_reference": dynamics.spring_reference}
        if safety is not None:
            low, high = safety.soft_lower_limit, safety.soft_upper_limit
            if low < high:
                values |= {"soft_q_min": low, "soft_q_max": high}
            values |= {"k_position": safety.k_position, "k_velocity": safety.k_velocity}
        if calibration is not None:
            values["calibration_rising"] = calibration.rising
            values["calibration_falling"] = calibration.falling
        for kind, value in values.items():
            if value is not None and isfinite(value):
                kinds[kind][own.name] = float(value)
    return kinds
