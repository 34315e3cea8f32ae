"""xacro in a process of its own: the same robot, or a clear error within its limits."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from urdf2mbs.api import convert
from urdf2mbs.diagnostics import ConfigError, ConversionError
from urdf2mbs.urdf.isolated import Isolate, isolated
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.xacro import expand

LIMITS = Isolate(seconds=20.0, memory="600MiB")
posix = pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")


def xacro(folder: Path, inside: str) -> Path:
    file = folder / "r.urdf.xacro"
    file.write_text(
        f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n{inside}\n</robot>\n'
    )
    return file


def run(file: Path, limits: Isolate = LIMITS, **args: str) -> bytes:
    return isolated(file, Packages({}, file), args, limits).text


@posix
def test_it_gives_what_xacro_gives(tmp_path: Path) -> None:
    (tmp_path / "part.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="b"/></robot>'
    )
    file = xacro(
        tmp_path,
        '<xacro:arg name="n" default="a"/><link name="$(arg n)ä"/>'
        '<xacro:include filename="part.xacro"/>',
    )
    packages = Packages({}, file)
    here = expand(file, packages, {"n": "x", "unused": "1"})
    there = isolated(file, packages, {"n": "x", "unused": "1"}, LIMITS)
    assert there == here._replace(asked=None)  # what may be kept is not asked for there
    assert [one.code for one in there.warnings] == ["xacro-unused-arg"]


@posix
def test_an_error_is_the_same_error(tmp_path: Path) -> None:
    file = xacro(tmp_path, '<xacro:include filename="not_there.xacro"/>')
    found = []
    for how in (lambda: expand(file, Packages({}, file), {}), lambda: run(file)):
        with pytest.raises(ConversionError) as caught:
            how()
        found.append(str(caught.value))
    assert found[0] == found[1]
    table = {"p": tmp_path / "nowhere"}
    file = xacro(tmp_path, '<link name="$(find p)"/>')
    with pytest.raises(ConfigError, match="package-folder"):
        isolated(file, Packages(table, file), {}, LIMITS)


@posix
def test_the_environment_is_empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SECRET", "password")
    file = xacro(tmp_path, '<link name="$(optenv SECRET nothing)"/>')
    assert b"password" in expand(file, Packages({}, file), {}).text
    assert b'"nothing"' in run(file)


@posix
@pytest.mark.parametrize(
    "inside",
    [
        "<link name=\"${len('a' * 10**10)}\"/>",
        '<xacro:property name="a" value="${[0] * 10**9}"/><link name="${len(a)}"/>',
        '<xacro:property name="a" value="aaaaaaaa"/>'
        + "".join(
            f'<xacro:property name="{b}" value="{f"${{{a}}}" * 16}"/>'
            for a, b in zip("abcdefgh", "bcdefghi", strict=True)
        )
        + '<link name="${i}"/>',
    ],
    ids=["text", "list", "laughs"],
)
def test_a_memory_bomb(tmp_path: Path, inside: str) -> None:
    with pytest.raises(ConversionError, match="took more than 600MiB of memory") as caught:
        run(xacro(tmp_path, inside))
    assert caught.value.code == "xacro-isolated"


@posix
def test_a_bomb_of_time(tmp_path: Path) -> None:
    # a power of numbers: an expression that takes hours and little memory
    file = xacro(tmp_path, '<link name="${(7**(10**8)) % 10}"/>')
    with pytest.raises(ConversionError, match="took more than 1 seconds") as caught:
        run(file, Isolate(seconds=1.0))
    assert caught.value.code == "xacro-isolated"


@posix
@pytest.mark.parametrize(
    "inside",
    [
        '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>',
        '<xacro:include filename="r.urdf.xacro"/>',
        '<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/>'
        '<link name="${a}"/>',
    ],
    ids=["macro", "include", "property"],
)
def test_endless_recursion(tmp_path: Path, inside: str) -> None:
    with pytest.raises(ConversionError) as caught:
        run(xacro(tmp_path, inside))
    assert caught.value.code == "xacro"


def test_too_little_for_python_itself(tmp_path: Path) -> None:
    if sys.platform == "win32":
        with pytest.raises(ConfigError) as refused:
            run(xacro(tmp_path, '<link name="a"/>'))
        assert refused.value.code == "isolate-unsupported"
        return
    with pytest.raises(ConversionError) as caught:
        run(xacro(tmp_path, '<link name="a"/>'), Isolate(memory="1MB"))
    assert caught.value.code == "xacro-isolated"


@posix
def test_the_option_of_expand(tmp_path: Path) -> None:
    file = xacro(tmp_path, '<link name="a"/>')
    made = [
        convert(file, options={"expand": options}).data
        for options in ({}, {"isolate": {"seconds": 30, "memory": "1GiB"}}, {"isolate": {}})
    ]
    assert made[0] == made[1] == made[2]
    for bad in ({"memory": "much"}, {"seconds": 0}, {"second": 1}, {"seconds": float("nan")}):
        with pytest.raises(ConfigError):
            convert(file, options={"expand": {"isolate": bad}})
