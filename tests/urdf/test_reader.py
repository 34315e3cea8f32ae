"""Plain URDF: what is refused and how it is said, what is permitted, what is kept.

Each fault of a file ends in the code that belongs to it, with file and line, and all faults are
told at once.  Whatever is in a file: a robot or one error, never anything else.
"""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from support.codes import DEFAULTS
from support.examples import reproducible
from support.folders import TESTS
from support.plugin_files import read_robot
from support.urdf_files import WORDS, XMLNS, read
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import convert_text
from urdf2mbs.urdf.messages import MAX_ERRORS
from urdf2mbs.urdf.model import (
    Box,
    Calibration,
    Collision,
    Cylinder,
    Dynamics,
    Inertial,
    Limit,
    Material,
    Mesh,
    Mimic,
    Origin,
    SafetyController,
    Sphere,
    Visual,
)
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.reader import choose_file_name, choose_title, parse_urdf
from urdf2mbs.urdf.xml import fix_slips

UNIT = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'


def arm(link: str = "", joint: str = "", *, kind: str = "continuous", robot: str = "") -> str:
    """Return a link 'base', and a link 'tip' on a joint 'turn'; given lines begin at 5 and 9."""
    return (
        f'<?xml version="1.0"?>\n<robot name="arm"{robot}>\n<link name="base"/>\n'
        f'<link name="tip">\n{link}\n</link>\n'
        f'<joint name="turn" type="{kind}"><parent link="base"/><child link="tip"/>\n\n'
        f"{joint}\n</joint>\n</robot>\n"
    )


def tree(*joints: str, links: str = "abcd") -> str:
    """Links a, b, ... (lines 2 on), then joints written 'parent>child' and called after it."""
    lines = ['<robot name="tree">', *(f'<link name="{name}"/>' for name in links)]
    for joint in joints:
        parent, child = joint.split(">")
        lines.append(
            f'<joint name="{joint.replace(">", "_")}" type="fixed">'
            f'<parent link="{parent}"/><child link="{child}"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


def inertial(mass: str = "1", inertia: str = UNIT) -> str:
    return f'<inertial>\n<mass value="{mass}"/>\n{inertia}</inertial>'


def moments(**values: str) -> str:
    zero = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
    return "<inertia " + " ".join(f'{k}="{v}"' for k, v in (zero | values).items()) + "/>"


def mimics(*pairs: str) -> str:
    """Joints a, b, c, one a line from 2 on, which mimic as in 'a>b'."""
    leaders = dict(pair.split(">") for pair in pairs)
    lines = ['<robot name="m">']
    for number, name in enumerate("abc"):
        mimic = f'<mimic joint="{leaders[name]}"/>' if name in leaders else ""
        lines.append(
            f'<joint name="{name}" type="continuous"><parent link="l{number}"/>'
            f'<child link="l{number + 1}"/>{mimic}</joint>'
        )
    lines += [f'<link name="l{number}"/>' for number in range(4)]
    return "\n".join([*lines, "</robot>"])


BOX = '<box size="1 1 1"/>'


#: What is refused: text, code, line, and what its message has.
BAD: list[tuple[str | bytes, str, int | None, str]] = [
    # the file
    ("", "file-empty", None, ""),
    (" \n\t\n", "file-empty", None, ""),
    ("hello\nworld", "not-xml", 1, "hello"),
    ('<robot name="r">\n<link name="a"/>\n', "xml-truncated", 3, ""),
    ('<robot name="r">\n<link na', "xml-truncated", 2, ""),
    ('<robot name="r">\n<link name="a', "xml-truncated", 2, ""),
    ('<robot name="r">\n<!-- a -', "xml-truncated", 2, ""),
    ('<robot name="r">\n<link name="a"/>\n</rob', "xml-truncated", 3, ""),
    ('<robot name="r">\n</robot>\ntext\n', "xml-syntax", 3, "expected nothing after the end"),
    ('<?xml version="1.0"?>\n', "xml-truncated", 2, ""),
    ("<robot>\n<link>\n</joint></robot>", "xml-syntax", 3, "</link> .* </joint>"),
    ('<robot name="r"/>\n<robot/>', "xml-syntax", 2, ""),
    ("<robot name=r>\n</robot>", "xml-syntax", 1, "has no quotes"),
    ('<robot name="a" name="b"/>', "xml-syntax", 1, "'name' is there twice"),
    ('<!DOCTYPE r [<!ENTITY e SYSTEM "file:///x">]>\n<robot>&e;</robot>', "xml-entity", 1, ""),
    ('<?xml version="1.0"?>\n<sdf version="1.6"/>', "wrong-root", 2, "sdf.*SDF"),
    ('<COLLADA xmlns="http://www.collada.org/2005/11"/>', "wrong-root", 1, "COLLADA"),
    ("<mbsDescR7/>", "wrong-root", 1, r"\.mbs"),
    ("<hello/>", "wrong-root", 1, "hello"),
    # macros
    ('<robot name="r">\n<macro name="m"/></robot>', "no-links", 1, ""),
    # names
    (
        '<robot>\n<link name="a"/>\n<link name="a"><visual/></link></robot>',
        "name-doubled",
        3,
        "'a'.*line 2",
    ),
    (
        tree("a>b", "a>b").replace("</joint>\n</robot>", "<axis/></joint>\n</robot>"),
        "name-doubled",
        7,
        "'a_b'.*line 6",
    ),
    *(  # a joint that another element names
        (
            tree("a>b", "b>c").replace('"b_c"', '"a_b"').replace("</robot>", f"{naming}</robot>"),
            "name-doubled",
            7,
            "'a_b'.*line 6",
        )
        for naming in ('<gazebo reference="a_b"/>', "<plugin><joint> a_b </joint></plugin>")
    ),
    ('<robot name="r"></robot>', "no-links", 1, ""),
    ("<robot>\n<link/></robot>", "name-missing", 2, "link"),
    ('<robot>\n<link name=" "/></robot>', "name-missing", 2, "link"),
    ('<robot>\n<link name="a"/>\n<joint type="fixed"/></robot>', "name-missing", 3, "joint"),
    # the tree
    (tree("a>b", "c>d"), "several-roots", 4, "'a'.*'c'"),
    (tree("a>b", "b>c", "c>a", links="abc"), "loop", 5, "'a', 'b', 'c'.*'c_a'"),
    (tree("b>c", "c>d", "d>b"), "loop", 6, "'b'.*'c'.*'d'"),
    (tree("a>b", "a>c", "b>d", "c>d"), "two-parents", 9, "'d'.*'b'.*'c_d'"),
    (tree("a>a", links="a"), "joint-same-link", 3, "'a_a'.*'a'"),
    (tree("a>b", "x>c"), "link-unknown", 7, "'x_c'.*'x'.*parent"),
    (tree("a>b", "b>x"), "link-unknown", 7, "'b_x'.*'x'.*child"),
    (tree("a>b").replace('<parent link="a"/>', ""), "joint-link-missing", 6, "'a_b'.*parent"),
    (tree("a>b").replace('<child link="b"/>', "\n<child/>"), "joint-link-missing", 7, "child"),
    (arm(kind="rotary"), "joint-type-unknown", 7, "'turn'.*'rotary'"),
    (arm(kind=""), "joint-type-missing", 7, "'turn'"),
    # numbers
    (arm(joint='<origin xyz="1 2"/>'), "number-count", 9, "'turn'.*'1 2'"),
    (arm(joint='<axis xyz="1 2 3 4"/>'), "number-count", 9, "'turn'.*axis"),
    (arm(inertial("1 2")), "number-count", 6, "'tip'.*expected a number, got 2"),
    (arm(joint='<origin xyz=""/>'), "number-missing", 9, "'turn'.*xyz"),
    (arm(inertial(inertia=UNIT.replace('iyy="1"', ""))), "number-missing", 7, "'tip'.*iyy"),
    (tree("a>b").replace('child link="b"', 'child link="world"'), "link-unknown", 6, "'world'"),
    (arm(joint="<axis/>"), "number-missing", 9, "'turn'.*axis"),
    (arm(f"<inertial>\n<mass>1</mass>{UNIT}</inertial>"), "number-missing", 6, "'tip'.*mass"),
    (arm(inertial("heavy " * 20)), "number-invalid", 6, r"'heavy heavy.*hea\.\.\.': "),
    (arm(inertial("heavy")), "number-invalid", 6, "'tip'.*heavy"),
    (arm(joint='<axis xyz="0 0 0"/>'), "axis-zero", 9, "'turn'"),
    (arm(joint='<axis xyz="0 -0 0"/>', kind="planar"), "axis-zero", 9, "'turn'"),
    (arm(joint='<axis xyz="0 x 0"/>'), "number-invalid", 9, "'turn'.*axis"),
    (arm(joint='<origin rpy="0 x 0"/>'), "number-invalid", 9, "'turn'.*rpy"),
    *(
        (arm(inertial(inertia=moments(**{moment: "x"}))), "number-invalid", 7, f"'tip'.*{moment}")
        for moment in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    ),
    (arm().replace("<link", "<<<<<<< HEAD\n<link", 1), "merge-conflict", 3, ""),
]


def changed(old: str, new: str) -> bytes:
    """Return the arm with other letters at a place."""
    assert old in arm()
    return arm().replace(old, new, 1).encode("utf-8", "surrogatepass")


def doctype(text: str, use: str = "turn") -> bytes:
    """Return the arm with a DOCTYPE, and with a reference in the name of its joint."""
    bare = arm().partition("?>")[2].strip().replace("turn", use)
    return f"<!DOCTYPE robot [{text}]>\n{bare}".encode()


LAUGHS = '<!ENTITY l0 "lol">' + "".join(
    f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12)
)
PASSWORDS = '"file:///etc/passwd"'
#: What is wrong with the file as XML, or with its letters, by the code.
NO_XML: dict[str, list[bytes]] = {
    "file-empty": [b"\xef\xbb\xbf", b"\0" * 100],
    "not-xml": [
        b'{"robot": {}}',
        b"\x89PNG\r\n\x1a\n" + bytes(range(256)),
        b"PK\x03\x04" + bytes(100),
    ],
    "xml-entity": [
        doctype(LAUGHS, "&l11;"),
        doctype(LAUGHS + '<!ATTLIST robot x CDATA "&l11;">'),
        doctype(f'<!ENTITY a "{"a" * 10000}">', "&a;" * 1000),
        doctype(f"<!ENTITY e SYSTEM {PASSWORDS}>", "&e;"),
        doctype('<!ENTITY e SYSTEM "http://127.0.0.1:9/">', "&e;"),
        doctype('<!ENTITY e "x">'),
        doctype(f"<!ENTITY % p SYSTEM {PASSWORDS}>%p;"),
        doctype('<!ENTITY e "&e;">', "&e;"),
    ],
    "xml-syntax": [
        changed("turn", "&e;"),
        changed("turn", "t\0n"),
        changed("turn", "&#0;"),
        changed("turn", "&#xD800;"),
        changed("turn", "\x1b[2J"),
        changed("turn", "\ud800"),
        arm().replace("turn", "é").encode("latin-1"),
        changed('"1.0"', '"1.0" encoding="klingon"'),
        changed("turn", "t<n"),
        changed("turn", "t&n"),
    ],
    "xml-truncated": [
        changed("</robot>", "<![CDATA[</robot>"),
        changed("</robot>", f"<!--{'x' * 21_000_000}-->"),
    ],
    "xml-too-large": [
        b'<robot name="r">' + b"<a>" * 100_000 + b"</a>" * 100_000 + b"</robot>",
        b'<robot name="r">' + b"<a>" * 100_000,
        changed("</robot>", f"<{'x' * 60_000}/>"),
        changed("</robot>", "x" * 11_000_000 + "</robot>"),
        changed("turn", "j" * 11_000_000),
    ],
}


@pytest.mark.parametrize(
    ("code", "data"),
    [
        pytest.param(code, data, id=f"{code}-{number}")
        for code, several in NO_XML.items()
        for number, data in enumerate(several)
    ],
)
def test_what_is_no_xml_is_refused(code: str, data: bytes) -> None:
    with pytest.raises(ConversionError) as caught:
        parse_urdf(data, "r.urdf")
    assert (caught.value.code, caught.value.file) == (code, "r.urdf")
    assert caught.value.line or code == "file-empty", "which line?"
    assert len(str(caught.value)) < 2000, "an error is for a person"


@pytest.mark.parametrize(
    ("words", "code"),
    [
        *((words, "number-missing") for words in ("", " ")),
        ("1&#10;2", "number-count"),
        *(
            (words, "number-invalid")
            for words in ("1,5", "nan", "-inf", "1e999", "0x10", "1_000", "١", "1;", "1.5.2")
        ),
        *((words, "xacro-unexpanded") for words in ("${x}", "$(arg x)")),
    ],
)
def test_what_is_no_number_is_refused(words: str, code: str) -> None:
    """For one number and among several; where the last of several is blank, they are too few."""
    several = code if words.strip() else "number-count"
    for text, expected in (
        (arm(inertial(words)), code),
        (arm(joint=f'<origin xyz="0 0 {words}"/>'), several),
    ):
        with pytest.raises(ConversionError) as caught:
            parse_urdf(text.encode(), "r.urdf")
        assert caught.value.code == expected


def test_errors_are_told_together_in_their_order() -> None:
    """The tree is judged when the others are mended; not too many are told."""

    def list_errors(text: str) -> list[tuple[int | None, str]]:
        with pytest.raises(ConversionError) as caught:
            parse_urdf(text.encode(), "r.urdf")
        errors = [*caught.value.earlier, caught.value.diagnostic()]
        assert ("there may be more" in str(errors[-1])) == (len(errors) == MAX_ERRORS)
        return [(error.line, error.code) for error in errors]

    three = arm(inertial("x"), '<axis xyz="0 0 0"/>').replace("/>", f">{inertial('')}</link>", 1)
    assert list_errors(three) == [(4, "number-missing"), (8, "number-invalid"), (13, "axis-zero")]
    assert list_errors(tree("a>b", "a>x", "c>b")) == [(7, "link-unknown"), (8, "two-parents")]
    many = "".join(
        f'<link name="c{n}"><inertial><mass value="x"/></inertial></link>\n' for n in range(1000)
    )
    assert list_errors(arm().replace("</robot>", f"{many}</robot>")) == [
        (11 + n, "number-invalid") for n in range(MAX_ERRORS)
    ]


def test_a_name_of_millions_of_letters_is_cut_in_a_message_and_kept_in_the_robot() -> None:
    name = "x" * 2_000_000
    with pytest.raises(ConversionError) as caught:
        parse_urdf(arm().replace('link="base"', f'link="{name}"').encode(), "r.urdf")
    assert caught.value.code == "link-unknown"
    assert name in caught.value.message
    assert len(str(caught.value)) < 5000
    result = convert_text(arm(inertial()).replace("turn", name))
    assert list(result.robot.joints)[-1] == name
    assert result.conversion.checked.proof is not None
    assert result.conversion.checked.proof.same


RICH = (TESTS / "corpus" / "urdf" / "good-rich").read_bytes()
fewer = settings(reproducible, max_examples=100)


def check_outcome(data: bytes) -> None:
    """Read a text as plain URDF and as expanded xacro: a robot, or an error with code and file."""
    for files in ((), ("r.xacro",)):
        robot, failure = None, None
        try:
            robot, diagnostics = parse_urdf(data, "r.urdf", expanded=files)
        except ConversionError as error:
            failure = error
        if robot is not None:
            assert len(robot.depth_first()) == len(robot.joints) == len(robot.links) - 1
            assert len(list(map(str, diagnostics))) < 100
        else:
            assert re.fullmatch("[a-z-]+", failure.code)
            assert "r.urdf" in str(failure)


@fewer
@given(st.integers(0, len(RICH.rstrip()) - 1))
def test_a_file_that_is_cut_anywhere_is_truncated(length: int) -> None:
    with pytest.raises(ConversionError) as caught:
        parse_urdf(RICH[:length], "r.urdf")
    assert caught.value.code in ("xml-truncated", "file-empty", "not-xml")


@fewer
@given(
    st.lists(
        st.tuples(st.integers(0, len(RICH)), st.integers(0, 12), st.sampled_from(WORDS)),
        min_size=1,
        max_size=4,
    )
)
def test_a_file_of_which_pieces_are_replaced_is_a_robot_or_an_error(
    changes: list[tuple[int, int, bytes]],
) -> None:
    data = RICH
    for start, length, word in changes:
        data = data[:start] + word + data[start + length :]
    check_outcome(data)


@fewer
@given(st.text(max_size=12), st.sampled_from(["0.5", "0 0 0.15", "0.2 0.1 0.3", "revolute", "arm"]))
def test_any_text_for_a_value_gives_a_robot_or_an_error(text: str, value: str) -> None:
    escaped = text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    check_outcome(RICH.replace(f'"{value}"'.encode(), f'"{escaped}"'.encode("utf-8", "replace")))


@pytest.mark.parametrize(("text", "code", "line", "words"), BAD)
def test_bad_input_is_one_error_that_says_where(
    tmp_path: Path, text: str, code: str, line: int | None, words: str
) -> None:
    with pytest.raises(ConversionError) as caught:
        read(tmp_path, text)
    error = caught.value
    assert (error.code, error.file) == (code, str(tmp_path / "robot.urdf")), str(error)
    assert line in (None, error.line), str(error)
    assert re.search(words, error.message, re.DOTALL)
    assert error.exit_code == 1
    assert len(str(error)) < 1000


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        (arm(kind="revolut"), "did you mean 'revolute'?"),
        (tree("b>c", "arm>b", links="abc").replace('name="a"', 'name="arms"'), "'arms'"),
        (arm(joint='<origin xyz="0,5 0 0"/>'), "decimals with a point"),
        (arm(joint='<origin xyz="0,5 0,1 0"/>'), "decimals with a point"),
        (arm(joint='<origin xyz="0,5 0,1"/>'), "decimals with a point"),
        (arm(joint='<origin xyz="0,5,1,"/>'), "separated by blanks, not commas"),
        (arm(inertial("1,")), "decimals with a point"),
        (arm(joint='<origin xyz="1 2"/>'), "give 3 numbers, with blanks between them"),
        ('<robot name="a&b">\n</robot>', "&amp;"),
    ],
)
def test_the_hint_says_what_to_do(tmp_path: Path, text: str, hint: str) -> None:
    with pytest.raises(ConversionError) as caught:
        read(tmp_path, text)
    assert hint in (caught.value.hint or "")


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    for name in ("robot.urdf", "robt.stl", "arm.urdf"):
        (tmp_path / name).touch()
    for path, code in (
        (tmp_path / "robt.urdf", "file-not-found"),
        (tmp_path / "robot.urdf" / "below", "file-unreadable"),
        (tmp_path / "nowhere" / "robot.xacro", "file-not-found"),
        (tmp_path, "file-is-directory"),
        (Path("a\0b"), "file-unreadable"),
    ):
        with pytest.raises(ConversionError) as caught:
            read_robot(path, Packages({}, tmp_path), {})
        assert caught.value.code == code
        assert caught.value.file == str(path)
        if path.name == "robt.urdf":
            assert caught.value.hint == "did you mean 'robot.urdf'?"
    with pytest.raises(ConversionError) as caught:
        read_robot(tmp_path / "robt.obj", Packages({}, tmp_path), {})
    assert caught.value.hint == "did you mean 'robot.urdf'?"
    with pytest.raises(ConversionError) as caught:
        read_robot(tmp_path / "atlas.urdf", Packages({}, tmp_path), {})
    assert "did you mean" not in (caught.value.hint or "")


def test_everything_of_the_model_is_filled(tmp_path: Path) -> None:
    robot, diagnostics = read(
        tmp_path,
        """<?xml version="1.0"?>
<robot name="full" version="1.0">
  <material name="red"><color rgba="1 0 0 0.5"/></material>
  <material name="wood"><texture filename="package://p/wood.png"/></material>
  <link name="base">
    <inertial>
      <origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>
      <mass value="4"/>
      <inertia ixx="3" ixy="0.1" ixz="0.2" iyy="4" iyz="0.3" izz="5"/>
    </inertial>
    <visual name="v"><origin xyz="0 0 1"/><geometry><box size="1 2 3"/></geometry>
      <material name="red"/></visual>
    <visual><geometry><cylinder radius="0.5" length="2"/></geometry>
      <material name="blue"><color rgba="0 0 1 1"/></material></visual>
    <collision name="c"><origin rpy="0 0 1"/><geometry><sphere radius="0.5"/></geometry></collision>
    <collision><geometry><mesh filename="package://p/m.stl" scale="1 -1 2"/></geometry></collision>
  </link>
  <link name="tip"/>
  <link name="leaf"/>
  <joint name="turn" type="revolute">
    <origin xyz="0 0 1" rpy="0 0 0.5"/><parent link="base"/><child link="tip"/>
    <axis xyz="0 2 0"/>
    <limit lower="-1" upper="2" effort="10" velocity="3"/>
    <dynamics damping="0.7" friction="0.1"/>
    <safety_controller k_velocity="10" k_position="20" soft_lower_limit="-2" soft_upper_limit="2"/>
    <calibration rising="0.5"/>
  </joint>
  <joint name="follow" type="prismatic">
    <parent link="tip"/><child link="leaf"/><limit effort="1" velocity="1" lower="0" upper="1"/>
    <mimic joint="turn" multiplier="-2" offset="0.1"/>
  </joint>
  <gazebo reference="tip"><mu1>0.2</mu1></gazebo>
  <transmission name="t"><joint name="turn"/></transmission>
</robot>
""",
    )
    assert diagnostics == []
    assert (robot.name, robot.file) == ("full", str(tmp_path / "robot.urdf"))
    assert list(robot.links) == ["base", "tip", "leaf"]
    assert list(robot.joints) == ["turn", "follow"]
    assert robot.root() == "base"
    base = robot.links["base"]
    assert base.line == 5
    assert base.inertial == Inertial(
        4.0, (3.0, 0.1, 0.2, 4.0, 0.3, 5.0), Origin((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    )
    blue = Material("blue", (0.0, 0.0, 1.0, 1.0))
    assert base.visuals == [
        Visual(Box((1.0, 2.0, 3.0)), Origin((0.0, 0.0, 1.0)), Material("red"), "v", 11),
        Visual(Cylinder(0.5, 2.0), Origin(), blue, None, 13),
    ]
    assert base.collisions == [
        Collision(Sphere(0.5), Origin(rpy=(0.0, 0.0, 1.0)), "c", 15),
        Collision(Mesh("package://p/m.stl", (1.0, -1.0, 2.0)), Origin(), None, 16),
    ]
    assert robot.materials == {
        "red": Material("red", (1.0, 0.0, 0.0, 0.5)),
        "wood": Material("wood", None, "package://p/wood.png"),
        "blue": blue,
    }
    turn, follow = robot.joints.values()
    assert (turn.type, turn.parent, turn.child, turn.line) == ("revolute", "base", "tip", 20)
    assert turn.origin == Origin((0.0, 0.0, 1.0), (0.0, 0.0, 0.5))
    assert turn.axis == (0.0, 2.0, 0.0)
    assert turn.limit == Limit(-1.0, 2.0, 10.0, 3.0)
    assert turn.dynamics == Dynamics(0.7, 0.1)
    assert turn.safety_controller == SafetyController(10.0, 20.0, -2.0, 2.0)
    assert turn.calibration == Calibration(0.5, None)
    assert turn.mimic is None
    assert follow.limit == Limit(0.0, 1.0, 1.0, 1.0)
    assert follow.mimic == Mimic("turn", -2.0, 0.1)
    assert follow.axis == (1.0, 0.0, 0.0)
    gazebo, transmission = robot.extensions
    assert (gazebo.tag, gazebo.reference, gazebo.line) == ("gazebo", "tip", 32)
    assert gazebo.xml == '<gazebo reference="tip"><mu1>0.2</mu1></gazebo>'
    assert (transmission.tag, transmission.reference) == ("transmission", None)


def test_what_a_urdf_may_leave_out_has_its_default(tmp_path: Path) -> None:
    robot, diagnostics = read(tmp_path, arm(f"<inertial>{inertial()[10:]}"))
    assert diagnostics == []
    turn = robot.joints["turn"]
    assert turn.origin == Origin()
    assert turn.axis == (1.0, 0.0, 0.0)
    assert turn.limit is None
    inertial_ = robot.links["tip"].inertial
    assert inertial_ is not None
    assert inertial_.origin == Origin()
    assert robot.links["base"].massless
    for mass, inertia, massless in (("0", moments(), True), ("0", UNIT, False), ("1", "", False)):
        assert read(tmp_path, arm(inertial(mass, inertia)))[0].links["tip"].massless is massless


def test_the_joints_stand_one_branch_after_the_other(tmp_path: Path) -> None:
    robot, _ = read(tmp_path, tree("a>b", "a>c", "b>d", "b>e", "c>f", links="abcdef"))
    assert [joint.name for joint in robot.depth_first()] == ["a_b", "b_d", "b_e", "a_c", "c_f"]


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("1e-3", 1e-3),
        ("+1", 1.0),
        (".5", 0.5),
        ("5.", 5.0),
        ("-0", 0.0),
        ("1E+2", 100.0),
        ("007", 7.0),
        ("1.7976931348623157e308", 1.7976931348623157e308),
        ("1e-400", 0.0),
        ("0.1234567890123456789", 0.1234567890123456789),
    ],
)
def test_numbers_are_read_in_every_usual_form(tmp_path: Path, text: str, number: float) -> None:
    for around in ("{}", " {}", "{}\n", "\t {}\r\n "):
        word = around.format(text)
        robot, _ = read(
            tmp_path,
            arm(f'<inertial><mass value="{word}"/></inertial>', f'<origin xyz="{word} 1\n2"/>'),
        )
        part = robot.links["tip"].inertial
        assert part is not None
        assert part.mass == number
        assert robot.joints["turn"].origin.xyz == (number, 1.0, 2.0)


@pytest.mark.parametrize(
    "text",
    [
        b'\xef\xbb\xbf<?xml version="1.0"?><robot name="r"><link name="\xc3\xa4"/></robot>',
        b'<?xml version="1.0" encoding="iso-8859-1"?><robot name="r"><link name="\xe4"/></robot>',
        '<?xml version="1.0"?><robot name="r"><link name="ä"/></robot>'.encode("utf-16"),
        b'<robot name="r"><link name="&#228;"/></robot>',
        '<!DOCTYPE robot><!-- - --><?pi?><robot name="r"><!-- --><link name="ä"/></robot>'.encode(),
        '<robot xmlns="http://ros.org/urdf" name="r"><link name="ä"/></robot>'.encode(),
        '<u:robot xmlns:u="http://ros.org/urdf" name="r"><u:link name="ä"/></u:robot>'.encode(),
        '<robot xmlns:xacro="http://ros.org/wiki/xacro" name="r"><link name="ä"/></robot>'.encode(),
        b'<robot xmlns:s="http://www.w3.org/2001/XMLSchema-instance" s:schemaLocation="x" '
        b'name="r"><link name="\xc3\xa4"/></robot>',
        '<robot name="r">\r\n<link name="ä"/>\r\n</robot>\r\n'.encode(),
        '<robot name="r">\r<link name="ä"/>\r</robot>\r'.encode(),
        '<?xml version="1.0" encoding="UTF-16"?><robot name="r"><link name="ä"/></robot>'.encode(
            "utf-16"
        ),
        '<?xml version="1.0" encoding="UTF-8"?><robot name="r"><link name="ä"/></robot>'.encode(
            "utf-16-le"
        ),
    ],
)
def test_files_are_read_in_any_encoding_and_namespace(tmp_path: Path, text: bytes) -> None:
    robot, diagnostics = read(tmp_path, text)
    assert (robot.name, list(robot.links)) == ("r", ["ä"])
    assert [diagnostic for diagnostic in diagnostics if diagnostic.level != "note"] == []


def test_comments_and_instructions_may_stand_anywhere(tmp_path: Path) -> None:
    noise = "<!-- <mass value='9'/> --><?pi <axis/> ?>"
    text = arm(
        f'<inertial>{noise}<mass value="2">{noise}</mass>{UNIT}</inertial>{noise}<visual>{noise}'
        f'<geometry>{noise}<sphere radius="1"/></geometry></visual>',
        f'{noise}<axis xyz="0 1 0">{noise}</axis>',
    )
    robot, diagnostics = read(tmp_path, text)
    assert diagnostics == []
    assert robot.joints["turn"].axis == (0.0, 1.0, 0.0)
    assert len(robot.links["tip"].visuals) == 1


def test_a_namespace_is_read_to_the_leaves(tmp_path: Path) -> None:
    text = arm(inertial(), '<axis xyz="0 1 0"/>', robot=' xmlns="http://ros.org/urdf"')
    gazebo = "<gazebo><material/></gazebo></robot>"
    robot, diagnostics = read(tmp_path, text.replace("</robot>", gazebo))
    assert diagnostics == []
    assert robot.joints["turn"].axis == (0.0, 1.0, 0.0)
    assert not robot.links["tip"].massless
    assert [extension.tag for extension in robot.extensions] == ["gazebo"]


def test_undeclared_prefixes_of_other_programs_are_kept(tmp_path: Path) -> None:
    text = arm().replace("</robot>", "<gazebo>\n<sensor:camera/></gazebo><a:b/></robot>")
    robot, diagnostics = read(tmp_path, text)
    assert "<sensor:camera/>" in robot.extensions[0].xml
    assert robot.extensions[1].xml == "<a:b/>"
    warnings = [
        (diagnostic.code, diagnostic.line)
        for diagnostic in diagnostics
        if diagnostic.level == "warning"
    ]
    assert warnings == [("xml-namespace", 12)] * 2 + [("mechanics-unread", 12)]


def test_joints_of_other_elements_are_not_the_robots(tmp_path: Path) -> None:
    text = arm().replace(
        "</robot>",
        '<transmission><joint name="turn"/></transmission><gazebo><joint/><link/></gazebo>'
        '<ros2_control><joint name="turn"/></ros2_control></robot>',
    )
    robot, _ = read(tmp_path, text)
    assert list(robot.joints) == ["turn"]
    assert [diagnostic.tag for diagnostic in robot.extensions] == [
        "transmission",
        "gazebo",
        "ros2_control",
    ]


def shaped(geometry: str, more: str = "") -> str:
    return f"<visual><geometry>{geometry}</geometry>{more}</visual>"


#: What is only warned of in the link 'tip': what stands in it, code, and what its message has.
IN_LINK = [
    ("<inertial/>", "inertial-incomplete", "mass"),
    ('<inertial><mass value="1"/></inertial>', "inertial-incomplete", "without <inertia>"),
    ("<visual/>", "geometry-unknown", "visual"),
    ("<collision><geometry/></collision>", "geometry-unknown", "collision"),
    (shaped('<ellipsoid radii="1 1 2"/>'), "geometry-unknown", "ellipsoid"),
    (shaped('<capsule radius="1"/>'), "number-left-out", "length of <capsule>"),
    (shaped("<mesh/>"), "geometry-unknown", "mesh"),
    (shaped('<box size="1 1 -1"/>'), "geometry-size", "box"),
    (shaped('<sphere radius="0"/>'), "geometry-size", "sphere"),
    ('<origin xyz="0 0 1"/>', "mechanics-unread", "<origin> in <link>"),
    ("<origin/>", "mechanics-unread", "<origin> in <link>"),
    ('<spring k="0"><rest/></spring>', "mechanics-unread", "<spring>"),
    ('<origin xyz="0 0 0"/>', "unknown-element", "<origin> in <link>"),
    ("<self_filter><a/></self_filter>", "unknown-element", "<self_filter>.*<link>"),
    (
        inertial().replace("<inertial", '<inertial height="1"'),
        "mechanics-unread",
        "'height' of <inertial> is",
    ),
    (
        shaped('<sphere radius="1"/>').replace("<geometry", '<geometry name="1"'),
        "unknown-attribute",
        "'name' of <geometry> is",
    ),
    (shaped(BOX, '<material name="re"/>'), "material-undefined", "'re'"),
    *(
        (shaped(BOX, f'<material name="a"><color rgba="{rgba}"/></material>'), "color-range", "")
        for rgba in ("255 0 0 1", "0 0 0 1.5", "-0.25 0 0 1")
    ),
    (inertial("0"), "inertia-without-mass", ""),
    (inertial(inertia=moments()), "mass-without-inertia", ""),
    # what the .mbs does not need
    (shaped('<mesh filename="m" scale="1 1 x"/>'), "number-left-out", "a <visual>.*scale"),
    (shaped('<mesh filename="m" scale="1,1,1"/>'), "number-left-out", "a <visual>"),
    (shaped('<mesh filename="m" scale="1 1 1 1"/>'), "number-left-out", "a <visual>.*got 4"),
    (shaped('<mesh filename="m" scale=".001"/>'), "mesh-scale", r"\.001"),
    (shaped(BOX, '<origin rpy="0 0 pi"/>'), "number-left-out", "rpy"),
    (shaped("<box/>"), "number-left-out", "size"),
    (shaped("<sphere/>"), "number-left-out", "radius"),
    (
        shaped('<mesh filename="m" scale="1e-3"/>').replace("visual", "collision"),
        "mesh-scale",
        "1e-3",
    ),
    (
        shaped(BOX, '<origin rpy="0 0 0 1"/>').replace("visual", "collision"),
        "number-left-out",
        "a <collision>",
    ),
]
#: The same in the joint 'turn'.
IN_JOINT = [
    ('<axis xyz="1 0 0" rpy="0 0 0"/>', "unknown-attribute", "'rpy'.*<axis>"),
    ('<axis xyz="1 0 0" rpy="0 1 0"/>', "mechanics-unread", "'rpy'.*<axis>"),
    (
        '<dynamics mu_viscous="3" D="1" K="7000"/>',
        "mechanics-unread",
        "'mu_viscous', 'D', 'K' of <dynamics> are",
    ),
    ('<origin quat_xyzw="0 0 0 1"/>', "mechanics-unread", "quat_xyzw"),
    ('<limits lower="1"/>', "misspelt", "<limits>"),
    ('<limit lower="-1" upper="1" velocty="1"/>', "misspelt", "'velocty'"),
    ('<limit lower="-1" upper="1" velocity="1" gear_velocity="1"/>', "mechanics-unread", "gear_"),
    ('<origin rpy="1 0 0 0"/>', "number-zeros", "Bullet"),
    ('<origin xyz="0, 0, 0.8"/>', "number-commas", "commas"),
    ('<origin xyz="0,0,0.8"/>', "number-commas", "commas"),
    ('<limit lower="x"/>', "number-left-out", "lower"),
    ('<limit lower="-inf" upper="1"/>', "number-left-out", "-inf"),
    ('<dynamics damping="1 1 1"/>', "number-left-out", "damping"),
    ('<calibration rising="x"/>', "number-left-out", "rising"),
    ("<safety_controller/>", "number-left-out", "k_velocity"),
    ('<mimic joint="turn" multiplier="x"/>', "number-left-out", "multiplier"),
    ('<limit lower="-1" upper="1" velocity="nan"/>', "number-left-out", "velocity"),
    ('<dynamics friction="low"/>', "number-left-out", "'low'"),
    ('<safety_controller k_position="0"/>', "number-left-out", "k_velocity"),
]
#: The same after the joint, in the robot; of an inertia (kg m^2); and in other robots, with the
#: line, the link and the joint.
IN_ROBOT = [
    ('<inertial><mass value="1"/></inertial>', "mechanics-unread", "<inertial> in <robot>"),
    ("<jiont/>", "misspelt", "<jiont>"),
    (f"<x:hand {XMLNS.replace(':xacro', ':x')}/>", "xacro-left", "<xacro:hand>"),
    (f"<xacro:hand {XMLNS}/>", "xacro-left", "<xacro:hand>"),
    ('<material name="red"><color rgba="1 0 0"/></material>', "number-left-out", "'red'.*got 3"),
    ('<property name="p" value="1"/>', "property-unused", "'p'"),
]
INERTIAS = [
    ({"ixx": "1", "iyy": "1", "izz": "2.001"}, "inertia-triangle", r"exceeds the sum.*2\.001"),
    ({"ixx": "2", "iyy": "2", "izz": "1", "ixy": "1.5"}, "inertia-triangle", r"0\.5, 1, 3\.5"),
    (
        {"ixx": "1", "iyy": "1", "izz": "1", "ixy": ".3", "ixz": ".3", "iyz": ".3"},
        "inertia-triangle",
        r"0\.7, 0\.7, 1\.6",
    ),
    *(
        (values, "inertia-indefinite", "is below zero.*principal moments.*kg m")
        for values in (
            {"ixx": "-1", "iyy": "1", "izz": "1"},
            {"ixx": "1", "iyy": "1", "izz": "1", "ixy": "1.00001"},
            {"ixx": "1e-6", "iyy": "1e-6", "izz": "1e-6", "iyz": "-2e-6"},
            {"ixx": "1", "iyy": "1", "izz": "-1e-8"},
            {"ixy": "1"},
            # positive diagonal and 2x2 minors, negative determinant
            {"ixx": "1", "iyy": "1", "izz": "1", "ixy": "0.9", "ixz": "-0.9", "iyz": "0.9"},
            {"ixx": "1e200", "iyy": "1e200", "izz": "1e200", "ixy": "2e200"},
            {"ixx": "-1", "iyy": "-1", "izz": "-1"},
            {"ixx": "2", "iyy": "2", "izz": "-2"},
        )
    ),
]
LIMIT = '<limit lower="1" upper="-1" effort="1" velocity="1"/>'
TURN_2 = '<joint name="turn" type="fixed"><parent link="tip"/><child link="end"/></joint>'
WARNED: list[tuple[str, str, str, int, str | None, str | None]] = [
    *((arm(inside), code, words, 5, "tip", None) for inside, code, words in IN_LINK),
    *((arm(joint=inside), code, words, 9, None, "turn") for inside, code, words in IN_JOINT),
    *(
        (arm().replace("</robot>", f"{inside}</robot>"), code, words, 11, None, None)
        for inside, code, words in IN_ROBOT
    ),
    *(
        (arm(inertial(inertia=moments(**values))), code, words, 7, "tip", None)
        for values, code, words in INERTIAS
    ),
    (
        arm(inertial(inertia=UNIT.replace('iyz="0"', ""))),
        "inertia-incomplete",
        "iyz",
        7,
        "tip",
        None,
    ),
    (arm(inertial("-1e-3")), "mass-negative", "-0.001 kg", 6, "tip", None),
    (arm(f"{inertial('1')}\n{inertial('2')}"), "doubled-element", "inertial", 8, "tip", None),
    (
        arm(shaped(f'<sphere radius="1"/>\n{BOX}')),
        "doubled-element",
        "one shape in <geometry>",
        6,
        "tip",
        None,
    ),
    (
        arm(shaped(f'{BOX}\n<origin xyz="1 0 0"/>')),
        "mechanics-unread",
        "<origin> in <geometry>",
        6,
        "tip",
        None,
    ),
    (
        arm(shaped(f'<material name="x"/>\n{BOX}')),
        "unknown-element",
        "<material> in <geometry>",
        5,
        "tip",
        None,
    ),
    (arm(joint='<origin/>\n<origin xyz="1 1 1"/>'), "doubled-element", "origin", 10, None, "turn"),
    (arm(joint=LIMIT, kind="revolute"), "limit-order", r"1\.0.*-1\.0", 9, None, "turn"),
    (arm(kind="revolute"), "joint-limit-missing", "revolute", 7, None, "turn"),
    (arm(kind="prismatic"), "joint-limit-missing", "", 7, None, "turn"),
    (arm(kind="Continuous"), "joint-type-spelling", "", 7, None, "turn"),
    (
        arm().replace("<joint", '<joint id="1"'),
        "unknown-attribute",
        "'id' of <joint> is",
        7,
        None,
        "turn",
    ),
    (
        arm().replace('<link name="tip"', '<link name="tip" type="1"'),
        "unknown-attribute",
        "'type' of <link> is",
        4,
        "tip",
        None,
    ),
    (
        arm().replace("</robot>", f'{TURN_2}<link name="end"/></robot>'),
        "joint-renamed",
        "'turn'",
        11,
        None,
        "turn_2",
    ),
    (arm().replace(' name="arm"', ""), "robot-unnamed", "", 2, None, None),
    (
        arm(shaped(BOX, '<material name="red"/>')).replace(
            "</robot>", '<material name="red"><color rgba="x"/></material></robot>'
        ),
        "number-left-out",
        "'red'",
        11,
        None,
        None,
    ),
    (tree("a >b", links="ab").replace('name="a"', 'name="a "'), "name-blank", "", 2, "a ", None),
    (
        '<robot name="r">\n<link name="a"/>\n<link name="a">\n</link></robot>',
        "doubled-element",
        "",
        3,
        "a",
        None,
    ),
    (tree("a>b", links="abc"), "link-unattached", "", 4, "c", None),
    (tree("world>a", links="a"), "world-implied", "", 3, None, "world_a"),
    (mimics("b>x"), "mimic-left-out", "'x'", 3, None, "b"),
    (mimics("b>b"), "mimic-left-out", "", 3, None, "b"),
    (arm(joint="<mimic/>"), "mimic-left-out", "names no joint", 7, None, "turn"),
]


@pytest.mark.parametrize(("text", "code", "words", "line", "link", "joint"), WARNED)
def test_what_is_only_warned_of(
    tmp_path: Path, text: str, code: str, words: str, line: int, link: str | None, joint: str | None
) -> None:
    (diagnostic,) = read(tmp_path, text)[1]
    assert (diagnostic.code, diagnostic.line, diagnostic.link, diagnostic.joint) == (
        code,
        line,
        link,
        joint,
    )
    assert (diagnostic.file, diagnostic.level) == (str(tmp_path / "robot.urdf"), DEFAULTS[code])
    assert re.search(words, diagnostic.message, re.DOTALL)
    assert (link or joint or "") in diagnostic.message


@pytest.mark.parametrize(
    "text",
    [
        "<robot>{}<link name='tip'/></robot>",
        *map(
            arm,
            (
                "{}",
                "<inertial>{}<mass value='0'/></inertial>",
                "<visual>{}</visual>",
                "<visual><geometry>{}</geometry></visual>",
                "<visual><material name='m'>{}</material></visual>",
                "<collision>{}</collision>",
            ),
        ),
        arm(joint="{}"),
    ],
)
def test_what_xacro_left_is_named_wherever_it_stands(tmp_path: Path, text: str) -> None:
    for element, code in (("xacro:m", "xacro-left"), ("macro", "xacro-legacy")):
        codes = [diagnostic.code for diagnostic in read(tmp_path, text.format(f"<{element}/>"))[1]]
        assert codes.count(code) == 1


def test_the_first_of_two_elements_counts(tmp_path: Path) -> None:
    robot, _ = read(tmp_path, arm(inertial("1") + inertial("2"), '<axis xyz="0 1 0"/><axis/>'))
    assert robot.links["tip"].inertial == Inertial(1.0, (1.0, 0.0, 0.0, 1.0, 0.0, 1.0))
    assert robot.joints["turn"].axis == (0.0, 1.0, 0.0)


def test_incomplete_inertials_are_read_as_ros_reads_them(tmp_path: Path) -> None:
    robot, _ = read(tmp_path, arm('<inertial><origin xyz="1 0 0"/><mass value="2"/></inertial>'))
    assert robot.links["tip"].inertial == Inertial(2.0, origin=Origin((1.0, 0.0, 0.0)))
    robot, _ = read(tmp_path, arm(f"<inertial>{UNIT}</inertial>"))
    assert robot.links["tip"].inertial is None


def test_the_same_warning_is_said_once(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{n}"><remark/><remark/></link>' for n in range(9))
    joints = "".join(
        f'<joint name="j{n}" type="fixed"><parent link="l0"/><child link="l{n}"/></joint>'
        for n in range(1, 9)
    )
    _, diagnostics = read(tmp_path, f'<robot name="r">{links}{joints}</robot>')
    (diagnostic,) = diagnostics
    assert diagnostic.message.endswith("link 'l0', link 'l1', link 'l2', link 'l3' and 5 more")
    assert diagnostic.link is None


def test_joints_that_mimic_one_another_are_free(tmp_path: Path) -> None:
    for pairs, free in ((("a>b", "b>c", "c>a"), "abc"), (("a>b", "b>c", "c>b"), "bc")):
        robot, (diagnostic,) = read(tmp_path, mimics(*pairs))
        assert diagnostic.code == "mimic-left-out"
        assert [name for name, joint in robot.joints.items() if joint.mimic is None] == list(free)


def test_an_element_without_the_prefix_is_an_error_that_can_be_lowered(tmp_path: Path) -> None:
    robot, (diagnostic,) = read(
        tmp_path, '<robot name="r"><link name="a"/>\n<macro name="m"/></robot>'
    )
    assert (diagnostic.level, diagnostic.code, diagnostic.line) == ("error", "xacro-legacy", 2)
    assert "xmlns:xacro" in (diagnostic.hint or "")
    assert list(robot.links) == ["a"]


def test_the_limits_that_can_be_read_stay(tmp_path: Path) -> None:
    limit = '<limit lower="-pi/2" upper="1" effort="inf" velocity="2"/>'
    robot, (reported,) = read(tmp_path, arm(joint=limit, kind="revolute"))
    assert robot.joints["turn"].limit == Limit(None, 1.0, None, 2.0)
    assert "joint 'turn' (lower of <limit> is '-pi/2'" in reported.message
    assert "; effort of <limit> is 'inf'" in reported.message


def test_harmless_slips_of_xml_are_mended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    link = '<robot name="r"><link name="ä"/></robot>'
    latin = f'<?xml version="1.0" encoding="iso-8859-1"?>{link}'.encode("iso-8859-1")
    for text, line in (
        (f'\n\n<?xml version="1.0"?>{link}'.encode(), 3),
        (f'\ufeff <?xml version="1.0"?>{link}'.encode(), 1),
        (f'<!-- licence -->\n<?xml version="1.0"?>{link}'.encode(), 2),
        (f'<?xml version="0.0"?>{link}'.encode(), 1),
        (f"<?xml?>{link}".encode(), 1),
        (f'<?xml version="1.0"?>\n<?xml version="1.0"?>{link}'.encode(), 2),
        (f"<!-- a\n -- b -->{link}".encode(), 1),
        (f"<!-- a --->\n{link}".encode(), 1),
        (f"<!-- <?xml?> -- -->{link}".encode(), 1),
        (f"<!-- a -->\n<!-- <?xml?> -- -->{link}".encode(), 2),
        (b"\n" + latin, 2),
        (b"<!-- 90\xb0 -->" + link.encode(), 1),
        (link.encode() + b"\r\n\0\0", 1),
    ):
        robot, (diagnostic,) = read(tmp_path, text)
        assert (diagnostic.code, diagnostic.line, list(robot.links)) == ("xml-mended", line, ["ä"])
        assert (len(fix_slips(text)[0]) == len(text)) == (text[1:] != latin), (
            "all stays at its place"
        )
    for more in (0, 1):  # libxml2 reads comments of so many letters
        assert len(parse_urdf(f"<!--{'x' * (10**7 + more)}-->{link}".encode(), "r")[1]) == more
    monkeypatch.setattr("urdf2mbs.urdf.xml.MAX_COMMENT", 3)
    _, reported = read(tmp_path, f'<!--\n\nlong-->\n<?xml version="1.0"?>{link}')
    assert [(diagnostic.line, "10,000,000" in diagnostic.message) for diagnostic in reported] == [
        (4, False),
        (1, True),
    ]
    for before, words in (("\n ", "there are blanks"), ("<!-- -->", "there is something")):
        _, (diagnostic,) = read(tmp_path, f'{before}<?xml version="1.0"?>{link}')
        assert words in diagnostic.message
    # what is mended does not hide what is not
    for text, code, line in (
        ("<link>\n</joint></robot>", "xml-syntax", 5),
        ("</robot><!-- a -\n", "xml-truncated", 5),
    ):
        with pytest.raises(ConversionError) as caught:
            read(tmp_path, f'\n<?xml version="1.0"?>\n<robot>\n{text}')
        assert (caught.value.code, caught.value.line) == (code, line)


@pytest.mark.parametrize("kind", ["fixed", "floating"])
@pytest.mark.parametrize("axis", ['<axis xyz="0 0 0"/>', "<axis/>", '<axis xyz="none"/>'])
def test_the_axis_of_a_joint_that_has_none_means_nothing(
    tmp_path: Path, kind: str, axis: str
) -> None:
    assert read(tmp_path, arm(joint=axis, kind=kind))[1] == []


@pytest.mark.parametrize("pairs", [("a>b", "b>c"), ("b>a", "c>b"), ("a>c", "b>c")])
def test_a_mimic_may_follow_a_mimic(tmp_path: Path, pairs: tuple[str, ...]) -> None:
    robot, diagnostics = read(tmp_path, mimics(*pairs))
    assert diagnostics == []
    assert sum(joint.mimic is not None for joint in robot.joints.values()) == 2


def test_materials_defined_in_place_are_known_by_name(tmp_path: Path) -> None:
    def link(name: str, material: str) -> str:
        return (
            f'<link name="{name}"><visual><geometry><sphere radius="1"/></geometry>'
            f"{material}</visual></link>"
        )

    robot, diagnostics = read(
        tmp_path,
        '<robot name="r">'
        + link("early", '<material name="red"/>')
        + link("here", '<material name="red"><color rgba="1 0 0 1"/></material>')
        + link("other", '<material name="red"><color rgba="0.5 0 0 1"/></material>')
        + link("nameless", '<material name=""><color rgba="0 1 0 1"/></material>')
        + link("none", '<material name=""/>')
        + "".join(
            f'<joint name="{n}" type="fixed"><parent link="early"/><child link="{n}"/></joint>'
            for n in ("here", "other", "nameless", "none")
        )
        + "</robot>",
    )
    assert diagnostics == []
    assert robot.materials == {"red": Material("red", (1.0, 0.0, 0.0, 1.0))}
    assert robot.links["early"].visuals[0].material == Material("red")
    assert robot.links["other"].visuals[0].material == Material("red", (0.5, 0.0, 0.0, 1.0))
    assert robot.links["nameless"].visuals[0].material == Material("", (0.0, 1.0, 0.0, 1.0))
    assert robot.links["none"].visuals[0].material is None


def test_materials_of_the_robot(tmp_path: Path) -> None:
    robot, diagnostics = read(
        tmp_path,
        arm().replace(
            "</robot>",
            '<material><color rgba="0 0 0 1"/></material>\n'
            '<material name="a"><color rgba="0 0 0 1"/></material>\n'
            '<material name="a"><color rgba="1 1 1 1"/></material></robot>',
        ),
    )
    assert robot.materials == {"a": Material("a", (0.0, 0.0, 0.0, 1.0))}
    assert [(diagnostic.code, diagnostic.line) for diagnostic in diagnostics] == [
        ("material-unnamed", 11),
        ("doubled-element", 13),
    ]


@pytest.mark.parametrize(
    "values",
    [
        {"ixx": "1", "iyy": "1", "izz": "2"},
        {"ixx": "1", "iyy": "1"},
        {"ixx": "1e-9", "iyy": "2e-9", "izz": "2.9e-9"},
        {"ixx": "1e150", "iyy": "1e150", "izz": "1e150"},
        # a rod along (1, 1, 0): rounding alone may make a moment negative
        {"ixx": "0.5", "iyy": "0.5", "izz": "1", "ixy": "-0.5"},
        {"ixx": "0.1", "iyy": "0.1", "izz": "0.2", "ixy": "-0.1"},
        {"ixx": "2", "iyy": "3", "izz": "4", "ixy": "0.1", "ixz": "-0.2", "iyz": "0.3"},
        # what iCub's generator left of zeros
        {"ixx": "-5.42101e-20", "iyy": "-5.42101e-20"},
        {"ixz": "2.40741e-35"},
        {"ixx": "1", "iyy": "1", "izz": "-1e-12"},
    ],
)
def test_possible_inertias_are_no_fault(tmp_path: Path, values: dict[str, str]) -> None:
    _, diagnostics = read(tmp_path, arm(inertial(inertia=moments(**values))))
    assert [
        diagnostic.code for diagnostic in diagnostics if diagnostic.code != "inertia-triangle"
    ] == []
    if values.get("izz") != "-1e-12":
        assert diagnostics == []


def test_quaternions_of_newer_files_are_read(tmp_path: Path) -> None:
    """With turns about all axes: the sign of each angle counts."""
    half = 0.5**0.5
    turns = [Rotation.from_euler("xyz", turn) for turn in ((0.3, -0.4, 0.5), (-1.2, 0.7, 2.0))]
    for turn in (
        (0.0, 0.0, half, half),
        (2.0, 0.0, 0.0, 0.0),
        (0.0, half, 0.0, half),
        *(turn.as_quat().tolist() for turn in turns),
    ):
        text = " ".join(map(repr, turn))
        origin = f'<origin xyz="1 2 3" quat_xyzw="{text}"/>'
        robot, diagnostics = read(tmp_path, arm(joint=origin, robot=' version="1.1"'))
        origin = robot.joints["turn"].origin
        assert (diagnostics, origin.xyz) == ([], (1.0, 2.0, 3.0))
        wanted = Rotation.from_quat(turn).as_matrix().ravel()
        np.testing.assert_allclose(origin.pose.rot, wanted, rtol=0, atol=1e-15)
    for wrong in ('quat_xyzw="0 0 0 0"', 'quat_xyzw="0 0 0 1" rpy="0 0 0"', 'quat_xyzw="0 0 1"'):
        with pytest.raises(ConversionError, match="quat_xyzw"):
            read(tmp_path, arm(joint=f"<origin {wrong}/>", robot=' version="1.2"'))


def test_a_robot_without_a_name_is_called_after_its_file(tmp_path: Path) -> None:
    robot, _ = read(tmp_path, '<robot><link name="a"/></robot>')
    assert robot.name == "robot"


def test_arguments_for_a_plain_file_are_warned_of(tmp_path: Path) -> None:
    source = tmp_path / "robot.urdf"
    source.write_text(arm())
    _, diagnostics = read_robot(source, Packages({}, source), {"b": "1", "a": "2"})
    assert [diagnostic.code for diagnostic in diagnostics] == ["xacro-unused-arg"]
    assert "a, b" in diagnostics[0].message


def test_an_error_of_another_file_is_not_remembered(tmp_path: Path) -> None:
    """libxml2's log of errors is global; a file cut off must not colour the next one."""
    for text, code in (
        ('<robot name="r">\n<link', "xml-truncated"),
        ('<robot name="r">\n<a:b/></robot>', "no-links"),
        ("<robot>\n<link>\n</joint></robot>", "xml-syntax"),
    ):
        with pytest.raises(ConversionError) as caught:
            read(tmp_path, text)
        assert caught.value.code == code


@pytest.mark.parametrize("chain", [True, False])
def test_thousands_of_links_in_a_row_or_on_one_are_converted(chain: bool) -> None:
    parts = ['<robot name="r"><link name="l0"/>']
    parts += [
        f'<link name="l{n}">\n{inertial()}</link>\n<joint name="j{n}" type="continuous">\n'
        f'<parent link="l{n - 1 if chain else 0}"/>\n<child link="l{n}"/></joint>'
        for n in range(1, 2000)
    ]
    result = convert_text("".join([*parts, "</robot>"]))
    assert len(result.mbs.bodies) >= 1999
    assert result.conversion.checked.proof is not None
    assert result.conversion.checked.proof.same


def test_a_loop_and_roots_among_a_thousand_links_are_found() -> None:
    names = [f"l{n}" for n in range(1000)]
    chain = [f"{a}>{b}" for a, b in pairwise(names)]
    links = "".join(f'<link name="{name}"/>' for name in names)
    fixed = '<joint name="{0}_{1}" type="fixed"><parent link="{0}"/><child link="{1}"/></joint>'
    for joints, code in (([*chain, "l999>l0"], "loop"), (chain[::2], "several-roots")):
        inside = "".join(fixed.format(*joint.split(">")) for joint in joints)
        with pytest.raises(ConversionError) as caught:
            parse_urdf(f'<robot name="r">{links}{inside}</robot>'.encode(), "r")
        assert caught.value.code == code
        assert len(caught.value.message) < 500


def test_numbers_that_an_element_does_not_state_have_their_defaults(tmp_path: Path) -> None:
    parts = '<dynamics/><limit/><calibration/><safety_controller k_velocity="2"/>'
    turn = read(tmp_path, arm(joint=parts))[0].joints["turn"]
    assert (turn.dynamics.damping, turn.dynamics.friction) == (0.0, 0.0)
    limit, marks, safety = turn.limit, turn.calibration, turn.safety_controller
    assert (limit.lower, limit.upper, limit.effort, limit.velocity) == (0.0, 0.0, None, None)
    assert (marks.rising, marks.falling) == (None, None)
    assert (safety.k_position, safety.soft_lower_limit, safety.soft_upper_limit) == (0.0, 0.0, 0.0)
    mimic = read(tmp_path, mimics("b>a"))[0].joints["b"].mimic
    assert (mimic.multiplier, mimic.offset) == (1.0, 0.0)
    assert (Inertial().mass, Inertial().inertia) == (0.0, (0.0,) * 6)
    assert Mesh("m").scale == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("robot_name", "file", "title", "file_name"),
    [
        ("a1", "robot.xacro", "a1", "a1"),
        ("ur5e", "ur.urdf.xacro", "ur5e", "ur5e"),
        ("iCub", "model.urdf", "iCub", "iCub"),
        # the name of the file says more
        ("talos", "talos_reduced.urdf", "talos", "talos_reduced"),
        ("2dof_planar", "2DofPlanar_2.urdf", "2dof_planar", "2DofPlanar_2"),
        # placeholders
        ("robot", "lab_arm.urdf", "lab_arm", "lab_arm"),
        ("MyRobot", "lab_arm.urdf", "lab_arm", "lab_arm"),
        ("MuJoCo Model", "go1.xml", "go1", "go1"),
        ("", "go1.xml", "go1", "go1"),
        ("robot_2", "robot.urdf", "robot", "robot"),
        # names that no file can have
        ("my arm/left", "model.urdf", "my arm/left", "my_arm_left"),
        ("../..", "arm.urdf", "arm", "arm"),
        ("con", "arm.urdf", "con", "arm"),
    ],
)
def test_a_robot_is_called_by_its_name(
    robot_name: str, file: str, title: str, file_name: str
) -> None:
    assert choose_title(robot_name, Path(file)) == title
    assert choose_file_name(robot_name, Path(file)) == file_name
