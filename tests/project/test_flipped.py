"""Joints that count the other way round: the same motion, whatever ``align-frames`` chose."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from project.standin import RungeKutta, make

from urdf2mbs.runtime import MbsData
from urdf2mbs.runtime.python_code import PythonCode, loaded
from urdf2mbs.testing import convert_text


def link(name: str) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="0.02 0.05 -0.1" rpy="0.1 0.2 0.3"/>'
        '<mass value="0.8"/><inertia ixx="0.004" ixy="0" ixz="0" iyy="0.005" iyz="0" izz="0.003"/>'
        "</inertial></link>"
    )


def joint(name: str, parent: str, axis: str, more: str = "", kind: str = "revolute") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="0.1 0 -0.2"/><parent link="{parent}"/>'
        f'<child link="of_{name}"/><axis xyz="{axis}"/>{more}</joint>' + link(f"of_{name}")
    )


def limit(low: float, high: float) -> str:
    return f'<limit lower="{low}" upper="{high}" effort="3" velocity="2"/>'


GRIPPER = (
    '<robot name="gripper"><link name="world"/>'
    + joint("left", "world", "0 -1 0", limit(0.3, 0.7))
    + joint("right", "world", "-1 0 0", limit(-9, 9) + '<mimic joint="left" multiplier="-1.5" '
            'offset="0.1"/>')
    + joint("slide", "of_left", "0 0 -1", limit(-9, 9) + '<mimic joint="left" multiplier="0.5"/>',
            "prismatic")
    + joint("tip", "of_right", "0 1 0", limit(-9, 9) + '<mimic joint="right" offset="-0.2"/>')
    + joint("swing", "of_left", "0 0 -1", limit(-0.05, 0.4)
            + '<dynamics damping="0.02" friction="0.01"/>')
    + joint("held", "of_swing", "-1 0 0", limit(-0.4, 0.9))
    + "</robot>"
)  # fmt: skip
POSTURE = {
    "joints": {"left": 0.6, "swing": -0.02, "held": 0.3},
    "hold": {"stiffness": 10.0, "damping": 0.05, "joints": ["held"]},
}


def run(folder: Path, *, flip: bool, nature: str) -> tuple[dict[str, Any], set[str], MbsData]:
    """The motion of each URDF joint, and those that are flipped."""
    folder.mkdir()
    passes = {
        "align-frames": {"flip": flip}, "posture": POSTURE, "equations": {"language": "python"},
        "mimic": {"joints": {"*": nature}},
    }  # fmt: skip
    project = make(
        folder, GRIPPER, base="fixed", pipeline="compact", passes=passes,
        diagnostics={"mimic-driven": "ignore"},
    )  # fmt: skip
    data = MbsData(project / "dataR" / "robot.mbs")
    with loaded(data):
        run, states = RungeKutta(PythonCode(data)), []
        names = {name: number for name, number in data.joint_id.items() if "_R" not in name}
        flipped = {name.removesuffix("_flipped") for name in names if name.endswith("_flipped")}
        for _ in range(600):
            states.append({
                name.removesuffix("_flipped"): (-1 if name.endswith("_flipped") else 1)
                * np.array([data.q[k], data.qd[k], data.qdd[k]])
                for name, k in names.items()
            })  # fmt: skip
            run.run(5e-4, 5e-4)
    return (
        {name: np.array([state[name] for state in states]) for name in states[0]},
        flipped,
        data,
    )


@pytest.mark.parametrize("nature", ["dependent", "driven"])
def test_a_gripper_moves_the_same_way(nature: str, tmp_path: Path) -> None:
    plain, none, _ = run(tmp_path / "plain", flip=False, nature=nature)
    other, flipped, data = run(tmp_path / "flipped", flip=True, nature=nature)
    assert not none
    assert flipped >= {"left", "slide", "swing"}
    assert not flipped >= {"tip"}
    assert plain.keys() == other.keys()
    for name, motion in plain.items():
        assert np.allclose(motion[:, 0], other[name][:, 0], rtol=0, atol=1e-9), name
        assert np.allclose(motion[:, 1], other[name][:, 1], rtol=0, atol=1e-7), name
    # it starts as the URDF's names say, follows by the URDF's rules, and has met its stops
    q = {name: motion[:, 0] for name, motion in other.items()}
    assert q["left"][0] == pytest.approx(0.6, abs=1e-12)
    assert q["held"][0] == pytest.approx(0.3, abs=1e-12)
    assert np.allclose(q["right"], -1.5 * q["left"] + 0.1, rtol=0, atol=1e-8)
    assert np.allclose(q["slide"], 0.5 * q["left"], rtol=0, atol=1e-8)
    assert np.allclose(q["tip"], q["right"] - 0.2, rtol=0, atol=1e-8)
    assert q["left"].min() < 0.3 or q["left"].max() > 0.7
    assert q["swing"].min() < -0.05 or q["swing"].max() > 0.4
    limits = data.user_model
    assert limits["q_min"]["left_flipped"] == -0.7
    assert limits["q_max"]["left_flipped"] == -0.3


def test_the_start_position_is_told_in_the_urdfs_numbers() -> None:
    options = {"align-frames": {"flip": True}, "posture": {"joints": {"left": 0.8}}}
    result = convert_text(GRIPPER, base="fixed", pipeline="compact", options=options)
    (warning,) = [d for d in result.diagnostics if d.code == "posture-limit"]
    assert "left at 0.8 of [0.3, 0.7] rad" in warning.message
    assert result.report.passes["posture"] == {"left": 0.8}
