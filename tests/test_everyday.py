"""The command line day by day: help, doctor, completion, standard streams, colours, next steps."""

from __future__ import annotations

import io
import json
import re
import shlex
import shutil
import subprocess
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.mbs.reader import read
from urdf2mbs.options import EXAMPLES, parser
from urdf2mbs.testing import TINY

XACRO = TINY.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ', 1).replace(
    "<link", '<xacro:arg name="a" default="1"/><link', 1
)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    return tmp_path


class Stdin(io.StringIO):
    """Standard input as Python has it: text, above bytes."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.buffer = io.BytesIO(text.encode())


@pytest.mark.parametrize("command", EXAMPLES)
def test_each_command_has_help_with_examples_that_are_commands(command: str, capsys: Any) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    said = capsys.readouterr().out
    assert "examples:\n" in said
    for line in EXAMPLES[command]:
        assert f"  {line}\n" in said
        words = shlex.split(line.partition(" > ")[0].rpartition("| ")[2], comments=True)
        assert words[:2] == ["urdf2mbs", command]
        parser().parse_args(words[1:])


def test_no_command_is_without_examples() -> None:
    actions = [a for a in parser()._actions if a.choices]
    assert set(actions[0].choices or ()) == set(EXAMPLES)
    assert len(EXAMPLES) >= 10


def test_doctor(capsys: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    share = tmp_path / "share" / "us"
    share.mkdir(parents=True)
    (share / "package.xml").write_text("<package><name>us</name></package>")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "nowhere"))
    assert main(["doctor", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["urdf2mbs"]["lxml"] == version("lxml")
    assert found["ROS packages"][str(tmp_path)] == "1 packages, of AMENT_PREFIX_PATH"
    assert "NO SUCH FOLDER" in found["ROS packages"][str(tmp_path / "nowhere")]
    monkeypatch.setattr("urdf2mbs.kit.doctor._version", lambda name: None)
    monkeypatch.setattr("urdf2mbs.kit.doctor.version", lambda name: "0")
    assert main(["doctor"]) == 0
    said = capsys.readouterr().out
    assert re.search(
        r"^  meshes +not installed, for .*: pip install 'urdf2mbs\[meshes\]'", said, re.M
    )
    assert re.search(r"^  lxml +MISSING$", said, re.M)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion(shell: str, capsys: Any, tmp_path: Path) -> None:
    pytest.importorskip("shtab", reason="the extra 'completion' is not installed")
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for word in ("new-pass", "doctor", "engine", "pinocchio"):
        assert word in script
    if shutil.which(shell):
        file = tmp_path / "script"
        file.write_text(script)
        subprocess.run([shell, "-n", str(file)], check=True)


@pytest.mark.parametrize("text", [TINY, XACRO], ids=["urdf", "xacro"])
def test_from_standard_input_to_standard_output(
    text: str, here: Path, monkeypatch: pytest.MonkeyPatch, capfdbinary: Any
) -> None:
    monkeypatch.setattr("sys.stdin", Stdin(text))
    assert main(["convert", "-", "-o", "-"]) == 0
    said = capfdbinary.readouterr()
    assert [body.name for body in read(said.out, "").bodies] == ["body", "arm", "hand"]
    assert b"written to standard output" in said.err
    assert b"the same robot" in said.err
    assert [file.name for file in here.iterdir()] == ["tiny.urdf"]


def test_an_error_of_standard_input_names_it(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setattr("sys.stdin", Stdin("<robot>\n<link/>\n</robot>"))
    assert main(["convert", "-", "-o", "x.mbs"]) == 1
    assert "<stdin>:" in capsys.readouterr().err
    assert not (here / "x.mbs").exists()


def test_the_same_bytes_go_to_a_file_and_to_standard_output(here: Path, capfdbinary: Any) -> None:
    assert main(["convert", "tiny.urdf"]) == 0
    capfdbinary.readouterr()
    assert main(["convert", "tiny.urdf", "-o", "-"]) == 0
    assert capfdbinary.readouterr().out == (here / "tiny.mbs").read_bytes()
    assert main(["convert", "tiny.urdf", "-o", "-", "--json"]) == 2


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("terminal", "variable", "coloured"),
    [(True, "X", True), (True, "NO_COLOR", False), (False, "X", False)],
)
def test_colours(
    terminal: bool, variable: str, coloured: bool, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("WT_SESSION", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv(variable, "1")
    out, err = (Terminal() if terminal else io.StringIO() for _ in range(2))
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr("sys.stderr", err)
    assert main(["convert", "tiny.urdf"]) == 0
    assert main(["convert", "nowhere.urdf"]) == 1
    assert ("\033[32mthe same robot\033[0m" in out.getvalue()) == coloured
    assert ("\033[1;31merror\033[0m[file-not-found]" in err.getvalue()) == coloured
    assert ("\033" in out.getvalue() + err.getvalue()) == coloured


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["convert", "tiny.urdf", "-o", "x.mbs"], "Next: open x.mbs in MBSysPad"),
        (["convert", "tiny.urdf", "-o", "x/"], "\n      python x/workR/main.py"),
        (["init", "tiny.urdf"], "Next: urdf2mbs run tiny.yaml\n      urdf2mbs report tiny.yaml"),
    ],
)
def test_each_result_ends_with_what_to_do_next(
    words: list[str], said: str, here: Path, capsys: Any
) -> None:
    assert main(words) == 0
    out = capsys.readouterr().out
    last = out.splitlines()[-2:]
    assert last[0].startswith("Next: ")
    assert last[1].startswith("      ")
    assert said in out
