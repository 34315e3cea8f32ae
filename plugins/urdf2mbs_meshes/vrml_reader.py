"""VRML97 (ISO/IEC 14772-1) read into triangles.

Faces are read, in groups and transforms, with their colours and textures.  Lines and lights draw
nothing.  A file with prototypes, routes or scripts is an error.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from urdf2mbs_meshes.model import MAX_PARTS, Material, Mesh, MeshError, TooLargeError, add_part

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_TOKEN = re.compile(
    rb'[\s,]*(?:#[^\n]*(?:\n|\Z)[\s,]*)*("(?:[^"\\]|\\.)*"|[{}\[\]]|[^\s,{}\[\]"#]+)'
)
_NUMBER = re.compile(rb"[+-]?(\d|\.\d)")
_NUMBERS = re.compile(rb"(?:[^\]#]|#[^\n]*)*")

#: Nodes with surfaces that are not drawn, which is a problem of the mesh.
_NOT_DRAWN = {
    "Box",
    "Cone",
    "Cylinder",
    "ElevationGrid",
    "Extrusion",
    "Inline",
    "LOD",
    "Sphere",
    "Switch",
    "Text",
}

Node = dict[str, Any]
"""The fields of a node by name; its type has the name ``""``."""


def read_vrml(data: bytes) -> Mesh:
    """Read a .wrl file.

    Args:
        data: The file.

    Returns:
        Its triangles; ``problems`` names the shapes that are not drawn.

    Raises:
        MeshError: The file is not VRML97, or holds no triangles.
    """
    data = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    if not data.startswith(b"#VRML V2.0"):
        raise MeshError("it is not VRML97")
    try:
        scene = _Scene()
        parser = _Parser(data)
        while parser.peek() is not None:
            scene.draw(parser.parse_node(parser.next_token()))
    except (ValueError, KeyError, IndexError, TypeError, RecursionError) as error:
        raise MeshError(f"it is not VRML as far as we can read it ({error})") from None
    if not scene.mesh.parts:
        raise MeshError("; ".join(["it holds no triangles", *scene.mesh.problems]))
    return scene.mesh


# --- the text ---


class _Parser:
    """Parses a file from its start to its end into nodes."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.position = 0
        self.defined_nodes: dict[bytes, Node] = {}

    def peek(self) -> bytes | None:
        """Return the next token; None at the end of the file."""
        match = _TOKEN.match(self.data, self.position)
        return match and match[1]

    def next_token(self) -> bytes:
        """Return the next token, and go on behind it."""
        match = _TOKEN.match(self.data, self.position)
        if match is None:
            raise ValueError("it is cut off")
        self.position = match.end()
        return match[1]

    def parse_node(self, token: bytes) -> Node:
        """Parse the node that begins with a token."""
        if token == b"USE":
            return self.defined_nodes[self.next_token()]
        node: Node = {}
        if token == b"DEF":
            self.defined_nodes[self.next_token()] = node
            token = self.next_token()
        node[""] = token.decode("ascii", "replace")
        if self.next_token() != b"{":
            raise ValueError(f"'{node['']}' at byte {self.position} is not read")
        while (token := self.next_token()) != b"}":
            node[token.decode("ascii", "replace")] = self.parse_field()
        return node

    def parse_field(self) -> Any:
        """Parse a list, numbers, or a single value."""
        token = self.next_token()
        if token == b"[":
            return self.parse_list()
        if not _NUMBER.match(token):
            return self.parse_value(token)
        numbers = [float(token)]
        while _NUMBER.match(self.peek() or b""):
            numbers.append(float(self.next_token()))
        return numbers

    def parse_value(self, token: bytes) -> Any:
        """Parse a text, a node, TRUE, FALSE, NULL or another word."""
        if token.startswith(b'"'):
            return re.sub(r"\\(.)", r"\1", token[1:-1].decode("utf-8", "replace"))
        if token in (b"{", b"}", b"]"):
            raise ValueError(f"no value at byte {self.position}")
        if token in (b"DEF", b"USE") or self.peek() == b"{":
            return self.parse_node(token)
        constants = {b"TRUE": True, b"FALSE": False, b"NULL": None}
        return constants[token] if token in constants else token.decode("ascii", "replace")

    def parse_list(self) -> Any:
        """Parse the values up to ``]``; numbers become an array."""
        import numpy as np

        if _NUMBER.match(self.peek() or b""):
            text = _NUMBERS.match(self.data, self.position)
            assert text is not None
            if text.end() == len(self.data):
                raise ValueError("it is cut off")
            self.position = text.end() + 1
            words = re.sub(rb"#[^\n]*", b"", text[0]).replace(b",", b" ").split()
            return np.array(words, dtype=np.float64)
        values: list[Any] = []
        while (token := self.next_token()) != b"]":
            values.append(self.parse_value(token))
        return values


# --- the scene ---


class _Faces(NamedTuple):
    """The triangles of an ``IndexedFaceSet``, which may have faces of more corners."""

    coordinate_index: NDArray[np.int64]
    """The indices of all corners, with -1 after each face."""
    corners: NDArray[np.int64]
    """(m, 3) the positions of a triangle's corners in ``coordinate_index``."""
    faces: NDArray[np.int64]
    """(m,) the number of the face that a triangle is part of."""


class _Scene:
    """Collects the triangles that nodes draw."""

    def __init__(self) -> None:
        self.mesh = Mesh(Path("mesh.wrl"))
        self.node_count = 0

    def draw(self, node: Node, parent_pose: NDArray[np.float64] | None = None) -> None:
        """Add the triangles of a node and its children.

        Args:
            node: The node.
            parent_pose: (4, 4) transform from the frame of the node's parent to that of the mesh.
        """
        import numpy as np

        self.node_count += 1
        if self.node_count > MAX_PARTS:
            raise TooLargeError(f"it has more than {MAX_PARTS:,} nodes, each copy counted")
        pose = np.eye(4) if parent_pose is None else parent_pose
        node_type = node[""]
        if node_type == "Transform":
            pose = pose @ _compute_transform(node)
        elif node_type == "Shape" and isinstance(node.get("geometry"), dict):
            geometry = node["geometry"]
            node_type = geometry[""]
            if node_type == "IndexedFaceSet":
                self._add_face_set(geometry, node.get("appearance") or {}, pose)
        if node_type in _NOT_DRAWN:
            self.mesh.problems.append(f"its {node_type} is not drawn")
        children = node.get("children", [])
        for child in children if isinstance(children, list) else [children]:
            if isinstance(child, dict):
                self.draw(child, pose)

    def _add_face_set(self, node: Node, appearance: Node, pose: NDArray[np.float64]) -> None:
        """Add the triangles of an ``IndexedFaceSet``."""
        import numpy as np

        coordinates, texture_coordinates = node.get("coord"), node.get("texCoord")
        if not coordinates or not len(node.get("coordIndex", ())):
            return
        points = np.asarray(coordinates.get("point", ()), float).reshape(-1, 3)
        faces = _triangulate(np.asarray(node["coordIndex"]).astype(np.int64))
        triangles = faces.coordinate_index[faces.corners]
        if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(points):
            raise ValueError("a face names a point that is not there")
        if not np.isfinite(points[triangles]).all():
            raise ValueError("a point is not finite")
        material, uv = _read_material(appearance), None
        if material.texture and texture_coordinates:
            uv_points = np.asarray(texture_coordinates["point"], float).reshape(-1, 2)
            uv = uv_points[_read_corner_index(node, "texCoordIndex", faces)]
        crease_angle = float(node.get("creaseAngle", [0.0])[0])
        add_part(
            self.mesh,
            pose,
            points,
            triangles,
            material=material,
            smooth=crease_angle > 0.0,
            colors=self._read_colors(node, faces) if node.get("color") else None,
            uv=uv,
        )

    def _read_colors(self, node: Node, faces: _Faces) -> NDArray[np.int64] | None:
        """Return the colours of corners (m, 3, 3) or faces (m, 3), 0 to 255; None: not usable."""
        import numpy as np

        palette = np.asarray(node["color"]["color"], float).reshape(-1, 3)
        color_index = node.get("colorIndex")
        if len(palette) == 1:
            indices = np.zeros(len(faces.faces), np.int64)
        elif node.get("colorPerVertex", True):
            indices = _read_corner_index(node, "colorIndex", faces)
        elif color_index is None:
            indices = faces.faces
        else:
            indices = np.asarray(color_index).astype(np.int64)[faces.faces]
        if not 0 <= indices.min(initial=0) <= indices.max(initial=0) < len(palette):
            self.mesh.problems.append("its faces name colours that are not there")
            return None
        return np.round(255 * palette[indices]).astype(np.int64)


def _read_corner_index(node: Node, field: str, faces: _Faces) -> NDArray[np.int64]:
    """Return (m, 3) the indices of corners in a field, or else in ``coordIndex``."""
    import numpy as np

    index = node.get(field)
    if index is None or len(index) <= int(faces.corners.max(initial=0)):
        index = faces.coordinate_index
    return np.asarray(index).astype(np.int64)[faces.corners]


def _read_material(appearance: Node) -> Material:
    """Read the ``Appearance`` of a shape."""
    node, texture = appearance.get("material") or {}, appearance.get("texture") or {}
    url = texture.get("url")
    if isinstance(url, list):
        url = url[0] if url else None
    red, green, blue = (float(value) for value in node.get("diffuseColor", (0.8, 0.8, 0.8))[:3])
    transparency = node.get("transparency", ())
    return Material(
        diffuse=(red, green, blue),
        transparency=float(transparency[0]) if len(transparency) else 0.0,
        texture=url,
    )


def _compute_transform(node: Node) -> NDArray[np.float64]:
    """Compute the (4, 4) matrix of a ``Transform``.

    It is ``T C R SR S SR^-1 C^-1`` (ISO/IEC 14772-1, 6.52): translation, center, rotation,
    scaleOrientation, scale.
    """
    import numpy as np

    centre = np.asarray(node.get("center", (0.0, 0.0, 0.0)), float)
    rotation = _compute_rotation(node.get("rotation"))
    scale_axes = _compute_rotation(node.get("scaleOrientation"))
    scale = np.diag(node.get("scale", (1.0, 1.0, 1.0)))
    transform = np.eye(4)
    transform[:3, :3] = rotation @ scale_axes @ scale @ scale_axes.T
    translation = node.get("translation", (0.0, 0.0, 0.0))
    transform[:3, 3] = translation + centre - transform[:3, :3] @ centre
    return transform


def _compute_rotation(axis_angle: Any) -> NDArray[np.float64]:
    """Compute the rotation matrix of an axis and an angle (rad); None is no rotation.

    By Rodrigues' formula ``R = 1 + sin(angle) K + (1 - cos(angle)) K^2``, where K, the cross
    matrix, multiplies by the unit axis in a cross product.
    """
    import numpy as np

    x, y, z, angle = axis_angle or (0.0, 0.0, 1.0, 0.0)
    length = float(np.hypot(np.hypot(x, y), z)) or 1
    cross_matrix = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / length
    rotation: NDArray[np.float64] = (
        np.eye(3)
        + np.sin(angle) * cross_matrix
        + (1 - np.cos(angle)) * (cross_matrix @ cross_matrix)
    )
    return rotation


def _triangulate(coordinate_index: NDArray[np.int64]) -> _Faces:
    """Split faces, each ended by -1, into fans of triangles.

    The face 3 7 8 9 becomes the triangles 3 7 8 and 3 8 9.
    """
    import numpy as np

    if len(coordinate_index) and coordinate_index[-1] != -1:
        coordinate_index = np.append(coordinate_index, -1)
    ends = np.flatnonzero(coordinate_index == -1)
    starts = np.concatenate([[0], ends[:-1] + 1]) if len(ends) else ends
    triangle_counts = np.maximum(ends - starts - 2, 0)
    faces = np.repeat(np.arange(len(ends)), triangle_counts)
    first_triangles = np.cumsum(triangle_counts) - triangle_counts
    number_in_face = np.arange(triangle_counts.sum()) - np.repeat(first_triangles, triangle_counts)
    first = starts[faces]
    corners = np.stack([first, first + number_in_face + 1, first + number_in_face + 2], axis=1)
    return _Faces(coordinate_index, corners.astype(np.int64), faces)
