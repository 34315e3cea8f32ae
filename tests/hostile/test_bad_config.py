"""Configs and commands that are wrong, each with its code; and robots that are too large."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.api import convert
from urdf2mbs.cli import main
from urdf2mbs.engine.config import load
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY

#: What follows ``source: tiny.urdf`` in a config, and the code of what is told.
CONFIGS = {
    "output: tiny.urdf": "output-is-source",
    "output: link.urdf": "output-is-source",
    "output: .": "output-is-folder",
    f"output: {'x' * 5000}": "path-invalid",
    'output: "a\\0b"': "path-invalid",
    "pipeline: faithfull": "unknown-preset",
    "diagnostics: {mesh-mising: ignore}": "unknown-code",
    "passes: {mimic: {joints: {nobody: driven}}}": "mimic-joints",
    "passes: {posture: {hold: {joints: [nobody], stiffness: 1, damping: 1}}}": "posture-hold",
    "passes: {loops: {cuts: {c: {ends: [{link: hand}, {link: body}]}}, dependent: [wrist_roll]}}":
        "loops-dependent",
    "passes: {loops: {cuts: {hand: {ends: [{link: hand}, {link: body}]}}}}": "loops-name",
    "passes: {forces: {wrenches: {w: {link: nobody}}}}": "forces-link",
    "passes: {forces: {wrenches: {1w: {link: hand}}}}": "forces-name",
    "passes: {forces: {wrenches: {w: {link: hand, force: [.nan, 0, 0]}}}}": "value-range",
    "passes: {forces: {springs: {s: {ends: [{link: hand}, {link: hand}], stiffness: 1}}}}":
        "forces-spring",
}  # fmt: skip


def codes(folder: Path, more: str) -> list[str]:
    (folder / "tiny.urdf").write_text(TINY)
    (folder / "link.urdf").symlink_to("tiny.urdf")
    (folder / "c.yaml").write_text(f"source: tiny.urdf\n{more}\n")
    try:
        found = Pipeline(*load(folder / "c.yaml"), installed_plugins=False).run().diagnostics
    except ConversionError as error:
        return [*(one.code for one in error.said), error.code]
    return [one.code for one in found]


@pytest.mark.parametrize("more", CONFIGS)
def test_a_bad_config(more: str, tmp_path: Path) -> None:
    assert CONFIGS[more] in codes(tmp_path, more)


def test_all_faults_of_a_config_are_told_at_once(tmp_path: Path) -> None:
    (tmp_path / "c.yaml").write_text(
        "source: tiny.urdf\noutput: {proyect: x}\npipelin: compact\nbase: floatin\n"
        "pipeline: compct\nequations: {}\npackages: {arm: nowhere}\n"
        "diagnostics: {mesh-mising: ignore}\n"
    )
    with pytest.raises(ConversionError) as caught:
        Pipeline(*load(tmp_path / "c.yaml"), installed_plugins=False)
    faults = [*caught.value.said, caught.value]
    assert [(fault.line, (fault.hint or "").partition("did you mean ")[2]) for fault in faults] == [
        (2, "'project'?"), (3, "'pipeline'?"), (4, "'floating'?"), (5, "'compact'?"),
        (6, "'passes: {equations: {}}'?"), (7, ""), (8, "'mesh-missing'?"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("place", "hint"),
    [
        ("sweep: {xacro_arg: {a: [1]}}", "'xacro_args'"),
        ("sweep: {xacro_args: {a: {form: 1, to: 2}}}", "'from'"),
        ("passes: {certificate: {tol: 1}}", "known: "),
        ("passes: {contacts: {zz: 1}, equations: {langage: c}}", "'language'"),
        ("passes: {posture: {hold: {jonts: [a]}}}", "'joints'"),
    ],
)
def test_every_unknown_key_has_a_hint(place: str, hint: str, tmp_path: Path) -> None:
    (tmp_path / "c.yaml").write_text(f"source: tiny.urdf\n{place}\n")
    with pytest.raises(ConversionError) as caught:
        Pipeline(*load(tmp_path / "c.yaml"), installed_plugins=False)
    assert hint in str(caught.value)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["convert", "tiny.urdf", "-o", ""], "usage"),
        (["convert", "tiny.urdf", "--set", "x=1"], "usage"),
        (["convert", "tiny.urdf", "--level", "x"], "usage"),
        (["convert", "tiny.urdf", "-o", "y" * 5000], "path-invalid"),
        (["convert", "z" * 5000], "path-invalid"),
        (["verify", "tiny.urdf", "z" * 5000], "model-unreadable"),
        (["diagram", "z" * 5000], "model-unreadable"),
        (["equations", "z" * 5000], "model-unreadable"),
        (["run", "z" * 5000], "config-unreadable"),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(value)[:30],
)
def test_a_bad_command(
    words: list[str], code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    assert main(words) in (1, 2)
    assert f"error[{code}]" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["tiny.urdf"]


@pytest.mark.parametrize("name", ["none.mbs", "folder"])
def test_every_command_says_the_same_of_an_mbs_that_it_cannot_read(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "folder").mkdir()
    said = set()
    for command in (["verify", "tiny.urdf"], ["diagram"], ["equations"]):
        assert main([*command, name]) == 2
        said.add(capsys.readouterr().err)
    (text,) = said
    assert text.startswith(f"error[model-unreadable]: cannot read '{name}': ")


def test_a_file_without_an_end() -> None:
    if not Path("/dev/zero").exists():
        pytest.skip("there is no /dev/zero here")
    with pytest.raises(ConversionError) as caught:
        convert("/dev/zero")
    assert caught.value.code == "file-unreadable"


def test_ten_thousand_joints_on_one_link(tmp_path: Path) -> None:
    legs = "".join(
        f'<link name="l{n}"/><joint name="j{n}" type="fixed"><parent link="a"/>'
        f'<child link="l{n}"/></joint>\n'
        for n in range(10_000)
    )
    inertial = (
        '<inertial><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    )
    file = tmp_path / "r.urdf"
    file.write_text(f'<robot name="r"><link name="a">{inertial}</link>\n{legs}</robot>')
    result = convert(file)
    assert len(result.robot.joints) > 9_999
    assert result.report.proof is not None
    assert result.report.proof.same


def changed(folder: Path, old: str, new: str, more: str = "") -> list[str]:
    """The codes of the tiny robot with a change, in a project."""
    assert old in TINY
    (folder / "r.urdf").write_text(TINY.replace(old, new, 1))
    (folder / "c.yaml").write_text(f"source: r.urdf\noutput: {{project: p}}\n{more}\n")
    found = Pipeline(*load(folder / "c.yaml"), installed_plugins=False).run().diagnostics
    return [one.code for one in found]


@pytest.mark.parametrize(
    "inside",
    [
        '<joint name="l" type="revolute"><parent>hand</parent><child>body</child>'
        "<axis><xyz>0 0 0</xyz></axis></joint>",
        '<joint name="l" type="revolute"><parent>hand</parent><child>body</child>'
        "<pose>1 2</pose></joint>",
        '<joint name="l" type="ball"><parent>hand</parent><child>body</child>'
        "<pose>nan 0 0</pose></joint>",
        '<joint name="l" type="screw"><parent>hand</parent><child>body</child></joint>',
    ],
)
def test_a_loop_that_cannot_be_read(inside: str, tmp_path: Path) -> None:
    assert "loop-left-out" in changed(tmp_path, "</robot>", f"<gazebo>{inside}</gazebo></robot>")


def test_a_loop_without_an_axis_is_about_z(tmp_path: Path) -> None:
    joint = '<joint name="l" type="revolute"><parent>hand</parent><child>body</child></joint>'
    found = changed(tmp_path, "</robot>", f"<gazebo>{joint}</gazebo></robot>")
    assert "loops" in found
    assert "loop-left-out" not in found


def test_a_mimic_joint_that_is_driven(tmp_path: Path) -> None:
    joint = '<joint name="wrist_roll" type="continuous">'
    found = changed(
        tmp_path, joint, joint + '<mimic joint="shoulder"/>',
        "passes: {mimic: {joints: {wrist_roll: driven}}}",
    )  # fmt: skip
    assert "mimic-driven" in found


def test_a_report_without_an_mbs(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "c.yaml").write_text("source: tiny.urdf\npipeline: [expand, insert-base]\n")
    assert main(["report", str(tmp_path / "c.yaml")]) == 2
    assert "error[no-mbs]" in capsys.readouterr().err
