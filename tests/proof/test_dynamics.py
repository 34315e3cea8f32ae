"""What Pinocchio is given: the model in its order, and the URDF's text as our reader takes it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from proving import SOLID, joint, link, robot

from urdf2mbs.api import verify
from urdf2mbs.mbs.model import Joint, Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs.proof.dynamics import compare_dynamics, to_pinocchio
from urdf2mbs.testing import TINY, convert_text

pinocchio = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")


def test_bodies_that_are_not_depth_first(tmp_path: Path) -> None:
    """A file edited by hand may have them in any order with parents first."""
    links = [link("world"), *(link(name, SOLID) for name in ("a", "b", "a2", "b2"))]
    joints = [
        joint("world", "a", axis="1 0 0"), joint("world", "b", axis="0 1 0", xyz="1 0 0"),
        joint("a", "a2", axis="0 1 0", xyz="0 1 0"), joint("b", "b2", axis="1 0 0", xyz="0 1 1"),
    ]  # fmt: skip
    text = robot(*links, *joints)
    mbs = read(convert_text(text).data, "")
    bodies = {body.name: body for body in mbs.bodies}
    mbs.bodies = [bodies[name] for name in ("a", "b", "a2", "b2")]
    (tmp_path / "r.urdf").write_text(text)
    (tmp_path / "r.mbs").write_bytes(write(mbs))
    verdict = verify(str(tmp_path / "r.urdf"), tmp_path / "r.mbs", engine="pinocchio")
    assert verdict.same, verdict.differences
    assert verdict.largest["mass matrix"] <= 1e-12


XACRO = (
    '<robot name="tiny" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    '<xacro:property name="half" value="0.25"/>'
)
SLIPS = {
    "a blank line first": lambda text: "\n" + text,
    "a comment with --": lambda text: text.replace("</robot>", "<!-- a -- b --></robot>"),
    "commas": lambda text: text.replace('xyz="0 0 0.3"', 'xyz="0, 0, 0.3"'),
    "a number on two lines": lambda text: text.replace('<mass value="2"/>', '<mass value="2\n"/>'),
    "a follower": lambda text: text.replace(
        '<axis xyz="0 1 1"/>', '<axis xyz="0 1 1"/><mimic joint="wrist_roll"/>'
    ),
    "joints that move no mass": lambda text: re.sub(
        r'(?s)(<link name="hand">\s*)<inertial>.*?</inertial>', r"\1", text
    ),
    "a ball joint": lambda text: text.replace(
        'name="wrist_pitch" type="revolute"', 'name="wrist_pitch" type="ball"'
    ),
    "two joints of one name": lambda text: text.replace(
        'joint name="wrist_pitch"', 'joint name="wrist_roll"'
    ),
    "xacro": lambda text: text.replace('<robot name="tiny">', XACRO).replace(
        '<mass value="0.5"/>', '<mass value="${2 * half}"/>'
    ),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_slips_and_xacro_in_a_urdf(slip: str, tmp_path: Path) -> None:
    text = SLIPS[slip](TINY)
    assert slip == "xacro" or text != TINY
    (tmp_path / "r.urdf").write_text(text)
    (tmp_path / "r.mbs").write_bytes(convert_text(text).data)
    assert verify(str(tmp_path / "r.urdf"), tmp_path / "r.mbs", engine="pinocchio").same


def test_bodies_and_points_are_frames_of_the_model() -> None:
    mbs = read(convert_text(TINY, base="fixed").data, "")
    model = to_pinocchio(mbs)
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model))
    at = {frame.name: pose for frame, pose in zip(model.frames, data.oMf, strict=True)}
    for body in mbs.bodies:
        assert body.points
        for point in body.points:
            expected = at[body.name].act(np.array(point.coordinates))
            seen = at[f"{body.name}/{point.name}"]
            assert np.allclose(seen.translation, expected, rtol=0.0, atol=1e-15)
            assert np.array_equal(seen.rotation, at[body.name].rotation)


def compare(text: str, mbs: Mbs, moving: list[str]) -> dict[str, float]:
    """How far the dynamics of a URDF and an .mbs are apart, by kind."""
    return compare_dynamics(text.encode(), mbs, {name: (name,) for name in moving})[1]


@pytest.mark.parametrize("kilogram", [1e-6, 1.0, 1e6])
def test_a_deviation_counts_as_much_in_a_light_robot(kilogram: float) -> None:
    """A tenth more mass and inertia everywhere."""
    text = re.sub(
        '(mass value|i[xyz]{2})="(.*?)"', lambda m: f'{m[1]}="{float(m[2]) * kilogram}"', TINY
    )
    mbs = read(convert_text(TINY, base="fixed").data, "")
    for body in mbs.bodies:
        body.mass = 1.1 * kilogram * (body.mass or 0.0)
        body.inertia = tuple(1.1 * kilogram * number for number in body.inertia or ())
    found = compare(text, mbs, [joint.name for body in mbs.bodies for joint in body.joints])
    assert found["mass matrix"] == pytest.approx(0.1, rel=1e-9)
    assert 1e-3 < found["gravity forces"] < 0.1
    assert 1e-3 < found["inverse dynamics"] < 0.1


@pytest.mark.parametrize(
    ("kind", "moved"), [("R1", {"rpy": "0.4 0 0"}), ("T1", {"xyz": "0.4 0 0"})]
)
def test_a_driven_joint_is_held_at_its_value(kind: str, moved: dict[str, str]) -> None:
    links = [link("world"), *(link(name, SOLID) for name in "ab")]
    text = robot(*links, joint("world", "a", axis="0 1 0"), joint("a", "b", "fixed", **moved))
    turning = robot(*links, joint("world", "a", axis="0 1 0"), joint("a", "b", axis="1 0 0"))
    mbs = read(convert_text(turning).data, "")
    held = mbs.bodies[1].joints[0]
    held.type, held.nature, held.q = kind, "driven", 0.4
    assert max(compare(text, mbs, ["world_to_a"]).values()) <= 1e-12


def test_a_body_without_inertia_has_a_mass() -> None:
    mbs = read(convert_text(TINY, base="fixed").data, "")
    for body in mbs.bodies:
        body.inertia = None
    text = re.sub('(i[xyz]{2})=".*?"', r'\1="0"', TINY)
    moving = [joint.name for body in mbs.bodies for joint in body.joints]
    assert max(compare(text, mbs, moving).values()) <= 1e-12


def test_other_joints_are_told_and_not_compared() -> None:
    mbs = read(convert_text(TINY, base="fixed").data, "")
    joints = {name: (name,) for name in ("shoulder", "wrist_roll", "wrist_pitch")}
    mbs.bodies[-1].joints.append(Joint("more", "R1", "independent"))
    (found,), largest = compare_dynamics(TINY.encode(), mbs, joints)
    assert (found.kind, largest) == ("joint-missing", {})
    assert found.message.endswith("other joints: 4 degrees of freedom instead of 3")
    mbs.joints()["shoulder"].name = "elbow"
    (found,), largest = compare_dynamics(TINY.encode(), mbs, joints)
    assert found.message.endswith("other joints: shoulder")
