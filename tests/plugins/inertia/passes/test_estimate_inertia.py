"""Estimate inertia: closed forms, meshes, and nothing in silence."""

import struct
from itertools import product
from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.build import SOLID, joint, link, robot
from support.inertia import two_links
from support.oracle.multibody import Array, Inertia, lump, rotation, translation
from urdf2mbs import Result, convert
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.spatial import Sym
from urdf2mbs.states import Estimates
from urdf2mbs.testing import assert_same_robot, convert_text


def shape(tag: str, geometry: str, origin: str = "") -> str:
    return f"<{tag}>{origin}<geometry>{geometry}</geometry></{tag}>"


def estimated(*content: str, more: str = "", **options: Any) -> Result:
    """One link ``a`` with this content, and no .mbs yet."""
    return convert_text(
        robot(link("a", *content), more),
        pipeline=["expand", "estimate-inertia"],
        passes={"estimate-inertia": options or {"density": 1000}},
    )


def inertia_of(result: Result, name: str = "a") -> Inertia:
    """In link axes."""
    inertial = result.robot.links[name].inertial
    assert inertial is not None
    xx, xy, xz, yy, yz, zz = inertial.inertia
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert inertial.origin.rpy == (0.0, 0.0, 0.0)
    return Inertia(inertial.mass, np.array(inertial.origin.xyz), tensor)


def assert_near(found: Inertia, wanted: Inertia, relative: float = 1e-12) -> None:
    assert found.mass == pytest.approx(wanted.mass, rel=relative)
    size = sqrt(np.abs(wanted.tensor).max() / wanted.mass)
    np.testing.assert_allclose(found.com, wanted.com, atol=relative * size)
    np.testing.assert_allclose(found.tensor, wanted.tensor, atol=relative * size**2 * wanted.mass)


@pytest.mark.parametrize(
    ("geometry", "mass", "diagonal"),
    [
        ('<box size="0.2 0.3 0.5"/>', 30.0, (0.34 / 12, 0.29 / 12, 0.13 / 12)),
        (
            '<cylinder radius="0.1" length="0.4"/>',
            4 * pi,
            (0.01 / 4 + 0.16 / 12, 0.01 / 4 + 0.16 / 12, 0.01 / 2),
        ),
        ('<sphere radius="0.1"/>', 4 / 3 * pi, (0.004, 0.004, 0.004)),
    ],
)
@pytest.mark.parametrize("tag", ["collision", "visual"])
def test_primitives_by_their_formulas(
    geometry: str, mass: float, diagonal: tuple[float, ...], tag: str
) -> None:
    wanted = Inertia(mass, np.zeros(3), mass * np.diag(diagonal))
    assert_near(inertia_of(estimated(shape(tag, geometry))), wanted, 1e-14)


def test_a_capsule_by_integration() -> None:
    """Against slices across its axis, of which each is a disk; the length is between the ends."""
    radius, length, n = 0.1, 0.4, 200_000
    z = (np.arange(n) + 0.5) / n * (length + 2 * radius) - length / 2 - radius
    beyond = np.maximum(np.abs(z) - length / 2, 0.0)
    squared = radius**2 - beyond**2
    step = (length + 2 * radius) / n
    mass = 1000 * pi * squared.sum() * step
    along = 1000 * pi * (squared**2 / 2).sum() * step
    across = 1000 * pi * (squared**2 / 4 + squared * z**2).sum() * step
    capsule = f'<capsule radius="{radius}" length="{length}"/>'
    found = inertia_of(estimated(shape("collision", capsule)))
    assert_near(found, Inertia(mass, np.zeros(3), np.diag((across, across, along))), 1e-9)


def test_several_shapes_where_their_origins_are() -> None:
    origin = '<origin xyz="0.1 -0.2 0.3" rpy="0.3 0.2 0.1"/>'
    found = inertia_of(
        estimated(
            shape("collision", '<box size="0.2 0.3 0.5"/>', origin),
            shape("collision", '<sphere radius="0.1"/>'),
        )
    )
    pose = translation((0.1, -0.2, 0.3))
    pose[:3, :3] = rotation((0, 0, 1), 0.1) @ rotation((0, 1, 0), 0.2) @ rotation((1, 0, 0), 0.3)
    box = Inertia(30.0, np.zeros(3), 30 * np.diag((0.34 / 12, 0.29 / 12, 0.13 / 12)))
    ball = Inertia(4 / 3 * pi, np.zeros(3), 4 / 3 * pi * 0.004 * np.eye(3))
    assert_near(found, lump([box.seen_from(pose), ball]))


def test_collision_geometry_comes_first() -> None:
    visual, collision = (
        shape("visual", '<box size="1 1 1"/>'),
        shape("collision", '<box size="1 1 2"/>'),
    )
    both, seen = estimated(visual, collision), estimated(visual)
    assert inertia_of(both).mass == pytest.approx(2000)
    assert both.report.passes["estimate-inertia"]["links"]["a"]["from"] == "collision geometry"
    assert inertia_of(seen).mass == pytest.approx(1000)
    assert seen.report.passes["estimate-inertia"]["links"]["a"]["from"] == "visual geometry"


def test_what_has_an_inertia_keeps_it_and_what_has_no_shape_gets_none() -> None:
    box = shape("collision", '<box size="1 1 1"/>')
    more = link("b") + joint("a", "b") + link("c", box) + joint("a", "c")
    result = estimated(SOLID, box, more=more)
    assert result.robot.links["a"].inertial.mass == 2.0
    assert result.robot.links["b"].inertial is None
    assert inertia_of(result, "c").mass == pytest.approx(1000)
    assert list(result.report.passes["estimate-inertia"]["links"]) == ["c"]
    assert result.conversion.state(Estimates).links == ["c"]


def test_a_total_mass_is_shared_out_by_volume() -> None:
    small, large = (shape("collision", f'<box size="1 1 {size}"/>') for size in (1, 3))
    more = link("b", large) + joint("a", "b") + link("c", SOLID) + joint("a", "c")
    result = estimated(small, more=more, total_mass=10)
    assert [result.robot.links[name].inertial.mass for name in "abc"] == pytest.approx([2, 6, 2])
    assert result.report.passes["estimate-inertia"]["density"] == pytest.approx(2.0)


@pytest.mark.parametrize("total", [1.5, 2.0])
def test_a_total_mass_is_more_than_what_the_links_have(total: float) -> None:
    box = shape("collision", '<box size="1 1 1"/>')
    with pytest.raises(ConfigError, match="that have a mass already weigh 4 kg") as refused:
        estimated(
            SOLID,
            more=link("b", SOLID) + joint("a", "b") + link("c", box) + joint("a", "c"),
            total_mass=2 * total,
        )
    assert refused.value.code == "estimate-inertia"


# -- meshes -----------------------------------------------------------------------------------


def box_triangles(size: tuple[float, float, float], at: tuple[float, float, float]) -> Array:
    """(12, 3, 3), outward by the right-hand rule."""
    found = []
    for axis, side in product(range(3), (-0.5, 0.5)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        square = np.full((4, 3), side)
        square[:, u], square[:, v] = (-0.5, 0.5, 0.5, -0.5), (-0.5, -0.5, 0.5, 0.5)
        if side < 0:
            square = square[::-1]
        found += [square[[0, 1, 2]], square[[0, 2, 3]]]
    return np.array(found) * size + at


def stl(path: Path, triangles: Array) -> Path:
    data = b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in triangles)
    path.write_bytes(bytes(80) + struct.pack("<I", len(triangles)) + data)
    return path


def of_mesh(folder: Path, triangles: Array, scale: str = "1 1 1") -> tuple[Inertia, str]:
    stl(folder / "part.stl", triangles)
    source = folder / "robot.urdf"
    mesh = f'<mesh filename="part.stl" scale="{scale}"/>'
    source.write_text(robot(link("a", shape("collision", mesh))))
    result = convert(
        source,
        pipeline=["expand", "estimate-inertia"],
        passes={"estimate-inertia": {"density": 1000}},
    )
    return inertia_of(result), result.report.passes["estimate-inertia"]["links"]["a"]["from"]


#: 1000 kg/m^3, 0.2 x 0.3 x 0.5 m; STL holds single precision.
BOX = Inertia(30.0, np.array((0.5, -0.25, 1.0)), 30 * np.diag((0.34 / 12, 0.29 / 12, 0.13 / 12)))
SINGLE = 1e-6
CUBOID = box_triangles((0.2, 0.3, 0.5), (0.5, -0.25, 1.0))
CUBE = Inertia(1000.0, np.array((3.0, 0.0, 0.0)), 1000 / 6 * np.eye(3))


@pytest.mark.parametrize(
    ("triangles", "wanted", "near", "hull"),
    [
        (CUBOID, BOX, SINGLE, False),
        (CUBOID[:, ::-1], BOX, SINGLE, False),  # inside out
        (np.concatenate((CUBOID, CUBOID[:1, [0, 1, 1]])), BOX, SINGLE, False),  # a flat face
        (
            np.concatenate((CUBOID, box_triangles((1, 1, 1), (3, 0, 0)))),
            lump([BOX, CUBE]),
            SINGLE,
            False,
        ),
        (CUBOID[:-1], BOX, SINGLE, True),  # a hole
    ],
    ids=["box", "inside-out", "flat-face", "two", "hole"],
)
def test_the_inertia_of_a_mesh_is_that_of_its_solid_or_hull(
    triangles: Array, wanted: Inertia, near: float, hull: bool, tmp_path: Path
) -> None:
    found, means = of_mesh(tmp_path, triangles)
    assert_near(found, wanted, near)
    assert means == ("convex hull of part.stl" if hull else "collision geometry")


@pytest.mark.parametrize("scale", ["0.001 0.001 0.001", "2 1 1", "-1 1 1", "-1 -1 -1", "1 -2 -0.5"])
def test_a_mesh_is_scaled_and_mirrored(tmp_path: Path, scale: str) -> None:
    factor = np.array([float(word) for word in scale.split()])
    found, _ = of_mesh(tmp_path, CUBOID, scale)
    x, y, z = np.array((0.2, 0.3, 0.5)) * np.abs(factor)
    mass = 1000 * x * y * z
    tensor = mass / 12 * np.diag((y * y + z * z, x * x + z * z, x * x + y * y))
    assert_near(found, Inertia(mass, BOX.com * factor, tensor), SINGLE)


def estimate_in(folder: Path, *elements: str) -> Result:
    """Estimate the inertias of a robot whose meshes are in a folder."""
    source = folder / "robot.urdf"
    source.write_text(robot(*elements))
    return convert(
        source,
        pipeline=["expand", "estimate-inertia"],
        passes={"estimate-inertia": {"density": 1000}},
    )


BOX_SHAPE = shape("collision", '<box size="1 1 1"/>', '<origin xyz="0 0 2"/>')
BOX_INERTIA = Inertia(1000.0, np.array((0.0, 0.0, 2.0)), 1000 / 6 * np.eye(3))
MESH_SHAPE = shape("collision", '<mesh filename="part.stl"/>')


@pytest.mark.parametrize("faces", [slice(None), slice(8, 10), slice(0, 2)])
def test_a_flat_mesh_gives_no_inertia(tmp_path: Path, faces: slice) -> None:
    """Closed, open, and nothing but edges."""
    stl(tmp_path / "part.stl", box_triangles((1, 1, 0), (0, 0, 0))[faces])
    result = estimate_in(tmp_path, link("a", MESH_SHAPE))
    assert result.robot.links["a"].inertial is None
    warnings = [
        diagnostic.code for diagnostic in result.diagnostics if diagnostic.level == "warning"
    ]
    assert warnings == ["nothing-estimated"]


@pytest.mark.parametrize("content", [None, b"not a mesh"])
@pytest.mark.parametrize("mesh_is_first", [False, True])
def test_a_mesh_without_volume_is_skipped(
    tmp_path: Path, content: bytes | None, mesh_is_first: bool
) -> None:
    """Beside a box the box remains; a link with the mesh alone gets no inertia."""
    if content is not None:
        (tmp_path / "part.stl").write_bytes(content)
    shapes = [MESH_SHAPE, BOX_SHAPE] if mesh_is_first else [BOX_SHAPE, MESH_SHAPE]
    result = estimate_in(tmp_path, link("a", *shapes), link("b", MESH_SHAPE), joint("a", "b"))
    assert_near(inertia_of(result), BOX_INERTIA)
    assert result.robot.links["b"].inertial is None
    links = result.report.passes["estimate-inertia"]["links"]
    assert {name: entry["from"] for name, entry in links.items()} == {
        "a": "collision geometry, without part.stl"
    }
    partial, empty = [
        diagnostic for diagnostic in result.diagnostics if diagnostic.code == "inertia-partial"
    ]
    assert partial.message == (
        "1 inertia estimated without meshes that are missing, unreadable or flat: "
        "link 'a' without 'part.stl'"
    )
    assert empty.message == (
        "1 link got no inertia, as meshes are missing, unreadable or flat: link 'b' ('part.stl')"
    )
    assert [(d.level, d.link) for d in (partial, empty)] == [("warning", "a"), ("warning", "b")]


def test_visuals_take_the_place_of_collisions_without_volume(tmp_path: Path) -> None:
    visual = shape("visual", '<box size="1 1 1"/>', '<origin xyz="0 0 2"/>')
    result = estimate_in(tmp_path, link("a", MESH_SHAPE, visual))
    assert_near(inertia_of(result), BOX_INERTIA)
    links = result.report.passes["estimate-inertia"]["links"]
    assert links["a"]["from"] == "visual geometry, without part.stl"


def test_nothing_to_estimate_is_told() -> None:
    result = estimated(SOLID, more=link("b") + joint("a", "b"))
    assert [
        diagnostic.code for diagnostic in result.diagnostics if diagnostic.level == "warning"
    ] == ["nothing-estimated"]
    assert result.report.passes["estimate-inertia"] == {"links": {}}


@pytest.mark.parametrize("pipeline", ["faithful", "compact"])
@pytest.mark.parametrize(
    ("mass", "values", "wanted", "said"),
    [
        # J = diag(1.5, 1.5, -0.5): the last becomes zero
        ("1", (1, 0, 0, 1, 0, 3), (1.5, 0, 0, 1.5, 0, 3), "by 0.5 kg m^2 (22.9 %)"),
        ("1", (-1, 0, 0, 1, 0, 1), (0, 0, 0, 1.5, 0, 1.5), "by 0.707 kg m^2 (42.6 %)"),
        ("-1", (1, 0, 0, 1, 0, 1), (1, 0, 0, 1, 0, 1), "from -1 kg to 0"),
    ],
)
def test_an_impossible_inertia_is_repaired_if_asked_for(
    pipeline: str, mass: str, values: Any, wanted: Sym, said: str
) -> None:
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    text = two_links(mass, " ".join(f'{n}="{v}"' for n, v in zip(names, values, strict=True)))
    kept = convert_text(text, pipeline=pipeline, base="floating")
    assert_same_robot(kept)
    (warned,) = [diagnostic for diagnostic in kept.diagnostics if diagnostic.level == "warning"]
    assert "estimate-inertia: {repair: true}" in (warned.hint or "")

    result = convert_text(text, pipeline=pipeline, passes={"estimate-inertia": {"repair": True}})
    assert_same_robot(result)
    inertial = result.robot.links["b"].inertial
    assert inertial is not None
    assert inertial.inertia == pytest.approx(wanted, abs=1e-14)
    codes = [diagnostic.code for diagnostic in result.diagnostics if diagnostic.level == "warning"]
    assert codes[0] == "inertia-repaired"
    assert warned.code not in codes  # a hint never recommends what is set
    assert said in next(
        diagnostic.message
        for diagnostic in result.diagnostics
        if diagnostic.code == "inertia-repaired"
    )
    assert result.report.passes["inertia-repair"]["b"]["inertia"][0] == tuple(map(float, values))


def test_an_estimated_mass_does_not_set_an_arm_free() -> None:
    """The root of a robot without masses is the foot of an arm, before and after the estimate."""
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    text = robot(link("a", box), link("b", box), joint("a", "b"))
    for options, code in (({}, "base"), ({"total_mass": 3.0}, "base-guessed")):
        result = convert_text(text, passes={"estimate-inertia": options})
        assert result.report.base_reason == "massless root"
        assert result.report.base_in_words.startswith("fixed base: root link 'a' has no mass")
        assert code in [diagnostic.code for diagnostic in result.diagnostics]


def test_a_robot_without_mass_is_sent_here_only_where_that_helps() -> None:
    """It has shapes, and nothing is estimated yet: of a flat shape there is no mass."""
    ball, flat = '<sphere radius="1"/>', '<box size="1 1 0"/>'
    for geometry, options, expected in (
        (ball, {}, [True]),
        (ball, {"density": 1000.0}, []),
        (flat, {"density": 1000.0}, [False]),
    ):
        text = robot(link("a", shape("visual", geometry)))
        found = convert_text(text, passes={"estimate-inertia": options}).diagnostics
        hints = [one.hint or "" for one in found if one.code == "no-mass"]
        assert ["estimate-inertia" in hint for hint in hints] == expected
