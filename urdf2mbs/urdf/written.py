"""Search the robot's files for the line of a name: xacro's messages have no lines."""

from __future__ import annotations

import os
import re
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.disk import standard_input

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

#: The most files, in as many folders, that are searched for a macro's definition.
_SEARCHED = 500
_DECLARED = re.compile(r"""<xacro:arg\s([^<>]*)""")
_NAME = re.compile(r"""(?<!\S)name\s*=\s*["']([^"']+)["']""")


def text(file: str) -> str:
    """The text of a file; empty where it cannot be read."""
    try:
        return standard_input.read(Path(file)).decode("utf-8", "replace")
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


def macro(name: str, folders: Iterable[Path]) -> str | None:
    """The .xacro file in some folders, or below them, that defines a macro."""
    begin = re.compile(r"<xacro:macro\s([^<>]*)")
    around = (file for folder in folders for file in _below(folder))
    for file in islice(around, _SEARCHED):
        if any(name in _NAME.findall(tag) for tag in begin.findall(text(file))):
            return file
    return None


def _below(folder: Path) -> Iterator[str]:
    """The .xacro files in a folder and, as far as it is not too large, below it."""
    for above, folders, names in islice(os.walk(folder), _SEARCHED):
        folders.sort()
        yield from (str(Path(above, name)) for name in sorted(names) if name.endswith(".xacro"))
