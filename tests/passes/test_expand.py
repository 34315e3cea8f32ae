"""Expand: the robot as its file states it, xacro expanded, what was found told."""

from __future__ import annotations

from pathlib import Path

import pytest
from proving import SOLID, joint, link, robot

from urdf2mbs import Result, convert
from urdf2mbs.messages.diagnostics import ConversionError

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


def test_the_robot_is_as_the_file_states_it(tmp_path: Path) -> None:
    text = robot(link("b", SOLID), link("a"), joint("a", "b", "prismatic", axis="0 2 0"))
    result = expanded(tmp_path / "r.urdf", text)
    assert list(result.robot.links) == ["b", "a"]
    assert result.robot.joints["a_to_b"].axis == (0.0, 2.0, 0.0)
    assert result.robot.joints["a_to_b"].type == "prismatic"
    assert result.diagnostics == []


def test_nothing_else_is_made(tmp_path: Path) -> None:
    conversion = expanded(tmp_path / "r.urdf", robot(link("a", SOLID))).conversion
    assert (conversion.segments, conversion.files, conversion.mbs.bodies) == ({}, {}, [])


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


def test_what_the_reader_found_is_told_once(tmp_path: Path) -> None:
    text = robot(link("a", SOLID), link("b", SOLID), joint("a", "b", "revolute"))
    result = expanded(tmp_path / "r.urdf", text.replace("<limit", "<lmit"))
    assert [found.code for found in result.diagnostics].count("joint-limit-missing") == 1


def test_an_error_names_file_and_line(tmp_path: Path) -> None:
    text = robot(link("a"), "\n", joint("a", "nowhere"))
    with pytest.raises(ConversionError) as refused:
        expanded(tmp_path / "r.urdf", text)
    assert refused.value.file == str(tmp_path / "r.urdf")
    assert refused.value.line == 2
