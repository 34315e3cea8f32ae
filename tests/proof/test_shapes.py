"""A shape that is elsewhere in the .mbs is named in the verdict, and no other robot."""

from collections.abc import Callable
from math import pi
from pathlib import Path

import msgspec
import pytest

from support.build import SOLID, joint, link, robot
from support.presets import PRESETS
from urdf2mbs import verify
from urdf2mbs.mbs.model import Mbs, Shape
from urdf2mbs.mbs.writer import write
from urdf2mbs.passes import convert_visuals
from urdf2mbs.spatial import IDENTITY
from urdf2mbs.testing import convert_text


def visual(geometry: str) -> str:
    origin = '<origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/>'
    return f"<visual>{origin}<geometry>{geometry}</geometry></visual>"


SHAPES = {
    "of_box": '<box size="0.1 0.2 0.3"/>',
    "of_cube": '<box size="0.2 0.2 0.2"/>',
    "of_cylinder": '<cylinder radius="0.1" length="0.5"/>',
    "of_sphere": '<sphere radius="0.1"/>',
    "of_mesh": '<mesh filename="a.stl" scale="1 -2 1"/>',
}
ROBOT = robot(
    link("base", SOLID, visual('<cylinder radius="0.2" length="0.1"/>')),
    *(link(name, SOLID, visual(geometry)) for name, geometry in SHAPES.items()),
    *(joint("base", name, axis="1 2 3") for name in SHAPES),
)


@pytest.mark.parametrize("pipeline", PRESETS)
def test_shapes_are_where_the_visuals_are(pipeline: str) -> None:
    proof = convert_text(ROBOT, pipeline=pipeline).conversion.checked.proof
    assert proof is not None
    assert proof.describe() == "the same robot"


@pytest.mark.parametrize("pipeline", PRESETS)
def test_a_capsule_is_three_shapes(pipeline: str, tmp_path: Path) -> None:
    """All three are compared: a sphere that is missing is named."""
    text = robot(
        link("base", SOLID),
        link("rod", SOLID, visual('<capsule radius="0.1" length="0.5"/>')),
        joint("base", "rod", axis="1 2 3"),
    )
    result = convert_text(text, pipeline=pipeline)
    assert result.report.proof.describe() == "the same robot"
    mbs = result.mbs
    next(body for body in mbs.bodies if body.name == "rod").shapes.pop()
    source, drawn = tmp_path / "rod.urdf", tmp_path / "rod.mbs"
    source.write_text(text)
    drawn.write_bytes(write(mbs))
    verdict = verify(source, drawn)
    assert verdict.same
    assert "visual of link 'rod' shifted by 0.5 m" in verdict.describe()


def test_cylinders_that_a_pass_rotates_wrongly_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(convert_visuals, "Y_ONTO_Z", IDENTITY)
    proof = convert_text(ROBOT).conversion.checked.proof
    assert proof is not None
    assert proof.same
    assert proof.describe() == (
        "the same robot, but for visual of link 'base' rotated by 1.57 rad, "
        "visual of link 'of_cylinder' rotated by 1.57 rad (a shape has no mass)"
    )


def shape_of(mbs: Mbs, link: str) -> Shape:
    (shape,) = next(body for body in mbs.bodies if body.name == link).shapes
    return shape


def turned(axis: int, amount: float) -> Callable[[Shape], None]:
    """Rotate a shape, which has no rotation yet, about one of its axes."""

    def turn(shape: Shape) -> None:
        shape.rotation = tuple(amount * (k == axis) for k in (1, 2, 3))  # type: ignore[assignment]

    return turn


def resized(size: tuple[float, float, float]) -> Callable[[Shape], None]:
    def resize(shape: Shape) -> None:
        shape.size = size
        turned(3, pi / 2)(shape)

    return resize


def shifted(shape: Shape) -> None:
    x, y, z = shape.position
    shape.position = (x, y + 0.25, z)


@pytest.mark.parametrize(
    ("link", "edit", "words"),
    [
        ("of_sphere", turned(1, 1.0), ""),
        ("of_sphere", shifted, "visual of link 'of_sphere' shifted by 0.25 m"),
        ("of_cylinder", turned(1, -pi / 2), ""),  # the other end up
        ("of_cylinder", turned(1, 0.0), "visual of link 'of_cylinder' rotated by 1.57 rad"),
        ("of_box", turned(2, pi), ""),
        ("of_box", resized((0.2, 0.1, 0.3)), ""),
        ("of_box", turned(3, pi / 2), "visual of link 'of_box' rotated by 1.57 rad"),
        ("of_cube", turned(3, pi / 2), ""),
        ("of_cube", turned(3, pi / 4), "visual of link 'of_cube' rotated by 0.785 rad"),
        ("of_mesh", turned(1, pi), "visual of link 'of_mesh' rotated by 3.14 rad"),
        ("of_mesh", shifted, "visual of link 'of_mesh' shifted by 0.25 m"),
    ],
)
def test_an_edited_shape(
    link: str, edit: Callable[[Shape], None], words: str, tmp_path: Path
) -> None:
    text = ROBOT.replace(' rpy="0.4 -0.5 0.6"', "")
    (tmp_path / "r.urdf").write_text(text)
    mbs = convert_text(text).mbs
    edit(shape_of(mbs, link))
    (tmp_path / "r.mbs").write_bytes(write(mbs))
    verdict = verify(tmp_path / "r.urdf", tmp_path / "r.mbs")
    assert verdict.same
    assert verdict.but_for == ({words: "a shape has no mass"} if words else {})
    assert verdict.not_compared == {}
    assert (words in verdict.verdict) or not words


def test_visuals_that_the_mbs_does_not_have_are_not_compared(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(ROBOT)
    mbs = convert_text(ROBOT).mbs
    shape_of(mbs, "of_box").size = (1.0, 1.0, 1.0)
    shape_of(mbs, "of_sphere").kind = "cone"
    mbs.bodies[-1].shapes = []  # that of the mesh
    mbs.base.shapes = [Shape("box", "more", size=(1.0, 1.0, 1.0))]
    (tmp_path / "r.mbs").write_bytes(write(mbs))
    verdict = verify(tmp_path / "r.urdf", tmp_path / "r.mbs")
    assert verdict.same
    assert verdict.but_for == {}
    why = "the .mbs has no shape of their kind and size there"
    names = ("of_box", "of_sphere", "of_mesh")
    assert verdict.not_compared == {f"visuals of link '{name}'": why for name in names}
    assert verdict.verdict.startswith("the same robot; not compared: visuals of link 'of_box', ")
    assert msgspec.to_builtins(verdict)["not_compared"] == verdict.not_compared
