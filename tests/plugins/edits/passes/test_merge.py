"""Convert again, from the command line: what is written, kept, planned and refused."""

import json
from pathlib import Path
from random import Random
from typing import Any

import pytest

from support import edits
from urdf2mbs.cli import main
from urdf2mbs.disk.record import is_ours
from urdf2mbs.mbs.model import Point
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs_edits.merge.base_file import is_base

ROBOT = """<robot name="one">
  <link name="body"><inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="arm"><inertial><mass value="2"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="elbow" type="revolute"><parent link="body"/><child link="arm"/>
    <origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
FEEL = '<gazebo reference="arm"><sensor name="feel" type="imu"/></gazebo>'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.urdf").write_text(ROBOT)
    return tmp_path


def change_robot(old: str, new: str) -> None:
    assert old in ROBOT
    Path("one.urdf").write_text(ROBOT.replace(old, new))


def edit(file: str, *made: Any) -> None:
    """Edit and save a file as people do it in MBSysPad."""
    path = Path(file)
    mbs = read_mbs(path.read_bytes(), file)
    for change in made:
        change(mbs, Random(1))
    path.write_bytes(edits.as_saved(write(mbs)))


def convert(*words: str) -> int:
    return main(["convert", "one.urdf", "-o", "one.mbs", *words])


def test_the_base_is_beside_the_output_and_says_of_which_robot(folder: Path) -> None:
    assert convert("-q") == 0
    base = (folder / "one.mbs.base").read_bytes()
    assert is_base(base)
    assert b"made of robot 'one' in one.urdf, sha256 " in base
    assert read_mbs(base, "base") == read_mbs((folder / "one.mbs").read_bytes(), "one")


def test_an_edited_file_is_merged(folder: Path, capsys: Any) -> None:
    assert convert("-q") == 0
    edit("one.mbs", edits.sensor, edits.link)
    change_robot('value="2"', 'value="4"')
    assert convert() == 0
    output = capsys.readouterr().out
    assert "merged with your edits: 1 updated, 2 kept" in output
    assert "the same robot; not compared: " in output
    assert "(added in one.mbs)" in output
    data = (folder / "one.mbs").read_bytes()
    assert b"my_sensor" in data
    assert b"my_link" in data
    assert b"<mass>4.0</mass>" in data
    assert b"\r\n" in data  # it is still the file of MBSysPad
    assert not is_ours(folder / "one.mbs")  # nobody replaces it without a merge
    assert convert("-q") == 0
    assert (folder / "one.mbs").read_bytes() == data


def test_the_plan_writes_nothing_and_is_what_happens(folder: Path, capsys: Any) -> None:
    assert convert("-q") == 0
    edit("one.mbs", edits.sensor)
    change_robot('value="2"', 'value="4"')
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    capsys.readouterr()
    assert convert("--plan") == 0
    output = capsys.readouterr().out
    assert "body 'arm': mass 2 -> 4 kg" in output
    assert "changed files: one.mbs\n" in output  # its base is no file for people
    assert convert("--plan", "--json") == 0
    plan = json.loads(capsys.readouterr().out)
    assert [change["field"] for change in plan["merge"]["updated"]] == ["mass"]
    assert {path: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before
    assert convert("-q") == 0
    changed = {path.name for path, data in before.items() if path.read_bytes() != data}
    assert changed == {".urdf2mbs", "one.mbs", "one.mbs.base"}


def test_the_plan_without_edits_lists_what_changes_in_the_model(folder: Path, capsys: Any) -> None:
    assert convert("-q") == 0
    assert convert("--plan") == 0
    assert "one: the plan; nothing is written\n  nothing changes\n" in capsys.readouterr().out
    change_robot('value="2"', 'value="4"')
    for flag in ((), ("--force",)):
        assert convert("--plan", *flag) == 0
        output = capsys.readouterr().out
        assert "  updated: 1\n    body 'arm': mass 2 -> 4 kg\n" in output
        assert "kept" not in output
        assert "changed files: one.mbs\n" in output
    # to start over gives up an edit, which is a change of the file
    edit("one.mbs", edits.sensor)
    assert convert("--plan", "--force") == 0
    assert "my_sensor" in capsys.readouterr().out
    # a file that is broken is replaced all the same
    Path("one.mbs").write_text("<mbsDescR7>")
    assert convert("--plan", "--force") == 0
    assert "  changed files: one.mbs\n" in capsys.readouterr().out


def test_what_is_computed_anew_is_one_line_of_the_plan(folder: Path, capsys: Any) -> None:
    """Stiffnesses follow from a mass; the damping is as the URDF states it."""
    second = ROBOT[ROBOT.index('  <link name="arm">') : ROBOT.index("</robot>")]
    second = second.replace('"arm"', '"leg"').replace('"elbow"', '"knee"')
    damped = ROBOT.replace('velocity="1"/>', 'velocity="1"/><dynamics damping="0.1"/>')
    text = damped.replace("</robot>", f"{second}</robot>")
    Path("one.urdf").write_text(text)
    words = ["convert", "one.urdf", "-o", "p/", "--base", "fixed"]
    words += ["--set", "posture.hold={frequency: 10, damping_ratio: 0.3}"]
    assert main([*words, "-q"]) == 0
    edit("p/dataR/p.mbs", edits.sensor)
    changed = text.replace('iyy="1"', 'iyy="4"').replace('ping="0.1"', 'ping="0.2"')
    Path("one.urdf").write_text(changed)
    capsys.readouterr()
    assert main([*words, "--plan"]) == 0
    brief = capsys.readouterr().out
    assert "  updated: 4\n    body 'body': inertia " in brief
    assert "    parameter 'elbow' of user model 'damping': values 0.1 -> 0.2\n" in brief
    models = "'stop_stiffness', 'hold_stiffness', 'hold_damping'"
    assert f"  computed anew: 6 values of {models} (-v lists them)\n  kept: " in brief
    assert main([*words, "--plan", "-v"]) == 0
    full = capsys.readouterr().out
    assert "  computed anew: 6\n    parameter 'elbow' of user model 'stop_stiffness': " in full
    assert main([*words, "--plan", "--json"]) == 0
    plan = json.loads(capsys.readouterr().out)["merge"]
    assert len(plan["updated"]) == 10
    assert main(words) == 0
    assert "merged with your edits: 4 updated, 6 computed anew, 1 kept" in capsys.readouterr().out
    # three lines are no more to read than one
    i = changed.rindex('iyy="4"')
    Path("one.urdf").write_text(f'{changed[:i]}iyy="5"{changed[i + 7 :]}')
    assert main([*words, "--plan"]) == 0
    few = capsys.readouterr().out
    assert "  updated: 1\n    body 'leg': inertia " in few
    assert "  computed anew: 3\n    parameter 'knee' of user model " in few


@pytest.mark.parametrize("prefer", ["edited", "{mass: edited}", ""])
def test_both_changed_it_and_the_urdf_wins_unless_the_edit_is_preferred(
    prefer: str, folder: Path, capsys: Any
) -> None:
    assert convert("-q") == 0
    edit("one.mbs", edits.mass)
    for old, new in (("1", "1.5"), ("2", "4")):
        text = Path("one.urdf").read_text()
        Path("one.urdf").write_text(text.replace(f'mass value="{old}"', f'mass value="{new}"'))
    capsys.readouterr()
    assert convert(*["--set", f"merge.prefer={prefer}"] * bool(prefer)) == 0
    output = capsys.readouterr()
    assert "warning[merge-conflict-won]" in output.err
    assert (b"<mass>33" in (folder / "one.mbs").read_bytes()) == bool(prefer)
    assert ("as edited in one.mbs" in output.out) == bool(prefer)


SHORTER = ROBOT[: ROBOT.index('  <link name="arm">')] + "</robot>"


def test_edits_that_lost_their_body_are_listed_and_the_file_is_untouched(
    folder: Path, capsys: Any
) -> None:
    assert convert("-q") == 0
    mbs = read_mbs((folder / "one.mbs").read_bytes(), "one")
    mbs.bodies[-1].points += [Point(name, (0.5, 0.0, 0.0)) for name in ("eye", "hook")]
    (folder / "one.mbs").write_bytes(write(mbs))
    Path("one.urdf").write_text(SHORTER)
    before = {path: path.read_bytes() for path in folder.iterdir()}
    capsys.readouterr()
    assert convert() == 1
    lines = capsys.readouterr().err.splitlines()
    assert sorted(lines[:2]) == [
        f"one.mbs: error[merge-inconsistent]: point '{name}' belongs to body 'arm', "
        "which the URDF removed"
        for name in ("eye", "hook")
    ]
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_a_changed_value_of_a_body_that_the_urdf_removed_is_named(
    folder: Path, capsys: Any
) -> None:
    assert convert("-q") == 0
    text = (folder / "one.mbs").read_text()
    (folder / "one.mbs").write_text(text.replace("<mass>2.0", "<mass>3.0"))
    Path("one.urdf").write_text(SHORTER)
    capsys.readouterr()
    assert convert() == 0
    lost = "body 'arm' was removed by the URDF: body 'arm': mass 2 -> 3 kg"
    assert f"warning[merge-orphaned]: {lost}" in capsys.readouterr().err
    assert not list(folder.glob("*.orphaned.mbs"))


def test_starting_over(folder: Path) -> None:
    assert convert("-q") == 0
    first = (folder / "one.mbs").read_bytes()
    edit("one.mbs", edits.sensor)
    assert convert("-q", "--fresh") == 0
    assert (folder / "one.mbs").read_bytes() == first
    (folder / "two.mbs").write_text("thesis")
    assert main(["convert", "one.urdf", "-o", "two.mbs", "-q", "--fresh"]) == 2  # it never was ours
    assert (folder / "two.mbs").read_text() == "thesis"


def test_another_robot_is_not_merged(folder: Path, capsys: Any) -> None:
    assert convert("-q") == 0
    edit("one.mbs", edits.sensor)
    mine = (folder / "one.mbs").read_bytes()
    Path("two.urdf").write_text(ROBOT.replace('name="one"', 'name="two"'))
    assert main(["convert", "two.urdf", "-o", "one.mbs", "-q"]) == 2
    assert "error[merge-other-robot]" in capsys.readouterr().err
    assert (folder / "one.mbs").read_bytes() == mine


@pytest.mark.parametrize(("file", "name"), [("one.urdf", "two"), ("two.urdf", "one")])
def test_a_robot_or_a_file_may_be_called_otherwise(file: str, name: str, folder: Path) -> None:
    assert convert("-q") == 0
    edit("one.mbs", edits.sensor)
    Path(file).write_text(ROBOT.replace('name="one"', f'name="{name}"'))
    assert main(["convert", file, "-o", "one.mbs", "-q"]) == 0
    assert b"my_sensor" in (folder / "one.mbs").read_bytes()


def test_without_its_base_an_edited_file_is_refused(folder: Path, capsys: Any) -> None:
    assert convert("-q") == 0
    edit("one.mbs", edits.sensor)
    base = folder / "one.mbs.base"
    base.write_bytes(base.read_bytes().replace(b"<mass>1.0", b"<mass>9.0"))
    assert convert("-q") == 2
    assert "error[output-not-ours]" in capsys.readouterr().err


def test_standard_output_is_merged_with_nothing(folder: Path, capsysbinary: Any) -> None:
    assert convert("-q") == 0
    edit("one.mbs", edits.sensor)
    capsysbinary.readouterr()
    assert main(["convert", "one.urdf", "-o", "-", "-q"]) == 0
    assert b"my_sensor" not in capsysbinary.readouterr().out


def test_a_project_follows_the_merged_model(folder: Path) -> None:
    assert main(["convert", "one.urdf", "-o", "p/", "-q"]) == 0
    edit("p/dataR/p.mbs", lambda mbs, _: edits.call("bodies.1.joints.0", "my_joint")(mbs))
    assert main(["convert", "one.urdf", "-o", "p/", "-q"]) == 0
    module = (folder / "p/userfctR/p_robot.py").read_text()
    assert "my_joint" in module


@pytest.mark.parametrize("flag", ["--plan", "--fresh"])
def test_it_is_for_one_robot(flag: str, folder: Path, capsys: Any) -> None:
    Path("one.yaml").write_text("source: one.urdf\n")
    assert main(["run", "one.yaml", "one.yaml", flag]) == 2
    assert f"{flag} is for one robot" in capsys.readouterr().err


def test_json_after_an_edit_of_a_robot_with_a_sensor(folder: Path, capsys: Any) -> None:
    change_robot("</robot>", f"{FEEL}</robot>")
    assert convert("-q") == 0
    text = (folder / "one.mbs").read_text()
    assert "feel" in text
    (folder / "one.mbs").write_text(text.replace("<mass>2.0", "<mass>3.0"))
    capsys.readouterr()
    assert convert("--json") == 0
    assert "feel" in json.dumps(json.loads(capsys.readouterr().out)["passes"]["sensors"])


def test_a_mass_below_zero_in_an_edited_file_is_said(folder: Path, capsys: Any) -> None:
    assert convert("-q") == 0
    text = (folder / "one.mbs").read_text()
    (folder / "one.mbs").write_text(text.replace("<mass>2.0", "<mass>-4"))
    capsys.readouterr()
    assert convert() == 0
    output = capsys.readouterr().err
    assert "warning[mass-negative]" in output
    assert "body 'arm': mass is -4 kg in one.mbs; expected 0 or more" in output
