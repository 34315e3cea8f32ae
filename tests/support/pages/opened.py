"""A report that is open in the browser."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf2mbs.conversion import Conversion
from urdf2mbs_report.page import make_robot_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


@dataclass
class Opened:
    """A report in the browser."""

    page: Page
    conversion: Conversion
    messages: list[str] = field(default_factory=list)
    """Messages of the console, errors, and every request that is not the page itself."""

    def ask(self, expression: str, argument: Any = None) -> Any:
        return self.page.evaluate(expression, argument)

    def pose(self, side: str, name: str | None) -> Any:
        """(4, 4): where the browser draws a body ("mbs") or a link ("urdf")."""
        return np.array(self.ask("([s, n]) => urdf2mbs.seen(s, n)", [side, name]))

    def slide(self, joint: str, value: float) -> None:
        slider = self.page.locator(f'input[type=range][data-joint="{joint}"]')
        slider.evaluate(
            """(slider, value) => {
              slider.value = value;
              slider.dispatchEvent(new Event("input"));
            }""",
            value,
        )

    def switch(self, name: str, is_on: bool) -> None:
        """Turn a switch of the menu "Show" on or off."""
        menu = self.page.locator("#show")
        if menu.get_attribute("open") is None:
            menu.locator("summary").click()
        self.page.locator(f"#{name}").set_checked(is_on)

    def position(self, joint: str) -> float:
        return float(self.ask("(name) => urdf2mbs.position(name)", joint))


Open = Callable[..., Opened]


def wait_until(page: Page, condition: str) -> None:
    """Wait until an expression of the page is true; fail if it is not after 300 frames."""
    is_true = page.evaluate(
        f"""new Promise((done) => {{
          let count = 0;
          requestAnimationFrame(function look() {{
            if ({condition}) done(true);
            else if (count++ === 300) done(false);
            else requestAnimationFrame(look);
          }});
        }})"""
    )
    assert is_true, condition


def open_report(
    browser: Browser, folder: Path, conversion: Conversion, init: str | None = None
) -> Opened:
    """Open the page of a conversion in a new tab; ``init`` is run before the page's own script."""
    file = folder / "report.html"
    file.write_bytes(make_robot_page(conversion).data)
    page = browser.new_page(viewport={"width": 1100, "height": 760})
    report = Opened(page, conversion)

    def check_request(url: str) -> None:
        if url != file.as_uri() and not url.startswith(("data:", "blob:")):
            report.messages.append(f"request: {url}")

    def add_message(kind: str, text: str) -> None:
        if "GPU stall due to ReadPixels" not in text:  # what a screenshot costs in software
            report.messages.append(f"{kind}: {text}")

    page.on("console", lambda message: add_message(message.type, message.text))
    page.on("pageerror", lambda error: add_message("error", str(error)))
    page.on("request", lambda request: check_request(request.url))
    if init:
        page.add_init_script(init)
    page.goto(file.as_uri())
    page.evaluate("urdf2mbs.ready")
    return report
