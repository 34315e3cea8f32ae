"""Search the robot's files for the declaration of a name: the text that xacro made has no lines."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.disk import files

if TYPE_CHECKING:
    from collections.abc import Iterable

#: The reader adds this to the name of a file that xacro has expanded.
EXPANDED = " (expanded)"
NAME_ATTRIBUTE = re.compile(r"""(?<!\S)name\s*=\s*["']([^"']+)["']""")
#: An expression of xacro in a name.
_EXPRESSION = re.compile(r"\$\{[^}]*\}|\$\([^)]*\)")
#: Longer names, and names of more parts, take too long to be compared.
_MAX_LETTERS, _MAX_PARTS = 200, 4


def read_text(file: str) -> str:
    """Return the text of a file; an empty one if it cannot be read."""
    try:
        return files.read_bytes(Path(file)).decode("utf-8", "replace")
    except (OSError, ValueError):
        return ""


def find_declaration(kind: str, name: str, names: Iterable[str]) -> tuple[str, int] | None:
    """Return the file and line of an element's declaration, if there is only one.

    A name with an expression, such as ``${side}_knee``, may be the name if no declaration has
    exactly the name.

    Args:
        kind: The tag of the element, such as ``link``.
        name: The value of its attribute ``name``.
        names: The files.
    """
    exact, possible = [], []
    for file in names if 0 < len(name) <= _MAX_LETTERS else ():
        text = read_text(file)
        for tag in re.finditer(rf"<{kind}\s[^<>]*", text):
            declared = NAME_ATTRIBUTE.search(tag[0])
            if declared is None or (kind == "joint" and not re.search(r"\stype\s*=", tag[0])):
                continue  # a joint of a <transmission> has no type
            place = file, text.count("\n", 0, tag.start()) + 1
            parts = [re.escape(part) for part in _EXPRESSION.split(declared[1])]
            if declared[1] == name:
                exact.append(place)
            elif len(parts) <= _MAX_PARTS and re.fullmatch(".*".join(parts), name):
                possible.append(place)
    places = exact or possible
    return places[0] if len(places) == 1 else None


def locate(
    kind: str, name: str, names: Iterable[str], file: str, line: int | None
) -> tuple[str, int | None]:
    """Return the file and line of an element, in the files that a user has written.

    Args:
        kind: The tag of the element.
        name: Its name.
        names: The files from which xacro has made the text that was read.
        file: The name of that text; it ends with ``EXPANDED`` if xacro has made it.
        line: The line of the element in that text.
    """
    if not file.endswith(EXPANDED):
        return file, line
    return find_declaration(kind, name, names) or (file.removesuffix(EXPANDED), None)
