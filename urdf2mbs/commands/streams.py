"""The standard streams: ``-`` in place of a file."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path

from urdf2mbs.engine.output import write_files
from urdf2mbs.messages.diagnostics import ConfigError

#: The name of standard input or output on a command line.
STREAM = "-"


def is_stream(file: Path | str | None) -> bool:
    """Return whether a file's name is ``-``."""
    return str(file) == STREAM


@contextmanager
def saving(
    arguments: argparse.Namespace, to_stdout: bool
) -> Iterator[Callable[[Path, bytes], None]]:
    """Yield the function that writes a file.

    If the file goes to standard output, text goes to standard error.

    Args:
        arguments: The options of the command: ``force``, ``json``, ``quiet``.
        to_stdout: Whether the file goes to standard output.

    Raises:
        ConfigError: ``usage``, JSON and the file would both go to standard output.
    """
    if not to_stdout:
        yield lambda path, data: write_files({path: data}, force=arguments.force)
        return
    if arguments.json:
        raise ConfigError("usage", "--json and the file cannot both go to standard output")
    stdout = sys.stdout

    def save(_: Path, data: bytes) -> None:
        stdout.flush()
        stdout.buffer.write(data)
        stdout.buffer.flush()

    with redirect_stdout(stdout if arguments.quiet else sys.stderr):
        yield save
