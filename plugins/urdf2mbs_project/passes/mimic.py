"""Mimic: joints that follow others (``<mimic>``) become dependent, each with a constraint.

Beyond the method.  In a Robotran project the generated ``user_cons_hJ`` has the constraint
``q_follower - multiplier q_leader - offset = 0``; the ``<user_constraint>`` in the .mbs only
describes it.  A plain .mbs cannot express the constraint.  There the joints stay independent,
with a warning, unless the option says otherwise.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from urdf2mbs.plugin import (
    Conversion,
    MbsJoint,
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
    """Couple the joints that follow others."""

    reads = ("robot", "bodies", "joints")
    writes = ("couplings", "joints", "posture", "forces")

    joints: dict[str, Nature] = {}
    """Pattern of followers: ``dependent`` (a constraint), ``independent`` (free) or ``driven``
    (moved by user code; its inertia is not felt). The first that fits counts."""

    def run(self, conversion: Conversion) -> None:
        """Couple each follower that is not independent to the joint at the end of its chain."""
        simulation = conversion.state(Simulation)
        coordinates = {step.joint.name: step.coordinates for step in conversion.steps()}
        natures = self._choose_natures(conversion)
        independent = {name for name, nature in natures.items() if nature == "independent"}
        for name, nature in natures.items():
            if name in independent:
                continue
            leader, multiplier, offset = follow(conversion.robot, name, independent)
            own_joints, leader_joints = coordinates.get(name, []), coordinates.get(leader, [])
            if len(own_joints) == 1 and not leader_joints and not multiplier:
                _lock(conversion, own_joints[0], name, leader, offset)
            elif len(own_joints) != 1 or len(leader_joints) != 1:
                _warn_of_leader(conversion, name, leader)
            else:
                coupling = Coupling(own_joints[0], leader_joints[0], multiplier, offset)
                coupling.update_follower()
                coupling.follower.nature = nature
                conversion.state(Placed).joints.setdefault("mimic", set()).add(name)
                if nature == "driven":
                    _drive(conversion, coupling, name, leader)
                else:
                    _constrain(conversion, coupling, name)
        couplings = [*simulation.couplings, *simulation.driven]
        if couplings:
            conversion.report["mimic"] = [
                msgspec.structs.asdict(coupling) for coupling in couplings
            ]

    def _choose_natures(self, conversion: Conversion) -> dict[str, Nature]:
        """Choose the nature of each follower: by the options, else dependent in a project."""
        followers = [
            name
            for name, joint in conversion.robot.joints.items()
            if joint.mimic is not None and joint.moves and name not in conversion.frozen
        ]
        choose(self.joints, followers, "mimic-joints", "mimic: no joint that mimics another")
        in_project = conversion.settings.project is not None
        natures: dict[str, Nature] = dict.fromkeys(
            followers, "dependent" if in_project else "independent"
        )
        # The first pattern is applied last, so that it overrules the others.
        for pattern, nature in reversed(self.joints.items()):
            fitting = [name for name in followers if fits(name, [pattern])]
            natures |= dict.fromkeys(fitting, nature)
        return natures


def _lock(conversion: Conversion, joint: MbsJoint, name: str, leader: str, offset: float) -> None:
    """Lock a follower whose multiplier is 0 at its offset (rad or m)."""
    joint.nature, joint.q, joint.symbols = "driven", offset, ("q",)
    message = f"joint '{name}' follows '{leader}' with the multiplier 0, and is held at {offset!r}"
    conversion.note("mimic-held", message, joint=name)


def _warn_of_leader(conversion: Conversion, name: str, leader: str) -> None:
    """Warn of a follower that stays independent, since its leader is not one coordinate."""
    message = (
        f"joint '{name}' follows '{leader}', which does not move in the .mbs by one coordinate: "
        f"'{name}' stays independent"
    )
    hint = None
    if leader in conversion.frozen:
        link = conversion.robot.joints[leader].child
        hint = f"'passes: {{prune-massless: {{keep: [{link}]}}}}' keeps its link"
    conversion.warn("mimic-leader", message, joint=name, hint=hint)


def _constrain(conversion: Conversion, coupling: Coupling, name: str) -> None:
    """Add a coupling as a constraint."""
    conversion.state(Simulation).couplings.append(coupling)
    joints = (coupling.follower.name, coupling.leader.name)
    conversion.mbs.user_constraints.append(UserConstraint(f"{name}_mimic", joints))


def _drive(conversion: Conversion, coupling: Coupling, name: str, leader: str) -> None:
    """Add a coupling that user code drives, and warn of the inertia that it neglects."""
    conversion.state(Simulation).driven.append(coupling)
    conversion.state(OnPurpose).driven.append(coupling.follower)
    message = (
        f"joint '{name}' is driven by '{leader}': it moves as it should, but '{leader}' does not "
        "feel its inertia"
    )
    conversion.warn("mimic-driven", message, joint=name, hint="'dependent' is exact")
