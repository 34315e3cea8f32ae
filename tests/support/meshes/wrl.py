"""A reader of VRML97 that shares nothing with the writer.

It knows enough of the grammar (ISO/IEC 14772-1, annex A) for nodes with fields, and makes triangles
of IndexedFaceSets.
"""

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

TOKEN = re.compile(r'#[^\n]*|"(?:[^"\\]|\\.)*"|[{}\[\]]|[^\s,{}\[\]"#]+')


@dataclass
class Shape:
    points: np.ndarray
    faces: np.ndarray
    material: dict[str, Any]
    texture: str | None
    uv: np.ndarray | None
    """(faces, 3, 2)"""
    colors: np.ndarray | None
    """(faces, 3, 3) of 0 to 255"""
    fields: dict[str, Any] = field(default_factory=dict)

    @property
    def rgb(self) -> set[tuple[int, ...]]:
        if self.colors is not None:
            return {tuple(c) for c in self.colors.reshape(-1, 3).tolist()}
        return {tuple(round(255 * c) for c in self.material["diffuseColor"])}


def read(data: bytes) -> list[Shape]:
    text = data.decode("utf-8")
    assert text.startswith("#VRML V2.0 utf8\n")
    tokens = [t for t in TOKEN.findall(text) if not t.startswith("#")]
    nodes, position = [], 0
    while position < len(tokens):
        node, position = _node(tokens, position)
        nodes.append(node)
    return [_shape(node) for node in nodes]


def _node(tokens: list[str], position: int) -> tuple[dict[str, Any], int]:
    node: dict[str, Any] = {"node": tokens[position]}
    assert tokens[position + 1] == "{", tokens[position : position + 5]
    position += 2
    while tokens[position] != "}":
        name = tokens[position]
        position += 1
        if tokens[position] == "[":
            end = tokens.index("]", position)
            node[name] = tokens[position + 1 : end]
            position = end + 1
        elif tokens[position + 1] == "{":
            node[name], position = _node(tokens, position)
        else:
            end = position
            while re.match(r'[-+.\d"]|TRUE|FALSE', tokens[end]):
                end += 1
            node[name] = tokens[position:end]
            assert end > position, tokens[position - 3 : position + 3]
            position = end
    return node, position + 1


def _shape(node: dict[str, Any]) -> Shape:
    assert node["node"] == "Shape"
    look, faces = node["appearance"], node["geometry"]
    assert faces["node"] == "IndexedFaceSet"
    points = _table(faces["coord"]["point"], 3)
    triangles = _triangles(faces["coordIndex"])
    colors = uv = None
    if "color" in faces:
        palette = np.round(255 * _table(faces["color"]["color"], 3)).astype(int)
        if faces.get("colorPerVertex") == ["FALSE"]:
            chosen = np.array([int(k) for k in faces["colorIndex"]])
            assert len(chosen) == len(triangles)
            colors = np.repeat(palette[chosen][:, None], 3, axis=1)
        else:
            colors = palette[_triangles(faces["colorIndex"])]
        assert colors.shape == (*triangles.shape, 3)
    if "texCoord" in faces:
        uv = _table(faces["texCoord"]["point"], 2)[_triangles(faces["texCoordIndex"])]
        assert uv.shape == (*triangles.shape, 2)
    material = {
        key: [float(v) for v in value] for key, value in look["material"].items() if key != "node"
    }
    texture = look["texture"]["url"][0].strip('"') if "texture" in look else None
    return Shape(points, triangles, material, texture, uv, colors, faces)


def _table(tokens: list[str], columns: int) -> np.ndarray:
    return np.array([np.float32(t) for t in tokens], dtype=float).reshape(-1, columns)


def _triangles(tokens: list[str]) -> np.ndarray:
    table = np.array([int(t) for t in tokens]).reshape(-1, 4)
    assert (table[:, 3] == -1).all()
    assert (table[:, :3] >= 0).all()
    return table[:, :3]


def corners(shapes: list[Shape], scale: tuple[float, ...] = (1.0, 1.0, 1.0)) -> np.ndarray:
    """(faces, 3, 3) of all shapes together, scaled."""
    return np.concatenate([s.points[s.faces] for s in shapes]) * np.array(scale)


def volume(triangles: np.ndarray) -> float:
    """Compute the volume in the triangles; it is positive if they face outward."""
    return float(np.linalg.det(triangles).sum() / 6)


HEAD = b"#VRML V2.0 utf8\n"
SQUARE = b"coord Coordinate { point [0 0 0, 1 0 0, 1 1 0, 0 1 0] } coordIndex [0 1 2 3 -1 0 2 3 -1]"


def of(faces: bytes, look: bytes = b"") -> bytes:
    """Return a file with one shape."""
    return HEAD + b"Shape { appearance Appearance { %s } geometry IndexedFaceSet { %s } }" % (
        look,
        faces,
    )
