"""Mesh files read into triangles in metres, z up: .stl, .dae, .obj, .ply, .glb and .gltf.

The scene graph of a file is flattened: every part stands in the file's own frame, its node's
transform applied; where that transform mirrors, the faces are turned back.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
from pathlib import Path, PureWindowsPath
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

import msgspec

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.vrml import Material, Part

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: What can be read, by the end of the file's name in small letters.
FORMATS = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf")

#: The image formats that VRML97's ImageTexture shows in every viewer.
IMAGES = {"PNG": ".png", "JPEG": ".jpg", "GIF": ".gif"}

#: COLLADA's ``<up_axis>``, turned so that z is up and what faced the viewer faces -y
#: (COLLADA 1.4.1, chapter 5, "up_axis").
UP_AXES = {
    "X_UP": ((0, -1, 0), (0, 0, -1), (1, 0, 0)),
    "Y_UP": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "Z_UP": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}  # fmt: skip

#: glTF extensions that trimesh does not need in order to give the right triangles.
GLTF_EXTENSIONS = {"KHR_materials_unlit", "KHR_texture_transform"}


class MeshError(Exception):
    """A mesh file that cannot be used, and why, in plain words."""


class Mesh:
    """What one mesh file holds."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.parts: list[Part] = []
        self.textures: dict[str, bytes] = {}
        """Images to lie beside the .wrl, by file name."""
        self.sources: dict[str, bytes | None] = {}
        """Every file that was read, by its name in the mesh file; None: it is not there."""
        self.problems: list[str] = []
        """What of the mesh file could not be taken over."""
        self.turned_up: str | None = None
        """COLLADA's ``<up_axis>``, where it made the mesh be turned."""

    def fetch(self, name: str) -> bytes | None:
        """A file that the mesh file names (relative to itself, as a path or a URI)."""
        if name not in self.sources:
            self.sources[name] = read_beside(self.path, name)
        return self.sources[name]

    def texture(self, data: bytes, name: str) -> str | None:
        """Keep an image under a name of its own, as PNG where VRML97 cannot show its format."""
        try:
            from PIL import Image
        except ImportError as error:
            raise missing_extra(error) from None
        try:
            with Image.open(io.BytesIO(data)) as image:
                image.load()
                if image.format not in IMAGES:
                    return self.picture(image, name)
                ending = IMAGES[image.format]
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
            self.problems.append(f"texture '{name}' is no readable image ({error})")
            return None
        return self._keep(data, name, ending)

    def picture(self, image: Any, name: str) -> str:
        """Keep a decoded image (PIL) as PNG."""
        out = io.BytesIO()
        plain = image.mode in ("1", "L", "LA", "RGB", "RGBA", "P")
        (image if plain else image.convert("RGBA")).save(out, "PNG")
        return self._keep(out.getvalue(), name, ".png")

    def _keep(self, data: bytes, name: str, ending: str) -> str:
        # named by content: equal images are one file, unequal ones never collide
        stem = re.sub(r"[^A-Za-z0-9_-]", "_", PureWindowsPath(unquote(name)).stem) or "texture"
        file = f"{stem}_{hashlib.sha256(data).hexdigest()[:8]}{ending}"
        self.textures[file] = data
        return file


def read(path: Path, *, up_axis: bool = True) -> Mesh:
    """Read a mesh file; the lengths are m, as ``<unit>`` (COLLADA) or the format says.

    ``up_axis`` False leaves COLLADA files as they lie, whatever their ``<up_axis>``.
    Raises MeshError for a file that holds no usable triangles.
    """
    import numpy as np

    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise MeshError(f"the format '{ending}' is not known; known are {', '.join(FORMATS)}")
    mesh = Mesh(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise MeshError(str(error)) from None
    mesh.sources[path.name] = data
    try:
        if ending == ".dae":
            _read_collada(mesh, data, up_axis)
        else:
            _read_trimesh(mesh, data, ending)
    except (MeshError, ConfigError):
        raise
    except Exception as error:  # the readers raise whatever a bad file makes them stumble on
        raise MeshError(f"{type(error).__name__}: {error}".rstrip(": ")) from error
    mesh.parts = [part for part in mesh.parts if len(part.triangles)]
    if not mesh.parts:
        raise MeshError("it holds no triangles")
    for part in mesh.parts:
        low, high = part.triangles.min(), part.triangles.max()
        if low < 0 or high >= len(part.points):
            raise MeshError(f"a triangle names a point that is not there ({low} or {high})")
        if not (np.abs(part.points) <= np.finfo(np.float32).max).all():
            raise MeshError("it has coordinates that are no finite single-precision numbers")
    return mesh


def read_beside(path: Path, name: str) -> bytes | None:
    """The content of a file that a mesh file names; None where there is none."""
    plain = name.replace("\\", "/")
    uri = urlsplit(plain)
    options = [plain, unquote(uri.path) if uri.scheme == "file" else unquote(plain)]
    for option in options:
        try:
            return (path.parent / option).read_bytes()
        except (OSError, ValueError):
            continue
    return None


def missing_extra(error: ImportError) -> ConfigError:
    return ConfigError(
        "extra-missing",
        f"converting meshes needs the package '{error.name}', which is not installed",
        hint="pip install 'urdf2mbs[meshes]'",
    )


def _add(mesh: Mesh, matrix: NDArray[np.float64], points: Any, triangles: Any, **rest: Any) -> None:
    """Add a part that stands in a node with the transform ``matrix`` (4 x 4)."""
    import numpy as np

    points = np.asarray(points, float).reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    part = Part(points, np.asarray(triangles, int).reshape(-1, 3), **rest)
    mesh.parts.append(turned(part) if np.linalg.det(matrix[:3, :3]) < 0 else part)


def turned(part: Part) -> Part:
    """The same part with every triangle's other side out."""
    by_corner = part.colors is not None and part.colors.ndim == 3
    return msgspec.structs.replace(
        part,
        triangles=part.triangles[:, ::-1],
        colors=part.colors[:, ::-1] if by_corner and part.colors is not None else part.colors,
        uv=None if part.uv is None else part.uv[:, ::-1],
    )


# COLLADA


def _read_collada(mesh: Mesh, data: bytes, up_axis: bool) -> None:
    import numpy as np

    try:
        import collada
        from collada.polylist import Polylist
        from collada.triangleset import TriangleSet
    except ImportError as error:
        raise missing_extra(error) from None
    data = re.sub(rb"<!--.*?-->", b"", data, flags=re.DOTALL)  # pycollada stumbles on comments
    document = collada.Collada(io.BytesIO(data), ignore=[collada.common.DaeError])
    if document.scene is None:
        raise MeshError("it has no scene")
    asset = document.assetInfo
    frame = np.eye(4)
    frame[:3, :3] *= 1.0 if asset.unitmeter is None else float(asset.unitmeter)
    up = asset.upaxis or "Y_UP"
    if up_axis and up != "Z_UP":
        frame[:3, :3] = np.array(UP_AXES[up]) @ frame[:3, :3]
        mesh.turned_up = up
    looks: dict[str, tuple[Material, str | None]] = {}
    for bound in document.scene.objects("geometry"):
        matrix = frame @ np.asarray(bound.matrix, float)
        for primitive in bound.original.primitives:
            if isinstance(primitive, Polylist):
                primitive = primitive.triangleset()
            if not isinstance(primitive, TriangleSet) or not len(primitive.index):
                continue  # lines, or nothing
            node = bound.materialnodebysymbol.get(primitive.material)
            look, channel = Material(), None
            if node is not None and node.target is not None:
                if node.target.id not in looks:
                    looks[node.target.id] = _collada_material(mesh, node.target.effect)
                look, channel = looks[node.target.id]
            inputs = primitive.sources
            uv = colors = None
            if look.texture and inputs.get("TEXCOORD"):
                sets = {name: number for name, _, number in node.inputs}
                wanted = str(sets.get(channel, ""))
                chosen = next(
                    (n for n, given in enumerate(inputs["TEXCOORD"]) if str(given[3]) == wanted), 0
                )
                uv = primitive.texcoordset[chosen][primitive.texcoord_indexset[chosen]][..., :2]
            if inputs.get("COLOR"):
                offset, *_, source = inputs["COLOR"][0]
                values = np.clip(np.asarray(source.data, float), 0.0, 1.0)
                colors = np.round(255 * values).astype(int)[primitive.index[:, :, offset]]
            _add(
                mesh, matrix, primitive.vertex, primitive.vertex_index,
                material=look, smooth=primitive.normal is not None, colors=colors, uv=uv,
            )  # fmt: skip
    if next(iter(document.scene.objects("controller")), None) is not None:
        mesh.problems.append("its skinned parts (instance_controller) are left out")
    # cameras and lights are no part of a shape
    lost = [str(error) for error in document.errors]
    mesh.problems += [e for e in dict.fromkeys(lost) if not re.search("camera|light", e, re.I)]


def _collada_material(mesh: Mesh, effect: Any) -> tuple[Material, str | None]:
    """What an effect looks like, and the name of its texture's coordinates."""

    def color(value: Any) -> tuple[float, float, float] | None:
        if not isinstance(value, tuple):
            return None
        return (float(value[0]), float(value[1]), float(value[2]))

    name = channel = None
    if effect.diffuse is not None and not isinstance(effect.diffuse, tuple):
        image = effect.diffuse.sampler.surface.image.path
        channel = effect.diffuse.texcoord
        content = mesh.fetch(image)
        name = None if content is None else mesh.texture(content, image)
    through = effect.transparency if isinstance(effect.transparency, (int, float)) else 1.0
    clear = effect.transparent if isinstance(effect.transparent, tuple) else (0.0, 0.0, 0.0, 1.0)
    if effect.opaque_mode == "RGB_ZERO":
        opacity = 1.0 - through * (0.212671 * clear[0] + 0.71516 * clear[1] + 0.072169 * clear[2])
    else:
        opacity = through * clear[3]
    # exporters that mean "opaque" often write what by the standard is invisible
    opacity = 1.0 if opacity <= 0.0 else min(opacity, 1.0)
    shininess = effect.shininess if isinstance(effect.shininess, (int, float)) else None
    look = Material(
        diffuse=color(effect.diffuse),
        transparency=1.0 - opacity,
        emissive=color(effect.emission),
        specular=color(effect.specular),
        shininess=None if shininess is None else min(shininess / 128, 1.0),
        texture=name,
    )
    return look, channel


# all other formats


def _read_trimesh(mesh: Mesh, data: bytes, ending: str) -> None:
    import numpy as np

    try:
        import PIL.Image  # noqa: F401  (without it trimesh drops textures in silence)
        import trimesh
    except ImportError as error:
        raise missing_extra(error) from None
    frame = np.eye(4)
    if ending in (".glb", ".gltf"):
        _check_gltf(data, ending)
        frame[:3, :3] = UP_AXES["Y_UP"]  # glTF 2.0, 3.4: y is up

    class Resolver(trimesh.resolvers.FilePathResolver):
        """Files that the mesh file names, each one remembered."""

        def get(self, name: str) -> bytes:
            content = mesh.fetch(name)
            if content is None:
                raise FileNotFoundError(name)
            return content

    scene = trimesh.load_scene(
        io.BytesIO(data), file_type=ending[1:], resolver=Resolver(str(mesh.path)), process=False
    )
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not isinstance(geometry, trimesh.Trimesh):
            continue  # lines or single points
        look, colors, uv = _trimesh_look(mesh, geometry)
        _add(
            mesh, frame @ matrix, geometry.vertices, geometry.faces,
            material=look, smooth=ending != ".stl", colors=colors, uv=uv,
        )  # fmt: skip


def _trimesh_look(mesh: Mesh, geometry: Any) -> tuple[Material, Any, Any]:
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
        import numpy as np

        if colors.dtype.kind == "f":
            colors = np.round(255 * np.clip(colors, 0.0, 1.0))
        elif colors.dtype.itemsize == 2:
            colors = colors // 257
        colors = colors.astype(int)[geometry.faces]
    uv = None if visual.uv is None else visual.uv[geometry.faces]
    return _trimesh_material(mesh, visual.material), colors, uv


def _trimesh_material(mesh: Mesh, material: Any) -> Material:
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
        path = material.image.info.get("file_path") or next(iter([*mesh.sources][1:]), None)
        content = mesh.fetch(path) if path else None
        name = mesh.texture(content, path) if path and content else None
    opacity = None
    if "d" in given:
        opacity = float(given["d"][-1])
    elif "tr" in given:
        opacity = 1.0 - float(given["tr"][-1])
    return Material(
        diffuse=color(material.diffuse) if "kd" in given else None,
        transparency=None if opacity is None else 1.0 - opacity,
        specular=color(material.specular) if "ks" in given else None,
        shininess=min(material.glossiness / 128, 1.0) if "ns" in given else None,
        texture=name,
    )


def _check_gltf(data: bytes, ending: str) -> None:
    """Refuse what trimesh would read as zeros."""
    if ending == ".glb":
        if data[:4] != b"glTF":
            raise MeshError("it does not start with 'glTF'")
        data = data[20 : 20 + int.from_bytes(data[12:16], "little")]
    required = set(json.loads(data).get("extensionsRequired", ())) - GLTF_EXTENSIONS
    if required:
        raise MeshError(f"it needs the glTF extension {', '.join(sorted(required))}")
