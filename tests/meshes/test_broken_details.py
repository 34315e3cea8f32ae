"""What is broken in a mesh file is named; broken looks cost no shape."""

from __future__ import annotations

from pathlib import Path

import pytest
from meshes.samples import (
    TRIANGLES,
    dae_text,
    dae_textured_text,
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


def test_one_triangle_that_cannot_be_drawn(tmp_path: Path) -> None:
    text = stl_ascii_text()
    first = text.index("vertex")
    broken = f"{text[:first]}vertex nan 0 0{text[text.index(chr(10), first) :]}"
    mesh = mesh_of(tmp_path, "a.stl", broken)
    assert count(mesh) == len(TRIANGLES) - 1
    assert mesh.problems == ["a coordinate of 1 triangle is no finite single-precision number"]
