"""`init`: the config it writes for any robot says what was found, and runs as it is."""

import re
from pathlib import Path
from typing import Any

import msgspec
import pytest
import yaml

from support.build import SOLID, joint, link, robot
from support.folders import ROOT
from support.real_robots import BROKEN, CONVERTIBLE, REAL_ROBOTS, RealRobot
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.config.load import load
from urdf2mbs.config.model import Project
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY
from urdf2mbs_project.commands.init import describe_facts, init

ENTRY = [robot for robot in CONVERTIBLE if robot.values[0] is None or robot.values[0].listed]


def started(robot: RealRobot, folder: Path) -> tuple[str, Path]:
    config = folder / "robot.yaml"
    packages = {name: str(path) for name, path in robot.packages.items()}
    written = init(str(robot.source), config, packages=packages, xacro_args=robot.args)
    return describe_facts(*written), config


@pytest.mark.slow
@pytest.mark.parametrize("robot", ENTRY)
def test_every_real_robot(robot: RealRobot, tmp_path: Path) -> None:
    """The config runs, is short, and finds the same packages and arguments without being told."""
    message, config = started(robot, tmp_path)
    text = config.read_text()
    assert len(text.splitlines()) < 60
    conversion = Pipeline(*load(config)).run()
    assert conversion.checked.proof is not None
    assert conversion.checked.proof.same
    assert f"{len(conversion.robot.links) - bool(conversion.base.inserted)} link" in message
    # uncommented, it is still a config
    bare = re.sub(r"^# (?=passes:|xacro_args:|packages:|  \S+: )", "", text, flags=re.M)
    assert set(yaml.safe_load(bare)) >= set(yaml.safe_load(text))


def _as_a_file(config: Path) -> Any:
    """Return the config with one file as output: meshes take long, and have other tests."""
    parsed, lines = load(config)
    return msgspec.structs.replace(parsed, output="robot.mbs"), lines


@pytest.mark.parametrize("robot", BROKEN)
def test_what_cannot_be_converted_gets_no_config(robot: RealRobot, tmp_path: Path) -> None:
    with pytest.raises(ConversionError):
        started(robot, tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("end", "feet"),
    [
        ("atlas_v5.urdf.xacro", ["l_foot", "r_foot"]),
        (
            "naoV50_generated_urdf/nao.urdf",
            [f"{side}Fsr{corner}_frame" for side in "LR" for corner in ("FL", "FR", "RL", "RR")],
        ),
        ("robotran_edu_2017/bigman.urdf", ["LFoot", "RFoot"]),
        ("iCubGazeboV2_5/model.urdf", ["l_foot", "r_foot"]),
        ("cassie_v4.urdf", ["leftfoot", "rightfoot"]),  # its meshes are not there, nor the next's
        ("solo12.urdf.xacro", ["FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"]),
        ("leo_sim.urdf.xacro", []),  # it has wheels
        ("fr3.urdf.xacro", []),  # it is fixed
    ],
)
def test_feet_of_real_robots(end: str, feet: list[str], tmp_path: Path) -> None:
    robot = next((r for r in REAL_ROBOTS if r.listed and r.source.as_posix().endswith(end)), None)
    if robot is None:
        pytest.skip("the real robots are not beside the checkout")
    message, config = started(robot, tmp_path)
    contacts = yaml.safe_load(config.read_text()).get("passes", {}).get("contacts", {})
    assert contacts.get("links", []) == ["*"] * (not end.startswith("fr3"))
    told = [line[8:].split(", ") for line in message.splitlines() if line.startswith("  feet: ")]
    assert sorted(told[0] if told else []) == feet


def test_the_biped_word_for_word(here: Path, capsys: Any) -> None:
    (here / "biped.urdf.xacro").write_text((ROOT / "configs" / "biped.urdf.xacro").read_text())
    assert main(["init", "biped.urdf.xacro", "--arg", "height:=0.9"]) == 0
    assert capsys.readouterr().out.endswith(
        "\n\nNext: urdf2mbs run biped.yaml; then: urdf2mbs simulate biped.yaml -o moves.html\n"
    )
    assert (
        (here / "biped.yaml").read_text()
        == """\
# biped: 21 links, 16 moving joints, 12.96 kg. Paths are relative to this file.
#   urdf2mbs run biped.yaml       convert it
#   urdf2mbs report biped.yaml    look at it
source: biped.urdf.xacro
output: {project: biped, language: both}  # a whole Robotran project; or only the file: biped.mbs
base: floating                            # nothing ties the root to 'world'; or fixed
pipeline: compact                         # the fewest joints; or faithful: a body for every link

xacro_args:
  height: 0.9
#   mass: 12.0
#   arms: true

passes:
  posture:
    hold: {frequency: 10, damping_ratio: 0.3}   # Hz; a controller holds the start position
  contacts: {links: ['*']}   # the ground; all that is solid touches
  equations: {language: project}   # of motion, which Robotran's programs need
"""
    )
    assert main(["run", "biped.yaml"]) == 0
    for suffix in ("py", "c"):
        assert (here / "biped" / "symbolicR" / f"mbs_dirdyna_biped.{suffix}").is_file()
    assert "Next: urdf2mbs simulate biped" in (output := capsys.readouterr().out)
    assert "urdf2mbs equations" not in output
    cmake = "cmake -S biped/workR -B biped/workR/build -DROBOTRAN_SOURCE_DIR=.../MBsysC"
    assert f"in C: {cmake} && cmake --build biped/workR/build\n" in output


LIMITED = """<robot name="arm"><link name="world"/><link name="a"><visual><geometry>
<box size="1 1 1"/></geometry></visual>MASS</link><joint name="j: 1" type="revolute">
<parent link="world"/><child link="a"/><limit lower="0.5" upper="1.5"/></joint></robot>"""


def part(
    name: str, parent: str, xyz: str, kind: str = "revolute", shape: str = '<box size=".2 .2 .2"/>'
) -> str:
    """Return a link with a mass and a shape, and the joint to it."""
    solid = link(name, SOLID, f"<collision><geometry>{shape}</geometry></collision>")
    return solid + joint(parent, name, kind, xyz=xyz, axis="1 0 0") * bool(parent)


TRUNK = part("trunk", "", "")
LEGS = part("l", "trunk", "0 1 -1") + part("r", "trunk", "0 -1 -1")
GONE = '<mesh filename="gone.stl"/>'


@pytest.mark.parametrize(
    ("parts", "feet"),
    [
        (LEGS, ["l", "r"]),
        (LEGS + part("tablet", "trunk", "1 0 -0.9"), ["l", "r"]),  # does not reach the ground
        (LEGS + part("toe", "l", "0 1 0"), ["toe"]),  # what is called so, first
        (LEGS + part("mast", "trunk", "0 0 -1", "fixed"), []),  # the root stands, too
        (part("l", "trunk", "0 1 -1", "continuous") + part("r", "trunk", "0 -1 -1"), []),  # a wheel
        (part("l", "trunk", "0 1 1") + part("r", "trunk", "0 -1 1"), []),  # fingers of a palm
        ("", []),  # no joint to hold
        (LEGS + part("claw", "l", "0 0 -1", shape=GONE), []),  # the lowest shape is not there
        # visual shapes touch the ground; a box replaces the missing shape
        (LEGS.replace("collision", "visual") + part("sole", "l", "0 0 1", "fixed", GONE), ["sole"]),
        # a leg starts in the middle of its limits, and not at zero
        (
            LEGS.replace("0 1 -1", "0 1 0").replace(
                'lower="-1" upper="1"', 'lower="1" upper="2"', 1
            )
            + part("end", "l", "0 0 -1.5", "fixed"),
            ["r"],
        ),
    ],
)
def test_feet_touch_the_ground_in_the_start_pose(parts: str, feet: list[str], here: Path) -> None:
    (here / "r.urdf").write_text(robot(TRUNK, parts))
    assert sorted(init("r.urdf", base="floating")[1].feet) == feet
    lost = "claw" in parts  # what reaches the ground is not known
    assert ("contacts" in Pipeline(*load(here / "r.yaml")).run().report) != lost


def test_the_start_position_is_within_the_limits(here: Path) -> None:
    (here / "arm.urdf").write_text(LIMITED.replace("MASS", SOLID))
    assert main(["init", "arm.urdf"]) == 0
    written = yaml.safe_load((here / "arm.yaml").read_text())
    assert written["passes"] == {
        "posture": {"joints": {"j: 1": 1.0}},
        "equations": {"language": "project"},
    }
    conversion = Pipeline(*_as_a_file(here / "arm.yaml")).run()
    assert "posture-limit" not in [diagnostic.code for diagnostic in conversion.diagnostics]


def test_the_inertia_of_motors_is_offered(here: Path) -> None:
    motor = "<mechanicalReduction>50</mechanicalReduction><motorInertia>1e-4</motorInertia>"
    transmission = f'<transmission name="t"><joint name="shoulder"/><actuator name="m">{motor}'
    text = TINY.replace("</robot>", f"{transmission}</actuator></transmission></robot>")
    (here / "motor.urdf").write_text(text)
    config = here / "motor.yaml"
    init("motor.urdf", config)
    offered = config.read_text()
    assert "#   rotors: {from_urdf: true}" in offered
    offered = offered.replace("# passes", "passes").replace("#   rotors", "  rotors")
    config.write_text(offered)
    conversion = Pipeline(*load(config)).run()
    assert conversion.report["rotors"] == {"shoulder": 0.25}


def test_a_robot_without_mass_is_offered_an_estimate(here: Path, capsys: Any) -> None:
    text = LIMITED.replace("MASS", "").replace('lower="0.5"', 'lower="-0.5"')
    (here / "arm.urdf").write_text(text)
    assert main(["init", "arm.urdf"]) == 0
    offered = (here / "arm.yaml").read_text()
    assert "estimate-inertia" in offered
    assert yaml.safe_load(offered)["passes"].keys() == {"equations"}
    offered = offered.replace("# passes", "passes").replace("#   estimate", "  estimate")
    (here / "arm.yaml").write_text(offered)
    conversion = Pipeline(*_as_a_file(here / "arm.yaml")).run()
    assert sum(body.mass or 0.0 for body in conversion.mbs.bodies) == pytest.approx(10.0)
    # nothing to estimate a mass from
    (here / "bare.urdf").write_text(re.sub("<visual>.*</visual>", "", text, flags=re.S))
    assert main(["init", "bare.urdf"]) == 0
    assert "no link has a mass, nor a shape" in (here / "bare.yaml").read_text()
    assert "no link has a mass, and nothing moves: see the end of bare" in capsys.readouterr().out
    bare = convert(here / "bare.urdf", passes={"estimate-inertia": {"total_mass": 1.0}})
    assert "nothing-estimated" in [diagnostic.code for diagnostic in bare.diagnostics]


XACRO = """<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <!-- how many there are -->
  <xacro:arg name="before" default="3"/>
  <xacro:arg name="beside" default="$(find us)/x: #y"/>   <!-- a file -->
  <xacro:arg name="plain" default="a: b # c"/>

  <!-- A section of the file. -->
  <link name="$(arg needed)"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://us/a.stl"/></geometry></visual>
    <visual><geometry><mesh filename="package://them/b.stl"/></geometry></visual></link>
</robot>"""


def test_arguments_packages_and_meshes(here: Path, capsys: Any) -> None:
    (here / "us").mkdir()
    (here / "us" / "package.xml").write_text("<package><name>us</name></package>")
    (here / "us" / "a.stl").write_text("")
    (here / "us" / "x.urdf.xacro").write_text(XACRO)
    assert main(["init", "us/x.urdf.xacro"]) == 1
    assert "the argument 'needed' is not defined" in capsys.readouterr().err
    assert main(["init", "us/x.urdf.xacro", "--arg", "needed:=yes: no"]) == 0
    assert "1 of 2 meshes found\n  not found: package://them/b.stl\n" in capsys.readouterr().out
    text = (here / "x.yaml").read_text()
    assert "\npackages:\n  us: us\n#   them: DIR   # meshes name it, and it was not found\n" in text
    assert (
        """
xacro_args:
  needed: 'yes: no'
#   before: 3
#   beside: VALUE
#   plain: 'a: b # c'
"""
        in text
    )
    assert load(here / "x.yaml")[0].xacro_args == {"needed": "yes: no"}


def test_it_overwrites_nothing(here: Path, capsys: Any) -> None:
    (here / "tiny.yaml").write_text("mine")
    assert main(["init", "tiny.urdf"]) == 2
    assert "error[output-not-ours]" in capsys.readouterr().err
    assert (here / "tiny.yaml").read_text() == "mine"
    assert main(["init", "tiny.urdf", "-o", "other.txt"]) == 2
    assert "error[config-name]" in capsys.readouterr().err


def test_files_have_the_name_of_the_robot(here: Path, capsys: Any) -> None:
    """A file is often called robot.urdf; two robots of one name do not share a config."""
    (here / "a" / "x").mkdir(parents=True)
    text = (here / "tiny.urdf").read_text().replace('name="tiny"', 'name="a"')
    (here / "a" / "x" / "robot.urdf").write_text(text)
    (here / "lab.urdf").write_text(text)
    for _ in range(2):
        assert main(["init", "a/x/robot.urdf"]) == 0
        assert "wrote a.yaml" in capsys.readouterr().out
    # the folder a/ has the robot
    assert load(here / "a.yaml")[0].output == Project("a_robotran", "both")
    assert main(["init", "lab.urdf"]) == 0
    assert "wrote lab.yaml" in capsys.readouterr().out
    assert load(here / "a.yaml")[0].source == "a/x/robot.urdf"
    (here / "a.yaml").write_text("[")
    assert main(["init", "a/x/robot.urdf"]) == 2
    assert "error[output-not-ours]: 'a.yaml'" in capsys.readouterr().err
