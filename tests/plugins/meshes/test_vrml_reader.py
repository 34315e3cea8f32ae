"""VRML97: what the reader makes of a file, of a broken one, and of one that we wrote."""

import numpy as np
import pytest

from support.meshes.wrl import HEAD, SQUARE, of
from urdf2mbs_meshes.model import MeshError, Part
from urdf2mbs_meshes.vrml_reader import read_vrml


def read(text: bytes) -> list[Part]:
    return read_vrml(text).parts


def test_polygons_become_fans() -> None:
    (part,) = read(of(SQUARE))
    assert part.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 2, 3]]
    assert part.points[2].tolist() == [1, 1, 0]


def test_a_last_face_needs_no_end() -> None:
    (part,) = read(of(SQUARE.removesuffix(b"-1]") + b"]"))
    assert len(part.triangles) == 3


def test_material_and_texture_are_read() -> None:
    look = (
        b"material Material { diffuseColor 1 .5 0 transparency .25 } "
        b'texture ImageTexture { url ["a \\"b\\".png"] }'
    )
    (part,) = read(
        of(SQUARE + b" texCoord TextureCoordinate { point [0 0 1 0 1 1 0 1] } creaseAngle .5", look)
    )
    assert part.material.diffuse == (1, 0.5, 0)
    assert part.material.transparency == 0.25
    assert part.material.texture == 'a "b".png'
    assert part.smooth
    assert part.uv is not None
    assert part.uv[1].tolist() == [[0, 0], [1, 1], [0, 1]]


def test_colours_by_face_and_by_corner() -> None:
    palette = b" color Color { color [1 0 0 0 0 1] } "
    (faces,) = read(of(SQUARE + palette + b"colorPerVertex FALSE colorIndex [1 0]"))
    assert faces.colors is not None
    assert faces.colors.tolist() == [[0, 0, 255], [0, 0, 255], [255, 0, 0]]
    (corners,) = read(of(SQUARE + palette + b"colorIndex [0 0 1 1 -1 0 1 1 -1]"))
    assert corners.colors is not None
    assert corners.colors[2].tolist() == [[255, 0, 0], [0, 0, 255], [0, 0, 255]]


def test_transforms_names_and_comments() -> None:
    text = (
        HEAD
        + b"""# a comment with { and "
    DEF A Transform { translation 1 2 3 rotation 0 0 1 1.5707963267948966 scale 2 2 2
      children [ # nested
        DEF S Shape { geometry IndexedFaceSet { %s } } Group { children USE S }
        Transform { translation 5 0 0 children [ USE S ] } ] }
    """
        % SQUARE
    )
    parts = read(text)
    places = [part.points[1] for part in parts]
    np.testing.assert_allclose(places, [[1, 4, 3], [1, 4, 3], [1, 14, 3]], atol=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"solid x\n",
        HEAD,
        HEAD + b"Shape { geometry IndexedLineSet { coordIndex [0 1 -1] } }",
        of(SQUARE)[:-20],
        of(SQUARE.replace(b"0 2 3", b"0 2 9")),
        of(SQUARE.replace(b"1 1 0", b"1 x 0")),
        HEAD + b"Shape { geometry USE nobody }",
        HEAD + b"Group { children [ " * 5000,
        of(SQUARE) + b"PROTO Bolt [ field SFFloat long 1 ] { Shape { } }",
        of(SQUARE) + b"ROUTE Clock.fraction_changed TO Mover.set_fraction",
        of(SQUARE) + b'Script { url "javascript: f() {}" eventIn SFTime start directOutput TRUE }',
        of(SQUARE) + b"Switch { whichChoice [ }",
    ],
)
def test_what_is_no_vrml_is_an_error(text: bytes) -> None:
    with pytest.raises(MeshError):
        read(text)


def test_a_comment_may_end_the_file() -> None:
    for end in (b"# sealed by x: sha256 12 } {\n", b"# no line end"):
        assert len(read(of(SQUARE) + end)) == 1


def test_a_transform_about_a_centre() -> None:
    text = (
        HEAD
        + b"""Transform { center 1 0 0 rotation 0 0 1 3.141592653589793
      scale 2 1 1 scaleOrientation 0 0 1 1.5707963267948966
      children Shape { geometry IndexedFaceSet { %s } } }"""
        % SQUARE
    )
    (part,) = read(text)
    # from the centre, y is doubled (x of the scale's own axes), then all is turned by 180 degrees
    np.testing.assert_allclose(part.points[2], [1, -2, 0], atol=1e-12)
    np.testing.assert_allclose(part.points[0], [2, 0, 0], atol=1e-12)


def test_what_draws_nothing_is_passed_and_what_is_left_out_is_named() -> None:
    shape = b"Shape { geometry IndexedFaceSet { %s } }" % SQUARE
    text = (
        HEAD
        + b"""DEF Clock TimeSensor { cycleInterval 2 } NavigationInfo { type ["WALK"] }
      %s Shape { geometry IndexedLineSet { coordIndex [0 1 -1] } }
      Inline { url "more.wrl" } Group { children Shape { geometry Box { size 1 2 3 } } }
      LOD { level [ %s ] }
    """
        % (shape, shape)
    )
    mesh = read_vrml(text)
    assert len(mesh.parts) == 1
    assert mesh.problems == [f"its {kind} is not drawn" for kind in ("Inline", "Box", "LOD")]


def test_a_byte_order_mark_is_read_over() -> None:
    assert len(read(b"\xef\xbb\xbf" + of(SQUARE))) == 1


def test_copies_of_copies_are_bounded() -> None:
    nested = b"DEF A0 Group { children [] } "
    for n in range(1, 40):
        nested += b"DEF A%d Group { children [USE A%d USE A%d] } " % (n, n - 1, n - 1)
    with pytest.raises(MeshError, match="each copy counted"):
        read(HEAD + nested)
