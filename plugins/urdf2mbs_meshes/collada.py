"""COLLADA files as pycollada reads them.

pycollada leaves out what is broken, with all that names it: without its image an effect, without
the effect a material, without the material a shape.  A file with a fault is read again without its
materials, so that its shapes stay.  Each fault is a problem of the mesh.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from collada import Collada
from collada.common import DaeError
from collada.polylist import Polylist
from collada.triangleset import TriangleSet
from lxml import etree

from urdf2mbs.plugin import ConfigError, safe_parser
from urdf2mbs_meshes.model import MOST_PARTS, NO_LINES, UP_AXES, Mesh, MeshError, TooLargeError, add
from urdf2mbs_meshes.model import Material as Look

#: The elements that say how shapes look.
LOOKS = ("library_images", "library_effects", "library_materials", "bind_material")

#: Elements that never hold a shape.
NO_SHAPES = (
    "library_lights", "library_cameras", "library_animations", "library_animation_clips",
    "library_controllers", "instance_light", "instance_camera", "instance_controller",
    "extra", "lines", "linestrips",
)  # fmt: skip


#: Elements that hold shapes which are left out, and what is said of them.
LEFT_OUT = {
    ("{*}instance_controller",): "its skinned parts (instance_controller) are left out",
    ("{*}lines", "{*}linestrips"): NO_LINES,
}


def read(mesh: Mesh, data: bytes, up_axis: bool) -> None:
    """Put the file's parts into ``mesh``; ``up_axis``: turn them so that z is up."""
    document, left_out, problems = load(data)
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
    looks: dict[str, tuple[Look, str | None]] = {}
    for bound in document.scene.objects("geometry"):
        matrix = frame @ np.asarray(bound.matrix, float)
        for primitive in bound.original.primitives:
            try:
                if isinstance(primitive, Polylist):
                    primitive = primitive.triangleset()
                if not isinstance(primitive, TriangleSet) or not len(primitive.index):
                    continue  # lines, or nothing
                look, channel = Look(), None
                node = bound.materialnodebysymbol.get(primitive.material)
                if node is not None and node.target is not None:
                    if node.target.id not in looks:
                        looks[node.target.id] = _material(mesh, node.target.effect)
                    look, channel = looks[node.target.id]
                sets = {name: number for name, _, number in node.inputs} if node else {}
                add(
                    mesh, matrix, primitive.vertex, primitive.vertex_index,
                    material=look, smooth=primitive.normal is not None,
                    colors=_colors(mesh, primitive),
                    uv=_uv(primitive, str(sets.get(channel, ""))) if look.texture else None,
                )  # fmt: skip
            except (ConfigError, MemoryError, TooLargeError):
                raise
            except Exception as error:  # the other parts may be good
                mesh.problems.append(
                    f"a part of geometry '{bound.original.id}' is left out: {error}"
                )
    mesh.problems += left_out


def _colors(mesh: Mesh, triangles: Any) -> Any:
    if not triangles.sources.get("COLOR"):
        return None
    offset, *_, source = triangles.sources["COLOR"][0]
    values = np.clip(np.asarray(source.data, float), 0.0, 1.0)
    index = triangles.index[:, :, offset]
    if index.max() >= len(values) or values.shape[1] not in (3, 4) or np.isnan(values).any():
        mesh.problems.append("the colours of its points cannot be read")
        return None
    return np.round(255 * values).astype(int)[index]


def _uv(triangles: Any, wanted: str) -> Any:
    """The texture coordinates of the wanted set, else of the first, by corner."""
    inputs = triangles.sources.get("TEXCOORD")
    if not inputs:
        return None
    chosen = next((n for n, given in enumerate(inputs) if str(given[3]) == wanted), 0)
    return triangles.texcoordset[chosen][triangles.texcoord_indexset[chosen]][..., :2]


def _material(mesh: Mesh, effect: Any) -> tuple[Look, str | None]:
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
    look = Look(
        diffuse=color(effect.diffuse),
        transparency=1.0 - opacity,
        emissive=color(effect.emission),
        specular=color(effect.specular),
        shininess=None if shininess is None else min(shininess / 128, 1.0),
        texture=name,
    )
    return look, channel


def load(data: bytes) -> tuple[Collada, list[str], list[str]]:
    """Return the document, which of its shapes are left out, and what is wrong with it.

    Raises what pycollada and lxml raise, where nothing can be read.
    """
    parser = safe_parser(remove_comments=True, remove_pis=True, huge_tree=True)
    root = etree.fromstring(data, parser)
    left_out = [what for tags, what in LEFT_OUT.items() if next(root.iter(*tags), None) is not None]
    _remove(root, NO_SHAPES)
    _check_copies(root)
    try:
        document = _collada(root)
        problems = [str(error) for error in document.errors]
    except Exception as error:  # a broken file can make pycollada raise anything
        problems = [str(error) or type(error).__name__]
    if problems:
        _remove(root, LOOKS)
        document = _collada(root)
        problems += map(str, document.errors)
    return document, left_out, problems


def _collada(root: Any) -> Collada:
    return Collada(io.BytesIO(etree.tostring(root)), ignore=[DaeError])


def _remove(root: Any, tags: tuple[str, ...]) -> None:
    for element in list(root.iter(*(f"{{*}}{tag}" for tag in tags))):
        element.getparent().remove(element)


def _check_copies(root: Any) -> None:
    """Raise MeshError for nodes that contain themselves, or copies of copies without number."""
    if next(root.iter("{*}instance_node"), None) is None:
        return
    named = {f"#{node.get('id')}": node for node in root.iter("{*}node")}
    count = 0
    todo = list(root.iter("{*}visual_scene"))
    while todo:
        node = todo.pop()
        copies = (named.get(copy.get("url")) for copy in node.iterchildren("{*}instance_node"))
        todo += [*node.iterchildren("{*}node"), *(copy for copy in copies if copy is not None)]
        count += 1
        if count > MOST_PARTS:
            raise MeshError(f"it has more than {MOST_PARTS} nodes, each copy counted")
