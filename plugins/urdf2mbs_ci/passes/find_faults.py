"""Find faults: warn of what is odd in the robot as a whole, as ``lint`` does.

The reader names what is odd in single elements; the other passes warn when they convert the robot.
"""

from __future__ import annotations

from urdf2mbs.plugin import Conversion, Pass, find_locked_joints


class FindFaults(Pass):
    reads = ("robot",)

    def run(self, conversion: Conversion) -> None:
        robot = conversion.robot
        if all(link.massless for link in robot.links.values()):
            conversion.warn(
                "no-mass", "no link has a mass or an inertia: no force can move the robot"
            )
        for locked in find_locked_joints(robot):
            message = locked.describe(robot)
            conversion.warn("mimic-locked", message, joint=locked.follower.name)
        warn_of_missing_meshes = conversion.find("warn_of_missing_meshes")
        if warn_of_missing_meshes is not None:
            warn_of_missing_meshes(conversion)
