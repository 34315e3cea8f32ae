"""VRML97 (ISO/IEC 14772-1) read into triangles, as far as it draws them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from urdf2mbs.meshes.model import Material, MeshError, Part

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_TOKEN = re.compile(rb'[\s,]*(?:#[^\n]*[\s,]*)*("(?:[^"\\]|\\.)*"|[{}\[\]]|[^\s,{}\[\]"#]+)')
_NUMBER = re.compile(rb"[+-]?(\d|\.\d)")
_BOOLEANS = {b"TRUE": True, b"FALSE": False}

Node = dict[str, Any]


def read(data: bytes) -> list[Part]:
    """The triangles of a .wrl: Shapes with an IndexedFaceSet, in Groups and Transforms.

    Raises MeshError for a file that is no VRML97 or holds nothing of the kind.
    """
    if not data.startswith(b"#VRML V2.0"):
        raise MeshError("it is not VRML97")
    try:
        parts = list(_parts(_Vrml(data).scene()))
    except (ValueError, KeyError, IndexError, TypeError, RecursionError) as error:
        raise MeshError(f"it is not VRML97 as far as we can read it ({error})") from None
    if not parts:
        raise MeshError("it holds no triangles")
    return parts


class _Vrml:
    """Nodes as dicts: their type under ``""``, and their fields."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.at = 0
        self.named: dict[bytes, Node] = {}

    def _next(self, *, keep: bool = False) -> bytes | None:
        match = _TOKEN.match(self.data, self.at)
        if match is None:
            return None
        if not keep:
            self.at = match.end()
        return match[1]

    def scene(self) -> list[Node]:
        nodes = []
        while (word := self._next()) is not None:
            nodes.append(self._node(word))
        return nodes

    def _node(self, word: bytes | None) -> Node:
        if word == b"USE":
            return self.named[self._next() or b""]
        name = None
        if word == b"DEF":
            name, word = self._next(), self._next()
        if word is None or self._next() != b"{":
            raise ValueError(f"no node at byte {self.at}")
        node: Node = {"": word.decode("ascii", "replace")}
        if name is not None:
            self.named[name] = node
        while (field := self._next()) != b"}":
            if field is None:
                raise ValueError("it is cut off")
            node[field.decode("ascii", "replace")] = self._value()
        return node

    def _value(self) -> Any:
        word = self._next()
        if word is None:
            raise ValueError("it is cut off")
        if word == b"[":
            return self._list()
        if word.startswith(b'"'):
            return _string(word)
        if word in _BOOLEANS:
            return _BOOLEANS[word]
        if not _NUMBER.match(word):
            return self._node(word) if word != b"NULL" else None
        numbers = [float(word)]
        while (word := self._next(keep=True)) is not None and _NUMBER.match(word):
            numbers.append(float(word))
            self._next()
        return numbers

    def _list(self) -> Any:
        import numpy as np

        first = self._next(keep=True)
        if first is not None and _NUMBER.match(first):
            end = self.data.index(b"]", self.at)
            text = self.data[self.at : end].replace(b",", b" ")
            self.at = end + 1
            if b"#" in text:
                text = re.sub(rb"#[^\n]*", b"", text)
            return np.array(text.split(), dtype=np.float64)
        out: list[Any] = []
        while (word := self._next()) != b"]":
            if word is None:
                raise ValueError("it is cut off")
            out.append(_string(word) if word.startswith(b'"') else self._node(word))
        return out


def _string(word: bytes) -> str:
    return re.sub(r"\\(.)", r"\1", word[1:-1].decode("utf-8", "replace"))


def _parts(nodes: list[Node]) -> Iterator[Part]:
    import numpy as np

    stack = [(node, np.eye(4)) for node in reversed(nodes)]
    while stack:
        node, pose = stack.pop()
        if node[""] == "Shape":
            part = _shape(node, pose)
            if part is not None:
                yield part
        elif node[""] == "Transform":
            if any(key in node for key in ("center", "scaleOrientation")):
                raise ValueError("a Transform with a centre")
            pose = pose @ _transform(node)
        children = node.get("children") or []
        children = [children] if isinstance(children, dict) else children
        stack.extend((child, pose) for child in reversed(children) if isinstance(child, dict))


def _transform(node: Node) -> NDArray[np.float64]:
    import numpy as np

    pose = np.eye(4)
    x, y, z, angle = node.get("rotation", (0.0, 0.0, 1.0, 0.0))
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / (float(np.hypot(np.hypot(x, y), z)) or 1)
    turn = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
    pose[:3, :3] = turn @ np.diag(node.get("scale", (1.0, 1.0, 1.0)))
    pose[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return pose


def _shape(node: Node, pose: NDArray[np.float64]) -> Part | None:
    import numpy as np

    faces = node.get("geometry") or {"": ""}
    if faces[""] != "IndexedFaceSet" or not faces.get("coord"):
        return None
    appearance = node.get("appearance") or {}
    look = appearance.get("material") or {}
    texture = (appearance.get("texture") or {}).get("url")
    if isinstance(texture, list):
        texture = texture[0] if texture else None
    points = np.asarray(faces["coord"]["point"], float).reshape(-1, 3)
    points = points @ pose[:3, :3].T + pose[:3, 3]
    index = np.asarray(faces["coordIndex"]).astype(np.int64)
    corners, face = _triangulate(index)
    named = index[corners]
    if named.size and not 0 <= named.min() <= named.max() < len(points):
        raise ValueError("a face names a point that is not there")
    colors = uv = None
    if faces.get("color"):
        palette = np.round(255 * np.asarray(faces["color"]["color"], float).reshape(-1, 3))
        if faces.get("colorPerVertex", True):
            chosen = np.asarray(faces.get("colorIndex", index)).astype(np.int64)[corners]
        else:
            order = faces.get("colorIndex")
            chosen = face if order is None else np.asarray(order).astype(np.int64)[face]
        colors = palette[chosen].astype(np.int64)
    if texture and faces.get("texCoord"):
        at = np.asarray(faces.get("texCoordIndex", index)).astype(np.int64)[corners]
        uv = np.asarray(faces["texCoord"]["point"], float).reshape(-1, 2)[at]
    diffuse = [float(c) for c in look.get("diffuseColor", (0.8, 0.8, 0.8))]
    material = Material(
        diffuse=(diffuse[0], diffuse[1], diffuse[2]),
        transparency=float(look.get("transparency", [0.0])[0]),
        texture=texture,
    )
    smooth = float(faces.get("creaseAngle", [0.0])[0]) > 0.0
    return Part(points, named, material, smooth, colors, uv)


def _triangulate(index: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces ended by -1 as fans: (m, 3) places in ``index``, and (m,) the face of each."""
    import numpy as np

    if len(index) and index[-1] != -1:
        index = np.append(index, -1)
    ends = np.flatnonzero(index == -1)
    starts = np.concatenate([[0], ends[:-1] + 1]) if len(ends) else ends
    counts = np.maximum(ends - starts - 2, 0)
    face = np.repeat(np.arange(len(ends)), counts)
    nth = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    first = starts[face]
    return np.stack([first, first + nth + 1, first + nth + 2], axis=1).astype(np.int64), face
