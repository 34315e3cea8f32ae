"""Small mesh files of every format, all of the same box, written without any mesh library.

After its unit, up axis and node transforms each is the box from LOW to HIGH, faces outward.
"""

import io
import json
import struct
from pathlib import Path
from typing import NamedTuple

LOW, HIGH = (1.0, 2.0, 3.0), (2.0, 4.0, 6.0)
VOLUME = 6.0

#: Corner number k of the box has x high where k & 1, y where k & 2, z where k & 4.
CORNERS = [tuple((HIGH if k >> axis & 1 else LOW)[axis] for axis in range(3)) for k in range(8)]
#: The six sides, anticlockwise seen from outside: -x, +x, -y, +y, -z, +z.
SIDES = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
TRIANGLES = [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))]
#: A colour for each side, 0 to 255; and one for each corner.
COLORS = [(200, 100, 50), (0, 255, 0), (0, 0, 255), (255, 255, 0), (10, 20, 30), (255, 255, 255)]
CORNER_COLORS = [*COLORS, (1, 2, 3), (4, 5, 6)]

Points = list[tuple[float, ...]]


class Sample(NamedTuple):
    name: str
    file: str
    files: dict[str, str | bytes]
    """The mesh file, and the files that it names."""
    colors: frozenset[tuple[int, int, int]]
    """What the file states; empty: it leaves the colour to the URDF."""
    texture: bool

    def write(self, folder: Path) -> Path:
        """Write the files; return the path of the mesh."""
        for name, content in self.files.items():
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content if isinstance(content, bytes) else content.encode())
        return folder / self.file


SAMPLES: list[Sample] = []


def add(
    name: str,
    file: str,
    content: str | bytes,
    colors: list[tuple[int, int, int]] | None = None,
    texture: bool = False,
    **beside: str | bytes,
) -> None:
    """``beside`` are further files; ``__`` in a name is a dot."""
    files = {file: content} | {key.replace("__", "."): data for key, data in beside.items()}
    colors = [(255, 255, 255)] if texture else colors
    SAMPLES.append(Sample(name, file, files, frozenset(colors or []), texture))


def write(name: str, folder: Path) -> Path:
    """Write a sample by its name."""
    return next(sample for sample in SAMPLES if sample.name == name).write(folder)


def image(format_: str, size: tuple[int, int] = (4, 2)) -> bytes:
    """Make a small picture whose pixels all differ."""
    from PIL import Image

    picture = Image.new("RGB", size)
    picture.putdata([(30 * k, 255 - 30 * k, 7 * k) for k in range(size[0] * size[1])])
    out = io.BytesIO()
    picture.save(out, format_)
    return out.getvalue()


def rows(*tables: list[tuple[float, ...]]) -> str:
    """Return tables side by side, a line for each row."""
    return "".join(
        " ".join(str(x) for row in line for x in row) + "\n" for line in zip(*tables, strict=True)
    )


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


add("stl_ascii", "ascii.stl", stl_ascii_text())
add("stl_binary", "binary.STL", stl_binary_data())
add("stl_binary_that_says_solid", "solid.stl", stl_binary_data(b"solid of some exporter"))


# OBJ


def obj_lines(faces: list[str], head: str = "") -> str:
    vertices = "\n".join("v {} {} {}".format(*c) for c in CORNERS)
    return f"{head}{vertices}\n" + "\n".join(faces) + "\n"


def face(corners: tuple[int, ...]) -> str:
    return "f " + " ".join(str(k + 1) for k in corners)


def obj_textured(picture: str) -> dict[str, str]:
    """Return an .obj, and its .mtl that names a picture."""
    faces = ["f " + " ".join(f"{k + 1}/{n}" for n, k in enumerate(s, 1)) for s in SIDES]
    head = "mtllib textured.mtl\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    material = f"newmtl wood\nKd 1 1 1\nmap_Kd {picture}\n"
    return {"content": obj_lines(["usemtl wood", *faces], head), "textured__mtl": material}


OBJ_FACES = [face(triangle) for triangle in TRIANGLES]
add("obj_triangles", "plain.obj", obj_lines(OBJ_FACES))
add("obj_quads", "quads.obj", obj_lines([face(side) for side in SIDES]))
add(
    "obj_materials",
    "materials.obj",
    obj_lines(
        [f"usemtl side{n}\n{face(side)}" for n, side in enumerate(SIDES)], "mtllib materials.mtl\n"
    ),
    COLORS,
    materials__mtl="".join(
        "newmtl side{}\nKd {} {} {}\nd 0.75\n".format(n, *(c / 255 for c in color))
        for n, color in enumerate(COLORS)
    ),
)
add(
    "obj_vertex_colors",
    "vertexcolors.obj",
    "".join(
        "v {} {} {} {} 0 {}\n".format(*corner, int(k < 4), int(k >= 4))
        for k, corner in enumerate(CORNERS)
    )
    + "\n".join(OBJ_FACES)
    + "\n",
    [(255, 0, 0), (0, 0, 255)],
)
add(
    "obj_texture_jpg",
    "textured.obj",
    **obj_textured("pictures/oak.jpg"),
    texture=True,
    **{"pictures/oak__jpg": image("JPEG")},
)
add(
    "obj_texture_tga",
    "textured.obj",
    **obj_textured("oak.tga"),
    texture=True,
    oak__tga=image("TGA"),
)


# PLY


def ply_header(format_: str, vertex: str = "", face: str = "", comment: str = "") -> str:
    return (
        f"ply\nformat {format_} 1.0\n{comment}element vertex {len(CORNERS)}\nproperty float x\n"
        f"property float y\nproperty float z\n{vertex}element face {len(TRIANGLES)}\n"
        f"property list uchar int vertex_indices\n{face}end_header\n"
    )


RGB_PROPERTIES = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
PLY_FACES: Points = [(3, *triangle) for triangle in TRIANGLES]
add("ply_ascii", "ascii.ply", ply_header("ascii") + rows(CORNERS) + rows(PLY_FACES))
add(
    "ply_binary",
    "binary.ply",
    ply_header("binary_little_endian").encode()
    + b"".join(struct.pack("<3f", *c) for c in CORNERS)
    + b"".join(struct.pack("<B3i", 3, *t) for t in TRIANGLES),
)
add(
    "ply_vertex_colors",
    "vertexcolors.ply",
    ply_header("ascii", vertex=RGB_PROPERTIES) + rows(CORNERS, CORNER_COLORS) + rows(PLY_FACES),
    CORNER_COLORS,
)
add(
    "ply_face_colors",
    "facecolors.ply",
    ply_header("ascii", face=RGB_PROPERTIES)
    + rows(CORNERS)
    + rows(PLY_FACES, [color for color in COLORS for _ in range(2)]),
    COLORS,
)
add(
    "ply_texture",
    "textured.ply",
    ply_header(
        "ascii",
        vertex="property float s\nproperty float t\n",
        comment="comment TextureFile pine.png\n",
    )
    + rows(CORNERS, [(k & 1, k >> 1 & 1) for k in range(8)])
    + rows(PLY_FACES),
    texture=True,
    pine__png=image("PNG"),
)


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
        "".join(
            f'<effect id="{n}-fx"><profile_COMMON>{e}</profile_COMMON></effect>'
            for n, e in effects.items()
        )
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
"""


def dae_faces(kind: str, inside: str, more: str = "") -> str:
    """Return a primitive of COLLADA with its corners; ``more`` is an attribute."""
    return f'<{kind}{more}><input semantic="VERTEX" source="#v" offset="0"/>{inside}</{kind}>'


def flat(table: list[tuple[int, ...]]) -> str:
    return " ".join(str(k) for row in table for k in row)


def add_dae(name: str, text: str, colors: list[tuple[int, int, int]] | None = None) -> None:
    add(f"dae_{name}", f"{name}.dae", text, colors)


add_dae("z_up_metres", dae_text())
add_dae(
    "y_up_centimetres",
    dae_text(
        [(100 * x, 100 * z, -100 * y) for x, y, z in CORNERS],
        unit='<unit name="centimeter" meter="0.01"/>',
        up_axis="Y_UP",
    ),
)
add_dae(
    "x_up_inches",
    dae_text(
        [(z / 0.0254, -x / 0.0254, -y / 0.0254) for x, y, z in CORNERS],
        unit='<unit name="inch" meter="0.0254"/>',
        up_axis="X_UP",
    ),
)
add_dae(
    "that_says_nothing_is_y_up_metres",
    dae_text([(x, z, -y) for x, y, z in CORNERS], unit="", up_axis=""),
)
# the box is at half size, a quarter turn about z and a shift away from where it belongs
add_dae(
    "nested_nodes_in_millimetres",
    dae_text(
        [(500 * y, -500 * x, 500 * (z - 3)) for x, y, z in CORNERS],
        unit='<unit meter="0.001"/>',
        node='<translate>0 0 3000</translate><node id="a"><rotate>0 0 1 90</rotate>'
        "<!-- between --><node><scale>2 2 2</scale>{geometry}</node></node>",
    ),
)
add_dae(
    "mirrored_node",
    dae_text(
        [(-x, y, z) for x, y, z in CORNERS],
        node="<matrix>-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>{geometry}",
        triangles=[(a, c, b) for a, b, c in TRIANGLES],  # outward, too, before it is mirrored
    ),
)
add_dae(
    "instance_node",
    dae_text(
        [(x - 1, y, z) for x, y, z in CORNERS],
        node='<instance_node url="#lib"/>',
        nodes='<node id="lib"><translate>1 0 0</translate><instance_geometry url="#g"/></node>',
    ),
)
add_dae(
    "polylist",
    dae_text(
        primitives=dae_faces(
            "polylist", f"<vcount>4 4 4 4 4 4</vcount><p>{flat(SIDES)}</p>", ' count="6"'
        )
    ),
)
add_dae(
    "polygons",
    dae_text(
        primitives=dae_faces(
            "polygons", "".join(f"<p>{flat([side])}</p>" for side in SIDES), ' count="6"'
        )
    ),
)


def effect(color: tuple[int, int, int], more: str = "") -> str:
    r, g, b = (c / 255 for c in color)
    return (
        f'<technique sid="common"><lambert><diffuse><color>{r} {g} {b} 1</color></diffuse>{more}'
        "</lambert></technique>"
    )


add_dae(
    "materials",
    dae_text(
        primitives="".join(
            dae_faces("triangles", f"<p>{a} {b} {c} {a} {c} {d}</p>", f' count="2" material="m{n}"')
            for n, (a, b, c, d) in enumerate(SIDES)
        ),
        effects={f"m{n}": effect(color) for n, color in enumerate(COLORS)},
    ),
    COLORS,
)
add_dae(
    "corner_colors",
    dae_text(
        primitives=dae_faces(
            "triangles",
            '<input semantic="COLOR" source="#c" offset="1"/><p>'
            + flat([(k, n // 2) for n, t in enumerate(TRIANGLES) for k in t])
            + "</p>",
            ' count="12"',
        ),
        sources='<source id="c"><float_array id="ca" count="18">'
        + " ".join(str(c / 255) for color in COLORS for c in color)
        + '</float_array><technique_common><accessor source="#ca" count="6" stride="3">'
        '<param name="R" type="float"/><param name="G" type="float"/><param name="B" type="float"/>'
        "</accessor></technique_common></source>",
    ),
    COLORS,
)


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


add(
    "dae_texture",
    "textured.dae",
    dae_textured_text("sugar%20maple.png"),
    texture=True,
    **{"sugar maple__png": image("PNG")},
)


# glTF: y is up, so the file holds (x, z, -y)

GLTF_POINTS = [(x, z, -y) for x, y, z in CORNERS]


def gltf(
    extra: dict[str, object] | None = None,
    *,
    colors: list[tuple[int, int, int]] | None = None,
    picture: bytes | None = None,
) -> tuple[dict[str, object], bytes]:
    """Return the JSON part and the buffer of a box in a node that shifts it by 1 along x."""
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
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(buffer)}],
    }
    return document, buffer


def glb(document: dict[str, object], buffer: bytes) -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


RED = {"materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]}
add("glb_material", "material.glb", glb(*gltf(RED)), [(255, 0, 0)])
add("glb_vertex_colors", "vertexcolors.glb", glb(*gltf(colors=CORNER_COLORS)), CORNER_COLORS)
add("glb_texture", "textured.glb", glb(*gltf(picture=image("PNG"))), texture=True)
DOCUMENT, BUFFER = gltf(RED)
DOCUMENT["buffers"] = [{"byteLength": len(BUFFER), "uri": "beside%20it.bin"}]
add(
    "gltf_with_a_buffer_beside",
    "beside.gltf",
    json.dumps(DOCUMENT),
    [(255, 0, 0)],
    **{"beside it__bin": BUFFER},
)
