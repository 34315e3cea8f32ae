"""The standard streams: ``-`` in place of a file."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path

from urdf2mbs.disk import files, standard_input
from urdf2mbs.disk.seal import seal
from urdf2mbs.messages.diagnostics import ConfigError

#: What stands for standard input or output.
STREAM = "-"


@contextmanager
def file_to_stdout(arguments: argparse.Namespace) -> Iterator[Callable[[bytes], None]]:
    """Within it words go to standard error; gives the function that writes a file to stdout."""
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
