"""``<visual>``, ``<collision>`` and ``<material>``: shapes, where they are and how they look."""

from __future__ import annotations

import re
from itertools import chain
from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.elements import is_drake, plain, split_tag
from urdf2mbs.urdf.model import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Material,
    Mesh,
    Sphere,
    Visual,
)

if TYPE_CHECKING:
    from urdf2mbs.spatial import Vec
    from urdf2mbs.urdf.model import Geometry, Origin, Robot
    from urdf2mbs.urdf.values import Reading

#: The model's class of each shape; it calls the attributes as URDF does.
SHAPES: dict[str, Any] = {
    "box": Box,
    "cylinder": Cylinder,
    "capsule": Capsule,
    "sphere": Sphere,
    "mesh": Mesh,
}
#: What xacro makes of ``file://$(find NAME)/...`` where the package was not found.
_UNRESOLVED = r"^file:/*(?=package://)"


def read_visual(reading: Reading, element: Any, visuals: list[Visual]) -> None:
    """Append a ``<visual>``: its shape, origin (m, rad) in its link's frame, and material."""
    name = reading.values(element).get("name")
    parts = reading.parts(element)
    material = parts.get("material")
    look = None if material is None else read_material(reading, material)
    placed = read_shape(reading, element, parts)
    if placed is not None:
        visuals.append(Visual(*placed, look, name, element.sourceline))


def read_collision(reading: Reading, element: Any, collisions: list[Collision]) -> None:
    """Append a ``<collision>``: its shape and origin (m, rad) in its link's frame."""
    name = reading.values(element).get("name")
    placed = read_shape(reading, element, reading.parts(element))
    if placed is not None:
        collisions.append(Collision(*placed, name, element.sourceline))


def read_shape(
    reading: Reading, element: Any, parts: dict[str, Any]
) -> tuple[Geometry, Origin] | None:
    """Geometry and origin of a visual or collision; None, with a warning: they cannot be read."""
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
        element: The ``<geometry>``; None if there is none.

    Raises:
        ConversionError: A number cannot be read.
    """
    shapes = [] if element is None else [child for child in element if isinstance(child.tag, str)]
    if element is not None:
        reading.values(element)
    if not shapes:
        what = f"<{owner.tag}> without a geometry is left out"
        reading.warn("geometry-unknown", what, owner.sourceline)
        return None
    for shape in shapes:
        if is_drake(shape.tag) and split_tag(shape.tag)[0] in SHAPES:  # <drake:capsule>
            shape.tag = split_tag(shape.tag)[0]
    shape, *others = sorted(shapes, key=lambda child: child.tag not in SHAPES)
    for child in others:
        if child.tag in SHAPES:
            what = "more than one shape in <geometry>: only the first is used"
            reading.warn("doubled-element", what, child.sourceline)
    unknown = [child for child in others if child.tag not in SHAPES]
    reading.unknown_children("geometry", unknown, SHAPES)
    kind = SHAPES.get(shape.tag)
    if kind is None:
        reading.report_xacro(shape)
        what = f"<{owner.tag}> is left out, its geometry <{plain(shape.tag)}> is not known"
        reading.warn("geometry-unknown", what, shape.sourceline)
        return None
    values = reading.values(shape)
    if kind is Mesh:
        filename = values.get("filename", "")
        if not filename.strip():
            what = f"<{owner.tag}> whose mesh has no filename is left out"
            reading.warn("geometry-unknown", what, shape.sourceline)
            return None
        values["filename"] = re.sub(_UNRESOLVED, "", filename)
        if "scale" in values:
            values["scale"] = read_scale(reading, shape, values["scale"])
    sizes = chain.from_iterable(
        map(abs, value) if kind is Mesh else value if isinstance(value, tuple) else [value]
        for name, value in values.items()
        if name != "filename"
    )
    if min(sizes, default=1.0) <= 0.0:  # a scale below zero is a mirror
        what = f"the <{shape.tag}> of a <{owner.tag}> has a size of zero or less, and is kept"
        reading.warn("geometry-size", what, shape.sourceline)
    return kind(**values)


def read_scale(reading: Reading, element: Any, text: str) -> Vec:
    """The scale of a mesh: three numbers, or one for all directions."""
    if len(text.split()) != 1:
        x, y, z = reading.numbers(element, "scale", text, 3)
        return (x, y, z)
    factor = reading.number(element, "scale", text)
    reading.warn(
        "mesh-scale", "the scale of a mesh is one number, taken for all directions",
        element.sourceline, detail=text.strip(),
    )  # fmt: skip
    return (factor, factor, factor)


def read_material(reading: Reading, element: Any) -> Material | None:
    """Name, colour (red, green, blue, alpha from 0 to 1) and texture; None: nothing of use."""
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
    named = reading.values(parts["texture"]) if "texture" in parts else {}
    texture = named.get("filename") or None
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
    """A material that a link defines in place is known by its name everywhere."""
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
            reading.warn(
                "material-undefined", f"the material '{name}' is not defined, and grey",
                line, owner=("link", link_name), like=(name, robot.materials),
            )  # fmt: skip
