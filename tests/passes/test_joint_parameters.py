"""Joint parameters: damping, friction and soft stops of the generated code."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path
from typing import Any

import pytest
from project.standin import MbsData, make, user_functions

from urdf2mbs.mbs.reader import read
from urdf2mbs.testing import TINY, convert_text

FRICTION = TINY.replace('<dynamics damping="0.1"/>', '<dynamics damping="0.1" friction="0.4"/>')


def joint_forces(project: Path, user: Any, state: dict[str, tuple[float, float]]) -> dict[str, Any]:
    data = MbsData(project / "dataR" / f"{project.name}.mbs")
    for name, (q, qd) in state.items():
        data.q[data.joint_id[name]], data.qd[data.joint_id[name]] = q, qd
    data.Qq[1:] = 7.0  # what was there before counts for nothing
    user["user_JointForces"].user_JointForces(data, 0.0)
    return {"data": data, **{name: data.Qq[k] for name, k in data.joint_id.items()}}


def test_damping_friction_and_stops(tmp_path: Path) -> None:
    project = make(tmp_path, FRICTION)
    with user_functions(project) as user:
        found = joint_forces(project, user, {"shoulder": (0.3, 0.05)})
        model = found["data"].user_model
        time, k = model["joint_forces"]["friction_time"], model["friction_stiffness"]["shoulder"]
        friction = min(0.4, k * time * 0.05)  # of a bristle that is not bent yet
        assert found["shoulder"] == pytest.approx(-0.1 * 0.05 - friction)
        assert found["wrist_pitch"] == found["wrist_roll"] == 0.0

        # beyond a limit it pushes back, harder on the way in, and never pulls
        k = model["stop_stiffness"]["wrist_pitch"]
        for q, qd, wanted in (
            (1.02, 0.0, -k * 0.02),
            (1.02, 0.5, -k * 0.02 * 1.5),
            (1.02, -0.5, -k * 0.02 * 0.5),
            (1.02, -2.0, 0.0),
            (-1.02, 0.0, k * 0.02),
            (-1.02, -0.5, k * 0.02 * 1.5),
            (-1.02, 2.0, 0.0),
            (0.99, 2.0, 0.0),
        ):
            found = joint_forces(project, user, {"wrist_pitch": (q, qd)})
            assert found["wrist_pitch"] == pytest.approx(wanted, abs=1e-12)


def test_a_stop_swings_with_its_frequency(tmp_path: Path) -> None:
    """The hand has 1e-4 kg m^2, and 0.1 kg at 0.05 m, of which the axis sees the half squared."""
    inertia = 1e-4 + 0.1 * 0.05**2 / 2
    alone = TINY.replace('name="shoulder" type="revolute"', 'name="shoulder" type="fixed"')
    alone = alone.replace("continuous", "fixed")
    for frequency in (5.0, 20.0):
        options = {"joint-parameters": {"stop_frequency": frequency}}
        result = convert_text(
            alone, base="fixed", passes=options, output={"project": tmp_path / "p"}
        )
        model = next(m for m in result.mbs.user_models if m.name == "stop_stiffness")
        stiffness = {p.name: float(p.values[0]) for p in model.parameters}["wrist_pitch"]
        swing = sqrt(stiffness / inertia) / (2 * pi)
        assert swing == pytest.approx(frequency, rel=0.01)


def test_a_limit_on_one_side(tmp_path: Path) -> None:
    project = make(tmp_path, TINY.replace('lower="-1.5" upper="1.5"', 'lower="-inf" upper="1.5"'))
    with user_functions(project) as user:
        assert joint_forces(project, user, {"shoulder": (-50.0, 0.0)})["shoulder"] == 0.0
        assert joint_forces(project, user, {"shoulder": (1.6, 0.0)})["shoulder"] < 0.0


def test_each_kind_can_be_switched_off(tmp_path: Path) -> None:
    project = make(tmp_path, FRICTION)
    with user_functions(project) as user:
        for kind in ("damping", "friction", "stops"):
            data = MbsData(project / "dataR" / "robot.mbs")
            for other in ("damping", "friction", "stops"):
                data.user_model["joint_forces"][other] = 0.0
            joint = data.joint_id["shoulder"]
            data.q[joint], data.qd[joint] = 1.6, 0.1
            user["user_JointForces"].user_JointForces(data, 0.0)
            assert data.Qq[joint] == 0.0
            data.user_model["joint_forces"][kind] = 1.0
            user["user_JointForces"].user_JointForces(data, 0.0)
            assert data.Qq[joint] < 0.0


def test_user_models_hold_what_the_urdf_states() -> None:
    robot = TINY.replace(
        '<dynamics damping="0.1"/>',
        '<dynamics damping="0.1" friction="0.4"/><calibration rising="0.3"/><safety_controller '
        'soft_lower_limit="-1" soft_upper_limit="1.25" k_position="15" k_velocity="10"/>',
    )
    result = convert_text(robot)
    models = {
        model.name: {p.name: float(p.values[0]) for p in model.parameters}
        for model in read(result.data, "robot.mbs").user_models
    }
    assert models["q_min"] == {"shoulder": -1.5, "wrist_pitch": -1.0}
    assert models["q_max"] == {"shoulder": 1.5, "wrist_pitch": 1.0}
    assert models["effort"] == {"shoulder": 10.0, "wrist_pitch": 1.0}
    assert models["velocity"] == {"shoulder": 2.0, "wrist_pitch": 2.0}
    assert models["damping"] == {"shoulder": 0.1}
    assert models["friction"] == {"shoulder": 0.4}
    assert models["soft_q_min"] == {"shoulder": -1.0}
    assert models["soft_q_max"] == {"shoulder": 1.25}
    assert models["k_position"] == {"shoulder": 15.0}
    assert models["k_velocity"] == {"shoulder": 10.0}
    assert models["calibration_rising"] == {"shoulder": 0.3}
    codes = {found.code for found in result.diagnostics}
    assert not codes & {"limit", "safety-controller", "calibration"}
    assert "joint-dynamics" in codes, "nothing applies them in a plain .mbs"


def test_renamed_joints_keep_their_parameters(tmp_path: Path) -> None:
    project = make(tmp_path, FRICTION.replace("shoulder", "shoulder/1"))
    with user_functions(project) as user:
        found = joint_forces(project, user, {"shoulder_1": (0.0, 50.0)})
        assert found["shoulder_1"] == pytest.approx(-5.4)
