"""What a URDF says of mechanics in words that are not read is a warning, which names the words."""

import re

import pytest

from support.build import limit, solid
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.reader import parse_urdf

SOLID = solid(1, 1, xyz="0 0 0.1")
LIMIT = limit()
TURN = (
    '<joint name="turn" type="{kind}"><parent link="base"/><child link="arm"/>{axis}{more}</joint>'
)


def read(
    link: str = SOLID,
    joint: str = LIMIT,
    robot: str = "",
    *,
    kind: str = "revolute",
    axis: str = '<axis xyz="0 1 0"/>',
    attributes: str = "",
) -> tuple[Robot, list[Diagnostic]]:
    """Read a robot of the links 'base' and 'arm' and the joint 'turn', with the parts given."""
    text = (
        f'<robot name="r"{attributes}><link name="base"/><link name="arm">{link}</link>'
        f"{TURN.format(kind=kind, axis=axis, more=joint)}{robot}</robot>"
    )
    return parse_urdf(text.encode(), "r.urdf")


def read_warning(**parts: str) -> Diagnostic:
    """Read a robot that has one warning, and return it."""
    (warning,) = [diagnostic for diagnostic in read(**parts)[1] if diagnostic.level == "warning"]
    return warning


#: What stands in the joint 'turn', beside limits, and what its warning says.
IN_JOINT = [
    (
        "<dynamics><damping>2</damping><friction>1</friction></dynamics>",
        "<damping>, <friction> in <dynamics> are not read",
    ),
    ("<origin>0 0 0.3</origin>", "the text '0 0 0.3' in <origin> is not read"),
    ("<origin><xyz>0 0 0.3</xyz></origin>", "<xyz> in <origin> is not read"),
    ('<origin pos="0 0 0.3" quat="1 0 0 0"/>', "the attributes 'pos', 'quat' of <origin>"),
    ('<origin x="0.3"/>', "the attribute 'x' of <origin> is not read"),
    ('<pose xyz="0.3 0 0.8"/>', "<pose> in <joint> is not read"),
    (
        "<position>0 0 1</position><orientation>0 0 1</orientation>",
        "<position>, <orientation> in <joint> are not read",
    ),
    (
        '<dynamics damping="1" D="3" K="2" mu_viscous="16"/>',
        "the attributes 'D', 'K', 'mu_viscous' of <dynamics> are not read",
    ),
    ('<dynamics rotor_inertia="0.1"/>', "'rotor_inertia' of <dynamics>"),
    ("<thread_pitch>0.01</thread_pitch>", "<thread_pitch> in <joint>"),
    ('<parent link="x"/>', "more than one <parent> in <joint>: only the first is used"),
    ("<!-- 2 --> stray", "the text 'stray' in <joint>"),
    ('<calibration rising="1"><falling>2</falling></calibration>', "<falling> in <calibration>"),
    ('<x:spring xmlns:x="urn:x" k="3"/>', "<x:spring> in <joint>"),
]
IN_LINK = [
    (SOLID.replace("<inertial>", '<inertial xyz="1 2 3">'), "'xyz' of <inertial>"),
    (SOLID.replace('value="1"', 'value="1" unit="g"'), "'unit' of <mass>"),
    (SOLID.replace("</inertial>", "<density>3</density></inertial>"), "<density> in <inertial>"),
    (SOLID + '<link name="inner"/>', "<link> in <link>"),
    (SOLID + "<gravity>0</gravity>", "<gravity> in <link>"),
    (SOLID + "<pose>0 0 1 0 0 0</pose>", "<pose> in <link>"),
    (SOLID.replace('izz="1"', 'izz="1" iyx="0.1"'), "'iyx' of <inertia>"),
    (
        SOLID + "<collision><pose>1</pose><geometry><sphere radius='1'/></geometry></collision>",
        "<pose> in <collision>",
    ),
]
IN_ROBOT = [
    ('<group><link name="inner"/></group>', "<group> in <robot>"),
    (
        '<d:ball_constraint xmlns:d="http://drake.mit.edu"><d:a name="arm"/></d:ball_constraint>',
        "<d:ball_constraint> in <robot>",
    ),
    ('<loop_joint name="j" type="ball"><link1/><link2/></loop_joint>', "<loop_joint> in <robot>"),
    ('<drake:weld a="1"/>', "<drake:weld> in <robot>"),
    ("word", "the text 'word' in <robot>"),
    ('<x:include xmlns:x="http://www.w3.org/2001/XInclude" href="arm.urdf"/>', "<x:include>"),
]


@pytest.mark.parametrize(("words", "message"), IN_JOINT)
def test_words_in_a_joint_that_are_not_read_are_named(words: str, message: str) -> None:
    warning = read_warning(joint=LIMIT + words)
    assert warning.code in ("mechanics-unread", "doubled-element")
    assert warning.joint == "turn"
    assert message in warning.message


@pytest.mark.parametrize(("words", "message"), IN_LINK)
def test_words_in_a_link_that_are_not_read_are_named(words: str, message: str) -> None:
    warning = read_warning(link=words)
    assert (warning.code, warning.link) == ("mechanics-unread", "arm")
    assert message in warning.message


@pytest.mark.parametrize(("words", "message"), IN_ROBOT)
def test_words_in_the_robot_that_are_not_read_are_named(words: str, message: str) -> None:
    warnings = [diagnostic for diagnostic in read(robot=words)[1] if diagnostic.level == "warning"]
    reported = [diagnostic for diagnostic in warnings if diagnostic.code != "xml-namespace"]
    assert [diagnostic.code for diagnostic in reported] == ["mechanics-unread"]
    assert message in reported[0].message


def test_elements_in_place_of_attributes_of_a_limit_and_an_inertia_are_named() -> None:
    """Such elements lack their attributes, too, which is said in true words."""
    diagnostics = read(joint="<limit><lower>-1</lower><upper>1</upper></limit>")[1]
    assert [diagnostic.code for diagnostic in diagnostics] == ["mechanics-unread", "limit-zero"]
    assert diagnostics[0].message.startswith("<lower>, <upper> in <limit> are not read")
    inertial = '<inertial><mass value="1"/><inertia><ixx>1</ixx></inertia></inertial>'
    diagnostics = read(link=inertial)[1]
    reported = {diagnostic.code: diagnostic.message for diagnostic in diagnostics}
    assert "<ixx> in <inertia> is not read" in reported["mechanics-unread"]
    assert "<inertial> without the attributes of <inertia>" in reported["inertial-incomplete"]


def test_elements_in_place_of_attributes_of_a_mimic_are_named() -> None:
    follower = (
        '<link name="tip"/><joint name="lead" type="continuous"><parent link="arm"/>'
        '<child link="tip"/><axis xyz="0 0 1"/></joint>'
    )
    mimic = '<mimic joint="lead"><multiplier>2</multiplier><offset>0.1</offset></mimic>'
    warning = read_warning(joint=LIMIT + mimic, robot=follower)
    assert "<multiplier>, <offset> in <mimic> are not read" in warning.message
    assert warning.hint == 'write attributes: <mimic multiplier="..." offset="..."/>'


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ("<dynamics><damping>2</damping></dynamics>", '<dynamics damping="..."/>'),
        ("<pose>0 0 1 0 0 0</pose>", '<origin xyz="x y z" rpy="roll pitch yaw"/>'),
        ('<dynamics unit="g"/>', "m, kg, rad, s and N"),
        ('<origin quat_xyzw="0 0 1 0"/>', '<robot version="1.1">'),
    ],
)
def test_a_warning_says_what_urdf_has_instead(words: str, hint: str) -> None:
    assert hint in (read_warning(joint=LIMIT + words).hint or "")


@pytest.mark.parametrize(
    ("part", "hint"),
    [
        ({"link": SOLID.replace('<mass value="1"/>', "<mass>3</mass>")}, '<mass value="3"/>'),
        ({"axis": "<axis><xyz>0 1 0</xyz></axis>"}, '<axis xyz="0 1 0"/>'),
    ],
)
def test_a_missing_number_that_is_a_text_is_an_error_with_a_hint(
    part: dict[str, str], hint: str
) -> None:
    with pytest.raises(ConversionError) as caught:
        read(**part)
    assert caught.value.code == "number-missing"
    assert hint in (caught.value.hint or "")


#: What says nothing of the mechanics, or says zero: link, joint, robot.
HARMLESS = [
    (SOLID + "<self_collision_checking><origin/></self_collision_checking>", "", ""),
    (
        SOLID + '<collision group="1"><geometry name="g"><sphere radius="1"/></geometry>'
        '<material name="x"/></collision>',
        "",
        "",
    ),
    (
        SOLID + '<visual><geometry><sphere radius="1"/></geometry>'
        '<material name="x"><color rgba="1 1 1 1"/><specular rgba="1 1 1 1"/></material></visual>',
        "",
        "",
    ),
    (SOLID + '<origin xyz="0 0 0"/>', "", ""),
    (SOLID.replace('ixy="0"', 'ixy="0.1"').replace('izz="1"', 'izz="1" iyx="0.1"'), "", ""),
    (SOLID, '<dynamics damping="1" K="0" D="0.0"/>', ""),
    (SOLID, '<joint_properties damping="0.0" friction="0.0"/>', ""),
    (SOLID, '<controller_gains Kp="3"/>', ""),
    (SOLID + "<gravity>true</gravity>", "", ""),
    (SOLID, "", '<frame name="f" link="arm" xyz="1 0 0"/>'),
    (
        SOLID,
        "",
        '<sensor:camera xmlns:sensor="http://playerstage.sourceforge.net/gazebo/xmlschema/'
        '#sensor" name="c"/>',
    ),
]


@pytest.mark.parametrize(("link", "joint", "robot"), HARMLESS)
def test_what_says_nothing_of_the_mechanics_is_a_note(link: str, joint: str, robot: str) -> None:
    diagnostics = read(link, LIMIT + joint, robot)[1]
    assert {diagnostic.level for diagnostic in diagnostics} == {"note"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("<gravity>0</gravity>", "<gravity> in <link>"),
        ("<use_gravity>false</use_gravity>", "<use_gravity> in <link>"),
        ("<gravity_scale>0</gravity_scale>", "<gravity_scale> in <link>"),
        ("<dynamic>false</dynamic>", "<dynamic> in <link>"),
        ("<pose><!-- metres -->0 0 0.85 0 0 0</pose>", "<pose> in <link>"),
        ("<pose>0 0 <!-- metres --> 0.85</pose>", "<pose> in <link>"),
        ("<damping><!-- none --></damping>", "<damping> in <link>"),
        (
            '<visual><geometry><sphere radius="1"/></geometry><material name="steel">'
            '<color rgba="1 1 1 1"/><density>7850</density></material></visual>',
            "<density> in <material>",
        ),
    ],
)
def test_zero_and_comments_hide_nothing(words: str, message: str) -> None:
    assert message in read_warning(link=SOLID + words).message


def test_each_kind_is_said_once_with_its_places() -> None:
    second = (
        TURN.replace("turn", "twist").replace("base", "arm").replace('"arm"/>{axis}', '"tip"/>')
    )
    second = second.format(kind="continuous", more='<dynamics K="2"/>')
    diagnostics = read(joint=f'{LIMIT}<dynamics K="1"/>', robot=f'<link name="tip"/>{second}')[1]
    assert [diagnostic.message.partition(": ")[2] for diagnostic in diagnostics] == [
        "joint 'turn', joint 'twist'"
    ]


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (f'{LIMIT}<dynamics damping="-1"/>', "damping of <dynamics> is below zero"),
        (f'{LIMIT}<dynamics friction="-1"/>', "friction of <dynamics> is below zero"),
        (LIMIT.replace('effort="1"', 'effort="-1"'), "effort of <limit> is below zero"),
        (LIMIT.replace('velocity="1"', 'velocity="-1"'), "velocity of <limit> is below zero"),
    ],
)
def test_numbers_that_no_joint_has_below_zero(joint: str, message: str) -> None:
    warning = read_warning(joint=joint)
    assert (warning.code, warning.joint) == ("number-negative", "turn")
    assert message in warning.message


@pytest.mark.parametrize(
    "numbers",
    ['lower="0" upper="0"', "", 'upper="0"', 'lower="-0.0"', 'lower="0.5" upper="0.5"'],
)
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_limits_from_zero_to_zero_have_two_meanings(numbers: str, kind: str) -> None:
    warning = read_warning(joint=f'<limit {numbers} effort="1" velocity="1"/>', kind=kind)
    assert (warning.code, warning.joint) == ("limit-zero", "turn")
    assert "locked there" in warning.message
    assert "(at " in warning.message
    assert "no limits" in warning.message
    assert "zero_limits: locked" in (warning.hint or "")


def test_one_number_of_a_limit_that_is_missing_is_zero() -> None:
    robot, (warning,) = read(joint='<limit upper="1" effort="1" velocity="1"/>')
    assert robot.joints["turn"].limit is not None
    assert robot.joints["turn"].limit.lower == 0.0
    assert warning.code == "limit-zero"
    assert "lower of <limit> is missing, which means 0" in warning.message


def test_a_continuous_joint_needs_no_limits() -> None:
    assert not read(joint='<limit effort="1" velocity="1"/>', kind="continuous")[1]


def test_bounds_of_urdf_1_2_and_of_drake_are_read() -> None:
    rates = 'drake:acceleration="2" deceleration="3" jerk="4"'
    robot, diagnostics = read(
        joint=LIMIT.replace("velocity", f"{rates} velocity"),
        attributes=' xmlns:drake="http://drake.mit.edu"',
    )
    assert not diagnostics
    limit = robot.joints["turn"].limit
    assert limit is not None
    assert (limit.acceleration, limit.deceleration, limit.jerk) == (2.0, 3.0, 4.0)


def test_the_harmless_list_has_its_limits() -> None:
    still = '<joint name="j" type="fixed"><parent link="arm"/><child link="b"/></joint>'
    reported = read_warning(robot=f'<link name="b" type="static"/>{still}')
    assert "the attribute 'type' of <link>" in reported.message
    diagnostics = read(robot="<author>x</author><date>y</date><meta><a/></meta>")[1]
    assert [(diagnostic.level, diagnostic.code) for diagnostic in diagnostics] == [
        ("note", "unknown-element")
    ]


@pytest.mark.parametrize("words", [words for words, _ in IN_JOINT if "stray" not in words])
def test_a_comment_changes_no_message(words: str) -> None:
    """Wherever it stands: behind each opening tag, or before each closing tag."""
    plain = [(diagnostic.code, diagnostic.message) for diagnostic in read(joint=LIMIT + words)[1]]
    opened = re.sub(r"(<\w[^<>]*[^/<>]>)", r"\1<!-- c -->", words)
    closed = re.sub(r"(</)", r"<!-- c -->\1", words)
    for text in (opened, closed):
        assert [
            (diagnostic.code, diagnostic.message) for diagnostic in read(joint=LIMIT + text)[1]
        ] == plain


DRAKE = (
    '<robot name="r" xmlns:drake="http://drake.mit.edu"><link name="base"/><link name="arm"/>'
    '<drake:joint name="turn" type="{}"><drake:parent link="base"/><child link="arm"/>'
    '<origin xyz="0 0 1"/></drake:joint></robot>'
)


@pytest.mark.parametrize(
    ("kind", "types"),
    [
        ("planar", {"turn": "planar"}),
        ("revolute", {"turn": "revolute"}),
        ("ball", dict.fromkeys(("turn_R1", "turn_R2", "turn_R3"), "continuous")),
        ("universal", dict.fromkeys(("turn_R1", "turn_R2"), "continuous")),
    ],
)
def test_joints_with_the_prefix_of_drake_are_joints(kind: str, types: dict[str, str]) -> None:
    declared = ' xmlns:drake="http://drake.mit.edu"'
    for text in (DRAKE, DRAKE.replace(declared, ""), DRAKE.replace("http:", "https:")):
        robot, _ = parse_urdf(text.format(kind).encode(), "r.urdf")
        assert {joint.name: joint.type for joint in robot.joints.values()} == types
        first = next(iter(robot.joints.values()))
        assert (first.parent, first.origin.xyz) == ("base", (0.0, 0.0, 1.0))


@pytest.mark.parametrize("kind", ["screw", "curvilinear"])
@pytest.mark.parametrize("prefix", ["http://drake.mit.edu", "urn:other"])
def test_other_joints_with_a_prefix_are_errors(kind: str, prefix: str) -> None:
    with pytest.raises(ConversionError) as caught:
        parse_urdf(DRAKE.replace("http://drake.mit.edu", prefix).format(kind).encode(), "r.urdf")
    errors = [*caught.value.earlier, caught.value.diagnostic()]
    (error,) = [diagnostic for diagnostic in errors if diagnostic.code == "joint-type-unknown"]
    assert f"<drake:joint> 'turn' of the type '{kind}' joins" in error.message
    assert "'base' and 'arm'" in error.message
