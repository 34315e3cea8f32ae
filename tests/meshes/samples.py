"""Small mesh files of every format, all of the same box, written without any mesh library.

After its unit, up axis and node transforms each is the box from LOW to HIGH, faces outward.
"""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

LOW, HIGH = (1.0, 2.0, 3.0), (2.0, 4.0, 6.0)
VOLUME = 6.0

#: Corner number k of the box has x high where k & 1, y where k & 2, z where k & 4.
CORNERS = [tuple((HIGH if k >> axis & 1 else LOW)[axis] for axis in range(3)) for k in range(8)]
#: The six sides, anticlockwise seen from outside: -x, +x, -y, +y, -z, +z.
SIDES = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
TRIANGLES = [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))]
#: A colour for each side, 0 to 255.
COLORS = [(200, 100, 50), (0, 255, 0), (0, 0, 255), (255, 255, 0), (10, 20, 30), (255, 255, 255)]

Points = list[tuple[float, ...]]


class Sample(NamedTuple):
    name: str
    write: Callable[[Path], Path]
    colors: frozenset[tuple[int, int, int]] = frozenset()
    """What the file states; empty: it leaves the colour to the URDF."""
    texture: bool = False


SAMPLES: list[Sample] = []


def sample(
    colors: list[tuple[int, int, int]] | None = None, texture: bool = False
) -> Callable[[Callable[[Path], Path]], Callable[[Path], Path]]:
    def register(write: Callable[[Path], Path]) -> Callable[[Path], Path]:
        SAMPLES.append(Sample(write.__name__, write, frozenset(colors or []), texture))
        return write

    return register


def image(format_: str, size: tuple[int, int] = (4, 2)) -> bytes:
    """A small picture whose pixels all differ."""
    from PIL import Image

    picture = Image.new("RGB", size)
    picture.putdata([(30 * k, 255 - 30 * k, 7 * k) for k in range(size[0] * size[1])])
    out = io.BytesIO()
    picture.save(out, format_)
    return out.getvalue()


# STL


def stl_ascii_text(points: Points = CORNERS) -> str:
    lines = ["solid box"]
    for triangle in TRIANGLES:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*points[k]) for k in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid box", ""])


def stl_binary_data(header: bytes = b"") -> bytes:
    data = header.ljust(80) + struct.pack("<I", len(TRIANGLES))
    for triangle in TRIANGLES:
        corners = [c for k in triangle for c in CORNERS[k]]
        data += struct.pack("<12fH", 0, 0, 0, *corners, 0)
    return data


@sample()
def stl_ascii(folder: Path) -> Path:
    path = folder / "ascii.stl"
    path.write_text(stl_ascii_text())
    return path


@sample()
def stl_binary(folder: Path) -> Path:
    path = folder / "binary.STL"
    path.write_bytes(stl_binary_data())
    return path


@sample()
def stl_binary_that_says_solid(folder: Path) -> Path:
    path = folder / "solid.stl"
    path.write_bytes(stl_binary_data(b"solid of some exporter"))
    return path


# OBJ


def obj_lines(faces: list[str], head: str = "") -> str:
    vertices = "\n".join("v {} {} {}".format(*c) for c in CORNERS)
    return f"{head}{vertices}\n" + "\n".join(faces) + "\n"


@sample()
def obj_triangles(folder: Path) -> Path:
    path = folder / "plain.obj"
    path.write_text(obj_lines([f"f {a + 1} {b + 1} {c + 1}" for a, b, c in TRIANGLES]))
    return path


@sample()
def obj_quads(folder: Path) -> Path:
    path = folder / "quads.obj"
    path.write_text(obj_lines(["f " + " ".join(str(k + 1) for k in side) for side in SIDES]))
    return path


@sample(COLORS)
def obj_materials(folder: Path) -> Path:
    path = folder / "materials.obj"
    faces = []
    for n, side in enumerate(SIDES):
        faces += [f"usemtl side{n}", "f " + " ".join(str(k + 1) for k in side)]
    path.write_text(obj_lines(faces, "mtllib materials.mtl\n"))
    (folder / "materials.mtl").write_text(
        "".join(
            "newmtl side{}\nKd {} {} {}\nd 0.75\n".format(n, *(c / 255 for c in color))
            for n, color in enumerate(COLORS)
        )
    )
    return path


@sample([(255, 0, 0), (0, 0, 255)])
def obj_vertex_colors(folder: Path) -> Path:
    path = folder / "vertexcolors.obj"
    vertices = [
        "v {} {} {} {} 0 {}".format(*corner, int(k < 4), int(k >= 4))
        for k, corner in enumerate(CORNERS)
    ]
    faces = [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in TRIANGLES]
    path.write_text("\n".join(vertices + faces) + "\n")
    return path


def _obj_textured(folder: Path, name: str, picture: bytes) -> Path:
    path = folder / "textured.obj"
    uv = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    faces = ["usemtl wood"]
    faces += ["f " + " ".join(f"{k + 1}/{n}" for n, k in enumerate(s, 1)) for s in SIDES]
    path.write_text(obj_lines(faces, f"mtllib textured.mtl\n{uv}"))
    (folder / "textured.mtl").write_text(f"newmtl wood\nKd 1 1 1\nmap_Kd {name}\n")
    place = folder / name
    place.parent.mkdir(exist_ok=True)
    place.write_bytes(picture)
    return path


@sample([(255, 255, 255)], texture=True)
def obj_texture_jpg(folder: Path) -> Path:
    folder = folder / "jpg"
    folder.mkdir()
    return _obj_textured(folder, "../pictures/oak.jpg", image("JPEG"))


@sample([(255, 255, 255)], texture=True)
def obj_texture_tga(folder: Path) -> Path:
    folder = folder / "tga"
    folder.mkdir()
    return _obj_textured(folder, "oak.tga", image("TGA"))


# PLY


def ply_header(format_: str, vertex: str = "", face: str = "", comment: str = "") -> str:
    return (
        f"ply\nformat {format_} 1.0\n{comment}element vertex {len(CORNERS)}\nproperty float x\n"
        f"property float y\nproperty float z\n{vertex}element face {len(TRIANGLES)}\n"
        f"property list uchar int vertex_indices\n{face}end_header\n"
    )


RGB_PROPERTIES = "property uchar red\nproperty uchar green\nproperty uchar blue\n"


@sample()
def ply_ascii(folder: Path) -> Path:
    path = folder / "ascii.ply"
    rows = ["{} {} {}".format(*c) for c in CORNERS]
    rows += ["3 {} {} {}".format(*t) for t in TRIANGLES]
    path.write_text(ply_header("ascii") + "\n".join(rows) + "\n")
    return path


@sample()
def ply_binary(folder: Path) -> Path:
    path = folder / "binary.ply"
    data = ply_header("binary_little_endian").encode()
    data += b"".join(struct.pack("<3f", *c) for c in CORNERS)
    data += b"".join(struct.pack("<B3i", 3, *t) for t in TRIANGLES)
    path.write_bytes(data)
    return path


@sample([*COLORS, (1, 2, 3), (4, 5, 6)])
def ply_vertex_colors(folder: Path) -> Path:
    path = folder / "vertexcolors.ply"
    colors = [*COLORS, (1, 2, 3), (4, 5, 6)]
    rows = ["{} {} {} {} {} {}".format(*p, *c) for p, c in zip(CORNERS, colors, strict=True)]
    rows += ["3 {} {} {}".format(*t) for t in TRIANGLES]
    path.write_text(ply_header("ascii", vertex=RGB_PROPERTIES) + "\n".join(rows) + "\n")
    return path


@sample(COLORS)
def ply_face_colors(folder: Path) -> Path:
    path = folder / "facecolors.ply"
    rows = ["{} {} {}".format(*c) for c in CORNERS]
    rows += ["3 {} {} {} {} {} {}".format(*t, *COLORS[n // 2]) for n, t in enumerate(TRIANGLES)]
    path.write_text(ply_header("ascii", face=RGB_PROPERTIES) + "\n".join(rows) + "\n")
    return path


@sample([(255, 255, 255)], texture=True)
def ply_texture(folder: Path) -> Path:
    path = folder / "textured.ply"
    rows = ["{} {} {} {} {}".format(*c, k & 1, k >> 1 & 1) for k, c in enumerate(CORNERS)]
    rows += ["3 {} {} {}".format(*t) for t in TRIANGLES]
    header = ply_header(
        "ascii",
        vertex="property float s\nproperty float t\n",
        comment="comment TextureFile pine.png\n",
    )
    path.write_text(header + "\n".join(rows) + "\n")
    (folder / "pine.png").write_bytes(image("PNG"))
    return path


# COLLADA


def dae_text(
    points: Points = CORNERS,
    *,
    unit: str = '<unit name="meter" meter="1"/>',
    up_axis: str = "Z_UP",
    node: str = "{geometry}",
    primitives: str | None = None,
    sources: str = "",
    effects: dict[str, str] | None = None,
    images: str = "",
    triangles: list[tuple[int, int, int]] = TRIANGLES,
    nodes: str = "",
) -> str:
    """``node`` is what stands in the scene's node, with {geometry} for the geometry."""
    effects = effects or {}
    flat = " ".join(f"{c}" for p in points for c in p)
    if primitives is None:
        index = " ".join(str(k) for t in triangles for k in t)
        primitives = (
            f'<triangles count="{len(triangles)}"><input semantic="VERTEX" source="#v" '
            f'offset="0"/><p>{index}</p></triangles>'
        )
    bind = "".join(
        f'<instance_material symbol="{name}" target="#{name}"><bind_vertex_input semantic="CH0" '
        f'input_semantic="TEXCOORD" input_set="0"/></instance_material>'
        for name in effects
    )
    geometry = (
        '<instance_geometry url="#g"><bind_material><technique_common>'
        f"{bind}</technique_common></bind_material></instance_geometry>"
    )
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>
{unit}{f"<up_axis>{up_axis}</up_axis>" if up_axis else ""}</asset>
<library_images>{images}</library_images>
<library_effects>{
        "".join(f'<effect id="{n}-fx"><profile_COMMON>{e}</profile_COMMON></effect>'
                for n, e in effects.items())
    }</library_effects>
<library_materials>{
        "".join(f'<material id="{n}"><instance_effect url="#{n}-fx"/></material>' for n in effects)
    }</library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{3 * len(points)}">{flat}</float_array>
<technique_common><accessor source="#pa" count="{len(points)}" stride="3"><param name="X"
type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>{sources}
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
{primitives}</mesh></geometry></library_geometries>
<library_nodes>{nodes}</library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="n">{
        node.format(geometry=geometry)
    }</node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""  # fmt: skip


def _dae(folder: Path, name: str, text: str) -> Path:
    path = folder / f"{name}.dae"
    path.write_text(text)
    return path


@sample()
def dae_z_up_metres(folder: Path) -> Path:
    return _dae(folder, "zup", dae_text())


@sample()
def dae_y_up_centimetres(folder: Path) -> Path:
    points: Points = [(100 * x, 100 * z, -100 * y) for x, y, z in CORNERS]
    unit = '<unit name="centimeter" meter="0.01"/>'
    return _dae(folder, "yup", dae_text(points, unit=unit, up_axis="Y_UP"))


@sample()
def dae_x_up_inches(folder: Path) -> Path:
    points: Points = [(z / 0.0254, -x / 0.0254, -y / 0.0254) for x, y, z in CORNERS]
    unit = '<unit name="inch" meter="0.0254"/>'
    return _dae(folder, "xup", dae_text(points, unit=unit, up_axis="X_UP"))


@sample()
def dae_that_says_nothing_is_y_up_metres(folder: Path) -> Path:
    points: Points = [(x, z, -y) for x, y, z in CORNERS]
    return _dae(folder, "silent", dae_text(points, unit="", up_axis=""))


@sample()
def dae_nested_nodes_in_millimetres(folder: Path) -> Path:
    # the box is at half size, a quarter turn about z and a shift away from where it belongs
    points: Points = [(500 * y, -500 * x, 500 * (z - 3)) for x, y, z in CORNERS]
    node = (
        '<translate>0 0 3000</translate><node id="a"><rotate>0 0 1 90</rotate>'
        "<!-- between --><node><scale>2 2 2</scale>{geometry}</node></node>"
    )
    return _dae(folder, "nested", dae_text(points, unit='<unit meter="0.001"/>', node=node))


@sample()
def dae_mirrored_node(folder: Path) -> Path:
    points: Points = [(-x, y, z) for x, y, z in CORNERS]
    triangles = [(a, c, b) for a, b, c in TRIANGLES]  # outward, too, before it is mirrored
    node = "<matrix>-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>{geometry}"
    return _dae(folder, "mirrored", dae_text(points, node=node, triangles=triangles))


@sample()
def dae_instance_node(folder: Path) -> Path:
    nodes = '<node id="lib"><translate>1 0 0</translate><instance_geometry url="#g"/></node>'
    points: Points = [(x - 1, y, z) for x, y, z in CORNERS]
    node = '<instance_node url="#lib"/>'
    return _dae(folder, "instanced", dae_text(points, node=node, nodes=nodes))


@sample()
def dae_polylist(folder: Path) -> Path:
    index = " ".join(str(k) for side in SIDES for k in side)
    primitives = (
        '<polylist count="6"><input semantic="VERTEX" source="#v" offset="0"/>'
        f"<vcount>4 4 4 4 4 4</vcount><p>{index}</p></polylist>"
    )
    return _dae(folder, "polylist", dae_text(primitives=primitives))


@sample()
def dae_polygons(folder: Path) -> Path:
    sides = "".join(f"<p>{' '.join(str(k) for k in side)}</p>" for side in SIDES)
    primitives = (
        '<polygons count="6"><input semantic="VERTEX" source="#v" offset="0"/>' + sides
    ) + "</polygons>"
    return _dae(folder, "polygons", dae_text(primitives=primitives))


def effect(color: tuple[int, int, int], more: str = "") -> str:
    r, g, b = (c / 255 for c in color)
    return (
        f'<technique sid="common"><lambert><diffuse><color>{r} {g} {b} 1</color></diffuse>{more}'
        "</lambert></technique>"
    )


@sample(COLORS)
def dae_materials(folder: Path) -> Path:
    primitives = "".join(
        f'<triangles count="2" material="m{n}"><input semantic="VERTEX" source="#v" offset="0"/>'
        f"<p>{a} {b} {c} {a} {c} {d}</p></triangles>"
        for n, (a, b, c, d) in enumerate(SIDES)
    )
    effects = {f"m{n}": effect(color) for n, color in enumerate(COLORS)}
    return _dae(folder, "materials", dae_text(primitives=primitives, effects=effects))


@sample(COLORS)
def dae_corner_colors(folder: Path) -> Path:
    values = " ".join(str(c / 255) for color in COLORS for c in color)
    sources = (
        f'<source id="c"><float_array id="ca" count="18">{values}</float_array><technique_common>'
        '<accessor source="#ca" count="6" stride="3"><param name="R" type="float"/><param '
        'name="G" type="float"/><param name="B" type="float"/></accessor></technique_common>'
        "</source>"
    )
    index = " ".join(f"{k} {n // 2}" for n, t in enumerate(TRIANGLES) for k in t)
    primitives = (
        '<triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/>'
        f'<input semantic="COLOR" source="#c" offset="1"/><p>{index}</p></triangles>'
    )
    return _dae(folder, "colors", dae_text(primitives=primitives, sources=sources))


def dae_textured_text(init_from: str = "maple.png") -> str:
    sources = (
        '<source id="t"><float_array id="ta" count="8">0 0 1 0 1 1 0 1</float_array>'
        '<technique_common><accessor source="#ta" count="4" stride="2"><param name="S" '
        'type="float"/><param name="T" type="float"/></accessor></technique_common></source>'
    )
    index = " ".join(f"{side[k]} {k}" for side in SIDES for t in ((0, 1, 2), (0, 2, 3)) for k in t)
    primitives = (
        '<triangles count="12" material="m"><input semantic="VERTEX" source="#v" offset="0"/>'
        f'<input semantic="TEXCOORD" source="#t" offset="1" set="0"/><p>{index}</p></triangles>'
    )
    look = (
        '<newparam sid="surf"><surface type="2D"><init_from>img</init_from></surface></newparam>'
        '<newparam sid="samp"><sampler2D><source>surf</source></sampler2D></newparam>'
        '<technique sid="common"><lambert><diffuse><texture texture="samp" texcoord="CH0"/>'
        "</diffuse></lambert></technique>"
    )
    images = f'<image id="img"><init_from>{init_from}</init_from></image>'
    return dae_text(primitives=primitives, sources=sources, effects={"m": look}, images=images)


@sample([(255, 255, 255)], texture=True)
def dae_texture(folder: Path) -> Path:
    (folder / "sugar maple.png").write_bytes(image("PNG"))
    return _dae(folder, "textured", dae_textured_text("sugar%20maple.png"))


# glTF: y is up, so the file holds (x, z, -y)

GLTF_POINTS = [(x, z, -y) for x, y, z in CORNERS]


def gltf(
    extra: dict[str, object] | None = None,
    *,
    colors: list[tuple[int, int, int]] | None = None,
    picture: bytes | None = None,
) -> tuple[dict[str, object], bytes]:
    """The JSON part and the buffer of a box with a node that shifts it by 1 along x."""
    points = b"".join(struct.pack("<3f", x - 1, y, z) for x, y, z in GLTF_POINTS)
    index = b"".join(struct.pack("<3H", *t) for t in TRIANGLES)
    blobs = [points, index]
    accessors: list[dict[str, object]] = [
        {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
    ]
    attributes = {"POSITION": 0}
    if colors is not None:
        attributes["COLOR_0"] = len(accessors)
        blobs.append(b"".join(struct.pack("<4B", *c, 255) for c in colors))
        accessors.append(
            {"bufferView": 2, "componentType": 5121, "count": 8, "type": "VEC4", "normalized": True}
        )
    primitive: dict[str, object] = {"attributes": attributes, "indices": 1}
    document: dict[str, object] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [1, 0, 0]}],
        "meshes": [{"primitives": [primitive]}],
    }
    if picture is not None:
        attributes["TEXCOORD_0"] = len(accessors)
        blobs.append(b"".join(struct.pack("<2f", k & 1, k >> 1 & 1) for k in range(8)))
        accessors.append({"bufferView": 2, "componentType": 5126, "count": 8, "type": "VEC2"})
        blobs.append(picture)
        document["images"] = [{"bufferView": 3, "mimeType": "image/png"}]
        document["textures"] = [{"source": 0}]
        document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        primitive["material"] = 0
    if extra:
        document |= extra
        primitive["material"] = 0
    views, buffer = [], b""
    for blob in blobs:
        views.append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(blob)})
        buffer += blob + bytes(-len(blob) % 4)
    document |= {
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(buffer)}]
    }  # fmt: skip
    return document, buffer


def glb(document: dict[str, object], buffer: bytes) -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


RED = {"materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]}


@sample([(255, 0, 0)])
def glb_material(folder: Path) -> Path:
    path = folder / "material.glb"
    path.write_bytes(glb(*gltf(RED)))
    return path


@sample([*COLORS, (1, 2, 3), (4, 5, 6)])
def glb_vertex_colors(folder: Path) -> Path:
    path = folder / "vertexcolors.glb"
    path.write_bytes(glb(*gltf(colors=[*COLORS, (1, 2, 3), (4, 5, 6)])))
    return path


@sample([(255, 255, 255)], texture=True)
def glb_texture(folder: Path) -> Path:
    path = folder / "textured.glb"
    path.write_bytes(glb(*gltf(picture=image("PNG"))))
    return path


@sample([(255, 0, 0)])
def gltf_with_a_buffer_beside(folder: Path) -> Path:
    path = folder / "beside.gltf"
    document, buffer = gltf(RED)
    document["buffers"] = [{"byteLength": len(buffer), "uri": "beside%20it.bin"}]
    path.write_text(json.dumps(document))
    (folder / "beside it.bin").write_bytes(buffer)
    return path
