"""Convert visuals: the method's step 4, "Retrieve the visual properties of the URDF link and
adapt them to the MBS body conventions".

Position and scale are the same in both; the orientation is "three fixed frame rotations" in
URDF and three current-frame ones, Rx Ry Rz, in .mbs; a cylinder's axis is z in URDF and y in
.mbs; a capsule is a cylinder and two spheres.  A mesh is shown from the VRML file that it is
converted to.
"""

from __future__ import annotations

import re
from math import pi
from pathlib import PurePosixPath

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk.files import is_portable
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import GREY, Shape
from urdf2mbs.mbs.names import free_name
from urdf2mbs.messages.diagnostics import some
from urdf2mbs.spatial import (
    IDENTITY,
    ZERO,
    Pose,
    Vec,
    compose,
    from_turn,
    multiply,
    to_xyz_angles,
)
from urdf2mbs.urdf.model import Box, Capsule, Cylinder, Geometry, Material, Mesh, Sphere

#: Turns .mbs's y axis onto URDF's z axis.
Y_ONTO_Z = from_turn((1, pi / 2))
#: Where the project keeps its meshes.
VRML = "PRJPATH/animationR/vrml"
#: A .wrl keeps so many letters of its mesh file's name: most file systems allow 255.
_LONGEST = 150


class ConvertVisuals(Pass):
    reads = ("robot", "bodies")
    writes = ("shapes",)

    def run(self, conversion: Conversion) -> None:
        stems: set[str] = set()
        for segment in conversion.segments.values():
            for link, pose in segment.parts.items():
                visuals = conversion.robot.links[link].visuals
                for number, visual in enumerate(visuals, start=1):
                    name = visual.name or (link if len(visuals) == 1 else f"{link}_{number}")
                    for geometry, offset in split_capsule(visual.geometry):
                        at = compose(pose, visual.origin.pose)
                        if offset != ZERO:
                            at = compose(at, Pose(offset))
                        shape = _shape(geometry, name, conversion, stems)
                        rot = multiply(at.rot, Y_ONTO_Z) if shape.kind == "cylinder" else at.rot
                        shape.position = at.xyz
                        shape.rotation = ZERO if rot == IDENTITY else to_xyz_angles(rot)
                        _colour(shape, visual.material, conversion.robot.materials)
                        segment.holder.shapes.append(shape)
        _warn_of_left_out(conversion)


def split_capsule(geometry: Geometry) -> list[tuple[Geometry, Vec]]:
    """Return a capsule as a cylinder and two spheres, as an .mbs has no capsules.

    Returns:
        Each shape, and its place (m) in the frame of the geometry; another geometry as it is.
    """
    if not isinstance(geometry, Capsule):
        return [(geometry, ZERO)]
    end, ball = geometry.length / 2, Sphere(geometry.radius)
    cylinder = Cylinder(geometry.radius, geometry.length)
    return [(cylinder, ZERO), (ball, (0.0, 0.0, end)), (ball, (0.0, 0.0, -end))]


def _shape(geometry: Geometry, name: str, conversion: Conversion, stems: set[str]) -> Shape:
    if isinstance(geometry, Box):
        return Shape("box", name, size=geometry.size)
    if isinstance(geometry, Cylinder):
        return Shape("cylinder", name, radius=geometry.radius, height=geometry.length)
    if isinstance(geometry, Sphere):
        return Shape("sphere", name, radius=geometry.radius)
    assert isinstance(geometry, Mesh)
    stem = conversion.meshes.get(geometry.filename)
    if stem is None:
        stem = conversion.meshes[geometry.filename] = _stem(geometry.filename, stems)
    return Shape("inline", name, scale=geometry.scale, url=f"{VRML}/{stem}.wrl")


def _stem(filename: str, taken: set[str]) -> str:
    """The mesh file's own name, made safe, and unique where letter case does not count."""
    plain = (
        re.sub(r"[^A-Za-z0-9_-]", "_", PurePosixPath(filename.replace("\\", "/")).stem) or "mesh"
    )[:_LONGEST]
    if not is_portable(plain):
        plain = f"{plain}_mesh"
    stem = free_name(plain, taken, str.lower)
    taken.add(stem.lower())
    return stem


def _colour(shape: Shape, material: Material | None, known: dict[str, Material]) -> None:
    """The visual's own colour, else that of the material of its name, else grey."""
    if material is not None and material.color is None:
        material = known.get(material.name)
    if material is None or material.color is None:
        shape.color = GREY
        return
    r, g, b, a = (min(max(c, 0.0), 1.0) for c in material.color)
    shape.color = (round(255 * r), round(255 * g), round(255 * b))
    shape.transparency = 1.0 - a


def _warn_of_left_out(conversion: Conversion) -> None:
    links, known = conversion.robot.links.values(), conversion.robot.materials
    textured = []
    for link in links:
        used = [visual.material for visual in link.visuals if visual.material]
        if any(known.get(material.name, material).texture for material in used):
            textured.append(link.name)
    if textured:
        what = f"textures are left out, as an .mbs shape has a colour only: {some(textured)}"
        conversion.warn("texture", what, link=textured[0])
    collisions = [link.name for link in links if link.collisions]
    if collisions:
        conversion.note("collision", f"collision shapes are left out: {some(collisions)}")
