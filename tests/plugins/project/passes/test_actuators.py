"""Actuators: the joints that a motor moves."""

from urdf2mbs.testing import TINY, convert_text


def test_actuated_joints() -> None:
    more = (
        '<transmission name="t"><joint name="shoulder"/></transmission>'
        '<ros2_control name="c" type="system"><joint name="wrist_roll"><command_interface '
        'name="position"/></joint><joint name="wrist_pitch"><state_interface name="position"/>'
        "</joint></ros2_control></robot>"
    )
    result = convert_text(TINY.replace("</robot>", more))
    actuated = [j.name for b in result.mbs.bodies for j in b.joints if j.actuated]
    assert actuated == ["shoulder", "wrist_roll"]
    result = convert_text(TINY, passes={"actuators": {"joints": ["wrist_*"]}})
    actuated = [j.name for b in result.mbs.bodies for j in b.joints if j.actuated]
    assert actuated == ["wrist_roll", "wrist_pitch"]
