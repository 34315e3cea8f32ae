"""Friction states: the deflections of bristles, as states of the user's model.

Beyond the method.  Dry friction at rest is a stiff spring, the bristle, whose deflection is a state
that the integrator carries (Canudas de Wit and others, A new model for control of systems with
friction, 1995): one for each joint that rubs (rad or m), three for each body that touches the
ground (m, in the axes of the base).  The states come behind all other user models, so that in
the structs of Robotran's C the others keep their places.
"""

from __future__ import annotations

from urdf2mbs.plugin import Conversion, Parameter, Pass, UserModel
from urdf2mbs_project.simulation import CONTACT_STATES, JOINT_STATES, Simulation, numbers_of


class FrictionStates(Pass):
    reads = ("forces",)
    writes = ("forces",)

    def run(self, conversion: Conversion) -> None:
        if conversion.settings.project is None:
            return
        stiffnesses = numbers_of(conversion.mbs, ["friction_stiffness"])
        joints = stiffnesses.get("friction_stiffness", {})
        touching = [contact.body.name for contact in conversion.state(Simulation).contacts]
        for name, states in (
            (JOINT_STATES, [Parameter(joint, "state", ("0.0",)) for joint in joints]),
            (CONTACT_STATES, [Parameter(body, "state", ("0.0",) * 3) for body in touching]),
        ):
            if states:
                conversion.mbs.user_models.append(UserModel(name, states))
