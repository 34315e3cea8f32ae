"""Which .mbs joints and frames are a URDF's, by their names."""

from pathlib import Path

import pytest

from support.build import SOLID, joint, link, robot
from support.presets import PRESETS
from urdf2mbs.mbs.model import Body, Joint, Mbs, Point
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.proof.compare import compare
from urdf2mbs.proof.match import match_by_name
from urdf2mbs.proof.mbs_side import build_mbs_side
from urdf2mbs.proof.rigid import AXES, compose, compute_rotation, compute_translation
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs.urdf.reader import parse_urdf
from urdf2mbs.verification import verify


def test_a_frame_ends_where_the_next_fixed_joint_begins() -> None:
    text = robot(
        link("world"),
        link("a", SOLID),
        link("b"),
        link("c", SOLID),
        joint("world", "a", name="i"),
        joint("a", "b", name="j"),
        joint("b", "c", "fixed", name="k"),
    )
    result = convert_text(text)
    assert [joint.name for joint in result.mbs.bodies[1].joints][-2:] == ["j", "k"]
    frames = match_by_name(result.robot, result.mbs).frames
    assert (frames["b"].body, frames["b"].joint) == ("c", "j")
    assert (frames["c"].body, frames["c"].joint) == ("c", None)


def files(tmp_path: Path) -> tuple[Path, Path]:
    source, model = tmp_path / "tiny.urdf", tmp_path / "tiny.mbs"
    source.write_text(TINY)
    model.write_bytes(convert_text().data)
    return source, model


@pytest.mark.parametrize(
    ("types", "wrong_joints"),
    [("R3 R2 R1", set()), ("R2 R3 R1", set()), ("R3 R1 R3", {"floating_base"})],
)
def test_a_floating_base_may_have_another_order_of_rotations(
    types: str, wrong_joints: set[str], tmp_path: Path
) -> None:
    source, model = files(tmp_path)
    mbs = read_mbs(model.read_bytes(), "")
    for rotation, joint_type in zip(mbs.bodies[0].joints[3:6], types.split(), strict=True):
        rotation.type = joint_type
    model.write_bytes(write(mbs))
    differences = verify(source, model).differences
    assert {difference.joint for difference in differences} == wrong_joints
    assert all(difference.kind in ("axis", "type") for difference in differences)


PLANES = ["1 0 0", "0 1 0", "0 0 1", "0 0 -1", "1 2 2"]


@pytest.mark.parametrize("pipeline", PRESETS)
def test_joints_are_found_by_the_names_of_a_conversion(pipeline: str) -> None:
    kinds = [("planar", axis) for axis in PLANES]
    kinds += [("prismatic", "0 1 0"), ("continuous", "1 0 0"), ("floating", "1 0 0")]
    names = ["world", *(f"{kind}{k}" for k, (kind, _) in enumerate(kinds))]
    joints = [
        joint(a, b, kind, axis=axis, name=f"of {b}")
        for a, b, (kind, axis) in zip(names, names[1:], kinds, strict=False)
    ]
    result = convert_text(
        robot(link("world"), *(link(name, SOLID) for name in names[1:]), *joints),
        pipeline=pipeline,
    )
    matched = match_by_name(result.robot, result.mbs).joints
    assert matched == {name: tuple(names) for name, names in result.names.coordinates.items()}


def test_joints_with_the_same_identifier_are_distinguished() -> None:
    names = ["a b", "a-b", "a.b", "a:b"]
    links = [link("world"), *(link(f"l{k}", SOLID) for k in range(4))]
    joints = [joint("world", f"l{k}", name=name) for k, name in enumerate(names)]
    result = convert_text(robot(*links, *joints))
    found = match_by_name(result.robot, result.mbs).joints
    assert found == {name: tuple(result.names.coordinates[name]) for name in names}


@pytest.mark.parametrize("kind", ["continuous", "prismatic", "planar", "floating"])
def test_a_joint_of_the_right_type_is_preferred_to_one_of_the_right_name(kind: str) -> None:
    solids = (link(name, SOLID) for name in "ab")
    result = convert_text(robot(link("world"), *solids, joint("world", "a"), joint("a", "b", kind)))
    first, *others = result.names.coordinates["a_to_b"]
    renamed = next(joint for joint in result.mbs.bodies[1].joints if joint.name == first)
    renamed.name += "_joint"
    wrong_type = "R1" if renamed.type[0] == "T" else "T1"
    result.mbs.bodies[1].joints.append(Joint(first, wrong_type))
    assert match_by_name(result.robot, result.mbs).joints["a_to_b"] == (renamed.name, *others)


@pytest.mark.parametrize("kind", ["T1", "T2", "T3", "R1", "R2", "R3"])
def test_a_joint_moves_along_or_about_an_axis_of_the_frame_before(kind: str) -> None:
    mbs = Mbs("r")
    first = [
        Joint("a", "R1", "driven", 0.3),
        Joint("b", "R2", "driven", 0.5),
        Joint("c", "R3", "driven", 0.7),
        Joint("d", "T1", "driven", 0.9),
    ]
    last = Joint("last", kind, "driven", 0.4)
    mbs.bodies = [Body("before", None, None, first), Body("after", None, None, [*first, last])]
    frames = build_mbs_side(mbs, ()).frames
    move = compute_rotation if kind[0] == "R" else compute_translation
    expected = compose(frames["before"][1], move(AXES[int(kind[1]) - 1], 0.4))
    assert frames["after"][1] == pytest.approx(expected, abs=1e-15)


def test_a_wrong_zero_is_reported_though_the_link_is_slightly_displaced(tmp_path: Path) -> None:
    source, model = files(tmp_path)
    mbs = read_mbs(model.read_bytes(), "")
    arm = next(body for body in mbs.bodies if body.name == "arm")
    at = [joint.name for joint in arm.joints].index("shoulder")
    arm.joints.insert(at, Joint("more", arm.joints[at].type, "driven", q=0.3))
    # 5e-5 m on a scale of about 0.3 m, beside 0.3 rad
    arm.joints.insert(at, Joint("aside", "T1", "driven", q=5e-5))
    model.write_bytes(write(mbs))
    differences = verify(str(source), model).differences
    (message,) = [each.message for each in differences if each.kind == "zero"]
    assert "joint 'shoulder': zero is at 0.3 rad of the URDF" in message
    assert "and link 'arm' is shifted by" in message


def test_names_with_the_same_identifier_are_matched_in_the_order_of_writing() -> None:
    """A branch at the origin of the root is written first."""
    links = [link("base"), *(link(name, SOLID) for name in "ab")]
    joints = [joint("base", "a", name="j-1", xyz="1 0 0"), joint("base", "b", name="j.1")]
    result = convert_text(robot(*links, *joints))
    expected = {name: tuple(names) for name, names in result.names.coordinates.items()}
    found = match_by_name(result.robot, result.mbs).joints
    assert {name: found[name] for name in ("j-1", "j.1")} == {
        k: expected[k] for k in ("j-1", "j.1")
    }
    assert expected["j-1"] != expected["j.1"]


def test_a_joint_may_have_the_name_of_another_body() -> None:
    """The frame after the joint is not taken for the frame of the body."""
    heavy = '<inertial><mass value="2"/>'
    heavy += '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    text = '<robot name="r">' + "".join(f'<link name="{name}">{heavy}</link>' for name in "abc")
    for name, child in (("a", "b"), ("turn", "c")):
        text += f'<joint name="{name}" type="continuous"><parent link="a"/><child link="{child}"/>'
        text += '<origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>'
    robot, _ = parse_urdf(f"{text}</robot>".encode(), "r.urdf")
    inertia = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    mbs = Mbs("r")
    mbs.bodies = [
        Body(
            "a",
            None,
            None,
            [Joint("hold", "R3", "driven")],
            2.0,
            (0.0, 0.0, 0.0),
            inertia,
            [Point("at", (1.0, 0.0, 0.0))],
        ),
        Body(
            "b",
            "a",
            "at",
            [Joint("a", "R3"), Joint("off", "T1", "driven", 0.5)],
            2.0,
            (-0.5, 0.0, 0.0),
            inertia,
        ),
        Body("c", "a", "at", [Joint("turn", "R3")], 2.0, (0.0, 0.0, 0.0), inertia),
    ]
    known = match_by_name(robot, mbs)
    known.frames["b"].joint = "a"
    known.frames["b"].body = "b"
    comparison = compare(robot, mbs, known)
    assert comparison.differences == []
    assert comparison.frames == []
