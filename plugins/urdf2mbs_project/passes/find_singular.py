"""Find singular: warn if the mass matrix is singular, and name the joints that make it so.

Beyond the method.  Robotran solves ``M qdd = Q`` at each step, and stops where M is singular.
The test takes the .mbs and the couplings of the project's code, at every position and at the
initial position (see ``urdf2mbs_project.singular``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import msgspec

from urdf2mbs.plugin import Conversion, Pass, Robot, some
from urdf2mbs_project.simulation import Simulation
from urdf2mbs_project.singular import FollowerRule, SingularJoint, find_singular_joints

REVOLUTE_TYPES = ("revolute", "continuous")


class FindSingular(Pass):
    """Warn if the mass matrix is singular."""

    reads = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        """Report the singular joints, and warn of them by their names in the URDF."""
        rules = {
            coupling.follower.name: FollowerRule(
                coupling.leader.name, coupling.multiplier, coupling.offset
            )
            for coupling in conversion.state(Simulation).couplings
        }
        singular_joints = find_singular_joints(conversion.mbs, rules)
        urdf_names = {
            name: joint for joint, names in conversion.names.coordinates.items() for name in names
        }
        conversion.report["singular"] = [
            {**msgspec.to_builtins(singular), "urdf_joint": urdf_names.get(singular.joint)}
            for singular in singular_joints
        ]
        if not any(body.mass or body.inertia for body in conversion.mbs.bodies):
            return  # A robot without any mass has a warning of its own.
        renamed = [_rename(singular, urdf_names) for singular in singular_joints]
        always = [singular for singular in renamed if singular.always]
        always_names = {singular.joint for singular in always}
        at_start = [
            singular
            for singular in renamed
            if not singular.always and singular.joint not in always_names
        ]
        if always:
            _warn_of_singular(conversion, always)
        if at_start:
            _warn_of_singular_start(conversion, at_start)


def _warn_of_singular(conversion: Conversion, singular_joints: list[SingularJoint]) -> None:
    """Warn of joints that are singular at every position."""
    causes = "; ".join(_describe_causes(singular_joints, conversion.robot))
    is_of_base = conversion.base.inserted in [singular.joint for singular in singular_joints]
    hint = "give mass and inertia to the links that they move, or fix the joints"
    if is_of_base:
        hint += "; or 'base: fixed', if the robot stands on the ground"
    message = (
        "the mass matrix is singular at every position, so Robotran cannot solve this model: "
        f"{causes}"
    )
    joint = None if is_of_base else singular_joints[0].joint
    conversion.warn("singular", message, joint=joint, hint=hint)


def _warn_of_singular_start(conversion: Conversion, singular_joints: list[SingularJoint]) -> None:
    """Warn of joints that are singular at the initial position only."""
    causes = "; ".join(_describe_causes(singular_joints, conversion.robot))
    is_of_base = conversion.base.inserted in [singular.joint for singular in singular_joints]
    message = (
        "the mass matrix is singular at its initial position, so Robotran cannot start this "
        f"model: {causes}"
    )
    joint = None if is_of_base else singular_joints[0].joint
    hint = "start from another position"
    conversion.warn("singular-at-start", message, joint=joint, hint=hint)


def _rename(singular: SingularJoint, urdf_names: Mapping[str, str]) -> SingularJoint:
    """Return a singular joint by the names of the URDF's joints, each once."""
    name = urdf_names.get(singular.joint, singular.joint)
    moves_with = dict.fromkeys(urdf_names.get(joint, joint) for joint in singular.moves_with)
    moves_with.pop(name, None)
    why = "no-inertia" if singular.why == "together" and not moves_with else singular.why
    return SingularJoint(name, why, tuple(moves_with), singular.always)


def _describe_causes(singular_joints: list[SingularJoint], robot: Robot) -> list[str]:
    """Describe why joints are singular, a text for each cause."""
    joints_by_cause: dict[str, list[str]] = {}
    for singular in singular_joints:
        names = joints_by_cause.setdefault(_describe_cause(singular, robot), [])
        if singular.joint not in names:
            names.append(singular.joint)
    texts = []
    for cause, names in joints_by_cause.items():
        if len(names) == 1:
            texts.append(f"joint '{names[0]}' {cause}")
        else:
            texts.append(f"each of the {len(names)} joints {_quote(names)} {cause}")
    return texts


def _describe_cause(singular: SingularJoint, robot: Robot) -> str:
    """Describe why a joint is singular."""
    if singular.moves_with:
        joints = _quote(singular.moves_with)
        return f"can move together with {joints} so that nothing that has mass moves"
    if singular.why == "moves-nothing":
        return "moves nothing that has mass"
    if singular.joint in robot.joints and robot.joints[singular.joint].type in REVOLUTE_TYPES:
        return "turns about an axis about which nothing has inertia"
    return "moves in a direction in which nothing has inertia"


def _quote(names: Iterable[str]) -> str:
    """Return names in quotes, some of many."""
    return some(f"'{name}'" for name in names)
