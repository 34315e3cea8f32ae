"""Actuators: the joints that a motor moves are marked as ``actuated``.

Beyond the method.  Robotran's inverse dynamics computes the forces of actuated joints.  Which
those are is taken from ``<transmission>`` and ``<ros2_control>``, or from the config.
"""

from __future__ import annotations

from urdf2mbs.plugin import Conversion, Pass, Placed, choose


class Actuators(Pass):
    reads = ("robot", "bodies", "joints")
    writes = ("joints",)

    joints: list[str] = []
    """Patterns of further joints that are actuated."""
    from_urdf: bool = True
    """Also actuate the joints of ``<transmission>`` and ``<ros2_control>``."""

    def run(self, conversion: Conversion) -> None:
        chosen = _from_urdf(conversion) if self.from_urdf else set()
        if not chosen and not self.joints:
            return
        joints = {
            step.joint.name: step.coordinates for step in conversion.steps() if step.coordinates
        }
        what = "actuators: no joint that moves"
        chosen.update(choose(self.joints, joints, "actuators-joints", what))
        for name, coordinates in joints.items():
            # a joint that follows another has no motor of its own
            if name in chosen:
                for joint in coordinates:
                    joint.actuated = joint.nature == "independent"


def _from_urdf(conversion: Conversion) -> set[str]:
    """All joints that a transmission or a control interface names."""
    driven: set[str] = set()
    for extension in conversion.robot.extensions:
        if extension.motors:
            driven.update(extension.motors)
            conversion.state(Placed).elements.append(extension)
    return driven
