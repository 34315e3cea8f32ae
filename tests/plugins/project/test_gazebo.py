"""Sensors and joints inside <gazebo> stand where SDF says, or are left out with their line."""

from typing import Any

import numpy as np
import pytest

from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.testing import convert_text
from urdf2mbs.urdf.model import Dynamics, Robot
from urdf2mbs.urdf.reader import parse

INERTIAL = (
    '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    "</inertial>"
)
#: Two arms on a base, all joints turned and shifted, and a tool at the end of the first.
ARMS = f"""<robot name="arms">
<link name="base">{INERTIAL}</link>
<link name="left">{INERTIAL}</link>
<link name="tool">{INERTIAL}</link>
<link name="right">{INERTIAL}</link>
<joint name="shoulder" type="floating">
  <parent link="base"/><child link="left"/><origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 0.6"/>
</joint>
<joint name="mount" type="fixed">
  <parent link="left"/><child link="tool"/><origin xyz="0.3 0.1 -0.2" rpy="-1.1 0.2 0.9"/>
</joint>
<joint name="hip" type="continuous">
  <parent link="base"/><child link="right"/><origin xyz="-0.4 0.1 0" rpy="0.3 0.7 -2"/>
  <axis xyz="0 0.6 0.8"/>
</joint>
"""
EXTEND = Plugins(installed=False).hook.urdf2mbs_extension
XYZ = "0.01 0.02 0.03"
RPY = (0.4, 0.5, 0.6)


def read(more: str) -> tuple[Robot, list[Any]]:
    return parse(f"{ARMS}{more}</robot>".encode(), "arms.urdf", extend=EXTEND)


def imu(pose: str, name: str = "imu", link: str = "tool") -> str:
    return f'<gazebo reference="{link}"><sensor name="{name}" type="imu">\n{pose}</sensor></gazebo>'


def ball(inside: str, kind: str = "ball") -> str:
    return (
        f'<gazebo><joint name="pin" type="{kind}"><parent>tool</parent><child>right</child>\n'
        f"{inside}</joint></gazebo>"
    )


def matrix(pose: Any) -> Any:
    out = np.eye(4)
    out[:3, 3], out[:3, :3] = pose.xyz, np.reshape(pose.rot, (3, 3))
    return out


def frames() -> Any:
    """Where each link is in the base, all joints at zero, as Pinocchio has it."""
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(f"{ARMS}</robot>")
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    return {
        frame.name: place.homogeneous for frame, place in zip(model.frames, data.oMf, strict=True)
    }


def rpy(*angles: float) -> Any:
    pin = pytest.importorskip("pinocchio")
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = pin.rpy.rpyToMatrix(*angles), (0.01, 0.02, 0.03)
    return out


RADIANS = " ".join(map(repr, RPY))


@pytest.mark.parametrize("seen_from", ["", "tool", "left", "right", "hip", "mount", "__model__"])
@pytest.mark.parametrize("word", ["relative_to", "frame"])
def test_a_pose_is_read_as_sdf_has_it(seen_from: str, word: str) -> None:
    relative = f' {word}="{seen_from}"' if seen_from else ""
    robot, said = read(imu(f"<pose{relative}> {XYZ} <!-- m --> {RADIANS}\n</pose>"))
    assert not said
    (sensor,) = robot.extensions[0].sensors
    place = frames()
    link = {"hip": "right", "mount": "tool", "__model__": "base", "": "tool"}.get(
        seen_from, seen_from
    )
    wanted = np.linalg.inv(place["tool"]) @ place[link] @ rpy(*RPY)
    assert np.allclose(matrix(sensor.pose), wanted, rtol=0, atol=1e-12)


def test_a_pose_may_be_left_out_or_empty() -> None:
    robot, said = read(
        imu("") + imu("<pose/>", "two") + imu("<pose relative_to='right'/>", "three")
    )
    assert not said
    poses = [matrix(sensor.pose) for e in robot.extensions for sensor in e.sensors]
    assert np.array_equal(poses[:2], [np.eye(4)] * 2)
    place = frames()
    wanted = np.linalg.inv(place["tool"]) @ place["right"]
    assert np.allclose(poses[2], wanted, rtol=0, atol=1e-12)


BAD = [
    ("<pose>1 2 3 4 5</pose>", "6 numbers wanted, 5 given"),
    ("<pose>1 2 3 4 5 6 7</pose>", "6 numbers wanted, 7 given"),
    ("<pose>0,2 0 0 0 0 0</pose>", "'0,2' is not a number"),
    ("<pose>nan 0 0 0 0 0</pose>", "numbers must be finite"),
    ("<pose>0 0 0 0 0 1e999</pose>", "numbers must be finite"),
    ("<pose>0 0 0 0 0 90deg</pose>", "'90deg' is not a number"),
    ('<pose degrees="true">0 0 0 0 0 0</pose>', "in degrees or with a quaternion"),
    ('<pose rotation_format="quat_xyzw">0 0 0 0 0 0 1</pose>', "in degrees or with a quaternion"),
    ('<pose relative_to="rihgt">0 0 0 0 0 0</pose>', "frame 'rihgt', which does not exist"),
]  # fmt: skip


@pytest.mark.parametrize(("pose", "why"), BAD)
def test_what_cannot_be_read_is_left_out_with_its_line(pose: str, why: str) -> None:
    line = ARMS.count("\n") + 1
    for text, code, who in (
        (imu(pose), "sensor-left-out", "sensor 'imu'"),
        (ball(pose), "loop-left-out", "joint 'pin'"),
    ):
        robot, (told,) = read(text)
        assert not robot.extensions[0].sensors
        assert not robot.extensions[0].joints
        assert (told.code, told.level) == (code, "warning")
        assert told.message.endswith(f": {who}")
        assert why in told.message
        assert told.line in (line, line + 1)


@pytest.mark.parametrize(
    ("inside", "why"),
    [
        ("<axis><xyz>0 0 x</xyz></axis>", "'x' is not a number"),
        ("<axis><xyz>0 0 0</xyz></axis>", "<axis> is zero"),
        ('<axis><xyz expressed_in="lfet">0 0 1</xyz></axis>', "did you mean 'left'"),
        (
            "<axis><xyz>0 0 1</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>",
            "use_parent_model_frame> is not read",
        ),
    ],
)
def test_an_axis_that_cannot_be_read(inside: str, why: str) -> None:
    robot, (told,) = read(ball(inside, "revolute"))
    assert not robot.extensions[0].joints
    assert why in told.message + (told.hint or "")


def test_links_that_are_not_there() -> None:
    _, said = read(
        imu("", link="tol")
        + '<sensor name="lost" type="imu"/>'
        + '<sensor name="ft" type="force_torque"><parent joint="muont"/></sensor>'
        + ball("").replace("<parent>tool", "<parent>world")
        + ball("").replace("<child>right", "<child>rihgt")
        + ball("").replace("<child>right", "<child>rod")
        + ball("").replace("<child>right", "<child>rod").replace('"pin"', '"bolt"')
        + '<gazebo><link name="rod"/></gazebo>'
        + '<transmission><joint name="sholder"/></transmission>'
        + '<transmission><joint name="xyz"/></transmission>'
    )
    told = [f"{one.code}: {one.message} {one.hint or ''}" for one in said]
    assert told == [
        "sensor-left-out: a sensor is left out: it is on link 'tol', which does not exist: sensor "
        "'imu' did you mean 'tool'?",
        "sensor-left-out: a sensor is left out: it names no link: sensor 'lost' ",
        "sensor-left-out: a sensor is left out: it is on joint 'muont', which does not exist: "
        "sensor 'ft' did you mean 'mount'?",
        "loop-left-out: a joint in <gazebo> is left out: it is on link 'world', which does not "
        "exist: joint 'pin' 'base: fixed' ties the root link to the world",
        "loop-left-out: a joint in <gazebo> is left out: it is on link 'rihgt', which does not "
        "exist: joint 'pin' did you mean 'right'?",
        "loop-left-out: a joint in <gazebo> is left out: it is on a link inside <gazebo>; no such "
        "link is read, nor its mass: joint 'pin', joint 'bolt' ",
        "mechanics-unread: <link> in <gazebo> is not read, and has no effect ",
        "actuator-unknown: a <transmission> drives a joint that does not exist: joint 'sholder' "
        "(did you mean 'shoulder'?), joint 'xyz' ",
    ]


def balls(inside: str, kind: str = "revolute", **options: Any) -> tuple[Any, Any]:
    """The ends of the cuts of a joint, each in the frame of its own link."""
    text = f"{ARMS}{ball(inside, kind)}</robot>"
    result = convert_text(text, base="fixed", passes=options)
    points = {p.name: np.array(p.coordinates) for b in result.mbs.bodies for p in b.points}
    return result, points


@pytest.mark.parametrize(
    ("inside", "frame", "axis"),
    [
        (f"<pose>{XYZ} {RADIANS}</pose>", "joint", (0, 0, 1)),
        (f"<pose>{XYZ} {RADIANS}</pose><axis><xyz>1 2 3</xyz></axis>", "joint", (1, 2, 3)),
        (f"<pose relative_to='left'>{XYZ} {RADIANS}</pose>", "joint", (0, 0, 1)),
        ("<axis><xyz expressed_in='left'>1 2 3</xyz></axis>", "left", (1, 2, 3)),
        ("<axis/>", "joint", (0, 0, 1)),
        (
            "<axis><xyz expressed_in='__model__'>1 2 3</xyz></axis>", "base", (1, 2, 3),
        ),
    ],
)  # fmt: skip
def test_the_balls_of_a_revolute_joint(inside: str, frame: str, axis: Any) -> None:
    place = frames()
    joint = place["left"] if "relative_to" in inside else place["right"]
    joint = joint @ rpy(*RPY) if "<pose" in inside else joint
    along = {**place, "joint": joint}[frame][:3, :3] @ (np.array(axis) / np.linalg.norm(axis))
    _, points = balls(inside)
    for number, away in ((1, 0.0), (2, 0.1)):
        for end, link in ((1, "tool"), (2, "right")):
            at = place[link] @ np.append(points[f"pin_{number}_{end}"], 1.0)
            assert np.allclose(at[:3], joint[:3, 3] + away * along, rtol=0, atol=1e-12)


def test_a_joint_is_placed_where_the_robot_is_at_zero() -> None:
    """SDF's initial position has all joints at zero; the start position changes no mechanism."""
    _, points = balls("<pose>0 0 0.3 0 0 0</pose>", "ball")
    result, moved = balls("<pose>0 0 0.3 0 0 0</pose>", "ball", posture={"joints": {"hip": 0.5}})
    assert {name: list(at) for name, at in points.items()} == {
        name: list(at) for name, at in moved.items()
    }
    assert "loop-open" in {found.code for found in result.diagnostics}


def test_a_universal_joint_keeps_its_axes_at_right_angles() -> None:
    axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    result, points = balls(axes, "universal")
    kinds = {cut.name: (cut.kind, cut.length) for cut in result.mbs.cuts}
    assert kinds["pin_1"] == ("ball", None)
    assert kinds["pin_2"][0] == "rod"
    assert kinds["pin_2"][1] == pytest.approx(0.1 * 2**0.5, rel=1e-14)
    assert np.allclose(points["pin_2_2"], [0, 0.1, 0], rtol=0, atol=1e-15)
    result, _ = balls("<axis><xyz>1 0 0</xyz></axis>", "universal")
    assert not result.mbs.cuts
    assert "two axes" in next(d.message for d in result.diagnostics if d.code == "loop-left-out")


def test_two_joints_of_one_name_make_two_cuts() -> None:
    text = f"{ARMS}{ball('', 'ball')}{ball('<pose>0 0 1 0 0 0</pose>', 'ball')}</robot>"
    result = convert_text(text, base="fixed")
    assert [cut.name for cut in result.mbs.cuts] == ["pin", "pin_2"]
    (told,) = [found for found in result.diagnostics if found.code == "loop-renamed"]
    assert told.line is not None
    assert "is called 'pin_2'" in told.message


def test_two_sensors_of_one_name_are_two() -> None:
    """On two links, or at two places of a link; a sensor that is there twice is one."""
    text = (
        imu("<pose>0 0 1 0 0 0</pose>") + imu("", link="left")
        + imu("<pose>0 0 2 0 0 0</pose>")
        + '<sensor name="imu" type="accelerometer"><parent link="tool"/></sensor>'
        + '<sensor name="imu" type="imu"><parent link="tool"/><origin xyz="0 0 1"/></sensor>'
    )  # fmt: skip
    result = convert_text(f"{ARMS}{text}</robot>", base="fixed")
    sensors = {
        s["name"]: (s["link"], s["point"].coordinates) for s in result.report.passes["sensors"]
    }
    assert sensors == {
        "imu": ("tool", (0.0, 0.0, 1.0)),
        "left_imu": ("left", (0.0, 0.0, 0.0)),
        "tool_imu": ("tool", (0.0, 0.0, 2.0)),
    }
    told = [found for found in result.diagnostics if found.code == "sensor-renamed"]
    assert ["'left_imu'" in told[0].message, "'tool_imu'" in told[1].message] == [True, True]
    assert all(found.line for found in told)


def test_a_sensor_without_a_name_gets_one() -> None:
    text = '<gazebo reference="tool"><sensor type="imu"/></gazebo>'
    robot, (told,) = read(text)
    assert robot.extensions[0].sensors[0].name == "tool_imu"
    assert told.code == "sensor-renamed"


def test_motors_rotors_starts_and_friction() -> None:
    """All that other programs state of joints; what cannot be read is named."""
    start = '<param name="initial_value">{}</param><param name="min">9</param>'
    control = "".join(
        f'<joint name="{joint}"><{kind}_interface name="position">{start.format(value)}'
        f"</{kind}_interface></joint>"
        for joint, kind, value in (("hip", "state", 0.5), ("mount", "command", 1), ("", "state", 2))
    )
    drive = (
        '<transmission><joint name="{}">{}</joint><actuator name="m"><motorInertia>{}'
        "</motorInertia>{}</actuator></transmission>"
    )
    ratio = "<mechanicalReduction>{}</mechanicalReduction>"
    robot, said = read(
        f"<ros2_control>{control}</ros2_control>"
        + drive.format("hip", "", 0.5, "")
        + drive.format("hip", ratio.format(3), 0.5, "")
        + drive.format("hip", ratio.format(3), 0.5, ratio.format(2))
        + drive.format("hip", "", -1, "") + drive.format("", "", 1, "")
        + drive.format("hip", "", "x", "") + drive.format("hip", "", 1, ratio.format("y"))
        + '<gazebo reference="hip"><mu1>0.25</mu1><springStiffness value="2"/><mu1>z</mu1></gazebo>'
        + "<ros2_control>" + control.replace("0.5", "w") + "</ros2_control>"
    )  # fmt: skip
    first, *drives, surface, last = robot.extensions
    assert (first.starts, last.starts) == ({"hip": 0.5}, {})
    assert (first.motors, last.motors) == (["mount"], ["mount"])
    assert [drive.rotors.get("hip") for drive in drives] == [0.5, 4.5, 2.0] + [None] * 4
    assert [drive.motors for drive in drives] == [["hip"]] * 4 + [[]] + [["hip"]] * 2
    assert not any("" in drive.rotors for drive in drives)
    assert surface.numbers == {"mu1": 0.25, "springStiffness": 2.0}
    assert [one.code for one in said] == ["number-negative"] + ["number-left-out"] * 3


def test_a_spring_of_a_joint() -> None:
    """The rest of the joint's dynamics stays; a joint has one spring, the last that is stated."""
    spring = '<gazebo reference="hip"><springReference>{}</springReference></gazebo>'
    stiff = '<gazebo reference="{}"><springStiffness>2</springStiffness></gazebo>'
    robot, said = read("".join(map(stiff.format, ("hip", "left", "none"))) + spring.format(-0.5))
    assert robot.joints["hip"].dynamics == Dynamics(0.0, 0.0, 2.0, -0.5)
    assert [joint.dynamics for joint in robot.joints.values()].count(None) == 2
    (told,) = said
    assert told.message.endswith("the joint has no spring here: joint 'left', joint 'none'")
    damped = ARMS.replace('<axis xyz="0 0.6 0.8"/>', '<dynamics damping="3"/>')
    robot = parse(f"{damped}{spring.format(1)}</robot>".encode(), "arms.urdf", extend=EXTEND)[0]
    assert robot.joints["hip"].dynamics == Dynamics(3.0, 0.0, 0.0, 1.0)


def test_friction_in_a_link_is_of_the_link() -> None:
    bullet = '<contact><lateral_friction value="{}"/></contact>'
    eye = '<link name="eye">' + "".join(map(bullet.format, (0.5, "x"))) + "</link>"
    joint = '<joint name="see" type="fixed"><parent link="tool"/><child link="eye"/></joint>'
    robot, said = read(eye + joint)
    assert [(e.tag, e.reference, e.numbers) for e in robot.extensions] == [
        ("contact", "eye", {"mu1": 0.5}), ("contact", "eye", {}),
    ]  # fmt: skip
    assert [one.code for one in said] == ["number-left-out"]


def test_mechanics_without_effect_are_named() -> None:
    """A link without mass has no weight that gravity could have."""
    gazebo = (
        '<gazebo reference="{}"><turnGravityOff>true</turnGravityOff>'
        "<springStiffness>{}</springStiffness></gazebo>"
    )
    joint = '<joint name="see" type="fixed"><parent link="tool"/><child link="eye"/></joint>'
    eye = f'<link name="eye"/>{joint}'
    places = gazebo.format("tool", 0.0) + gazebo.format("eye", "x") + gazebo.format("see", 40)
    _, said = read(eye + places)
    told = [one.message for one in said if one.code == "mechanics-unread"]
    assert told == [
        "<turnGravityOff> of <gazebo> has no effect, as the link has its weight here: link 'tool'",
        "<springStiffness> of <gazebo> has no effect, as the joint has no spring here: joint 'see'",
    ]
    assert [one.code for one in said].count("number-left-out") == 1
