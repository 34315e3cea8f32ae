"""Where a run is, told while it lasts."""

from __future__ import annotations

import argparse
import sys
from _thread import allocate_lock, start_new_thread  # threading takes long to import

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass, hookimpl


class Progress:
    """Says on stderr where a run is: each pass with its time if asked, else only when it lasts."""

    PATIENCE = 2.0
    """Seconds of silence."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self._verbose: bool = arguments.verbose
        self._quiet: bool = getattr(arguments, "quiet", False)
        self._at = ""
        self._lasts = allocate_lock()

    def __enter__(self) -> Progress:
        if not self._quiet:
            self._lasts.acquire()
            start_new_thread(self._speak, ())
        return self

    def __exit__(self, *_: object) -> None:
        if not self._quiet:
            self._lasts.release()

    def _speak(self) -> None:
        while not self._lasts.acquire(timeout=self.PATIENCE):
            print(f"... {self._at}", file=sys.stderr)

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass, conversion: Conversion) -> None:
        self._at = pass_.name

        def progress(text: str) -> None:
            self._at = f"{pass_.name}: {text}"

        conversion.progress = progress

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, seconds: float) -> None:
        if self._verbose:
            print(f"{1000 * seconds:9.2f} ms  {pass_.name}", file=sys.stderr)
