"""What a terminal is shown: colours, and no control character that is not ours."""

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


class Shown:
    """A stream that is written to without control characters, and with colours if wanted.

    A name in a robot, or a file's name, may hold a sequence that clears the screen.
    """

    def __init__(self, stream: TextIO, coloured: bool) -> None:
        self._stream = stream
        self._coloured = coloured

    def write(self, text: str) -> int:
        return self._stream.write(self._shown(text))

    def rewrite(self, text: str) -> None:
        """Show a text in the place of the terminal's last line."""
        self._stream.write(f"\r\033[K{self._shown(text)}")
        self._stream.flush()

    def _shown(self, text: str) -> str:
        text = printable(text)
        if not self._coloured:
            return text
        text = re.sub(_LEVEL, lambda found: f"{_COLOURS[found[1]]}{found[1]}{_OFF}", text)
        text = re.sub(_OTHER, lambda found: f"{_RED}{found[0]}{_OFF}", text)
        return re.sub(_SAME, lambda found: f"{_GREEN}{found[0]}{_OFF}", text)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


@contextmanager
def shown(colours: str = "auto") -> Iterator[None]:
    """Within it, standard output and error show no foreign control character, and have colours:
    ``auto``, ``always`` or ``never``.

    ``auto`` is where they are terminals; there ``NO_COLOR`` (https://no-color.org) and
    ``TERM=dumb`` switch colours off.
    """
    plain = sys.stdout, sys.stderr
    wanted = not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    if os.name == "nt" and "WT_SESSION" not in os.environ:
        wanted = False  # the old console shows the codes
    always = colours == "always"
    try:
        sys.stdout, sys.stderr = (
            Shown(stream, always or (wanted and colours == "auto" and stream.isatty()))
            for stream in plain
        )
        yield
    finally:
        sys.stdout, sys.stderr = plain
