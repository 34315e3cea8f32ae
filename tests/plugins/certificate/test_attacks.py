"""Attacks on the replay of certificates: files that say another thing than they seem to say.

None of them is "the same robot" without a word.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from support.certificates import made, replay

BODY = (
    '<inertial><origin xyz="0.1 0 0.02"/><mass value="2"/>'
    '<inertia ixx="0.03" ixy="0.001" ixz="0" iyy="0.04" iyz="0" izz="0.05"/></inertial>'
)
#: A robot with all six types of joints.
ROBOT = f"""<?xml version="1.0"?>
<!-- a licence -->
<robot name="all">
  <link name="foot"/>
  <link name="upper">{BODY}</link>
  <link name="wheel">{BODY}</link>
  <link name="slide">{BODY}</link>
  <link name="sheet">{BODY}</link>
  <link name="kite">{BODY}</link>
  <link name="finger">{BODY}</link>
  <link name="tool"/>
  <joint name="hip" type="revolute"><parent link="foot"/><child link="upper"/>
    <origin xyz="0 0.1 0.4" rpy="0 0.25 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1.5" effort="30" velocity="4"/>
    <dynamics damping="0.5" friction="0.25"/></joint>
  <joint name="roll" type="continuous"><parent link="upper"/><child link="wheel"/>
    <origin xyz="0.3 0 0"/><axis xyz="0 0 2"/><limit effort="3" velocity="9"/></joint>
  <joint name="push" type="prismatic"><parent link="upper"/><child link="slide"/>
    <origin xyz="0 0.2 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.2" effort="5" velocity="1"/></joint>
  <joint name="lie" type="planar"><parent link="foot"/><child link="sheet"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="fly" type="floating"><parent link="foot"/><child link="kite"/>
    <origin xyz="0 0 2"/></joint>
  <joint name="grip" type="revolute"><parent link="slide"/><child link="finger"/>
    <origin xyz="0 0 0.1"/><axis xyz="0 0 1"/><mimic joint="hip" multiplier="2"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="mount" type="fixed"><parent link="finger"/><child link="tool"/>
    <origin xyz="0 0 0.05" rpy="0.5 0 0"/></joint>
  <gazebo><axis><xyz>1 0 0</xyz></axis></gazebo>
</robot>
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, bytes, Any]:
    """Return the URDF, the .mbs and the certificate of a robot with all types of joints."""
    return made(ROBOT, tmp_path_factory.mktemp("robot"), base="fixed")


AXIS = '<axis xyz="0 1 0"/>'
BASE = "<bodytree>"
HIP = '<joint name="hip" type="revolute">'
#: A file, what is replaced in it (once), by what, and the end: a refusal, another robot, or words
#: that must then be among those behind "the same robot, but for".
ATTACKS: Any = {
    # the URDF: what stands before the root
    "a DOCTYPE": ("urdf", "<!-- a licence -->", "<!DOCTYPE robot>", 1),
    "an entity": ("urdf", "<!-- a licence -->", '<!DOCTYPE r [<!ENTITY a "2">]>', 1),
    "another robot in a comment": ("urdf", "a licence", f"<robot>{HIP}</robot>", 0),
    "a second declaration": ("urdf", "<!-- a licence -->", '<?xml version="1.0"?>', 1),
    "an instruction": ("urdf", "<!-- a licence -->", "<?other robot?>", 1),
    "an instruction within": ("urdf", AXIS, f"<?x?>{AXIS}", 1),
    "text before the root": ("urdf", "<?xml", "x<?xml", 1),
    "text behind the root": ("urdf", "</robot>", "</robot>x", 1),
    "two roots": ("urdf", "</robot>", "</robot><robot/>", 1),
    "another root": ("urdf", "<robot ", "<sdf><robot ", 1),
    "a declaration in CDATA": (
        "urdf",
        "<robot ",
        '<robot name="x"><![CDATA[<?xml version="1.0"?>]]></robot><robot ',
        1,
    ),
    "a namespace": ("urdf", "<robot ", '<robot xmlns="http://x" ', 1),
    "a namespace within": ("urdf", AXIS, '<axis xmlns="http://x" xyz="1 0 0"/>', 1),
    # the URDF: doubled
    "two axes": ("urdf", AXIS, f'<axis xyz="1 0 0"/>{AXIS}', 1),
    "two axes, turned": ("urdf", AXIS, f'{AXIS}<axis xyz="1 0 0"/>', 1),
    "two origins of a joint": (
        "urdf",
        '<origin xyz="0 0.2 0"/>',
        '<origin/><origin xyz="0 0.2 0"/>',
        1,
    ),
    "two inertials": ("urdf", "</inertial>", f"</inertial>{BODY}", 1),
    "two origins of an inertial": ("urdf", '<mass value="2"/>', '<origin/><mass value="2"/>', 1),
    "two masses": ("urdf", '<mass value="2"/>', '<mass value="2"/><mass value="3"/>', 1),
    "two inertias": ("urdf", "<inertia ", '<inertia ixx="1"/><inertia ', 1),
    "two limits": (
        "urdf",
        '<limit lower="-1" upper="1.5"',
        '<limit/><limit lower="-1" upper="1.5"',
        1,
    ),
    "two parents": (
        "urdf",
        '<parent link="upper"/>',
        '<parent link="foot"/><parent link="upper"/>',
        1,
    ),
    "two mimics": ("urdf", "<mimic ", '<mimic joint="roll"/><mimic ', 1),
    "two links of a name": (
        "urdf",
        '<link name="foot"/>',
        '<link name="foot"/><link name="foot"/>',
        1,
    ),
    "two joints of a name": ("urdf", '<joint name="roll"', '<joint name="hip"', 1),
    # the URDF: no tree
    "a cycle": (
        "urdf",
        '<parent link="upper"/><child link="slide"/>',
        '<parent link="finger"/><child link="slide"/>',
        1,
    ),
    "a link below itself": ("urdf", '<parent link="finger"/>', '<parent link="tool"/>', 1),
    "a cycle of fixed joints behind the root": (
        "urdf",
        "</robot>",
        """
        <joint name="there" type="fixed"><parent link="tool"/><child link="tip"/></joint>
        <link name="tip"/>
        <joint name="back" type="fixed"><parent link="tip"/><child link="tool"/></joint>
        </robot>""",
        1,
    ),
    "a link that hangs twice": ("urdf", '<child link="kite"/>', '<child link="sheet"/>', 1),
    "a second root": ("urdf", '<link name="foot"/>', '<link name="foot"/><link name="more"/>', 1),
    "a link that is not there": ("urdf", '<child link="tool"/>', '<child link="tol"/>', 1),
    "a parent that is not there": ("urdf", '<parent link="finger"/>', '<parent link="thumb"/>', 1),
    "no child": ("urdf", '<child link="tool"/>', "", 1),
    "no parent": ("urdf", '<parent link="finger"/>', "", 1),
    # the URDF: unknown
    "an unknown type": ("urdf", 'type="fixed"', 'type="ball"', 1),
    "a type with a blank": ("urdf", 'type="fixed"', 'type=" fixed"', 1),
    "no type": ("urdf", ' type="fixed"', "", 1),
    "an element in a joint": ("urdf", AXIS, f"{AXIS}<armature/>", 1),
    "an element in a link": ("urdf", '<link name="foot"/>', '<link name="foot"><mass/></link>', 1),
    "an element in the robot": ("urdf", '<link name="foot"/>', '<link name="foot"/><origin/>', 1),
    "an element in an axis": ("urdf", AXIS, '<axis xyz="0 1 0"><xyz/></axis>', 1),
    "a misspelt element": ("urdf", AXIS, '<Axis xyz="0 1 0"/>', 1),
    "a misspelt attribute": ("urdf", "multiplier", "mutiplier", "mutiplier='2'"),
    "a quaternion": (
        "urdf",
        '<origin xyz="0 0.2 0"/>',
        '<origin xyz="0 0.2 0" quat_xyzw="1 0 0 0"/>',
        "quat_xyzw",
    ),
    "xacro": ("urdf", '<mass value="2"/>', '<mass value="${2}"/>', 1),
    # the URDF: numbers
    **{
        f"a mass of {mass!r}": ("urdf", '<mass value="2"/>', f'<mass value="{mass}"/>', 1)
        for mass in ("nan", "inf", "1e999", "0x2", "2_0", "\u0662", "2,0", "", "2 2", "-2")
    },
    "four numbers in an axis": ("urdf", AXIS, '<axis xyz="0 1 0 0"/>', 1),
    "two numbers in an axis": ("urdf", AXIS, '<axis xyz="0 1"/>', 1),
    "six numbers in an origin": ("urdf", 'xyz="0 0.2 0"', 'xyz="0 0.2 0 0 0 0"', 1),
    "commas": ("urdf", AXIS, '<axis xyz="0, 1, 0"/>', 1),
    "a blank that is none": ("urdf", AXIS, '<axis xyz="0\u00a01 0"/>', 1),
    "a limit that is no number": ("urdf", 'upper="1.5"', 'upper="inf"', 1),
    # the URDF: another robot
    "an axis of zero": ("urdf", AXIS, '<axis xyz="0 0 0"/>', 3),
    "an axis turned round": ("urdf", AXIS, '<axis xyz="0 -1 0"/>', 3),
    "a tilted axis": ("urdf", AXIS, '<axis xyz="0 1 1e-6"/>', 3),
    "no axis": ("urdf", AXIS, "", 3),
    "the axis of Gazebo": ("urdf", "<gazebo>", '<gazebo reference="hip">', 0),
    "a fixed joint": ("urdf", 'type="continuous"', 'type="fixed"', 1),
    "a joint that shifts": ("urdf", 'type="continuous"', 'type="prismatic"', 3),
    "the plane": (
        "urdf",
        '<origin xyz="1 0 0"/><axis xyz="0 0 1"/>',
        '<origin xyz="1 0 0"/><axis xyz="0 1 0"/>',
        1,
    ),
    "the kite elsewhere": ("urdf", '<origin xyz="0 0 2"/>', '<origin xyz="0 0 2.5"/>', 3),
    "a shift beside the axis": ("urdf", 'xyz="0 0.1 0.4"', 'xyz="0 0.1 0.400001"', 3),
    "a shift along the axis": ("urdf", 'xyz="0 0.1 0.4"', 'xyz="0 0.100001 0.4"', 3),
    "a shift by far": ("urdf", 'xyz="0 0.1 0.4"', 'xyz="0.001 1e9 0.4"', 3),
    "another zero": ("urdf", 'rpy="0 0.25 0"', 'rpy="0 0.250001 0"', 3),
    "another parent": (
        "urdf",
        '<parent link="upper"/><child link="slide"/>',
        '<parent link="foot"/><child link="slide"/>',
        3,
    ),
    "another mass": ("urdf", '<mass value="2"/>', '<mass value="2.000001"/>', 3),
    "no mass": ("urdf", '<mass value="2"/>', "", 3),
    "another product of inertia": ("urdf", 'ixy="0.001"', 'ixy="-0.001"', 3),
    "another centre": ("urdf", 'xyz="0.1 0 0.02"', 'xyz="0.1 0 0.020001"', 3),
    "a turned inertia": ("urdf", 'xyz="0.1 0 0.02"', 'xyz="0.1 0 0.02" rpy="1e-6 0 0"', 3),
    "another limit": ("urdf", 'upper="1.5"', 'upper="1.6"', 3),
    "a limit more": (
        "urdf",
        '<limit effort="3"',
        '<limit lower="-1" effort="3"',
        "q_min of 'roll': None, and -1.0 in the URDF",
    ),
    "another effort": ("urdf", 'effort="30"', 'effort="31"', 3),
    "another speed": ("urdf", 'velocity="4"', 'velocity="5"', 3),
    "another damping": ("urdf", 'damping="0.5"', 'damping="0.6"', 3),
    "no friction": ("urdf", 'friction="0.25"', "", 3),
    "free, and no mimic": ("urdf", '<mimic joint="hip" multiplier="2"/>', "", 0),
    # the .mbs
    "a DOCTYPE of the .mbs": ("mbs", "<mbsDescR7>", "<!DOCTYPE mbsDescR7><mbsDescR7>", 1),
    "another root of the .mbs": ("mbs", "mbsDescR7", "mbsDescR6", 1),
    "two bodies of a name": ("mbs", "<bodyname>wheel</bodyname>", "<bodyname>upper</bodyname>", 1),
    "a body called base": ("mbs", "<bodyname>wheel</bodyname>", "<bodyname>base</bodyname>", 1),
    "two joints of a name in the .mbs": ("mbs", ">roll<", ">hip<", 1),
    "two masses of a body": ("mbs", "<mass>2.0</mass>", "<mass>3.0</mass><mass>2.0</mass>", 1),
    "two types": ("mbs", "<type>R2</type>", "<type>R1</type><type>R2</type>", 1),
    "two bases": ("mbs", BASE, f"<base/>{BASE}", 1),
    "two trees": ("mbs", "</bodytree>", "</bodytree><bodytree/>", 1),
    "gravity twice": ("mbs", "<gravity>", "<gravity/><gravity>", 1),
    "an unknown element": ("mbs", "<mass>2.0</mass>", "<mass>2.0</mass><Mass>3.0</Mass>", 1),
    "an unknown type in the .mbs": ("mbs", "<type>R2</type>", "<type>R4</type>", 1),
    "a type of two joints": ("mbs", "<type>R2</type>", "<type>R23</type>", 1),
    "an unknown nature": ("mbs", "<nature>independent</nature>", "<nature>free</nature>", 3),
    "an unknown parent": ("mbs", "<bodyname>upper</bodyname>", "<bodyname>uper</bodyname>", 1),
    "a mass of nan": ("mbs", "<mass>2.0</mass>", "<mass>nan</mass>", 1),
    "a mass below zero": ("mbs", "<mass>2.0</mass>", "<mass>-2.0</mass>", 1),
    "a comment in a number": ("mbs", "<mass>2.0</mass>", "<mass>2.0<!-- -->1</mass>", 3),
    "an element in a number": ("mbs", "<mass>2.0</mass>", "<mass>2.0<x>1</x></mass>", 1),
    "another mass in the .mbs": ("mbs", "<mass>2.0</mass>", "<mass>2.5</mass>", 3),
    "no mass in the .mbs": ("mbs", "<mass>2.0</mass>", "", 3),
    "gravity of nan": ("mbs", "-9.81", "nan", 1),
    "another gravity": ("mbs", "-9.81", "-9.80665", 3),
    "gravity the other way": ("mbs", "-9.81", "9.81", 3),
    "another axis in the .mbs": ("mbs", "<type>R2</type>", "<type>R1</type>", 3),
    "a turn for a shift": ("mbs", "<type>T1</type>", "<type>R1</type>", 3),
    "driven": ("mbs", "<nature>independent</nature>", "<nature>driven</nature>", 3),
    "dependent": (
        "mbs",
        "<nature>independent</nature>",
        "<nature>dependent</nature>",
        ": 'dependent', and 'independent' in the URDF",
    ),
    "another limit in the .mbs": ("mbs", "<value>1.5</value>", "<value>1.6</value>", 3),
    "a limit of nan": ("mbs", "<value>1.5</value>", "<value>nan</value>", 1),
    "two values": ("mbs", "<value>1.5</value>", "<value>1.5</value><value>2</value>", 1),
    "another user model": (
        "mbs",
        "<name>effort</name>",
        "<name>power</name>",
        "effort of 'hip': None, and 30.0 in the URDF",
    ),
    "limits at one end": ("mbs", "<name>q_max</name>", "<name>q_most</name>", 1),
    "two user models of a name": ("mbs", "<name>q_max</name>", "<name>q_min</name>", 1),
    "a cut": (
        "mbs",
        "</bodytree>",
        "</bodytree><cuts><rod><name>r</name></rod></cuts>",
        "rod of 'r'",
    ),
    # the certificate
    "no map": ("map", None, "[]", 1),
    "no JSON": ("map", None, "{", 1),
    "deep JSON": ("map", None, "[" * 100_000, 1),
    "joints exchanged": ("map", {"joints": {"hip": ["roll"], "roll": ["hip"]}}, None, 3),
    "a joint twice": ("map", {"joints": {"roll": ["hip"]}}, None, 1),
    "a joint of no name": ("map", {"joints": {"roll": [""]}}, None, 1),
    "a joint that is not there": ("map", {"joints": {"roll": ["rol"]}}, None, 1),
    "two coordinates for one": ("map", {"joints": {"roll": ["roll", "push"]}}, None, 1),
    "coordinates of a fixed joint": ("map", {"joints": {"mount": ["push"]}}, None, 1),
    "a joint left out": ("map", {"joints": {"hip": []}}, None, 3),
    "no right angles": ("map", {"planes": {"lie": [[1, 0, 0], [1, 1, 0]]}}, None, 1),
    "axes of nan": ("map", {"planes": {"lie": [[1, 0, 0], [float("nan")] * 3]}}, None, 1),
    "axes out of the plane": ("map", {"planes": {"lie": [[1, 0, 0], [0, 0, 1]]}}, None, 1),
}


@pytest.mark.parametrize("name", ATTACKS)
def test_no_attack_is_the_same_robot_without_a_word(
    name: str, files: Any, tmp_path: Path, capsys: Any
) -> None:
    which, old, new, end = ATTACKS[name]
    urdf, mbs, certificate = files[0].decode(), files[1].decode(), json.loads(json.dumps(files[2]))
    if which == "urdf":
        assert old in urdf
        urdf = urdf.replace(old, new, 1)
    elif which == "mbs":
        assert old in mbs
        mbs = mbs.replace(old, new, 1)
    elif old is None:
        certificate = new
    else:
        for key, value in old.items():
            certificate[key] = {**certificate[key], **value} if isinstance(value, dict) else value
    output = replay(urdf.encode(), mbs.encode(), certificate, tmp_path, capsys)
    if isinstance(end, str):
        assert end in output.out
        assert output.code == 0
        assert output.out.startswith("the same robot, but for:")
    else:
        assert output.code == end, output.out + output.error
