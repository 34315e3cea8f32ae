"""The standard streams: ``-`` in place of a file, and ``--quiet``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import TextIO

from urdf2mbs.disk import files, standard_input
from urdf2mbs.disk.seal import seal
from urdf2mbs.messages.diagnostics import ConfigError

#: What stands for standard input or output.
STREAM = "-"


class Silent:
    """Standard output, of which words are dropped; a file may still be written to its bytes."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        return len(text)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


@contextmanager
def quiet(wanted: bool) -> Iterator[None]:
    """Within it no words go to standard output, if that is wanted."""
    plain = sys.stdout
    try:
        if wanted:
            sys.stdout = Silent(plain)
        yield
    finally:
        sys.stdout = plain


@contextmanager
def file_to_stdout(arguments: argparse.Namespace) -> Iterator[Callable[[bytes], None]]:
    """Within it words go to standard error; it gives what writes a file to standard output."""
    if arguments.json:
        raise ConfigError("usage", "--json and the file cannot both go to standard output")
    output = sys.stdout

    def write(data: bytes) -> None:
        output.flush()
        output.buffer.write(seal(Path(), data))
        output.buffer.flush()

    with redirect_stdout(output if arguments.quiet else sys.stderr):
        yield write


def read_model(model: Path) -> bytes:
    """The bytes of an .mbs file; raises ConfigError."""
    try:
        if str(model) == STREAM:
            return standard_input.data()
        return files.read(model)
    except OSError as error:
        raise ConfigError("model-unreadable", f"cannot read '{model}': {error.strerror}") from None
