"""Mesh files converted on all cores: what each gives comes in the order of the files.

The other processes are started by hand.  Those of ``multiprocessing`` import the script that was
started first, which not every script is made for.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import IO, Any, TypeVar

from urdf2mbs.cores import cores
from urdf2mbs.meshes.model import MeshError

#: So many bytes of mesh files are worth a process: they take a second or two, and so does a start
#: on a machine that is busy.
WORTH = 48 * 2**20

_Task = TypeVar("_Task")
_Result = TypeVar("_Result")

_START = "import sys; sys.path[:] = sys.argv[1:]; from urdf2mbs.meshes.cores import serve; serve()"


def in_order(
    work: Callable[[_Task], _Result], tasks: Sequence[_Task], sizes: Sequence[int]
) -> Iterator[Callable[[], _Result]]:
    """For each task in turn a function that gives what ``work`` makes of it, or raises MeshError.

    ``work`` is a function of a module; ``sizes`` are those of the files (bytes), by which it is
    decided how many processes pay.  Each has one file in memory at a time, and at most two results
    for each lie ready.  With one process, a task is carried out when its function is called.
    """
    count = min(len(tasks), sum(sizes) // WORTH)
    if count < 2 or (count := min(count, _cores())) < 2:
        for task in tasks:
            yield _here(work, task)
        return
    from concurrent.futures import Future, ThreadPoolExecutor
    from queue import SimpleQueue

    free: SimpleQueue[_Process] = SimpleQueue()
    processes = [_Process() for _ in range(count)]
    for process in processes:
        free.put(process)

    def elsewhere(task: _Task) -> Callable[[], _Result]:
        process = free.get()
        try:
            return process.ask(work, task)
        finally:
            free.put(process)

    waiting: deque[Future[Callable[[], _Result]]] = deque()
    pool = ThreadPoolExecutor(count)
    try:
        for task in tasks:
            waiting.append(pool.submit(elsewhere, task))
            if len(waiting) > 2 * count:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        for process in processes:
            process.end()
        pool.shutdown(cancel_futures=True)


def _here(work: Callable[[_Task], _Result], task: _Task) -> Callable[[], _Result]:
    return lambda: work(task)


def _cores() -> int:
    """How many cores there are for this conversion: one where many are under way."""
    from multiprocessing import parent_process

    return cores() if parent_process() is None else 1


class _Process:
    """Another process, which converts one mesh after the other."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", _START, *map(os.path.abspath, sys.path)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip

    def ask(self, work: Callable[[Any], Any], task: Any) -> Callable[[], Any]:
        """What the process answers; where it cannot, the task is carried out here."""
        try:
            assert self._process.stdin is not None
            assert self._process.stdout is not None
            pickle.dump((work, task), self._process.stdin)
            self._process.stdin.flush()
            said, value = pickle.load(self._process.stdout)
        except (OSError, EOFError, ValueError, pickle.PickleError):
            return _here(work, task)
        if said == "made":
            return lambda: value
        if said == "mesh-error":
            return lambda: _fail(value)
        return _here(work, task)

    def end(self) -> None:
        self._process.kill()
        for stream in (self._process.stdin, self._process.stdout):
            assert stream is not None
            with suppress(OSError):
                stream.close()
        self._process.wait()


def _fail(message: str) -> Any:
    raise MeshError(message)


def serve() -> None:
    """What the other process does, until its input ends."""
    out: IO[bytes] = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # nothing that a library prints is part of an answer
    answer: tuple[str, Any]
    while True:
        try:
            work, task = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        try:
            answer = "made", work(task)
        except MeshError as error:
            answer = "mesh-error", str(error)
        except Exception:  # which is raised again where it can be told
            answer = "failed", None
        pickle.dump(answer, out)
        out.flush()
