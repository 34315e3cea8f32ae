"""What is compared, one rule at a time: a model is spoilt in one place, and is found out."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from presets import PRESETS
from proving import SOLID, joint, link, robot
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


def pieces(text: str = TINY, **settings: Any) -> tuple[Result, Mbs]:
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


def body(mbs: Mbs, name: str) -> Any:
    return next(body for body in mbs.bodies if body.name == name)


def own_joint(mbs: Mbs, name: str) -> Joint:
    return next(one for b in mbs.bodies for one in b.joints if one.name == name)


def test_nothing_differs() -> None:
    result, mbs = pieces()
    comparison = compared(result, mbs)
    assert comparison.same
    assert comparison.frames == []
    assert comparison.urdf_mass == comparison.mbs_mass == 2.6


def setting(name: str, **values: Any) -> Callable[[Mbs], None]:
    """Give a joint other values."""

    def plant(mbs: Mbs) -> None:
        for key, value in values.items():
            setattr(own_joint(mbs, name), key, value)

    return plant


def of_body(name: str, **values: Any) -> Callable[[Mbs], None]:
    """Give a body other values."""

    def plant(mbs: Mbs) -> None:
        for key, value in values.items():
            setattr(body(mbs, name), key, value)

    return plant


def _number(model: str, joint: str, value: str) -> Callable[[Mbs], None]:
    """Give a joint another number in a user model."""

    def plant(mbs: Mbs) -> None:
        (of,) = (one for one in mbs.user_models if one.name == model)
        (own,) = (one for one in of.parameters if one.name == joint)
        own.values = (value,)

    return plant


def _products(mbs: Mbs) -> None:
    xx, xy, xz, yy, yz, zz = body(mbs, "arm").inertia
    body(mbs, "arm").inertia = (xx, -xy, -xz, yy, -yz, zz)


def _gravity(k: int, off: float) -> Callable[[Mbs], None]:
    def plant(mbs: Mbs) -> None:
        own = list(mbs.base.gravity)
        own[k] += 9.81 * off
        mbs.base.gravity = (own[0], own[1], own[2])

    return plant


def _more(nature: str) -> Callable[[Mbs], None]:
    return lambda mbs: body(mbs, "hand").joints.append(Joint("more", "R1", nature))


def _turn(**values: Any) -> Callable[[Mbs], None]:
    """Give the turn before the shoulder, which never moves, other values."""

    def plant(mbs: Mbs) -> None:
        (turn,) = (one for one in body(mbs, "arm").joints if one.nature == "driven" and one.q)
        for key, value in values.items():
            setattr(turn, key, value)

    return plant


#: What is planted in TINY, and the kinds of what is found.  A joint that is held stands where it is
#: held, so that what else is wrong is not blamed on its angle.
PLANTED: dict[str, tuple[Callable[[Mbs], None], set[str]]] = {
    **{f"gravity {k} off by {off}": (_gravity(k, off), {"gravity"} if off > 1e-9 else set())
       for k in (0, 2) for off in (1e-12, 1e-8, 1e-3)},
    "dependent": (setting("shoulder", nature="dependent"), {"nature"}),
    "held": (setting("shoulder", nature="driven", q=0.4), {"nature"}),
    "held, and of another type": (setting("shoulder", nature="driven", type="T3"), {"nature"}),
    "starts elsewhere": (setting("shoulder", q=0.4), set()),
    "slides": (setting("shoulder", type="T3"), {"type"}),
    "no mass": (of_body("hand", mass=None), {"mass", "inertia"}),
    "a centre negated": (of_body("arm", com=(0.0, 0.0, -0.15)), {"centre"}),
    "products of inertia negated": (_products, {"inertia"}),
    "an anchor 1e-6 m off": (
        lambda mbs: setattr(body(mbs, "body").points[0], "coordinates", (0.100001, 0.0, 0.15)),
        {"frame"},
    ),
    "damping a hundredfold": (_number("damping", "shoulder", "10.0"), {"parameter"}),
    "a limit moved": (_number("q_max", "shoulder", "1.5015"), {"parameter"}),
    "no symbols": (setting("shoulder", symbols=()), {"symbols"}),
    "q alone in the symbols": (setting("shoulder", symbols=("q",)), {"symbols"}),
    "no q in the symbols of a driven joint": (_turn(symbols=("qd",)), {"symbols"}),
    "a velocity of a driven joint": (_turn(symbols=None, qd=1.0), {"symbols"}),
    "an acceleration of a driven joint": (_turn(symbols=None, qdd=1.0), {"symbols"}),
    "a turn of 1e-8 too much": (_turn(q=0.5 + 1e-8), {"frame"}),
    "another turn": (_turn(q=-0.5), {"frame"}),
    "a joint too many": (_more("independent"), {"joint-extra"}),
    "a dependent joint too many": (_more("dependent"), {"joint-extra"}),
}  # fmt: skip


@pytest.mark.parametrize("name", PLANTED)
def test_a_fault_is_of_its_kind(name: str) -> None:
    plant, found = PLANTED[name]
    result, mbs = pieces()
    plant(mbs)
    proof = compared(result, mbs)
    assert kinds(proof) == found
    assert len(proof.differences) == len(found)
    assert proof.same is not bool(found)


@pytest.mark.parametrize(("kind", "unit"), [("continuous", "rad"), ("prismatic", "m")])
def test_another_zero_of_a_joint_is_one_difference(kind: str, unit: str) -> None:
    result, mbs = pieces(robot(link("world"), link("a", SOLID), joint("world", "a", kind)))
    own = own_joint(mbs, "world_to_a")
    body(mbs, "a").joints.insert(0, Joint("still", own.type, "driven", q=0.25))
    (found,) = compared(result, mbs).differences
    assert (found.kind, found.joint, found.mbs) == ("zero", "world_to_a", pytest.approx(0.25))
    assert found.message == f"joint 'world_to_a': zero is at 0.25 {unit} of the URDF"


def test_one_joint_for_two() -> None:
    result, mbs = pieces()
    coordinates = {name: tuple(names) for name, names in result.names.coordinates.items()}
    twice = compared(result, mbs, joints=coordinates | {"wrist_pitch": ("wrist_roll",)})
    assert kinds(twice) == {"joint-missing", "joint-extra"}


@pytest.mark.parametrize(("name", "heavy"), [("wrist_roll", True), ("tip", False)])
def test_only_what_weighs_nothing_may_be_left_out(name: str, heavy: bool) -> None:
    text = TINY.replace("</robot>", f"{link('tip')}{joint('hand', 'tip', name='tip')}</robot>")
    result, mbs = pieces(text)
    locked = {**result.frozen, name: result.frozen["tip"]}
    found = compared(result, mbs, locked=locked, massless=[*locked])
    assert ("joint-missing" in kinds(found)) is heavy
    assert found.but_for[f"joint '{name}'"] == "held at zero: nothing that it moves has mass"


def test_a_reason_of_ones_own_is_a_passes_business() -> None:
    result, mbs = pieces()
    own_joint(mbs, "wrist_roll").nature = "driven"
    own_joint(mbs, "wrist_roll").q = 0.0
    found = compared(result, mbs, locked={"wrist_roll": "locked on purpose"})
    assert found.same
    assert found.but_for == {"joint 'wrist_roll'": "held at zero: locked on purpose"}


def _tensor(k: int) -> Callable[[Mbs], None]:
    def plant(mbs: Mbs) -> None:
        tensor = list(mbs.bodies[0].inertia or ())
        tensor[k] += 1e-6
        mbs.bodies[0].inertia = tuple(tensor)  # type: ignore[assignment]

    return plant


ROTOR = SOLID.replace('<mass value="2"/>', '<mass value="0"/>')
POINT = '<inertial><mass value="2"/></inertial>'
#: Of a robot with one joint: its inertia, what is planted, and the kinds of what is found.
ALONE: dict[str, tuple[str, Callable[[Mbs], None], set[str]]] = {
    **{f"moment {k}": (SOLID, _tensor(k), {"inertia"}) for k in range(6)},
    "a rotor": (ROTOR, lambda mbs: None, set()),
    "a moment of a rotor": (ROTOR, _tensor(5), {"inertia"}),
    "a rotor without inertia": (ROTOR, of_body("a", inertia=None), {"inertia"}),
    "a rotor has no centre": (ROTOR, of_body("a", com=(1.0, 2.0, 3.0)), set()),
    "a point mass without inertia": (POINT, of_body("a", inertia=None), set()),
    "an axis that is right at zero only": (SOLID, setting("world_to_a", type="R2"), {"axis"}),
}  # fmt: skip


@pytest.mark.parametrize("name", ALONE)
def test_a_fault_of_a_robot_with_one_joint(name: str) -> None:
    inertia, plant, found = ALONE[name]
    result, mbs = pieces(robot(link("world"), link("a", inertia), joint("world", "a")))
    plant(mbs)
    assert kinds(compared(result, mbs)) == found
    assert kinds(compared(result, mbs, frames={})) == found


def test_a_light_bodys_inertia_counts_far_from_its_joint() -> None:
    """The scale of an inertia is the inertia itself, not what its mass has far out."""
    far = SOLID.replace('xyz="0.1 -0.2 0.3"', 'xyz="5 0 0"')
    result, mbs = pieces(robot(link("world"), link("a", far), joint("world", "a")))
    xx, *rest = mbs.bodies[0].inertia
    mbs.bodies[0].inertia = (xx * (1 + 1e-6), *rest)
    assert kinds(compared(result, mbs)) == {"inertia"}


@pytest.mark.parametrize("k", range(3))
@pytest.mark.parametrize("kind", ["T", "R"])
def test_every_direction_of_a_wrong_place_counts(k: int, kind: str) -> None:
    result, mbs = pieces()
    turned = Joint("off", f"{kind}{k + 1}", "driven", q=1e-6)
    body(mbs, "arm").joints.insert(0, turned)
    comparison = compared(result, mbs)
    assert not comparison.same
    assert comparison.largest["motion"] > 1e-7


def test_a_body_that_hangs_on_another_one() -> None:
    solids = (link(name, SOLID) for name in "abc")
    text = robot(link("world"), *solids, joint("world", "a"), joint("a", "b"), joint("a", "c"))
    result, mbs = pieces(text)
    mbs.bodies[2].parent, mbs.bodies[2].point = "b", None
    for frames in (result.frames, {}):
        proof = compared(result, mbs, frames=frames)
        assert [(found.kind, found.joint) for found in proof.differences] == [("parent", "a_to_c")]
        assert max(proof.largest.values()) <= 1e-12
    body(mbs, "c").mass = 3.0
    assert kinds(compared(result, mbs, frames={})) == {"parent", "mass"}


def test_a_planar_joint_that_goes_another_way_round_is_one_difference() -> None:
    result, mbs = pieces(robot(link("world"), link("a", SOLID), joint("world", "a", "planar")))
    mbs.bodies[0].joints.insert(0, mbs.bodies[0].joints.pop(1))
    (found,) = (found for found in compared(result, mbs).differences if found.kind == "parent")
    assert found.joint == "world_to_a"


def test_a_short_axis_may_be_a_little_tilted() -> None:
    text = robot(link("world"), link("a", SOLID), joint("world", "a", axis="1e-7 0 1e-3"))
    assert compared(*pieces(text)).same


def test_a_frame_that_is_not_where_it_is_said_to_be() -> None:
    result, mbs = pieces()
    body(mbs, "hand").points[0].coordinates = (0.0, 0.0, 0.11)
    (found,) = compared(result, mbs).frames
    assert (found.kind, found.link) == ("point", "tool")
    assert "m from the frame of the link" in found.message
    assert 0.0 < found.size < 1.0
    body(mbs, "hand").points[0].coordinates = (0.0, 0.0, 900.0)
    frames = {"tool": LinkFrame("hand", None, Pose((0.0, 800.0, 0.0)))}
    sizes = {found.kind: found.size for found in compared(result, mbs, frames=frames).frames}
    assert sizes == {"frame": 1.0, "point": 1.0}


def test_two_links_of_one_spelling_have_no_point_of_their_own() -> None:
    text = robot(
        link("world"), link("a", SOLID), link("left foot"), link("left-foot"), joint("world", "a"),
        joint("a", "left foot", "fixed", xyz="1 0 0"),
        joint("a", "left-foot", "fixed", xyz="2 0 0"),
    )  # fmt: skip
    result, mbs = pieces(text)
    comparison = compared(result, mbs)
    assert comparison.frames == []
    assert comparison.same


@pytest.mark.parametrize("axis", ["1 0 0", "0 1 0", "0 0 1", "1 1 0", "0 1 1", "1 0 1", "1 2 3"])
def test_a_planar_joint_shifts_in_its_plane(axis: str) -> None:
    text = robot(link("world"), link("a", SOLID), joint("world", "a", "planar", axis=axis))
    for pipeline in PRESETS:
        assert compared(*pieces(text, pipeline=pipeline)).same


def test_a_fingers_error_counts_on_a_crane() -> None:
    finger = SOLID.replace("0.1 -0.2 0.3", "0.01 0.02 0.03")
    text = robot(
        link("world"), link("a", SOLID), link("b", finger), link("c", finger), joint("world", "a"),
        joint("a", "b", xyz="1000 0 0"), joint("b", "c", xyz="0.05 0 0"),
    )  # fmt: skip
    result, mbs = pieces(text)
    assert compared(result, mbs).same
    x, y, z = body(mbs, "c").com
    body(mbs, "c").com = (x + 2e-9, y, z)
    assert kinds(compared(result, mbs)) == {"centre"}


@pytest.mark.parametrize(("nature", "matched"), [("driven", False), ("independent", True)])
def test_a_joint_that_moves_nothing_may_be_held_by_hand(nature: str, matched: bool) -> None:
    text = TINY.replace("</robot>", f"{link('tip')}{joint('hand', 'tip', name='tip')}</robot>")
    result, mbs = pieces(text, passes={"prune-massless": {"keep": ["tip"]}})
    own_joint(mbs, "tip").nature = nature
    found = match_by_name(result.robot, mbs)
    assert ("tip" in found.joints) is matched
    assert ("tip" in found.locked) is not matched
    assert (
        kinds(compare(result.robot, mbs, Match(joints=found.joints, locked=found.locked))) == set()
    )


@pytest.mark.parametrize("pipeline", PRESETS)
def test_a_link_whose_mass_is_lost_is_named(pipeline: str) -> None:
    text = robot(
        link("world"), link("a", SOLID), link("b", SOLID.replace('"2"', '"3"')),
        joint("world", "a"), joint("a", "b", "fixed", xyz="1 0 0"),
    )  # fmt: skip
    result, _ = pieces(text, pipeline=pipeline)
    alone, mbs = pieces(robot(link("world"), link("a", SOLID), joint("world", "a")))
    frames = {**alone.frames, "b": result.frames["b"]}
    found = compared(result, mbs, frames=frames).differences
    (lost,) = (d for d in found if "link 'b': mass of 3 kg is missing in the .mbs" in d.message)
    assert (lost.urdf, lost.mbs, lost.size) == (3.0, 0.0, pytest.approx(3 / 5))


def test_a_body_without_mass_weighs_nothing() -> None:
    result, mbs = pieces()
    before = compared(result, mbs).mbs_mass
    hand = body(mbs, "hand")
    hand.mass = None
    proof = compared(result, mbs)
    assert (before, proof.mbs_mass) == pytest.approx((2.6, 2.5))
    assert proof.urdf_mass == before


@pytest.mark.parametrize("size", [1e-6, 1e3])
def test_a_deviation_is_relative_to_the_robot(size: float) -> None:
    """A robot of another size, with the same fault: the same deviations."""
    solid = SOLID.replace("0.1 -0.2 0.3", f"{0.1 * size} {-0.2 * size} {0.3 * size}")
    joints = (joint("world", "a"), joint("a", "b", xyz=f"{size} 0 0"))
    result, mbs = pieces(robot(link("world"), link("a", solid), link("b", solid), *joints))
    b = body(mbs, "b")
    b.com = (b.com[0] + 1e-3 * size, *b.com[1:])
    (found,) = compared(result, mbs).differences
    assert found.kind == "centre"
    assert found.size == pytest.approx(1e-3 / 1.0001)


def test_small_deviations_of_bodies_may_sum_up() -> None:
    """Each body is as it should be, by the tolerance, and both together are not."""
    joints = (joint("world", "a"), joint("a", "b", "fixed", xyz="0 1 0"))
    result, mbs = pieces(robot(link("world"), link("a", SOLID), link("b", SOLID), *joints))
    for name, off in (("a", -8e-4), ("b", 8e-4)):
        x, y, z = body(mbs, name).com
        body(mbs, name).com = (x, y + off, z)
    (found,) = compared(result, mbs, tolerance=1e-3).differences
    assert (found.kind, found.link, found.message) == ("inertia", "a", "link 'a': inertia")
    assert 1e-3 < found.size < 1e-2


def test_two_cuts_that_share_joints_want_as_many_dependent_joints_as_they_hold() -> None:
    """Three arms in a plane, tip to tip: each cut leaves the joints of one arm alone."""
    elements = [link("world")]
    for x, (one, two) in enumerate(("ab", "cd", "ef")):
        elements += [link(one, SOLID), link(two, SOLID), joint("world", one, xyz=f"{x} 0 0"),
                     joint(one, two, xyz=f"0.3 {1 + x} 0")]  # fmt: skip
    result, mbs = pieces(robot(*elements))
    for name in "bdf":
        body(mbs, name).points.append(Point("end", (0.4, 0.1, 0.0)))
    mbs.cuts = [Connection("ball", a + b, (a, "end"), (b, "end")) for a, b in ("bd", "df")]
    for count in (3, 4, 5):
        names = ["world_to_a", "a_to_b", "world_to_c", "c_to_d", "world_to_e"][:count]
        for name in names:
            own_joint(mbs, name).nature = "dependent"
        assert kinds(compared(result, mbs)) == (set() if count == 4 else {"cut"})


def test_a_cut_of_a_joint_in_gazebo_is_no_deviation() -> None:
    closing = ClosingJoint("pin", "revolute", "hand", "tool")
    result, mbs = pieces(base="fixed")
    result.robot.extensions = [Extension("gazebo", "", joints=[closing])]
    for name, stated in (("pin", True), ("pin_1", True), ("pin_2", True), ("pin_3", False)):
        mbs.cuts = [Connection("ball", name, ("hand", None), (None, None))]
        proof = compared(result, mbs)
        assert (f"cut '{name}' (ball)" in proof.not_compared) is stated
        assert (f"cut '{name}' (ball)" in proof.but_for) is not stated


def test_where_a_frame_should_be_is_said() -> None:
    result, mbs = pieces()
    frames = {"hand": LinkFrame("arm", None, Pose()), "tool": LinkFrame("none", None, Pose())}
    said = [found.message for found in compared(result, mbs, frames=frames).frames]
    assert said[0] == "link 'hand': moves with another body"
    assert said[1] == "link 'tool': no body or joint 'none' in the .mbs"


def test_how_far_an_axis_is_beside_is_said() -> None:
    """The body and what hangs on it are where they should be, and the axis alone is not."""
    result, mbs = pieces(robot(link("world"), link("a", SOLID), joint("world", "a")))
    own = body(mbs, "a")
    own.joints = [Joint("to", "T1", "driven", q=0.01), *own.joints,
                  Joint("back", "T1", "driven", q=-0.01)]  # fmt: skip
    (found,) = compared(result, mbs).differences
    assert found.kind == "axis"
    assert "axis is displaced by 0.01 m in the .mbs" in found.message


def test_a_number_that_the_urdf_has_not_is_told_as_such() -> None:
    result, mbs = pieces()
    (damping,) = (model for model in mbs.user_models if model.name == "damping")
    (own,) = damping.parameters
    damping.parameters = [Parameter(own.name, "scalar", ("7",)),
                          Parameter("wrist_roll", "scalar", ("8",))]  # fmt: skip
    told = {found.joint: found.message for found in compared(result, mbs).differences}
    stated = result.robot.joints[own.name].dynamics.damping
    assert told == {
        own.name: f"joint '{own.name}': damping is 7; expected {stated:.9g}",
        "wrist_roll": "joint 'wrist_roll': damping is 8; the URDF has none",
    }


def test_a_link_without_mass_is_placed_by_what_it_carries() -> None:
    """So the joint that is wrong is named, and not the one after it."""
    result, mbs = pieces()
    body(mbs, "arm").points[0].coordinates = (0.05, 0.0, 0.3)
    (found,) = compared(result, mbs).differences
    assert found.message.startswith("link 'wrist' is displaced behind joint 'wrist_roll'")
    result, mbs = pieces(re.sub(r'(?s)(<link name="arm">\s*)<inertial>.*?</inertial>', r"\1", TINY))
    own_joint(mbs, "shoulder").type = "R1"
    assert kinds(compared(result, mbs)) == {"axis"}
