"""Collect anchors: where bodies are attached, and where the frames of other links are."""

import pytest

from support.build import SOLID, joint, link, robot
from support.presets import PRESETS
from support.proving import prove
from urdf2mbs import Result
from urdf2mbs.testing import convert_text


def anchored(*elements: str, root: str = "world", pipeline: str = "") -> Result:
    text = robot(link(root), *elements)
    base = "fixed"
    if pipeline:
        return prove(text, pipeline=pipeline, base=base)
    passes = ["expand", "insert-base", "prune-massless", "collect-anchors"]
    return convert_text(text, base=base, pipeline=passes)


def points(result: Result) -> dict[str, list[tuple[str, tuple[float, float, float]]]]:
    bodies = {"ground": result.mbs.base.points}
    bodies |= {body.name: body.points for body in result.mbs.bodies}
    return {name: [(p.name, p.coordinates) for p in found] for name, found in bodies.items()}


A, B, C = (link(name, SOLID) for name in "abc")


def test_a_body_stands_on_a_point_of_its_parent_named_after_it() -> None:
    result = anchored(A, B, joint("world", "a", xyz="1 0 0"), joint("a", "b", xyz="0 2 0"))
    a, b = result.mbs.bodies
    assert points(result) == {
        "ground": [("a", (1.0, 0.0, 0.0))],
        "a": [("b", (0.0, 2.0, 0.0))],
        "b": [],
    }
    assert (a.parent, a.point) == (None, "a")
    assert (b.parent, b.point) == ("a", "b")


def test_on_the_origin_of_the_base_no_point_is_needed_and_on_a_body_there_is_one() -> None:
    result = anchored(A, B, joint("world", "a", rpy="0 0 1"), joint("a", "b"))
    a, b = result.mbs.bodies
    assert (a.parent, a.point) == (None, None)
    assert (b.parent, b.point) == ("a", "b")
    assert points(result) == {"ground": [], "a": [("b", (0.0, 0.0, 0.0))], "b": []}


def test_bodies_first_then_frames_in_the_order_of_the_file() -> None:
    result = anchored(
        A,
        link("p"),
        B,
        link("q"),
        C,
        joint("world", "a", xyz="0 0 1"),
        joint("a", "p", "fixed", xyz="1 0 0"),
        joint("a", "b", xyz="2 0 0"),
        joint("a", "q", "fixed", xyz="3 0 0"),
        joint("a", "c", xyz="4 0 0"),
    )
    assert [name for name, _ in points(result)["a"]] == ["b", "c", "p", "q"]


def test_a_turned_frame_is_named_in_a_note_and_a_straight_one_is_not() -> None:
    result = anchored(
        A,
        link("p"),
        link("q"),
        link("mark"),
        joint("world", "a"),
        joint("a", "p", "fixed", rpy="0 0 1"),
        joint("a", "q", "fixed", xyz="1 0 0"),
        joint("world", "mark", "fixed", xyz="7 8 9"),
    )
    assert points(result)["ground"] == [("mark", (7.0, 8.0, 9.0))]
    (warning,) = [
        diagnostic
        for diagnostic in result.diagnostics
        if diagnostic.code == "point-without-rotation"
    ]
    assert warning.level == "note"
    assert warning.message.endswith(": p")


@pytest.mark.skipif("compact" not in PRESETS, reason="the plugin compact is away")
def test_the_bodys_own_link_has_a_point_only_where_its_frame_was_moved() -> None:
    """compact moves a body's frame along its axis; then the link's frame is a point of it."""
    chain = (A, link("m"), B, joint("world", "a", xyz="1 1 0"), joint("a", "m"))
    moved = anchored(*chain, joint("m", "b", xyz="1 0 0", axis="1 0 0"), pipeline="compact")
    assert ("b", (1.0, 0.0, 0.0)) in points(moved)["b"]
    straight = anchored(*chain, joint("m", "b", axis="1 0 0"), pipeline="compact")
    assert points(straight)["b"] == []
