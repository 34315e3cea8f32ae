"""Every format, read and written, gives the same box with the colours that the file states."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np
import pytest
from meshes import wrl
from meshes.samples import (
    HIGH,
    LOW,
    TRIANGLES,
    VOLUME,
    Sample,
    dae_text,
    dae_textured_text,
    effect,
    glb,
    gltf,
    image,
    obj_lines,
    ply_header,
    stl_ascii_text,
    stl_binary_data,
)
from meshes.samples import write as write_sample
from PIL import Image

from urdf2mbs.meshes.model import Mesh, MeshError
from urdf2mbs.meshes.reader import read
from urdf2mbs.meshes.vrml import write

#: What the URDF says, for parts without a colour of their own: 0.8, 0.4, 0.2.
URDF_COLOR = (0.8, 0.4, 0.2)


def converted(path: Path) -> tuple[Mesh, list[wrl.Shape]]:
    mesh = read(path)
    return mesh, wrl.read(b"".join(write(mesh.parts, URDF_COLOR, 0.25)))


def test_box(sample: Sample, mesh: Path) -> None:
    _, shapes = converted(mesh)
    triangles = wrl.corners(shapes)
    assert len(triangles) == len(TRIANGLES)
    np.testing.assert_allclose(triangles.min((0, 1)), LOW, rtol=2e-7)
    np.testing.assert_allclose(triangles.max((0, 1)), HIGH, rtol=2e-7)
    assert wrl.volume(triangles) == pytest.approx(VOLUME, rel=1e-6)


def test_equal_points_are_written_once(sample: Sample, mesh: Path) -> None:
    _, shapes = converted(mesh)
    for shape in shapes:
        assert len(np.unique(shape.points, axis=0)) == len(shape.points)
        assert set(shape.faces.ravel()) == set(range(len(shape.points)))
    if len(shapes) == 1:
        assert len(shapes[0].points) == 8


def test_colors(sample: Sample, mesh: Path) -> None:
    _, shapes = converted(mesh)
    found = set().union(*(shape.rgb for shape in shapes))
    assert found == (sample.colors or {(204, 102, 51)})
    if not sample.colors:
        assert [shape.material["transparency"] for shape in shapes] == [[0.25]] * len(shapes)


def test_texture(sample: Sample, mesh: Path) -> None:
    found, shapes = converted(mesh)
    assert found.problems == []
    assert len(found.textures) == sample.texture
    for name, data in found.textures.items():
        assert [shape.texture for shape in shapes] == [name] * len(shapes)
        assert Image.open(io.BytesIO(data)).format == {".png": "PNG", ".jpg": "JPEG"}[name[-4:]]
        assert all(shape.uv is not None for shape in shapes)


@pytest.mark.parametrize(("name", "flip"), [("ply_texture", False), ("glb_texture", True)])
def test_texture_coordinates_start_in_the_lower_left(tmp_path: Path, name: str, flip: bool) -> None:
    # as in .ply; glTF's start in the upper left, and so are turned over
    _, (shape,) = converted(write_sample(name, tmp_path))
    assert shape.uv is not None
    points = shape.points[shape.faces]
    np.testing.assert_array_equal(shape.uv[..., 0], points[..., 0] == HIGH[0])
    np.testing.assert_array_equal(shape.uv[..., 1], (points[..., 1] == HIGH[1]) != flip)


def test_copied_texture_keeps_its_bytes(tmp_path: Path) -> None:
    (tmp_path / "maple.jpg").write_bytes(image("JPEG"))
    (tmp_path / "box.dae").write_text(dae_textured_text("maple.jpg"))
    mesh = read(tmp_path / "box.dae")
    assert list(mesh.textures.values()) == [image("JPEG")]


def test_converted_texture_keeps_its_pixels(tmp_path: Path) -> None:
    (tmp_path / "maple.tif").write_bytes(image("TIFF"))
    (tmp_path / "box.dae").write_text(dae_textured_text("maple.tif"))
    (data,) = read(tmp_path / "box.dae").textures.values()
    with Image.open(io.BytesIO(data)) as found, Image.open(io.BytesIO(image("TIFF"))) as given:
        assert found.tobytes() == given.tobytes()


def test_equal_texture_names_of_unequal_images(tmp_path: Path) -> None:
    names = set()
    for folder, size in (("a", (2, 2)), ("b", (4, 4)), ("c", (4, 4))):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "maple.png").write_bytes(image("PNG", size))
        (tmp_path / folder / "box.dae").write_text(dae_textured_text())
        names |= set(read(tmp_path / folder / "box.dae").textures)
    assert len(names) == 2


def test_texture_that_is_no_image(tmp_path: Path) -> None:
    (tmp_path / "maple.png").write_bytes(b"no image")
    (tmp_path / "box.dae").write_text(dae_textured_text())
    mesh, (shape,) = converted(tmp_path / "box.dae")
    assert "maple.png" in mesh.problems[0]
    assert shape.texture is None
    assert shape.rgb == {(204, 102, 51)}


def test_collada_unit_and_up_axis_are_ours_alone(tmp_path: Path) -> None:
    """trimesh, which reads everything else here, applies neither."""
    import trimesh

    path = write_sample("dae_y_up_centimetres", tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        low, high = trimesh.load_scene(path).bounds
    np.testing.assert_allclose((low, high), ((100, 300, -400), (200, 600, -200)))
    triangles = wrl.corners(converted(path)[1])
    np.testing.assert_allclose(triangles.min((0, 1)), LOW, rtol=1e-6)


def test_up_axis_can_be_ignored_and_the_unit_still_counts(tmp_path: Path) -> None:
    mesh = read(write_sample("dae_y_up_centimetres", tmp_path), up_axis=False)
    points = mesh.parts[0].points
    np.testing.assert_allclose((points.min(0), points.max(0)), ((1, 3, -4), (2, 6, -2)), rtol=1e-6)


@pytest.mark.parametrize(
    ("more", "transparency"),
    [
        ("", 0.0),
        ("<transparency><float>0.25</float></transparency>", 0.75),
        ("<transparent><color>0 0 0 0.5</color></transparent>", 0.5),
        ('<transparent opaque="RGB_ZERO"><color>1 1 1 1</color></transparent>'
         "<transparency><float>0.25</float></transparency>", 0.25),
        ('<transparent opaque="RGB_ZERO"><color>1 1 1 1</color></transparent>'
         "<transparency><float>0</float></transparency>", 0.0),
        # meant "opaque" by who wrote it, as nobody writes a mesh that cannot be seen
        ("<transparency><float>0</float></transparency>", 0.0),
    ],
)  # fmt: skip
def test_collada_transparency(tmp_path: Path, more: str, transparency: float) -> None:
    path = tmp_path / "box.dae"
    primitives = (
        '<triangles count="1" material="m"><input semantic="VERTEX" source="#v" offset="0"/>'
        "<p>0 1 2</p></triangles>"
    )
    path.write_text(dae_text(primitives=primitives, effects={"m": effect((9, 9, 9), more)}))
    (shape,) = converted(path)[1]
    assert shape.material.get("transparency", [0.0]) == pytest.approx([transparency])


def test_mtl_transparency(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl glass\nKd 0 0 1\nd 0.25\n")
    (tmp_path / "a.obj").write_text(obj_lines(["usemtl glass", "f 1 2 3"], "mtllib a.mtl\n"))
    (shape,) = converted(tmp_path / "a.obj")[1]
    assert shape.material["transparency"] == [0.75]


DRACO = glb({**gltf()[0], "extensionsRequired": ["KHR_draco_mesh_compression"]}, gltf()[1])


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.stl", b""),
        ("cut.stl", stl_binary_data()[:-7]),
        ("noise.stl", bytes(range(256)) * 3),
        ("nan.stl", stl_ascii_text([(float("nan"), 0, 0)] * 8).encode()),
        ("huge.stl", stl_ascii_text([(1e39, 0, 0)] * 8).encode()),
        ("text.dae", b"this is no XML"),
        ("cut.dae", dae_text().encode()[:-200]),
        ("html.dae", b"<html><body>404</body></html>"),
        ("noscene.dae", dae_text().replace("visual_scene", "other").encode()),
        ("index.dae", dae_text(triangles=[(0, 1, 99)]).encode()),
        ("index.obj", obj_lines(["f 1 2 99"]).encode()),
        ("nofaces.obj", obj_lines([]).encode()),
        ("cut.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n"),
        ("cut.glb", glb(*gltf())[:200]),
        ("text.glb", b"no glTF at all, but long enough"),
        ("nobuffer.gltf", b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "a.bin"}]}'),
        ("draco.glb", DRACO),
        ("index.ply", ply_header("ascii").encode() + b"0 0 0\n" * 8 + b"3 0 1 99\n" * 12),
        ("robot.step", b"ISO-10303-21;"),
    ],
)
def test_unusable_files(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=r"\w"):
        read(tmp_path / name)


def test_smooth_only_where_the_source_is(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_text(stl_ascii_text())
    (tmp_path / "a.obj").write_text(obj_lines(["f 1 2 3"]))
    assert "creaseAngle" not in converted(tmp_path / "a.stl")[1][0].fields
    assert converted(tmp_path / "a.obj")[1][0].fields["creaseAngle"] == ["0.5"]
