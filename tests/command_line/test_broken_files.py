"""Every command with every kind of bad file: a documented exit code, a code, no traceback."""

import io
import os
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from support.codes import CATALOGUE
from urdf2mbs.api import convert
from urdf2mbs.cli import main
from urdf2mbs.config.load import load
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY
from urdf2mbs.verification import verify

pytestmark = pytest.mark.slow

LAUGHS = b"a: &a [x]\n" + b"".join(
    b"%c: &%c [%s]\n" % (c + 1, c + 1, b",".join([b"*%c" % c] * 10)) for c in range(97, 115)
)
#: Files that no command takes for a robot, a config, an .mbs, an SRDF or a plugin.
CONTENTS = {
    "empty": b"",
    "blank": b" \n",
    "binary": bytes(range(256)) * 9,
    "words": b"robot\n",
    "nul": b"\0" * 50,
    "page": b"<html><body/></html>",
    "list": b"- a\n",
    "json": b'{"source": 1}',
    "Latin-1": "é: è\n".encode("latin-1"),
    "UTF-16": "source: tiny.urdf\n".encode("utf-16"),
    "deep": b"source: tiny.urdf\npasses: " + b"[" * 100_000,
    "deep_blocks": b"source: tiny.urdf\npasses: \n" + b"- " * 50_000,
    "alias": b"a: &a [*a]\n",
    "laughs": LAUGHS,
    "more_laughs": b"source: tiny.urdf\npasses: {emit: {z: &z [x]}, check: {x: [*z]}}\nafter: {"
    + LAUGHS.replace(b"\n", b", ")
    + b"}\n",
    "elements": b"<robot>" + b"<a>" * 10_000,
    "truncated": TINY.encode()[:300],
    "exits": b"raise SystemExit(0)\n",
    "no_syntax": b"def\n",
}
#: Names of what is no readable file.
NAMES = (
    "missing.x",
    "folder",
    "dangling",
    "loop",
    "tiny.urdf/x",
    "x" * 300,
    "x" * 5000,
    "a\x1b[2Jb",
    "a\nerror[internal]: b",
    "a\0b",
    "a\udcff",
    "",
    "~nobody/x",
    "http://127.0.0.1:9/x.urdf",
    "robot_descriptions:nothing_of_the_kind",
)
BAD = [*CONTENTS, *NAMES, *(["/dev/null"] if Path("/dev/null").exists() else []), "-"]

#: What is read: X stands for the bad file.
READING = (
    "simulate X",
    "run X",
    "run X tiny.yaml",
    "convert X -o out.mbs",
    "report X",
    "verify X tiny.mbs",
    "verify tiny.urdf X",
    "diagram X",
    "equations X",
    "explain X",
    "init X",
    "explain --plugin X",
    "schema --plugin X",
    "convert tiny.urdf --plugin X",
    "convert tiny.urdf --set posture.srdf=X --set posture.state=home",
)
#: Where X is not a file to read; these may do well.
ELSEWHERE = (
    "convert tiny.urdf -o X",
    "report tiny.urdf -o X",
    "diagram tiny.mbs -o X",
    "equations tiny.mbs -o X",
    "init tiny.urdf -o X",
    "new-pass swing -o X",
    "convert tiny.urdf --dump X",
    "convert tiny.urdf --package p=X",
    "new-pass X",
    "simulate tiny.mbs --push X",
    "convert tiny.urdf --stop-after X",
    "convert tiny.urdf --pipeline X",
    "convert tiny.urdf --set X.X=X",
    "convert tiny.urdf --level X=X",
    "convert tiny.urdf --arg X",
    "convert tiny.urdf --after X=X",
    "verify tiny.urdf tiny.mbs --tolerance X",
    "doctor X",
)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of good files and bad ones."""
    folder = tmp_path_factory.mktemp("every") / "good"
    folder.mkdir()
    (folder / "tiny.urdf").write_text(TINY)
    (folder / "tiny.mbs").write_bytes(convert(folder / "tiny.urdf").data)
    (folder / "tiny.yaml").write_text("source: tiny.urdf\n")
    (folder / "folder").mkdir()
    for name, data in CONTENTS.items():
        (folder / name).write_bytes(data)
    if sys.platform != "win32":
        (folder / "dangling").symlink_to("nowhere")
        (folder / "loop").symlink_to("loop")
    return folder


@pytest.fixture
def untouched(good: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Change to that folder, and return it; all that is in it must stay."""
    monkeypatch.chdir(good)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"")))
    before = state(good)
    yield good
    assert state(good) == before, "what was there is still there"


def state(folder: Path) -> set[str]:
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*")}


def call(words: list[str], capsys: Any) -> tuple[int, str]:
    """The exit code, and what standard error has."""
    ended = None
    try:
        code = main(words)
    except SystemExit as end:
        ended = end.code
    said = capsys.readouterr()
    if ended is not None:  # argparse
        assert ended == 2, words
        assert re.match(r"urdf2mbs.*: error: (?s:.*) --help shows how it is used\n$", said.err)
        return 2, said.err
    shown = said.out + said.err
    assert "Traceback" not in shown, words
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f]", shown), words
    told = re.findall(r"^(?:.*: )?error\[([a-z-]+)\]: ", said.err, re.MULTILINE)
    assert set(told) <= set(CATALOGUE) - {"internal"}, (words, said.err)
    assert bool(told) == (code != 0), (words, said.err)
    return code, said.err


@pytest.mark.parametrize("command", READING)
def test_a_command_that_reads(command: str, untouched: Path, capsys: Any) -> None:
    before = state(untouched)
    for bad in BAD:
        words = [word.replace("X", bad) for word in command.split(" ")]
        code, said = call(words, capsys)
        # explain reads a config; a robot only has to be there
        assert code in (1, 2) or (words[0] == "explain" and bad in CONTENTS), (words, said)
        assert state(untouched) == before, (words, "nothing is written")


@pytest.mark.parametrize("command", ELSEWHERE)
def test_a_command_that_does_something_else(command: str, untouched: Path, capsys: Any) -> None:
    before = state(untouched)
    for bad in ("missing", *NAMES, "/dev/null"):
        words = [word.replace("X", bad) for word in command.split(" ")]
        code, said = call(words, capsys)
        assert code in (0, 1, 2), (words, said)
        if code:
            assert state(untouched) == before, (words, "nothing is written")
        for name in sorted(state(untouched) - before, reverse=True):
            path = untouched / name
            path.rmdir() if path.is_dir() else path.unlink()


@pytest.mark.parametrize("bad", BAD)
def test_from_python(bad: str, untouched: Path) -> None:
    """No exception but ours leaves the library."""
    model, robot = untouched / "tiny.mbs", str(untouched / "tiny.urdf")
    for act in (
        lambda: convert(bad),
        lambda: convert(robot, plugins=[bad]),
        lambda: convert(robot, passes={"posture": {"srdf": bad, "state": "home"}}),
        lambda: convert(robot, packages={"p": bad}) and convert(bad),
        lambda: verify(bad, model),
        lambda: verify(robot, Path(bad)),
        lambda: load(Path(bad)),
        lambda: read_mbs(CONTENTS.get(bad, b""), bad),
    ):
        with pytest.raises(ConversionError) as caught:
            act()
        assert caught.value.code in CATALOGUE
        assert caught.value.code != "internal"


@pytest.mark.skipif(not hasattr(os, "seteuid"), reason="rights of POSIX")
@pytest.mark.parametrize("name", ["secret", "locked/x"])
def test_what_may_not_be_read(
    name: str, good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    def closed(function: Any) -> Any:
        def plain_or_error(self: Path, *args: Any, **more: Any) -> Any:
            if self.name == "secret" or "locked" in self.parts[:-1]:
                raise PermissionError(13, "Permission denied", str(self))
            return function(self, *args, **more)

        return plain_or_error

    monkeypatch.chdir(tmp_path)
    for file in ("tiny.urdf", "tiny.mbs", "tiny.yaml"):
        shutil.copy(good / file, tmp_path)
    (tmp_path / "locked").mkdir()
    (tmp_path / "secret").write_text("x")
    for call_ in ("open", "stat", "mkdir"):
        monkeypatch.setattr(Path, call_, closed(getattr(Path, call_)))  # root may do all
    for command in READING:
        if "--plugin" in command:
            continue  # Python reads it
        code, said = call([word.replace("X", name) for word in command.split(" ")], capsys)
        assert code in (1, 2), command
        assert name != "secret" or "Permission denied" in said or "explain" in command, said


def test_robots_in_a_folder_that_may_not_be_looked_into_are_not_left_out_in_silence(
    good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    (tmp_path / "in" / "locked").mkdir(parents=True)
    shutil.copy(good / "tiny.urdf", tmp_path / "in")
    look = os.scandir

    def closed(place: Any) -> Any:
        if os.fspath(place).endswith("locked"):
            raise PermissionError(13, "Permission denied", place)
        return look(place)

    monkeypatch.setattr(os, "scandir", closed)  # root may look into all
    code, said = call(["convert", str(tmp_path / "in"), "-o", f"{tmp_path / 'out'}/"], capsys)
    assert code == 2
    assert "file-unreadable" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "command", ["convert tiny.urdf", "doctor", "init tiny.urdf", "run a b", "explain"]
)
def test_a_working_folder_that_is_gone(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    if sys.platform == "win32":
        pytest.skip("Windows keeps it")
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    code, said = call(command.split(), capsys)
    assert code == 2
    assert "the working folder does not exist any more" in said
    with pytest.raises(ConversionError, match="the working folder"):
        convert("tiny.urdf")


def test_streams_that_are_closed(good: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a shell's ``>&- 2>&- <&-``, and as for a service."""
    monkeypatch.chdir(good)
    for name in ("stdout", "stderr", "stdin"):
        monkeypatch.setattr(sys, name, None)
    assert main(["explain"]) == 0
    assert main(["convert", "missing.urdf"]) == 1
    assert main(["convert", "-", "-o", "out.mbs"]) == 1
    assert main(["equations", "-", "-o", "out"]) == 2
    for stream in (sys.stdout, sys.stderr):
        assert stream is not None
        stream.close()
    assert not (good / "out.mbs").exists()


@pytest.mark.parametrize(
    ("where", "command"),
    [
        ("urdf2mbs.passes.emit.write", "convert tiny.urdf -o out.mbs"),
        ("urdf2mbs_report.draw.draw", "diagram tiny.mbs -o a.svg"),
    ],
)
def test_too_little_memory(
    where: str, command: str, untouched: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise MemoryError

    monkeypatch.setattr(where, full)
    code, said = call(command.split(), capsys)
    assert code == 1
    assert "error[memory-full]: " in said
