"""The command line day by day: help, flags, doctor, streams, colours, next steps."""

import io
import json
import re
import shlex
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import urdf2mbs
from support.folders import ROOT
from support.processes import loaded
from urdf2mbs.cli import main
from urdf2mbs.commands import list_commands, parser
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import TINY

XACRO = TINY.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ', 1).replace(
    "<link", '<xacro:arg name="a" default="1"/><link', 1
)


class Stdin(io.StringIO):
    """Standard input as Python has it: text, above bytes."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.buffer = io.BytesIO(text.encode())


COMMANDS = list_commands()


def read_help(command: str, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> str:
    """Return the help of a command, with the text of each option in one line."""
    monkeypatch.setenv("COLUMNS", "500")
    with pytest.raises(SystemExit):
        main([command, "--help"])
    return str(capsys.readouterr().out)


def list_options(said: str) -> dict[str, str]:
    """Return what a help says of each option, with the name of its value, by its long name."""
    found = re.findall(r"^  (-\S.*?)(?: {2,}(\S.*)|\n {8,}(\S.*))?$", said, re.MULTILINE)
    names = [re.search("--[a-z-]+", name) for name, *_ in found]
    return {
        name[0]: f"{words.rpartition('--')[2]}: {beside or below}"
        for name, (words, beside, below) in zip(names, found, strict=True)
        if name is not None
    }


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_help_with_examples_that_are_commands(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    said = read_help(command, monkeypatch, capsys)
    assert "examples:\n" in said
    every = parser()
    for line in import_module(COMMANDS[command].module).EXAMPLES:
        assert f"  {line}\n" in said
        words = shlex.split(line.partition(" > ")[0].rpartition("| ")[2], comments=True)
        assert words[:2] == ["urdf2mbs", command]
        every.parse_args(words[1:])
    options = list_options(said)
    assert {"--help", "--debug", "--color"} <= options.keys()
    assert [option for option, text in options.items() if text.endswith(": ")] == []


#: The flags that commands share: who has them.
CONVERTING = {"run", "convert", "diagram", "equations", "report", "simulate", "modes"}
WRITING = {"merge", "new-pass", "new-plugin"}
ROBOTS = {*CONVERTING, "init", "explain", "lint", "verify"} - {"run"}
PLUGINS = {*CONVERTING, "explain", "schema", "doctor"}
SHARED = {
    "--debug": set(COMMANDS),
    "--color": set(COMMANDS),
    "--json": set(COMMANDS) - {"schema"},  # which always prints JSON
    "--quiet": {*CONVERTING, *WRITING, "init", "verify"},
    "--no-plugins": {*PLUGINS, "lint", "verify"},
    "--level": {*CONVERTING, "explain", "lint", "verify"},
    "--strict": {*CONVERTING, "explain", "lint", "verify"},
    "--verbose": {*CONVERTING, "explain", "lint", "verify"},
    "--set": {*CONVERTING, "explain"},
    "--trust-xacro": {*CONVERTING, "explain", "init", "lint", "verify"},
    "--package": ROBOTS,
    "--arg": ROBOTS,
    "--base": ROBOTS,
    "--sarif": {"lint", "verify"},
    "--plugin": {*CONVERTING, "explain", "schema"} - {"run"},
}


def test_a_flag_is_on_every_command_that_it_suits_and_the_same_there(
    monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    options = {name: list_options(read_help(name, monkeypatch, capsys)) for name in COMMANDS}
    for flag, commands in SHARED.items():
        found = {name: said[flag] for name, said in options.items() if flag in said}
        assert set(found) == commands, flag
        assert len({*found.values()}) == 1, flag


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
def test_quiet_prints_warnings_and_errors_alone(
    words: list[str], code: int, here: Path, capsys: Any
) -> None:
    assert main([*words, "--quiet"]) == code
    said = capsys.readouterr()
    assert said.out == ""
    assert ("error[" in said.err) == (code != 0)


def test_json_of_those_that_write_for_you(here: Path, capsys: Any) -> None:
    assert main(["init", "tiny.urdf", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["config"], found["robot"], found["links"]) == ("tiny.yaml", "tiny", 5)
    assert main(["new-pass", "paint", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"plugin": "paint.py", "test": "test_paint.py"}


@pytest.mark.parametrize("text", [TINY, XACRO], ids=["urdf", "xacro"])
def test_from_standard_input_to_standard_output(
    text: str, here: Path, monkeypatch: pytest.MonkeyPatch, capfdbinary: Any
) -> None:
    monkeypatch.setattr("sys.stdin", Stdin(text))
    assert main(["convert", "-", "-o", "-"]) == 0
    said = capfdbinary.readouterr()
    assert [body.name for body in read_mbs(said.out, "").bodies] == ["body", "arm", "hand"]
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
        "tiny.mbs",
        "tiny.svg",
        "tiny.urdf",
    ]


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
        (["convert", "tiny.urdf", "-o", "x/"], "simulate x -o moves.html; or open x/dataR/"),
        (
            ["simulate", "tiny.urdf", "-o", "s/", "--time", "0.02"],
            "Next: add '-o PAGE.html' to see it move; plot s/resultsR/dirdyn.csv",
        ),
        (["init", "tiny.urdf"], "Next: urdf2mbs run tiny.yaml; then: urdf2mbs simu"),
        (["diagram", "tiny.mbs"], "Next: open tiny.svg in a browser"),
        (["equations", "tiny.mbs", "-o", "s"], "robot = load_equations("),
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
    # at most two steps, or one with the three lines of code that it takes
    assert out.rpartition("\nNext: ")[2].count("\n") <= 2 + 2 * (words[0] == "equations")
    assert said in out


@pytest.mark.parametrize(
    ("package", "words"),
    [
        ("distributed", ["run", "tiny.yaml", "tiny.yaml", "--cluster", "nobody:1"]),
        ("robot_descriptions", ["init", "robot_descriptions:atlas_v4_description"]),
    ],
)
def test_a_missing_extra_says_what_to_install(
    package: str, words: list[str], here: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    (here / "tiny.yaml").write_text("source: tiny.urdf")
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "error[extra-missing]" in said
    assert f"pip install {package}\n" in said


def test_the_package_imports_what_is_asked_for() -> None:
    assert "urdf2mbs.messages.diagnostics" not in loaded("import urdf2mbs")
    stub = (ROOT / "urdf2mbs" / "__init__.pyi").read_text()
    for name in re.findall(r"as (\w+)", stub):
        assert getattr(urdf2mbs, name).__name__ == name
        assert name in dir(urdf2mbs)
    with pytest.raises(AttributeError, match="'urdf2mbs' has no attribute 'nosuch'"):
        urdf2mbs.nosuch  # noqa: B018


@pytest.mark.parametrize(
    "words",
    [
        ["explain"],
        ["lint"],
        ["report"],
        ["run", "--plan"],
        ["simulate", "--time", "0.01"],
        ["verify"],
    ],
)
def test_no_plugins_leaves_out_those_of_a_config(words: list[str], here: Path) -> None:
    (here / "tiny.mbs").write_bytes(urdf2mbs.convert("tiny.urdf").data)
    (here / "lab.py").write_text("open('ran', 'w').close()\n")
    (here / "tiny.yaml").write_text("source: tiny.urdf\nplugins: [lab.py]\n")
    main([*words, "tiny.yaml", "--no-plugins"])
    assert not (here / "ran").exists()
    main([*words, "tiny.yaml"])
    assert (here / "ran").exists()


def test_a_model_needs_no_ending_in_its_name(here: Path) -> None:
    assert main(["convert", "tiny.urdf", "-o", "panda_v1.0"]) == 0
    assert main(["diagram", "panda_v1.0"]) == 0
    assert (here / "panda_v1.0.svg").is_file()


BARE = """<robot name="r"><link name="a"/><link name="b"><visual><geometry><box size="1 1 1"/>
</geometry></visual></link><joint name="j" type="continuous"><parent link="a"/><child link="b"/>
</joint></robot>"""


def test_a_robot_without_mass_is_not_sent_to_the_simulation(here: Path, capsys: Any) -> None:
    (here / "lamp.urdf").write_text(BARE)
    assert main(["convert", "lamp.urdf", "-o", "lamp/"]) == 0
    out = capsys.readouterr().out
    assert "NO DYNAMICS" in out
    assert "Next: give the links masses" in out
    assert "main.py" not in out
