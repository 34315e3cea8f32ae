"""Robots whose parts have other names are matched by place, and what differs is told by cause."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from support.build import joint, link, robot
from support.nameless import change, leave_out, make_humanoid, rename_mbs, rename_urdf
from support.real_robots import CONVERTIBLE, RealRobot
from urdf2mbs import verify
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.verification import Verdict

HUMANOID = make_humanoid()


def compare(
    tmp_path: Path, first: str, second: bytes, ending: str = "urdf", **given: Any
) -> Verdict:
    """Compare a URDF with a robot without its names."""
    (tmp_path / "a.urdf").write_text(first)
    (tmp_path / f"b.{ending}").write_bytes(second)
    return verify(tmp_path / "a.urdf", tmp_path / f"b.{ending}", **given)


def matched(verdict: Verdict, names: dict[str, str]) -> dict[str, tuple[str, str]]:
    """Return the joints that are not matched as they should be: what they are, and should be."""
    found = {joint: names_of_joint[0] for joint, names_of_joint in verdict.joints.items()}
    return {
        joint: (found.get(joint, ""), name)
        for joint, name in names.items()
        if found.get(joint) != name
    }


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("rename", "ending"), [(rename_urdf, "urdf"), (rename_mbs, "mbs")])
def test_joints_are_found_without_their_names(
    rename: Callable[..., Any], ending: str, seed: int, tmp_path: Path
) -> None:
    nameless = rename(HUMANOID, seed)
    verdict = compare(tmp_path, HUMANOID, nameless.data, ending)
    assert verdict.same, [difference.message for difference in verdict.differences]
    assert matched(verdict, nameless.names) == {}
    assert set(verdict.by.values()) == {"place"}
    assert verdict.equal == []
    assert not verdict.turned


@pytest.mark.parametrize("real", CONVERTIBLE)
def test_joints_of_real_robots_are_found_without_their_names(
    real: RealRobot, tmp_path: Path
) -> None:
    nameless = rename_urdf(real.text.read_text(), 5)
    (tmp_path / "b.urdf").write_bytes(nameless.data)
    verdict = verify(real.text, tmp_path / "b.urdf", packages=real.packages)
    assert verdict.same
    may_be_exchanged = {joint for group in verdict.equal for joint in group}
    assert matched(verdict, nameless.names).keys() <= may_be_exchanged


KNEE = r'(<link name="left_knee_link"><inertial><origin xyz=")([^"]*)("/><mass value=")([^"]*)'
SHIN = "left_knee_link"
JOINT = r'(<joint name="{}" type=")(\w+)("><parent link="\w+"/><child link="\w+"/><origin '
JOINT += r'xyz=")([^"]*)(" rpy=")([^"]*)("/><axis xyz=")([^"]*)'


def of_joint(name: str, new: str) -> tuple[str, str]:
    """A change of a joint; in ``new``, 2 is its type, 4 its xyz, 6 its rpy and 8 its axis."""
    return JOINT.format(name), new


#: What is changed, and words of the first line that tells of it.
CHANGES = {
    "mass": ((KNEE, r"\g<1>\2\g<3>3.7"), f"link '{SHIN}': mass is 3.7"),
    "no mass": ((KNEE, r"\g<1>\2\g<3>0"), f"link '{SHIN}': mass"),
    "centre": (
        (KNEE, r"\g<1>0.05 0.01 -0.1\g<3>\4"),
        f"link '{SHIN}': centre is (0.05, 0.01, -0.1)",
    ),
    "place": (of_joint("left_knee", r"\1\2\g<3>0 0.03 -0.41\5\6\7\8"), "left_knee"),
    "axis": (of_joint("left_elbow", r"\1\2\3\4\5\6\g<7>0 0.6 0.8"), "'left_elbow': axis is"),
    "flipped": (
        of_joint("left_elbow", r"\1\2\3\4\5\6\g<7>0 0 -1"),
        "'left_elbow': axis is",
    ),
    "zero": (of_joint("left_knee", r"\1\2\3\4\g<5>0 0.7 0\7\8"), "'left_knee': zero is at 0.7 rad"),
    "shift": (of_joint("left_wrist", r"\1prismatic\3\4\5\6\7\8"), "is a T1; expected R1"),
    "held": (
        of_joint("left_wrist", r"\1fixed\3\4\5\6\7\8"),
        "joint 'left_wrist' (continuous) is not",
    ),
}


@pytest.mark.parametrize("kind", CHANGES)
def test_a_change_is_told_first_and_alone(kind: str, tmp_path: Path) -> None:
    (pattern, new), words = CHANGES[kind]
    nameless = rename_urdf(change(HUMANOID, pattern, new), 1)
    verdict = compare(tmp_path, HUMANOID, nameless.data)
    assert not verdict.same
    assert matched(verdict, nameless.names).keys() <= {"left_wrist"}
    assert words in verdict.findings[0].message
    assert len(verdict.findings) == 1 + (kind == "shift")
    numbers = [number for finding in verdict.findings for number in finding.differences]
    assert sorted(numbers) == [*range(len(verdict.differences))]


def test_a_wrong_mass_explains_centre_and_inertia(tmp_path: Path) -> None:
    """The masses of left and right are wrong, and so are the inertias of their groups."""
    text = HUMANOID
    for side in ("left", "right"):
        motor = link(f"{side}_motor", HUMANOID.split("<inertial>")[9].join(("<inertial>", "")))
        motor = motor.split("</inertial>")[0] + "</inertial></link>"
        fixed = joint(f"{side}_knee_link", f"{side}_motor", "fixed", xyz="0 0.05 0.1")
        text = text.replace("</robot>", f"{motor}{fixed}</robot>")
    wrong = text
    for side in ("left", "right"):
        pattern = KNEE.replace("left", side)
        wrong = change(wrong, pattern, r"\g<1>\2\g<3>4.5")
    verdict = compare(tmp_path, text, rename_mbs(wrong, 2).data, "mbs")
    (finding,) = verdict.findings
    assert "link 'left_knee_link': mass is 4.5 in the .mbs; expected 3" in finding.message
    assert "(and so 'right_knee_link')" in finding.message


def test_what_is_left_out_takes_with_it_what_it_carries(tmp_path: Path) -> None:
    text = HUMANOID
    for name in ("wrist", "elbow", "shoulder"):
        text = leave_out(text, f"right_{name}")
    verdict = compare(tmp_path, HUMANOID, rename_urdf(text, 3).data)
    (finding,) = verdict.findings
    assert "joint 'right_shoulder' (continuous) is not in b.urdf, nor is what" in finding.message
    assert len(finding.differences) == len(verdict.differences) > 2


# --- equal, and against ---


def make_hand(*names: str, y: float = 0.0) -> str:
    """Make two equal fingers at one place of a palm; y moves the second one (m)."""
    palm = link("palm", '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ')
    palm = palm.replace("</link>", 'ixz="0" iyz="0"/></inertial></link>')
    tip = '<inertial><origin xyz="0 0 0.1"/><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" '
    tip += 'izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>'
    fingers = [
        link(name, tip)
        + joint("palm", name, xyz=f"0 {place} 0.1", axis="1 0 0", name=f"{name}_joint")
        for name, place in zip(names, (0.0, y), strict=True)
    ]
    return robot(palm, *fingers)


def test_joints_that_numbers_cannot_tell_apart_are_said_to_be_equal(tmp_path: Path) -> None:
    first, second = make_hand("thumb", "index"), make_hand("a", "b")
    verdict = compare(tmp_path, first, second.encode())
    assert verdict.same
    assert verdict.equal == [["thumb_joint", "index_joint"]]


def test_names_that_disagree_with_places_are_named(tmp_path: Path) -> None:
    first, second = make_hand("f_left", "f_right", y=0.2), make_hand("g_right", "g_left", y=0.2)
    verdict = compare(tmp_path, first, second.encode())
    assert verdict.same
    (exchange,) = verdict.against
    assert set(exchange.joints) == {"f_left_joint", "f_right_joint"}
    assert exchange.differing == 2
    told = " ".join(verdict.describe_match())
    assert "by name, 'f_left_joint' and 'f_right_joint' would match the other way" in told


def test_joints_of_the_same_name_at_other_places_are_no_match(tmp_path: Path) -> None:
    """Each author counts from another number."""
    one, two = HUMANOID, HUMANOID
    for number, name in enumerate(sorted(rename_urdf(HUMANOID, 0).names)):
        one = one.replace(f'<joint name="{name}"', f'<joint name="j{number}"')
        two = two.replace(f'<joint name="{name}"', f'<joint name="j{number + 1}"')
    verdict = compare(tmp_path, one, two.encode())
    assert verdict.same
    assert verdict.joints["j3"] == ("j4",)
    assert verdict.instead_of_names > 8
    assert "joints of the same name are not at the same place" in " ".join(verdict.describe_match())


def test_if_all_names_match_nothing_is_matched_by_place(tmp_path: Path) -> None:
    verdict = compare(tmp_path, HUMANOID, HUMANOID.encode())
    assert verdict.same
    assert set(verdict.by.values()) == {"name"}
    wrong = change(HUMANOID, *CHANGES["mass"][0])
    assert len(compare(tmp_path, HUMANOID, wrong.encode()).differences) == 1


# --- maps ---


def test_a_map_that_is_written_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    nameless = rename_urdf(HUMANOID, 4)
    Path("a.urdf").write_text(HUMANOID)
    Path("b.urdf").write_bytes(nameless.data)
    assert main(["verify", "a.urdf", "b.urdf", "--write-map", "joints.yaml"]) == 0
    written = Path("joints.yaml").read_text()
    assert f"left_knee: {nameless.names['left_knee']}\n" in written
    assert main(["verify", "a.urdf", "b.urdf", "--map", "joints.yaml"]) == 0
    assert "16 of 16 joints match (16 by map)" in capsys.readouterr().out
    assert main(["verify", "a.urdf", "b.urdf", "--map", "joints.yaml", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["by"].values()) == {"map"}
    assert found["equal"] == found["against"] == []


def test_a_map_decides_against_places(tmp_path: Path) -> None:
    nameless = rename_urdf(HUMANOID, 4)
    names = nameless.names
    crossed = {"left_wrist": names["right_wrist"], "right_wrist": names["left_wrist"]}
    verdict = compare(tmp_path, HUMANOID, nameless.data, joint_map=crossed)
    assert not verdict.same
    assert verdict.joints["left_wrist"] == (names["right_wrist"],)
    assert {name for name, how in verdict.by.items() if how == "map"} == crossed.keys()
    assert matched(verdict, names).keys() >= crossed.keys()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("left_kneee: y1\n", "a.yaml:1: error[map-invalid]: the first robot has no joint"),
        ("\nleft_knee: nothing\n", "a.yaml:2: error[map-invalid]: the second robot has no joint"),
        ("left_knee: y1\nright_knee: y1\n", "'y1' is the joint of 'left_knee' and of 'right_knee'"),
        ("left_knee: [y1, y2]\n", "'left_knee' has 1 coordinates, and the map 2"),
        ("left_knee:\n", "'left_knee': None is no joint"),
        (
            "- left_knee: y1\n- left_knee: y2\n",
            "a.yaml:2: error[map-invalid]: 'left_knee' is there",
        ),
        ("just words\n", "this is no map of joints"),
        ("- just words\n", "this is no map of joints"),
        ("left_knee: {a: b}\n", "is no joint"),
        ("left_knee: [\n", "error[config-yaml]"),
    ],
)
def test_a_wrong_map_says_what_is_wrong(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(ConfigError) as error:
        compare(tmp_path, HUMANOID, rename_urdf(HUMANOID, 4).data, joint_map=tmp_path / "a.yaml")
    assert words in str(error.value)


def test_a_map_may_be_a_list(tmp_path: Path) -> None:
    nameless = rename_urdf(HUMANOID, 4)
    lines = [f"- {name}: {other}\n" for name, other in nameless.names.items()]
    (tmp_path / "a.yaml").write_text("".join(lines))
    verdict = compare(tmp_path, HUMANOID, nameless.data, joint_map=tmp_path / "a.yaml")
    assert verdict.same
    assert set(verdict.by.values()) == {"map"}


def test_a_map_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot read the map"):
        compare(tmp_path, HUMANOID, HUMANOID.encode(), joint_map=tmp_path / "none.yaml")


def test_the_verdict_of_json_has_all_that_is_known(tmp_path: Path) -> None:
    verdict = compare(tmp_path, HUMANOID, rename_urdf(HUMANOID, 4).data)
    keys = msgspec.to_builtins(verdict).keys()
    assert {"joints", "by", "equal", "against", "turned", "findings"} <= keys


def test_a_map_is_of_the_robots_as_they_are_named(tmp_path: Path) -> None:
    """An .mbs before a URDF: the map leads from the .mbs to the URDF."""
    nameless = rename_mbs(HUMANOID, 4)
    (tmp_path / "a.mbs").write_bytes(nameless.data)
    (tmp_path / "b.urdf").write_text(HUMANOID)
    joints = {other: name for name, other in nameless.names.items()}
    verdict = verify(tmp_path / "a.mbs", tmp_path / "b.urdf", joint_map=joints)
    assert verdict.same
    assert set(verdict.by.values()) == {"map"}


def test_a_map_takes_the_names_of_a_second_urdf(tmp_path: Path) -> None:
    """Also those that no .mbs could have."""
    second = HUMANOID.replace('"left_knee"', '"2"').replace('"waist"', '"my joint"')
    joints = {"left_knee": "2", "waist": "my joint"}
    verdict = compare(tmp_path, HUMANOID, second.encode(), joint_map=joints)
    assert verdict.same
    assert {name for name, how in verdict.by.items() if how == "map"} == joints.keys()


def test_huge_numbers_are_matched_by_name_alone(tmp_path: Path) -> None:
    huge = change(HUMANOID, *CHANGES["centre"][0]).replace("0.05 0.01 -0.1", "1e160 0 0")
    verdict = compare(tmp_path, huge, rename_urdf(HUMANOID, 1).data)
    assert not verdict.same


def test_joints_of_other_masses_may_not_be_exchanged(tmp_path: Path) -> None:
    """Both ways are wrong, by about as much."""
    first, second = make_hand("thumb", "index"), make_hand("a", "b")
    first = first.replace('value="0.1"', 'value="1"', 1).replace('value="0.1"', 'value="50"', 1)
    second = second.replace('value="0.1"', 'value="20"', 1).replace('value="0.1"', 'value="21"', 1)
    assert compare(tmp_path, first, second.encode()).equal == []
