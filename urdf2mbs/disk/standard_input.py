"""A robot that comes from standard input: ``-`` on the command line."""

from __future__ import annotations

import sys
from errno import EBADF
from pathlib import Path

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConversionError

#: What messages call it, and the name of the file that it stands for, in the working folder.
NAME = "<stdin>"

_read: list[bytes] = []


def take() -> str:
    """Read all of standard input; gives the source that stands for it.

    :raises ConversionError: ``file-unreadable``
    """
    try:
        _read[:] = [data()]
    except OSError as error:
        raise ConversionError(
            "file-unreadable", f"cannot be read: {error.strerror}", file=NAME
        ) from None
    return NAME


def data() -> bytes:
    """All of standard input; raises OSError."""
    if sys.stdin is None:
        raise OSError(EBADF, "standard input is closed", NAME)
    stream = getattr(sys.stdin, "buffer", None)
    return sys.stdin.read().encode() if stream is None else files.read_stream(stream, NAME)


def stands_for(source: Path) -> bool:
    """True if standard input was read, and this is the name of its file."""
    return source.name == NAME and bool(_read)


def read(source: Path) -> bytes:
    """The bytes of a file, or of standard input; raises OSError and ValueError."""
    return _read[0] if stands_for(source) else files.read(source)
