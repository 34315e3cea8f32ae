"""Force-torque: a sensor at a fixed joint becomes six driven joints, whose forces are the wrench.

Beyond the method.  Robotran computes the force ``Qc`` that holds each driven joint, so three
shifts and three turns that are held at zero measure what one side puts on the other.  This is how
the authors of WalkMan's model did it.  It costs six joints a sensor, so it is done only for the
joints that the config names; the URDF's own ``<sensor type="force_torque">`` are told of.
"""

from __future__ import annotations

from fnmatch import fnmatchcase

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.names import free_name
from urdf2mbs.messages.diagnostics import ConfigError, nearest
from urdf2mbs.urdf.gazebo import FORCE_TORQUE


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
        chosen: dict[str, str] = {}
        for pattern in self.joints:
            fitting = [name for name in steps if fnmatchcase(name, pattern)]
            if not fitting:
                joint = joints.get(pattern)
                why = (
                    "there is no fixed joint of that name" if joint is None
                    else f"it is {joint.type}, not fixed" if joint.moves
                    else "nothing that has mass hangs on it, so that it measures nothing"
                )  # fmt: skip
                raise ConfigError(
                    "force-torque-joint", f"force-torque: '{pattern}': {why}",
                    hint=nearest(pattern, steps),
                )  # fmt: skip
            chosen |= {name: named.get(name, name) for name in fitting}
        names: set[str] = set()
        for joint_name, name in chosen.items():
            # the code finds a sensor by its name, which may stand at several joints
            own = free_name(f"{joint_name}_{name}" if name in names else name, names)
            names.add(own)
            steps[joint_name].measured = own
        conversion.simulation.used += [one for sensor, one in sensors if sensor.on in chosen]
        left = [name for name in named if name in steps and name not in chosen]
        if left:
            conversion.note(
                "force-torque",
                f"force-torque sensors at fixed joints that are left out: {', '.join(left)}; "
                "'passes: {force-torque: {joints: [NAME]}}' makes them, at six driven joints each",
            )
        moving = [name for name in named if joints[name].moves]
        if moving:
            conversion.note(
                "force-torque",
                f"force-torque sensors at joints that move are left out: {', '.join(moving)}; only "
                "at fixed joints can they be made",
            )
