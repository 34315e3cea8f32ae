"""A base passes the angle at which its three angles have no rates."""

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.project_robots import BOX
from support.standin import make
from urdf2mbs.mbs.model import Connection
from urdf2mbs.mbs.reader import read_mbs_file
from urdf2mbs.mbs.writer import write
from urdf2mbs_simulate.c_code import TURNED_NOTE, can_turn
from urdf2mbs_simulate.model_code import RowCounts
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

in_c = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
pytestmark = in_c
#: The languages of the project, and of the run.
LANGUAGES = pytest.mark.parametrize(
    ("written", "language"), [("c", "c"), ("python", "c"), ("python", "python")]
)
MOMENTS = np.diag([0.02, 0.03, 0.04])


def compute_rotation(q: Any) -> Any:
    """From the axes of a body behind three joints R1, R2, R3 (rad) to those before them."""
    (a, b, c), (u, v, w) = np.cos(q), np.sin(q)
    return np.array(
        [
            [b * c, -b * w, v],
            [a * w + u * v * c, a * c - u * v * w, -u * b],
            [u * w - a * v * c, u * c + a * v * w, a * b],
        ]
    )


def compute_rate_matrix(q: Any) -> Any:
    """Return the angular velocity by the rates of the angles, in columns."""
    (a, b, _), (u, v, _) = np.cos(q), np.sin(q)
    return np.array([[1.0, 0.0, v], [0.0, a, -u * b], [0.0, u, a * b]])


def thrown(project: Path, q: Any, qd: Any, time: float, language: str, **options: Any) -> Any:
    data = MbsData(project / "dataR" / "robot.mbs")
    data.q[1:], data.qd[1:] = q, qd
    data.set_qdriven(options.pop("driven", []))
    data._run.pushes = options.pop("pushes", [])
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(tf=time, language=language, save2file=0, **options)
    results = dirdyn.run()
    assert np.isfinite(results.q).all()
    return results


@pytest.mark.parametrize(
    ("written", "language", "method"),
    [("c", "c", None), ("c", "c", "DOP853"), ("python", "c", None), ("python", "python", None)],
)
def test_a_body_that_tumbles_keeps_its_momentum(
    tmp_path: Path, written: str, language: str, method: str | None
) -> None:
    """Results are in the model's own axes, whatever the axes in which it was computed."""
    project = make(tmp_path, BOX, base="floating", language=written)
    rates, exact = [1.0, 2.0, 5.0, 0.4, 6.0, 0.7], {"rtoler": 1e-9, "atoler": 1e-10}
    results = thrown(project, [0.0] * 6, rates, 1.0, language, integrator=method, **exact)
    angles, speeds = results.q[:, 4:7], results.qd[:, 4:7]
    assert np.abs(angles[:, 1]).max() > 1.4
    first = MOMENTS @ compute_rate_matrix(angles[0]) @ speeds[0]
    for q, qd in zip(angles, speeds, strict=True):
        if abs(np.cos(q[1])) > 1e-2:
            turned = compute_rotation(q)
            momentum = turned @ MOMENTS @ turned.T @ compute_rate_matrix(q) @ qd
            assert momentum == pytest.approx(first, abs=1e-6)
    assert results.q[-1, 1:4] == pytest.approx([1.0, 2.0, 5.0 - 9.81 / 2], abs=1e-7)
    assert results.data._run.notes == [TURNED_NOTE]
    assert np.abs(np.diff(results.q[:, 1:4], axis=0)).max() < 0.06


@LANGUAGES
def test_a_box_that_turns_over_ten_times_has_gone_on(
    tmp_path: Path, written: str, language: str
) -> None:
    """Its second angle is not wrapped, and the first and third stay."""
    project = make(tmp_path, BOX, base="floating", language=written, gravity=[0, 0, 0])
    results = thrown(project, [0.0] * 6, [0.0, 0.0, 0.0, 0.0, 20 * np.pi, 0.0], 1.0, language)
    assert results.q[-1, 5] == pytest.approx(20 * np.pi, abs=1e-4)
    assert np.abs(results.q[:, [4, 6]]).max() < 1e-4


@LANGUAGES
def test_a_box_lies_on_its_side_at_the_singular_angle(
    tmp_path: Path, written: str, language: str
) -> None:
    """It is pushed there, slides as Coulomb says, and rests."""
    from urdf2mbs_simulate.push import Push

    passes = {"contacts": {"links": ["*"], "friction": 0.5, "depth": 1e-4}}
    project = make(tmp_path, BOX, base="floating", language=written, passes=passes)
    start = [0.0, 0.0, 0.15, 0.0, np.pi / 2, 0.0]
    push = Push("box", (0.0, 19.62, 0.0), 0.5, 0.7)
    results = thrown(project, start, [0.0] * 6, 1.5, language, pushes=[push])
    assert results.q[-1, 5] == pytest.approx(np.pi / 2, abs=1e-3)
    assert np.abs(results.qd[-1, 1:4]).max() < 1e-6
    # it is pushed with twice the friction, and goes on as far as it was pushed
    assert results.q[-1, 1:3] == pytest.approx([0.0, 4.905 * 0.2**2], abs=5e-3)
    weight = sum(rows[-1, :3] for rows in results.external.values())
    assert weight == pytest.approx([0.0, 0.0, 19.62], abs=1e-3)


@in_c
def test_a_step_that_is_refused_does_not_turn_what_is_shown(tmp_path: Path) -> None:
    """It may lead anywhere, such as a whole turn further."""
    passes = {"contacts": {"links": ["*"]}}
    project = make(tmp_path, BOX, base="floating", language="c", passes=passes)
    for height in np.linspace(0.4, 1.4, 11):
        start = [0.0, 0.0, height, 0.0, -np.pi / 2, 0.0]
        long = {"dt0": 0.5, "dt_max": 1.0, "framerate": 1.0}
        results = thrown(project, start, [0.0, 0.0, 0.0, 0.1, 0.1, 0.1], 3.0, "c", **long)
        assert np.abs(results.q[:, 5]).max() < 4.0


@in_c
def test_two_bodies_have_each_their_own_force(tmp_path: Path) -> None:
    """Two boxes that hang together lie on their sides."""
    second = BOX[BOX.index("<link") : BOX.index("</robot>")].replace("box", "lid", 1)
    second = second.replace('<link name="box"', '<link name="lid"')
    hinge = '<joint name="hinge" type="prismatic"><parent link="box"/><child link="lid"/>'
    hinge += '<origin xyz="0 0.5 0"/><axis xyz="1 0 0"/><limit effort="1" velocity="1"/></joint>'
    text = BOX.replace("</robot>", f"{second}{hinge}</robot>")
    passes = {"contacts": {"links": ["*"]}, "posture": {"hold": {}}}
    project = make(tmp_path, text, base="floating", language="c", passes=passes)
    start = [0.0, 0.0, 0.3, 0.0, np.pi / 2, 0.0, 0.0]
    results = thrown(project, start, [0.0] * 7, 1.5, "c")
    each = [rows[-1, 2] for rows in results.external.values()]
    assert each == pytest.approx([19.62, 19.62], rel=1e-3)


WATCH = {
    "python": """
    found = robot.sensor(mbs_data, "box")
    mbs_data.set_output(max(abs(found.OMP[1:])), "gain")
    mbs_data.set_output(mbs_data.q[5], "angle")""",
    "c": """
    MbsSensor *sensor = mbs_dd->mbs_aux->psens;
    mbs_sensor(sensor, mbs_data, 1);
    for (int i = 1; i <= 3; i++)
        set_output(sensor->OMP[i], "gain");
    set_output(mbs_data->q[5], "angle");""",
}
CHECK = {"python": "    robot.check_step(mbs_data)", "c": "    robot_check_step(mbs_data);"}


@LANGUAGES
def test_user_functions_see_the_base_in_its_own_axes(
    tmp_path: Path, written: str, language: str
) -> None:
    """A ball that spins has no gain of spin, which follows from q, qd and qdd."""
    ball = BOX.replace("0.03", "0.02").replace("0.04", "0.02")
    passes = {"sensors": {"links": ["box"]}}
    project = make(tmp_path, ball, base="floating", language=written, passes=passes)
    file = project / "userfctR" / f"user_dirdyn.{'py' if written == 'python' else 'c'}"
    check = CHECK[written]
    assert check in file.read_text()
    file.write_text(file.read_text().replace(check, check + WATCH[written]))
    results = thrown(project, [0.0] * 6, [1.0, 2.0, 5.0, 0.4, 6.0, 0.7], 1.0, language, dt_max=0.01)
    gain, angle = (results.outputs[name] for name in ("gain", "angle"))
    assert np.abs(gain[:, 1]).max() < 1e-6
    assert angle[-1, 1] == pytest.approx(results.q[-1, 5], abs=1e-9)
    assert angle[:, 1].max() > 1.4
    assert np.abs(np.diff(angle[:, 1])).max() < 0.3


#: What stands first in user functions in Python and in C.
LOOK = {
    "user_DrivenJoints": ("    mbs_data.q[7] = mbs_data.q[5]", "mbs_data->q[7] = mbs_data->q[5];"),
    "user_LinkForces": (
        '    mbs_data.set_output(mbs_data.q[5] - 6 * tsim, "link")',
        'set_output(mbs_data->q[5] - 6 * tsim, "link");',
    ),
    "user_Link3DForces": (
        '    mbs_data.set_output(mbs_data.q[5] - 6 * tsim, "link3D")\n'
        "    return mbs_data.l3DWr[ixF]",
        'set_output(mbs_data->q[5] - 6 * tsim, "link3D");',
    ),
}


def with_lid(tmp_path: Path, written: str, end: str | None) -> Path:
    """Make a box with a lid that turns about its middle, and links of two kinds to the lid."""
    lid = BOX[BOX.index("<link") : BOX.index("</robot>")].replace(
        'link name="box"', 'link name="lid"'
    )
    hinge = '<joint name="hinge" type="continuous"><parent link="box"/><child link="lid"/>'
    hinge += '<axis xyz="0 1 0"/></joint>'
    text = BOX.replace("</robot>", f"{lid}{hinge}</robot>")
    project = make(tmp_path, text, base="floating", language=written, gravity=[0, 0, 0])
    file = project / "dataR" / "robot.mbs"
    mbs = read_mbs_file(file)
    mbs.links += [Connection(kind, kind, (end, None), ("lid", None)) for kind in ("link", "link3D")]
    file.write_bytes(write(mbs))
    return project


@LANGUAGES
def test_drives_and_links_see_the_base_in_its_own_axes(
    tmp_path: Path, written: str, language: str
) -> None:
    project = with_lid(tmp_path, written, "box")
    for name, looks in LOOK.items():
        file = project / "userfctR" / f"{name}.{'py' if written == 'python' else 'c'}"
        look = looks[written == "c"]
        text = re.sub(
            r"(?m)^(def .*|{)$", lambda head, look=look: f"{head[0]}\n{look}", file.read_text()
        )
        file.write_text(text)
    rates = [0.0, 0.0, 0.0, 0.0, 6.0, 0.0, 0.0]
    results = thrown(project, [0.0] * 7, rates, 1.0, language, driven=7, dt_max=0.01)
    assert results.data._run.notes == [TURNED_NOTE]
    assert results.q[:, 5] == pytest.approx(6.0 * results.time, abs=1e-4)
    assert results.q[1:, 7] == pytest.approx(results.q[1:, 5], abs=1e-9)
    for name in ("link", "link3D"):
        assert results.outputs[name][:, 1] == pytest.approx(0.0, abs=1e-4)


def test_a_base_that_a_link_ties_to_the_ground_keeps_its_axes(tmp_path: Path) -> None:
    data = [MbsData(with_lid(tmp_path, "python", end) / "dataR/robot.mbs") for end in ("box", None)]
    assert [can_turn(model_data, RowCounts(0, 0)) for model_data in data] == [True, False]


@LANGUAGES
def test_gravity_is_that_of_the_data_in_all_directions(
    tmp_path: Path, written: str, language: str
) -> None:
    """Also where user code changes it, while the simulation runs."""
    project = make(tmp_path, BOX, base="floating", language=written)
    file = project / "userfctR" / f"user_dirdyn.{'py' if written == 'python' else 'c'}"
    check, word = CHECK[written], "mbs_data." if written == "python" else "mbs_data->"
    mark = check if written == "c" else f"{check}\n"
    change = f"    {word}g[2] = -3.0{';' * (written == 'c')}\n"
    file.write_text(file.read_text().replace(mark, f"{mark}\n{change}"))
    data = MbsData(project / "dataR" / "robot.mbs")
    data.g[1] = 2.0
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(tf=1.0, language=language, save2file=0, dt_max=1e-3)
    results = dirdyn.run()
    assert results.q[-1, 1:4] == pytest.approx([1.0, -1.5, -9.81 / 2], abs=5e-3)
