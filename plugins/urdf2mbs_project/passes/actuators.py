"""Actuators: mark the joints that a motor moves as ``actuated``.

Beyond the method.  Robotran's inverse dynamics computes the forces of actuated joints.  They are
those that ``<transmission>`` and ``<ros2_control>`` name, or the config.
"""

from __future__ import annotations

from urdf2mbs.plugin import Conversion, Pass, Placed, choose


class Actuators(Pass):
    """Mark the joints that a motor moves."""

    reads = ("robot", "bodies", "joints")
    writes = ("joints",)

    joints: list[str] = []
    """Patterns of further joints that are actuated."""
    from_urdf: bool = True
    """Also actuate the joints of ``<transmission>`` and ``<ros2_control>``."""

    def run(self, conversion: Conversion) -> None:
        """Mark the joints."""
        actuated = _find_motor_joints(conversion) if self.from_urdf else set()
        if not actuated and not self.joints:
            return
        joints = {
            step.joint.name: step.coordinates for step in conversion.steps() if step.coordinates
        }
        message = "actuators: no joint that moves"
        actuated.update(choose(self.joints, joints, "actuators-joints", message))
        for name, coordinates in joints.items():
            if name in actuated:
                for joint in coordinates:
                    # A joint that follows another has no motor.
                    joint.actuated = joint.nature == "independent"


def _find_motor_joints(conversion: Conversion) -> set[str]:
    """Find the joints that a transmission or a control interface names."""
    names: set[str] = set()
    for extension in conversion.robot.extensions:
        if extension.motors:
            names.update(extension.motors)
            conversion.state(Placed).elements.append(extension)
    return names
