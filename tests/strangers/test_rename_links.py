"""samples/rename_links.py, used as a lab would: named by a config, from outside the package."""

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY, assert_same_robot, run_pass

PLUGIN = Path(__file__).with_name("samples") / "rename_links.py"


def rename(robot: str = TINY, **options: Any) -> Any:
    return run_pass("rename-links", PLUGIN, options=options, robot=robot)


def test_by_table_and_by_pattern() -> None:
    result = rename(
        links={"body": "pelvis"}, joints={"shoulder": "s1"},
        link_patterns={"^(.*)m$": r"left_\1m", "o": "0"}, joint_patterns={"wrist_": "w"},
    )  # fmt: skip
    assert list(result.robot.links) == ["ground", "pelvis", "left_arm", "wrist", "hand", "t00l"]
    assert list(result.robot.joints) == [
        "floating_base", "s1", "wroll", "wpitch", "tool_mount",
    ]  # fmt: skip
    assert {body.name for body in result.mbs.bodies} == {"pelvis", "left_arm", "hand"}
    assert result.names.coordinates["wroll"] == ["wroll"]
    assert_same_robot(result)


REFERENCES = """
  <transmission name="t">
    <joint name="shoulder"><link name="arm"/></joint>
    <actuator name="arm"/>
  </transmission>
  <gazebo reference="shoulder"><a/></gazebo>
  <gazebo><plugin name="shoulder"/></gazebo>
</robot>
"""


def test_all_references_follow() -> None:
    text = TINY.replace("</robot>", REFERENCES).replace(
        '<axis xyz="1 0 0"/>', '<axis xyz="1 0 0"/><mimic joint="shoulder" multiplier="2"/>'
    )
    result = rename(text, links={"hand": "palm", "arm": "left_arm"}, joints={"shoulder": "s1"})
    robot = result.robot
    assert robot.joints["wrist_pitch"].child == "palm"
    assert robot.joints["wrist_roll"].parent == "left_arm"
    mimic = robot.joints["wrist_roll"].mimic
    assert mimic is not None
    assert mimic.joint == "s1"
    hand, transmission, joint, plugin = robot.extensions
    assert hand.reference == "palm"
    assert hand.xml == '<gazebo reference="palm"><mu1>0.9</mu1></gazebo>'
    assert '<joint name="s1"><link name="left_arm"/></joint>' in transmission.xml
    assert '<actuator name="arm"/>' in transmission.xml
    assert joint.reference == "s1"
    assert plugin.xml == '<gazebo><plugin name="shoulder"/></gazebo>'


def test_two_names_may_change_places() -> None:
    result = rename(links={"arm": "hand", "hand": "arm"})
    assert result.robot.joints["shoulder"].child == "hand"
    assert result.robot.joints["wrist_pitch"].child == "arm"
    assert_same_robot(result)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"links": {"arn": "x"}}, r"rename-unknown.*no link 'arn'\n.*did you mean 'arm'"),
        ({"joints": {"arm": "x"}}, r"rename-unknown.*no joint 'arm'"),
        ({"links": {"arm": "hand"}}, r"rename-doubled.*links 'arm' and 'hand' would both"),
        ({"link_patterns": {"arm|hand": "x"}}, r"rename-doubled.*under 'links'"),
        ({"link_patterns": {"(": "x"}}, r"rename-pattern.*pattern '\(': missing \)"),
        ({"link_patterns": {"a": r"\1"}}, r"rename-pattern.*invalid group reference"),
        ({"link_patterns": {".*": ""}}, r"rename-empty.*link 'body' would have no name"),
        ({"table": {}}, r"unknown-key.*unknown key 'passes.rename-links.table'"),
    ],
)
def test_what_cannot_be_meant_is_an_error(options: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=f"(?s){said}"):
        rename(**options)
