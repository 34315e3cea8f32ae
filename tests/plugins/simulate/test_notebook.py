"""In a notebook a simulation and modes show themselves: the page, in an iframe."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from support.folders import CONFIGS
from urdf2mbs import modes, simulate

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.mark.slow
def test_they_show_themselves(browser: Browser, tmp_path: Path) -> None:
    results = simulate(CONFIGS / "arm.urdf.xacro", time=0.05)
    found = modes(CONFIGS / "biped.urdf.xacro", base="fixed")
    last = results.joint("elbow")[-1]
    page = browser.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    for shown in (results, found):
        (tmp_path / "notebook.html").write_text(f"<p>A notebook</p>{shown._repr_html_()}", "utf-8")
        page.goto((tmp_path / "notebook.html").as_uri())
        frame = page.frames[1]
        frame.evaluate("urdf2mbs.ready")
        if shown is results:
            frame.evaluate("urdf2mbs.player.seek(1)")
            seen = frame.evaluate("urdf2mbs.position('elbow')")
            assert seen == pytest.approx(last, abs=1e-6)
            frame.locator("nav a").last.click()
            assert "notebook.html" in page.url
            assert frame.locator("#around").is_visible()
        else:
            row = frame.locator("#mode-table tbody tr").first.inner_text()
            assert f"{found.modes[0].frequency:.4g}" in row
    assert not list((tmp_path).glob("resultsR")), "looking writes no results"
    assert errors == []
    page.close()
