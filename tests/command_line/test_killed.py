"""A run that is killed, or fails, at any moment leaves no half file, and loses no edit.

The next run works.

The process ends, or a call of the system fails, at each step of writing in turn: the steps are
counted, so the same ones are met every time.
"""

import os
import shutil
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest

from support.edits import as_saved
from urdf2mbs import Result, convert
from urdf2mbs.disk.record import RECORD
from urdf2mbs.mbs.model import Point
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="processes of POSIX"),
]

State = dict[str, bytes]
#: The calls by which something on the disk changes: before each of them a process may end.
STEPS: list[tuple[Any, str]] = [
    (os, "fsync"),
    (os, "replace"),
    (Path, "open"),
    (Path, "unlink"),
    (Path, "mkdir"),
    (Path, "chmod"),
]


@contextmanager
def at_step(number: int, act: Callable[[], None]) -> Iterator[list[str]]:
    """Do something before a step of writing; gives the steps that were taken."""
    taken: list[str] = []

    def counted(plain: Any, name: str) -> Any:
        def step(*args: Any, **options: Any) -> Any:
            if name != "open" or {*str(args[1:2])} & {*"wax"}:
                taken.append(name)
                if len(taken) == number:
                    act()
            return plain(*args, **options)

        return step

    with ExitStack() as stack:
        for owner, name in STEPS:
            stack.enter_context(patch.object(owner, name, counted(getattr(owner, name), name)))
        yield taken


def killed_at(number: int, work: Callable[[], Any]) -> bool:
    """True if a process that does some work ended at this step, and not by itself."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pid = os.fork()
    if pid == 0:
        try:
            with at_step(number, lambda: os._exit(9)):
                work()
            os._exit(0)
        finally:
            os._exit(1)
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    assert code in (0, 9)
    return code == 9


def state(folder: Path) -> State:
    """Return all files below a folder, without temporary files.

    Records are left out, too: after a kill they know more than they must.
    """
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != RECORD and path.suffix != ".part"
    }


def lay(folder: Path, template: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(template, folder)


@pytest.fixture(params=["new", "edited", "other language"])
def case(request: Any, tmp_path: Path) -> tuple[Path, Callable[[], Result]]:
    """The folder of a project as it is before, and the conversion that is written into it."""
    folder, source, language = tmp_path / "out", tmp_path / "tiny.urdf", ["python"]
    source.write_text(TINY)

    def converted() -> Result:
        return convert(source, output={"project": folder, "language": language})

    folder.mkdir()
    if request.param != "new":
        converted().write()
        source.write_text(TINY.replace('<mass value="2', '<mass value="3', 1))
    if request.param == "edited":
        model = folder / "dataR" / "out.mbs"
        mbs = read_mbs(model.read_bytes(), "out.mbs")
        mbs.bodies[0].points.append(Point("mine", (0.5, 0.25, 0.125)))
        model.write_bytes(as_saved(write(mbs)))
        (folder / "userfctR" / "user_JointForces.py").write_text("mine\n")
    if request.param == "other language":
        language[:] = ["c"]
    shutil.copytree(folder, tmp_path / "before")
    return folder, converted


def test_a_kill_at_any_step(case: Any, tmp_path: Path) -> None:
    folder, converted = case
    before, ready = state(folder), converted()
    converted().write()
    wanted = state(folder)
    assert wanted != before
    number = 1
    while True:
        lay(folder, tmp_path / "before")
        ended = killed_at(number, ready.write)
        for name, data in state(folder).items():
            assert data in (before.get(name), wanted.get(name)), f"step {number}: {name}"
        converted().write()
        assert state(folder) == wanted, f"step {number}"
        if not ended:
            break
        number += 1
    assert number > 30


def test_a_full_disk_at_any_step(case: Any, tmp_path: Path) -> None:
    folder, converted = case
    before = state(folder)
    converted().write()
    wanted = state(folder)

    def full() -> None:
        raise OSError(28, "No space left on device")

    number = failed = 0
    taken = [""]
    while len(taken) >= number:
        number += 1
        lay(folder, tmp_path / "before")
        said = ""
        with at_step(number, full) as taken, suppress(ConfigError):
            said = "unwritable"
            converted().write()
            said = ""
        failed += bool(said)
        assert [*folder.rglob("*.part")] == [], f"step {number}"
        for name, data in state(folder).items():
            assert data in (before.get(name), wanted.get(name)), f"step {number}: {name}"
        converted().write()
        assert state(folder) == wanted, f"step {number}"
    assert failed > 20
