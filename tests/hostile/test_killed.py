"""A kill, a full disk or another run at any moment: the old result is whole, and no litter stays.

The process is killed, or a call of the system fails, at each step of writing in turn: the steps
are counted, so the same ones are met every time.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from merge.edits import as_saved

from urdf2mbs import cli
from urdf2mbs.conversion import Conversion
from urdf2mbs.disk import output
from urdf2mbs.disk.output import write, write_files
from urdf2mbs.engine.config import Config, Lines, typed
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs.model import Point
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write as write_mbs
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="processes of POSIX"),
]

State = dict[str, bytes | None]

#: The calls by which something on the disk changes.
STEPS: list[tuple[Any, str]] = [
    (os, "fsync"), (os, "link"), (output, "_private"), (Path, "replace"), (Path, "unlink"),
    (Path, "mkdir"), (Path, "rmdir"), (Path, "chmod"),
]  # fmt: skip


@contextmanager
def at_step(number: int, act: Callable[[], None], but: str = "") -> Iterator[list[str]]:
    """Do something before a step of writing; gives the steps that were taken."""
    taken: list[str] = []

    def counted(plain: Any, name: str) -> Any:
        def step(*args: Any, **options: Any) -> Any:
            taken.append(name)
            if len(taken) == number and name != but:
                act()
            return plain(*args, **options)

        return step

    with ExitStack() as stack:
        for owner, name in STEPS:
            stack.enter_context(patch.object(owner, name, counted(getattr(owner, name), name)))
        yield taken


def in_child(work: Callable[[], Any]) -> int:
    """The exit code of a process that does something; minus the signal that has killed it."""
    return os.waitstatus_to_exitcode(os.waitpid(started(work), 0)[1])


def started(work: Callable[[], Any]) -> int:
    """The number of a new process that does something."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pid = os.fork()
    if pid == 0:
        code = 99
        try:
            work()
            code = 0
        except ConfigError:
            code = 2
        except SystemExit as end:
            code = int(end.code or 0)
        finally:
            os._exit(code)
    return pid


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process is killed here, not the machine: nothing has to be on the disk itself."""
    monkeypatch.setattr(os, "fsync", lambda _: None)


def kill() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def full() -> None:
    raise OSError(28, "No space left on device")


def state(folder: Path) -> State:
    """Everything below a folder; None is a folder.

    A record of checksums is left out: after a kill the record knows the earlier files, too.
    """
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
        if path.name != ".urdf2mbs"
    }


def conversion(folder: Path, mass: str, *, project: bool) -> Conversion:
    source = folder / "tiny.urdf"
    source.write_text(TINY.replace('<mass value="', f'<mass value="{mass}', 1))
    out: Any = {"project": str(folder / "out")} if project else str(folder / "out" / "tiny.mbs")
    lines = Lines()
    given = {"source": str(source), "output": out, "pipeline": "faithful"}
    return Pipeline(typed(Config, given, lines), lines, installed_plugins=False).run()


@pytest.fixture(scope="module", params=["file", "project"])
def two(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Conversion]]:
    """A folder, and two conversions into it that differ."""
    folder = tmp_path_factory.mktemp("killed")
    made = [conversion(folder, mass, project=request.param == "project") for mass in ("2", "3")]
    assert made[0].files != made[1].files
    return folder / "out", made


def clean(folder: Path, before: Conversion | None) -> State:
    shutil.rmtree(folder, ignore_errors=True)
    if before is not None:
        write(before)
    return state(folder)


def whole(conversion: Conversion, folder: Path) -> State:
    clean(folder, None)
    write(conversion)
    return state(folder)


@pytest.mark.parametrize("fresh", [True, False])
def test_a_kill_at_any_step(two: tuple[Path, list[Conversion]], fresh: bool) -> None:
    folder, (old, new) = two
    wanted = whole(new, folder)
    for number in range(1, 1000):
        before = clean(folder, None if fresh else old)

        def work(number: int = number) -> None:
            with at_step(number, kill):
                write(new)

        code = in_child(work)
        after = state(folder)
        for name, data in before.items():
            if data is not None:
                assert after[name] in (data, wanted[name]), f"step {number}: {name}"
        for name, data in after.items():
            if name in wanted and name not in before:
                assert data == wanted[name], f"step {number}: {name}"
        write(new)  # which accepts what is there, and takes the litter away
        assert state(folder) == wanted, f"step {number}"
        if code == 0:
            assert number > 4
            return
        assert code == -signal.SIGKILL
    raise AssertionError("it never ended")


def test_a_kill_while_a_merge_is_written(tmp_path: Path) -> None:
    """The edit is never lost, and the next run makes of it what this one would have made."""
    folder = tmp_path / "out"
    write(conversion(tmp_path, "2", project=False))
    file = folder / "tiny.mbs"
    mbs = read(file.read_bytes(), "tiny.mbs")
    mbs.bodies[0].points.append(Point("mine", (0.5, 0.25, 0.125)))
    file.write_bytes(as_saved(write_mbs(mbs)))
    before = state(folder)
    write(conversion(tmp_path, "3", project=False))
    wanted = state(folder)
    assert wanted["tiny.mbs"] != before["tiny.mbs"]
    for number in range(1, 1000):
        shutil.rmtree(folder)
        folder.mkdir()
        for name, data in before.items():
            (folder / name).write_bytes(data or b"")
        new = conversion(tmp_path, "3", project=False)

        def work(number: int = number, new: Conversion = new) -> None:
            with at_step(number, kill):
                write(new)

        code = in_child(work)
        for name, data in before.items():
            assert (folder / name).read_bytes() in (data, wanted[name]), number
        write(conversion(tmp_path, "3", project=False))
        assert state(folder) == wanted, number
        if code == 0:
            assert number > 4
            return
    raise AssertionError("it never ended")


@pytest.mark.parametrize("fresh", [True, False])
def test_a_full_disk_at_any_step(two: tuple[Path, list[Conversion]], fresh: bool) -> None:
    folder, (old, new) = two
    whole(new, folder)
    failed = 0
    for number in range(1, 1000):
        before = clean(folder, None if fresh else old)
        folder.mkdir(exist_ok=True)  # made by the test, so that it may stay
        said = None
        with at_step(number, full, but="unlink") as taken:
            try:
                write(new)
            except ConfigError as error:
                said = error
        if said is not None:
            assert said.code == "output-unwritable"
            assert "No space left" in said.message
            assert state(folder) == before, f"step {number}: {taken[number - 1]}"
            failed += 1
        if len(taken) < number:
            assert failed >= 4
            return
    raise AssertionError("it never ended")


@pytest.mark.parametrize("signal_", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_takes_the_litter_away(
    signal_: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source, out = tmp_path / "tiny.urdf", tmp_path / "out" / "tiny.mbs"
    source.write_text(TINY)
    before = state(tmp_path)
    monkeypatch.setattr(sys, "argv", ["urdf2mbs", "convert", str(source), "-o", str(out)])
    for number in range(1, 100):

        def work(number: int = number) -> None:
            with at_step(number, lambda: os.kill(os.getpid(), signal_)):
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
                os.dup2(1, 2)
                raise SystemExit(cli.main())

        code = in_child(work)
        if code == 0:
            break
        assert code == 128 + signal_
        done = {*before, "out", "out/tiny.mbs", "out/tiny.mbs.base"}
        assert set(state(tmp_path)) in ({*before}, done), number
        shutil.rmtree(out.parent, ignore_errors=True)
    assert number > 4


def test_two_runs_at_once_do_not_mix(two: tuple[Path, list[Conversion]]) -> None:
    folder, made = two
    wholes = [whole(one, folder) for one in made]
    clean(folder, made[0])
    for _ in range(5):
        pids = [started(partial(write, one)) for one in made]
        assert [os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) for pid in pids] == [0, 0]
        assert state(folder) in wholes
        write(made[0])  # it is ours still


def test_whose_the_mbs_is_is_asked_when_nobody_else_writes(
    two: tuple[Path, list[Conversion]],
) -> None:
    """Another run, or MBSysPad, that changes the .mbs before the lock is seen, and not after."""
    folder, (old, new) = two
    mbs = new.settings.output
    plain = output._lock

    def between(change: Callable[[], Any]) -> Callable[..., bool]:
        """The lock, and before the first of them another writes."""
        done: list[bool] = []

        def lock(path: Path, locks: ExitStack) -> bool:
            if not done:
                done.append(True)
                change()
            return plain(path, locks)

        return lock

    # by hand: it is not overwritten
    clean(folder, old)
    with (
        patch.object(output, "_lock", between(lambda: mbs.write_bytes(b"by hand"))),
        pytest.raises(ConfigError, match="has no seal of urdf2mbs"),
    ):
        write(new)
    assert mbs.read_bytes() == b"by hand"
    # by another run that is whole, killed after the record of this one: it is ours still
    for number in range(1, 1000, 9):
        clean(folder, None)

        def work(number: int = number) -> None:
            with (
                patch.object(output, "_lock", between(lambda: in_child(lambda: write(old)))),
                at_step(number, kill),
            ):
                write(new)

        code = in_child(work)
        if mbs.exists():
            assert mbs.read_bytes() in (old.files[mbs], new.files[mbs])
        write(new)
        if code == 0:
            return
    raise AssertionError("it never ended")


def test_litter_of_others_stays(tmp_path: Path) -> None:
    ours = [".a.mbs.abcd_123.part", ".a.mbs.12345678.old"]
    others = [".b.mbs.abcd_123.part", ".a.mbs.part", "a.mbs.abcd_123.part", ".a.mbs.abcd_1234.part"]
    for name in (*ours, *others):
        (tmp_path / name).touch()
    write_files({tmp_path / "a.mbs": b"<a/>"})
    assert sorted(state(tmp_path)) == sorted([*others, "a.mbs"])
