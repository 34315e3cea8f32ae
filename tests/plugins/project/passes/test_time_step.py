"""The time step, and the start within limits."""

import re
import shutil
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from support import build
from support.folders import ROOT, SHARED
from support.light_chains import BIPED, WIDE, convert_project, hinge, light_link, messages
from support.oracle.mbs import Evaluator
from support.oracle.multibody import State, opening
from support.proving import models
from support.standin import RungeKutta, make, without_meshes
from urdf2mbs.mbs.model import Connection
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import convert_text
from urdf2mbs_project.mass import MassModel
from urdf2mbs_project.passes.time_step import describe_duration, round_to_two_digits_below
from urdf2mbs_project.simulation import Simulation
from urdf2mbs_project.stability import compute_longest_steps, compute_reduction
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.python_code import user_code
from urdf2mbs_simulate.runtime import MbsData

pin = pytest.importorskip("pinocchio")
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not there")


#: The light link between two coaxial joints feels the damping of both.
WRIST = (
    '<robot name="wrist"><link name="world"/>'
    + light_link("arm", 1.0, 0.01)
    + light_link("ring", 1e-4, 1e-6)
    + light_link("hand", 0.5, 0.002, 0.05)
    + hinge("shoulder", "world", "arm", WIDE)
    + hinge("first", "arm", "ring", WIDE + '<dynamics damping="0.02"/>', "0 0 1")
    + hinge("second", "ring", "hand", WIDE + '<dynamics damping="0.02"/>', "0 0 1")
    + "</robot>"
)


def step_of(project: Path) -> float:
    (module,) = project.glob("userfctR/*_robot.py")
    (line,) = [x for x in module.read_text().splitlines() if x.startswith("TIME_STEP")]
    return float(line.split()[-1])


# --- the bound ---


def test_the_bound_of_runge_and_kutta() -> None:
    steps = compute_longest_steps(np.array([-1.0, 1j, -10.0, 0.0, -100 + 100j]))
    assert steps[0] == pytest.approx(2.785293563, rel=1e-8)
    assert steps[1] == pytest.approx(sqrt(8.0), rel=1e-6)
    assert steps[2] == pytest.approx(0.2785293563, rel=1e-8)
    assert steps[3] == np.inf
    # a step beyond the bound grows, and none below it does
    for angle in np.linspace(pi / 2, pi, 40):
        direction = np.exp(1j * angle)
        (bound,) = compute_longest_steps(np.array([direction]))
        z = direction * bound * np.linspace(0.01, 1.3, 400)
        grows = np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24) > 1 + 1e-9
        assert np.array_equal(grows, np.abs(z) > bound * (1 + 1e-6))


def test_the_step_is_that_of_the_derivatives_of_the_accelerations(tmp_path: Path) -> None:
    """Eigenvalues by finite differences of what the generated functions do."""
    text = WRIST.replace('<dynamics damping="0.02"/>', '<dynamics damping="0.02" friction="0.01"/>')
    passes = {
        "joint-parameters": {"stops": False},
        "posture": {"joints": {"second": 0.3}, "hold": {"joints": ["shoulder"], "stiffness": 50}},
    }
    project = make(tmp_path, text, passes=passes)
    data = MbsData(project / "dataR" / "robot.mbs")
    with user_code(data):
        code, tiny = CCode(data), 1e-7
        y = code.get_state()
        still = code.accelerate(0.0, y)
        directions = np.eye(len(y))
        system = np.array(
            [(code.accelerate(0.0, y + tiny * w) - still) / tiny for w in directions]
        ).T
    rates = np.linalg.eigvals(system)
    assert step_of(project) == pytest.approx(0.4 * compute_longest_steps(rates).min(), rel=0.02)
    assert step_of(project) < 2e-4
    module = (project / "userfctR" / "robot_robot.py").read_text()
    assert "of joint 'first'.\n" in module or "of joint 'second'.\n" in module


def test_a_stop_counts_as_hit(tmp_path: Path) -> None:
    """With w = 2 pi frequency: stiffness 2 I w^2, damping I w; without stops it takes 0.5 ms."""
    text = (
        '<robot name="r"><link name="world"/>'
        + light_link("a", 1.0, 0.01)
        + hinge("one", "world", "a", WIDE)
        + "</robot>"
    )
    heavy = {"posture": {"hold": {"stiffness": 1e6, "damping": 0}}}
    for frequency, passes in ((20, {}), (800, heavy)):
        options = {"joint-parameters": {"stop_frequency": frequency}} | passes
        stiffness = (2 * pi * frequency) ** 2 * 2 + (1e6 / 0.01 if passes else 0.0)
        rates = np.roots([1.0, 2 * pi * frequency, stiffness])
        wanted = min(0.4 * compute_longest_steps(rates).min(), 1e-4)
        assert (wanted < 9.9e-5) == bool(passes)
        time_step = (
            convert_project(text, tmp_path, **options).conversion.state(Simulation).time_step
        )
        assert time_step == pytest.approx(wanted, rel=0.05)
    still = convert_project(text, tmp_path, **{"joint-parameters": {"stops": False}})
    assert still.conversion.state(Simulation).time_step == 5e-4


@pytest.mark.parametrize(
    ("step", "rounded"),
    [
        (2.79e-4, 2.7e-4),
        (3e-4, 3e-4),
        (2.9999999999e-4, 3e-4),
        (2.99999e-4, 2.9e-4),
        (1e-5, 1e-5),
        (9.99e-6, 9.9e-6),
        (0.128, 0.12),
        (1.0, 1.0),
    ],
)
def test_a_step_has_two_digits_and_is_not_rounded_up(step: float, rounded: float) -> None:
    assert round_to_two_digits_below(step) == rounded


# --- below 1e-5 s ---


@pytest.mark.parametrize(
    ("damping", "hold", "cause"),
    [(3.0, None, "damping of joint '"), (None, {"stiffness": 300.0, "damping": 4.0}, "hold of")],
)
def test_no_number_is_softened_for_a_longer_step(
    damping: float | None, hold: dict[str, float] | None, cause: str, tmp_path: Path
) -> None:
    """A warning names what makes the step short."""
    given = "" if damping is None else f'<dynamics damping="{damping}"/>'
    text = WRIST.replace('<dynamics damping="0.02"/>', given)
    result = convert_project(text, tmp_path, **({"posture": {"hold": hold}} if hold else {}))
    texts = messages(result)
    assert cause in texts["time-step-short"]
    assert "TIME_STEP is only" in texts["time-step-short"]
    numbers = models(result.mbs)
    if hold:
        assert set(numbers["hold_damping"].values()) == {4.0}
        assert set(numbers["hold_stiffness"].values()) == {300.0}
    else:
        assert set(numbers["damping"].values()) == {3.0}


def test_a_short_step_says_what_it_costs(tmp_path: Path) -> None:
    """How many steps a second of motion takes, and how long they compute."""
    result = convert_project(WRIST.replace('"0.02"', '"3"'), tmp_path)
    numbers = re.search(
        r"TIME_STEP is only (\S+) s, because of the damping of joint '\w+' \(3 N m s/rad, where "
        r"the joint feels (\S+) kg m\^2\): 1 s of motion takes (\S+) steps of RK4, about (\d+) s "
        r"of computing in C",
        messages(result)["time-step-short"],
    )
    assert numbers is not None, messages(result)["time-step-short"]
    step, inertia, n_steps, seconds = map(float, numbers.groups())
    assert inertia == pytest.approx(1e-6, rel=0.1)
    assert n_steps == pytest.approx(1.0 / step, rel=0.05)
    assert seconds == pytest.approx(1.3e-6 * n_steps * len(result.mbs.numbers()), rel=0.5)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.34, "0.3 s"), (49.0, "50 s"), (150.0, "2 min"), (4000.0, "70 min"), (9000.0, "2 h")],
)
def test_a_duration_has_one_digit(seconds: float, words: str) -> None:
    assert describe_duration(seconds) == words


# --- what comes out ---

ARM = ROOT / "configs" / "arm.urdf.xacro"
REAL_ROBOTS = {
    "cassie": SHARED / "robots/cassie/cassie_description/urdf/cassie_v4.urdf",
    "fr3": SHARED / "robots/franka/expanded/fr3.urdf",
    "ur10e": SHARED / "robots/ur/expanded/ur10e.urdf",
}


def compiled(project: Path) -> RungeKutta:
    (model,) = project.glob("dataR/*.mbs")
    return RungeKutta(CCode(MbsData(model)))


def c_step_of(project: Path) -> float:
    (header,) = project.glob("userfctR/*_robot.h")
    (line,) = [x for x in header.read_text().splitlines() if "_TIME_STEP " in x]
    return float(line.split()[-1])


@needs_gcc
@pytest.mark.parametrize(
    ("source", "divisor"),
    [
        pytest.param(ARM, 4, id="arm"),
        *(
            pytest.param(source, 16, id=f"{name}, finer", marks=pytest.mark.slow)
            for name, source in {"arm": ARM, "biped": BIPED, **REAL_ROBOTS}.items()
        ),
    ],
)
def test_a_finer_step_gives_the_same_motion(source: Path, divisor: int, tmp_path: Path) -> None:
    """A second of swinging by its base, into the stops, with all default options."""
    if not source.is_file():
        pytest.skip("the real robots are not beside the checkout")
    project = make(
        tmp_path,
        source,
        base="fixed",
        language="c",
        pipeline=without_meshes("compact"),
        passes={"equations": {"language": "c"}},
    )
    step = c_step_of(project)
    fine = compiled(project).positions(1.0, step / divisor, 20)
    assert np.abs(fine - fine[0]).max() > 0.1
    assert np.abs(compiled(project).positions(1.0, step, 20) - fine).max() <= 1e-4


@pytest.mark.parametrize("kind", ["ball", "rod", "solid"])
def test_a_closed_loop_stays_closed(kind: str) -> None:
    """The velocities that the time step is computed with open no cut."""
    text = build.robot(
        build.link("world"),
        *(build.link(name, build.SOLID) for name in "abcd"),
        build.joint("world", "a", axis="0 0 1"),
        build.joint("world", "b", axis="0 1 0", xyz="0.3 0 0"),
        build.joint("a", "c", "floating", xyz="0.1 0.2 0"),
        build.joint("b", "d", axis="1 0 0", xyz="0 0 0.2"),
    )
    data = convert_text(text, pipeline="faithful").data
    mbs, evaluator = read_mbs(data, ""), Evaluator(data)
    cut = Connection(kind, "tie", ("c", None), ("d", None), 0.3)
    mbs.cuts.append(cut)
    for name, mbs_joint in mbs.joints().items():
        mbs_joint.nature = "dependent" if name.startswith("a_to_c") else mbs_joint.nature
    reduction = compute_reduction(MassModel(mbs), Simulation())
    still = State(evaluator.system, evaluator.vector({}))
    rows = opening(kind, 0.3, *(still.place(evaluator.bodies[name].node) for name in "cd"))[1]
    assert reduction.any(axis=1).sum() > reduction.shape[1]
    np.testing.assert_allclose(rows[:, 1:] @ reduction, 0.0, atol=1e-12)
