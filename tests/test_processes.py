"""Several processes: no task is lost, and no process stays."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.machine import processes
from urdf2mbs.meshes.model import MeshError
from urdf2mbs.testing import TINY


def note_processes(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The processes that are started from now on."""
    started: list[Any] = []
    start = processes._Pool._start

    def noted(self: Any) -> Any:
        started.append(start(self))
        return started[-1]

    monkeypatch.setattr(processes._Pool, "_start", noted)
    return started


def double(number: int) -> int:
    if number == 3:
        raise MeshError("three")
    if number == 4:
        raise KeyError(number)
    if number == 5:
        os._exit(1)
    return 2 * number


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> Any:
    """``double``, of a module that another process can import."""
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parent), *sys.path])
    return __import__("test_processes").double


def test_each_task_has_its_result(work: Any) -> None:
    done = list(processes.each(work, range(20), 2))
    assert sorted(task for task, _ in done) == list(range(20))
    for task, future in done:
        if task == 3:
            with pytest.raises(MeshError, match="three"):
                future.result()
        elif task == 4:
            with pytest.raises(KeyError):
                future.result()
        elif task == 5:
            with pytest.raises(processes.EndedError):
                future.result()
        else:
            assert future.result() == 2 * task


def test_who_stops_asking_leaves_no_process(work: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    started = note_processes(monkeypatch)
    results = processes.each(work, range(10, 10**5), 2)
    assert len({next(results)[0] for _ in range(5)}) == 5
    results.close()
    assert len(started) == 2
    assert all(process.returncode is not None for process in started)


SCRIPT = """\
from urdf2mbs import convert_many
print("once")
configs = [{"source": "r.urdf", "output": name} for name in ("a.mbs", "b.mbs")]
assert [outcome.code for outcome in convert_many(configs, workers=2)] == [0, 0]
"""


def test_a_script_needs_no_guard(tmp_path: Path) -> None:
    """Processes of multiprocessing would run the script again."""
    (tmp_path / "r.urdf").write_text(TINY)
    (tmp_path / "script.py").write_text(SCRIPT)
    command = [sys.executable, "script.py"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "once\n"), done.stderr
