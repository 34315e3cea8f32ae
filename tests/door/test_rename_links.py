"""The example rename_links.py: names change, and all that refers to them; the robot does not."""

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.plugin import ConfigError
from urdf2mbs.testing import TINY, assert_same_robot, convert_text, run_pass

PLUGIN = Path(__file__).with_name("rename_links.py")


def rename(robot: str = TINY, **options: Any) -> Any:
    return run_pass("rename-links", PLUGIN, options=options, robot=robot)


def test_names_change_and_the_robot_does_not() -> None:
    result = rename(links={"body": "pelvis"}, joints={"shoulder": "s1"})
    assert list(result.robot.links) == ["ground", "pelvis", "arm", "wrist", "hand", "tool"]
    assert {body.name for body in result.mbs.bodies} == {"pelvis", "arm", "hand"}
    assert result.names.coordinates["s1"] == ["s1"]
    assert_same_robot(result)
    renamed = result.data.replace(b"pelvis", b"body").replace(b"s1", b"shoulder")
    assert [line.strip() for line in renamed.splitlines() if b"name>" in line] == [
        line.strip() for line in convert_text().data.splitlines() if b"name>" in line
    ]


REFERENCES = """
  <transmission name="t">
    <joint name="shoulder"><link name="arm"/></joint>
    <actuator name="arm"/>
  </transmission>
  <gazebo reference="shoulder"><a/></gazebo>
  <gazebo reference="hand"><sensor name="imu" type="imu"/></gazebo>
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
    hand, transmission, joint, imu, plugin = robot.extensions
    assert hand.reference == "palm"
    assert hand.xml == '<gazebo reference="palm"><mu1>0.9</mu1></gazebo>'
    assert '<joint name="s1"><link name="left_arm"/></joint>' in transmission.xml
    assert '<actuator name="arm"/>' in transmission.xml
    assert joint.reference == "s1"
    assert all(sensor.on == "palm" for sensor in imu.sensors)
    assert plugin.xml == '<gazebo><plugin name="shoulder"/></gazebo>'


def test_two_names_may_change_places() -> None:
    result = rename(links={"arm": "hand", "hand": "arm"})
    assert result.robot.joints["shoulder"].child == "hand"
    assert result.robot.joints["wrist_pitch"].child == "arm"
    assert_same_robot(result)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"links": {"arn": "x"}}, r"rename-unknown.*no link 'arn' to rename\n.*mean 'arm'"),
        ({"joints": {"arm": "x"}}, r"rename-unknown.*no joint 'arm'"),
        ({"links": {"arm": "hand"}}, r"rename-doubled.*links 'arm' and 'hand' would both"),
        ({"links": {"arm": ""}}, r"rename-doubled.*link 'arm' would have no name"),
        ({"table": {}}, r"unknown-key.*unknown key 'passes.rename-links.table'"),
    ],
)
def test_a_wrong_table_is_an_error(options: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=f"(?s){said}"):
        rename(**options)
