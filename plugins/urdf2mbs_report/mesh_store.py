"""The meshes of a page, packed for its script.

The script unpacks them in ``js/geometry.js``.  All numbers of the meshes are 32-bit words in a
single text: gzip, then base64.  Equal arrays are stored once.
"""

from __future__ import annotations

import base64
import gzip
from collections.abc import Callable
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import msgspec

from urdf2mbs.plugin import ConversionError, size
from urdf2mbs_meshes.model import Mesh, MeshError, MeshLimit, Part, find_distinct_rows
from urdf2mbs_meshes.reader import FORMATS, read_mesh
from urdf2mbs_meshes.vrml_reader import read_vrml

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: The types of images by their first bytes.
IMAGE_TYPES = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"GIF8": "image/gif"}

#: Number of steps along the longest side of a mesh to which its points are rounded.
STEPS = 65535

FileReader: TypeAlias = Callable[[str], "bytes | None"]
"""Returns a file by its url or name; None if it does not exist."""


class StoredMesh(NamedTuple):
    """A file that was read once."""

    number: int | None
    """Of its mesh; None if it cannot be drawn."""
    reason: str
    """Why it cannot be drawn, or its parts that are left out."""


class MeshStore:
    """The meshes of a page: each mesh is a list of parts.

    Attributes:
        meshes: The parts of each mesh, as the script reads them.
        textures: Images as data urls.
        missing: Meshes that cannot be drawn, and why.
        incomplete: Meshes that are drawn in part, and the parts that are left out.
    """

    def __init__(self, max_mebibytes: int = MeshLimit().mebibytes) -> None:
        """Create an empty store, for which at most this much of a URDF's mesh files is read."""
        self.meshes: list[list[dict[str, Any]]] = []
        self.textures: list[str] = []
        self.missing: dict[str, str] = {}
        self.incomplete: dict[str, str] = {}
        self._array_offsets: dict[bytes, int] = {}
        """The arrays, each with its first byte."""
        self._n_array_bytes = 0
        """Number of bytes of all arrays."""
        self._stored_meshes: dict[tuple[str, str], StoredMesh] = {}
        self._max_mebibytes = max_mebibytes
        self._bytes_left = max_mebibytes * 2**20

    def add_mbs_mesh(self, url: str, read_file: FileReader, path: Path | None = None) -> int | None:
        """Add the mesh that an .mbs shows.

        Args:
            url: The url of the mesh.
            read_file: Reads the .wrl and its textures.
            path: The file of the mesh, if it has another format than .wrl.

        Returns:
            The number of the mesh; None if it cannot be drawn.
        """
        if path is not None and path.suffix.lower() in FORMATS:
            return self.add_urdf_mesh(url, path)
        return self._add_once(url, ("wrl", url), partial(self._read_wrl, url, read_file))

    def add_urdf_mesh(self, filename: str, path: Path | None) -> int | None:
        """Add a mesh file of a URDF, drawn as RViz draws it.

        Args:
            filename: The name of the mesh in the URDF.
            path: Its file; None if it was not found.

        Returns:
            The number of the mesh; None if it cannot be drawn.
        """
        # A file may have several names.
        mesh_key = ("source", filename if path is None else str(path))
        return self._add_once(filename, mesh_key, partial(self._read_mesh_file, path))

    def pack_arrays(self) -> str:
        """Return all arrays for the script: gzip, then base64."""
        return base64.b64encode(gzip.compress(b"".join(self._array_offsets), 9, mtime=0)).decode()

    def _add_once(
        self,
        mesh_name: str,
        mesh_key: tuple[str, str],
        read_source: Callable[[], tuple[Mesh, FileReader]],
    ) -> int | None:
        """Return the number of a mesh, which is read when its key is first asked for."""
        if mesh_key not in self._stored_meshes:
            try:
                mesh, read_texture = read_source()
                packed_parts = [
                    self._pack_part(part, read_texture) for part in _join_parts(mesh.parts)
                ]
                self.meshes.append(packed_parts)
                problems = "; ".join(dict.fromkeys(mesh.problems))
                self._stored_meshes[mesh_key] = StoredMesh(len(self.meshes) - 1, problems)
            except MeshError as error:
                self._stored_meshes[mesh_key] = StoredMesh(None, str(error))
        mesh_number, reason = self._stored_meshes[mesh_key]
        if reason:
            (self.missing if mesh_number is None else self.incomplete)[mesh_name] = reason
        return mesh_number

    def _read_wrl(self, url: str, read_file: FileReader) -> tuple[Mesh, FileReader]:
        """Read a .wrl; return the mesh and a reader of its textures."""
        vrml_data = read_file(url)
        if vrml_data is None:
            raise MeshError("the .wrl is not there ('output: {project: DIR}' makes it)")
        mesh_folder = PurePosixPath(url.replace("\\", "/")).parent
        return read_vrml(vrml_data), lambda texture_name: read_file(str(mesh_folder / texture_name))

    def _read_mesh_file(self, mesh_file: Path | None) -> tuple[Mesh, FileReader]:
        """Read a mesh file of a URDF; return the mesh and a reader of its textures."""
        if mesh_file is None:
            raise MeshError("the mesh file is not there")
        if size(mesh_file) > self._bytes_left:
            raise MeshError(
                f"the files of all meshes are more than {self._max_mebibytes} MiB, "
                "'at_most' of convert-meshes"
            )
        try:
            mesh = read_mesh(mesh_file, up_axis=False)
            self._bytes_left -= mesh.size
        except ConversionError as error:
            raise MeshError(f"{error.message}; {error.hint}") from None
        return mesh, mesh.textures.get

    # --- packing ---

    def _pack_part(self, part: Part, read_texture: FileReader) -> dict[str, Any]:
        """Return a part as the script reads it; its arrays are kept."""
        import numpy as np

        # The sum with 0 turns -0 to 0, so that both are the same point.
        corners = part.points.astype(np.float32)[part.triangles].reshape(-1, 3) + np.float32(0.0)
        points, triangles = find_distinct_rows(corners)
        rounded_points = _round_points(points)
        packed_part: dict[str, Any] = {
            "low": rounded_points.lowest_corner,
            "step": rounded_points.step,
            "points": self._add_array(rounded_points.differences),
            "triangles": self._add_array(_encode_indices(triangles)),
            "color": part.material.diffuse,
            "transparency": part.material.transparency,
        }
        if part.material.texture and part.uv is not None:
            image_data = read_texture(part.material.texture) or b""
            signatures = (
                signature for signature in IMAGE_TYPES if image_data.startswith(signature)
            )
            image_type = IMAGE_TYPES.get(next(signatures, b""))
            if image_type is not None:
                texture_coordinates = part.uv.astype(np.float32).reshape(-1, 2)
                packed_part["texture"] = self._add_texture(image_data, image_type)
                packed_part["uv"] = self._add_array(texture_coordinates.view(np.uint32))
        if part.colors is not None:
            colors = np.asarray(part.colors)
            if colors.ndim == 2:  # of faces: each corner has that of its face
                colors = np.repeat(colors[:, None, :], 3, axis=1)
            if colors.shape[-1] == 4 and part.material.transparency is None:
                packed_part["transparency"] = 1.0 - float(colors[..., 3].mean()) / 255
            rgba_colors = np.full((len(corners), 4), 255, np.uint8)
            rgba_colors[:, :3] = colors[..., :3].reshape(-1, 3)
            packed_part["colors"] = self._add_array(rgba_colors.view("<u4"))
        return packed_part

    def _add_array(self, word_array: NDArray[np.uint32]) -> tuple[int, int]:
        """Keep an array of 32-bit words; return its first byte and its number of words.

        The lowest bytes of all words come first, then the next ones: in this order they pack best.
        """
        import numpy as np

        array_bytes = word_array.astype("<u4").view(np.uint8).reshape(-1, 4).T.tobytes()
        if array_bytes not in self._array_offsets:
            self._array_offsets[array_bytes] = self._n_array_bytes
            self._n_array_bytes += len(array_bytes)
        return self._array_offsets[array_bytes], word_array.size

    def _add_texture(self, image_data: bytes, image_type: str) -> int:
        """Keep an image, and return its number."""
        data_url = f"data:{image_type};base64,{base64.b64encode(image_data).decode()}"
        if data_url not in self.textures:
            self.textures.append(data_url)
        return self.textures.index(data_url)


class RoundedPoints(NamedTuple):
    """Points as multiples of a step, which pack better than floats."""

    lowest_corner: list[float]
    """Of the box around the points (m)."""
    step: float
    """The longest side of the box, divided by ``STEPS`` (m)."""
    differences: NDArray[np.uint32]
    """(3 n,) the steps from each point to the next, modulo 65536: all of x, then of y and z."""


def _round_points(points: NDArray[np.float32]) -> RoundedPoints:
    """Round (n, 3) points (m) to steps from the lowest corner of the box around them."""
    import numpy as np

    if not len(points):
        return RoundedPoints([0.0, 0.0, 0.0], 1.0, np.zeros(0, np.uint32))
    lowest_corner = points.min(axis=0).astype(float)
    step = float((points - lowest_corner).max()) / STEPS or 1.0
    multiples = np.rint((points - lowest_corner) / step).astype(np.int64)
    differences = np.diff(multiples, axis=0, prepend=0).T.ravel() & 65535
    return RoundedPoints(lowest_corner.tolist(), step, differences.astype("<u4"))


def _encode_indices(triangles: NDArray[np.int32]) -> NDArray[np.uint32]:
    """Encode the indices of corners as small numbers, which pack well.

    Each index becomes its distance from the next new index.  As points are in the order of their
    first use, a new point is 0::

        index            0 1 2 0 2 3
        next new index   0 1 2 3 3 3
        distance         0 0 0 3 1 0
    """
    import numpy as np

    indices = triangles.ravel()
    largest_so_far = np.maximum.accumulate(indices) if len(indices) else indices
    next_new = np.concatenate([[-1], largest_so_far])[: len(indices)] + 1
    return (next_new - indices).astype("<u4")


def _join_parts(parts: list[Part]) -> list[Part]:
    """Join the parts that look the same: a browser draws a few large ones faster."""
    import numpy as np

    part_groups: dict[Any, list[Part]] = {}
    for part_index, part in enumerate(parts):
        can_join = part.uv is None and part.colors is None
        part_groups.setdefault((part.material, part.smooth) if can_join else part_index, []).append(
            part
        )
    joined_parts = []
    for group in part_groups.values():
        first_points = np.cumsum([0, *(len(part.points) for part in group)])
        joined_part = msgspec.structs.replace(
            group[0],
            points=np.concatenate([part.points for part in group]),
            triangles=np.concatenate(
                [
                    part.triangles + first_point
                    for part, first_point in zip(group, first_points, strict=False)
                ]
            ),
        )
        joined_parts.append(joined_part if len(group) > 1 else group[0])
    return joined_parts
