"""Merge massless: joint chains in one body, wherever what lies between can be moved away."""

import pytest

from support.build import BOX, SOLID, joint, link, robot
from support.proving import chains, prove


def wrist(
    first: str,
    second: str,
    *,
    kinds: tuple[str, str] = ("continuous", "continuous"),
    xyz: str = "0 0 0",
    rpy: str = "0 0 0",
    between: tuple[str, ...] = (),
    before: tuple[str, ...] = (),
) -> str:
    """Return an arm; a massless link on it; a hand, which carries a finger and a tool frame."""
    one, two = kinds
    return robot(
        link("world"),
        link("arm", SOLID),
        link("wrist", *between),
        link("hand", SOLID, BOX),
        link("finger", SOLID),
        link("tool"),
        *before,
        joint("world", "arm", axis="0 1 0"),
        joint("arm", "wrist", one, axis=first, xyz="0.1 0.2 0.3", rpy="0.1 0 0.2"),
        joint("wrist", "hand", two, axis=second, xyz=xyz, rpy=rpy),
        joint("hand", "finger", axis="1 0 0", xyz="0 0.1 0", rpy="0.3 0.1 0"),
        joint("hand", "tool", "fixed", xyz="0.01 0.02 0.03", rpy="0.3 0.2 0.1"),
    )


def moving(text: str, **settings: object) -> dict[str, int]:
    """How many moving joints each body has, in a conversion that is the same robot."""
    found = chains(prove(text, base="fixed", **settings))
    return {name: sum(t.isupper() for t in chain) for name, chain in found.items()}


MERGED = {"arm": 1, "hand": 2, "finger": 1}
KEPT = {"arm": 1, "wrist": 1, "hand": 1, "finger": 1}


#: The second joint's origin: y of the hand is z of the wrist.
QUARTER = "1.5707963267948966 0 0"


@pytest.mark.parametrize(
    ("first", "second", "xyz", "rpy", "merged"),
    [
        ("0 0 1", "0 1 0", "0 0 0", "0 0 0", True),
        ("0 0 1", "0 1 0", "0 0 0.2", "0 0 0", True),  # along the first axis
        ("0 0 1", "0 1 0", "0 -0.3 0", "0 0 0", True),  # along the second
        ("0 0 1", "0 1 0", "0 0.3 0.2", "0 0 0", True),  # some along each
        ("1 2 3", "0 1 1", "0.1 0.5 0.6", "0 0 0", True),  # (1 2 3)/10 + (0 1 1) * 0.3
        ("0 0 1", "0 0 1", "0 0 0.4", "0 0 0", True),
        ("0 0 1", "0 0 -1", "0 0 0.4", "0 0 0", True),
        ("1 0 0", "0 1 0", "0.1 0 0.2", QUARTER, True),  # some along each
        ("0 0 1", "0 1 0", "0.2 0 0", "0 0 0", False),
        ("0 0 1", "0 1 0", "1e-9 0 0.2", "0 0 0", False),
        ("0 0 1", "0 0 1", "0.1 0 0.4", "0 0 0", False),
        ("0 0 1", "0 0 1", "0.1 0 0", "0 0 0", False),
        ("1 0 0", "0 1 0", "0.1 0.2 0", QUARTER, False),
    ],
)
def test_two_turns_are_merged_where_a_joint_of_the_mbs_can_have_both(
    first: str, second: str, xyz: str, rpy: str, merged: bool
) -> None:
    assert moving(wrist(first, second, xyz=xyz, rpy=rpy)) == (MERGED if merged else KEPT)


@pytest.mark.parametrize("xyz", ["0.1 0.2 0.3", "0 0 0.3", "0 0 0"])
@pytest.mark.parametrize(
    "kinds",
    [
        ("prismatic", "continuous"),
        ("continuous", "prismatic"),
        ("prismatic", "prismatic"),
        ("prismatic", "planar"),
        ("floating", "prismatic"),
        ("prismatic", "floating"),
    ],
)
def test_a_shift_takes_any_other(kinds: tuple[str, str], xyz: str) -> None:
    found = moving(wrist("1 2 3", "0 1 1", kinds=kinds, xyz=xyz, rpy="0.3 0.2 0.1"))
    assert "wrist" not in found


@pytest.mark.parametrize(
    ("kinds", "xyz", "merged"),
    [
        (("planar", "continuous"), "0 0 0.3", True),
        (("continuous", "planar"), "0 0 0.3", True),
        (("planar", "planar"), "0 0.3 0.3", True),
        (("planar", "continuous"), "0.3 0 0", False),
        (("floating", "continuous"), "0 0.3 0", True),  # into the hand
        (("floating", "continuous"), "0 0 0.3", False),
        (("continuous", "floating"), "0 0 0.3", True),  # out to the anchor point
        (("continuous", "floating"), "0 0.3 0", False),
        (("floating", "floating"), "0 0 0", True),
        (("floating", "floating"), "0 0 1", False),
    ],
)
def test_planar_and_floating_joints(kinds: tuple[str, str], xyz: str, merged: bool) -> None:
    found = moving(wrist("0 0 1", "0 1 0", kinds=kinds, xyz=xyz))
    assert ("wrist" not in found) is merged


def test_where_the_frames_are_is_reported() -> None:
    """The hand's frame is 0.3 along y of the body's; the wrist's is 0.2 back along z."""
    result = prove(wrist("0 0 1", "0 1 0", xyz="0 0.3 0.2"), base="fixed")
    hand, tip = result.frames["hand"], result.frames["wrist"]
    assert (hand.body, hand.joint) == ("hand", None)
    assert sum(c * c for c in hand.pose.xyz) ** 0.5 == pytest.approx(0.3)
    assert (tip.body, tip.joint) == ("hand", "arm_to_wrist")
    assert sum(c * c for c in tip.pose.xyz) ** 0.5 == pytest.approx(0.2)
    # the displaced frame is an anchor point of its own body, beside those of what it carries
    (body,) = [body for body in result.mbs.bodies if body.name == "hand"]
    points = {point.name: point.coordinates for point in body.points}
    assert points["hand"] == hand.pose.xyz
    assert set(points) == {"hand", "finger", "tool"}


def test_a_link_that_is_seen_or_carries_more_stays() -> None:
    assert moving(wrist("0 0 1", "0 1 0", between=(BOX,))) == KEPT
    side = wrist("0 0 1", "0 1 0", before=(link("side", SOLID), joint("wrist", "side")))
    assert moving(side) == {**KEPT, "side": 1}
    frame = wrist("0 0 1", "0 1 0", before=(link("side"), joint("wrist", "side", "fixed")))
    assert moving(frame) == KEPT


@pytest.mark.parametrize("keep", [[], ["*"]])
@pytest.mark.parametrize(
    ("second", "third", "bodies"),
    [
        ("0 0 0", "0 0 0", 1),
        ("0 0 0.1", "0 0 0", 1),  # before the first
        ("0 0 0", "0.1 0 0", 1),  # after the third
        ("0 0 0.1", "0.1 0 0", 1),
        ("0 0.1 0", "0 0 0", 2),  # in a chain there is no place between two joints
        ("0.1 0 0", "0 0 0", 2),
        ("0.1 0 0", "0 0.1 0", 2),
        ("0.1 0 0", "0 0 0.1", 3),
    ],
)
def test_several_in_a_row(second: str, third: str, bodies: int, keep: list[str]) -> None:
    """Joints about z, y and x, with a shift before the second and the third."""
    text = robot(
        link("world"),
        link("one"),
        link("two"),
        link("hand", SOLID),
        link("finger", SOLID),
        joint("world", "one", axis="0 0 1", xyz="1 2 3"),
        joint("one", "two", axis="0 1 0", xyz=second),
        joint("two", "hand", axis="1 0 0", xyz=third),
        joint("hand", "finger", axis="0 0 1", xyz="1 2 3"),
    )
    result = prove(text, base="fixed", passes={"prune-massless": {"keep": keep}})
    assert len(result.mbs.bodies) == bodies + 1


def test_a_massless_root_that_floats() -> None:
    text = robot(
        link("frame"),
        link("trunk", SOLID),
        link("leg", SOLID),
        joint("frame", "trunk", "prismatic", axis="0 1 0", xyz="0.1 0.2 0.3", rpy="0 0 0.1"),
        joint("trunk", "leg", axis="0 1 1", xyz="0 0 1"),
    )
    result = prove(text, base="floating")
    assert chains(result)["trunk"][:6] == ["T1", "T2", "T3", "R1", "R2", "R3"]
    assert len(result.mbs.bodies) == 2
