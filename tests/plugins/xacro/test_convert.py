"""xacro through the passes and commands: arguments, packages, levels, names of files."""

import os
import random
import re
from pathlib import Path
from typing import Any

import pytest

from support.plugin_files import read_robot
from support.urdf_files import WORDS
from urdf2mbs import Result, convert
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.written import find_declaration


def test_the_error_that_ends_a_run_comes_after_what_was_found_before(here: Path) -> None:
    """A macro that is unknown may be why a link is."""
    (here / "tiny.urdf").write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:hand/>\n'
        '<xacro:property name="p" value="1"/>'
        '<link name="a"><x/></link><joint name="j" type="fixed"><parent link="a"/>'
        '<child link="hand"/></joint></robot>'
    )
    for given, codes in (
        ({}, ["xacro-macro-unknown", "link-unknown"]),
        ({"xacro-macro-unknown": "warning"}, ["link-unknown"]),
        (
            {"mechanics-unread": "error"},
            ["xacro-macro-unknown", "mechanics-unread", "link-unknown"],
        ),
    ):
        with pytest.raises(ConversionError) as caught:
            convert("tiny.urdf", diagnostics=given)
        assert re.findall(r"error\[([a-z-]+)\]", str(caught.value)) == codes
        assert caught.value.code == "link-unknown"


XACRO = (
    '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="size" '
    'default="1"/><xacro:include filename="$(find parts)/leg.xacro"/>'
    '<link name="a"><inertial><mass value="${2 * LEGS}"/><inertia ixx="1" ixy="0" ixz="0" '
    'iyy="1" iyz="0" izz="1"/></inertial><visual><geometry><sphere radius="$(arg size)"/>'
    "</geometry></visual></link></robot>"
)


def expanded(source: Path, text: str, **settings: object) -> Result:
    source.write_text(text)
    return convert(source, pipeline=["expand"], **settings)


def test_xacro_takes_its_arguments_and_packages_from_the_settings(tmp_path: Path) -> None:
    package = tmp_path / "somewhere" / "else"
    package.mkdir(parents=True)
    (package / "leg.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:property name="LEGS" value="4"/></robot>'
    )
    settings = {"packages": {"parts": package}, "xacro_args": {"size": "0.25"}}
    body = expanded(tmp_path / "r.xacro", XACRO, **settings).robot.links["a"]
    assert body.inertial.mass == 8.0
    assert body.visuals[0].geometry.radius == 0.25


def test_a_path_is_printed_as_the_user_would_type_it(here: Path, capsys: Any) -> None:
    (here / "below").mkdir()
    (here / "below" / "x.xacro").write_text(TINY.replace("<dynamics", "<dynamic"))
    assert main(["convert", "below/x.xacro", "-o", "b.mbs"]) == 0
    err = capsys.readouterr().err
    places = re.findall(rf"below{re.escape(os.sep)}x.xacro:(\d+): warning", err)
    assert places == ["13", "3"]
    assert err.count("x.xacro") == 2
    assert "(expanded)" not in err


@pytest.mark.parametrize("seed", range(4))
def test_a_damaged_xacro_is_read_or_refused_with_its_file(
    shared: Path, tmp_path: Path, seed: int
) -> None:
    chance = random.Random(seed)
    original = (
        shared / "robots/solo12/robot_properties_solo/src/robot_properties_solo/resources/xacro"
    )
    data = (original / "solo8.urdf.xacro").read_bytes()
    table = {"robot_properties_solo": shared / "robots/solo12/robot_properties_solo"}
    source = tmp_path / "damaged.urdf.xacro"
    for _ in range(5):
        damaged = bytearray(data[: chance.choice([len(data), chance.randrange(len(data))])])
        for _ in range(chance.randrange(1, 4)):
            start = chance.randrange(len(damaged))
            damaged[start : start + chance.randrange(4)] = chance.choice(WORDS)
        source.write_bytes(damaged)
        try:
            read_robot(source, Packages(table, source), {})
        except ConversionError as error:
            file = error.file
            assert file


@pytest.mark.parametrize(
    ("written", "joint", "line"),
    [
        ('<joint name="a_knee" type="x"/>', "a_knee", 1),
        # a transmission's joint is no place, nor is a template where the name stands
        ('<joint name="knee"/>\n<joint name="${s}_knee" type="x"/>', "a_knee", 2),
        ('<joint name="${s}_knee" type="x"/>\n<joint name="a_knee" type="x"/>', "a_knee", 2),
        ('<joint name="${s}_knee" type="x"/>\n<joint name="$(arg n)" type="x"/>', "a_knee", None),
        ('<joint name="${s}_hip" type="x"/>', "a_knee", None),
    ],
)
def test_the_line_that_writes_a_name(
    written: str, joint: str, line: int | None, tmp_path: Path
) -> None:
    file = tmp_path / "a.xacro"
    file.write_text(written)
    place = find_declaration("joint", joint, [str(file)])
    assert place == (None if line is None else (str(file), line))
