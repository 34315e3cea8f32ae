"""Search the robot's files for what is written in one place: xacro's messages have no lines."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from urdf2mbs.urdf.written import NAME, text

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

_DECLARED = re.compile(r"""<xacro:arg\s([^<>]*)""")


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


def arguments(names: Iterable[str]) -> list[str]:
    """The arguments that files declare."""
    declared = (NAME.search(tag) for file in names for tag in _DECLARED.findall(text(file)))
    return list(dict.fromkeys(name[1] for name in declared if name))
