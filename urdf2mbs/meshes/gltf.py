"""glTF files (.glb, .gltf), checked before trimesh reads them."""

from __future__ import annotations

import json
from pathlib import PureWindowsPath
from urllib.parse import unquote, urlsplit

from urdf2mbs.meshes.model import MOST_PARTS, MOST_TRIANGLES, MeshError, TooLargeError

#: glTF extensions that trimesh does not need in order to give the right triangles.
EXTENSIONS = {"KHR_materials_unlit", "KHR_texture_transform"}


def check(data: bytes, ending: str) -> None:
    """Refuse a file whose points trimesh would read as zeros, or that asks for far too many."""
    if ending == ".glb" and data[:4] != b"glTF":
        raise MeshError("it does not start with 'glTF'")
    document = json.loads(_text(data))
    required = set(document.get("extensionsRequired", ())) - EXTENSIONS
    if required:
        raise MeshError(f"it needs the glTF extension {', '.join(sorted(required))}")
    for buffer in document.get("buffers", []):
        if _is_elsewhere(str(buffer.get("uri", ""))):
            raise MeshError(
                f"its buffer {buffer['uri']!r} is not in the folder of the mesh, nor below it: "
                "such a file is not read"
            )
    accessors = document.get("accessors", [])
    counts = [int(one["count"]) for one in accessors]
    empty = sum(counts[n] for n, one in enumerate(accessors) if "bufferView" not in one)
    named = [
        counts[number]
        for mesh in document.get("meshes", [])
        for shape in mesh.get("primitives", [])
        for number in (*shape.get("attributes", {}).values(), shape.get("indices"))
        if isinstance(number, int) and number < len(counts)
    ]
    if empty > MOST_PARTS or sum(named) > 5 * MOST_TRIANGLES or len(named) > 5 * MOST_PARTS:
        raise TooLargeError("it asks for far more points than a mesh has")


def _is_elsewhere(uri: str) -> bool:
    """Whether a buffer is no file beside the mesh or below it.

    Any file can be read as numbers, and a mesh of somebody else must not ask for those of its user.
    """
    if uri[:5].lower() == "data:":
        return False
    plain = uri
    while plain != unquote(plain):
        plain = unquote(plain)
    path = PureWindowsPath(plain)  # which knows both slashes, and drives
    return bool(path.anchor or ".." in path.parts or urlsplit(plain).scheme)


def _text(data: bytes) -> bytes:
    """The JSON part of a .gltf or .glb."""
    if data[:4] != b"glTF":
        return data
    return data[20 : 20 + int.from_bytes(data[12:16], "little")]
