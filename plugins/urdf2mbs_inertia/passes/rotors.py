"""Rotors: the inertia of motors, as the joints feel it behind their gears ("armature").

Beyond the method.  Robotran has no such number for a joint, and no joint force can depend on an
acceleration.  So each rotor becomes a link without mass, of the inertia J that the joint feels,
that rotates on the base about z.  It follows its joint as ``<mimic>`` says, with the multiplier 1.
It is attached to nothing that moves, so its energy is just ``J qd^2 / 2``.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from urdf2mbs.plugin import (
    JOINT_TYPES,
    ConfigError,
    Conversion,
    Inertial,
    Link,
    Mimic,
    Pass,
    UrdfJoint,
    choose,
    free_name,
    some,
)


class Rotors(Pass):
    """Add the rotors of motors, whose inertia the joints feel."""

    reads = ("robot",)
    writes = ("robot",)

    armature: dict[str, Annotated[float, msgspec.Meta(gt=0.0, le=1e6)]] = {}
    """Pattern of joints: the inertia of the rotor as the joint feels it (kg m^2, or kg for a
    prismatic joint); a later pattern overrules."""
    from_urdf: bool = False
    """Also take ``motorInertia`` times ``mechanicalReduction`` squared from ``<transmission>``, in
    a project."""

    def run(self, conversion: Conversion) -> None:
        """Add a rotor for each joint whose armature is given."""
        inertias = self._collect_inertias(conversion)
        if not inertias:
            return
        if conversion.settings.project is None:
            if not self.armature:
                _warn_left_out(conversion, inertias)
                return
            message = "rotors: only a project can couple rotors to their joints"
            raise ConfigError("rotors-project", message, hint="'output: {project: DIR}'")
        _add_rotors(conversion, inertias)
        conversion.report["rotors"] = inertias

    def _collect_inertias(self, conversion: Conversion) -> dict[str, float]:
        """Return the inertia (kg m^2 or kg) of each rotor, by joint; warn of those left out."""
        robot = conversion.robot
        joint_names = [
            joint_name for joint_name, joint in robot.joints.items() if JOINT_TYPES[joint.type] == 1
        ]
        stated_inertias = {
            joint_name: inertia
            for extension in robot.extensions
            for joint_name, inertia in extension.rotors.items()
            if joint_name in joint_names
        }
        inertias = dict(stated_inertias) if self.from_urdf else {}
        for pattern, inertia in self.armature.items():
            label = "rotors: no joint that moves by one coordinate"
            selected_joints = choose([pattern], joint_names, "rotors-joints", label)
            inertias |= dict.fromkeys(selected_joints, inertia)
        unused_inertias = {
            joint_name: inertia
            for joint_name, inertia in stated_inertias.items()
            if joint_name not in inertias
        }
        if unused_inertias:
            _warn_left_out(conversion, unused_inertias)
        return inertias


def _warn_left_out(conversion: Conversion, inertias: dict[str, float]) -> None:
    """Warn of the rotors that the robot states, and the .mbs does not have."""
    listed = some(f"joint '{joint_name}' {inertia:.3g}" for joint_name, inertia in inertias.items())
    conversion.warn(
        "rotors-left-out",
        f"joints feel the inertia of rotors, which is left out: {listed} kg m^2",
        hint="a project adds it: 'passes: {rotors: {from_urdf: true}}'",
    )


def _add_rotors(conversion: Conversion, inertias: dict[str, float]) -> None:
    """Add a link and a joint for the rotor of each of these joints."""
    robot = conversion.robot
    base_link, used_names = robot.root(), {*robot.links, *robot.joints}
    links, joints = dict(robot.links), dict(robot.joints)
    for leader_joint, inertia in inertias.items():
        rotor_link = free_name(f"{leader_joint}_rotor", used_names)
        rotor_joint = free_name(f"{rotor_link}_turn", used_names)
        used_names |= {rotor_link, rotor_joint}
        links[rotor_link] = Link(
            rotor_link, Inertial(0.0, (inertia, 0.0, 0.0, inertia, 0.0, inertia))
        )
        joints[rotor_joint] = UrdfJoint(
            rotor_joint,
            "continuous",
            base_link,
            rotor_link,
            axis=(0.0, 0.0, 1.0),
            mimic=Mimic(leader_joint),
        )
    conversion.robot = msgspec.structs.replace(robot, links=links, joints=joints)
