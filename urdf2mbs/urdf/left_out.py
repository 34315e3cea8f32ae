"""What a URDF says of its joints and an .mbs has no place for, as values."""

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
        if not joint.moves:
            continue
        parts = {name: part for name in PARTS if (part := getattr(joint, name)) is not None}
        if parts:
            left_out[joint.name] = {
                name: msgspec.structs.asdict(part) for name, part in parts.items()
            }
    return left_out
