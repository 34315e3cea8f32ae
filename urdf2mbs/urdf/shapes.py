"""``<visual>``, ``<collision>`` and ``<material>``: shapes, their poses and their appearance."""

from __future__ import annotations

import re
from itertools import chain
from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.elements import ELEMENTS, is_drake, plain, split_tag
from urdf2mbs.urdf.model import Collision, Material, Visual

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
    name = reading.values(element).get("name")
    parts = reading.parts(element)
    material = None
    if "material" in parts:
        material = read_material(reading, parts["material"])
    shape = read_shape(reading, element, parts)
    if shape is not None:
        visuals.append(Visual(*shape, material, name, element.sourceline))


def read_collision(reading: Reading, element: Any, collisions: list[Collision]) -> None:
    """Append a ``<collision>``: its shape and origin (m, rad) in its link's frame."""
    name = reading.values(element).get("name")
    shape = read_shape(reading, element, reading.parts(element))
    if shape is not None:
        collisions.append(Collision(*shape, name, element.sourceline))


def read_shape(
    reading: Reading, element: Any, parts: dict[str, Any]
) -> tuple[Geometry, Origin] | None:
    """Return the geometry and origin of a visual or collision.

    Args:
        reading: The file being read.
        element: The ``<visual>`` or ``<collision>``.
        parts: Its children, by tag.

    Returns:
        None, after a warning, if the shape is not known or cannot be read.
    """
    try:
        geometry = read_geometry(reading, element, parts.get("geometry"))
        return None if geometry is None else (geometry, reading.origin(parts.get("origin")))
    except ConversionError as error:
        reading.warn_of_left_out(element, f"a <{element.tag}>", error)
        return None


def read_geometry(reading: Reading, owner: Any, element: Any) -> Geometry | None:
    """Return the shape in ``<geometry>`` (m); None, after a warning, if no shape is known.

    Args:
        reading: The file being read.
        owner: The ``<visual>`` or ``<collision>``.
        element: The ``<geometry>``; None if there is no such element.

    Raises:
        ConversionError: A number cannot be read.
    """
    shape = _find_shape(reading, owner, element)
    if shape is None:
        return None
    values = reading.values(shape)
    if shape.tag == "mesh":
        filename = values.get("filename", "")
        if not filename.strip():
            message = f"<{owner.tag}> whose mesh has no filename is left out"
            reading.warn("geometry-unknown", message, shape.sourceline)
            return None
        values["filename"] = re.sub(_UNRESOLVED, "", filename)
        if "scale" in values:
            values["scale"] = read_scale(reading, shape, values["scale"])
    struct: Any = ELEMENTS[shape.tag].struct
    geometry: Geometry = struct(**values)
    if min(_list_sizes(values), default=1.0) <= 0.0:
        message = f"the <{shape.tag}> of a <{owner.tag}> has a size of zero or less, and is kept"
        reading.warn("geometry-size", message, shape.sourceline)
    return geometry


def _find_shape(reading: Reading, owner: Any, element: Any) -> Any:
    """Return the first known shape in ``<geometry>``; None, after a warning, without one."""
    shapes = [] if element is None else [child for child in element if isinstance(child.tag, str)]
    if element is not None:
        reading.values(element)
    if not shapes:
        message = f"<{owner.tag}> without a geometry is left out"
        reading.warn("geometry-unknown", message, owner.sourceline)
        return None
    for shape in shapes:
        name = split_tag(shape.tag)[0]
        if is_drake(shape.tag) and name in SHAPES:  # <drake:capsule>
            shape.tag = name
    first, *rest = sorted(shapes, key=lambda child: child.tag not in SHAPES)
    for child in rest:
        if child.tag in SHAPES:
            message = "more than one shape in <geometry>: only the first is used"
            reading.warn("doubled-element", message, child.sourceline)
    unknown = [child for child in rest if child.tag not in SHAPES]
    reading.unknown_children("geometry", unknown, SHAPES)
    if first.tag in SHAPES:
        return first
    reading.report_xacro(first)
    message = f"<{owner.tag}> is left out, its geometry <{plain(first.tag)}> is not known"
    reading.warn("geometry-unknown", message, first.sourceline)
    return None


def _list_sizes(values: dict[str, Any]) -> list[float]:
    """Return the sizes of a shape (m), and the scale of a mesh, which is a mirror below zero."""
    if "filename" in values:
        return [abs(factor) for factor in values.get("scale", ())]
    sizes = (size if isinstance(size, tuple) else (size,) for size in values.values())
    return list(chain.from_iterable(sizes))


def read_scale(reading: Reading, element: Any, text: str) -> Vec:
    """Return the scale of a mesh: three numbers, or one for all directions."""
    if len(text.split()) != 1:
        x, y, z = reading.numbers(element, "scale", text, 3)
        return (x, y, z)
    factor = reading.number(element, "scale", text)
    message = "the scale of a mesh is one number, taken for all directions"
    reading.warn("mesh-scale", message, element.sourceline, detail=text.strip())
    return (factor, factor, factor)


def read_material(reading: Reading, element: Any) -> Material | None:
    """Return a material: name, colour (red, green, blue, alpha from 0 to 1) and texture.

    Returns:
        None if the element has none of these.
    """
    name = reading.values(element).get("name", "")
    color: tuple[float, float, float, float] | None = None
    parts = reading.parts(element)
    if "color" in parts:
        child = parts["color"]
        try:
            color = reading.values(child)["rgba"]
        except ConversionError as error:
            reading.warn_of_left_out(child, "a colour", error)
            reading.colourless.add(name)
        if color is not None and (min(color) < 0.0 or max(color) > 1.0):
            reading.warn("color-range", "rgba is not within 0 and 1", child.sourceline)
    texture = None
    if "texture" in parts:
        texture = reading.values(parts["texture"]).get("filename") or None
    if not name and color is None and texture is None:
        return None
    return Material(name, color, texture)


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
    used = []
    for link in robot.links.values():
        for visual in link.visuals:
            material = visual.material
            if material is not None and material.name:
                if material.color is None and material.texture is None:
                    used.append((material.name, link.name, visual.line))
                else:
                    robot.materials.setdefault(material.name, material)
    for name, link_name, line in used:
        if name not in robot.materials and name not in reading.colourless:
            message = f"the material '{name}' is not defined, and grey"
            owner, like = ("link", link_name), (name, robot.materials)
            reading.warn("material-undefined", message, line, owner=owner, like=like)
