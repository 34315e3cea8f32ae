"""Meshes: files of other formats become the .wrl files that Robotran draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import PassEntry, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion


def _are_there(conversion: Conversion, given: bool) -> bool:
    """True if the robot has meshes."""
    return given or bool(conversion.meshes)


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    return [PassEntry("convert-meshes", "urdf2mbs_meshes", ("convert-visuals",), _are_there)]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_meshes.codes import CODES

    return CODES
