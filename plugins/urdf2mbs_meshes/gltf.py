"""Checks of glTF files (.glb, .gltf) that are made before trimesh reads them."""

from __future__ import annotations

import json
from pathlib import PureWindowsPath
from typing import Any
from urllib.parse import unquote, urlsplit

from urdf2mbs_meshes.model import MAX_TRIANGLES, MeshError, TooLargeError

#: glTF extensions that trimesh does not need in order to read the right triangles.
HARMLESS_EXTENSIONS = {"KHR_materials_unlit", "KHR_texture_transform"}
#: Largest number of points, indices and other elements of all shapes, each use counted.
MAX_ELEMENTS = 5 * MAX_TRIANGLES


def check_gltf(data: bytes, ending: str) -> None:
    """Check that trimesh can read a file safely.

    Raises:
        MeshError: trimesh would read its points as zeros, or from outside of its folder.
        TooLargeError: It asks for more memory than any mesh needs.
    """
    is_binary = data[:4] == b"glTF"
    if ending == ".glb" and not is_binary:
        raise MeshError("it does not start with 'glTF'")
    if is_binary:  # a header of 12 bytes, then the length, type and text of the JSON chunk
        data = data[20 : 20 + int.from_bytes(data[12:16], "little")]
    document = json.loads(data)
    extensions = set(document.get("extensionsRequired", ())) - HARMLESS_EXTENSIONS
    if extensions:
        raise MeshError(f"it requires the glTF extension {', '.join(sorted(extensions))}")
    for buffer in document.get("buffers", []):
        _check_buffer(str(buffer.get("uri", "")))
    if _count_elements(document) > MAX_ELEMENTS:
        raise TooLargeError("it asks for far more points than a mesh has")


def _count_elements(document: dict[str, Any]) -> int:
    """Count the elements of all arrays (accessors), and those of each use of one by a shape.

    An array may have no bytes in the file, and many shapes may use the same array.
    """
    counts = [int(accessor["count"]) for accessor in document.get("accessors", [])]
    total = sum(counts)
    for mesh in document.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            used = [*primitive.get("attributes", {}).values(), primitive.get("indices")]
            total += sum(counts[index] for index in used if index is not None)
    return total


def _check_buffer(uri: str) -> None:
    """Refuse a buffer that is not a file beside the mesh or below it.

    Any file can be read as numbers, and the mesh of a stranger must not ask for those of its user.
    """
    decoded = uri
    while decoded != unquote(decoded):
        decoded = unquote(decoded)
    path = PureWindowsPath(decoded)  # understands both slashes, and drives
    is_outside = path.anchor or ".." in path.parts or urlsplit(decoded).scheme
    if is_outside and uri[:5].lower() != "data:":
        raise MeshError(
            f"its buffer {uri!r} is not in the folder of the mesh, nor below it: such a file is "
            "not read"
        )
