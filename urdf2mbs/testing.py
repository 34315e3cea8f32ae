"""For the tests of your own passes: a tiny robot, one pass run on it, and "is it the same?".

::

    from urdf2mbs.testing import TINY, assert_same_robot, convert_text, run_pass

    def test_my_pass():
        result = run_pass("my-pass", "my_pass.py", after="expand")
        assert "arm" in result.robot.links
        assert_same_robot(result)
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from urdf2mbs.api import Result, convert
from urdf2mbs.mbs.reader import read
from urdf2mbs.proof.compare import compare

#: A robot with a bit of all that robots have: a root with mass, a turned joint, an axis between
#: two coordinate axes, a massless link on the way (``wrist``) and one at the end (``tool``).
TINY = """\
<?xml version="1.0"?>
<robot name="tiny">
  <link name="body">
    <inertial>
      <mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/>
    </inertial>
    <visual>
      <geometry><box size="0.2 0.1 0.3"/></geometry>
    </visual>
  </link>

  <joint name="shoulder" type="revolute">
    <parent link="body"/>
    <child link="arm"/>
    <origin xyz="0.1 0 0.15" rpy="0 0.5 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1.5" upper="1.5" effort="10" velocity="2"/>
    <dynamics damping="0.1"/>
  </joint>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 0.15" rpy="0.3 0 0"/>
      <mass value="0.5"/>
      <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.001"/>
    </inertial>
    <visual>
      <origin xyz="0 0 0.15"/>
      <geometry><cylinder radius="0.03" length="0.3"/></geometry>
      <material name="red"><color rgba="1 0 0 1"/></material>
    </visual>
  </link>

  <joint name="wrist_roll" type="continuous">
    <parent link="arm"/>
    <child link="wrist"/>
    <origin xyz="0 0 0.3"/>
    <axis xyz="1 0 0"/>
  </joint>
  <link name="wrist"/>
  <joint name="wrist_pitch" type="revolute">
    <parent link="wrist"/>
    <child link="hand"/>
    <axis xyz="0 1 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="2"/>
  </joint>
  <link name="hand">
    <inertial>
      <origin xyz="0 0 0.05"/>
      <mass value="0.1"/>
      <inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.0001"/>
    </inertial>
    <collision>
      <origin xyz="0 0 0.05"/>
      <geometry><box size="0.06 0.04 0.1"/></geometry>
    </collision>
  </link>

  <joint name="tool_mount" type="fixed">
    <parent link="hand"/>
    <child link="tool"/>
    <origin xyz="0 0 0.1" rpy="0 1.5708 0"/>
  </joint>
  <link name="tool"/>

  <gazebo reference="hand"><mu1>0.9</mu1></gazebo>
</robot>
"""


def convert_text(robot: str = TINY, **settings: Any) -> Result:
    """Convert the text of a URDF; ``settings`` are those of ``urdf2mbs.convert``."""
    with TemporaryDirectory() as folder:
        source = Path(folder, "robot.urdf")
        source.write_text(robot, "utf-8")
        return convert(source, **settings)


def run_pass(
    name: str,
    plugin: str | os.PathLike[str] | None = None,
    *,
    after: str = "expand",
    options: Mapping[str, Any] | None = None,
    robot: str = TINY,
    **settings: Any,
) -> Result:
    """Convert a robot by the preset ``faithful`` with one pass put in ``after`` another.

    ``plugin`` is the file that brings the pass; None: a package that is installed.
    """
    return convert_text(
        robot,
        plugins=[] if plugin is None else [plugin],
        after={after: name},
        options={name: options or {}},
        **settings,
    )


def assert_same_robot(result: Result, expected: Result | None = None) -> None:
    """Fail where the .mbs is not the same robot as the URDF that the passes left.

    With ``expected``, as the URDF of that conversion: ``convert_text()`` for the tiny robot
    as it is, of which your pass has changed nothing.
    """
    comparison = compare(
        (expected or result).robot.with_flipped(result.names.flipped),
        read(result.data, "robot.mbs"),
        {name: tuple(joints) for name, joints in result.names.coordinates.items()},
        frames=result.frames,
        frozen=result.frozen,
        weightless=sorted(result.conversion.weightless & result.frozen.keys()),
        driven=[one.follower.name for one in result.conversion.simulation.driven],
        gravity=result.conversion.settings.gravity,
    )
    found = [difference.message for difference in comparison.differences + comparison.frames]
    found += [str(one) for one in result.conversion.changed if not one.declared]
    if found:
        raise AssertionError("not the same robot:\n  " + "\n  ".join(found))
