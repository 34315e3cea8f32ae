"""A simulation keeps the error that it promises, and shares nothing with another one."""

import gc
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import Any

import numpy as np
import pytest

from support.standin import make
from urdf2mbs import ConversionError, load_equations, simulate
from urdf2mbs_simulate.steps import Rosenbrock

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")

INERTIAL = (
    '<inertial><origin xyz="0 0 -0.5"/><mass value="1"/><inertia ixx="0.02" iyy="0.02" '
    'izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>'
)
#: Two links of 1 m.
PENDULUM = (
    f'<robot name="dp"><link name="world"/><link name="a">{INERTIAL}</link><link name="b">'
    f'{INERTIAL}</link><joint name="j1" type="continuous"><parent link="world"/><child link="a"/>'
    '<axis xyz="0 1 0"/></joint><joint name="j2" type="continuous"><parent link="a"/>'
    '<child link="b"/><origin xyz="0 0 -1"/><axis xyz="0 1 0"/></joint></robot>'
)
START = {"posture": {"joints": {"j1": 1.0, "j2": 0.5}}}


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    return make(tmp_path, PENDULUM, base="fixed", language="both", passes=START)


@pytest.fixture
def in_python(tmp_path: Path) -> Path:
    return make(tmp_path, PENDULUM, base="fixed", language="python", passes=START)


def add_forces(project: Path, lines: str) -> None:
    """Add lines of C to user_JointForces."""
    file = project / "userfctR" / "user_JointForces.c"
    end = "    return mbs_data->Qq;"
    assert end in file.read_text()
    file.write_text(file.read_text().replace(end, f"    {{ {lines} }}\n{end}"))


def add_python(project: Path, name: str, after: str, lines: str) -> None:
    file = project / "userfctR" / name
    assert after in file.read_text()
    file.write_text(file.read_text().replace(after, after + lines))


def add_states(project: Path, values: list[float]) -> None:
    (model,) = project.glob("dataR/*.mbs")
    parameters = "".join(
        f"<parameter><name>x{k}</name><type>state</type><value>{value}</value></parameter>"
        for k, value in enumerate(values)
    )
    user = f"<user_model><name>ctrl</name>{parameters}</user_model>"
    text = model.read_text()
    if "</user_models>" in text:
        text = text.replace("</user_models>", f"{user}</user_models>")
    else:
        text = text.replace("</bodytree>", f"</bodytree><user_models>{user}</user_models>", 1)
    model.write_text(text)


# --- the error ---


@pytest.mark.parametrize("rate", [300.0, 1000.0, 1e4, 1e6])
def test_a_stiff_user_state_is_right(in_python: Path, rate: float) -> None:
    """ux' = -rate (ux - sin t), which is a function of the time alone."""
    add_states(in_python, [0.0])
    (in_python / "userfctR" / "user_Derivative.py").write_text(
        "from math import sin\n"
        "def user_derivatives(mbs_data):\n"
        f"    mbs_data.uxd[1] = -{rate} * (mbs_data.ux[1] - sin(mbs_data.tsim))\n"
    )
    results = simulate(in_python, time=1.0)
    t = results.time
    exact = (rate**2 * np.sin(t) - rate * np.cos(t) + rate * np.exp(-rate * t)) / (1 + rate**2)
    assert np.abs(results.ux[:, 1] - exact).max() < 1e-4
    assert results.ux.shape == (101, 2)


@pytest.mark.parametrize("seed", range(4))
def test_random_stiff_user_states_keep_ten_times_the_tolerance(in_python: Path, seed: int) -> None:
    """w' = -A (w - sin t), of random matrices with eigenvalues from 1 to 1e6 1/s."""
    rng = np.random.default_rng(seed)
    basis = rng.normal(size=(4, 4))
    matrix = basis @ np.diag(10.0 ** rng.uniform(0.0, 6.0, 4)) @ np.linalg.inv(basis)
    add_states(in_python, [0.3, -0.2, 0.1, 0.5])
    (in_python / "userfctR" / "user_Derivative.py").write_text(
        f"import numpy as np\nA = np.array({matrix.tolist()})\n"
        "def user_derivatives(mbs_data):\n"
        "    mbs_data.uxd[1:] = -A @ (mbs_data.ux[1:] - np.sin(mbs_data.tsim))\n"
    )
    states = simulate(in_python, time=0.5).ux[:, 1:]
    # w = sin t + z with z' = -A z - cos t, solved by the eigenvectors of A
    rates, vectors = np.linalg.eig(matrix)
    inverse, t = np.linalg.inv(vectors), np.linspace(0.0, 0.5, 51)[:, None]
    start, drive = inverse @ [0.3, -0.2, 0.1, 0.5], inverse @ np.ones(4)
    forced = -drive * (rates * np.cos(t) + np.sin(t)) / (rates**2 + 1.0)
    fading = (start + drive * rates / (rates**2 + 1.0)) * np.exp(-rates * t)
    exact = np.sin(t) + ((forced + fading) @ vectors.T).real
    assert np.abs(states - exact).max() < 10 * 1e-5 * np.abs(exact).max()


def test_user_states_in_c_are_states_of_the_run(pendulum: Path) -> None:
    add_states(pendulum, [1.0])
    (pendulum / "userfctR" / "user_Derivative.c").write_text(
        '#include "mbs_data.h"\n#include "mbs_project_interface.h"\n'
        "void user_Derivative(MbsData *mbs_data)\n"
        "{\n    mbs_data->uxd[1] = -50.0 * mbs_data->ux[1];\n}\n"
    )
    results = simulate(pendulum, time=0.2, language="c")
    assert results.language == "C"
    assert results.ux[:, 1] == pytest.approx(np.exp(-50.0 * results.time), abs=1e-4)


@pytest.mark.parametrize(("stiffness", "damping"), [(1e5, 1e3), (1e5, 1e4), (1e6, 3e3), (1e7, 1e4)])
def test_a_spring_between_two_joints_is_exact_and_fast(
    pendulum: Path, stiffness: float, damping: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_forces(
        pendulum,
        "double e = mbs_data->q[1] - mbs_data->q[2] - 0.5, ed = mbs_data->qd[1] - mbs_data->qd[2];"
        f"double f = {stiffness} * e + {damping} * ed;"
        "mbs_data->Qq[1] -= f; mbs_data->Qq[2] += f;",
    )
    tight = {"rtol": 1e-8, "atol": 1e-10, "language": "c", "time": 2.0}
    exact = simulate(pendulum, method="Radau", **tight)
    taken, step = [0], Rosenbrock.step

    def count(solver: Rosenbrock) -> None:
        step(solver)
        taken[0] += solver.steps_taken

    monkeypatch.setattr(Rosenbrock, "step", count)
    results = simulate(pendulum, time=2.0, language="c")
    assert np.abs(results.q - exact.q).max() < 1e-4
    assert taken[0] < 1000
    fine = simulate(pendulum, time=2.0, language="c", rtol=1e-8)
    assert np.abs(fine.q - exact.q).max() < 1e-6


def test_smaller_tolerances_give_smaller_errors(pendulum: Path) -> None:
    exact = simulate(pendulum, time=2.0, language="c", method="DOP853", rtol=1e-12, atol=1e-12)
    errors = [
        np.abs(simulate(pendulum, time=2.0, language="c", rtol=rtol).q - exact.q).max()
        for rtol in (1e-5, 1e-7, 1e-9)
    ]
    assert errors[1] < errors[0] / 10
    assert errors[2] < errors[1] / 10


@pytest.mark.parametrize("is_stiff", [False, True])
def test_the_rate_of_frames_changes_no_step(pendulum: Path, is_stiff: bool) -> None:
    if is_stiff:
        add_forces(pendulum, "mbs_data->Qq[1] -= 1e4 * mbs_data->qd[1];")
    ends = [simulate(pendulum, time=2.0, rate=rate, language="c") for rate in (1.0, 10.0, 1000.0)]
    for results in ends:
        assert results.q[-1, 1:].tolist() == ends[0].q[-1, 1:].tolist()
    exact = simulate(pendulum, time=2.0, language="c", method="Radau", rtol=1e-9, rate=1000.0)
    assert np.abs(ends[2].q - exact.q).max() < 1e-3
    assert np.abs(ends[2].qd - exact.qd).max() < 3e-3


# --- what a run keeps ---


@pytest.mark.parametrize("language", ["c", "python"])
def test_outputs_are_those_of_the_frames(pendulum: Path, language: str) -> None:
    """User code in user_JointForces is called in trial states, too."""
    file = pendulum / "userfctR" / "user_JointForces.c"
    file.write_text(f'#include "set_output.h"\n{file.read_text()}')
    add_forces(pendulum, 'set_output(mbs_data->qd[1], "speed");')
    add_python(
        pendulum,
        "user_JointForces.py",
        "    robot.joint_forces(mbs_data)\n",
        '    mbs_data.set_output(mbs_data.qd[1], "speed")\n',
    )
    results = simulate(pendulum, time=1.0, language=language)
    speed = results.outputs["speed"]
    assert speed[:, 0].tolist() == results.time.tolist()
    assert speed[:, 1].tolist() == results.qd[:, 1].tolist()


@pytest.mark.parametrize("language", ["c", "python"])
def test_trial_states_give_no_outputs(pendulum: Path, language: str) -> None:
    file = pendulum / "userfctR" / "user_JointForces.c"
    file.write_text(f'#include "set_output.h"\n{file.read_text()}')
    off = "fabs(100 * tsim - floor(100 * tsim + 0.5)) > 1e-6"
    add_forces(pendulum, f'if ({off}) set_output(1.0, "between");')
    add_python(
        pendulum,
        "user_JointForces.py",
        "    robot.joint_forces(mbs_data)\n",
        "    if abs(100 * tsim - round(100 * tsim)) > 1e-6:\n"
        '        mbs_data.set_output(1.0, "between")\n',
    )
    assert "between" not in simulate(pendulum, time=0.1, language=language).outputs


def test_an_error_of_python_is_that_of_the_user(in_python: Path) -> None:
    """Solvers of scipy raise a ValueError themselves, and a user's is not theirs."""
    add_python(
        in_python,
        "user_JointForces.py",
        "    robot.joint_forces(mbs_data)\n",
        "    mbs_data.Qq[1] += float('' if tsim > 0.5 else '0')\n",
    )
    file = in_python / "userfctR" / "user_JointForces.py"
    for method in ("Rosenbrock", "Radau", "DOP853", "RK4"):
        with pytest.raises(ConversionError, match=r"at 0\.5\d* s: ValueError: could not") as caught:
            simulate(in_python, time=1.0, method=method)
        assert caught.value.file == str(file)
        assert caught.value.line is not None


NAMES = [
    "held",
    "push",
    "pushes",
    "said",
    "model",
    "mbs",
    "project",
    "modules",
    "natures",
    "kept",
    "own",
    "turned",
    "outputs",
    "can_turn",
    "mbs_file",
    "own_angles",
    "u",
    "state",
    "notes",
    "locked",
]


def test_any_attribute_is_the_users(in_python: Path) -> None:
    lines = "".join(f"    mbs_data.{name} = 1\n" for name in NAMES)
    add_python(in_python, "user_dirdyn.py", "    robot.check_step(mbs_data)\n", lines)
    add_python(
        in_python,
        "user_JointForces.py",
        "    robot.joint_forces(mbs_data)\n",
        "    mbs_data.Qq[1] -= 5 * getattr(mbs_data, 'u', 0.0) * mbs_data.qd[1]\n",
    )
    results = simulate(in_python, time=0.1, push=["b:1,0,0@0.02.."])
    assert results.time[-1] == 0.1
    assert "push1.b.Fx" in results.columns()


def test_steps_of_robotrans_take_the_step_of_the_project(tmp_path: Path) -> None:
    """A stop of 800 Hz wants a step of 20 us: steps of 1 ms failed."""
    text = PENDULUM.replace('type="continuous"', 'type="revolute"').replace(
        "</joint>", '<limit lower="-0.1" upper="1.1" effort="9" velocity="9"/></joint>'
    )
    passes = START | {"joint-parameters": {"stop_frequency": 800}}
    project = make(tmp_path, text, base="fixed", language="python", passes=passes)
    (step,) = re.findall(
        r"(?m)^TIME_STEP = (\S+)", (project / "userfctR" / "robot_robot.py").read_text()
    )
    count = [0]

    def watch(_: float) -> None:
        count[0] += 1

    results = simulate(project, time=0.02, method="RK4", watch=watch)
    assert count[0] == pytest.approx(0.02 / float(step), abs=1.5)
    assert np.isfinite(results.q).all()


# --- several runs at once ---


def test_equations_do_not_feel_the_push_of_a_simulation(in_python: Path) -> None:
    """Both take the same library; the pushes of the one were memory that was freed."""
    (model,) = in_python.glob("dataR/*.mbs")
    robot = load_equations(model, language="c")
    q, z = [0.3, 0.2], [0.0, 0.0]
    wanted = robot.forward_dynamics(q, z, z).tolist()
    results = simulate(model, time=0.5, push=["b:100,0,0@0..9"])
    assert robot.forward_dynamics(q, z, z).tolist() == wanted
    del results
    gc.collect()
    assert robot.forward_dynamics(q, z, z).tolist() == wanted


CASES: list[dict[str, Any]] = [
    {},
    {"push": ["b:30,0,0@0.1..0.3"]},
    {"push": ["a:0,0,50@0..0.2"], "rtol": 1e-7},
    {"method": "DOP853"},
]


@pytest.fixture
def ball_and_pendulum(tmp_path: Path) -> list[Path]:
    """One has contacts, user states and user functions in C, the other is all Python's."""
    ball = '<robot name="r"><link name="b"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" '
    ball += 'izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>'
    ball += '<sphere radius="0.1"/></geometry></collision></link></robot>'
    (tmp_path / "c").mkdir()
    (tmp_path / "py").mkdir()
    passes = {"contacts": {"links": ["b"]}}
    first = make(tmp_path / "c", ball, base="floating", language="both", passes=passes)
    return [
        first,
        make(tmp_path / "py", PENDULUM, base="fixed", language="python", passes=START),
    ]


def run_case(project: Path, case: dict[str, Any], **more: Any) -> Any:
    case = case | ({"push": ["b:5,0,0@0.1..0.3"]} if "push" in case else {})
    return simulate(project, time=0.4, **case, **more).q


def test_runs_in_threads_are_those_alone(ball_and_pendulum: list[Path]) -> None:
    jobs = [(project, case) for project in ball_and_pendulum for case in CASES] * 2
    alone = [run_case(*job) for job in jobs]
    begin = Barrier(len(jobs))
    waiting = [True] * len(jobs)

    def run(k: int) -> Any:
        def watch(_: float) -> None:
            if waiting[k]:  # all have begun before one goes on
                waiting[k] = False
                begin.wait()

        try:
            return run_case(*jobs[k], watch=watch)
        except BaseException:
            begin.abort()
            raise

    with ThreadPoolExecutor(len(jobs)) as pool:
        together = list(pool.map(run, range(len(jobs))))
    for wanted, found in zip(alone, together, strict=True):
        assert np.array_equal(wanted, found)


def test_runs_inside_of_others_are_those_alone(ball_and_pendulum: list[Path]) -> None:
    """A second simulation and other equations run between the steps of the first."""
    first, second = ball_and_pendulum
    (model,) = second.glob("dataR/*.mbs")
    alone = run_case(first, CASES[1]), run_case(second, CASES[1])
    robot = load_equations(model)
    state = [0.3, 0.2], [0.0, 0.0], [0.0, 0.0]
    wanted = robot.forward_dynamics(*state).tolist()
    inner: list[Any] = []

    def watch(time: float) -> None:
        if len(inner) < 3 and time > 0.05 * len(inner):
            inner.append(run_case(second, CASES[1]))
            assert robot.forward_dynamics(*state).tolist() == wanted

    assert np.array_equal(run_case(first, CASES[1], watch=watch), alone[0])
    assert len(inner) == 3
    assert all(np.array_equal(found, alone[1]) for found in inner)


#: Several simulations whose C looks at each access to memory.
CHECKED = """
import sys
from urdf2mbs import load_equations, simulate
from urdf2mbs_simulate import compiler
compiler.FLAGS += ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g")
make = compiler.Build.make
def with_checks(build, sources):
    link = [*build.flags.link, "-fsanitize=address,undefined"]
    build.flags = build.flags._replace(link=link)
    return make(build, sources)
compiler.Build.make = with_checks
for project in sys.argv[1:]:
    robots = []
    def watch(time):
        if len(robots) < 2:
            simulate(project, time=0.02)
            robots.append(load_equations(project))
            zeros = [0.0] * len(robots[0].joints)
            robots[-1].forward_dynamics(zeros, zeros, zeros)
    simulate(project, time=0.3, push=["b:5,0,0@0.1..0.2"], watch=watch)
print("checked")
"""


@pytest.mark.slow
def test_a_checker_of_memory_finds_no_fault(ball_and_pendulum: list[Path], tmp_path: Path) -> None:
    cc = shutil.which("cc")
    sanitizer = subprocess.run(
        [str(cc), "-print-file-name=libasan.so"], capture_output=True, text=True, check=False
    ).stdout.strip()
    if not Path(sanitizer).is_file():
        pytest.skip("the compiler has no address sanitizer")
    environment = {
        "LD_PRELOAD": sanitizer,
        "ASAN_OPTIONS": "detect_leaks=0",
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "PATH": str(Path(str(cc)).parent),
        "HOME": str(tmp_path),
    }
    done = subprocess.run(
        [sys.executable, "-c", CHECKED, *map(str, ball_and_pendulum)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "checked" in done.stdout, done.stderr[-3000:]
