"""The base of the next merge: what was written last, beside the .mbs as ``NAME.mbs.base``.

Its seal is its checksum; a line before it says of which robot it was made.
"""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs.disk import files, standard_input
from urdf2mbs.disk.seal import intact, unseal

_LINE = "<!-- the base of the next merge, made of robot '{}' in {}, sha256 {} -->\n"
_MADE_OF = r"<!-- the base of .*, made of robot '(.*)' in (.*), sha256 \w+.*-->\n\Z"


def path(output: Path) -> Path:
    """Where the base of an .mbs is."""
    return output.with_name(f"{output.name}.base")


def text(data: bytes, robot: str, source: Path) -> bytes:
    """The base that is an .mbs, made of a robot in a URDF or xacro file."""
    from hashlib import sha256

    made_of = [text.replace("--", "- -") for text in (robot, source.name)]
    line = _LINE.format(*made_of, sha256(standard_input.read(source)).hexdigest())
    return unseal(data) + line.encode("utf-8", "replace")


def read(output: Path) -> bytes | None:
    """The base of an .mbs; None where there is none, or where somebody changed it."""
    there = path(output)
    data = files.read(there) if files.is_file(there) else b""
    return unseal(data) if intact(data) else None


def is_of(base: bytes, robot: str, source: Path) -> bool:
    """Whether a base was made of this robot, or of this file."""
    made_of = re.search(_MADE_OF, base.decode("utf-8", "replace"))
    names = [text.replace("--", "- -") for text in (robot, source.name)]
    return made_of is not None and (made_of[1] == names[0] or made_of[2] == names[1])
