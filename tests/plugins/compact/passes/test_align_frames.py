"""Align frames: the fewest joints for given directions, and the same robot."""

from itertools import pairwise, product
from math import radians
from random import Random

import numpy as np
import pytest

from support.build import SOLID, joint, link, robot
from support.oracle.multibody import Array, rotation
from support.oracle.urdf import Urdf
from support.proving import chains, driven, prove
from urdf2mbs.testing import convert_text


def arm(*axes: str, rpy: str = "0 0 0") -> str:
    """Return a chain of revolute joints on the world."""
    names = ["world", *(f"l{i}" for i in range(len(axes)))]
    links = [link(name, SOLID) for name in names[1:]]
    joints = [
        joint(*ends, axis=axis, rpy=rpy) for ends, axis in zip(pairwise(names), axes, strict=True)
    ]
    return robot(link("world"), *links, *joints)


@pytest.mark.parametrize(
    ("axis", "types"),
    [
        ("1 0 0", "R1"),
        ("0 1 0", "R2"),
        ("0 0 1", "R3"),
        ("-1 0 0", "r R"),
        ("0 -1 0", "r R"),
        ("0 0 -1", "r R"),
        ("0 1 1", "r1 R"),
        ("2 0 -1", "r2 R"),
        ("-1 -3 0", "r3 R"),
        ("1 2 3", "r r R"),
        ("1 1e-8 1", "r r R"),
        ("-1 -1 -1", "r r R"),
    ],
)
def test_an_axis_takes_as_few_turns_as_its_direction_needs(axis: str, types: str) -> None:
    (found,) = chains(prove(arm(axis), base="fixed")).values()
    assert len(found) == len(types.split())
    assert all(one.startswith(start) for one, start in zip(found, types.split(), strict=True))


def test_joints_at_right_angles_need_nothing() -> None:
    """Whatever the frames of the links are."""
    assert driven(prove(arm("0 0 1", "0 1 0", "1 0 0", "0 0 1"), base="fixed")) == 0
    links = [link("world"), link("a", SOLID), link("b", SOLID), link("c", SOLID)]
    # z of the world; then its y, in a link frame that is turned by 0.3; then its x
    joints = [
        joint("world", "a", rpy="0 0 0.3"),
        joint("a", "b", rpy="0 0 -0.3", axis="0 1 0"),
        joint("b", "c", rpy="0.7 0 0", axis="1 0 0"),
    ]
    assert driven(prove(robot(*links, *joints), base="fixed")) == 0


@pytest.mark.parametrize("axis", ["1 2e-9 0", "1 -1e-8 3e-9", "-1 1e-6 1e-8"])
def test_an_axis_nearly_along_another_is_exact(axis: str) -> None:
    prove(arm("1 0 0", axis, "1 0 0", "0 1 0"), base="fixed")


@pytest.mark.parametrize(
    ("axis", "types"), [("0 0 1", ["T1 T2 R3"]), ("1 2 3", ["T1 T2 R3", "T2 T3 R1", "T3 T1 R2"])]
)
def test_a_planar_joint_keeps_its_plane(axis: str, types: list[str]) -> None:
    text = robot(
        link("world"),
        link("a", SOLID),
        link("b", SOLID),
        joint("world", "a", "planar", axis=axis),
        joint("a", "b", axis="0 1 0"),
    )
    found = chains(prove(text, base="fixed"))["a"]
    assert " ".join(one for one in found if one.isupper()) in types


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_a_floating_joint_keeps_its_axes(base: str) -> None:
    """Those of its origin in the link before, which an oblique joint has turned."""
    text = robot(
        link("world"),
        link("a", SOLID),
        link("b", SOLID),
        link("c", SOLID),
        joint("world", "a", axis="1 2 3"),
        joint("a", "b", "floating", rpy="0.1 0.2 0.3"),
        joint("b", "c", axis="0 0 1"),
    )
    found = chains(prove(text, base=base))
    assert found["b"][-6:] == ["T1", "T2", "T3", "R1", "R2", "R3"]
    assert found["c"] == ["R3"]


def test_a_turned_fixed_joint_that_is_a_joint_still_needs_no_turns() -> None:
    text = robot(
        *(link(name, SOLID) for name in "abc"),
        link("world"),
        joint("world", "a", axis="1 2 3"),
        joint("a", "b", "fixed", rpy="0.1 0.2 0.3", xyz="1 2 3"),
        joint("b", "c", axis="0 1 1", xyz="1 0 0"),
    )
    assert chains(prove(text, base="fixed", without=["lump-fixed"]))["b"] == ["t3"]


@pytest.mark.parametrize("axis", ["0 1 1", "1 2 3", "0 0 -1"])
def test_a_frame_in_the_middle_of_a_chain_stays_known(axis: str) -> None:
    text = robot(
        link("world"),
        link("middle"),
        link("tip", SOLID),
        joint("world", "middle", axis=axis, rpy="0.1 0.2 0.3"),
        joint("middle", "tip", axis="3 -1 2", rpy="0.3 0.2 0.1"),
    )
    assert prove(text).frames["middle"].joint == "world_to_middle"


# -- the choice of quarter turns against all there are -----------------------------------------


def tree(random: Random, count: int) -> str:
    """Draw revolute joints at multiples of 15 degrees and in between, on the world."""
    step = radians(random.choice((90, 90, 45, 30, 15)))

    def angle() -> float:
        return step * random.randrange(-6, 7) if random.random() < 0.8 else random.uniform(-3, 3)

    names = ["world"]
    elements = [link("world")]
    for i in range(count):
        parent = names[-1] if random.random() < 0.6 else random.choice(names)
        names.append(f"l{i}")
        rpy = " ".join(repr(angle() if random.random() < 0.5 else 0.0) for _ in range(3))
        axis = random.choice(("1 0 0", "0 1 0", "0 0 1", "0 0 -1", "0 1 1", "1 2 3"))
        elements += [link(f"l{i}", SOLID), joint(parent, f"l{i}", rpy=rpy, axis=axis)]
    return robot(*elements)


def fewest(text: str) -> int:
    """Count the fewest turns of all choices of quarter turns, of frames in the world at zero."""
    urdf = Urdf.parse(text.encode())
    pose, frames = {urdf.root: np.eye(4)}, {urdf.root: [np.eye(3)]}
    for one in urdf.outward:
        pose[one.child] = pose[one.parent] @ one.origin
        axis = pose[one.child][:3, :3] @ one.axis
        toward = (np.cross(axis, before) for before in frames[one.parent][0].T)
        y = next(v / length for v in toward if (length := np.linalg.norm(v)) > 1e-9)
        frames[one.child] = [
            rotation(axis, radians(90 * quarter)) @ np.column_stack((axis, y, np.cross(axis, y)))
            for quarter in range(4)
        ]
    names = list(frames)
    tables = [
        (
            names.index(one.parent),
            names.index(one.child),
            [[turns(a.T @ b) for b in frames[one.child]] for a in frames[one.parent]],
        )
        for one in urdf.outward
    ]
    choices = product(*(range(len(found)) for found in frames.values()))
    return min(sum(table[way[a]][way[b]] for a, b, table in tables) for way in choices)


def turns(rot: Array) -> int:
    """How many turns a rotation takes, any axis of the joint's becoming x, y or z."""
    zero = np.abs(rot) < 1e-12
    if not zero.any():
        return 3
    return (2, 1, 1, 0)[int(((rot > 0.5) & (zero.sum(axis=1, keepdims=True) == 2)).sum())]


@pytest.mark.parametrize("seed", range(30))
def test_no_quarter_turns_do_with_fewer(seed: int) -> None:
    text = tree(Random(seed), 5)
    found = driven(prove(text, base="fixed"))
    assert found == fewest(text)
    assert found <= driven(convert_text(text, base="fixed", pipeline="faithful"))
