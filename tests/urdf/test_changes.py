"""What differs between two states of a robot: each value, by its kind and name."""

from copy import deepcopy
from typing import Any

import pytest

from support.build import BOX, SOLID, joint, link, robot
from urdf2mbs.urdf.changes import Change, describe_changes, encode, find_changes
from urdf2mbs.urdf.model import (
    Collision,
    Dynamics,
    Extension,
    Material,
    Mimic,
    Origin,
    Robot,
    Sphere,
)
from urdf2mbs.urdf.reader import parse_urdf

TEXT = robot(
    link("a", SOLID, BOX),
    link("b", SOLID),
    link("c"),
    joint("a", "b", name="one"),
    joint("b", "c", name="two").replace("</joint>", '<mimic joint="one" multiplier="2"/></joint>'),
)


def made() -> Robot:
    return parse_urdf(TEXT.encode(), "r.urdf")[0]


def renamed(robot: Robot, **names: str) -> None:
    """Give links and joints other names, everywhere."""
    robot.links = {names.get(name, name): each for name, each in robot.links.items()}
    robot.joints = {names.get(name, name): each for name, each in robot.joints.items()}
    for each in (*robot.links.values(), *robot.joints.values()):
        each.name = names.get(each.name, each.name)
    for each in robot.joints.values():
        each.parent, each.child = (names.get(n, n) for n in (each.parent, each.child))
        if each.mimic is not None:
            each.mimic.joint = names.get(each.mimic.joint, each.mimic.joint)


def swapped(robot: Robot) -> None:
    robot.links = dict(reversed(robot.links.items()))


def without_joint(robot: Robot) -> None:
    del robot.joints["two"], robot.links["c"]


def with_joint(robot: Robot) -> None:
    robot.links["d"] = deepcopy(robot.links["c"])
    robot.joints["three"] = deepcopy(robot.joints["two"])


def with_values(robot: Robot) -> None:
    solid, turn = robot.links["a"].inertial, robot.joints["one"]
    assert solid is not None
    solid.mass, solid.origin = 3.0, Origin()
    solid.inertia = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    robot.links["a"].visuals = []
    robot.links["b"].collisions = [Collision(Sphere(1.0))]
    robot.links["c"].inertial = deepcopy(robot.links["b"].inertial)
    turn.axis, turn.dynamics, turn.origin = (1.0, 0.0, 0.0), Dynamics(1.0), Origin((1.0, 0.0, 0.0))
    robot.joints["two"].mimic = Mimic("one", 3.0)
    robot.name, robot.materials["red"] = "s", Material("red")
    robot.extensions.append(Extension("gazebo", "<gazebo/>"))


SAME: tuple[float, ...] = (0.03, 0.001, -0.002, 0.04, 0.003, 0.05)
CASES: list[tuple[Any, str]] = [
    (lambda robot: None, ""),
    (lambda robot: renamed(robot, a="x"), "1 link renamed"),
    (lambda robot: renamed(robot, a="x", b="y", one="uno"), "2 links renamed, 1 joint renamed"),
    (lambda robot: renamed(robot, a="b", b="a"), "2 visuals, 2 parents, 1 child, 1 order"),
    (swapped, "1 order"),
    (without_joint, "1 link removed, 1 joint removed"),
    (with_joint, "1 link added, 1 joint added"),
    (
        with_values,
        "1 name, 2 masses, 2 centres, 2 inertias, 1 visuals, 1 collisions, 1 origin, 1 axis, "
        "1 dynamics, 1 mimic, 1 materials, 1 extensions",
    ),
]


@pytest.mark.parametrize(("change", "expected"), CASES)
def test_changes_are_counted_in_words(change: Any, expected: str) -> None:
    before, after = made(), made()
    change(after)
    assert describe_changes(find_changes(encode(before), encode(after))) == expected


def test_each_change_has_its_values() -> None:
    before, after = made(), made()
    with_values(after)
    changes = find_changes(encode(before), encode(after))
    assert changes[:2] == [Change("name", "", "r", "s"), Change("mass", "a", 2.0, 3.0)]
    assert Change("mass", "c", None, 2.0) in changes
    assert Change("axis", "one", (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)) in changes
    renamed(after := made(), b="y")
    assert find_changes(encode(before), encode(after)) == [Change("link-renamed", "b", "b", "y")]


def test_what_no_urdf_can_hold_is_refused() -> None:
    broken = made()
    broken.links["a"].name = object()  # type: ignore[assignment]
    with pytest.raises(TypeError, match="object"):
        encode(broken)
