"""Reports in a real browser: what differs, hostile names, choosing, print, marks, motion."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from support.build import SOLID, joint, link, robot
from support.folders import ROOT
from support.oracle.mbs import Evaluator
from support.oracle.multibody import rotation
from support.pages.opened import Open, Opened, open_report, wait_until
from support.pages.shown import EVIL, HOSTILE, SHOWN, data, edit, run
from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.output import write_files
from urdf2mbs.mbs.kinematics import compute_placement
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import TINY
from urdf2mbs_report.page import make_model_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.slow

DOCS = ROOT / "docs"


@pytest.fixture
def opened(browser: Browser, tmp_path: Path) -> Iterator[Open]:
    """Open pages for one test."""
    tabs: list[Opened] = []

    def open_(conversion: Conversion, *, init: str | None = None) -> Opened:
        tabs.append(open_report(browser, tmp_path, conversion, init))
        return tabs[-1]

    yield open_
    for tab in tabs:
        tab.page.close()


@pytest.fixture
def tiny_project(tmp_path: Path) -> Conversion:
    source = tmp_path / "tiny_project.urdf"
    source.write_text(TINY)
    return run(source, tmp_path / "p", base="fixed")


def test_what_differs_blinks(opened: Open, tiny_project: Conversion) -> None:
    edit(tiny_project, "<q>0.5</q>", "<q>0.6</q>")
    report = opened(tiny_project)
    agreement = report.ask("urdf2mbs.agreement()")
    assert "arm" in agreement["differing"]
    assert "body" not in agreement["differing"]
    assert "elsewhere or turned" in report.page.locator("#agreement").inner_text()
    lit = set()
    for _ in range(50):  # the page's own clock blinks, too: it may undo a step of ours
        lit.add(tuple(report.ask("urdf2mbs.lit('arm')")))
        report.ask("urdf2mbs.blink()")
        if len(lit) > 1:
            break
    assert lit == {("mbs",), ("urdf",)}


def test_a_shape_elsewhere_is_found(opened: Open, tiny_project: Conversion) -> None:
    edit(tiny_project, "(<cylinder>.*?<radius>0.03)", r"\g<1>1")
    agreement = opened(tiny_project).ask("urdf2mbs.agreement()")
    assert agreement["differing"] == []
    assert agreement["shapesDiffering"] == [
        ["mbs", "arm", "in form or place"],
        ["urdf", "arm", "in form or place"],
    ]


def test_followers_follow(
    opened: Open, tiny_project: Conversion, shared: Path, tmp_path: Path
) -> None:
    assert opened(tiny_project).page.locator("#mimic-label").is_hidden()
    source, _, packages = SHOWN["leo"]
    sim = source.with_name("leo_sim.urdf.xacro")
    report = opened(run(sim, tmp_path / "leo", packages))
    report.slide("rocker_L_joint", 0.2)
    assert report.position("rocker_R_joint") == 0.2
    follower = report.page.locator('input[type=range][data-joint="rocker_R_joint"]')
    assert follower.is_disabled()
    report.page.locator("#mimic").click()
    report.slide("rocker_L_joint", -0.1)
    assert report.position("rocker_R_joint") == 0.2


def test_planar_and_floating_joints(opened: Open, tmp_path: Path) -> None:
    source = tmp_path / "odd.urdf"
    source.write_text(
        robot(
            link("world"),
            link("a", SOLID),
            link("b", SOLID),
            joint("world", "a", "planar", xyz="1 2 3", rpy="0.1 0.2 0.3", axis="1 -2 0.5"),
            joint("a", "b", "floating", xyz="0 1 0", rpy="1.5707963 0 -0.7"),
        )
    )
    report = opened(run(source, tmp_path / "p"))
    for _ in range(3):
        for name in Evaluator(data(report.conversion)).moving:
            report.slide(name, Random(name).uniform(-1, 1))
        assert report.ask("urdf2mbs.agreement()")["largest"] < 1e-12


def test_hostile_names_do_nothing(opened: Open, tmp_path: Path) -> None:
    source = tmp_path / "evil.urdf"
    source.write_text(HOSTILE)
    report = opened(run(source, tmp_path / "p"))
    assert report.ask("window.hacked") is None
    assert report.messages == []
    assert EVIL in report.page.locator("#names").inner_text()
    assert report.page.locator("h1").inner_text() == EVIL


def test_without_webgl_all_else_works(opened: Open, tiny_project: Conversion) -> None:
    report = opened(tiny_project, init="HTMLCanvasElement.prototype.getContext = () => null;")
    assert "no WebGL" in report.page.locator("#view").inner_text()
    report.slide("shoulder", 0.5)
    poses = Evaluator(data(tiny_project)).positions({"shoulder": 0.5})
    np.testing.assert_allclose(report.pose("mbs", "arm"), poses.body("arm"), atol=1e-12)


def test_the_diagram_zooms_and_moves(opened: Open, tiny_project: Conversion) -> None:
    """The wheel scrolls the page; with Ctrl it zooms."""
    report = opened(tiny_project)
    svg = report.page.locator("#paper > svg")
    svg.scroll_into_view_if_needed()
    box = svg.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def read_view_box() -> list[float]:
        return [float(n) for n in (svg.get_attribute("viewBox") or "").split()]

    whole_box = read_view_box()
    report.page.mouse.move(x, y)
    before_wheel = report.ask("scrollY")
    report.page.mouse.wheel(0, -100)
    wait_until(report.page, f"scrollY < {before_wheel}")
    assert read_view_box() == whole_box
    y += before_wheel - report.ask("scrollY")
    report.page.keyboard.down("Control")
    report.page.mouse.wheel(0, -100)
    report.page.keyboard.up("Control")
    from playwright.sync_api import expect  # only where there is a browser

    expect(svg).not_to_have_attribute("viewBox", " ".join(f"{n:g}" for n in whole_box))
    assert read_view_box()[2] < whole_box[2]
    before = read_view_box()
    report.page.mouse.move(x, y)
    report.page.mouse.down()
    report.page.mouse.move(x + 60, y + 30, steps=3)
    report.page.mouse.up()
    assert read_view_box()[0] < before[0]
    assert read_view_box()[1] < before[1]
    report.page.locator("#diagram-fit").click()
    assert read_view_box() == whole_box


MARKED = """() => [...document.querySelectorAll(".selected")].map((one) => {
  const {body, joint, link, urdfJoint} = one.dataset;
  return `${one.className.baseVal ?? one.className}`.split(" ")[0] + " "
    + one.tagName.toLowerCase() + " " + (body ?? joint ?? link ?? urdfJoint);
})"""
JOINT = [
    '#joints tr[data-joint="shoulder"]',
    '#names tr[data-urdf-joint="shoulder"]',
    '#messages tr[data-urdf-joint="shoulder"]',
    '.slider[data-joint="shoulder"] .name',
    '#paper g.joint[data-joint="shoulder"] circle',
]
BODY = [
    '#bodies tr[data-body="arm"]',
    '#names tr[data-link="arm"]',
    '#tree [data-link="arm"]',
    '#paper g.body-name[data-body="arm"] text',
]


def test_what_is_chosen_is_marked_everywhere(opened: Open, tiny_project: Conversion) -> None:
    tiny_project.note("axis-aligned", "a message about it", joint="shoulder")
    report = opened(tiny_project)
    picked = report.page.locator("#picked")
    for click in JOINT:
        report.page.locator(click).first.click()
        marked = set(report.ask(MARKED))
        joint = {"body g arm", "joint g shoulder", "joint-label g shoulder", "slider div shoulder"}
        assert joint <= marked, click
        rows = {mark.split(" tr ")[1] for mark in marked if " tr " in mark}
        assert rows == {"shoulder", "arm"}, click
        assert not any("wrist" in mark or "body g body" in mark for mark in marked), click
        assert "q3 R3 shoulder" in picked.inner_text()
    report.page.locator("#as-links").click()
    for click in BODY:
        report.page.locator(click).first.click()
        marked_ = report.ask(MARKED)
        assert {"body g arm", "joint g shoulder", "joint g shoulder_origin_R2"} <= set(marked_)
        assert sum(mark.endswith(" tr arm") for mark in marked_) == 2, "as a body, and as a link"
        assert sum(mark.endswith(" div arm") for mark in marked_) == 1, "in the tree"
    report.page.locator('#paper g.body[data-body="body"] .box').click(position={"x": 5, "y": 5})
    assert picked.inner_text().startswith("body")
    report.page.locator(JOINT[0]).press("Enter")
    assert "joint g shoulder" in report.ask(MARKED)
    assert report.messages == []


def test_the_camera_turns_moves_and_zooms_and_a_click_chooses(
    opened: Open, tiny_project: Conversion
) -> None:
    report = opened(tiny_project)
    mouse, picked = report.page.mouse, report.page.locator("#picked")
    canvas = report.page.locator("#view canvas")
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    seen = [report.ask("urdf2mbs.picture()")]
    for button in ("left", "right"):
        mouse.move(x, y)
        mouse.down(button=button)
        mouse.move(x + 40, y + 20, steps=3)
        mouse.up(button=button)
        seen.append(report.ask("urdf2mbs.picture()"))
    assert len(set(seen)) == 3
    assert picked.inner_text() == ""
    report.page.locator("#fit").click()
    assert report.ask("urdf2mbs.picture()") == seen[1], "turned, and not moved"
    mouse.click(x, y + 0.08 * box["height"])  # the middle of the robot is below the picture's
    assert picked.inner_text() != ""
    assert report.messages == []


def test_the_panel_of_a_plain_robot(opened: Open, tmp_path: Path) -> None:
    """The tree has all links; the base's sliders come last; there are no switches for nothing."""
    source = tmp_path / "tiny_project.urdf"
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    source.write_text(TINY.replace("</link>", f"{box}</link>", 1))
    report = opened(run(source, tmp_path / "p", base="floating"))
    robot, page = report.conversion.robot, report.page
    sliders = page.locator("#sliders input[type=range]")
    joints = sliders.evaluate_all("sliders => sliders.map(slider => slider.dataset.joint)")
    of_base = [name.startswith("floating_base") for name in joints]
    assert of_base == sorted(of_base)
    assert 0 < sum(of_base) < len(of_base)
    page.locator("#as-links").click()
    assert page.locator("#sliders").is_hidden()
    tree = page.locator("#tree > div").evaluate_all("rows => rows.map(r => r.dataset.link)")
    assert tree == [robot.root(), *(joint.child for joint in robot.depth_first())]
    for kind in ("sensors", "contacts", "forces", "loops"):
        assert not page.locator(f"#show-{kind}").is_visible()
    without = report.ask("urdf2mbs.picture()")
    report.switch("show-collisions", True)
    assert report.ask("urdf2mbs.picture()") != without
    assert report.ask("urdf2mbs.agreement()")["shapesDiffering"] == []


def test_an_inertia_box_has_the_body_s_inertia(opened: Open, tmp_path: Path) -> None:
    """A solid box of 2 kg, 0.1 x 0.2 x 0.4 m, turned: its inertia box is the same box."""
    a, b, c = 0.1, 0.2, 0.4
    turn = rotation(np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0), 0.7)
    tensor = turn @ np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) @ turn.T / 6.0
    entries = ("xx", "xy", "xz", "yy", "yz", "zz")
    values = tensor[np.triu_indices(3)].tolist()
    text = " ".join(f'i{entry}="{value}"' for entry, value in zip(entries, values, strict=True))
    source = tmp_path / "box.urdf"
    source.write_text(
        f"""<robot name="box"><link name="l"><inertial><origin xyz="1 2 3"/><mass value="2"/>
        <inertia {text}/></inertial></link></robot>"""
    )
    report = opened(run(source, tmp_path / "p", base="floating"))
    corners = np.array(report.ask("urdf2mbs.inertiaCorners('l')")) - [1.0, 2.0, 3.0]
    expected = np.array([[x, y, z] for x in (-a, a) for y in (-b, b) for z in (-c, c)]) / 2 @ turn.T
    apart = np.linalg.norm(corners[:, None] - expected[None], axis=2)
    assert not apart.min(axis=1).max() > 1e-6
    assert not apart.min(axis=0).max() > 1e-6


def test_the_diagram_is_readable_in_the_dark(opened: Open, tiny_project: Conversion) -> None:
    """Its texts stand out from what is behind them: a contrast of 4.5 at least (axe skips SVG)."""
    report = opened(tiny_project)
    report.page.emulate_media(color_scheme="dark")
    contrasts = report.ask(
        """() => [...document.querySelectorAll("#paper text")].map((text) => {
          const light = (one) => getComputedStyle(one).fill.match(/[\\d.]+/g).slice(0, 3)
            .map((c) => c / 255).map((c) => c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
            .reduce((sum, c, k) => sum + c * [0.2126, 0.7152, 0.0722][k], 0);
          const behind = text.parentElement.querySelector(".box, .sheet");
          const ground = behind || document.querySelector("#paper .sheet");
          const [a, b] = [light(text), light(ground)].sort((x, y) => y - x);
          return (a + 0.05) / (b + 0.05);
        })"""
    )
    assert len(contrasts) > 5
    assert min(contrasts) >= 4.5


def test_on_paper_nothing_is_clipped(opened: Open, tiny_project: Conversion) -> None:
    report = opened(tiny_project)
    report.page.locator("#diagram-full").click()
    report.page.emulate_media(media="print")
    report.page.set_viewport_size({"width": 700, "height": 1000})  # A4 within its margins
    report.ask("window.dispatchEvent(new Event('beforeprint'))")
    clipped = report.ask(
        """() => [...document.querySelectorAll(".scroll, table, .view, .paper")].filter((one) =>
          one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).overflowX !== "visible"
          || one.getBoundingClientRect().right > innerWidth + 1).map((one) => one.className)"""
    )
    assert clipped == []
    assert report.page.locator("#view canvas").is_visible()
    assert report.page.locator(".sliders").is_hidden()
    full = report.ask("document.querySelector('#paper svg').getAttribute('viewBox')")
    report.ask("window.dispatchEvent(new Event('afterprint'))")
    assert full != report.ask("document.querySelector('#paper svg').getAttribute('viewBox')")
    blank = report.ask(
        """() => {
          const seen = document.querySelector("#view canvas");
          const copy = document.createElement("canvas");
          [copy.width, copy.height] = [seen.width, seen.height];
          const paper = copy.getContext("2d");
          paper.drawImage(seen, 0, 0);
          const {data} = paper.getImageData(0, 0, copy.width, copy.height);
          return data.every((value) => value === 0);
        }"""
    )
    assert not blank


CRANE = TINY.replace(
    "</robot>",
    link("cart", SOLID)
    + joint(
        "body",
        "cart",
        "prismatic",
        name="slider",
        xyz="0.2 0 0",
        axis="0 1 0",
    ).replace('lower="-1" upper="1"', 'lower="-0.2" upper="0.3"')
    + "</robot>",
)


def test_marks_stand_where_the_model_has_them(browser: Browser, tmp_path: Path) -> None:
    """Sensors, contacts, forces, both ends of a cut, and stops, also after a joint has moved."""
    source = tmp_path / "crane.urdf"
    source.write_text(CRANE)
    conversion = run(
        source,
        tmp_path / "crane",
        passes={
            "sensors": {"links": ["cart"]},
            "contacts": {"points": {"cart": [[0.1, 0, 0], [0.1, 0, 0.05]]}},
            "forces": {
                "wrenches": {"push": {"link": "cart", "at": [0, 0, 0.1], "force": [1, 0, 0]}}
            },
            "loops": {
                "cuts": {
                    "rope": {
                        "kind": "rod",
                        "ends": [{"link": "cart", "at": [0, 0.1, 0]}, {"link": "body"}],
                    }
                }
            },
        },
    )
    report = open_report(browser, tmp_path, conversion)
    report.switch("show-stops", True)
    assert report.ask("urdf2mbs.marks('contacts')") == [], "off at first"
    report.switch("show-contacts", True)
    (touching,) = report.ask("urdf2mbs.marks('contacts')")
    assert touching[2] == pytest.approx(0.0, abs=1e-9), "the other one is above the ground"
    report.page.locator('#bodies tr[data-body="cart"]').click()
    report.slide("slider", 0.25)
    cart, body = (report.pose("mbs", name) for name in ("cart", "body"))

    def transform(pose: Any, *xyz: float) -> Any:
        return (pose @ [*xyz, 1.0])[:3]

    for kind, xyz in (("sensors", (0, 0, 0)), ("contacts", (0.1, 0, 0)), ("forces", (0, 0, 0.1))):
        mark, *others = report.ask("(kind) => urdf2mbs.marks(kind)", kind)
        assert len(others) == (kind == "contacts"), "all of the body that is selected"
        assert np.allclose(mark, transform(cart, *xyz), rtol=0, atol=1e-6), kind
    (line,) = report.ask("urdf2mbs.ends()")
    expected = [*transform(cart, 0, 0.1, 0), *transform(body, 0, 0, 0)]
    assert np.allclose(line, expected, rtol=0, atol=1e-6)
    stops = {stop["joint"]: stop for stop in report.ask("urdf2mbs.stops()")}
    assert (stops["slider"]["low"], stops["slider"]["high"]) == (-0.2, 0.3)
    assert not stops["slider"]["beyond"]
    assert np.allclose(np.array(stops["slider"]["hand"])[:3, 3], cart[:3, 3], rtol=0, atol=1e-6)
    report.ask("urdf2mbs.set('slider', 0.3)")
    text = report.page.locator("#around").inner_text()
    for word in ("user model 'push'", "cart_contact", "rope", "q_max", "0.3"):
        assert word in text, word
    report.switch("show-contacts", False)
    assert report.ask("urdf2mbs.marks('contacts')") == []
    assert not report.messages
    report.page.close()


def test_a_simulated_project_plays(browser: Browser, tmp_path: Path) -> None:
    conversion = run(DOCS.parent / "configs" / "arm.urdf.xacro", tmp_path / "arm")
    write_files(conversion.files)
    model = read_mbs(data(conversion), "robot.mbs")
    joints = list(model.numbers())
    rows = [[0.02 * k, *(0.3 * k + 0.1 * j for j in range(len(joints)))] for k in range(6)]
    pushed = model.bodies[-1].name
    more = {"energy.kinetic": [2.0] * 6, "energy.potential": [7.0] * 6}
    more |= {f"push1.{pushed}.F{axis}": [0, 0, 0, 5, 5, 5] for axis in "xyz"}
    more |= {f"push1.{pushed}.d{axis}": [0.1] * 6 for axis in "xyz"}
    head = ["time", *(f"q.{j}" for j in joints), *more]
    lines = [
        [*row, *cells] for row, cells in zip(rows, zip(*more.values(), strict=True), strict=True)
    ]
    text = "\n".join(",".join(map(str, line)) for line in [head, *lines])
    results = tmp_path / "arm" / "resultsR"
    results.mkdir(exist_ok=True)
    (results / "dirdyn.csv").write_text(text + "\n", "utf-8")
    file = tmp_path / "motion.html"
    file.write_bytes(make_model_page(model, conversion.settings.output).data)
    page = browser.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(file.as_uri())
    page.evaluate("urdf2mbs.ready")
    assert page.locator("#player").is_visible()
    for row in (rows[1], rows[3], rows[5]):
        page.locator("#scrub").evaluate(
            "(s, t) => { s.value = t; s.dispatchEvent(new Event('input')); }", row[0]
        )
        poses = compute_placement(model, dict(zip(joints, row[1:], strict=True))).bodies
        for body in model.bodies:
            seen = np.array(page.evaluate("(name) => urdf2mbs.seen('mbs', name)", body.name))
            wanted = poses[body.name]
            np.testing.assert_allclose(seen[:3, :3].ravel(), wanted.rot, atol=1e-6)
            np.testing.assert_allclose(seen[:3, 3], wanted.xyz, atol=1e-6)
        # the push is an arrow from its point
        point = np.array(poses[pushed].rot).reshape(3, 3) @ np.full(3, 0.1) + poses[pushed].xyz
        arrows = page.evaluate("urdf2mbs.arrows()")
        np.testing.assert_allclose(arrows, [point] if row is not rows[1] else [], atol=1e-6)
    # a slider leaves the moment: its forces are gone
    moving = page.locator("#sliders .slider").first.get_attribute("data-joint")
    page.evaluate("(name) => urdf2mbs.set(name, 0)", moving)
    assert page.evaluate("urdf2mbs.arrows()") == []
    page.locator(".view canvas").focus()
    seen = [page.evaluate("urdf2mbs.picture()")]
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.keyboard.press(key)
        seen.append(page.evaluate("urdf2mbs.picture()"))
    assert len(set(seen)) == 4
    curves = page.locator("#curve option").all_inner_texts()
    assert curves[:4] == ["Angles", "Lengths", "Forces", "Energy"]
    assert curves[-1] == f"|push1.{pushed}|"
    page.evaluate("urdf2mbs.player.seek(0.04)")
    legend = page.locator("#legend li").all_inner_texts()
    for name, value in (line.rsplit(" ", 1) for line in legend):
        degrees = np.degrees(rows[2][1 + joints.index(name)])
        assert float(value.removesuffix("°")) == pytest.approx(degrees, abs=0.6)
    assert legend
    page.locator("#curve").select_option(label="Energy")
    assert "sum 9 J" in page.locator("#legend").inner_text()
    page.evaluate("urdf2mbs.player.seek(0)")
    page.keyboard.press(" ")
    page.evaluate("""new Promise((done) => {
        const look = () => urdf2mbs.player.time > 0 ? done() : requestAnimationFrame(look);
        look();
    })""")
    page.keyboard.press(" ")
    assert page.locator("#play").inner_text() == "Play"
    page.click("#reset")
    assert page.locator("#clock").inner_text() == "0.00 s"
    page.click("#show summary")
    page.click("#record")
    page.evaluate("urdf2mbs.player.seek(0)")
    with page.expect_download() as download:
        page.click("#record")
    assert download.value.suggested_filename == "arm.webm"
    assert download.value.path().read_bytes()[:4] == b"\x1aE\xdf\xa3"  # the mark of a WebM file
    assert not errors
    page.close()
