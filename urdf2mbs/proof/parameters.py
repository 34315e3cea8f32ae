"""Compare the numbers beside the mechanism: user models, forces, and the start."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import isfinite

import msgspec

from urdf2mbs.mbs.model import Mbs, UserModel
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.proof.match import Match
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.urdf.model import RATES, Joint, Robot

#: The user models that have numbers of the URDF, by the names of the .mbs joints.
PARAMETERS = (
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
#: Why elements of the .mbs are not compared.
USER_CODE = "left to the user functions"


class ParameterComparison(msgspec.Struct):
    """The differences between the numbers of a URDF and those of an .mbs."""

    differences: list[Difference] = []
    but_for: dict[str, str] = {}
    """Numbers that only the URDF has."""
    not_compared: dict[str, str] = {}
    """Elements that Robotran reads and a URDF cannot state, each with the reason."""


def compare_parameters(
    robot: Robot, mbs: Mbs, match: Match, expected_models: Sequence[UserModel] | None
) -> ParameterComparison:
    """Compare the numbers of the URDF's joints with the user models of an .mbs.

    Args:
        robot: The robot of the URDF.
        mbs: The model.
        match: Which joints of the .mbs are those of the URDF.
        expected_models: The user models that the passes made, which must be in the .mbs unchanged;
            None if they are not known.
    """
    comparison = ParameterComparison()
    mbs_texts = read_user_models(mbs)
    missing: Counter[str] = Counter()
    for joint in robot.joints.values():
        names = match.joints.get(joint.name, ())
        if joint.moves and joint.name not in match.locked and len(names) == 1:
            texts = {kind: texts.get(names[0]) for kind, texts in mbs_texts.items()}
            differences, missing_kinds = _compare_joint(joint, texts)
            comparison.differences += differences
            missing.update(missing_kinds)
    for kind in PARAMETERS:
        if kind in missing:
            numbers = f"{kind} of {counted(missing[kind], 'joint')}"
            comparison.but_for[numbers] = "only in the URDF"
    expected_models = expected_models or ()
    unchanged_models = {model.name for model in expected_models if model in mbs.user_models}
    for model in expected_models:
        if model.name not in unchanged_models:
            message = f"user model '{model.name}' differs from the one that the passes made"
            comparison.differences.append(Difference("parameter", message))
    followers = {
        name
        for joint in robot.joints.values()
        if joint.mimic
        for name in match.joints.get(joint.name, ())
    }
    compared_models = {*PARAMETERS, *unchanged_models}
    comparison.not_compared = _list_user_code(mbs, compared_models, followers)
    return comparison


def read_user_models(mbs: Mbs) -> dict[str, dict[str, str]]:
    """Read the scalar parameters of the user models: model, parameter, text of the value."""
    texts: dict[str, dict[str, str]] = {}
    for model in mbs.user_models:
        parameters = texts.setdefault(model.name, {})
        parameters.update({p.name: p.values[0] for p in model.parameters if len(p.values) == 1})
    return texts


def _compare_joint(
    joint: Joint, mbs_texts: Mapping[str, str | None]
) -> tuple[list[Difference], list[str]]:
    """Compare the numbers of a URDF joint with those of the .mbs.

    Args:
        joint: The joint.
        mbs_texts: Its numbers in the .mbs, by the names of user models.

    Returns:
        The differences, and the kinds of numbers that only the URDF has.
    """
    differences: list[Difference] = []
    missing_kinds: list[str] = []
    numbers = list_joint_parameters(joint)
    # A URDF's limits from 0 to 0 may mean that there are no limits.
    may_be_unlimited = joint.limit is not None and joint.limit.is_single
    for kind in PARAMETERS:
        number, text = numbers.get(kind), mbs_texts.get(kind)
        if text is None:
            if number is not None and not (kind in ("q_min", "q_max") and may_be_unlimited):
                missing_kinds.append(kind)
        elif number is None or _parse_number(text) != number:
            expected = "the URDF has none" if number is None else f"expected {number:.9g}"
            message = f"joint '{joint.name}': {kind} is {text}; {expected}"
            differences.append(
                Difference(
                    "parameter", message, link=joint.child, joint=joint.name, urdf=number, mbs=text
                )
            )
    return differences, missing_kinds


def list_joint_parameters(joint: Joint) -> dict[str, float]:
    """List the numbers of a URDF joint, by the names of their user models.

    Without limits of which the lower one is above the upper one, and without damping or friction
    of zero.
    """
    numbers: dict[str, float | None] = {}
    limit, safety = joint.limit, joint.safety_controller
    if limit is not None:
        for kind in ("effort", *RATES):
            numbers[kind] = getattr(limit, kind)
        has_range = limit.lower is None or limit.upper is None or limit.lower < limit.upper
        if joint.type != "continuous" and (has_range or limit.is_single):
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


def _parse_number(text: str) -> float | None:
    """Parse a number; None if the text is not one."""
    try:
        return float(text)
    except ValueError:
        return None


def _list_user_code(
    mbs: Mbs, compared_models: Collection[str], followers: set[str]
) -> dict[str, str]:
    """List the elements that Robotran reads and a URDF cannot state, each with the reason.

    Args:
        mbs: The model.
        compared_models: Names of the user models that are compared.
        followers: The joints that follow others in the URDF; their constraints are known.
    """
    reasons = dict.fromkeys(_name_user_elements(mbs, compared_models), USER_CODE)
    for constraint in mbs.user_constraints:
        if followers.isdisjoint(constraint.joints):
            name = f"user constraint '{constraint.name}'"
            reasons[name] = "held by the user functions (user_cons_hJ)"
    reasons |= dict.fromkeys((f"link '{link.name}' ({link.kind})" for link in mbs.links), USER_CODE)
    for body in mbs.bodies:
        for point in body.points:
            if point.extforce:
                reasons[f"force '{point.extforce.name}'"] = USER_CODE
    free_joints = [joint for joint in mbs.joints().values() if joint.nature != "driven"]
    started = sum(any((joint.q, joint.qd, joint.qdd)) for joint in free_joints)
    if started:
        reasons[f"start of {counted(started, 'joint')}"] = "a URDF has none"
    return reasons


def _name_user_elements(mbs: Mbs, compared_models: Collection[str]) -> Iterator[str]:
    """Name the user models that are not compared, and the user variables."""
    for model in mbs.user_models:
        if model.name not in compared_models:
            yield f"user model '{model.name}'"
    for variable in mbs.user_variables:
        yield f"user variable '{variable.name}'"
