"""Singular mass matrices, against the rank of Pinocchio's."""

from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from support.oracle.pin import to_pinocchio
from support.singular import mass_matrix, rotation_about_z_and_x, trees
from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs_project.singular import FollowerRule, find_singular_joints


def smallest(matrix: Any) -> float:
    """Return the smallest eigenvalue, each joint scaled; 0 if a joint has no inertia at all."""
    if not len(matrix):
        return 1.0
    scale = np.sqrt(np.abs(np.diag(matrix)))
    if scale.min() <= 1e-7:  # masses and lengths are around one
        return 0.0
    return float(np.linalg.eigvalsh(matrix / np.outer(scale, scale))[0])


def least(mbs: Mbs) -> tuple[float, float]:
    """Return it for an .mbs: the largest of some random positions, and at the initial one."""
    model = to_pinocchio(mbs)
    random = np.random.default_rng(7)
    anywhere = max(smallest(mass_matrix(model, random.uniform(-2, 2, model.nq))) for _ in range(6))
    return anywhere, smallest(mass_matrix(model, np.zeros(model.nq)))


ZERO_BELOW, ABOVE = 1e-11, 1e-9


@settings(max_examples=150)
@given(trees())
def test_singular_where_pinocchio_says_so(mbs: Mbs) -> None:
    singular_joints = find_singular_joints(mbs)
    anywhere, initially = least(mbs)
    for smallest, singular in (
        (anywhere, any(singular.always for singular in singular_joints)),
        (initially, bool(singular_joints)),
    ):
        assert smallest < ZERO_BELOW or smallest > ABOVE  # else the truth itself is not clear
        assert singular == (smallest < ZERO_BELOW), smallest


@st.composite
def coupled(draw: Any) -> tuple[Mbs, dict[str, FollowerRule]]:
    """Draw a tree some of whose joints follow others, as in ``<mimic>``."""
    mbs = draw(trees())
    moving = [j for body in mbs.bodies for j in body.joints if j.nature != "driven"]
    leaders = [joint for joint in moving if draw(st.booleans())]
    rules = {}
    for joint in moving:
        if leaders and joint not in leaders and draw(st.sampled_from((True, True, False))):
            leader = draw(st.sampled_from(leaders))
            multiplier = draw(st.sampled_from((1.0, -1.0, 2.0, -0.5, 0.0)))
            offset = draw(st.sampled_from((0.0, 0.3)))
            rules[joint.name] = FollowerRule(leader.name, multiplier, offset)
            joint.nature, joint.q = "dependent", rules[joint.name].offset
    return mbs, rules


def reduced(mbs: Mbs, rules: dict[str, FollowerRule]) -> tuple[float, float]:
    """``least`` of the mass matrix of the joints that follow no other: B^T M B, where B has the
    speeds of all joints for each of those."""
    model = to_pinocchio(mbs)
    names = list(model.names)[1:]
    free = [name for name in names if name not in rules]
    turn, offset = np.zeros((model.nv, len(free))), np.zeros(model.nv)
    for row, name in enumerate(names):
        rule = rules.get(name, FollowerRule(name, 1.0, 0.0))
        turn[row, free.index(rule.leader)], offset[row] = rule.multiplier, rule.offset
    random = np.random.default_rng(7)
    least = [
        smallest(turn.T @ mass_matrix(model, turn @ x + offset) @ turn)
        for x in (np.zeros(len(free)), *(random.uniform(-2, 2, len(free)) for _ in range(6)))
    ]
    return max(least[1:]), least[0]


@settings(max_examples=80)
@given(coupled())
def test_couplings_leave_it_singular_where_pinocchio_says_so(
    case: tuple[Mbs, dict[str, FollowerRule]],
) -> None:
    singular_joints = find_singular_joints(*case)
    anywhere, initially = reduced(*case)
    for least, singular in (
        (anywhere, any(singular.always for singular in singular_joints)),
        (initially, bool(singular_joints)),
    ):
        assert least < ZERO_BELOW or least > ABOVE  # else the truth itself is not clear
        assert singular == (least < ZERO_BELOW), least


@settings(max_examples=60)
@given(coupled(), st.sampled_from((1e-9, 1e9)))
def test_a_robot_of_any_size_has_the_same_singular_joints(
    case: tuple[Mbs, dict[str, FollowerRule]], length: float
) -> None:
    mbs, rules = case
    assume(any(any(b.com or ()) or any(p.coordinates) for b in mbs.bodies for p in b.points))
    before = find_singular_joints(mbs, rules)
    joints = mbs.joints()
    units = {name: length if joint.type[0] == "T" else 1.0 for name, joint in joints.items()}
    for body in mbs.bodies:
        body.com = body.com and scaled(body.com, length)
        body.inertia = body.inertia and scaled(body.inertia, length**2)
        for point in body.points:
            point.coordinates = scaled(point.coordinates, length)
    for name, joint in joints.items():
        joint.q = joint.q and joint.q * units[name]
    for name, (leader, multiplier, offset) in rules.items():
        multiplier *= units[name] / units[leader]
        rules[name] = FollowerRule(leader, multiplier, offset * units[name])
    assert find_singular_joints(mbs, rules) == before


def scaled(numbers: Any, factor: float) -> Any:
    return tuple(number * factor for number in numbers)


@settings(max_examples=80)
@given(trees())
def test_locking_the_joints_that_are_found_makes_it_regular(mbs: Mbs) -> None:
    singular_joints = find_singular_joints(mbs)
    locked = {singular.joint for singular in singular_joints if singular.always}
    for number, name in enumerate(mbs.numbers()):
        joint = next(j for body in mbs.bodies for j in body.joints if j.name == name)
        if name in locked:  # at no special position
            joint.nature, joint.q = "driven", 0.7 + 0.37 * number
    assert not any(singular.always for singular in find_singular_joints(mbs))
    assert least(mbs)[0] > ABOVE


@pytest.mark.parametrize(
    ("middle", "always"),
    [
        (Joint("b", "R3", "driven", pi / 2), True),  # turns the last axis onto the first
        (Joint("b", "R2", q=pi / 2), False),
    ],
)
def test_turns_about_different_axes_may_be_about_one(middle: Joint, always: bool) -> None:
    """Though the body behind them resists everything, as a floating base does."""
    last = "R2" if middle.type == "R3" else "R3"
    body = Body("solid", None, None, [Joint("a", "R1"), middle, Joint("c", last)])
    body.mass, body.inertia = 1.0, (1.0, 0.0, 0.0, 2.0, 0.0, 2.5)
    singular_joints = find_singular_joints(Mbs("gimbal", bodies=[body]))
    assert [(singular.joint, singular.always) for singular in singular_joints] == [("a", always)]


def chain(*parts: tuple[str, float, tuple[float, float, float]]) -> Mbs:
    """Bodies in a row, each with a joint of a type, a point mass and its place."""
    bodies = []
    for number, (kind, mass, com) in enumerate(parts):
        parent = None if number == 0 else f"b{number - 1}"
        bodies.append(Body(f"b{number}", parent, None, [Joint(f"j{number}", kind)], mass, com))
    return Mbs("chain", bodies=bodies)


@pytest.mark.parametrize(
    ("parts", "told"),
    [
        ((("R1", 1.0, (0, 1, 0)), ("R2", 0.0, (0, 0, 0))), [("j1", "moves-nothing", ())]),
        (
            (("R1", 1.0, (0, 1, 0)), ("R2", 0.0, (0, 0, 0)), ("R3", 0.0, (0, 0, 0))),
            [("j1", "moves-nothing", ()), ("j2", "moves-nothing", ())],
        ),
        (
            (("R3", 0.0, (0, 0, 0)), ("T1", 0.0, (0, 0, 0)), ("T2", 1.0, (0, 0, 0))),
            [("j0", "together", ("j1", "j2"))],
        ),
        ((("R3", 1.0, (0, 0, 1)),), [("j0", "no-inertia", ())]),
        ((("R3", 0.0, (0, 0, 0)), ("R3", 1.0, (0, 1, 0))), [("j0", "together", ("j1",))]),
        (
            (("T1", 0.0, (0, 0, 0)), ("R3", 0.0, (0, 0, 0)), ("R3", 1.0, (1, 0, 0))),
            [("j1", "together", ("j2",))],
        ),
        ((("T1", 0.0, (0, 0, 0)), ("T1", 1.0, (0, 0, 0))), [("j0", "together", ("j1",))]),
        ((("T1", 0.0, (0, 0, 0)), ("T2", 1.0, (0, 0, 0))), []),
    ],
)
def test_why_a_joint_is_singular_and_what_moves_along(parts: Any, told: Any) -> None:
    singular_joints = find_singular_joints(chain(*parts))
    assert [
        (singular.joint, singular.why, singular.moves_with) for singular in singular_joints
    ] == told
    assert all(singular.always for singular in singular_joints)


def test_without_any_mass_all_joints_that_move_are_singular() -> None:
    mbs = chain(("R1", 0.0, (0, 0, 0)), ("R2", 0.0, (0, 0, 0)), ("R3", 0.0, (0, 0, 0)))
    mbs.bodies[1].joints[0].nature = "driven"
    singular_joints = find_singular_joints(mbs, {"j2": FollowerRule("j0", 1.0, 0.0)})
    assert [(singular.joint, singular.why) for singular in singular_joints] == [
        ("j0", "moves-nothing")
    ]


@pytest.mark.parametrize(("offset", "singular"), [(-0.4, ["a"]), (0.4, [])])
def test_a_follower_starts_where_its_rule_says(offset: float, singular: list[str]) -> None:
    """Together with a fixed turn it brings the last axis onto the first, or not."""
    turns = [Joint("c", "R3", "driven", 0.4), Joint("b", "R3", "dependent", offset)]
    body = Body("solid", None, None, [Joint("a", "R1"), *turns, Joint("d", "R1")])
    other_body = Body("other", None, None, [Joint("l", "R1")])
    for solid in (body, other_body):
        solid.mass, solid.inertia = 1.0, (1.0, 0.0, 0.0, 2.0, 0.0, 2.5)
    rules = {"b": FollowerRule("l", 1.0, offset)}
    singular_joints = find_singular_joints(Mbs("r", bodies=[body, other_body]), rules)
    assert [
        singular_joint.joint for singular_joint in singular_joints if not singular_joint.always
    ] == singular


@pytest.mark.parametrize(("multiplier", "always"), [(-1.0, True), (1.0, False)])
def test_followers_hold_two_axes_parallel_at_every_position(
    multiplier: float, always: bool
) -> None:
    """The follower turns back what its leader turns."""
    middle = [Joint("lead", "R2"), Joint("follow", "R2", "dependent")]
    body = Body("solid", None, None, [Joint("a", "R3"), *middle, Joint("c", "R3")])
    body.mass, body.inertia = 1.0, (1.0, 0.0, 0.0, 2.0, 0.0, 2.5)
    leader = Body("other", "solid", None, [Joint("e", "R1")], 1.0, (0.0, 1.0, 0.0))
    leader.inertia = body.inertia
    singular_joints = find_singular_joints(
        Mbs("r", bodies=[body, leader]), {"follow": FollowerRule("lead", multiplier, 0.0)}
    )
    assert ("a", always) in [
        (singular_joint.joint, singular_joint.always) for singular_joint in singular_joints
    ]


@pytest.mark.parametrize(
    ("angle", "singular"), [(pi / 2, True), (1.5708, True), (1.570797, True), (1.5712, False)]
)
def test_an_angle_in_few_digits_is_as_good_as_singular(angle: float, singular: bool) -> None:
    middle = Joint("b", "R3", "driven", angle)  # turns the last axis onto the first
    body = Body("solid", None, None, [Joint("a", "R1"), middle, Joint("c", "R2")])
    body.mass, body.inertia = 1.0, (1.0, 0.0, 0.0, 2.0, 0.0, 2.5)
    assert bool(find_singular_joints(Mbs("gimbal", bodies=[body]))) == singular


@pytest.mark.parametrize("size", [1e-8, 1.0, 1e8])
@pytest.mark.parametrize(("kind", "singular"), [("R1", True), ("R2", False)])
def test_a_rod_of_any_size_turns_freely_about_its_own_axis(
    size: float, kind: str, singular: bool
) -> None:
    turn = rotation_about_z_and_x(0.4, 0.0)
    tensor = size * turn @ np.diag((0.0, 1.0, 1.0)) @ turn.T
    joints = [Joint("c", "R3", "driven", 0.4), Joint("a", kind), Joint("d", "R3", "driven", -0.4)]
    body = Body("rod", None, None, joints, size)
    xx, xy, xz, yy, yz, zz = (float(tensor[i]) for i in zip(*np.triu_indices(3), strict=True))
    body.inertia = (xx, xy, xz, yy, yz, zz)
    singular_joints = find_singular_joints(Mbs("rod", bodies=[body]))
    assert [singular_joint.joint for singular_joint in singular_joints] == ["a"] * singular


@pytest.mark.parametrize(("inertia", "turns"), [(1e-6, True), (1e-12, True), (1e-35, False)])
def test_a_small_inertia_is_one_and_dust_is_none(inertia: float, turns: bool) -> None:
    """Of 1 kg whose centre is on the axis of its joint, in a robot of 1 m."""
    tensor = (inertia, 0.0, 0.0, inertia, 0.0, inertia)
    body = Body("b", None, None, [Joint("j", "R1", "independent")], mass=1.0, inertia=tensor)
    body.com = (1.0, 0.0, 0.0)
    assert (find_singular_joints(Mbs("r", bodies=[body])) == []) is turns


def test_rigid_bodies_without_inertia_need_no_mass_matrix(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sensor that is fixed to a hand, and a root without mass that a trunk is fixed to."""
    solid = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    root = Body("root", None, None, [Joint("lift", "T3"), Joint("turn", "R3")])
    trunk = Body("trunk", "root", None, [], mass=1.0, com=(0.0, 0.0, 0.0), inertia=solid)
    held = Joint("held", "R1", "driven", 0.4)
    sensor = Body("sensor", "trunk", None, [held], mass=0.1, com=(0.0, 0.0, 0.1))
    mbs = Mbs("robot", bodies=[root, trunk, sensor])
    monkeypatch.setattr("urdf2mbs_project.singular.find_singular_joints_at", None)
    assert find_singular_joints(mbs) == []
    held.nature = "independent"
    with pytest.raises(TypeError):
        find_singular_joints(mbs)
