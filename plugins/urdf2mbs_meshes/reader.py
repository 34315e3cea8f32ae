"""Mesh files read into triangles in metres, z up: .stl, .dae, .obj, .ply, .glb and .gltf.

The scene graph of a file is flattened: every part is in the frame of the file, with the transform
of its node applied.  If that transform mirrors, the faces are flipped back.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from urdf2mbs.plugin import ConfigError, counted, files
from urdf2mbs_meshes.model import Mesh, MeshError, Part

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: The endings of the formats that can be read, in small letters.
FORMATS = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf")


def read_mesh(path: Path, *, up_axis: bool = True) -> Mesh:
    """Read a mesh file.

    Args:
        path: The file; the ending of its name is its format.
        up_axis: False ignores the ``<up_axis>`` of COLLADA files.

    Returns:
        The mesh; lengths are in m, as ``<unit>`` (COLLADA) or the format says.

    Raises:
        MeshError: The file holds no usable triangles.
    """
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise MeshError(f"the format '{ending}' is not known; known are {', '.join(FORMATS)}")
    mesh = Mesh(path)
    try:
        data = files.read_bytes(path)
    except OSError as error:
        raise MeshError(error.strerror or str(error)) from None
    mesh.sources[path.name] = data
    _read_parts(mesh, data, ending, up_axis)
    if not any(len(part.triangles) for part in mesh.parts):
        raise MeshError("; ".join(["it holds no triangles", *mesh.problems]))
    parts = [_drop_undrawable(mesh, part) for part in mesh.parts if len(part.triangles)]
    mesh.parts = [part for part in parts if len(part.triangles)]
    if not mesh.parts:
        raise MeshError(mesh.problems[-1])
    mesh.problems = list(dict.fromkeys(mesh.problems))
    return mesh


def _read_parts(mesh: Mesh, data: bytes, ending: str, up_axis: bool) -> None:
    """Read the parts of a file by the reader of its format, whose errors become MeshErrors."""
    try:
        with warnings.catch_warnings():  # numpy warns of numbers that are not finite
            warnings.simplefilter("ignore")
            if ending == ".dae":
                from urdf2mbs_meshes.collada import read_collada

                read_collada(mesh, data, up_axis)
            else:
                from urdf2mbs_meshes.by_trimesh import read_by_trimesh

                read_by_trimesh(mesh, data, ending)
    except MemoryError:
        raise MeshError("it takes more memory than there is") from None
    except (MeshError, ConfigError):
        raise
    except Exception as error:  # a broken file can make the readers raise anything
        raise MeshError(f"{type(error).__name__}: {error}".rstrip(": ")) from error


def _drop_undrawable(mesh: Mesh, part: Part) -> Part:
    """Drop the triangles of a part that cannot be drawn: with one, no viewer opens the file."""
    import numpy as np

    is_drawable = _find_drawable(mesh, part)
    uv = part.uv
    if uv is not None and not np.isfinite(uv[is_drawable]).all():
        mesh.problems.append("its texture coordinates are not finite numbers")
        uv = None
    if uv is part.uv and is_drawable.all():
        return part
    material = part.material
    if uv is None and part.uv is not None:
        material = msgspec.structs.replace(material, texture=None)
    return msgspec.structs.replace(
        part,
        triangles=part.triangles[is_drawable],
        colors=None if part.colors is None else part.colors[is_drawable],
        uv=None if uv is None else uv[is_drawable],
        material=material,
    )


def _find_drawable(mesh: Mesh, part: Part) -> NDArray[np.bool_]:
    """Return (m,) True for each triangle whose corners exist and fit into single precision."""
    import numpy as np

    has_corners = ((part.triangles >= 0) & (part.triangles < len(part.points))).all(axis=1)
    if not has_corners.all():
        count = counted(int((~has_corners).sum()), "triangle")
        mesh.problems.append(f"a point of {count} is not there")
    point_is_finite = np.all(np.abs(part.points) <= np.finfo(np.float32).max, axis=1)
    is_drawable = np.zeros_like(has_corners)
    is_drawable[has_corners] = np.all(point_is_finite[part.triangles[has_corners]], axis=1)
    if not is_drawable[has_corners].all():
        count = counted(int((~is_drawable[has_corners]).sum()), "triangle")
        mesh.problems.append(f"a coordinate of {count} is not a finite single-precision number")
    return is_drawable
