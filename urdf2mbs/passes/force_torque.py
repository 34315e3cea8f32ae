"""Force-torque: a sensor at a fixed joint becomes six driven joints, whose forces are the wrench.

Beyond the method.  Robotran computes the force ``Qc`` that holds each driven joint, so three
shifts and three turns that are held at zero measure what one side puts on the other.  This is how
the authors of WalkMan's model did it.  It costs six joints a sensor, so it is done only for the
joints that the config names; the URDF's own ``<sensor type="force_torque">`` are told of.
"""

from __future__ import annotations

from fnmatch import fnmatchcase

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError, nearest
from urdf2mbs.engine.hookspecs import Pass


class ForceTorque(Pass):
    reads = ("robot", "bodies")
    writes = ("bodies",)

    joints: list[str] = []
    """Patterns of the fixed joints that are force-torque sensors."""

    def run(self, conversion: Conversion) -> None:
        named = _named(conversion)
        if not named and not self.joints:
            return
        steps = {
            step.joint.name: step
            for segment in conversion.segments.values()
            for step in segment.steps
            if step.joint.type == "fixed"
        }
        for pattern in self.joints:
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
    sensors: dict[str, str] = {}
    for extension in conversion.robot.extensions:
        for name, _, element in extension.sensors("force_torque"):
            parent = element.find("parent")
            joint = extension.reference if parent is None else parent.get("joint")
            if joint is not None:
                sensors.setdefault(joint, name)
    return sensors
