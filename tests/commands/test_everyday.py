"""The command line day by day: help, flags, doctor, completion, streams, colours, next steps."""

from __future__ import annotations

import io
import json
import re
import shlex
import subprocess
import sys
from errno import ENOSPC
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.commands import commands_of, parser
from urdf2mbs.mbs.reader import read
from urdf2mbs.testing import TINY

XACRO = TINY.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ', 1).replace(
    "<link", '<xacro:arg name="a" default="1"/><link', 1
)


class Stdin(io.StringIO):
    """Standard input as Python has it: text, above bytes."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.buffer = io.BytesIO(text.encode())


COMMANDS = commands_of()


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_help_with_examples_that_are_commands(command: str, capsys: Any) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    said = capsys.readouterr().out
    assert "examples:\n" in said
    for line in import_module(COMMANDS[command].module).EXAMPLES:
        assert f"  {line}\n" in said
        words = shlex.split(line.partition(" > ")[0].rpartition("| ")[2], comments=True)
        assert words[:2] == ["urdf2mbs", command]
        parser().parse_args(words[1:])
    commands: Any = next(action.choices for action in parser()._actions if action.choices)
    assert all(action.help for action in commands[command]._actions)


def test_an_unknown_option_shows_the_usage_of_the_command(capsys: Any) -> None:
    with pytest.raises(SystemExit) as end:
        main(["verify", "a", "b", "--nosuch"])
    assert end.value.code == 2
    err = capsys.readouterr().err
    assert err.startswith("usage: urdf2mbs verify ")
    assert "unrecognized arguments: --nosuch" in err


#: The flags that commands share: who has them.
CONVERTING = {"run", "convert", "report", "simulate"}
WRITING = {"diagram", "equations", "merge", "new-pass"}
PLUGINS = {*CONVERTING, "explain", "schema", "doctor"}
SHARED = {
    "--debug": set(COMMANDS),
    "--color": set(COMMANDS),
    "--json": set(COMMANDS) - {"schema", "completion"},  # what these print is no table of words
    "--quiet": {*CONVERTING, *WRITING, "init", "verify"},
    "--no-plugins": PLUGINS,
    "--level": {*CONVERTING, "explain", "lint", "verify"},
    "--strict": {*CONVERTING, "explain", "lint", "verify"},
    "--verbose": {*CONVERTING, "explain", "lint", "verify"},
    "--set": {*CONVERTING, "explain"},
    "--trust-xacro": {*CONVERTING, "explain", "init", "lint", "verify"},
    "--package": {"init", "convert", "report", "simulate", "explain", "lint", "verify"},
    "--arg": {"init", "convert", "report", "simulate", "explain", "lint", "verify"},
    "--base": {"init", "convert", "report", "simulate", "explain", "lint", "verify"},
    "--sarif": {"lint", "verify"},
    "--plugin": {"convert", "report", "simulate", "explain", "schema"},
}


@pytest.mark.parametrize("flag", SHARED)
def test_a_flag_is_on_every_command_that_it_suits_and_the_same_there(flag: str) -> None:
    commands = next(a.choices for a in parser()._actions if a.choices)
    assert isinstance(commands, dict)
    found = {
        name: action
        for name, command in commands.items()
        for action in command._actions
        if flag in action.option_strings
    }
    assert set(found) == SHARED[flag]
    assert len({(a.help, a.metavar, str(a.default)) for a in found.values()}) == 1
    assert all(a.help for a in found.values())


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["convert", "tiny.urdf"], 0),
        (["convert", "tiny.urdf", "-o", "x/"], 0),
        (["convert", "nowhere.urdf"], 1),
        (["init", "tiny.urdf"], 0),
        (["new-pass", "paint"], 0),
    ],
)
def test_quiet(words: list[str], code: int, here: Path, capsys: Any) -> None:
    assert main([*words, "--quiet"]) == code
    said = capsys.readouterr()
    assert said.out == ""
    assert ("error[" in said.err) == (code != 0)


def test_quiet_leaves_warnings(here: Path, capsys: Any) -> None:
    (here / "odd.urdf").write_text(TINY.replace('<link name="hand">', '<link name="hand"><visul/>'))
    assert main(["convert", "odd.urdf", "-q"]) == 0
    said = capsys.readouterr()
    assert said.out == ""
    assert "warning[misspelt]" in said.err
    for more, code, out, err in (
        (["-q"], 0, "", "warning[misspelt]"),
        (["--level", "misspelt=ignore"], 0, "the same robot", ""),
        (["--strict"], 1, "", "error[misspelt]"),
    ):
        assert main(["verify", "odd.urdf", "odd.mbs", *more]) == code
        said = capsys.readouterr()
        assert (out in said.out, err in said.err) == (True, True)
        assert (bool(said.out), bool(said.err)) == (bool(out), bool(err))


def test_json_of_those_that_write_for_you(here: Path, capsys: Any) -> None:
    assert main(["init", "tiny.urdf", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["config"], found["robot"], found["links"]) == ("tiny.yaml", "tiny", 5)
    assert main(["new-pass", "paint", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"plugin": "paint.py", "test": "test_paint.py"}


def test_set_changes_a_config(here: Path, capsys: Any) -> None:
    (here / "tiny.yaml").write_text("source: tiny.urdf\npasses: {check: {tolerance: 1.0e-3}}\n")
    assert main(["explain", "tiny.yaml", "--json", "--set", "prune-massless.keep=[tool]"]) == 0
    options = {one["name"]: one["options"] for one in json.loads(capsys.readouterr().out)}
    assert options["check"]["tolerance"] == 1e-3
    assert options["prune-massless"]["keep"] == ["tool"]


def test_doctor(capsys: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert main(["doctor", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["urdf2mbs"]["lxml"] == version("lxml")
    assert found["ROS packages"]["AMENT_PREFIX_PATH"] == str(tmp_path)
    monkeypatch.setattr("urdf2mbs_setup.commands.doctor.version_of", lambda name: "")
    monkeypatch.setattr("urdf2mbs_setup.commands.doctor.version", lambda name: "0")
    assert main(["doctor"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"^  distributed +not installed, for ", said, re.M)
    assert re.search(r"^  lxml +MISSING$", said, re.M)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion(shell: str, capsys: Any) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(word in script for word in ("new-pass", "doctor", "tolerance", "gravity"))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have other shells")
@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("ver", "verify"),
        ("verify --tol", "--tolerance"),
        ("convert --base fl", "floating"),
        ("convert ti", "tiny.urdf"),
        ("convert tiny.urdf --dump d", "dump"),
        ("convert tiny.urdf --set ti", ""),
    ],
)
def test_completion_in_a_shell(words: str, found: str, here: Path, capsys: Any) -> None:
    """In bash, which every Linux has; zsh and fish were tried by hand."""
    (here / "dump").mkdir()
    assert main(["completion", "bash"]) == 0
    typed = ["urdf2mbs", *words.split(" ")]
    script = f"""{capsys.readouterr().out}
        COMP_WORDS=({" ".join(typed)}); COMP_CWORD={len(typed) - 1}
        _shtab_urdf2mbs urdf2mbs {typed[-1]} {typed[-2]}
        echo "${{COMPREPLY[*]}}" """
    done = subprocess.run(["bash", "-c", script], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == found


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
    monkeypatch.setattr("sys.stdin", Stdin("<robot>\n<link/>\n</robot>"))
    assert main(["convert", "-", "-o", "x.mbs"]) == 1
    assert b"<stdin>:" in capfdbinary.readouterr().err
    assert main(["report", "tiny.urdf", "-o", "-", "-q"]) == 0
    said = capfdbinary.readouterr()
    assert said.out.startswith(b"<!")
    assert b"written" not in said.err


def test_the_same_bytes_go_to_a_file_and_to_standard_output(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfdbinary: Any
) -> None:
    assert main(["convert", "tiny.urdf"]) == 0
    assert main(["diagram", "tiny.mbs"]) == 0
    monkeypatch.setattr("sys.stdin", Stdin((here / "tiny.mbs").read_text()))
    capfdbinary.readouterr()
    assert main(["convert", "tiny.urdf", "-o", "-"]) == 0
    assert capfdbinary.readouterr().out == (here / "tiny.mbs").read_bytes()
    assert main(["diagram", "-"]) == 0
    assert capfdbinary.readouterr().out == (here / "tiny.svg").read_bytes()
    monkeypatch.setattr("sys.stdin", Stdin(TINY))
    assert main(["verify", "-", "tiny.mbs"]) == 0
    assert main(["equations", "-"]) == 2
    assert sorted(file.name for file in here.glob("tiny.[msu]*[!e]")) == [
        "tiny.mbs", "tiny.svg", "tiny.urdf",
    ]  # fmt: skip


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("terminal", "variable", "when", "coloured"),
    [
        (True, "X", "auto", True),
        (True, "NO_COLOR", "auto", False),
        (False, "X", "auto", False),
        (True, "X", "never", False),
        (False, "NO_COLOR", "always", True),
    ],
)
def test_colours(
    terminal: bool, variable: str, when: str, coloured: bool, here: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("WT_SESSION", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv(variable, "1")
    out, err = (Terminal() if terminal else io.StringIO() for _ in range(2))
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr("sys.stderr", err)
    assert main(["convert", "tiny.urdf", "--color", when]) == 0
    assert main(["convert", "nowhere.urdf", "--color", when]) == 1
    assert ("\033[32mthe same robot\033[0m" in out.getvalue()) == coloured
    assert ("\033[1;31merror\033[0m[file-not-found]" in err.getvalue()) == coloured
    assert ("\033" in out.getvalue() + err.getvalue()) == coloured


def test_a_report_recommends_no_run_that_has_been_done(here: Path, capsys: Any) -> None:
    told = []
    for words in (["report"], ["convert"], ["report"], ["report", "--base", "fixed"]):
        assert main([words[0], "tiny.urdf", *words[1:]]) == 0
        told.append("the .mbs itself is written by" in capsys.readouterr().out)
    assert told == [True, False, False, True]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["convert", "tiny.urdf", "-o", "x.mbs"], "Next: open x.mbs in MBSysPad"),
        (["convert", "tiny.urdf", "-o", "x/"], "Next: let it move: urdf2mbs simulate x\n"),
        (
            ["simulate", "tiny.urdf", "-o", "s/", "--time", "0.02"],
            "Next: add '-o PAGE.html' to see it move; plot s/resultsR/dirdyn.csv",
        ),
        (["init", "tiny.urdf"], "Next: urdf2mbs run tiny.yaml\n      urdf2mbs report tiny.yaml"),
        (["diagram", "tiny.mbs"], "Next: open tiny.svg in a browser"),
        (["equations", "tiny.mbs", "-o", "s"], "Next: call them"),
        (["convert", "robots/", "-o", "m/"], "Next: open a model in MBSysPad"),
    ],
)
def test_each_result_ends_with_what_to_do_next(
    words: list[str], said: str, here: Path, capsys: Any
) -> None:
    (here / "robots").mkdir()
    (here / "robots" / "tiny.urdf").write_text(TINY)
    assert main(["convert", "tiny.urdf"]) == 0
    assert main(words) == 0
    out = capsys.readouterr().out
    last = out.splitlines()[-2:]
    assert last[0].startswith("Next: ")
    assert last[1].startswith("      ")
    assert said in out


@pytest.mark.parametrize(
    ("base", "said"),
    [
        ("floating", "moved most: 0.00196 m\n  nothing holds it: 'base: fixed' bolts it down"),
        ("fixed", " rad\n  s/"),
    ],
)
def test_a_robot_that_falls_is_told_what_holds_it(
    base: str, said: str, here: Path, capsys: Any
) -> None:
    words = ["simulate", "tiny.urdf", "-o", "s/", "--time", "0.02", "--base", base]
    assert main(words) == 0
    assert said in capsys.readouterr().out


@pytest.mark.parametrize(
    ("raised", "code", "said"),
    [
        (BrokenPipeError(), 0, ""),
        (KeyboardInterrupt(), 130, "stopped by SIGINT\n"),
        (OSError(ENOSPC, "No space left on device"), 2, "error[output-unwritable]: cannot print"),
        (ValueError("two\nlines"), 1, "error[internal]: ValueError: two lines\n  this is a"),
    ],
)
def test_how_a_command_ends(
    raised: BaseException, code: int, said: str, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    def carry_out(arguments: object) -> int:
        raise raised

    monkeypatch.setattr("urdf2mbs_setup.commands.doctor.carry_out", carry_out)
    assert main(["doctor"]) == code
    err = capsys.readouterr().err
    assert err.startswith(said)
    assert bool(err) == bool(said)
    if code == 1:
        with pytest.raises(type(raised)):
            main(["doctor", "--debug"])


@pytest.mark.skipif(sys.platform == "win32", reason="a pipe of POSIX")
def test_who_reads_no_further_sees_no_traceback() -> None:
    command = f"{shlex.quote(sys.executable)} -m urdf2mbs schema | head -c 10"
    done = subprocess.run(command, shell=True, check=False, capture_output=True)
    assert done.stdout.startswith(b"{")
    assert done.stderr == b""


BARE = """<robot name="r"><link name="a"/><link name="b"><visual><geometry><box size="1 1 1"/>
</geometry></visual></link><joint name="j" type="continuous"><parent link="a"/><child link="b"/>
</joint></robot>"""


def decisions(out: str) -> list[str]:
    """The lines between the count of the warnings and what to do next."""
    return re.findall(r"^  (.*)$", re.split(r"\d+ notes?.*\n", out)[1].partition("Next")[0], re.M)


def test_a_run_ends_with_what_was_decided_and_the_line_for_the_other_choice(
    here: Path, capsys: Any
) -> None:
    assert main(["convert", "tiny.urdf"]) == 0
    floating = "floating base, a guess, as nothing ties the root to the world"
    assert decisions(capsys.readouterr().out) == [f"{floating}; 'base: fixed' if it is wrong"]
    (here / "lamp.urdf").write_text(BARE)
    assert main(["convert", "lamp.urdf", "--set", "estimate-inertia.density=500"]) == 0
    said = decisions(capsys.readouterr().out)
    assert said == [
        "fixed base, a guess, as the root has no mass; 'base: floating' if it is wrong",
        "1 link got an inertia, estimated at 500 kg/m^3; else 'passes: {estimate-inertia: "
        "{density: KG_PER_M3}}'",
    ]


def test_a_robot_without_mass_is_not_sent_to_the_simulation(here: Path, capsys: Any) -> None:
    (here / "lamp.urdf").write_text(BARE)
    assert main(["convert", "lamp.urdf", "-o", "lamp/"]) == 0
    out = capsys.readouterr().out
    assert "NO DYNAMICS" in out
    assert "Next: give the links masses" in out
    assert "main.py" not in out


def test_a_missing_extra_says_what_to_install(
    here: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    (here / "tiny.yaml").write_text("source: tiny.urdf")
    assert main(["run", "tiny.yaml", "tiny.yaml", "--cluster", "nobody:1"]) == 2
    said = capsys.readouterr().err
    assert "error[extra-missing]" in said
    assert "pip install distributed\n" in said
