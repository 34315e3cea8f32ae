"""What the command `diff` prints, and its exit codes."""

import json
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs import convert
from urdf2mbs.cli import main


@pytest.fixture
def pair(here: Path) -> Path:
    """The folder of a.mbs, and of b.mbs, which is heavier and drawn elsewhere."""
    data = convert("tiny.urdf").data
    (here / "a.mbs").write_bytes(data)
    assert b"<mass>0.5</mass>" in data
    (here / "b.mbs").write_bytes(data.replace(b"<mass>0.5</mass>", b"<mass>0.75</mass>"))
    (here / "drawn.mbs").write_bytes(data.replace(b"transparency>0.0", b"transparency>0.5"))
    return here


def test_exit_codes_are_those_of_diff(pair: Path, capsys: Any) -> None:
    assert main(["diff", "a.mbs", "a.mbs"]) == 0
    assert capsys.readouterr().out == "a.mbs -> a.mbs: no difference\n"
    assert main(["diff", "a.mbs", "b.mbs"]) == 1
    out = capsys.readouterr().out.splitlines()
    assert out == [
        "a.mbs -> b.mbs: 1 difference",
        "  body 'arm': mass 0.5 -> 0.75 kg",
    ]
    assert main(["diff", "a.mbs", "absent.mbs"]) == 2
    (pair / "broken.mbs").write_text("<mbsDescR7>\n<base>")
    assert main(["diff", "a.mbs", "broken.mbs"]) == 2
    assert "broken.mbs:2: error[" in capsys.readouterr().err


def test_numbers_are_said_as_people_write_them(pair: Path, capsys: Any) -> None:
    data = (pair / "a.mbs").read_bytes()
    for spelling, shown in (
        ("3.5999999999999996", "0.5 -> 3.6"),
        ("0.5000000000000001", "0.5 -> 0.50"),
    ):
        (pair / "b.mbs").write_bytes(data.replace(b"<mass>0.5<", f"<mass>{spelling}<".encode()))
        assert main(["diff", "a.mbs", "b.mbs"]) == 1
        assert f"mass {shown}" in capsys.readouterr().out


def test_what_is_drawn_is_counted_listed_or_left_out(pair: Path, capsys: Any) -> None:
    assert main(["diff", "a.mbs", "drawn.mbs"]) == 1
    out = capsys.readouterr().out
    assert "no difference, but for the drawing" in out
    assert "transparency" not in out
    assert main(["diff", "a.mbs", "drawn.mbs", "--drawing"]) == 1
    assert "transparency 0 -> 0.5" in capsys.readouterr().out
    assert main(["diff", "a.mbs", "drawn.mbs", "--physics"]) == 0


def test_diff_prints_json(pair: Path, capsys: Any) -> None:
    assert main(["diff", "a.mbs", "b.mbs", "--json"]) == 1
    text = json.loads(capsys.readouterr().out)
    assert text["same"] is False
    assert text["differences"]["changes"] == [
        {
            "change": "changed",
            "kind": "body",
            "name": "arm",
            "field": "mass",
            "before": 0.5,
            "after": 0.75,
        }
    ]
