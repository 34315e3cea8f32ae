"""A robot that comes from standard input: ``-`` on the command line."""

from __future__ import annotations

import sys
from pathlib import Path

#: What messages call it, and the name of the file that it stands for, in the working folder.
NAME = "<stdin>"

_read: list[bytes] = []


def take() -> str:
    """Read all of standard input; gives the source that stands for it."""
    stream = getattr(sys.stdin, "buffer", None)
    _read[:] = [stream.read() if stream is not None else sys.stdin.read().encode()]
    return NAME


def taken(source: Path) -> bytes | None:
    """The bytes of standard input, if a source stands for it."""
    return _read[0] if source.name == NAME and _read else None
