"""Work on all cores, by processes that do one task after the other.

The processes are started by hand, with ``sys.path`` as it is here.  Those of ``multiprocessing``
and of loky import modules from the working folder before our code runs, print a traceback for
Ctrl-C while they start, and all end where one does; ``multiprocessing`` also runs the user's script
again in each.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Generator, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

from urdf2mbs.machine import stopping

if TYPE_CHECKING:
    from concurrent.futures import Future

Task = TypeVar("Task")
Result = TypeVar("Result")

_START = (
    "import sys; sys.path[:] = sys.argv[1:]; from urdf2mbs.machine.processes import serve; serve()"
)

#: Seconds that a process has to take its unfinished files away.
PATIENCE = 5.0


class EndedError(Exception):
    """The process ended before it answered."""


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def each(
    work: Callable[[Task], Result], tasks: Iterable[Task], count: int
) -> Generator[tuple[Task, Future[Result]]]:
    """Each task and its result, as they are done by ``count`` processes.

    ``work`` is a function of a module, and raises what pickle can write.  Of a process that ends
    the one task that it had is an EndedError; a new process goes on with the others.
    """
    from concurrent.futures import ThreadPoolExecutor, as_completed

    pool = _Pool()
    with stopping.Unfinished(), ThreadPoolExecutor(count) as threads:
        running: dict[Future[Result], Task] = {
            threads.submit(pool.ask, work, task): task for task in tasks
        }
        try:
            for future in as_completed(list(running)):
                yield running.pop(future), future
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
            pool.end()


class _Pool:
    """A process for each thread; each is started when it is first needed."""

    def __init__(self) -> None:
        self._own = threading.local()
        self._started: list[subprocess.Popen[bytes]] = []
        self._ended = False
        self._lock = threading.Lock()

    def ask(self, work: Callable[[Any], Any], task: Any) -> Any:
        """The result of a task; raises what it raises, or EndedError."""
        process = getattr(self._own, "process", None)
        try:
            process = self._own.process = process or self._start()
            assert process.stdin is not None
            assert process.stdout is not None
            process.stdin.write(pickle.dumps((work, task)))
            process.stdin.flush()
            good, value = pickle.load(process.stdout)
        except (OSError, EOFError, pickle.UnpicklingError):
            if process is not None:
                process.terminate()
            self._own.process = None
            raise EndedError from None
        if not good:
            raise value
        return value

    def _start(self) -> subprocess.Popen[bytes]:
        """Another process.  Ctrl-C on a terminal does not reach it: it is ended from here."""
        with self._lock:
            if self._ended:
                raise EOFError
            process = subprocess.Popen(
                [sys.executable, "-c", _START, *map(os.path.abspath, filter(None, sys.path))],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True,
                creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            )  # fmt: skip
            self._started.append(process)
            return process

    def end(self) -> None:
        """End all processes."""
        with self._lock:
            self._ended = True
        for process in self._started:
            process.terminate()
        for process in self._started:
            with suppress(subprocess.TimeoutExpired):
                process.wait(PATIENCE)
            process.kill()
            with suppress(BrokenPipeError), process:  # which closes its pipes
                pass


def serve() -> None:
    """What the other process does, until its input ends."""
    stopping.end_on_signals(speaks=False)
    tasks, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)  # nothing that a library prints is part of an answer
    with suppress(EOFError, BrokenPipeError):
        while True:
            work, task = pickle.load(tasks)
            try:
                answer = pickle.dumps((True, work(task)))
            except Exception as error:
                answer = pickle.dumps((False, error))
            answers.write(answer)
            answers.flush()
