"""Pages as people use them: sliders, loops, wheel, keys, small screens, modes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from support.pages.opened import wait_until
from support.pages.shown import CONFIGS, run
from urdf2mbs.mbs.model import Base, Body, Connection, Joint, Mbs, Parameter, Point, UserModel
from urdf2mbs_report.motion import stack_columns
from urdf2mbs_report.page import Page as Report
from urdf2mbs_report.page import ShownModes, make_model_page, make_robot_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.slow

SIZES = {"desktop": (1280, 800), "tablet": (820, 1180), "phone": (390, 844)}
#: Names of joints that are wider than a phone.
LONG = "a_joint_with_a_name_that_is_much_longer_than_a_phone_is_wide"

#: Opens a page in a window of a size.
OpenPage = Callable[..., "Page"]


@pytest.fixture
def open_page(browser: Browser, tmp_path: Path) -> Iterator[OpenPage]:
    """Open pages; a test fails if one of them raises an error."""
    errors: list[str] = []
    contexts = []

    def open_(report: Report, size: str = "desktop", **options: Any) -> Page:
        width, height = SIZES[size]
        context = browser.new_context(
            viewport={"width": width, "height": height}, has_touch=size != "desktop", **options
        )
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: errors.append(str(error)))
        file = tmp_path / "page.html"
        file.write_bytes(report.data)
        page.goto(file.as_uri())
        page.evaluate("urdf2mbs.ready")
        return page

    yield open_
    for context in contexts:
        context.close()
    assert errors == []


def four_bar() -> Mbs:
    """A crank of 0.1 m, a coupler of 0.3 m and a rocker of 0.2 m, whose end is 0.3 m away.

    A ball closes the loop.  The start is closed: the crank is along z, the rest by its lengths.
    Its first body floats; a driven joint turns it.
    """
    base = [
        Joint(f"base_{kind}", kind, q=0.5 if kind == "T3" else 0.0)
        for kind in ("T1", "T2", "T3", "R1", "R2", "R3")
    ]
    frame = Body("frame", None, "origin", [*base, Joint("turned", "R1", "driven", q=0.4)], mass=1.0)
    frame.points = [Point("crank_pin", (0.0, 0.0, 0.0)), Point("rocker_pin", (0.3, 0.0, 0.0))]
    crank = Body("crank", "frame", "crank_pin", [Joint("crank", "R2", q=0.3)], mass=0.1)
    crank.points = [Point("tip", (0.0, 0.0, 0.1))]
    coupler = Body(
        "coupler", "crank", "tip", [Joint("coupler", "R2", "dependent", q=1.0)], mass=0.1
    )
    coupler.points = [Point("end", (0.0, 0.0, 0.3))]
    rocker = Body("rocker", "frame", "rocker_pin", [Joint("rocker", "R2", "dependent")], mass=0.1)
    rocker.points = [Point("end", (0.0, 0.0, 0.2))]
    limits = [
        UserModel("q_min", [Parameter("crank", "scalar", ("-0.5",))]),
        UserModel("q_max", [Parameter("crank", "scalar", ("0.75",))]),
    ]
    return Mbs(
        "four_bar",
        base=Base(points=[Point("origin", (0.0, 0.0, 0.0))]),
        bodies=[frame, crank, coupler, rocker],
        cuts=[Connection("ball", "loop", ("coupler", "end"), ("rocker", "end"))],
        user_models=limits,
    )


def test_loops_stay_closed_and_limits_hold(open_page: OpenPage, tmp_path: Path) -> None:
    """Driven joints have no sliders; the base comes last, and stays."""
    page = open_page(make_model_page(four_bar(), tmp_path / "m.mbs"))
    assert "Loop 'loop' is open by" in page.locator("#gap").inner_text(), "as the file says"
    sliders = page.locator("#sliders .slider")
    names = sliders.evaluate_all("rows => rows.map((row) => row.dataset.joint)")
    assert names[:3] == ["crank", "coupler", "rocker"]
    assert sorted(names[3:]) == [f"base_{kind}" for kind in ("R1", "R2", "R3", "T1", "T2", "T3")]
    for button, expected in (("zero", 0.0), ("random", None), ("random", None)):
        page.locator(f"#{button}").click()
        crank = page.evaluate("urdf2mbs.position('crank')")
        assert -0.5 <= crank <= 0.75
        if expected is not None:
            assert crank == pytest.approx(expected, abs=1e-9)
        (loop,) = page.evaluate("urdf2mbs.gaps()")
        assert loop["gap"] < 1e-6
        assert page.locator("#gap").is_hidden()
        assert page.evaluate("urdf2mbs.position('base_T3')") == 0.5
    page.evaluate("urdf2mbs.set('crank', 2)")
    assert page.evaluate("urdf2mbs.position('crank')") == pytest.approx(0.75)
    # the rocker moves as far as the crank's limits let it
    before = page.evaluate("urdf2mbs.position('rocker')")
    page.evaluate("(q) => urdf2mbs.set('rocker', q)", before - 0.2)
    (loop,) = page.evaluate("urdf2mbs.gaps()")
    assert loop["gap"] < 1e-6
    assert -0.5 <= page.evaluate("urdf2mbs.position('crank')") <= 0.75
    page.locator("#start").click()
    assert page.evaluate("urdf2mbs.position('coupler')") == 1.0
    assert page.evaluate("urdf2mbs.position('turned')") == 0.4


def test_a_loop_that_cannot_close_says_its_gap(open_page: OpenPage, tmp_path: Path) -> None:
    model = four_bar()
    model.bodies[3].points = [Point("end", (0.0, 0.0, 0.9))]
    page = open_page(make_model_page(model, tmp_path / "m.mbs"))
    page.locator("#random").click()
    assert page.locator("#gap").is_visible()
    assert "Loop 'loop' is open by" in page.locator("#gap").inner_text()


@pytest.mark.parametrize("kind", ["rod", "solid"])
def test_other_cuts_close(kind: str, open_page: OpenPage, tmp_path: Path) -> None:
    model = four_bar()
    cut = Connection(kind, "loop", ("coupler", "end"), ("rocker", "end"), length=0.05)
    model.cuts = [cut]
    if kind == "solid":  # the rocker is free to turn and to shift at its end
        model.bodies[3].joints = [
            Joint("shift_x", "T1", "dependent"),
            Joint("shift_z", "T3", "dependent"),
            Joint("rocker", "R2", "dependent"),
        ]
    page = open_page(make_model_page(model, tmp_path / "m.mbs"))
    for _ in range(3):
        page.locator("#random").click()
        (loop,) = page.evaluate("urdf2mbs.gaps()")
        assert loop["gap"] < 1e-6
    if kind == "solid":
        angles = [page.evaluate(f"urdf2mbs.position('{name}')") for name in ("crank", "coupler")]
        rocker = page.evaluate("urdf2mbs.position('rocker')")
        assert sum(angles) == pytest.approx(rocker, abs=1e-6), "the axes are parallel"


@pytest.fixture
def biped(tmp_path: Path) -> Report:
    return make_robot_page(run(CONFIGS / "biped.urdf.xacro", tmp_path / "biped"))


def test_tab_reaches_all_in_few_stops(open_page: OpenPage, biped: Report) -> None:
    """Groups are one stop each; arrow keys move within them."""
    page = open_page(biped)
    stops: list[str] = []
    for _ in range(60):
        page.keyboard.press("Tab")
        stop = page.evaluate("(document.activeElement.closest('[id]') || {}).id")
        is_again = page.evaluate(
            """() => { const element = document.activeElement, isAgain = element.dataset.visited;
              element.dataset.visited = "1"; return element === document.body || !!isAgain; }"""
        )
        if is_again:
            break
        stops.append(stop)
    assert len(stops) <= 40
    assert {"fit", "show", "zero", "sliders", "joints", "bodies", "names"} <= set(stops)
    page.locator("#as-links").click()
    page.locator("#tree [role=treeitem]").first.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    second = page.locator("#tree [role=treeitem]").nth(1)
    assert second.get_attribute("aria-selected") == "true"
    assert page.locator("#tree [tabindex='0']").count() == 1
    page.locator("#zero").focus()
    page.keyboard.press("ArrowRight")
    assert page.evaluate("document.activeElement.id") == "start"


@pytest.mark.parametrize("size", SIZES)
def test_nothing_is_wider_than_the_screen(size: str, open_page: OpenPage, tmp_path: Path) -> None:
    model = four_bar()
    model.bodies[1].joints[0].name = LONG
    page = open_page(make_model_page(model, tmp_path / "m.mbs"), size)
    if size != "desktop":
        assert page.locator("#sliders").is_hidden()
        page.locator("#panel summary").click()
    too_wide = page.evaluate(
        """() => [...document.querySelectorAll("main *")].filter((element) =>
          !element.closest(".scroll table, svg")
          && element.getBoundingClientRect().right > innerWidth + 1).map((one) => one.outerHTML)"""
    )
    assert too_wide == []
    assert page.evaluate("document.documentElement.scrollWidth") <= SIZES[size][0]


@pytest.mark.parametrize("part", ["#view canvas", "#paper svg", "#bodies .scroll"])
def test_a_finger_scrolls_the_page(part: str, open_page: OpenPage, biped: Report) -> None:
    page = open_page(biped, "phone")
    page.locator(part).evaluate("element => element.scrollIntoView({block: 'center'})")
    box = page.locator(part).bounding_box()
    assert box is not None
    touch = page.context.new_cdp_session(page)
    x, y = box["x"] + box["width"] / 2, min(box["y"] + box["height"] / 2, 600.0)
    before = page.evaluate("scrollY")

    def send(kind: str, *points: tuple[float, float]) -> None:
        touches = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(points)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})

    send("touchStart", (x, y))
    for step in range(1, 12):
        send("touchMove", (x, y - 15 * step))
    send("touchEnd")
    wait_until(page, f"scrollY > {before + 50}")
    if part != "#paper svg":
        return
    view_box = page.locator(part).get_attribute("viewBox")
    assert view_box is not None
    box = page.locator(part).bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    send("touchStart", (x - 20, y), (x + 20, y))
    for step in range(1, 8):
        send("touchMove", (x - 20 - 5 * step, y), (x + 20 + 5 * step, y))
    send("touchEnd")
    pinched = page.locator(part).get_attribute("viewBox")
    assert pinched is not None
    assert float(pinched.split()[2]) < 0.6 * float(view_box.split()[2]), "two fingers zoom"


def test_less_motion_ends_the_blinking(open_page: OpenPage, tmp_path: Path) -> None:
    conversion = run(CONFIGS / "biped.urdf.xacro", tmp_path / "biped")
    written = conversion.files[conversion.settings.output]
    assert b"<q>" in written
    start = written.index(b"<q>") + 3
    end = written.index(b"</q>")
    conversion.files[conversion.settings.output] = written[:start] + b"0.7" + written[end:]
    page = open_page(make_robot_page(conversion), reduced_motion="reduce")
    (link,) = page.evaluate("urdf2mbs.agreement().differing.slice(0, 1)")
    shown = set(page.evaluate("(link) => urdf2mbs.lit(link)", link))
    assert shown <= {"mbs", "urdf"}
    assert page.evaluate("urdf2mbs.blink()") is None
    assert set(page.evaluate("(link) => urdf2mbs.lit(link)", link)) == shown


def test_a_page_of_modes_lists_them(open_page: OpenPage, tmp_path: Path) -> None:
    """The second mode is chosen by a click; its joint moves by the amplitude."""
    model = four_bar()
    model.cuts = []
    names = [joint.name for body in model.bodies for joint in body.joints]

    def describe(number: int, frequency: float, joint: str) -> dict[str, Any]:
        amplitudes = [1.0 if name == joint else 0.0 for name in names]
        mode = {"number": number, "frequency": frequency, "damping": 0.1, "time": "fades in 2 s"}
        return {
            **mode,
            "amplitudes": amplitudes,
            "phases": [0.0 for _ in names],
            "joints": [joint],
        }

    modes = [describe(1, 1.25, "crank"), describe(2, 3.5, "rocker"), describe(3, 0.0, "coupler")]
    positions = dict.fromkeys(names, 0.0)
    shown = ShownModes({"modes": modes, "chosen": 0, "positions": positions}, ["55 more"])
    page = open_page(make_model_page(model, tmp_path / "m.mbs", modes=shown))
    assert page.title() == "four_bar: modes"
    rows = page.locator("#mode-table tbody tr")
    assert rows.nth(1).locator("td").all_inner_texts() == ["2", "3.5", "0.1", "rocker"]
    assert "fades in 2 s" in rows.nth(2).inner_text()
    assert "55 more" in page.locator("#model").inner_text()
    assert page.evaluate("urdf2mbs.position('crank')") == pytest.approx(0.2)
    rows.nth(1).click()
    assert rows.nth(1).get_attribute("aria-selected") == "true"
    assert page.evaluate("urdf2mbs.position('crank')") == 0.0
    assert page.evaluate("urdf2mbs.position('rocker')") == pytest.approx(0.2)
    assert page.locator("#amplitude-value").inner_text() == "11.5° of rocker"
    page.locator("#play").click()
    wait_until(page, "urdf2mbs.position('rocker') < 0.19")
    page.locator("#play").click()
    assert page.locator("#play").inner_text() == "Play"


def test_modes_fit_a_phone(open_page: OpenPage, tmp_path: Path) -> None:
    """The last column, the joints that move most, is the answer that people look for."""
    model = four_bar()
    model.cuts = []
    joints = [LONG, "crank", "coupler", "rocker"]
    model.bodies[0].joints[0].name = LONG
    names = [joint.name for body in model.bodies for joint in body.joints]
    mode = {"number": 1, "frequency": 0.0, "damping": 1.0, "time": "fades in 0.0424 s"}
    mode |= {"amplitudes": [1.0 for _ in names], "phases": [0.0 for _ in names], "joints": joints}
    positions = dict.fromkeys(names, 0.0)
    shown = ShownModes({"modes": [mode], "chosen": 0, "positions": positions}, [])
    page = open_page(make_model_page(model, tmp_path / "m.mbs", modes=shown), "phone")
    cell = page.locator("#mode-table tbody td").last
    assert cell.inner_text() == ", ".join(joints)
    box = cell.bounding_box()
    assert box is not None
    assert box["x"] + box["width"] <= SIZES["phone"][0]


def test_what_agrees_is_apart_by_zero(open_page: OpenPage, biped: Report) -> None:
    """Rounding is 0; the licence, which scrolls, is reached by keys."""
    page = open_page(biped)
    assert "apart by at most 0 m" in page.locator("#model").inner_text()
    page.locator("footer summary").click()
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe-playwright")
    violations = axe.Axe().run(page).response["violations"]
    assert [violation["id"] for violation in violations] == []


def test_the_camera_follows_the_robot(open_page: OpenPage, tmp_path: Path) -> None:
    model = four_bar()
    columns = {
        f"q.{joint.name}": np.full(2, joint.q or 0.0)
        for body in model.bodies
        for joint in body.joints
    }
    columns["q.base_T1"] = np.array([0.0, 5.0])
    results = stack_columns({"time": np.array([0.0, 1.0]), **columns})
    page = open_page(make_model_page(model, tmp_path / "m.mbs", results))
    start = page.evaluate("urdf2mbs.camera()")
    page.evaluate("urdf2mbs.player.seek(1)")
    assert page.evaluate("urdf2mbs.camera()") == pytest.approx([start[0] + 5.0, *start[1:]])
    page.locator("#reset").click()
    assert page.evaluate("urdf2mbs.camera()") == pytest.approx(start)
    page.locator("#follow").uncheck()
    page.evaluate("urdf2mbs.player.seek(1)")
    assert page.evaluate("urdf2mbs.camera()") == pytest.approx(start)


def test_still_curves_look_still_and_have_units(open_page: OpenPage, tmp_path: Path) -> None:
    """A joint that moves by a thousandth of a degree does not fill the plot."""
    model = four_bar()
    columns = {
        f"q.{joint.name}": np.full(2, joint.q or 0.0)
        for body in model.bodies
        for joint in body.joints
    }
    columns["q.crank"] = np.array([0.3, 0.3 + 2e-5])
    results = stack_columns({"time": np.array([0.0, 1.0]), **columns})
    page = open_page(make_model_page(model, tmp_path / "m.mbs", results))
    ink = """() => {
      const canvas = document.getElementById("curves"), {width, height} = canvas;
      const {data} = canvas.getContext("2d").getImageData(0, 0, width, height);
      const rows = new Set();
      for (let k = 0; k < data.length; k += 4) {
        const isRed = data[k] > 150 && data[k + 1] < 90 && data[k + 3] > 120;
        if (isRed) rows.add(Math.floor(k / 4 / width));
      }
      return [rows.size, height];
    }"""
    rows, height = page.evaluate(ink)
    assert 0 < rows < 0.1 * height, "a flat line, in the colour of the first curve"
    assert page.locator("#legend").inner_text() == "crank 17.2°"
    page.locator("#unit").select_option("rad")
    assert page.locator("#legend").inner_text() == "crank 0.3 rad"
