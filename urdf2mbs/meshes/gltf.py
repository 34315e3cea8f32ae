"""glTF files (.glb, .gltf): checked before trimesh reads them, or cut down where it cannot."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import PureWindowsPath
from typing import Any
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


def load_plain(load: Callable[[bytes], Any], data: bytes) -> list[Any]:
    """A scene for each primitive of a glTF file, with only its points, its faces and its place.

    A primitive that cannot be read even so is left out.
    """
    document = json.loads(_text(data))
    shapes = [primitive for shape in document["meshes"] for primitive in shape["primitives"]]
    for key in ("materials", "textures", "images", "samplers", "animations", "skins", "cameras"):
        document.pop(key, None)
    for part in (document, *document["nodes"], *document["meshes"], *shapes):
        for key in ("camera", "skin", "material", "targets", "extensions", "extensionsUsed"):
            part.pop(key, None)

    def alone(shape: dict[str, Any]) -> bytes:
        """The file with this primitive only.  trimesh would also read what nothing uses."""
        used = {shape["attributes"]["POSITION"], shape.get("indices")} - {None}
        accessors = [document["accessors"][i] for i in sorted(used)]
        views = {accessor.get("bufferView") for accessor in accessors} - {None}
        out = document | {
            "accessors": _with_copies(document["accessors"], used),
            "bufferViews": _with_copies(document["bufferViews"], views),
            "meshes": [
                mesh | {"primitives": [p for p in mesh["primitives"] if p is shape]}
                for mesh in document["meshes"]
            ],
        }
        return _with_text(data, json.dumps(out).encode())

    for shape in shapes:
        shape["attributes"] = {"POSITION": shape["attributes"].get("POSITION")}
    scenes = []
    for shape in shapes:
        try:
            scenes.append(load(alone(shape)))
        except Exception:
            continue  # the caller tells what is wrong
    if not scenes:
        raise MeshError("no part of it can be read")
    return scenes


def _with_copies(all_: list[Any], used: set[Any]) -> list[Any]:
    """The list with each unused item replaced by a used one: so the numbers stay valid."""
    return [one if i in used else all_[min(used)] for i, one in enumerate(all_)]


def _text(data: bytes) -> bytes:
    """The JSON part of a .gltf or .glb."""
    if data[:4] != b"glTF":
        return data
    return data[20 : 20 + int.from_bytes(data[12:16], "little")]


def _with_text(data: bytes, text: bytes) -> bytes:
    """The file with another JSON part."""
    if data[:4] != b"glTF":
        return text
    rest = data[20 + int.from_bytes(data[12:16], "little") :]
    text += b" " * (-len(text) % 4)
    size = (20 + len(text) + len(rest)).to_bytes(4, "little")
    return data[:8] + size + len(text).to_bytes(4, "little") + data[16:20] + text + rest
