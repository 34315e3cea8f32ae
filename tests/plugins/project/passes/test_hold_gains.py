"""The gains of the controller that holds the start position."""

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from support.light_chains import BIPED, WIDE, convert_project, hinge, light_link
from support.proving import models
from urdf2mbs import convert
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_project.mass import MassModel
from urdf2mbs_project.passes.hold_gains import MAX_DAMPING, MAX_STIFFNESS
from urdf2mbs_project.simulation import Simulation
from urdf2mbs_project.stability import compute_effective_inertias, compute_reduction


def test_gains_follow_from_frequency_and_damping_ratio_and_may_be_given() -> None:
    options = {
        "frequency": 2.0,
        "damping_ratio": 0.5,
        "gains": {"wrist_*": {"stiffness": 7.0, "damping": 0.25}, "wrist_roll": {"frequency": 1.0}},
    }
    mbs = convert_text(TINY, passes={"posture": {"hold": options}}).mbs
    gains = models(mbs)
    moved = dict(zip(mbs.numbers(), np.diag(MassModel(mbs).matrix), strict=True))
    k, d = gains["hold_stiffness"], gains["hold_damping"]
    assert gains["hold"] == {"on": 1.0}
    assert (k["wrist_pitch"], d["wrist_pitch"]) == (7.0, 0.25)
    assert k["shoulder"] == pytest.approx(moved["shoulder"] * (4 * pi) ** 2, rel=0.05)
    assert d["shoulder"] == pytest.approx(sqrt(moved["shoulder"] * k["shoulder"]), rel=0.05)
    assert k["wrist_roll"] == pytest.approx(moved["wrist_roll"] * (2 * pi) ** 2, rel=0.05)


def test_a_leg_carries_the_robot_and_an_arm_itself() -> None:
    passes = {"posture": {"hold": {}}, "contacts": {"links": ["*_foot"]}}
    mbs = convert(BIPED, passes=passes, pipeline="compact").mbs
    gains = models(mbs)
    moved = dict(zip(mbs.numbers(), np.diag(MassModel(mbs).matrix), strict=True))
    k = {name: value / (20 * pi) ** 2 for name, value in gains["hold_stiffness"].items()}
    assert k["left_ankle"] > 100 * moved["left_ankle"]
    assert k["left_shoulder"] == pytest.approx(moved["left_shoulder"], rel=0.05)
    # the ground: 0.1 % of the leg for a quarter of the robot, damped by 0.3
    total = sum(body.mass or 0.0 for body in mbs.bodies)
    law = gains["contact"]
    depth = total * 9.81 / 4 / law["stiffness"]
    assert 0.00025 < depth < 0.0006
    ratio = total / 4 * 9.81 / law["speed"] / (2 * sqrt(total / 4 * law["stiffness"]))
    assert ratio == pytest.approx(0.3, rel=0.05)


def test_a_leader_carries_what_follows_it(tmp_path: Path) -> None:
    """A knuckle without inertia of its own, as in the hand of a NAO, moves a heavy finger."""
    text = (
        '<robot name="r"><link name="world"/>'
        + light_link("a", 1e-6, 1e-9)
        + light_link("b", 1.0, 0.01)
        + hinge("one", "world", "a", WIDE)
        + hinge("two", "world", "b", WIDE + '<mimic joint="one" multiplier="2"/>')
        + "</robot>"
    )
    hold = {"frequency": 1.0, "damping_ratio": 0.5, "joints": ["one"]}
    result = convert_project(text, tmp_path, posture={"hold": hold})
    gains = models(result.mbs)
    assert gains["hold_stiffness"]["one"] == pytest.approx(0.04 * (2 * pi) ** 2, rel=0.05)
    assert gains["hold_damping"]["one"] == pytest.approx(0.04 * 2 * pi, rel=0.05)


def test_the_gains_are_bounded_by_what_a_joint_feels() -> None:
    options = {"frequency": 1000.0, "damping_ratio": 1000.0}
    result = convert_text(TINY, passes={"posture": {"hold": options}})
    gains, mass = models(result.mbs), MassModel(result.mbs)
    names = [placed.joint.name for placed in mass.placement.joints]
    inertias = compute_effective_inertias(mass, compute_reduction(mass, Simulation()))
    feels = dict(zip(names, inertias, strict=True))
    assert gains["hold_damping"].keys() == {"shoulder", "wrist_roll", "wrist_pitch"}
    for name, damping in gains["hold_damping"].items():
        assert damping == pytest.approx(MAX_DAMPING * feels[name], rel=0.05)
        assert gains["hold_stiffness"][name] <= 1.05 * MAX_STIFFNESS * feels[name]
