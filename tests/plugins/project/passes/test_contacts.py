"""Contacts: where a robot touches the ground, and the law of the generated code."""

from __future__ import annotations

import re
from itertools import pairwise
from math import sin, sqrt
from pathlib import Path
from typing import Any

import pytest

from proving import SOLID, codes, joint, link, models, robot
from urdf2mbs import Result, convert
from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.spatial import Vec, dot
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_project.places import point_at

ROOT = Path(__file__).resolve().parents[4]
BIPED = ROOT / "configs" / "biped.urdf.xacro"
STANCE = {"*_hip_pitch": -0.3, "*_knee": 0.6, "*_ankle": -0.3}
HAND = {"points": {"hand": [[0, 0, 0]]}}


def touching(result: Result) -> list[tuple[float, ...]]:
    """The contact points, each in its body."""
    points = (point for body in result.mbs.bodies for point in body.points)
    return [point.coordinates for point in points if point.extforce is not None]


def heights(mbs: Mbs, up: Vec = (0.0, 0.0, 1.0)) -> list[float]:
    """How high the contact points are."""
    placement = place(mbs)
    return [
        dot(up, point_at(placement, mbs, body.name, point.name))
        for body in mbs.bodies
        for point in body.points
        if point.extforce is not None
    ]


def test_the_robot_stands_on_its_lowest_points() -> None:
    passes = {"posture": {"joints": STANCE}, "contacts": {"links": ["*_foot"]}}
    found = heights(convert(BIPED, passes=passes).mbs)
    assert len(found) == 8
    assert min(found) == pytest.approx(0.0, abs=1e-12)
    assert max(found) < 1e-9, "the feet are level in this position"


def test_a_robot_that_floats_by_its_own_joint_is_raised_once() -> None:
    """The fixed joint below the floating one is a driven T3, which must not move."""
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    robot = f"""<robot name="own"><link name="world"/><link name="root"/>
      <link name="foot"><inertial><mass value="1"/>{inertia}</inertial><collision><geometry>
        <box size="1 1 1"/></geometry></collision></link>
      <joint name="free" type="floating"><parent link="world"/><child link="root"/></joint>
      <joint name="stay" type="fixed"><parent link="root"/><child link="foot"/></joint></robot>"""
    for pipeline in ("faithful", "compact"):
        options = {"contacts": {"links": ["foot"]}}
        result = convert_text(robot, pipeline=pipeline, passes=options)
        assert result.conversion.checked.proof.same
        (body,) = result.mbs.bodies
        assert place(result.mbs).bodies[body.name].xyz[2] == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (0.0, 0.0, 9.81), (0.0, -9.81, 0.0)])
def test_up_is_against_gravity(gravity: tuple[float, float, float]) -> None:
    passes = {"contacts": {"links": ["*_foot"], "ground": 0.25}}
    x, y, z = (-c / 9.81 for c in gravity)
    found = heights(convert(BIPED, passes=passes, gravity=gravity).mbs, (x, y, z))
    assert min(found) == pytest.approx(0.25, abs=1e-12)


#: What TINY's body looks like, and by what gravity its points lie deepest.
BODY = '<geometry><box size="0.2 0.1 0.3"/>'
DOWN = (0.0, 0.0, -9.81)
#: A sole with a pointed heel, and an ankle far above it that does not count.
FOOT = "0 0 0;0.2 0.05 0;0.2 -0.05 0;-0.1 0.03 0;-0.1 -0.03 0;0 0 0.3"
#: Each quarter counts by the foot's own length and width: the toe is between two corners.
LONG = "0.2 0.01 0;0.2 -0.01 0;-0.1 0.01 0;-0.1 -0.01 0;0.23 0 0;0 0 0.3"
ROUND = '<geometry><cylinder radius="0.1" length="0.4"/>'
BRICK = '<geometry><box size="0.2 0.4 0.6"/>'
MESH = '<geometry><mesh filename="foot.obj"/>'
WIDE_MESH = MESH.replace("/>", ' scale="1 2 1"/>')
RIM = [(0.1, 0.0), (0.0, 0.1), (-0.1, 0.0), (0.0, -0.1)]
SQUARE = [(1, 1), (1, -1), (-1, -1), (-1, 1)]


def on_body(folder: Path, shape: str, corners: str = FOOT, **settings: Any) -> Result:
    """TINY with this shape on its body, whose lowest points touch; ``corners`` of its mesh."""
    at = corners.split(";")
    faces = "".join(f"f 1 2 {k}\n" for k in range(3, len(at) + 1))
    (folder / "foot.obj").write_text("".join(f"v {corner}\n" for corner in at) + faces)
    source = folder / "r.urdf"
    source.write_text(TINY.replace(BODY, shape))
    return convert(source, passes={"contacts": {"links": ["body"]}}, **settings)


@pytest.mark.parametrize(
    ("shape", "gravity", "points"),
    [
        ('<geometry><sphere radius="0.1"/>', DOWN, [(0.0, 0.0, -0.1)]),
        (ROUND, DOWN, [(*at, -0.2) for at in RIM]),
        (ROUND, (0.0, 0.6, 0.8), [(*at, 0.2) for at in RIM]),
        (ROUND, (0.48, 0.64, -0.6), [(0.06, 0.08, 0.2), (0.06, 0.08, -0.2)]),
        (f'<origin rpy="1.5707963267948966 0 0"/>{ROUND}', DOWN,
         [(0.0, -0.2, -0.1), (0.0, 0.2, -0.1)]),
        (BRICK, (0.2, -0.3, -0.9), [(0.1 * a, 0.2 * b, -0.3) for a, b in SQUARE]),
        (BRICK, (0.0, 0.0, 1.0), [(0.1 * a, 0.2 * b, 0.3) for a, b in SQUARE]),
        (BRICK, (-0.8, 0.5, 0.3), [(-0.1, 0.2 * a, 0.3 * b) for a, b in SQUARE]),
        (BRICK, (0.0, 1.0, 0.0), [(0.1 * a, 0.2, 0.3 * b) for a, b in SQUARE]),
        (WIDE_MESH, DOWN, [(0.2, 0.1, 0.0), (0.2, -0.1, 0.0), (-0.1, -0.06, 0.0),
                           (-0.1, 0.06, 0.0)]),
        (f"{MESH}{LONG}", DOWN, [(0.2, 0.01, 0.0), (0.2, -0.01, 0.0), (-0.1, -0.01, 0.0),
                                 (-0.1, 0.01, 0.0)]),
    ],
)  # fmt: skip
def test_points_of_shapes(
    tmp_path: Path, shape: str, gravity: Vec, points: list[tuple[float, ...]]
) -> None:
    """They stand in order round the face, as a polygon."""
    shape, own, _ = shape.partition(LONG)
    found = touching(on_body(tmp_path, shape, own or FOOT, gravity=gravity, base="fixed"))
    assert sorted(found) == [pytest.approx(at, abs=1e-7) for at in sorted(points)]
    if len(found) == 4 and "box" in shape:
        for one, two in pairwise([*found, found[0]]):
            assert sum(a != b for a, b in zip(one, two, strict=True)) == 1


def test_a_link_that_rolls_touches_by_its_lowest_point() -> None:
    """The point is the centre; the base stands on the rim, which the tilt brings nearer."""
    text = (
        '<robot name="r"><link name="wheel"><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
        'ixz="0" iyy="1" iyz="0" izz="1"/></inertial><collision><origin xyz="0.1 0 0" '
        'rpy="1.2 0 0"/><geometry>{}</geometry></collision></link></robot>'
    )
    cylinder, ball = '<cylinder radius="0.3" length="1"/>', '<sphere radius="0.3"/>'
    for shape, height in ((cylinder, 0.3 * sin(1.2)), (ball, 0.3)):
        passes = {"contacts": {"roll": ["wheel"]}}
        result = convert_text(text.format(shape), base="floating", passes=passes)
        (found,) = result.report.passes["contacts"]
        assert found["point"].coordinates == (0.1, 0.0, 0.0)
        assert place(result.mbs).bodies["wheel"].xyz[2] == pytest.approx(height)
    for ground, said in ((-0.3, []), (-0.4, ["0.1 m lower"]), (0.0, ["0.3 m higher"])):
        passes = {"contacts": {"roll": ["wheel"], "ground": ground}}
        result = convert_text(text.format(ball), base="floating", passes=passes)
        notes = [one.message for one in result.diagnostics if one.code == "stand"]
        assert [note[16 : note.index(",")] for note in notes] == said


WEIGHTLESS = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("stated", "options", "gravity", "law"),
    [
        # with m = 2.6 kg: speed (g d)^(1/2) / 2 with d = m g / kp; or m g / kd where it damps more
        ("<kp>1e5</kp>", {}, DOWN, {"stiffness": 1e5, "speed": 0.025}),
        ("<kp>1e5</kp><kd>1</kd>", {}, DOWN, {"stiffness": 1e5, "speed": 0.025}),
        ("<kp>1e5</kp><kd>1e4</kd>", {}, DOWN, {"stiffness": 1e5, "speed": 0.0026}),
        ("<kp>1e5</kp><kd>1e4</kd>", {"stiffness": 2e4, "speed": 0.1}, DOWN,
         {"stiffness": 2e4, "speed": 0.1}),
        ("<kp>0</kp><kd>0</kd><kd>-1</kd>", {"depth": 0.01}, DOWN,
         {"stiffness": 2600.0, "speed": 0.16}),
        ("", {"depth": 0.25}, WEIGHTLESS, {"stiffness": 1000.0, "speed": 0.1, "bristle": 0.25}),
        ("", {"stiffness": 5e4}, WEIGHTLESS, {"stiffness": 5e4, "speed": 0.1, "bristle": 0.001}),
        # the smallest friction; that of TINY's own hand is 0.9
        ("", {}, DOWN, {"friction": 0.9}),
        ("<mu1>0.4</mu1><mu1>-1</mu1><mu1>9e9</mu1>", {}, DOWN, {"friction": 0.4}),
        ("<mu1>0.4</mu1>", {"friction": 0.7}, DOWN, {"friction": 0.7}),
    ],
)  # fmt: skip
def test_the_law_is_that_of_the_config_then_of_the_urdf(
    stated: str, options: dict[str, float], gravity: Vec, law: dict[str, float]
) -> None:
    """Each number stands in a ``<gazebo>`` of its own."""
    gazebo = "".join(
        f'<gazebo reference="hand">{one}</gazebo>' for one in re.findall("<(?:.*?)</.*?>", stated)
    )
    text = TINY.replace("</robot>", f"{gazebo}</robot>")
    passes = {"contacts": {**HAND, **options}}
    found = models(convert_text(text, gravity=gravity, passes=passes).mbs)["contact"]
    assert found.items() >= law.items()
    rate = 2 * sqrt(found["bristle"] / 9.81)
    assert found["bristle_time"] == pytest.approx(rate, rel=0.05)


def test_friction_is_of_the_links_that_touch() -> None:
    feet = {"points": {"body": [[0, 0, 0]], "hand": [[0, 0, 0]]}}
    bare = TINY.replace("mu1", "mu2")
    bullet = '<link name="body"><contact><lateral_friction value="0.2"/></contact>'
    other = '<gazebo reference="arm"><mu1>0.1</mu1></gazebo></robot>'
    for text, friction in (
        (TINY.replace('<link name="body">', bullet), 0.2),
        (bare, 0.8),
        (bare.replace("</robot>", other), 0.8),
    ):
        law = models(convert_text(text, passes={"contacts": feet}).mbs)["contact"]
        assert law["friction"] == friction


def test_a_robot_without_mass_has_no_balance() -> None:
    passes = {"contacts": {"points": {"b": [[1, 0, 0]]}}}
    text = robot(link("a"), link("b"), joint("a", "b"))
    result = convert_text(text, base="floating", passes=passes)
    assert "contacts-balance" not in codes(result)
    assert models(result.mbs)["contact"]["stiffness"] == 1000.0


def test_what_no_ground_has_is_cut_and_said(tmp_path: Path) -> None:
    """TurtleBot3 states mu1 = 10000."""
    stated = "<mu1>1e4</mu1><kp>1e15</kp><kd>1e13</kd>"
    own = TINY.replace("mu1", "mu2")
    text = own.replace("</robot>", f'<gazebo reference="hand">{stated}</gazebo></robot>')
    result = convert_text(text, passes={"contacts": HAND}, output={"project": tmp_path / "p"})
    assert result.report.proof is not None
    assert result.report.proof.same
    assert models(result.mbs)["contact"]["friction"] == 100.0
    told = [said.message for said in result.diagnostics if said.code == "contacts-most"]
    numbers = [(words[1], float(words[3].rstrip(","))) for words in map(str.split, told)]
    assert numbers == [("mu1", 100.0), ("kp", 1e12), ("kd", 1e12)]


@pytest.mark.parametrize("shift", range(3))
def test_the_corners_of_a_mesh_wherever_down_is(shift: int, tmp_path: Path) -> None:
    def turned(at: tuple[float, ...]) -> tuple[float, ...]:
        return (at * 2)[shift : shift + 3]

    sole = [(0.0, 0.3, 0.1), (0.0, 0.3, -0.1), (0.0, -0.2, -0.15), (0.0, -0.2, 0.15)]
    points = [*sole, (0.0, 0.31, 0.0), (-0.5, 0.0, 0.0), (0.0, 0.0, 0.0)]
    corners = ";".join(" ".join(map(str, turned(at))) for at in points)
    x, y, z = turned((-1.0, 0.0, 0.0))
    found = touching(on_body(tmp_path, MESH, corners, gravity=(-x, -y, -z)))
    assert sorted(found) == [pytest.approx(at, abs=1e-7) for at in sorted(map(turned, sole))]


def test_a_mesh_that_cannot_be_used_is_told(tmp_path: Path) -> None:
    source = tmp_path / "r.urdf"
    options = {"contacts": {"links": ["body"]}}
    for mesh in ("none.obj", "r.urdf"):
        source.write_text(TINY.replace('<box size="0.2 0.1 0.3"/>', f'<mesh filename="{mesh}"/>'))
        with pytest.raises(ConfigError, match="no shape to take points of"):
            convert(source, passes=options)
    text = source.read_text().replace(
        "</visual>", "</visual><collision><geometry><sphere radius='1'/></geometry></collision>"
        "<collision><geometry><mesh filename='none.obj'/></geometry></collision>", 1,
    )  # fmt: skip
    source.write_text(text)
    result = convert(source, passes=options)
    assert "contacts-mesh" in codes(result)
    assert touching(result) == [(0.0, 0.0, -1.0)]


@pytest.mark.parametrize(
    ("places", "base", "gravity", "away"),
    [
        ("1 1, 1 -1, -1 0", "floating", DOWN, 0.0), ("1 1, 1 -1", "floating", DOWN, 1.0),
        ("-0.5 1, -0.5 -1", "floating", DOWN, -0.5),
        ("0.002 1, 0.002 -1", "floating", DOWN, 0.002),
        ("1 1, 1 -1", "fixed", DOWN, 0.0), ("1 1, 1 -1", "floating", WEIGHTLESS, 0.0),
        # the centre of the triangle is at 1 in x: this is more than a fifth of the way there
        ("-0.26 1, -0.26 -1, 3.52 0", "floating", DOWN, 0.0),
    ],
)  # fmt: skip
def test_a_robot_falls_whose_mass_is_not_over_the_polygon(
    places: str, base: str, gravity: Vec, away: float
) -> None:
    """Only what floats and has weight can fall; it must come nearer in x by ``away`` (m)."""
    text = robot(link("a", SOLID.replace("0.1 -0.2 0.3", "0 0 1")))
    at = [[*map(float, place.split()), 0.0] for place in places.split(", ")]
    passes = {"contacts": {"points": {"a": at}}}
    result = convert_text(text, base=base, gravity=gravity, passes=passes)
    said = [found for found in result.diagnostics if found.code == "contacts-balance"]
    assert bool(said) == bool(away)
    for found in said:
        assert f"but {abs(away):.3g} m beside them" in found.message
        assert f"it must come ({away:.3g}, 0, 0) m" in (found.hint or "")
    if base == "floating" and any(gravity):  # without a leg, it sinks in by a thousandth of a metre
        stiffness = models(result.mbs)["contact"]["stiffness"]
        assert stiffness == pytest.approx(2 * 9.81 / len(at) / 0.001, rel=0.05)


@pytest.mark.parametrize(
    ("places", "away"),
    [("0 1, 0 -1", 0.0), ("0 0", 0.0), ("0.0008 1, 0.0008 -1", 0.0008),
     ("-0.24 1, -0.24 -1, 3.48 0", 0.24)],
)  # fmt: skip
def test_a_robot_must_step_whose_mass_is_near_the_edge(places: str, away: float) -> None:
    """Less than a fifth of the way to the middle of its feet, whose corners in the air do not
    count."""
    at = [[*map(float, place.split()), 0.0] for place in places.split(", ")]
    points = {"points": {"a": [*at, [-9, 9, 0.5], [-9, -9, 0.5]]}}
    text = robot(link("a", SOLID.replace("0.1 -0.2 0.3", "0 0 1")))
    result = convert_text(text, base="floating", passes={"contacts": points})
    [said] = [found.message for found in result.diagnostics if found.code == "contacts-balance"]
    assert f"is only {away:.3g} m from the edge" in said
    assert "cannot stand without a controller that steps" in said


@pytest.mark.parametrize(("height", "count"), [(0.008, 4), (0.016, 3)])
@pytest.mark.parametrize("x", [0.0, 7.0])
def test_a_corner_counts_up_to_a_fiftieth_of_the_mesh_above_the_lowest(
    x: float, height: float, count: int, tmp_path: Path
) -> None:
    low, high = x - 0.3, x + 0.3
    corners = f"{high} 0.1 0;{high} -0.1 0;{low} -0.1 0;{low} 0.1 {height};{x} 0 0.3"
    assert len(touching(on_body(tmp_path, MESH, corners))) == count
