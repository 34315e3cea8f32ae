"""Simulations with nothing but generated files: equations and user functions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from project.generated import Robotran
from project.standin import make, user_functions

from urdf2mbs.engine.config import parse

ROOT = Path(__file__).resolve().parents[2]


def from_the_page(folder: Path, **changed: Any) -> Path:
    """The project that docs/first-simulation.md makes of the biped."""
    page = (ROOT / "docs" / "first-simulation.md").read_text("utf-8")
    text = page.split("```yaml file=biped.yaml\n")[1].split("```")[0]
    passes = parse(text, folder / "biped.yaml")[0].passes
    return make(
        folder, ROOT / "configs/biped.urdf.xacro", "biped", pipeline="compact",
        passes={**passes, **changed},
    )  # fmt: skip


@pytest.mark.slow
def test_the_biped_stands_on_generated_files_alone(tmp_path: Path) -> None:
    """0.3 s on its contacts: it sinks in by about their depth, and is still then."""
    project = from_the_page(tmp_path, forces={})
    with user_functions(project) as user:
        data = Robotran(project, user)
        robot = user["user_dirdyn"].robot
        height, tilt = (data.joint_id[f"floating_base_{k}"] for k in ("T3", "R2"))
        start = np.array(data.q)
        for _ in data.run(0.3, robot.TIME_STEP):
            pass
        weight = sum(robot.contact_force(data, f"{side}_foot")[2] for side in ("left", "right"))
    total = sum(body.mass or 0.0 for body in data.mbs.bodies) * 9.81
    moved = data.q - start
    assert -0.006 < moved[height] < 0.0
    assert abs(moved[tilt]) < 0.05
    assert np.abs(moved).max() < 0.05
    assert np.abs(data.qd).max() < 0.05
    assert weight == pytest.approx(total, rel=0.02)
    # accelred, dirdyna and invdyna say the same
    n, free = data.njoint, data.free
    m, c, phi = np.zeros((n + 1, n + 1)), np.zeros(n + 1), np.zeros(n + 1)
    data.mbs_dirdyna(m, c, data, 1.0)
    data.mbs_invdyna(phi, data, 1.0)
    assert np.allclose((m @ data.qdd + c)[free], data.Qq[free], rtol=0, atol=1e-9 * total)
    assert np.allclose(phi[free], data.Qq[free], rtol=0, atol=1e-9 * total)


def test_a_falling_floating_robot_keeps_its_energy(tmp_path: Path) -> None:
    """It tumbles and swings its limbs; nothing brakes it."""
    project = from_the_page(tmp_path, posture={}, forces={})
    with user_functions(project) as user:
        data = Robotran(project, user)
        for kind in data.user_model["joint_forces"]:
            data.user_model["joint_forces"][kind] = 0.0
        rng = np.random.default_rng(11)
        for k in data.free:
            data.q[k] += rng.uniform(-0.5, 0.5)
            data.qd[k] = rng.uniform(-2.0, 2.0)
        data.q[data.joint_id["floating_base_T3"]] += 5.0
        before, moving = data.energy(), data.energy(kinetic=True)
        for _ in data.run(0.5, 1e-3):
            pass
    assert data.energy(kinetic=True) > 2 * moving, "it falls"
    assert abs(data.energy() - before) <= 1e-10 * moving
