"""Colours on a terminal, and none elsewhere."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

_RED, _YELLOW, _CYAN, _GREEN, _OFF = (f"\033[{n}m" for n in ("1;31", "1;33", "36", "32", "0"))
_COLOURS = {"error": _RED, "warning": _YELLOW, "note": _CYAN}
_LEVEL = re.compile(r"\b(error|warning|note)(?=\[[a-z0-9-]+\])")
_SAME = re.compile(r"(?<!NOT )\bthe same robot\b")
_OTHER = re.compile(r"\bNOT (?:the same robot|THE SAME ROBOT)")


class Coloured:
    """A terminal that is written to with colours."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        text = _LEVEL.sub(lambda found: f"{_COLOURS[found[1]]}{found[1]}{_OFF}", text)
        text = _OTHER.sub(lambda found: f"{_RED}{found[0]}{_OFF}", text)
        text = _SAME.sub(lambda found: f"{_GREEN}{found[0]}{_OFF}", text)
        return self._stream.write(text)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


@contextmanager
def colours(when: str = "auto") -> Iterator[None]:
    """Within it, standard output and error have colours: ``auto``, ``always`` or ``never``.

    ``auto`` is where they are terminals; there ``NO_COLOR`` (https://no-color.org) and
    ``TERM=dumb`` switch colours off.
    """
    plain = sys.stdout, sys.stderr
    wanted = not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    if os.name == "nt" and "WT_SESSION" not in os.environ:
        wanted = False  # the old console shows the codes
    try:
        if when != "never" and (wanted or when == "always"):
            sys.stdout, sys.stderr = (
                Coloured(stream) if when == "always" or stream.isatty() else stream
                for stream in plain
            )
        yield
    finally:
        sys.stdout, sys.stderr = plain
