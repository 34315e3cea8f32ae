"""Every mesh of the real robots: bounding box and number of triangles, source against .wrl.

The source is read here a second time, by a few lines of our own a format, so that neither
trimesh nor pycollada is on both sides.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from plugins.meshes import wrl
from urdf2mbs_meshes.reader import FORMATS, read
from urdf2mbs_meshes.vrml import write

Box = tuple[int, np.ndarray, np.ndarray]
"""How many triangles, and the lower and upper corner of the box round them (m)."""


def stl(path: Path) -> Box:
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * count:
        facets = np.frombuffer(data, np.dtype("<12f4,<u2"), offset=84)["f0"]
        points = facets.reshape(-1, 4, 3)[:, 1:].reshape(-1, 3).astype(float)
    else:
        numbers = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", data)
        points = np.array(numbers, float)
    return len(points) // 3, points.min(0), points.max(0)


def obj(path: Path) -> Box:
    points, count, used = [], 0, set()
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            points.append([float(x) for x in rest[:3]])
        elif word == "f":
            count += len(rest) - 2
            used |= {int(corner.split("/")[0]) - 1 for corner in rest}
    table = np.array([points[k] for k in sorted(used)])
    return count, table.min(0), table.max(0)


def dae(path: Path) -> Box:
    root = ET.parse(path).getroot()
    space = root.tag.partition("}")[0] + "}"

    def found(at: ET.Element, *steps: str) -> list[ET.Element]:
        return at.findall("/".join(space + step for step in steps))

    unit = next((float(u.get("meter", 1)) for u in found(root, "asset", "unit")), 1.0)
    up = next((u.text for u in found(root, "asset", "up_axis")), "Y_UP")
    geometries = {g.get("id"): g for g in found(root, "library_geometries", "geometry")}
    count = 0
    clouds = []

    def walk(node: ET.Element, outer: np.ndarray) -> None:
        nonlocal count
        matrix = outer.copy()
        for child in node:
            kind = child.tag.removeprefix(space)
            if kind in ("matrix", "translate", "rotate", "scale"):
                values = np.array([float(x) for x in (child.text or "").split()])
                step = np.eye(4)
                if kind == "matrix":
                    step = values.reshape(4, 4)
                elif kind == "translate":
                    step[:3, 3] = values
                elif kind == "scale":
                    step[:3, :3] = np.diag(values)
                else:  # Rodrigues
                    x, y, z = values[:3] / np.linalg.norm(values[:3])
                    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                    a = np.radians(values[3])
                    step[:3, :3] = np.eye(3) + np.sin(a) * k + (1 - np.cos(a)) * k @ k
                matrix = matrix @ step
            elif kind == "node":
                walk(child, matrix)
            elif kind == "instance_geometry":
                (mesh,) = found(geometries[(child.get("url") or "")[1:]], "mesh")
                sources = {
                    s.get("id"): np.array((found(s, "float_array")[0].text or "").split(), float)
                    for s in found(mesh, "source")
                }
                (position,) = (
                    i for i in found(mesh, "vertices", "input") if i.get("semantic") == "POSITION"
                )
                points = sources[(position.get("source") or "")[1:]].reshape(-1, 3)
                for triangles in found(mesh, "triangles"):
                    inputs = found(triangles, "input")
                    (offset,) = (
                        int(i.get("offset", 0)) for i in inputs if i.get("semantic") == "VERTEX"
                    )
                    stride = 1 + max(int(i.get("offset", 0)) for i in inputs)
                    index = np.array((found(triangles, "p")[0].text or "").split(), int)
                    index = index.reshape(-1, stride)[:, offset]
                    count += len(index) // 3
                    cloud = points[index] @ matrix[:3, :3].T + matrix[:3, 3]
                    clouds.append(cloud)
                others = ("polylist", "polygons", "tristrips", "trifans")
                assert not [p for kind in others for p in found(mesh, kind)]

    for scene in found(root, "library_visual_scenes", "visual_scene"):
        walk(scene, np.eye(4))
    x, y, z = (unit * np.concatenate(clouds)).T
    points = np.stack({"Z_UP": (x, y, z), "Y_UP": (x, -z, y)}[up or ""], axis=1)
    return count, points.min(0), points.max(0)


READERS = {".stl": stl, ".obj": obj, ".dae": dae}


def test_every_mesh_of_every_robot(shared: Path) -> None:
    robots = shared / "robots"
    meshes = sorted(p for p in robots.rglob("*") if p.suffix.lower() in FORMATS)
    assert len(meshes) == 142
    wrong, small, large = [], 0, 0
    for path in meshes:
        count, low, high = READERS[path.suffix.lower()](path)
        data = b"".join(write(read(path).parts, (0.5, 0.5, 0.5), 0.0))
        triangles = wrl.corners(wrl.read(data))
        size = np.abs((low, high)).max()
        off = max(
            np.abs(triangles.min((0, 1)) - low).max(), np.abs(triangles.max((0, 1)) - high).max()
        )
        if len(triangles) != count or off > 1e-6 * size:  # pycollada's transforms are float32
            wrong.append((str(path.relative_to(robots)), len(triangles), count, off / size))
        small, large = small + len(data), large + path.stat().st_size
    assert not wrong
    assert small < 0.45 * large


@pytest.mark.parametrize(
    ("name", "length"), [("atlas", 1.1), ("leo_rover", 0.3), ("urdf_tutorial_r2d2", 0.11)]
)
def test_links_have_the_size_of_links(shared: Path, name: str, length: float) -> None:
    """A missed unit would be a factor of 100 or more."""
    robot = shared / "robots" / name
    sizes = [
        np.ptp(np.concatenate([part.points for part in read(path).parts]), axis=0).max()
        for path in robot.rglob("*.dae")
        # Atlas keeps a copy in a folder tmp that is 100 times as small
        if "tmp" not in path.relative_to(robot).parts
    ]
    assert length / 3 < max(sizes) < length * 3
