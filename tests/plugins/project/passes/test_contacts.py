"""Contacts: where a robot touches the ground, and the law of the generated code."""

import re
from math import cos, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.build import SOLID, joint, link, robot
from support.folders import ROOT
from support.proving import codes, models
from urdf2mbs import Result, convert
from urdf2mbs.mbs.kinematics import compute_placement
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.spatial import Vec, dot
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_project.simulation import Contact, Simulation, Spot

BIPED = ROOT / "configs" / "biped.urdf.xacro"
STANCE = {"*_hip_pitch": -0.3, "*_knee": 0.6, "*_ankle": -0.3}
HAND = {"points": {"hand": [[0, 0, 0]]}}


def contacts(result: Result) -> list[Contact]:
    return result.conversion.state(Simulation).contacts


def points(result: Result) -> list[tuple[float, ...]]:
    """Return the points that touch, each in its body, without spheres and rims."""
    return [
        spot.centre for contact in contacts(result) for spot in contact.spots if not spot.radius
    ]


def heights(result: Result, up: Vec = (0.0, 0.0, 1.0)) -> list[float]:
    """How high the places are on which the robot stands."""
    return [dot(up, position) for _, position in result.conversion.state(Simulation).stance]


def test_the_robot_stands_on_its_lowest_points() -> None:
    passes = {"posture": {"joints": STANCE}, "contacts": {"links": ["*_foot"]}}
    actual = heights(convert(BIPED, passes=passes))
    assert len(actual) == 8
    assert min(actual) == pytest.approx(0.0, abs=1e-12)
    assert max(actual) < 1e-9, "the feet are level in this position"


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
        assert compute_placement(result.mbs).bodies[body.name].xyz[2] == pytest.approx(
            0.5, abs=1e-12
        )


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (0.0, 0.0, 9.81), (0.0, -9.81, 0.0)])
def test_up_is_against_gravity(gravity: tuple[float, float, float]) -> None:
    passes = {"contacts": {"links": ["*_foot"], "ground": 0.25}}
    x, y, z = (-c / 9.81 for c in gravity)
    actual = heights(convert(BIPED, passes=passes, gravity=gravity), (x, y, z))
    assert min(actual) == pytest.approx(0.25, abs=1e-12)


DOWN = (0.0, 0.0, -9.81)
#: What TINY's body looks like.
BODY = '<geometry><box size="0.2 0.1 0.3"/>'
MESH = '<geometry><mesh filename="foot.obj"/>'
#: Five corners, and places inside.
FOOT = "0.2 0.05 0;0.2 -0.05 0;-0.1 0.05 0;-0.1 -0.05 0;0 0 0.3;0 0 0.1;0.01 0 0.1;0 0 0.02;0 0 0"


def on_body(folder: Path, shape: str, corners: str = FOOT, **settings: Any) -> Result:
    """TINY with this shape on its body, which touches; ``corners`` of its mesh."""
    positions = corners.split(";")
    faces = "".join(f"f 1 2 {k}\n" for k in range(3, len(positions) + 1))
    (folder / "foot.obj").write_text("".join(f"v {corner}\n" for corner in positions) + faces)
    source = folder / "r.urdf"
    source.write_text(TINY.replace(BODY, shape))
    return convert(source, passes={"contacts": {"links": ["body"]}}, **settings)


def test_what_of_shapes_may_touch(tmp_path: Path) -> None:
    """The corners of boxes, those of hulls that count, spheres, and eight points of each rim."""
    made = on_body(tmp_path, BODY)
    assert sorted(points(made)) == [
        (x, y, z) for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.15, 0.15)
    ]
    assert len(points(on_body(tmp_path, MESH))) == 5
    turns = [k / 32 for k in range(200)]
    fine = ";".join(f"{0.1 * cos(t)} {0.1 * sin(t)} {z}" for t in turns for z in (0, 1))
    assert len(points(on_body(tmp_path, MESH, fine))) < 60
    (ball,) = contacts(on_body(tmp_path, '<geometry><sphere radius="0.1"/>'))
    assert [(spot.centre, spot.radius) for spot in ball.spots] == [((0.0, 0.0, 0.0), 0.1)]
    capsule = '<geometry><capsule radius="0.1" length="0.4"/>'
    (rod,) = contacts(on_body(tmp_path, capsule))
    assert sorted((spot.centre, spot.radius) for spot in rod.spots) == [
        ((0.0, 0.0, -0.2), 0.1),
        ((0.0, 0.0, 0.2), 0.1),
    ]
    roller = '<origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.1" length="0.4"/>'
    (wheel,) = contacts(on_body(tmp_path, roller))
    assert len(wheel.spots) == 16
    for spot in wheel.spots:
        assert spot.axis == pytest.approx((0.0, -1.0, 0.0))
        assert abs(spot.centre[1]) == pytest.approx(0.2)
    assert wheel.bounding_radius == pytest.approx(0.3)


def test_a_sheet_touches_by_the_corners_of_its_box(tmp_path: Path) -> None:
    flat = ";".join(f"{x} {y} 0" for x in range(4) for y in range(3))
    actual = points(on_body(tmp_path, MESH, flat))
    assert sorted(actual) == [(0.0, 0.0, 0.0), (0.0, 2.0, 0.0), (3.0, 0.0, 0.0), (3.0, 2.0, 0.0)]


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(9, 200), size=st.floats(0.01, 2.0))
def test_no_corner_is_far_outside_the_hull(seed: int, count: int, size: float) -> None:
    """What is left out is at most 3 mm, or a twentieth of a small body, below what touches
    along a corner's own normal; elsewhere it may be a little more."""
    from urdf2mbs_project.spots import thin_spots

    random = np.random.default_rng(seed)
    cloud = size * random.normal(size=(count, 3)) * (1.0, 0.5, 0.3)
    kept = np.array(
        [spot.centre for spot in thin_spots([Spot(tuple(point)) for point in cloud.tolist()])]
    )
    assert len(kept) <= count
    allowed = min(0.003, 0.05 * np.ptp(cloud, axis=0).max()) + 1e-6
    for direction in random.normal(size=(50, 3)):
        direction /= np.linalg.norm(direction)
        assert 0.0 <= (cloud @ direction).max() - (kept @ direction).max() + 1e-6 <= 2 * allowed


@pytest.mark.parametrize(
    ("shapes", "n_spots"),
    [
        ('<box size="0.2 0.1 0"/>', 4),
        ('<sphere radius="0.1"/>', 1),
        ('<cylinder radius="0.1" length="0"/>', 8),
    ],
)
@pytest.mark.parametrize("n_times", [1, 2])
def test_nothing_touches_twice_in_one_place(shapes: str, n_spots: int, n_times: int) -> None:
    """Shapes that are flat, or stated twice: the ground would be twice as stiff there."""
    collision = f"<collision><geometry>{shapes}</geometry></collision>"
    text = robot(link("l", SOLID, collision * n_times))
    conversion = convert_text(text, passes={"contacts": {"links": ["l"]}}).conversion
    assert [contact["spots"] for contact in conversion.report["contacts"]] == [n_spots]


def test_a_point_that_a_config_names_twice_touches_once() -> None:
    points = {"l": [[0.1, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]]}
    text = robot(link("l", SOLID, ""))
    conversion = convert_text(text, passes={"contacts": {"points": points}}).conversion
    assert [contact["spots"] for contact in conversion.report["contacts"]] == [2]


def test_all_that_is_solid_and_moves_touches() -> None:
    """Links without shapes do not, and nothing that stands still; what is named must."""
    shape = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    text = robot(
        link("world"),
        link("table", shape),
        link("arm", SOLID + shape),
        link("tip", shape),
        link("bare", SOLID),
        joint("world", "table", "fixed"),
        joint("table", "arm"),
        joint("arm", "tip", "fixed", xyz="0 0 1"),
        joint("arm", "bare"),
    )
    (contact,) = contacts(
        convert_text(text, passes={"contacts": {"links": ["*"]}}, pipeline="compact")
    )
    assert contact.links == ["arm", "tip"]
    assert [spot.centre for spot in contact.spots] == [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    named = {"contacts": {"links": ["bare"]}}
    with pytest.raises(ConfigError, match="no shape to take points of"):
        convert_text(text, passes=named)
    plain = robot(link("a", SOLID), link("b", SOLID), joint("a", "b"))
    with pytest.raises(ConfigError, match="no link that moves has a shape"):
        convert_text(plain, passes={"contacts": {"links": ["*"]}})


def test_a_robot_stands_on_what_is_round() -> None:
    """A floating base is shifted until the tilted rim, or the ball, is on the ground."""
    text = (
        '<robot name="r"><link name="wheel"><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
        'ixz="0" iyy="1" iyz="0" izz="1"/></inertial><collision><origin xyz="0.1 0 0" '
        'rpy="1.2 0 0"/><geometry>{}</geometry></collision></link></robot>'
    )
    cylinder, ball = '<cylinder radius="0.3" length="1"/>', '<sphere radius="0.3"/>'
    for shape, height in ((cylinder, 0.3 * sin(1.2) + 0.5 * cos(1.2)), (ball, 0.3)):
        passes = {"contacts": {"roll": ["wheel"]}}
        result = convert_text(text.format(shape), base="floating", passes=passes)
        (contact,) = result.report.passes["contacts"]
        assert contact["point"].coordinates == (0.0, 0.0, 0.0)
        assert compute_placement(result.mbs).bodies["wheel"].xyz[2] == pytest.approx(height)
    for ground, expected in ((-0.3, []), (-0.4, ["0.1 m lower"]), (0.0, ["0.3 m higher"])):
        passes = {"contacts": {"roll": ["wheel"], "ground": ground}}
        result = convert_text(text.format(ball), base="floating", passes=passes)
        notes = [
            diagnostic.message for diagnostic in result.diagnostics if diagnostic.code == "stand"
        ]
        assert [note[16 : note.index(",")] for note in notes] == expected


WEIGHTLESS = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("stated", "options", "gravity", "law"),
    [
        # with m = 2.6 kg / 4: speed (g d)^(1/2) / 0.6 with d = m g / stiffness
        ("", {"stiffness": 1e5}, DOWN, {"stiffness": 1e5, "speed": 0.042}),
        ("", {"stiffness": 2e4, "speed": 0.1}, DOWN, {"stiffness": 2e4, "speed": 0.1}),
        # kp and kd are numbers of Gazebo's solver
        ("<kp>1e9</kp><kd>1e9</kd>", {"depth": 0.01}, DOWN, {"stiffness": 640.0, "speed": 0.52}),
        ("", {"depth": 0.25}, WEIGHTLESS, {"stiffness": 1000.0, "speed": 0.1, "bristle": 0.25}),
        ("", {"stiffness": 5e4}, WEIGHTLESS, {"stiffness": 5e4, "speed": 0.1, "bristle": 0.001}),
        # the smallest friction; that of TINY's own hand is 0.9
        ("", {}, DOWN, {"friction": 0.9}),
        ("<mu1>0.4</mu1><mu1>-1</mu1><mu1>9e9</mu1>", {}, DOWN, {"friction": 0.4}),
        ("<mu1>0.4</mu1>", {"friction": 0.7}, DOWN, {"friction": 0.7}),
    ],
)
def test_the_law_is_that_of_the_config_then_of_the_urdf(
    stated: str, options: dict[str, float], gravity: Vec, law: dict[str, float]
) -> None:
    """Each number is in its own ``<gazebo>``."""
    gazebo = "".join(
        f'<gazebo reference="hand">{element}</gazebo>'
        for element in re.findall("<(?:.*?)</.*?>", stated)
    )
    text = TINY.replace("</robot>", f"{gazebo}</robot>")
    passes = {"contacts": {**HAND, **options}}
    actual = models(convert_text(text, gravity=gravity, passes=passes).mbs)["contact"]
    assert actual.items() >= law.items()
    rate = 0.6 * sqrt(actual["bristle"] / 9.81)
    assert actual["bristle_time"] == pytest.approx(rate, rel=0.05)


def test_friction_is_of_the_links_that_touch() -> None:
    feet = {"points": {"body": [[0, 0, 0]], "hand": [[0, 0, 0]]}}
    bare = TINY.replace("mu1", "mu2")
    bullet = '<link name="body"><contact><lateral_friction value="0.2"/></contact>'
    other_link = '<gazebo reference="arm"><mu1>0.1</mu1></gazebo></robot>'
    for text, friction in (
        (TINY.replace('<link name="body">', bullet), 0.2),
        (bare, 0.8),
        (bare.replace("</robot>", other_link), 0.8),
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
    stated = "<mu1>1e4</mu1>"
    without_friction = TINY.replace("mu1", "mu2")
    text = without_friction.replace(
        "</robot>", f'<gazebo reference="hand">{stated}</gazebo></robot>'
    )
    result = convert_text(text, passes={"contacts": HAND}, output={"project": tmp_path / "p"})
    assert result.report.proof is not None
    assert result.report.proof.same
    assert models(result.mbs)["contact"]["friction"] == 100.0
    told = [
        diagnostic.message
        for diagnostic in result.diagnostics
        if diagnostic.code == "contacts-most"
    ]
    assert told == ["contacts: mu1 is 100, not 10000 as in the URDF"]


def test_a_centre_of_mass_stands_in_for_a_lost_mesh(tmp_path: Path) -> None:
    """So no link falls through the ground; a link that was named wants points instead."""
    source = tmp_path / "r.urdf"
    source.write_text(TINY.replace('<box size="0.2 0.1 0.3"/>', '<mesh filename="none.obj"/>'))
    result = convert(source, passes={"contacts": {"links": ["*"]}})
    [message] = [
        diagnostic.message
        for diagnostic in result.diagnostics
        if diagnostic.code == "contacts-mesh"
    ]
    assert message.endswith("so its centre of mass touches instead: 'body' (it was not found)")
    body = next(contact for contact in contacts(result) if "body" in contact.links)
    centre = result.conversion.robot.links["body"].inertial
    assert centre is not None
    assert [spot.centre for spot in body.spots] == [pytest.approx(centre.origin.pose.xyz, abs=1e-9)]


def test_a_mesh_that_cannot_be_used_is_told(tmp_path: Path) -> None:
    source = tmp_path / "r.urdf"
    options = {"contacts": {"links": ["body"]}}
    for mesh in ("none.obj", "r.urdf"):
        source.write_text(TINY.replace('<box size="0.2 0.1 0.3"/>', f'<mesh filename="{mesh}"/>'))
        with pytest.raises(ConfigError, match="no shape to take points of"):
            convert(source, passes=options)
    text = source.read_text().replace(
        "</visual>",
        "</visual><collision><geometry><sphere radius='1'/></geometry></collision>"
        "<collision><geometry><mesh filename='none.obj'/></geometry></collision>",
        1,
    )
    source.write_text(text)
    result = convert(source, passes=options)
    [message] = [
        diagnostic.message
        for diagnostic in result.diagnostics
        if diagnostic.code == "contacts-mesh"
    ]
    assert message.endswith("so its other shapes touch alone: 'body' (it was not found)")
    assert [spot.radius for contact in contacts(result) for spot in contact.spots] == [1.0]


@pytest.mark.parametrize(
    ("places", "base", "gravity", "away"),
    [
        ("1 1, 1 -1, -1 0", "floating", DOWN, 0.0),
        ("1 1, 1 -1", "floating", DOWN, 1.0),
        ("-0.5 1, -0.5 -1", "floating", DOWN, -0.5),
        ("0.002 1, 0.002 -1", "floating", DOWN, 0.002),
        ("1 1, 1 -1", "fixed", DOWN, 0.0),
        ("1 1, 1 -1", "floating", WEIGHTLESS, 0.0),
        # the centre of the triangle is at 1 in x: this is more than a fifth of the way there
        ("-0.26 1, -0.26 -1, 3.52 0", "floating", DOWN, 0.0),
    ],
)
def test_a_robot_falls_whose_mass_is_not_over_the_polygon(
    places: str, base: str, gravity: Vec, away: float
) -> None:
    """Only what floats and has weight can fall; it must come nearer in x by ``away`` (m)."""
    text = robot(link("a", SOLID.replace("0.1 -0.2 0.3", "0 0 1")))
    positions = [[*map(float, place.split()), 0.0] for place in places.split(", ")]
    passes = {"contacts": {"points": {"a": positions}}}
    result = convert_text(text, base=base, gravity=gravity, passes=passes)
    diagnostics = [
        diagnostic for diagnostic in result.diagnostics if diagnostic.code == "contacts-balance"
    ]
    assert bool(diagnostics) == bool(away)
    for found in diagnostics:
        assert f"but {abs(away):.3g} m beside them" in found.message
        assert f"it must come ({away:.3g}, 0, 0) m" in (found.hint or "")
    if base == "floating" and any(gravity):  # without a leg, it sinks in by a thousandth of a metre
        stiffness = models(result.mbs)["contact"]["stiffness"]
        assert stiffness == pytest.approx(2 * 9.81 / 4 / 0.001, rel=0.05)


@pytest.mark.parametrize(
    ("places", "away"),
    [
        ("0 1, 0 -1", 0.0),
        ("0 0", 0.0),
        ("0.0008 1, 0.0008 -1", 0.0008),
        ("-0.24 1, -0.24 -1, 3.48 0", 0.24),
    ],
)
def test_a_robot_must_step_whose_mass_is_near_the_edge(places: str, away: float) -> None:
    """Less than a fifth of the way to the middle of its feet, whose corners in the air do not
    count."""
    positions = [[*map(float, place.split()), 0.0] for place in places.split(", ")]
    points = {"points": {"a": [*positions, [-9, 9, 0.5], [-9, -9, 0.5]]}}
    text = robot(link("a", SOLID.replace("0.1 -0.2 0.3", "0 0 1")))
    result = convert_text(text, base="floating", passes={"contacts": points})
    [message] = [
        diagnostic.message
        for diagnostic in result.diagnostics
        if diagnostic.code == "contacts-balance"
    ]
    assert f"is only {away:.3g} m from the edge" in message
    assert "a robot that sways tips over" in message


@pytest.mark.parametrize("effort", [1.0, 5.8, 6.2, 0.0])
def test_a_robot_falls_whose_ankle_is_too_weak(effort: float) -> None:
    """It holds 10 kg, 50 mm before the ankle, and sways by a hundredth of its height; 0 is no
    limit."""
    axis = '<axis xyz="0 1 0"/>'
    limit = f'<limit lower="-1" upper="1" effort="{effort}" velocity="1"/>'
    ankle = f'<joint name="ankle" type="revolute"><parent link="leg"/><child link="foot"/>{axis}'
    mass = '<inertial><origin xyz="{}"/><mass value="{}"/><inertia ixx="0.1" iyy="0.1" izz="0.1" '
    mass += 'ixy="0" ixz="0" iyz="0"/></inertial>'
    text = robot(
        link("foot", mass.format("0 0 0", 1e-3)),
        link("leg", mass.format("0.05 0 0.9", 10.0)),
        f"{ankle}{limit}</joint>",
    )
    corners = [[x, y, -0.1] for x in (-0.1, 0.15) for y in (-0.1, 0.1)]
    passes = {"contacts": {"points": {"foot": corners}}, "posture": {"hold": {}}}
    result = convert_text(text, base="floating", passes=passes)
    messages = [
        diagnostic.message
        for diagnostic in result.diagnostics
        if diagnostic.code == "contacts-balance"
    ]
    assert bool(messages) == (0.0 < effort < 6.0)
    for message in messages:  # 10 g (0.05 + 0.01)
        assert message.endswith(f"stands and sways: 'ankle' has {effort:g} of 5.89 N m")
