"""glTF files (.glb, .gltf), checked before trimesh reads them."""

from __future__ import annotations

import json
from pathlib import PureWindowsPath
from urllib.parse import unquote, urlsplit

from urdf2mbs_meshes.model import MOST_PARTS, MOST_TRIANGLES, MeshError, TooLargeError

#: glTF extensions that trimesh does not need in order to give the right triangles.
EXTENSIONS = {"KHR_materials_unlit", "KHR_texture_transform"}


def check(data: bytes, ending: str) -> None:
    """Refuse a file whose points trimesh would read as zeros, or that asks for far too many."""
    binary = data[:4] == b"glTF"
    if ending == ".glb" and not binary:
        raise MeshError("it does not start with 'glTF'")
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")] if binary else data)
    required = set(document.get("extensionsRequired", ())) - EXTENSIONS
    if required:
        raise MeshError(f"it needs the glTF extension {', '.join(sorted(required))}")
    for buffer in document.get("buffers", []):
        _check_buffer(str(buffer.get("uri", "")))
    accessors = document.get("accessors", [])
    counts = [int(one["count"]) for one in accessors]
    empty = sum(int(one["count"]) for one in accessors if "bufferView" not in one)
    shapes = [one for mesh in document.get("meshes", []) for one in mesh.get("primitives", [])]
    named = [n for one in shapes for n in (*one.get("attributes", {}).values(), one.get("indices"))]
    points = sum(counts[n] for n in named if isinstance(n, int) and n < len(counts))
    if empty > MOST_PARTS or points > 5 * MOST_TRIANGLES or len(named) > 5 * MOST_PARTS:
        raise TooLargeError("it asks for far more points than a mesh has")


def _check_buffer(uri: str) -> None:
    """Refuse a buffer that is no file beside the mesh or below it.

    Any file can be read as numbers, and a mesh of somebody else must not ask for those of its user.
    """
    plain = uri
    while plain != unquote(plain):
        plain = unquote(plain)
    path = PureWindowsPath(plain)  # which knows both slashes, and drives
    is_outside = path.anchor or ".." in path.parts or urlsplit(plain).scheme
    if is_outside and uri[:5].lower() != "data:":
        raise MeshError(
            f"its buffer {uri!r} is not in the folder of the mesh, nor below it: such a file is "
            "not read"
        )
