"""The preset ``compact``: the same robot, to rounding, with far fewer joints."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.build import SOLID, joint, link, robot
from support.examples import reproducible
from support.oracle.urdf import Urdf
from support.proving import assert_same, driven, prove
from support.real_robots import CONVERTIBLE, REAL_ROBOTS, RealRobot
from support.strategies import LINK_NAMES, robots, snapped
from urdf2mbs.testing import convert_text

KEEP_ALL = {"prune-massless": {"keep": ["*"]}}
ROBOTS = {robot.name: robot for robot in REAL_ROBOTS}


@pytest.mark.parametrize("robot", CONVERTIBLE)
def test_real_robots_are_the_same(robot: RealRobot) -> None:
    result = robot.convert(base="floating", pipeline="compact")

    # 1e-10 is promised; what is found is 1.4e-12 with Atlas, angles of which are 5e-13 off,
    # and 1e-13 with all others
    tolerance = 3e-12 if "atlas" in robot.name else 1e-12
    assert_same(result, robot.text.read_bytes(), "floating", tolerance)
    assert result.report.proof.same
    assert driven(result) <= driven(robot.convert(base="floating", pipeline="faithful"))


#: Moving joints, and driven ones, with all massless links kept.  The issue's numbers are these,
#: but for NAO (14) and the UR arms (1), which take directions for aligned that are 1.4e-7 and
#: 2e-10 off; see docs/compact.md.
FEWEST = {
    "icub-iCubGazeboV2_5": (32, 14),
    "icub-iCubGenova02": (32, 16),
    "icub-iCubLisboa01": (32, 46),
    "icub-iCubNancy01": (32, 48),
    "nao-naoV50_generated_urdf": (42, 16),
    "walkman-bigman": (31, 8),
    "atlas-atlas_v5": (31, 1),
    "atlas-atlas_v3": (29, 4),
    "ur-ur5": (6, 3),
    "franka-fr3_nohand": (7, 2),
    "cassie-cassie_v4": (16, 6),
    "solo12-solo12.urdf.xacro": (12, 0),
    "t12-T12": (36, 36),
}


@pytest.mark.parametrize("name", FEWEST)
def test_so_few_joints_are_enough(name: str, shared: Path) -> None:
    result = ROBOTS[name].convert(base="fixed", pipeline="compact", passes=KEEP_ALL)

    joints = result.report.joints
    assert (joints.independent, joints.driven) == FEWEST[name]
    # one body for each that moves, at most
    assert result.report.bodies <= joints.independent
    assert all(
        any(joint.nature == "independent" for joint in body.joints) for body in result.mbs.bodies
    )


@pytest.mark.parametrize(("name", "fewest"), [("nao-naoV50_generated_urdf", 14), ("ur-ur5", 1)])
def test_a_tolerance_takes_more_for_aligned_and_says_so(
    name: str, fewest: int, shared: Path
) -> None:
    options = {**KEEP_ALL, "align-frames": {"tolerance": 1e-6}, "check": {"tolerance": 1e-6}}

    result = ROBOTS[name].convert(base="fixed", pipeline="compact", passes=options)

    assert result.report.joints.driven == fewest
    told = [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "axis-aligned"]
    off = max(float(re.search(r"its axis is (\S+) rad off", d.message)[1]) for d in told)
    found = max(result.report.proof.largest.values())
    # more than is promised of the default, and about what is said
    assert 1e-10 < found < 5 * off < 1e-6
    assert {d.joint for d in told} <= result.robot.joints.keys()


@pytest.mark.slow
@settings(reproducible, max_examples=120)
@given(
    robots(most=9),
    st.sampled_from(("auto", "floating", "fixed")),
    st.booleans(),
    st.lists(st.sampled_from(("*", "b*", "*foot", *LINK_NAMES)), max_size=3),
)
def test_random_robots_are_the_same(
    text: bytes, base: str, keep: bool, keep_fixed: list[str]
) -> None:
    options = {
        **(KEEP_ALL if keep else {}),
        "lump-fixed": {"keep": keep_fixed},
    }

    # an axis within 1e-9 rad of a coordinate axis or plane of its link is taken to lie on it
    result = prove(text, tolerance=3e-11, moved=snapped(text), base=base, passes=options)

    urdf = Urdf.parse(text)
    kinds = {joint.type for joint in urdf.joints.values()}
    if not kinds & {"floating", "planar"}:
        faithful = convert_text(text.decode(), base=base, passes=KEEP_ALL if keep else {})
        assert driven(result) <= driven(faithful)


def test_an_axis_that_is_nearly_aligned_is_told_of() -> None:
    text = robot(link("a", SOLID), link("b", SOLID), joint("a", "b", axis="5e-10 0 1"))
    result = prove(text, moved=5e-10, base="floating")
    assert driven(result) == 0
    assert "5.0e-10 rad off" in str(
        [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "axis-aligned"]
    )
