"""Prune massless: which links become bodies, and where the frames of the others go."""

import pytest

from support.build import BOX, SOLID, joint, link, robot
from support.proving import prove
from urdf2mbs import Result
from urdf2mbs.testing import convert_text


def pruned(*elements: str, keep: tuple[str, ...] = ()) -> Result:
    text = robot(link("world"), *elements)
    result = convert_text(
        text,
        pipeline=["expand", "insert-base", "prune-massless"],
        passes={"prune-massless": {"keep": list(keep)}},
    )
    # and by physics
    prove(text, pipeline="faithful", passes={"prune-massless": {"keep": list(keep)}})
    return result


def steps(result: Result) -> dict[str, list[str]]:
    """Return the children of the URDF joints that lead to each body."""
    return {
        segment.link: [step.joint.child for step in segment.steps]
        for segment in result.conversion.segments.values()
        if segment.parent is not None
    }


def parts(result: Result) -> dict[str, list[str]]:
    return {s.link: list(s.parts) for s in result.conversion.segments.values()}


HAND = (link("hand", SOLID), joint("wrist", "hand"))


def test_massless_links_hand_their_joints_on() -> None:
    result = pruned(link("wrist"), *HAND, joint("world", "wrist"))
    assert steps(result) == {"hand": ["wrist", "hand"]}
    first, last = result.conversion.segments["hand"].steps
    assert list(first.frames) == ["wrist"]
    assert last.frames == {}
    chain = (link("p"), link("q"), joint("world", "p"), joint("p", "q"), joint("q", "wrist"))
    assert steps(pruned(*chain, link("wrist"), *HAND)) == {"hand": ["p", "q", "wrist", "hand"]}


@pytest.mark.parametrize(
    ("seen", "xyz", "branch"),
    [
        ("", "0 0 0.1", ""),
        (BOX, "0 0 0", ""),
        ("", "0 0 0", link("other", SOLID) + joint("wrist", "other")),
        ("", "0 0 0", link("tool") + joint("wrist", "tool", "fixed")),
    ],
)
def test_it_stays_where_something_lies_between(seen: str, xyz: str, branch: str) -> None:
    """A shift, something to show, a body to carry, or a frame to carry."""
    result = pruned(
        link("wrist", seen),
        joint("world", "wrist"),
        link("hand", SOLID),
        joint("wrist", "hand", xyz=xyz),
        branch,
    )
    assert steps(result)["wrist"] == ["wrist"]
    assert steps(result)["hand"] == ["hand"]


def test_on_a_fixed_joint_it_is_a_part_of_the_body_and_may_show_something() -> None:
    """Where the URDF's fixed joint only turns."""
    result = pruned(
        link("wrist", BOX),
        joint("world", "wrist"),
        link("hand", SOLID),
        joint("wrist", "hand", "fixed", rpy="0.1 0.2 0.3"),
    )
    assert steps(result) == {"hand": ["wrist", "hand"]}
    assert parts(result)["hand"] == ["hand", "wrist"]


def test_a_leaf_goes_and_its_frame_stays() -> None:
    result = pruned(
        *(link("wrist", SOLID), joint("world", "wrist")),
        *(link("tool"), joint("wrist", "tool", "fixed", xyz="1 2 3", rpy="0 0 1.5")),
        *(link("tip"), joint("tool", "tip", "fixed", xyz="1 0 0")),
    )
    assert steps(result) == {"wrist": ["wrist"]}
    assert parts(result) == {"world": ["world"], "wrist": ["wrist", "tool", "tip"]}
    assert result.conversion.frozen == {}
    assert [diagnostic for diagnostic in result.diagnostics if diagnostic.level == "warning"] == []


def test_a_leaf_that_moves_is_held_at_zero_with_a_warning() -> None:
    result = pruned(
        *(link("wrist", SOLID), joint("world", "wrist")),
        *(link("tool"), joint("wrist", "tool", xyz="0 0 1")),
        *(link("tip"), joint("tool", "tip", "fixed", xyz="1 0 0")),
    )
    assert list(result.conversion.frozen) == ["wrist_to_tool"]
    (warning,) = [
        diagnostic for diagnostic in result.diagnostics if diagnostic.code == "massless-leaf"
    ]
    assert (warning.level, warning.joint, warning.link) == ("warning", "wrist_to_tool", "tool")
    assert warning.message.endswith("it is locked at zero, and is not in the .mbs")
    at = result.conversion.segments["wrist"].parts
    assert at["tip"].xyz == (1.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("keep", "bodies"),
    [
        ((), ["hand"]),
        (("tool",), ["hand", "tool"]),
        (("w*t",), ["wrist", "hand"]),
        (("*",), ["wrist", "hand", "tool"]),
        (("Tool", "t"), ["hand"]),
    ],
)
def test_links_that_are_kept_become_bodies(keep: tuple[str, ...], bodies: list[str]) -> None:
    tool = (link("tool"), joint("hand", "tool"))
    result = pruned(link("wrist"), *HAND, *tool, joint("world", "wrist"), keep=keep)
    assert list(steps(result)) == bodies
    assert [body.name for body in result.mbs.bodies] == bodies
