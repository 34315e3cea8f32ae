"""One broken detail of a mesh file costs that detail, and never a shape."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from meshes.samples import (
    TRIANGLES,
    dae_text,
    dae_textured_text,
    glb,
    glb_texture,
    gltf,
    image,
    obj_lines,
    stl_ascii_text,
)

from urdf2mbs.meshes.model import Mesh, MeshError
from urdf2mbs.meshes.reader import read

FACES = [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in TRIANGLES]


def mesh_of(folder: Path, name: str, content: str | bytes) -> Mesh:
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    (folder / "maple.png").write_bytes(image("PNG"))
    return read(folder / name)


def count(mesh: Mesh) -> int:
    return sum(len(part.triangles) for part in mesh.parts)


def replaced(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        # after example-robot-data's anymal_foot.dae
        ("<source>surf</source>", "<source>gone</source>", "effect 'm-fx'"),
        ("<source>surf</source>", "<source/>", "effect 'm-fx'"),
        ("<init_from>img</init_from>", "<init_from>gone</init_from>", "effect 'm-fx'"),
        ('texture="samp"', "", "effect 'm-fx'"),
        ('url="#m-fx"', 'url="#gone"', "material 'm'"),
        ('<material id="m">', '<material id="gone">', "instance_material '#m'"),
        ('target="#m"', "", "instance_material ''"),
        (
            '<input semantic="TEXCOORD" source="#t"',
            '<input semantic="TEXCOORD" source="#gone"',
            "g",
        ),
        ("0 0 1 0 1 1 0 1", "0 0 1 0 1 1", "geometry 'g'"),
        ("0 0 1 0 1 1 0 1", "0 0 1 zz 1 1 0 1", "geometry 'g'"),
    ],
)
def test_a_broken_look_in_collada(tmp_path: Path, old: str, new: str, told: str) -> None:
    mesh = mesh_of(tmp_path, "a.dae", replaced(dae_textured_text(), old, new))
    assert count(mesh) == len(TRIANGLES)
    assert mesh.parts[0].uv is None or mesh.parts[0].material.texture is None
    assert told in "\n".join(mesh.problems)


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


GOOD = '<input semantic="VERTEX" source="#v" offset="0"/>'


@pytest.mark.parametrize(
    "broken",
    [
        f'<triangles count="1">{GOOD}<p>0 1 99</p></triangles>',
        f'<triangles count="1">{GOOD}<p>0 1</p></triangles>',
        f'<triangles count="1">{GOOD}<p>0 1 x</p></triangles>',
        f'<triangles count="1">{GOOD}</triangles>',
        '<triangles count="1"><p>0 1 2</p></triangles>',
        f'<polylist count="1">{GOOD}<vcount>9</vcount><p>0 1 2</p></polylist>',
        f'<polylist count="1">{GOOD}<p>0 1 2</p></polylist>',
        "<unheard-of/>",
    ],
)
def test_one_bad_part_of_a_geometry(tmp_path: Path, broken: str) -> None:
    text = replaced(dae_text(), "</mesh>", f"{broken}</mesh>")
    mesh = mesh_of(tmp_path, "a.dae", text)
    assert count(mesh) == len(TRIANGLES)
    assert any("geometry 'g'" in problem for problem in mesh.problems)


@pytest.mark.parametrize(
    "broken",
    [
        '<instance_geometry url="#gone"/>',
        "<instance_geometry/>",
        '<instance_node url="#gone"/>',
        '<node><translate>0 0 x</translate><instance_geometry url="#g"/></node>',
        '<node><translate/><instance_geometry url="#g"/></node>',
    ],
)
def test_one_bad_node_of_a_scene(tmp_path: Path, broken: str) -> None:
    """A node that stands nobody knows where is left out: it would be in the wrong place."""
    text = replaced(dae_text(), '<node id="n">', f'<node id="n">{broken}')
    mesh = mesh_of(tmp_path, "a.dae", text)
    assert count(mesh) == len(TRIANGLES)
    assert len(mesh.problems) == 1


@pytest.mark.parametrize("url", ['url="#gone"', "", 'url="s"'])
def test_the_only_scene_is_shown(tmp_path: Path, url: str) -> None:
    text = replaced(dae_text(), '<instance_visual_scene url="#s"', f"<instance_visual_scene {url}")
    mesh = mesh_of(tmp_path, "a.dae", text)
    assert count(mesh) == len(TRIANGLES)
    assert mesh.problems == ["it does not say which scene it shows; it has one"]


def test_skinned_parts_are_told_of(tmp_path: Path) -> None:
    text = replaced(dae_text(), '<node id="n">', '<node id="n"><instance_controller url="#k"/>')
    mesh = mesh_of(tmp_path, "a.dae", text)
    assert count(mesh) == len(TRIANGLES)
    assert mesh.problems == ["its skinned parts (instance_controller) are left out"]


@pytest.mark.parametrize(
    "lines",
    [
        ["vt 0 zz", *FACES],
        ["vn 0 zz 1", *FACES],
        ["vn 0 0 1", *[f"{face}//7" for face in FACES]],
        [*FACES, "f 1 2 99"],
        [*FACES, "f 1 2 zz"],
        [*FACES, "f 1 2 -99"],
    ],
)
def test_one_bad_line_of_an_obj(tmp_path: Path, lines: list[str]) -> None:
    assert count(mesh_of(tmp_path, "a.obj", obj_lines(lines))) == len(TRIANGLES)


def test_an_obj_counts_from_the_end_and_its_plain_form_does_too(tmp_path: Path) -> None:
    last = [f"f {a - 8} {b - 8} {c - 8}" for a, b, c in TRIANGLES]
    mesh = mesh_of(tmp_path, "a.obj", obj_lines([*last, "f 1 2 99"]))
    (part,) = mesh.parts
    np.testing.assert_array_equal(
        part.points[part.triangles],
        (whole := mesh_of(tmp_path, "b.obj", obj_lines(FACES)).parts[0]).points[whole.triangles],
    )


@pytest.mark.parametrize("name", ["a.obj", "a.mtl"])
def test_an_obj_in_latin_1(tmp_path: Path, name: str) -> None:
    (tmp_path / "a.mtl").write_bytes(b"newmtl red\nKd 1 0 0\n")
    text = obj_lines(["usemtl red", *FACES], "mtllib a.mtl\n").encode()
    (tmp_path / "a.obj").write_bytes(text)
    comment = "# für die Nadel\n".encode("latin-1")
    (tmp_path / name).write_bytes(comment + (tmp_path / name).read_bytes())
    mesh = read(tmp_path / "a.obj")
    assert count(mesh) == len(TRIANGLES)
    assert mesh.parts[0].material.diffuse == (1.0, 0.0, 0.0)


def test_a_transparency_that_is_no_number(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\nd half\n")
    mesh = mesh_of(tmp_path, "a.obj", obj_lines(["usemtl red", *FACES], "mtllib a.mtl\n"))
    assert count(mesh) == len(TRIANGLES)
    assert mesh.parts[0].material.transparency is None
    assert mesh.problems == ["the transparency of a material is no number"]


def break_glb(data: bytes, change: Callable[[dict], None]) -> bytes:
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + length])
    change(document)
    return glb(document, data[28 + length :])


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d["accessors"][2].update(bufferView=99),
        lambda d: d["accessors"][2].update(count=99),
        lambda d: d["bufferViews"][3].pop("byteLength"),
        lambda d: d["materials"][0]["pbrMetallicRoughness"].update(baseColorTexture=7),
        lambda d: d["materials"].clear(),
        lambda d: d["textures"].clear(),
        lambda d: d.update(materials=3, images=None),
        lambda d: d["nodes"][0].update(camera=5, skin=7),
    ],
)
def test_a_broken_look_in_gltf(tmp_path: Path, change: Callable[[dict], None]) -> None:
    data = glb_texture(tmp_path).read_bytes()
    assert count(mesh_of(tmp_path, "a.glb", break_glb(data, change))) == len(TRIANGLES)


def test_one_bad_part_of_a_gltf(tmp_path: Path) -> None:
    document, buffer = gltf()
    shapes = document["meshes"][0]["primitives"]
    shapes.append({"attributes": {"POSITION": 99}})
    mesh = mesh_of(tmp_path, "a.glb", glb(document, buffer))
    whole = mesh_of(tmp_path, "b.glb", glb(*gltf()))
    assert count(mesh) == len(TRIANGLES)
    np.testing.assert_array_equal(mesh.parts[0].points, whole.parts[0].points)
    shapes.pop(0)
    with pytest.raises(MeshError, match="no part"):
        mesh_of(tmp_path, "c.glb", glb(document, buffer))


def test_one_triangle_that_cannot_be_drawn(tmp_path: Path) -> None:
    text = stl_ascii_text()
    first = text.index("vertex")
    broken = f"{text[:first]}vertex nan 0 0{text[text.index(chr(10), first) :]}"
    mesh = mesh_of(tmp_path, "a.stl", broken)
    assert count(mesh) == len(TRIANGLES) - 1
    assert mesh.problems == [
        "1 triangles have coordinates that are no finite single-precision numbers"
    ]
