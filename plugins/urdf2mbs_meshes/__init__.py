"""Meshes: files of other formats become the .wrl files that Robotran draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import PassEntry, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion


def _has_meshes(conversion: Conversion, has_options: bool) -> bool:
    """Return True if the robot has meshes, or the config has options for them."""
    if has_options or conversion.meshes:
        return True
    from urdf2mbs.plugin import Mesh

    collisions = (shape for link in conversion.robot.links.values() for shape in link.collisions)
    return any(isinstance(shape.geometry, Mesh) for shape in collisions)


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    """Return the pass of this plugin, which comes after ``convert-visuals``."""
    return [PassEntry("convert-meshes", "urdf2mbs_meshes", ("convert-visuals",), _has_meshes)]


@hookimpl
def urdf2mbs_find_faults(conversion: Conversion) -> None:
    """Warn of the meshes that are not found."""
    from urdf2mbs_meshes.missing import warn_of_missing_meshes

    warn_of_missing_meshes(conversion)


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of messages with their meanings."""
    from urdf2mbs_meshes.codes import CODES

    return CODES
