"""Configs and commands that are wrong, each with its code; and robots that are too large."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

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


#: A command, and the code of what is told.
COMMANDS = {
    "convert tiny.urdf -o ": "usage",
    "convert tiny.urdf --set x=1": "usage",
    "convert tiny.urdf --level x": "usage",
    f"convert tiny.urdf -o {'y' * 5000}": "path-invalid",
    f"convert {'z' * 5000}": "path-invalid",
    "convert /dev/zero": "file-unreadable",
    "verify tiny.urdf none.mbs": "model-unreadable",
    "diagram none.mbs": "model-unreadable",
    "equations folder": "model-unreadable",
    f"equations {'z' * 5000}": "model-unreadable",
    f"run {'z' * 5000}": "config-unreadable",
    "report short.yaml": "no-mbs",
}


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[:30])
def test_a_bad_command(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "short.yaml").write_text("source: tiny.urdf\npipeline: [expand, insert-base]\n")
    (tmp_path / "folder").mkdir()
    before = {*tmp_path.iterdir()}
    assert main(command.split(" ")) in (1, 2)
    assert f"error[{COMMANDS[command]}]" in capsys.readouterr().err
    assert {*tmp_path.iterdir()} == before


LOOP = "<parent>hand</parent><child>body</child>"
#: What is added to the tiny robot, a config of its project, and what is said.
CHANGES = {
    "a zero axis": (
        f'<gazebo><joint name="l" type="revolute">{LOOP}<axis><xyz>0 0 0</xyz></axis></joint>'
        "</gazebo>", "", "loop-left-out",
    ),
    "half a pose": (
        f'<gazebo><joint name="l" type="revolute">{LOOP}<pose>1 2</pose></joint></gazebo>', "",
        "loop-left-out",
    ),
    "no number": (
        f'<gazebo><joint name="l" type="ball">{LOOP}<pose>nan 0 0</pose></joint></gazebo>', "",
        "loop-left-out",
    ),
    "a screw": (f'<gazebo><joint name="l" type="screw">{LOOP}</joint></gazebo>', "",
                "loop-left-out"),
    "a loop about z": (f'<gazebo><joint name="l" type="revolute">{LOOP}</joint></gazebo>', "",
                       "loops"),
    "a sensor on no link": ('<gazebo reference="nobody"><sensor name="s" type="imu"/></gazebo>',
                            "", "sensor-left-out"),
    "a sensor on the ground": (
        '<link name="world"/><joint name="w" type="fixed"><parent link="world"/>'
        '<child link="body"/></joint>'
        '<gazebo reference="world"><sensor name="s" type="imu"/></gazebo>',
        "base: fixed", "sensor-left-out",
    ),
    "no mesh": (
        '<link name="foot"><collision><geometry><box size="1 1 1"/></geometry></collision>'
        '<collision><geometry><mesh filename="no.obj"/></geometry></collision></link>'
        '<joint name="f" type="fixed"><parent link="hand"/><child link="foot"/></joint>',
        "passes: {contacts: {links: [foot]}}", "contacts-mesh",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_what_is_left_out_of_a_project(name: str, tmp_path: Path) -> None:
    more, config, code = CHANGES[name]
    (tmp_path / "r.urdf").write_text(TINY.replace("</robot>", f"{more}</robot>"))
    (tmp_path / "c.yaml").write_text(f"source: r.urdf\noutput: {{project: p}}\n{config}\n")
    found = Pipeline(*load(tmp_path / "c.yaml"), installed_plugins=False).run().diagnostics
    assert code in [one.code for one in found]
