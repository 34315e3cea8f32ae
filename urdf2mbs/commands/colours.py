"""Output on a terminal: coloured, and without control characters that are not ours."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from urdf2mbs.messages.diagnostics import printable

_RED, _YELLOW, _CYAN, _GREEN, _OFF = (f"\033[{n}m" for n in ("1;31", "1;33", "36", "32", "0"))
_COLOURS = {"error": _RED, "warning": _YELLOW, "note": _CYAN}
_LEVEL = re.compile(r"\b(error|warning|note)(?=\[[a-z0-9-]+\])")
_SAME_ROBOT = re.compile(r"(?<!NOT )\bthe same robot\b")
_NOT_SAME_ROBOT = re.compile(r"\bNOT (?:the same robot|CHECKED)\b")


class CleanStream:
    """A stream that drops control characters, and adds colours.

    A name in a robot, or a file's name, may contain a sequence that clears the screen.

    Args:
        stream: The stream that is written to.
        coloured: Whether to add colours.
        silent: Whether to drop all text; bytes may still be written to ``buffer``.
    """

    def __init__(self, stream: TextIO, coloured: bool, silent: bool = False) -> None:
        self._stream = stream
        self._coloured = coloured
        self._silent = silent

    def write(self, text: str) -> int:
        """Write a text, and return the number of its characters."""
        return len(text) if self._silent else self._stream.write(self._clean(text))

    def _clean(self, text: str) -> str:
        text = printable(text)
        if not self._coloured:
            return text
        text = _LEVEL.sub(lambda match: f"{_COLOURS[match[1]]}{match[1]}{_OFF}", text)
        text = _NOT_SAME_ROBOT.sub(lambda match: f"{_RED}{match[0]}{_OFF}", text)
        return _SAME_ROBOT.sub(lambda match: f"{_GREEN}{match[0]}{_OFF}", text)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


@contextmanager
def clean_streams(colours: str = "auto", *, quiet: bool = False) -> Iterator[None]:
    """Replace standard output and error by clean streams.

    Args:
        colours: ``always``, ``never``, or ``auto``: on terminals, unless ``NO_COLOR``
            (https://no-color.org) or ``TERM=dumb`` is set.
        quiet: Whether to silence standard output.
    """
    streams = sys.stdout, sys.stderr
    coloured = [
        colours == "always" or (colours == "auto" and stream.isatty() and _allows_colours())
        for stream in streams
    ]
    try:
        sys.stdout = CleanStream(streams[0], coloured[0], quiet)
        sys.stderr = CleanStream(streams[1], coloured[1])
        yield
    finally:
        sys.stdout, sys.stderr = streams


def _allows_colours() -> bool:
    """Return whether the environment asks for no plain text, and the terminal knows colours."""
    if os.name == "nt" and "WT_SESSION" not in os.environ:
        return False  # the old console of Windows shows the codes
    return not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
