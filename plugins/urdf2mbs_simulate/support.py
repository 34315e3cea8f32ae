"""What holds a model: finds a floating base, and proposes what can carry the model's weight."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from urdf2mbs.plugin import near, some

if TYPE_CHECKING:
    from urdf2mbs.plugin import Mbs, MbsJoint
    from urdf2mbs_simulate.data import MbsData

#: How insert-base names the joints of a floating base; a number follows where the name is taken.
INSERTED_BASE = "floating_base"


def find_floating_base(model: Mbs) -> list[MbsJoint]:
    """Return the six joints of a floating base; none if something holds it.

    A floating base is a body on the ground with three translations and three rotations.  A cut, or
    a force element, between the ground and another body holds it.
    """
    for connection in (*model.cuts, *model.links):
        if None in (connection.endpoint1[0], connection.endpoint2[0]):
            return []
    for body in model.bodies:
        joints = [joint for joint in body.joints if joint.nature != "driven"][:6]
        kinds = sorted(joint.type[0] for joint in joints)
        is_free = all(joint.nature == "independent" for joint in joints)
        if body.parent is None and is_free and kinds == ["R", "R", "R", "T", "T", "T"]:
            return joints
    return []


def propose_support(joint: MbsJoint) -> str:
    """Say how a config can hold a floating base, of which ``joint`` is one of the joints."""
    ground = "'passes: {contacts: {links: [FOOT]}}' gives it a ground"
    # an option of the config can fix only a base that insert-base has made
    is_inserted = re.fullmatch(rf"{INSERTED_BASE}(_\d+)?_[TR]\d", joint.name)
    return f"'base: fixed' bolts it down, {ground}" if is_inserted else ground


def propose_equilibrium(data: MbsData) -> str:
    """Return what to do with a model for which no equilibrium is found."""
    run = data._run
    forces = [*data.extforce_id, *data.link_id]
    if forces and not data.user_path.is_dir():
        return (
            f"the laws of {some(forces, 4)} are user functions, which are not beside it: give the "
            f".mbs in its project, with {near(data.user_path)}"
        )
    base = find_floating_base(run.mbs)
    if base and not forces:
        return f"nothing holds it: {propose_support(base[0])}"
    return (
        f"'urdf2mbs simulate {near(run.file)} -o PAGE.html' shows how it moves; contacts, springs, "
        "stops, or a controller hold it"
    )
