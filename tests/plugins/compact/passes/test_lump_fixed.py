"""Lump fixed: what moves as one is one body, and every frame stays known."""

from itertools import pairwise

import pytest

from support.build import BOX, SOLID, joint, link, robot
from support.oracle.mbs import Evaluator
from support.proving import chains, prove
from urdf2mbs import Result

TURNED = {"xyz": "0.1 0.2 0.3", "rpy": "0.1 0.2 0.3"}


def row(kinds: str, *, keep: tuple[str, ...] = (), base: str = "fixed") -> Result:
    """Return a chain ``a - b - c ...`` on the world of fixed (f) and revolute (r) joints."""
    names = ["world", *"abcdefgh"[: len(kinds)]]
    joints = [
        joint(*ends, {"f": "fixed", "r": "continuous"}[kind], axis="0 1 1", **TURNED)
        for ends, kind in zip(pairwise(names), kinds, strict=True)
    ]
    text = robot(link("world"), *(link(name, SOLID, BOX) for name in names[1:]), *joints)
    return prove(text, base=base, passes={"lump-fixed": {"keep": list(keep)}})


def bodies(result: Result) -> list[str]:
    return [body.name for body in result.mbs.bodies]


@pytest.mark.parametrize(
    ("kinds", "found"),
    [
        ("fr", ["b"]),  # first
        ("rf", ["a"]),  # last
        ("rfr", ["a", "c"]),  # in the middle
        ("ffrffrff", ["c", "f"]),
        ("rrr", ["a", "b", "c"]),
    ],
)
def test_fixed_joints_anywhere_in_a_chain(kinds: str, found: list[str]) -> None:
    result = row(kinds)
    assert bodies(result) == found
    assert "t3" not in [t for chain in chains(result).values() for t in chain]
    # what is fixed to the root floats with it
    assert bodies(row(kinds, base="floating")) == ["world", *found]


def test_a_lumped_frame_is_a_point_under_its_name_and_its_turn_is_reported() -> None:
    result = row("rff")
    (body,) = result.mbs.bodies
    # of the three links the body's own frame needs none
    assert [point.name for point in body.points] == ["b", "c"]
    assert body.points[0].coordinates == result.frames["b"].pose.xyz
    assert result.frames["c"].body == "a"
    assert result.report.frames["c"].pose.rot == result.frames["c"].pose.rot
    turned = [
        diagnostic
        for diagnostic in result.diagnostics
        if diagnostic.code == "point-without-rotation"
    ]
    assert "b, c" in turned[0].message
    # two boxes moved along with their links
    assert len(body.shapes) == 3


def test_what_is_fixed_to_the_ground_becomes_ground() -> None:
    result = row("ffrf")
    assert bodies(result) == ["c"]
    assert [shape.name for shape in result.mbs.base.shapes] == ["a", "b"]
    assert {p.name for p in result.mbs.base.points} >= {"a", "b"}
    assert result.frames["b"].body is None
    (told,) = [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "ground-mass"]
    assert "4 kg" in told.message
    assert told.message.endswith("a, b")


@pytest.mark.parametrize("count", [1, 3])
def test_where_nothing_moves_one_body_stays(count: int) -> None:
    result = row("f" * count)
    assert chains(result) == {"a": ["t3"]}
    assert result.report.mass == pytest.approx(2.0 * count)
    assert not [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "ground-mass"]
    Evaluator(result.data)


def test_where_nothing_moves_and_all_hangs_on_the_ground() -> None:
    text = robot(
        link("world"),
        *(link(name, SOLID) for name in "abc"),
        *(joint("world", name, "fixed", **TURNED) for name in "abc"),
    )
    result = prove(text, base="fixed")
    assert chains(result) == {"a": ["t3"]}
    (told,) = [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "ground-mass"]
    assert told.message.endswith("b, c")


@pytest.mark.parametrize(
    ("kinds", "keep", "found"),
    [
        ("rff", ("b",), {"a": "R", "b": "t3"}),
        ("rff", ("c",), {"a": "R", "c": "t3"}),
        ("rff", ("b", "c"), {"a": "R", "b": "t3", "c": "t3"}),  # one on the other
        ("rfff", ("b", "d"), {"a": "R", "b": "t3", "d": "t3"}),
        ("ff", ("a", "b"), {"a": "t3", "b": "t3"}),  # on the ground
        ("frf", ("*",), {"a": "t3", "b": "R", "c": "t3"}),
        ("rf", ("B", "x*"), {"a": "R"}),  # patterns are of links, and case counts
    ],
)
def test_a_kept_link_stays_a_body_of_its_own(
    kinds: str, keep: tuple[str, ...], found: dict[str, str]
) -> None:
    result = row(kinds, keep=keep)
    last = {name: chain[-1] for name, chain in chains(result).items()}
    assert {name: kind if kind == "t3" else kind[0] for name, kind in last.items()} == found
    assert all(result.frames[name].body == name for name in found)


def test_a_kept_link_behind_a_moving_massless_one_needs_no_joint_of_its_own() -> None:
    text = robot(
        link("world"),
        link("frame"),
        link("tip", SOLID),
        joint("world", "frame"),
        joint("frame", "tip", "fixed", rpy="0.1 0.2 0.3"),
    )
    result = prove(text, base="fixed", passes={"lump-fixed": {"keep": ["tip"]}})
    assert chains(result) == {"tip": ["R3"]}
