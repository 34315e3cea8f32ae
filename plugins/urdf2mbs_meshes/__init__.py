"""Meshes: files of other formats become the .wrl files that Robotran draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import PassEntry, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion


def _are_there(conversion: Conversion, given: bool) -> bool:
    """Return True if the robot has meshes."""
    if given or conversion.meshes:
        return True
    from urdf2mbs.plugin import Mesh

    collisions = (shape for link in conversion.robot.links.values() for shape in link.collisions)
    return any(isinstance(shape.geometry, Mesh) for shape in collisions)


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    return [PassEntry("convert-meshes", "urdf2mbs_meshes", ("convert-visuals",), _are_there)]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    return {"warn_of_missing_meshes": "urdf2mbs_meshes.missing:warn_of_missing"}


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_meshes.codes import CODES

    return CODES
