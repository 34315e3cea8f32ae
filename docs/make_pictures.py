"""Makes the pictures of README and docs, from our example robots, by our own commands.

    python docs/make_pictures.py

It wants Playwright, and a Chromium on the PATH; it takes a minute.
"""

from __future__ import annotations

import json
import shutil
import sys
from contextlib import redirect_stdout
from io import BytesIO, StringIO
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from urdf2mbs.cli import main
from urdf2mbs.testing import TINY

DOCS = Path(__file__).resolve().parent
OUT = DOCS / "pictures"
CONFIGS = DOCS.parent / "configs"
ROBOTS = {
    "biped": CONFIGS / "biped.urdf.xacro",
    "arm": CONFIGS / "arm.urdf.xacro",
    "hexapod": CONFIGS / "hexapod.urdf.xacro",
    "lamp": CONFIGS / "lamp.urdf",
}
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]

#: A plugin that changes the robot and does not say so: what `verify` is there for.
MISTAKE = '''
from urdf2mbs.plugin import Pass, hookimpl


class Mistake(Pass):
    """Forget which way the forearm is turned."""

    def run(self, conversion):
        for body in conversion.mbs.bodies:
            for joint in body.joints:
                if joint.name.startswith("elbow_origin"):
                    joint.q = 0.6


@hookimpl
def urdf2mbs_passes():
    return [Mistake]
'''


def run(*words: object, code: int = 0) -> str:
    """What a command prints."""
    with redirect_stdout(StringIO()) as said:
        done = main([str(word) for word in words])
    if done != code:
        sys.exit(f"exit code {done}: urdf2mbs {' '.join(map(str, words))}")
    return said.getvalue()


def compressed(pictures: list[Image.Image], width: int) -> bytes:
    """A PNG of some pictures side by side, of 64 colours, which is a quarter as large."""
    height = max(one.height for one in pictures)
    whole = Image.new("RGB", (sum(one.width for one in pictures), height))
    at = 0
    for one in pictures:
        whole.paste(one, (at, 0))
        at += one.width
    whole = whole.resize((width, round(height * width / whole.width)))
    out = BytesIO()
    whole.quantize(64, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return out.getvalue()


#: Where URDF and .mbs differ, the page shows now the one and now the other: here always the .mbs.
STILL = "window.setInterval = () => 0"
SHOW_MBS = "async () => { await urdf2mbs.ready; urdf2mbs.blink(); }"
DRAWN = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def still_page(browser: Browser) -> Page:
    """A page in which nothing changes with time."""
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.add_init_script(STILL)
    return page


def page_of(page: Page, html: Path) -> Image.Image:
    """A report page as it opens."""
    page.goto(html.as_uri())
    page.evaluate(SHOW_MBS)
    page.evaluate(DRAWN)
    return Image.open(BytesIO(page.screenshot())).convert("RGB")


def in_3d(page: Page, html: Path, side: str = "mbs") -> Image.Image:
    """The 3D view of a report page: as the .mbs says, as the URDF does, or both."""
    page_of(page, html)
    page.check(f"input[name=side][value={side}]")
    page.add_style_tag(content="#view > :not(canvas) { visibility: hidden }")
    page.evaluate(DRAWN)
    png = page.locator("#view canvas").screenshot()
    return Image.open(BytesIO(png)).convert("RGB")


def gallery(page: Page, work: Path) -> None:
    """Each robot in 3D and as a diagram; of the first, the report page too."""
    for name, source in ROBOTS.items():
        config, html, model = (work / f"{name}{end}" for end in (".yaml", ".html", ".mbs"))
        run("init", source, "-o", config)
        run("report", config, "-o", html)
        (OUT / f"{name}.png").write_bytes(compressed([in_3d(page, html)], 480))
        run("convert", source, "--pipeline", "compact", "-o", model)
        run("diagram", model, "-o", OUT / f"{name}.svg", "--force")
    (OUT / "report.png").write_bytes(compressed([page_of(page, work / "biped.html")], 960))


def moving(page: Page, work: Path) -> None:
    """The hexapod is pushed up, falls and lands: a GIF of the page that plays it."""
    html = work / "moving.html"
    run("simulate", ROBOTS["hexapod"], "-o", html, "--time", "1.4",
        "--push", "body:0,12,130@0.1..0.25")  # fmt: skip
    page.goto(html.as_uri())
    page.evaluate("urdf2mbs.ready")
    page.click("#show summary")
    page.uncheck("#show-forces")
    page.uncheck("#follow")
    page.add_style_tag(content="#view > :not(canvas) { visibility: hidden }")
    canvas = page.locator("#view canvas")
    frames = []
    for number in range(42):
        page.evaluate("(time) => urdf2mbs.player.seek(time)", number / 30)
        page.evaluate(DRAWN)
        frame = Image.open(BytesIO(canvas.screenshot())).convert("RGB")
        frames.append(frame.resize((400, round(400 * frame.height / frame.width))))
    palette = frames[0].quantize(64, dither=Image.Dither.NONE)
    first, *rest = (one.quantize(palette=palette, dither=Image.Dither.NONE) for one in frames)
    first.save(OUT / "moving.gif", save_all=True, append_images=rest, duration=50, loop=0)


def swinging(page: Page, work: Path) -> None:
    """The biped at both ends of its first mode."""
    config, html = work / "swing.yaml", work / "swing.html"
    run("init", ROBOTS["biped"], "-o", config)
    run("modes", config, "-o", html)
    page_of(page, html)
    page.add_style_tag(content="#view > :not(canvas) { visibility: hidden }")
    ends = []
    for phase in (0.0, pi):
        page.evaluate("(phase) => urdf2mbs.showPhase(phase)", phase)
        page.evaluate(DRAWN)
        png = page.locator("#view canvas").screenshot()
        ends.append(Image.open(BytesIO(png)).convert("RGB"))
    (OUT / "swing.png").write_bytes(compressed(ends, 960))


def how_to(page: Page, work: Path) -> None:
    """A picture for each of the pages that say how to do something."""
    # fewer joints: the arm with every link's frame kept; arm.svg is the same in `compact`
    run("convert", ROBOTS["arm"], "-o", work / "faithful.mbs")
    run("diagram", work / "faithful.mbs", "-o", OUT / "arm-faithful.svg", "--force")
    # passes: the robot of all the examples there
    (work / "tiny.urdf").write_text(TINY, "utf-8")
    run("convert", work / "tiny.urdf", "-o", work / "tiny.mbs")
    run("diagram", work / "tiny.mbs", "-o", OUT / "tiny.svg", "--force")
    # many robots: a family from one source
    family = []
    for legs in (4, 6, 9):
        html = work / f"hexapod{legs}.html"
        run("report", ROBOTS["hexapod"], "--arg", f"legs:={legs}", "-o", html)
        family.append(in_3d(page, html))
    (OUT / "family.png").write_bytes(compressed(family, 960))
    # are they the same: a planted mistake
    (work / "mistake.py").write_text(MISTAKE, "utf-8")
    html = work / "mistake.html"
    run("report", ROBOTS["arm"], "-o", html, "--plugin", work / "mistake.py",
        "--after", "decompose-joints=mistake", code=3)  # fmt: skip
    (OUT / "mistake.png").write_bytes(compressed([page_of(page, html)], 960))


def operations(work: Path) -> None:
    """How many operations the equations of each robot take, as bars."""
    bars = []
    for name, source in ROBOTS.items():
        model = work / f"{name}.mbs"
        run("convert", source, "--pipeline", "compact", "-o", model)
        for fold in ((), ("--fold",)):
            found = json.loads(run("equations", model, "-o", work / "symbolicR", "--json", *fold))
            count = found["counts"]["dirdyna"]
            bars.append((f"{name} {' '.join(fold)}", count["products"], count["sums"]))
    scale = 420 / max(products + sums for _, products, sums in bars)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 {24 * len(bars) + 40}" '
        'font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for row, (name, products, sums) in enumerate(bars):
        y, first, second = 24 * row + 8, products * scale, sums * scale
        lines += [
            f'<text x="132" y="{y + 13}" text-anchor="end">{name}</text>',
            f'<rect x="140" y="{y}" width="{first:.1f}" height="17" fill="#3f51b5"/>',
            f'<rect x="{140 + first:.1f}" y="{y}" width="{second:.1f}" height="17" '
            'fill="#9fa8da"/>',
            f'<text x="{146 + first + second:.1f}" y="{y + 13}">{products + sums}</text>',
        ]
    y = 24 * len(bars) + 18
    lines += [
        f'<rect x="140" y="{y}" width="12" height="12" fill="#3f51b5"/>',
        f'<text x="157" y="{y + 11}">products</text>',
        f'<rect x="240" y="{y}" width="12" height="12" fill="#9fa8da"/>',
        f'<text x="257" y="{y + 11}">sums, in dirdyna</text>',
        "</svg>",
    ]
    (OUT / "operations.svg").write_text("\n".join(lines) + "\n", "utf-8")


def make() -> None:
    OUT.mkdir(exist_ok=True)
    with TemporaryDirectory() as folder, sync_playwright() as driver:
        work = Path(folder)
        chromium = driver.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = still_page(chromium)
        gallery(page, work)
        moving(page, work)
        swinging(page, work)
        how_to(page, work)
        operations(work)
        chromium.close()


if __name__ == "__main__":
    make()
