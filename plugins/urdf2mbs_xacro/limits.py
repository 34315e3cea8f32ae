"""The limits of an expansion: its time and memory, and the length of each value.

xacro, minidom and the evaluator are loops in Python.  A second thread watches them, and interrupts
the thread that expands by an exception (``PyThreadState_SetAsyncExc`` of CPython).  This costs the
expansion nothing, and works in each thread and on each system::

    expanding   |--- xacro ---------------- Interrupted
    watching        .   .   .   .   .   .  ^  time or memory exceeded

The exception arrives between two instructions of Python: a single call of C code is short, since
no text, list or number that it is given is longer than ``MAX_LENGTH``.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from urdf2mbs.plugin import ConversionError

if TYPE_CHECKING:
    from collections.abc import Callable

#: The CPU time of one expansion (s), or elapsed time on macOS and Windows; the largest robot known
#: takes 0.1 s.
MAX_TIME = 5.0
#: The memory by which the process may grow during one expansion (bytes).
MAX_MEMORY = 2 * 2**30
#: The letters and items of one value, each item of an item included.
MAX_LENGTH = 10**5
#: The bytes of one file.
MAX_FILE = 10 * 2**20
#: How often the time and memory are looked at (s).
INTERVAL = 0.05
#: An exception that was lost, as in a function that Python calls to delete an object, is raised
#: again after this time (s).
RETRY = 1.0

TRUST = "if you trust the robot's author: `trust_xacro: true` in the config, or --trust-xacro"


def too_large(message: str) -> ConversionError:
    """Return the error for a value or an expansion beyond the limits."""
    return ConversionError("xacro-too-large", message, hint=TRUST)


class Interrupted(BaseException):
    """The expansion has exceeded its time or memory; no ``except Exception`` stops it."""


class Watch:
    """A context in which the thread that enters it may take a limited time and memory.

    An ``Interrupted`` that arrives while the context is being left is raised from it: who catches
    it calls ``stop``.

    Raises:
        ConversionError: ``xacro-too-large``, on leaving.
    """

    def __init__(self) -> None:
        self.exceeded: str | None = None
        """The limit that was exceeded, in words."""
        self._finished = threading.Event()
        self._lock = threading.Lock()
        self._thread_id = threading.get_ident()
        self._watcher = threading.Thread(target=self._watch, name="xacro limits", daemon=True)

    def __enter__(self) -> None:
        self._clock = _make_clock(self._thread_id)
        self._end_time = self._clock() + MAX_TIME
        self._max_memory = _measure_memory() + MAX_MEMORY
        self._watcher.start()

    def __exit__(self, *_: object) -> Literal[False]:
        self.stop()
        if self.exceeded is not None:
            raise self.error() from None
        return False

    def stop(self) -> None:
        """End the watch: no exception arrives from here on."""
        with self._lock:
            self._finished.set()
        if self.exceeded is not None:
            _send_exception(self._thread_id, None)

    def error(self) -> ConversionError:
        """Return the error for the limit that was exceeded."""
        return too_large(f"the expansion takes more than {self.exceeded}")

    def _watch(self) -> None:
        """Interrupt the expansion once it has exceeded a limit, until it has ended."""
        wait_time = INTERVAL
        while not self._finished.wait(wait_time):
            # The thread cannot end while the lock is held, and its clock can be read.
            with self._lock:
                if self._finished.is_set():
                    return
                self.exceeded = self.exceeded or self._find_exceeded()
                if self.exceeded is not None:
                    _send_exception(self._thread_id, Interrupted)
                    wait_time = RETRY

    def _find_exceeded(self) -> str | None:
        """Return the limit that is exceeded; None if all is well."""
        if self._clock() > self._end_time:
            return f"{MAX_TIME:g} s of CPU time"
        if _measure_memory() > self._max_memory:
            return f"{MAX_MEMORY / 2**30:g} GiB of memory"
        return None


def _send_exception(thread_id: int, exception_type: type[BaseException] | None) -> None:
    """Raise an exception in a thread, or take back one that has not arrived there (None)."""
    import ctypes  # takes milliseconds, which few expansions need

    exception = None if exception_type is None else ctypes.py_object(exception_type)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread_id), exception)


def _make_clock(thread_id: int) -> Callable[[], float]:
    """Return a clock of the CPU time of a thread (s); a monotonic clock if a system has none."""
    if hasattr(time, "pthread_getcpuclockid"):
        return partial(time.clock_gettime, time.pthread_getcpuclockid(thread_id))
    return time.monotonic


def _measure_memory() -> int:
    """Return the memory of this process (bytes): its peak on macOS, 0 if it is not reported."""
    if sys.platform == "linux":
        page_count = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
        return int(page_count) * os.sysconf("SC_PAGE_SIZE")
    if sys.platform == "darwin":
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return 0
