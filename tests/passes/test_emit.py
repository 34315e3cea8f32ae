"""Emit: the file itself: order, names, frames, view, and what .mbs has no place for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from making import passes_of
from proving import SOLID, joint, link, robot

from urdf2mbs import Result
from urdf2mbs.mbs.reader import read
from urdf2mbs.testing import TINY, convert_text

A, B, C, D = (link(name, SOLID) for name in "abcd")


def emitted(*elements: str, **settings: Any) -> Result:
    return convert_text(robot(link("world"), *elements), **settings)


def names(result: Result) -> list[str]:
    return [body.name for body in result.mbs.bodies]


def test_bodies_on_the_bases_origin_stand_before_those_on_points() -> None:
    """As MBSysPad numbers joints when it saves: else their numbers would change under the user."""
    result = emitted(A, B, joint("world", "a", xyz="1 0 0"), joint("world", "b"))
    assert names(result) == ["b", "a"]
    assert result.mbs.numbers() == {"world_to_b": 1, "world_to_a": 2}


def test_a_branch_stands_before_the_next() -> None:
    result = emitted(
        A, B, C, D,
        joint("world", "a", xyz="1 0 0"), joint("world", "b", xyz="2 0 0"),
        joint("a", "c", xyz="1 0 0"), joint("b", "d", xyz="1 0 0"),
    )  # fmt: skip
    assert names(result) == ["a", "c", "b", "d"]


@pytest.mark.parametrize("pipeline", ["faithful", "compact"])
def test_the_order_is_the_one_of_the_files_own_points(pipeline: str) -> None:
    """lump-fixed brings a body's children together from several links."""
    result = emitted(
        A, B, C, D,
        joint("world", "a", xyz="0 0 1"), joint("a", "b", "fixed", xyz="1 0 0"),
        joint("b", "c", xyz="1 0 0"), joint("a", "d", xyz="2 0 0"),
        pipeline=pipeline,
    )  # fmt: skip
    found = read(result.data, "r.mbs")
    assert [body.name for body in found.bodies] == [body.name for body in found.depth_first()]


def test_the_file_is_the_model() -> None:
    result = convert_text(TINY)
    found = read(result.data, "tiny.mbs")
    assert found.name == "robot"  # the file's stem
    assert found.base.name == "ground"
    assert [body.name for body in found.bodies] == names(result)
    assert found.view is not None


@pytest.mark.parametrize(
    ("element", "code", "level"),
    [
        ('<dynamics damping="0.1"/>', "joint-dynamics-lost", "warning"),
        ('<dynamics friction="0.1"/>', "joint-dynamics-lost", "warning"),
        ('<safety_controller k_velocity="1"/>', "safety-controller", "note"),
        ('<calibration rising="1"/>', "calibration", "note"),
    ],
)
def test_what_an_mbs_has_no_place_for(element: str, code: str, level: str) -> None:
    """Without joint-parameters, which finds a place for it."""
    holding = joint("world", "a", name="j").replace("</joint>", f"{element}</joint>")
    pipeline = [one for one in passes_of("faithful") if one != "joint-parameters"]
    found = {d.code: d for d in emitted(A, holding, pipeline=pipeline).diagnostics}
    assert found[code].level == level
    assert found[code].message.endswith("1 joint: j")
    assert found["limit"].level == "note"
    codes = {d.code for d in emitted(A, holding).diagnostics}
    assert not codes & {"limit", "safety-controller", "calibration"}


def test_no_damping_is_not_told_of() -> None:
    holding = joint("world", "a").replace("</joint>", '<dynamics damping="0"/></joint>')
    assert "joint-dynamics-lost" not in [d.code for d in emitted(A, holding).diagnostics]


def test_other_programs_elements_are_counted() -> None:
    text = robot(link("world"), A, joint("world", "a"), "<gazebo/>", "<gazebo/>", "<transmission/>")
    (told,) = [d for d in convert_text(text).diagnostics if d.code == "extension"]
    assert told.level == "note"
    assert "gazebo" in told.message
    assert "transmission" in told.message


def test_the_same_bytes_every_time(tmp_path: Path) -> None:
    assert convert_text(TINY).data == convert_text(TINY).data


def test_mimics_are_named_with_their_rule_and_frozen_ones_are_not() -> None:
    follow = joint("a", "b", name="k").replace(
        "</joint>", '<mimic joint="j" multiplier="-2" offset="0.5"/></joint>'
    )
    (told,) = [
        d for d in emitted(A, B, joint("world", "a", name="j"), follow).diagnostics
        if d.code == "mimic"
    ]  # fmt: skip
    assert "k = -2.0 * j + 0.5" in told.message
    massless = emitted(A, link("b"), joint("world", "a", name="j"), follow)
    codes = [d.code for d in massless.diagnostics]
    assert "massless-leaf" in codes
    assert "mimic" not in codes
