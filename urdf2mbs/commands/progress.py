"""Prints where a run is."""

from __future__ import annotations

import argparse
import re
import sys
from threading import Event, Thread

from urdf2mbs.hookspecs import Pass, hookimpl


class Progress:
    """Watches pipelines, and prints on stderr where a run is.

    A verbose run prints each pass with its time; any run prints a line when it takes long.
    """

    PATIENCE = 2.0
    """Seconds between two lines."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self._verbose: bool = arguments.verbose
        self._quiet: bool = getattr(arguments, "quiet", False)
        self._pass = ""
        self._over = Event()
        self.at = ""
        """The text of the next line."""

    def __enter__(self) -> Progress:
        if not self._quiet:
            Thread(target=self._speak, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()

    def say(self, text: str) -> None:
        """Print a line now, unless the run is quiet."""
        if not self._quiet:
            print(f"... {text}", file=sys.stderr)

    def _speak(self) -> None:
        last = ""
        while not self._over.wait(self.PATIENCE):
            # lines stay where there is no terminal: those that differ by numbers alone are one
            text = re.sub(r"[\d.]+", "", self.at)
            if text != last or (sys.__stderr__ is not None and sys.__stderr__.isatty()):
                print(f"... {self.at}", file=sys.stderr)
            last = text

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass) -> None:
        self._pass = self.at = pass_.name

    @hookimpl
    def urdf2mbs_progress(self, text: str) -> None:
        self.at = f"{self._pass}: {text}"

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, seconds: float) -> None:
        if self._verbose:
            print(f"{1000 * seconds:9.2f} ms  {pass_.name}", file=sys.stderr)
