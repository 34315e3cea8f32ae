"""Find faults: warn of faults of the robot as a whole, as ``lint`` does.

The reader warns of single elements, and the other passes of what they convert.  Plugins add checks
by the hook ``urdf2mbs_find_faults``.
"""

from __future__ import annotations

from urdf2mbs.plugin import Conversion, Pass, find_locked_joints


class FindFaults(Pass):
    """Warn of faults of the robot as a whole, as ``lint`` does."""

    reads = ("robot",)

    def run(self, conversion: Conversion) -> None:
        """Warn of a robot without mass, and of locked joints; then run the checks of plugins."""
        robot = conversion.robot
        if all(link.massless for link in robot.links.values()):
            conversion.warn(
                "no-mass", "no link has a mass or an inertia: no force can move the robot"
            )
        for locked in find_locked_joints(robot):
            message = locked.describe(robot)
            conversion.warn("mimic-locked", message, joint=locked.follower.name)
        conversion.hook.urdf2mbs_find_faults(conversion=conversion)
