"""The styles of the diagram: nothing overlaps, wires are short, and the robot is recognised."""

import copy
import sys
from collections.abc import Callable
from math import atan2
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.diagram_faults import boxes, dots, faults
from support.diagram_trees import LENGTHS, add_body, centres, humanoid, trees
from support.examples import reproducible
from urdf2mbs.diagram import arrange
from urdf2mbs.mbs.model import Body, Joint, Mbs, Point, Sensor
from urdf2mbs.spatial import Vec

forty = settings(reproducible, max_examples=40)


@st.composite
def robots(draw: st.DrawFn) -> Mbs:
    """Random robots: a spine, limbs in pairs and alone, each with branches, frames anywhere."""
    mbs = Mbs("m")
    spine: list[Body] = []
    for k in range(draw(st.integers(1, 4))):
        up = (0.0, 0.0, 0.3) if k else (0.0, 0.0, 0.0)
        spine.append(
            add_body(mbs, spine[-1] if k else None, f"spine{k}", up, draw(st.integers(1, 6)))
        )

    def add_limb(parent: Body, name: str, at: Vec, plan: list[Any], sign: float) -> None:
        for index, (joints, step, leaves, frames) in enumerate(plan):
            body = add_body(mbs, parent, f"{name}_{index}", (at[0], sign * at[1], at[2]), joints)
            body.points += [Point(f"f{k}") for k in range(frames)]
            for k in range(leaves):
                leaf = add_body(mbs, body, f"{name}_{index}_leaf{k}", (0.02 * k, 0.0, -0.1), 1)
                if k == 1:
                    add_body(mbs, leaf, f"{name}_{index}_tip{k}", (0.0, 0.0, -0.1), 1)
            parent, at = body, step

    steps = st.tuples(LENGTHS, LENGTHS, LENGTHS)
    part = st.tuples(
        st.integers(1, 6), steps, st.sampled_from((0, 0, 0, 1, 2, 5)), st.integers(0, 9)
    )
    for number in range(draw(st.integers(1, 4))):
        parent = draw(st.sampled_from(spine))
        at = (draw(LENGTHS), draw(st.sampled_from((0.1, 0.25))), draw(LENGTHS))
        plan = draw(st.lists(part, min_size=1, max_size=6))
        add_limb(parent, f"left{number}", at, plan, 1.0)
        add_limb(parent, f"right{number}", at, plan if draw(st.booleans()) else plan[:1], -1.0)
    for number in range(draw(st.integers(0, 4))):
        add_limb(
            draw(st.sampled_from(spine)),
            f"odd{number}",
            draw(steps),
            draw(st.lists(part, min_size=1, max_size=4)),
            1.0,
        )
    return mbs


@forty
@given(trees(), st.sampled_from(("robot", "tree")))
def test_no_fault_in_random_trees(mbs: Mbs, style: str) -> None:
    arrange(mbs, style)
    assert faults(mbs) == []


@pytest.mark.slow
@forty
@given(robots())
def test_no_fault_in_random_robots(mbs: Mbs) -> None:
    arrange(mbs)
    assert faults(mbs) == []


def test_a_humanoid_is_drawn_as_it_stands() -> None:
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
    for rotate in (
        lambda x, y, z: (-x, -y, z),
        lambda x, y, z: (-y, x, z),
        lambda x, y, z: (y, -x, z),
    ):
        mbs = humanoid()
        for owner in (mbs.base, *mbs.bodies):
            for point in owner.points:
                point.coordinates = rotate(*point.coordinates)
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
        add_body(mbs, hands["left_hand"], name, (0.0, 0.0, -0.1))
    tool = add_body(mbs, hands["right_hand"], "tool", (0.0, 0.0, -0.1))
    add_body(mbs, tool, "tip", (0.0, 0.0, -0.1))
    straight = humanoid()
    for model in (mbs, straight):
        arrange(model)
        assert faults(model) == []
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
            add_body(mbs, body, name, (0.0, sign * (0.05 if "finger" in name else -0.05), -0.1))
    arrange(mbs)
    width = {box.name: box.right - box.left for box in boxes(mbs)}
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
def test_a_robot_without_shape_is_drawn_as_a_tree(kind: str) -> None:
    mbs = Mbs("m")
    root = add_body(mbs, None, "root", joints=6)
    if kind == "chain":
        for k in range(12):
            root = add_body(mbs, root, f"b{k}", (0.1, 0.0, 0.0))
    elif kind == "hand":
        for k in range(5):
            finger = add_body(mbs, root, f"f{k}", (0.01 * k, 0.02 * k - 0.03, 0.0))
            add_body(mbs, finger, f"g{k}", (0.1, 0.0, 0.0))
    elif kind == "wheels":
        for k, (x, y) in enumerate(((0.2, 0.1), (0.2, -0.1), (-0.2, 0.1), (-0.2, -0.1))):
            add_body(mbs, root, f"wheel{k}", (x, y, 0.0))
    else:
        add_body(mbs, None, "other")
    assert arrange(mbs) == "tree"
    assert faults(mbs) == []


def test_a_parent_stands_at_the_middle_above_its_children() -> None:
    mbs = Mbs("m")
    root = add_body(mbs, None, "root")
    for k in range(3):
        add_body(mbs, root, f"b{k}", (0.0, 0.1 * k, 0.0))
    arrange(mbs, "tree")
    chains = [body.joints[-1].position for body in mbs.bodies[1:]]
    (left, y), (middle, _), (right, _) = [position for position in chains if position is not None]
    assert centres(mbs)["root"][0] == middle == (left + right) / 2
    assert centres(mbs)["root"][1] < y


@pytest.mark.parametrize(("count", "rows"), [(4, 4), (5, 3), (6, 4), (7, 5), (8, 6), (9, 5)])
def test_a_long_chain_of_joints_is_folded(count: int, rows: int) -> None:
    """Four joints are in two rows, there and back; the last one is straight before its box."""
    mbs = Mbs("m")
    body = add_body(mbs, add_body(mbs, None, "root"), "wrist", joints=count)
    arrange(mbs)
    assert faults(mbs) == []
    positions = [joint.position or (0.0, 0.0) for joint in body.joints]
    assert len({y for _, y in positions}) == rows
    assert positions[0][0] == positions[-1][0] == positions[-2][0]
    assert len({x for x, _ in positions}) == (1 if count == 4 else 2)


def test_frames_are_stacked_inside_the_box() -> None:
    mbs = Mbs("m")
    body = add_body(mbs, None, "body")
    body.points += [Point(f"frame{k}") for k in range(60)]
    for point in body.points[::3]:
        point.sensor, point.extforce = Sensor(f"s_{point.name}"), Sensor(f"f_{point.name}")
    arrange(mbs)
    assert faults(mbs) == []
    box = boxes(mbs)[1]
    assert box.right - box.left < 600.0
    joint = body.joints[-1].position
    assert joint is not None
    directions = {
        round(atan2(dot.position[1] - joint[1], dot.position[0] - joint[0]), 1)
        for dot in dots(mbs)
        if dot.name.startswith("point frame")
    }
    assert len(directions) == 4  # arrows with different directions
    for dot in dots(mbs):
        if dot.name.startswith("point frame"):
            assert box.left < dot.position[0] < box.right
            assert box.top < dot.position[1] < box.bottom


def test_the_same_model_gives_the_same_diagram_whatever_the_order_of_bodies() -> None:
    original, reordered = humanoid(), humanoid()
    reordered.bodies.sort(key=lambda body: body.name != "pelvis" and body.name != "chest")
    arrange(original)
    arrange(reordered)
    arrange(copy.deepcopy(original))
    assert centres(original) == centres(reordered)
    arrange(original)
    assert centres(original) == centres(reordered)


PARENTS: dict[str, Callable[[int], int]] = {
    "chain": lambda k: k - 1,
    "star": lambda k: 0,
    "comb": lambda k: (k - 1) // 2 * 2,
    "shared": lambda k: 0,
}


def build_large_tree(shape: str, count: int) -> Mbs:
    mbs = Mbs("m")
    for k in range(count):
        body = add_body(mbs, mbs.bodies[PARENTS[shape](k)] if k else None, f"b{k}")
        if shape == "shared":
            body.point = None
    return mbs


@pytest.mark.parametrize("shape", PARENTS)
def test_the_work_is_proportional_to_the_number_of_bodies(shape: str) -> None:
    def count_calls(count: int) -> int:
        mbs = build_large_tree(shape, count)
        calls = 0

        def count(*_: object) -> None:
            nonlocal calls
            calls += 1

        sys.setprofile(count)
        try:
            arrange(mbs)
        finally:
            sys.setprofile(None)
        return calls

    assert count_calls(1_000) < 12 * count_calls(100)
