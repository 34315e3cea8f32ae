"""Every real robot here is the same robot after its conversion.

Compared at zero and at random positions of all joints, with pinocchio on the URDF: the pose of
every link; mass, centre and inertia of every rigid group; total mass; mass matrix; gravity forces;
inverse dynamics.
"""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from support.compare import beside_its_urdf, lost_shapes, structure_faults
from support.oracle.mbs import Evaluator
from support.oracle.urdf import Urdf
from support.real_robots import BROKEN, CONVERTIBLE, RealRobot
from urdf2mbs.messages.diagnostics import ConversionError

#: 1e-10 is promised; what is found is 100 times less than this.
TOLERANCE = 1e-12
POSITIONS = 5
KEEP_ALL = {"prune-massless": {"keep": ["*"]}}


@cache
def urdf_of(text: Path) -> Urdf:
    return Urdf.parse(text.read_bytes())


@pytest.mark.parametrize(("base", "keep"), [("fixed", False), ("floating", True)])
@pytest.mark.parametrize("robot", CONVERTIBLE)
def test_is_the_same_robot(
    robot: RealRobot, base: str, keep: bool, shared: Path, record_property: Callable[..., None]
) -> None:
    """By the preset faithful; tests/plugins/compact/test_compact.py has the other."""
    urdf = urdf_of(robot.text)
    result = robot.convert(base=base, passes=KEEP_ALL if keep else {})
    comparison, errors = beside_its_urdf(
        result, urdf, robot.text.read_bytes(), base, positions=POSITIONS
    )
    for kind, error in errors.items():
        record_property(kind, float(error))
    assert not {kind: error for kind, error in errors.items() if not error <= TOLERANCE}
    assert structure_faults(comparison) == []
    assert lost_shapes(comparison) == []
    # whatever moves matter, moves; what does not, is said to stand still
    said = [found.code for found in result.diagnostics]
    no_mass = all(map(urdf.massless, urdf.inertias))
    assert ("no-mass" in said) == no_mass
    assert set(result.frozen) == (set() if keep or no_mass else urdf.moving_nothing())
    assert ("massless-leaf" in said) == bool(result.frozen)


@pytest.mark.parametrize("robot", CONVERTIBLE)
def test_auto_is_one_of_the_two_bases(robot: RealRobot, shared: Path) -> None:
    urdf = urdf_of(robot.text)
    base = "floating" if urdf.floats("auto") else "fixed"
    auto = robot.convert(pipeline=["expand", "insert-base"]).conversion.base

    own = any(joint.type == "floating" for joint in urdf.joints.values())
    assert (auto.reason == "own joint") == own
    assert auto.floating == (base == "floating" and not own)


@pytest.mark.parametrize("robot", BROKEN)
def test_what_is_no_robot_is_refused(robot: RealRobot, shared: Path) -> None:
    with pytest.raises(ConversionError) as refused:
        robot.convert()
    assert refused.value.exit_code == 1
    assert refused.value.code != "internal"


def test_one_conversion_does_not_influence_the_next(shared: Path) -> None:
    robots = [param.values[0] for param in CONVERTIBLE[::9]]
    once = [robot.convert(passes=KEEP_ALL).data for robot in robots]

    again = [robot.convert(passes=KEEP_ALL).data for robot in reversed(robots)]

    assert once == again[::-1]
    for data in once:
        Evaluator(data)
