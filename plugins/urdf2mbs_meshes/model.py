"""A mesh in memory: triangles in metres, z up, how they look, and where they come from."""

from __future__ import annotations

import io
import re
from contextlib import suppress
from pathlib import Path, PureWindowsPath
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

import msgspec

from urdf2mbs.plugin import files

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.floating[Any]]
    Integers = NDArray[np.integer[Any]]

#: Red, green, blue, each 0 to 1.
RGB = tuple[float, float, float]

#: So many parts and triangles of a mesh are read at most, each copy of a part counted: a file of
#: a few bytes can ask for any number.
MOST_PARTS, MOST_TRIANGLES = 100_000, 20_000_000

NO_PILLOW = "textures are left out, as the package 'pillow' is not installed: pip install pillow"

#: What is said of lines and points: a .wrl of ours shows surfaces.
NO_LINES = "its lines and points are left out"

#: An image of a few bytes can say that it has any number of pixels.
MOST_PIXELS = 2**26

#: The image formats that VRML97's ImageTexture shows in every viewer.
IMAGES = {"PNG": ".png", "JPEG": ".jpg", "GIF": ".gif"}

#: The turn that makes z up of a file's up axis; what faced the viewer then faces -y
#: (COLLADA 1.4.1, chapter 5, "up_axis"; glTF 2.0, 3.4 has y up).
UP_AXES = {
    "X_UP": ((0, -1, 0), (0, 0, -1), (1, 0, 0)),
    "Y_UP": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "Z_UP": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}  # fmt: skip


class MeshLimit(msgspec.Struct):
    """How much of a robot's mesh files is read, as the pass ``convert-meshes`` was told."""

    mebibytes: int = 256


class MeshError(Exception):
    """A mesh file that cannot be used, and why, in plain words."""


class TooLargeError(MeshError):
    """A mesh that would take more memory than any robot needs."""


class Material(msgspec.Struct, frozen=True):
    """How a part looks; ``diffuse`` None is the colour that the URDF gives the visual."""

    diffuse: RGB | None = None
    transparency: float | None = None
    """0 opaque to 1 invisible; None is the visual's own."""
    emissive: RGB | None = None
    specular: RGB | None = None
    shininess: float | None = None
    """0 to 1: the specular exponent / 128."""
    texture: str | None = None
    """Name of an image file (PNG, JPEG or GIF) beside the .wrl."""


class Part(msgspec.Struct):
    """Triangles of one material."""

    points: Floats
    """(n, 3) m."""
    triangles: Integers
    """(m, 3) indices into ``points``, anticlockwise seen from outside."""
    material: Material = Material()
    smooth: bool = False
    colors: Integers | None = None
    """(m, 3, k) one colour a corner, or (m, k) one a face: k = 3 or 4 of 0 to 255."""
    uv: Floats | None = None
    """(m, 3, 2) texture coordinates of each corner, (0, 0) in the lower left of the image."""


class Mesh:
    """What one mesh file holds."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.parts: list[Part] = []
        self.triangles = 0
        """Of all parts."""
        self.textures: dict[str, bytes] = {}
        """Images to lie beside the .wrl, by file name."""
        self.sources: dict[str, bytes | None] = {}
        """Every file that was read, by its name in the mesh file; None: it is not there."""
        self.problems: list[str] = []
        """What of the mesh file could not be taken over."""
        self.turned_up: str | None = None
        """COLLADA's ``<up_axis>``, where it made the mesh be turned."""

    @property
    def size(self) -> int:
        """Bytes of all files that were read."""
        return sum(len(data) for data in self.sources.values() if data)

    def fetch(self, name: str) -> bytes | None:
        """A file that the mesh file names (relative to itself, as a path or a URI)."""
        if name in self.sources:
            return self.sources[name]
        plain = name.replace("\\", "/")
        uri = urlsplit(plain)
        data = None
        for path in (plain, unquote(uri.path) if uri.scheme == "file" else unquote(plain)):
            with suppress(OSError, ValueError):
                data = files.read_bytes(self.path.parent / path, files.MAX_FILE_SIZE - self.size)
                break
        self.sources[name] = data
        return data

    def texture(self, data: bytes, name: str) -> str | None:
        """Keep an image under a name of its own, as PNG where VRML97 cannot show its format."""
        try:
            from PIL import Image
        except ImportError:
            self.problems.append(NO_PILLOW)
            return None
        try:
            with Image.open(io.BytesIO(data)) as image:
                if image.width * image.height > MOST_PIXELS:
                    raise ValueError(f"more than {MOST_PIXELS:,} pixels")
                image.load()
                if image.format not in IMAGES:
                    return self.picture(image, name)
                ending = IMAGES[image.format]
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
            self.problems.append(f"texture '{name}' is no readable image ({error})")
            return None
        return self._keep(data, name, ending)

    def picture(self, image: Any, name: str) -> str:
        """Keep a decoded image (PIL) as PNG."""
        out = io.BytesIO()
        plain = image.mode in ("1", "L", "LA", "RGB", "RGBA", "P")
        (image if plain else image.convert("RGBA")).save(out, "PNG")
        return self._keep(out.getvalue(), name, ".png")

    def _keep(self, data: bytes, name: str, ending: str) -> str:
        from hashlib import sha256

        # named by content: equal images are one file, unequal ones never collide
        stem = re.sub(r"[^A-Za-z0-9_-]", "_", PureWindowsPath(unquote(name)).stem) or "texture"
        file = f"{stem[:100]}_{sha256(data).hexdigest()[:8]}{ending}"
        self.textures[file] = data
        return file


def add(mesh: Mesh, matrix: NDArray[np.float64], points: Any, triangles: Any, **rest: Any) -> None:
    """Add a part that stands in a node with the transform ``matrix`` (4 x 4)."""
    import numpy as np

    points = np.asarray(points).reshape(-1, 3)
    if not np.array_equal(matrix, np.eye(4)):
        points = points @ matrix[:3, :3].T + matrix[:3, 3]
    part = Part(points, np.asarray(triangles, int).reshape(-1, 3), **rest)
    if len(mesh.parts) >= MOST_PARTS:
        raise TooLargeError(f"it has more than {MOST_PARTS:,} parts, each copy counted")
    mesh.triangles += len(part.triangles)
    if mesh.triangles > MOST_TRIANGLES:
        raise TooLargeError(f"it has more than {MOST_TRIANGLES:,} triangles, each copy counted")
    mesh.parts.append(turned(part) if np.linalg.det(matrix[:3, :3]) < 0 else part)


def turned(part: Part) -> Part:
    """The same part with every triangle turned inside out."""
    by_corner = part.colors is not None and part.colors.ndim == 3
    return msgspec.structs.replace(
        part,
        triangles=part.triangles[:, ::-1],
        colors=part.colors[:, ::-1] if by_corner and part.colors is not None else part.colors,
        uv=None if part.uv is None else part.uv[:, ::-1],
    )


def distinct(rows: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """The distinct rows in the order in which they come, and which of them each row is."""
    import numpy as np

    rows = np.ascontiguousarray(rows)
    # a row as one value: sorted by its bytes
    whole = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    _, first, which = np.unique(whole, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int32)
    rank[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
    return rows[np.sort(first)], rank[which.ravel()]
