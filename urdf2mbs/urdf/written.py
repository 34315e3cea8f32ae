"""Search the robot's files for the line of a name: what xacro expanded has no lines."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.disk import files

if TYPE_CHECKING:
    from collections.abc import Iterable

#: What the reader adds to the name of a file that xacro has expanded.
EXPANDED = " (expanded)"
#: What xacro computes in a name.
_EXPRESSION = re.compile(r"\$\{[^}]*\}|\$\([^)]*\)")
#: Longer names, and names of more parts, take too long to be compared.
_LONGEST, _MOST = 200, 4
NAME_ATTRIBUTE = re.compile(r"""(?<!\S)name\s*=\s*["']([^"']+)["']""")


def read_text(file: str) -> str:
    """The text of a file; empty where it cannot be read."""
    try:
        return files.read_bytes(Path(file)).decode("utf-8", "replace")
    except (OSError, ValueError):
        return ""


def find_declaration(kind: str, name: str, names: Iterable[str]) -> tuple[str, int] | None:
    """The file and line of a link, say, where only one place has it.

    A name with an expression, as ``${side}_knee``, is the name if no other place has the name.
    """
    exact, written = [], []
    for file in names if 0 < len(name) <= _LONGEST else ():
        found = read_text(file)
        for tag in re.finditer(rf"<{kind}\s[^<>]*", found):
            own = NAME_ATTRIBUTE.search(tag[0])
            if own is None or (kind == "joint" and not re.search(r"\stype\s*=", tag[0])):
                continue  # a joint of a <transmission> has no type
            at = file, found.count("\n", 0, tag.start()) + 1
            parts = [re.escape(part) for part in _EXPRESSION.split(own[1])]
            if own[1] == name:
                exact.append(at)
            elif len(parts) <= _MOST and re.fullmatch(".*".join(parts), name):
                written.append(at)
    places = exact or written
    return places[0] if len(places) == 1 else None


def locate(
    kind: str, name: str, names: Iterable[str], file: str, line: int | None
) -> tuple[str, int | None]:
    """The file and line of a link, say; no line of a text that is in no file."""
    if not file.endswith(EXPANDED):
        return file, line
    return find_declaration(kind, name, names) or (file.removesuffix(EXPANDED), None)
