"""What is left out is told as values, once for each cause, in plain words."""

import json
from pathlib import Path

import pytest

from support.build import SOLID, joint, link, robot
from support.presets import PRESETS
from support.proving import codes
from urdf2mbs import convert
from urdf2mbs.testing import convert_text

LEADS = robot(
    *(link(name, SOLID) for name in "abc"),
    '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
    '<limit lower="-1.25" upper="0.1" effort="inf" velocity="3"/>'
    '<dynamics damping="0.7" friction="0.2"/><calibration rising="0.5"/>'
    '<safety_controller k_velocity="10" soft_lower_limit="-1"/></joint>'
    '<joint name="k" type="continuous"><parent link="b"/><child link="c"/>'
    '<mimic joint="j" multiplier="-2" offset="0.3"/></joint>',
)
VALUES = {
    "j": {
        "limit": {
            "lower": -1.25,
            "upper": 0.1,
            "effort": None,
            "velocity": 3.0,
            "acceleration": None,
            "deceleration": None,
            "jerk": None,
        },
        "dynamics": {
            "damping": 0.7,
            "friction": 0.2,
            "spring_stiffness": 0.0,
            "spring_reference": 0.0,
        },
        "safety_controller": {
            "k_velocity": 10.0,
            "k_position": 0.0,
            "soft_lower_limit": -1.0,
            "soft_upper_limit": 0.0,
        },
        "calibration": {"rising": 0.5, "falling": None},
    },
    "k": {"mimic": {"joint": "j", "multiplier": -2.0, "offset": 0.3}},
}


@pytest.mark.parametrize("pipeline", PRESETS)
def test_every_name_and_number_is_in_the_report(pipeline: str) -> None:
    report = convert_text(LEADS, pipeline=pipeline, without=["joint-parameters"]).report
    assert report.left_out == VALUES
    # the rest has found a place in user models
    assert convert_text(LEADS, pipeline=pipeline).report.left_out == {"k": VALUES["k"]}
    assert json.loads(json.dumps(report.left_out)) == VALUES


def test_all_frames_kept_needs_no_hint_to_keep_them(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text('<robot name="r"><link name="a"/></robot>')
    keep = {"prune-massless": {"keep": ["*"]}}
    for options in ({}, keep):
        found = convert(tmp_path / "r.urdf", passes=options).diagnostics
        (said,) = [one for one in found if one.level == "warning"]
        assert said.code == "no-mass"
        assert "keep" not in (said.hint or "")


@pytest.mark.parametrize("project", [False, True])
def test_of_a_fixed_joint_nothing_is_left_out(tmp_path: Path, project: bool) -> None:
    """Damping, friction and limits of a joint that does not move mean nothing."""
    text = LEADS.replace('type="revolute"', 'type="fixed"').replace("<mimic", "<nothing")
    source = tmp_path / "robot.urdf"
    source.write_text(text)
    result = convert(source, output={"project": tmp_path / "p"} if project else None)
    assert not codes(result) & {"joint-dynamics", "limit", "safety-controller", "calibration"}
    assert result.report.left_out == {}


@pytest.mark.parametrize("count", [80, 81])
def test_a_model_that_is_too_large_for_the_generator_is_told(count: int) -> None:
    chain = [link("l0"), *(link(f"l{n}", SOLID) for n in range(1, count + 1))]
    joints = (joint(f"l{n}", f"l{n + 1}") for n in range(count))
    found = convert_text(robot(*chain, *joints), base="fixed").diagnostics
    told = [one.message for one in found if one.code == "generator-limits"]
    assert len(told) == (count > 80)
    assert all("81 joints (80); " in message for message in told)


def test_damping_of_a_joint_that_is_left_out_is_said_once() -> None:
    """Nothing can be added for it in user_JointForces: massless-leaf says that it is not there."""
    text = robot(
        link("a", SOLID),
        link("b"),
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<dynamics damping="0.7"/></joint>',
    )
    said = codes(convert_text(text))
    assert "massless-leaf" in said
    assert "joint-dynamics-lost" not in said
