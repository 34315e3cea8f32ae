"""The example pose_from_csv.py: the links start where the pose of the table puts them."""

from math import cos, pi, sin
from pathlib import Path

import pytest

from urdf2mbs import convert
from urdf2mbs.api import Result
from urdf2mbs.plugin import ConfigError, compute_placement
from urdf2mbs.testing import assert_same_robot

PLUGIN = Path(__file__).with_name("pose_from_csv.py")
BALL = """<link name="NAME"><inertial><mass value="1"/>
  <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>"""
JOINT = """<joint name="NAME_joint" type="TYPE"><parent link="PARENT"/><child link="NAME"/>
  <origin xyz="1 0 0"/><axis xyz="0 0 1"/>MIMIC</joint>"""


def write_robot(folder: Path, mimic: str = "") -> None:
    """Write an arm of three links of 1 m, which turn about z."""
    text = BALL.replace("NAME", "base")
    for parent, name in (("base", "upper"), ("upper", "lower"), ("lower", "tip")):
        kind = "fixed" if name == "tip" else "continuous"
        joint = JOINT.replace("NAME", name).replace("PARENT", parent).replace("TYPE", kind)
        text += BALL.replace("NAME", name)
        text += joint.replace("MIMIC", mimic if name == "lower" else "")
    (folder / "arm.urdf").write_text(f'<robot name="arm">{text}</robot>')


def pose(folder: Path, table: str) -> Result:
    (folder / "pose.csv").write_text(table)
    options = "{pose-from-csv: {file: pose.csv}, mimic: {joints: {'lower*': dependent}}}"
    if "mimic" not in (folder / "arm.urdf").read_text():
        options = "{pose-from-csv: {file: pose.csv}}"
    config = f"source: arm.urdf\nbase: fixed\npasses: {options}\nplugins: [{PLUGIN}]\n"
    (folder / "arm.yaml").write_text(config)
    return convert(folder / "arm.yaml")


def test_the_tip_is_where_the_angles_put_it(tmp_path: Path) -> None:
    write_robot(tmp_path)
    result = pose(tmp_path, f"upper_joint,0.3\nlower_joint,{pi / 2}\n")
    assert_same_robot(result)
    tip = compute_placement(result.mbs).bodies["tip"].xyz
    first, second = 0.3, 0.3 + pi / 2
    expected = (1 + cos(first) + cos(second), sin(first) + sin(second), 0.0)
    assert tip == pytest.approx(expected, abs=1e-12)


def test_a_follower_starts_where_its_leader_puts_it(tmp_path: Path) -> None:
    write_robot(tmp_path, '<mimic joint="upper_joint" multiplier="2"/>')
    joints = pose(tmp_path, "upper_joint,0.3\n").mbs.joints()
    assert joints["lower_joint"].q == pytest.approx(0.6)
    with pytest.raises(ConfigError, match=r"pose.csv:1: error\[pose-line\]: 'lower_joint,1'"):
        pose(tmp_path, "lower_joint,1\n")


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("uper_joint,1", "upper_joint"),
        ("tip_joint,1", ""),
        ("upper_joint,east", ""),
        ("upper_joint", ""),
        ("upper_joint,nan", ""),
        ("upper_joint,inf", ""),
        ("", ""),
    ],
)
def test_a_wrong_line_is_named(line: str, hint: str, tmp_path: Path) -> None:
    write_robot(tmp_path)
    with pytest.raises(ConfigError, match=r"pose.csv:2: error\[pose-line\]") as caught:
        pose(tmp_path, f"lower_joint,0\n{line}\nupper_joint,0\n")
    assert hint in (caught.value.hint or "")


def test_a_missing_table_is_named_with_its_line_of_the_config(tmp_path: Path) -> None:
    write_robot(tmp_path)
    pose(tmp_path, "")
    config = tmp_path / "arm.yaml"
    config.write_text(config.read_text().replace("pose.csv", "pase.csv"))
    with pytest.raises(ConfigError, match=r"arm.yaml:3: error\[pose-file\]: .*'pase.csv'"):
        convert(config)
