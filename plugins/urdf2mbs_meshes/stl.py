"""Binary .stl files, read as they lie in memory: the meshes of robots are large ones.

A header of 80 bytes, which says nothing, not even "solid"; the number of triangles; then, for
each, 50 bytes: a normal and three points in single precision, and two bytes without a meaning.
"""

from __future__ import annotations

from urdf2mbs_meshes.model import Mesh, MeshError, add

#: Bytes before the triangles, and of each.
HEAD, EACH = 84, 50


def is_binary(data: bytes) -> bool:
    """Whether it is not a text, which begins with "solid" too."""
    begin = data[:1000]
    return len(data) >= HEAD and not (begin.lstrip()[:5].lower() == b"solid" and b"\0" not in begin)


def read(mesh: Mesh, data: bytes) -> None:
    """Put the triangles into ``mesh``; raises MeshError where some are missing."""
    import numpy as np

    said, there = int.from_bytes(data[80:HEAD], "little"), (len(data) - HEAD) // EACH
    if there < said:
        raise MeshError(f"its header says {said} triangles, and it has {there}")
    if len(data) > HEAD + EACH * said:
        mesh.problems.append(f"its header says {said} triangles: what follows them is left out")
    records = np.dtype([("normal", "<f4", 3), ("points", "<f4", (3, 3)), ("color", "<u2")])
    points = np.frombuffer(data, records, said, HEAD)["points"].reshape(-1, 3)
    add(mesh, np.eye(4), points, np.arange(3 * said))
