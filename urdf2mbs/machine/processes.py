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
from collections.abc import Callable, Generator, Iterable
from contextlib import suppress
from threading import Lock
from typing import TYPE_CHECKING, Generic, TypeVar

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


class _State:
    """The state of this process."""

    serves = False


def cores() -> int:
    """How many cores this process may use: one where it is one of many at work."""
    if _State.serves:
        return 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def each(
    work: Callable[[Task], Result], tasks: Iterable[Task], count: int, *, in_order: bool = False
) -> Generator[tuple[Task, Future[Result]]]:
    """Each task and its result, as they are done, or in the order of the tasks.

    ``work`` is a function of a module, and raises what pickle can write.  Of a process that ends
    the one task that it had is an EndedError; a new process goes on with the others.  At most two
    tasks for each of the ``count`` processes are under way, or wait to be taken.
    """
    from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

    running: dict[Future[Result], Task] = {}
    last: list[tuple[Task, Future[Result]]] = []
    with stopping.Unfinished(), ThreadPoolExecutor(count) as threads, _Pool(work, count) as pool:
        coming = iter(tasks)
        more = True
        try:
            while not last:
                while more and len(running) < 2 * count:
                    task = next(coming, None)
                    more = task is not None
                    if task is not None:
                        running[threads.submit(pool.ask, task)] = task
                if not running:
                    break
                first = next(iter(running))
                done = wait([first] if in_order else running, return_when=FIRST_COMPLETED).done
                results = [(running.pop(future), future) for future in done]
                if running or more:
                    yield from results
                else:  # who asks for no more must not keep the pool
                    last = results
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
    yield from last


class _Pool(Generic[Task, Result]):
    """Processes that all do the same work; each is started when it is first needed."""

    def __init__(self, work: Callable[[Task], Result], count: int) -> None:
        from queue import SimpleQueue

        self._work = work
        self._free: SimpleQueue[subprocess.Popen[bytes] | None] = SimpleQueue()
        for _ in range(count):
            self._free.put(None)
        self._started: list[subprocess.Popen[bytes]] = []
        self._closed = False
        self._lock = Lock()

    def __enter__(self) -> _Pool[Task, Result]:
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._closed = True
        for process in self._started:
            process.terminate()
        for process in self._started:
            with suppress(subprocess.TimeoutExpired):
                process.wait(PATIENCE)
            process.kill()
            with suppress(BrokenPipeError), process:  # which closes its pipes
                pass

    def ask(self, task: Task) -> Result:
        """The result of a task; raises what it raises, or EndedError."""
        process = self._free.get()
        try:
            process = process or self._start()
            assert process.stdin is not None
            assert process.stdout is not None
            process.stdin.write(pickle.dumps((self._work, task)))
            process.stdin.flush()
            good, value = pickle.load(process.stdout)
        except (OSError, EOFError, pickle.UnpicklingError):
            if process is not None:
                process.terminate()
                process = None
            raise EndedError from None
        finally:
            self._free.put(process)
        if not good:
            raise value
        result: Result = value
        return result

    def _start(self) -> subprocess.Popen[bytes]:
        """Another process.  Ctrl-C on a terminal does not reach it: it is ended from here."""
        with self._lock:
            if self._closed:
                raise EOFError
            process = subprocess.Popen(
                [sys.executable, "-c", _START, *map(os.path.abspath, filter(None, sys.path))],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True,
                creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            )  # fmt: skip
            self._started.append(process)
            return process


def serve() -> None:
    """What the other process does, until its input ends."""
    stopping.end_on_signals(speaks=False)
    _State.serves = True
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
