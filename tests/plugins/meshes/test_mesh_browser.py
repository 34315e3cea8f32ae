"""A VRML reader that is not ours: VRMLLoader of npm's ``three``, in Chromium.

Nothing is fetched: the page, three.js and the meshes are handed to the browser from memory.
Wants the npm package ``three``, in a ``node_modules`` folder at or above this file, or named by
NODE_PATH.
"""

from __future__ import annotations

import mimetypes
import os
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

import pytest

from support.meshes import wrl
from support.meshes.robot import convert, visual
from support.meshes.samples import SAMPLES, TRIANGLES

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Route

pytestmark = pytest.mark.slow

HOST = "http://meshes.test"

PAGE = """<!doctype html><link rel="icon" href="data:,">
<script type="importmap">
{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}
</script>
<script type="module">
import { LoadingManager } from "three";
import { VRMLLoader } from "three/addons/loaders/VRMLLoader.js";
window.load = async (url) => {
  const manager = new LoadingManager();
  const idle = new Promise((resolve, reject) => {
    manager.onLoad = resolve;
    manager.onError = (what) => reject(new Error("cannot load " + what));
  });
  const scene = await new VRMLLoader(manager).loadAsync(url);
  await idle;
  const parts = [];
  scene.traverse((mesh) => {
    if (!mesh.isMesh) return;
    const { position, color, uv } = mesh.geometry.attributes;
    const at = [...position.array], rgb = new Set();
    const shade = (c) => "#" + c.getHexString();
    if (color) for (let i = 0; i < color.count; i++)
      rgb.add(shade(mesh.material.color.clone().fromBufferAttribute(color, i)));
    const index = mesh.geometry.index?.array ?? [...Array(position.count).keys()];
    const map = mesh.material.map;
    parts.push({
      corners: index.length, at: [...index].flatMap((k) => at.slice(3 * k, 3 * k + 3)),
      diffuse: shade(mesh.material.color), colors: [...rgb], opacity: mesh.material.opacity,
      texture: map ? [map.image.width, map.image.height, uv !== undefined] : null,
    });
  });
  return parts;
};
window.ready = true;
</script>
"""


def three() -> Path | None:
    """Return the folder of npm's three."""
    places = [Path(place) for place in os.environ.get("NODE_PATH", "").split(os.pathsep) if place]
    places += [folder / "node_modules" for folder in Path(__file__).resolve().parents]
    return next((place / "three" for place in places if (place / "three").is_dir()), None)


Load = Callable[[dict[str, bytes], str], Any]


@pytest.fixture
def load(browser: Browser) -> Iterator[Load]:
    """Load a file beside others; return what three.js made of each of its meshes."""
    package = three()
    if package is None:
        pytest.skip("no npm package three: npm install three@0.187.0")
    files: dict[str, bytes] = {}
    complaints: list[str] = []

    def answer(route: Route) -> None:
        path = route.request.url.removeprefix(HOST)
        if path == "/":
            route.fulfill(body=PAGE, content_type="text/html")
        elif path.startswith("/three/"):
            body = (package / path.removeprefix("/three/")).read_bytes()
            route.fulfill(body=body, content_type="text/javascript")
        elif (name := PurePosixPath(path).name) in files:
            kind = mimetypes.guess_type(path)[0] or "text/plain"
            route.fulfill(body=files[name], content_type=kind)
        else:
            route.fulfill(status=404)

    page = browser.new_page()
    page.route("**/*", answer)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    page.goto(HOST + "/")
    page.wait_for_function("window.ready")

    def load(given: dict[str, bytes], name: str) -> Any:
        files.clear()
        files.update(given)
        parts = page.evaluate("(url) => window.load(url)", f"{HOST}/files/{name}")
        assert complaints == []
        return parts

    yield load
    page.close()


def _hex(rgb: tuple[int, ...]) -> str:
    return "#{:02x}{:02x}{:02x}".format(*rgb)


def _compare(parts: Any, data: bytes) -> None:
    """Assert that three.js has read what the file holds."""
    shapes = wrl.read(data)
    assert len(parts) == len(shapes)
    for part, shape in zip(parts, shapes, strict=True):
        corners = shape.points[shape.faces].reshape(-1, 3)
        assert part["corners"] == len(corners)
        flat = corners.ravel().tolist()
        assert max(abs(a - b) for a, b in zip(part["at"], flat, strict=True)) == 0.0
        colors = part["colors"] or [part["diffuse"]]
        assert set(colors) == {_hex(rgb) for rgb in shape.rgb}
        assert (part["texture"] is not None) == (shape.texture is not None)
        clear = shape.material.get("transparency", [0.0])[0]
        assert part["opacity"] == pytest.approx(1 - clear)


def test_every_file_that_the_tests_write(load: Load, tmp_path: Path) -> None:
    scales = [(1.0, 1.0, 1.0), (1.0, -1.0, 1.0)]
    for sample in SAMPLES:
        mesh = sample.write(tmp_path / sample.name)
        conversion = convert(
            tmp_path, [visual(mesh, scale, (0.8, 0.4, 0.2, 0.5)) for scale in scales]
        )
        files = {path.name: data for path, data in conversion.files.items()}
        meshes = [name for name in files if name.endswith(".wrl")]
        assert len(meshes) == len(scales)
        for name in meshes:
            parts = load(files, name)
            _compare(parts, files[name])
            assert sum(part["corners"] for part in parts) == 3 * len(TRIANGLES)
            expected = {_hex(rgb) for rgb in sample.colors} or {"#cc6633"}
            assert {c for p in parts for c in p["colors"] or [p["diffuse"]]} == expected
            assert [p["texture"] for p in parts] == [
                [4, 2, True] if sample.texture else None
            ] * len(parts)
