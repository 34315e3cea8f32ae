"""COLLADA files as pycollada reads them, and what of a broken one can still be read.

pycollada drops whatever names something broken: a sampler without its surface loses the effect,
the effect its material, the material all the shapes that wear it.  Here a broken thing is taken
out, with what names it, before pycollada sees the file.  So a shape is lost only where its own
points or faces are broken.
"""

from __future__ import annotations

import io
from typing import Any

from collada import Collada
from collada.common import DaeError
from collada.geometry import Geometry
from collada.material import CImage, Effect, Material
from collada.scene import loadNode
from lxml import etree

#: Elements that never hold a shape.
NO_SHAPES = (
    "library_lights", "library_cameras", "library_animations", "library_animation_clips",
    "library_controllers", "instance_light", "instance_camera", "instance_controller",
    "extra", "lines", "linestrips",
)  # fmt: skip

#: Elements that say where a node is.
TRANSFORMS = ("translate", "rotate", "scale", "matrix", "lookat")


def load(data: bytes) -> tuple[Collada, bool, list[str]]:
    """The document, whether it has skinned parts (which are left out), and what of it is
    broken.  Raises what pycollada and lxml raise, where nothing can be read."""
    parser = etree.XMLParser(
        remove_comments=True, remove_pis=True, huge_tree=True,
        resolve_entities=False, no_network=True,
    )  # fmt: skip
    root = etree.fromstring(data, parser)
    skinned = next(root.iter("{*}instance_controller"), None) is not None
    for tag in NO_SHAPES:
        for element in list(root.iter(f"{{*}}{tag}")):
            _remove(element)
    problems: list[str] = []
    try:
        document = _collada(root)
        broken = bool(document.errors) or document.scene is None
    except Exception:  # it raises whatever a broken file makes it stumble on
        broken = True
    if broken:
        problems = _mend(root)
        document = _collada(root)
        problems += [str(error) for error in document.errors]
    return document, skinned, list(dict.fromkeys(problems))


def _collada(root: Any) -> Collada:
    return Collada(io.BytesIO(etree.tostring(root)), ignore=[DaeError])


def _mend(root: Any) -> list[str]:
    """Take out what cannot be read, and no more; the result names it."""
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
    """Keep points and faces only, and of the faces those that can be read."""
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
    found: list[Any] = element.findall("/".join(steps))
    return found


def _remove(element: Any) -> None:
    element.getparent().remove(element)
