"""Every format, read and written, gives the same box with the colours that the file states."""

import io
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from support.meshes import wrl
from support.meshes.samples import (
    HIGH,
    LOW,
    OBJ_FACES,
    SAMPLES,
    TRIANGLES,
    VOLUME,
    Sample,
    dae_text,
    dae_textured_text,
    effect,
    image,
    obj_lines,
    stl_ascii_text,
)
from support.meshes.samples import write as write_sample
from urdf2mbs_meshes.model import NO_PILLOW, Mesh, MeshError
from urdf2mbs_meshes.reader import read_mesh
from urdf2mbs_meshes.vrml import write_vrml

#: What the URDF says, for parts without a colour of their own: 0.8, 0.4, 0.2.
URDF_COLOR = (0.8, 0.4, 0.2)


def converted(path: Path) -> tuple[Mesh, list[wrl.Shape]]:
    mesh = read_mesh(path)
    return mesh, wrl.read(b"".join(write_vrml(mesh.parts, URDF_COLOR, 0.25)))


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.name)
def test_each_format_keeps_box_points_colours_and_texture(sample: Sample, tmp_path: Path) -> None:
    """Its box, points, colours and texture."""
    mesh, shapes = converted(sample.write(tmp_path))
    triangles = wrl.corners(shapes)
    assert len(triangles) == len(TRIANGLES)
    np.testing.assert_allclose(triangles.min((0, 1)), LOW, rtol=2e-7)
    np.testing.assert_allclose(triangles.max((0, 1)), HIGH, rtol=2e-7)
    assert wrl.volume(triangles) == pytest.approx(VOLUME, rel=1e-6)
    for shape in shapes:  # equal points are written once
        assert len(np.unique(shape.points, axis=0)) == len(shape.points)
        assert set(shape.faces.ravel()) == set(range(len(shape.points)))
    assert len(shapes) > 1 or len(shapes[0].points) == 8
    assert set().union(*(shape.rgb for shape in shapes)) == (sample.colors or {(204, 102, 51)})
    if not sample.colors:
        assert all(shape.material["transparency"] == [0.25] for shape in shapes)
    assert mesh.problems == []
    assert len(mesh.textures) == sample.texture
    for name, data in mesh.textures.items():
        assert all(shape.texture == name and shape.uv is not None for shape in shapes)
        assert Image.open(io.BytesIO(data)).format == {".png": "PNG", ".jpg": "JPEG"}[name[-4:]]


@pytest.mark.parametrize(("name", "flip"), [("ply_texture", False), ("glb_texture", True)])
def test_texture_coordinates_start_in_the_lower_left(tmp_path: Path, name: str, flip: bool) -> None:
    # as in .ply; glTF's start in the upper left, and so are turned over
    _, (shape,) = converted(write_sample(name, tmp_path))
    assert shape.uv is not None
    points = shape.points[shape.faces]
    np.testing.assert_array_equal(shape.uv[..., 0], points[..., 0] == HIGH[0])
    np.testing.assert_array_equal(shape.uv[..., 1], (points[..., 1] == HIGH[1]) != flip)


@pytest.mark.parametrize("name", ["obj_texture_jpg", "glb_texture"])
def test_without_pillow_a_mesh_has_no_texture(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """trimesh, which says nothing of it, has its own import of pillow."""
    monkeypatch.setitem(sys.modules, "PIL", None)
    for module in [name for name in sys.modules if name.partition(".")[0] == "trimesh"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.delitem(sys.modules, "urdf2mbs_meshes.by_trimesh", raising=False)
    mesh = read_mesh(write_sample(name, tmp_path))
    assert mesh.parts
    assert (mesh.textures, set(mesh.problems)) == ({}, {NO_PILLOW})


def test_a_texture_keeps_its_bytes_or_its_pixels(tmp_path: Path) -> None:
    for name, format_ in (("maple.jpg", "JPEG"), ("maple.tif", "TIFF")):
        (tmp_path / name).write_bytes(image(format_))
        (tmp_path / "box.dae").write_text(dae_textured_text(name))
        (data,) = read_mesh(tmp_path / "box.dae").textures.values()
        assert (data == image(format_)) == (format_ == "JPEG")
        with (
            Image.open(io.BytesIO(data)) as picture,
            Image.open(io.BytesIO(image(format_))) as original,
        ):
            assert picture.tobytes() == original.tobytes()


def test_equal_texture_names_of_unequal_images(tmp_path: Path) -> None:
    names = set()
    for folder, size in (("a", (2, 2)), ("b", (4, 4)), ("c", (4, 4))):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "maple.png").write_bytes(image("PNG", size))
        (tmp_path / folder / "box.dae").write_text(dae_textured_text())
        names |= set(read_mesh(tmp_path / folder / "box.dae").textures)
    assert len(names) == 2


def test_texture_that_is_no_image(tmp_path: Path) -> None:
    (tmp_path / "maple.png").write_bytes(b"no image")
    (tmp_path / "box.dae").write_text(dae_textured_text())
    mesh, (shape,) = converted(tmp_path / "box.dae")
    assert "maple.png" in mesh.problems[0]
    assert shape.texture is None
    assert shape.rgb == {(204, 102, 51)}


@pytest.mark.parametrize(
    ("more", "transparency"),
    [
        ("", 0.0),
        ("<transparency><float>0.25</float></transparency>", 0.75),
        ("<transparent><color>0 0 0 0.5</color></transparent>", 0.5),
        (
            '<transparent opaque="RGB_ZERO"><color>1 1 1 1</color></transparent>'
            "<transparency><float>0.25</float></transparency>",
            0.25,
        ),
        (
            '<transparent opaque="RGB_ZERO"><color>1 1 1 1</color></transparent>'
            "<transparency><float>0</float></transparency>",
            0.0,
        ),
        # meant "opaque" by who wrote it, as nobody writes a mesh that cannot be seen
        ("<transparency><float>0</float></transparency>", 0.0),
    ],
)
def test_transparency_of_collada_is_read(tmp_path: Path, more: str, transparency: float) -> None:
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


def test_smooth_only_where_the_source_is(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_text(stl_ascii_text())
    (tmp_path / "a.obj").write_text(obj_lines(["f 1 2 3"]))
    assert "creaseAngle" not in converted(tmp_path / "a.stl")[1][0].fields
    assert converted(tmp_path / "a.obj")[1][0].fields["creaseAngle"] == ["0.5"]


# --- what is broken is named; a broken look costs no shape ----------------------------------------


def mesh_of(folder: Path, name: str, content: str | bytes) -> Mesh:
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    (folder / "maple.png").write_bytes(image("PNG"))
    return read_mesh(folder / name)


def count(mesh: Mesh) -> int:
    return sum(len(part.triangles) for part in mesh.parts)


def replaced(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        # after example-robot-data's anymal_foot.dae
        ("<source>surf</source>", "<source>gone</source>"),
        ("<source>surf</source>", "<source/>"),
        ("<init_from>img</init_from>", "<init_from>gone</init_from>"),
        ('texture="samp"', ""),
        ('url="#m-fx"', 'url="#gone"'),
        ('<material id="m">', '<material id="gone">'),
        ('target="#m"', ""),
    ],
)
def test_a_broken_look_in_collada(tmp_path: Path, old: str, new: str) -> None:
    mesh = mesh_of(tmp_path, "a.dae", replaced(dae_textured_text(), old, new))
    assert count(mesh) == len(TRIANGLES)
    assert mesh.parts[0].material.texture is None
    assert mesh.problems


def test_a_broken_shape_in_collada(tmp_path: Path) -> None:
    text = replaced(dae_textured_text(), "0 0 1 0 1 1 0 1", "0 0 1 0 1 1")
    with pytest.raises(MeshError, match="it holds no triangles; "):
        mesh_of(tmp_path, "a.dae", text)


@pytest.mark.parametrize(
    "broken",
    [
        "<library_lights><light id='l'><technique_common/></light></library_lights>",
        "<library_cameras><camera id='c'/></library_cameras>",
        "<library_animations><animation><source id='s'/></animation></library_animations>",
        "<library_controllers><controller id='k'><skin source='#g'/></controller>"
        "</library_controllers>",
    ],
)
def test_what_is_no_shape_is_not_looked_at(tmp_path: Path, broken: str) -> None:
    text = replaced(dae_text(), "<library_geometries>", f"{broken}<library_geometries>")
    for instance in ("light", "camera"):
        text = text.replace('<node id="n">', f'<node id="n"><instance_{instance} url="#gone"/>')
    mesh = mesh_of(tmp_path, "a.dae", text)
    assert count(mesh) == len(TRIANGLES)
    assert mesh.problems == []


def test_skinned_parts_are_told_of(tmp_path: Path) -> None:
    text = replaced(dae_text(), '<node id="n">', '<node id="n"><instance_controller url="#k"/>')
    mesh = mesh_of(tmp_path, "a.dae", text)
    assert count(mesh) == len(TRIANGLES)
    assert mesh.problems == ["its skinned parts (instance_controller) are left out"]


PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
element edge {}
property int vertex1
property int vertex2
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
{}
"""


@pytest.mark.parametrize(
    ("name", "text", "lost"),
    [
        ("a.obj", obj_lines(["f 1 2 3", "l 1 2"]), True),
        ("a.obj", obj_lines(["f 1 2 3", "  l\t-1 -2 -3"]), True),
        ("a.obj", obj_lines(["f 1 2 3", "p 1"]), True),
        ("a.obj", obj_lines(["f 1 2 3"], "# l 1 2\no p 1\ng l 1\n"), False),
        ("a.ply", PLY.format(1, "0 1"), True),
        ("a.ply", PLY.format(0, ""), False),
        ("a.dae", replaced(dae_text(), "</mesh>", '<lines count="0"/></mesh>'), True),
        ("a.dae", dae_text(), False),
    ],
)
def test_lines_and_points_beside_triangles_are_told_of(
    tmp_path: Path, name: str, text: str, lost: bool
) -> None:
    mesh = mesh_of(tmp_path, name, text)
    assert count(mesh) > 0
    assert mesh.problems == (["its lines and points are left out"] if lost else [])


def test_a_mesh_of_lines_alone_says_so(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="no triangles; its lines and points are left out"):
        mesh_of(tmp_path, "a.obj", obj_lines(["l 1 2 3"]))


@pytest.mark.parametrize("name", ["a.obj", "a.mtl"])
def test_comments_in_latin_1_are_read(tmp_path: Path, name: str) -> None:
    (tmp_path / "a.mtl").write_bytes(b"newmtl red\nKd 1 0 0\n")
    text = obj_lines(["usemtl red", *OBJ_FACES], "mtllib a.mtl\n").encode()
    (tmp_path / "a.obj").write_bytes(text)
    comment = "# für die Nadel\n".encode("latin-1")
    (tmp_path / name).write_bytes(comment + (tmp_path / name).read_bytes())
    mesh = read_mesh(tmp_path / "a.obj")
    assert count(mesh) == len(TRIANGLES)
    assert mesh.parts[0].material.diffuse == (1.0, 0.0, 0.0)


def test_a_transparency_that_is_no_number(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\nd half\n")
    mesh = mesh_of(tmp_path, "a.obj", obj_lines(["usemtl red", *OBJ_FACES], "mtllib a.mtl\n"))
    assert count(mesh) == len(TRIANGLES)
    assert mesh.parts[0].material.transparency is None
    assert mesh.problems == ["the transparency of a material is not a number"]


def test_one_triangle_that_cannot_be_drawn(tmp_path: Path) -> None:
    text = stl_ascii_text()
    first = text.index("vertex")
    broken = f"{text[:first]}vertex nan 0 0{text[text.index(chr(10), first) :]}"
    mesh = mesh_of(tmp_path, "a.stl", broken)
    assert count(mesh) == len(TRIANGLES) - 1
    assert mesh.problems == ["a coordinate of 1 triangle is not a finite single-precision number"]
