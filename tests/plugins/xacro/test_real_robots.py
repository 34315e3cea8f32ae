"""Real robots in xacro: the robot that we expand is the one that xacro itself expanded."""

import pytest

from support.plugin_files import read_robot
from support.real_robots import CONVERTIBLE, RealRobot
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.reader import parse_urdf

XACRO = [
    param
    for param in CONVERTIBLE
    if param.values[0] is None or param.values[0].text != param.values[0].source
]


@pytest.mark.parametrize("robot", XACRO)
def test_a_real_robot_is_expanded_as_by_xacro_itself(robot: RealRobot) -> None:
    """Its packages are those that are given, or those that are found around the file."""
    expected, _ = parse_urdf(robot.text.read_bytes(), "")
    expected_values = plain(expected)
    for folders in (robot.packages, {}):
        read, diagnostics = read_robot(robot.source, Packages(folders, robot.source), robot.args)
        assert plain(read) == expected_values
        assert not [message for message in diagnostics if message.code.startswith("xacro")]


def plain(robot: Robot) -> tuple[object, ...]:
    """Return a robot without its lines, and with the files of meshes by their last name only."""
    for link in robot.links.values():
        link.line = None
        for part in (*link.visuals, *link.collisions):
            part.line = None
            if hasattr(part.geometry, "filename"):
                part.geometry.filename = part.geometry.filename.rpartition("/")[2]
    for joint in robot.joints.values():
        joint.line = None
    materials = {
        name: (material.color, material.texture and material.texture.rpartition("/")[2])
        for name, material in robot.materials.items()
    }
    kept = [(extension.tag, extension.reference) for extension in robot.extensions]
    return (robot.name, robot.links, robot.joints, materials, kept)
