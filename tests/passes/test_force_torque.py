"""Force-torque: sensors at fixed joints weigh what hangs on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from project.standin import MbsData, make, user_functions
from proving import SOLID, joint, link, robot

from urdf2mbs.testing import TINY, convert_text


@pytest.mark.parametrize("preset", ["faithful", "compact"])
def test_a_force_torque_sensor_weighs_what_hangs_on_it(tmp_path: Path, preset: str) -> None:
    pin = pytest.importorskip("pinocchio")
    from oracle.pin import to_pinocchio

    heavy = TINY.replace(
        '<link name="tool"/>',
        '<link name="tool"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>',
    )
    angles = {"shoulder": 0.3, "wrist_roll": 0.5, "wrist_pitch": -0.7}
    passes = {"force-torque": {"joints": ["tool_mount"]}, "posture": {"joints": angles}}
    project = make(tmp_path, heavy, pipeline=preset, base="fixed", passes=passes)
    data = MbsData(project / "dataR" / "robot.mbs")
    moved = data.mbs
    for body in moved.bodies:
        for own in body.joints:
            if own.name.startswith(("tool_mount_T", "tool_mount_R")):
                own.nature = "independent"
    model = to_pinocchio(moved)
    order = [data.joint_id[name] for name in list(model.names)[1:]]
    q = np.array([data.q0[k] for k in order])
    torque = pin.computeGeneralizedGravity(model, model.createData(), q)
    for k, value in zip(order, torque, strict=True):
        data.Qc[k] = value
    with user_functions(project) as user:
        found = user["user_dirdyn"].robot.force_torque(data, "tool_mount")

    urdf = pin.buildModelFromXML(heavy)
    at = np.zeros(urdf.nq)
    for name, value in angles.items():
        joint = urdf.joints[urdf.getJointId(name)]
        if joint.nq == 2:
            at[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        else:
            at[joint.idx_q] = value
    computed = urdf.createData()
    pin.framesForwardKinematics(urdf, computed, at)
    turned = computed.oMf[urdf.getFrameId("tool")].rotation
    weight = turned.T @ np.array([0, 0, 2 * 9.81])
    assert np.allclose(found[:3], weight, rtol=0, atol=1e-12)
    assert np.allclose(found[3:], np.cross([0.1, 0.2, 0.3], weight), rtol=0, atol=1e-12)


def test_force_torque_sensors_of_one_name_and_at_joints_that_move() -> None:
    """Each has a name of its own in the generated code; a joint that moves cannot have one."""
    links = "".join(
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" '
        f'iyy="1" iyz="0" izz="1"/></inertial></link><joint name="{name}_ft" type="fixed">'
        f'<parent link="hand"/><child link="{name}"/></joint>'
        f'<sensor name="ft" type="force_torque"><parent joint="{name}_ft"/></sensor>'
        for name in ("left", "right")
    )
    more = '<gazebo reference="shoulder"><sensor name="torque" type="force_torque"/></gazebo>'
    text = TINY.replace("</robot>", f"{links}{more}</robot>")
    result = convert_text(text, passes={"force-torque": {"joints": ["*_ft"]}})
    names = {joint.name for body in result.mbs.bodies for joint in body.joints}
    assert {"left_ft_T1", "right_ft_R3"} <= names
    told = {found.code: found.message for found in result.diagnostics}
    assert "joints that move are left out: shoulder" in told["force-torque"]
    assert "2 <gazebo>" in told["extension"]
    assert "<sensor>" not in told["extension"]


def test_three_sensors_of_one_name_are_three() -> None:
    text = robot(
        *(link(name, SOLID) for name in "abcd"),
        *(joint("a", child, "fixed", name=f"to_{child}") for child in "bcd"),
        *(f'<sensor name="ft" type="force_torque"><parent joint="to_{child}"/></sensor>'
          for child in "bcd"),
    )  # fmt: skip
    result = convert_text(text, passes={"force-torque": {"joints": ["to_*"]}})
    found = [sensor.name for sensor in result.conversion.simulation.force_torques]
    assert found == ["ft", "to_c_ft", "to_d_ft"]
    result = convert_text(
        text.replace('"ft"', '"one"', 1), passes={"force-torque": {"joints": ["to_c"]}}
    )
    (said,) = [one.message for one in result.diagnostics if one.code == "force-torque"]
    assert said.startswith("force-torque sensors at fixed joints that are left out: to_b, to_d; ")
