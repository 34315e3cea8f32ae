"""Jobs on all cores."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from threading import Thread
from types import ModuleType

from urdf2mbs_many.job import Job, Outcome, convert_one, died


def in_processes(jobs: Sequence[Job], count: int) -> Generator[Outcome]:
    """Each outcome as it comes, from ``count`` processes.

    Where the system ends a process, the pool ends.  The jobs that were in it are tried again, each
    by itself, when all others are done: then there is more memory.
    """
    left, lost = deque(jobs), list[Job]()
    while left:
        lost += yield from _in_pool(left, count)
    for job in lost:
        for _ in (yield from _in_pool(deque([job]), 1)):
            yield died(job)


def _in_pool(left: deque[Job], count: int) -> Generator[Outcome, None, list[Job]]:
    """Take jobs from ``left`` until the pool ends; gives the jobs that were lost with it."""
    others = multiprocessing.active_children()
    spawn = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, mp_context=spawn, initializer=_begin)
    running: dict[Future[Outcome], Job] = {}
    try:
        while left or running:
            while left and len(running) < 2 * count:  # few are lost with the pool
                with _without_script():
                    future = pool.submit(convert_one, left[0])
                running[future] = left.popleft()
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                outcome = future.result()
                del running[future]
                yield outcome
        pool.shutdown()
    except BrokenProcessPool:
        pass
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        if running:
            for process in multiprocessing.active_children():
                if process not in others:
                    process.terminate()
    return [*running.values()]


@contextmanager
def _without_script() -> Iterator[None]:
    """Within it, a new process does not import the script that is running.

    A script without ``if __name__ == "__main__":`` would convert its robots in each process again.
    """
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


def _begin() -> None:
    """Prepare a process of the pool.

    Ctrl-C on a terminal reaches all processes: the first one ends the others, and none outlives
    the first.  What a library prints goes to standard error.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(2, 1)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
