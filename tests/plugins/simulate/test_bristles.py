"""Friction with a state: it lets joints and feet rest, and is the URDF's in motion."""

import shutil
from math import cos, radians, sin
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.light_chains import hinge, light_link
from support.standin import make, user_functions
from urdf2mbs import simulate
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_simulate.dirdyn import load_code
from urdf2mbs_simulate.python_code import user_code
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

LANGUAGES = [
    "python",
    pytest.param("c", marks=pytest.mark.skipif(shutil.which("cc") is None, reason="no compiler")),
]
G = 9.81


def pendulum(friction: float) -> str:
    """1 kg at 0.3 m, held out level: gravity pulls with 2.943 N m."""
    wide = '<limit lower="-9" upper="9" effort="0" velocity="1"/>'
    return (
        '<robot name="r"><link name="world"/>'
        + light_link("arm", 1.0, 0.01, 0.3)
        + hinge("axle", "world", "arm", wide + f'<dynamics friction="{friction}"/>')
        + "</robot>"
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_joint_rests_below_its_friction_and_turns_above(tmp_path: Path, language: str) -> None:
    """A joint that turns loses friction times its way."""
    project = make(tmp_path, pendulum(3.5), "rests", base="fixed", language="both")
    results = simulate(project, time=1.0, language=language)
    assert results.data.Nux == 1
    assert abs(results.qd[-1, 1]) < 1e-9
    assert abs(results.q[-1, 1]) < 1e-3
    assert results.Qq[-1, 1] == pytest.approx(-0.3 * G * cos(results.q[-1, 1]), rel=1e-6)
    project = make(tmp_path, pendulum(0.5), "turns", base="fixed", language="both")
    turns = simulate(project, time=0.4, language=language, rtol=1e-9, atol=1e-10)
    turned, energy = turns.q[:, 1], turns.energy().sum(axis=1)
    assert abs(turned[-1]) > 1.0
    late = np.abs(turned) > 0.05
    assert np.allclose(np.abs(turns.Qq[late, 1]), 0.5, rtol=1e-12, atol=0)
    lost = energy[late][0] - energy[-1]
    assert lost == pytest.approx(0.5 * abs(turned[-1] - turned[late][0]), rel=1e-6)


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_ladder_stands_by_friction_alone(tmp_path: Path, language: str) -> None:
    """Return two rails and a free hinge, which friction of 0.8 keeps from the splits.

    A body gets another name than its friction: the .mbs reserves ``base``.
    """
    length, half = 1.0, radians(25.0)

    def rail(name: str, way: float) -> str:
        shift = f"{way * sin(half) / 2} 0 {-cos(half) / 2}"
        return (
            f'<link name="{name}"><inertial><origin xyz="{shift}"/><mass value="1"/><inertia '
            'ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    hinge = '<joint name="hinge" type="continuous"><parent link="base"/><child link="b"/><axis '
    text = f'<robot name="r">{rail("base", 1)}{rail("b", -1)}{hinge}xyz="0 1 0"/></joint></robot>'
    feet = {
        name: [[way * length * sin(half), side, -length * cos(half)] for side in (0.2, -0.2)]
        for name, way in (("base", 1), ("b", -1))
    }
    passes = {"contacts": {"points": feet}}
    project = make(tmp_path, text, "ladder", base="floating", language="both", passes=passes)
    results = simulate(project, time=4.0, language=language, rate=10.0)
    weight = sum(rows[-1, 2] for rows in results.external.values())
    assert weight == pytest.approx(2 * G, rel=1e-3)
    assert np.abs(results.qd[-1, 1:]).max() < 1e-9
    assert abs(results.joint("hinge")[-1] - results.joint("hinge")[20]) < 1e-6


@settings(max_examples=30, deadline=None)
@given(
    motion=st.lists(st.tuples(st.floats(-3, 3), st.floats(0.001, 0.02)), min_size=1, max_size=8),
    most=st.floats(1e-4, 0.1),
)
def test_a_bristle_gives_back_no_more_than_it_took(
    robot: Any, motion: list[tuple[float, float]], most: float
) -> None:
    """Its work is at least what it holds, spring energy up to ``most``; no pull is above most."""
    time, work = 0.005, 0.0
    data = SimpleNamespace(ux=np.zeros(2), uxd=np.zeros(2))
    for rate, duration in motion:
        for _ in range(200):
            pull = robot.move_bristle(data, 1, rate, most, time)
            assert abs(pull) <= most * (1 + 1e-12)
            work += pull * rate * duration / 200
            data.ux += data.uxd * duration / 200
    bent = min(abs(data.ux[1]), most)
    distance = sum(abs(rate) * duration for rate, duration in motion)
    assert np.isfinite(work)
    assert work >= bent**2 / 2 - 0.02 * most * distance - 1e-12


@settings(max_examples=15, deadline=None)
@given(
    motion=st.lists(
        st.tuples(*[st.floats(-0.5, 0.5)] * 2, st.floats(-5, 5), st.floats(0.001, 0.02)),
        min_size=1,
        max_size=6,
    ),
    tilt=st.floats(-0.004, 0.004),
)
def test_the_bristles_of_a_body_give_back_no_more_than_they_took(
    robot: Any, motion: list[tuple[float, float, float, float]], tilt: float
) -> None:
    """A plate slides and turns on the ground, pressed unevenly; each spot holds N bent^2 / 2."""
    data = SimpleNamespace(ux=np.zeros(4), uxd=np.zeros(4), user_model={"contact": GROUND})
    corners = [(x, y, tilt * (x + 2 * y)) for x in (-0.1, 0.1) for y in (-0.05, 0.05)]
    plate, P, R = robot.make_contact(1, corners), np.array([0.0, 0.0, 0.0, -0.001]), np.eye(4)
    work = distance = 0.0
    for vx, vy, spin, duration in motion:
        V, OM = np.array([0.0, vx, vy, 0.0]), np.array([0.0, 0.0, 0.0, spin])
        for _ in range(100):
            force = np.array(robot.ground_force(plate, P, R, V, OM, data))
            turned = spin * duration / 100
            power = -(force[:3] @ V[1:] + force[3:] @ OM[1:])
            work += power * duration / 100
            distance += (np.hypot(vx, vy) + abs(spin) * 0.12) * duration / 100
            assert np.hypot(force[0], force[1]) <= 0.8 * force[2] * (1 + 1e-9)
            data.ux += data.uxd * duration / 100
            R[1:, 1:] = R[1:, 1:] @ [
                [np.cos(turned), np.sin(turned), 0.0],
                [-np.sin(turned), np.cos(turned), 0.0],
                [0.0, 0.0, 1.0],
            ]
    assert np.isfinite(work)
    assert work >= -0.02 * 0.8 * force[2] * distance - 1e-9


GROUND = {
    "ground": 0.0,
    "stiffness": 1e4,
    "speed": 0.05,
    "friction": 0.8,
    "bristle": 0.001,
    "bristle_time": 0.02,
}


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Any:
    project = make(tmp_path_factory.mktemp("bristle"), TINY)
    with user_functions(project) as user:
        return user["user_JointForces"].robot


def test_states_stand_last_and_are_found(tmp_path: Path) -> None:
    """A plain .mbs, whose forces nobody computes, has none."""
    text = pendulum(3.5).replace("axle", "axle/1")
    points = {"arm": [[0.6, 0, 0], [0.6, 0.1, 0]]}
    project = make(tmp_path, text, base="fixed", passes={"contacts": {"points": points}})
    with user_functions(project) as user:
        robot = user["user_JointForces"].robot
        assert robot.FRICTION_STATES == {"axle_1": 1}
        assert robot.CONTACT_STATE == 2
    data = simulate(project, time=0.001, language="python").data
    names = [model.name for model in data._run.mbs.user_models]
    assert names[-2:] == ["friction_state", "contact_state"]
    assert data.user_model["friction_state"] == {"axle_1": 1}
    assert data.user_model["contact_state"] == {"arm": [2, 3, 4]}
    plain = convert_text(text, base="fixed", passes={"contacts": {"points": points}})
    assert not [p for m in plain.mbs.user_models for p in m.parameters if p.type == "state"]


def test_a_block_slides_to_rest_as_coulomb_says(tmp_path: Path) -> None:
    """It is thrown at 1 m/s, slides 1 / (2 mu g) far, and lies still."""
    block = (
        '<robot name="block"><link name="block"><inertial><mass value="2"/><inertia ixx="0.01" '
        'iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    points = {"block": [[x, y, 0] for x in (-0.2, 0.2) for y in (-0.2, 0.2)]}
    project = make(
        tmp_path, block, base="floating", passes={"contacts": {"points": points, "depth": 1e-4}}
    )
    data = MbsData(project / "dataR" / "robot.mbs")
    data.qd[data.joint_id["floating_base_T1"]] = 1.0
    data.q[data.joint_id["floating_base_T3"]] -= 1e-4  # at rest on the ground
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(tf=1.0, language="python", save2file=0)
    results = dirdyn.run()
    moved = results.joint("floating_base_T1")
    assert moved[-1] == pytest.approx(1.0 / (2 * 0.8 * G), rel=0.01)
    assert np.abs(results.qd[-1, 1:]).max() < 1e-9
    pulls = sum(rows[5] for rows in results.external.values())
    assert pulls[:3] == pytest.approx([-0.8 * pulls[2], 0.0, 2 * G], rel=1e-3, abs=1e-9)


@pytest.mark.slow
def test_a_robot_at_rest_takes_long_steps(tmp_path: Path) -> None:
    """C and Python give the same derivatives, which implicit integrators get.

    With differences of their own, which are rounding here, Radau took 15,000 steps, and LSODA
    18,000 a second where Solo stands.
    """
    project = make(
        tmp_path,
        pendulum(3.5),
        base="fixed",
        language="both",
        passes={"contacts": {"points": {"arm": [[0.6, 0, -0.1]]}, "ground": -0.0995}},
    )
    times: list[float] = []
    simulate(project, time=20.0, language="python", method="Radau", watch=times.append)
    assert len(times) < 1500
    data = MbsData(project / "dataR" / "robot.mbs")
    with user_code(data):
        jacobians = []
        for language in ("python", "c") if shutil.which("cc") else ("python", "python"):
            code = load_code(data, language)
            jacobians.append(code.differentiate(0.0, np.full(2 + data.Nux, 1e-3)))
    assert np.abs(jacobians[0]).max() > 1e3
    assert np.allclose(*jacobians, rtol=0, atol=1e-6 * np.abs(jacobians[0]).max())


@pytest.mark.skipif(shutil.which("cc") is None, reason="no compiler")
def test_bristles_spring_back_in_the_air_however_long_the_steps_are(tmp_path: Path) -> None:
    points = {"box": [[0, 0, 0]]}
    box = '<robot name="box">' + light_link("box", 2.0, 0.01, 0.0) + "</robot>"
    project = make(
        tmp_path,
        box,
        base="floating",
        language="both",
        passes={"contacts": {"points": points, "depth": 1e-4, "ground": -99.0, "stand": False}},
    )
    data = MbsData(project / "dataR" / "robot.mbs")
    data.ux[1:] = 1e-3
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(tf=2.0, framerate=10.0, language="c", save2file=0)
    dirdyn.run()
    assert np.abs(data.ux[1:]).max() < 1e-6
