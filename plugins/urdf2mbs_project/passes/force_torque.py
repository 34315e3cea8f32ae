"""Force-torque: a sensor at a fixed joint becomes six driven joints, whose forces are the wrench.

Beyond the method.  Robotran computes the force ``Qc`` that holds each driven joint.  So three
shifts and three turns, held at zero, measure the force and torque of one side on the other.  A
sensor costs six joints, so the pass makes only the sensors that the config names.
"""

from __future__ import annotations

from urdf2mbs.plugin import ConfigError, Conversion, Pass, Placed, choose, free_name, nearest
from urdf2mbs_project.gazebo import FORCE_TORQUE


class ForceTorque(Pass):
    reads = ("robot", "bodies")
    writes = ("bodies",)

    joints: list[str] = []
    """Patterns of the fixed joints that are force-torque sensors."""

    def run(self, conversion: Conversion) -> None:
        sensors = [
            (sensor, extension)
            for extension in conversion.robot.extensions
            for sensor in extension.sensors
            if sensor.type == FORCE_TORQUE
        ]
        if not sensors and not self.joints:
            return
        named: dict[str, str] = {}
        for sensor, _ in sensors:
            named.setdefault(sensor.on, sensor.name)
        joints = conversion.robot.joints
        steps = {step.joint.name: step for step in conversion.steps() if not step.joint.moves}
        for pattern in self.joints:
            joint = joints.get(pattern)
            if joint is not None and pattern not in steps:
                why = (
                    f"it is {joint.type}, not fixed" if joint.moves
                    else "nothing that has mass hangs on it, so that it measures nothing"
                )  # fmt: skip
                raise ConfigError(
                    "force-torque-joint", f"force-torque: '{pattern}': {why}",
                    hint=nearest(pattern, steps),
                )  # fmt: skip
        what = "force-torque: no fixed joint"
        names = choose(self.joints, steps, "force-torque-joint", what)
        chosen = {name: named.get(name, name) for name in names}
        taken: set[str] = set()
        for joint_name, name in chosen.items():
            # several joints may have sensors of one name; the code finds a sensor by its name
            own = free_name(f"{joint_name}_{name}" if name in taken else name, taken)
            taken.add(own)
            steps[joint_name].measured = own
        used = [extension for sensor, extension in sensors if sensor.on in chosen]
        conversion.state(Placed).elements += used
        left = [name for name in named if name in steps and name not in chosen]
        if left:
            conversion.note(
                "force-torque",
                f"force-torque sensors at fixed joints are left out: {', '.join(left)}; "
                "'passes: {force-torque: {joints: [NAME]}}' makes them, at six driven joints each",
            )
        moving = [name for name in named if joints[name].moves]
        if moving:
            conversion.note(
                "force-torque",
                f"force-torque sensors at joints that move are left out: {', '.join(moving)}; "
                "they need fixed joints",
            )
