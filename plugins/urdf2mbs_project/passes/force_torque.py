"""Force-torque: turn fixed joints into sensors, each of six driven joints.

Beyond the method.  Robotran computes the force ``Qc`` that a driven joint needs.  So three
prismatic and three revolute joints, driven at zero, measure the force and torque of one side on the
other.  A sensor costs six joints, so the pass makes only the sensors that the config names.
"""

from __future__ import annotations

from collections.abc import Mapping

from urdf2mbs.plugin import ConfigError, Conversion, Pass, Placed, Step, choose, free_name, nearest
from urdf2mbs_project.sdf import FORCE_TORQUE


class ForceTorque(Pass):
    """Turn the fixed joints that the config names into force-torque sensors."""

    reads = ("robot", "bodies")
    writes = ("bodies",)

    joints: list[str] = []
    """Patterns of the fixed joints that are force-torque sensors."""

    def run(self, conversion: Conversion) -> None:
        """Name the sensor of each chosen step; ``decompose-joints`` makes its joints."""
        sensors = [
            (sensor, extension)
            for extension in conversion.robot.extensions
            for sensor in extension.sensors
            if sensor.type == FORCE_TORQUE
        ]
        if not sensors and not self.joints:
            return
        sensor_names: dict[str, str] = {}
        for sensor, _ in sensors:
            sensor_names.setdefault(sensor.on, sensor.name)
        steps = {step.joint.name: step for step in conversion.steps() if not step.joint.moves}
        self._check_joints(conversion, steps)
        message = "force-torque: no fixed joint"
        chosen = choose(self.joints, steps, "force-torque-joint", message)
        used_names: set[str] = set()
        for joint_name in chosen:
            # The code finds a sensor by its name, and several joints may have sensors of one name.
            name = sensor_names.get(joint_name, joint_name)
            full_name = f"{joint_name}_{name}" if name in used_names else name
            unique_name = free_name(full_name, used_names)
            used_names.add(unique_name)
            steps[joint_name].measured = unique_name
        used = [extension for sensor, extension in sensors if sensor.on in chosen]
        conversion.state(Placed).elements += used
        _note_unused_sensors(conversion, [name for name in sensor_names if name not in chosen])

    def _check_joints(self, conversion: Conversion, steps: Mapping[str, Step]) -> None:
        """Raise ConfigError if an option names a joint that cannot be a sensor."""
        for name in self.joints:
            joint = conversion.robot.joints.get(name)
            if joint is None or name in steps:
                continue
            if joint.moves:
                reason = f"it is {joint.type}, not fixed"
            else:
                reason = "nothing that has mass is attached to it, so that it measures nothing"
            message = f"force-torque: '{name}': {reason}"
            raise ConfigError("force-torque-joint", message, hint=nearest(name, steps))


def _note_unused_sensors(conversion: Conversion, joint_names: list[str]) -> None:
    """Note which sensors of the URDF become none, by the joints that they are on."""
    joints = conversion.robot.joints
    steps = {step.joint.name for step in conversion.steps() if not step.joint.moves}
    fixed = [name for name in joint_names if name in steps]
    if fixed:
        message = (
            f"force-torque sensors at fixed joints are left out: {', '.join(fixed)}; "
            "'passes: {force-torque: {joints: [NAME]}}' makes them, at six driven joints each"
        )
        conversion.note("force-torque", message)
    moving = [name for name in joint_names if joints[name].moves]
    if moving:
        message = (
            f"force-torque sensors at joints that move are left out: {', '.join(moving)}; "
            "they need fixed joints"
        )
        conversion.note("force-torque", message)
