"""Simulations with Pinocchio's mass matrix and forces, and the generated functions for all else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SHARED
from project.standin import MbsData, make, user_functions, without_meshes

pin = pytest.importorskip("pinocchio")

from project.engine import Engine  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
GRIPPER = SHARED / "robots/robotiq_2f_140/expanded/robotiq_arg2f_140_model.urdf"


@pytest.mark.skipif(not GRIPPER.is_file(), reason="the real robots are not beside the checkout")
def test_a_gripper_falls_as_a_reduction_by_hand(tmp_path: Path) -> None:
    """Five joints follow one: the same motion as of one degree of freedom, whose equation is
    q'' = (Q - S' (M S' 0 + c)) / (S' M S) with the constant S of the mimic rules."""
    project = make(tmp_path, GRIPPER, base="fixed", pipeline=without_meshes("compact"))
    data = MbsData(project / "dataR" / "robot.mbs")
    for kind in data.user_model["joint_forces"]:
        data.user_model["joint_forces"][kind] = 0.0
    with user_functions(project) as user:
        rules = user["user_cons_hJ"].robot.COUPLINGS
        assert len(rules) == 5
        data.set_nb_userc(len(rules))
        engine = Engine(data, user)
        q, v = engine.run(0.2, 1e-3)

    model, computed = engine.model, engine.model.createData()
    names = list(model.names)[1:]
    slope = np.zeros(model.nv)
    slope[names.index("finger_joint")] = 1.0
    for follower, _, multiplier, _ in rules:
        slope[names.index(follower)] = multiplier

    def acceleration(x: float, xd: float) -> float:
        mass = pin.crba(model, computed, slope * x)
        mass = np.triu(mass) + np.triu(mass, 1).T
        bias = pin.nonLinearEffects(model, computed, slope * x, slope * xd)
        return float(-(slope @ bias) / (slope @ mass @ slope))

    x, xd, step = 0.0, 0.0, 1e-3
    for _ in range(200):
        k1, l1 = xd, acceleration(x, xd)
        k2, l2 = xd + step / 2 * l1, acceleration(x + step / 2 * k1, xd + step / 2 * l1)
        k3, l3 = xd + step / 2 * l2, acceleration(x + step / 2 * k2, xd + step / 2 * l2)
        k4, l4 = xd + step * l3, acceleration(x + step * k3, xd + step * l3)
        x += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        xd += step / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
    assert abs(x) > 0.05, "it moves"
    assert np.allclose(q, slope * x, rtol=0, atol=1e-9 * abs(x))
    assert np.allclose(v, slope * xd, rtol=0, atol=1e-9 * abs(xd))


@pytest.mark.slow
def test_the_biped_stands_on_its_contacts(tmp_path: Path) -> None:
    """0.3 s: it sinks into the ground by about ``depth``, and is still then."""
    passes: dict[str, Any] = {
        "posture": {
            "joints": {"*_hip_pitch": -0.3, "*_knee": 0.6, "*_ankle": -0.3},
            "hold": {},
        },
        "contacts": {"links": ["*_foot"]},
    }
    source = ROOT / "configs" / "biped.urdf.xacro"
    project = make(tmp_path, source, passes=passes, pipeline="compact")
    data = MbsData(project / "dataR" / "robot.mbs")
    with user_functions(project) as user:
        robot = user["user_dirdyn"].robot
        engine = Engine(data, user)
        start, _ = engine.start()
        q, v = engine.run(0.3, robot.TIME_STEP)
        engine.put(q, v)
        weight = sum(robot.contact_force(data, f"{side}_foot")[2] for side in ("left", "right"))
    names = list(engine.model.names)[1:]
    height = names.index("floating_base_T3")
    assert -0.006 < q[height] - start[height] < 0.0
    tilt = [names.index(f"floating_base_R{k}") for k in (1, 2, 3)]
    assert np.abs(q[tilt]).max() < 0.05
    total = sum(body.mass or 0.0 for body in data.mbs.bodies) * 9.81
    assert weight == pytest.approx(total, rel=0.02)
    assert np.abs(v).max() < 0.05
    turns = [k for k, name in enumerate(names) if not name.startswith("floating_base")]
    assert np.abs((q - start)[turns]).max() < 0.05
