"""The example list_masses.py: a command of an installed package, with its help and its errors."""

import sys
from pathlib import Path

import pytest

from support.installed import install_file
from urdf2mbs.cli import main

PLUGIN = Path(__file__).with_name("list_masses.py")
TABLE = "body,2.0\narm,0.5\nhand,0.1\n"


@pytest.fixture
def model(here: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The .mbs of the tiny robot; the plugin is installed."""
    monkeypatch.syspath_prepend(install_file(here / "site-packages", PLUGIN))
    monkeypatch.delitem(sys.modules, "list_masses", raising=False)
    assert main(["convert", "tiny.urdf", "--quiet"]) == 0
    return here / "tiny.mbs"


def test_the_masses_are_those_of_the_robot(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["masses", str(model)]) == 0
    assert capsys.readouterr().out == TABLE


def test_an_option_of_run_writes_them_beside_the_mbs(model: Path) -> None:
    Path("tiny.yaml").write_text("source: tiny.urdf\noutput: out/tiny.mbs\n")
    assert main(["run", "tiny.yaml"]) == 0
    table = model.parent / "out" / "masses.csv"
    assert not table.exists()
    for words in (["run", "tiny.yaml"], ["convert", "tiny.urdf", "-o", "out/tiny.mbs"]):
        assert main([*words, "--masses"]) == 0
        assert table.read_text() == TABLE
        table.unlink()


def test_the_command_and_the_option_are_in_the_help(
    model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for command, text in (("masses", "urdf2mbs masses robot.mbs"), ("run", "--masses")):
        with pytest.raises(SystemExit):
            main([command, "--help"])
        assert text in " ".join(capsys.readouterr().out.split())


def test_a_wrong_file_is_an_error(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["masses", "tiny.urdf"]) == 1
    assert "tiny.urdf" in capsys.readouterr().err
    assert main(["masses", "missing.mbs"]) == 2
    assert "missing.mbs" in capsys.readouterr().err
