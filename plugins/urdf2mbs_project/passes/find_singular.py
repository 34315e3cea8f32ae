"""Find singular: say if the mass matrix is singular, and which joints are the cause.

Beyond the method.  Robotran solves ``M qdd = Q`` at each step, and stops where M is singular.
The test takes the .mbs and the couplings of the project's code, at every position and at the
initial position (see ``urdf2mbs_project.singular``).
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from urdf2mbs.plugin import Conversion, Pass, Robot, some
from urdf2mbs_project.simulation import Simulation
from urdf2mbs_project.singular import Rule, Singular, find_singular

TURNING = ("revolute", "continuous")


class FindSingular(Pass):
    reads = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        rules = {
            coupling.follower.name: Rule(coupling.leader.name, coupling.multiplier, coupling.offset)
            for coupling in conversion.state(Simulation).couplings
        }
        singular = find_singular(conversion.mbs, rules)
        owner = {
            name: joint for joint, names in conversion.names.coordinates.items() for name in names
        }
        conversion.report["singular"] = [
            {**msgspec.to_builtins(found), "urdf_joint": owner.get(found.joint)}
            for found in singular
        ]
        if not any(body.mass or body.inertia for body in conversion.mbs.bodies):
            return  # a robot without any mass has another warning
        named = [_in_urdf(one, owner) for one in singular]
        known = {one.joint for one in named if one.always}
        for code, always in (("singular", True), ("singular-at-start", False)):
            listed = [one for one in named if one.always == always]
            listed = listed if always else [one for one in listed if one.joint not in known]
            if listed:
                causes = "; ".join(_causes(listed, conversion.robot))
                floats = conversion.base.inserted in [one.joint for one in listed]
                where = "at every position" if always else "at its initial position"
                conversion.warn(
                    code,
                    f"the mass matrix is singular {where}, so Robotran cannot "
                    f"{'solve' if always else 'start'} this model: {causes}",
                    joint=None if floats else listed[0].joint,
                    hint="start from another position" if not always
                    else "give mass and inertia to the links that they move, or fix the joints"
                    + ("; or 'base: fixed', if the robot stands on the ground" if floats else ""),
                )  # fmt: skip


def _in_urdf(found: Singular, owner: dict[str, str]) -> Singular:
    """The same by the names of the URDF's joints, each once."""
    name = owner.get(found.joint, found.joint)
    others = dict.fromkeys(owner.get(other, other) for other in found.others)
    others.pop(name, None)
    why = "no-inertia" if found.why == "together" and not others else found.why
    return Singular(name, why, tuple(others), found.always)


def _causes(listed: list[Singular], robot: Robot) -> list[str]:
    causes: dict[str, list[str]] = {}
    for found in listed:
        if found.others:
            cause = (
                f"can move together with {_quote(found.others)} so that nothing that has mass moves"
            )
        elif found.why == "moves-nothing":
            cause = "moves nothing that has mass"
        elif found.joint in robot.joints and robot.joints[found.joint].type in TURNING:
            cause = "turns about an axis about which nothing has inertia"
        else:
            cause = "moves in a direction in which nothing has inertia"
        names = causes.setdefault(cause, [])
        if found.joint not in names:
            names.append(found.joint)
    return [
        f"joint '{names[0]}' {cause}" if len(names) == 1
        else f"each of the {len(names)} joints {_quote(names)} {cause}"
        for cause, names in causes.items()
    ]  # fmt: skip


def _quote(names: Iterable[str]) -> str:
    return some(f"'{name}'" for name in names)
