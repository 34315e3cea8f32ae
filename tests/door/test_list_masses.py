"""The example list_masses.py: a command of an installed package, with its help and its errors."""

import json
import sys
from pathlib import Path

import pytest

from installed import install_file
from urdf2mbs.cli import main

PLUGIN = Path(__file__).with_name("list_masses.py")


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
    rows = [line.split(" kg  ") for line in capsys.readouterr().out.splitlines()]
    assert [(float(mass), name) for mass, name in rows] == [
        (2.0, "body"), (0.5, "arm"), (0.1, "hand"), (2.6, "in all"),
    ]  # fmt: skip
    assert main(["masses", "--json", str(model)]) == 0
    masses = json.loads(capsys.readouterr().out)
    assert list(masses.items()) == [("body", 2.0), ("arm", 0.5), ("hand", 0.1)]


def test_the_command_is_listed_with_its_help(
    model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["masses", "--help"])
    text = " ".join(capsys.readouterr().out.split())
    assert "Prints the bodies, the heaviest first" in text
    assert "urdf2mbs masses robot.mbs --json" in text


def test_a_wrong_file_is_an_error(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["masses", "tiny.urdf"]) == 1
    assert "tiny.urdf" in capsys.readouterr().err
    assert main(["masses", "missing.mbs"]) == 2
    assert "missing.mbs" in capsys.readouterr().err
