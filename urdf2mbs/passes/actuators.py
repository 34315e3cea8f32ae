"""Actuators: the joints that a motor moves are marked as ``actuated``.

Beyond the method.  Robotran's inverse dynamics computes the forces of actuated joints.  Which
those are is taken from ``<transmission>`` and ``<ros2_control>``, or from the config.
"""

from __future__ import annotations

from fnmatch import fnmatchcase

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError, nearest
from urdf2mbs.engine.hookspecs import Pass


class Actuators(Pass):
    reads = ("robot", "joints", "couplings")
    writes = ("joints",)

    joints: list[str] = []
    """Patterns of the joints that are actuated, besides those of the URDF."""
    from_urdf: bool = True
    """Whether those of ``<transmission>`` and ``<ros2_control>`` are."""

    def run(self, conversion: Conversion) -> None:
        chosen = _from_urdf(conversion) if self.from_urdf else set()
        if not chosen and not self.joints:
            return
        joints = {
            step.joint.name: step.coordinates
            for segment in conversion.segments.values()
            for step in segment.steps
            if step.coordinates
        }
        for pattern in self.joints:
            named = {name for name in joints if fnmatchcase(name, pattern)}
            if not named:
                raise ConfigError(
                    "actuators-joints", f"actuators: no joint that moves is called '{pattern}'",
                    hint=nearest(pattern, joints) or "'*' in a pattern stands for any text",
                )  # fmt: skip
            chosen |= named
        for name, coordinates in joints.items():
            # a joint that follows another has no motor of its own
            if name in chosen:
                for joint in coordinates:
                    joint.actuated = joint.nature == "independent"


def _from_urdf(conversion: Conversion) -> set[str]:
    """All joints that a transmission or a control interface names."""
    driven: set[str] = set()
    for extension in conversion.robot.extensions:
        if extension.tag not in ("transmission", "ros2_control"):
            continue
        always = extension.tag == "transmission"
        for joint in extension.element().iter("joint", "{*}joint"):
            name = joint.get("name")
            if name and (always or joint.find("command_interface") is not None):
                driven.add(str(name))
                conversion.simulation.used.append(extension)
    return driven
