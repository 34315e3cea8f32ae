"""Expand: the robot as its file states it, xacro expanded, what was found told."""

from pathlib import Path

from support.build import SOLID, joint, link, robot
from urdf2mbs import Result, convert


def expanded(source: Path, text: str, **settings: object) -> Result:
    source.write_text(text)
    return convert(source, pipeline=["expand"], **settings)


def test_what_the_reader_found_is_told_once(tmp_path: Path) -> None:
    text = robot(link("a", SOLID), link("b", SOLID), joint("a", "b", "revolute"))
    result = expanded(tmp_path / "r.urdf", text.replace("<limit", "<lmit"))
    assert [diagnostic.code for diagnostic in result.diagnostics].count("joint-limit-missing") == 1
