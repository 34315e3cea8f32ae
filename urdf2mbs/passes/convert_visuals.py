"""Convert visuals: the method's step 4, about the shapes of links.

"Retrieve the visual properties of the URDF link and adapt them to the MBS body conventions":

=============  ======================================  =======================================
               URDF                                    .mbs
=============  ======================================  =======================================
position       (m)                                     the same
orientation    roll, pitch, yaw about fixed axes       Rx Ry Rz about current axes
cylinder       along z                                 along y
capsule        one shape                               a cylinder and two spheres
mesh           a file of any format                    the VRML file that it is converted to
=============  ======================================  =======================================
"""

from __future__ import annotations

import re
from math import pi
from pathlib import PurePosixPath

from urdf2mbs.conversion import Conversion, Segment
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
from urdf2mbs.urdf.model import Box, Capsule, Cylinder, Geometry, Material, Mesh, Sphere, Visual

#: Turns .mbs's y axis onto URDF's z axis.
Y_ONTO_Z = from_turn((1, pi / 2))
#: Where the project has its meshes.
VRML_FOLDER = "PRJPATH/animationR/vrml"
#: A .wrl keeps this many letters of its mesh file's name: most file systems allow 255.
MAX_STEM_LENGTH = 150


class ConvertVisuals(Pass):
    """Convert the shapes of links to shapes of bodies."""

    reads = ("robot", "bodies")
    writes = ("shapes",)

    def run(self, conversion: Conversion) -> None:
        """Add the shapes of each link to the body that the link is a part of."""
        for segment in conversion.segments.values():
            for link, pose in segment.parts.items():
                _add_shapes(conversion, segment, link, pose)
        _report_left_out(conversion)


def _add_shapes(conversion: Conversion, segment: Segment, link: str, link_pose: Pose) -> None:
    """Add the shapes of a link to the body of its segment.

    Args:
        conversion: The robot as a URDF and as an .mbs.
        segment: The links that move as one body.
        link: The name of the link.
        link_pose: Pose of the link in the body.
    """
    visuals = conversion.robot.links[link].visuals
    for number, visual in enumerate(visuals, start=1):
        name = visual.name or (link if len(visuals) == 1 else f"{link}_{number}")
        for geometry, offset in split_capsule(visual.geometry):
            pose = compose(link_pose, visual.origin.pose)
            if offset != ZERO:
                pose = compose(pose, Pose(offset))
            shape = _make_shape(conversion, geometry, name)
            rotation = multiply(pose.rot, Y_ONTO_Z) if shape.kind == "cylinder" else pose.rot
            shape.position = pose.xyz
            shape.rotation = ZERO if rotation == IDENTITY else to_xyz_angles(rotation)
            _colour(shape, visual, conversion.robot.materials)
            segment.holder.shapes.append(shape)


def split_capsule(geometry: Geometry) -> list[tuple[Geometry, Vec]]:
    """Return a capsule as a cylinder and two spheres, as an .mbs has no capsules.

    Returns:
        Each shape, and its position (m) in the frame of the geometry; another geometry as it is.
    """
    if not isinstance(geometry, Capsule):
        return [(geometry, ZERO)]
    half, sphere = geometry.length / 2, Sphere(geometry.radius)
    cylinder = Cylinder(geometry.radius, geometry.length)
    return [(cylinder, ZERO), (sphere, (0.0, 0.0, half)), (sphere, (0.0, 0.0, -half))]


def _make_shape(conversion: Conversion, geometry: Geometry, name: str) -> Shape:
    """Return the .mbs shape of a geometry, other than a capsule, without pose and colour."""
    if isinstance(geometry, Box):
        return Shape("box", name, size=geometry.size)
    if isinstance(geometry, Cylinder):
        return Shape("cylinder", name, radius=geometry.radius, height=geometry.length)
    if isinstance(geometry, Sphere):
        return Shape("sphere", name, radius=geometry.radius)
    assert isinstance(geometry, Mesh)
    stems = conversion.meshes
    if geometry.filename not in stems:
        stems[geometry.filename] = choose_stem(geometry.filename, set(stems.values()))
    url = f"{VRML_FOLDER}/{stems[geometry.filename]}.wrl"
    return Shape("inline", name, scale=geometry.scale, url=url)


def choose_stem(filename: str, stems: set[str]) -> str:
    """Choose the name of the .wrl of a mesh file, without the suffix.

    It is the mesh file's own name, made safe for every file system, and different from those of
    ``stems`` even if letter case is ignored.
    """
    stem = PurePosixPath(filename.replace("\\", "/")).stem
    stem = (re.sub(r"[^A-Za-z0-9_-]", "_", stem) or "mesh")[:MAX_STEM_LENGTH]
    if not is_portable(stem):
        stem = f"{stem}_mesh"
    return free_name(stem, {stem_in_use.lower() for stem_in_use in stems}, str.lower)


def _colour(shape: Shape, visual: Visual, materials: dict[str, Material]) -> None:
    """Give a shape the visual's own colour, else that of the material of its name, else grey."""
    material = visual.material
    if material is not None and material.color is None:
        material = materials.get(material.name)
    if material is None or material.color is None:
        shape.color = GREY
        return
    red, green, blue, alpha = (min(max(part, 0.0), 1.0) for part in material.color)
    shape.color = (round(255 * red), round(255 * green), round(255 * blue))
    shape.transparency = 1.0 - alpha


def _report_left_out(conversion: Conversion) -> None:
    """Name the links whose textures or collision shapes are left out."""
    links, materials = conversion.robot.links.values(), conversion.robot.materials
    textured = []
    for link in links:
        used = [visual.material for visual in link.visuals if visual.material]
        if any(materials.get(material.name, material).texture for material in used):
            textured.append(link.name)
    if textured:
        message = f"textures are left out, as an .mbs shape has a colour only: {some(textured)}"
        conversion.warn("texture", message, link=textured[0])
    collisions = [link.name for link in links if link.collisions]
    if collisions:
        conversion.note("collision", f"collision shapes are left out: {some(collisions)}")
