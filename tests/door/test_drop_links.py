"""The example drop_links.py: a camera goes with all that it carries, and nothing else does."""

from pathlib import Path

import pytest

from urdf2mbs.plugin import ConfigError, ConversionError
from urdf2mbs.testing import TINY, assert_same_robot, convert_text, run_pass

PLUGIN = Path(__file__).with_name("drop_links.py")
CAMERA = """
  <link name="front_camera"><inertial><mass value="0.2"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <joint name="tilt" type="continuous"><parent link="body"/><child link="front_camera"/></joint>
  <link name="lens"/>
  <joint name="focus" type="fixed"><parent link="front_camera"/><child link="lens"/></joint>
</robot>"""
ROBOT = TINY.replace("</robot>", CAMERA)


def test_without_its_camera_the_robot_is_the_one_without_a_camera() -> None:
    result = run_pass("drop-links", PLUGIN, options={"links": ["*_camera"]}, robot=ROBOT)
    assert_same_robot(result)
    assert result.data == convert_text().data
    (message,) = [found for found in result.diagnostics if found.code == "dropped"]
    assert "2 links are left out: front_camera, lens" in message.message


def test_what_a_dropped_link_carries_is_dropped() -> None:
    result = run_pass("drop-links", PLUGIN, options={"links": ["arm"]})
    assert [body.mass for body in result.mbs.bodies] == [2.0]


def test_the_warning_can_be_silenced() -> None:
    levels = {"dropped": "ignore"}
    options = {"links": ["hand"]}
    result = run_pass("drop-links", PLUGIN, options=options, diagnostics=levels)
    assert "dropped" not in [found.code for found in result.diagnostics]


def test_wrong_links_are_an_error() -> None:
    with pytest.raises(ConfigError, match="no link is called 'hnad'"):
        run_pass("drop-links", PLUGIN, options={"links": ["hnad"]})
    with pytest.raises(ConversionError, match="'body' is the root"):
        run_pass("drop-links", PLUGIN, options={"links": ["body"]})
