"""``<visual>``, ``<collision>`` and ``<material>``: shapes, their poses and their appearance."""

from __future__ import annotations

import re
from itertools import chain
from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.elements import ELEMENTS, is_drake, plain, split_tag
from urdf2mbs.urdf.model import Collision, Material, Visual
from urdf2mbs.urdf.unread import report_xacro

if TYPE_CHECKING:
    from urdf2mbs.spatial import Vec
    from urdf2mbs.urdf.model import Geometry, Origin, Robot
    from urdf2mbs.urdf.values import Reading

#: The tags of shapes.
SHAPES = ELEMENTS["geometry"].children
#: xacro makes this of ``file://$(find NAME)/...`` if the package was not found.
_UNRESOLVED = r"^file:/*(?=package://)"


def read_visual(reading: Reading, element: Any, visuals: list[Visual]) -> None:
    """Append a ``<visual>``: its shape, origin (m, rad) in its link's frame, and material."""
    visual_name = reading.values(element).get("name")
    children = reading.parts(element)
    material = None
    if "material" in children:
        material = read_material(reading, children["material"])
    shape = read_shape(reading, element, children)
    if shape is not None:
        visuals.append(Visual(*shape, material, visual_name, element.sourceline))


def read_collision(reading: Reading, element: Any, collisions: list[Collision]) -> None:
    """Append a ``<collision>``: its shape and origin (m, rad) in its link's frame."""
    collision_name = reading.values(element).get("name")
    shape = read_shape(reading, element, reading.parts(element))
    if shape is not None:
        collisions.append(Collision(*shape, collision_name, element.sourceline))


def read_shape(
    reading: Reading, element: Any, children: dict[str, Any]
) -> tuple[Geometry, Origin] | None:
    """Return the geometry and origin of a visual or collision.

    Args:
        reading: The file being read.
        element: The ``<visual>`` or ``<collision>``.
        children: Its children, by tag.

    Returns:
        None, after a warning, if the shape is not known or cannot be read.
    """
    try:
        geometry = read_geometry(reading, element, children.get("geometry"))
        return None if geometry is None else (geometry, reading.origin(children.get("origin")))
    except ConversionError as error:
        reading.warn_of_left_out(element, f"a <{element.tag}>", error)
        return None


def read_geometry(reading: Reading, shape_owner: Any, element: Any) -> Geometry | None:
    """Return the shape in ``<geometry>`` (m); None, after a warning, if no shape is known.

    Args:
        reading: The file being read.
        shape_owner: The ``<visual>`` or ``<collision>``.
        element: The ``<geometry>``; None if there is no such element.

    Raises:
        ConversionError: A number cannot be read.
    """
    shape_element = _find_shape(reading, shape_owner, element)
    if shape_element is None:
        return None
    values = reading.values(shape_element)
    if shape_element.tag == "mesh":
        filename = values.get("filename", "")
        if not filename.strip():
            message = f"<{shape_owner.tag}> whose mesh has no filename is left out"
            reading.warn("geometry-unknown", message, shape_element.sourceline)
            return None
        values["filename"] = re.sub(_UNRESOLVED, "", filename)
        if "scale" in values:
            values["scale"] = read_scale(reading, shape_element, values["scale"])
    struct_class: Any = ELEMENTS[shape_element.tag].struct
    geometry: Geometry = struct_class(**values)
    if min(_list_sizes(values), default=1.0) <= 0.0:
        message = (
            f"the <{shape_element.tag}> of a <{shape_owner.tag}> has a size of zero or less, "
            "and is kept"
        )
        reading.warn("geometry-size", message, shape_element.sourceline)
    return geometry


def _find_shape(reading: Reading, shape_owner: Any, element: Any) -> Any:
    """Return the first known shape in ``<geometry>``; None, after a warning, without one."""
    shapes = [] if element is None else [child for child in element if isinstance(child.tag, str)]
    if element is not None:
        reading.values(element)
    if not shapes:
        message = f"<{shape_owner.tag}> without a geometry is left out"
        reading.warn("geometry-unknown", message, shape_owner.sourceline)
        return None
    for shape in shapes:
        bare_tag = split_tag(shape.tag)[0]
        if is_drake(shape.tag) and bare_tag in SHAPES:  # <drake:capsule>
            shape.tag = bare_tag
    first_shape, *more_shapes = sorted(shapes, key=lambda child: child.tag not in SHAPES)
    for child in more_shapes:
        if child.tag in SHAPES:
            message = "more than one shape in <geometry>: only the first is used"
            reading.warn("doubled-element", message, child.sourceline)
    unknown_shapes = [child for child in more_shapes if child.tag not in SHAPES]
    reading.unknown_children("geometry", unknown_shapes, SHAPES)
    if first_shape.tag in SHAPES:
        return first_shape
    report_xacro(reading, first_shape)
    message = (
        f"<{shape_owner.tag}> is left out, its geometry <{plain(first_shape.tag)}> is not known"
    )
    reading.warn("geometry-unknown", message, first_shape.sourceline)
    return None


def _list_sizes(values: dict[str, Any]) -> list[float]:
    """Return the sizes of a shape (m), and the scale of a mesh, which is a mirror below zero."""
    if "filename" in values:
        return [abs(scale_factor) for scale_factor in values.get("scale", ())]
    sizes = (size if isinstance(size, tuple) else (size,) for size in values.values())
    return list(chain.from_iterable(sizes))


def read_scale(reading: Reading, element: Any, scale_text: str) -> Vec:
    """Return the scale of a mesh: three numbers, or one for all directions."""
    if len(scale_text.split()) != 1:
        x, y, z = reading.numbers(element, "scale", scale_text, 3)
        return (x, y, z)
    scale_factor = reading.number(element, "scale", scale_text)
    message = "the scale of a mesh is one number, taken for all directions"
    reading.warn("mesh-scale", message, element.sourceline, detail=scale_text.strip())
    return (scale_factor, scale_factor, scale_factor)


def read_material(reading: Reading, element: Any) -> Material | None:
    """Return a material: name, colour (red, green, blue, alpha from 0 to 1) and texture.

    Returns:
        None if the element has none of these.
    """
    material_name = reading.values(element).get("name", "")
    color: tuple[float, float, float, float] | None = None
    children = reading.parts(element)
    if "color" in children:
        color_element = children["color"]
        try:
            color = reading.values(color_element)["rgba"]
        except ConversionError as error:
            reading.warn_of_left_out(color_element, "a colour", error)
            reading.colourless.add(material_name)
        if color is not None and (min(color) < 0.0 or max(color) > 1.0):
            reading.warn("color-range", "rgba is not within 0 and 1", color_element.sourceline)
    texture = None
    if "texture" in children:
        texture = reading.values(children["texture"]).get("filename") or None
    if not material_name and color is None and texture is None:
        return None
    return Material(material_name, color, texture)


def read_global_material(reading: Reading, element: Any, robot: Robot) -> None:
    """Add a ``<material>`` of the robot, which links refer to by its name."""
    reading.owner = ("material", element.get("name") or "")
    material = read_material(reading, element)
    if material is None or not material.name:
        reading.warn("material-unnamed", "a material of <robot> has no name", element.sourceline)
    elif material.name in robot.materials:
        reading.warn_of_double("robot", element)
    elif material.color is not None or material.texture is not None:
        robot.materials[material.name] = material


def check_materials(reading: Reading, robot: Robot) -> None:
    """Add the materials that links define to those of the robot; warn of undefined ones."""
    used_materials = []
    for link in robot.links.values():
        for visual in link.visuals:
            material = visual.material
            if material is not None and material.name:
                if material.color is None and material.texture is None:
                    used_materials.append((material.name, link.name, visual.line))
                else:
                    robot.materials.setdefault(material.name, material)
    for material_name, link_name, line in used_materials:
        if material_name not in robot.materials and material_name not in reading.colourless:
            message = f"the material '{material_name}' is not defined, and grey"
            owner, like = ("link", link_name), (material_name, robot.materials)
            reading.warn("material-undefined", message, line, owner=owner, like=like)
