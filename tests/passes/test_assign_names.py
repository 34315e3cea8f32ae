"""Assign names: identifiers, and where each link's frame is."""

from typing import Any

from support.build import SOLID, joint, link, robot
from urdf2mbs import Result
from urdf2mbs.testing import TINY, convert_text

A, B = link("a", SOLID), link("b", SOLID)


def emitted(*elements: str, **settings: Any) -> Result:
    return convert_text(robot(link("world"), *elements), **settings)


def test_names_become_identifiers_and_the_map_says_which() -> None:
    result = emitted(
        link("left foot", SOLID), joint("world", "left foot", name="2nd-joint", axis="0 1 1")
    )
    assert result.names.bodies == {"left foot": "left_foot"}
    assert result.names.coordinates == {"2nd-joint": ["n_2nd_joint"]}
    assert result.names.joints == {
        "2nd-joint": ["n_2nd_joint_axis_R1", "n_2nd_joint", "n_2nd_joint_back_R1"]
    }
    assert result.mbs.name == "robot"


def test_a_fixed_joint_has_joints_and_no_coordinates() -> None:
    result = emitted(A, B, joint("world", "a"), joint("a", "b", "fixed"))
    assert result.names.joints["a_to_b"] == ["a_to_b"]
    assert "a_to_b" not in result.names.coordinates


def test_every_link_has_a_frame() -> None:
    result = convert_text(TINY)
    assert set(result.frames) == set(result.robot.links)
    assert result.frames["ground"].body is None
    assert (result.frames["wrist"].body, result.frames["wrist"].joint) == ("hand", "wrist_roll")
    assert (result.frames["tool"].body, result.frames["tool"].joint) == ("hand", None)
    assert result.frames["tool"].pose.xyz == (0.0, 0.0, 0.1)
