"""The replay of certificates: it says "the same robot" of the same robot, and of no other."""

import ast
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from support.build import SOLID, joint, link, robot
from support.certificates import ALWAYS, FILES, files_of, made, replay
from support.folders import CONFIGS
from support.planted import MIMIC, NATURE_FAULTS, NUMBERS, PLANTED, WORLD
from support.real_robots import CONVERTIBLE, RealRobot
from urdf2mbs import convert, verify
from urdf2mbs.mbs.model import Joint, Mbs
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import TINY
from urdf2mbs_certificate import certificate as checker

CHECKER = Path(checker.__file__)


def test_the_program_is_one_file_that_needs_the_standard_library_alone() -> None:
    tree = ast.parse(CHECKER.read_text("utf-8"))
    names = {
        name.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, (ast.Import, ast.ImportFrom))
        for name in [getattr(node, "module", None) or node.names[0].name]
    }
    assert names <= sys.stdlib_module_names


# --- the same robot -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["arm", "biped", "hexapod"])
def test_robots_of_configs_are_the_same(name: str, tmp_path: Path, capsys: Any) -> None:
    result = convert(CONFIGS / f"{name}.urdf.xacro", pipeline="compact", passes=ALWAYS)
    assert replay(*files_of(result), tmp_path, capsys).code == 0


@pytest.mark.slow
@pytest.mark.parametrize("robot", CONVERTIBLE)
def test_real_robots_are_the_same(robot: RealRobot, tmp_path: Path, capsys: Any) -> None:
    result = robot.convert(pipeline="compact", passes=ALWAYS)
    assert replay(*files_of(result), tmp_path, capsys).code == 0


def test_the_program_runs_alone(tmp_path: Path, capsys: Any) -> None:
    files = made(TINY, tmp_path, base="fixed")
    output = replay(*files, tmp_path, capsys)
    (tmp_path / "alone").mkdir()
    (tmp_path / "alone" / "certificate.py").write_bytes(CHECKER.read_bytes())
    done = subprocess.run(
        [sys.executable, "-I", "certificate.py", *(f"../{name}" for name in FILES)],
        cwd=tmp_path / "alone",
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, output.out.replace("\r", ""))
    for files in ((), ("missing.urdf", *FILES[1:])):
        done = subprocess.run(
            [sys.executable, CHECKER, *files], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stdout) == (1, "")
        assert "Traceback" not in done.stderr


HANDLESS = re.sub(r'(?s)(<link name="hand">\s*)<inertial>.*?</inertial>', r"\1", TINY)
#: The joint "stays" follows a joint that moves nothing, with the multiplier 0.
STAYS = robot(
    link("world"),
    link("a", SOLID),
    joint("world", "a"),
    link("knob"),
    joint("a", "knob", name="drive"),
    link("b", SOLID),
    joint("a", "b", name="stays", xyz="1 0 0").replace(
        "<limit", '<mimic joint="drive" multiplier="0" offset="0.1"/><limit'
    ),
)
#: Robots, how they are converted, and what the replay says beside "the same robot".
SAME: Any = {
    "fixed": (TINY, {"base": "fixed"}, []),
    "floating": (TINY, {"base": "floating"}, ['<joint name="floating_base" type="floating">']),
    "world": (WORLD, {}, []),
    "a world that is not declared": (WORLD.replace('<link name="world"/>', ""), {}, []),
    "mimic": (MIMIC, {}, ["nature of 'wrist_pitch': 'independent', and 'follower'"]),
    "mimic in a project": (
        MIMIC,
        {"output": {"project": "p"}},
        ["nature of 'wrist_pitch': 'dependent', and 'follower'"],
    ),
    "mimic by force": (
        MIMIC,
        {"output": {"project": "p"}, "passes": {"mimic": {"joints": {"*": "driven"}}}},
        ["nature of 'wrist_pitch': 'driven', and 'follower'"],
    ),
    "a follower that stays": (
        STAYS,
        {"output": {"project": "p"}},
        ["nature of 'stays': 'driven', and 'follower'"],
    ),
    "held": (HANDLESS, {"base": "fixed"}, ["joint 'wrist_pitch' is held at zero: '"]),
    "estimate-inertia": (
        HANDLESS,
        {"output": {"project": "p"}, "passes": {"estimate-inertia": {"density": 1000.0}}},
        ["<link> 'hand' has '<inertial>"],
    ),
    "rotors": (
        TINY,
        {"output": {"project": "p"}, "passes": {"rotors": {"armature": {"wrist_roll": 0.1}}}},
        ['<link name="wrist_roll_rotor"'],
    ),
    "snap": (
        TINY,
        {"output": {"project": "p"}, "passes": {"snap": {"angle": 1e-3}}},
        ["<joint> 'tool_mount' has '<origin ", "on purpose, and '<origin "],
    ),
    "a rod": (
        TINY,
        {
            "base": "fixed",
            "passes": {
                **ALWAYS,
                "loops": {
                    "cuts": {
                        "rod": {
                            "kind": "rod",
                            "length": 0.5,
                            "ends": [{"link": "body"}, {"link": "tool", "at": [0, 0, 1]}],
                        }
                    }
                },
            },
        },
        ["rod of '", "'dependent', and 'independent'"],
    ),
    "the moon": (TINY, {"gravity": [0, 0, -1.62]}, ["gravity of 'base': (0.0, 0.0, -1.62)"]),
    "no damping": (TINY, {"without": ["joint-parameters"]}, ["damping of 'shoulder': None, and"]),
    "unknown attributes": (
        TINY.replace('<axis xyz="0 1 1"/>', '<axis xyz="0 1 1" rpy="0 0 1"/>'),
        {},
        ["rpy='0 0 1'"],
    ),
    "blank lines first": (f"\n\n{TINY}", {}, []),
    "a mark of byte order": (f"\ufeff{TINY}", {}, []),
    **{
        kind: (
            TINY.replace('name="wrist_pitch" type="revolute"', f'name="wrist_pitch" type="{kind}"'),
            {},
            [],
        )
        for kind in ("planar", "floating", "prismatic", "continuous")
    },
}


#: Those of which "compact" makes another model than "faithful".
COMPACT = ("fixed", "world", "mimic in a project", "held", "a rod", "planar", "floating")


@pytest.mark.parametrize(
    ("name", "pipeline"),
    [*((name, "faithful") for name in SAME), *((name, "compact") for name in COMPACT)],
)
def test_a_conversion_is_the_same_robot_and_all_that_was_meant_is_named(
    name: str, pipeline: str, tmp_path: Path, monkeypatch: Any, capsys: Any
) -> None:
    text, settings, known = SAME[name]
    monkeypatch.chdir(tmp_path)
    output = replay(*made(text, tmp_path, pipeline=pipeline, **settings), tmp_path, capsys)
    assert output.code == 0
    for words in known:
        assert words in output.out


def test_a_chain_of_a_thousand_links_is_replayed(tmp_path: Path, capsys: Any) -> None:
    """No function calls itself for each link of a chain."""
    inertial = '<inertial><mass value="1"/></inertial>'
    urdf = mbs = ""
    for n in range(1, 1100):
        urdf += f'<link name="l{n}">{inertial}</link><joint name="j{n}" type="continuous">'
        urdf += f'<parent link="l{n - 1}"/><child link="l{n}"/><origin xyz="0.1 0 0"/></joint>'
        parent = f"<bodyname>l{n - 1}</bodyname><pointname>end</pointname>"
        mbs += f"<body><bodyname>l{n}</bodyname><parent>{parent}</parent>"
        mbs += f"<joint><jointname>j{n}</jointname><type>R1</type><nature>independent</nature>"
        mbs += f"</joint><mass>1</mass>{END}</body>"
    base = f"<base><gravity><coordinates><z>-9.81</z></coordinates></gravity>{END}</base>"
    mbs = mbs.replace("<bodyname>l0<", "<bodyname>base<")
    joints = {"joints": {f"j{n}": [f"j{n}"] for n in range(1, 1100)}}
    nothing = {"planes": {}, "held": {}, "changes": [], "edited": []}
    found = replay(
        f'<robot name="long"><link name="l0"/>{urdf}</robot>'.encode(),
        f"<mbsDescR7>{base}<bodytree>{mbs}</bodytree></mbsDescR7>".encode(),
        {**joints, **nothing, "gravity": [0.0, 0.0, -9.81]},
        tmp_path,
        capsys,
    )
    assert found.plain, found.error


END = "<point><pointname>end</pointname><coordinates><x>0.1</x></coordinates></point>"


def test_edits_by_people_are_named(tmp_path: Path, capsys: Any) -> None:
    source, model = tmp_path / "tiny.urdf", tmp_path / "p" / "dataR" / "p.mbs"
    source.write_text(TINY)
    convert(source, output={"project": tmp_path / "p"}).write()
    mbs = read_mbs(model.read_bytes(), "p.mbs")
    mbs.bodies[-1].mass = 7.0
    next(m for m in mbs.user_models if m.name == "q_max").parameters[0].values = ("0.25",)
    mbs.bodies[-1].joints.append(Joint("spin", "R1", "independent"))
    model.write_bytes(write(mbs))
    result = convert(source, output={"project": tmp_path / "p"})
    files = files_of(result)
    output = replay(*files, tmp_path, capsys)
    assert output.code == 0
    for words in ("mass or inertia of 'wrist_pitch'", "q_max of ", "motion of 'spin'"):
        assert re.search(f"{words}.*as edited", output.out), words
    files[2]["edited"] = []
    assert replay(*files, tmp_path, capsys).code == 3


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"<q>0.1</q>", b"<q>0.2</q>"),
        (b'multiplier="0"', b'multiplier="2"'),
        (b'offset="0.1"', b'offset="0.2"'),
        (b"<q/>", b"<qd/>"),
    ],
)
def test_a_follower_stays_at_its_offset(
    old: bytes, new: bytes, tmp_path: Path, capsys: Any
) -> None:
    urdf, mbs, certificate = made(STAYS, tmp_path, output={"project": tmp_path / "p"})
    assert old in urdf + mbs
    (tmp_path / "new.urdf").write_bytes(urdf.replace(old, new))
    (tmp_path / "new.mbs").write_bytes(mbs.replace(old, new))
    assert (
        replay(urdf.replace(old, new), mbs.replace(old, new), certificate, tmp_path, capsys).code
        == 3
    )
    differences = verify(tmp_path / "new.urdf", tmp_path / "new.mbs").differences
    assert {difference.joint for difference in differences} == {"stays"}


# --- another robot ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def files_of_tiny(tmp_path_factory: Any) -> tuple[bytes, bytes, Any]:
    """Return the URDF, the .mbs and the certificate of the tiny robot."""
    return made(TINY, tmp_path_factory.mktemp("tiny"))


def is_found(
    files: tuple[bytes, bytes, Any], plant: Callable[[Mbs], None], folder: Path, capsys: Any
) -> bool:
    """Return True if the replay fails, or prints a line that is new."""
    before = replay(*files, folder, capsys).out
    mbs = read_mbs(files[1], "model.mbs")
    plant(mbs)
    output = replay(files[0], write(mbs), files[2], folder, capsys)
    return output.code != 0 or not {*output.out.splitlines()} <= {*before.splitlines()}


@pytest.mark.parametrize("fault", [name for name, (_, kinds) in PLANTED.items() if kinds])
def test_a_fault_planted_in_the_mbs_is_found(
    fault: str, files_of_tiny: Any, tmp_path: Path, capsys: Any
) -> None:
    plant, _ = PLANTED[fault]
    assert is_found(files_of_tiny, plant, tmp_path, capsys)


@pytest.mark.parametrize("fault", NATURE_FAULTS)
def test_a_fault_of_natures_and_cuts_is_found(fault: str, tmp_path: Path, capsys: Any) -> None:
    text, base, plant, _ = NATURE_FAULTS[fault]
    if text == WORLD:  # the certificate is of the robot that stands; the .mbs floats
        floats = made(text, tmp_path, base=base)[1]
        urdf, _, certificate = made(text, tmp_path)
        assert replay(urdf, floats, certificate, tmp_path, capsys).code == 3
    else:
        assert is_found(made(text, tmp_path, base=base), plant, tmp_path, capsys)


@pytest.mark.parametrize("where", NUMBERS)
def test_another_number_is_found(
    where: str, files_of_tiny: Any, tmp_path: Path, capsys: Any
) -> None:
    assert is_found(files_of_tiny, lambda mbs: NUMBERS[where](mbs, 1e-4), tmp_path, capsys)


def test_a_small_inertia_is_compared_with_its_own_size(
    files_of_tiny: Any, tmp_path: Path, capsys: Any
) -> None:
    for name in ("body", "arm", "hand"):

        def plant(mbs: Mbs, name: str = name) -> None:
            (body,) = (body for body in mbs.bodies if body.name == name)
            body.inertia = (body.inertia[0] * (1.0 + 1e-7), *body.inertia[1:])

        assert is_found(files_of_tiny, plant, tmp_path, capsys), name


@pytest.mark.parametrize(
    ("distance", "shift", "is_different"),
    [
        (1e-4, 5e-12, True),
        (1e-4, 5e-13, False),
        (0.02, 1e-10, True),
        (0.02, 1e-11, False),
        (50.0, 5e-9, True),
        (50.0, 5e-10, False),
    ],
)
def test_the_place_of_a_joint_is_compared_with_its_distance_between_1_mm_and_1_m(
    distance: float, shift: float, is_different: bool, tmp_path: Path, capsys: Any
) -> None:
    hinge = joint("a", "b", xyz=f"{distance} 0 0")
    files = made(robot(link("a", SOLID), link("b", SOLID), hinge), tmp_path, base="fixed")
    mbs = read_mbs(files[1], "model.mbs")
    mbs.points()[mbs.bodies[-1].place].coordinates = (distance + shift, 0.0, 0.0)
    output = replay(files[0], write(mbs), files[2], tmp_path, capsys)
    assert ("motion of 'a_to_b'" in output.out) is is_different, output.out
