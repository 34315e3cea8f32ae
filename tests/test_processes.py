"""Several processes: the same as one by one, in order where it counts, and none stays."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs import convert
from urdf2mbs.machine import processes
from urdf2mbs.meshes.model import MeshError
from urdf2mbs.passes import convert_meshes

OBJ = "v 0 0 {z}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def robot(folder: Path, meshes: list[str], scale: str = "1 1 1") -> Path:
    parts = ['<robot name="r"><link name="base"/>']
    for k, name in enumerate(meshes):
        parts.append(
            f'<link name="l{k}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" '
            f'iyy="1" iyz="0" izz="1"/></inertial><visual><geometry><mesh filename="{name}" '
            f'scale="{scale}"/></geometry></visual></link><joint name="j{k}" type="continuous">'
            f'<parent link="base"/><child link="l{k}"/></joint>'
        )
    source = folder / "r.urdf"
    source.write_text("".join([*parts, "</robot>"]))
    return source


def made(source: Path) -> tuple[dict[str, bytes], list[str], Any]:
    conversion = convert(source, project=source.parent / "project").conversion
    written = {path.name: data for path, data in conversion.files.items() if path.suffix == ".wrl"}
    said = [str(one) for one in conversion.diagnostics]
    return written, said, conversion.facts["convert-meshes"]


@pytest.fixture
def two(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(convert_meshes, "WORTH", 1)
    monkeypatch.setattr(processes, "cores", lambda: 2)


def mixed(folder: Path) -> Path:
    """Eight meshes, of which some are broken, missing, empty, or the same file twice."""
    names = []
    for k in range(8):
        (folder / f"m{k}.obj").write_text(OBJ.format(z=k))
        names.append(f"m{k}.obj")
    (folder / "m2.obj").write_text("nothing")
    (folder / "m5.obj").write_bytes(b"")
    names[3] = "missing.obj"
    return robot(folder, [*names, "./m1.obj", f"file://{folder}/m1.obj", "m6.obj"])


def note_processes(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The processes that are started from now on."""
    started: list[Any] = []
    start = processes._Pool._start

    def noted(self: Any) -> Any:
        started.append(start(self))
        return started[-1]

    monkeypatch.setattr(processes._Pool, "_start", noted)
    return started


def test_all_is_as_in_one_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = mixed(tmp_path)
    alone = made(source)
    monkeypatch.setattr(convert_meshes, "WORTH", 1)
    monkeypatch.setattr(processes, "cores", lambda: 2)
    started = note_processes(monkeypatch)
    assert made(source) == alone
    assert len(started) == 2
    assert all(process.wait(30) is not None for process in started)
    assert len(alone[0]) == 7
    assert any("mesh-unreadable" in line for line in alone[1])
    assert any("mesh-missing" in line for line in alone[1])


def test_each_file_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = mixed(tmp_path)
    read: list[str] = []
    make = convert_meshes.make

    def counted(job: convert_meshes.Job) -> convert_meshes.Converted:
        read.append(job.path.name)
        return make(job)

    monkeypatch.setattr(convert_meshes, "make", counted)
    made(source)
    assert sorted(read) == ["m0.obj", "m1.obj", "m2.obj", "m4.obj", "m5.obj", "m6.obj", "m7.obj"]


@pytest.mark.usefixtures("two")
def test_a_process_that_ends_is_no_loss(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = mixed(tmp_path)
    whole = made(source)
    monkeypatch.setattr(processes, "_START", "raise SystemExit(1)")
    assert made(source) == whole


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


@pytest.mark.parametrize("in_order", [True, False])
def test_each_task_has_its_result(work: Any, in_order: bool) -> None:
    done = list(processes.each(work, range(20), 2, in_order=in_order))
    tasks = [task for task, _ in done]
    assert (tasks if in_order else sorted(tasks)) == list(range(20))
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
    results = processes.each(work, iter(range(10, 10**9)), 2)
    assert len({next(results)[0] for _ in range(5)}) == 5
    results.close()
    assert len(started) == 2
    assert all(process.returncode is not None for process in started)


def test_few_and_small_files_stay_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "cores", lambda: 8)
    monkeypatch.setattr(processes, "each", None)
    made(mixed(tmp_path))


SCRIPT = """\
import sys
from pathlib import Path
from urdf2mbs import convert
from urdf2mbs.machine import processes
from urdf2mbs.passes import convert_meshes
convert_meshes.WORTH, processes.cores = 1, lambda: 2
print("once")
convert(sys.argv[1], project=Path(sys.argv[1]).parent / "p").write()
"""


def test_a_script_needs_no_guard(tmp_path: Path) -> None:
    """Processes of multiprocessing would run the script again."""
    source = mixed(tmp_path)
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    command = [sys.executable, str(script), str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "once\n"), done.stderr
    assert len(list((tmp_path / "p" / "animationR" / "vrml").glob("*.wrl"))) == 7


@pytest.mark.parametrize("in_order", [False, True])
def test_no_task_is_lost(in_order: bool) -> None:
    done = [
        (task, result.result())
        for task, result in processes.each(str, range(23), 2, in_order=in_order)
    ]
    assert sorted(done) == [(task, str(task)) for task in range(23)]
