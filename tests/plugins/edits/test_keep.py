"""What somebody moved by hand stays, in a diagram that is made anew."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from urdf2mbs import convert
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import TINY
from urdf2mbs_edits.diff.flat import things
from urdf2mbs_edits.diff.matching import match
from urdf2mbs_edits.merge.keep import keep

if TYPE_CHECKING:
    from pathlib import Path

    from urdf2mbs.mbs.model import Mbs


@pytest.fixture
def by_hand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The tiny robot, converted, and its arm and the arm's point moved by hand."""
    monkeypatch.chdir(tmp_path)
    robot = tmp_path / "tiny.urdf"
    robot.write_text(TINY.replace('name="arm"', 'name="left/arm"').replace('"arm"', '"left/arm"'))
    output = tmp_path / "tiny.mbs"
    output.write_bytes(convert(robot).data)
    mbs = read(output.read_bytes(), "tiny.mbs")
    arm = mbs.bodies[1]
    for joint in arm.joints:
        assert joint.position is not None
        joint.position = (joint.position[0] + 333.0, joint.position[1] + 44.0)
    arm.points[0].position = (777.0, 888.0)
    output.write_bytes(write(mbs))
    return tmp_path


def again(folder: Path) -> Mbs:
    """A new diagram with the places of the file."""
    mbs, drawn = convert(folder / "tiny.urdf").mbs, read((folder / "tiny.mbs").read_bytes(), "m")
    found, before = things(mbs), things(drawn)
    match(found, before)
    there = {thing.number: thing.part for thing in before}
    keep(mbs, {id(t.part): there[t.number] for t in found if t.number in there})
    return mbs


def places(result_or_file: Any) -> dict[str, Any]:
    mbs = result_or_file
    out: dict[str, Any] = {"base": (mbs.base.position, mbs.base.drawing.size)}
    for body in mbs.bodies:
        out[body.name] = (body.drawing.position, [j.position for j in body.joints])
        out[f"{body.name}'s points"] = [p.position for p in body.points]
    return out


def test_what_was_moved_stays(by_hand: Path) -> None:
    before = read((by_hand / "tiny.mbs").read_bytes(), "tiny.mbs")
    assert places(again(by_hand)) == places(before)


def test_a_new_body_stands_beside_its_parent(by_hand: Path) -> None:
    robot = by_hand / "tiny.urdf"
    extra = """
      <joint name="bolt" type="revolute">
        <parent link="left/arm"/><child link="plate"/>
        <origin xyz="0 0 0.3"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
      </joint>
      <link name="plate"><inertial><mass value="1"/>
        <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
    </robot>"""
    robot.write_text(robot.read_text().replace("</robot>", extra))
    before = places(read((by_hand / "tiny.mbs").read_bytes(), "tiny.mbs"))
    mbs = again(by_hand)
    after = places(mbs)
    assert after["left_arm"] == before["left_arm"]
    fresh = convert(robot).mbs
    (new,) = [body for body in mbs.bodies if body.name == "plate"]
    (there,) = [body for body in fresh.bodies if body.name == "plate"]
    arm = mbs.bodies[1].joints[-1].position
    fresh_arm = fresh.bodies[1].joints[-1].position
    assert new.joints[-1].position is not None
    for k in (0, 1):
        apart = there.joints[-1].position[k] - fresh_arm[k]
        assert new.joints[-1].position[k] - arm[k] == pytest.approx(apart)


def test_a_body_with_other_joints_keeps_the_places_of_those_that_stay(by_hand: Path) -> None:
    before = read((by_hand / "tiny.mbs").read_bytes(), "tiny.mbs").joints()
    robot = by_hand / "tiny.urdf"
    robot.write_text(robot.read_text().replace('rpy="0 0.5 0"', 'rpy="0 0.5 0.2"'))
    after = again(by_hand).joints()
    assert after.keys() - before.keys()
    for name in after.keys() & before.keys():
        assert after[name].position == before[name].position


def test_a_file_without_a_diagram_is_no_error(by_hand: Path) -> None:
    mbs = read((by_hand / "tiny.mbs").read_bytes(), "tiny.mbs")
    mbs.base.position = mbs.base.drawing = None
    for body in mbs.bodies:
        body.drawing = None
        for part in (*body.joints, *body.points):
            part.position = None
    (by_hand / "tiny.mbs").write_bytes(write(mbs))
    drawn = again(by_hand)
    assert all(joint.position for body in drawn.bodies for joint in body.joints)
