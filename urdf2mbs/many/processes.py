"""Jobs on all cores."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from threading import Thread

from urdf2mbs.many.job import Job, Outcome, convert_one, died


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
                future = pool.submit(_work, left[0])
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


class _Process:
    """The state of a process of the pool."""

    busy = ended = False


def _work(job: Job) -> Outcome:
    _Process.busy = True
    try:
        return convert_one(job)
    finally:
        _Process.busy = False
        if _Process.ended:
            os._exit(1)


def _end(*_: object) -> None:
    """End this process; what is half written is undone first."""
    if not _Process.busy:
        os._exit(1)
    _Process.ended = True
    raise KeyboardInterrupt


def _begin() -> None:
    """Prepare a process of the pool.

    Ctrl-C on a terminal reaches all processes: the first one ends the others, and none outlives
    the first.  What a library prints goes to standard error.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end)
    os.dup2(2, 1)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
