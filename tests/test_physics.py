"""Every real robot here is the same robot after its conversion.

Compared at zero and at random positions of all joints, with pinocchio and with Rodrigues'
formula on the URDF: the pose of every link; mass, centre and inertia of every rigid group;
total mass; mass matrix; gravity forces; inverse dynamics. ``python tests/test_physics.py``
prints a table of the largest errors.
"""

from __future__ import annotations

import zlib
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracle.compare import Comparison, lost_shapes, structure_faults
from oracle.mbs import Evaluator
from oracle.urdf import Urdf
from robots import BROKEN, CONVERTIBLE, RealRobot

from urdf2mbs.messages.diagnostics import ConversionError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

#: 1e-10 is promised; what is found is 100 times less than this.
TOLERANCE = 1e-12
#: Of the compact one, which takes axes up to 1e-9 off for aligned in frames of its own choice.
COMPACT_TOLERANCE = 1e-9
POSITIONS = 5
KEEP_ALL = {"prune-massless": {"keep": ["*"]}}


@cache
def urdf_of(text: Path) -> Urdf:
    return Urdf.parse(text.read_bytes())


def converted(robot: RealRobot, base: str, keep: bool) -> Comparison:
    urdf = urdf_of(robot.text)
    result = robot.convert(base=base, passes=KEEP_ALL if keep else {})
    return Comparison(result, urdf, floating=urdf.floats(base))


def has_bodies(robot: RealRobot, base: str, keep: bool) -> bool:
    """Whether anything is left to make a body of."""
    urdf = urdf_of(robot.text)
    if keep:
        return bool(urdf.joints) or urdf.floats(base)
    return not all(urdf.massless(link) for link in urdf.inertias)


def largest_errors(comparison: Comparison, robot: RealRobot) -> dict[str, dict[str, float]]:
    """By reference, by kind."""
    rng = np.random.default_rng(zlib.crc32(robot.name.encode()))
    positions = [{}, *(comparison.random(rng) for _ in range(POSITIONS))]
    models = (comparison.pinocchio(robot.text.read_bytes()), comparison.reference())
    return {model.name: comparison.errors(model, positions) for model in models}


def too_large(errors: dict[str, dict[str, float]], tolerance: float) -> dict[str, float]:
    return {
        f"{model} {kind}": error
        for model, by_kind in errors.items()
        for kind, error in by_kind.items()
        if error > tolerance
    }


@pytest.mark.parametrize("keep", [False, True], ids=["pruned", "kept"])
@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("robot", CONVERTIBLE)
def test_is_the_same_robot(
    robot: RealRobot, base: str, keep: bool, shared: Path, record_property: Callable[..., None]
) -> None:
    comparison = converted(robot, base, keep)
    no_mass = all(map(comparison.urdf.massless, comparison.urdf.inertias))
    said = [found.code for found in comparison.result.diagnostics]
    assert ("no-mass" in said) == no_mass
    keep = keep or no_mass

    errors = largest_errors(comparison, robot)
    for model, by_kind in errors.items():
        for kind, error in by_kind.items():
            record_property(f"{model} {kind}", float(error))
    assert not too_large(errors, TOLERANCE)
    assert structure_faults(comparison) == []
    assert lost_shapes(comparison) == []
    # whatever moves matter, moves; what does not, is said to stand still
    result, urdf = comparison.result, comparison.urdf
    assert set(result.frozen) == (set() if keep else urdf.moving_nothing())
    assert ("massless-leaf" in said) == bool(result.frozen)


@pytest.mark.parametrize("robot", CONVERTIBLE)
def test_the_compact_one_is_the_same_robot(
    robot: RealRobot, shared: Path, record_property: Callable[..., None]
) -> None:
    urdf = urdf_of(robot.text)
    result = robot.convert(pipeline="compact")

    # what is fixed to the ground becomes ground, and that has no inertia
    comparison = Comparison(result, urdf, floating=urdf.floats("auto"), ground_has_mass=False)

    errors = largest_errors(comparison, robot)
    for model, by_kind in errors.items():
        for kind, error in by_kind.items():
            record_property(f"{model} {kind}", float(error))
    assert not too_large(errors, COMPACT_TOLERANCE)
    assert structure_faults(comparison, faithful=False) == []
    assert lost_shapes(comparison) == []


@pytest.mark.parametrize("robot", CONVERTIBLE)
def test_auto_is_one_of_the_two_bases(robot: RealRobot, shared: Path) -> None:
    urdf = urdf_of(robot.text)
    base = "floating" if urdf.floats("auto") else "fixed"
    if not has_bodies(robot, base, keep=True):
        pytest.skip("a single massless link")

    auto = robot.convert(passes=KEEP_ALL)

    own = any(joint.type == "floating" for joint in urdf.joints.values())
    assert auto.report.base == ("floating" if own else base)
    assert bool(auto.report.floating_joints) == own
    assert auto.data == robot.convert(base=base, passes=KEEP_ALL).data


@pytest.mark.parametrize("robot", BROKEN)
def test_what_is_no_robot_is_refused(robot: RealRobot, shared: Path) -> None:
    with pytest.raises(ConversionError) as refused:
        robot.convert()
    assert refused.value.exit_code == 1
    assert refused.value.code != "internal"


def test_one_conversion_does_not_influence_the_next(shared: Path) -> None:
    robots = [param.values[0] for param in CONVERTIBLE[::3]]
    once = [robot.convert(passes=KEEP_ALL).data for robot in robots]

    again = [robot.convert(passes=KEEP_ALL).data for robot in reversed(robots)]

    assert once == again[::-1]
    for data in once:
        Evaluator(data)


def main() -> None:
    kinds = ("pose", "mass", "com", "inertia", "matrix", "gravity", "dynamics")
    head = f"{'robot':38} {'base':8} {'':6} links bodies joints moving"
    print(head + "".join(f"{kind:>9}" for kind in kinds))
    worst: dict[tuple[str, str], float] = {}
    for param in CONVERTIBLE:
        robot: Any = param.values[0]
        for base in ("fixed", "floating"):
            for keep in (False, True):
                if not has_bodies(robot, base, keep):
                    continue
                comparison = converted(robot, base, keep)
                found = largest_errors(comparison, robot)
                for model, by_kind in found.items():
                    for kind, error in by_kind.items():
                        worst[model, kind] = max(worst.get((model, kind), 0.0), error)
                row = [max(by_kind[kind] for by_kind in found.values()) for kind in kinds]
                mbs = comparison.mbs
                print(
                    f"{robot.name:38} {base:8} {'kept' if keep else 'pruned':6} "
                    f"{len(comparison.urdf.inertias):5} {len(mbs.bodies) - 1:6} "
                    f"{len(mbs.joints):6} {len(mbs.moving):6}"
                    + "".join(f"{error:9.1e}" for error in row)
                )
    for model in ("pinocchio", "rodrigues"):
        row = [worst[model, kind] for kind in kinds]
        print(f"{'largest, against ' + model:82}" + "".join(f"{error:9.1e}" for error in row))


if __name__ == "__main__":
    main()
