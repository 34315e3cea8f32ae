"""Mimic: joints that follow others (``<mimic>``) become dependent, each with a constraint.

Beyond the method.  In a Robotran project the generated ``user_cons_hJ`` holds the constraint
``q_follower - multiplier q_leader - offset = 0``; the ``<user_constraint>`` in the .mbs only
describes it.  In a plain .mbs nothing can hold the constraint.  There the joints stay independent,
with a warning, unless the option says otherwise.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from urdf2mbs.plugin import (
    Conversion,
    OnPurpose,
    Pass,
    Placed,
    UserConstraint,
    choose,
    fits,
    follow,
)
from urdf2mbs_project.simulation import Coupling, Simulation

Nature = Literal["dependent", "independent", "driven"]


class Mimic(Pass):
    reads = ("robot", "bodies", "joints")
    writes = ("couplings", "joints", "posture", "forces")

    joints: dict[str, Nature] = {}
    """Pattern of followers: ``dependent`` (a constraint), ``independent`` (free) or ``driven``
    (moved by user code; its inertia is not felt). The first that fits counts."""

    def run(self, conversion: Conversion) -> None:
        robot = conversion.robot
        simulation = conversion.state(Simulation)
        coordinates = {step.joint.name: step.coordinates for step in conversion.steps()}
        followers = [
            name
            for name, joint in robot.joints.items()
            if joint.mimic is not None and joint.moves and name not in conversion.frozen
        ]
        choose(self.joints, followers, "mimic-joints", "mimic: no joint that mimics another")
        natures = self._natures(conversion, followers)
        free = {name for name, nature in natures.items() if nature == "independent"}
        for name, nature in natures.items():
            if name in free:
                continue
            leader, multiplier, offset = follow(robot, name, free)
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
                    hint=f"'passes: {{prune-massless: {{keep: [{link}]}}}}' keeps its link"
                    if leader in conversion.frozen
                    else None,
                )
                continue
            coupling = Coupling(own[0], others[0], multiplier, offset)
            coupling.follow()
            conversion.state(Placed).joints.setdefault("mimic", set()).add(name)
            own[0].nature = nature
            if nature == "driven":
                _drive(conversion, coupling, name, leader)
            else:
                simulation.couplings.append(coupling)
                conversion.mbs.user_constraints.append(
                    UserConstraint(f"{name}_mimic", (own[0].name, others[0].name))
                )
        couplings = [*simulation.couplings, *simulation.driven]
        if couplings:
            conversion.report["mimic"] = [msgspec.structs.asdict(c) for c in couplings]

    def _natures(self, conversion: Conversion, followers: list[str]) -> dict[str, Nature]:
        """What each follower is: as the options say, else dependent in a project."""
        in_project = conversion.settings.project is not None
        natures: dict[str, Nature] = dict.fromkeys(
            followers, "dependent" if in_project else "independent"
        )
        for pattern, nature in reversed(self.joints.items()):
            natures |= dict.fromkeys((n for n in followers if fits(n, [pattern])), nature)
        return natures


def _drive(conversion: Conversion, coupling: Coupling, name: str, leader: str) -> None:
    conversion.state(Simulation).driven.append(coupling)
    conversion.state(OnPurpose).driven.append(coupling.follower)
    conversion.warn(
        "mimic-driven",
        f"joint '{name}' is driven by '{leader}': it moves as it should, but '{leader}' does not "
        "feel its inertia",
        joint=name, hint="'dependent' is exact",
    )  # fmt: skip
