"""Where a robot stands: what its feet are, and that bent knees bring the feet under the hips."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from support.build import SOLID, link, robot
from urdf2mbs.cli import main
from urdf2mbs.config.load import load
from urdf2mbs.conversion import Conversion
from urdf2mbs.disk.files import model_of
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs.kinematics import compute_placement
from urdf2mbs_project.commands.init import init
from urdf2mbs_project.feet import is_foot_name
from urdf2mbs_project.simulation import Simulation
from urdf2mbs_simulate.runtime import MbsData

EVEN = SOLID.replace("0.1 -0.2 0.3", "0 0 0")


def part(
    name: str, parent: str, origin: str, shape: str, limits: str = "-3 3", axis: str = "0 1 0"
) -> str:
    """Return a link, and the joint to it, which is fixed without limits."""
    solid = link(name, EVEN, f"<collision><geometry>{shape}</geometry></collision>")
    low, _, high = limits.partition(" ")
    kind = "revolute" if limits else "fixed"
    return f"""{solid}<joint name="{name}_joint" type="{kind}"><parent link="{parent}"/>
      <child link="{name}"/><origin xyz="{origin}"/><axis xyz="{axis}"/>
      <limit lower="{low or 0}" upper="{high or 0}" effort="99" velocity="9"/></joint>"""


GONE = '<mesh filename="gone.stl"/>'
BALL, ROD, SOLE = '<sphere radius="0.02"/>', '<box size=".02 .02 .1"/>', '<box size=".2 .1 .02"/>'
TRUNK = link("trunk", EVEN, '<collision><geometry><box size=".6 .2 .1"/></geometry></collision>')


def leg(x: float, y: float, sign: int, foot: str = "foot") -> str:
    name = f"{'FH'[x < 0]}{'LR'[y < 0]}_"
    knee = "0.5 2" if sign > 0 else "-2 -0.5"
    return (
        part(f"{name}hip", "trunk", f"{x} {y} 0", ROD, axis="1 0 0")
        + part(f"{name}thigh", f"{name}hip", f"0 {y / 2} 0", ROD)
        + part(f"{name}calf", f"{name}thigh", "0 0 -0.3", ROD, knee)
        + part(f"{name}{foot}", f"{name}calf", "0 0 -0.2", BALL, "")
    )


DOG = robot(TRUNK, *(leg(x, y, 1 if x < 0 else -1) for x in (-0.2, 0.2) for y in (-0.1, 0.1)))
"""Its knees point forward behind, and backward in front, as those of HyQ do."""


def started(text: str, folder: Path) -> Conversion:
    """Run the config that ``init`` writes."""
    (folder / "r.urdf").write_text(text)
    init("r.urdf")
    return Pipeline(*load(folder / "r.yaml")).run()


def test_hips_bend_until_the_feet_are_under_them(here: Path) -> None:
    conversion = started(DOG, here)
    assert "contacts-balance" not in [diagnostic.code for diagnostic in conversion.diagnostics]
    placement, parts = compute_placement(conversion.mbs), conversion.parts()
    joints = {joint.joint.name: joint for joint in placement.joints}
    for end, sign in (("FL", -1), ("FR", -1), ("HL", 1), ("HR", 1)):
        segment, pose = parts[f"{end}_foot"]
        bodies = placement.bodies[segment.body.name]
        foot = np.array(bodies.xyz) + np.reshape(bodies.rot, (3, 3)) @ pose.xyz
        hip = np.array(joints[f"{end}_thigh_joint"].origin)
        assert foot - hip == pytest.approx([0.0, 0.0, foot[2] - hip[2]], abs=2e-3)
        assert foot[2] - hip[2] == pytest.approx(-0.4097, abs=1e-3)  # 0.3 m, 0.2 m, 1.25 rad
        assert joints[f"{end}_calf_joint"].joint.q == pytest.approx(1.25 * sign)
        assert joints[f"{end}_hip_joint"].joint.q in (None, 0.0)


def test_an_ankle_keeps_the_sole_level(here: Path) -> None:
    legs = [
        part(f"{side}_thigh", "trunk", f"0 {y} 0", ROD)
        + part(f"{side}_shin", f"{side}_thigh", "0 0 -0.3", ROD, "0.3 1.3")
        + part(f"{side}_ankle", f"{side}_shin", "0 0 -0.3", SOLE)
        for side, y in (("l", 0.1), ("r", -0.1))
    ]
    conversion = started(robot(TRUNK, *legs), here)
    assert {body for body, _ in conversion.state(Simulation).stance} == {"l_ankle", "r_ankle"}
    placement = compute_placement(conversion.mbs)
    assert placement.bodies["l_ankle"].rot == pytest.approx((1, 0, 0, 0, 1, 0, 0, 0, 1), abs=2e-3)
    thigh = next(placed for placed in placement.joints if placed.joint.name == "r_thigh_joint")
    assert placement.bodies["r_ankle"].xyz[0] == pytest.approx(thigh.origin[0], abs=2e-3)


def test_a_box_with_its_inertia_replaces_a_foot_whose_mesh_is_lost(here: Path) -> None:
    """The inertia of a uniform box gives its corners back, wherever its axes are; a mere frame is a
    point."""
    size = np.array([0.2, 0.1, 0.04])
    principal = 3.0 / 12.0 * np.diag(size @ size - size**2)
    turn = Rotation.from_euler("z", 0.3)
    inertia = turn.as_matrix() @ principal @ turn.as_matrix().T
    values = " ".join(
        f'i{"xyz"[i]}{"xyz"[j]}="{inertia[i, j]}"' for i in range(3) for j in range(i, 3)
    )
    solid = (
        f'<inertial><origin xyz="0.01 0.02 -0.03"/><mass value="3"/><inertia {values}/></inertial>'
    )
    feet = [
        part(f"{side}_foot", "trunk", f"0 {y} -0.5", GONE) for side, y in (("l", 0.2), ("r", -0.2))
    ]
    left = feet[0].replace(EVEN, solid)
    sole = (
        link("r_sole")
        + '<joint name="j" type="fixed"><parent link="r_leg"/><child link="r_sole"/></joint>'
    )
    conversion = started(robot(TRUNK, left, feet[1].replace("r_foot", "r_leg"), sole), here)
    points = yaml.safe_load((here / "r.yaml").read_text())["passes"]["contacts"]["points"]
    corners = [(a, b, -0.02) for a in (-0.1, 0.1) for b in (-0.05, 0.05)]
    wanted = np.add(turn.apply(corners), (0.01, 0.02, -0.03))
    assert sorted(points["l_foot"]) == [
        pytest.approx(corner, abs=1e-4) for corner in sorted(wanted.tolist())
    ]
    assert points["r_sole"] == [[0.0, 0.0, 0.0]]
    assert conversion.report["contacts"]


@pytest.mark.parametrize(
    ("moments", "n_points"),
    [
        ("0 0 0", 1),
        ("0 0.01 0.01", 2),
        ("0.01 0.01 0", 1),
        ("0.01 0.01 0.02", 4),
        ("0.02 0.01 0.01", 2),
    ],
)
def test_a_foot_of_a_point_a_bar_or_a_sheet_has_no_point_twice(
    moments: str, n_points: int, here: Path
) -> None:
    xx, yy, zz = moments.split()
    inertia = f'ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"'
    solid = f'<inertial><origin xyz="-0.041 0 0"/><mass value="1"/><inertia {inertia}/></inertial>'
    feet = [
        part(f"{side}_foot", "trunk", f"0 {y} -0.5", GONE).replace(EVEN, solid)
        for side, y in (("l", 0.2), ("r", -0.2))
    ]
    conversion = started(robot(TRUNK, *feet), here)
    points = yaml.safe_load((here / "r.yaml").read_text())["passes"]["contacts"]["points"]
    assert [len(points[foot]) for foot in ("l_foot", "r_foot")] == [n_points] * 2
    assert [c["spots"] for c in conversion.report["contacts"]][1:] == [n_points] * 2


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (
            robot(TRUNK, part("l", "trunk", "0 1 -1", GONE), part("r", "trunk", "0 -1 -1", GONE)),
            "no shape was found of 'l'",
        ),
        (
            DOG.replace("_foot", "_end").replace(
                ' name="HL_calf_joint" type="revolute"', ' name="HL_calf_joint" type="continuous"'
            ),
            "'HL_end' is a wheel; all that is solid touches the ground",
        ),
        (
            robot(TRUNK, part("l", "trunk", "0 1 1", BALL), part("r", "trunk", "0 -1 1", BALL)),
            "'trunk' reaches the ground, and is not the end of a limb; all that is solid touches "
            "the ground",
        ),
    ],
)
def test_it_says_why_there_are_no_feet(
    text: str, why: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "r.urdf").write_text(text)
    assert main(["init", "r.urdf", "--base", "floating"]) == 0
    assert f"\n  no feet: {why}\n" in capsys.readouterr().out
    passes = yaml.safe_load((here / "r.yaml").read_text()).get("passes", {})
    assert passes.get("contacts") == ({"links": ["*"]} if "solid" in why else None)


@pytest.mark.slow
def test_simulate_starts_as_init_proposes(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    conversion = started(DOG, here)
    assert main(["simulate", "r.urdf", "--time", "0.01", "--language", "python"]) == 0
    assert "the robot stands on HR_foot, HL_foot, FR_foot, FL_foot" in capsys.readouterr().out
    data = MbsData(model_of(Path("r_robotran")) or "")
    for joint in conversion.mbs.joints().values():
        assert data.q0[data.joint_id[joint.name]] == pytest.approx(joint.q or 0.0, abs=1e-12)
    assert set(data.user_model["hold_stiffness"]) >= {"FL_calf_joint", "HR_hip_joint"}


def test_a_toe_is_a_foot_however_it_is_written() -> None:
    """Toes of human-gazebo are called so; theirs were not, and an upper arm was a foot."""
    assert all(map(is_foot_name, ["RightToe", "l_toe", "TOE_1", "leftSole", "LeftFoot", "FL_foot"]))
    assert not any(map(is_foot_name, ["mistletoe", "console", "RightToes", "Thigh"]))
