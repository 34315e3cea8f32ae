"""Actuators: the joints that a motor moves are marked as ``actuated``.

Beyond the method.  Robotran's inverse dynamics computes the forces of actuated joints.  Which
those are is taken from ``<transmission>`` and ``<ros2_control>``, or from the config.
"""

from __future__ import annotations

from fnmatch import fnmatchcase

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError, nearest
from urdf2mbs.engine.hookspecs import Pass


class Options(msgspec.Struct, forbid_unknown_fields=True):
    joints: list[str] = []
    """Patterns of the joints that are actuated, besides those of the URDF."""
    from_urdf: bool = True
    """Whether those of ``<transmission>`` and ``<ros2_control>`` are."""


def run(conversion: Conversion, options: Options) -> None:
    chosen = _from_urdf(conversion) if options.from_urdf else set()
    if not chosen and not options.joints:
        return
    joints = {
        step.joint.name: step.coordinates
        for segment in conversion.segments.values()
        for step in segment.steps
        if step.coordinates
    }
    for pattern in options.joints:
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
        if extension.motors:
            driven.update(extension.motors)
            conversion.simulation.used.append(extension)
    return driven


PASS = Pass("actuators", run, Options, needs=("robot", "joints", "couplings"))
