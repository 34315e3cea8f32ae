"""Decompose joints: URDF joints as chains of .mbs joints, each by the method's rules."""

import numpy as np
import pytest
from msgspec.structs import replace

from support.build import SOLID, joint, link, robot
from urdf2mbs import Result
from urdf2mbs.passes.decompose_joints import DecomposeJoints
from urdf2mbs.testing import convert_text

PASSES = ["expand", "insert-base", "prune-massless", "decompose-joints"]


def decomposed(*joints: str) -> Result:
    links = (link(name, SOLID) for name in "ab"[: len(joints)])
    return convert_text(robot(link("world"), *links, *joints), pipeline=PASSES)


def chain(**given_: str) -> list[tuple[str, str, float | None]]:
    """Name, type (in lower case if driven) and position of a joint's joints."""
    (body,) = decomposed(joint("world", "a", name="j", **given_)).mbs.bodies
    return [(j.name, j.type.lower() if j.nature == "driven" else j.type, j.q) for j in body.joints]


@pytest.mark.parametrize(
    ("kind", "axis", "found"),
    [
        ("continuous", "1 0 0", ["R1"]),
        ("revolute", "0 5 0", ["R2"]),
        ("prismatic", "0 0 1e-3", ["T3"]),
        ("fixed", "0 0 1", ["t3"]),
        ("floating", "0 0 1", ["T1", "T2", "T3", "R1", "R2", "R3"]),
        ("planar", "0 0 1", ["T1", "T2", "R3"]),
        ("planar", "0 1 0", ["T3", "T1", "R2"]),
        ("planar", "1 0 0", ["T2", "T3", "R1"]),
        ("continuous", "-1 0 0", ["r3", "R1", "r3"]),
        ("prismatic", "0 -1 0", ["r1", "T2", "r1"]),
        ("continuous", "0 0 -1", ["r2", "R3", "r2"]),
        ("continuous", "0 1 1", ["r1", "R2", "r1"]),
        ("continuous", "1 0 1", ["r2", "R3", "r2"]),
        ("continuous", "1 1 0", ["r3", "R1", "r3"]),
        ("continuous", "1 2 3", ["r3", "r2", "R1", "r2", "r3"]),
    ],
)
def test_a_joint_becomes_joints_of_these_types(kind: str, axis: str, found: list[str]) -> None:
    assert [type_ for _, type_, _ in chain(kind=kind, axis=axis)] == found


def test_the_joints_of_an_oblique_axis_have_names_and_positions() -> None:
    a, b = np.arctan2(2, 1), -np.arctan2(3, np.hypot(1, 2))
    found = chain(axis="1 2 3", rpy="0.1 0.2 0.3", xyz="1 2 3")
    assert [(name, type_) for name, type_, _ in found] == [
        ("j_origin_R3", "r3"),
        ("j_origin_R2", "r2"),
        ("j_origin_R1", "r1"),
        ("j_axis_R3", "r3"),
        ("j_axis_R2", "r2"),
        ("j", "R1"),
        ("j_back_R2", "r2"),
        ("j_back_R3", "r3"),
    ]
    assert [q for *_, q in found[:3]] == [0.3, 0.2, 0.1]  # the URDF's own numbers
    assert [q for *_, q in found[3:]] == pytest.approx([a, b, None, -b, -a], abs=1e-15)


def test_driven_joints_keep_only_q_and_real_ones_everything() -> None:
    (body,) = decomposed(joint("world", "a", axis="0 1 1", rpy="0.1 0 0")).mbs.bodies
    for one in body.joints:
        assert one.symbols == (("q",) if one.nature == "driven" else None)
        assert (one.q is None) == (one.nature == "independent")
        assert not one.actuated


def test_a_urdf_joint_keeps_its_name_and_ours_gives_way() -> None:
    result = decomposed(
        joint("world", "a", name="j", rpy="0 0 1"), joint("a", "b", name="j_origin_R3")
    )
    first, second = result.mbs.bodies
    assert [one.name for one in first.joints] == ["j_origin_R3_2", "j"]
    assert [one.name for one in second.joints] == ["j_origin_R3"]


@pytest.mark.parametrize(
    ("axis", "told"),
    [("0 1e-10 1", True), ("0 0.9e-9 1", True), ("0 2e-9 1", False), ("0 0 1", False)],
)
def test_an_axis_that_is_moved_is_told_of(axis: str, told: bool) -> None:
    codes = [
        diagnostic.code for diagnostic in decomposed(joint("world", "a", axis=axis)).diagnostics
    ]
    assert ("axis-aligned" in codes) is told


@pytest.mark.parametrize("kind", ["fixed", "floating"])
@pytest.mark.parametrize("axis", ["0 0 0", "0 1e-10 1", "1 2 3"])
def test_a_joint_without_axis_has_none_whatever_the_file_says(kind: str, axis: str) -> None:
    result = decomposed(joint("world", "a", kind, axis=axis, name="j"))
    (body,) = result.mbs.bodies
    assert len(body.joints) == (1 if kind == "fixed" else 6)
    assert "axis-aligned" not in [diagnostic.code for diagnostic in result.diagnostics]


def test_the_axis_of_a_joint_that_a_pass_has_fixed_means_nothing() -> None:
    conversion = decomposed(joint("world", "a", axis="0 1e-10 1")).conversion
    (step,) = conversion.steps()
    step.joint = replace(step.joint, type="fixed")
    assert conversion.settle("axis-aligned") == 1
    DecomposeJoints().run(conversion)
    assert conversion.settle("axis-aligned") == 0


def test_two_of_our_own_names_that_meet_stay_apart() -> None:
    """The turns before an axis, and the coordinates of a planar joint of an unlucky name."""
    links = (link("world"), link("a", SOLID), link("b", SOLID))
    first = joint("world", "a", name="hip", axis="1 2 3")
    text = robot(*links, first, joint("a", "b", "planar", name="hip_axis"))
    bodies = convert_text(text, pipeline=PASSES).mbs.bodies
    names = [one.name for body in bodies for one in body.joints]
    assert "hip_axis_R3" in names
    assert len(set(names)) == len(names)
