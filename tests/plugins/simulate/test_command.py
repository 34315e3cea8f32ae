"""What the command `simulate` says."""

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main


@pytest.mark.parametrize(
    ("base", "said"),
    [
        ("floating", "moved most: 0.00196 m\n  nothing holds it: 'base: fixed' bolts it down"),
        ("fixed", " rad\n  alone/"),
    ],
)
def test_a_robot_that_falls_is_told_what_holds_it(
    base: str, said: str, here: Path, capsys: Any
) -> None:
    assert main(["convert", "tiny.urdf", "-o", "tiny.mbs", "--base", base]) == 0
    assert main(["simulate", "tiny.mbs", "-o", "alone/", "--time", "0.02"]) == 0
    assert said in capsys.readouterr().out


def test_a_robot_without_feet_rests_on_the_ground(here: Path, capsys: Any) -> None:
    assert main(["simulate", "tiny.urdf", "-o", "s/", "--time", "0.02"]) == 0
    out = capsys.readouterr().out
    assert "no feet: nobody knows if its base floats; all that is solid touches the ground" in out
    assert "nothing holds it" not in out


def test_an_mbs_alone_becomes_a_project(here: Path, capsys: Any) -> None:
    assert main(["convert", "tiny.urdf", "-o", "tiny.mbs"]) == 0
    words = ["simulate", "tiny.mbs", "-o", "alone", "--time", "0.02", "--language", "python"]
    assert main(words) == 0
    assert Path("alone/dataR/tiny.mbs").read_bytes() == Path("tiny.mbs").read_bytes()
    assert Path("alone/resultsR/dirdyn_q.res").is_file()
    assert not Path("resultsR").exists()
    assert main(["simulate", "alone", *words[2:]]) == 2
    assert "is a project already" in capsys.readouterr().err
