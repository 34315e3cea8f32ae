"""Our steps in C: of order 5 or 3, and as exact as is asked for, beside scipy's."""

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.folders import CONFIGS
from support.motions import DAMPING, MASS, SLIDER, STIFFNESS, falls
from support.rich_robot import PASSES, convert
from support.standin import make
from urdf2mbs import ConversionError, simulate
from urdf2mbs.engine.output import write
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.c_sources import SOURCES
from urdf2mbs_simulate.compiler import HERE, compiler
from urdf2mbs_simulate.equations import HEADERS
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn
from urdf2mbs_simulate.steps import Rosenbrock

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
LAMP = CONFIGS / "lamp.urdf"
#: So far off may a run of the tolerance 1e-6 be: steps add up, and friction and stops have kinks.
ADDED = 100


def in_steps(project: Path, time: float, count: int, rate: float = 20.0) -> Any:
    """Run a number of steps of one length, whatever their error."""
    dirdyn = MbsDirdyn(MbsData(project / "dataR" / "robot.mbs"))
    step = time / count
    dirdyn.set_options(tf=time, dt0=step, dt_max=step, framerate=rate, language="c", save2file=0)
    dirdyn.set_options(rtoler=1e9, atoler=1e9)
    return dirdyn.run()


def test_the_error_of_an_explicit_step_is_of_order_5(tmp_path: Path) -> None:
    project = make(tmp_path, SLIDER, base="fixed", language="both")
    errors = []
    for steps in (10, 20, 40):
        results = in_steps(project, 0.5, steps)
        errors.append(abs(results.q[-1, 1] - falls(0.5)[0]))
    assert 1e-11 < errors[2] < 1e-7
    assert 20 < errors[0] / errors[1] < 48
    assert 20 < errors[1] / errors[2] < 48


def test_steps_are_implicit_where_a_joint_is_stiff(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Explicit steps of 0.7 ms at most would be stable, and it takes 1500 of them."""
    damping, taken = 10000.0, [0]
    text = SLIDER.replace(f'damping="{DAMPING}"', f'damping="{damping}"')
    step = Rosenbrock.step

    def count(solver: Rosenbrock) -> None:
        step(solver)
        taken[0] += solver.steps_taken

    monkeypatch.setattr(Rosenbrock, "step", count)
    project = make(tmp_path, text, base="fixed", language="both")
    results = simulate(project, time=1.0, language="c", rate=10)
    slow = STIFFNESS / damping
    rest = MASS * 9.81 / STIFFNESS
    assert results.q[-1, 1] == pytest.approx(rest * np.expm1(-slow), abs=1e-5)
    assert taken[0] < 150


def random_robot(seed: int, follows: bool) -> str:
    """Return a tree of four links, with damping; the last joint may follow the first one."""
    rng = np.random.default_rng(seed)

    def three(size: float) -> str:
        return " ".join(map(repr, rng.uniform(-size, size, 3).tolist()))

    def link(name: str) -> str:
        a, b, c = rng.uniform(0.02, 0.05, 3).tolist()
        mass, centre = rng.uniform(1.0, 3.0), three(0.1)
        return (
            f'<link name="{name}"><inertial><origin xyz="{centre}" rpy="{three(3.0)}"/>'
            f'<mass value="{mass}"/><inertia ixx="{b + c}" iyy="{a + c}" izz="{a + b}" ixy="0" '
            f'ixz="0" iyz="0"/></inertial><collision><origin xyz="{centre}"/><geometry>'
            '<box size="0.2 0.2 0.2"/></geometry></collision></link>'
        )

    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="l{rng.integers(i)}"/>'
        f'<child link="l{i}"/><origin xyz="{three(0.3)}" rpy="{three(3.0)}"/>'
        f'<axis xyz="{three(1.0)}"/><dynamics damping="0.05"/>'
        + '<mimic joint="j1" multiplier="-0.7" offset="0.2"/>' * (follows and i == 3)
        + "</joint>"
        for i in (1, 2, 3)
    )
    links = "".join(map(link, ("l0", "l1", "l2", "l3")))
    return f'<robot name="random{seed}">{links}{joints}</robot>'


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed"),
    [(kind, seed) for kind in ("bolted", "free", "follows", "ground") for seed in (1, 2)]
    + [("loop", 0)],
)
def test_random_robots_move_as_with_scipy(kind: str, seed: int, tmp_path: Path) -> None:
    """The motion is that of DOP853, and on the ground that of Radau, with errors of 1e-10 a step.

    On the ground a robot tips over, and each spot that lands is a kink.
    """
    base: dict[str, Any] = {"base": "fixed" if kind in ("bolted", "follows") else "floating"}
    if kind == "ground":
        base["passes"] = {"contacts": {"links": ["*"]}}
    source = LAMP if kind == "loop" else random_robot(seed, kind == "follows")
    project = make(tmp_path, source, language="both", **base)
    more: dict[str, Any] = {"time": 0.3, "language": "c", "rate": 20}
    if kind == "free":
        more["push"] = ["l3:30,40,50@0..0.1"]
    method = "Radau" if kind == "ground" else "DOP853"
    exact = simulate(project, method=method, rtol=1e-10, atol=1e-10, **more)
    assert np.abs(exact.q[-1, 1:] - exact.q[0, 1:]).max() > 0.01
    for tolerance, kinks in ((1e-5, 1e-3), (1e-8, 1e-4)):
        results = simulate(project, rtol=tolerance, atol=tolerance, **more)
        off = np.abs(results.q - exact.q).max()
        assert off < (kinks if kind == "ground" else ADDED * tolerance)


def arm(damping: float = 0.0) -> str:
    """Three links, and no two of their axes are parallel."""
    links = "".join(
        f'<link name="l{i}"><inertial><origin xyz="0.2 0.02 0.1"/><mass value="{3 - i}"/><inertia '
        'ixx="0.02" iyy="0.03" izz="0.025" ixy="0.001" ixz="0" iyz="0"/></inertial><collision>'
        '<geometry><sphere radius="0.1"/></geometry></collision></link>'
        f'<joint name="j{i}" type="continuous"><parent link="{f"l{i - 1}" if i else "base"}"/>'
        f'<child link="l{i}"/><origin xyz="0.4 0 0.1"/><axis xyz="{axis}"/>'
        f'<dynamics damping="{damping}"/></joint>'
        for i, axis in enumerate(("0 1 0", "0.6 0.8 0", "0 0.6 0.8"))
    )
    return f'<robot name="arm"><link name="base"/>{links}</robot>'


def test_an_arm_that_swings_is_exact_by_default(tmp_path: Path) -> None:
    project = make(tmp_path, arm(), base="fixed", language="both")
    exact = simulate(project, time=1.0, language="c", method="DOP853", rtol=1e-10, atol=1e-10)
    results = simulate(project, time=1.0, language="c")
    assert (np.ptp(exact.q[:, 1:], axis=0) > 0.5).sum() == 3
    assert np.abs(results.q - exact.q).max() < 1e-4


def test_the_error_of_an_implicit_step_is_of_order_3_with_old_slopes(tmp_path: Path) -> None:
    """Steps are implicit where an external force acts, and slopes serve for four of them."""
    wrench = {"link": "l2", "force": [0, 0, 1], "start": -1, "stop": 9}
    passes = {"forces": {"wrenches": {"push": wrench}}}
    project = make(tmp_path, arm(0.5), base="fixed", language="both", passes=passes)
    tight: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-11}
    exact = simulate(project, time=0.5, language="c", **tight).q[-1]
    errors = []
    for steps in (40, 80, 160):
        results = in_steps(project, 0.5, steps)
        errors.append(np.abs(results.q[-1] - exact).max())
    assert 1e-8 < errors[2] < 1e-5
    assert 6 < errors[0] / errors[1] < 11
    assert 6 < errors[1] / errors[2] < 11


def beside(project: Path, time: float, other: str, **more: Any) -> float:
    """Return the largest difference (rad, m) of two runs of a robot that moves."""
    wanted = simulate(project, time=time, language="c", method=other, rtol=1e-9, atol=1e-11, **more)
    results = simulate(project, time=time, language="c", rtol=1e-6, atol=1e-7, **more)
    assert np.ptp(wanted.q[:, 1:], axis=0).max() > 0.001
    return float(np.abs(results.q - wanted.q).max())


@pytest.mark.slow
def test_loops_drives_contacts_and_friction_move_as_with_scipy(tmp_path: Path) -> None:
    """A rod, dependent and driven joints, stops, friction, springs, wrenches and the ground."""
    both = {"project": str(tmp_path / "rich"), "language": "both"}
    write(convert(tmp_path, PASSES, output=both))
    assert beside(tmp_path / "rich", 0.1, "DOP853") < ADDED * 1e-6


@pytest.mark.slow
def test_a_robot_that_stands_and_is_pushed_moves_as_with_scipy(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[3]
    project = make(
        tmp_path,
        root / "configs/biped.urdf.xacro",
        "biped",
        pipeline="compact",
        language="both",
        passes={
            "contacts": {"links": ["*_foot"]},
            "posture": {"hold": {"frequency": 10, "damping_ratio": 0.3}},
        },
    )
    assert beside(project, 0.5, "Radau", push=("chest:40,10,0@0.1..0.3",)) < ADDED * 1e-6


@pytest.mark.parametrize(
    ("command", "flags"),
    [
        ("cc", ["-fsyntax-only", "-Wall", "-Wextra", "-Werror"]),
        pytest.param("clang-tidy", [], marks=pytest.mark.slow),
    ],
)
def test_checkers_of_c_are_silent(command: str, flags: list[str], tmp_path: Path) -> None:
    program = shutil.which(command) or shutil.which(command, path=Path(sys.executable).parent)
    if program is None:
        pytest.skip(f"there is no {command}")
    data = MbsData(make(tmp_path, arm(), base="fixed", language="c") / "dataR" / "robot.mbs")
    sources = CCode(data).sources
    runtime = [str(source.file) for source in sources if source.file.parent == HERE]
    runtime.append(str(HERE / "live.c"))
    defines = [*{word: word for source in sources for word in source.defines}]
    folders = [f"-I{folder}" for folder in (HERE, HEADERS, data.user_path)]
    words = ["-std=gnu99", "-Wno-comment", *flags, *folders, *defines]
    checks = "--checks=clang-diagnostic-*,clang-analyzer-*,-clang-analyzer-security.ArrayBound"
    first = ["--quiet", checks, "--warnings-as-errors=*", *runtime, "--", *words]
    subprocess.run(
        [program, *(first if command == "clang-tidy" else [*words, *runtime])], check=True
    )
    assert len(runtime) == len(SOURCES) + 1


#: A run whose C ends where a whole number is too large.
TRAPS = """
import sys
from urdf2mbs import simulate
from urdf2mbs_simulate import compiler
compiler.FLAGS += ("-ftrapv",)
simulate(sys.argv[1], time=1.0, language="c")
"""


def test_steps_may_be_refused_any_number_of_times(tmp_path: Path) -> None:
    """The force jumps 100 times a second, and an explicit step does not pass over a jump."""
    project = make(tmp_path, SLIDER, base="fixed", language="c")
    file = project / "userfctR" / "user_JointForces.c"
    jumps = "mbs_data->Qq[1] += (int) (100.0 * tsim) % 2 ? 50.0 : -50.0;\nreturn mbs_data->Qq;"
    file.write_text(file.read_text().replace("return mbs_data->Qq;", jumps))
    subprocess.run([sys.executable, "-c", TRAPS, str(project)], check=True)


def test_a_run_that_cannot_go_on_is_an_error(tmp_path: Path) -> None:
    project = make(tmp_path, SLIDER, base="fixed", language="both")
    file = project / "userfctR" / "user_JointForces.c"
    file.write_text(
        file.read_text().replace(
            "return mbs_data->Qq;", "mbs_data->Qq[1] = 0.0 / 0.0;\nreturn mbs_data->Qq;"
        )
    )
    with pytest.raises(ConversionError, match="'rail' is not a number at 0 s"):
        simulate(project, time=0.5, language="c")


def test_a_step_does_not_pass_over_the_begin_of_a_contact(tmp_path: Path) -> None:
    """Free fall allows steps of any length, and one that ended in the ground would make energy."""
    turning = 'ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"'
    ball = (
        f'<robot name="r"><link name="ball"><inertial><mass value="2"/><inertia {turning}/>'
        '</inertial><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
        "</robot>"
    )
    passes = {"contacts": {"links": ["ball"], "depth": 0.001, "damping_ratio": 1.0}}
    project = make(tmp_path, ball, base="floating", language="c", passes=passes)
    for height in np.linspace(0.5, 1.5, 15):
        data = MbsData(project / "dataR" / "robot.mbs")
        data.q[3] = height
        dirdyn = MbsDirdyn(data)
        dirdyn.set_options(tf=1.0, framerate=20, language="c", save2file=0)
        results = dirdyn.run()
        depth = np.maximum(0.1 - results.q[:, 3], 0.0)
        assert 0.0 < depth.max() < 0.02
        springs = data.user_model["contact"]["stiffness"] * depth**2 / 2
        assert np.diff(results.energy().sum(axis=1) + springs).max() < 1e-6


@pytest.mark.slow
def test_the_extra_live_is_the_compiler_where_there_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without cc, zig compiles for a processor that all machines are: they may share the cache.

    A stand-in for ziglang passes its arguments to cc if they name its compiler and this processor.
    """
    zig = tmp_path / "ziglang" / "zig"
    zig.parent.mkdir()
    zig.with_name("__init__.py").touch()
    cc = shutil.which("cc")
    zig.write_text(
        f"#!{sys.executable}\nimport os, sys\nwords = sys.argv[1:]\nassert words.pop(0) == 'cc'\n"
        f"words.remove('-mcpu=baseline')\nos.execv('{cc}', ['cc', *words])\n"
    )
    zig.chmod(0o755)
    project = make(tmp_path, SLIDER, base="fixed", language="both")
    find = shutil.which
    monkeypatch.setattr(shutil, "which", lambda name, path=None: path and find(name, path=path))
    monkeypatch.delitem(sys.modules, "ziglang", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    compiler.cache_clear()
    try:
        assert compiler() == str(zig)
        results = simulate(project, time=0.5)
        assert results.language == "C"
        assert results.q[-1, 1] == pytest.approx(falls(0.5)[0], abs=1e-5)
    finally:
        compiler.cache_clear()
