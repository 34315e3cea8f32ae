"""`verify` of two .mbs files and of two URDFs: same, different, not compared."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs import convert, verify
from urdf2mbs.api import Verdict
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs, Parameter, Point, Sensor, UserModel
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.proof.alike import compare_models
from urdf2mbs.proof.compare import compare
from urdf2mbs.proof.match import match
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.verdict import Proof
from urdf2mbs.testing import TINY
from urdf2mbs.urdf.reader import parse

CALLED = ("a.mbs", "b.mbs")


def loop() -> Mbs:
    """Two pendulums side by side, tied by a rod, with a force, a link and a user model."""
    mbs = Mbs("loop")
    for name, x in (("left", 0.0), ("right", 1.0)):
        mbs.base.points.append(Point(f"at_{name}", (x, 0.0, 0.0)))
        mbs.bodies.append(
            Body(
                name, None, f"at_{name}", [Joint(f"swing_{name}", "R2", "independent")],
                mass=1.0 + x, com=(0.0, 0.0, -0.5), inertia=(0.1, 0.0, 0.0, 0.1, 0.0, 0.01),
                points=[Point("tip", (0.0, 0.0, -1.0))],
            )
        )  # fmt: skip
    mbs.bodies[1].joints[0].nature = "dependent"
    mbs.bodies[0].points[0].extforce = Sensor("wind")
    mbs.bodies[1].points[0].sensor = Sensor("imu")
    mbs.cuts = [Connection("rod", "tie", ("left", "tip"), ("right", "tip"), 1.0)]
    mbs.links = [Connection("link", "spring", ("left", None), ("right", "tip"))]
    mbs.user_models = [UserModel("spring", [Parameter("k", "scalar", ("10.0",))])]
    return mbs


def compared(after: Mbs) -> Proof:
    return compare_models(loop(), after, TOLERANCE, CALLED)


def kinds(after: Mbs) -> set[str]:
    return {difference.kind for difference in compared(after).differences}


def test_a_model_is_as_itself_and_what_is_not_compared_is_named() -> None:
    same = compared(loop())
    assert same.same
    assert same.not_compared == {
        "link 'spring' (link)": "left to the user functions",
        "force 'wind'": "left to the user functions",
        "1 sensor": "they do not move the robot",
    }


def edits() -> dict[str, tuple[Any, set[str]]]:
    def body(mbs: Mbs) -> Body:
        return mbs.bodies[0]

    return {
        "mass": (lambda m: setattr(body(m), "mass", 2.0), {"mass"}),
        "no number": (lambda m: setattr(body(m), "mass", float("nan")), {"mass"}),
        "gravity": (lambda m: setattr(m.base, "gravity", (0.0, 0.0, 9.81)), {"gravity"}),
        "nature": (lambda m: setattr(body(m).joints[0], "nature", "dependent"), {"nature"}),
        "rod": (lambda m: setattr(m.cuts[0], "length", 1.1), {"cut"}),
        "end": (lambda m: setattr(m.cuts[0], "endpoint1", ("left", None)), {"cut"}),
        "no cut": (lambda m: m.cuts.clear(), {"cut"}),
        "draft": (lambda m: setattr(m.cuts[0], "endpoint1", ("", "")), {"cut"}),
        "link": (lambda m: setattr(m.links[0], "endpoint1", (None, None)), {"link"}),
        "parameter": (
            lambda m: setattr(m.user_models[0].parameters[0], "values", ("11",)), {"parameter"},
        ),
        "respelt": (
            lambda m: setattr(m.user_models[0].parameters[0], "values", ("1e1",)), set(),
        ),
        "joint": (lambda m: body(m).joints.append(Joint("more", "R1")), {"joint-extra"}),
        "driven": (lambda m: body(m).joints.append(Joint("still", "R1", "driven")), set()),
        "symbols": (lambda m: setattr(body(m).joints[0], "symbols", ("q",)), {"symbols"}),
        "force": (lambda m: setattr(body(m).points[0], "extforce", None), {"force"}),
    }  # fmt: skip


@pytest.mark.parametrize("name", edits())
def test_an_edit_is_a_difference(name: str) -> None:
    change, expected = edits()[name]
    after = deepcopy(loop())
    change(after)
    assert kinds(after) == expected


def test_exchanged_ends_are_named_and_no_difference() -> None:
    after = loop()
    cut = after.cuts[0]
    cut.endpoint1, cut.endpoint2 = cut.endpoint2, cut.endpoint1
    comparison = compared(after)
    assert comparison.same
    assert list(comparison.but_for) == ["cut 'tie'"]


def test_a_body_may_have_its_frame_elsewhere() -> None:
    """The point, the centre and the joint's place move along."""
    after = loop()
    left = after.bodies[0]
    left.joints.append(Joint("down", "T3", "driven", q=-0.25))
    left.com = (0.0, 0.0, -0.25)
    left.points = [Point("tip", (0.0, 0.0, -0.75), extforce=Sensor("wind")),
                   Point("top", (0.0, 0.0, 0.25))]  # fmt: skip
    after.links[0].endpoint1 = ("left", "top")
    assert compared(after).same


def test_another_zero_of_a_joint_is_one_difference() -> None:
    """What the joint carries tells how far its zero is off."""
    before, after = loop(), loop()
    for mbs in (before, after):
        mbs.cuts.clear()
        mbs.links.clear()
        mbs.bodies[0].com = (0.1, 0.0, -0.5)
    after.bodies[0].joints.insert(0, Joint("still", "R2", "driven", q=0.25))
    (found,) = compare_models(before, after, TOLERANCE, CALLED).differences
    assert (found.kind, found.joint) == ("zero", "swing_left")
    assert found.message == "joint 'swing_left': its zero is a.mbs's 0.25 rad"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "tiny.mbs").write_bytes(convert("tiny.urdf").data)
    return tmp_path


def test_the_compact_model_is_the_faithful_one(folder: Path, capsys: Any) -> None:
    (folder / "compact.mbs").write_bytes(convert("tiny.urdf", pipeline="compact").data)
    assert main(["verify", "tiny.mbs", "compact.mbs"]) == 0
    assert capsys.readouterr().out.endswith("the same robot\n")


PENDULUM = """<robot name="pendulum"><link name="world"/>
<link name="ball"><inertial><mass value="1"/></inertial></link>
<joint name="swing" type="continuous"><parent link="world"/><child link="ball"/></joint></robot>"""


def test_two_urdfs(folder: Path) -> None:
    def against(old: str, new: str, **options: Any) -> Verdict:
        assert old in TINY
        (folder / "new.urdf").write_text(TINY.replace(old, new))
        return verify("tiny.urdf", "new.urdf", **options)

    assert against('<mass value="2"/>', '<mass value="2.00"/>').same
    heavy = against('<mass value="2"/>', '<mass value="3"/>')
    assert [difference.message for difference in heavy.differences] == [
        "link 'body': mass is 3 in new.urdf, and should be 2"
    ]
    limit = against('lower="-1.5"', 'lower="-1.4"')
    assert [difference.kind for difference in limit.differences] == ["parameter"]
    assert [d.kind for d in against('name="shoulder"', 'name="elbow"').differences] == [
        "type", "joint-extra"
    ]  # fmt: skip
    assert not against(TINY, PENDULUM).same  # no group in common
    tool = ('<origin xyz="0 0 0.1" rpy="0 1.5708 0"/>', '<origin xyz="0 0 0.2"/>')
    assert against(*tool).same
    assert len(against(*tool).frames) == 1
    assert "frame" not in against(*tool).largest
    mark = '<joint name="mark" type="fixed"><parent link="body"/><child link="mark"/></joint>'
    marked = against("</robot>", f'<link name="mark"/>{mark}</robot>')
    assert marked.same
    assert [found.message for found in marked.frames] == ["link 'mark' is in new.urdf only"]
    moved = against(*tool, frames=True)
    assert not moved.same
    assert moved.largest["frame"] > 1.0


def test_the_order_of_robot_and_model_does_not_matter(folder: Path) -> None:
    assert verify("tiny.mbs", "tiny.urdf").same
    with pytest.raises(ConfigError, match="compares a URDF with"):
        verify("tiny.mbs", "tiny.mbs", engine="pinocchio")


def test_a_framed_joint_may_be_called_as_another_body() -> None:
    """The frame after the joint is asked for; the frame of the body stays its own."""
    heavy = '<inertial><mass value="2"/>'
    heavy += '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    text = '<robot name="r">' + "".join(f'<link name="{name}">{heavy}</link>' for name in "abc")
    for name, child in (("a", "b"), ("turn", "c")):
        text += f'<joint name="{name}" type="continuous"><parent link="a"/><child link="{child}"/>'
        text += '<origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>'
    robot, _ = parse(f"{text}</robot>".encode(), "r.urdf")
    inertia = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    mbs = Mbs("r")
    mbs.bodies = [
        Body("a", None, None, [Joint("hold", "R3", "driven")], 2.0, (0.0, 0.0, 0.0), inertia,
             [Point("at", (1.0, 0.0, 0.0))]),
        Body("b", "a", "at", [Joint("a", "R3"), Joint("off", "T1", "driven", 0.5)], 2.0,
             (-0.5, 0.0, 0.0), inertia),
        Body("c", "a", "at", [Joint("turn", "R3")], 2.0, (0.0, 0.0, 0.0), inertia),
    ]  # fmt: skip
    known = match(robot, mbs)
    known.frames["b"].joint = "a"
    known.frames["b"].body = "b"
    comparison = compare(robot, mbs, known.joints, frames=known.frames)
    assert comparison.differences == []
    assert comparison.frames == []
