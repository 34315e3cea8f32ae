"""Expand: the robot as its file states it, xacro expanded, what was found told."""

from __future__ import annotations

from pathlib import Path

from proving import SOLID, joint, link, robot
from urdf2mbs import Result, convert

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


def test_what_the_reader_found_is_told_once(tmp_path: Path) -> None:
    text = robot(link("a", SOLID), link("b", SOLID), joint("a", "b", "revolute"))
    result = expanded(tmp_path / "r.urdf", text.replace("<limit", "<lmit"))
    assert [found.code for found in result.diagnostics].count("joint-limit-missing") == 1
