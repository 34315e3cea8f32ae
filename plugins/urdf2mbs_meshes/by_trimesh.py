"""Mesh files that trimesh reads: .stl, .obj, .ply, .glb and .gltf."""

from __future__ import annotations

import io
import logging
import re
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import trimesh

from urdf2mbs.plugin import ConfigError
from urdf2mbs_meshes.gltf import check_gltf
from urdf2mbs_meshes.model import (
    NO_LINES,
    NO_PILLOW,
    RGB,
    UP_AXES,
    Material,
    Mesh,
    MeshError,
    add_part,
)

if TYPE_CHECKING:
    from urdf2mbs_meshes.model import Floats, Integers

# The errors of a file become our messages; without a handler trimesh logs to standard error.
logging.getLogger("trimesh").addHandler(logging.NullHandler())

#: A line or a point in a file, by the ending.  A .ply of triangles has no other elements.
LINE_PATTERNS = {
    ".obj": rb"(?m)^[ \t]*[lp][ \t]+[-\d]",
    ".ply": rb"\A[^\0]{0,4096}?\nelement edge [1-9]",
}
#: The words by which files name their textures.
TEXTURE_WORDS = (b"map_Kd", b"TextureFile", b'"images"')

#: Number of bytes of a binary .stl before the triangles, and of each triangle.
STL_HEADER_SIZE, STL_TRIANGLE_SIZE = 84, 50


class Look(NamedTuple):
    """The material of a part, with colours and texture coordinates as in ``Part``."""

    material: Material
    colors: Integers | None = None
    uv: Floats | None = None


class Resolver(trimesh.resolvers.FilePathResolver):
    """Reads the files that a mesh file names, through the mesh."""

    def __init__(self, mesh: Mesh) -> None:
        super().__init__(str(mesh.path))
        self.mesh = mesh

    def get(self, name: str) -> bytes:
        """Return the content of a file; raise FileNotFoundError if it does not exist."""
        content = self.mesh.read_file(name)
        if content is None:
            raise FileNotFoundError(name)
        return _repair_utf_8(content) if name.lower().endswith(".mtl") else content


def read_by_trimesh(mesh: Mesh, data: bytes, ending: str) -> None:
    """Add the parts of a file to a mesh.

    Args:
        mesh: The mesh; it gets the problems of the file, too.
        data: The file.
        ending: The ending of its name, which is its format.

    Raises:
        MeshError: The file cannot be used; trimesh raises other errors for broken files.
    """
    file_frame = np.eye(4)
    if ending in (".glb", ".gltf"):
        check_gltf(data, ending)
        file_frame[:3, :3] = UP_AXES["Y_UP"]  # glTF 2.0, 3.4: y is up
    elif ending == ".stl" and _is_binary_stl(data):
        data = _trim_binary_stl(mesh, data)
    elif ending == ".obj":
        data = _repair_utf_8(data)
    scene = trimesh.load_scene(
        io.BytesIO(data), file_type=ending[1:], resolver=Resolver(mesh), process=False
    )
    _find_problems(mesh, data, ending)
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not isinstance(geometry, trimesh.Trimesh):
            mesh.problems.append(NO_LINES)
            continue
        look = _read_look(mesh, geometry, name)
        add_part(
            mesh,
            file_frame @ transform,
            geometry.vertices,
            geometry.faces,
            smooth=ending != ".stl",
            **look._asdict(),
        )


def _repair_utf_8(text: bytes) -> bytes:
    """Replace the bytes that are not UTF-8: comments and names often have other encodings."""
    return text.decode("utf-8", "replace").encode()


def _is_binary_stl(data: bytes) -> bool:
    """Return True for a .stl that is not a text; both may begin with "solid"."""
    begin = data[:1000]
    is_text = begin.lstrip()[:5].lower() == b"solid" and b"\0" not in begin
    return len(data) >= STL_HEADER_SIZE and not is_text


def _trim_binary_stl(mesh: Mesh, data: bytes) -> bytes:
    """Return a binary .stl without the bytes after its last triangle, which trimesh refuses."""
    expected = int.from_bytes(data[80:STL_HEADER_SIZE], "little")
    count = (len(data) - STL_HEADER_SIZE) // STL_TRIANGLE_SIZE
    if count < expected:
        raise MeshError(f"its header says {expected} triangles, and it has {count}")
    end = STL_HEADER_SIZE + STL_TRIANGLE_SIZE * expected
    if len(data) > end:
        mesh.problems.append(f"its header says {expected} triangles: the bytes after are left out")
    return data[:end]


def _find_problems(mesh: Mesh, data: bytes, ending: str) -> None:
    """Find the textures, lines and points that trimesh drops without a message."""
    texts = [text for text in (data, *mesh.sources.values()) if text]
    has_texture = any(word in text for text in texts for word in TEXTURE_WORDS)
    if has_texture and find_spec("PIL") is None:
        mesh.problems.append(NO_PILLOW)
    if ending in LINE_PATTERNS and re.search(LINE_PATTERNS[ending], data):
        mesh.problems.append(NO_LINES)


def _read_look(mesh: Mesh, geometry: Any, name: object) -> Look:
    """Read the look of a geometry; one that is broken becomes a problem of the mesh."""
    try:
        return _read_visual(mesh, geometry)
    except ConfigError:
        raise
    except Exception as error:  # a broken file can make trimesh and pillow raise anything
        has_pillow = find_spec("PIL") is not None
        problem = f"the colours of '{name}' cannot be read ({error})"
        mesh.problems.append(problem if has_pillow else NO_PILLOW)
        return Look(Material())


def _read_visual(mesh: Mesh, geometry: Any) -> Look:
    """Read the colours of corners or faces, or the material and texture of a geometry."""
    visual = geometry.visual
    if visual.kind == "vertex":
        return Look(Material(), colors=visual.vertex_colors[geometry.faces].astype(int))
    if visual.kind == "face":
        return Look(Material(), colors=visual.face_colors.astype(int))
    if visual.kind != "texture":
        return Look(Material())
    colors = visual.vertex_attributes.get("color")
    if colors is not None:
        if colors.dtype.kind == "f":
            colors = np.round(255 * np.clip(colors, 0.0, 1.0))
        elif colors.dtype.itemsize == 2:
            colors = colors // 257  # 65535 / 257 = 255
        colors = colors.astype(int)[geometry.faces]
    uv = None if visual.uv is None else visual.uv[geometry.faces]
    is_gltf = hasattr(visual.material, "baseColorFactor")
    read_material = _read_gltf_material if is_gltf else _read_simple_material
    return Look(read_material(mesh, visual.material), colors, uv)


def _read_gltf_material(mesh: Mesh, material: Any) -> Material:
    """Read a material of a glTF file (glTF 2.0, 3.9)."""
    factor = material.baseColorFactor
    image = material.baseColorTexture
    is_blended = material.alphaMode == "BLEND" and factor is not None
    glow = material.emissiveFactor
    return Material(
        diffuse=(1.0, 1.0, 1.0) if factor is None else _convert_color(factor),
        transparency=1.0 - float(factor[3]) / 255 if is_blended else 0.0,
        emissive=None if glow is None else (float(glow[0]), float(glow[1]), float(glow[2])),
        texture=mesh.add_image(image, material.name or "texture") if image else None,
    )


def _read_simple_material(mesh: Mesh, material: Any) -> Material:
    """Read a material of an .mtl or a .ply file."""
    statements = material.kwargs  # those of the .mtl, in small letters
    opacity = None
    try:
        if "d" in statements:
            opacity = float(statements["d"][-1])
        elif "tr" in statements:
            opacity = 1.0 - float(statements["tr"][-1])
    except ValueError:
        mesh.problems.append("the transparency of a material is not a number")
    return Material(
        diffuse=_convert_color(material.diffuse) if "kd" in statements else None,
        transparency=None if opacity is None else 1.0 - opacity,
        specular=_convert_color(material.specular) if "ks" in statements else None,
        shininess=min(material.glossiness / 128, 1.0) if "ns" in statements else None,
        texture=_read_texture(mesh, material.image),
    )


def _read_texture(mesh: Mesh, image: Any) -> str | None:
    """Add the file of an image that trimesh has read to the mesh, and return its new name."""
    if image is None:
        return None
    # The .mtl names the file.  A .ply names a single file, the only one read beside the mesh.
    # An image without a file is a default of trimesh.
    path = image.info.get("file_path")
    if path is None and mesh.path.suffix.lower() == ".ply":
        path = next(iter([*mesh.sources][1:]), None)
    content = mesh.read_file(path) if path else None
    return mesh.add_texture(content, path) if path and content else None


def _convert_color(color: Any) -> RGB:
    """Convert a colour of 0 to 255 to one of 0 to 1, without its opacity."""
    red, green, blue = (float(value) / 255 for value in color[:3])
    return (red, green, blue)
