"""The spots of a robot's shapes: the parts that may touch a plane.

A rigid body touches a plane by the corners of its convex hull, by its spheres, and by the rims of
its cylinders.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import ZERO, Conversion, Vec, urdf
from urdf2mbs_meshes.files import get_mesh_files
from urdf2mbs_project.simulation import Spot

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: The corners that are left out stick out of the hull of the others by no more than this (m).
HULL_TOLERANCE = 0.003
#: ... and by no more than this, relative to the size of the body.
RELATIVE_HULL_TOLERANCE = 0.05
#: Number of spots of a rim.
RIM_SPOTS = 8
#: Number of digits to which coordinates of spots are rounded (nm).
SPOT_DIGITS = 9


def list_contact_spots(
    conversion: Conversion, link: str, unreadable: dict[str, str] | None = None
) -> list[Spot]:
    """List the spots of a link's shapes: those that collide, or else those that are seen.

    Args:
        conversion: The robot, and the files of its meshes.
        link: The name of the link.
        unreadable: Gets the reason, by the name of the link, if a mesh cannot be read.

    Returns:
        The spots in the link's frame.
    """
    from urdf2mbs_meshes.model import MeshError

    element = conversion.robot.links[link]
    spots: list[Spot] = []
    for shape in element.collisions or element.visuals:
        try:
            shape_spots = _list_shape_spots(conversion, shape.geometry)
        except MeshError as error:
            if unreadable is not None:
                unreadable[link] = str(error)
        else:
            spots += [spot.transform(shape.origin.pose) for spot in shape_spots]
    return spots


def thin_spots(spots: list[Spot]) -> list[Spot]:
    """Return the spheres, the rims, and those points that the hull needs, each once.

    Coordinates are rounded: two spots at the same position would make the ground twice as stiff.
    """
    corners = find_hull_corners([spot.centre for spot in spots if not spot.radius])
    rounded = []
    for spot in (*(spot for spot in spots if spot.radius), *map(Spot, corners)):
        x, y, z = (round(coordinate, SPOT_DIGITS) for coordinate in spot.centre)
        rounded.append(spot._replace(centre=(x, y, z)))
    return list(dict.fromkeys(rounded))


def _list_shape_spots(conversion: Conversion, shape: urdf.Geometry) -> list[Spot]:
    """List the spots of a shape, in its frame."""
    if isinstance(shape, urdf.Sphere):
        return [Spot(ZERO, shape.radius)]
    if isinstance(shape, urdf.Box):
        x, y, z = (size / 2 for size in shape.size)
        return [Spot(corner) for corner in product((-x, x), (-y, y), (-z, z))]
    if isinstance(shape, urdf.Capsule):
        half = shape.length / 2
        return [Spot((0.0, 0.0, z), shape.radius) for z in (-half, half)]
    if isinstance(shape, urdf.Cylinder):
        centres = [(0.0, 0.0, sign * shape.length / 2) for sign in (-1, 1)]
        angles = [2 * pi * k / RIM_SPOTS for k in range(RIM_SPOTS)]
        return [
            Spot(centre, shape.radius, (0.0, 0.0, 1.0), angle)
            for centre in centres
            for angle in angles
        ]
    return [Spot(corner) for corner in _read_mesh_corners(conversion, shape)]


# --- the convex hull ---


def find_hull_corners(points: Any) -> list[Vec]:
    """Find the corners of a convex hull, without those that hardly stick out of the others.

    Args:
        points: (n, 3), in m.

    Returns:
        The points themselves if they are eight or fewer; the corners of the box around them if
        they are flat.
    """
    import numpy as np

    corners = np.asarray(points, float)
    if len(points) > 8:
        corners = np.round(corners, SPOT_DIGITS)
        # Sorting by hand, since np.unique takes twice as long.
        corners = corners[np.lexsort(corners.T[::-1])]
        corners = corners[np.append(True, np.diff(corners, axis=0).any(axis=1))]
        corners = _choose_hull_corners(corners)
    return [tuple(map(float, corner)) for corner in corners]  # type: ignore[misc]


def _choose_hull_corners(points: Array) -> Array:
    r"""Choose the corners (k, 3) of the hull of points (n, 3) that stick out of the others.

    Each corner has a normal, the mean of those of its faces.  One at a time, the corner is taken
    that is furthest, along its normal, beyond all that are taken already::

                 ^ normal
                 |
                 o  corner      ) its distance beyond them
          o------|------o       )
         / taken corners  \
    """
    import numpy as np
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except QhullError:  # flat
        low, high = points.min(axis=0), points.max(axis=0)
        return np.unique(np.array([*product(*zip(low, high, strict=True))]), axis=0)
    size = float(np.ptp(points, axis=0).max())
    tolerance = min(HULL_TOLERANCE, RELATIVE_HULL_TOLERANCE * size)
    normals = np.zeros_like(points)
    for corner in hull.simplices.T:
        np.add.at(normals, corner, hull.equations[:, :3])
    corners, normals = points[hull.vertices], normals[hull.vertices]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    chosen: list[int] = []
    extent, covered = (corners * normals).sum(axis=1), -np.inf
    while not chosen or (extent - covered).max() > tolerance:
        # Rounded, so that of equal corners the first is taken on each machine.
        chosen.append(int(np.argmax(np.round(extent - covered, SPOT_DIGITS))))
        covered = np.maximum(covered, normals @ corners[chosen[-1]])
    taken: Array = corners[sorted(chosen)]
    return taken


def _read_mesh_corners(conversion: Conversion, mesh: urdf.Mesh) -> tuple[Vec, ...]:
    """Read the corners of a mesh file, scaled (m).

    Raises:
        MeshError: The file was not found, or cannot be read.
    """
    from urdf2mbs_meshes.model import MeshError

    path = get_mesh_files(conversion).find(mesh.filename)
    if path is None:
        raise MeshError("it was not found")
    return _read_file_corners(path, path.stat().st_mtime_ns, mesh.scale)


@lru_cache(maxsize=256)
def _read_file_corners(path: Path, modified: int, scale: Vec) -> tuple[Vec, ...]:
    """Read the corners of a mesh file; cached, as init and several passes ask for each mesh.

    Args:
        path: The file.
        modified: When it was modified (ns), so that a changed file is read again.
        scale: The scale along each axis.
    """
    import numpy as np

    from urdf2mbs_meshes.reader import read_mesh

    points = [part.points for part in read_mesh(path).parts]
    return tuple(find_hull_corners(np.concatenate(points).astype(float) * np.array(scale)))
