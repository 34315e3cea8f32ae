"""Search the robot's files for the line of a name: what xacro expanded has no lines."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.disk import files

if TYPE_CHECKING:
    from collections.abc import Iterable

NAME = re.compile(r"""(?<!\S)name\s*=\s*["']([^"']+)["']""")


def text(file: str) -> str:
    """The text of a file; empty where it cannot be read."""
    try:
        return files.read(Path(file)).decode("utf-8", "replace")
    except (OSError, ValueError):
        return ""


def place(kind: str, name: str, names: Iterable[str]) -> tuple[str, int] | None:
    """The file and line of a link, say, where only one place has it."""
    begin = re.compile(rf"""<{kind}\s[^<>]*""")
    places = [
        (file, found.count("\n", 0, tag.start()) + 1)
        for file, found in ((file, text(file)) for file in names if name)
        for tag in begin.finditer(found)
        if name in NAME.findall(tag[0])
    ]
    return places[0] if len(places) == 1 else None


def element(kind: str, name: str, names: Iterable[str]) -> str | None:
    """A hint that names the file and line of a link, say, where only one place has it."""
    found = place(kind, name, names)
    return f"{kind} '{name}' is in {found[0]}:{found[1]}" if found else None
