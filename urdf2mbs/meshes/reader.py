"""Mesh files read into triangles in metres, z up: .stl, .dae, .obj, .ply, .glb and .gltf.

The scene graph of a file is flattened: every part stands in the file's own frame, its node's
transform applied; where that transform mirrors, the faces are turned back.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
from collections.abc import Callable
from pathlib import Path, PureWindowsPath
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

import msgspec

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.meshes.vrml import Material, Part

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
    if not any(len(part.triangles) for part in mesh.parts):
        raise MeshError("it holds no triangles")
    mesh.parts = [_usable(mesh, part) for part in mesh.parts if len(part.triangles)]
    mesh.parts = [part for part in mesh.parts if len(part.triangles)]
    if not mesh.parts:
        raise MeshError(mesh.problems[-1])
    mesh.problems = list(dict.fromkeys(mesh.problems))
    return mesh


def _usable(mesh: Mesh, part: Part) -> Part:
    """The part without triangles that cannot be drawn: no viewer opens a file that has one."""
    import numpy as np

    there = ((part.triangles >= 0) & (part.triangles < len(part.points))).all(axis=1)
    if not there.all():
        mesh.problems.append(f"{(~there).sum()} triangles name a point that is not there")
    good = np.all(np.abs(part.points) <= np.finfo(np.float32).max, axis=1)
    finite = np.zeros_like(there)
    finite[there] = np.all(good[part.triangles[there]], axis=1)
    if not finite[there].all():
        mesh.problems.append(
            f"{(~finite[there]).sum()} triangles have coordinates that are no finite "
            "single-precision numbers"
        )
    uv = part.uv
    if uv is not None and not np.isfinite(uv[finite]).all():
        mesh.problems.append("its texture coordinates are no finite numbers")
        uv = None
    if uv is part.uv and finite.all():
        return part
    return msgspec.structs.replace(
        part,
        triangles=part.triangles[finite],
        colors=None if part.colors is None else part.colors[finite],
        uv=None if uv is None else uv[finite],
        material=part.material
        if uv is part.uv
        else msgspec.structs.replace(part.material, texture=None),
    )


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
        from collada.polylist import Polylist
        from collada.triangleset import TriangleSet

        from urdf2mbs.meshes import collada as collada_file
    except ImportError as error:
        raise missing_extra(error) from None
    document, skinned, problems = collada_file.load(data)
    mesh.problems += problems
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
            try:
                if isinstance(primitive, Polylist):
                    primitive = primitive.triangleset()
                if not isinstance(primitive, TriangleSet) or not len(primitive.index):
                    continue  # lines, or nothing
                look, channel = Material(), None
                node = bound.materialnodebysymbol.get(primitive.material)
                if node is not None and node.target is not None:
                    if node.target.id not in looks:
                        looks[node.target.id] = _collada_material(mesh, node.target.effect)
                    look, channel = looks[node.target.id]
                sets = {name: number for name, _, number in node.inputs} if node else {}
                _add(
                    mesh, matrix, primitive.vertex, primitive.vertex_index,
                    material=look, smooth=primitive.normal is not None,
                    colors=_collada_colors(mesh, primitive),
                    uv=_collada_uv(primitive, str(sets.get(channel, ""))) if look.texture else None,
                )  # fmt: skip
            except (ConfigError, MemoryError):
                raise
            except Exception as error:  # what this one is broken in does not concern the others
                mesh.problems.append(
                    f"a part of geometry '{bound.original.id}' is left out: {error}"
                )
    if skinned:
        mesh.problems.append("its skinned parts (instance_controller) are left out")


def _collada_colors(mesh: Mesh, triangles: Any) -> Any:
    import numpy as np

    if not triangles.sources.get("COLOR"):
        return None
    offset, *_, source = triangles.sources["COLOR"][0]
    values = np.clip(np.asarray(source.data, float), 0.0, 1.0)
    index = triangles.index[:, :, offset]
    if index.max() >= len(values) or values.shape[1] not in (3, 4) or np.isnan(values).any():
        mesh.problems.append("the colours of its points cannot be read")
        return None
    return np.round(255 * values).astype(int)[index]


def _collada_uv(triangles: Any, wanted: str) -> Any:
    """The texture coordinates of the wanted set, else of the first, by corner."""
    inputs = triangles.sources.get("TEXCOORD")
    if not inputs:
        return None
    chosen = next((n for n, given in enumerate(inputs) if str(given[3]) == wanted), 0)
    return triangles.texcoordset[chosen][triangles.texcoord_indexset[chosen]][..., :2]


def _collada_material(mesh: Mesh, effect: Any) -> tuple[Material, str | None]:
    """What an effect looks like, and the name of its texture's coordinates."""

    def color(value: Any) -> tuple[float, float, float] | None:
        if not isinstance(value, tuple):
            return None
        return (float(value[0]), float(value[1]), float(value[2]))

    name = channel = None
    if effect.diffuse is not None and not isinstance(effect.diffuse, tuple):
        image = effect.diffuse.sampler.surface.image.path or ""
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
            return _utf8(content) if name.lower().endswith(".mtl") else content

    def load(data: bytes) -> Any:
        return trimesh.load_scene(
            io.BytesIO(data), file_type=ending[1:], resolver=Resolver(str(mesh.path)), process=False
        )

    try:
        scenes = [load(_utf8(data) if ending == ".obj" else data)]
        if not len(scenes[0].graph.nodes_geometry):
            raise MeshError("it holds no triangles")
    except Exception as error:  # what it stumbles on may be no point and no face
        if ending == ".obj":
            scenes = [load(_plain_obj(data))]
        elif ending in (".glb", ".gltf"):
            scenes = _load_plain_gltf(load, data)
        else:
            raise
        mesh.problems.append(f"of what it holds only points and faces can be read ({error})")
    for scene, node in ((s, node) for s in scenes for node in s.graph.nodes_geometry):
        matrix, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not isinstance(geometry, trimesh.Trimesh):
            continue  # lines or single points
        try:
            look, colors, uv = _trimesh_look(mesh, geometry)
        except ConfigError:
            raise
        except Exception as error:
            look, colors, uv = Material(), None, None
            mesh.problems.append(f"the colours of '{name}' cannot be read ({error})")
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


def _utf8(text: bytes) -> bytes:
    """A text that is not in UTF-8, as comments and names often are, made readable."""
    return text.decode("utf-8", "replace").encode()


def _plain_obj(data: bytes) -> bytes:
    """An .obj file's points and faces alone, without faces that name other points."""
    points: list[str] = []
    faces: list[str] = []
    for line in data.decode("utf-8", "replace").replace("\\\n", " ").splitlines():
        match line.split():
            case ["v", *numbers]:
                points.append(f"v {' '.join([*numbers[:3], *'000'][:3])}")
            case ["f", *corners]:
                index = [corner.partition("/")[0] for corner in corners]
                if all(re.fullmatch("-?[0-9]+", i) for i in index):
                    which = [int(i) if int(i) > 0 else len(points) + 1 + int(i) for i in index]
                    faces.append(f"f {' '.join(map(str, which))}" if min(which) > 0 else "")
    count = len(points)
    faces = [f for f in faces if f and all(int(i) <= count for i in f.split()[1:])]
    return "\n".join([*points, *faces, ""]).encode()


def _load_plain_gltf(load: Callable[[bytes], Any], data: bytes) -> list[Any]:
    """A scene for each primitive of a glTF file, with nothing but points, faces and where they
    are; none for those that even so cannot be read."""
    document = json.loads(_gltf_text(data))
    shapes = [primitive for shape in document["meshes"] for primitive in shape["primitives"]]
    for key in ("materials", "textures", "images", "samplers", "animations", "skins", "cameras"):
        document.pop(key, None)
    for part in (document, *document["nodes"], *document["meshes"], *shapes):
        for key in ("camera", "skin", "material", "targets", "extensions", "extensionsUsed"):
            part.pop(key, None)

    def alone(shape: dict[str, Any]) -> bytes:
        """The file with this primitive only: trimesh reads what nothing uses, too."""
        used = {shape["attributes"]["POSITION"], shape.get("indices")} - {None}
        accessors = [document["accessors"][i] for i in sorted(used)]
        views = {accessor.get("bufferView") for accessor in accessors} - {None}
        out = document | {
            "accessors": _with_copies(document["accessors"], used),
            "bufferViews": _with_copies(document["bufferViews"], views),
            "meshes": [
                mesh | {"primitives": [p for p in mesh["primitives"] if p is shape]}
                for mesh in document["meshes"]
            ],
        }
        return _with_gltf_text(data, json.dumps(out).encode())

    for shape in shapes:
        shape["attributes"] = {"POSITION": shape["attributes"].get("POSITION")}
    scenes = []
    for shape in shapes:
        try:
            scenes.append(load(alone(shape)))
        except Exception:
            continue  # the caller tells what is wrong
    if not scenes:
        raise MeshError("no part of it can be read")
    return scenes


def _with_copies(all_: list[Any], used: set[Any]) -> list[Any]:
    """The list with one that is used in the place of each that is not."""
    return [one if i in used else all_[min(used)] for i, one in enumerate(all_)]


def _gltf_text(data: bytes) -> bytes:
    """The JSON part of a .gltf or .glb."""
    if data[:4] != b"glTF":
        return data
    return data[20 : 20 + int.from_bytes(data[12:16], "little")]


def _with_gltf_text(data: bytes, text: bytes) -> bytes:
    """The file with another JSON part."""
    if data[:4] != b"glTF":
        return text
    rest = data[20 + int.from_bytes(data[12:16], "little") :]
    text += b" " * (-len(text) % 4)
    size = (20 + len(text) + len(rest)).to_bytes(4, "little")
    return data[:8] + size + len(text).to_bytes(4, "little") + data[16:20] + text + rest


def _check_gltf(data: bytes, ending: str) -> None:
    """Refuse what trimesh would read as zeros."""
    if ending == ".glb" and data[:4] != b"glTF":
        raise MeshError("it does not start with 'glTF'")
    required = set(json.loads(_gltf_text(data)).get("extensionsRequired", ())) - GLTF_EXTENSIONS
    if required:
        raise MeshError(f"it needs the glTF extension {', '.join(sorted(required))}")
