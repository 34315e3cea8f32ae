"""What the report's 3D view draws, as plain data: an .mbs file, a URDF, and their meshes.

The two sides know nothing of each other.  The .mbs's shapes are what its .wrl files hold,
read here by a VRML reader of its own; the URDF's are its own mesh files.  Where both give the
same triangles, these are stored once.
"""

from __future__ import annotations

import base64
import gzip
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

import msgspec

from urdf2mbs.diagnostics import ConversionError
from urdf2mbs.mbs import model as mbs
from urdf2mbs.meshes import reader as meshes
from urdf2mbs.meshes.vrml import Material, Part
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf import model as urdf

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

IMAGES = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"GIF8": "image/gif"}

#: Gives a file by its url or name; None: it is not there.
Fetch = Callable[[str], bytes | None]


class Store:
    """The meshes of one page: each mesh a list of parts, each array stored once."""

    def __init__(self) -> None:
        self.meshes: list[list[dict[str, Any]]] = []
        self.textures: list[str] = []
        self.missing: dict[str, str] = {}
        """Meshes that cannot be drawn, and why."""
        self._arrays: dict[bytes, int] = {}
        self._index: list[tuple[int, int, int]] = []
        self._known: dict[tuple[str, str], int | None] = {}
        self._offset = 0

    def wrl(self, url: str, fetch: Fetch) -> int | None:
        """The number of the mesh that an .mbs's ``url`` shows, None where it cannot be drawn."""
        return self._once("wrl", url, lambda: self._read_wrl(url, fetch))

    def source(self, filename: str, path: Path | None) -> int | None:
        """The same for a URDF's mesh file, drawn as RViz draws it."""
        return self._once("source", filename, lambda: self._read_source(path))

    def _once(
        self, kind: str, name: str, make: Callable[[], tuple[list[Part], Fetch]]
    ) -> int | None:
        if (kind, name) not in self._known:
            number: int | None = None
            try:
                parts, fetch = make()
            except meshes.MeshError as error:
                self.missing[name] = str(error)
            else:
                self.meshes.append([self._part(part, fetch) for part in parts])
                number = len(self.meshes) - 1
            self._known[kind, name] = number
        return self._known[kind, name]

    def _read_wrl(self, url: str, fetch: Fetch) -> tuple[list[Part], Fetch]:
        data = fetch(url)
        if data is None:
            raise meshes.MeshError("the .wrl is not there ('output: {project: DIR}' makes it)")
        folder = PurePosixPath(url).parent
        return read_vrml(data), lambda name: fetch(str(folder / name))

    def _read_source(self, path: Path | None) -> tuple[list[Part], Fetch]:
        if path is None:
            raise meshes.MeshError("the mesh file is not there")
        try:
            mesh = meshes.read(path, up_axis=False)
        except ConversionError as error:
            raise meshes.MeshError(f"{error.message}; {error.hint}") from None
        return mesh.parts, mesh.textures.get

    def _part(self, part: Part, fetch: Fetch) -> dict[str, Any]:
        import numpy as np

        corners = part.points.astype(np.float32)[part.triangles].reshape(-1, 3) + np.float32(0.0)
        points, triangles = _indexed(corners)
        look = part.material
        out: dict[str, Any] = {
            "points": self._array(points.view(np.uint32)),
            "triangles": self._array(triangles.astype(np.uint32), differences=True),
            "smooth": part.smooth,
            "color": look.diffuse,
            "transparency": look.transparency,
        }
        texture = fetch(look.texture) if look.texture and part.uv is not None else None
        if texture is not None and part.uv is not None:
            out["texture"] = self._texture(texture)
            out["uv"] = self._array(part.uv.astype(np.float32).reshape(-1, 2).view(np.uint32))
        if part.colors is not None:
            colors = np.asarray(part.colors)
            if colors.ndim == 2:
                colors = np.repeat(colors[:, None, :], 3, axis=1)
            if colors.shape[-1] == 4 and look.transparency is None:
                out["transparency"] = 1.0 - float(colors[..., 3].mean()) / 255
            packed = colors[..., :3].reshape(-1, 3).astype(np.uint32) @ np.array(
                [1 << 16, 1 << 8, 1], dtype=np.uint32
            )
            out["colors"] = self._array(packed.astype(np.uint32), differences=True)
        return out

    def _array(self, values: NDArray[np.uint32], *, differences: bool = False) -> list[int]:
        """Keep an array of 32-bit words; gives its place, its length, and how it is packed.

        Its bytes are put apart by their rank, so that like stands beside like: this lets
        gzip save about a third more.
        """
        import numpy as np

        flat = np.ascontiguousarray(values).ravel().astype("<u4")
        if differences:
            flat = np.diff(flat, prepend=np.uint32(0)).astype("<u4")
            flat = (flat << np.uint32(1)) ^ (np.uint32(0) - (flat >> np.uint32(31)))
        packed = flat.view(np.uint8).reshape(-1, 4).T.tobytes()
        if packed not in self._arrays:
            self._arrays[packed] = self._offset
            self._offset += len(packed)
        return [self._arrays[packed], len(flat), int(differences)]

    def _texture(self, data: bytes) -> int:
        kind = next((kind for start, kind in IMAGES.items() if data.startswith(start)), "image/png")
        url = f"data:{kind};base64,{base64.b64encode(data).decode()}"
        if url not in self.textures:
            self.textures.append(url)
        return self.textures.index(url)

    def packed(self) -> str:
        """All arrays, for the page to unpack: gzip, then base64."""
        return base64.b64encode(gzip.compress(b"".join(self._arrays), 9, mtime=0)).decode()


def _indexed(corners: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.intp]]:
    """The distinct points in the order in which the corners (n, 3) use them, and each one's."""
    import numpy as np

    rows = np.ascontiguousarray(corners).view(np.dtype((np.void, 12))).ravel()
    _, first, which = np.unique(rows, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return corners[first[order]], np.argsort(order)[which.ravel()]


def mbs_side(model: mbs.Mbs, store: Store, fetch: Fetch) -> dict[str, Any]:
    """The .mbs's own joint list, points and shapes."""

    def shapes(given: list[mbs.Shape]) -> list[dict[str, Any]]:
        out = []
        for shape in given:
            drawn = {
                key: getattr(shape, key)
                for key in (
                    "kind", "name", "position", "rotation", "scale", "color", "transparency",
                    "size", "radius", "height", "url",
                )
            }  # fmt: skip
            if shape.url is not None:
                drawn["mesh"] = store.wrl(shape.url, fetch)
            out.append(drawn)
        return out

    def points(given: list[mbs.Point]) -> list[dict[str, Any]]:
        return [{"name": point.name, "xyz": point.coordinates} for point in given]

    places: dict[tuple[str | None, str | None], Vec] = {
        (None, point.name): point.coordinates for point in model.base.points
    } | {
        (body.name, point.name): point.coordinates for body in model.bodies for point in body.points
    }
    return {
        "gravity": model.base.gravity,
        "base": {
            "name": model.base.name,
            "points": points(model.base.points),
            "shapes": shapes(model.base.shapes),
        },
        "bodies": [
            {
                "name": body.name,
                "parent": body.parent,
                "at": (0.0, 0.0, 0.0) if body.point is None else places[body.parent, body.point],
                "joints": [
                    {"name": joint.name, "type": joint.type, "nature": joint.nature, "q": joint.q}
                    for joint in body.joints
                ],
                "mass": body.mass,
                "com": body.com,
                "inertia": body.inertia,
                "points": points(body.points),
                "shapes": shapes(body.shapes),
            }
            for body in model.bodies
        ],
    }  # fmt: skip


def urdf_side(
    robot: urdf.Robot, store: Store, find: Callable[[str], Path | None]
) -> dict[str, Any]:
    """The URDF's links and joints, the joints in an order in which parents come first."""

    def visual(given: urdf.Visual) -> dict[str, Any]:
        material = given.material
        if material is not None and material.color is None and material.name in robot.materials:
            material = robot.materials[material.name]
        color = None if material is None else material.color
        return {**placed(given), "color": color}

    def placed(given: urdf.Visual | urdf.Collision) -> dict[str, Any]:
        shape = given.geometry
        out: dict[str, Any] = {
            "xyz": given.origin.xyz,
            "rpy": given.origin.rpy,
            "geometry": msgspec.to_builtins(shape),
        }
        if isinstance(shape, urdf.Mesh):
            out["mesh"] = store.source(shape.filename, find(shape.filename))
        return out

    return {
        "root": robot.root(),
        "links": [
            {
                "name": link.name,
                "visuals": [visual(given) for given in link.visuals],
                "collisions": [placed(given) for given in link.collisions],
            }
            for link in robot.links.values()
        ],
        "joints": [
            {
                "name": joint.name,
                "type": joint.type,
                "parent": joint.parent,
                "child": joint.child,
                "xyz": joint.origin.xyz,
                "rpy": joint.origin.rpy,
                "axis": joint.axis,
                "limit": None
                if joint.limit is None or None in (joint.limit.lower, joint.limit.upper)
                else (joint.limit.lower, joint.limit.upper),
                "mimic": joint.mimic
                and (joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset),
            }
            for joint in robot.depth_first()
        ],
    }


# --- VRML97, as much of it as draws triangles -------------------------------------------------

_TOKEN = re.compile(rb'[\s,]*(?:#[^\n]*[\s,]*)*("(?:[^"\\]|\\.)*"|[{}\[\]]|[^\s,{}\[\]"#]+)')
_NUMBER = re.compile(rb"[+-]?(\d|\.\d)")
_BOOLEANS = {b"TRUE": True, b"FALSE": False}

Node = dict[str, Any]


def read_vrml(data: bytes) -> list[Part]:
    """The triangles of a .wrl: Shapes with an IndexedFaceSet, in Groups and Transforms.

    Raises MeshError for a file that is no VRML97 or holds nothing of the kind.
    """
    if not data.startswith(b"#VRML V2.0"):
        raise meshes.MeshError("it is not VRML97")
    try:
        parts = list(_parts(_Vrml(data).scene()))
    except (ValueError, KeyError, IndexError, TypeError, RecursionError) as error:
        raise meshes.MeshError(f"it is not VRML97 as far as we can read it ({error})") from None
    if not parts:
        raise meshes.MeshError("it holds no triangles")
    return parts


class _Vrml:
    """Nodes as dicts: their type under ``""``, and their fields."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.at = 0
        self.named: dict[bytes, Node] = {}

    def _next(self, *, keep: bool = False) -> bytes | None:
        found = _TOKEN.match(self.data, self.at)
        if found is None:
            return None
        if not keep:
            self.at = found.end()
        return found[1]

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


def lookup(files: Mapping[Path, bytes], project: Path) -> Fetch:
    """Fetches what ``PRJPATH`` urls name: what is about to be written, else what lies there."""

    def fetch(url: str) -> bytes | None:
        path = Path(url.replace("PRJPATH", str(project), 1))
        if path in files:
            return files[path]
        try:
            return path.read_bytes()
        except OSError:
            return None

    return fetch
