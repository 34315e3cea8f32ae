"""Find singular: say if the mass matrix is singular, and which joints make it so.

Beyond the method.  Robotran solves ``M qdd = Q`` at each step, and stops where M is singular.
The test takes the .mbs as it is, with the couplings of the project's code, at every position and
at the initial one; it is exact (see ``urdf2mbs.mbs.singular``).
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.singular import Rule, Singular, find_singular
from urdf2mbs.urdf.model import Robot

#: So many joints are named in a message; the report has all.
SHOWN = 5
TURNING = ("revolute", "continuous")


class FindSingular(Pass):
    reads = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        rules = {
            coupling.follower.name: Rule(coupling.leader.name, coupling.multiplier, coupling.offset)
            for coupling in conversion.simulation.couplings
        }
        singular = find_singular(conversion.mbs, rules)
        if not singular:
            conversion.facts["singular"] = []
            return
        owner = {
            name: joint for joint, names in conversion.names.coordinates.items() for name in names
        }
        conversion.facts["singular"] = [
            {**msgspec.to_builtins(one), "urdf_joint": owner.get(one.joint)} for one in singular
        ]
        if not any(body.mass or body.inertia for body in conversion.mbs.bodies):
            return  # a robot without any mass has another warning
        for code, nearly, always, where in (
            ("singular", False, True, "at every position"),
            ("singular", True, True, "at every position"),
            ("singular-at-start", False, False, "at its initial position"),
            ("singular-at-start", True, False, "at its initial position"),
        ):
            told = [
                _in_urdf(one, owner)
                for one in singular
                if one.always == always and one.nearly == nearly
            ]
            if told:
                causes = "; ".join(_causes(told, conversion.robot))
                floats = conversion.inserted in [one.joint for one in told]
                conversion.warn(
                    code,
                    f"the mass matrix is {'all but ' if nearly else ''}singular {where}, so "
                    f"Robotran cannot {'solve' if always else 'start'} this model: {causes}",
                    joint=None if floats else told[0].joint,
                    hint="if the robot stands on the ground: 'base: fixed'" if floats and always
                    else "give what they move mass and inertia, or make them fixed joints" if always
                    else "start from another position",
                )  # fmt: skip


def _in_urdf(one: Singular, owner: dict[str, str]) -> Singular:
    """The same by the names of the URDF's joints, each once."""
    name = owner.get(one.joint, one.joint)
    others = dict.fromkeys(owner.get(other, other) for other in one.others)
    others.pop(name, None)
    why = "no-inertia" if one.why == "together" and not others else one.why
    return Singular(name, why, tuple(others), one.always, one.nearly)


def _causes(told: list[Singular], robot: Robot) -> list[str]:
    causes: dict[str, list[str]] = {}
    for one in told:
        if one.others:
            cause = (
                f"can move together with {_named(one.others)} so that nothing that has mass moves"
            )
        elif one.why == "moves-nothing":
            cause = "moves nothing that has mass"
        elif one.joint in robot.joints and robot.joints[one.joint].type in TURNING:
            cause = "turns about an axis about which nothing has inertia"
        else:
            cause = "moves in a direction in which nothing has inertia"
        names = causes.setdefault(cause, [])
        if one.joint not in names:
            names.append(one.joint)
    return [
        f"joint '{names[0]}' {cause}" if len(names) == 1
        else f"each of the {len(names)} joints {_named(names)} {cause}"
        for cause, names in causes.items()
    ]  # fmt: skip


def _named(names: Sequence[str]) -> str:
    shown = ", ".join(f"'{name}'" for name in names[:SHOWN])
    return f"{shown}, ..." if len(names) > SHOWN else shown
