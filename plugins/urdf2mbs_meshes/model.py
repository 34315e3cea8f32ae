"""A mesh in memory: triangles in metres, how they look, and the files that they were read from."""

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

#: Largest number of parts of a mesh, each copy counted: a file of a few bytes can ask for more.
MAX_PARTS = 100_000
#: Largest number of triangles of a mesh, those of each copy counted.
MAX_TRIANGLES = 20_000_000
#: Largest number of pixels of a texture: an image of a few bytes can claim any number.
MAX_PIXELS = 2**26

NO_PILLOW = "textures are left out, as the package 'pillow' is not installed: pip install pillow"

#: The problem of a mesh with lines or points: only surfaces are converted.
NO_LINES = "its lines and points are left out"

#: The image formats that VRML97's ImageTexture shows in every viewer, with their endings.
IMAGE_ENDINGS = {"PNG": ".png", "JPEG": ".jpg", "GIF": ".gif"}

#: The rotation that turns a file's up axis to z; the side that faced the viewer then faces -y
#: (COLLADA 1.4.1, chapter 5, "up_axis"; glTF 2.0, 3.4 has y up).
UP_AXES = {
    "X_UP": ((0, -1, 0), (0, 0, -1), (1, 0, 0)),
    "Y_UP": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "Z_UP": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}


class MeshLimit(msgspec.Struct):
    """The limit on the size of all mesh files of a robot, an option of ``convert-meshes``."""

    mebibytes: int = 256


class MeshError(Exception):
    """A mesh file cannot be used; the message says why."""


class TooLargeError(MeshError):
    """A mesh would take more memory than that of any robot."""


class Material(msgspec.Struct, frozen=True):
    """How a part of a mesh looks; a field that is None is left to the visual in the URDF."""

    diffuse: RGB | None = None
    transparency: float | None = None
    """0 opaque to 1 invisible."""
    emissive: RGB | None = None
    specular: RGB | None = None
    shininess: float | None = None
    """0 to 1: the specular exponent / 128."""
    texture: str | None = None
    """Name of an image file (PNG, JPEG or GIF) beside the .wrl."""


class Part(msgspec.Struct):
    """Triangles of one material."""

    points: Floats
    """(n, 3) m, in the frame of the mesh."""
    triangles: Integers
    """(m, 3) indices into ``points``, anticlockwise seen from outside."""
    material: Material = Material()
    smooth: bool = False
    colors: Integers | None = None
    """(m, 3, k) a colour for each corner, or (m, k) for each face: k = 3 or 4 of 0 to 255."""
    uv: Floats | None = None
    """(m, 3, 2) texture coordinates of each corner, (0, 0) in the lower left of the image."""


class Mesh:
    """The content of a mesh file.

    Attributes:
        path: The mesh file.
        parts: Its triangles, by material.
        triangle_count: Number of triangles of all parts.
        textures: Images to be written beside the .wrl, by file name.
        sources: Every file that was read, by its name in the mesh file; None: it does not exist.
        problems: What of the mesh file could not be converted, in words.
        applied_up_axis: COLLADA's ``<up_axis>``, if the mesh was turned by it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.parts: list[Part] = []
        self.triangle_count = 0
        self.textures: dict[str, bytes] = {}
        self.sources: dict[str, bytes | None] = {}
        self.problems: list[str] = []
        self.applied_up_axis: str | None = None

    @property
    def size(self) -> int:
        """Number of bytes of all files that were read."""
        return sum(len(data) for data in self.sources.values() if data)

    def read_file(self, name: str) -> bytes | None:
        """Read a file that the mesh file names, once.

        Args:
            name: A path relative to the mesh file, or a URI.

        Returns:
            The content; None if there is no such file.
        """
        if name in self.sources:
            return self.sources[name]
        plain_name = name.replace("\\", "/")
        uri = urlsplit(plain_name)
        decoded_name = unquote(uri.path if uri.scheme == "file" else plain_name)
        data = None
        for path in (plain_name, decoded_name):
            with suppress(OSError, ValueError):
                data = files.read_bytes(self.path.parent / path, files.MAX_FILE_SIZE - self.size)
                break
        self.sources[name] = data
        return data

    def add_texture(self, data: bytes, name: str) -> str | None:
        """Keep an image file, as PNG if VRML97 cannot show its format.

        Args:
            data: The image file.
            name: Its name in the mesh file.

        Returns:
            Its name beside the .wrl; None if it cannot be read, which becomes a problem.
        """
        try:
            from PIL import Image
        except ImportError:
            self.problems.append(NO_PILLOW)
            return None
        try:
            with Image.open(io.BytesIO(data)) as image:
                if image.width * image.height > MAX_PIXELS:
                    raise ValueError(f"more than {MAX_PIXELS:,} pixels")
                image.load()
                if image.format not in IMAGE_ENDINGS:
                    return self.add_image(image, name)
                ending = IMAGE_ENDINGS[image.format]
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
            self.problems.append(f"texture '{name}' is not a readable image ({error})")
            return None
        return self._add_texture_file(data, name, ending)

    def add_image(self, image: Any, name: str) -> str:
        """Keep a decoded image (PIL) as PNG, and return its name beside the .wrl."""
        stream = io.BytesIO()
        is_png_mode = image.mode in ("1", "L", "LA", "RGB", "RGBA", "P")
        (image if is_png_mode else image.convert("RGBA")).save(stream, "PNG")
        return self._add_texture_file(stream.getvalue(), name, ".png")

    def _add_texture_file(self, data: bytes, name: str, ending: str) -> str:
        """Keep an image file under a name that its content decides.

        So equal images are one file, and unequal ones never collide.
        """
        from hashlib import sha256

        stem = re.sub(r"[^A-Za-z0-9_-]", "_", PureWindowsPath(unquote(name)).stem) or "texture"
        file_name = f"{stem[:100]}_{sha256(data).hexdigest()[:8]}{ending}"
        self.textures[file_name] = data
        return file_name


def add_part(
    mesh: Mesh, transform: NDArray[np.float64], points: Any, triangles: Any, **looks: Any
) -> None:
    """Add a part to a mesh, transformed from the frame of its node to that of the mesh.

    Args:
        mesh: The mesh.
        transform: (4, 4) transform of the node; if it mirrors, the faces are flipped back.
        points: (n, 3) or (3 n,) in the frame of the node.
        triangles: (m, 3) or (3 m,) indices into the points.
        looks: Other fields of the ``Part``.

    Raises:
        TooLargeError: The mesh has too many parts or triangles.
    """
    import numpy as np

    points = np.asarray(points).reshape(-1, 3)
    if not np.array_equal(transform, np.eye(4)):
        points = points @ transform[:3, :3].T + transform[:3, 3]
    part = Part(points, np.asarray(triangles, int).reshape(-1, 3), **looks)
    if len(mesh.parts) >= MAX_PARTS:
        raise TooLargeError(f"it has more than {MAX_PARTS:,} parts, each copy counted")
    mesh.triangle_count += len(part.triangles)
    if mesh.triangle_count > MAX_TRIANGLES:
        raise TooLargeError(f"it has more than {MAX_TRIANGLES:,} triangles, each copy counted")
    mirrors = np.linalg.det(transform[:3, :3]) < 0
    mesh.parts.append(flip_faces(part) if mirrors else part)


def flip_faces(part: Part) -> Part:
    """Return a part whose triangles face the other side, with colours and texture as before."""
    colors = part.colors
    if colors is not None and colors.ndim == 3:
        colors = colors[:, ::-1]
    return msgspec.structs.replace(
        part,
        triangles=part.triangles[:, ::-1],
        colors=colors,
        uv=None if part.uv is None else part.uv[:, ::-1],
    )


def find_distinct_rows(rows: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """Find the distinct rows of an array.

    Args:
        rows: (n, k).

    Returns:
        (m, k) the distinct rows, in the order of their first occurrence; and (n,) the index of
        each row among them.
    """
    import numpy as np

    rows = np.ascontiguousarray(rows)
    # Each row is viewed as a single value, so that rows are compared by their bytes.
    row_type = np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))
    _, first_rows, sorted_indices = np.unique(
        rows.view(row_type).ravel(), return_index=True, return_inverse=True
    )
    ranks = np.empty(len(first_rows), np.int32)
    ranks[np.argsort(first_rows)] = np.arange(len(first_rows), dtype=np.int32)
    return rows[np.sort(first_rows)], ranks[sorted_indices.ravel()]
