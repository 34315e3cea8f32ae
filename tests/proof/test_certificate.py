"""The replay of certificates: it says "the same robot" of the same robot, and of no other."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from proof.test_not_fooled import PLANTS
from proof.test_planted import PLANTED
from proof.test_words import FOUND, MIMIC, TINY, WORLD
from robots import CONVERTIBLE, RealRobot

from urdf2mbs import Result, convert
from urdf2mbs.mbs.model import Joint, Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs.proof import certificate as checker

CHECKER = Path(checker.__file__)
CONFIGS = Path(__file__).parents[2] / "configs"
ALWAYS = {"certificate": {"write": "always"}}
#: Lines of code, without docstrings, comments and empty lines.
LONGEST = 200
FILES = ("robot.urdf", "model.mbs", "model.proof.json")


class Said:
    """What the replay says of three files."""

    def __init__(self, code: int, out: str, error: str) -> None:
        self.code, self.out, self.error = code, out, error
        self.plain = out == "the same robot\n"


def replay(urdf: bytes, mbs: bytes, said: Any, folder: Path, capsys: Any) -> Said:
    files = [folder / name for name in FILES]
    text = said if isinstance(said, str) else json.dumps(said)
    for file, data in zip(files, (urdf, mbs, text.encode()), strict=True):
        file.write_bytes(data)
    capsys.readouterr()
    code = checker.main([str(file) for file in files])
    out = capsys.readouterr()
    assert out.err.count("\n") == (code == 1), "one line says why a file is refused"
    assert code in (0, 1, 3)
    assert out.out.startswith("the same robot") == (code == 0)
    assert out.out.startswith("NOT the same robot") == (code == 3)
    return Said(code, out.out, out.err)


def files_of(result: Result) -> tuple[bytes, bytes, Any]:
    """The URDF, the .mbs and its certificate."""
    conversion = result.conversion
    path = conversion.settings.output.with_suffix(".proof.json")
    return conversion.expanded or conversion.source, result.data, json.loads(conversion.files[path])


def made(text: str, folder: Path, **settings: Any) -> tuple[bytes, bytes, Any]:
    source = folder / "tiny.urdf"
    source.write_text(text)
    return files_of(convert(source, **{"passes": ALWAYS, **settings}))


def test_it_is_one_short_file_of_the_standard_library() -> None:
    text = CHECKER.read_text("utf-8")
    tree = ast.parse(text)
    said = {
        number
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        for number in range(node.lineno, (node.end_lineno or 0) + 1)
    }
    code = [
        line
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#") and number not in said
    ]
    assert len(code) <= LONGEST
    names = {
        name.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, (ast.Import, ast.ImportFrom))
        for name in [getattr(node, "module", None) or node.names[0].name]
    }
    assert names <= sys.stdlib_module_names


# --- the same robot -----------------------------------------------------------------------------


@pytest.mark.parametrize("pipeline", ["faithful", "compact"])
@pytest.mark.parametrize("name", ["arm", "biped", "hexapod"])
def test_our_robots_are_the_same(name: str, pipeline: str, tmp_path: Path, capsys: Any) -> None:
    result = convert(CONFIGS / f"{name}.urdf.xacro", pipeline=pipeline, passes=ALWAYS)
    assert replay(*files_of(result), tmp_path, capsys).code == 0


@pytest.mark.slow
@pytest.mark.parametrize("pipeline", ["faithful", "compact"])
@pytest.mark.parametrize("robot", CONVERTIBLE)
def test_real_robots_are_the_same(
    robot: RealRobot, pipeline: str, tmp_path: Path, capsys: Any
) -> None:
    result = robot.convert(pipeline=pipeline, passes=ALWAYS)
    assert replay(*files_of(result), tmp_path, capsys).code == 0


def test_it_runs_alone(tmp_path: Path, capsys: Any) -> None:
    files = made(TINY, tmp_path, base="fixed")
    said = replay(*files, tmp_path, capsys)
    (tmp_path / "alone").mkdir()
    (tmp_path / "alone" / "certificate.py").write_bytes(CHECKER.read_bytes())
    done = subprocess.run(
        [sys.executable, "-I", "certificate.py", *(f"../{name}" for name in FILES)],
        cwd=tmp_path / "alone", capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, said.out.replace("\r", ""))
    for files in ((), ("missing.urdf", *FILES[1:])):
        done = subprocess.run(
            [sys.executable, CHECKER, *files], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stdout) == (1, "")
        assert "Traceback" not in done.stderr


HANDLESS = re.sub(r'(?s)(<link name="hand">\s*)<inertial>.*?</inertial>', r"\1", TINY)
#: Robots, how they are converted, and what the replay says beside "the same robot".
SAME: Any = {
    "fixed": (TINY, {"base": "fixed"}, []),
    "floating": (TINY, {"base": "floating"}, ['<joint name="floating_base" type="floating">']),
    "world": (WORLD, {}, []),
    "a world that is not declared": (WORLD.replace('<link name="world"/>', ""), {}, []),
    "mimic": (MIMIC, {}, ["nature of 'wrist_pitch': 'independent', and 'follower'"]),
    "mimic in a project": (MIMIC, {"output": {"project": "p"}},
                           ["nature of 'wrist_pitch': 'dependent', and 'follower'"]),
    "mimic by force": (MIMIC, {"output": {"project": "p"}, "passes": {
        "mimic": {"joints": {"*": "driven"}}}},
        ["nature of 'wrist_pitch': 'driven', and 'follower'"]),
    "held": (HANDLESS, {"base": "fixed"}, ["joint 'wrist_pitch' is held at zero: '"]),
    "estimate-inertia": (HANDLESS, {"output": {"project": "p"}, "passes": {
        "estimate-inertia": {"density": 1000.0}}}, ["<link> 'hand' has '<inertial>"]),
    "rotors": (TINY, {"output": {"project": "p"}, "passes": {
        "rotors": {"armature": {"wrist_roll": 0.1}}}}, ['<link name="wrist_roll_rotor"']),
    "snap": (TINY, {"output": {"project": "p"}, "passes": {"snap": {"angle": 1e-3}}},
             ["<joint> 'tool_mount' has '<origin ", "on purpose, and '<origin "]),
    "a rod": (TINY, {"base": "fixed", "passes": {**ALWAYS, "loops": {"cuts": {"rod": {
        "kind": "rod", "length": 0.5,
        "ends": [{"link": "body"}, {"link": "tool", "at": [0, 0, 1]}]}}}}},
        ["rod of '", "'dependent', and 'independent'"]),
    "the moon": (TINY, {"gravity": [0, 0, -1.62]}, ["gravity of 'base': (0.0, 0.0, -1.62)"]),
    "no damping": (TINY, {"without": ["joint-parameters"]}, ["damping of 'shoulder': None, and"]),
    "unknown attributes": (TINY.replace('<axis xyz="0 1 1"/>', '<axis xyz="0 1 1" rpy="0 0 1"/>'),
                           {}, ["rpy='0 0 1'"]),
    "blank lines first": (f"\n\n{TINY}", {}, []),
    "a mark of byte order": (f"\ufeff{TINY}", {}, []),
    **{kind: (TINY.replace('name="wrist_pitch" type="revolute"',
                           f'name="wrist_pitch" type="{kind}"'), {}, [])
       for kind in ("planar", "floating", "prismatic", "continuous")},
}  # fmt: skip


@pytest.mark.parametrize("pipeline", ["faithful", "compact"])
@pytest.mark.parametrize("name", SAME)
def test_the_same(name: str, pipeline: str, tmp_path: Path, monkeypatch: Any, capsys: Any) -> None:
    text, settings, known = SAME[name]
    monkeypatch.chdir(tmp_path)
    said = replay(*made(text, tmp_path, pipeline=pipeline, **settings), tmp_path, capsys)
    assert said.code == 0
    for words in known:
        assert words in said.out


def test_a_long_chain(tmp_path: Path, capsys: Any) -> None:
    """Nothing is called once for each link of a chain within the one before it."""
    inertial = '<inertial><mass value="1"/></inertial>'
    urdf = mbs = ""
    for n in range(1, 1300):
        urdf += f'<link name="l{n}">{inertial}</link><joint name="j{n}" type="continuous">'
        urdf += f'<parent link="l{n - 1}"/><child link="l{n}"/><origin xyz="0.1 0 0"/></joint>'
        parent = f"<bodyname>l{n - 1}</bodyname><pointname>end</pointname>"
        mbs += f"<body><bodyname>l{n}</bodyname><parent>{parent}</parent>"
        mbs += f"<joint><jointname>j{n}</jointname><type>R1</type><nature>independent</nature>"
        mbs += f"</joint><mass>1</mass>{END}</body>"
    base = f"<base><gravity><coordinates><z>-9.81</z></coordinates></gravity>{END}</base>"
    mbs = mbs.replace("<bodyname>l0<", "<bodyname>base<")
    said = {"joints": {f"j{n}": [f"j{n}"] for n in range(1, 1300)}}
    nothing = {"planes": {}, "held": {}, "changes": [], "edited": []}
    found = replay(
        f'<robot name="long"><link name="l0"/>{urdf}</robot>'.encode(),
        f"<mbsDescR7>{base}<bodytree>{mbs}</bodytree></mbsDescR7>".encode(),
        {**said, **nothing, "gravity": [0.0, 0.0, -9.81]}, tmp_path, capsys,
    )  # fmt: skip
    assert found.plain, found.error


END = "<point><pointname>end</pointname><coordinates><x>0.1</x></coordinates></point>"


def test_what_people_edited_is_named(tmp_path: Path, capsys: Any) -> None:
    source, model = tmp_path / "tiny.urdf", tmp_path / "p" / "dataR" / "p.mbs"
    source.write_text(TINY)
    convert(source, output={"project": tmp_path / "p"}).write()
    mbs = read(model.read_bytes(), "p.mbs")
    mbs.bodies[-1].mass = 7.0
    next(m for m in mbs.user_models if m.name == "q_max").parameters[0].values = ("0.25",)
    mbs.bodies[-1].joints.append(Joint("spin", "R1", "independent"))
    model.write_bytes(write(mbs))
    result = convert(source, output={"project": tmp_path / "p"})
    files = files_of(result)
    said = replay(*files, tmp_path, capsys)
    assert said.code == 0
    for words in ("mass or inertia of 'wrist_pitch'", "q_max of ", "motion of 'spin'"):
        assert re.search(f"{words}.*as edited", said.out), words
    files[2]["edited"] = []
    assert replay(*files, tmp_path, capsys).code == 3


# --- another robot ------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["faithful", "compact"])
def biped(request: pytest.FixtureRequest) -> tuple[bytes, bytes, Any]:
    return files_of(convert(CONFIGS / "biped.urdf.xacro", pipeline=request.param, passes=ALWAYS))


def is_found(
    files: tuple[bytes, bytes, Any], plant: Callable[[Mbs], None], folder: Path, capsys: Any
) -> bool:
    """True if the replay fails, or says what it does not say without the fault."""
    before = replay(*files, folder, capsys).out
    mbs = read(files[1], "model.mbs")
    plant(mbs)
    said = replay(files[0], write(mbs), files[2], folder, capsys)
    return said.code != 0 or not {*said.out.splitlines()} <= {*before.splitlines()}


@pytest.mark.parametrize("fault", PLANTED)
def test_a_planted_fault_is_found(fault: str, biped: Any, tmp_path: Path, capsys: Any) -> None:
    assert is_found(biped, PLANTED[fault][0], tmp_path, capsys)


@pytest.mark.parametrize("fault", FOUND)
def test_a_fault_of_natures_and_cuts_is_found(fault: str, tmp_path: Path, capsys: Any) -> None:
    text, base, plant, _ = FOUND[fault]
    if text == WORLD:  # the certificate is of the robot that stands; the .mbs floats
        floats = made(text, tmp_path, base=base)[1]
        urdf, _, said = made(text, tmp_path)
        assert replay(urdf, floats, said, tmp_path, capsys).code == 3
    else:
        assert is_found(made(text, tmp_path, base=base), plant, tmp_path, capsys)


@pytest.mark.parametrize("where", PLANTS)
def test_another_number_is_found(where: str, tmp_path: Path, capsys: Any) -> None:
    files = made(TINY, tmp_path)
    assert is_found(files, lambda mbs: PLANTS[where](mbs, 1e-4), tmp_path, capsys)


def test_a_small_inertia_is_compared_with_its_own_size(
    biped: Any, tmp_path: Path, capsys: Any
) -> None:
    for name in [body.name for body in read(biped[1], "model.mbs").bodies][-3:]:

        def plant(mbs: Mbs, name: str = name) -> None:
            (body,) = (body for body in mbs.bodies if body.name == name)
            body.inertia = (body.inertia[0] * (1.0 + 1e-7), *body.inertia[1:])

        assert is_found(biped, plant, tmp_path, capsys), name


# --- attacks ------------------------------------------------------------------------------------

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


@pytest.fixture(scope="module", params=["faithful", "compact"])
def robot(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, bytes, Any]:
    folder = tmp_path_factory.mktemp("robot")
    return made(ROBOT, folder, base="fixed", pipeline=request.param)


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
        "urdf", "<robot ", '<robot name="x"><![CDATA[<?xml version="1.0"?>]]></robot><robot ', 1),
    "a namespace": ("urdf", "<robot ", '<robot xmlns="http://x" ', 1),
    "a namespace within": ("urdf", AXIS, '<axis xmlns="http://x" xyz="1 0 0"/>', 1),
    # the URDF: doubled
    "two axes": ("urdf", AXIS, f'<axis xyz="1 0 0"/>{AXIS}', 1),
    "two axes, turned": ("urdf", AXIS, f'{AXIS}<axis xyz="1 0 0"/>', 1),
    "two origins of a joint": ("urdf",
        '<origin xyz="0 0.2 0"/>', '<origin/><origin xyz="0 0.2 0"/>', 1),
    "two inertials": ("urdf", "</inertial>", f"</inertial>{BODY}", 1),
    "two origins of an inertial": ("urdf", '<mass value="2"/>', '<origin/><mass value="2"/>', 1),
    "two masses": ("urdf", '<mass value="2"/>', '<mass value="2"/><mass value="3"/>', 1),
    "two inertias": ("urdf", "<inertia ", '<inertia ixx="1"/><inertia ', 1),
    "two limits": ("urdf",
        '<limit lower="-1" upper="1.5"', '<limit/><limit lower="-1" upper="1.5"', 1),
    "two parents": ("urdf",
        '<parent link="upper"/>', '<parent link="foot"/><parent link="upper"/>', 1),
    "two mimics": ("urdf", "<mimic ", '<mimic joint="roll"/><mimic ', 1),
    "two links of a name": ("urdf",
        '<link name="foot"/>', '<link name="foot"/><link name="foot"/>', 1),
    "two joints of a name": ("urdf", '<joint name="roll"', '<joint name="hip"', 1),
    # the URDF: no tree
    "a cycle": ("urdf", '<parent link="upper"/><child link="slide"/>',
                '<parent link="finger"/><child link="slide"/>', 1),
    "a link below itself": ("urdf", '<parent link="finger"/>', '<parent link="tool"/>', 1),
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
    "a quaternion": ("urdf", '<origin xyz="0 0.2 0"/>',
                     '<origin xyz="0 0.2 0" quat_xyzw="1 0 0 0"/>', "quat_xyzw"),
    "xacro": ("urdf", '<mass value="2"/>', '<mass value="${2}"/>', 1),
    # the URDF: numbers
    **{f"a mass of {mass!r}": ("urdf", '<mass value="2"/>', f'<mass value="{mass}"/>', 1)
       for mass in ("nan", "inf", "1e999", "0x2", "2_0", "\u0662", "2,0", "", "2 2", "-2")},
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
    "the plane": ("urdf", '<origin xyz="1 0 0"/><axis xyz="0 0 1"/>',
                  '<origin xyz="1 0 0"/><axis xyz="0 1 0"/>', 1),
    "the kite elsewhere": ("urdf", '<origin xyz="0 0 2"/>', '<origin xyz="0 0 2.5"/>', 3),
    "a shift beside the axis": ("urdf", 'xyz="0 0.1 0.4"', 'xyz="0 0.1 0.400001"', 3),
    "a shift along the axis": ("urdf", 'xyz="0 0.1 0.4"', 'xyz="0 0.100001 0.4"', 3),
    "a shift by far": ("urdf", 'xyz="0 0.1 0.4"', 'xyz="0.001 1e9 0.4"', 3),
    "another zero": ("urdf", 'rpy="0 0.25 0"', 'rpy="0 0.250001 0"', 3),
    "another parent": ("urdf", '<parent link="upper"/><child link="slide"/>',
                       '<parent link="foot"/><child link="slide"/>', 3),
    "another mass": ("urdf", '<mass value="2"/>', '<mass value="2.000001"/>', 3),
    "no mass": ("urdf", '<mass value="2"/>', "", 3),
    "another product of inertia": ("urdf", 'ixy="0.001"', 'ixy="-0.001"', 3),
    "another centre": ("urdf", 'xyz="0.1 0 0.02"', 'xyz="0.1 0 0.020001"', 3),
    "a turned inertia": ("urdf", 'xyz="0.1 0 0.02"', 'xyz="0.1 0 0.02" rpy="1e-6 0 0"', 3),
    "another limit": ("urdf", 'upper="1.5"', 'upper="1.6"', 3),
    "a limit more": ("urdf", '<limit effort="3"', '<limit lower="-1" effort="3"',
                     "q_min of 'roll': None, and -1.0 in the URDF"),
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
    "dependent": ("mbs", "<nature>independent</nature>", "<nature>dependent</nature>",
                  ": 'dependent', and 'independent' in the URDF"),
    "another limit in the .mbs": ("mbs", "<value>1.5</value>", "<value>1.6</value>", 3),
    "a limit of nan": ("mbs", "<value>1.5</value>", "<value>nan</value>", 1),
    "two values": ("mbs", "<value>1.5</value>", "<value>1.5</value><value>2</value>", 1),
    "another user model": ("mbs", "<name>effort</name>", "<name>power</name>",
                           "effort of 'hip': None, and 30.0 in the URDF"),
    "limits at one end": ("mbs", "<name>q_max</name>", "<name>q_most</name>", 1),
    "two user models of a name": ("mbs", "<name>q_max</name>", "<name>q_min</name>", 1),
    "a cut": ("mbs",
        "</bodytree>", "</bodytree><cuts><rod><name>r</name></rod></cuts>", "rod of 'r'"),
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
}  # fmt: skip


@pytest.mark.parametrize("name", ATTACKS)
def test_an_attack_fails(name: str, robot: Any, tmp_path: Path, capsys: Any) -> None:
    which, old, new, end = ATTACKS[name]
    urdf, mbs, said = robot[0].decode(), robot[1].decode(), json.loads(json.dumps(robot[2]))
    if which == "urdf":
        assert old in urdf
        urdf = urdf.replace(old, new, 1)
    elif which == "mbs":
        assert old in mbs
        mbs = mbs.replace(old, new, 1)
    elif old is None:
        said = new
    else:
        for key, value in old.items():
            said[key] = {**said[key], **value} if isinstance(value, dict) else value
    found = replay(urdf.encode(), mbs.encode(), said, tmp_path, capsys)
    if isinstance(end, str):
        assert end in found.out
        assert found.code == 0
        assert found.out.startswith("the same robot, but for:")
    else:
        assert found.code == end, found.out + found.error


def test_there_are_many_attacks() -> None:
    assert sum(attack[3] != 0 for attack in ATTACKS.values()) >= 70
