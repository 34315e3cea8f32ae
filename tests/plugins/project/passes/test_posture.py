"""Posture: the position that a simulation starts from."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from support.light_chains import convert_project, hinge, light_link, messages
from urdf2mbs import Result
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_project.simulation import Simulation


def group_states(folder: Path, text: str, state: str, **options: Any) -> Result:
    """TINY in a state of an SRDF file with this text."""
    (folder / "r.srdf").write_text(text)
    passes = {"srdf": str(folder / "r.srdf"), "state": state, **options}
    return convert_text(TINY, passes={"posture": passes})


def test_a_group_state(tmp_path: Path) -> None:
    """States of one name add up; what has no position, or no number, is named."""
    text = (
        '<robot name="tiny"><group_state name="home" group="a"><joint name="shoulder" '
        'value="0.5"/></group_state><group_state name="home" group="b"><joint name="wrist_pitch" '
        'value="-1.5"/><joint name="gone" value="1"/></group_state><group_state name="odd">'
        '<joint name="shoulder" value="0 0 1"/><joint name="wrist_pitch" value="inf"/>'
        '<joint name="wrist_roll" value="0.5"/></group_state></robot>'
    )
    result = group_states(tmp_path, text, "home", joints={"shoulder": 0.25})
    assert starts(result)["shoulder"] == 0.25
    assert starts(result)["wrist_pitch"] == -1.5
    told = messages(result)
    assert "is not used for gone: " in told["posture-state"]
    assert "wrist_pitch at -1.5 (not in [-1, 1] rad)" in told["posture-limit"]
    result = group_states(tmp_path, text, "odd")
    assert result.conversion.report["posture"] == {"wrist_roll": 0.5}
    assert "is not used for shoulder, wrist_pitch: " in messages(result)["posture-state"]
    with pytest.raises(ConfigError, match="no group state 'hoem'") as caught:
        group_states(tmp_path, text, "hoem")
    assert caught.value.hint == "did you mean 'home'?"
    with pytest.raises(ConfigError, match="is not XML") as caught:
        group_states(tmp_path, "<robot>\n<group_state>\n</robot>\n", "home")
    assert caught.value.line == 3


LIMITED = (
    '<robot name="r"><link name="world"/>'
    + light_link("a", 1.0, 0.01)
    + light_link("b", 1.0, 0.01)
    + hinge("one", "world", "a", '<limit lower="0.5" upper="1.5" effort="0" velocity="1"/>')
    + hinge(
        "two",
        "a",
        "b",
        '<limit lower="-4" upper="-1.8" effort="0" velocity="1"/>'
        '<mimic joint="one" multiplier="-2" offset="0.2"/>',
    )
    + "</robot>"
)


def starts(result: Result) -> dict[str, float]:
    return {j.name: j.q or 0.0 for body in result.mbs.bodies for j in body.joints}


def test_a_joint_starts_within_its_limits_and_those_of_its_followers(tmp_path: Path) -> None:
    result = convert_project(LIMITED, tmp_path)
    assert starts(result)["one"] == pytest.approx(1.0)
    assert starts(result)["two"] == pytest.approx(-1.8)
    told = messages(result)["posture-limit"]
    assert "one at 1 (0 is not in [0.5, 1.5] rad)" in told
    assert "two at -1.8 (0.2 is not in [-4, -1.8] rad)" in told
    # asked for, or only a file: it stays, and is told
    result = convert_project(LIMITED, tmp_path, posture={"inside": False})
    assert starts(result)["one"] == 0.0
    assert "posture-limit" in messages(result)
    result = convert_text(LIMITED)
    assert starts(result)["one"] == 0.0
    assert "one at 0 (not in [0.5, 1.5] rad)" in messages(result)["posture-limit"]


def test_the_hint_has_the_middle_ready_to_paste(tmp_path: Path) -> None:
    """Of what leads; a follower is where its leader puts it."""
    (told,) = [d for d in convert_text(LIMITED).diagnostics if d.code == "posture-limit"]
    line = (told.hint or "").split("'")[1]
    assert yaml.safe_load(line) == {"passes": {"posture": {"joints": {"one": 1.0}}}}
    pasted = yaml.safe_load(line)["passes"]
    assert "one at" not in messages(convert_text(LIMITED, passes=pasted)).get("posture-limit", "")
    assert not [
        d
        for d in convert_text(LIMITED.replace(' upper="1.5"', ' upper="inf"')).diagnostics
        if "middle" in (d.hint or "")
    ]


def test_only_the_joints_that_are_named_are_held() -> None:
    options = {"posture": {"hold": {"joints": ["wrist_*"]}}}
    result = convert_text(TINY, passes=options)
    names = [held.joint.name for held in result.conversion.state(Simulation).hold]
    assert names == ["wrist_roll", "wrist_pitch"]


def test_ros2_control_says_where_joints_start() -> None:
    def control(value: str) -> str:
        return (
            '<ros2_control name="c" type="system"><joint name="wrist_pitch">'
            '<state_interface name="velocity"><param name="initial_value">9</param>'
            '</state_interface><state_interface name="position">'
            f'<param name="initial_value">{value}</param></state_interface></joint>'
            '<joint name="nobody"><state_interface name="position"><param name="initial_value">1'
            "</param></state_interface></joint></ros2_control></robot>"
        )

    for value, options, start in (
        ("0.25", {}, 0.25),
        ("0.25", {"from_urdf": False}, 0.0),
        ("0.25", {"joints": {"wrist_*": 0.5}}, 0.5),
        ("${q}", {}, 0.0),
    ):
        text = TINY.replace("</robot>", control(value))
        result = convert_text(text, passes={"posture": options})
        assert starts(result)["wrist_pitch"] == start
        told = [d.message for d in result.diagnostics if d.code == "posture-urdf"]
        assert told == ["joints start where <ros2_control> says: wrist_pitch at 0.25"] * bool(
            value == "0.25" and options.get("from_urdf", True)
        )
        assert ("number-left-out" in [d.code for d in result.diagnostics]) == (value == "${q}")


def test_a_follower_that_an_mbs_cannot_bind_starts_by_its_rule() -> None:
    text = LIMITED.replace('"two"', '"hang"')
    positions = starts(convert_text(text, passes={"posture": {"joints": {"one": 0.25}}}))
    assert positions == {**positions, "one": 0.25, "hang": -0.3}


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("hang", "joint 'hang' follows another joint"),
        ("stuck", "joint 'stuck' has no position of its own"),
        ("flag", "joint 'flag' is not in the .mbs: "),
        ("nobody", "no joint is called 'nobody'"),
    ],
)
def test_joints_that_have_no_position(tmp_path: Path, name: str, says: str) -> None:
    text = LIMITED.replace('"two"', '"hang"').replace(
        "</robot>",
        '<link name="c"/><joint name="stuck" type="fixed"><parent link="b"/><child link="c"/>'
        '</joint><link name="d"/><joint name="flag" type="continuous"><parent link="b"/>'
        '<child link="d"/></joint></robot>',
    )
    with pytest.raises(ConfigError) as caught:
        convert_project(text, tmp_path, posture={"joints": {name: 1.0}})
    assert says in caught.value.message


@pytest.mark.parametrize(
    ("low", "high", "middle"),
    [
        (0.5, 1.5, 1.0),
        (0.1234, 0.12346, 0.12343),
        (-3.0, -1.0, -2.0),
        (1.0, 1.0046, 1.0023),
        (0.9972, 1.0072, 1.0),
        (0.9982, 1.0062, 1.0022),
    ],
)
def test_the_middle_is_short_and_within_the_limits(low: float, high: float, middle: float) -> None:
    """In few digits where few will do."""
    text = TINY.replace('lower="-1" upper="1"', f'lower="{low}" upper="{high}"')
    assert f'"{high}"' in text
    (warning,) = [d for d in convert_text(text).diagnostics if d.code == "posture-limit"]
    assert f": {middle!r}}}" in (warning.hint or "")


@pytest.mark.parametrize(("beyond", "told"), [(1e-10, False), (1e-6, True)])
@pytest.mark.parametrize(("limit", "side"), [(1.5, 1), (1.0, -1)])
def test_what_rounding_adds_is_not_beyond_a_limit(
    limit: float, side: int, beyond: float, told: bool, tmp_path: Path
) -> None:
    text = LIMITED.replace('"0.5"', '"1"')
    start = limit + side * beyond
    result = convert_project(text, tmp_path, posture={"joints": {"one": start}})
    assert ("one at" in messages(result).get("posture-limit", "")) is told
    assert starts(result)["one"] == (limit if told else start)


@pytest.mark.parametrize(
    ("start", "kind", "told"),
    [
        (6.2, "revolute", False),
        (-6.4, "revolute", True),
        (6.4, "revolute", True),
        (6.4, "prismatic", False),
    ],
)
def test_a_start_in_degrees_is_told_to_be_in_rad(start: float, kind: str, told: bool) -> None:
    text = LIMITED.replace('name="one" type="revolute"', f'name="one" type="{kind}"')
    texts = messages(convert_text(text, passes={"posture": {"joints": {"one": start}}}))
    assert ("; positions are in rad)" in texts["posture-limit"]) is told
    unit = "m" if kind == "prismatic" else "rad"
    assert f"one at {start} (not in [0.5, 1.5] {unit}" in texts["posture-limit"]


def test_a_follower_starts_by_its_rule_without_this_pass_too(tmp_path: Path) -> None:
    result = convert_text(LIMITED, output={"project": tmp_path / "robot"}, without=["posture"])
    assert starts(result) == {"one": 0.0, "two": 0.2}


@pytest.mark.parametrize(("count", "listed"), [(10, True), (11, False)])
def test_the_middles_of_many_joints_are_no_hint(count: int, listed: bool) -> None:
    text = '<robot name="r"><link name="l"/>' + "".join(
        light_link(f"l{n}", 1.0, 0.01)
        + hinge(f"j{n}", "l", f"l{n}", '<limit lower="1" upper="2" effort="0" velocity="1"/>')
        for n in range(count)
    )
    (warning,) = [
        d for d in convert_text(f"{text}</robot>").diagnostics if d.code == "posture-limit"
    ]
    assert ('"j0": 1.5' in (warning.hint or "")) is listed
    assert ("'urdf2mbs init' writes a config" in (warning.hint or "")) is not listed


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [("-inf", "-1", True), ("1", "inf", True), ("2", "2", False), ("2", "-1", False)],
)
def test_limits_that_are_missing_or_leave_no_room(low: str, high: str, told: bool) -> None:
    text = TINY.replace('lower="-1" upper="1"', f'lower="{low}" upper="{high}"')
    assert ("posture-limit" in messages(convert_text(text))) is told
