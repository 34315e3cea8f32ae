"""Equilibria and modes are those of closed forms.

A run that starts in an equilibrium stays, and a small oscillation has the frequency and the damping
of its mode.
"""

import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.loops import FREE, arm, four_bar, made
from support.motions import DAMPING, MASS, SLIDER, STIFFNESS, model
from support.standin import make
from urdf2mbs import ConversionError, modes, simulate
from urdf2mbs.cli import main
from urdf2mbs.commands.printing import near
from urdf2mbs.mbs.model import BASE, Parameter, Sensor, UserModel
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import TINY
from urdf2mbs_simulate.compiler import compiler
from urdf2mbs_simulate.dirdyn import load_closed_code
from urdf2mbs_simulate.modal import find_modes
from urdf2mbs_simulate.project import find_equilibrium
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn, MbsEquil, MbsModal, MbsPart

G = 9.81
#: Of ``arm``: mass, centre (x, z) and inertia about y.
ONE, X, Z, IYY = 1.0, 0.1, -0.05, 0.03
EXACT = 1e-9
LAMP = Path(__file__).resolve().parents[3] / "configs" / "lamp.urdf"


def find_pose(file: Path, **options: Any) -> tuple[MbsData, MbsEquil]:
    data = MbsData(file)
    equil = MbsEquil(data)
    equil.set_options(language="python", **options)
    equil.run()
    return data, equil


def modes_of(data: MbsData) -> Any:
    modal = MbsModal(data)
    modal.set_options(language="python")
    return modal.run()


@settings(max_examples=10, deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(0.2, 3.0))
def test_a_pendulum_hangs_and_swings(
    tmp_path_factory: pytest.TempPathFactory, start: float, mass: float
) -> None:
    """From any pose the centre comes to hang below the hinge."""
    file = made(tmp_path_factory.mktemp("p"), arm("bob", BASE, ("R2", start, FREE), mass=mass))
    data, equil = find_pose(file, save2file=0)
    assert equil.found is not None
    distance = math.hypot(X, Z)
    assert math.sin(data.q[1]) * X - math.cos(data.q[1]) * Z == pytest.approx(distance, abs=EXACT)
    (mode,) = modes_of(data).modes
    speed = math.sqrt(
        ONE * G * distance / (IYY + ONE * distance**2)
    )  # inertia scales with the mass
    assert mode.value == pytest.approx(1j * speed, abs=EXACT)
    assert (mode.frequency, mode.joints()) == (pytest.approx(speed / 2 / math.pi), [1])


def test_a_start_upright_stays_upright_and_is_unstable(tmp_path: Path) -> None:
    upright = math.atan2(X, -Z) + math.pi
    file = made(tmp_path, arm("bob", BASE, ("R2", upright, FREE)))
    data, _ = find_pose(file)
    assert data.q[1] == pytest.approx(upright, abs=EXACT)
    found_modes = modes_of(data)
    distance = math.hypot(X, Z)
    speed = math.sqrt(G * distance / (IYY + distance**2))
    values = sorted(mode.value.real for mode in found_modes.modes)
    assert values == pytest.approx([-speed, speed], abs=EXACT)
    assert not found_modes.stable
    assert found_modes.lines()[-1].startswith("unstable: mode ")


def test_two_pendulums_swing_in_two_ways(tmp_path: Path) -> None:
    """M q'' = -K q of two rods, each with its centre on its axis."""
    length, com, inertia = 0.5, 0.3, 0.02
    bodies = []
    for name, parent in (("one", BASE), ("two", "one")):
        point = None if parent == BASE else "end"
        body = arm(name, parent, ("R2", 0.4, FREE), at=point, end=(0.0, 0.0, -length))
        body.com, body.inertia = (0.0, 0.0, -com), (0.0, 0.0, 0.0, inertia, 0.0, 0.0)
        bodies.append(body)
    data, _ = find_pose(made(tmp_path, *bodies))
    assert np.abs(data.q[1:]).max() < EXACT
    pivot_inertia = inertia + com**2
    mass = np.array(
        [
            [2 * pivot_inertia + length**2 + 2 * length * com, pivot_inertia + length * com],
            [pivot_inertia + length * com, pivot_inertia],
        ]
    )
    stiff = G * np.array([[length + 2 * com, com], [com, com]])
    speeds = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiff))))
    found_modes = modes_of(data)
    assert [m.value.imag for m in found_modes.modes] == pytest.approx(speeds.tolist(), abs=EXACT)
    assert [m.value.real for m in found_modes.modes] == pytest.approx([0.0, 0.0], abs=EXACT)
    for mode in found_modes.modes:
        shape = mode.shape[1:].real
        assert np.abs(stiff @ shape - mode.value.imag**2 * mass @ shape).max() < 1e-7


def test_a_mass_on_a_spring_sinks_and_swings(tmp_path: Path) -> None:
    project = make(tmp_path, SLIDER, base="fixed", language="python")
    data, _ = find_pose(model(project))
    assert data.q[1] == pytest.approx(-MASS * G / STIFFNESS, abs=EXACT)
    (mode,) = modes_of(data).modes
    decay = DAMPING / (2 * MASS)
    assert mode.value == pytest.approx(
        -decay + 1j * math.sqrt(STIFFNESS / MASS - decay**2), abs=EXACT
    )
    assert mode.damping == pytest.approx(decay / math.sqrt(STIFFNESS / MASS), abs=EXACT)
    results = simulate(project, time=1.0, language="python", equilibrium=True)
    assert np.ptp(results.q[:, 1]) < 1e-8
    assert results.equilibrium.q[1] == data.q[1]
    # a swing of 1e-5 m has this frequency and damping
    data.q[1] += 1e-5
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(
        tf=2.0,
        integrator="DOP853",
        rtoler=1e-11,
        atoler=1e-16,
        save2file=0,
        language="python",
        framerate=500,
    )
    swing = dirdyn.run().q
    fit = np.exp(mode.value * swing[:, 0])
    terms = np.column_stack([fit.real, fit.imag])
    left = swing[:, 1] + MASS * G / STIFFNESS
    assert np.abs(left - terms @ np.linalg.lstsq(terms, left, rcond=None)[0]).max() < 1e-10


def test_a_double_mode_does_not_swing(tmp_path: Path) -> None:
    """Rounding splits the value of critical damping into two with an imaginary part."""
    project = make(tmp_path, SLIDER, base="fixed", language="python")
    data, _ = find_pose(model(project))
    code = load_closed_code(data, "python")
    modes = find_modes(code, np.array([[-5.0, 1e-5], [-1.5e-8, -5.0]])).modes
    assert [mode.value.imag for mode in modes] == [0.0, 0.0]


def test_a_mode_without_damping_has_a_frequency_and_no_time(tmp_path: Path) -> None:
    project = make(tmp_path, SLIDER, base="fixed", language="python")
    code = load_closed_code(find_pose(model(project))[0], "python")
    modes = find_modes(code, np.array([[0.0, 1.0], [-((2.0 * np.pi) ** 2), 0.0]]))
    assert modes.modes[0].value.real == 0.0
    assert modes.lines()[1].split()[1:3] == ["1", "0"]


def test_a_parameter_is_found_for_a_joint_that_stays(tmp_path: Path) -> None:
    """The force of a motor that holds a pendulum level; and no pose is found without it."""
    file = made(tmp_path, arm("bob", BASE, ("R2", 0.0, FREE)))
    mbs = read_mbs(file.read_bytes(), str(file))
    mbs.user_models = [UserModel.of("motor", {"torque": 0.0})]
    file.write_bytes(write(mbs))
    user = file.parent.parent / "userfctR"
    user.mkdir()
    (user / "user_JointForces.py").write_text(
        "def user_JointForces(mbs_data, tsim):\n"
        "    mbs_data.Qq[1] = mbs_data.user_model['motor']['torque']\n"
    )
    data = MbsData(file)
    equil = MbsEquil(data)
    equil.set_options(language="python")
    equil.add_exchange("motor", "torque", data.joint_id["bob_0"])
    equil.run()
    assert data.q[1] == 0.0
    assert data.user_model["motor"]["torque"] == pytest.approx(-ONE * G * X, abs=EXACT)
    equil.add_exchange("motor", "nothing", 1)
    with pytest.raises(ConversionError, match=r"no parameter 'motor\.nothing'"):
        equil.run()


def test_a_loop_hangs_where_its_energy_is_least(tmp_path: Path) -> None:
    file = four_bar(tmp_path, ["independent", "dependent", "dependent"], 1.0)
    data, _ = find_pose(file)
    rest, frames = data.q.copy(), []
    results = simulate(file, time=1.0, language="python", equilibrium=True)
    assert np.ptp(results.q[:, 1:], axis=0).max() < 1e-8
    for step in (-1e-3, 0.0, 1e-3):
        data.q[:] = rest
        data.q[1] += step
        MbsPart(data).run()
        energy = np.zeros(3)
        data.mbs_energy(energy, data)
        frames.append(energy[2])
    assert frames[1] < min(frames[0], frames[2])
    assert frames[0] - frames[2] == pytest.approx(0.0, abs=1e-6)


def test_what_falls_has_no_equilibrium_and_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = made(tmp_path, arm("bob", BASE, ("T1", 0.0, FREE), ("T3", 0.0, FREE)))
    assert main(["simulate", str(file), "--equilibrium"]) == 1
    message = capsys.readouterr().err
    assert "error[no-equilibrium]" in message
    assert "joint 'bob_1' still has -9.81 m/s^2" in message
    assert f"'urdf2mbs simulate {near(file)} -o PAGE.html' shows how it moves" in message
    assert main(["modes", str(file), "--drawn"]) == 0
    assert (
        "rigid-body motion, without a restoring force: bob_0, bob_1\n  stable"
        in capsys.readouterr().out
    )


def test_forces_without_their_laws_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An .mbs away from its project lacks the laws of tyres and springs, as students' cars do."""
    bob = arm("bob", BASE, ("T3", 0.0, FREE), tip=(0.0, 0.0, 1.0))
    bob.points[-1].extforce = Sensor("tyre")
    file = made(tmp_path, bob)
    assert main(["modes", str(file)]) == 1
    hint = capsys.readouterr().err
    assert "the laws of tyre are user functions, which are not beside it" in hint
    assert f"in its project, with {near(file.parent.parent / 'userfctR')}" in hint


def test_a_floating_base_without_ground_is_told_what_holds_it(tmp_path: Path) -> None:
    project = make(tmp_path, TINY, base="floating", language="python")
    with pytest.raises(ConversionError) as error:
        modes(project, language="python")
    words = "nothing holds it: 'base: fixed' bolts it down, 'passes: {contacts: "
    assert (error.value.hint or "").startswith(words)


def test_nothing_to_swing_leads_to_no_page(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = made(here, arm("bob", BASE, ("T1", 0.0, FREE)))
    assert main(["modes", str(file), "--drawn", "-o", "modes.html"]) == 0
    out = capsys.readouterr().out
    assert "Next: simulate it; nothing brings it back to this pose: there is no page" in out
    assert not Path("modes.html").exists()


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_a_loop_is_closed_as_it_was_after_a_failed_attempt(tmp_path: Path) -> None:
    """The lamp sinks on its stops; Newton's method, tried on the way, folds its parallelogram."""
    found = modes(LAMP, base="fixed")
    q = dict(zip(found.data.joint_id, found.q[1:].tolist(), strict=True))
    assert q["front"] == pytest.approx(q["back"], abs=1e-9)
    assert q["front"] == pytest.approx(-q["front_top"], abs=1e-9)
    assert -0.62 < q["front"] < -0.6  # its stop, and how far the stop yields
    assert found.stable
    text = "\n".join(found.data._run.notes)
    assert "its base has moved" not in text  # the lamp is fixed to the world
    assert "posture: {joints: {front: -0.6" in text


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_a_block_rests_on_its_contacts(tmp_path: Path) -> None:
    """It falls, turns, and sinks until the ground carries its weight; it may stand anywhere."""
    block = """<robot name="block"><link name="foot"><inertial><mass value="2"/><inertia ixx="0.02"
ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial><collision><geometry><box
size="0.3 0.2 0.1"/></geometry></collision></link></robot>"""
    passes = {"contacts": {"links": ["foot"]}}
    project = make(tmp_path, block, base="floating", language="c", passes=passes)
    results = simulate(project, time=1.0, rtol=1e-9, atol=1e-12, equilibrium=True)
    assert np.ptp(results.q[:, 1:], axis=0).max() < 1e-8
    weight = sum(rows[:, :3] for rows in results.external.values())
    assert np.abs(weight - [0.0, 0.0, 2.0 * G]).max() < 1e-6
    found_modes = modes(project)
    assert found_modes.stable
    assert set(found_modes.free) >= set(results.equilibrium.free)
    names = [list(found_modes.data.joint_id)[k - 1] for k in results.equilibrium.free]
    assert [name[-2:] for name in names] == ["T1", "T2", "R3"]
    assert found_modes.stopped == found_modes.free


def test_a_swing_is_shown_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The page, the table and the .csv have the same modes."""
    page, folder = tmp_path / "swing.html", tmp_path / "slider"
    make(tmp_path, SLIDER, base="fixed", language="python", name="slider")
    assert main(["modes", str(folder), "-o", str(page), "--language", "python"]) == 0
    out = capsys.readouterr().out
    swing = math.sqrt(STIFFNESS / MASS - (DAMPING / 2 / MASS) ** 2) / 2 / math.pi
    assert re.search(rf"1 +{swing:.4g} .* rail\n  stable", out)
    assert b"q.rail" in (folder / "resultsR" / "mode.csv").read_bytes()
    assert page.read_bytes().startswith(b"<!DOCTYPE html>")
    assert main(["modes", str(folder), "--json"]) == 0
    described = json.loads(capsys.readouterr().out)
    assert described["modes"][0]["frequency"] == pytest.approx(swing)
    assert described["stable"]
    assert main(["modes", str(folder), "--mode", "9"]) == 2
    assert "the model has 1 modes" in capsys.readouterr().err
    assert modes(folder, language="python").modes[0].joints() == [1]


@pytest.mark.parametrize(
    ("upper", "said"),
    [
        (
            "0",
            [
                "at a stop, or beyond: rail; 'passes: {posture"
                ": {joints: {NAME: VALUE}}}' starts elsewhere"
            ],
        ),
        ("0.001", []),
    ],
)
def test_a_start_at_a_stop_is_named(tmp_path: Path, upper: str, said: list[str]) -> None:
    text = SLIDER.replace('upper="9"', f'upper="{upper}"')
    project = make(tmp_path, text, base="fixed", language="python")
    assert modes(project, drawn=True, language="python").data._run.notes == said
    assert simulate(project, time=0.01, language="python").data._run.notes == []
    data = MbsData(next((project / "dataR").glob("*.mbs")))
    data.q[1] = 0.01
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(tf=0.01, save2file=0)
    dirdyn.run()
    assert data._run.notes == [
        "pushed by their stops from the start: rail; "
        "'passes: {posture: {joints: {NAME: VALUE}}}' starts elsewhere"
    ]


def test_the_pose_of_a_tiny_pendulum_is_found(tmp_path: Path) -> None:
    """Of 30 um: its accelerations are large, and what rounding leaves of them is not 1e-8."""
    text = (
        '<robot name="p"><link name="base"/><link name="bob"><inertial><origin xyz="0 0 -3e-5"/>'
        '<mass value="1e-9"/><inertia ixx="1e-22" iyy="1e-22" izz="1e-22" ixy="0" ixz="0" iyz="0"/>'
        '</inertial></link><joint name="swing" type="continuous"><parent link="base"/>'
        '<child link="bob"/><axis xyz="0 1 0"/></joint></robot>'
    )
    passes = {"posture": {"joints": {"swing": 0.1}}}
    project = make(tmp_path, text, base="fixed", language="python", passes=passes)
    analysis = modes(project)
    assert analysis.q[1] == pytest.approx(0.0, abs=1e-9)
    (mode,) = analysis.modes
    assert mode.frequency == pytest.approx(np.sqrt(9.81 / 3e-5) / (2 * np.pi), rel=1e-3)
    assert mode.damping == 0.0


def test_states_that_fade_are_one_line_of_the_table(tmp_path: Path) -> None:
    """A box rests on its contacts, and an arm hangs in the air, whose bristles move nothing."""
    box = (
        '<robot name="box"><link name="box"><inertial><mass value="2"/><inertia ixx="0.02" '
        'iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>'
        '<box size="0.3 0.2 0.1"/></geometry></collision></link><link name="arm"><inertial>'
        '<origin xyz="0 0 0.1"/><mass value="0.1"/><inertia ixx="0.002" iyy="0.002" izz="0.002" '
        'ixy="0" ixz="0" iyz="0"/></inertial><collision><origin xyz="0 0 0.2"/><geometry>'
        '<sphere radius="0.02"/></geometry></collision></link><joint name="swing" type="revolute">'
        '<parent link="box"/><child link="arm"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" '
        'effort="9" velocity="9"/></joint></robot>'
    )
    passes = {"contacts": {"links": ["*"]}, "posture": {"hold": {"frequency": 3}}}
    project = make(tmp_path, box, base="floating", language="c", passes=passes)
    analysis = modes(project)
    inner = [mode for mode in analysis.modes if mode.is_inner]
    lines = analysis.lines()
    assert len(inner) >= 3
    assert all(mode.value.real < 0 for mode in inner)
    (line,) = [line for line in lines if "states of contacts, friction or the user" in line]
    assert line.startswith(f"{len(inner)} more: ")
    named = [line for line in lines[1:] if line[:4].strip().isdigit()]
    assert len(named) == len(analysis.modes) - len(inner)
    assert not any("user states" in line for line in named)


def test_an_equilibrium_that_lies_does_not_stand(tmp_path: Path) -> None:
    """A box that is drawn on its edge rests on its side; 'posture' cannot give this pose."""
    box = (
        '<robot name="box"><link name="box"><inertial><mass value="2"/><inertia ixx="0.02" '
        'iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>'
        '<box size="0.1 0.2 0.3"/></geometry></collision></link></robot>'
    )
    passes = {"contacts": {"links": ["*"]}}
    project = make(tmp_path, box, base="floating", language="c", passes=passes)
    data = MbsData(next((project / "dataR").glob("*.mbs")))
    data.q[3], data.q[5] = 0.16, 0.8
    equilibrium = find_equilibrium(data)
    assert abs(equilibrium.moved[5]) > 0.6
    text = "\n".join(equilibrium.lines())
    assert "its base has moved" in text
    assert "posture: {joints" not in text
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(tf=0.3, save2file=0)
    results = dirdyn.run()
    results.equilibrium = equilibrium
    story = results.story()
    assert story is not None
    assert story.fell
    assert "does not stand at the equilibrium" in story.words


def test_zero_modes_are_named_apart(tmp_path: Path) -> None:
    """One slide goes on for ever, oil stops another, and a state keeps what it has."""
    slides = arm("bob", BASE, ("T1", 0.0, FREE), ("T2", 0.0, FREE), ("R2", math.atan2(X, -Z), FREE))
    file = made(tmp_path, slides)
    mbs = read_mbs(file.read_bytes(), str(file))
    mbs.user_models = [UserModel("memory", [Parameter("at", "state", ("0.0", "0.0"))])]
    file.write_bytes(write(mbs))
    user = file.parent.parent / "userfctR"
    user.mkdir()
    (user / "user_JointForces.py").write_text(
        "def user_JointForces(mbs_data, tsim):\n    mbs_data.Qq[2] = -3.0 * mbs_data.qd[2]\n"
    )
    (user / "user_Derivative.py").write_text(
        "def user_derivatives(mbs_data):\n    mbs_data.uxd[1] = -mbs_data.ux[1]\n"
    )
    *_, drifts, stops, states, stable = modes_of(MbsData(file)).lines()
    assert drifts == "rigid-body motion, without a restoring force: bob_0"
    assert stops == "friction or damping holds these where they are: bob_1"
    assert (states, stable) == ("user states that keep their values: memory.at", "stable")


MAIN = """
import MBsysPy as Robotran
from MBsysPy.mbs_utilities import set_output
from MBsysPy.mbsyspy.utilities.algebra import cross_product, matrix_matrix_product
import numpy as np, os
here = os.path.dirname(os.path.abspath(__file__))
mbs_data = Robotran.MbsData(os.path.join(here, "..", "dataR", "loops.mbs"))
mbs_data.set_qdriven(mbs_data.joint_id["bob_0"])
part = Robotran.MbsPart(mbs_data); part.set_options(rowperm=1, verbose=1); part.run()
mbs_data.set_qu(mbs_data.joint_id["bob_0"])
mbs_equil = Robotran.MbsEquil(mbs_data)
mbs_equil.set_options(method=1, senstol=1e-2, verbose=1); mbs_equil.run(); mbs_equil.print_equil()
mbs_modal = Robotran.MbsModal(mbs_data)
mbs_modal.set_options(save_result=1, save_anim=1, mode_ampl=0.2); mbs_modal.run()
mbs_dirdyn = Robotran.MbsDirdyn(mbs_data)
mbs_dirdyn.set_options(dt0=1e-3, tf=0.1, save2file=1); results = mbs_dirdyn.run()
mbs_data.sensors.append(Robotran.MbsSensor(mbs_data)); mbs_data.sensors[1].P
print(results.outputs["three"].shape, mbs_data.nqa, mbs_data.Nsensor)
product = Robotran.matrix_vector_product(np.eye(4) * 2, np.arange(4.0))
print(product.tolist(), cross_product([0, 1, 0, 0], [0, 0, 1, 0]).tolist())
mbs_dirdyn.set_options(integrator="Sundials"); mbs_dirdyn.run()
"""
LOOP = """
import MBsysPy as Robotran
def user_dirdyn_init(mbs_data, mbs_dirdyn):
    Robotran.define_output_vector("three", 3)
def user_dirdyn_loop(mbs_data, mbs_dirdyn):
    Robotran.set_output(1.0, "one")
    Robotran.set_output_vector([1.0, 2.0, 3.0], "three")
def user_dirdyn_finish(mbs_data, mbs_dirdyn):
    pass
"""


def test_a_main_py_of_robotrans_runs_unchanged(tmp_path: Path) -> None:
    """Up to its last line, of which the error has our words."""
    project = made(tmp_path, arm("bob", BASE, ("R2", 0.3, FREE))).parent.parent
    for name, text in (("workR/main.py", MAIN), ("userfctR/user_dirdyn.py", LOOP)):
        (project / name).parent.mkdir()
        (project / name).write_text(text)
    done = subprocess.run(
        [sys.executable, "-m", "urdf2mbs_simulate", str(project / "workR" / "main.py")],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1, done.stderr
    assert "no integrator 'Sundials'" in done.stderr
    assert "Traceback" not in done.stderr
    assert re.search(r"\(\d+, 4\) 0 0\n\[0.0, 2.0, 4.0, 6.0\] \[0.0, 0.0, 0.0, 1.0\]", done.stdout)
    names = {file.name for file in (project / "resultsR").iterdir()}
    assert {"equil_q.res", "modal_eval_a.res", "dirdyn_q.res", "dirdyn_three.res"} <= names
    assert (project / "animationR" / "modal_1_q.anim").is_file()
