"""Insert base: a root without inertia, and the six degrees of freedom of a floating robot."""

from itertools import pairwise

import pytest

from support.build import SOLID, joint, link, robot
from urdf2mbs import Result
from urdf2mbs.testing import convert_text


def based(*elements: str, base: str = "auto") -> Result:
    return convert_text(robot(*elements), base=base, pipeline=["expand", "insert-base"])


def added(result: Result) -> tuple[str, str, str] | None:
    """Parent, type and child of the joint that was put in."""
    name = result.conversion.base.inserted
    if name is None:
        return None
    found = result.robot.joints[name]
    return found.parent, found.type, found.child


A = link("a", SOLID)
WELDED = (link("world"), A, joint("world", "a", "fixed"))


@pytest.mark.parametrize(
    ("elements", "base", "floats", "joint_added", "why"),
    [
        # nothing ties it to the world
        ((A,), "auto", True, ("ground", "floating", "a"), "nothing ties root link 'a'"),
        (
            (link("a"), link("b", SOLID), joint("a", "b")),
            "auto",
            False,
            None,
            "root link 'a' has no mass, nor has what is fixed to it",
        ),
        # a root called world, or one that is welded to a world
        (WELDED, "auto", False, None, "root link 'world' is called world"),
        (
            (link("world", SOLID), A, joint("world", "a")),
            "auto",
            False,
            ("ground", "fixed", "world"),
            "is called world",
        ),
        (
            (
                link("mount"),
                link("world"),
                A,
                joint("mount", "world", "fixed"),
                joint("mount", "a"),
            ),
            "auto",
            False,
            None,
            "root link 'mount' is welded to world",
        ),
        (
            (
                link("mount"),
                link("plate"),
                link("world"),
                A,
                joint("mount", "plate", "fixed"),
                joint("plate", "world", "fixed"),
                joint("mount", "a"),
            ),
            "auto",
            False,
            None,
            "root link 'mount' is welded to world",
        ),
        # a world that can move away is none
        (
            (link("cart"), link("world"), A, joint("cart", "world"), joint("cart", "a")),
            "auto",
            False,
            None,
            "has no mass, nor has what is fixed",
        ),
        # as asked for
        ((A,), "fixed", False, ("ground", "fixed", "a"), "as asked for"),
        (WELDED, "floating", True, ("ground", "floating", "world"), "as asked for"),
        ((link("a"), link("b", SOLID), joint("a", "b")), "fixed", False, None, "as asked for"),
    ],
)
def test_whether_the_base_floats_and_why(
    elements: tuple[str, ...], base: str, floats: bool, joint_added: object, why: str
) -> None:
    result = based(*elements, base=base)
    assert result.conversion.base.floating is floats
    assert added(result) == joint_added
    (told,) = [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "base"]
    assert told.level == "note"
    assert why in told.message
    assert told.message.startswith("floating" if floats else "fixed")


def chain(count: int, *types: str) -> list[str]:
    """Return a root with mass that carries some joints in a row, and ends of these types."""
    elements = [link("l0", SOLID)]
    for k in range(1, count + 1):
        elements += [link(f"l{k}", SOLID), joint(f"l{k - 1}", f"l{k}")]
    for kind in types:
        elements += [link(kind, SOLID), joint(f"l{count}", kind, kind)]
    return elements


def limbs(up: float, *counts: int) -> list[str]:
    """Return a root with mass that carries limbs of some joints, each ``up`` (m) on the last."""
    elements = [link("l0", SOLID)]
    for n, count in enumerate(counts):
        names = ["l0", *(f"limb{n}_{k}" for k in range(count))]
        for parent, child in pairwise(names):
            elements += [link(child, SOLID), joint(parent, child, "revolute", xyz=f"0 0 {up}")]
    return elements


LEGS = [
    *(link("leg", SOLID), joint("l0", "leg", "revolute")),
    *(link("other", SOLID), joint("l0", "other", "revolute")),
]


@pytest.mark.parametrize(
    ("elements", "reason", "loud"),
    [
        (chain(4), "one limb", False),
        (chain(3, "continuous"), "one limb", False),  # a wrist
        (chain(4, "revolute", "prismatic"), "one limb", False),  # a gripper
        ([*chain(4), link("mount"), joint("mount", "l0", "fixed")], "one limb", False),
        (chain(3), "free root", True),
        # a leg may hop
        ([*chain(4), link("foot", SOLID), joint("l4", "foot", "fixed")], "one limb", True),
        # an arm that moves in a plane only, as some of its joints are fixed
        (
            [
                *chain(3),
                *(link(one, SOLID) for one in "abc"),
                *(
                    joint(one, other, "fixed")
                    for one, other in (("l3", "a"), ("a", "b"), ("b", "c"))
                ),
            ],
            "one limb",
            False,
        ),
        # a drone or a vehicle with an arm, whatever turns its rotors
        ([*chain(5), link("rotor_1"), joint("l0", "rotor_1", "fixed")], "free root", False),
        ([*chain(4), link("cart", SOLID), joint("cart", "l0", "planar")], "free root", True),
        # two arms on a torso, with a head; two legs below a trunk; a third limb
        (limbs(1, 4, 5, 1), "two arms", True),
        (limbs(-1, 4, 4), "free root", True),  # or two arms that hang
        (
            [*limbs(-1, 4, 4), link("left_foot"), joint("limb0_3", "left_foot", "fixed")],
            "free root",
            False,
        ),
        (limbs(1, 4, 3), "free root", True),
        (limbs(1, 4, 4, 2), "free root", True),
        # a hand, on its palm
        ([*chain(0), *LEGS], "free root", True),
        # legs below a trunk
        (
            [*chain(0), *LEGS, link("foot", SOLID), joint("leg", "foot", "revolute", xyz="0 0 -1")],
            "free root",
            False,
        ),
        # wheels
        (
            [
                *chain(4),
                link("wheel", SOLID),
                joint("l4", "wheel", "continuous"),
                link("other", SOLID),
                joint("l4", "other", "continuous"),
            ],
            "free root",
            False,
        ),
        (
            [
                *chain(4),
                link("wheel", SOLID),
                joint("l4", "wheel", "continuous"),
                link("cap", SOLID),
                joint("wheel", "cap", "fixed"),
                link("other", SOLID),
                joint("l4", "other", "continuous"),
            ],
            "free root",
            False,
        ),
        # nothing moves
        ([*chain(0), link("b", SOLID), joint("l0", "b", "fixed")], "free root", False),
    ],
)
def test_a_base_that_may_well_be_guessed_wrong_is_a_warning(
    elements: list[str], reason: str, loud: bool
) -> None:
    """An arm is bolted down; its root has mass, and nothing ties the root to the world."""
    result = based(*elements)
    assert result.conversion.base.reason == reason
    assert result.conversion.base.floating is (reason == "free root")
    (told,) = [
        diagnostic for diagnostic in result.diagnostics if diagnostic.code.startswith("base")
    ]
    assert (told.code, told.level) == (("base-guessed", "warning") if loud else ("base", "note"))
    other = "fixed" if reason == "free root" else "floating"
    assert loud == (f"'base: {other}'" in str(told.hint))
    (told,) = [
        diagnostic.level
        for diagnostic in based(*elements, base=other).diagnostics
        if diagnostic.code == "base"
    ]
    assert told == "note"


@pytest.mark.parametrize("base", ["auto", "floating", "fixed"])
def test_a_floating_joint_of_the_robots_own_lets_it_float(base: str) -> None:
    """Six coordinates more would say nothing new."""
    result = based(link("odom"), A, joint("odom", "a", "floating"), base=base)
    assert added(result) is None
    (told,) = [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "base"]
    assert told.message == "floating base: joint 'odom_to_a' lets it float"


def test_a_floating_joint_behind_a_fixed_one_counts_and_one_behind_a_moving_one_does_not() -> None:
    fixed = (link("w"), link("m"), A, joint("w", "m", "fixed"), joint("m", "a", "floating"))
    assert added(based(*fixed)) is None
    moving = (link("w", SOLID), link("m", SOLID), A, joint("w", "m"), joint("m", "a", "floating"))
    assert added(based(*moving)) == ("ground", "floating", "w")


def test_names_that_are_taken_get_a_number() -> None:
    elements = (A, link("ground"), link("ground_2", SOLID))
    joints = (joint("a", "ground", name="floating_base"), joint("a", "ground_2"))
    result = based(*elements, *joints)
    assert result.conversion.base.inserted == "floating_base_2"
    assert result.robot.root() == "ground_3"
