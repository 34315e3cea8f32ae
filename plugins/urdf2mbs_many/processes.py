"""Run jobs in several processes.

``ProcessPoolExecutor`` breaks when the system ends one of its processes (out of memory, mostly).
Here only the jobs that were in the pool then are run again, each in a pool of its own.
"""

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

from urdf2mbs_many.job import Job, Outcome, convert_one, make_death


def run_in_processes(jobs: Sequence[Job], n_processes: int) -> Generator[Outcome]:
    """Run jobs in some processes.

    Jobs that were lost with a process are run again when all others are done, one at a time: then
    there is more memory.  A job that is lost twice has failed.

    Yields:
        Each outcome as soon as its job is done.
    """
    job_queue, lost_jobs = deque(jobs), list[Job]()
    while job_queue:
        lost_jobs += yield from _run_pool(job_queue, n_processes)
    for job in lost_jobs:
        for _ in (yield from _run_pool(deque([job]), 1)):
            yield make_death(job)


def _run_pool(job_queue: deque[Job], n_processes: int) -> Generator[Outcome, None, list[Job]]:
    """Run jobs from a queue until it is empty or the pool breaks.

    Returns:
        The jobs that were lost when the pool broke.

    Yields:
        Each outcome as soon as its job is done.
    """
    processes_before = multiprocessing.active_children()
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(n_processes, mp_context=context, initializer=_start_worker)
    running: dict[Future[Outcome], Job] = {}
    try:
        while job_queue or running:
            while job_queue and len(running) < 2 * n_processes:  # so that a broken pool loses few
                with _hide_main_script():
                    future = pool.submit(convert_one, job_queue[0])
                running[future] = job_queue.popleft()
            completed_futures, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in completed_futures:
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
                if process not in processes_before:
                    process.terminate()
    return [*running.values()]


@contextmanager
def _hide_main_script() -> Iterator[None]:
    """Start processes that do not import the running script.

    A script without ``if __name__ == "__main__":`` would convert its robots in each process again.
    """
    main_script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main_script


def _start_worker() -> None:
    """Prepare a process of the pool.

    Ctrl-C in a terminal reaches all processes: the main process ends its workers, and no worker
    outlives it.  What a library prints goes to standard error.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(2, 1)
    Thread(target=_exit_with_parent, daemon=True).start()


def _exit_with_parent() -> None:
    """Wait for the main process to end, then exit."""
    parent_process = multiprocessing.parent_process()
    if parent_process is not None:
        parent_process.join()
        os._exit(1)
