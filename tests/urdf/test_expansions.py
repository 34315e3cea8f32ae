"""The cache of expansions: used where nothing has changed, and noticed where anything has."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.urdf import expansions, xacro
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.xacro import Expansion

ROBOT = """\
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="mass" default="1"/>
  <xacro:include filename="part.xacro"/>
  <xacro:include filename="$(find parts)/far.xacro"/>
  <xacro:include filename="more.xacro" optional="true"/>
  <xacro:property name="values" value="${xacro.load_yaml('values.yaml')}"/>
  <link name="base">
    <inertial>
      <mass value="$(arg mass)"/>
      <inertia ixx="${values['i']}" iyy="${near}" izz="${far}" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <link name="side_$(optenv SIDE left)"/>
  <joint name="j" type="fixed">
    <parent link="base"/><child link="side_$(optenv SIDE left)"/>
  </joint>
</robot>
"""
PROPERTY = """\
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="{}" value="{}"/>
</robot>
"""


class Robot:
    """A robot of several files, and how often xacro was run on it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.runs = 0
        self.args: dict[str, str] = {}
        self.package = folder / "parts"
        self.write("robot.urdf.xacro", ROBOT)
        self.write("part.xacro", PROPERTY.format("near", "0.02"))
        self.write("parts/far.xacro", PROPERTY.format("far", "0.03"))
        self.write("other/far.xacro", PROPERTY.format("far", "0.025"))
        self.write("values.yaml", "i: 0.02")

    def write(self, name: str, text: str) -> None:
        file = self.folder / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)

    def expand(self) -> bytes:
        """Through the cache; it must be what xacro itself gives."""
        source = self.folder / "robot.urdf.xacro"
        table = {"parts": self.package}

        def make(source: Path, packages: Packages, args: Mapping[str, str]) -> Expansion:
            self.runs += 1
            return xacro.expand(source, packages, args)

        made = expansions.expand(source, Packages(table, source), self.args, make)
        direct = xacro.expand(source, Packages(table, source), self.args)
        assert made[:3] == direct[:3]
        return made.text


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Robot:
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path / "cache"))
    monkeypatch.delenv("SIDE", raising=False)
    (tmp_path / "robot").mkdir()
    robot = Robot(tmp_path / "robot")
    robot.expand()
    assert robot.runs == 1
    return robot


def test_a_second_time_xacro_does_not_run(robot: Robot) -> None:
    robot.expand()
    (robot.folder / "part.xacro").touch()  # a date is nothing
    robot.expand()
    assert robot.runs == 1


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("robot.urdf.xacro", ROBOT.replace('default="1"', 'default="2"')),
        ("part.xacro", PROPERTY.format("near", "0.021")),
        ("parts/far.xacro", PROPERTY.format("far", "0.031")),
        ("values.yaml", "i: 0.021"),
        ("more.xacro", PROPERTY.format("near", "0.022")),
    ],
)
def test_a_file_that_changes_is_noticed(robot: Robot, name: str, text: str) -> None:
    before = robot.expand()
    robot.write(name, text)
    assert robot.expand() != before
    assert robot.runs == 2


def test_an_argument_a_variable_a_package(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = {robot.expand()}
    robot.args = {"mass": "3"}
    seen.add(robot.expand())
    monkeypatch.setenv("SIDE", "right")
    seen.add(robot.expand())
    robot.package = robot.folder / "other"
    seen.add(robot.expand())
    assert len(seen) == robot.runs == 4


def test_another_version_of_the_program(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expansions, "_version", lambda module: (module, 1, 1))
    robot.expand()
    assert robot.runs == 2


def test_a_pattern_is_never_kept(robot: Robot) -> None:
    text = ROBOT.replace('filename="part.xacro"', 'filename="p*.xacro"')
    robot.write("robot.urdf.xacro", text)
    robot.expand()
    robot.write("pz.xacro", PROPERTY.format("near", "0.023"))
    assert b"0.023" in robot.expand()


def test_a_cache_that_is_broken_or_not_to_be_written(robot: Robot) -> None:
    for file in expansions.cache_folder().rglob("*.json"):
        file.write_bytes(file.read_bytes()[:-9])
    robot.expand()
    assert robot.runs == 2
    for file in sorted(expansions.cache_folder().rglob("*"), reverse=True):
        file.rmdir() if file.is_dir() else file.unlink()
    expansions.cache_folder().rmdir()
    expansions.cache_folder().touch()
    robot.expand()
    robot.expand()
    assert robot.runs == 4


def test_the_cache_does_not_grow_without_end(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expansions, "MOST", 1)
    places = {
        expansions._place(
            robot.folder / "robot.urdf.xacro", Packages({}, robot.folder), {"n": str(n)}
        )
        for n in range(60)
    }
    kept = expansions.Kept(b"", [], [], {}, {}, {})
    for place in places:
        expansions._write(place, kept)
    folders = list(expansions.cache_folder().iterdir())
    assert len(folders) >= len({place.parent for place in places})
    assert all(len(list(folder.iterdir())) == 1 for folder in folders)


def test_no_cache(robot: Robot, tmp_path: Path) -> None:
    kept = sorted(expansions.cache_folder().rglob("*.json"))
    source = str(robot.folder / "robot.urdf.xacro")
    words = [
        "convert",
        source,
        "--package",
        f"parts={robot.package}",
        "-o",
        str(tmp_path / "o.mbs"),
    ]
    packages = {"parts": robot.package}
    args = {"mass": "7"}
    assert main([*words, "--arg", "mass:=7", "--no-cache"]) == 0
    convert(source, packages=packages, xacro_args=args, cache=False)
    assert sorted(expansions.cache_folder().rglob("*.json")) == kept
    data = convert(source, packages=packages, xacro_args=args).data
    assert len(list(expansions.cache_folder().rglob("*.json"))) == len(kept) + 1
    assert convert(source, packages=packages, xacro_args=args).data == data
