"""Sensors and joints inside <gazebo> stand where SDF says, or are left out with their line."""

from typing import Any

import numpy as np
import pytest

from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.testing import convert_text
from urdf2mbs.urdf.model import Dynamics, Mimic, Robot
from urdf2mbs.urdf.reader import parse_urdf

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
    return parse_urdf(f"{ARMS}{more}</robot>".encode(), "arms.urdf", extend=EXTEND)


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
    robot, diagnostics = read(imu(f"<pose{relative}> {XYZ} <!-- m --> {RADIANS}\n</pose>"))
    assert not diagnostics
    (sensor,) = robot.extensions[0].sensors
    place = frames()
    link = {"hip": "right", "mount": "tool", "__model__": "base", "": "tool"}.get(
        seen_from, seen_from
    )
    wanted = np.linalg.inv(place["tool"]) @ place[link] @ rpy(*RPY)
    assert np.allclose(matrix(sensor.pose), wanted, rtol=0, atol=1e-12)


def test_a_pose_may_be_left_out_or_empty() -> None:
    robot, diagnostics = read(
        imu("") + imu("<pose/>", "two") + imu("<pose relative_to='right'/>", "three")
    )
    assert not diagnostics
    poses = [matrix(sensor.pose) for e in robot.extensions for sensor in e.sensors]
    assert np.array_equal(poses[:2], [np.eye(4)] * 2)
    place = frames()
    wanted = np.linalg.inv(place["tool"]) @ place["right"]
    assert np.allclose(poses[2], wanted, rtol=0, atol=1e-12)


BAD = [
    ("<pose>1 2 3 4 5</pose>", "expected 6 numbers, got 5"),
    ("<pose>1 2 3 4 5 6 7</pose>", "expected 6 numbers, got 7"),
    ("<pose>0,2 0 0 0 0 0</pose>", "'0,2' is not a number"),
    ("<pose>nan 0 0 0 0 0</pose>", "numbers must be finite"),
    ("<pose>0 0 0 0 0 1e999</pose>", "numbers must be finite"),
    ("<pose>0 0 0 0 0 90deg</pose>", "'90deg' is not a number"),
    ('<pose degrees="true">0 0 0 0 0 0</pose>', "in degrees or with a quaternion"),
    ('<pose rotation_format="quat_xyzw">0 0 0 0 0 0 1</pose>', "in degrees or with a quaternion"),
    ('<pose relative_to="rihgt">0 0 0 0 0 0</pose>', "frame 'rihgt', which does not exist"),
]


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
    _, diagnostics = read(
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
    told = [
        f"{diagnostic.code}: {diagnostic.message} {diagnostic.hint or ''}"
        for diagnostic in diagnostics
    ]
    assert told == [
        "sensor-left-out: a sensor is left out: it is on link 'tol', which does not exist: sensor "
        "'imu' did you mean 'tool'?",
        "sensor-left-out: a sensor is left out: it names no link: sensor 'lost' ",
        "sensor-left-out: a sensor is left out: it is on joint 'muont', which does not exist: "
        "sensor 'ft' did you mean 'mount'?",
        "loop-left-out: a joint in <gazebo> is left out: it is on link 'world', which does not "
        "exist: joint 'pin' only a fixed joint of the root link to the world is read",
        "loop-left-out: a joint in <gazebo> is left out: it is on link 'rihgt', which does not "
        "exist: joint 'pin' did you mean 'right'?",
        "loop-left-out: a joint in <gazebo> is left out: it is on a link inside <gazebo>; no such "
        "link is read, nor its mass: joint 'pin', joint 'bolt' ",
        "mechanics-unread: <link> in <gazebo> is not read, and has no effect ",
        "actuator-unknown: a <transmission> drives a joint that does not exist: joint 'sholder' "
        "(did you mean 'shoulder'?), joint 'xyz' ",
    ]


def balls(inside: str, kind: str = "revolute", **options: Any) -> tuple[Any, Any]:
    """Return the ends of the cuts of a joint, each in the frame of its link."""
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
            "<axis><xyz expressed_in='__model__'>1 2 3</xyz></axis>",
            "base",
            (1, 2, 3),
        ),
    ],
)
def test_the_balls_of_a_revolute_joint(inside: str, frame: str, axis: Any) -> None:
    place = frames()
    joint = place["left"] if "relative_to" in inside else place["right"]
    joint = joint @ rpy(*RPY) if "<pose" in inside else joint
    along = {**place, "joint": joint}[frame][:3, :3] @ (np.array(axis) / np.linalg.norm(axis))
    _, points = balls(inside)
    for number, away in ((1, 0.0), (2, 0.1)):
        for end, link in ((1, "tool"), (2, "right")):
            position = place[link] @ np.append(points[f"pin_{number}_{end}"], 1.0)
            assert np.allclose(position[:3], joint[:3, 3] + away * along, rtol=0, atol=1e-12)


def test_a_joint_is_placed_where_the_robot_is_at_zero() -> None:
    """SDF's initial position has all joints at zero; the start position changes no mechanism."""
    _, points = balls("<pose>0 0 0.3 0 0 0</pose>", "ball")
    result, moved = balls("<pose>0 0 0.3 0 0 0</pose>", "ball", posture={"joints": {"hip": 0.5}})
    assert {name: list(position) for name, position in points.items()} == {
        name: list(at) for name, at in moved.items()
    }
    assert "loop-open" in {diagnostic.code for diagnostic in result.diagnostics}


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
    (told,) = [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "loop-renamed"]
    assert told.line is not None
    assert "is called 'pin_2'" in told.message


def test_two_sensors_of_one_name_are_two() -> None:
    """On two links, or at two places of a link; a sensor that is there twice is one."""
    text = (
        imu("<pose>0 0 1 0 0 0</pose>")
        + imu("", link="left")
        + imu("<pose>0 0 2 0 0 0</pose>")
        + '<sensor name="imu" type="accelerometer"><parent link="tool"/></sensor>'
        + '<sensor name="imu" type="imu"><parent link="tool"/><origin xyz="0 0 1"/></sensor>'
    )
    result = convert_text(f"{ARMS}{text}</robot>", base="fixed")
    sensors = {
        s["name"]: (s["link"], s["point"].coordinates) for s in result.report.passes["sensors"]
    }
    assert sensors == {
        "imu": ("tool", (0.0, 0.0, 1.0)),
        "left_imu": ("left", (0.0, 0.0, 0.0)),
        "tool_imu": ("tool", (0.0, 0.0, 2.0)),
    }
    told = [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "sensor-renamed"]
    assert ["'left_imu'" in told[0].message, "'tool_imu'" in told[1].message] == [True, True]
    assert all(diagnostic.line for diagnostic in told)


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
    robot, diagnostics = read(
        f"<ros2_control>{control}</ros2_control>"
        + drive.format("hip", "", 0.5, "")
        + drive.format("hip", ratio.format(3), 0.5, "")
        + drive.format("hip", ratio.format(3), 0.5, ratio.format(2))
        + drive.format("hip", "", -1, "")
        + drive.format("", "", 1, "")
        + drive.format("hip", "", "x", "")
        + drive.format("hip", "", 1, ratio.format("y"))
        + '<gazebo reference="hip"><mu1>0.25</mu1><springStiffness value="2"/><mu1>z</mu1></gazebo>'
        + "<ros2_control>"
        + control.replace("0.5", "w")
        + "</ros2_control>"
    )
    first, *drives, surface, last = robot.extensions
    assert (first.starts, last.starts) == ({"hip": 0.5}, {})
    assert (first.motors, last.motors) == (["mount"], ["mount"])
    assert [drive.rotors.get("hip") for drive in drives] == [0.5, 4.5, 2.0] + [None] * 4
    assert [drive.motors for drive in drives] == [["hip"]] * 4 + [[]] + [["hip"]] * 2
    assert not any("" in drive.rotors for drive in drives)
    assert surface.numbers == {"mu1": 0.25, "springStiffness": 2.0}
    assert [diagnostic.code for diagnostic in diagnostics] == ["number-negative"] + [
        "number-left-out"
    ] * 3


def test_a_spring_of_a_joint() -> None:
    """The rest of the joint's dynamics stays; a joint has one spring, the last that is stated."""
    spring = '<gazebo reference="hip"><springReference>{}</springReference></gazebo>'
    stiff = '<gazebo reference="{}"><springStiffness>2</springStiffness></gazebo>'
    robot, diagnostics = read(
        "".join(map(stiff.format, ("hip", "left", "none"))) + spring.format(-0.5)
    )
    assert robot.joints["hip"].dynamics == Dynamics(0.0, 0.0, 2.0, -0.5)
    assert [joint.dynamics for joint in robot.joints.values()].count(None) == 2
    told, lost = diagnostics
    assert told.message.endswith("the joint has no spring here: joint 'left'")
    assert lost.message.endswith("does not exist has no effect: gazebo 'none'")
    damped = ARMS.replace('<axis xyz="0 0.6 0.8"/>', '<dynamics damping="3"/>')
    robot = parse_urdf(f"{damped}{spring.format(1)}</robot>".encode(), "arms.urdf", extend=EXTEND)[
        0
    ]
    assert robot.joints["hip"].dynamics == Dynamics(3.0, 0.0, 0.0, 1.0)


def test_friction_in_a_link_is_of_the_link() -> None:
    bullet = '<contact><lateral_friction value="{}"/></contact>'
    eye = '<link name="eye">' + "".join(map(bullet.format, (0.5, "x"))) + "</link>"
    joint = '<joint name="see" type="fixed"><parent link="tool"/><child link="eye"/></joint>'
    robot, diagnostics = read(eye + joint)
    assert [(e.tag, e.reference, e.numbers) for e in robot.extensions] == [
        ("contact", "eye", {"mu1": 0.5}),
        ("contact", "eye", {}),
    ]
    assert [diagnostic.code for diagnostic in diagnostics] == ["number-left-out"]


def test_mechanics_without_effect_are_named() -> None:
    """A link without mass has no weight that gravity could have."""
    gazebo = (
        '<gazebo reference="{}"><turnGravityOff>true</turnGravityOff>'
        "<springStiffness>{}</springStiffness></gazebo>"
    )
    joint = '<joint name="see" type="fixed"><parent link="tool"/><child link="eye"/></joint>'
    eye = f'<link name="eye"/>{joint}'
    places = gazebo.format("tool", 0.0) + gazebo.format("eye", "x") + gazebo.format("see", 40)
    _, diagnostics = read(eye + places)
    told = [
        diagnostic.message for diagnostic in diagnostics if diagnostic.code == "mechanics-unread"
    ]
    assert told == [
        "<turnGravityOff> of <gazebo> has no effect, as the link has its weight here: link 'tool'",
        "<springStiffness> of <gazebo> has no effect, as the joint has no spring here: joint 'see'",
    ]
    assert [diagnostic.code for diagnostic in diagnostics].count("number-left-out") == 1


def warnings_of(more: str) -> list[str]:
    """Read the arms with more elements; return the code, message and hint of each warning."""
    return [
        f"{diagnostic.code}: {diagnostic.message} {diagnostic.hint or ''}"
        for diagnostic in read(more)[1]
        if diagnostic.level == "warning"
    ]


UNREAD = [
    ("<dampingFactor>0.1</dampingFactor>", "tool", "<dampingFactor> in <gazebo>", "link 'tool'"),
    ("<static>true</static>", "tool", "<static> of <gazebo> is of the whole robot", "link 'tool'"),
    ("<gravity>0 0 -1.62</gravity>", "", "<gravity> of <gazebo> is '0 0 -1.62'", ""),
    ("<include><uri>model://x</uri></include>", "", "<include> in <gazebo>", ""),
    ('<plugin name="Buoyancy" filename="x.so"/>', "", "the plugin 'x.so'", ""),
    ('<plugin filename="x.so"><parent>a</parent><child>b</child></plugin>', "", "'x.so'", ""),
    ("<kinematic><!-- c -->true</kinematic>", "tool", "<kinematic> in <gazebo>", "link 'tool'"),
    ("<kinematic>true</kinematic>", "tool", "<kinematic> in <gazebo>", "link 'tool'"),
    ("<gravity>0</gravity>", "tool", "<gravity> of <gazebo>", "link 'tool'"),
    ("<gravity>false</gravity>", "tool", "<gravity> of <gazebo>", "link 'tool'"),
    ("<turnGravityOff>1</turnGravityOff>", "", "'gravity' of the config", ""),
    ("<inertial><mass>3</mass></inertial>", "tool", "<inertial> in <gazebo>", "link 'tool'"),
    ("<pose>0 0 1 0 0 0</pose>", "", "<pose> in <gazebo>", ""),
    ('<plugin filename="libLiftDragPlugin.so"/>', "", "the plugin 'libLiftDragPlugin.so'", ""),
    (
        '<plugin filename="libx.so"><joint><parent>world</parent></joint></plugin>',
        "",
        "the plugin 'libx.so'",
        "",
    ),
    (
        "<collision><surface><friction/></surface></collision>",
        "tool",
        "the friction of <collision>",
        "link 'tool'",
    ),
]


def test_what_is_said_of_no_link_is_named() -> None:
    told = warnings_of(
        '<gazebo reference="toool"><mu1>1</mu1><material>x</material></gazebo>'
        '<gazebo reference="gone"><turnGravityOff>true</turnGravityOff></gazebo>'
        '<gazebo reference="lost"><material>x</material></gazebo>'
    )
    assert told == [
        "mechanics-unread: what <gazebo> says of a link or joint that does not exist has no "
        "effect: gazebo 'toool', gazebo 'gone' did you mean 'tool'?"
    ]


@pytest.mark.parametrize(("words", "reference", "message", "place"), UNREAD)
def test_mechanics_in_gazebo_are_named(
    words: str, reference: str, message: str, place: str
) -> None:
    about = f' reference="{reference}"' if reference else ""
    (told,) = warnings_of(f"<gazebo{about}>{words}</gazebo>")
    assert told.startswith("mechanics-unread")
    assert message in told
    assert place in told


@pytest.mark.parametrize(
    "words",
    [
        "<gravity>1</gravity><gravity>true</gravity>",
        "<kinematic>0</kinematic><static>false</static>",
        "<material>Gazebo/Red</material><selfCollide>true</selfCollide><mu2>0.3</mu2>",
        '<plugin filename="libgazebo_ros_control.so"><robotNamespace>/r</robotNamespace></plugin>',
        '<plugin filename="libgazebo_ros_diff_drive.so"><leftJoint>hip</leftJoint></plugin>',
        "<sensor name='eye' type='camera'><pose>0 0 1 0 0 0</pose></sensor>",
    ],
)
def test_what_says_nothing_of_the_mechanics_is_no_warning(words: str) -> None:
    assert warnings_of(f'<gazebo reference="tool">{words}</gazebo>') == []


def test_dynamics_under_an_axis_of_sdf_are_named() -> None:
    axis = (
        "<axis><xyz>0 0 1</xyz><dynamics><damping>2</damping></dynamics>"
        "<limit><lower>-1</lower></limit></axis><thread_pitch>3</thread_pitch>"
    )
    told = warnings_of(ball(axis, "revolute"))
    assert [text.partition(" are not")[0].partition(" is not")[0] for text in told] == [
        "mechanics-unread: <thread_pitch> in <joint>",
        "mechanics-unread: <dynamics>, <limit> in <axis>",
    ]
    assert not warnings_of(
        ball("<axis><dynamics><damping>0.0</damping></dynamics></axis>", "revolute")
    )


@pytest.mark.parametrize("name", ["mu1", "springStiffness", "kp"])
def test_numbers_below_zero_in_gazebo(name: str) -> None:
    (told,) = warnings_of(f'<gazebo reference="hip"><{name}>-50</{name}></gazebo>')
    assert told.startswith(f"number-negative: <{name}> of <gazebo> is below zero")


def test_unread_numbers_of_bullet_are_named() -> None:
    contact = '<contact><lateral_friction value="1"/><inertia_scaling value="3"/></contact>'
    more = f'<link name="eye">{contact}</link>' + (
        '<joint name="see" type="fixed"><parent link="tool"/><child link="eye"/></joint>'
    )
    (told,) = warnings_of(more)
    assert "<inertia_scaling> in <contact> is not read, and has no effect: link 'eye'" in told


# --- what ties the root to the world ---

WELD = '<gazebo><joint name="weld" type="{}"><parent>{}</parent><child>{}</child></joint></gazebo>'


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        ("<gazebo><static>true</static></gazebo>", "<static> of <gazebo>"),
        (WELD.format("fixed", "world", "base"), "joint 'weld' of <gazebo>"),
        (WELD.format("fixed", "base", "world"), "joint 'weld' of <gazebo>"),
        (WELD.format("Fixed", "world", "arms::base"), "joint 'weld' of <gazebo>"),
        ("<gazebo><static>yes</static></gazebo>", "<static> of <gazebo>"),
    ],
)
def test_a_static_robot_and_one_welded_to_the_world_have_a_fixed_base(
    more: str, reason: str
) -> None:
    text = f"{ARMS}{more}</robot>".replace('type="floating"', 'type="continuous"')
    result = convert_text(text)
    assert not result.conversion.base.floating
    (told,) = [diagnostic for diagnostic in result.diagnostics if diagnostic.code == "base"]
    assert told.message == f"fixed base: {reason} ties the root to the world"
    assert not [
        diagnostic for diagnostic in result.diagnostics if diagnostic.code == "base-guessed"
    ]
    assert convert_text(text, base="floating").conversion.base.floating


@pytest.mark.parametrize(
    "more",
    [
        WELD.format("fixed", "world", "tool"),  # the tool moves: this would be a loop
        WELD.format("revolute", "world", "base"),
        '<gazebo reference="tool"><static>true</static></gazebo>',
    ],
)
def test_other_ties_to_the_world_do_not_fix_the_base(more: str) -> None:
    assert read(more)[0].fixed_by == ""


# --- joints that follow others ---


def control(*joints: str) -> str:
    return f'<ros2_control name="c" type="system">{"".join(joints)}</ros2_control>'


def follower(leader: str, rule: str = "", name: str = "hip") -> str:
    return f'<joint name="{name}"><param name="mimic">{leader}</param>{rule}</joint>'


RULE = '<param name="multiplier">-2</param><param name="offset">0.5</param>'
PLUGIN = (
    '<gazebo><plugin filename="libroboticsgroup_gazebo_mimic_joint_plugin.so">'
    "<joint>{}</joint><mimicJoint>hip</mimicJoint>{}</plugin></gazebo>"
)
PLUGIN_RULE = "<multiplier>-2</multiplier><offset>0.5</offset>"
#: A joint that 'hip' may follow.
LEAD = (
    '<link name="wrist"/><joint name="lead" type="continuous"><parent link="tool"/>'
    '<child link="wrist"/><axis xyz="0 0 1"/></joint>'
)


@pytest.mark.parametrize(
    "more", [control(follower("lead", RULE)), PLUGIN.format("lead", PLUGIN_RULE)]
)
def test_a_joint_follows_another_by_other_programs(more: str) -> None:
    robot, diagnostics = read(LEAD + more)
    assert not diagnostics
    assert robot.joints["hip"].mimic == Mimic("lead", -2.0, 0.5)
    plain, _ = read(LEAD + more.replace(RULE, "").replace(PLUGIN_RULE, ""))
    assert plain.joints["hip"].mimic == Mimic("lead", 1.0, 0.0)


def test_it_is_coupled_as_by_mimic() -> None:
    """A project has the same constraint for each of the three ways to say it."""
    arms = ARMS.replace('type="floating"', 'type="continuous"')
    mimic = '<mimic joint="shoulder" multiplier="-2" offset="0.5"/>'
    texts = [
        f"{arms}{control(follower('shoulder', RULE))}</robot>",
        f"{arms}{PLUGIN.format('shoulder', PLUGIN_RULE)}</robot>",
        f"{arms}</robot>".replace('<axis xyz="0 0.6 0.8"/>', f'<axis xyz="0 0.6 0.8"/>{mimic}'),
    ]
    rules = [
        convert_text(text, base="fixed", output={"project": "p"}).report.passes["mimic"]
        for text in texts
    ]
    assert rules[0] == rules[1] == rules[2]


@pytest.mark.parametrize(
    ("more", "code", "words"),
    [
        (control(follower("laed")), "mimic-left-out", "'laed' is no joint"),
        (control(follower("lead", name="hop")), "mimic-left-out", "joint 'hop' did you mean 'hip'"),
        (
            control(follower("lead", RULE.replace("-2", "x"))),
            "mimic-left-out",
            "'x' is not a number",
        ),
        (control('<joint name="hip" mimic="true"/>'), "mimic-conflict", "has no <mimic>"),
        (
            PLUGIN.format("lead", "").replace("mimicJoint", "other"),
            "mimic-left-out",
            "<mimicJoint>",
        ),
        (
            PLUGIN.format("lead", "") + control(follower("lead", RULE)),
            "mimic-conflict",
            "hip = lead, and hip = -2.0 * lead + 0.5",
        ),
    ],
)
def test_followers_that_cannot_be_read_or_contradict_are_named(
    more: str, code: str, words: str
) -> None:
    (told,) = warnings_of(LEAD + more)
    assert told.startswith(code)
    assert words in told


# --- transmissions ---

TRANSMISSION = '<transmission name="t"><type>{}</type>{}{}</transmission>'


@pytest.mark.parametrize(
    "more",
    [
        TRANSMISSION.format(
            "transmission_interface/DifferentialTransmission",
            '<joint name="hip"/><joint name="shoulder"/>',
            '<actuator name="m"/><actuator name="n"/>',
        ),
        TRANSMISSION.format("x/SimpleTransmission", '<joint name="hip"/>', '<actuator name="m"/>')
        + TRANSMISSION.format("x/Simple", '<joint name="shoulder"/>', '<actuator name="m"/>'),
    ],
)
def test_transmissions_that_couple_joints_are_named(more: str) -> None:
    (told,) = warnings_of(more)
    assert told.startswith("mechanics-unread")
    assert "couples" in told
    assert "joint 'hip'" in told
    assert "joint 'shoulder'" in told


def test_one_transmission_of_an_actuator_that_is_there_twice_is_no_coupling() -> None:
    transmission = TRANSMISSION.format("x/Simple", '<joint name="hip"/>', '<actuator name="m"/>')
    assert warnings_of(transmission * 2) == []


def test_two_that_contradict_name_the_first() -> None:
    (told,) = warnings_of(LEAD + control(follower("lead")) + PLUGIN.format("lead", PLUGIN_RULE))
    assert "<ros2_control> and a plugin of <gazebo> contradict" in told
    assert "<ros2_control> is used" in told


def test_a_rule_by_a_chain_is_no_contradiction() -> None:
    """The tip follows the wrist, which follows the hip: so the tip follows the hip."""
    chain = LEAD.replace("</joint>", '<mimic joint="hip" multiplier="2" offset="1"/></joint>')
    last = (
        '<link name="tip"/><joint name="last" type="continuous"><parent link="wrist"/>'
        '<child link="tip"/><axis xyz="0 0 1"/><mimic joint="lead" multiplier="3"/></joint>'
    )
    rule = '<param name="multiplier">6</param><param name="offset">3</param>'
    assert warnings_of(chain + last + control(follower("hip", rule, "last"))) == []
    wrong = warnings_of(chain + last + control(follower("hip", "", "last")))
    assert "mimic-conflict" in wrong[0]


def test_a_reduction_of_ros2_counts() -> None:
    drive = (
        "<ros2_control><joint name='hip'><command_interface/></joint><transmission name='t'>"
        "<joint name='hip'/><actuator name='m'><mechanical_reduction>50</mechanical_reduction>"
        "<motor_inertia>1e-4</motor_inertia></actuator></transmission></ros2_control>"
    )
    robot, diagnostics = read(drive)
    assert not diagnostics
    assert robot.extensions[0].rotors == pytest.approx({"hip": 0.25}, rel=1e-15)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ("<mechanicalReduction>0</mechanicalReduction><motorInertia>1</motorInertia>", "is 0"),
        ("</actuator><compensator k_belt='3'/><actuator name='m'>", "<compensator>"),
    ],
)
def test_parts_of_a_transmission_that_are_lost(parts: str, words: str) -> None:
    drive = f'<transmission><joint name="hip"/><actuator name="m">{parts}</actuator></transmission>'
    assert any(words in warning for warning in warnings_of(drive))


def test_masses_that_mujoco_changes_are_named() -> None:
    mujoco = '<mujoco><compiler meshdir="m" {}/><option gravity="0 0 0"/></mujoco>'
    told = warnings_of(mujoco.format('balanceinertia="true"'))
    assert "<option> in <mujoco>" in told[0]
    assert "<compiler> of <mujoco> changes masses by balanceinertia" in told[1]
    assert len(warnings_of(mujoco.format(""))) == 1


@pytest.mark.parametrize("place", ["<actuator name='m'>{}</actuator>", "<actuator name='m'/>{}"])
def test_the_rotor_of_drake_is_the_rotor_of_a_transmission(place: str) -> None:
    numbers = '<drake:gear_ratio value="100"/><drake:rotor_inertia value="1e-4"/>'
    drive = f'<transmission><joint name="hip"/>{place.format(numbers)}</transmission>'
    arms = ARMS.replace("<robot", '<robot xmlns:drake="http://drake.mit.edu"')
    robot, diagnostics = parse_urdf(f"{arms}{drive}</robot>".encode(), "arms.urdf", extend=EXTEND)
    assert not diagnostics
    assert robot.extensions[0].rotors == pytest.approx({"hip": 1.0}, rel=1e-15)


def test_joints_of_other_elements_are_named() -> None:
    robot, diagnostics = read(
        '<transmission><joint name="hip"/></transmission><gazebo><joint/><link/></gazebo>'
        '<ros2_control><joint name="hip"/></ros2_control>'
    )
    assert list(robot.joints) == ["shoulder", "mount", "hip"]
    assert {diagnostic.code for diagnostic in diagnostics} == {"loop-left-out", "mechanics-unread"}
