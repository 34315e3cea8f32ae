"""The numbers of a URDF's joints that have no place in an .mbs."""

from __future__ import annotations

from typing import Any

import msgspec

from urdf2mbs.urdf.model import Robot

#: The parts of a joint that are not in an .mbs.
PARTS = ("limit", "dynamics", "mimic", "safety_controller", "calibration")


def left_out(robot: Robot) -> dict[str, dict[str, dict[str, Any]]]:
    """By joint that moves and part, each number with its name (units: those of URDF).

    A limit that is not there, as it is infinite or could not be read, is None.
    """
    left_out: dict[str, dict[str, dict[str, Any]]] = {}
    for joint in robot.joints.values():
        parts = {name: getattr(joint, name) for name in PARTS}
        numbers = {name: msgspec.structs.asdict(part) for name, part in parts.items() if part}
        if joint.moves and numbers:
            left_out[joint.name] = numbers
    return left_out
