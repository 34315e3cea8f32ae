"""The runtime moves small robots as their closed forms say, and keeps all that it has computed."""

import ctypes
import math
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from support.motions import DAMPING, MASS, SLIDER, STIFFNESS, falls, model
from support.rich_robot import PASSES, convert
from support.standin import make
from urdf2mbs import ConversionError, Push, load_equations, simulate
from urdf2mbs.engine.output import write
from urdf2mbs.mbs.model import (
    BASE,
    Body,
    Joint,
    Mbs,
)
from urdf2mbs.mbs.writer import write as write_mbs
from urdf2mbs_simulate import dirdyn as runs
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.compiler import compiler
from urdf2mbs_simulate.data import MbsSensor
from urdf2mbs_simulate.dirdyn import integrate, load_code
from urdf2mbs_simulate.memory import RunInC, SensorInC, as_c_vector
from urdf2mbs_simulate.python_code import USER_FUNCTIONS, get_default_function, user_code
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn, MbsPart
from urdf2mbs_simulate.solvers import METHODS, ROBOTRAN_METHODS

pytestmark = pytest.mark.skipif(compiler() is None, reason="there is no C compiler")
#: Of the user functions.
LANGUAGES = pytest.mark.parametrize("language", ["python", "c"])


@pytest.fixture(scope="module")
def slider(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("slider"), SLIDER, base="fixed")


@pytest.fixture(scope="module")
def rich(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a project with a rod, dependent and driven joints, contacts, a spring and a wrench."""
    folder = tmp_path_factory.mktemp("rich")
    write(convert(folder, PASSES))
    return folder / "rich"


@LANGUAGES
@pytest.mark.parametrize("method", [*METHODS, *ROBOTRAN_METHODS])
def test_a_slider_swings_and_comes_to_rest(slider: Path, method: str, language: str) -> None:
    times: list[float] = []
    results = simulate(
        slider,
        time=0.61,
        method=method,
        language=language,
        rate=50.0,
        rtol=1e-7,
        atol=1e-9,
        watch=times.append,
    )
    assert np.allclose(results.time, np.linspace(0.0, 0.61, 31), rtol=0, atol=1e-14)
    assert times[-1] == results.time[-1] == 0.61
    (rail,) = results.data.joint_id.values()
    q, qd = falls(results.time)
    force = -STIFFNESS * q - DAMPING * qd
    for found, should in (
        (results.q, q),
        (results.qd, qd),
        (results.Qq, force),
        (results.qdd, force / MASS - 9.81),
    ):
        assert np.allclose(found[:, rail], should, rtol=0, atol=2e-5)
        assert np.array_equal(found[:, 0], results.time)
    energies = results.energy()
    assert np.allclose(energies[:, 0], MASS / 2 * results.qd[:, rail] ** 2, rtol=0, atol=1e-12)
    height = results.q[:, rail] + 0.3
    assert np.allclose(energies[:, 1], MASS * 9.81 * height, rtol=0, atol=1e-9)
    assert results.language == "C, user functions in Python"
    assert not results.stopped


@LANGUAGES
def test_slopes_are_those_of_the_slider(slider: Path, language: str) -> None:
    data = MbsData(model(slider))
    with user_code(data):
        code = load_code(data, language)
        should = [-0.3, -9.81 - (STIFFNESS * 0.2 - DAMPING * 0.3) / MASS]
        rates = code.accelerate(0.5, np.array([0.2, -0.3]))
        assert np.allclose(rates, should, rtol=0, atol=1e-12)
        assert data.tsim == 0.5
        for y in ([0.2, -0.3], [-4.0, 30.0]):
            should = [[0.0, 1.0], [-STIFFNESS / MASS, -DAMPING / MASS]]
            assert np.allclose(code.differentiate(0.0, np.array(y)), should, rtol=0, atol=1e-5)


@LANGUAGES
def test_what_constraints_and_drives_do_is_what_is_left_of_the_forces(
    rich: Path, language: str
) -> None:
    """M qdd + c = Qq + Jac' Lambda, and Qc in driven joints; Jac is that of h, by differences."""
    data = MbsData(model(rich))
    with user_code(data):
        code = load_code(data, language)
        cuts, user = code.row_counts
        assert (cuts, user) == (1, 2)
        data.qd[data.qu[1:]] = np.linspace(-1.0, 1.0, data.nqu)
        assert not code.compute_accelerations()
        code.compute_reactions()
        jac = code.compute_constraints()[1]
        rest = code.compute_inverse_dynamics() - data.Qq - jac.T @ data.Lambda[1:]
        scale = 1e-9 * np.abs(code.compute_inverse_dynamics()).max()
        assert np.allclose(rest[data.qc[1:]], data.Qc[data.qc[1:]], rtol=0, atol=scale)
        rest[data.qc[1:]] = 0.0
        assert np.abs(rest[1:]).max() < scale
        assert np.abs(data.Lambda[1:]).min() > 1e-3
        assert np.median(np.abs(data.Qc[data.qc[1:]])) > 1e-2
        h = np.zeros(data.nqv + 1)
        table, q = np.zeros((data.nqv + 1, data.njoint + 1)), data.q.copy()

        def opened(at: Any) -> Any:
            data.q[:] = at
            data.mbs_cons_hJ(h, table, data)
            data.user_cons_hJ(h[cuts:], table[cuts:], data, 0.0)
            return h[1:].copy()

        assert np.abs(opened(q)).max() < 1e-9
        for k in (*data.qu[1:], *data.qv[1:]):
            step = 1e-6 * np.eye(data.njoint + 1)[k]
            slope = (opened(q + step) - opened(q - step)) / 2e-6
            assert np.allclose(jac[:, k], slope, rtol=0, atol=1e-7)


def test_all_that_a_run_has_computed_is_kept_and_written(rich: Path, tmp_path: Path) -> None:
    data = MbsData(model(rich))
    data._run.pushes = [
        Push("of_arm", (1.0, 2.0, 3.0), 0.001, 0.002),
        Push("rope_1", (0.0, 0.0, -4.0)),
    ]
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(
        tf=0.003,
        framerate=2000,
        resfilename="mine",
        respath=str(tmp_path / "r"),
        animpath=tmp_path / "a",
        language="python",
    )
    results = dirdyn.run()
    assert len(results.time) == 7
    names = {
        file.name.removeprefix("mine_").removesuffix(".res"): file
        for file in (tmp_path / "r").glob("*.res")
    }
    assert {*names} == {
        "q",
        "qd",
        "qdd",
        "Qq",
        "Qc",
        "Lambda",
        "ux",
        "uxd",
        "linkZ",
        "linkZD",
        "linkF",
    }
    kept = {"linkZ": "Z", "linkZD": "Zd", "linkF": "Fl"}
    for name, file in names.items():
        assert np.array_equal(np.loadtxt(file), results.frames[kept.get(name, name)])
        assert np.array_equal(np.loadtxt(file)[:, 0], results.time)
    assert [file.name for file in (tmp_path / "a").glob("*.anim")] == ["mine_q.anim"]
    columns, n = results.columns(), len(data.joint_id)
    forces, links = data.extforce_id, data.link_id
    assert len(columns) == 1 + 5 * n + 9 * len(forces) + 3 * len(links) + 2 + 2 * 6
    (rope,) = links
    spring = data.user_model["link_stiffness"][rope], data.user_model["link_length"][rope]
    stretched = columns[f"{rope}.Z"] - spring[1]
    damped = data.user_model["link_damping"][rope] * columns[f"{rope}.Zd"]
    assert np.allclose(columns[f"{rope}.Fl"], spring[0] * stretched + damped, rtol=0, atol=1e-9)
    one, two = (np.array([columns[f"{rope}.{kind}"] for kind in ("Z", "Zd")])[:, k] for k in (1, 2))
    assert (two[0] - one[0]) / 0.0005 == pytest.approx((one[1] + two[1]) / 2, abs=1e-3)
    for name, number in forces.items():
        assert columns[f"{name}.Fz"].tolist() == results.frames["SWr"][:, number, 3].tolist()
        assert columns[f"{name}.dx"].tolist() == results.external[name][:, 6].tolist()
    first, second = (f"push{k}.{body}" for k, body in ((1, "of_arm"), (2, "trunk")))
    acts = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])  # from 0.001 s until 0.002 s
    for k, axis in enumerate("xyz"):
        assert columns[f"{first}.F{axis}"].tolist() == ((k + 1) * acts).tolist()
        place = data.l[k + 1, data.body_id["of_arm"]]
        assert columns[f"{first}.d{axis}"].tolist() == [place] * 7
        place = data.dpt[k + 1, data.points_id["trunk"]["rope_1"]]
        assert columns[f"{second}.d{axis}"].tolist() == [place] * 7
    assert columns[f"{second}.Fz"].tolist() == [-4.0] * 7


def test_a_body_without_mass_weighs_nothing(tmp_path: Path) -> None:
    file = tmp_path / "dataR" / "r.mbs"
    file.parent.mkdir()
    heavy = Body("heavy", None, None, [Joint("one", "R1", "independent")], mass=2.0)
    bare = Body("bare", "heavy", None, [Joint("two", "R1", "driven")])
    file.write_bytes(write_mbs(Mbs("r", bodies=[heavy, bare])))
    data = MbsData(file)
    assert list(data.m) == [0.0, 2.0, 0.0]
    assert not data.l.any()
    assert not data.In.any()


def test_a_push_does_the_work_of_its_point(rich: Path) -> None:
    robot, chance = load_equations(model(rich), language="python"), np.random.default_rng(7)
    data = MbsData(model(rich))
    free = np.sort([*data.qu[1:], *data.qv[1:]])  # the others are constants of the equations
    for link, place in (
        ("of_ankle", "of_ankle"),
        ("of_bar3", "of_bar3"),
        ("trunk", "trunk"),
        ("wind_at", ("of_slide", "wind_at")),
    ):
        selection = robot.selection
        is_free = np.isin(selection.numbers, free)
        q = data.q0[selection.numbers] + is_free * chance.uniform(-1.0, 1.0, len(is_free))
        selection.spread(q, data.q, selection.q0)
        force = chance.uniform(-1.0, 1.0, 3)
        data._run.pushes = [Push(link, tuple(force), 1.0, 2.0)]
        data.user_JointForces = lambda mbs_data, tsim: mbs_data.Qq.fill(0.5)
        with user_code(data):
            code = CCode(data)
        jac = robot.jacobian(place, q)
        if link == place:  # at the centre of mass
            arm = _axes(robot, link, q).T @ data.l[1:, data.body_id[link]]
            jac[:3] += np.cross(jac[3:].T, arm).T
        should = (jac[:3].T @ force)[is_free]
        for time, acts in ((0.99, 0.0), (1.0, 1.0), (1.5, 1.0), (2.0, 0.0)):
            code.library.user_call_JointForces(code.run_address, ctypes.c_double(time))
            actual = selection.reduce(data.Qq - 0.5, (0,))[is_free]
            assert np.allclose(actual, acts * should, rtol=0, atol=1e-12), (link, time)


def _axes(robot: Any, body: str, q: Any) -> Any:
    """Return the axes of a body in those of the base, a row each."""
    sensor = SimpleNamespace(
        **{name: np.zeros(4) for name in ("P", "V", "OM", "A", "OMP")},
        R=np.zeros((4, 4)),
        J=np.zeros((7, len(q) + 1)),
    )
    robot.selection.spread(q, robot.data.q, robot.selection.q0)
    robot.data.mbs_gensensor(sensor, robot.data, robot.data.body_id[body])
    return sensor.R[1:, 1:]


def test_no_step_goes_over_the_begin_or_end_of_a_force(rich: Path) -> None:
    data = MbsData(model(rich))  # its wrench lasts from 0.5 s to 1.5 s
    force = (1.0, 0.0, 0.0)
    data._run.pushes = [Push("trunk", force, 0.2, 0.7), Push("trunk", force, 0.1)]
    data.user_model["of_a_user"] = {"start": 0.3, "other": 0.4}
    assert runs.list_discontinuities(data, 0.0, 9.0) == [0.1, 0.2, 0.5, 0.7, 1.5]
    assert runs.list_discontinuities(data, 0.1, 0.7) == [0.2, 0.5]


@pytest.mark.parametrize(
    ("language", "changed", "user_in_c"),
    [(None, False, True), (None, True, False), ("c", True, True), ("python", False, False)],
)
def test_the_language_of_user_functions(
    language: Any, changed: bool, user_in_c: bool, tmp_path: Path
) -> None:
    project = make(tmp_path, SLIDER, base="fixed", language="both")
    if changed:
        file = project / "userfctR" / "user_JointForces.py"
        file.write_text(file.read_text() + "\nmine = 1\n")
    data = MbsData(model(project))
    with user_code(data):
        code = load_code(data, language)
    assert code.has_user_c is user_in_c
    assert code.name == ("C" if user_in_c else "C, user functions in Python")


def test_without_a_compiler_one_line_says_what_to_install(
    slider: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("urdf2mbs_simulate.compiler.compiler", lambda: None)
    with pytest.raises(ConversionError, match="no C compiler") as caught:
        simulate(slider)
    assert caught.value.hint == "pip install ziglang"


@pytest.mark.parametrize(
    "option",
    [
        {"tf": 0.0},
        {"t0": 6.0},
        {"tf": math.inf},
        {"tf": math.nan},
        {"framerate": 0},
        {"rtoler": 0.0},
        {"rtoler": math.nan},
        {"dt0": 0.0},
        {"dt0": -1.0},
    ],
)
def test_a_run_with_impossible_options_is_refused(slider: Path, option: dict[str, float]) -> None:
    dirdyn = MbsDirdyn(MbsData(model(slider)))
    dirdyn.set_options(save2file=0, language="python", **option)
    with pytest.raises(ConversionError, match="must be"):
        dirdyn.run()


def test_a_run_from_a_later_time_calls_the_user_after_each_step(slider: Path) -> None:
    data = MbsData(model(slider))
    calls: list[tuple[str, float]] = []
    for name in ("init", "loop", "finish"):
        setattr(data, f"user_dirdyn_{name}", lambda d, _, name=name: calls.append((name, d.tsim)))
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(t0=1.0, tf=1.1, dt_max=0.02, framerate=100, language="python")
    with user_code(data):
        results = integrate(data, CCode(data), dirdyn.options, dirdyn)
    assert np.allclose(results.q[:, 1], falls(results.time - 1.0)[0], rtol=0, atol=1e-5)
    assert np.allclose(results.time, np.linspace(1.0, 1.1, 11), rtol=0, atol=1e-14)
    assert [name for name, _ in calls] == ["init", *["loop"] * (len(calls) - 2), "finish"]
    times = [1.0, *(time for name, time in calls if name == "loop")]
    assert np.diff(times).max() <= 0.02 + 1e-12
    assert np.diff(times)[0] <= 1e-3 + 1e-12
    assert times[-1] == 1.1


def test_the_start_is_closed_or_not(rich: Path) -> None:
    data = MbsData(model(rich))
    MbsPart(data).run()
    assert data.DonePart == 1
    data = MbsData(model(rich))
    data.lrod[1] = 9.0  # longer than all bars together
    with pytest.raises(RuntimeError, match=r"rod 'tie' is \S+ mm from closed along the rod"):
        MbsPart(data).run()
    assert data.DonePart == 0
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(language="python", save2file=0)
    data.q[2] = math.nan
    with pytest.raises(ConversionError, match=f"position or speed of '{list(data.joint_id)[1]}'"):
        dirdyn.run()


def test_derivatives_are_differences(rich: Path, slider: Path) -> None:
    robot = load_equations(model(slider), language="python")
    assert robot.position("load", [0.4]).tolist() == [0.0, 0.0, 0.4]
    by_q, by_qd, by_tau = robot.forward_dynamics_derivatives([0.3], [0.2], [0.1])
    assert (by_q.item(), by_qd.item(), by_tau.item()) == (0.0, 0.0, 1.0 / MASS)
    assert robot.parameters().tolist()[:4] == pytest.approx([MASS, 0.2, 0.4, 0.6])
    for place in (BASE, "nowhere"):
        with pytest.raises(ValueError, match="no body and no point"):
            robot.position(place, [0.0])
    for wrong, words in (
        ({"language": "java"}, "no language 'java'"),
        ({"language": "c", "math": np}, "C has floats only"),
    ):
        with pytest.raises(ConversionError, match=words):
            load_equations(model(slider), **wrong)
    robot = load_equations(model(rich), language="python")
    with pytest.raises(ValueError, match="rod 'tie' closes a loop with joint 'bar3'"):
        robot.forward_dynamics_derivatives(*np.zeros((3, len(robot.joints))))


def test_a_run_by_itself_is_of_two_seconds(slider: Path) -> None:
    results = simulate(slider, language="python")
    assert np.allclose(results.time, np.arange(201) / 100, rtol=0, atol=1e-12)
    options = MbsDirdyn(results.data).options
    assert (options["t0"], options["tf"], options["dt0"]) == (0.0, 5.0, None)
    assert (options["framerate"], options["save2file"]) == (100.0, 1)


def test_the_joint_and_the_force_that_are_named_are_the_largest(rich: Path) -> None:
    data = MbsData(model(rich))
    data.qd[3], data.qdd[2:4], data.Qq[3] = 7.0, (50.0, -60.0), 8.0
    force = list(data.extforce_id)[1]
    data.SWr[1:, 1:4], data.SWr[2, 1:4] = 1.0, (-30.0, 0.0, 40.0)
    data._run.pushes = [
        Push("trunk", (3.0, 0.0, 4.0), 0.5, 1.0),
        Push("of_arm", (9.0, 0.0, 0.0), 1.0),
    ]
    code: Any = SimpleNamespace(data=data, accelerate=lambda *_: None)
    message = runs.make_step_error(code, 0.5, np.zeros(0), "no").message
    joint = list(data.joint_id)[2]
    assert f"joint '{joint}' has 7 rad/s or m/s and -60 rad/s^2 or m/s^2" in message
    assert "its force is 8 N m or N" in message
    assert f"'{force}' with 50 N; the push on 'trunk' is 5 N" in message
    assert "of_arm" not in message
    assert "push on 'of_arm' is 9 N" in runs.make_step_error(code, 1.0, np.zeros(0), "no").message


def test_what_the_user_has_not_gives_what_is_there(rich: Path) -> None:
    data = MbsData(model(rich))
    data.SWr[:] = np.arange(data.SWr.size).reshape(data.SWr.shape)
    data.l3DWr = np.arange(30.0).reshape(3, 10)
    functions = {name: get_default_function(data, name) for name in USER_FUNCTIONS}
    assert functions["user_ExtForces"](data, 0.0, 1).tolist() == data.SWr[1].tolist()
    assert functions["user_Link3DForces"](data, 0.0, 2).tolist() == data.l3DWr[2].tolist()
    assert functions["user_LinkForces"](1.0, 2.0, data, 0.0, 1) == 0.0
    assert functions["user_JointForces"](data, 0.0) is None


@pytest.mark.parametrize(
    "call",
    [
        lambda code, y: code.accelerate(0.0, y),
        lambda code, y: code.differentiate(0.0, y),
        lambda code, _: code.compute_accelerations(),
        lambda code, _: code.compute_constraints(),
    ],
)
def test_what_python_raises_comes_through_c(rich: Path, call: Any) -> None:
    data = MbsData(model(rich))

    def fails(*_: Any) -> None:
        raise ZeroDivisionError

    data.user_cons_hJ = fails
    with user_code(data):
        code = CCode(data, user_in_c=False)
        with pytest.raises(ZeroDivisionError):
            call(code, code.get_state())


def test_the_language_of_equations(slider: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = model(slider)
    assert load_equations(file).language == "c"
    assert load_equations(file, math=np).language == "python"
    assert load_equations(file, language="python").language == "python"
    monkeypatch.setattr("urdf2mbs_simulate.robot.compiler", lambda: None)
    assert load_equations(file).language == "python"


@LANGUAGES
def test_steps_of_robotrans_have_its_errors(slider: Path, language: str) -> None:
    """Of a linear law, a step of order 4 is its series up to the fourth power."""
    data = MbsData(model(slider))
    data.q[1] = 0.2
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(
        integrator="RK4", dt0=0.02, tf=0.48, framerate=25.0, save2file=0, language=language
    )
    results = dirdyn.run()
    z = 0.02 * np.array([[0.0, 1.0], [-STIFFNESS / MASS, -DAMPING / MASS]])
    step = sum(np.linalg.matrix_power(z, k) / math.factorial(k) for k in range(5))
    rest = np.array([-MASS * 9.81 / STIFFNESS, 0.0])
    should = rest + np.linalg.matrix_power(step, 24) @ ([0.2, 0.0] - rest)
    assert results.time[12] == pytest.approx(0.48)
    assert results.q[12, 1] == pytest.approx(should[0], abs=1e-12)
    assert results.qd[12, 1] == pytest.approx(should[1], abs=1e-12)


@LANGUAGES
def test_a_force_knows_what_the_loop_has_kept_at_the_start(
    slider: Path, language: str, tmp_path: Path
) -> None:
    """As Robotran's first call is that of the start; else a joint would move in the first step."""
    project = shutil.copytree(slider, tmp_path / "slider")
    user = project / "userfctR"
    (user / "user_dirdyn.py").write_text(
        "def user_dirdyn_init(mbs_data, mbs_dirdyn):\n    mbs_data.place = 99.0\n"
        "def user_dirdyn_loop(mbs_data, mbs_dirdyn):\n    mbs_data.place = mbs_data.q[1]\n"
        "def user_dirdyn_finish(mbs_data, mbs_dirdyn):\n    pass\n"
    )
    (user / "user_JointForces.py").write_text(
        "def user_JointForces(mbs_data, tsim):\n"
        f"    mbs_data.Qq[1] = {MASS * 9.81} + mbs_data.place - mbs_data.q[1]\n"
    )
    assert np.ptp(simulate(project, time=0.01, language=language).q[:, 1]) < 1e-12


@LANGUAGES
def test_a_force_in_python_knows_the_time(slider: Path, language: str, tmp_path: Path) -> None:
    """As an argument and as ``mbs_data.tsim``, which also is the time of what it gives out."""
    project = shutil.copytree(slider, tmp_path / "slider")
    (project / "userfctR" / "user_JointForces.py").write_text(
        "def user_JointForces(mbs_data, tsim):\n"
        "    mbs_data.set_output(mbs_data.tsim - tsim, 'late')\n"
        "    mbs_data.Qq[1] = 10.0\n"
    )
    late = simulate(project, time=0.05, language=language).outputs["late"]
    assert len(late) == 6
    assert not late[:, 1].any()


def test_the_motion_of_each_body_is_that_of_its_equations(rich: Path) -> None:
    """``frame.c`` goes from joint to joint, the equations are written for each body."""
    data, rng = MbsData(model(rich)), np.random.default_rng(5)
    moves = np.flatnonzero([nature != "driven" for nature in data._run.natures]) + 1
    for row in (data.q, data.qd, data.qdd):
        row[moves] = rng.normal(size=len(moves))
    with user_code(data):
        code = CCode(data)
        frame = SensorInC.from_buffer(code.run_memory.data, ctypes.sizeof(RunInC))
        for joint in data.body_id.values():
            should = MbsSensor(data)
            should.comp_gen_sensor(joint)
            code.library.compute_frame(code.run_address, joint, as_c_vector(np.zeros(4)))
            for name in ("P", "V", "OM", "A", "OMP"):
                values = np.array(getattr(frame, name))
                assert np.allclose(values[1:], getattr(should, name)[1:], rtol=0, atol=1e-12)
            assert np.allclose(np.array(frame.R).reshape(4, 4), should.R, rtol=0, atol=1e-12)
            slopes = [[frame.J[i][j] for j in range(data.njoint + 1)] for i in range(1, 7)]
            assert np.allclose(slopes, should.J[1:], rtol=0, atol=1e-12)
