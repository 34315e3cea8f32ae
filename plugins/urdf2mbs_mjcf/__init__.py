"""Robots of MuJoCo: an MJCF is compiled by MuJoCo itself, and read as a URDF."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.plugin import PassEntry, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion, Expansion, Packages

#: What may come before the root element of an XML file: its beginning, and its end.
_BEFORE_ROOT = {b"<?": b"?>", b"<!--": b"-->", b"<!DOCTYPE": b">"}
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_SPACE = re.compile(rb"\s*")


@hookimpl
def urdf2mbs_read(source: Path, data: bytes, packages: Packages, trust: bool) -> Expansion | None:
    """Read an MJCF, with all files that it includes."""
    if not is_mjcf(data):
        return None
    from urdf2mbs_mjcf.reader import read

    return read(source, data, packages, trust=trust)


def is_mjcf(data: bytes) -> bool:
    """Return True if the root element of an XML file is ``<mujoco>``.

    URDFs have such an element, too, but not as their root.
    """
    if b"<mujoco" not in data:
        return False
    position = _find_element(data, len(_BYTE_ORDER_MARK) * data.startswith(_BYTE_ORDER_MARK))
    while beginning := next(
        (each for each in _BEFORE_ROOT if data.startswith(each, position)), b""
    ):
        ending = _BEFORE_ROOT[beginning]
        end = data.find(ending, position)
        if end < 0:
            return False
        position = _find_element(data, end + len(ending))
    return re.match(rb"<mujoco[\s>/]", data[position : position + 8]) is not None


def _find_element(data: bytes, position: int) -> int:
    """Return where the next element begins: after white space."""
    match = _SPACE.match(data, position)
    return position if match is None else match.end()


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
