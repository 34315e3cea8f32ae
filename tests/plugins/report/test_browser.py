"""The reports of five robots in a real browser."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from support.folders import SHARED
from support.oracle.mbs import Evaluator
from support.pages.opened import Opened, open_report
from support.pages.shown import SHOWN, data, shown
from urdf2mbs.conversion import Conversion

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", params=SHOWN)
def report(
    request: pytest.FixtureRequest, browser: Browser, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Opened]:
    """Open the page of each robot, one after the other."""
    if request.param != "biped" and not SHARED.is_dir():
        pytest.skip(f"the real robots are not here: {SHARED} does not exist")
    folder = tmp_path_factory.mktemp(request.param)
    tab = open_report(browser, folder, shown(request.param, folder))
    yield tab
    tab.page.close()


def link_poses(conversion: Conversion, q: dict[str, float]) -> dict[str, Any]:
    """(4, 4) of each URDF link's frame, as the .mbs file has it."""
    evaluator = Evaluator(data(conversion))
    poses = evaluator.positions(q)
    link_poses_by_name = {}
    for link, frame in conversion.frames.items():
        link_pose = np.eye(4)
        link_pose[:3, :3] = np.reshape(frame.pose.rot, (3, 3))
        link_pose[:3, 3] = frame.pose.xyz
        holder = poses.joint(frame.joint) if frame.joint else poses.body(frame.body or "base")
        link_poses_by_name[link] = holder @ link_pose
    return link_poses_by_name


def test_opens_without_a_word_and_without_the_network(report: Opened) -> None:
    assert report.messages == []


def test_readable_by_keyboard_and_screen_reader(report: Opened) -> None:
    """In light and in dark colours."""
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="no Python package axe-playwright-python"
    )
    for scheme in ("dark", "light"):
        report.page.emulate_media(color_scheme=scheme)
        violations = axe.Axe().run(report.page).response["violations"]
        assert not [
            violation["id"]
            for violation in violations
            if violation["impact"] in ("serious", "critical")
        ], scheme


def test_sliders_move_everything_where_the_file_says(report: Opened) -> None:
    evaluator = Evaluator(data(report.conversion))
    report.ask("document.getElementById('mimic').checked = false")
    report.page.locator("#zero").click()
    random = Random(7)
    q = {joint: report.position(joint) for joint in evaluator.moving}
    for joint in random.sample(evaluator.moving, min(8, len(evaluator.moving))):
        low, high = report.ask("(name) => urdf2mbs.limits(name)", joint)
        report.slide(joint, low + (high - low) * random.uniform(0.1, 0.9))
        before, q[joint] = q[joint], report.position(joint)
        assert q[joint] != before
    assert q == {joint: report.position(joint) for joint in evaluator.moving}, "and no other"
    poses = evaluator.positions(q)
    for body in evaluator.bodies:
        if body != "base":
            np.testing.assert_allclose(report.pose("mbs", body), poses.body(body), atol=1e-12)
    for link, pose in link_poses(report.conversion, q).items():
        np.testing.assert_allclose(report.pose("urdf", link), pose, atol=1e-12)


def test_limits_are_the_urdf_s(report: Opened) -> None:
    conversion = report.conversion
    report.ask("document.getElementById('mimic').checked = false")
    limited = 0
    for joint in conversion.robot.joints.values():
        names = conversion.names.coordinates.get(joint.name, [])
        if joint.type not in ("revolute", "prismatic") or not joint.limit or not names:
            continue
        limited += 1
        report.slide(names[0], 1e3)
        assert report.position(names[0]) == joint.limit.upper
        report.slide(names[0], -1e3)
        assert report.position(names[0]) == joint.limit.lower
    report.page.locator("#zero").click()
    assert limited or conversion.robot.name == "leo"


def test_urdf_and_mbs_agree_everywhere(report: Opened) -> None:
    for _ in range(3):
        report.page.locator("#random").click()
        agreement = report.ask("urdf2mbs.agreement()")
        assert agreement["differing"] == []
        assert agreement["largest"] < 1e-12
        assert agreement["compared"] == len(report.conversion.robot.links)
    counts = report.ask("urdf2mbs.counts()")
    visuals = sum(len(link.visuals) for link in report.conversion.robot.links.values())
    assert counts["mbs"] == counts["urdf"] == agreement["shapes"]
    assert counts["mbs"] + counts["lost"] == visuals  # what is lost is in no .mbs
    assert agreement["shapesDiffering"] == []
    report.page.locator("#zero").click()


def test_no_boxes_of_the_diagram_overlap_and_names_fit(report: Opened) -> None:
    boxes, names = report.ask(
        """() => [".body .box", ".body-name text"].map((what) => Object.fromEntries(
          [...document.querySelectorAll(`#paper ${what}`)].map((one) => {
            const {left, top, right, bottom} = one.getBoundingClientRect();
            return [one.closest("[data-body]").dataset.body, [left, top, right, bottom]];
          })))"""
    )
    assert len(boxes) == len(report.conversion.mbs.bodies) + 1
    for body, (left, _, right, _) in names.items():
        assert right - left <= boxes[body][2] - boxes[body][0], body
    sides = np.array(list(boxes.values()))
    inside = (sides[:, None, :2] < sides[None, :, 2:] - 1e-6).all(axis=2)
    both = inside & inside.T
    np.fill_diagonal(both, False)
    assert not both.any()


def test_switches_change_the_picture(report: Opened) -> None:
    seen = {report.ask("urdf2mbs.picture()")}
    switches = ["show-frames", "show-coms", "show-skeleton", "show-grid", "show-inertias"]
    if report.ask("urdf2mbs.counts()")["mbs"]:
        switches.append("see-through")
    for switch in switches:
        report.switch(switch, not report.page.locator(f"#{switch}").is_checked())
        picture = report.ask("urdf2mbs.picture()")
        assert picture not in seen, switch
        seen.add(picture)
    assert report.messages == [], "nothing went wrong in all tests above"
