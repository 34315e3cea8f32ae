"""Simulations of generated projects: nothing runs but their equations and user functions."""

import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf2mbs
from support.folders import ROOT, SHARED
from support.oracle.pin import to_pinocchio
from support.standin import make, without_meshes
from urdf2mbs import ConversionError, Push, simulate
from urdf2mbs.cli import main
from urdf2mbs.config.load import parse
from urdf2mbs.mbs.kinematics import compute_placement
from urdf2mbs.testing import TINY
from urdf2mbs_project.places import compute_point_position
from urdf2mbs_simulate.dirdyn import load_code, solve_start_state
from urdf2mbs_simulate.push import parse_push
from urdf2mbs_simulate.python_code import has_user_changes, user_code
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn, Results

pin = pytest.importorskip("pinocchio")
GRIPPER = SHARED / "robots/robotiq_2f_140/expanded/robotiq_arg2f_140_model.urdf"
TINY_FILE = Path(urdf2mbs.__file__).with_name("tiny.urdf")
LAMP = ROOT / "configs" / "lamp.urdf"
needs_gcc = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
TIGHT: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-11}


def from_the_page(folder: Path, language: str = "python", **changed: Any) -> Path:
    """Make the project of the biped that docs/first-simulation.md makes."""
    page = (ROOT / "docs" / "first-simulation.md").read_text("utf-8")
    text = page.split("```yaml file=biped.yaml\n")[1].split("```")[0]
    passes = parse(text, folder / "biped.yaml")[0].passes
    return make(
        folder,
        ROOT / "configs/biped.urdf.xacro",
        "biped",
        pipeline="compact",
        passes={**passes, **changed},
        language=language,
    )


def still(data: MbsData) -> MbsData:
    """Switch all forces in joints off."""
    for kind in data.user_model["joint_forces"]:
        data.user_model["joint_forces"][kind] = 0.0
    return data


def run(data: MbsData, time: float, language: str, **more: Any) -> Results:
    dirdyn = MbsDirdyn(data)
    options = {"integrator": "DOP853", "rtoler": 1e-11, "atoler": 1e-11, **more}
    dirdyn.set_options(tf=time, language=language, save2file=0, **options)
    return dirdyn.run()


# --- held against Pinocchio ---


class Truth:
    """The model in Pinocchio, its joints in the order of the .mbs."""

    def __init__(self, data: MbsData) -> None:
        self.model = to_pinocchio(data._run.mbs)
        self.data = self.model.createData()
        self.order = [data.joint_id[name] for name in list(self.model.names)[1:]]

    def energies(self, results: Results) -> Any:
        """Return the total and the kinetic energy of each frame."""
        energies = []
        for row, rate in zip(results.q, results.qd, strict=True):
            q, qd = row[self.order], rate[self.order]
            kinetic = pin.computeKineticEnergy(self.model, self.data, q, qd)
            energies.append(
                [kinetic + pin.computePotentialEnergy(self.model, self.data, q), kinetic]
            )
        return np.array(energies).T

    def swing(self, q: Any, qd: Any, slope: Any, time: float) -> Any:
        """Return positions and speeds at the end of a motion without forces, by scipy.

        Joints move by q = q0 + slope x, for constant columns of slope.
        """
        from scipy.integrate import solve_ivp

        q, slope = q[self.order], slope[self.order]
        x0 = np.concatenate([np.zeros(slope.shape[1]), np.linalg.pinv(slope) @ qd[self.order]])

        def derivative(_: float, y: Any) -> Any:
            x, xd = np.split(y, 2)
            position, rate = q + slope @ x, slope @ xd
            mass = pin.crba(self.model, self.data, position)
            mass = np.triu(mass) + np.triu(mass, 1).T
            bias = pin.nonLinearEffects(self.model, self.data, position, rate)
            return np.concatenate([xd, np.linalg.solve(slope.T @ mass @ slope, -slope.T @ bias)])

        solution = solve_ivp(derivative, (0.0, time), x0, method="DOP853", rtol=1e-12, atol=1e-12)
        x, xd = np.split(solution.y[:, -1], 2)
        return np.concatenate([q + slope @ x, slope @ xd])


@needs_gcc
def test_a_floating_robot_falls_and_swings_as_pinocchio_says(tmp_path: Path) -> None:
    """The biped, thrown: the same motion after 1 s, and no energy is lost."""
    project = from_the_page(tmp_path, posture={}, forces={}, contacts={})
    data = still(MbsData(project / "dataR" / "biped.mbs"))
    rng = np.random.default_rng(11)
    data.q[data.qu[1:]] += rng.uniform(-0.5, 0.5, data.nqu)
    data.qd[data.qu[1:]] = rng.uniform(-2.0, 2.0, data.nqu)
    q, qd = data.q.copy(), data.qd.copy()
    results = run(data, 1.0, "c")
    assert results.language == "C, user functions in Python"
    truth = Truth(data)
    free = np.eye(data.njoint + 1)[:, data.qu[1:]]
    wanted = truth.swing(q, qd, free, 1.0)
    end = np.concatenate([results.q[-1][truth.order], results.qd[-1][truth.order]])
    assert np.abs(wanted - np.concatenate([q[truth.order], qd[truth.order]])).max() > 3
    assert np.allclose(end, wanted, rtol=0, atol=1e-6)
    energy, kinetic = truth.energies(results)
    assert kinetic.max() > 2 * kinetic[0], "it falls"
    assert np.abs(energy - energy[0]).max() <= 1e-9 * kinetic.max()


@pytest.mark.skipif(not GRIPPER.is_file(), reason="the real robots are not beside the checkout")
@pytest.mark.parametrize("language", ["python", pytest.param("c", marks=needs_gcc)])
def test_a_gripper_falls_as_its_reduction(tmp_path: Path, language: str) -> None:
    """Five joints follow one, so that there is one degree of freedom."""
    project = make(tmp_path, GRIPPER, base="fixed", pipeline=without_meshes("compact"))
    data = still(MbsData(project / "dataR" / "robot.mbs"))
    q, qd = data.q.copy(), data.qd.copy()
    results = run(data, 0.2, language)
    moved = results.q[-1] - results.q[0]
    slope = moved[:, None] / moved[data.joint_id["finger_joint"]]
    slope[0] = 0.0
    rules = sorted(float(abs(x)) for x in slope[1:, 0] if x)
    assert rules == pytest.approx([1.0] * 6, abs=1e-9)
    truth = Truth(data)
    wanted = truth.swing(q, qd, slope, 0.2)
    end = np.concatenate([results.q[-1][truth.order], results.qd[-1][truth.order]])
    assert np.abs(wanted).max() > 0.05
    assert np.allclose(end, wanted, rtol=0, atol=1e-8)


@pytest.mark.parametrize("language", ["python", pytest.param("c", marks=needs_gcc)])
def test_a_loop_stays_closed_and_keeps_its_energy(tmp_path: Path, language: str) -> None:
    """The lamp has a parallelogram: its cut stays closed, and it does no work.

    The accelerations are those of Pinocchio's solver for constraints.
    """
    project = make(tmp_path, LAMP)
    data = still(MbsData(project / "dataR" / "robot.mbs"))
    results = run(data, 0.5, language)
    assert data.nqv
    cut = data._run.mbs.cuts[0]
    for q in results.q:
        placed = compute_placement(
            data._run.mbs, {name: q[number] for name, number in data.joint_id.items()}
        )
        ends = [
            compute_point_position(placed, data._run.mbs, *end)
            for end in (cut.endpoint1, cut.endpoint2)
        ]
        assert np.allclose(*ends, rtol=0, atol=1e-8)
    assert np.abs(results.q[-1] - results.q[0])[1:].max() > 0.1
    truth = Truth(data)
    energy, kinetic = truth.energies(results)
    assert np.abs(energy - energy[0]).max() <= 1e-8 * kinetic.max()
    ours = results.energy()
    assert np.allclose(ours[:, 0], kinetic, rtol=1e-9, atol=1e-12)
    assert np.allclose(ours.sum(axis=1), energy, rtol=1e-9, atol=1e-12)
    model, computed, ends_in_joints = truth.model, truth.data, []
    for body, point in (cut.endpoint1, cut.endpoint2):
        frame = model.frames[model.getFrameId(f"{body}/{point}")]
        ends_in_joints += [frame.parentJoint, frame.placement]
    cuts, solved = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    cuts.append(
        pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, *ends_in_joints, pin.LOCAL)
    )
    solved.append(cuts[0].createData())
    pin.initConstraintDynamics(model, computed, cuts, solved)
    exactly = pin.ProximalSettings(1e-12, 1e-12, 100)
    for q, qd, qdd in zip(results.q, results.qd, results.qdd, strict=True):
        wanted = pin.constraintDynamics(
            model,
            computed,
            q[truth.order],
            qd[truth.order],
            np.zeros(model.nv),
            cuts,
            solved,
            exactly,
        )
        assert np.allclose(qdd[truth.order], wanted, rtol=0, atol=1e-8 * np.abs(wanted).max())


@pytest.mark.parametrize("language", ["python", pytest.param("c", marks=needs_gcc)])
def test_a_loop_that_cannot_be_closed_leaves_no_trace(tmp_path: Path, language: str) -> None:
    """A trial state of the integrator may be far away: the next one does not start from it."""
    data = MbsData(make(tmp_path, LAMP) / "dataR" / "robot.mbs")
    with user_code(data):
        code = load_code(data, language)
        assert solve_start_state(data, code)
        y = code.get_state()
        rates = code.accelerate(0.0, y)
        assert np.isfinite(rates).all()
        for away in (1.0, 2.0, 3.0, 1e9):
            code.accelerate(0.0, y + away)
            assert np.array_equal(code.accelerate(0.0, y), rates)


# --- C and Python ---


@needs_gcc
@pytest.mark.slow
def test_the_biped_stands_and_is_pushed_the_same_way_in_every_language(tmp_path: Path) -> None:
    """With contacts, a wrench, a push, and user functions in C, in Python, and called from C."""
    project = from_the_page(
        tmp_path,
        "both",
        forces={
            "wrenches": {"push": {"link": "chest", "force": [20, 0, 0], "start": 0.05, "stop": 0.1}}
        },
    )
    more: dict[str, Any] = {"time": 0.15, "push": ["head:0,9,0@0.03..0.08"]}
    more |= {"method": "DOP853", "rtol": 1e-9, "atol": 1e-11}
    plain = simulate(project, language="python", **more)
    in_c = simulate(project, language="c", **more)
    by_itself = simulate(project, time=0.001)
    file = project / "userfctR" / "user_JointForces.py"
    file.write_text(file.read_text() + "changed = True\n")
    mixed = simulate(project, **more)
    languages = [results.language for results in (plain, in_c, by_itself, mixed)]
    mixed_name = "C, user functions in Python"
    assert languages == [mixed_name, "C", "C", mixed_name]
    for results in (in_c, mixed):
        for name in ("q", "qd", "Qq"):
            wanted, values = getattr(plain, name), getattr(results, name)
            assert np.allclose(values, wanted, rtol=0, atol=1e-7 * np.abs(wanted).max()), name
    # it stands on its feet, is pushed, and leans
    total = sum(body.mass or 0.0 for body in plain.data._run.mbs.bodies) * 9.81
    weight = sum(rows[:, 2] for name, rows in plain.external.items() if "contact" in name)
    assert weight[4:10].mean() == pytest.approx(total, rel=0.2)
    pushed = plain.external["push"][:, 0]
    assert [round(t, 2) for t, force in zip(plain.time, pushed, strict=True) if force] == [
        0.05,
        0.06,
        0.07,
        0.08,
        0.09,
    ]
    lean = plain.joint("floating_base_R1")
    assert abs(lean[-1]) > 10 * abs(lean[3])


@pytest.mark.slow
@needs_gcc
def test_a_robot_without_a_config_stands(tmp_path: Path, capsys: Any) -> None:
    folder = tmp_path / "stands"
    source = str(ROOT / "configs/biped.urdf.xacro")
    assert main(["simulate", source, "-o", str(folder), "--time", "0.3"]) == 0
    assert "the robot stands on left_foot, right_foot" in capsys.readouterr().out
    q = np.loadtxt(folder / "resultsR" / "dirdyn_q.res")
    height = MbsData(folder / "dataR" / "stands.mbs").joint_id["floating_base_T3"]
    assert np.ptp(q[:, height]) < 0.005
    falls = [source, "-o", str(tmp_path / "falls"), "--set", "posture.hold={}", "--time", "0.3"]
    assert main(["simulate", *falls]) == 0
    assert "stands" not in capsys.readouterr().out
    q = np.loadtxt(tmp_path / "falls" / "resultsR" / "dirdyn_q.res")
    assert np.ptp(q[:, height]) > 0.4


def test_what_is_compiled_is_kept_and_never_half(tmp_path: Path) -> None:
    from urdf2mbs_simulate.equations import get_cache_folder, write_to_cache

    assert str(get_cache_folder()).endswith("urdf2mbs")
    file = tmp_path / "folder" / "file"
    write_to_cache(file, b"one")
    write_to_cache(file, b"two")
    assert file.read_bytes() == b"two"
    assert [path.name for path in file.parent.iterdir()] == ["file"]


# --- forces ---


@pytest.mark.parametrize("language", ["python", pytest.param("c", marks=needs_gcc)])
def test_a_push_moves_the_centre_of_mass(language: str) -> None:
    """F t = m v, while nothing else acts."""
    results = simulate(
        TINY_FILE,
        time=0.4,
        push=[Push("arm", (3.0, -2.0, 5.0), 0.1, 0.3)],
        language=language,
        base="floating",
        gravity=(0.0, 0.0, 0.0),
        **TIGHT,
    )
    truth = Truth(results.data)
    q, qd = results.q[-1][truth.order], results.qd[-1][truth.order]
    pin.centerOfMass(truth.model, truth.data, q, qd)
    mass = sum(body.mass or 0.0 for body in results.data._run.mbs.bodies)
    assert mass * truth.data.vcom[0] == pytest.approx(0.2 * np.array([3, -2, 5]), abs=1e-9)
    still_there = simulate(
        TINY_FILE, time=0.4, language=language, base="floating", gravity=(0.0, 0.0, 0.0)
    )
    assert not still_there.qd[:, 1:].any(), "the push was of the other run"


def test_a_short_push_is_not_stepped_over() -> None:
    """A robot at rest lets the integrator take steps that are longer than the push."""
    results = simulate(
        TINY_FILE,
        time=3.0,
        push=["arm:0,0,500@2.5..2.501"],
        language="python",
        base="floating",
        gravity=(0.0, 0.0, 0.0),
    )
    truth = Truth(results.data)
    pin.centerOfMass(
        truth.model, truth.data, results.q[-1][truth.order], results.qd[-1][truth.order]
    )
    mass = sum(body.mass or 0.0 for body in results.data._run.mbs.bodies)
    assert mass * truth.data.vcom[0][2] == pytest.approx(0.5, rel=1e-3)


def test_a_push_that_cannot_be_read_or_placed() -> None:
    assert parse_push("arm:1,2,3@0.5..") == Push("arm", (1.0, 2.0, 3.0), 0.5)
    assert parse_push("arm:1,-2e1,.3@...5") == Push("arm", (1.0, -20.0, 0.3), 0.0, 0.5)
    for text in (
        "arm",
        "arm:1,2",
        "arm:1,2,x@0..1",
        "arm:1,2,3@0.5",
        "arm:1,2,nan@0..1",
        "arm:1,2,3@0.5..0.5",
    ):
        with pytest.raises(ConversionError, match=r"write LINK:FX,FY,FZ@START\.\.STOP"):
            simulate(TINY_FILE, push=[text])
    with pytest.raises(ConversionError, match="no body and no point 'amr'") as caught:
        simulate(TINY_FILE, push=["amr:1,2,3@0..1"])
    assert caught.value.hint == "did you mean 'arm'?"


def test_a_push_finds_a_link_whose_body_has_another_name(tmp_path: Path) -> None:
    """The .mbs reserves ``base``."""
    box = (
        '<robot name="box"><link name="base"><inertial><mass value="2"/><inertia ixx="1" iyy="1" '
        'izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    project = make(tmp_path, box, base="floating")
    results = simulate(project, time=0.1, language="python", push=["base:4,0,0@0..1"])
    assert results.columns()["push1.base_body.Fx"][0] == 4.0
    assert results.joint("floating_base_T1")[-1] == pytest.approx(0.01, rel=1e-6)


# --- results ---


def test_results_are_robotrans_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    project = make(tmp_path, TINY, passes={"sensors": {"links": ["tool"]}})
    push = ["arm:0,0,2@0.03..0.07"]
    results = simulate(project, time=0.1, language="python", rate=50.0, push=push)
    results.write()
    folder = project / "resultsR"
    assert np.allclose(results.time, [0, 0.02, 0.04, 0.06, 0.08, 0.1], rtol=0, atol=1e-15)
    anim = (project / "animationR" / "dirdyn_q.anim").read_bytes()
    assert anim == (folder / "dirdyn_q.res").read_bytes()
    head, *lines = (folder / "dirdyn.csv").read_text().splitlines()
    rows = [[float(cell) for cell in line.split(",")] for line in lines]
    assert head == ",".join(results.columns())
    assert np.array_equal(rows, np.transpose([*results.columns().values()]))
    assert np.array_equal(results.columns()["energy.kinetic"], results.energy()[:, 0])
    assert np.array_equal(results.columns()["energy.potential"], results.energy()[:, 1])
    results.data.qd[:] = 7.0
    truth, sensor = Truth(results.data), results.sensor("tool_sensor")
    frame = truth.model.getFrameId("hand/tool")
    for k, (q, qd) in enumerate(zip(results.q, results.qd, strict=True)):
        pin.forwardKinematics(truth.model, truth.data, q[truth.order], qd[truth.order])
        place = pin.updateFramePlacement(truth.model, truth.data, frame)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        speed = pin.getFrameVelocity(truth.model, truth.data, frame, axes)
        pairs = (
            (sensor.P[k], place.translation),
            (sensor.V[k], speed.linear),
            (sensor.R[k], place.rotation.T),
            (sensor.OM[k], speed.angular),
        )
        for rows, should in pairs:
            assert np.allclose(rows, should, rtol=0, atol=1e-12)
    assert np.abs(sensor.V[-1]).max() > 0.0
    assert (results.data.qd == 7.0).all()  # as before
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "pandas", None)
        with pytest.raises(ConversionError, match="needs the package"):
            results.table()
    pd = pytest.importorskip("pandas", reason="the table of results is one of pandas")
    table = pd.read_csv(folder / "dirdyn.csv")
    pd.testing.assert_frame_equal(results.table(), table, rtol=1e-14, atol=0)


def test_driven_joints_feel_what_drives_them(tmp_path: Path) -> None:
    """Qc of driven joints: M qdd + c - Qq."""
    project = make(tmp_path, TINY, base="fixed", pipeline="faithful")
    file = project / "userfctR" / "user_JointForces.py"
    file.write_text(file.read_text() + "    mbs_data.Qq[1:] += 0.5\n")
    results = simulate(project, time=0.05, language="python")
    data = results.data
    driven = data.qc[1:]
    assert len(driven)
    for body in data._run.mbs.bodies:
        for joint in body.joints:
            joint.nature = "independent"  # Pinocchio has no driven joints
    truth = Truth(data)
    for q, qd, qdd, held, force in zip(
        results.q, results.qd, results.qdd, results.Qc, results.Qq, strict=True
    ):
        tau = np.zeros(data.njoint + 1)
        tau[truth.order] = pin.rnea(
            truth.model, truth.data, *(x[truth.order] for x in (q, qd, qdd))
        )
        assert np.allclose(held[driven], (tau - force)[driven], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("language", "comment"), [("python", "# a word\n"), ("c", "/* a word */\n")]
)
def test_comments_of_another_version_are_no_code_of_the_user(
    language: str, comment: str, tmp_path: Path
) -> None:
    project = make(tmp_path, TINY, language=language)
    data = MbsData(next((project / "dataR").glob("*.mbs")))
    suffix = {"python": "py", "c": "c"}[language]
    file = project / "userfctR" / f"user_dirdyn.{suffix}"
    file.write_text(comment + file.read_text())
    assert not has_user_changes(data, language, file.name)
    file.write_text(file.read_text() + "int more;\n")
    assert has_user_changes(data, language, file.name)
