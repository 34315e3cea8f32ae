"""Prints which pass a run is at."""

from __future__ import annotations

import argparse
import re
import sys
from threading import Event, Thread

from urdf2mbs.hookspecs import Pass, hookimpl


class Progress:
    """Watches pipelines, and prints on stderr which pass is running.

    A verbose run prints each pass with its time; any run prints a line when it takes long.

    Args:
        arguments: The options of the command: ``verbose``, ``quiet``.
    """

    PATIENCE = 2.0
    """The time between two lines, in seconds."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self._verbose: bool = arguments.verbose
        self._quiet: bool = getattr(arguments, "quiet", False)
        self._pass_name = ""
        self._ended = Event()
        self.at = ""
        """The text of the next line."""

    def __enter__(self) -> Progress:
        if not self._quiet:
            Thread(target=self._print_lines, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()

    def say(self, text: str) -> None:
        """Print a line now, unless the run is quiet."""
        if not self._quiet:
            print(f"... {text}", file=sys.stderr)

    def _print_lines(self) -> None:
        previous_text = ""
        while not self._ended.wait(self.PATIENCE):
            # a log shows one line for texts that differ only by their numbers
            text_without_numbers = re.sub(r"[\d.]+", "", self.at)
            if text_without_numbers != previous_text or (
                sys.__stderr__ is not None and sys.__stderr__.isatty()
            ):
                print(f"... {self.at}", file=sys.stderr)
            previous_text = text_without_numbers

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass) -> None:
        """Remember the name of the pass."""
        self._pass_name = self.at = pass_.name

    @hookimpl
    def urdf2mbs_progress(self, text: str) -> None:
        """Remember what the pass is doing."""
        self.at = f"{self._pass_name}: {text}"

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, seconds: float) -> None:
        """Print the time of the pass, if the run is verbose."""
        if self._verbose:
            print(f"{1000 * seconds:9.2f} ms  {pass_.name}", file=sys.stderr)
