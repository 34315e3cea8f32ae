"""Volume, centre and inertia of the shapes of links, as solids of density 1 kg/m^3."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any, NamedTuple

from urdf2mbs.plugin import (
    ZERO,
    Box,
    Capsule,
    Cylinder,
    Geometry,
    Pose,
    Sphere,
    Sym,
    Vec,
    compose,
    rotate_inertia,
)
from urdf2mbs_meshes.files import MeshFiles


class Solid(NamedTuple):
    """A solid of density 1 kg/m^3."""

    volume: float
    """m^3."""
    centre: Vec
    """m."""
    inertia: Sym
    """About the centre (m^5)."""


class ShapeSolid(NamedTuple):
    """The solid of a shape, or of the convex hull of a mesh that is not closed."""

    solid: Solid
    hull_of: str = ""
    """Name of the file of the mesh; empty if it is not a hull."""


def compute_solid(geometry: Geometry, mesh_files: MeshFiles) -> ShapeSolid | None:
    """Compute the solid of a shape, in its own frame.

    Args:
        geometry: The shape.
        mesh_files: Finds the files of meshes.

    Returns:
        The solid; None for a mesh that is missing, unreadable or flat.
    """
    if isinstance(geometry, Box):
        return ShapeSolid(compute_box(geometry.size))
    if isinstance(geometry, Cylinder):
        return ShapeSolid(compute_cylinder(geometry.radius, geometry.length))
    if isinstance(geometry, Capsule):
        return ShapeSolid(compute_capsule(geometry.radius, geometry.length))
    if isinstance(geometry, Sphere):
        return ShapeSolid(compute_sphere(geometry.radius))
    mesh_file = mesh_files.find(geometry.filename)
    return None if mesh_file is None else compute_mesh(mesh_file, geometry.scale)


def move_solid(solid: Solid, pose: Pose) -> Solid:
    """Return a solid in another frame, from the pose of its frame there."""
    centre = compose(pose, Pose(solid.centre)).xyz
    return Solid(solid.volume, centre, rotate_inertia(pose.rot, solid.inertia))


# --- primitives, all centred in their frame ---


def compute_box(size: Vec) -> Solid:
    """Compute the solid of a box with the edges x, y and z (m): ``I_x = V (y^2 + z^2) / 12``."""
    x, y, z = size
    volume = x * y * z
    about_x = volume * (y * y + z * z) / 12
    about_y = volume * (x * x + z * z) / 12
    about_z = volume * (x * x + y * y) / 12
    return Solid(volume, ZERO, (about_x, 0.0, 0.0, about_y, 0.0, about_z))


def compute_cylinder(radius: float, length: float) -> Solid:
    """Compute the solid of a cylinder about z, of a radius and a length (m)."""
    volume = pi * radius * radius * length
    inertia_across = volume * (3 * radius * radius + length * length) / 12
    inertia_along = volume * radius * radius / 2
    return Solid(volume, ZERO, (inertia_across, 0.0, 0.0, inertia_across, 0.0, inertia_along))


def compute_capsule(radius: float, length: float) -> Solid:
    """Compute the solid of a cylinder about z, of a radius and a length (m), with two hemispheres.

    The centre of a hemisphere is 3/8 r from its plane.  Its inertia across the axis, about the
    centre of the plane, is ``2/5 m r^2``: half of that of the ball.
    """
    cylinder, ball = compute_cylinder(radius, length), compute_sphere(radius)
    hemisphere_shift = ball.volume * (length * length / 4 + 3 / 8 * radius * length)
    inertia_across = cylinder.inertia[0] + ball.inertia[0] + hemisphere_shift
    inertia_along = cylinder.inertia[5] + ball.inertia[5]
    volume = cylinder.volume + ball.volume
    return Solid(volume, ZERO, (inertia_across, 0.0, 0.0, inertia_across, 0.0, inertia_along))


def compute_sphere(radius: float) -> Solid:
    """Compute the solid of a ball of a radius (m)."""
    volume = 4 / 3 * pi * radius**3
    moment = 0.4 * volume * radius * radius
    return Solid(volume, ZERO, (moment, 0.0, 0.0, moment, 0.0, moment))


# --- meshes ---


def compute_mesh(mesh_file: Path, scale: Vec) -> ShapeSolid | None:
    """Compute the solid of a mesh by the divergence theorem (trimesh's ``mass_properties``).

    Args:
        mesh_file: The file.
        scale: Factors of x, y and z; negative ones mirror.

    Returns:
        The solid that the surface encloses, or that of its convex hull if the surface is not
        closed; None if the file cannot be read, or has no volume.
    """
    from urdf2mbs_meshes.model import MeshError
    from urdf2mbs_meshes.reader import read_mesh

    try:
        mesh = read_mesh(mesh_file)
    except MeshError:
        return None
    import numpy as np
    import trimesh

    corners = np.concatenate([part.points[part.triangles] for part in mesh.parts])
    surface = trimesh.Trimesh(**trimesh.triangles.to_kwargs(corners * np.asarray(scale)))  # type: ignore[no-untyped-call]
    surface.merge_vertices()
    surface.update_faces(surface.nondegenerate_faces())
    is_closed = surface.is_watertight and surface.is_winding_consistent
    triangles = surface.triangles if is_closed else compute_convex_hull(surface.vertices)
    if triangles is None:
        return None
    with np.errstate(all="ignore"):  # a flat surface has no centre
        mass_properties: Any = trimesh.triangles.mass_properties(triangles)
        if mass_properties.volume < 0.0:  # inside out, or mirrored by its scale
            mass_properties = trimesh.triangles.mass_properties(triangles[:, ::-1])
    if not mass_properties.volume > 0.0:
        return None
    x, y, z = mass_properties.center_mass.tolist()
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = mass_properties.inertia.tolist()
    solid = Solid(float(mass_properties.volume), (x, y, z), (xx, xy, xz, yy, yz, zz))
    return ShapeSolid(solid, "" if is_closed else mesh_file.name)


def compute_convex_hull(points: Any) -> Any:
    """Compute the convex hull of points (n, 3).

    Returns:
        Its triangles (n, 3, 3), whose normals point outward; None if all points are in a plane.
    """
    import numpy as np
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    triangles = points[hull.simplices]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    points_inward = (normals * hull.equations[:, :3]).sum(axis=1) < 0.0
    triangles[points_inward] = triangles[points_inward][:, ::-1]
    return triangles
