"""Data that passes share beyond the sections: each class by ``conversion.state(CLASS)``."""

from __future__ import annotations

from typing import Any

import msgspec

from urdf2mbs.mbs.model import Joint
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.urdf.model import Extension


class Estimates(msgspec.Struct):
    """The links whose inertia is only an estimate."""

    links: list[str] | None = None
    """Their names; None if no estimate was asked for."""

    def sections(self) -> dict[str, Any]:
        """Return the sections that change with the estimates, as ``conversion.state`` expects."""
        return {"robot": self.links}


class JointModels(msgspec.Struct):
    """The properties of joints that joint-parameters has written as user models."""

    values: dict[str, dict[str, float]] = {}
    """By the name of the user model: the value at each joint of the .mbs."""
    stop_frequency: float | None = None
    """Stiffness (Hz) of the soft stops of a project; None if it has no stops."""


class Placed(msgspec.Struct):
    """Parts of the URDF that are in the .mbs, so that ``left-out`` does not name them."""

    joints: dict[str, set[str]] = {}
    """By the code of a note of ``left-out``: the URDF joints whose property is in the .mbs."""
    elements: list[Extension] = []
    """The elements of other programs from which a pass has taken something."""


class OnPurpose(msgspec.Struct):
    """Differences between the robots of .mbs and URDF that are intended; ``check`` names them."""

    massless: set[str] = set()
    """The joints of ``frozen`` that are left out because nothing that they move has mass."""
    driven: list[Joint] = []
    """The followers that user code moves."""
    edited: dict[str, None] = {}
    """The files whose edits make the .mbs another robot than the URDF's."""
    added: dict[str, str] = {}
    """Elements that people added to the .mbs, and where each of them is."""


class SecondOpinions(msgspec.Struct):
    """What other programs compute for the robot that was read; the verdict states it."""

    confirmed: list[str] = []
    """What agrees, such as ``as MuJoCo computes it, to 1e-13``."""
    differences: list[Difference] = []
    not_compared: dict[str, str] = {}
    """Elements of the .mbs that the robot's file states and the proof does not see, such as
    ``cut 'NAME' (ball)``, each with the reason."""

    def add_to(self, proof: Proof) -> None:
        """Add the opinions to a proof; with differences it is not the same robot."""
        for element in self.not_compared.keys() & proof.but_for.keys():
            del proof.but_for[element]
            proof.not_compared[element] = self.not_compared[element]
        proof.confirmed += self.confirmed
        proof.add_differences(self.differences)
