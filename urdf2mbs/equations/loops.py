"""The accelerations of a model with loops: what the function must know of the model.

Dependent joints are solved for by Newton's method, their rates and accelerations by the
Jacobian of the constraints; then the equations of the independent ones are those of Robotran's
own ``dirdynared`` (Samin and Fisette, Symbolic Modeling of Multibody Systems, 2003, chapter 4):
with qdd = T qdd_u + g it is T^T M T qdd_u = T^T (Qq - c - M g).
"""

from __future__ import annotations

from dataclasses import dataclass

from urdf2mbs.equations.constraints import EQUATIONS
from urdf2mbs.equations.tree import Tree


@dataclass
class Loops:
    """The joints by number; of the constraints, those of cuts come first."""

    joints: int
    dependent: list[int]
    independent: list[int]
    driven: list[int]
    cuts: int
    """Equations of cuts."""
    user: int
    """Equations that the user's functions give."""


@dataclass
class Refused:
    """A function that is not generated, and why."""

    why: str


def loops(tree: Tree) -> Loops | Refused:
    numbers: dict[str, list[int]] = {"dependent": [], "independent": [], "driven": []}
    for frame in tree.frames[1:]:
        numbers[frame.joint.nature].append(frame.number)
    cuts = sum(EQUATIONS[cut.kind] for cut in tree.mbs.cuts)
    dependent = len(numbers["dependent"])
    if dependent < cuts:
        return Refused(
            f"the cuts make {cuts} equations, and {dependent} joints are dependent: "
            "it takes one joint for each equation"
        )
    return Loops(len(tree.frames) - 1, **numbers, cuts=cuts, user=dependent - cuts)
