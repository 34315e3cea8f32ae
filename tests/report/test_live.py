"""The motion that the page computes: the same numbers as in Python, and a mouse that pulls."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from report.shown import CONFIGS, run

from urdf2mbs.disk.output import write
from urdf2mbs.report.live import NotLive, live
from urdf2mbs.report.page import make_of_model
from urdf2mbs.runtime.data import MbsData
from urdf2mbs.runtime.python_code import PythonCode, loaded

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

ROLLER = (
    '<robot name="roller"><link name="wheel"><inertial><mass value="1"/><inertia ixx="0.01" '
    'iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
    '<collision><origin rpy="1 0 0.2"/><geometry><cylinder radius="0.3" length="0.1"/></geometry>'
    '</collision><collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.3"/></geometry>'
    "</collision></link></robot>"
)
SPRING = (
    '<gazebo reference="elbow"><springStiffness>2</springStiffness>'
    "<springReference>0.3</springReference></gazebo>"
)
#: Robots with all that the page computes: contacts, stops, friction and a controller; followers
#: and springs; loops; a driven joint.
STANDS = {
    "contacts": {"links": ["left_foot", "right_foot"]},
    "posture": {"hold": {"frequency": 10, "damping_ratio": 0.3}},
    "forces": {
        "wrenches": {"wind": {"link": "chest", "force": [3, 0, 0], "torque": [0, 0, 1]}},
        "springs": {
            "band": {
                "ends": [{"link": "left_foot"}, {"link": "right_foot", "at": [0, 0, 0.1]}],
                "stiffness": 50, "damping": 2,
            }
        },
    },
}  # fmt: skip
ROBOTS: dict[str, tuple[str, dict[str, Any]]] = {
    "biped": ("biped.urdf.xacro", STANDS),
    "arm": ("arm.urdf.xacro", {"posture": {"hold": {"frequency": 5}}}),
    "driven": ("arm.urdf.xacro", {"mimic": {"joints": {"*": "driven"}}}),
    "lamp": ("lamp.urdf", {}),
    "roller": ("roller.urdf", {"contacts": {"roll": ["wheel"]}}),
}


def project(name: str, folder: Path) -> MbsData:
    robot, passes = ROBOTS[name]
    output = {"project": str(folder), "language": ["python", "c"]}
    source = CONFIGS / robot
    if name == "roller":
        source = folder.with_name(robot)
        source.write_text(ROLLER)
    if name == "arm":
        source = folder.with_name(robot)
        source.write_text((CONFIGS / robot).read_text().replace("</robot>", f"{SPRING}</robot>"))
    conversion = run(source, folder, passes=passes, output=output)
    assert conversion.rejected is None
    write(conversion)
    return MbsData(conversion.settings.output)


def open_live(browser: Browser, folder: Path, data: MbsData) -> Page:
    file = folder / "live.html"
    file.write_bytes(make_of_model(data.mbs, data.mbs_file, live(data)).data)
    page = browser.new_page(viewport={"width": 500, "height": 500})
    page.goto(file.as_uri())
    page.evaluate("urdf2mbs.ready")
    return page


def close_loops(data: MbsData) -> None:
    """Close them to the last digits: Newton's method may end elsewhere on the page."""
    rows = data.nqv if data.mbs.cuts else 0
    for _ in range(5 if rows else 0):
        h, jac = np.zeros(rows + 1), np.zeros((rows + 1, data.njoint + 1))
        data.mbs_cons_hJ(h, jac, data)
        data.q[data.qv[1:]] -= np.linalg.solve(jac[1:, data.qv[1:]], h[1:])


@pytest.mark.parametrize("name", ROBOTS)
def test_the_page_computes_what_python_computes(
    browser: Browser, tmp_path: Path, name: str
) -> None:
    data = project(name, tmp_path / name)
    page = open_live(browser, tmp_path, data)
    random = np.random.default_rng(7)
    size, kept = data.njoint + 1, ("q", "qd", "qdd", "uxd", "Qq", "SWr")
    states, wanted = [], []
    with loaded(data):
        code = PythonCode(data)
        for _ in range(200):
            data.q[1:] = data.q0[1:] + 0.1 * random.standard_normal(size - 1)
            data.qd[1:] = random.standard_normal(size - 1)
            driven = data.qc[1:]
            data.q[driven], data.qd[driven], data.qdd[:] = data.q0[driven], 0.0, 0.0
            close_loops(data)
            data.ux[1:] = 1e-3 * random.standard_normal(data.Nux)
            states.append([getattr(data, array).tolist() for array in ("q", "qd", "ux")])
            code.guess = data.q[code.dependent]
            state = data.q[code.free], data.qd[code.free], data.ux[1:]
            found = code.accelerate(0.0, np.concatenate(state))
            assert np.isfinite(found).all()
            wanted.append([getattr(data, array).copy() for array in kept])
    computed = page.evaluate(
        """([states, kept]) => states.map(([q, qd, ux]) => {
          const {s} = urdf2mbs.live();
          s.q.set(q);
          s.qd.set(qd);
          s.ux.set(ux);
          s.qdd.fill(0);
          if (!s.accelerate()) throw new Error("the loops cannot be closed");
          return kept.map((name) => name === "SWr" ? s.SWr.map((row) => [...row]) : [...s[name]]);
        })""",
        [states, kept],
    )
    off = page.evaluate(
        """() => {
          const {s} = urdf2mbs.live(), {dependent = []} = equations, before = [...s.q];
          dependent.forEach((k) => { s.q[k] += 1e-3; });
          s.accelerate();
          return Math.max(...s.q.map((x, k) => Math.abs(x - before[k])));
        }"""
    )
    assert off < 1e-8  # it closes the loops
    page.close()
    worst = dict.fromkeys(kept, 0.0)
    for there, here in zip(computed, wanted, strict=True):
        for array, ours, theirs in zip(kept, here, there, strict=True):
            off = np.abs(np.array(theirs) - ours).max()
            assert off <= 1e-12 * max(1.0, np.abs(ours).max()), (array, off)
            worst[array] = max(worst[array], np.abs(ours).max())
    assert worst["qdd"] > 1.0
    assert (worst["SWr"] > 100.0) == (name in ("biped", "roller"))  # it touches the ground


@pytest.mark.slow
def test_a_robot_is_pulled_let_go_dropped_and_recorded(browser: Browser, tmp_path: Path) -> None:
    data = project("biped", tmp_path / "biped")
    page = open_live(browser, tmp_path, data)
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))

    def wait(condition: str) -> None:
        page.evaluate(f"""new Promise((done, fail) => {{
            const {{s}} = urdf2mbs.live(), end = s.tsim + 5;
            const look = () => {condition} ? done()
                : s.tsim > end ? fail(new Error("not within 5 s")) : requestAnimationFrame(look);
            look();
        }})""")

    page.click("#record")
    page.click("#live-run")
    wait("s.tsim > 0.05")
    assert abs(page.evaluate("urdf2mbs.live().s.q[3]") - data.q0[3]) < 0.01
    view = page.locator("#view canvas")
    view.scroll_into_view_if_needed()
    box = view.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + 0.4 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y)
    wait("s.pull && Math.hypot(...s.pull[1]) > 1")
    page.mouse.up()
    wait("!s.pull")
    page.uncheck("#live-hold")
    wait(f"s.q[3] < {data.q0[3] - 0.1}")
    page.click("#live-drop")
    wait(f"s.q[3] > {data.q0[3] + 0.2}")
    with page.expect_download() as download:
        page.click("#record")
    assert download.value.suggested_filename == "biped.webm"
    assert download.value.path().read_bytes()[:4] == b"\x1aE\xdf\xa3"  # the mark of a WebM file
    assert not errors
    page.close()


def test_code_of_others_is_in_no_page(tmp_path: Path) -> None:
    data = project("arm", tmp_path / "arm")
    values, script = live(data)
    assert values["step"] > 0.0
    assert "equations.dirdyna" in script
    edited = tmp_path / "arm/userfctR/user_JointForces.py"
    edited.write_text(edited.read_text("utf-8") + "# mine\n", "utf-8")
    with pytest.raises(NotLive, match=r"user_JointForces\.py' is not as urdf2mbs wrote it"):
        live(data)
