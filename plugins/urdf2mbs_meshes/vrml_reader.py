"""VRML97 (ISO/IEC 14772-1) read into triangles.

Faces are read, in groups and transforms, with their colours and textures.  Lines and lights draw
nothing.  A file with prototypes, routes or scripts is an error.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from urdf2mbs_meshes.model import MOST_PARTS, Material, Mesh, MeshError, TooLargeError, add

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_TOKEN = re.compile(
    rb'[\s,]*(?:#[^\n]*(?:\n|\Z)[\s,]*)*("(?:[^"\\]|\\.)*"|[{}\[\]]|[^\s,{}\[\]"#]+)'
)
_NUMBER = re.compile(rb"[+-]?(\d|\.\d)")
_NUMBERS = re.compile(rb"(?:[^\]#]|#[^\n]*)*")

#: What is not drawn, and says so.
_NOT_DRAWN = {
    "Box", "Cone", "Cylinder", "ElevationGrid", "Extrusion", "Inline", "LOD", "Sphere", "Switch",
    "Text",
}  # fmt: skip

Node = dict[str, Any]
"""The node's fields; its type stands under ``""``."""


def read(data: bytes) -> Mesh:
    """The triangles of a .wrl; ``problems`` names what is not drawn.

    Raises MeshError for a file that is no VRML or holds no triangles.
    """
    data = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    if not data.startswith(b"#VRML V2.0"):
        raise MeshError("it is not VRML97")
    try:
        scene = _Scene()
        text = _Text(data)
        while text.peek() is not None:
            scene.draw(text.node(text.next()))
    except (ValueError, KeyError, IndexError, TypeError, RecursionError) as error:
        raise MeshError(f"it is not VRML as far as we can read it ({error})") from None
    if not scene.mesh.parts:
        raise MeshError("; ".join(["it holds no triangles", *scene.mesh.problems]))
    return scene.mesh


class _Text:
    """The text of a file, read from its start to its end."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.at = 0
        self.named: dict[bytes, Node] = {}

    def peek(self) -> bytes | None:
        match = _TOKEN.match(self.data, self.at)
        return match and match[1]

    def next(self) -> bytes:
        match = _TOKEN.match(self.data, self.at)
        if match is None:
            raise ValueError("it is cut off")
        self.at = match.end()
        return match[1]

    def node(self, word: bytes) -> Node:
        """The node that begins with ``word``."""
        if word == b"USE":
            return self.named[self.next()]
        node: Node = {}
        if word == b"DEF":
            self.named[self.next()] = node
            word = self.next()
        node[""] = word.decode("ascii", "replace")
        if self.next() != b"{":
            raise ValueError(f"'{node['']}' at byte {self.at} is not read")
        while (word := self.next()) != b"}":
            node[word.decode("ascii", "replace")] = self.value()
        return node

    def value(self) -> Any:
        """A list, numbers, or a single value."""
        word = self.next()
        if word == b"[":
            return self.list()
        if not _NUMBER.match(word):
            return self.single(word)
        numbers = [float(word)]
        while _NUMBER.match(self.peek() or b""):
            numbers.append(float(self.next()))
        return numbers

    def single(self, word: bytes) -> Any:
        """A text, a node, TRUE, FALSE, NULL or another word."""
        if word.startswith(b'"'):
            return re.sub(r"\\(.)", r"\1", word[1:-1].decode("utf-8", "replace"))
        if word in (b"{", b"}", b"]"):
            raise ValueError(f"no value at byte {self.at}")
        if word in (b"DEF", b"USE") or self.peek() == b"{":
            return self.node(word)
        known = {b"TRUE": True, b"FALSE": False, b"NULL": None}
        return known[word] if word in known else word.decode("ascii", "replace")

    def list(self) -> Any:
        """The values up to ``]``; numbers as an array."""
        import numpy as np

        if _NUMBER.match(self.peek() or b""):
            text = _NUMBERS.match(self.data, self.at)
            assert text is not None
            if text.end() == len(self.data):
                raise ValueError("it is cut off")
            self.at = text.end() + 1
            words = re.sub(rb"#[^\n]*", b"", text[0]).replace(b",", b" ").split()
            return np.array(words, dtype=np.float64)
        values: list[Any] = []
        while (word := self.next()) != b"]":
            values.append(self.single(word))
        return values


class _Scene:
    """What the nodes draw."""

    def __init__(self) -> None:
        self.mesh = Mesh(Path("mesh.wrl"))
        self.visits = 0

    def draw(self, node: Node, pose: NDArray[np.float64] | None = None) -> None:
        """Add what a node draws at a pose (4 x 4)."""
        import numpy as np

        self.visits += 1
        if self.visits > MOST_PARTS:
            raise TooLargeError(f"it has more than {MOST_PARTS:,} nodes, each copy counted")
        pose = np.eye(4) if pose is None else pose
        kind = node[""]
        if kind == "Transform":
            pose = pose @ _transform(node)
        elif kind == "Shape" and isinstance(node.get("geometry"), dict):
            geometry = node["geometry"]
            kind = geometry[""]
            if kind == "IndexedFaceSet":
                self._add_faces(geometry, node.get("appearance") or {}, pose)
        if kind in _NOT_DRAWN:
            self.mesh.problems.append(f"its {kind} is not drawn")
        children = node.get("children", [])
        for child in children if isinstance(children, list) else [children]:
            if isinstance(child, dict):
                self.draw(child, pose)

    def _add_faces(self, node: Node, appearance: Node, pose: NDArray[np.float64]) -> None:
        import numpy as np

        coordinates, texture = node.get("coord"), node.get("texCoord")
        if not coordinates or not len(node.get("coordIndex", ())):
            return
        points = np.asarray(coordinates.get("point", ()), float).reshape(-1, 3)
        index = np.asarray(node["coordIndex"]).astype(np.int64)
        corners, face = _triangulate(index)
        triangles = index[corners]
        if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(points):
            raise ValueError("a face names a point that is not there")
        if not np.isfinite(points[triangles]).all():
            raise ValueError("a point is not finite")

        def by_corner(name: str) -> NDArray[np.int64]:
            given = node.get(name)
            usable = given is not None and len(given) > int(corners.max(initial=0))
            return np.asarray(given if usable else index).astype(np.int64)[corners]

        material, uv = _material(appearance), None
        if material.texture and texture:
            uv = np.asarray(texture["point"], float).reshape(-1, 2)[by_corner("texCoordIndex")]
        colors = None
        if node.get("color"):
            palette = np.asarray(node["color"]["color"], float).reshape(-1, 3)
            order = node.get("colorIndex")
            if len(palette) == 1:
                chosen = np.zeros(len(face), np.int64)
            elif node.get("colorPerVertex", True):
                chosen = by_corner("colorIndex")
            else:
                chosen = face if order is None else np.asarray(order).astype(np.int64)[face]
            if 0 <= chosen.min(initial=0) <= chosen.max(initial=0) < len(palette):
                colors = np.round(255 * palette[chosen]).astype(np.int64)
            else:
                self.mesh.problems.append("its faces name colours that are not there")
        crease = float(node.get("creaseAngle", [0.0])[0])
        add(
            self.mesh, pose, points, triangles,
            material=material, smooth=crease > 0.0, colors=colors, uv=uv,
        )  # fmt: skip


def _material(appearance: Node) -> Material:
    look, texture = appearance.get("material") or {}, appearance.get("texture") or {}
    url = texture.get("url")
    if isinstance(url, list):
        url = url[0] if url else None
    red, green, blue = (float(c) for c in look.get("diffuseColor", (0.8, 0.8, 0.8))[:3])
    clear = look.get("transparency", ())
    return Material(
        diffuse=(red, green, blue), transparency=float(clear[0]) if len(clear) else 0.0, texture=url
    )


def _transform(node: Node) -> NDArray[np.float64]:
    """T C R SR S -SR -C (ISO/IEC 14772-1, 6.52)."""
    import numpy as np

    centre = np.asarray(node.get("center", (0.0, 0.0, 0.0)), float)
    turn, aside = _turn(node.get("rotation")), _turn(node.get("scaleOrientation"))
    pose = np.eye(4)
    pose[:3, :3] = turn @ aside @ np.diag(node.get("scale", (1.0, 1.0, 1.0))) @ aside.T
    pose[:3, 3] = node.get("translation", (0.0, 0.0, 0.0)) + centre - pose[:3, :3] @ centre
    return pose


def _turn(rotation: Any) -> NDArray[np.float64]:
    """The turn (3, 3) about an axis by an angle (rad), by Rodrigues' formula."""
    import numpy as np

    x, y, z, angle = rotation or (0.0, 0.0, 1.0, 0.0)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / (float(np.hypot(np.hypot(x, y), z)) or 1)
    turn: NDArray[np.float64] = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
    return turn


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
