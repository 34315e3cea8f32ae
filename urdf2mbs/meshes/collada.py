"""COLLADA files as pycollada reads them, and what of a broken one can still be read.

pycollada drops whatever names something broken: a sampler without its surface loses the effect,
the effect its material, the material all the shapes that wear it.  Here a broken thing is taken
out, with what names it, before pycollada sees the file.  So a shape is lost only where its own
points or faces are broken.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from collada import Collada
from collada.common import DaeError
from collada.geometry import Geometry
from collada.material import CImage, Effect, Material
from collada.polylist import Polylist
from collada.scene import loadNode
from collada.triangleset import TriangleSet
from lxml import etree

from urdf2mbs.meshes.model import MOST_PARTS, UP_AXES, Mesh, MeshError, TooLargeError, add
from urdf2mbs.meshes.model import Material as Look
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.xml import lines as xml_lines

#: Elements that never hold a shape.
NO_SHAPES = (
    "library_lights", "library_cameras", "library_animations", "library_animation_clips",
    "library_controllers", "instance_light", "instance_camera", "instance_controller",
    "extra", "lines", "linestrips",
)  # fmt: skip

#: Elements that say where a node is.
TRANSFORMS = ("translate", "rotate", "scale", "matrix", "lookat")


def read(mesh: Mesh, data: bytes, up_axis: bool) -> None:
    """Put the file's parts into ``mesh``; ``up_axis``: turn them so that z is up."""
    document, skinned, problems = load(data)
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
    if skinned:
        mesh.problems.append("its skinned parts (instance_controller) are left out")


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


def load(data: bytes) -> tuple[Collada, bool, list[str]]:
    """The document, whether it has skinned parts (which are left out), and what of it is
    broken.  Raises what pycollada and lxml raise, where nothing can be read."""
    parser = xml_lines.parser(remove_comments=True, remove_pis=True, huge_tree=True)
    root = etree.fromstring(data, parser)
    skinned = next(root.iter("{*}instance_controller"), None) is not None
    for tag in NO_SHAPES:
        for element in list(root.iter(f"{{*}}{tag}")):
            _remove(element)
    _check_copies(root)
    problems: list[str] = []
    try:
        document = _collada(root)
        broken = bool(document.errors) or document.scene is None
    except Exception:  # a broken file can make it raise anything
        broken = True
    if broken:
        problems = _mend(root)
        document = _collada(root)
        problems += [str(error) for error in document.errors]
    return document, skinned, list(dict.fromkeys(problems))


def _check_copies(root: Any) -> None:
    """Raise MeshError for nodes that contain themselves, or copies of copies without number."""
    if next(root.iter("{*}instance_node"), None) is None:
        return
    nodes = list(root.iter("{*}node"))
    named = {f"#{node.get('id')}": node for node in nodes}
    copies: dict[Any, int] = {}
    begun = set()
    todo = list(nodes)
    while todo:
        node = todo[-1]
        inner = [*node.iterchildren("{*}node")]
        inner += [
            named[one.get("url")]
            for one in node.iterchildren("{*}instance_node")
            if one.get("url") in named
        ]
        missing = [one for one in inner if one not in copies]
        if node not in begun:
            begun.add(node)
            todo += missing
        elif missing:
            raise MeshError(f"its node '{node.get('id')}' contains itself")
        else:
            copies[node] = 1 + sum(copies[one] for one in inner)
            todo.pop()
            if copies[node] > MOST_PARTS:
                raise MeshError(f"it has more than {MOST_PARTS} nodes, each copy counted")


def _collada(root: Any) -> Collada:
    return Collada(io.BytesIO(etree.tostring(root)), ignore=[DaeError])


def _mend(root: Any) -> list[str]:
    """Take out only what cannot be read; the result says what that was."""
    told: list[str] = []
    document = _collada(etree.Element(root.tag, nsmap=root.nsmap))

    def drop(element: Any, why: object) -> None:
        name = element.get("id") or element.get("target") or element.get("url") or ""
        told.append(f"{etree.QName(element).localname} '{name}' is left out: {why}")
        _remove(element)

    for path, kind, loaded in (
        ("library_images/image", CImage, document.images),
        ("library_effects/effect", Effect, document.effects),
        ("library_materials/material", Material, document.materials),
    ):
        for element in _find(root, path):
            try:
                loaded.append(kind.load(document, {}, element))
            except Exception as error:
                drop(element, error)
    for geometry in _find(root, "library_geometries/geometry"):
        try:
            Geometry.load(document, {}, geometry)
        except Exception as error:
            for mesh in _find(geometry, "mesh"):
                _mend_mesh(document, geometry, mesh)
            told.append(f"of geometry '{geometry.get('id')}' only a part can be read: {error}")
    for node in list(root.iter("{*}node")):
        try:
            for tag in TRANSFORMS:
                for transform in _find(node, tag):
                    loadNode(document, transform, {})
        except Exception as error:  # without it the shapes would be in the wrong place
            drop(node, error)
    for tag, attribute, named in (
        ("instance_material", "target", "library_materials/material"),
        ("instance_geometry", "url", "library_geometries/geometry"),
        ("instance_node", "url", "library_nodes//node"),
    ):
        known = {f"#{element.get('id')}" for element in _find(root, named)}
        for element in list(root.iter(f"{{*}}{tag}")):
            if element.get(attribute) not in known:
                drop(element, "what it names is not there")
    _mend_scene(root, told)
    return told


def _mend_mesh(document: Collada, geometry: Any, mesh: Any) -> None:
    """Keep only the points, and the faces that can be read."""
    points = [e for e in _find(mesh, "vertices/input") if e.get("semantic") == "POSITION"]
    sources = {element.get("source") for element in points}
    primitives = [element for element in mesh if element.find("{*}p") is not None]
    for element in [*mesh, *_find(mesh, "vertices/input")]:
        tag = etree.QName(element).localname
        if not (
            tag == "vertices" or element in points
            or (tag == "source" and f"#{element.get('id')}" in sources)
        ):  # fmt: skip
            _remove(element)
    good = []
    for primitive in primitives:
        mesh.append(primitive)
        try:
            _only_points(primitive)
            Geometry.load(document, {}, geometry)
        except Exception:
            pass  # the caller has told why
        else:
            good.append(primitive)
        _remove(primitive)
    mesh.extend(good)


def _only_points(primitive: Any) -> None:
    """Take the other inputs (normals, colours, texture coordinates) out of the faces' indices."""
    inputs = _find(primitive, "input")
    count = 1 + max(int(element.get("offset")) for element in inputs)
    for element in inputs:
        if element.get("semantic") == "VERTEX":
            offset = int(element.get("offset"))
            element.set("offset", "0")
        else:
            _remove(element)
    for index in _find(primitive, "p"):
        index.text = " ".join(index.text.split()[offset::count])


def _mend_scene(root: Any, told: list[str]) -> None:
    """Show the only visual scene where the file does not say which one."""
    scenes = _find(root, "library_visual_scenes/visual_scene")
    shown = _find(root, "scene/instance_visual_scene")
    if len(scenes) == 1 and (
        not shown or shown[0].get("url") != f"#{scenes[0].get('id')}" or not scenes[0].get("id")
    ):
        for element in _find(root, "scene"):
            _remove(element)
        scenes[0].set("id", scenes[0].get("id") or "scene")
        tag = root.tag[: -len("COLLADA")]
        scene = etree.SubElement(root, f"{tag}scene")
        etree.SubElement(scene, f"{tag}instance_visual_scene", url=f"#{scenes[0].get('id')}")
        told.append("it does not say which scene it shows; it has one")


def _find(element: Any, path: str) -> list[Any]:
    """The elements at a path, in whatever namespace."""
    steps = (f"{{*}}{tag}" if tag else "" for tag in path.split("/"))
    elements: list[Any] = element.findall("/".join(steps))
    return elements


def _remove(element: Any) -> None:
    element.getparent().remove(element)
