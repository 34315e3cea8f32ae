"""The checker of certificates: every fault planted in an .mbs is found without our code."""

from __future__ import annotations

import ast
import hashlib
import json
import re
import subprocess
import sys
from collections.abc import Callable
from math import cos, sin
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from proof.test_not_fooled import PLANTS
from proof.test_planted import BIPED, PLANTED
from proof.test_words import FOUND, MIMIC, SAID, TINY, WORLD

from urdf2mbs import Result, convert
from urdf2mbs.mbs.model import Joint, Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs.proof import certificate as checker

CHECKER = Path(checker.__file__)
ALWAYS = {"certificate": {"write": "always"}}
#: Lines of code, without docstrings, comments and empty lines.
LONGEST = 200
FILES = ("robot.urdf", "model.mbs", "model.proof.json")
Texts = tuple[bytes, bytes, dict[str, Any]]


def texts_of(result: Result) -> Texts:
    """The URDF, the .mbs and its certificate."""
    conversion = result.conversion
    path = conversion.settings.output.with_suffix(".proof.json")
    urdf = conversion.source if conversion.expanded is None else conversion.expanded
    return urdf, result.data, json.loads(conversion.files[path])


@pytest.fixture(scope="module", params=["faithful", "compact"])
def biped(request: pytest.FixtureRequest) -> Texts:
    return texts_of(convert(BIPED, pipeline=request.param, passes=ALWAYS))


def tiny(text: str, folder: Path, **settings: Any) -> Texts:
    source = folder / "tiny.urdf"
    source.write_text(text)
    return texts_of(convert(source, **{"passes": ALWAYS, **settings}))


def replay(texts: Texts, folder: Path) -> int:
    """What the checker says; the certificate is made to name the .mbs by its sha256."""
    urdf, mbs, said = texts
    said["subject"][0]["digest"]["sha256"] = hashlib.sha256(mbs).hexdigest()
    return run(urdf, mbs, said, folder)


def run(urdf: bytes, mbs: bytes, said: dict[str, Any], folder: Path) -> int:
    files = [folder / name for name in FILES]
    files[0].write_bytes(urdf)
    files[1].write_bytes(mbs)
    files[2].write_text(json.dumps(said))
    return checker.replay(*map(str, files))


def planted(texts: Texts, plant: Callable[[Mbs], None]) -> Texts:
    mbs = read(texts[1], "model.mbs")
    plant(mbs)
    return texts[0], write(mbs), json.loads(json.dumps(texts[2]))


def as_converted(texts: Texts) -> Texts:
    """As if the fault were in the converter: what the replay only compares with the certificate is
    in the certificate."""
    said = texts[2]["predicate"]["urdf2mbs"]
    said["rest"] = checker.rest_of(ElementTree.fromstring(texts[1]))
    return texts


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


def test_it_runs_alone(biped: Texts, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert replay(biped, tmp_path) == 0
    alone = tmp_path / "alone"
    alone.mkdir()
    (alone / "certificate.py").write_bytes(CHECKER.read_bytes())
    done = subprocess.run(
        [sys.executable, "-I", "certificate.py",
         *(f"../{name}" for name in FILES)],
        cwd=alone, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, capsys.readouterr().out.replace("\r", ""))
    assert done.stdout.startswith("the same robot: 22 groups")


@pytest.mark.parametrize("fault", PLANTED)
def test_a_planted_fault_is_found(biped: Texts, fault: str, tmp_path: Path) -> None:
    texts = planted(biped, PLANTED[fault][0])
    assert replay(texts, tmp_path) == 3
    unseen = {"gravity the other way", "no damping", "dependent instead of independent"}
    assert replay(as_converted(texts), tmp_path) == (0 if fault in unseen else 3)


@pytest.mark.parametrize("fault", FOUND)
def test_a_fault_of_natures_and_cuts_is_found(fault: str, tmp_path: Path) -> None:
    text, base, plant, _ = FOUND[fault]
    if text == WORLD:  # the certificate is of the robot that stands; the .mbs floats
        model = tiny(text, tmp_path, base=base)[1]
        assert replay((text.encode(), model, tiny(text, tmp_path)[2]), tmp_path) == 3
    else:
        texts = planted(tiny(text, tmp_path, base=base), plant)
        assert replay(texts, tmp_path) == 3
        assert replay(as_converted(texts), tmp_path) == (
            0 if re.search("cut|follower", fault) else 3
        )


@pytest.mark.parametrize("fault", [fault for fault in SAID if "follower that is free" not in fault])
def test_what_is_not_as_in_the_certificate_is_found(fault: str, tmp_path: Path) -> None:
    text, base, plant, _ = SAID[fault]
    assert replay(planted(tiny(text, tmp_path, base=base), plant), tmp_path) == 3


@pytest.mark.parametrize("where", PLANTS)
def test_another_number_is_found(where: str, tmp_path: Path) -> None:
    def plant(mbs: Mbs) -> None:
        PLANTS[where](mbs, 1e-4)

    assert replay(planted(tiny(TINY, tmp_path), plant), tmp_path) == 3


def test_a_small_inertia_is_compared_with_its_own_size(biped: Texts, tmp_path: Path) -> None:
    names = [body.name for body in read(biped[1], "model.mbs").bodies]
    for name in names[-3:]:

        def plant(mbs: Mbs, name: str = name) -> None:
            (body,) = (body for body in mbs.bodies if body.name == name)
            body.inertia = (body.inertia[0] * (1.0 + 1e-7), *body.inertia[1:])

        assert replay(planted(biped, plant), tmp_path) == 3, name


def _turn_frame(mbs: Mbs) -> None:
    """The robot is the same, but the frame of the hand is turned."""
    mbs.bodies[-1].joints.append(Joint("more", "R1", "driven", q=0.3))
    mbs.bodies[-1].com = (0.0, 0.05 * sin(0.3), 0.05 * cos(0.3))


def _move_point(name: str) -> Callable[[Mbs], None]:
    def plant(mbs: Mbs) -> None:
        (point,) = (p for body in mbs.bodies for p in body.points if p.name == name)
        x, y, z = point.coordinates
        point.coordinates = (x, y + 1e-6, z)

    return plant


#: Faults of what moves nothing by itself: frames, and where cuts, forces and sensors are.
PLACES: dict[str, Callable[[Mbs], None]] = {
    "a frame turned": _turn_frame,
    "an end of a cut": _move_point("rod_2"),
    "the other end of a cut": lambda mbs: setattr(mbs.cuts[0], "endpoint1", ("hand", None)),
    "the length of a rod": lambda mbs: setattr(mbs.cuts[0], "length", 0.51),
    "the point of a force": _move_point("push_at"),
    "the point of a sensor": _move_point("hand_at"),
    "the dependent joint": lambda mbs: [
        setattr(j, "nature", "independent") for b in mbs.bodies for j in b.joints
        if j.nature == "dependent"
    ],
}  # fmt: skip
PASSES: Any = {
    "loops": {"cuts": {"rod": {
        "kind": "rod", "length": 0.5, "ends": [{"link": "body"}, {"link": "tool", "at": [0, 0, 1]}],
    }}},
    "forces": {"wrenches": {"push": {"link": "arm", "at": [0, 0, 1], "force": [1, 0, 0]}}},
    "sensors": {"links": ["hand"]},
}  # fmt: skip


@pytest.mark.parametrize("fault", ["", *PLACES])
def test_another_place_is_found(fault: str, tmp_path: Path) -> None:
    texts = tiny(TINY, tmp_path, base="fixed", passes=PASSES, output={"project": tmp_path / "p"})
    texts = planted(texts, PLACES.get(fault, lambda mbs: None))
    assert replay(texts, tmp_path) == (3 if fault else 0)
    seen = fault in ("a frame turned", "an end of a cut")
    assert replay(as_converted(texts), tmp_path) == (3 if seen else 0)


HANDLESS = re.sub(r'(?s)(<link name="hand">\s*)<inertial>.*?</inertial>', r"\1", TINY)
#: Passes that change the robot on purpose, and what of it.
CHANGES: Any = {
    "estimate-inertia": (
        {"density": 1000.0},
        {"link inertial mass", "link inertial inertia", "link inertial origin"},
    ),
    "rotors": (
        {"armature": {"wrist_roll": 0.1}},
        {"link", "link inertial inertia", "joint child", "joint axis", "joint mimic"},
    ),
    "snap": ({"angle": 1e-3}, {"joint origin"}),
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_a_pass_changed_on_purpose_is_named(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The robot is the same but for these changes, and each value is what it was and became."""
    options, kinds = CHANGES[name]
    settings = {"base": "fixed", "passes": {name: options}, "output": {"project": tmp_path / "p"}}
    texts = tiny(HANDLESS if name == "estimate-inertia" else TINY, tmp_path, **settings)
    assert replay(texts, tmp_path) == 0
    assert f"  but for {name} (plugin 'urdf2mbs') changed of" in capsys.readouterr().out
    changes = texts[2]["predicate"]["urdf2mbs"]["changes"]
    assert kinds <= {" ".join([tag, *path]) for (tag, _, *path), *_ in changes}
    for number, change in enumerate(changes):
        said = json.loads(json.dumps(texts[2]))
        said["predicate"]["urdf2mbs"]["changes"][number][1] = ["", {"xyz": "9 9 9"}]
        assert replay((texts[0], texts[1], said), tmp_path) == 3, change
    if name != "rotors":
        said = json.loads(json.dumps(texts[2]))
        added = [change for change in changes if change[0][1] == "ground"]
        said["predicate"]["urdf2mbs"]["changes"] = added
        assert replay((texts[0], texts[1], said), tmp_path) == 3


def test_what_a_certificate_permits_is_printed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A certificate that says less than it permits does not hide what is another robot."""
    options = {"snap": {"angle": 1e-3}}
    texts = tiny(TINY, tmp_path, base="fixed", passes=options, output={"project": tmp_path / "p"})
    texts[2]["predicate"]["warnedTests"] = []
    assert replay(texts, tmp_path) == 0
    said = capsys.readouterr().out
    assert "  but for what was added or changed on purpose: joint 'tool_mount'" in said
    assert "groups, to" in said
    assert ", damping" in said.splitlines()[0]
    del texts[2]["predicate"]["urdf2mbs"]["numbers"]["damping"]
    assert replay(texts, tmp_path) == 0
    assert ", damping" not in capsys.readouterr().out


def test_a_joint_that_is_held_must_be_named(tmp_path: Path) -> None:
    texts = tiny(HANDLESS, tmp_path, base="fixed", output={"project": tmp_path / "p"})
    assert any("held at zero" in line for line in texts[2]["predicate"]["warnedTests"])
    assert replay(texts, tmp_path) == 0
    texts[2]["predicate"]["warnedTests"] = []
    assert replay(texts, tmp_path) == 3


@pytest.mark.parametrize("text", [TINY, MIMIC, WORLD], ids=["tiny", "mimic", "world"])
def test_a_good_file_is_the_same(text: str, tmp_path: Path) -> None:
    assert replay(tiny(text, tmp_path), tmp_path) == 0


def test_slips_that_people_make_are_read(tmp_path: Path) -> None:
    for text in (
        f"\n<!-- licence -->\n{TINY}",
        WORLD.replace('<link name="world"/>', ""),
        TINY.replace("<robot ", '<robot xmlns="http://drake.mit.edu" '),
        re.sub(r'xyz="(\S+) (\S+) (\S+)"', r'xyz="\1, \2, \3"', TINY),
    ):
        assert text not in (TINY, WORLD)
        assert replay(tiny(text, tmp_path), tmp_path) == 0, text
        said = tiny(text, tmp_path, passes={"snap": {"angle": 1e-3}, **ALWAYS})
        assert replay(said, tmp_path) == 0, text


def test_joints_of_all_types(tmp_path: Path) -> None:
    for kind in ("planar", "floating", "prismatic", "revolute"):
        text = TINY.replace(
            'name="wrist_pitch" type="revolute"', f'name="wrist_pitch" type="{kind}"'
        )
        assert replay(tiny(text, tmp_path, base="fixed"), tmp_path) == 0, kind


def test_springs_are_those_of_the_urdf(tmp_path: Path) -> None:
    springs = "".join(
        f"<springStiffness>{i}</springStiffness><springReference>0.{i}</springReference>"
        f'</gazebo><gazebo reference="{name}">'
        for i, name in ((1, "wrist_roll"), (2, "none"))
    )
    text = TINY.replace("</robot>", f'<gazebo reference="wrist_pitch">{springs}</gazebo></robot>')
    settings = {"base": "fixed", "pipeline": "compact", "project": tmp_path / "p"}
    urdf, mbs, said = tiny(text, tmp_path, **settings)
    assert replay((urdf, mbs, said), tmp_path) == 0
    for old, new in ((b"<springStiffness>1<", b"<springStiffness>3<"), (b">0.2<", b">0.4<")):
        assert old in urdf
        other = urdf.replace(old, new)
        digest = {"sha256": hashlib.sha256(other).hexdigest()}
        said["predicate"]["configuration"][0]["digest"] = digest
        assert replay((other, mbs, said), tmp_path) == 3


@pytest.mark.parametrize("key", ["axis", "place", "mass", "centre", "inertia"])
def test_a_number_of_the_certificate_that_is_not_the_urdfs(
    biped: Texts, key: str, tmp_path: Path
) -> None:
    said = json.loads(json.dumps(biped[2]))
    group = next(g for g in said["predicate"]["urdf2mbs"]["groups"] if g["joint"] == "left_knee")
    rows = {"mass": [group], "place": group["place"][:3]}.get(key, [group[key]])
    for row in rows:
        for index in ["mass"] if key == "mass" else range(len(row)):
            value = row[index]
            row[index] += 1e-3
            assert replay((biped[0], biped[1], said), tmp_path) == 3, (key, index)
            row[index] = value


def test_other_files_than_those_certified(
    biped: Texts, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    urdf, mbs, said = biped
    assert run(urdf, mbs.replace(b"\n", b"\r\n"), said, tmp_path) == 3
    assert "model.mbs is not the file that was certified" in capsys.readouterr().out
    assert replay((urdf.replace(b"<robot ", b"<robot a='' "), mbs, said), tmp_path) == 3
    assert "robot.urdf is not the file that was certified" in capsys.readouterr().out


def test_what_cannot_be_read(biped: Texts, tmp_path: Path) -> None:
    urdf, mbs, said = biped
    secret = tmp_path / "secret"
    secret.write_text("<link name='secret'/>")
    fetched = f'<!DOCTYPE robot [<!ENTITY a SYSTEM "{secret.as_uri()}">]><robot>&a;</robot>'
    with pytest.raises(ElementTree.ParseError, match="undefined entity"):
        run(fetched.encode(), mbs, said, tmp_path)
    done = subprocess.run(
        [sys.executable, CHECKER, *(tmp_path / name for name in FILES)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("ParseError: undefined entity")
    with pytest.raises(AttributeError):
        run(urdf, b"<mbsDescR7/>", said, tmp_path)
    with pytest.raises(KeyError):
        run(urdf, mbs, {}, tmp_path)


def test_a_number_that_is_none(biped: Texts, tmp_path: Path) -> None:
    urdf, mbs, said = biped
    assert replay((urdf, mbs.replace(b"<mass>0.36<", b"<mass>nan<"), said), tmp_path) == 3


def test_what_people_edited_is_named_and_all_else_is_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, model = tmp_path / "tiny.urdf", tmp_path / "p" / "dataR" / "p.mbs"
    damped = TINY.replace("<limit ", '<dynamics damping="0.5"/><limit ')
    source.write_text(damped)
    convert(source, output={"project": tmp_path / "p"}).write()
    mbs = read(model.read_bytes(), "p.mbs")
    body, damping = mbs.bodies[-1], next(m for m in mbs.user_models if m.name == "damping")
    _turn_frame(mbs)
    body.mass, damping.parameters[0].values = 7.0, ("0.25",)
    model.write_bytes(write(mbs))
    result = convert(source, output={"project": tmp_path / "p"})
    assert result.report.verdict.startswith("the same robot, but for ")
    result.write()
    files = [str(file) for file in (source, model, model.with_suffix(".proof.json"))]
    capsys.readouterr()
    assert checker.replay(*files) == 0
    said = capsys.readouterr().out
    assert said.startswith("the same robot: ")
    assert "mass is 7 in the .mbs, and should be" in said
    assert said.count("(edited)") == 1
    assert "what moves with joint 'wrist_pitch' (edited)" in said
    assert said.count("as edited in p.mbs") >= 2
    mbs.bodies[-1].joints.append(Joint("spin", "R1", "independent"))
    model.write_bytes(write(mbs))
    convert(source, output={"project": tmp_path / "p"}).write()
    assert checker.replay(*files) == 0
    assert "joint 'spin' of body 'hand' moves in the .mbs only" in capsys.readouterr().out
    for change in (
        lambda mbs: setattr(mbs.bodies[-1].joints[0], "nature", "driven"),
        lambda mbs: setattr(mbs.bodies[-1], "mass", 7.5),
        lambda mbs: setattr(mbs.bodies[0], "mass", 7.5),
        lambda mbs: setattr(mbs.user_models[1].parameters[0], "values", ("0.75",)),
    ):
        edited = read(model.read_bytes(), "p.mbs")
        change(edited)
        texts = damped.encode(), write(edited), json.loads(Path(files[2]).read_text())
        assert replay(texts, tmp_path) == 3
