"""The diagram's styles: nothing overlaps, wires are short, and one sees the robot."""

import copy
import sys
from collections.abc import Callable
from math import atan2
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import reproducible
from diagram.faults import boxes, dots, faults
from diagram.trees import LENGTHS, trees
from urdf2mbs.diagram import arrange
from urdf2mbs.mbs.model import Body, Joint, Mbs, Point, Sensor
from urdf2mbs.spatial import Vec

eighty = settings(reproducible, max_examples=80)


def grow(
    mbs: Mbs, parent: Body | None, name: str, at: Vec = (0.0, 0.0, 0.0), joints: int = 1
) -> Body:
    """A body at a point of its own on its parent."""
    point = Point(f"to_{name}", at)
    (mbs.base.points if parent is None else parent.points).append(point)
    body = Body(
        name, None if parent is None else parent.name, point.name,
        [Joint(f"{name}_j{k}", "R1") for k in range(joints)],
    )  # fmt: skip
    mbs.bodies.append(body)
    return body


@st.composite
def robots(draw: st.DrawFn) -> Mbs:
    """Random robots: a spine, limbs in pairs and alone, each with branches, frames anywhere."""
    mbs = Mbs("m")
    spine: list[Body] = []
    for k in range(draw(st.integers(1, 4))):
        up = (0.0, 0.0, 0.3) if k else (0.0, 0.0, 0.0)
        spine.append(grow(mbs, spine[-1] if k else None, f"spine{k}", up, draw(st.integers(1, 6))))

    def limb(parent: Body, name: str, at: Vec, plan: list[Any], sign: float) -> None:
        for index, (joints, step, leaves, frames) in enumerate(plan):
            body = grow(mbs, parent, f"{name}_{index}", (at[0], sign * at[1], at[2]), joints)
            body.points += [Point(f"f{k}") for k in range(frames)]
            for k in range(leaves):
                leaf = grow(mbs, body, f"{name}_{index}_leaf{k}", (0.02 * k, 0.0, -0.1), 1)
                if k == 1:
                    grow(mbs, leaf, f"{name}_{index}_tip{k}", (0.0, 0.0, -0.1), 1)
            parent, at = body, step

    steps = st.tuples(LENGTHS, LENGTHS, LENGTHS)
    part = st.tuples(
        st.integers(1, 6), steps, st.sampled_from((0, 0, 0, 1, 2, 5)), st.integers(0, 9)
    )
    for number in range(draw(st.integers(1, 4))):
        parent = draw(st.sampled_from(spine))
        at = (draw(LENGTHS), draw(st.sampled_from((0.1, 0.25))), draw(LENGTHS))
        plan = draw(st.lists(part, min_size=1, max_size=6))
        limb(parent, f"left{number}", at, plan, 1.0)
        limb(parent, f"right{number}", at, plan if draw(st.booleans()) else plan[:1], -1.0)
    for number in range(draw(st.integers(0, 4))):
        limb(
            draw(st.sampled_from(spine)), f"odd{number}", draw(steps),
            draw(st.lists(part, min_size=1, max_size=4)), 1.0,
        )  # fmt: skip
    return mbs


@eighty
@given(trees(), st.sampled_from(("robot", "tree")))
def test_no_fault_in_random_trees(mbs: Mbs, style: str) -> None:
    arrange(mbs, style)
    assert faults(mbs) == []


@pytest.mark.slow
@eighty
@given(robots())
def test_no_fault_in_random_robots(mbs: Mbs) -> None:
    arrange(mbs)
    assert faults(mbs) == []


def humanoid() -> Mbs:
    """A pelvis, a chest, a head, two arms of four bodies and two legs of four."""
    mbs = Mbs("m")
    pelvis = grow(mbs, None, "pelvis", joints=6)
    chest = grow(mbs, pelvis, "chest", (0.0, 0.0, 0.3))
    grow(mbs, chest, "head", (0.0, 0.0, 0.3))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        arm = grow(mbs, chest, f"{side}_shoulder", (0.0, 0.2 * sign, 0.2))
        for part in ("arm", "forearm", "hand"):
            arm = grow(mbs, arm, f"{side}_{part}", (0.0, 0.0, -0.2))
        leg = grow(mbs, pelvis, f"{side}_hip", (0.0, 0.1 * sign, -0.1))
        for part in ("thigh", "shank", "foot"):
            leg = grow(mbs, leg, f"{side}_{part}", (0.0, 0.0, -0.3))
    return mbs


def centres(mbs: Mbs) -> dict[str, tuple[float, float]]:
    return {b.what: ((b.left + b.right) / 2, (b.top + b.bottom) / 2) for b in boxes(mbs)}


def test_one_sees_a_humanoid() -> None:
    mbs = humanoid()
    assert arrange(mbs) == "robot"
    assert faults(mbs) == []
    at = centres(mbs)
    middle = at["pelvis"][0]
    assert at["head"][0] == at["chest"][0] == at[""][0] == middle
    assert at["head"][1] < at["chest"][1] < at["pelvis"][1] < at[""][1]
    for part in ("shoulder", "arm", "forearm", "hand", "hip", "thigh", "shank", "foot"):
        left, right = at[f"left_{part}"], at[f"right_{part}"]
        assert left[0] - middle == pytest.approx(middle - right[0], abs=0.2)
        assert left[1] == right[1]
        assert left[0] > middle  # as when somebody faces you
    assert at["left_hand"][0] > at["left_foot"][0]
    assert at["left_shoulder"][1] < at["left_forearm"][1] < at["left_hand"][1]
    assert at["left_foot"][1] > at["left_hand"][1]


def test_legs_that_are_both_a_little_to_one_side_stand_apart() -> None:
    """A calibrated Talos, whose legs were drawn one on the other."""
    mbs = humanoid()
    for body in mbs.bodies:
        for point in body.points:
            if point.name.endswith("_hip"):
                point.coordinates = (0.0, 0.03 if "left" in point.name else -0.03, -0.1)
            if point.name.endswith("_thigh"):
                point.coordinates = (0.0, 0.06, -0.3)
    assert arrange(mbs) == "robot"
    assert faults(mbs) == []
    assert centres(mbs)["left_foot"][0] != centres(mbs)["right_foot"][0]


def test_a_robot_that_faces_backwards_or_along_y() -> None:
    """The names say which side is the left one."""
    for turned in (
        lambda x, y, z: (-x, -y, z),
        lambda x, y, z: (-y, x, z),
        lambda x, y, z: (y, -x, z),
    ):
        mbs = humanoid()
        for owner in (mbs.base, *mbs.bodies):
            for point in owner.points:
                point.coordinates = turned(*point.coordinates)
        arrange(mbs)
        straight = humanoid()
        arrange(straight)
        assert centres(mbs) == centres(straight)


def test_the_start_pose_counts() -> None:
    """Limbs that only the joints' start positions put to the two sides."""
    mbs = humanoid()
    for body in mbs.bodies:
        if body.name in ("left_hip", "right_hip"):
            sign = 1.0 if body.name == "left_hip" else -1.0
            point = next(p for p in mbs.bodies[0].points if p.name == body.point)
            point.coordinates = (0.0, 1e-4 * sign, -0.1)
            body.joints.append(Joint(f"{body.name}_out", "T2", q=0.1 * sign))
    arrange(mbs)
    at = centres(mbs)
    assert at["left_foot"][0] > at["pelvis"][0] > at["right_foot"][0]


def test_partners_turn_down_at_the_same_distance() -> None:
    """The left hand is wider below, for which its arm goes farther out; the right one does too."""
    mbs = humanoid()
    hands = {body.name: body for body in mbs.bodies if "hand" in body.name}
    for name in ("thumb", "finger"):
        grow(mbs, hands["left_hand"], name, (0.0, 0.0, -0.1))
    tool = grow(mbs, hands["right_hand"], "tool", (0.0, 0.0, -0.1))
    grow(mbs, tool, "tip", (0.0, 0.0, -0.1))
    straight = humanoid()
    for one in (mbs, straight):
        arrange(one)
        assert faults(one) == []
    at, before = centres(mbs), centres(straight)
    middle = at["pelvis"][0]
    out = middle - at["right_shoulder"][0]
    assert out == pytest.approx(at["left_shoulder"][0] - middle, abs=0.2)
    assert out > before["pelvis"][0] - before["right_shoulder"][0]


def test_partners_are_counted_from_the_middle_outwards() -> None:
    """Whatever the order of their points: what is alike has boxes of one width."""
    mbs = humanoid()
    for hand, sign, names in (
        ("left_hand", 1.0, ("left_thumb", "left_finger")),
        ("right_hand", -1.0, ("right_finger_with_a_long_name", "right_thumb")),
    ):
        body = next(body for body in mbs.bodies if body.name == hand)
        for name in names:
            grow(mbs, body, name, (0.0, sign * (0.05 if "finger" in name else -0.05), -0.1))
    arrange(mbs)
    width = {box.what: box.right - box.left for box in boxes(mbs)}
    assert width["left_finger"] == width["right_finger_with_a_long_name"]
    assert width["left_thumb"] == width["right_thumb"] < width["left_finger"]


def test_partners_with_unlike_chains_are_still_drawn_alike() -> None:
    mbs = humanoid()
    for body in mbs.bodies:
        if body.name in ("left_arm", "right_shank"):
            body.joints += [Joint(f"{body.name}_more{k}", "R3") for k in range(5)]
    arrange(mbs)
    assert faults(mbs) == []
    at = centres(mbs)
    for part in ("forearm", "hand", "foot"):
        assert at[f"left_{part}"][1] == at[f"right_{part}"][1]


@pytest.mark.parametrize("kind", ["chain", "hand", "wheels", "two robots"])
def test_what_has_no_shape_is_a_tree(kind: str) -> None:
    mbs = Mbs("m")
    root = grow(mbs, None, "root", joints=6)
    if kind == "chain":
        for k in range(12):
            root = grow(mbs, root, f"b{k}", (0.1, 0.0, 0.0))
    elif kind == "hand":
        for k in range(5):
            finger = grow(mbs, root, f"f{k}", (0.01 * k, 0.02 * k - 0.03, 0.0))
            grow(mbs, finger, f"g{k}", (0.1, 0.0, 0.0))
    elif kind == "wheels":
        for k, (x, y) in enumerate(((0.2, 0.1), (0.2, -0.1), (-0.2, 0.1), (-0.2, -0.1))):
            grow(mbs, root, f"wheel{k}", (x, y, 0.0))
    else:
        grow(mbs, None, "other")
    assert arrange(mbs) == "tree"
    assert faults(mbs) == []


def test_a_parent_stands_at_the_middle_above_its_children() -> None:
    mbs = Mbs("m")
    root = grow(mbs, None, "root")
    for k in range(3):
        grow(mbs, root, f"b{k}", (0.0, 0.1 * k, 0.0))
    arrange(mbs, "tree")
    chains = [body.joints[-1].position for body in mbs.bodies[1:]]
    (left, y), (middle, _), (right, _) = [place for place in chains if place is not None]
    assert centres(mbs)["root"][0] == middle == (left + right) / 2
    assert centres(mbs)["root"][1] < y


@pytest.mark.parametrize(("count", "rows"), [(4, 4), (5, 3), (6, 4), (7, 5), (8, 6), (9, 5)])
def test_a_tower_of_joints_is_folded(count: int, rows: int) -> None:
    """Four joints in two rows, there and back; the last one stands straight before its box."""
    mbs = Mbs("m")
    body = grow(mbs, grow(mbs, None, "root"), "wrist", joints=count)
    arrange(mbs)
    assert faults(mbs) == []
    places = [joint.position or (0.0, 0.0) for joint in body.joints]
    assert len({y for _, y in places}) == rows
    assert places[0][0] == places[-1][0] == places[-2][0]
    assert len({x for x, _ in places}) == (1 if count == 4 else 2)


def test_frames_are_stacked_inside_the_box() -> None:
    mbs = Mbs("m")
    body = grow(mbs, None, "body")
    body.points += [Point(f"frame{k}") for k in range(60)]
    for point in body.points[::3]:
        point.sensor, point.extforce = Sensor(f"s_{point.name}"), Sensor(f"f_{point.name}")
    arrange(mbs)
    assert faults(mbs) == []
    box = boxes(mbs)[1]
    assert box.right - box.left < 600.0
    joint = body.joints[-1].position
    assert joint is not None
    rays = {
        round(atan2(dot.place[1] - joint[1], dot.place[0] - joint[0]), 1)
        for dot in dots(mbs)
        if dot.what.startswith("point frame")
    }
    assert len(rays) == 4  # so many arrows one sees
    for dot in dots(mbs):
        if dot.what.startswith("point frame"):
            assert box.left < dot.place[0] < box.right
            assert box.top < dot.place[1] < box.bottom


def test_the_same_model_gives_the_same_diagram_whatever_the_order_of_bodies() -> None:
    one, other = humanoid(), humanoid()
    other.bodies.sort(key=lambda body: body.name != "pelvis" and body.name != "chest")
    arrange(one)
    arrange(other)
    arrange(copy.deepcopy(one))
    assert centres(one) == centres(other)
    arrange(one)
    assert centres(one) == centres(other)


PARENTS: dict[str, Callable[[int], int]] = {
    "chain": lambda k: k - 1,
    "star": lambda k: 0,
    "comb": lambda k: (k - 1) // 2 * 2,
    "shared": lambda k: 0,
}


def many(shape: str, count: int) -> Mbs:
    mbs = Mbs("m")
    for k in range(count):
        body = grow(mbs, mbs.bodies[PARENTS[shape](k)] if k else None, f"b{k}")
        if shape == "shared":
            body.point = None
    return mbs


@pytest.mark.parametrize("shape", PARENTS)
def test_ten_times_the_bodies_take_ten_times_the_work(shape: str) -> None:
    def work(count: int) -> int:
        mbs = many(shape, count)
        calls = 0

        def counted(*_: object) -> None:
            nonlocal calls
            calls += 1

        sys.setprofile(counted)
        try:
            arrange(mbs)
        finally:
            sys.setprofile(None)
        return calls

    assert work(1_000) < 12 * work(100)
