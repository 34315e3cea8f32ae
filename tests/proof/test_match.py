"""Which .mbs joints and frames are a URDF's, by their names."""

from __future__ import annotations

from pathlib import Path

import pytest
from proving import SOLID, joint, link, robot

from urdf2mbs.api import verify
from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs.proof.match import match
from urdf2mbs.proof.mbs_side import mbs_side
from urdf2mbs.proof.rigid import AXES, compose, shift, spin
from urdf2mbs.testing import TINY, convert_text


def test_a_frame_ends_where_the_next_fixed_joint_begins() -> None:
    text = robot(
        link("world"), link("a", SOLID), link("b"), link("c", SOLID),
        joint("world", "a", name="i"), joint("a", "b", name="j"),
        joint("b", "c", "fixed", name="k"),
    )  # fmt: skip
    result = convert_text(text)
    assert [one.name for one in result.mbs.bodies[1].joints][-2:] == ["j", "k"]
    frames = match(result.robot, result.mbs).frames
    assert (frames["b"].body, frames["b"].joint) == ("c", "j")
    assert (frames["c"].body, frames["c"].joint) == ("c", None)


def files(tmp_path: Path) -> tuple[Path, Path]:
    source, model = tmp_path / "tiny.urdf", tmp_path / "tiny.mbs"
    source.write_text(TINY)
    model.write_bytes(convert_text().data)
    return source, model


@pytest.mark.parametrize("kinds", ["R3 R2 R1", "R2 R3 R1"])
def test_a_floating_base_may_turn_in_another_order(kinds: str, tmp_path: Path) -> None:
    source, model = files(tmp_path)
    mbs = read(model.read_bytes(), "")
    first = mbs.bodies[0].joints
    for one, kind in zip(first[3:6], kinds.split(), strict=True):
        one.type = kind
    model.write_bytes(write(mbs))
    assert verify(str(source), model).same


def test_a_base_that_turns_twice_about_one_axis_is_not_the_same(tmp_path: Path) -> None:
    source, model = files(tmp_path)
    mbs = read(model.read_bytes(), "")
    for one, kind in zip(mbs.bodies[0].joints[3:6], ("R3", "R1", "R3"), strict=True):
        one.type = kind
    model.write_bytes(write(mbs))
    found = verify(str(source), model).differences
    assert {one.joint for one in found} == {"floating_base"}
    assert all(one.kind in ("axis", "type") for one in found)


PLANES = ["1 0 0", "0 1 0", "0 0 1", "0 0 -1", "1 2 2"]


@pytest.mark.parametrize("pipeline", ["faithful", "compact"])
def test_joints_are_found_by_the_names_of_a_conversion(pipeline: str) -> None:
    kinds = [("planar", axis) for axis in PLANES]
    kinds += [("prismatic", "0 1 0"), ("continuous", "1 0 0"), ("floating", "1 0 0")]
    names = ["world", *(f"{kind}{k}" for k, (kind, _) in enumerate(kinds))]
    joints = [joint(a, b, kind, axis=axis, name=f"of {b}")
              for a, b, (kind, axis) in zip(names, names[1:], kinds, strict=False)]  # fmt: skip
    result = convert_text(
        robot(link("world"), *(link(name, SOLID) for name in names[1:]), *joints),
        pipeline=pipeline,
    )
    found = match(result.robot, result.mbs).joints
    assert found == {name: tuple(own) for name, own in result.names.coordinates.items()}


@pytest.mark.parametrize("kind", ["continuous", "prismatic", "planar", "floating"])
def test_a_joint_of_the_right_kind_goes_before_one_of_the_right_name(kind: str) -> None:
    solids = (link(name, SOLID) for name in "ab")
    result = convert_text(robot(link("world"), *solids, joint("world", "a"), joint("a", "b", kind)))
    first, *others = result.names.coordinates["a_to_b"]
    own = next(own for own in result.mbs.bodies[1].joints if own.name == first)
    own.name += "_joint"
    result.mbs.bodies[1].joints.append(Joint(first, "R1" if own.type[0] == "T" else "T1"))
    assert match(result.robot, result.mbs).joints["a_to_b"] == (own.name, *others)


@pytest.mark.parametrize("kind", ["T1", "T2", "T3", "R1", "R2", "R3"])
def test_a_step_is_along_or_about_an_axis_of_the_frame_before(kind: str) -> None:
    mbs = Mbs("r")
    first = [Joint("a", "R1", "driven", 0.3), Joint("b", "R2", "driven", 0.5),
             Joint("c", "R3", "driven", 0.7), Joint("d", "T1", "driven", 0.9)]  # fmt: skip
    last = Joint("last", kind, "driven", 0.4)
    mbs.bodies = [Body("before", None, None, first), Body("after", None, None, [*first, last])]
    frames = mbs_side(mbs, ()).frames
    move = spin if kind[0] == "R" else shift
    expected = compose(frames["before"][1], move(AXES[int(kind[1]) - 1], 0.4))
    assert frames["after"][1] == pytest.approx(expected, abs=1e-15)


def test_a_joints_zero_is_told_though_its_link_is_a_little_off(tmp_path: Path) -> None:
    source, model = files(tmp_path)
    mbs = read(model.read_bytes(), "")
    arm = next(body for body in mbs.bodies if body.name == "arm")
    at = next(n for n, one in enumerate(arm.joints) if one.name == "shoulder")
    arm.joints.insert(at, Joint("more", arm.joints[at].type, "driven", q=0.3))
    # 5e-5 m on a scale of about 0.3 m, beside 0.3 rad
    arm.joints.insert(at, Joint("aside", "T1", "driven", q=5e-5))
    model.write_bytes(write(mbs))
    (told,) = [one.message for one in verify(str(source), model).differences if one.kind == "zero"]
    assert "joint 'shoulder': its zero is the URDF's 0.3 rad" in told
    assert "and link 'arm' is shifted by" in told
