"""Many conversions on the cores of this machine."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from itertools import islice
from multiprocessing import current_process
from typing import TYPE_CHECKING

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.many.convert import Job, Outcome, convert_one, died

if TYPE_CHECKING:
    from concurrent.futures import Future, ProcessPoolExecutor

#: So many jobs lie ready for each process.
AHEAD = 4


def in_processes(jobs: list[Job], workers: int) -> Iterator[Outcome]:
    """Each outcome as it comes.

    A process that is ended by the system takes its pool with it.  The jobs that were under way
    are then tried again, each in a process of its own; the others go on in a new pool.
    """
    workers = min(workers, len(jobs))
    if workers <= 1:
        yield from map(convert_one, jobs)
        return
    if getattr(current_process(), "_inheriting", False):
        raise ConfigError(
            "usage", "each process that converts robots reads this script anew, and so on",
            hint="put what the script does below:  if __name__ == '__main__':",
        )  # fmt: skip
    from concurrent.futures import FIRST_COMPLETED, wait
    from concurrent.futures.process import BrokenProcessPool

    todo = iter(jobs)
    pool = _pool(workers)
    running: dict[Future[Outcome], Job] = {}
    try:
        while True:
            suspects: list[Job] = []
            try:
                for job in islice(todo, workers * AHEAD - len(running)):
                    suspects = [job]
                    running[pool.submit(_carry_out, job)] = job
                suspects = []
            except BrokenProcessPool:
                pass
            if not running and not suspects:
                return
            done = wait(running, return_when=FIRST_COMPLETED).done if running else set()
            for future in done:
                job = running.pop(future)
                if isinstance(future.exception(), BrokenProcessPool):
                    suspects.append(job)
                else:
                    yield future.result()
            if suspects:
                for future, job in running.items():
                    if isinstance(future.exception(), BrokenProcessPool):
                        suspects.append(job)
                    else:
                        yield future.result()
                running.clear()
                pool.shutdown()
                for job in suspects:
                    yield _alone(job)
                pool = _pool(workers)
    finally:
        pool.shutdown(cancel_futures=True)


def _alone(job: Job) -> Outcome:
    """The outcome of a job in a process that does nothing else."""
    from concurrent.futures.process import BrokenProcessPool

    with _pool(1) as pool:
        try:
            return pool.submit(_carry_out, job).result()
        except BrokenProcessPool:
            return died(job)


def _pool(workers: int) -> ProcessPoolExecutor:
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    # a fork would copy whatever threads and locks the caller has
    return ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _begin)


class _State:
    """Of this process, if it is one of a pool."""

    busy = False
    ending = False


def _begin() -> None:
    """Let a process of the pool end as it should: without half a job, and not after its parent."""
    import threading

    # Ctrl-C is for the process that was started by hand, which ends the others
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a pool that lost one process ends the others by this signal
    signal.signal(signal.SIGTERM, _end)
    threading.Thread(target=_follow_parent, daemon=True).start()


def _end(*_: object) -> None:
    if not _State.busy:
        os._exit(0)
    _State.ending = True


def _follow_parent() -> None:
    from multiprocessing import parent_process

    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _carry_out(job: Job) -> Outcome:
    _State.busy = True
    try:
        return convert_one(job)
    finally:
        _State.busy = False
        if _State.ending:
            os._exit(0)
