"""Mimic: joints that follow others (``<mimic>``) become dependent, each with a constraint.

Beyond the method.  In a Robotran project the generated ``user_cons_hJ`` holds the constraint
``q_follower - multiplier q_leader - offset = 0``, and the main script says how many there are:
the ``<user_constraint>`` in the .mbs tells a reader, but makes no constraint.  A follower that
were driven instead would move right, but its inertia would not be felt by its leader.

In a plain .mbs nothing can hold the constraint, so there the joints stay independent, with a
warning, unless the option says otherwise.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Literal

from urdf2mbs.conversion import Conversion, choose
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import UserConstraint
from urdf2mbs.simulation import Coupling
from urdf2mbs.urdf.model import Robot

Nature = Literal["dependent", "independent", "driven"]


class Mimic(Pass):
    reads = ("robot", "joints")
    writes = ("couplings", "joints", "forces")

    joints: dict[str, Nature] = {}
    """Pattern of followers: ``dependent`` (a constraint), ``independent`` (free) or ``driven``
    (moved by user code; its inertia is not felt). The first that fits counts."""

    def run(self, conversion: Conversion) -> None:
        # a joint that counts the other way round follows, and is followed, with the other sign
        robot = conversion.robot.with_flipped(conversion.names.flipped)
        simulation = conversion.simulation
        coordinates = {step.joint.name: step.coordinates for step in conversion.steps()}
        followers = [
            name
            for name, joint in robot.joints.items()
            if joint.mimic is not None and joint.moves and name not in conversion.frozen
        ]
        for pattern in self.joints:
            choose(pattern, followers, "mimic-joints", "mimic: no joint that mimics another")
        in_project = conversion.settings.project is not None
        natures = {name: _nature(name, self, in_project=in_project) for name in followers}
        for name, nature in natures.items():
            if nature == "independent":
                continue
            leader, multiplier, offset = resolve(robot, name, natures)
            own, others = coordinates.get(name, []), coordinates.get(leader, [])
            if len(own) == 1 and not others and not multiplier:
                own[0].nature, own[0].q, own[0].symbols = "driven", offset, ("q",)
                conversion.note(
                    "mimic-held",
                    f"joint '{name}' follows '{leader}' with the multiplier 0, and is held at "
                    f"{offset!r}",
                    joint=name,
                )
                continue
            if len(own) != 1 or len(others) != 1:
                link = robot.joints[leader].child
                conversion.warn(
                    "mimic-leader",
                    f"joint '{name}' follows '{leader}', which does not move in the .mbs by one "
                    f"coordinate: '{name}' stays independent",
                    joint=name,
                    hint=f"'passes: {{prune-massless: {{keep: [{link}]}}}}' keeps what it moves"
                    if leader in conversion.frozen
                    else None,
                )
                continue
            coupling = Coupling(own[0], others[0], multiplier, offset)
            coupling.follow()
            own[0].nature = nature
            if nature == "driven":
                simulation.driven.append(coupling)
                conversion.warn(
                    "mimic-driven",
                    f"joint '{name}' is driven by '{leader}': it moves as it should, but "
                    f"'{leader}' does not feel its inertia",
                    joint=name,
                    hint="'dependent' is exact",
                )
            else:
                simulation.couplings.append(coupling)
                conversion.mbs.user_constraints.append(
                    UserConstraint(f"{name}_mimic", (own[0].name, others[0].name))
                )
        conversion.facts["mimic"] = [
            {
                "follower": coupling.follower, "leader": coupling.leader,
                "multiplier": coupling.multiplier, "offset": coupling.offset,
            }
            for coupling in (*simulation.couplings, *simulation.driven)
        ]  # fmt: skip
        if not conversion.facts["mimic"]:
            del conversion.facts["mimic"]


def resolve(robot: Robot, name: str, natures: dict[str, Nature]) -> tuple[str, float, float]:
    """The first joint up the chain of mimics that is free, and the multiplier and offset (rad
    or m) with which ``name`` follows it."""
    mimic = robot.joints[name].mimic
    multiplier, offset = 1.0, 0.0
    # the reader has seen to it that there are no loops
    while mimic is not None:
        offset += multiplier * mimic.offset
        multiplier *= mimic.multiplier
        name = mimic.joint
        mimic = None if natures.get(name) == "independent" else robot.joints[name].mimic
    return name, multiplier, offset


def _nature(name: str, options: Mimic, *, in_project: bool) -> Nature:
    for pattern, nature in options.joints.items():
        if fnmatchcase(name, pattern):
            return nature
    return "dependent" if in_project else "independent"
