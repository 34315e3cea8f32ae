"""Each rule of the comparison: a fault that is planted in a model is found, and no other."""

import re
from typing import Any

import pytest

from support.build import SOLID, joint, link, robot
from support.planted import (
    PLANTED,
    Plant,
    change_tensor,
    do_nothing,
    find_body,
    find_joint,
    set_body,
    set_joint,
)
from support.presets import PRESETS
from urdf2mbs import Result
from urdf2mbs.mbs.model import Connection, Joint, LinkFrame, Mbs, Parameter, Point
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.proof.compare import Expectation, compare
from urdf2mbs.proof.match import Match, match_by_name
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.verdict import Proof
from urdf2mbs.spatial import Pose
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs.urdf.model import ClosingJoint, Extension


def convert_and_read(text: str = TINY, **settings: Any) -> tuple[Result, Mbs]:
    result = convert_text(text, **settings)
    return result, read_mbs(result.data, "r.mbs")


def compared(result: Result, mbs: Mbs, **changes: Any) -> Proof:
    """Compare an .mbs with the robot of a conversion.

    Args:
        result: The conversion.
        mbs: The model.
        changes: Other fields of ``Match``; ``massless`` and ``tolerance`` as of ``compare``.
    """
    expectation = Expectation(massless=changes.pop("massless", ()))
    tolerance = changes.pop("tolerance", TOLERANCE)
    joints = {name: tuple(names) for name, names in result.names.coordinates.items()}
    fields = {"joints": joints, "frames": result.frames, "locked": result.frozen, **changes}
    return compare(result.robot, mbs, Match(**fields), expectation, tolerance)


def kinds(comparison: Proof) -> set[str]:
    return {difference.kind for difference in comparison.differences}


def test_nothing_differs() -> None:
    result, mbs = convert_and_read()
    comparison = compared(result, mbs)
    assert comparison.same
    assert comparison.frames == []
    assert comparison.urdf_mass == comparison.mbs_mass == 2.6


@pytest.mark.parametrize("name", PLANTED)
def test_a_fault_is_of_its_kind(name: str) -> None:
    plant, expected_kinds = PLANTED[name]
    result, mbs = convert_and_read()
    plant(mbs)
    proof = compared(result, mbs)
    assert kinds(proof) == expected_kinds
    assert len(proof.differences) == len(expected_kinds)
    assert proof.same is not bool(expected_kinds)


@pytest.mark.parametrize(("kind", "unit"), [("continuous", "rad"), ("prismatic", "m")])
def test_another_zero_of_a_joint_is_one_difference(kind: str, unit: str) -> None:
    result, mbs = convert_and_read(
        robot(link("world"), link("a", SOLID), joint("world", "a", kind))
    )
    mbs_joint = find_joint(mbs, "world_to_a")
    find_body(mbs, "a").joints.insert(0, Joint("still", mbs_joint.type, "driven", q=0.25))
    (difference,) = compared(result, mbs).differences
    assert (difference.kind, difference.joint, difference.mbs) == (
        "zero",
        "world_to_a",
        pytest.approx(0.25),
    )
    assert difference.message == f"joint 'world_to_a': zero is at 0.25 {unit} of the URDF"


def test_a_joint_cannot_be_that_of_two() -> None:
    result, mbs = convert_and_read()
    coordinates = {name: tuple(names) for name, names in result.names.coordinates.items()}
    twice = compared(result, mbs, joints=coordinates | {"wrist_pitch": ("wrist_roll",)})
    assert kinds(twice) == {"joint-missing", "joint-extra"}


@pytest.mark.parametrize(("name", "heavy"), [("wrist_roll", True), ("tip", False)])
def test_only_a_massless_joint_may_be_left_out(name: str, heavy: bool) -> None:
    text = TINY.replace("</robot>", f"{link('tip')}{joint('hand', 'tip', name='tip')}</robot>")
    result, mbs = convert_and_read(text)
    locked = {**result.frozen, name: result.frozen["tip"]}
    proof = compared(result, mbs, locked=locked, massless=[*locked])
    assert ("joint-missing" in kinds(proof)) is heavy
    assert proof.but_for[f"joint '{name}'"] == "held at zero: nothing that it moves has mass"


def test_a_pass_may_lock_a_joint_for_any_reason() -> None:
    result, mbs = convert_and_read()
    find_joint(mbs, "wrist_roll").nature = "driven"
    find_joint(mbs, "wrist_roll").q = 0.0
    proof = compared(result, mbs, locked={"wrist_roll": "locked on purpose"})
    assert proof.same
    assert proof.but_for == {"joint 'wrist_roll'": "held at zero: locked on purpose"}


ROTOR = SOLID.replace('<mass value="2"/>', '<mass value="0"/>')
POINT = '<inertial><mass value="2"/></inertial>'
#: Of a robot with one joint: its inertia, what is planted, and the kinds of the differences.
ALONE: dict[str, tuple[str, Plant, set[str]]] = {
    **{f"moment {k}": (SOLID, change_tensor(k), {"inertia"}) for k in range(6)},
    "a rotor": (ROTOR, do_nothing, set()),
    "a moment of a rotor": (ROTOR, change_tensor(5), {"inertia"}),
    "a rotor without inertia": (ROTOR, set_body("a", inertia=None), {"inertia"}),
    "a rotor has no centre": (ROTOR, set_body("a", com=(1.0, 2.0, 3.0)), set()),
    "a point mass without inertia": (POINT, set_body("a", inertia=None), set()),
    "an axis that is right at zero only": (SOLID, set_joint("world_to_a", type="R2"), {"axis"}),
}


@pytest.mark.parametrize("name", ALONE)
def test_a_fault_of_a_robot_with_one_joint(name: str) -> None:
    inertia, plant, expected_kinds = ALONE[name]
    result, mbs = convert_and_read(robot(link("world"), link("a", inertia), joint("world", "a")))
    plant(mbs)
    assert kinds(compared(result, mbs)) == expected_kinds
    assert kinds(compared(result, mbs, frames={})) == expected_kinds


def test_the_scale_of_an_inertia_is_the_inertia() -> None:
    """A small error is found although the mass is far from the joint."""
    far = SOLID.replace('xyz="0.1 -0.2 0.3"', 'xyz="5 0 0"')
    result, mbs = convert_and_read(robot(link("world"), link("a", far), joint("world", "a")))
    xx, *rest = mbs.bodies[0].inertia
    mbs.bodies[0].inertia = (xx * (1 + 1e-6), *rest)
    assert kinds(compared(result, mbs)) == {"inertia"}


@pytest.mark.parametrize("k", range(3))
@pytest.mark.parametrize("kind", ["T", "R"])
def test_a_displacement_in_any_direction_is_found(k: int, kind: str) -> None:
    result, mbs = convert_and_read()
    displacement = Joint("off", f"{kind}{k + 1}", "driven", q=1e-6)
    find_body(mbs, "arm").joints.insert(0, displacement)
    comparison = compared(result, mbs)
    assert not comparison.same
    assert comparison.largest["motion"] > 1e-7


def test_a_body_with_another_parent() -> None:
    solids = (link(name, SOLID) for name in "abc")
    text = robot(link("world"), *solids, joint("world", "a"), joint("a", "b"), joint("a", "c"))
    result, mbs = convert_and_read(text)
    mbs.bodies[2].parent, mbs.bodies[2].point = "b", None
    for frames in (result.frames, {}):
        proof = compared(result, mbs, frames=frames)
        assert [(difference.kind, difference.joint) for difference in proof.differences] == [
            ("parent", "a_to_c")
        ]
        assert max(proof.largest.values()) <= 1e-12
    find_body(mbs, "c").mass = 3.0
    assert kinds(compared(result, mbs, frames={})) == {"parent", "mass"}


def test_a_planar_joint_with_another_order_is_one_difference() -> None:
    result, mbs = convert_and_read(
        robot(link("world"), link("a", SOLID), joint("world", "a", "planar"))
    )
    mbs.bodies[0].joints.insert(0, mbs.bodies[0].joints.pop(1))
    (difference,) = (
        difference
        for difference in compared(result, mbs).differences
        if difference.kind == "parent"
    )
    assert difference.joint == "world_to_a"


def test_a_short_axis_may_be_a_little_tilted() -> None:
    text = robot(link("world"), link("a", SOLID), joint("world", "a", axis="1e-7 0 1e-3"))
    assert compared(*convert_and_read(text)).same


def test_a_displaced_frame() -> None:
    result, mbs = convert_and_read()
    find_body(mbs, "hand").points[0].coordinates = (0.0, 0.0, 0.11)
    (difference,) = compared(result, mbs).frames
    assert (difference.kind, difference.link) == ("point", "tool")
    assert "m from the frame of the link" in difference.message
    assert 0.0 < difference.size < 1.0
    find_body(mbs, "hand").points[0].coordinates = (0.0, 0.0, 900.0)
    frames = {"tool": LinkFrame("hand", None, Pose((0.0, 800.0, 0.0)))}
    sizes = {
        difference.kind: difference.size
        for difference in compared(result, mbs, frames=frames).frames
    }
    assert sizes == {"frame": 1.0, "point": 1.0}


def test_links_with_the_same_identifier_have_no_point() -> None:
    text = robot(
        link("world"),
        link("a", SOLID),
        link("left foot"),
        link("left-foot"),
        joint("world", "a"),
        joint("a", "left foot", "fixed", xyz="1 0 0"),
        joint("a", "left-foot", "fixed", xyz="2 0 0"),
    )
    result, mbs = convert_and_read(text)
    comparison = compared(result, mbs)
    assert comparison.frames == []
    assert comparison.same


@pytest.mark.parametrize("axis", ["1 0 0", "0 1 0", "0 0 1", "1 1 0", "0 1 1", "1 0 1", "1 2 3"])
def test_a_planar_joint_shifts_in_its_plane(axis: str) -> None:
    text = robot(link("world"), link("a", SOLID), joint("world", "a", "planar", axis=axis))
    for pipeline in PRESETS:
        assert compared(*convert_and_read(text, pipeline=pipeline)).same


def test_the_error_of_a_finger_on_a_crane_is_found() -> None:
    finger = SOLID.replace("0.1 -0.2 0.3", "0.01 0.02 0.03")
    text = robot(
        link("world"),
        link("a", SOLID),
        link("b", finger),
        link("c", finger),
        joint("world", "a"),
        joint("a", "b", xyz="1000 0 0"),
        joint("b", "c", xyz="0.05 0 0"),
    )
    result, mbs = convert_and_read(text)
    assert compared(result, mbs).same
    x, y, z = find_body(mbs, "c").com
    find_body(mbs, "c").com = (x + 2e-9, y, z)
    assert kinds(compared(result, mbs)) == {"centre"}


@pytest.mark.parametrize(("nature", "matched"), [("driven", False), ("independent", True)])
def test_a_massless_joint_may_be_driven(nature: str, matched: bool) -> None:
    text = TINY.replace("</robot>", f"{link('tip')}{joint('hand', 'tip', name='tip')}</robot>")
    result, mbs = convert_and_read(text, passes={"prune-massless": {"keep": ["tip"]}})
    find_joint(mbs, "tip").nature = nature
    match = match_by_name(result.robot, mbs)
    assert ("tip" in match.joints) is matched
    assert ("tip" in match.locked) is not matched
    assert (
        kinds(compare(result.robot, mbs, Match(joints=match.joints, locked=match.locked))) == set()
    )


@pytest.mark.parametrize("pipeline", PRESETS)
def test_a_link_whose_mass_is_lost_is_named(pipeline: str) -> None:
    text = robot(
        link("world"),
        link("a", SOLID),
        link("b", SOLID.replace('"2"', '"3"')),
        joint("world", "a"),
        joint("a", "b", "fixed", xyz="1 0 0"),
    )
    result, _ = convert_and_read(text, pipeline=pipeline)
    alone, mbs = convert_and_read(robot(link("world"), link("a", SOLID), joint("world", "a")))
    frames = {**alone.frames, "b": result.frames["b"]}
    differences = compared(result, mbs, frames=frames).differences
    message = "link 'b': mass of 3 kg is missing in the .mbs"
    (lost,) = (difference for difference in differences if message in difference.message)
    assert (lost.urdf, lost.mbs, lost.size) == (3.0, 0.0, pytest.approx(3 / 5))


def test_a_body_without_mass_is_not_in_the_sum() -> None:
    result, mbs = convert_and_read()
    before = compared(result, mbs).mbs_mass
    hand = find_body(mbs, "hand")
    hand.mass = None
    proof = compared(result, mbs)
    assert (before, proof.mbs_mass) == pytest.approx((2.6, 2.5))
    assert proof.urdf_mass == before


@pytest.mark.parametrize("size", [1e-6, 1e3])
def test_a_deviation_is_relative_to_the_robot(size: float) -> None:
    """A robot of another size, with the same fault: the same deviations."""
    solid = SOLID.replace("0.1 -0.2 0.3", f"{0.1 * size} {-0.2 * size} {0.3 * size}")
    joints = (joint("world", "a"), joint("a", "b", xyz=f"{size} 0 0"))
    result, mbs = convert_and_read(
        robot(link("world"), link("a", solid), link("b", solid), *joints)
    )
    b = find_body(mbs, "b")
    b.com = (b.com[0] + 1e-3 * size, *b.com[1:])
    (difference,) = compared(result, mbs).differences
    assert difference.kind == "centre"
    assert difference.size == pytest.approx(1e-3 / 1.0001)


def test_small_deviations_of_bodies_may_sum_up() -> None:
    """Each body is within tolerance, but their sum is not."""
    joints = (joint("world", "a"), joint("a", "b", "fixed", xyz="0 1 0"))
    result, mbs = convert_and_read(
        robot(link("world"), link("a", SOLID), link("b", SOLID), *joints)
    )
    for name, off in (("a", -8e-4), ("b", 8e-4)):
        x, y, z = find_body(mbs, name).com
        find_body(mbs, name).com = (x, y + off, z)
    (difference,) = compared(result, mbs, tolerance=1e-3).differences
    assert (difference.kind, difference.link, difference.message) == (
        "inertia",
        "a",
        "link 'a': inertia",
    )
    assert 1e-3 < difference.size < 1e-2


def test_cuts_that_share_joints_need_a_dependent_joint_for_each_constraint() -> None:
    """Three arms in a plane, tip to tip: each cut leaves the joints of one arm alone."""
    elements = [link("world")]
    for x, (inner, outer) in enumerate(("ab", "cd", "ef")):
        elements += [
            link(inner, SOLID),
            link(outer, SOLID),
            joint("world", inner, xyz=f"{x} 0 0"),
            joint(inner, outer, xyz=f"0.3 {1 + x} 0"),
        ]
    result, mbs = convert_and_read(robot(*elements))
    for name in "bdf":
        find_body(mbs, name).points.append(Point("end", (0.4, 0.1, 0.0)))
    mbs.cuts = [Connection("ball", a + b, (a, "end"), (b, "end")) for a, b in ("bd", "df")]
    for count in (3, 4, 5):
        names = ["world_to_a", "a_to_b", "world_to_c", "c_to_d", "world_to_e"][:count]
        for name in names:
            find_joint(mbs, name).nature = "dependent"
        assert kinds(compared(result, mbs)) == (set() if count == 4 else {"cut"})


def test_a_cut_of_a_joint_in_gazebo_is_no_deviation() -> None:
    closing = ClosingJoint("pin", "revolute", "hand", "tool")
    result, mbs = convert_and_read(base="fixed")
    result.robot.extensions = [Extension("gazebo", "", joints=[closing])]
    for name, stated in (("pin", True), ("pin_1", True), ("pin_2", True), ("pin_3", False)):
        mbs.cuts = [Connection("ball", name, ("hand", None), (None, None))]
        proof = compared(result, mbs)
        assert (f"cut '{name}' (ball)" in proof.not_compared) is stated
        assert (f"cut '{name}' (ball)" in proof.but_for) is not stated


def test_a_frame_in_a_wrong_body_or_in_none() -> None:
    result, mbs = convert_and_read()
    frames = {"hand": LinkFrame("arm", None, Pose()), "tool": LinkFrame("none", None, Pose())}
    messages = [difference.message for difference in compared(result, mbs, frames=frames).frames]
    assert messages[0] == "link 'hand': moves with another body"
    assert messages[1] == "link 'tool': no body or joint 'none' in the .mbs"


def test_an_axis_that_is_displaced() -> None:
    """Only the axis is displaced, not the body and its children."""
    result, mbs = convert_and_read(robot(link("world"), link("a", SOLID), joint("world", "a")))
    displaced_body = find_body(mbs, "a")
    displaced_body.joints = [
        Joint("to", "T1", "driven", q=0.01),
        *displaced_body.joints,
        Joint("back", "T1", "driven", q=-0.01),
    ]
    (difference,) = compared(result, mbs).differences
    assert difference.kind == "axis"
    assert "axis is displaced by 0.01 m in the .mbs" in difference.message


def test_a_number_that_the_urdf_does_not_have() -> None:
    result, mbs = convert_and_read()
    (damping,) = (model for model in mbs.user_models if model.name == "damping")
    (parameter,) = damping.parameters
    damping.parameters = [
        Parameter(parameter.name, "scalar", ("7",)),
        Parameter("wrist_roll", "scalar", ("8",)),
    ]
    messages = {
        difference.joint: difference.message for difference in compared(result, mbs).differences
    }
    stated = result.robot.joints[parameter.name].dynamics.damping
    assert messages == {
        parameter.name: f"joint '{parameter.name}': damping is 7; expected {stated:.9g}",
        "wrist_roll": "joint 'wrist_roll': damping is 8; the URDF has none",
    }


def test_a_massless_link_is_placed_by_its_children() -> None:
    """So the wrong joint is named, and not the one after it."""
    result, mbs = convert_and_read()
    find_body(mbs, "arm").points[0].coordinates = (0.05, 0.0, 0.3)
    (difference,) = compared(result, mbs).differences
    assert difference.message.startswith("link 'wrist' is displaced after joint 'wrist_roll'")
    result, mbs = convert_and_read(
        re.sub(r'(?s)(<link name="arm">\s*)<inertial>.*?</inertial>', r"\1", TINY)
    )
    find_joint(mbs, "shoulder").type = "R1"
    assert kinds(compared(result, mbs)) == {"axis"}


def test_the_mass_of_a_link_may_be_in_another_body() -> None:
    """A body of two links has the mass of the one, and the next body that of the other, too."""
    solids = (link(name, SOLID) for name in "abc")
    joints = (joint("a", "b", "fixed", xyz="0 1 0"), joint("a", "c", "fixed", xyz="1 0 0"))
    result, mbs = convert_and_read(
        robot(link("world"), *solids, joint("world", "a"), *joints), pipeline="faithful"
    )
    frames = {**result.frames, "b": result.frames["a"]}
    mbs.bodies.remove(find_body(mbs, "b"))
    find_body(mbs, "c").mass *= 2
    differences = compared(result, mbs, frames=frames).differences
    masses = {each.link: (each.urdf, each.mbs) for each in differences if each.kind == "mass"}
    assert masses["c"] == (2.0, 4.0)
    assert masses.keys() & {"a", "b"}
