"""Mesh files that trimesh reads: .stl that are text, .obj, .ply, .glb and .gltf."""

from __future__ import annotations

import io
import logging
import re
from importlib.util import find_spec
from typing import Any

import numpy as np
import trimesh

from urdf2mbs.plugin import ConfigError
from urdf2mbs_meshes import gltf
from urdf2mbs_meshes.model import NO_LINES, NO_PILLOW, UP_AXES, Material, Mesh, add

# What is wrong with a file is said by us; without a handler its log goes to standard error.
logging.getLogger("trimesh").addHandler(logging.NullHandler())


#: A line or a point in a file, by the ending.  A .ply of triangles has no other elements.
_LINES = {".obj": rb"(?m)^[ \t]*[lp][ \t]+[-\d]", ".ply": rb"\A[^\0]{0,4096}?\nelement edge [1-9]"}


def read(mesh: Mesh, data: bytes, ending: str) -> None:
    """Put the file's parts into ``mesh``; ``ending`` says which format it is."""
    frame = np.eye(4)
    if ending in (".glb", ".gltf"):
        gltf.check(data, ending)
        frame[:3, :3] = UP_AXES["Y_UP"]  # glTF 2.0, 3.4: y is up

    class Resolver(trimesh.resolvers.FilePathResolver):
        """Files that the mesh file names, each one remembered."""

        def get(self, name: str) -> bytes:
            content = mesh.fetch(name)
            if content is None:
                raise FileNotFoundError(name)
            return _utf_8(content) if name.lower().endswith(".mtl") else content

    scene = trimesh.load_scene(
        io.BytesIO(_utf_8(data) if ending == ".obj" else data),
        file_type=ending[1:], resolver=Resolver(str(mesh.path)), process=False,
    )  # fmt: skip
    pillow = find_spec("PIL") is not None
    if not pillow and any(
        b"map_Kd" in text or b"TextureFile" in text or b'"images"' in text
        for text in (data, *mesh.sources.values())
        if text
    ):  # trimesh says nothing
        mesh.problems.append(NO_PILLOW)
    if ending in _LINES and re.search(_LINES[ending], data):  # trimesh drops them beside faces
        mesh.problems.append(NO_LINES)
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not isinstance(geometry, trimesh.Trimesh):
            mesh.problems.append(NO_LINES)
            continue
        try:
            look, colors, uv = _look(mesh, geometry)
        except ConfigError:
            raise
        except Exception as error:
            look, colors, uv = Material(), None, None
            told = f"the colours of '{name}' cannot be read ({error})"
            mesh.problems.append(told if pillow else NO_PILLOW)
        add(
            mesh, frame @ matrix, geometry.vertices, geometry.faces,
            material=look, smooth=ending != ".stl", colors=colors, uv=uv,
        )  # fmt: skip


def _utf_8(text: bytes) -> bytes:
    """A text that is not in UTF-8, as comments and names often are, made readable."""
    return text.decode("utf-8", "replace").encode()


def _look(mesh: Mesh, geometry: Any) -> tuple[Material, Any, Any]:
    """A geometry's material, its colours and its texture coordinates by corner."""
    visual = geometry.visual
    if visual.kind == "vertex":
        return Material(), visual.vertex_colors[geometry.faces].astype(int), None
    if visual.kind == "face":
        return Material(), visual.face_colors.astype(int), None
    if visual.kind != "texture":
        return Material(), None, None
    colors = visual.vertex_attributes.get("color")
    if colors is not None:
        if colors.dtype.kind == "f":
            colors = np.round(255 * np.clip(colors, 0.0, 1.0))
        elif colors.dtype.itemsize == 2:
            colors = colors // 257
        colors = colors.astype(int)[geometry.faces]
    uv = None if visual.uv is None else visual.uv[geometry.faces]
    return _material(mesh, visual.material), colors, uv


def _material(mesh: Mesh, material: Any) -> Material:
    def color(value: Any) -> tuple[float, float, float]:
        r, g, b = (float(c) / 255 for c in value[:3])
        return (r, g, b)

    if hasattr(material, "baseColorFactor"):  # glTF
        factor = material.baseColorFactor
        image = material.baseColorTexture
        blend = material.alphaMode == "BLEND" and factor is not None
        glow = material.emissiveFactor
        return Material(
            diffuse=(1.0, 1.0, 1.0) if factor is None else color(factor),
            transparency=1.0 - float(factor[3]) / 255 if blend else 0.0,
            emissive=None if glow is None else (float(glow[0]), float(glow[1]), float(glow[2])),
            texture=mesh.picture(image, material.name or "texture") if image else None,
        )
    given = material.kwargs  # the statements of the .mtl, in small letters
    name = None
    if material.image is not None:
        # .mtl: as it names it; .ply: the one file it names; none: trimesh's own stand-in
        path = material.image.info.get("file_path")
        if path is None and mesh.path.suffix.lower() == ".ply":
            path = next(iter([*mesh.sources][1:]), None)
        content = mesh.fetch(path) if path else None
        name = mesh.texture(content, path) if path and content else None
    opacity = None
    try:
        if "d" in given:
            opacity = float(given["d"][-1])
        elif "tr" in given:
            opacity = 1.0 - float(given["tr"][-1])
    except ValueError:
        mesh.problems.append("the transparency of a material is no number")
    return Material(
        diffuse=color(material.diffuse) if "kd" in given else None,
        transparency=None if opacity is None else 1.0 - opacity,
        specular=color(material.specular) if "ks" in given else None,
        shininess=min(material.glossiness / 128, 1.0) if "ns" in given else None,
        texture=name,
    )
