"""Masses and inertias that a URDF lacks or rounds: estimates, round angles, rotors of motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import PassEntry, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion

NEEDS = ("meshes",)


def _has_rotors(conversion: Conversion, given: bool) -> bool:
    """Return True if the config has options of rotors, or the robot states inertias of motors."""
    return given or any(extension.rotors for extension in conversion.robot.extensions)


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    """Return the passes, with the passes after which they run, and when they have work."""
    package = "urdf2mbs_inertia"
    return [
        PassEntry("snap", package, after=("expand",)),
        PassEntry("estimate-inertia", package, after=("expand", "snap")),
        PassEntry("rotors", package, after=("insert-base",), work=_has_rotors),
    ]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of the messages."""
    from urdf2mbs_inertia.codes import CODES

    return CODES
