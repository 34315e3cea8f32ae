"""Search the robot's files for the line of a name: xacro's messages have no lines."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.disk import files

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

_DECLARED = re.compile(r"""<xacro:arg\s([^<>]*)""")
_NAME = re.compile(r"""(?<!\S)name\s*=\s*["']([^"']+)["']""")


def text(file: str) -> str:
    """The text of a file; empty where it cannot be read."""
    try:
        return files.read(Path(file)).decode("utf-8", "replace")
    except (OSError, ValueError):
        return ""


def locate(texts: Iterable[str], names: Sequence[str]) -> tuple[str, int] | None:
    """The file and line of the first of the texts that stands on one line only."""
    for wanted in texts:
        for file in names:
            lines = [
                number for number, line in enumerate(text(file).splitlines(), 1) if wanted in line
            ]
            if len(lines) == 1:
                return file, lines[0]
            if lines:
                break
    return None


def place(kind: str, name: str, names: Iterable[str]) -> tuple[str, int] | None:
    """The file and line of a link, say, where only one place has it."""
    begin = re.compile(rf"""<{kind}\s[^<>]*""")
    places = [
        (file, found.count("\n", 0, tag.start()) + 1)
        for file, found in ((file, text(file)) for file in names if name)
        for tag in begin.finditer(found)
        if name in _NAME.findall(tag[0])
    ]
    return places[0] if len(places) == 1 else None


def element(kind: str, name: str, names: Iterable[str]) -> str | None:
    """A hint that names the file and line of a link, say, where only one place has it."""
    found = place(kind, name, names)
    return f"{kind} '{name}' is in {found[0]}:{found[1]}" if found else None


def arguments(names: Iterable[str]) -> list[str]:
    """The arguments that files declare."""
    declared = (_NAME.search(tag) for file in names for tag in _DECLARED.findall(text(file)))
    return list(dict.fromkeys(name[1] for name in declared if name))
