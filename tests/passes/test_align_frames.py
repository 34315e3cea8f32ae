"""Align frames: the fewest joints for given directions, and the same robot."""

from __future__ import annotations

from itertools import pairwise
from math import pi, radians
from random import Random
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from evaluator import rotation
from hypothesis import given, settings
from hypothesis import strategies as st
from proving import SOLID, chains, driven, joint, link, prove, robot

from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.passes.align_frames import AlignFrames, _across, _exchange, _Search
from urdf2mbs.spatial import dot, fewest_turns, from_rpy, unit
from urdf2mbs.testing import convert_text

if TYPE_CHECKING:
    from evaluator import Array

reproducible = settings(max_examples=300, derandomize=True, deadline=None, database=None)


def arm(*axes: str, rpy: str = "0 0 0") -> str:
    """A chain of turning joints on the world."""
    names = ["world", *(f"l{i}" for i in range(len(axes)))]
    links = [link(name, SOLID) for name in names[1:]]
    joints = [
        joint(*ends, axis=axis, rpy=rpy) for ends, axis in zip(pairwise(names), axes, strict=True)
    ]
    return robot(link("world"), *links, *joints)


@pytest.mark.parametrize(
    ("axis", "types"),
    [
        ("1 0 0", ["R1"]),
        ("0 1 0", ["R2"]),
        ("0 0 1", ["R3"]),
        ("-1 0 0", ["r", "R"]),
        ("0 -1 0", ["r", "R"]),
        ("0 0 -1", ["r", "R"]),
        ("0 1 1", ["r1", "R"]),
        ("2 0 -1", ["r2", "R"]),
        ("-1 -3 0", ["r3", "R"]),
        ("1 2 3", ["r", "r", "R"]),
        ("1 1e-8 1", ["r", "r", "R"]),
        ("-1 -1 -1", ["r", "r", "R"]),
    ],
)
def test_turns_before_a_joint(axis: str, types: list[str]) -> None:
    (found,) = chains(prove(arm(axis), base="fixed")).values()
    assert len(found) == len(types)
    assert all(one.startswith(start) for one, start in zip(found, types, strict=True))


@pytest.mark.parametrize("axes", ["x", "y", "z"])
@pytest.mark.parametrize("kind", ["continuous", "prismatic"])
def test_a_single_axis(axes: str, kind: str) -> None:
    letter = "T" if kind == "prismatic" else "R"
    for directions in (["1 0 0", "0 1 0", "0 0 1"], ["1 2 3", "0 -1 1", "1 0 0", "1 0 0"]):
        text = arm(*directions, rpy="0.1 0 0.2").replace('"continuous"', f'"{kind}"')
        result = prove(text, base="fixed", options={"align-frames": {"axes": axes}})
        last = {chain[-1] for chain in chains(result).values()}
        assert last == {f"{letter}{'xyz'.index(axes) + 1}"}


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


def test_a_frame_serves_all_that_its_body_carries() -> None:
    """Four joints across the body's own, 45 degrees off the axes of every link frame."""
    links = [link("world"), link("body", SOLID), *(link(f"leg{i}", SOLID) for i in range(4))]
    legs = [
        joint("body", f"leg{i}", axis=axis, xyz=f"{i} 0 0")
        for i, axis in enumerate(("0 1 1", "0 1 -1", "0 1 1", "0 -1 1"))
    ]
    result = prove(robot(*links, joint("world", "body", axis="1 0 0"), *legs), base="fixed")
    # the body is turned, once for all; two axes at right angles, and one that is backwards
    assert driven(result) <= 1 + 1
    assert chains(result)["body"] == ["r1", "R1"]


def test_a_frame_serves_those_beyond_parallel_joints() -> None:
    links = [link(name, SOLID) for name in ("a", "b1", "b2", "b3", "c1", "c2", "c3")]
    joints = [joint("world", "a")]
    for i in "123":
        joints += [joint("a", f"b{i}", xyz="0 0 1"), joint(f"b{i}", f"c{i}", axis="1 1 0")]
    result = prove(robot(link("world"), *links, *joints), base="fixed")
    assert driven(result) == 1
    assert chains(result)["a"] == ["r3", "R3"]


@pytest.mark.parametrize("axes", ["any", "x"])
@pytest.mark.parametrize("axis", ["1 2e-9 0", "1 -1e-8 3e-9", "-1 1e-6 1e-8"])
def test_an_axis_nearly_along_another_is_exact(axis: str, axes: str) -> None:
    options = {"align-frames": {"axes": axes}}
    prove(arm("1 0 0", axis, "1 0 0", "0 1 0"), base="fixed", options=options)


def test_a_floating_base_is_turned_if_it_pays() -> None:
    legs = [joint("trunk", f"leg{i}", axis="1 2 3", xyz=f"{i} 0 0") for i in range(4)]
    links = [link(f"leg{i}", SOLID) for i in range(4)]
    many = prove(robot(link("trunk", SOLID), *links, *legs), base="floating")
    one = prove(robot(link("trunk", SOLID), links[0], legs[0]), base="floating")
    assert driven(many) == 2
    assert chains(many)["trunk"][:6] == ["T1", "T2", "T3", "R1", "R2", "R3"]
    assert driven(one) == 2
    assert len(chains(one)["trunk"]) + len(chains(one)["leg0"]) == 9


def test_a_planar_joint_keeps_its_plane() -> None:
    text = robot(
        link("world"), link("a", SOLID), link("b", SOLID),
        joint("world", "a", "planar", axis="0 0 1"), joint("a", "b", "planar", axis="1 2 3"),
    )  # fmt: skip
    found = chains(prove(text, base="fixed"))
    assert found["a"] == ["T1", "T2", "R3"]
    assert [one for one in found["b"] if one.isupper()] in (
        ["T1", "T2", "R3"], ["T2", "T3", "R1"], ["T3", "T1", "R2"],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("axis", "axes", "found"),
    [
        ("1 0 0", "any", "T2 T3 R1"), ("1 0 0", "y", "r1 r3 T3 T1 R2"),
        ("1 0 0", "z", "r1 r2 T1 T2 R3"), ("0 1 0", "any", "T3 T1 R2"),
        ("0 1 0", "x", "r1 r2 T2 T3 R1"), ("0 0 1", "y", "r1 r2 T3 T1 R2"),
        ("0 0 1", "z", "T1 T2 R3"), ("0 -1 0", "y", "r1 T3 T1 R2"),
    ],
)  # fmt: skip
def test_a_planar_joint_turns_about_the_axis_asked_for(axis: str, axes: str, found: str) -> None:
    text = robot(
        link("world"), link("a", SOLID), link("b", SOLID),
        joint("world", "a", "planar", axis=axis), joint("a", "b", axis="0 1 0"),
    )  # fmt: skip
    result = prove(text, base="fixed", options={"align-frames": {"axes": axes}})
    assert " ".join(chains(result)["a"]) == found
    for step in result.conversion.steps():
        assert sorted(map(abs, step.axis)) == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("axis", "fixed", "moving"),
    [("1 2 3", 3, 2), ("-1 -2 -3", 3, 2), ("1 1 0", 2, 1), ("0 1 1", 3, 1), ("-1 0 0", 2, 1)],
)
@pytest.mark.parametrize("fingers", [2, 4])
def test_a_palm_is_turned_for_all_its_fingers(
    axis: str, fixed: int, moving: int, fingers: int
) -> None:
    for kind, rpy, wanted in (("fixed", "0 0 0.5", fixed), ("continuous", "0 0 0", moving)):
        elements = [
            link("world"), link("palm", SOLID), link("other", SOLID), joint("world", "other"),
            joint("world", "palm", kind, rpy=rpy, axis="0 0 1", xyz="1 2 3"),
        ]  # fmt: skip
        for i in range(fingers):
            elements += [link(f"f{i}", SOLID), joint("palm", f"f{i}", xyz=f"{i} 0 0", axis=axis)]
        result = prove(robot(*elements), base="fixed")
        assert driven(result) == wanted
        # else the palm is a part of the ground
        codes = {found.code for found in result.diagnostics}
        assert ("ground-mass" in codes) is ("palm" not in chains(result))


@pytest.mark.parametrize("shift", range(3))
def test_a_palm_is_turned_for_a_plane_of_its_fingers(shift: int) -> None:
    """Two fingers across the plane stay as they are, and each of three in it needs a turn less."""
    elements = [link("world"), link("palm", SOLID)]
    elements.append(joint("world", "palm", "fixed", rpy="0.1 0.2 0.3"))
    for i, axis in enumerate(("0 1 0", "0 1 0", "1 2 1", "1 -3 1", "1 1 1")):
        turned = " ".join((axis.split() * 2)[shift : shift + 3])
        elements += [link(f"f{i}", SOLID), joint("palm", f"f{i}", xyz=f"{i} 0 0", axis=turned)]
    assert driven(prove(robot(*elements), base="fixed")) == 3 + 1 + 3


@pytest.mark.parametrize("options", [{"axes": "w"}, {"candidate": 3}, {"tolerance": "much"}])
def test_wrong_options_are_named(options: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match=next(iter(options))):
        prove(arm("0 0 1"), options={"align-frames": options})


@pytest.mark.slow
def test_the_search_is_never_worse_with_more_candidates() -> None:
    random = Random(5)
    for _ in range(20):
        text = tree(random, 6)
        found = [
            driven(prove(text, base="fixed", options={"align-frames": {"candidates": n}}))
            for n in (1, 6, 40)
        ]
        assert found[0] >= found[1] >= found[2]


@st.composite
def fans(draw: Any) -> str:
    """Links behind turned fixed joints and oblique moving joints, with several joints each."""
    elements, links = [link("world")], ["world"]
    for i in range(draw(st.integers(1, 5))):
        kind = draw(
            st.sampled_from(("fixed", "fixed", "continuous", "prismatic", "planar", "floating"))
        )
        rpy = draw(st.sampled_from(("1.5708 0 0", "0 1.5708 0", "0.3 0.2 0.1", "0 0 0", "1 -1 0")))
        axis = draw(st.sampled_from(("0 0 1", "1 2 3", "0 1 -1", "-1 0 0")))
        parent, palm = draw(st.sampled_from(links)), f"palm{i}"
        content = (SOLID,) if draw(st.booleans()) else ()
        elements += [
            link(palm, *content), joint(parent, palm, kind, xyz="0.1 0.2 0.3", rpy=rpy, axis=axis)
        ]  # fmt: skip
        links.append(palm)
        for k in range(draw(st.sampled_from((0, 1, 2, 4, 6)))):
            axis = draw(st.sampled_from(("1 0 0", "0 1 0", "0 0 1")))
            finger = f"finger{i}_{k}"
            elements += [link(finger, SOLID), joint(palm, finger, xyz=f"{k} 0.2 0", axis=axis)]
    return robot(*elements, link("end", SOLID), joint(links[-1], "end"))


@settings(parent=reproducible, max_examples=100)
@given(text=fans())
def test_compact_never_has_more_joints_than_faithful(text: str) -> None:
    faithful = convert_text(text, base="fixed", pipeline="faithful")
    compact = prove(text, base="fixed")
    assert driven(compact) <= driven(faithful)


def test_a_turned_fixed_joint_that_is_a_joint_still_needs_no_turns() -> None:
    text = robot(
        *(link(name, SOLID) for name in "abcde"), link("world"),
        joint("world", "a", axis="1 2 3"), joint("a", "b", "fixed", rpy="0.1 0.2 0.3", xyz="1 2 3"),
        *(joint("b", name, axis="0 1 1", xyz="1 0 0") for name in "cde"),
    )  # fmt: skip
    result = prove(text, base="fixed", without=["lump-fixed"])
    found = chains(result)
    assert found["b"][-1] == "t3"
    assert [len(found[name]) for name in "cde"] == [1, 1, 1]
    assert driven(result) == 6


ANGLES = st.sampled_from([0.0, 0.0, pi / 2, -pi / 2, pi, pi / 4, 0.3, -2.0])


@reproducible
@given(st.tuples(ANGLES, ANGLES, ANGLES), st.tuples(ANGLES, ANGLES, ANGLES))
def test_turns_are_counted_as_they_will_be(one: tuple[float, ...], two: tuple[float, ...]) -> None:
    """The search counts zeros; what is written comes from ``fewest_turns``."""
    rot = from_rpy((one[0], one[1], two[2]))
    ways = [len(fewest_turns(_exchange(rot, by))) for by in range(3)]
    assert _Search(AlignFrames()).turns(rot) == min(ways)
    assert _Search(AlignFrames(axes="y")).turns(rot) == ways[0]


# -- the search against all there is ----------------------------------------------------------


def tree(random: Random, count: int) -> str:
    """Turning joints at multiples of 15 degrees and in between, on the world."""
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


def exhaustive(text: str) -> int:
    """The fewest turns of all choices of a frame for each body, from a large set of frames.

    In the world at zero: each frame has its joint's axis for one of its own, and another one
    across this axis towards any other joint's axis, any axis of the world or of another body's
    frame so made, or at 15 degrees to these.
    """
    from reference import Urdf

    urdf = Urdf.parse(text.encode())
    pose = {urdf.root: np.eye(4)}
    for one in urdf.outward:
        pose[one.child] = pose[one.parent] @ one.origin
    axis = {one.child: pose[one.child][:3, :3] @ one.axis for one in urdf.outward}
    seen = [*np.eye(3), *axis.values()]
    first = {name: frames(a, seen) for name, a in axis.items()}
    seen += [f[:, i] for found in first.values() for f in found[::4] for i in range(3)]
    all_frames = {name: frames(a, seen, grid=True)[:400] for name, a in axis.items()}
    cost = {name: np.zeros(len(found)) for name, found in all_frames.items()}
    total = 0.0
    for one in reversed(urdf.outward):
        before = [np.eye(3)] if one.parent == urdf.root else all_frames[one.parent]
        after = all_frames[one.child]
        turns = count(np.einsum("aji,bjk->abik", np.array(before), np.array(after)))
        best = (turns + cost[one.child]).min(axis=1)
        if one.parent == urdf.root:
            total += float(best[0])
        else:
            cost[one.parent] = cost[one.parent] + best
    return int(total)


def frames(axis: Array, seen: list[Array], grid: bool = False) -> list[Array]:
    """With the axis as x, the quarter turns together; doubles are left out."""
    found: list[Array] = []
    for direction in seen:
        across = np.cross(axis, direction)
        if np.linalg.norm(across) < 1e-9:
            continue
        across /= np.linalg.norm(across)
        for turn in range(0, 90, 15) if grid else (0,):
            y = rotation(axis, radians(turn)) @ across
            z = np.cross(axis, y)
            if all(min(abs(f[:, 1] @ y), abs(f[:, 1] @ z)) > 1e-9 for f in found[::4]):
                found += [
                    np.column_stack((axis, *pair)) for pair in ((y, z), (z, -y), (-y, -z), (-z, y))
                ]
    return found


def count(rot: Array) -> Array:
    """(..., 3, 3): how many turns each takes, any axis of the joint's becoming x, y or z."""
    zero = np.abs(rot) < 1e-12
    one = (rot > 0) & (zero.sum(axis=-1, keepdims=True) == 2) & ~zero
    ones = one.sum(axis=(-1, -2))
    return np.where(ones == 3, 0, np.where(ones > 0, 1, np.where(zero.any(axis=(-1, -2)), 2, 3)))


@pytest.mark.parametrize("seed", range(30))
def test_no_choice_of_frames_does_with_fewer(seed: int) -> None:
    text = tree(Random(seed), 4)
    found = driven(prove(text, base="fixed"))
    assert found <= exhaustive(text)


@pytest.mark.parametrize("off", [1e-11, 1e-9, 1e-6, 1e-3, 1.0])
def test_what_is_across_an_axis_is_so_to_the_last_digit(off: float) -> None:
    """However nearly along it lies: the rounding of the first subtraction is as large as it."""
    axis = unit((1.0, 2.0, 3.0))
    aside = unit((3.0, -3.0, 1.0))
    x, y, z = (a + off * b for a, b in zip(axis, aside, strict=True))
    across = _across((x, y, z), axis, 1e-12)
    assert across is not None
    assert abs(dot(across, axis)) <= 3e-16


@pytest.mark.parametrize("axis", ["0 1 1", "1 2 3", "0 0 -1"])
def test_a_frame_in_the_middle_of_a_chain_stays_known(axis: str) -> None:
    text = robot(
        link("world"), link("middle"), link("tip", SOLID),
        joint("world", "middle", axis=axis, rpy="0.1 0.2 0.3"),
        joint("middle", "tip", axis="3 -1 2", rpy="0.3 0.2 0.1"),
    )  # fmt: skip
    assert prove(text).frames["middle"].joint == "world_to_middle"
