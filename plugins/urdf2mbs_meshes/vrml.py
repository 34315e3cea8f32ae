"""Triangle meshes written as VRML97 (ISO/IEC 14772-1), the one format that MBSysPad shows.

Every part becomes a ``Shape`` with an ``IndexedFaceSet``.  VRML97 stores coordinates in single
precision, so each is written with the fewest digits that are read as the same float32.  Equal
points are written once.  There are no normals: viewers compute them, flat, or smooth below
``CREASE_ANGLE`` if the source is smooth.  Both sides of a face are drawn (``solid FALSE``), as
RViz does, since CAD meshes are seldom closed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

from urdf2mbs_meshes.model import RGB, Material, Part, find_distinct_rows

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import numpy as np
    from numpy.typing import NDArray

#: Faces that meet at less than this angle (rad) are shaded as one smooth surface.
CREASE_ANGLE = 0.5

#: Number of lines that are made at a time: their numbers take ten times the memory of their text.
LINES = 2**14


def write_vrml(parts: list[Part], color: RGB, transparency: float) -> Iterator[bytes]:
    """Write a mesh as a .wrl file.

    Args:
        parts: The parts of the mesh.
        color: The colour of parts that have none.
        transparency: The transparency of parts that have none.

    Yields:
        The file, in pieces.
    """
    yield b"#VRML V2.0 utf8\n"
    for part in parts:
        yield from _write_shape(part, color, transparency)


class Palette(NamedTuple):
    """The distinct colours of a part, and those of its corners or faces."""

    rgb: NDArray[np.float64]
    """(n, 3) 0 to 1."""
    indices: NDArray[np.int32]
    """(m, 3) the colour of each corner, or (m,) that of each face."""


def _write_shape(part: Part, color: RGB, transparency: float) -> Iterator[bytes]:
    """Write a part as a ``Shape``, in pieces."""
    import numpy as np

    is_used = np.zeros(len(part.points), bool)
    is_used[part.triangles] = True
    used_points = part.points if is_used.all() else part.points[is_used]
    # The sum with 0 turns -0 to 0, so that both are the same point.
    points, point_indices = find_distinct_rows(np.add(used_points, 0, dtype=np.float32))
    used_indices = np.cumsum(is_used, dtype=np.int32) - 1
    triangles = point_indices[used_indices[part.triangles]]
    material, palette = _merge_colors(part)

    yield b"Shape {\n" + _format_appearance(material, color, transparency)
    yield b"geometry IndexedFaceSet {\nsolid FALSE\n"
    if part.smooth:
        yield b"creaseAngle %s\n" % _format_number(CREASE_ANGLE)
    yield from _write_block(b"coord Coordinate { point [", points, _format_points, b"] }")
    yield from _write_block(b"coordIndex [", triangles, _format_faces, b"]")
    if palette is not None:
        yield from _write_palette(palette)
    if part.uv is not None and material.texture:
        corners = part.uv.reshape(-1, 2).astype(np.float32) + np.float32(0.0)
        uv, uv_indices = find_distinct_rows(corners)
        begin = b"texCoord TextureCoordinate { point ["
        yield from _write_block(begin, uv, _format_points, b"] }")
        yield from _write_block(b"texCoordIndex [", uv_indices.reshape(-1, 3), _format_faces, b"]")
    yield b"}\n}\n"


def _merge_colors(part: Part) -> tuple[Material, Palette | None]:
    """Return the material of a part, and the palette of its colours.

    VRML97 has a single transparency for a shape, so it is the mean of that of the colours.  A
    part of a single colour needs no palette, since its material can have the colour.
    """
    import numpy as np

    material = part.material
    if part.colors is None:
        return material, None
    colors = np.asarray(part.colors)
    rgba, flat_indices = find_distinct_rows(colors.reshape(-1, colors.shape[-1]))
    palette = Palette(rgba[:, :3] / 255, flat_indices.reshape(colors.shape[:-1]))
    if rgba.shape[1] == 4:
        opacity = float(rgba[:, 3][palette.indices].mean()) / 255
        material = msgspec.structs.replace(material, transparency=1.0 - opacity)
    if len(rgba) == 1:
        red, green, blue = palette.rgb[0].tolist()
        return msgspec.structs.replace(material, diffuse=(red, green, blue)), None
    return material, palette


def _write_palette(palette: Palette) -> Iterator[bytes]:
    """Write the colours of corners or faces, in pieces."""
    import numpy as np

    yield from _write_block(
        b"color Color { color [", np.round(palette.rgb, 3), _format_rows, b"] }"
    )
    if palette.indices.ndim == 1:
        yield b"colorPerVertex FALSE\n"
        yield from _write_block(b"colorIndex [", palette.indices[:, None], _format_rows, b"]")
    else:
        yield from _write_block(b"colorIndex [", palette.indices, _format_faces, b"]")


def _write_block(
    begin: bytes, rows: NDArray[Any], format_rows: Callable[[NDArray[Any]], bytes], end: bytes
) -> Iterator[bytes]:
    """Write an array between two words, in pieces of up to ``LINES`` rows."""
    yield begin + b"\n"
    for start in range(0, len(rows), LINES):
        yield format_rows(rows[start : start + LINES]) + b"\n"
    yield end + b"\n"


def _format_appearance(material: Material, color: RGB, transparency: float) -> bytes:
    """Return the ``Appearance`` of a material; see ``write_vrml`` for the colour."""
    # A texture of three colours replaces the diffuse colour, a grey one is multiplied by it.
    diffuse = (1.0, 1.0, 1.0) if material.texture else material.diffuse
    fields = [b"diffuseColor " + _format_color(color if diffuse is None else diffuse)]
    if material.emissive and any(material.emissive):
        fields.append(b"emissiveColor " + _format_color(material.emissive))
    if material.specular and any(material.specular):
        fields.append(b"specularColor " + _format_color(material.specular))
        if material.shininess is not None:
            fields.append(b"shininess " + _format_number(material.shininess))
    if material.transparency is not None:
        transparency = material.transparency
    if transparency > 0.0:
        fields.append(b"transparency " + _format_number(transparency))
    texture = b""
    if material.texture:
        texture = b"texture ImageTexture { url %s }\n" % msgspec.json.encode(material.texture)
    return b"appearance Appearance {\nmaterial Material { %s }\n%s}\n" % (
        b" ".join(fields),
        texture,
    )


def _format_color(rgb: RGB) -> bytes:
    """Return a colour as three numbers."""
    return b" ".join(_format_number(value) for value in rgb)


def _format_number(value: float) -> bytes:
    """Return a number of 0 to 1 with three decimals, enough for the 256 steps of a colour."""
    return msgspec.json.encode(round(min(max(value, 0.0), 1.0), 3)).removesuffix(b".0")


def _format_points(points: NDArray[np.float32]) -> bytes:
    """Return points, one a line, as the shortest decimals that are read as the same float32."""
    # 32 letters are needed, since numpy cuts longer text without a message: numpy 2.2 writes
    # -1e15 with 19 letters.
    return _format_rows(points.astype("S32").astype(float))


def _format_rows(rows: NDArray[Any]) -> bytes:
    """Return the rows of an array, one a line, with blanks between the numbers."""
    import numpy as np

    text = bytearray(msgspec.json.encode(rows.ravel().tolist())[1:-1])
    letters = np.frombuffer(text, np.uint8)
    commas = np.flatnonzero(letters == ord(","))
    columns = rows.shape[1]
    letters[commas] = ord(" ")
    letters[commas[columns - 1 :: columns]] = ord("\n")
    del letters  # a view keeps the text from being resized
    text += b"\n"
    return bytes(text.replace(b".0 ", b" ").replace(b".0\n", b"\n").removesuffix(b"\n"))


def _format_faces(triangles: NDArray[Any]) -> bytes:
    """Return triangles, one a line, each ended by -1."""
    return _format_rows(triangles).replace(b"\n", b" -1\n") + b" -1"
