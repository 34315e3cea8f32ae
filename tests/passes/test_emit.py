"""Emit: the file itself: order, names, frames, view, and what .mbs has no place for."""

from typing import Any

import pytest

from support.build import SOLID, joint, link, robot
from support.plugin_files import passes_of
from support.presets import PRESETS
from support.proving import codes
from urdf2mbs import Result
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import convert_text

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


@pytest.mark.parametrize("pipeline", PRESETS)
@pytest.mark.parametrize(
    "joints",
    [
        (
            joint("world", "a", xyz="1 0 0"),
            joint("world", "b", xyz="2 0 0"),
            joint("a", "c", xyz="1 0 0"),
            joint("b", "d", xyz="1 0 0"),
        ),
        # lump-fixed brings a body's children together from several links
        (
            joint("world", "a", xyz="0 0 1"),
            joint("a", "b", "fixed", xyz="1 0 0"),
            joint("b", "c", xyz="1 0 0"),
            joint("a", "d", xyz="2 0 0"),
        ),
    ],
)
def test_a_branch_stands_before_the_next(pipeline: str, joints: tuple[str, ...]) -> None:
    result = emitted(A, B, C, D, *joints, pipeline=pipeline)
    found = read_mbs(result.data, "r.mbs")
    assert [body.name for body in found.bodies] == [body.name for body in found.depth_first()]


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
    found = {
        diagnostic.code: diagnostic
        for diagnostic in emitted(A, holding, pipeline=pipeline).diagnostics
    }
    assert found[code].level == level
    assert found["limit"].level == "note"
    assert not codes(emitted(A, holding)) & {"limit", "safety-controller", "calibration"}
