"""Rotors: the inertia of motors, as the joints feel it behind their gears ("armature").

Beyond the method.  Robotran has no such number for a joint, and no joint force can depend on an
acceleration.  So each rotor becomes a link without mass, of the inertia J that the joint feels,
that turns on the base about z.  It follows its joint as ``<mimic>`` says, with the multiplier 1.
It hangs on nothing that moves, so its energy is just ``J qd^2 / 2``.
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
    choose,
    free_name,
    some,
)
from urdf2mbs.plugin import UrdfJoint as Joint


class Rotors(Pass):
    reads = ("robot",)
    writes = ("robot",)

    armature: dict[str, Annotated[float, msgspec.Meta(gt=0.0, le=1e6)]] = {}
    """Pattern of joints: the inertia of the rotor as the joint feels it (kg m^2, or kg for a
    prismatic joint); a later pattern overrules."""
    from_urdf: bool = False
    """Also take ``motorInertia`` times ``mechanicalReduction`` squared from ``<transmission>``."""

    def run(self, conversion: Conversion) -> None:
        robot = conversion.robot
        joints = [name for name, joint in robot.joints.items() if JOINT_TYPES[joint.type] == 1]
        stated = {
            name: inertia
            for extension in robot.extensions
            for name, inertia in extension.rotors.items()
            if name in joints
        }
        felt = dict(stated) if self.from_urdf else {}
        for pattern, inertia in self.armature.items():
            what = "rotors: no joint that moves by one coordinate"
            felt |= dict.fromkeys(choose([pattern], joints, "rotors-joints", what), inertia)
        left_out = {name: inertia for name, inertia in stated.items() if name not in felt}
        if left_out:
            listed = some(f"joint '{name}' {inertia:.3g}" for name, inertia in left_out.items())
            conversion.warn(
                "rotors-left-out",
                f"joints feel the inertia of rotors, which is left out: {listed} kg m^2",
                hint="a project counts it: 'passes: {rotors: {from_urdf: true}}'",
            )
        if not felt:
            return
        if conversion.settings.project is None:
            raise ConfigError(
                "rotors-project", "rotors: only a project can hold rotors to their joints",
                hint="'output: {project: DIR}'",
            )  # fmt: skip
        base, taken = robot.root(), {*robot.links, *robot.joints}
        links, turning = dict(robot.links), dict(robot.joints)
        for name, inertia in felt.items():
            rotor = free_name(f"{name}_rotor", taken)
            turn = free_name(f"{rotor}_turn", taken)
            taken |= {rotor, turn}
            tensor = (inertia, 0.0, 0.0, inertia, 0.0, inertia)
            links[rotor] = Link(rotor, Inertial(0.0, tensor))
            turning[turn] = Joint(
                turn, "continuous", base, rotor, axis=(0.0, 0.0, 1.0), mimic=Mimic(name)
            )
        conversion.robot = msgspec.structs.replace(robot, links=links, joints=turning)
        conversion.report["rotors"] = felt
