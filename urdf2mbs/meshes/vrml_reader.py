"""VRML97 (ISO/IEC 14772-1) read into triangles.

Faces are read, in groups and transforms, with their colours and textures.  Lines, lights, scripts
and prototypes draw nothing.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from urdf2mbs.meshes.model import MOST_PARTS, Material, Mesh, MeshError, TooLargeError, add

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_TOKEN = re.compile(
    rb'[\s,]*(?:#[^\n]*(?:\n|\Z)[\s,]*)*("(?:[^"\\]|\\.)*"|[{}\[\]]|[^\s,{}\[\]"#]+)'
)
_NUMBER = re.compile(rb"[+-]?(\d|\.\d)")
_NUMBERS = re.compile(rb"(?:[^\]#]|#[^\n]*)*")
_BOOLEANS = {b"TRUE": True, b"FALSE": False}

#: What is not drawn, and says so.
_NOT_DRAWN = ("ElevationGrid", "Extrusion", "Inline", "Switch", "Text")

Node = dict[str, Any]
"""The node's fields; its type stands under ``""``, the nodes inside it under ``children``."""


def read(data: bytes) -> Mesh:
    """The triangles of a .wrl; ``problems`` names what is not drawn.

    Raises MeshError for a file that is no VRML or holds no triangles.
    """
    data = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    if not data.startswith(b"#VRML V2.0"):
        raise MeshError("it is not VRML97")
    try:
        scene = _Scene()
        for node in _Text(data).scene():
            scene.draw(node)
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

    def scene(self) -> list[Node]:
        nodes: list[Node] = []
        while self.peek() is not None:
            self.add_node(self.next(), nodes)
        return nodes

    def add_node(self, word: bytes, nodes: list[Node]) -> None:
        """Read what begins with ``word``: a node, or a statement that draws nothing."""
        if word == b"ROUTE":
            for _ in ("from", "TO", "to"):
                self.next()
        elif word in (b"PROTO", b"EXTERNPROTO"):
            for _ in ("name", "interface", "body"):
                self.skip()
        elif word != b"NULL":
            nodes.append(self.node(word))

    def skip(self) -> None:
        """Pass a word, or all that stands between brackets."""
        depth = 0
        while True:
            word = self.next()
            depth += (word in (b"{", b"[")) - (word in (b"}", b"]"))
            if depth <= 0:
                return

    def node(self, word: bytes) -> Node:
        if word == b"USE":
            return self.named[self.next()]
        node: Node = {"children": []}
        if word == b"DEF":
            self.named[self.next()] = node
            word = self.next()
        if self.next() != b"{":
            raise ValueError(f"no node at byte {self.at}")
        node[""] = word.decode("ascii", "replace")
        while (word := self.next()) != b"}":
            if word in (b"eventIn", b"eventOut", b"field", b"exposedField"):  # of a Script
                self.next()
                name = self.next()
                if not word.startswith(b"event"):
                    node[name.decode("ascii", "replace")] = self.value()
                elif self.peek() == b"IS":
                    self.skip()
                    self.skip()
            elif word in (b"DEF", b"USE", b"ROUTE", b"PROTO") or self.peek() == b"{":
                self.add_node(word, node["children"])
            else:
                node[word.decode("ascii", "replace")] = self.value()
        return node

    def value(self) -> Any:
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
        """A text, a node, TRUE, FALSE, NULL or another word, such as PER_FACE."""
        if word.startswith(b'"'):
            return re.sub(r"\\(.)", r"\1", word[1:-1].decode("utf-8", "replace"))
        if word in _BOOLEANS:
            return _BOOLEANS[word]
        if word in (b"DEF", b"USE") or self.peek() == b"{":
            return self.node(word)
        if word == b"IS":
            self.next()
            return None
        if word in (b"{", b"}", b"]"):
            raise ValueError(f"no value at byte {self.at}")
        return None if word == b"NULL" else word.decode("ascii", "replace")

    def list(self) -> Any:
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
            if word in (b"ROUTE", b"PROTO", b"EXTERNPROTO"):
                self.add_node(word, values)
            else:
                values.append(self.single(word))
        return values


def primitive(kind: str, radius: float, height: float, size: Any) -> tuple[Any, Any]:
    """Points (n, 3) and triangles (m, 3) of a box, sphere, cylinder or cone (m).

    The axis is y, in VRML as in an .mbs.
    """
    import numpy as np
    from trimesh import creation

    if kind == "box":
        solid = creation.box(size)
        return solid.vertices, solid.faces
    if kind == "sphere":
        solid = creation.icosphere(2, radius)
    elif kind == "cone":
        solid = creation.cone(radius, height)
        solid.apply_translation((0.0, 0.0, -height / 2))
    else:
        solid = creation.cylinder(radius, height, sections=24)
    return solid.vertices @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), solid.faces


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
        kind = node[""]
        pose = np.eye(4) if pose is None else pose
        if kind == "Transform":
            pose = pose @ _transform(node)
        elif kind == "Shape" and isinstance(node.get("geometry"), dict):
            geometry = node["geometry"]
            if geometry[""] == "IndexedFaceSet":
                self._add_faces(geometry, node.get("appearance") or {}, pose)
            elif geometry[""] in ("Box", "Sphere", "Cylinder", "Cone"):
                self._add_primitive(geometry, node.get("appearance") or {}, pose)
            elif geometry[""] in _NOT_DRAWN:
                self.mesh.problems.append(f"its {geometry['']} is not drawn")
        elif kind in _NOT_DRAWN:
            self.mesh.problems.append(f"its {kind} is not drawn")
        children = node["children"]
        if kind == "LOD":
            children = node.get("level", [])[:1]
        for child in children if isinstance(children, list) else [children]:
            if isinstance(child, dict):
                self.draw(child, pose)

    def _add_primitive(self, node: Node, appearance: Node, pose: NDArray[np.float64]) -> None:
        def number(name: str, default: float) -> float:
            return float(node.get(name, [default])[0])

        radius = number("bottomRadius" if node[""] == "Cone" else "radius", 1.0)
        size = [float(side) for side in node.get("size", (2.0, 2.0, 2.0))]
        points, triangles = primitive(node[""].lower(), radius, number("height", 2.0), size)
        material, smooth = _material(appearance), node[""] != "Box"
        add(self.mesh, pose, points, triangles, material=material, smooth=smooth)

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

    def shift(xyz: Any) -> NDArray[np.float64]:
        pose = np.eye(4)
        pose[:3, 3] = xyz
        return pose

    scale: Any = node.get("scale", (1.0, 1.0, 1.0))
    stretched = np.diag(np.append(scale, 1.0))
    centre = np.asarray(node.get("center", (0.0, 0.0, 0.0)), float)
    turned = _turn(node.get("scaleOrientation"))
    return (
        shift(node.get("translation", (0.0, 0.0, 0.0))) @ shift(centre)
        @ _turn(node.get("rotation")) @ turned @ stretched @ turned.T @ shift(-centre)
    )  # fmt: skip


def _turn(rotation: Any) -> NDArray[np.float64]:
    """The turn about an axis by an angle (rad), by Rodrigues' formula."""
    import numpy as np

    x, y, z, angle = rotation or (0.0, 0.0, 1.0, 0.0)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / (float(np.hypot(np.hypot(x, y), z)) or 1)
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
    return pose


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
