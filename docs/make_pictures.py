"""Makes the pictures of README and docs by our own commands: python docs/make_pictures.py [ROBOTS]

ROBOTS is a folder of robots for the gallery, each in a folder of its own; without it only our
biped is drawn. It needs the extras meshes and report, Playwright, and a Chromium on the PATH.
"""

from __future__ import annotations

import shutil
import sys
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from urdf2mbs.cli import main

HERE = Path(__file__).resolve().parent
OUT = HERE / "pictures"
BIPED = HERE.parent / "configs" / "biped.urdf.xacro"

#: Name of the picture: the robot's file below ROBOTS. Their licences permit pictures.
GALLERY = {
    "atlas": "atlas/atlas_description/robots/atlas_v5.urdf.xacro",
    "r2d2": "urdf_tutorial_r2d2/urdf_tutorial/urdf/07-physics.urdf",
    "t12": "t12/T12/urdf/T12.URDF",
}
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def run(*words: str) -> None:
    if main(words) != 0:
        sys.exit(f"failed: urdf2mbs {' '.join(words)}")


def compressed(png: bytes, width: int) -> bytes:
    """A PNG of 64 colours, which is a quarter as large."""
    picture = Image.open(BytesIO(png)).convert("RGB")
    picture = picture.resize((width, round(picture.height * width / picture.width)))
    out = BytesIO()
    picture.quantize(64, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return out.getvalue()


def photograph(page: Page, html: Path, name: str) -> None:
    """The 3D view of a report, as the .mbs says."""
    page.goto(html.as_uri())
    page.wait_for_timeout(1500)
    page.check("input[name=side][value=mbs]")
    page.add_style_tag(content="#view > :not(canvas) { visibility: hidden }")
    page.wait_for_timeout(500)
    png = page.locator("#view canvas").screenshot()
    (OUT / f"{name}.png").write_bytes(compressed(png, 480))


def make(robots: Path | None) -> None:
    OUT.mkdir(exist_ok=True)
    sources = {"biped": BIPED}
    if robots is not None:
        sources |= {name: robots / file for name, file in GALLERY.items()}
    with TemporaryDirectory() as folder, sync_playwright() as driver:
        work = Path(folder)
        chromium = driver.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = chromium.new_page(viewport={"width": 1280, "height": 900})
        for name, source in sources.items():
            html, model = work / f"{name}.html", work / f"{name}.mbs"
            config = work / f"{name}.yaml"
            run("init", str(source), "-o", str(config))
            run("report", str(config), "-o", str(html))
            photograph(page, html, name)
            run("convert", str(source), "--pipeline", "compact", "-o", str(model))
            run("diagram", str(model), "-o", str(OUT / f"{name}.svg"))
            if name == "biped":
                page.goto(html.as_uri())
                page.wait_for_timeout(1500)
                png = page.screenshot()
                (OUT / "report.png").write_bytes(compressed(png, 960))
        chromium.close()


if __name__ == "__main__":
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
