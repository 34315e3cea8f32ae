"""Meshes that are cut off, empty, huge, or lie: a shape that can be drawn, or one clear warning."""

import base64
import json
import logging
import re
import socket
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from support.build import link, robot, solid
from support.meshes.samples import dae_text
from urdf2mbs.api import Result, convert
from urdf2mbs_meshes import model, vrml
from urdf2mbs_meshes.model import MeshError
from urdf2mbs_meshes.reader import read_mesh

NAN, INF = float("nan"), float("inf")
TRIANGLE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0)


def stl(said: int, *triangles: tuple[float, ...], more: bytes = b"") -> bytes:
    packed = (struct.pack("<12fH", 0, 0, 1, *points, 0) for points in triangles)
    return b"\0" * 80 + struct.pack("<I", said) + b"".join(packed) + more


def ply(points: int, faces: int, body: str, kind: str = "ascii") -> bytes:
    return (
        f"ply\nformat {kind} 1.0\nelement vertex {points}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {faces}\nproperty list uchar int vertex_indices\n"
        f"end_header\n{body}"
    ).encode()


def obj(*lines: str) -> bytes:
    return "\n".join(["v 0 0 0", "v 1 0 0", "v 0 1 0", *lines]).encode()


def gltf(change: Callable[[Any], Any] = lambda _: None) -> bytes:
    data = struct.pack("<9f", *TRIANGLE)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    document: Any = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"byteLength": 36, "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    }
    change(document)
    return json.dumps(document).encode()


def accessor(**changed: Any) -> bytes:
    return gltf(lambda document: document["accessors"][0].update(changed))


def dae(old: str = "", new: str = "") -> bytes:
    text = dae_text()
    assert old in text
    return text.replace(old, new, 1).encode()


def copies(depth: int, last: str = "", leaf: str = '<instance_geometry url="#g"/>') -> bytes:
    """A COLLADA file whose node stands for 2 to the power of ``depth`` copies of its last one."""
    nodes = "".join(
        f'<node id="n{n}"><instance_node url="#n{n + 1}"/><instance_node url="#n{n + 1}"/></node>'
        for n in reversed(range(depth))
    )
    nodes = f'<node id="n{depth}">{last}{leaf}</node>{nodes}'
    text = dae_text(node='<instance_node url="#n0"/>')
    scenes = "<library_visual_scenes>"
    assert scenes in text
    return text.replace(scenes, f"<library_nodes>{nodes}</library_nodes>{scenes}").encode()


def shared(times: int, count: int) -> bytes:
    """A glTF whose mesh has the same points so many times."""

    def change(document: Any) -> None:
        document["meshes"][0]["primitives"] *= times
        document["accessors"][0]["count"] = count

    return gltf(change)


#: What cannot be drawn at all, and words of the error.  Others' readers say a part of them.
LOST = {
    "empty.stl": (b"", "no triangles"),
    "empty.obj": (b"", "no triangles"),
    "empty.dae": (b"", "XMLSyntaxError"),
    "empty.ply": (b"", "Not a ply file"),
    "empty.glb": (b"", "glTF"),
    "empty.gltf": (b"", "JSONDecodeError"),
    "no_triangles.stl": (stl(0), "no triangles"),
    "half_a_header.stl": (b"\0" * 50, "no triangles"),
    "all_the_world.stl": (stl(2**32 - 1, TRIANGLE), "says 4294967295 triangles, and it has 1"),
    "one_too_many.stl": (stl(2, TRIANGLE), "says 2 triangles, and it has 1"),
    "cut_off.stl": (stl(2, TRIANGLE, more=b"\0" * 20), "says 2 triangles, and it has 1"),
    "solid_and_binary.stl": (b"solid" + stl(2, TRIANGLE)[5:], "says 2 triangles, and it has 1"),
    "text_cut_off.stl": (b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0", "no triangles"),
    "text_only.stl": (b"solid\n" + b"x" * 10_000, "no triangles"),
    "nan.stl": (stl(1, (NAN, *TRIANGLE[1:])), "not a finite"),
    "inf.stl": (stl(1, (*TRIANGLE[:8], -INF)), "not a finite"),
    "too_many_points.ply": (ply(10**12, 1, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "no triangles"),
    "too_many_in_binary.ply": (
        ply(10**9, 10**9, "\0" * 50, "binary_little_endian"),
        "unexpected length",
    ),
    "fewer_than_none.ply": (ply(-3, 1, "0 0 0\n"), "no triangles"),
    "a_face_beyond.ply": (ply(3, 1, "0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n"), "not there"),
    "nan.ply": (ply(3, 1, "nan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "not a finite"),
    "inf.ply": (ply(3, 1, "0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n"), "not a finite"),
    "a_face_beyond.obj": (obj("f 1 2 999999999"), "IndexError"),
    "a_face_before.obj": (obj("f 1 2 -9"), "IndexError"),
    "a_huge_index.obj": (obj("f 99999999999999999999 1 2"), "IndexError"),
    "nan.obj": (b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "not a finite"),
    "inf.obj": (b"v 0 0 0\nv 1 0 -inf\nv 0 1 0\nf 1 2 3", "not a finite"),
    "beyond_single.obj": (b"v 1e39 0 0\nv -1e308 0 0\nv 0 1 0\nf 1 2 3", "not a finite"),
    "too_many.gltf": (accessor(count=10**9), "far more points"),
    "zeros.gltf": (accessor(count=10**9, bufferView=None), "far more points"),
    "fewer_than_none.gltf": (accessor(count=-3), "no triangles"),
    "far_away.gltf": (accessor(byteOffset=10**12), "ValueError"),
    "before.gltf": (accessor(byteOffset=-12), "ValueError"),
    "deep.gltf": (b"[" * 100_000, "RecursionError"),
    "a_million_times.gltf": (shared(1000, 10**6), "far more points"),
    "long_words.glb": (
        b"glTF" + struct.pack("<III", 2, 2**32 - 1, 2**32 - 1) + b"JSON{}",
        "no triangles",
    ),
    "cut_off.glb": (b"glTF", "JSONDecodeError"),
    "a_face_beyond.dae": (dae("<p>0", "<p>99999999"), "no triangles"),
    # numpy before 2.3 reads the numbers before the word
    "no_index.dae": (dae("<p>", "<p>x"), "Corrupted index|it holds no triangles"),
    "an_entity.dae": (
        dae("<COLLADA", '<!DOCTYPE a [<!ENTITY b "c">]><COLLADA>&b;<COLLADA'),
        "XMLSyntaxError",
    ),
    "cut_off.dae": (dae()[:900], "XMLSyntaxError"),
    "no_xml.dae": (b"this is no XML", "XMLSyntaxError"),
    "a_page.dae": (b"<html><body>404</body></html>", "no scene"),
    "no_scene.dae": (dae().replace(b"visual_scene", b"other"), "no scene"),
    "no_faces.obj": (obj(), "no triangles"),
    "no_buffer.gltf": (
        b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "a.bin"}]}',
        "FileNotFoundError: a.bin",
    ),
    "draco.gltf": (
        gltf(lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"])),
        "KHR_draco_mesh_compression",
    ),
    "robot.step": (b"ISO-10303-21;", "'.step' is not known"),
    "copies.dae": (copies(40), "more than 100000 nodes"),
    "copies_of_nothing.dae": (copies(40, leaf=""), "more than 100000 nodes"),
    "of_itself.dae": (copies(3, '<instance_node url="#n0"/>'), "more than 100000 nodes"),
}
#: What has one triangle still, or as many as it holds.
KEPT = {
    "fewer_said.stl": stl(1, TRIANGLE, TRIANGLE),
    "more_behind.stl": stl(1, TRIANGLE, more=b"somebody's comment"),
    "solid_and_good.stl": b"solid" + stl(1, TRIANGLE)[5:],
    "one_bad.stl": stl(2, TRIANGLE, (NAN, *TRIANGLE[1:])),
    "fewer_faces.ply": ply(3, 10**10, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "count.dae": dae('count="', 'count="99999999999'),
    "some_copies.dae": copies(3),
    "of_itself.gltf": gltf(lambda d: d["nodes"][0].update(children=[0])),
}


@pytest.fixture(autouse=True)
def no_network(monkeypatch: pytest.MonkeyPatch) -> None:
    def opened(*_: Any, **__: Any) -> None:
        raise AssertionError("a socket is opened")

    monkeypatch.setattr(socket, "socket", opened)
    monkeypatch.setattr(socket, "create_connection", opened)
    monkeypatch.setattr(socket, "getaddrinfo", opened)


@pytest.mark.parametrize("name", LOST)
def test_a_mesh_that_cannot_be_drawn_is_one_error(name: str, tmp_path: Path, recwarn: Any) -> None:
    data, words = LOST[name]
    (tmp_path / name).write_bytes(data)
    with pytest.raises(MeshError) as caught:
        read_mesh(tmp_path / name)
    assert re.search(words, str(caught.value))
    assert "Module" not in str(caught.value)
    assert not recwarn.list


@pytest.mark.parametrize("name", KEPT)
def test_a_broken_mesh_keeps_what_can_be_drawn(name: str, tmp_path: Path, recwarn: Any) -> None:
    (tmp_path / name).write_bytes(KEPT[name])
    mesh = read_mesh(tmp_path / name)
    assert sum(len(part.triangles) for part in mesh.parts) >= 1
    assert vrml.write_vrml(mesh.parts, (0.5, 0.5, 0.5), 0.0)
    assert not recwarn.list


def convert_meshes(folder: Path, *filenames: str, **options: Any) -> Result:
    """Convert a robot that shows these meshes."""
    folder.mkdir(exist_ok=True)
    visuals = (
        f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in filenames
    )
    text = robot(link("a", solid(), *visuals))
    (folder / "r.urdf").write_text(text)
    return convert(
        folder / "r.urdf", output={"project": folder / "p"}, passes={"convert-meshes": options}
    )


def codes(result: Result) -> set[str]:
    return {one.code for one in result.diagnostics if one.level == "warning"}


def test_a_robot_with_all_broken_meshes_has_one_warning(tmp_path: Path) -> None:
    for name, data in {**KEPT, **{name: data for name, (data, _) in LOST.items()}}.items():
        (tmp_path / name).write_bytes(data)
    result = convert_meshes(tmp_path, *LOST, *KEPT)
    warnings = [one for one in result.diagnostics if one.code == "mesh-unreadable"]
    assert len(warnings) == 1
    assert warnings[0].message.startswith(f"{len(LOST)} meshes left out, as the file cannot")
    assert result.report.passes["convert-meshes"]["converted"] == len(KEPT)


@pytest.mark.parametrize(
    ("filename", "words"),
    [
        ("http://127.0.0.1:9/a.stl", "'http://' names are not known"),
        ("https://example.com/a.stl", "'https://' names are not known"),
        ("ftp://127.0.0.1/a.stl", "'ftp://' names are not known"),
        ("//127.0.0.1/share/a.stl", "//127.0.0.1/share/a.stl"),
        ("file://127.0.0.1/a.stl", "127.0.0.1"),
        ("data:model/stl;base64,AAAA", "data:"),
        ("C:\\robots\\a.stl", "C:\\robots\\a.stl"),
        ("C:/robots/a.stl", "C:/robots/a.stl"),
        ("\\\\server\\share\\a.stl", "server"),
        ("file:///C:/robots/a.stl", "C:/robots/a.stl"),
        ("../../../nowhere/a.stl", "nowhere"),
        ("/nowhere/a.stl", "/nowhere/a.stl"),
        ("package://../a.stl", "'..'"),
        ("package://no_package/../../a.stl", "'no_package'"),
        (".", "'.' (link a)"),
        ("x" * 5000, "xxx"),
    ],
)
def test_a_mesh_that_is_nowhere_is_said_to_be_missing(
    filename: str, words: str, tmp_path: Path
) -> None:
    result = convert_meshes(tmp_path / "robot", filename)
    (warning,) = (one for one in result.diagnostics if one.level == "warning")
    assert warning.code == "mesh-missing"
    assert words in str(warning)
    result.write()
    assert {file.name for file in tmp_path.iterdir()} == {"robot"}, "nothing outside"


def test_a_mesh_without_a_filename_is_left_out(tmp_path: Path) -> None:
    assert codes(convert_meshes(tmp_path, "")) == {"geometry-unknown"}


@pytest.mark.parametrize("name", ["http://127.0.0.1:9/a.mtl", "../away/a.bin", "//a/b"])
def test_what_a_mesh_names_is_never_fetched(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "robot"
    for each in (folder, tmp_path / "away"):
        each.mkdir()
    (tmp_path / "away" / "a.bin").write_bytes(bytes(1000))
    (folder / "a.obj").write_bytes(f"mtllib {name}\nusemtl m\n".encode() + obj("f 1 2 3"))
    image = f'<image id="i"><init_from>{name}</init_from></image>'
    (folder / "b.dae").write_text(dae_text(images=image))
    document = json.loads(gltf())
    document["buffers"][0]["uri"] = name
    (folder / "c.gltf").write_text(json.dumps(document))
    result = convert_meshes(folder, "a.obj", "b.dae", "c.gltf")
    assert result.report.passes["convert-meshes"]["converted"] == 2
    expected_suffixes = {".mbs", ".base", ".wrl", ".py", ".json", ".txt", ""}
    assert {file.suffix for file in result.conversion.files} <= expected_suffixes


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("a.bin", True),
        ("./below/a.bin", True),
        ("below%2Fa.bin", True),
        ("../away/a.bin", False),
        ("below/../../away/a.bin", False),
        ("..\\away\\a.bin", False),
        ("%2e%2e/away/a.bin", False),
        ("%252e%252e/away/a.bin", False),
        ("{away}/a.bin", False),
        ("file://{away}/a.bin", False),
        ("file:../away/a.bin", False),
        ("C:/away/a.bin", False),
    ],
)
def test_a_gltf_buffer_is_beside_the_mesh_or_below_it(
    name: str, read: bool, tmp_path: Path
) -> None:
    """Any file can be a buffer: one of the user's must not come to stand in a .wrl."""
    folder = tmp_path / "robot"
    points = struct.pack("<9f", *TRIANGLE)
    for each in (folder, folder / "below", tmp_path / "away"):
        each.mkdir()
        (each / "a.bin").write_bytes(points)
    document = json.loads(gltf())
    document["buffers"][0]["uri"] = name.format(away=tmp_path / "away")
    (folder / "c.gltf").write_text(json.dumps(document))
    result = convert_meshes(folder, "c.gltf")
    assert result.report.passes["convert-meshes"]["converted"] == int(read)
    warnings = [one for one in result.diagnostics if one.code == "mesh-unreadable"]
    assert bool(warnings) != read
    if warnings:
        assert "is not in the folder of the mesh, nor below it" in (warnings[0].hint or "")


def test_all_meshes_together_have_a_bound(tmp_path: Path) -> None:
    many = stl(6000, *[TRIANGLE] * 6000)  # 0.29 MiB
    for n in range(5):
        (tmp_path / f"{n}.stl").write_bytes(many)
    names = [f"{n}.stl" for n in range(5)]
    result = convert_meshes(tmp_path, *names, at_most=1)
    warnings = [one for one in result.diagnostics if one.code == "mesh-too-large"]
    assert len(warnings) == 1
    assert "2 meshes left out" in warnings[0].message
    assert "more than 1 MiB" in warnings[0].message
    assert "at_most: 4" in (warnings[0].hint or "")
    assert "mesh-too-large" not in codes(
        convert_meshes(tmp_path / "x", *[f"../{n}" for n in names])
    )


def test_the_triangles_and_parts_of_a_mesh_have_a_bound(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.dae").write_bytes(copies(6))
    read_mesh(tmp_path / "a.dae")
    for name, most in (("MAX_TRIANGLES", 100), ("MAX_PARTS", 20)):
        with monkeypatch.context() as patch:
            patch.setattr(model, name, most)
            with pytest.raises(MeshError, match=f"more than {most} (triangles|parts)"):
                read_mesh(tmp_path / "a.dae")


def test_a_texture_of_too_many_pixels_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from support.meshes.samples import image

    mesh = model.Mesh(tmp_path / "a.obj")
    assert mesh.add_texture(image("PNG"), "a.png")
    monkeypatch.setattr(model, "MAX_PIXELS", 2)
    assert mesh.add_texture(image("PNG"), "b.png") is None
    assert "more than 2 pixels" in mesh.problems[0]


def test_nothing_that_others_log_is_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setattr(logging.getLogger(), "handlers", [])
    (tmp_path / "a.stl").write_bytes(b"solid x\nfacet normal 0 0 \xff\nouter loop\nvertex 0")
    with pytest.raises(MeshError):
        read_mesh(tmp_path / "a.stl")
    assert capsys.readouterr().err == ""
