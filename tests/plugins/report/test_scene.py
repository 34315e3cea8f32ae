"""What the 3D view is given: .wrl files read back, meshes packed, both sides as they state it."""

import base64
import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.build import SOLID, joint, link, robot
from support.meshes import wrl
from support.meshes.samples import write
from support.pages.shown import data, shown
from urdf2mbs import convert
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.urdf.packages import Packages
from urdf2mbs_meshes import reader as meshes
from urdf2mbs_meshes import vrml_reader
from urdf2mbs_meshes.files import MeshFiles
from urdf2mbs_report.mesh_store import MeshStore
from urdf2mbs_report.page import make_robot_page
from urdf2mbs_report.scene import describe_mbs, describe_urdf, make_file_reader


def unpack(store: MeshStore, place: list[int]) -> Any:
    """Unpack an array as the page does."""
    everything = gzip.decompress(base64.b64decode(store.pack_arrays()))
    planes = np.frombuffer(everything, np.uint8, offset=place[0], count=4 * place[1])
    return np.ascontiguousarray(planes.reshape(4, -1).T).view("<u4").ravel()


def corners(store: MeshStore, part: dict[str, Any]) -> Any:
    """Return (3 m, 3) the corners of all triangles (m)."""
    steps = unpack(store, part["points"]).reshape(3, -1)
    points = part["low"] + part["step"] * (np.cumsum(steps, axis=1) & 65535).T
    indices: list[int] = []
    for back in unpack(store, part["triangles"]).tolist():
        indices.append(max(indices, default=-1) + 1 - back)
    return points[indices]


def test_arrays_come_back_and_are_stored_once() -> None:
    text = wrl.of(wrl.SQUARE + b" color Color { color [1 0 0 0 0 1 0 1 0 1 1 1] } ")
    store = MeshStore()
    first = store.add_mbs_mesh("a.wrl", lambda url: text)
    again = store.add_mbs_mesh("b.wrl", lambda url: text)
    assert (first, again) == (0, 1)
    assert store.meshes[0] == store.meshes[1]
    (part,) = store.meshes[0]
    colors = unpack(store, part["colors"])
    (read_back,) = vrml_reader.read_vrml(text).parts
    wanted = read_back.points[read_back.triangles].reshape(-1, 3)
    np.testing.assert_allclose(corners(store, part), wanted, rtol=0, atol=0.51 * part["step"])
    assert part["step"] == pytest.approx(np.ptp(wanted, axis=0).max() / 65535)
    assert colors[:3].tolist() == [0xFF0000FF, 0xFFFF0000, 0xFF00FF00]


@pytest.mark.parametrize("name", ["leo", "r2d2", "atlas"])
def test_wrl_and_source_are_the_same_triangles(shared: Path, tmp_path: Path, name: str) -> None:
    """Stored once, because both sides give the very same arrays."""
    conversion = shown(name, tmp_path)
    store = MeshStore()
    model = read_mbs(data(conversion), "m.mbs")
    describe_mbs(model, store, make_file_reader(conversion.files, tmp_path))
    half = len(store.meshes)
    packed = store.pack_arrays()
    packages = Packages(conversion.settings.packages, conversion.settings.source)
    for each in conversion.robot.links.values():
        each.collisions = []  # an .mbs has none
    describe_urdf(conversion.robot, store, MeshFiles(packages).find)
    assert len(store.meshes) == 2 * half > 0
    assert store.pack_arrays() == packed


def test_what_a_mesh_of_the_urdf_loses_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n")
    store = MeshStore()
    assert store.add_urdf_mesh("a.obj", tmp_path / "a.obj") is not None
    assert store.incomplete == {"a.obj": "its lines and points are left out"}


@pytest.mark.parametrize(("at_most", "read"), [(1, 2), (2, 5)])
def test_the_page_reads_as_much_as_the_config_says(tmp_path: Path, at_most: int, read: int) -> None:
    triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    links, joints = [], []
    for n in range(5):
        (tmp_path / f"{n}.obj").write_bytes(triangle + b"# a comment\n" * 30_000)  # 0.34 MiB
        mesh = f'<visual><geometry><mesh filename="{n}.obj"/></geometry></visual>'
        links.append(link(f"l{n}", SOLID, mesh))
        joints += [joint("l0", f"l{n}")] if n else []
    (tmp_path / "r.urdf").write_text(robot(*links, *joints))
    result = convert(tmp_path / "r.urdf", passes={"convert-meshes": {"at_most": at_most}})
    page = make_robot_page(result.conversion)
    assert page.missing == [f"{n}.obj" for n in range(read, 5)]
    told = f"more than {at_most} MiB, &#39;at_most&#39; of convert-meshes".encode()
    assert (told in page.data) == (read < 5)


def test_the_urdf_side_is_drawn_as_rviz_does(tmp_path: Path) -> None:
    mesh = write("dae_y_up_centimetres", tmp_path)
    store = MeshStore()
    number = store.add_urdf_mesh(mesh.name, mesh)
    assert number is not None
    (part,) = store.meshes[number]
    (unturned,) = meshes.read_mesh(mesh, up_axis=False).parts
    np.testing.assert_allclose(corners(store, part).max(0), unturned.points.max(0), rtol=1e-5)
