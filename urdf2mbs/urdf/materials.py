"""``<material>``: in a visual, and those of the whole robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.model import Material

if TYPE_CHECKING:
    from urdf2mbs.urdf.model import Robot
    from urdf2mbs.urdf.values import Reading


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
                "material-undefined", f"the material '{name}' is not defined",
                line, owner=("link", link_name), like=(name, robot.materials),
            )  # fmt: skip
