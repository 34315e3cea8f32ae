"""What the command `simulate` says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main


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


def test_an_mbs_alone_becomes_a_project(here: Path, capsys: Any) -> None:
    assert main(["convert", "tiny.urdf", "-o", "tiny.mbs"]) == 0
    words = ["simulate", "tiny.mbs", "-o", "alone", "--time", "0.02", "--language", "python"]
    assert main(words) == 0
    assert Path("alone/dataR/tiny.mbs").read_bytes() == Path("tiny.mbs").read_bytes()
    assert Path("alone/resultsR/dirdyn_q.res").is_file()
    assert not Path("resultsR").exists()
    assert main(["simulate", "alone", *words[2:]]) == 2
    assert "is a project already" in capsys.readouterr().err
