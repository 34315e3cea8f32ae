"""The base of the next merge: what was written last, beside the .mbs as ``NAME.mbs.base``.

Its last line says of which robot it was made, and has the checksum of what stands before it.
"""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs.plugin import checksum, files

_BEGIN = "<!-- the base of the next merge, made of robot '"
_LAST = re.compile(rb"made of robot '(.*)' in (.*), sha256 ([0-9a-f]{64}) -->\s*\Z", re.DOTALL)


def path(output: Path) -> Path:
    """Where the base of an .mbs is."""
    return output.with_name(f"{output.name}.base")


def text(data: bytes, robot: str, source: str) -> bytes:
    """The base that is an .mbs, made of a robot in a URDF or xacro file."""
    made_of = f"{_plain(robot)}' in {_plain(source)}, sha256 {checksum(data)} -->\n"
    return data + f"{_BEGIN}{made_of}".encode("utf-8", "replace")


def read(output: Path) -> bytes | None:
    """The base of an .mbs; None where there is none, or where somebody changed it."""
    there = path(output)
    data = files.read_bytes(there) if files.is_file(there) else b""
    return data if is_base(data) else None


def is_base(data: bytes) -> bool:
    """True if this is a base, and nobody has changed it."""
    found, start = _last(data)
    return found is not None and found[3].decode() == checksum(data[:start])


def is_of(base: bytes, robot: str, source: str) -> bool:
    """Whether a base was made of this robot, or of this file."""
    found, _ = _last(base)
    names = [_plain(name).encode("utf-8", "replace") for name in (robot, source)]
    return found is not None and (found[1] == names[0] or found[2] == names[1])


def renewed(data: bytes) -> bytes:
    """A base that was changed on purpose, with its checksum."""
    found, start = _last(data)
    if found is None:
        return data
    return text(data[:start], found[1].decode(), found[2].decode())


def _last(data: bytes) -> tuple[re.Match[bytes] | None, int]:
    """The last line, and where it begins."""
    start = max(0, data.rfind(_BEGIN.encode()))
    return _LAST.search(data, start), start


def _plain(name: str) -> str:
    return name.replace("--", "- -")
