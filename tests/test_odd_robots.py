"""Robots with an oddity each: what converts, what is refused, and what is said of it."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from conftest import SHARED

from urdf2mbs.cli import main
from urdf2mbs.mbs.reader import read

if TYPE_CHECKING:
    from collections.abc import Callable

#: Exit code, code of the error or warning (None: no warning), and a word of its message; by the
#: number of the file in ../shared/odd-robots.
SHARED_ROBOTS: dict[str, tuple[int, str | None, str]] = {
    "01": (0, None, ""),
    "02": (0, "inertia-indefinite", "-3.53486e-08, 3.50085e-08, 9.08701e-08"),
    "03": (0, "mimic-left-out", "'elsewhere', which is no joint, so it is free"),
    "04": (0, "mesh-scale", "taken for all directions: link 'base' (.00254)"),
    "05": (0, "xml-mended", "there are blanks before it"),
    "06": (0, "xml-mended", "no XML version '0.0'"),
    "07": (0, "property-unused", "property 'M_PI'"),
    "08": (0, "xacro-left", "<xacro:v1_pelvis_sensors_usb> was left by xacro: left out"),
    "09": (0, None, ""),
    "10": (0, "number-commas", "numbers are parted by commas"),
    "11": (0, "number-left-out", "lower of <limit> is '-pi/2'"),
    "12": (0, "no-mass", "NO DYNAMICS"),
    "13": (0, "world-implied", "it is implied"),
    "14": (1, "merge-conflict", "a merge conflict was left in the file"),
    "15": (0, "inertia-incomplete", "(ixy, ixz, iyz)"),
    "16": (0, "number-left-out", "<dynamics> is left out"),
    "17": (0, None, ""),
    "18": (0, "package-unresolved", "'pkg' was not found"),
    "19": (0, "xml-mended", "says no version"),
    "20": (0, "xml-mended", "'--' within a comment"),
}


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Callable[..., Any]:
    """Convert a file; the exit code, what was said, and the .mbs that is there."""
    monkeypatch.chdir(tmp_path)

    def convert(source: Path | str, *words: str) -> tuple[int, str, Path]:
        output = tmp_path / "out.mbs"
        output.unlink(missing_ok=True)
        code = main(["convert", "--no-plugins", str(source), "-o", str(output), *words])
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        assert output.exists() == (code == 0)
        assert [file for file in tmp_path.iterdir() if file.name.endswith(".part")] == []
        if code == 0:
            assert "  the same robot" in said.out
            assert read(output.read_bytes(), "").bodies
        return code, said.out + said.err, output

    return convert


def check(run: Callable[..., Any], source: Path, wanted: tuple[int, str | None, str]) -> None:
    exit_code, code, word = wanted
    for preset in ("faithful", "compact"):
        found, said, _ = run(source, "--pipeline", preset)
        assert found == exit_code, said
        assert word in said
        level = "error" if exit_code else "warning"
        told = [line.partition("[")[2].partition("]")[0] for line in said.splitlines()
                if f"{level}[" in line]  # fmt: skip
        # a body that lost its inertia may make the mass matrix singular, too
        told = [one for one in told if one not in ("singular", "base-guessed")]
        assert told == ([] if code is None else [code]), said


def shared_file(number: str) -> Path:
    folder = SHARED / "odd-robots"
    if not folder.is_dir():
        pytest.skip(f"the odd robots are not here: {folder} does not exist")
    return next(folder.glob(f"{number}_*.urdf"))


@pytest.mark.parametrize("number", SHARED_ROBOTS)
def test_shared_odd_robot(number: str, run: Callable[..., Any]) -> None:
    check(run, shared_file(number), SHARED_ROBOTS[number])


def test_the_unknown_macro_is_left_out_if_the_user_says_so(run: Callable[..., Any]) -> None:
    source = shared_file("08")
    for level in ("warning", "note", "ignore"):
        code, said, output = run(source, "--level", f"xacro-left={level}")
        assert code == 0
        assert ("warning[xacro-left]" in said) == (level == "warning")
        assert "--level" not in said  # which is set already
        assert [body.name for body in read(output.read_bytes(), "").bodies] == ["base_body"]


BODY = (
    '<inertial><origin xyz="0 0 0.1"/><mass value="1"/>'
    '<inertia ixx=".01" ixy="0" ixz="0" iyy=".01" iyz="0" izz=".01"/></inertial>'
)
XACRO = ' xmlns:xacro="http://www.ros.org/wiki/xacro"'


def arm(tip: str = "", joint: str = "", kind: str = "continuous", head: str = "") -> str:
    """A base and a tip, both with mass, on one joint."""
    return (
        f'<robot name="r"{head}>\n<link name="base">{BODY}</link>\n'
        f'<link name="tip">{BODY}{tip}</link>\n<joint name="j" type="{kind}">'
        f'<parent link="base"/><child link="tip"/>\n{joint}</joint>\n</robot>'
    )


def inertial(
    mass: str = "1", moments: str = 'ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"'
) -> str:
    return arm().replace(
        f'<link name="tip">{BODY}',
        f'<link name="tip"><inertial><mass value="{mass}"/><inertia {moments}/></inertial>',
    )


def shape(geometry: str, before: str = "", tag: str = "visual", after: str = "") -> str:
    return arm(f"<{tag}>{before}<geometry>{geometry}</geometry>{after}</{tag}>")


LIMITS = '<limit lower="{}" upper="{}" effort="{}" velocity="{}"/>'
#: text, exit code, code, a word of the message
OWN: dict[str, tuple[str, int, str | None, str]] = {
    # limits and the like
    "infinite limits": (
        arm(joint=LIMITS.format("-inf", "1", "1", "1"), kind="revolute"),
        0, "number-left-out", "lower of <limit>",
    ),
    "infinite effort": (
        arm(joint=LIMITS.format(-1, 1, "inf", 1), kind="revolute"),
        0, "number-left-out", "effort of <limit>",
    ),
    "nan velocity": (
        arm(joint=LIMITS.format(-1, 1, 1, "nan"), kind="prismatic"),
        0, "number-left-out", "velocity of <limit>",
    ),
    "empty effort": (
        arm(joint=LIMITS.format(-1, 1, "", 1), kind="revolute"), 0, "number-left-out", "is missing",
    ),
    "friction in words": (
        arm(joint='<dynamics friction="low"/>'), 0, "number-left-out", "'low'",
    ),
    "calibration in words": (
        arm(joint='<calibration rising="x"/>'), 0, "number-left-out", "<calibration>",
    ),
    "safety controller without a gain": (
        arm(joint='<safety_controller soft_lower_limit="0"/>'), 0, "number-left-out", "k_velocity",
    ),
    "multiplier in words": (
        arm(joint='<mimic joint="j" multiplier="-"/>'), 0, "number-left-out", "multiplier",
    ),
    "mimics itself": (arm(joint='<mimic joint="j"/>'), 0, "mimic-left-out", "are free"),
    "mimics nothing": (arm(joint="<mimic/>"), 0, "mimic-left-out", "does not say which"),
    "fixed with an axis of words": (arm(joint='<axis xyz="z"/>', kind="fixed"), 0, None, ""),
    "floating with two numbers": (arm(joint='<axis xyz="0 0"/>', kind="floating"), 0, None, ""),
    "capital type": (arm(kind="Continuous"), 0, "joint-type-spelling", "'continuous'"),
    "type with a blank": (arm(kind="continuous "), 0, "joint-type-spelling", "'continuous'"),
    # shapes
    "scale of four": (
        shape('<mesh filename="m.stl" scale="1 1 1 1"/>'), 0, "number-left-out", "a <visual>",
    ),
    "scale with commas": (
        shape('<mesh filename="m.stl" scale="1,1,1"/>'), 0, "number-left-out", "a <visual>",
    ),
    "collision's scale of one": (
        shape('<mesh filename="m.stl" scale="1e-3"/>', tag="collision"), 0, "mesh-scale", "(1e-3)",
    ),
    "rpy with pi": (
        shape('<sphere radius="1"/>', '<origin rpy="pi/2 0 0"/>'), 0, "number-left-out", "rpy",
    ),
    "rpy of four of a collision": (
        shape('<sphere radius="1"/>', '<origin rpy="0 0 0 1"/>', "collision"),
        0, "number-left-out", "a <collision>",
    ),
    "sphere without a radius": (shape("<sphere/>"), 0, "number-left-out", "radius"),
    "colour of three": (
        shape('<sphere radius="1"/>', after='<material name="a"><color rgba="1 0 0"/></material>'),
        0, "number-left-out", "a colour",
    ),
    # inertia
    "negative mass": (inertial("-1"), 0, "mass-negative", "-1.0 kg"),
    "negative moment": (
        inertial(moments='ixx="-1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"'),
        0, "inertia-indefinite", "principal moments -1, 1, 1",
    ),
    "triangle": (
        inertial(moments='ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="3"'),
        0, "inertia-triangle", "principal moments 1, 1, 3",
    ),
    "products of two": (
        inertial(moments='ixx="1" ixy="0" iyy="1" iyz="0" izz="1"'), 0, "inertia-incomplete", "ixz",
    ),
    "two moments": (inertial(moments='ixx="1" iyy="1"'), 1, "number-missing", "izz"),
    "no tensor": (inertial(moments=""), 0, "inertial-incomplete", "as in ROS"),
    "mass in words": (inertial("heavy"), 1, "number-invalid", "'heavy'"),
    # the tree
    "said twice": (
        arm().replace("</robot>", f'<link name="tip">\n {BODY}</link></robot>'),
        0, "doubled-element", "link 'tip'",
    ),
    "two of one name": (
        arm().replace("</robot>", '<link name="tip"/></robot>'), 1, "name-doubled", "'tip'",
    ),
    "link aside": (
        arm().replace("</robot>", '<link name="world"/></robot>'), 0, "link-unattached", "'world'",
    ),
    "mass aside": (
        arm().replace("</robot>", f'<link name="b">{BODY}</link></robot>'),
        1, "several-roots", "'b'",
    ),
    "implied world that moves": (
        arm().replace("</robot>", '<joint name="w" type="prismatic"><parent link="world"/>'
                      f'<child link="base"/>{LIMITS.format(0, 1, 1, 1)}</joint></robot>'),
        0, "world-implied", "joint 'w'",
    ),
    "unknown child": (arm().replace('"tip"/>', '"world"/>'), 1, "link-unknown", "'world'"),
    "zero axis": (arm(joint='<axis xyz="0 0 0"/>'), 1, "axis-zero", "give a direction"),
    # XML
    "licence first": (
        '<!-- (c) -->\n<?xml version="1.0"?>\n' + arm(), 0, "xml-mended", "before it",
    ),
    "two declarations": (
        '<?xml version="1.0"?>\n<?xml version="1.0"?>\n' + arm(), 0, "xml-mended", "before it",
    ),
    "version 2": ('<?xml version="2.0"?>' + arm(), 0, "xml-mended", "version '2.0'"),
    "dashes": (arm(tip="<!-- ---- a ---- -->"), 0, "xml-mended", "'--' within a comment"),
    "crossed tags": (
        "<robot>\n<link></robot>", 1, "xml-syntax", "</robot> stands where <link> of line 2",
    ),
    "bare ampersand": (arm().replace('"r"', '"a & b"'), 1, "xml-syntax", "&amp;"),
    "no quotes": (arm().replace('"r"', "r"), 1, "xml-syntax", "no quotes around it"),
    "attribute twice": (arm(head=' name="q"'), 1, "xml-syntax", "'name' is there twice"),
    "marker in the middle": (
        arm(tip="\n<<<<<<< HEAD\n=======\n>>>>>>> b\n"), 1, "merge-conflict", "choose one",
    ),
    "cut off": (arm()[:-9], 1, "xml-truncated", "cut off"),
    # numbers
    "decimal comma": (arm(joint='<origin xyz="0,5 0 0"/>'), 1, "number-invalid", "with a point"),
    "commas without blanks": (
        arm(joint='<origin xyz="0,0,1"/>'), 0, "number-commas", "parted by commas",
    ),
    # xacro
    "xacro in a .urdf": (
        arm(head=XACRO).replace("</robot>", '<xacro:property name="x" value="1"/></robot>'),
        0, None, "",
    ),
    "expression in a .urdf": (arm(joint='<origin xyz="${1/2} 0 0"/>'), 0, None, ""),
    "expression of nothing": (arm(joint='<origin xyz="${h} 0 0"/>'), 1, "xacro", "'h'"),
    "expression of gazebo's": (
        arm().replace("</robot>", "<gazebo><a>${robot_name}</a></gazebo></robot>"), 0, None, "",
    ),
    "property without the prefix": (
        arm(joint='<origin xyz="${h} 0 0"/>').replace(
            "</robot>", '<property name="h" value="1"/></robot>'
        ),
        1, "xacro-legacy", "<property>",
    ),
    "include without the prefix": (
        arm().replace("</robot>", '<include filename="a"/></robot>'), 1, "xacro-legacy", "include",
    ),
    "arguments": (
        arm(head=XACRO, joint='<origin xyz="$(arg x) $(arg y) 0"/>'),
        1, "xacro-arg", "'x' is not defined",
    ),
    "package of an include": (
        arm(head=XACRO).replace(
            "</robot>", '<xacro:include filename="$(find gone)/a.xacro"/></robot>'
        ),
        1, "package-not-found", "'gone'",
    ),
    # no mass
    "nothing but a link": ('<robot name="r"><link name="a"/></robot>', 0, "no-mass", "<inertial>"),
    "geometry but no mass": (
        '<robot name="r"><link name="a"><visual><geometry><sphere radius="1"/></geometry></visual>'
        "</link></robot>",
        0, "no-mass", "estimate-inertia",
    ),
    "no link": ('<robot name="r"/>', 1, "no-links", ""),
}  # fmt: skip


@pytest.mark.parametrize("name", OWN)
def test_own_odd_robot(name: str, run: Callable[..., Any], tmp_path: Path) -> None:
    text, *wanted = OWN[name]
    source = tmp_path / "odd.urdf"
    source.write_text(text)
    check(run, source, (wanted[0], wanted[1], wanted[2]))


def test_no_mass_with_either_base(run: Callable[..., Any], tmp_path: Path) -> None:
    source = tmp_path / "odd.urdf"
    text = OWN["geometry but no mass"][0]
    for base, preset in product(("fixed", "floating"), ("faithful", "compact")):
        source.write_text(text)
        code, said, _ = run(source, "--base", base, "--pipeline", preset)
        assert code == 0
        assert "NO DYNAMICS: no link has a mass\n" in said
        # what is already set is not recommended
        _, said, _ = run(
            source, "--base", base, "--pipeline", preset, "--set", "estimate-inertia.density=1000"
        )
        assert "no-mass" not in said
    flat = text.replace('<sphere radius="1"/>', '<box size="1 1 0"/>')
    source.write_text(flat)
    _, said, _ = run(source, "--set", "estimate-inertia.density=1000")
    assert "warning[no-mass]" in said
    assert "estimate-inertia" not in said


def test_the_expanded_text_is_dumped_where_reading_it_fails(
    run: Callable[..., Any], tmp_path: Path
) -> None:
    source = tmp_path / "odd.xacro"
    source.write_text(arm(head=XACRO, joint='<origin xyz="${1} x 0"/>'))
    code, said, _ = run(source, "--dump", "states")
    assert code == 1
    assert "(expanded):" in said
    assert "'urdf2mbs convert --dump DIR' writes it, as DIR/expanded.urdf" in said
    line = int(said.partition("(expanded):")[2].partition(":")[0])
    text = (tmp_path / "states" / "expanded.urdf").read_text()
    assert 'xyz="1 x 0"' in text.splitlines()[line - 1]
    source.write_text(arm())
    run(source.rename(tmp_path / "plain.urdf"), "--dump", "states")
    assert not (tmp_path / "states" / "expanded.urdf").exists()


def test_a_file_that_is_not_there(run: Callable[..., Any], tmp_path: Path) -> None:
    for name in ("fetch.svg", "fetch.urdf", "fetch.ur"):
        (tmp_path / name).touch()
    _, said, _ = run("fetch.urd")
    assert "did you mean 'fetch.urdf'?" in said
    _, said, _ = run("atlas.urdf")
    assert "did you mean" not in said
