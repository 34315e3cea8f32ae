"""Friction states: add the deflections of bristles as states of user models.

Beyond the method.  Dry friction at rest is a stiff spring, the bristle, whose deflection is a state
that the integrator carries (Canudas de Wit and others, A new model for control of systems with
friction, 1995).  Each joint with friction has one (rad or m), and each body that touches the ground
has three (m, m, rad).  The states come after all other user models, so that these keep their
places in the structs of Robotran's C.
"""

from __future__ import annotations

from urdf2mbs.plugin import Conversion, Parameter, Pass, UserModel
from urdf2mbs_project.simulation import CONTACT_STATES, JOINT_STATES, Simulation, read_parameters


class FrictionStates(Pass):
    """Add the states of friction."""

    reads = ("forces",)
    writes = ("forces",)

    def run(self, conversion: Conversion) -> None:
        """Add a user model for the joints, and one for the contacts."""
        if conversion.settings.project is None:
            return
        stiffnesses = read_parameters(conversion.mbs, ["friction_stiffness"])
        joints = stiffnesses.get("friction_stiffness", {})
        joint_states = [Parameter(joint, "state", ("0.0",)) for joint in joints]
        contact_states = [
            Parameter(contact.body.name, "state", ("0.0",) * 3)
            for contact in conversion.state(Simulation).contacts
        ]
        for model_name, states in ((JOINT_STATES, joint_states), (CONTACT_STATES, contact_states)):
            if states:
                conversion.mbs.user_models.append(UserModel(model_name, states))
