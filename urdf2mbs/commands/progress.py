"""Prints which pass a run is at."""

from __future__ import annotations

import argparse
import re
import sys
from threading import Event, Thread
from time import monotonic

from urdf2mbs.hookspecs import Pass, hookimpl


class Progress:
    """Watches pipelines, and prints on stderr which pass is running.

    A verbose run prints each pass with its time; any run prints a line when it takes long.

    Args:
        arguments: The options of the command: ``verbose``, ``quiet``.
    """

    PATIENCE = 2.0
    """The time between two lines on a terminal, in seconds."""
    LOG_PATIENCE = 10.0
    """The time between two lines in a log, in seconds."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self._verbose: bool = arguments.verbose
        self._quiet: bool = getattr(arguments, "quiet", False)
        self._pass_name = ""
        self._begin = monotonic()
        """When the pass began."""
        self.ended = Event()
        """Set when the run is done."""
        self._printer: Thread | None = None
        self.at = ""
        """The text of the next line."""

    def __enter__(self) -> Progress:
        if not self._quiet:
            self._printer = Thread(target=self.print_lines, daemon=True)
            self._printer.start()
        return self

    def __exit__(self, *_: object) -> None:
        """End the thread before the command prints its result."""
        self.ended.set()
        if self._printer is not None:
            self._printer.join()

    def say(self, text: str) -> None:
        """Print a line now, unless the run is quiet."""
        if not self._quiet:
            print(f"... {text}", file=sys.stderr)

    def print_lines(self) -> None:
        """Print what the run is at, again and again until it has ended."""
        is_terminal = sys.__stderr__ is not None and sys.__stderr__.isatty()
        previous_text, waited = "", 0.0
        interval = self.PATIENCE if is_terminal else self.LOG_PATIENCE
        while not self.ended.wait(interval):
            text = self.at
            waited = waited + interval if text == previous_text else 0.0
            print(f"... {text}, for {waited:.0f} s" if waited else f"... {text}", file=sys.stderr)
            previous_text = text

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass) -> None:
        """Remember the name of the pass."""
        self._pass_name = self.at = pass_.name
        self._begin = monotonic()

    @hookimpl
    def urdf2mbs_progress(self, text: str) -> None:
        """Remember what the pass is doing; estimate its end from a text with ``(3 of 48)``."""
        self.at = f"{self._pass_name}: {text}"
        count = re.search(r"\((\d+) of (\d+)\)", text)
        if count:
            self.at += estimate_end(int(count[1]) - 1, int(count[2]), monotonic() - self._begin)

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, seconds: float) -> None:
        """Print the time of the pass, if the run is verbose."""
        if self._verbose:
            print(f"{1000 * seconds:9.2f} ms  {pass_.name}", file=sys.stderr)


def estimate_end(done: float, total: float, elapsed: float) -> str:
    """Return the end of a message that says how long something still takes.

    Args:
        done: What is done, in any unit.
        total: What there is to do.
        elapsed: How long it took until now (s).
    """
    if done <= 0 or elapsed < 1.0:  # too early to tell
        return ""
    return f", about {elapsed * (total / done - 1.0):.0f} s to go"
