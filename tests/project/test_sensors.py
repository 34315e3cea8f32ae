"""Sensors: where they are, and what the generated helpers make of what Robotran computes."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from project.standin import MbsData, from1, make, user_functions

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.testing import TINY, convert_text

IMU = """
  <gazebo reference="hand">
    <sensor name="wrist imu" type="imu"><pose>0.01 0.02 0.03 0.4 0.5 0.6</pose></sensor>
    <sensor name="camera" type="camera"/>
  </gazebo>
  <sensor name="wrist imu" type="imu"><parent link="hand"/></sensor>
  <sensor name="turn" type="gyroscope">
    <parent link="arm"/><origin xyz="0 0 0.1" rpy="0 0 1.5"/>
  </sensor>
</robot>
"""
ROBOT = TINY.replace("</robot>", IMU)


class MbsSensor:
    """Computes a sensor as Robotran does, by Pinocchio."""

    def __init__(self, data: MbsData) -> None:
        self.data = data
        self.P, self.V, self.A, self.OM, self.OMP = (from1(3) for _ in range(5))
        self.R = from1(3, 3)

    def comp_s_sensor(self, number: int) -> None:
        import pinocchio as pin

        from urdf2mbs.proof.dynamics import to_pinocchio

        data = self.data
        owner, point = data.sensor_at[number]
        model = to_pinocchio(data.mbs)
        order = [data.joint_id[name] for name in list(model.names)[1:]]
        q, v, a = (np.array([x[k] for k in order]) for x in (data.q, data.qd, data.qdd))
        computed = model.createData()
        pin.forwardKinematics(model, computed, q, v, a)
        pin.updateFramePlacements(model, computed)
        frame = model.getFrameId(f"{owner}/{point.name}")
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        self.P[1:] = computed.oMf[frame].translation
        self.R[1:, 1:] = computed.oMf[frame].rotation.T
        velocity = pin.getFrameVelocity(model, computed, frame, world)
        self.V[1:], self.OM[1:] = velocity.linear, velocity.angular
        acceleration = pin.getFrameClassicalAcceleration(model, computed, frame, world)
        self.A[1:], self.OMP[1:] = acceleration.linear, acceleration.angular


@pytest.fixture
def robotran(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    pytest.importorskip("pinocchio")
    monkeypatch.setitem(sys.modules, "MBsysPy", SimpleNamespace(MbsSensor=MbsSensor))
    return


@pytest.mark.parametrize("preset", ["faithful", "compact"])
def test_an_imu_reads_in_its_own_axes(tmp_path: Path, preset: str, robotran: None) -> None:
    """Against the URDF's own frames: Pinocchio reads it, with a link where the IMU is."""
    import pinocchio as pin

    project = make(tmp_path, ROBOT, pipeline=preset, base="fixed")
    data = MbsData(project / "dataR" / "robot.mbs")
    assert set(data.sensor_id) == {"wrist_imu", "turn"}
    random = np.random.default_rng(5)
    state = {name: random.normal(size=3) for name in ("shoulder", "wrist_roll", "wrist_pitch")}
    for name, (q, qd, qdd) in state.items():
        k = data.joint_id[name]
        data.q[k], data.qd[k], data.qdd[k] = q, qd, qdd
    with user_functions(project) as user:
        robot = user["user_dirdyn"].robot
        force, turn = robot.imu(data, "wrist imu")

    there = (
        '<link name="there"/><joint name="at" type="fixed"><parent link="hand"/>'
        '<child link="there"/><origin xyz="0.01 0.02 0.03" rpy="0.4 0.5 0.6"/></joint></robot>'
    )
    model = pin.buildModelFromXML(ROBOT.replace("</robot>", there))
    q, v, a = np.zeros(model.nq), np.zeros(model.nv), np.zeros(model.nv)
    for name, values in state.items():
        joint = model.joints[model.getJointId(name)]
        if joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(values[0]), np.sin(values[0])
        else:
            q[joint.idx_q] = values[0]
        v[joint.idx_v], a[joint.idx_v] = values[1:]
    computed = model.createData()
    pin.forwardKinematics(model, computed, q, v, a)
    pin.updateFramePlacements(model, computed)
    frame = model.getFrameId("there")
    own = pin.ReferenceFrame.LOCAL
    wanted = pin.getFrameClassicalAcceleration(model, computed, frame, own).linear
    wanted = wanted - computed.oMf[frame].rotation.T @ model.gravity.linear
    assert np.allclose(force, wanted, rtol=0, atol=1e-12)
    spin = pin.getFrameVelocity(model, computed, frame, own).angular
    assert np.allclose(turn, spin, rtol=0, atol=1e-12)


@pytest.mark.parametrize("preset", ["faithful", "compact"])
def test_a_force_torque_sensor_weighs_what_hangs_on_it(tmp_path: Path, preset: str) -> None:
    pin = pytest.importorskip("pinocchio")
    from urdf2mbs.proof.dynamics import to_pinocchio

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
        for joint in body.joints:
            if joint.name.startswith("tool_mount_T") or joint.name.startswith("tool_mount_R"):
                joint.nature = "independent"
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


def test_sensors_of_the_config(tmp_path: Path) -> None:
    project = make(tmp_path, TINY, passes={"sensors": {"links": ["tool", "arm"]}})
    data = MbsData(project / "dataR" / "robot.mbs")
    assert data.sensor_id == {"arm_sensor": 1, "tool_sensor": 2}
    points = {b.name: [p.name for p in b.points] for b in data.mbs.bodies}
    assert points["hand"] == ["tool"], "the frame's own point has the sensor"
    (tool,) = [p for b in data.mbs.bodies for p in b.points if p.name == "tool"]
    assert set(tool.sensor.measures) == {"Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac"}


@pytest.mark.parametrize(
    ("name", "options", "code"),
    [
        ("sensors", {"links": ["hnad"]}, "sensors-links"),
        ("sensors", {"only": ["imu"]}, "sensors-only"),
        ("force-torque", {"joints": ["tool_mount"]}, "force-torque-joint"),
        ("force-torque", {"joints": ["shoulder"]}, "force-torque-joint"),
        ("actuators", {"joints": ["tool_mount"]}, "actuators-joints"),
        ("posture", {"joints": {"shuolder": 1.0}}, "posture-joint"),
        ("posture", {"joints": {"tool_mount": 1.0}}, "posture-joint"),
        ("posture", {"joints": {"shoulder": float("nan")}}, "value-range"),
        ("posture", {"hold": {"stiffness": float("inf"), "damping": 1.0}}, "config-type"),
        ("joint-parameters", {"stop_frequency": -1.0}, "config-type"),
        ("posture", {"state": "home"}, "posture-srdf"),
        ("posture", {"state": "home", "srdf": "not_there.srdf"}, "posture-srdf"),
    ],
)
def test_wrong_options(name: str, options: dict[str, Any], code: str) -> None:
    with pytest.raises(ConfigError) as caught:
        convert_text(TINY, options={name: options})
    assert caught.value.code == code


def test_sensors_of_the_urdf_have_places_and_links() -> None:
    """In SDF's words and in URDF's; a sensor without a place is where its link is; a sensor whose
    place or link cannot be read is left out, and that is said."""
    more = (
        '<gazebo reference="arm"><sensor name="sdf" type="imu"><pose>1 2 3 0 0 0</pose></sensor>'
        '<sensor name="bare" type="imu"/><sensor name="bad" type="imu"><pose>1 2 x 0 0 0</pose>'
        "</sensor></gazebo>"
        '<sensor name="urdf" type="imu"><parent link="hand"/><origin xyz="0 0 4"/></sensor>'
        '<sensor name="lost" type="imu"><parent link="nowhere"/></sensor></robot>'
    )
    result = convert_text(TINY.replace("</robot>", more))
    points = {p.sensor.name: p for b in result.mbs.bodies for p in b.points if p.sensor is not None}
    assert set(points) == {"sdf", "bare", "urdf"}
    assert points["sdf"].coordinates == (1.0, 2.0, 3.0)
    assert points["bare"].coordinates == (0.0, 0.0, 0.0)
    assert points["urdf"].coordinates == (0.0, 0.0, 4.0)
    bad, lost = [one for one in result.diagnostics if one.code == "sensor-left-out"]
    assert "sensor 'bad' is left out: the text of <pose> is '1 2 x 0 0 0'" in bad.message
    assert "sensor 'lost' is left out: it is on link 'nowhere', which does not" in lost.message


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
    result = convert_text(TINY, options={"actuators": {"joints": ["wrist_*"]}})
    actuated = [j.name for b in result.mbs.bodies for j in b.joints if j.actuated]
    assert actuated == ["wrist_roll", "wrist_pitch"]


def test_a_group_state(tmp_path: Path) -> None:
    (tmp_path / "robot.srdf").write_text(
        '<robot name="tiny"><group_state name="home" group="a"><joint name="shoulder" '
        'value="0.5"/></group_state><group_state name="home" group="b"><joint name="wrist_pitch" '
        'value="-1.5"/><joint name="gone" value="1"/></group_state></robot>'
    )
    file = str(tmp_path / "robot.srdf")
    passes = {"srdf": file, "state": "home", "joints": {"shoulder": 0.25}}
    result = convert_text(TINY, options={"posture": passes})
    start = {j.name: j.q for b in result.mbs.bodies for j in b.joints}
    assert start["shoulder"] == 0.25
    assert start["wrist_pitch"] == -1.5
    told = {found.code: found.message for found in result.diagnostics}
    assert "gone" in told["posture-state"]
    assert "wrist_pitch at -1.5 of [-1, 1] rad" in told["posture-limit"]
    with pytest.raises(ConfigError, match="no group state 'hoem'") as caught:
        convert_text(TINY, options={"posture": {"srdf": file, "state": "hoem"}})
    assert caught.value.hint == "did you mean 'home'?"


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
    result = convert_text(text, options={"force-torque": {"joints": ["*_ft"]}})
    names = {joint.name for body in result.mbs.bodies for joint in body.joints}
    assert {"left_ft_T1", "right_ft_R3"} <= names
    told = {found.code: found.message for found in result.diagnostics}
    assert "joints that move are left out: shoulder" in told["force-torque"]
    assert "2 <gazebo>" in told["extension"]
    assert "<sensor>" not in told["extension"]
