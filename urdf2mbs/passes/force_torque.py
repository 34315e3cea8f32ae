"""Force-torque: a sensor at a fixed joint becomes six driven joints, whose forces are the wrench.

Beyond the method.  Robotran computes the force ``Qc`` that holds each driven joint, so three
shifts and three turns that are held at zero measure what one side puts on the other.  This is how
the authors of WalkMan's model did it.  It costs six joints a sensor, so it is done only for the
joints that the config names; the URDF's own ``<sensor type="force_torque">`` are told of.
"""

from __future__ import annotations

from fnmatch import fnmatchcase

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError, nearest
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.urdf.gazebo import FORCE_TORQUE


class Options(msgspec.Struct, forbid_unknown_fields=True):
    joints: list[str] = []
    """Patterns of the fixed joints that are force-torque sensors."""


def run(conversion: Conversion, options: Options) -> None:
    named = _named(conversion)
    if not named and not options.joints:
        return
    steps = {step.joint.name: step for step in conversion.steps() if not step.joint.moves}
    for pattern in options.joints:
        joints = [name for name in steps if fnmatchcase(name, pattern)]
        if not joints:
            joint = conversion.robot.joints.get(pattern)
            why = (
                "there is no fixed joint of that name" if joint is None
                else f"it is {joint.type}, not fixed" if joint.moves
                else "nothing that has mass hangs on it, so that it measures nothing"
            )  # fmt: skip
            raise ConfigError(
                "force-torque-joint", f"force-torque: '{pattern}': {why}",
                hint=nearest(pattern, steps),
            )  # fmt: skip
        for name in joints:
            steps[name].measured = named.get(name, name)
    left = [joint for joint in named if joint in steps and steps[joint].measured is None]
    if left:
        conversion.note(
            "force-torque",
            f"force-torque sensors at fixed joints that are left out: {', '.join(left)}; "
            "'passes: {force-torque: {joints: [NAME]}}' makes them, at six driven joints each",
        )


def _named(conversion: Conversion) -> dict[str, str]:
    """The joints with a force-torque sensor in the URDF, and the name of the sensor."""
    return {
        sensor.on: sensor.name
        for extension in reversed(conversion.robot.extensions)
        for sensor in reversed(extension.sensors)
        if sensor.type == FORCE_TORQUE
    }


PASS = Pass("force-torque", run, Options, needs=("robot",), changes=("bodies",))
