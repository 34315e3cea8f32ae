"""Contacts and friction move bodies as Coulomb and energy say."""

import shutil
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.build import link, robot, solid
from support.standin import make
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
GRAVITY, MASS = 9.81, 2.0


def body(shape: str, moment: float) -> str:
    """Return a robot of one body that touches the ground with a shape."""
    collision = f"<collision><geometry>{shape}</geometry></collision>"
    return robot(link("body", solid(MASS, moment), collision))


BOX = body('<box size="0.3 0.3 0.02"/>', 0.02)
BALL = body('<sphere radius="0.1"/>', 0.4 * MASS * 0.1**2)


def moved(folder: Path, text: str, time: float, push: float = 0.0, **start: Any) -> Any:
    """Run a body on the ground, with a push along x, relative to its weight."""
    contacts = {"links": ["*"], "friction": 0.5, "depth": 1e-4}
    passes: dict[str, Any] = {"contacts": contacts}
    if push:
        force = [push * MASS * GRAVITY, 0, 0]
        wrench = {"link": "body", "force": force, "start": -1, "stop": 99}
        passes["forces"] = {"wrenches": {"slope": wrench}}
    project = make(folder, text, base="floating", language="c", passes=passes)
    data = MbsData(project / "dataR" / "robot.mbs")
    for name, values in start.items():
        getattr(data, name)[1:] = values
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(tf=time, save2file=0)
    return dirdyn.run()


def test_a_box_slides_as_far_as_coulomb_says(tmp_path: Path) -> None:
    results = moved(tmp_path, BOX, 1.0, q=[0, 0, 0.01, 0, 0, 0], qd=[1, 0, 0, 0, 0, 0])
    assert results.q[-1, 1] == pytest.approx(1.0 / (2 * 0.5 * GRAVITY), abs=2e-3)
    assert abs(results.qd[-1, 1]) < 1e-6


def test_a_box_on_a_slope_that_holds_does_not_creep(tmp_path: Path) -> None:
    """Of 0.45 of the weight, with a friction of 0.5."""
    results = moved(tmp_path, BOX, 3.0, 0.45, q=[0, 0, 0.01, 0, 0, 0])
    assert abs(results.q[-1, 1] - results.q[200, 1]) < 1e-9
    assert abs(results.q[-1, 1]) < 1e-3


def test_a_ball_slides_until_it_rolls(tmp_path: Path) -> None:
    results = moved(tmp_path, BALL, 1.0, q=[0, 0, 0.1, 0, 0, 0], qd=[1, 0, 0, 0, 0, 0])
    assert results.qd[-1, 1] == pytest.approx(5.0 / 7.0, abs=1e-3)
    assert results.qd[-1, 5] == pytest.approx(5.0 / 7.0 / 0.1, rel=2e-3)


def test_a_ball_rolls_down_a_slope(tmp_path: Path) -> None:
    results = moved(tmp_path, BALL, 1.0, 0.2, q=[0, 0, 0.1, 0, 0, 0])
    assert results.q[-1, 1] == pytest.approx(5.0 / 7.0 * 0.2 * GRAVITY / 2, rel=2e-3)


@pytest.mark.parametrize("seed", range(4))
def test_a_drop_never_gains_energy(seed: int, tmp_path: Path) -> None:
    """But for what the ground has stored."""
    rng = np.random.default_rng(seed)
    start = [0.0, 0.0, 0.6, *rng.uniform(-1.0, 1.0, 3)]
    results = moved(tmp_path, BOX, 1.5, q=start, qd=rng.uniform(-1.0, 1.0, 6))
    energy = results.energy().sum(axis=1)
    ground = 0.03 * (energy[0] - energy[-1])
    assert np.diff(np.minimum.accumulate(energy)).max() <= 0.0
    assert (energy - np.minimum.accumulate(energy)).max() < ground
    assert energy[-1] < energy[0] - 5.0


def test_a_pendulum_sticks_where_friction_holds_it(tmp_path: Path) -> None:
    """Each swing loses friction times its way, and the last one ends where gravity is weaker."""
    length, friction, start = 0.5, 1.0, 1.2
    text = (
        '<robot name="p"><link name="base"/><link name="bob"><inertial>'
        f'<origin xyz="0 0 -{length}"/><mass value="{MASS}"/><inertia ixx="0.01" iyy="0.01" '
        'izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="swing" '
        'type="continuous"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/>'
        f'<dynamics friction="{friction}"/></joint></robot>'
    )
    passes = {"posture": {"joints": {"swing": start}}}
    project = make(tmp_path, text, base="fixed", language="c", passes=passes)
    dirdyn = MbsDirdyn(MbsData(project / "dataR" / "robot.mbs"))
    dirdyn.set_options(tf=20.0, save2file=0)
    positions = dirdyn.run().q[:, 1]
    weight, angle = MASS * GRAVITY * length, start
    while weight * sin(angle) > friction:
        ends = np.linspace(-angle, angle, 200001)
        left = weight * (np.cos(ends) - cos(angle)) - friction * (angle - ends)
        angle = abs(float(ends[np.flatnonzero(left >= 0.0)[0]]))
    assert abs(positions[-1]) == pytest.approx(angle, abs=2e-3)
    assert np.ptp(positions[-500:]) < 1e-6
