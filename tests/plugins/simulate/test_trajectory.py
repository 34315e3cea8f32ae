"""The forces that made a motion are found again from the motion, with loops closed."""

from pathlib import Path

import numpy as np
import pytest

from support.loops import FOLLOWS, FREE, arm, four_bar, made
from urdf2mbs import ConversionError, load_equations
from urdf2mbs.mbs.model import BASE
from urdf2mbs_simulate.compiler import compiler
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn, MbsInvdyn, MbsSolvekin

FORCES = "def user_JointForces(mbs_data, tsim):\n    mbs_data.Qq[1:] = 0.0\n"
PUSHED = f"{FORCES}    mbs_data.Qq[1] = 2.0 + tsim\n"
#: Newton's method takes its last step where loops are closed to 1e-9.
EXACT = 1e-8


def moved(file: Path) -> tuple[np.ndarray, dict[str, str]]:
    """Return the forces of a motion, and the files of the motion of a model without them."""
    user = file.parent.parent / "userfctR" / "user_JointForces.py"
    user.parent.mkdir()
    user.write_text(PUSHED)
    dirdyn = MbsDirdyn(MbsData(file))
    dirdyn.set_options(tf=0.3, integrator="DOP853", rtoler=1e-11, atoler=1e-12, language="python")
    results = dirdyn.run()
    user.write_text(FORCES)
    folder = file.parent.parent / "resultsR"
    files = {
        f"trajectory{name}name": str(folder / f"dirdyn_{name}.res") for name in ("q", "qd", "qdd")
    }
    return results.Qq, files


@pytest.mark.parametrize(
    "language",
    [
        "python",
        pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
    ],
)
@pytest.mark.parametrize("loop", [False, True])
def test_forces_are_found_again(tmp_path: Path, loop: bool, language: str) -> None:
    if loop:
        file = four_bar(tmp_path, [FREE, FOLLOWS, FOLLOWS], 1.0)
    else:
        two = arm("two", "one", ("R1", 0.3, FREE), at="end")
        file = made(tmp_path, arm("one", BASE, ("R2", 0.4, FREE), end=(0.0, 0.0, -0.5)), two)
    forces, files = moved(file)
    data = MbsData(file)
    invdyn = MbsInvdyn(data)
    invdyn.set_options(tf=0.3, dt=0.01, language=language, **files)
    results = invdyn.run()
    assert np.ptp(results.q[:, 1]) > 0.1
    assert np.abs(results.Qa[:, 1] - forces[:, 1]).max() < EXACT
    assert np.abs(results.Qa[:, 2:]).max() < EXACT
    written = np.loadtxt(file.parent.parent / "resultsR" / "invdyn_Qa.res")
    assert np.array_equal(written, results.Qa)
    assert np.array_equal(results.columns()["Qa." + results.joints[0]], results.Qa[:, 1])
    if not loop:
        robot = load_equations(file, language="python")
        tau = [robot.inverse_dynamics(*(x[9, 1:] for x in (results.q, results.qd, results.qdd)))]
        assert np.abs(tau - results.Qa[9, 1:]).max() < EXACT


def test_loops_are_closed_along_a_motion_of_one_joint(tmp_path: Path) -> None:
    """The followers' columns are zeros; slopes are those of a spline."""
    file = four_bar(tmp_path, [FREE, FOLLOWS, FOLLOWS], 1.0)
    time = np.linspace(0.0, 1.0, 101)
    q = np.zeros((101, 4))
    q[:, 0], q[:, 1] = time, 0.3 + 0.5 * time**3
    np.savetxt(tmp_path / "q.res", q)
    solvekin = MbsSolvekin(MbsData(file))
    solvekin.set_options(
        trajectoryqname=str(tmp_path / "q.res"), tf=1.0, dt=0.001, save2file=0, language="python"
    )
    results = solvekin.run()
    assert results.qdd[:, 1] == pytest.approx(3.0 * results.time, abs=1e-9)
    for values, slopes in ((results.q, results.qd), (results.qd, results.qdd)):
        by_differences = (values[2:, 1:] - values[:-2, 1:]) / 0.002
        assert np.abs(by_differences - slopes[1:-1, 1:]).max() < 1e-4


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0 0.1\n1 two\n", ":2: .*could not convert string to float: 'two'"),
        ("0 0.1\n1\n", ":2: .*a time and 1 numbers, one for each joint"),
        ("0 0.1\n1 nan\n", ":2: .*a time and 1 numbers, one for each joint"),
        ("0 0.1\n\n0 0.2\n", ":3: .*time is not after"),
        ("", "it has 0 rows"),
        (None, "cannot be read: No such file"),
    ],
)
def test_a_file_that_is_no_motion_is_named_with_its_line(
    tmp_path: Path, text: str | None, said: str
) -> None:
    file = tmp_path / "q.res"
    if text is not None:
        file.write_text(text)
    solvekin = MbsSolvekin(MbsData(made(tmp_path, arm("bob", BASE, ("R2", 0.0, FREE)))))
    solvekin.set_options(trajectoryqname=str(file), tf=1.0)
    with pytest.raises(ConversionError, match=said) as caught:
        solvekin.run()
    assert caught.value.file == str(file)


def test_user_functions_of_inverse_dynamics_are_called(tmp_path: Path) -> None:
    model = made(tmp_path, arm("bob", BASE, ("R2", 0.0, FREE)))
    user = model.parent.parent / "userfctR" / "user_invdyn.py"
    user.parent.mkdir()
    user.write_text(
        "".join(
            f"def user_invdyn_{when}(mbs_data, mbs_invdyn):\n"
            f"    mbs_data.set_output(mbs_data.Qa[1], '{when}')\n"
            for when in ("init", "loop", "finish")
        )
    )
    (tmp_path / "q.res").write_text("0 0\n1 1\n2 2\n")
    invdyn = MbsInvdyn(MbsData(model))
    invdyn.set_options(trajectoryqname=str(tmp_path / "q.res"), tf=1.0, dt=0.1, language="python")
    results = invdyn.run()
    assert np.array_equal(results.outputs["loop"], results.Qa)
    assert len(results.outputs["init"]) == len(results.outputs["finish"]) == 1


def test_a_motion_that_the_actuated_joints_cannot_make_is_named(tmp_path: Path) -> None:
    file = four_bar(tmp_path, [FREE, FOLLOWS, FOLLOWS], 1.0)
    two = made(tmp_path, arm("bob", BASE, ("R2", 0.0, FREE), ("R1", 0.0, FREE)))
    _, files = moved(two)
    data = MbsData(two)
    data.set_qa(2)
    invdyn = MbsInvdyn(data)
    invdyn.set_options(tf=0.3, dt=0.1, language="python", **files)
    with pytest.raises(ConversionError, match="cannot move 'bob_0'") as error:
        invdyn.run()
    assert error.value.code == "not-actuated"
    invdyn.set_options(tf=9.0)
    with pytest.raises(ConversionError, match="no motion from 0 s to 9 s"):
        invdyn.run()
    with pytest.raises(ConversionError, match="trajectoryqname"):
        MbsInvdyn(MbsData(file)).run()
