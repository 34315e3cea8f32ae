"""What a terminal gets: colours, and no control character that is not ours."""

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
_LEVEL = r"\b(error|warning|note)(?=\[[a-z0-9-]+\])"
_SAME = r"(?<!NOT )\bthe same robot\b"
_OTHER = r"\bNOT (?:the same robot|CHECKED)\b"


class Screen:
    """A stream that gets words without control characters, and with colours if wanted.

    A name in a robot, or a file's name, may hold a sequence that clears the screen.  A silent
    stream drops words; a file may still be written to its bytes.
    """

    def __init__(self, stream: TextIO, coloured: bool, silent: bool = False) -> None:
        self._stream = stream
        self._coloured = coloured
        self._silent = silent

    def write(self, text: str) -> int:
        return len(text) if self._silent else self._stream.write(self._clean(text))

    def _clean(self, text: str) -> str:
        text = printable(text)
        if not self._coloured:
            return text
        text = re.sub(_LEVEL, lambda match: f"{_COLOURS[match[1]]}{match[1]}{_OFF}", text)
        text = re.sub(_OTHER, lambda match: f"{_RED}{match[0]}{_OFF}", text)
        return re.sub(_SAME, lambda match: f"{_GREEN}{match[0]}{_OFF}", text)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


@contextmanager
def screens(colours: str = "auto", *, quiet: bool = False) -> Iterator[None]:
    """Within it, standard output and error are screens; ``quiet`` silences standard output.

    ``colours`` are ``always``, ``never``, or ``auto``: on terminals.  There ``NO_COLOR``
    (https://no-color.org) and ``TERM=dumb`` switch colours off.
    """
    plain = sys.stdout, sys.stderr
    wanted = not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    if os.name == "nt" and "WT_SESSION" not in os.environ:
        wanted = False  # the old console shows the codes
    coloured = [
        colours == "always" or (wanted and colours == "auto" and stream.isatty())
        for stream in plain
    ]
    try:
        sys.stdout = Screen(plain[0], coloured[0], quiet)
        sys.stderr = Screen(plain[1], coloured[1])
        yield
    finally:
        sys.stdout, sys.stderr = plain
