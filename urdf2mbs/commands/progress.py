"""Where a run is, told while it lasts."""

from __future__ import annotations

import argparse
import sys
from _thread import allocate_lock, start_new_thread  # threading takes long to import

from urdf2mbs.engine.hookspecs import Pass, hookimpl
from urdf2mbs.engine.pipeline import Pipeline


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

    def follow(self, pipeline: Pipeline) -> None:
        """Tell of the runs of a pipeline."""
        pipeline.tell = self._is_at
        if self._verbose:
            pipeline.watch(self)

    def _is_at(self, text: str) -> None:
        self._at = text

    def _speak(self) -> None:
        while not self._lasts.acquire(timeout=self.PATIENCE):
            print(f"... {self._at}", file=sys.stderr)

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, seconds: float) -> None:
        print(f"{1000 * seconds:9.2f} ms  {pass_.name}", file=sys.stderr)
