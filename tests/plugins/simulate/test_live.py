"""The live robot of a page: the same motion as that of ``simulate``, pulled, dropped and held."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from support.folders import CONFIGS
from urdf2mbs.cli import main
from urdf2mbs_report import page as report
from urdf2mbs_simulate import live
from urdf2mbs_simulate.dirdyn import MbsDirdyn
from urdf2mbs_simulate.results import Results
from urdf2mbs_simulate.runtime import MbsData

if TYPE_CHECKING:
    from playwright.sync_api import Browser

BIPED = CONFIGS / "biped.urdf.xacro"
STEP = 1e-3
#: A gripper with a follower, which a constraint rules.
GRIPPER = """<robot name="gripper">
  <link name="world"/>
  <joint name="bolt" type="fixed"><parent link="world"/><child link="palm"/></joint>
  <link name="palm"><inertial><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="left"><inertial><origin xyz="0.1 0 0"/><mass value="0.2"/>
    <inertia ixx="0.001" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right"><inertial><origin xyz="0.1 0 0"/><mass value="0.3"/>
    <inertia ixx="0.001" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="lead" type="continuous"><origin xyz="0 0.05 0"/>
    <parent link="palm"/><child link="left"/><axis xyz="0 1 0"/></joint>
  <joint name="follow" type="continuous"><origin xyz="0 -0.05 0"/>
    <parent link="palm"/><child link="right"/><axis xyz="0 1 0"/>
    <mimic joint="lead" multiplier="-0.5" offset="0.1"/></joint>
</robot>"""
#: What a page does, in Node: 50 frames of 10 ms, of which each is a row of q.
NODE = """
const fs = require("fs"), [places, count] = JSON.parse(fs.readFileSync("places.json"));
const system = new Proxy({}, {get: () => () => 52});
const module = new WebAssembly.Module(fs.readFileSync("live.wasm"));
const robot = new WebAssembly.Instance(module, {wasi_snapshot_preview1: system}).exports;
const bytes = fs.readFileSync("numbers"), packed = new Float64Array(new Uint8Array(bytes).buffer);
robot._initialize();
const at = robot.room(packed.length), rows = [];
new Float64Array(robot.memory.buffer, at).set(packed);
const page = robot.begin(at);
if (!page || robot.go(page, 0, 0) !== 0) throw new Error("it cannot start");
for (let frame = 0; frame <= 50; frame++) {
  for (let time = -1; time < frame / 100;) {
    time = robot.go(page, frame / 100, 7);
    if (time < 0) throw new Error("it failed");
  }
  rows.push([...new Float64Array(robot.memory.buffer, at + 8 * (places.q + 1), count)]);
}
console.log(JSON.stringify(rows));
"""

#: Until 0.3 s have passed; Playwright's own waiting calls eval, which the page forbids.
WAIT = """new Promise((done) => requestAnimationFrame(function look() {
  if (urdf2mbs.live.getTime() > 0.3) done(); else requestAnimationFrame(look);
}))"""


@pytest.fixture
def compiler(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiling C's own library takes half a minute: it is kept for all workers."""
    pytest.importorskip("ziglang", reason="no compiler for a page: pip install ziglang")
    folder = tmp_path_factory.getbasetemp().parent / "zig"
    monkeypatch.setenv("ZIG_GLOBAL_CACHE_DIR", str(folder))


def at_fixed_steps(project: Path, time: float = 0.5) -> Results:
    dirdyn = MbsDirdyn(MbsData(next((project / "dataR").glob("*.mbs"))))
    dirdyn.set_options(
        tf=time, dt0=STEP, dt_max=STEP, rtoler=1e9, atoler=1e9, save2file=0, language="c"
    )
    return dirdyn.run()


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("node") is None, reason="no Node")
@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("name", ["biped", "gripper"])
def test_it_moves_as_simulate_says(name: str, here: Path) -> None:
    source = BIPED
    if name == "gripper":
        source = here / "gripper.urdf"
        source.write_text(GRIPPER)
    assert main(["simulate", str(source), "-o", name, "--time", "0.01"]) == 0
    results = at_fixed_steps(here / name)
    made = live.make_live(results, step=STEP)
    assert not isinstance(made, str), made
    Path("live.wasm").write_bytes(made.code)
    Path("numbers").write_bytes(made.numbers.tobytes())
    Path("places.json").write_text(json.dumps([made.data["places"], results.data.njoint]))
    done = subprocess.run(["node", "-e", NODE], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = np.array(json.loads(done.stdout))
    assert np.abs(results.q[-1, 1:] - results.q[0, 1:]).max() > 1e-4
    np.testing.assert_allclose(rows, results.q[:, 1:], rtol=0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.usefixtures("compiler")
def test_a_page_drops_and_pulls_it(here: Path, browser: Browser) -> None:
    assert main(["simulate", str(BIPED), "-o", "biped", "--time", "0.01"]) == 0
    file, call = here / "biped/userfctR/user_dirdyn.c", "_check_step(mbs_data);"
    stop = "if (mbs_data->tsim > 5.0) mbs_data->flag_stop = 1;"
    file.write_text(file.read_text().replace(call, f"{call} {stop}"))
    assert main(["simulate", "biped", "-o", "biped.html", "--time", "0.1"]) == 0
    page, events = browser.new_page(viewport={"width": 1100, "height": 1200}), []
    page.on("pageerror", lambda error: events.append(str(error)))
    page.on("request", lambda request: events.append(request.url))
    page.goto((here / "biped.html").as_uri())
    page.evaluate("urdf2mbs.ready")

    page.get_by_role("button", name="Drop on its back").click()
    page.evaluate("urdf2mbs.live.setRunning(false)")
    page.evaluate("urdf2mbs.live.advance(3, 1e5)")
    q = page.evaluate("[...urdf2mbs.live.getJointRow('q'), urdf2mbs.live.getTime()]")
    assert q[-1] == 3.0
    assert 0.02 < q[3] < 0.1, "it lands, and stays above the ground"
    assert abs(abs(q[5]) - np.pi / 2) < 0.2
    assert page.evaluate("urdf2mbs.seen('mbs', 'pelvis')[2][3]") == pytest.approx(q[3])

    # the user's own code ends a run, and Reset begins again
    assert page.evaluate("urdf2mbs.live.advance(6, 1e5)") is False
    assert "user code has ended the run" in page.locator("#live-message").inner_text()
    page.get_by_role("button", name="Reset").click()
    assert page.evaluate("urdf2mbs.live.advance(0.01, 1e5)") is True
    page.get_by_label("Hold").uncheck()
    before = page.evaluate("[...urdf2mbs.live.getJointRow('q')]")
    box = page.locator("#view canvas").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + 0.4 * box["height"]
    page.get_by_role("button", name="Live").click()
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y, steps=3)
    assert page.locator("#picked b").inner_text() == "chest"
    page.evaluate(WAIT)
    page.mouse.up()
    page.evaluate("urdf2mbs.live.setRunning(false)")
    after = page.evaluate("[...urdf2mbs.live.getJointRow('q')]")
    assert np.abs(np.subtract(after, before)).max() > 1e-2

    # the page says why a run has ended, and the sentence stays
    page.evaluate("urdf2mbs.live.restart((q) => { q[7] = NaN; })")
    assert page.evaluate("urdf2mbs.live.advance(1, 1e5)") is False
    assert "no step is short enough" in page.locator("#live-message").inner_text()
    assert [event for event in events if not event.startswith(("file:", "data:", "blob:"))] == []
    page.close()


def test_the_terminal_says_how_to_get_a_live_robot(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setattr(live, "find_zig", lambda: None)
    assert main(["simulate", "tiny.urdf", "-o", "t", "--time", "0.01"]) == 0
    assert main(["simulate", "t", "-o", "t.html", "--time", "0.01"]) == 0
    assert "pip install ziglang" in capsys.readouterr().err
    text = Path("t.html").read_text()
    assert "pip install" not in text, "the page goes to others"
    assert "wasm-unsafe-eval" not in text


def test_user_functions_that_are_changed_in_python_alone_do_not_live(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live, "find_zig", lambda: "zig")
    assert main(["simulate", "tiny.urdf", "-o", "t", "--time", "0.01"]) == 0
    file = here / "t/userfctR/user_JointForces.py"
    file.write_text(file.read_text() + "mine = 1\n")
    results = at_fixed_steps(here / "t", 0.01)
    made = live.make_live(results)
    assert isinstance(made, str)
    assert "in Python" in made


def test_the_script_takes_what_the_modules_of_the_page_give() -> None:
    folder = Path(report.__file__).with_name("js")
    text = Path(live.__file__).with_name("live.js").read_text("utf-8")
    imports = re.findall(r'^import {(.*?)}\s+from "./(\w+).js";$', text, re.M | re.S)
    assert len(imports) == text.count("import ")
    for names, name in imports:
        module = (folder / f"{name}.js").read_text("utf-8")
        for export in re.split(r",\s+", names):
            assert re.search(rf"^export (?:async )?(?:const|let|function) {export}\b", module, re.M)
