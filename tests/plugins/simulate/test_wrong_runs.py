"""Runs of projects that go wrong, and what user code may do."""

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf2mbs
from support.project_robots import MIMIC_CHAIN as CHAIN
from support.standin import make
from urdf2mbs import ConversionError, load_equations, simulate
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import TINY
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

TINY_FILE = Path(urdf2mbs.__file__).with_name("tiny.urdf")
needs_gcc = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
TIGHT: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-11}


NAN = "    mbs_data.Qq[mbs_data.joint_id['wrist_roll']] += 9.0 if tsim < 0.05 else float('nan')\n"
WILD = "    mbs_data.Qq[mbs_data.joint_id['wrist_roll']] += 1e9 * (tsim * 1e15 % 7 - 3)\n"
NO_STEP = r"no step from 0\.0[45]\S* s is short enough: joint 'wrist_roll' has .* force is 9 N m"
FORCES, MODEL = "userfctR/user_JointForces", "dataR/robot.mbs"
#: The language; the file, what is replaced there by what ("": added); the code and the words.
WRONG_FILES: dict[str, tuple[str, str, str, str, str, str]] = {
    "C that does not compile": (
        "c",
        f"{FORCES}.c",
        "",
        "int x = nothing;\n",
        "not-compiled",
        "nothing",
    ),
    "C of MBsysC": (
        "c",
        f"{FORCES}.c",
        "",
        '#include "mbs_matrix.h"\n',
        "not-compiled",
        "mbs_matrix.h.*\n.* it belongs to Robotran's MBsysC",
    ),
    "C of an add-on": (
        "c",
        f"{FORCES}.c",
        "",
        '#include "tgc_car.h"\n',
        "not-compiled",
        "tyres on the ground",
    ),
    "an add-on": (
        "python",
        f"{FORCES}.py",
        r"(?s)\A.*\Z",
        "import mbs_rwc\n",
        "user-function-failed",
        "for wheels on rails, which is not available",
    ),
    "a module elsewhere": (
        "python",
        f"{FORCES}.py",
        r"(?s)\A.*\Z",
        "import user_DrivenJoints\nimport accelred\n",
        "user-function-failed",
        "in .*elsewhere: add this folder to PYTHONPATH",
    ),
    "no Python": (
        "python",
        f"{FORCES}.py",
        r"(?s)\A.*\Z",
        "def user_JointForces(mbs_data, tsim:\n",
        "user-function-failed",
        "SyntaxError",
    ),
    "no number": ("python", f"{FORCES}.py", "", NAN, "step-failed", NO_STEP),
    "no number, Radau": ("Radau", f"{FORCES}.py", "", NAN, "step-failed", NO_STEP),
    "no number, DOP853": ("DOP853", f"{FORCES}.py", "", NAN, "step-failed", NO_STEP),
    "no law": ("Radau", f"{FORCES}.py", "", WILD, "step-failed", "no step|steps lead"),
    "equations of another model": (
        "c",
        MODEL,
        "<type>R1</type>",
        "<type>R2</type>",
        "equations-of-another-model",
        "not of the model",
    ),
    "a vector for C": (
        "c",
        MODEL,
        "<type>scalar</type>",
        "<type>vector</type>",
        "user-model-in-c",
        "is a vector of 1 values, and C user functions",
    ),
    "a lost function": (
        "python",
        "userfctR/user_cons_hJ.py",
        "",
        None,
        "partition",
        r"2 joints are dependent.* 0 of user_cons",
    ),
}


@pytest.mark.parametrize("fault", WRONG_FILES)
def test_a_fault_in_a_file_is_named(
    fault: str, tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    how, name, before, after, code, said = WRONG_FILES[fault]
    language = "c" if how == "c" else "python"
    if how == "c" and shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    passes = {"equations": {"language": "c"}} if "another" in fault else {}
    text = CHAIN if after is None else TINY
    project = make(tmp_path, text, base="fixed", language=language, passes=passes)
    file = project / name
    if after is None:
        file.unlink()
    else:
        own = file.read_text()
        file.write_text(re.sub(before, lambda _: after, own, count=1) if before else own + after)
        assert file.read_text() != own
    (project / "elsewhere").mkdir()
    (project / "elsewhere" / "accelred.py").touch()
    method = {"method": how} if how in ("Radau", "DOP853") else {}
    with pytest.raises(ConversionError, match=said) as caught:
        simulate(project, time=0.1, language=language, **method)
    assert caught.value.code == code
    if code in ("not-compiled", "user-function-failed"):
        assert caught.value.file == str(file)
        assert caught.value.line == len(file.read_text().splitlines())
    assert not recwarn.list


def test_user_functions_in_c_alone_do_not_run_in_python(tmp_path: Path) -> None:
    with pytest.raises(ConversionError, match="are in C only"):
        simulate(make(tmp_path, TINY, language="c"), language="python")


def test_a_model_without_mass_is_held_and_called_so(tmp_path: Path) -> None:
    """A run says what gives it masses; its equations alone cannot be made."""
    chain, tiny = (re.sub(r"(?s)<inertial>.*?</inertial>", "", text) for text in (CHAIN, TINY))
    robot = tmp_path / "light.urdf"
    robot.write_text(chain)
    results = simulate(robot, output={"project": tmp_path / "light"}, time=0.1, language="python")
    assert np.ptp(results.q[:, 1:], axis=0).max() == 0.0
    assert "; no body has a mass: a config gives masses" in results.data._run.notes[-1]
    assert "estimate-inertia" in results.data._run.notes[-1]
    robot.write_text(tiny)
    model = load_equations(robot, language="python")
    zeros = [0.0] * model.data.njoint
    with pytest.raises(np.linalg.LinAlgError, match="no mass resists the force of joint 'wrist"):
        model.forward_dynamics(zeros, zeros, zeros)
    with pytest.raises(ConversionError, match="no body has a mass") as caught:
        model.centre_of_mass(zeros)
    assert caught.value.code == "equations-not-generated"


def test_numbers_that_make_no_run(tmp_path: Path, capsys: Any) -> None:
    project = make(tmp_path, TINY)
    for option in ("--time=0", "--time=nan", "--time=inf", "--rate=0", "--tolerance=nan"):
        assert main(["simulate", str(project), option]) == 2
        assert "expected a number above 0" in capsys.readouterr().err
    data = MbsData(project / "dataR" / "robot.mbs")
    for values in (data.q, data.qd):
        values[2] = np.nan
        dirdyn = MbsDirdyn(data)
        dirdyn.set_options(tf=0.1, language="python", save2file=0)
        with pytest.raises(ConversionError, match="start position or speed of"):
            dirdyn.run()
        values[2] = 0.0


@pytest.mark.parametrize("language", ["python", pytest.param("c", marks=needs_gcc)])
def test_a_user_function_that_raises_is_shown_with_its_line(tmp_path: Path, language: str) -> None:
    project = make(tmp_path, TINY)
    file = project / "userfctR" / "user_JointForces.py"
    text = file.read_text()
    file.write_text(text + "    if tsim > 0.01:\n        mbs_data.Qq[99] = 1.0\n")
    with pytest.raises(ConversionError, match=r"at 0\.01\d* s: IndexError: index 99") as caught:
        simulate(project, time=0.1, language=language, method="DOP853")
    assert caught.value.file == str(file)
    assert caught.value.line == len(text.splitlines()) + 2
    assert caught.value.code == "user-function-failed"


def test_options_are_those_of_robotran(tmp_path: Path) -> None:
    dirdyn = MbsDirdyn(MbsData(make(tmp_path, TINY) / "dataR" / "robot.mbs"))
    dirdyn.set_options(tf=2.0, save_anim=1)
    assert dirdyn.get_options("tf") == 2.0
    with pytest.raises(ConversionError, match="MbsDirdyn has no option 'save_anin'"):
        dirdyn.set_options(save_anin=1)


@needs_gcc
def test_the_loop_of_user_code_in_c_is_called(tmp_path: Path) -> None:
    project = make(tmp_path, TINY, language="c")
    file = project / "userfctR" / "user_dirdyn.c"
    call = "_check_step(mbs_data);"
    file.write_text(file.read_text().replace(call, call + "\n    mbs_data->flag_stop = 1;"))
    assert simulate(project, time=0.1).stopped


def test_a_gimbal_that_starts_locked_is_named(tmp_path: Path) -> None:
    solid = '<inertial><mass value="1"/><inertia ixx="1" iyy="2" izz="2.5"/></inertial>'
    links = "".join(f'<link name="{name}"/>' for name in ("world", "of_a", "of_b"))
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
        f'<child link="of_{name}"/><axis xyz="{axis}"/></joint>'
        for name, parent, axis in (
            ("a", "world", "0 0 1"),
            ("b", "of_a", "0 1 0"),
            ("c", "of_b", "1 0 0"),
        )
    )
    text = f'<robot name="gimbal">{links}<link name="of_c">{solid}</link>{joints}</robot>'
    project = make(tmp_path, text, passes={"posture": {"joints": {"b": 1.5708}}})
    file = project / "userfctR" / "user_JointForces.py"
    file.write_text(file.read_text() + "    mbs_data.Qq[1:] += 0.0 if tsim == 0.0 else 1e400\n")
    with pytest.raises(ConversionError, match="nothing that has mass resists joint 'a'") as caught:
        simulate(project, time=0.1, language="python")
    assert (caught.value.hint or "").startswith("start elsewhere, ")


def test_an_absurd_push_ends_in_a_bounded_number_of_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """1e9 N on the biped ran for 425 s without a word."""
    monkeypatch.setattr("urdf2mbs_simulate.dirdyn.MAX_STEPS", 50)
    times: list[float] = []
    with pytest.raises(
        ConversionError,
        match=r"50 steps lead from 0\.\S+ s to 0\.\S+ s only: "
        r"joint '\w+' has .*the push on 'arm' is 1e\+09 N",
    ) as caught:
        simulate(TINY_FILE, push=["arm:0,1e9,0@0.01.."], language="python", watch=times.append)
    assert caught.value.code == "step-failed"
    assert len(times) < 2000
    assert times == sorted(times)


@needs_gcc
def test_a_loop_of_the_user_reads_an_imu_in_both_languages(tmp_path: Path) -> None:
    """The lines that the templates offer as comments."""
    project = make(
        tmp_path, TINY, base="fixed", language="both", passes={"sensors": {"links": ["tool"]}}
    )
    python, c = (project / "userfctR" / f"user_dirdyn.{end}" for end in ("py", "c"))
    python.write_text(python.read_text().replace("    # ", "    "))
    inside = re.search(r"/\* (MbsSensor.*?) \*/", c.read_text(), re.DOTALL)
    assert inside is not None
    lines = inside[1].replace("     * ", "    ")
    c.write_text('#include "set_output.h"\n' + c.read_text().replace(inside[0], lines))
    read = {}
    for language in ("python", "c"):
        results = simulate(project, time=0.2, language=language, method="DOP853", rtol=1e-9)
        read[language] = results.outputs["tool_sensor_z"]
    assert len(read["c"]) > 3
    assert np.ptp(read["c"][:, 1]) > 0.1, "it swings"
    # the lengths of steps differ by 1e-9 s, in which a stop changes the force by 1e-4
    assert np.allclose(read["c"], read["python"], rtol=0, atol=1e-3)


def test_user_code_ends_a_run_and_gives_outputs(tmp_path: Path, capsys: Any) -> None:
    project = make(tmp_path, TINY)
    file = project / "userfctR" / "user_dirdyn.py"
    file.write_text(
        file.read_text().replace(
            "    robot.check_step(mbs_data)\n",
            "    robot.check_step(mbs_data)\n"
            "    mbs_data.set_output(mbs_data.tsim ** 2, 'square')\n"
            "    mbs_data.flag_stop = mbs_data.tsim > 0.05\n",
        )
    )
    results = simulate(project, language="python")
    assert results.stopped
    assert 0.05 < results.outputs["square"][-1, 0] < 0.2
    assert np.allclose(results.outputs["square"][:, 1], results.outputs["square"][:, 0] ** 2)
    assert results.time[-1] <= results.outputs["square"][-1, 0]
    assert main(["simulate", str(project), "--language", "python"]) == 1
    assert "a user function has stopped the run at 0." in capsys.readouterr().err


@pytest.mark.parametrize("language", ["python", pytest.param("c", marks=needs_gcc)])
def test_robotrans_equations_without_accelred_get_one(tmp_path: Path, language: str) -> None:
    """Robotran's own are in Python without it."""
    project = make(tmp_path, TINY, language=language, passes={"equations": {"language": language}})
    wanted = simulate(project, time=0.1, language=language)
    (file,) = project.glob("symbolicR/mbs_accelred_robot.*")
    file.unlink()
    results = simulate(project, time=0.1, language=language)
    assert np.allclose(results.q, wanted.q, rtol=0, atol=1e-7)


@needs_gcc
@pytest.mark.parametrize(
    ("old", "said"),
    [
        ("//\t==> Number of joints : 21\n", ", of a model with 21 joints"),
        ('#include "mbs_message.h"\n', " that include mbs_message.h of another Robotran"),
    ],
    ids=["joints", "header"],
)
def test_equations_of_robotrans_that_cannot_run_are_not_used(
    old: str, said: str, tmp_path: Path
) -> None:
    """Such as those in C of an older model, left behind in a project whose code is in Python."""
    project = make(tmp_path, TINY, passes={"equations": {"language": "c"}})
    wanted = simulate(project, time=0.1)
    (file,) = project.glob("symbolicR/mbs_dirdyna_robot.c")
    file.write_text(old)
    results = simulate(project, time=0.1)
    assert np.array_equal(results.q, wanted.q)
    assert results.data._run.notes == [f"not used: equations in symbolicR{said}"]


def test_what_cannot_be_simulated_is_told(tmp_path: Path) -> None:
    (tmp_path / "dataR").mkdir()
    (tmp_path / "dataR" / "arm.rejected.mbs").write_text("")
    with pytest.raises(ConversionError, match=r"expected 1 model .* in its dataR, got 0") as caught:
        simulate(tmp_path)
    assert (caught.value.code, caught.value.exit_code) == ("project-unknown", 2)
    with pytest.raises(ConversionError, match="there is no integrator 'Euler'"):
        simulate(TINY_FILE, method="Euler")
    mistake = tmp_path / "mistake.py"
    mistake.write_text(
        "from urdf2mbs.plugin import Pass, hookimpl\n"
        "class Wrong(Pass):\n"
        "    def run(self, conversion): conversion.mbs.bodies[0].mass = 9.0\n"
        "@hookimpl\ndef urdf2mbs_passes(): return [Wrong]\n"
    )
    with pytest.raises(ConversionError, match="is not the same robot") as caught:
        simulate(TINY_FILE, plugins=[mistake], after={"reframe-inertia": ["wrong"]})
    assert (caught.value.code, caught.value.exit_code) == ("not-the-same", 3)


def test_a_new_model_without_bodies_runs(tmp_path: Path, capsys: Any) -> None:
    """As MBSysPad makes it: the command ended as a mistake of urdf2mbs."""
    model = tmp_path / "new.mbs"
    model.write_bytes(write(Mbs("new")))
    assert main(["simulate", str(model), "--language", "python", "--time", "0.02"]) == 0
    assert "0.02 s of 0 independent joints" in capsys.readouterr().out


@pytest.mark.parametrize("language", ["python", pytest.param("c", marks=needs_gcc)])
def test_user_states_are_integrated(tmp_path: Path, language: str) -> None:
    """u' = -3 u, from the value that the .mbs gives."""
    project = make(tmp_path, TINY)
    model = project / "dataR" / "robot.mbs"
    state = (
        "<user_model><name>filter</name><parameter><name>u</name><type>state</type>"
        "<value>2.0</value></parameter></user_model>"
    )
    text = model.read_text()
    model.write_text(text.replace("</user_models>", state + "</user_models>"))
    (project / "userfctR" / "user_Derivative.py").write_text(
        "def user_derivatives(mbs_data):\n"
        "    u = mbs_data.user_model['filter']['u']\n"
        "    mbs_data.uxd[u] = -3.0 * mbs_data.ux[u]\n"
    )
    results = simulate(project, time=0.5, language=language, **TIGHT)
    u = results.frames["ux"][:, 1]
    assert np.allclose(u, 2.0 * np.exp(-3.0 * results.time), rtol=0, atol=1e-8)
