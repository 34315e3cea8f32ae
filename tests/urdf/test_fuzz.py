"""Whatever is in the file: a robot or one error, never anything else."""

import random
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.examples import reproducible
from support.urdf_files import WORDS
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.reader import parse_urdf

ROBOT = b"""<?xml version="1.0"?>
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="a"><inertial><origin xyz="0 0 1" rpy="0 1e-3 0"/><mass value="2.5"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><mesh filename="package://p/m.stl" scale="1 1 1"/></geometry>
    <material name="red"/></visual><collision><geometry><box size="1 2 3"/></geometry></collision>
  </link>
  <link name="b"/>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="k" offset="1"/></joint>
  <link name="c"/>
  <joint name="k" type="prismatic"><parent link="b"/><child link="c"/></joint>
  <gazebo reference="a"><b c="d">&lt;</b></gazebo>
</robot>
"""

few = settings(reproducible, max_examples=150)


def check(data: bytes) -> None:
    for files in ((), ("r.xacro",)):
        try:
            robot, diagnostics = parse_urdf(data, "r.urdf", expanded=files)
        except ConversionError as error:
            code, text = error.code, str(error)
            assert re.fullmatch("[a-z-]+", code)
            assert "r.urdf" in text
        else:
            assert robot.links
            assert len(robot.depth_first()) == len(robot.joints) == len(robot.links) - 1
            assert len(list(map(str, diagnostics))) < 100


@few
@given(st.binary(max_size=200))
def test_any_bytes(data: bytes) -> None:
    check(data)


@few
@given(st.integers(0, len(ROBOT)))
def test_cut_anywhere(length: int) -> None:
    if length >= len(ROBOT.rstrip()):
        check(ROBOT[:length])
        return
    with pytest.raises(ConversionError) as caught:
        parse_urdf(ROBOT[:length], "r.urdf")
    assert caught.value.code in ("xml-truncated", "file-empty", "not-xml")


@few
@given(
    st.lists(
        st.tuples(st.integers(0, len(ROBOT)), st.integers(0, 12), st.sampled_from(WORDS)),
        min_size=1,
        max_size=4,
    )
)
def test_pieces_replaced(changes: list[tuple[int, int, bytes]]) -> None:
    data = ROBOT
    for start, length, word in changes:
        data = data[:start] + word + data[start + length :]
    check(data)


@few
@given(st.text(max_size=12), st.sampled_from(["2.5", "0 0 1", "1 2 3", "revolute", "a"]))
def test_any_value(text: str, value: str) -> None:
    escaped = text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    check(ROBOT.replace(f'"{value}"'.encode(), f'"{escaped}"'.encode("utf-8", "replace")))


@pytest.mark.parametrize("seed", range(6))
def test_damaged_real_files(shared: Path, seed: int) -> None:
    chance = random.Random(seed)
    files = sorted((shared / "robots").rglob("*.urdf"))
    for path in chance.sample(files, 5):
        data = path.read_bytes()
        check(data[: chance.randrange(len(data))])
        damaged = bytearray(data)
        for _ in range(chance.randrange(1, 5)):
            damaged[chance.randrange(len(data))] = chance.randrange(256)
        check(bytes(damaged))
