"""The command line day by day: flags, colours, streams, how a command ends."""

import io
from errno import ENOSPC
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.testing import TINY


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("verify a b --nosuch", "unrecognized arguments: --nosuch"),
        ("convert a --pipline compact", "--pipline compact; did you mean '--pipeline'?"),
        ("convert a height:=1", "unrecognized arguments: height:=1; write '--arg height:=1'"),
        ("run a --arg b:=1", "--arg b:=1; write 'xacro_args: {NAME: VALUE}' in the config"),
        ("run a --base=fixed", "--base=fixed; write 'base:' in the config"),
        ("convert a --fps 3", "unrecognized arguments: --fps 3"),  # is like no option
    ],
)
def test_an_unknown_option_names_what_is_meant(words: str, message: str, capsys: Any) -> None:
    with pytest.raises(SystemExit) as end:
        main(words.split())
    assert end.value.code == 2
    program = f"urdf2mbs {words.split()[0]}"
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith(f"{program}: error: ")
    assert first.endswith(message)
    assert second == f"  {program} --help shows how it is used"


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


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_help_has_no_colours_of_a_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    terminal = Terminal()
    monkeypatch.setattr("sys.stdout", terminal)
    with pytest.raises(SystemExit):
        main(["verify", "--help"])
    assert "the same robot" in terminal.getvalue()
    assert "\033" not in terminal.getvalue()


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
def test_colours_are_for_terminals_or_asked_for(
    terminal: bool,
    variable: str,
    when: str,
    coloured: bool,
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
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

    monkeypatch.setattr("urdf2mbs.commands.run.carry_out", carry_out)
    assert main(["run", "tiny.yaml"]) == code
    err = capsys.readouterr().err
    assert err.startswith(said)
    assert bool(err) == bool(said)
    if code == 1:
        with pytest.raises(type(raised)):
            main(["run", "tiny.yaml", "--debug"])
