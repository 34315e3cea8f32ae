"""Who owns which file of a project, and the main script as a user would start it."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from support.laws import convert as with_laws
from support.project_robots import MIMIC_CHAIN as CHAIN
from support.proving import codes
from support.standin import MbsData, make, user_functions
from urdf2mbs import convert, simulate
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_project.code import FOLDER, generate_starter_files

#: All twelve user functions of MBsysPy, and what is called in each file.
FUNCTIONS = {
    "user_Derivative": ["user_derivatives"],
    **{
        name: [name]
        for name in (
            "user_DrivenJoints",
            "user_ExtForces",
            "user_JointForces",
            "user_Link3DForces",
            "user_LinkForces",
            "user_cons_J_accelred",
            "user_cons_hJ",
            "user_cons_jdqd",
        )
    },
    **{
        name: [f"{name}_{phase}" for phase in ("init", "loop", "finish")]
        for name in ("user_dirdyn", "user_equil", "user_invdyn")
    },
}


#: Stands for MBsysPy: it writes down what the main script asks for.
MBSYSPY = """
import sys
from pathlib import Path
sys.path[:0] = {paths!r}
import numpy as np
from support.standin import MbsData as Data

class MbsData(Data):
    def set_nb_userc(self, count):
        print("constraints", count)

class Module:
    def __init__(self, mbs_data):
        self.mbs_data = mbs_data
        print(type(self).__name__, mbs_data.process)

    def set_options(self, **options):
        print(*(f"{{key}}={{value}}" for key, value in options.items()))

    def run(self):
        self.q = np.zeros((3, self.mbs_data.njoint + 1))
        return self

class MbsPart(Module):
    pass

class MbsDirdyn(Module):
    pass
"""

#: What Robotran does where it cannot go on.
FAILURES = {
    "partition": ("MbsPart", "self.mbs_data.DonePart, self.mbs_data.nqv = 0, 0"),
    "nan": ("MbsDirdyn", "self.mbs_data.q[3], self.mbs_data.tsim = np.nan, 0.25"),
    "stopped": ("MbsDirdyn", "self.mbs_data.flag_stop, self.mbs_data.tsim = 1, 0.25"),
    "raises": ("MbsDirdyn", "raise RuntimeError('Cholesky failed')"),
}


def test_all_twelve_user_functions_are_there(tmp_path: Path) -> None:
    project = make(tmp_path, TINY)
    with user_functions(project) as user:
        assert set(user) == set(FUNCTIONS)
        for name, functions in FUNCTIONS.items():
            assert all(callable(getattr(user[name], function)) for function in functions)
        assert callable(user["user_equil"].user_equil_fxe)
    for folder in ("resultsR", "animationR/vrml", "symbolicR"):
        assert (project / folder).is_dir()


def test_code_of_another_language_goes_and_that_of_this_one_stays(tmp_path: Path) -> None:
    user = make(tmp_path, CHAIN, language="both") / "userfctR"
    assert (user / "robot_robot.c").is_file()
    made = convert(tmp_path / "source.urdf", output={"project": user.parent})
    (told,) = [d.message for d in made.diagnostics if d.code == "project-obsolete"]
    assert told.startswith("11 files of an earlier conversion fit the robot no more")
    make(tmp_path, CHAIN, language="python")
    assert not (user / "robot_robot.c").exists()
    assert (user / "robot_robot.py").is_file()


def test_a_second_conversion_writes_what_depends_on_the_robot_alone(tmp_path: Path) -> None:
    project = make(tmp_path, CHAIN, language="both")
    kept = project / "userfctR" / "user_JointForces.py"
    kept.write_text("mine = 1\n")
    main_script = project / "workR" / "main.py"
    main_script.unlink()
    before = {path: path.read_bytes() for path in project.rglob("*") if path.is_file()}
    (project / "dataR" / "robot.mbs").unlink()
    make(tmp_path, CHAIN.replace('multiplier="2"', 'multiplier="4"'), language="both")
    assert main_script.is_file(), "what is not there is written"
    changed = {path.name for path, data in before.items() if path.read_bytes() != data}
    assert changed == {"robot_robot.py", "robot_robot.c", ".urdf2mbs"}


def test_user_joint_forces_says_how_hold_ends(tmp_path: Path) -> None:
    """By joints of this robot; without such a controller it says nothing."""
    hold = {"posture": {"hold": {"joints": ["wr*"]}}}
    project = make(tmp_path, TINY, language="both", base="fixed", passes=hold)
    for file, says in (
        ("user_JointForces.py", 'user_model["hold_stiffness"]["wrist_roll"] = 0.0'),
        ("user_JointForces.c", "user_model->hold_stiffness.wrist_roll = 0.0;"),
    ):
        assert says in (project / "userfctR" / file).read_text()
        language = "python" if file.endswith("py") else "c"
        assert b"hold" not in generate_starter_files(language, Mbs("r"))[f"userfctR/{file}"]
    data = MbsData(project / "dataR" / "robot.mbs")
    data.user_model["joint_forces"] = {}
    data.q[1:] = 0.7
    with user_functions(project) as user:
        for on in (1.0, 0.0):
            data.user_model["hold"]["on"] = on
            user["user_JointForces"].user_JointForces(data, 0.0)
            assert np.any(data.Qq[1:]) == bool(on)


def test_a_link_that_leads_nowhere_is_the_users_too(tmp_path: Path) -> None:
    (tmp_path / "robot" / "workR").mkdir(parents=True)
    (tmp_path / "robot" / "workR" / "main.py").symlink_to(tmp_path / "elsewhere.py")
    make(tmp_path, TINY)
    assert (tmp_path / "robot" / "workR" / "main.py").is_symlink()


def run_main(project: Path, start: str, more: str = "") -> subprocess.CompletedProcess[str]:
    library = project.parent / "library"
    library.mkdir()
    tests = str(Path(__file__).resolve().parents[3])
    (library / "MBsysPy.py").write_text(MBSYSPY.format(paths=[tests]) + more)
    (library / "matplotlib.py").write_text("raise ImportError('none here')\n")
    return subprocess.run(
        [sys.executable, str(project / "workR" / "main.py")],
        cwd=project / start,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(library), os.environ["PYTHONPATH"]])},
    )


@pytest.mark.parametrize(
    ("failure", "says"),
    [
        ("partition", "there is no partition, so the loops would be open: two, three cannot"),
        ("nan", "at 0.25 s the position or speed of joint two is not a number"),
        ("stopped", "the run stopped at 0.25 s"),
        ("raises", "the run stopped at 0 s: Cholesky failed"),
    ],
)
def test_main_stops_where_robotran_cannot_go_on(tmp_path: Path, failure: str, says: str) -> None:
    name, fails = FAILURES[failure]
    more = f"""
class {name}(Module):
    def run(self):
        {fails}
        return super().run()
"""
    done = run_main(make(tmp_path, CHAIN, base="fixed"), ".", more)
    assert done.returncode == 1
    assert says in done.stderr
    assert "Traceback" not in done.stderr
    assert "plot" not in done.stdout


def test_a_step_that_is_not_a_number_ends_the_run(tmp_path: Path, capsys: object) -> None:
    """It is said once, with the joint that was the fastest before."""
    project = make(tmp_path, CHAIN, base="fixed")
    data = MbsData(project / "dataR" / "robot.mbs")
    with user_functions(project) as user:
        loop = user["user_dirdyn"].user_dirdyn_loop
        data.qd[5] = -70.0
        loop(data, None)
        assert data.flag_stop == 0
        data.q[2] = float("inf")
        for _ in range(3):
            loop(data, None)
        assert data.flag_stop == 1
    (line,) = capsys.readouterr().err.splitlines()  # type: ignore[attr-defined]
    assert "joint one is not a number" in line
    assert "joint four was the fastest, at 70 rad/s" in line


@pytest.mark.parametrize("start", ["workR", "/"])
def test_main_starts_from_any_folder(tmp_path: Path, start: str) -> None:
    project = make(tmp_path, CHAIN, passes={"posture": {"joints": {"one": 0.25}}})
    done = run_main(project, start)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [
        "MBsysPy simulates",
        "constraints 2",
        "MbsPart 1",
        "rowperm=1 verbose=1",
        "MbsDirdyn 3",
        "dt0=0.0005 tf=1.0 save2file=1",
        "saveperiod=20",
        "no plot: pip install matplotlib",
        f"robot: 0 s simulated; results are in {project / 'resultsR'}",
    ]


@pytest.mark.skipif(
    find_spec("MBsysPy") is None,
    reason="MBsysPy, which pip finds in https://www.robotran.eu/dist/, is not installed",
)
def test_main_runs_with_robotran(tmp_path: Path) -> None:
    """Robotran's own program and our runtime compute the same motion of one project."""
    project = make(tmp_path, CHAIN, base="fixed", passes={"posture": {"joints": {"one": 0.25}}})
    (tmp_path / "matplotlib.py").write_text("raise ImportError('none here')\n")
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    command = [sys.executable, str(project / "workR" / "main.py")]
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("MBsysPy simulates")
    robotran = np.loadtxt(project / "resultsR" / "dirdyn_q.res")
    ours = simulate(project, time=1.0).q
    assert robotran[-1, 0] == pytest.approx(1.0)
    assert robotran[-1, 1:] == pytest.approx(ours[-1, 1:], abs=1e-5)


def test_main_runs_without_robotran(tmp_path: Path) -> None:
    """The runtime moves it; what cannot go on is told as with Robotran."""
    project = make(tmp_path, CHAIN, base="fixed", passes={"posture": {"joints": {"one": 0.25}}})
    file = project / "userfctR" / "user_JointForces.py"
    file.write_text(file.read_text() + "    mbs_data.Qq[mbs_data.joint_id['one']] += 9.0\n")
    (tmp_path / "matplotlib.py").write_text("raise ImportError('none here')\n")
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ["PYTHONPATH"]])}
    command = [sys.executable, str(project / "workR" / "main.py")]
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [
        "MBsysPy is not installed: the runtime of urdf2mbs simulates",
        "no plot: pip install matplotlib",
        f"robot: 1 s simulated; results are in {project / 'resultsR'}",
    ]
    q = np.loadtxt(project / "resultsR" / "dirdyn_q.res")
    data = MbsData(project / "dataR" / "robot.mbs")
    assert q[-1, 0] == 1.0
    first, two = (q[:, data.joint_id[name]] for name in ("one", "two"))
    assert np.ptp(first) > 0.1
    assert np.ptp(two - robot_rule(project) * first) < 1e-8
    file.write_text(file.read_text() + "    mbs_data.Qq[mbs_data.joint_id['one']] = float('nan')\n")
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "the force of joint 'one' is not a number at 0 s" in done.stderr


def robot_rule(project: Path) -> float:
    """How fast 'two' follows 'one'."""
    text = (project / "userfctR" / "robot_robot.py").read_text()
    return float(text.split('("two", "one", ')[1].split(",")[0])


def test_user_functions_are_found_however_they_are_loaded(tmp_path: Path) -> None:
    """By path, by name with the folder on Python's path, and as text without a file."""
    project = make(tmp_path, CHAIN)
    folder = project / "userfctR"
    text = (folder / "user_cons_hJ.py").read_text()
    script = (
        "import sys, runpy\n"
        f"runpy.run_path({str(folder / 'user_cons_hJ.py')!r})\n"
        f"sys.path.insert(0, {str(folder)!r})\n"
        "import user_cons_jdqd\n"
        f"exec(compile({text!r}, 'user_cons_hJ', 'exec'), {{}})\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd="/", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_nothing_of_urdf2mbs_is_needed_at_run_time() -> None:
    """But for main.py, where Robotran is not there."""
    for file in FOLDER.rglob("*.py.in"):
        expected = file.name == "main.py.in"
        assert ("import urdf2mbs" in file.read_text()) == expected, file


def test_a_project_that_was_renamed(tmp_path: Path) -> None:
    """Its user functions still call the module of the old name: that is told."""
    make(tmp_path, TINY, name="old", language="both").rename(tmp_path / "new")
    touched = tmp_path / "new" / "userfctR" / "user_ExtForces.c"
    touched.write_text(touched.read_text() + "/* mine */\n")
    output = {"project": tmp_path / "new", "language": "both"}
    (told,) = [
        diagnostic
        for diagnostic in convert(tmp_path / "source.urdf", output=output).diagnostics
        if diagnostic.code == "project-renamed"
    ]
    assert "the project is called 'new', and your files use 'old_robot'" in told.message
    assert told.message.endswith(": user_ExtForces.c"), "those nobody touched are renewed"


def test_your_files_that_name_what_is_gone_are_told(tmp_path: Path) -> None:
    """With line and name; not those of urdf2mbs, and not other texts."""
    passes = {"sensors": {"links": ["hand"]}, "contacts": {"links": ["body"]}}
    project = make(tmp_path, TINY, passes=passes)
    user = project / "userfctR"
    (user / "mine.py").write_text(
        "a = 1\nb = joint_id['shoulder']\n# shoulder\nc = wrist_roll_id\n"
    )
    (user / "mine.txt").write_text("'shoulder'")
    (project / "workR" / "more").mkdir()
    (project / "workR" / "more" / "run.c").write_text(
        'x("hand_sensor", "body_contact_force")\nf = "bristle"\n'
    )
    text = TINY.replace('"shoulder"', '"hip"').replace('"wrist_roll"', '"roll"')
    messages = {}
    for new in (TINY, text):
        (tmp_path / "r.urdf").write_text(new)
        result = convert(tmp_path / "r.urdf", output={"project": project})
        messages[new] = [d.message for d in result.diagnostics if d.code == "project-names-lost"]
    gone = "run.c:1 'hand_sensor', run.c:1 'body_contact_force', run.c:2 'bristle'"
    assert messages[TINY] == [f"your files use names that the model has no more: {gone}"]
    assert messages[text] == [
        "your files use names that the model has no more: mine.py:2 'shoulder', "
        "mine.py:4 'wrist_roll', " + gone
    ]


@pytest.mark.parametrize(("name", "code"), [("storm", "law-missing"), ("rubber", "law-doubled")])
def test_a_law_needs_a_function_of_its_own_name(name: str, code: str, tmp_path: Path) -> None:
    assert "law-unknown" in codes(with_laws(tmp_path))
    with pytest.raises(ConversionError) as error:
        with_laws(tmp_path, name_of_point=name)
    assert error.value.code == code


def test_a_project_without_the_states_of_friction_is_refused(tmp_path: Path) -> None:
    passes = {"contacts": {"points": {"hand": [[0.0, 0.0, 0.0]]}}}
    with pytest.raises(ConfigError) as caught:
        convert_text(
            TINY, output={"project": tmp_path / "p"}, passes=passes, without=["friction-states"]
        )
    assert caught.value.code == "project-states"
