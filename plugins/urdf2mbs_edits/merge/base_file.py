"""The base of the next merge: the .mbs as written last, saved beside it as ``NAME.mbs.base``.

Its last line is a comment: the robot that it was made of, and a checksum of all before it.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from urdf2mbs.plugin import checksum, files

_COMMENT_START = "<!-- the base of the next merge, made of robot '"
_COMMENT = re.compile(
    rb"made of robot '(?P<robot>.*)' in (?P<source>.*), sha256 (?P<checksum>[0-9a-f]{64}) -->\s*\Z",
    re.DOTALL,
)


class _Base(NamedTuple):
    """A base in parts."""

    data: bytes
    """The .mbs."""
    robot: bytes
    source: bytes
    """Name of the URDF or xacro file."""
    checksum: str


def get_base_path(output: Path) -> Path:
    """Return the path of the base of an .mbs."""
    return output.with_name(f"{output.name}.base")


def make_base(data: bytes, robot: str, source: str) -> bytes:
    """Make the base that is an .mbs.

    Args:
        data: The .mbs.
        robot: Name of the robot that it was made of.
        source: Name of the URDF or xacro file.
    """
    origin = f"{_escape(robot)}' in {_escape(source)}, sha256 {checksum(data)} -->\n"
    return data + f"{_COMMENT_START}{origin}".encode("utf-8", "replace")


def read_base(output: Path) -> bytes | None:
    """Read the base of an .mbs; None if there is no base, or if somebody changed it."""
    path = get_base_path(output)
    data = files.read_bytes(path) if files.is_file(path) else b""
    return data if is_base(data) else None


def is_base(data: bytes) -> bool:
    """Return whether a file is a base that nobody has changed."""
    base = _parse(data)
    return base is not None and base.checksum == checksum(base.data)


def is_made_of(data: bytes, robot: str, source: str) -> bool:
    """Return whether a base was made of a robot of this name, or of a file of this name."""
    base = _parse(data)
    robot_name, source_name = (_escape(name).encode("utf-8", "replace") for name in (robot, source))
    return base is not None and (base.robot == robot_name or base.source == source_name)


def renew_checksum(data: bytes) -> bytes:
    """Return a base that was changed on purpose with its new checksum."""
    base = _parse(data)
    if base is None:
        return data
    return make_base(base.data, base.robot.decode(), base.source.decode())


def _parse(data: bytes) -> _Base | None:
    """Split a base into its parts; None if it has no such comment at its end."""
    start = max(0, data.rfind(_COMMENT_START.encode()))
    comment = _COMMENT.search(data, start)
    if comment is None:
        return None
    return _Base(data[:start], comment["robot"], comment["source"], comment["checksum"].decode())


def _escape(name: str) -> str:
    """Return a name without two hyphens in a row, which XML does not allow in a comment."""
    return name.replace("--", "- -")
