"""COLLADA files, read by pycollada.

pycollada drops broken elements, with all elements that refer to it: without its image an effect,
without the effect a material, without the material a shape.  A file with an error is therefore
read again without its materials, so that its shapes stay.  Each error is a problem of the mesh.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from collada import Collada
from collada.common import DaeError
from collada.polylist import Polylist
from collada.triangleset import TriangleSet
from lxml import etree

from urdf2mbs.plugin import ConfigError, safe_parser
from urdf2mbs_meshes.model import (
    MAX_PARTS,
    NO_LINES,
    RGB,
    UP_AXES,
    Material,
    Mesh,
    MeshError,
    TooLargeError,
    add_part,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf2mbs_meshes.model import Integers

#: The elements that define how shapes look.
LOOK_TAGS = ("library_images", "library_effects", "library_materials", "bind_material")

#: Elements that never hold a surface.
SHAPELESS_TAGS = (
    "library_lights",
    "library_cameras",
    "library_animations",
    "library_animation_clips",
    "library_controllers",
    "instance_light",
    "instance_camera",
    "instance_controller",
    "extra",
    "lines",
    "linestrips",
)

#: Elements whose shapes are dropped, and the problem of a mesh that has some.
DROPPED_TAGS = {
    ("{*}instance_controller",): "its skinned parts (instance_controller) are left out",
    ("{*}lines", "{*}linestrips"): NO_LINES,
}

#: The share of each colour in the luminance of a light (COLLADA 1.4.1, RGB_ZERO).
LUMINANCE = (0.212671, 0.71516, 0.072169)


class LoadedDocument(NamedTuple):
    """A COLLADA document and its problems, in words."""

    document: Collada
    dropped: list[str]
    """The kinds of shapes that are dropped."""
    errors: list[str]


class BoundMaterial(NamedTuple):
    """A material and the name of its texture's coordinates."""

    material: Material
    texture_channel: str | None


def read_collada(mesh: Mesh, data: bytes, up_axis: bool) -> None:
    """Add the parts of a COLLADA file to a mesh.

    Args:
        mesh: The mesh; it gets the problems of the file, too.
        data: The file.
        up_axis: True turns the parts so that z is up, as ``<up_axis>`` says.

    Raises:
        MeshError: The file has no scene, or too many nodes.
        TooLargeError: The file has too many parts or triangles.
    """
    loaded = _load_document(data)
    mesh.problems += loaded.errors
    scene = loaded.document.scene
    if scene is None:
        raise MeshError("it has no scene")
    file_frame = _compute_file_frame(mesh, loaded.document.assetInfo, up_axis)
    materials: dict[str, BoundMaterial] = {}
    for geometry in scene.objects("geometry"):
        transform = file_frame @ np.asarray(geometry.matrix, float)
        for primitive in geometry.original.primitives:
            try:
                _add_primitive(mesh, geometry, primitive, transform, materials)
            except (ConfigError, MemoryError, TooLargeError):
                raise
            except Exception as error:  # the other parts may be good
                name = geometry.original.id
                mesh.problems.append(f"a part of geometry '{name}' is left out: {error}")
    mesh.problems += loaded.dropped


# --- the document ---


def _load_document(data: bytes) -> LoadedDocument:
    """Load a document; raise what pycollada and lxml raise if nothing can be read."""
    parser = safe_parser(remove_comments=True, remove_pis=True, huge_tree=True)
    root = etree.fromstring(data, parser)
    dropped = [
        problem
        for tags, problem in DROPPED_TAGS.items()
        if next(root.iter(*tags), None) is not None
    ]
    _remove_elements(root, SHAPELESS_TAGS)
    _check_copies(root)
    try:
        document = _parse_document(root)
        errors = [str(error) for error in document.errors]
    except Exception as error:  # a broken file can make pycollada raise anything
        errors = [str(error) or type(error).__name__]
    if errors:
        _remove_elements(root, LOOK_TAGS)
        document = _parse_document(root)
        errors += map(str, document.errors)
    return LoadedDocument(document, dropped, errors)


def _parse_document(root: Any) -> Collada:
    """Parse a document; its errors are listed, not raised."""
    return Collada(io.BytesIO(etree.tostring(root)), ignore=[DaeError])


def _remove_elements(root: Any, tags: tuple[str, ...]) -> None:
    """Remove the elements of some tags, in any namespace."""
    for element in list(root.iter(*(f"{{*}}{tag}" for tag in tags))):
        element.getparent().remove(element)


def _check_copies(root: Any) -> None:
    """Raise MeshError if nodes contain themselves, or copies of copies without number."""
    if next(root.iter("{*}instance_node"), None) is None:
        return
    nodes_by_url = {f"#{node.get('id')}": node for node in root.iter("{*}node")}
    count = 0
    remaining = list(root.iter("{*}visual_scene"))
    while remaining:
        node = remaining.pop()
        copies = (
            nodes_by_url.get(instance.get("url"))
            for instance in node.iterchildren("{*}instance_node")
        )
        remaining += node.iterchildren("{*}node")
        remaining += (copy for copy in copies if copy is not None)
        count += 1
        if count > MAX_PARTS:
            raise MeshError(f"it has more than {MAX_PARTS} nodes, each copy counted")


def _compute_file_frame(mesh: Mesh, asset: Any, up_axis: bool) -> NDArray[np.float64]:
    """Return the (4, 4) transform of the file to metres and, if ``up_axis``, to z up."""
    frame = np.eye(4)
    frame[:3, :3] *= 1.0 if asset.unitmeter is None else float(asset.unitmeter)
    up_direction = asset.upaxis or "Y_UP"
    if up_axis and up_direction != "Z_UP":
        frame[:3, :3] = np.array(UP_AXES[up_direction]) @ frame[:3, :3]
        mesh.applied_up_axis = up_direction
    return frame


# --- its parts ---


def _add_primitive(
    mesh: Mesh,
    geometry: Any,
    primitive: Any,
    transform: NDArray[np.float64],
    materials: dict[str, BoundMaterial],
) -> None:
    """Add the triangles of a primitive to a mesh; lines and empty primitives are ignored.

    Args:
        mesh: The mesh.
        geometry: The primitive's geometry, as it is bound in the scene.
        primitive: A set of triangles or polygons of pycollada.
        transform: (4, 4) from the frame of the geometry to that of the mesh.
        materials: The materials by id, in which a new one is kept.
    """
    if isinstance(primitive, Polylist):
        primitive = primitive.triangleset()
    if not isinstance(primitive, TriangleSet) or not len(primitive.index):
        return
    bound = BoundMaterial(Material(), None)
    node = geometry.materialnodebysymbol.get(primitive.material)
    if node is not None and node.target is not None:
        if node.target.id not in materials:
            materials[node.target.id] = _read_material(mesh, node.target.effect)
        bound = materials[node.target.id]
    channels = {name: number for name, _, number in node.inputs} if node else {}
    coordinate_set = str(channels.get(bound.texture_channel, ""))
    add_part(
        mesh,
        transform,
        primitive.vertex,
        primitive.vertex_index,
        material=bound.material,
        smooth=primitive.normal is not None,
        colors=_read_colors(mesh, primitive),
        uv=_read_texture_coordinates(primitive, coordinate_set) if bound.material.texture else None,
    )


def _read_colors(mesh: Mesh, triangles: Any) -> Integers | None:
    """Return the (m, 3, k) colours of the corners, 0 to 255; None if there are no usable ones."""
    if not triangles.sources.get("COLOR"):
        return None
    offset, *_, source = triangles.sources["COLOR"][0]
    palette = np.clip(np.asarray(source.data, float), 0.0, 1.0)
    index = triangles.index[:, :, offset]
    is_usable = index.max() < len(palette) and palette.shape[1] in (3, 4)
    if not is_usable or np.isnan(palette).any():
        mesh.problems.append("the colours of its points cannot be read")
        return None
    colors: Integers = np.round(255 * palette).astype(int)[index]
    return colors


def _read_texture_coordinates(triangles: Any, set_number: str) -> Any:
    """Return the (m, 3, 2) texture coordinates of a set, or else of the first set."""
    inputs = triangles.sources.get("TEXCOORD")
    if not inputs:
        return None
    numbers = [str(entry[3]) for entry in inputs]
    index = numbers.index(set_number) if set_number in numbers else 0
    return triangles.texcoordset[index][triangles.texcoord_indexset[index]][..., :2]


def _read_material(mesh: Mesh, effect: Any) -> BoundMaterial:
    """Read an effect; the image of its texture is added to the mesh."""
    texture = channel = None
    if effect.diffuse is not None and not isinstance(effect.diffuse, tuple):
        image_name = effect.diffuse.sampler.surface.image.path or ""
        channel = effect.diffuse.texcoord
        data = mesh.read_file(image_name)
        texture = None if data is None else mesh.add_texture(data, image_name)
    shininess = effect.shininess if isinstance(effect.shininess, (int, float)) else None
    material = Material(
        diffuse=_read_color(effect.diffuse),
        transparency=1.0 - _compute_opacity(effect),
        emissive=_read_color(effect.emission),
        specular=_read_color(effect.specular),
        shininess=None if shininess is None else min(shininess / 128, 1.0),
        texture=texture,
    )
    return BoundMaterial(material, channel)


def _read_color(value: Any) -> RGB | None:
    """Return a colour of pycollada without its opacity; None for a texture or for no colour."""
    if not isinstance(value, tuple):
        return None
    return (float(value[0]), float(value[1]), float(value[2]))


def _compute_opacity(effect: Any) -> float:
    """Compute the opacity of an effect (COLLADA 1.4.1, chapter 7, "Determining Transparency").

    With the transparency t and the colour (r, g, b, a) of ``transparent`` it is ``t a`` in the
    mode A_ONE, and ``1 - t luminance(r, g, b)`` in the mode RGB_ZERO.  An effect that would be
    invisible is opaque: exporters that write this mean opaque.
    """
    amount = effect.transparency if isinstance(effect.transparency, (int, float)) else 1.0
    color = effect.transparent if isinstance(effect.transparent, tuple) else (0.0, 0.0, 0.0, 1.0)
    if effect.opaque_mode == "RGB_ZERO":
        red, green, blue = LUMINANCE
        opacity = 1.0 - amount * (red * color[0] + green * color[1] + blue * color[2])
    else:
        opacity = amount * color[3]
    return 1.0 if opacity <= 0.0 else min(opacity, 1.0)
