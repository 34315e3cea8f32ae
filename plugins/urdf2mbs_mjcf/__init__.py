"""Robots of MuJoCo: an MJCF is compiled by MuJoCo itself, and read as a URDF."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.plugin import PassEntry, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion, Expansion, Packages

#: The beginning of an MJCF.  URDFs have <mujoco>, too, but not as their root.
_ROOT = re.compile(rb"(?s)(\xef\xbb\xbf)?(\s|<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>]*>)*<mujoco[\s>/]")


@hookimpl
def urdf2mbs_read(source: Path, data: bytes, packages: Packages, trust: bool) -> Expansion | None:
    """Read an MJCF, with all files that it includes."""
    if not _ROOT.match(data):
        return None
    from urdf2mbs_mjcf.reader import read

    return read(source, data, packages, trust=trust)


def _is_mjcf(conversion: Conversion, given: bool) -> bool:
    """Return True if the robot was read by this plugin."""
    return given or any(kind.__module__ == "urdf2mbs_mjcf.model" for kind in conversion.states)


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    """Return the pass that compares the robot with MuJoCo's."""
    return [PassEntry("compare-mujoco", "urdf2mbs_mjcf", after=("expand",), work=_is_mjcf)]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of this plugin's messages."""
    from urdf2mbs_mjcf.codes import CODES

    return CODES
