"""The content of an .mbs beside the mechanism: user models, forces, and the start."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from math import isfinite

from urdf2mbs.mbs.model import Mbs, UserModel
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.urdf.model import RATES, Joint, Robot

#: The user models that hold a URDF's numbers, by the names of the .mbs joints.
STATED = (
    "damping",
    "friction",
    "spring_stiffness",
    "spring_reference",
    "q_min",
    "q_max",
    "effort",
    *RATES,
    "soft_q_min",
    "soft_q_max",
    "k_position",
    "k_velocity",
    "calibration_rising",
    "calibration_falling",
)


def compare_parameters(
    robot: Robot, mbs: Mbs, joints: Mapping[str, Sequence[str]], frozen: Collection[str],
    models: Sequence[UserModel] | None,
) -> tuple[list[Difference], dict[str, str], dict[str, str]]:  # fmt: skip
    """Compare the numbers of the URDF's joints (limits, damping, springs, controllers) with the
    user models; gives the differences, what only the URDF has, and what is not compared.

    ``models``: the user models as the passes made them, each of which must be in the file as it
    is; None where nobody knows.
    """
    differences: list[Difference] = []
    there: dict[str, dict[str, str]] = {}
    for model in mbs.user_models:
        values = there.setdefault(model.name, {})
        values.update({p.name: p.values[0] for p in model.parameters if len(p.values) == 1})
    missing: dict[str, int] = {}
    for joint in robot.joints.values():
        names = joints.get(joint.name, ())
        if not joint.moves or joint.name in frozen or len(names) != 1:
            continue
        numbers = stated(joint)
        for kind in STATED:
            text, value = there.get(kind, {}).get(names[0]), numbers.get(kind)
            if text is None:
                # A URDF's limits from 0 to 0 may mean that there are none.
                may_be_none = joint.limit is not None and joint.limit.is_single
                if value is not None and not (kind in ("q_min", "q_max") and may_be_none):
                    missing[kind] = missing.get(kind, 0) + 1
            elif value is None or _number(text) != value:
                should = "the URDF has none" if value is None else f"should be {value:.9g}"
                differences.append(
                    Difference(
                        "parameter", f"joint '{joint.name}': {kind} is {text}, and {should}",
                        link=joint.child, joint=joint.name, urdf=value, mbs=text,
                    )
                )  # fmt: skip
    but_for = {
        f"{kind} of {counted(missing[kind], 'joint')}": "only in the URDF"
        for kind in STATED
        if kind in missing
    }
    known = [model.name for model in models or () if model in mbs.user_models]
    for model in models or ():
        if model.name not in known:
            said = f"user model '{model.name}' is not in the file as the passes made it"
            differences.append(Difference("parameter", said))
    followers = {name for j in robot.joints.values() if j.mimic for name in joints.get(j.name, ())}
    return differences, but_for, left_out(mbs, [*STATED, *known], followers)


def left_out(mbs: Mbs, known: Collection[str], followers: set[str]) -> dict[str, str]:
    """The things that Robotran reads and a URDF has no word for, each with the reason."""
    free = [joint for joint in mbs.joints().values() if joint.nature != "driven"]
    start = sum(any((joint.q, joint.qd, joint.qdd)) for joint in free)
    forces = [point.extforce for body in mbs.bodies for point in body.points if point.extforce]
    theirs = "left to the user functions"
    return {
        **{f"user model '{m.name}'": theirs for m in mbs.user_models if m.name not in known},
        **{f"user variable '{v.name}'": theirs for v in mbs.user_variables},
        **{
            f"user constraint '{c.name}'": "held by the user functions (user_cons_hJ)"
            for c in mbs.user_constraints
            if followers.isdisjoint(c.joints)
        },
        **{f"link '{link.name}' ({link.kind})": theirs for link in mbs.links},
        **{f"force '{force.name}'": theirs for force in forces},
        **({f"start of {counted(start, 'joint')}": "a URDF has none"} if start else {}),
    }


def stated(joint: Joint) -> dict[str, float]:
    """Return the numbers of a URDF joint, by kind.

    Limits of which the lower is above the upper are left out, and damping or friction of zero.
    """
    numbers: dict[str, float | None] = {}
    limit, safety = joint.limit, joint.safety_controller
    if limit is not None:
        for kind in ("effort", *RATES):
            numbers[kind] = getattr(limit, kind)
        has_room = limit.lower is None or limit.upper is None or limit.lower < limit.upper
        if joint.type != "continuous" and (has_room or limit.is_single):
            numbers |= {"q_min": limit.lower, "q_max": limit.upper}
    if joint.dynamics is not None:
        numbers["damping"] = joint.dynamics.damping or None
        numbers["friction"] = joint.dynamics.friction or None
        if joint.dynamics.spring_stiffness:
            numbers["spring_stiffness"] = joint.dynamics.spring_stiffness
            numbers["spring_reference"] = joint.dynamics.spring_reference
    if safety is not None:
        numbers |= {"k_position": safety.k_position, "k_velocity": safety.k_velocity}
        if safety.soft_lower_limit < safety.soft_upper_limit:
            numbers["soft_q_min"] = safety.soft_lower_limit
            numbers["soft_q_max"] = safety.soft_upper_limit
    if joint.calibration is not None:
        numbers["calibration_rising"] = joint.calibration.rising
        numbers["calibration_falling"] = joint.calibration.falling
    return {kind: float(v) for kind, v in numbers.items() if v is not None and isfinite(v)}


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
