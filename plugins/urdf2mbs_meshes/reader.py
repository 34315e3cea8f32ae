"""Mesh files read into triangles in metres, z up: .stl, .dae, .obj, .ply, .glb and .gltf.

The scene graph of a file is flattened: every part stands in the file's own frame, its node's
transform applied; where that transform mirrors, the faces are turned back.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import msgspec

from urdf2mbs.plugin import ConfigError, counted, files
from urdf2mbs_meshes import stl
from urdf2mbs_meshes.model import Mesh, MeshError, Part

#: What can be read, by the end of the file's name in small letters.
FORMATS = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf")


def read_mesh(path: Path, *, up_axis: bool = True) -> Mesh:
    """Read a mesh file; the lengths are m, as ``<unit>`` (COLLADA) or the format says.

    ``up_axis`` False leaves COLLADA files as they lie, whatever their ``<up_axis>``.
    Raises MeshError for a file that holds no usable triangles.
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
    try:
        with warnings.catch_warnings():  # numpy's, of numbers that are not finite
            warnings.simplefilter("ignore")
            if ending == ".dae":
                from urdf2mbs_meshes import collada

                collada.read(mesh, data, up_axis)
            elif ending == ".stl" and stl.is_binary(data):
                stl.read(mesh, data)
            else:
                from urdf2mbs_meshes import by_trimesh

                by_trimesh.read(mesh, data, ending)
    except MemoryError:
        raise MeshError("it takes more memory than there is") from None
    except (MeshError, ConfigError):
        raise
    except Exception as error:  # a broken file can make the readers raise anything
        raise MeshError(f"{type(error).__name__}: {error}".rstrip(": ")) from error
    if not any(len(part.triangles) for part in mesh.parts):
        raise MeshError("; ".join(["it holds no triangles", *mesh.problems]))
    mesh.parts = [_usable(mesh, part) for part in mesh.parts if len(part.triangles)]
    mesh.parts = [part for part in mesh.parts if len(part.triangles)]
    if not mesh.parts:
        raise MeshError(mesh.problems[-1])
    mesh.problems = list(dict.fromkeys(mesh.problems))
    return mesh


def _usable(mesh: Mesh, part: Part) -> Part:
    """The part without triangles that cannot be drawn: with one, no viewer opens the file."""
    import numpy as np

    there = ((part.triangles >= 0) & (part.triangles < len(part.points))).all(axis=1)
    if not there.all():
        bad = counted(int((~there).sum()), "triangle")
        mesh.problems.append(f"a point of {bad} is not there")
    good = np.all(np.abs(part.points) <= np.finfo(np.float32).max, axis=1)
    finite = np.zeros_like(there)
    finite[there] = np.all(good[part.triangles[there]], axis=1)
    if not finite[there].all():
        bad = counted(int((~finite[there]).sum()), "triangle")
        mesh.problems.append(f"a coordinate of {bad} is no finite single-precision number")
    uv = part.uv
    if uv is not None and not np.isfinite(uv[finite]).all():
        mesh.problems.append("its texture coordinates are no finite numbers")
        uv = None
    if uv is part.uv and finite.all():
        return part
    return msgspec.structs.replace(
        part,
        triangles=part.triangles[finite],
        colors=None if part.colors is None else part.colors[finite],
        uv=None if uv is None else uv[finite],
        material=part.material
        if uv is part.uv
        else msgspec.structs.replace(part.material, texture=None),
    )
