"""The proof cannot be fooled: by what is no number, by a pass, by stale knowledge, by words."""

import json
from math import inf, nan
from pathlib import Path
from typing import Any

import pytest

from support.planted import MIMIC, NUMBERS
from support.plugin_files import write_plugin
from support.presets import PRESETS
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.conversion import Conversion
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.proof.compare import compare
from urdf2mbs.proof.match import Match
from urdf2mbs.proof.rigid import IDENTITY, Inertia, compare_inertias, compute_frame_deviation
from urdf2mbs.testing import TINY, assert_same_robot, convert_text, run_pass
from urdf2mbs.verification import verify

# --- not a number -------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [inf, -inf, nan])
@pytest.mark.parametrize("where", NUMBERS)
def test_nan_and_infinity_are_differences(where: str, value: float) -> None:
    result = convert_text()
    mbs = read_mbs(result.data, "tiny.mbs")
    if where == "angle" and value == value:
        pytest.skip("an infinite angle has no sine: Python itself refuses it")
    NUMBERS[where](mbs, value)
    found = compare(
        result.robot,
        mbs,
        Match(
            joints={name: tuple(names) for name, names in result.names.coordinates.items()},
            frames=result.frames,
        ),
    )
    assert found.differences
    assert not max(found.largest.values()) <= 1e-9
    json.dumps(found.largest, allow_nan=False)


@pytest.mark.parametrize("bad", [inf, nan])
def test_nan_and_infinity_are_not_equal_to_themselves(bad: float) -> None:
    """The very same tuple on both sides, as where a model is compared that shares its numbers."""
    for index in range(12):
        frame = (*IDENTITY[:index], bad, *IDENTITY[index + 1 :])
        assert compute_frame_deviation(frame, frame, 1.0) > 1e300  # type: ignore[arg-type]
    tensor = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    for inertia in (
        Inertia(bad, (0.0, 0.0, 0.0), tensor),
        Inertia(1.0, (0.0, bad, 0.0), tensor),
        Inertia(1.0, (0.0, 0.0, 0.0), (1.0, 0.0, bad, 1.0, 0.0, 1.0)),
    ):
        assert max(compare_inertias(inertia, inertia, 1.0).values()) > 1e300


@pytest.mark.parametrize("tolerance", [inf, nan, 0.0, -1.0, 1e300, 1.0, 2e-3])
def test_a_tolerance_is_above_zero_and_at_most_1e_3(tolerance: float, tmp_path: Path) -> None:
    model = tmp_path / "tiny.mbs"
    model.write_bytes(convert_text().data)
    with pytest.raises(ConfigError, match="tolerance-invalid"):
        verify("tiny.urdf", model, tolerance=tolerance)


def test_an_overflow_is_an_error_without_traceback() -> None:
    text = TINY.replace('xyz="0.1 0 0.15"', 'xyz="1e308 0 0.15"').replace(
        'xyz="0 0 0.3"', 'xyz="1e308 1e308 1e308"'
    )
    for pipeline in PRESETS:
        with pytest.raises(ConversionError, match=r"has the number (inf|nan), which no") as refused:
            convert_text(text, pipeline=pipeline)
        assert refused.value.code == "mbs-unwritable"


# --- the reference is what was read -------------------------------------------------------------

SCALE = """
for link in conversion.robot.links.values():
    if link.inertial:
        link.inertial.mass /= 2
"""


def test_a_declared_change_is_in_the_verdict(tmp_path: Path) -> None:
    result = run_pass("scale", write_plugin(tmp_path, "scale", SCALE, writes=("robot",)))
    assert result.report.proof is not None
    assert result.report.proof.same
    assert result.report.verdict == "the same robot, but for what scale changed: 3 masses"
    (change,) = result.report.changed
    assert (change.by, change.plugin, change.declared) == ("scale", "scale", True)
    first = change.changes[0]
    assert (first.kind, first.name, first.before, first.after) == ("mass", "body", 2.0, 1.0)
    assert_same_robot(result)


def test_a_change_that_no_pass_declares_is_a_difference(tmp_path: Path, capsys: Any) -> None:
    result = run_pass("scale", write_plugin(tmp_path, "scale", SCALE, reads=("robot",)))
    assert result.report.proof is not None
    assert [d.kind for d in result.report.proof.differences] == ["changed"]
    assert result.report.verdict == "NOT the same robot"
    with pytest.raises(AssertionError, match="scale"):
        assert_same_robot(result)

    (tmp_path / "tiny.urdf").write_text(TINY)
    config = tmp_path / "tiny.yaml"
    config.write_text("source: tiny.urdf\nplugins: [scale.py]\nafter: {expand: scale}\n")
    assert main(["run", str(config)]) == 3
    output = capsys.readouterr()
    assert "scale (plugin 'scale') changed of the robot: 3 masses" in output.err
    assert "writes = ('robot',)" in output.err
    assert not (tmp_path / "tiny.mbs").exists()


def test_a_change_by_a_hook_is_a_difference(tmp_path: Path) -> None:
    file = tmp_path / "plugin.py"
    file.write_text(
        "from urdf2mbs.hookspecs import hookimpl\n"
        "@hookimpl\n"
        "def urdf2mbs_after_pass(pass_, conversion):\n"
        "    if pass_.name == 'expand':\n"
        "        conversion.robot.joints['shoulder'].axis = (1.0, 0.0, 0.0)\n"
    )
    result = convert_text(plugins=[file])
    assert result.report.proof is not None
    assert not result.report.proof.same
    assert "the hook after 'expand'" in result.report.proof.differences[0].message


def test_a_file_changed_after_it_was_checked_is_an_error(tmp_path: Path) -> None:
    changes = """
        output = conversion.settings.output
        conversion.files[output] = conversion.files[output].replace(b"2.0", b"3.0")
    """
    file = write_plugin(tmp_path, "late", changes, reads=("mbs-file",))
    with pytest.raises(ConversionError, match=r"is not the 'robot\.mbs' that was checked"):
        run_pass("late", file, after="check")


# --- natures, names and words -------------------------------------------------------------------

DEPENDENT = """
from urdf2mbs.mbs.model import UserConstraint
for segment in conversion.segments.values():
    for step in segment.steps:
        if step.joint.mimic:
            step.coordinates[0].nature = "dependent"
            conversion.mbs.user_constraints.append(
                UserConstraint("follows", (step.joint.mimic.joint, step.joint.name)))
            conversion.settle("axis-aligned", joint=step.joint.name)
"""


def test_counts_and_warnings_are_of_the_finished_mbs(tmp_path: Path, capsys: Any) -> None:
    free = convert_text(MIMIC)
    assert "mimic" in {diagnostic.code for diagnostic in free.diagnostics}
    assert free.report.joints.independent == 9

    couple = write_plugin(tmp_path, "couple", DEPENDENT, writes=("joints",))
    coupled = run_pass("couple", couple, after="decompose-joints", robot=MIMIC)
    assert "mimic" not in {diagnostic.code for diagnostic in coupled.diagnostics}
    joints = coupled.report.joints
    assert (joints.independent, joints.dependent) == (8, 1)
    assert coupled.report.proof is not None
    assert coupled.report.proof.same
    assert str(joints).startswith(f"{joints.mbs} joints: 8 independent, 1 dependent, ")


def test_an_earlier_warning_can_be_withdrawn() -> None:
    made = convert_text().conversion
    conversion = Conversion(made.settings)
    conversion.warn("a", "one", joint="j")
    conversion.warn("a", "two", joint="k")
    conversion.note("b", "three", link="l")
    assert conversion.settle("a", joint="k") == 1
    assert conversion.settle("b", link="m") == 0
    assert [diagnostic.message for diagnostic in conversion.diagnostics] == ["one", "three"]
    assert conversion.settle("a") == 1


IMU = """<robot name="r">
  <link name="world"/>
  <link name="trunk"><inertial><mass value="2"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="imu"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j" type="continuous"><parent link="world"/><child link="trunk"/></joint>
  <joint name="k" type="fixed"><parent link="trunk"/><child link="imu"/>
    <origin xyz="0 0 0.1" rpy="RPY"/></joint>
</robot>"""


def test_a_rotated_sensor_frame_is_a_difference_if_asked_for(tmp_path: Path, capsys: Any) -> None:
    here, turned = tmp_path / "here.urdf", tmp_path / "turned.urdf"
    here.write_text(IMU.replace("RPY", "0 0 0"))
    turned.write_text(IMU.replace("RPY", "0 0 3.141592653589793"))
    model = tmp_path / "turned.mbs"
    model.write_bytes(convert(turned).data)
    assert main(["verify", str(here), str(model)]) == 0
    assert "1 frame of links and points elsewhere than by the URDF" in capsys.readouterr().out
    assert main(["verify", str(here), str(model), "--frames"]) == 3
    out = capsys.readouterr().out
    assert "link 'imu': frame is rotated by 3.14159 about z" in out
    assert "NOT the same robot" in out
    assert main(["verify", str(turned), str(model), "--frames"]) == 0


OWN = IMU.replace('name="j" type="continuous"', 'name="free" type="floating"')


def summary(text: str, tmp_path: Path, capsys: Any, *more: str) -> str:
    source = tmp_path / "r.urdf"
    source.write_text(text.replace("RPY", "0 0 0"))
    assert main(["convert", str(source), "-o", str(tmp_path / "r.mbs"), "-v", *more]) == 0
    return "".join(capsys.readouterr())


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("base", ["fixed", "floating", "auto"])
def test_a_base_with_six_free_coordinates_floats(
    base: str, preset: str, tmp_path: Path, capsys: Any
) -> None:
    out = summary(OWN, tmp_path, capsys, "--base", base, "--pipeline", preset)
    assert "6 independent" in out
    assert "floating base: joint 'free' lets it float" in out
    assert "fixed base" not in out
    assert main(["verify", str(tmp_path / "r.urdf"), str(tmp_path / "r.mbs")]) == 0
    assert "'free' floats" in capsys.readouterr().out


def test_a_floating_joint_after_another_joint_leaves_the_base_fixed(
    tmp_path: Path, capsys: Any
) -> None:
    text = IMU.replace('name="k" type="fixed"', 'name="free" type="floating"')
    out = summary(text, tmp_path, capsys)
    assert "7 independent" in out
    assert "fixed base: root link 'world' is called world" in out
