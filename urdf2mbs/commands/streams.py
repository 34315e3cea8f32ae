"""The standard streams: ``-`` in place of a file."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path

from urdf2mbs.engine.output import write_files
from urdf2mbs.messages.diagnostics import ConfigError

#: What stands for standard input or output.
STREAM = "-"


def is_stream(file: Path | str | None) -> bool:
    """True if ``-`` stands in place of a file."""
    return str(file) == STREAM


@contextmanager
def saving(
    arguments: argparse.Namespace, to_stdout: bool
) -> Iterator[Callable[[Path, bytes], None]]:
    """Gives the function that writes a file.

    If the file goes to standard output, words go to standard error.
    """
    if not to_stdout:
        yield lambda path, data: write_files({path: data}, force=arguments.force)
        return
    if arguments.json:
        raise ConfigError("usage", "--json and the file cannot both go to standard output")
    output = sys.stdout

    def save(_: Path, data: bytes) -> None:
        output.flush()
        output.buffer.write(data)
        output.buffer.flush()

    with redirect_stdout(output if arguments.quiet else sys.stderr):
        yield save
