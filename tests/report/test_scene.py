"""What the 3D view is given: .wrl files read back, meshes packed, both sides as they state it."""

from __future__ import annotations

import base64
import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from meshes.samples import dae_y_up_centimetres
from report.shown import data, shown

from urdf2mbs.mbs.reader import read
from urdf2mbs.meshes import reader as meshes
from urdf2mbs.meshes import vrml
from urdf2mbs.meshes.reader import MeshError
from urdf2mbs.report.scene import Store, lookup, mbs_side, read_vrml, urdf_side
from urdf2mbs.urdf.packages import Packages

HEAD = b"#VRML V2.0 utf8\n"
SQUARE = b"coord Coordinate { point [0 0 0, 1 0 0, 1 1 0, 0 1 0] } coordIndex [0 1 2 3 -1 0 2 3 -1]"


def wrl(faces: bytes, look: bytes = b"") -> bytes:
    return HEAD + b"Shape { appearance Appearance { %s } geometry IndexedFaceSet { %s } }" % (
        look,
        faces,
    )


def test_polygons_become_fans() -> None:
    (part,) = read_vrml(wrl(SQUARE))
    assert part.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 2, 3]]
    assert part.points[2].tolist() == [1, 1, 0]


def test_a_last_face_needs_no_end() -> None:
    (part,) = read_vrml(wrl(SQUARE.removesuffix(b"-1]") + b"]"))
    assert len(part.triangles) == 3


def test_material_and_texture() -> None:
    look = (
        b"material Material { diffuseColor 1 .5 0 transparency .25 } "
        b'texture ImageTexture { url ["a \\"b\\".png"] }'
    )
    (part,) = read_vrml(
        wrl(
            SQUARE + b" texCoord TextureCoordinate { point [0 0 1 0 1 1 0 1] } creaseAngle .5", look
        )
    )
    assert part.material.diffuse == (1, 0.5, 0)
    assert part.material.transparency == 0.25
    assert part.material.texture == 'a "b".png'
    assert part.smooth
    assert part.uv is not None
    assert part.uv[1].tolist() == [[0, 0], [1, 1], [0, 1]]


def test_colours_by_face_and_by_corner() -> None:
    palette = b" color Color { color [1 0 0 0 0 1] } "
    (faces,) = read_vrml(wrl(SQUARE + palette + b"colorPerVertex FALSE colorIndex [1 0]"))
    assert faces.colors is not None
    assert faces.colors.tolist() == [[0, 0, 255], [0, 0, 255], [255, 0, 0]]
    (corners,) = read_vrml(wrl(SQUARE + palette + b"colorIndex [0 0 1 1 -1 0 1 1 -1]"))
    assert corners.colors is not None
    assert corners.colors[2].tolist() == [[255, 0, 0], [0, 0, 255], [0, 0, 255]]


def test_transforms_names_and_comments() -> None:
    text = HEAD + b"""# a comment with { and "
    DEF A Transform { translation 1 2 3 rotation 0 0 1 1.5707963267948966 scale 2 2 2
      children [ # nested
        DEF S Shape { geometry IndexedFaceSet { %s } } Group { children USE S }
        Transform { translation 5 0 0 children [ USE S ] } ] }
    """ % SQUARE  # fmt: skip
    parts = read_vrml(text)
    places = [part.points[1] for part in parts]
    np.testing.assert_allclose(places, [[1, 4, 3], [1, 4, 3], [1, 14, 3]], atol=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"solid x\n",
        HEAD,
        HEAD + b"Shape { geometry Box { size 1 1 1 } }",
        wrl(SQUARE)[:-20],
        wrl(SQUARE.replace(b"0 2 3", b"0 2 9")),
        wrl(SQUARE.replace(b"1 1 0", b"1 x 0")),
        HEAD + b"Shape { geometry USE nobody }",
        HEAD + b"Group { children [ " * 5000,
    ],
)
def test_what_is_no_vrml_is_an_error(text: bytes) -> None:
    with pytest.raises(MeshError):
        read_vrml(text)


def unpack(store: Store, place: list[int]) -> Any:
    """A packed array, as the page unpacks it."""
    everything = gzip.decompress(base64.b64decode(store.packed()))
    at, length, differences = place
    planes = np.frombuffer(everything[at : at + 4 * length], np.uint8).reshape(4, length)
    words = np.ascontiguousarray(planes.T).view("<u4").ravel()
    if differences:
        steps = (words >> 1).astype(np.int64) ^ -(words & 1).astype(np.int64)
        words = np.cumsum(steps).astype("<u4")
    return words


def test_arrays_come_back_and_are_stored_once() -> None:
    text = wrl(SQUARE + b" color Color { color [1 0 0 0 0 1 0 1 0 1 1 1] } ")
    store = Store()
    first = store.wrl("a.wrl", lambda url: text)
    again = store.wrl("b.wrl", lambda url: text)
    assert (first, again) == (0, 1)
    assert store.meshes[0] == store.meshes[1]
    (part,) = store.meshes[0]
    points = unpack(store, part["points"]).view("<f4").reshape(-1, 3)
    triangles = unpack(store, part["triangles"])
    colors = unpack(store, part["colors"])
    (read_back,) = read_vrml(text)
    assert (
        points[triangles].tolist() == read_back.points[read_back.triangles].reshape(-1, 3).tolist()
    )
    assert colors[:3].tolist() == [0xFF0000, 0x0000FF, 0x00FF00]


def test_a_file_is_read_once() -> None:
    asked: list[str] = []

    def fetch(url: str) -> bytes | None:
        asked.append(url)
        return None

    store = Store()
    assert store.wrl("PRJPATH/a.wrl", fetch) is store.wrl("PRJPATH/a.wrl", fetch) is None
    assert asked == ["PRJPATH/a.wrl"]
    assert "PRJPATH/a.wrl" in store.missing


@pytest.mark.parametrize("name", ["leo", "r2d2", "atlas"])
def test_wrl_and_source_are_the_same_triangles(shared: Path, tmp_path: Path, name: str) -> None:
    """Stored once, because both sides give the very same arrays."""
    pytest.importorskip("trimesh")
    conversion = shown(name, tmp_path)
    store = Store()
    model = read(data(conversion), "m.mbs")
    mbs_side(model, store, lookup(conversion.files, tmp_path))
    half = len(store.meshes)
    packed = store.packed()
    packages = Packages(conversion.settings.packages, conversion.settings.source)
    for link in conversion.robot.links.values():
        link.collisions = []  # an .mbs has none
    urdf_side(conversion.robot, store, packages.resolve)
    assert len(store.meshes) == 2 * half > 0
    assert store.packed() == packed


def test_the_page_reads_what_convert_meshes_writes(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    source = tmp_path / "tetra.obj"
    source.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    parts = meshes.read(source).parts
    written = HEAD + vrml.write(parts, (0.2, 0.4, 0.6), 0.5)
    (part,) = read_vrml(written)
    (given,) = parts
    assert part.material.diffuse == (0.2, 0.4, 0.6)
    assert part.material.transparency == 0.5
    np.testing.assert_array_equal(
        part.points[part.triangles].astype(np.float32),
        given.points[given.triangles].astype(np.float32),
    )


def test_the_urdf_side_is_drawn_as_rviz_does(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    mesh = dae_y_up_centimetres(tmp_path)
    store = Store()
    number = store.source(mesh.name, mesh)
    assert number is not None
    (part,) = store.meshes[number]
    (unturned,) = meshes.read(mesh, up_axis=False).parts
    points = unpack(store, part["points"]).view("<f4").reshape(-1, 3)
    np.testing.assert_allclose(
        points[unpack(store, part["triangles"])].max(0), unturned.points.max(0)
    )


def test_without_the_extra_the_place_is_shown_and_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_trimesh(path: Path, *, up_axis: bool = True) -> meshes.Mesh:
        raise meshes.missing_extra(ImportError("no", name="trimesh"))

    monkeypatch.setattr(meshes, "read", no_trimesh)
    store = Store()
    assert store.source("a.stl", tmp_path / "a.stl") is None
    assert "pip install" in store.missing["a.stl"]
