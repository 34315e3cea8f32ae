"""Triangle meshes written as VRML97 (ISO/IEC 14772-1), the one format that MBSysPad shows.

Every part becomes one ``Shape`` with an ``IndexedFaceSet``.  VRML97 stores coordinates in
single precision, so each is written in the fewest digits that give its float32 back.  Equal
points are written once.  There are no normals: viewers make them, flat, or smooth below
``CREASE_ANGLE`` where the source is smooth.  Both sides of a face are drawn (``solid FALSE``),
as RViz does, for CAD meshes are seldom closed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from urdf2mbs_meshes.model import RGB, Material, Part, distinct

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import numpy as np
    from numpy.typing import NDArray

#: Faces that meet at less than this angle (rad) are shaded as one smooth surface.
CREASE_ANGLE = 0.5


#: So many lines are made at a time: their numbers take ten times the memory of their text.
LINES = 2**14


def write(parts: list[Part], color: RGB, transparency: float) -> Iterator[bytes]:
    """A .wrl, piece by piece; ``color`` and ``transparency`` are for the parts that have none of
    their own."""
    yield b"#VRML V2.0 utf8\n"
    for part in parts:
        yield from _shape(part, color, transparency)


def _shape(part: Part, color: RGB, transparency: float) -> Iterator[bytes]:
    import numpy as np

    shown = np.zeros(len(part.points), bool)
    shown[part.triangles] = True
    points = part.points if shown.all() else part.points[shown]
    points, which = distinct(np.add(points, 0, dtype=np.float32))  # which makes 0 of -0
    triangles = which[(np.cumsum(shown, dtype=np.int32) - 1)[part.triangles]]
    material, colors = part.material, part.colors
    palette = None
    if colors is not None:
        colors = np.asarray(colors)
        palette, chosen = distinct(colors.reshape(-1, colors.shape[-1]))
        chosen = chosen.reshape(colors.shape[:-1])
        rgb = palette[:, :3] / 255
        if palette.shape[1] == 4:
            alpha = float(palette[:, 3][chosen].mean()) / 255
            material = msgspec.structs.replace(material, transparency=1.0 - alpha)
        if len(palette) == 1:
            r, g, b = rgb[0].tolist()
            material = msgspec.structs.replace(material, diffuse=(r, g, b))
            palette = None
    yield b"Shape {\n" + _appearance(material, color, transparency)
    yield b"geometry IndexedFaceSet {\nsolid FALSE\n"
    if part.smooth:
        yield b"creaseAngle %s\n" % _number(CREASE_ANGLE)
    yield from _block(b"coord Coordinate { point [", points, _points, b"] }")
    yield from _block(b"coordIndex [", triangles, _faces, b"]")
    if palette is not None:
        yield from _block(b"color Color { color [", np.round(rgb, 3), _rows, b"] }")
        if chosen.ndim == 1:
            yield b"colorPerVertex FALSE\n"
            yield from _block(b"colorIndex [", chosen[:, None], _rows, b"]")
        else:
            yield from _block(b"colorIndex [", chosen, _faces, b"]")
    if part.uv is not None and material.texture:
        uv, index = distinct(part.uv.reshape(-1, 2).astype(np.float32) + np.float32(0.0))
        yield from _block(b"texCoord TextureCoordinate { point [", uv, _points, b"] }")
        yield from _block(b"texCoordIndex [", index.reshape(-1, 3), _faces, b"]")
    yield b"}\n}\n"


def _block(
    begin: bytes, numbers: NDArray[Any], text: Callable[[NDArray[Any]], bytes], end: bytes
) -> Iterator[bytes]:
    """An array as text: ``begin``, the rows, ``end``; ``text`` writes up to ``LINES`` rows."""
    yield begin + b"\n"
    for at in range(0, len(numbers), LINES):
        yield text(numbers[at : at + LINES]) + b"\n"
    yield end + b"\n"


def _appearance(material: Material, color: RGB, transparency: float) -> bytes:
    # a texture of three colours replaces the diffuse colour, one of grey values multiplies it
    own = (1.0, 1.0, 1.0) if material.texture else material.diffuse
    fields = [b"diffuseColor " + _color(color if own is None else own)]
    if material.emissive and any(material.emissive):
        fields.append(b"emissiveColor " + _color(material.emissive))
    if material.specular and any(material.specular):
        fields.append(b"specularColor " + _color(material.specular))
        if material.shininess is not None:
            fields.append(b"shininess " + _number(material.shininess))
    clear = transparency if material.transparency is None else material.transparency
    if clear > 0.0:
        fields.append(b"transparency " + _number(clear))
    texture = b""
    if material.texture:
        texture = b"texture ImageTexture { url %s }\n" % msgspec.json.encode(material.texture)
    return b"appearance Appearance {\nmaterial Material { %s }\n%s}\n" % (
        b" ".join(fields),
        texture,
    )


def _color(rgb: RGB) -> bytes:
    return b" ".join(_number(c) for c in rgb)


def _number(value: float) -> bytes:
    """A number of 0 to 1 with three decimals, which tell 256 steps of a colour apart."""
    return msgspec.json.encode(round(min(max(value, 0.0), 1.0), 3)).removesuffix(b".0")


def _points(points: NDArray[np.float32]) -> bytes:
    """A line a point; a number as text is the shortest decimal that is read as that float32."""
    # numpy cuts longer text in silence: numpy 2.2 writes -1e15 with 19 letters.
    return _rows(points.astype("S32").astype(float))


def _rows(numbers: NDArray[Any]) -> bytes:
    """A line a row, blanks between the numbers."""
    import numpy as np

    text = bytearray(msgspec.json.encode(numbers.ravel().tolist())[1:-1])
    letters = np.frombuffer(text, np.uint8)
    commas = np.flatnonzero(letters == ord(","))
    letters[commas] = ord(" ")
    letters[commas[numbers.shape[1] - 1 :: numbers.shape[1]]] = ord("\n")
    del letters  # which holds the text
    text += b"\n"
    return bytes(text.replace(b".0 ", b" ").replace(b".0\n", b"\n").removesuffix(b"\n"))


def _faces(triangles: NDArray[Any]) -> bytes:
    """A line a face, each ended by -1."""
    return _rows(triangles).replace(b"\n", b" -1\n") + b" -1"
