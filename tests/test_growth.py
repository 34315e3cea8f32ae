"""Work and memory grow no faster than the robot.  Counted, not timed: the calls of functions."""

from __future__ import annotations

import sys
import tracemalloc
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from lxml import etree
from making import read_robot

from urdf2mbs import Result, convert, verify
from urdf2mbs.mbs import reader
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.reader import parse
from urdf2mbs.urdf.values import _says_the_same

LINK = """\
<link name="l{i}">
  <inertial>
    <mass value="1.5"/>
    <inertia ixx="0.011" ixy="0.001" ixz="0" iyy="0.012" iyz="0" izz="0.013"/>
  </inertial>
  <visual><geometry><box size="0.05 0.05 0.2"/></geometry></visual>
</link>
"""
JOINT = """\
<joint name="j{i}" type="{kind}">
  <origin xyz="0 0.01 {z}" rpy="{rpy}"/>
  <parent link="l{parent}"/>
  <child link="l{i}"/>
  <axis xyz="{axis}"/>
  <limit lower="-1.5" upper="1.5" effort="100" velocity="2"/>
  <dynamics damping="0.1"/>
</joint>
"""
FIXED = """\
<joint name="j{i}" type="fixed"><parent link="root"/><child link="l{i}"/></joint>
"""
KINDS = ("revolute", "continuous", "prismatic", "fixed", "revolute")
AXES = ("1 0 0", "0 1 0", "0 0.6 0.8")
RPYS = ("0 0 0", "1.5708 0 0", "0.1 0.2 0.3")


def urdf(shape: str, links: int) -> str:
    parts = ['<robot name="r">\n']
    for i in range(links):
        parts.append(LINK.format(i=i))
        if i:
            parent = {"chain": i - 1, "tree": (i - 1) // 3, "star": 0}[shape]
            parts.append(
                JOINT.format(
                    i=i, parent=parent, kind=KINDS[i % 5], axis=AXES[i % 3], rpy=RPYS[i % 3],
                    z=0.2 + i % 7 / 100,
                )
            )  # fmt: skip
    return "".join([*parts, "</robot>\n"])


def converted(folder: Path, shape: str, links: int) -> Result:
    source = folder / "robot.urdf"
    source.write_text(urdf(shape, links))
    return convert(source)


def calls(what: Callable[[], Any]) -> tuple[int, Any]:
    """How many functions something calls, Python's own included; and what it gives."""
    count = 0

    def profile(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(profile)
    try:
        result = what()
    finally:
        sys.setprofile(None)
    return count, result


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "pipeline"),
    [("chain", "faithful"), ("tree", "faithful"), ("star", "faithful"), ("tree", "compact")],
)
def test_four_times_the_links_are_four_times_the_work(
    shape: str, pipeline: str, tmp_path: Path
) -> None:
    source = tmp_path / "robot.urdf"
    counted = []
    for links in (300, 1200):
        source.write_text(urdf(shape, links))
        count, result = calls(partial(convert, source, pipeline=pipeline))
        assert result.conversion.rejected is None
        counted.append(count)
    assert counted[1] < 4.3 * counted[0]


@pytest.mark.slow
@pytest.mark.parametrize("of_one", [True, False])
def test_four_times_the_exact_doubles_are_four_times_the_work(of_one: bool) -> None:
    counted = []
    for links in (200, 800):
        once = [LINK.format(i=i) + FIXED.format(i=i) for i in range(links)]
        again = [LINK.format(i=0) + FIXED.format(i=0)] * links if of_one else once
        text = "<robot name='r'><link name='root'/>" + "".join([*once, *again]) + "</robot>"
        count, (robot, diagnostics) = calls(partial(parse, text.encode(), "r.urdf"))
        assert len(robot.joints) == links
        assert "doubled-element" in [one.code for one in diagnostics]
        counted.append(count)
    assert counted[1] < 4.3 * counted[0]


def test_a_short_double_of_a_long_link_is_compared_only_as_far_as_it_goes() -> None:
    counted = []
    for visuals in (100, 400):
        first = etree.fromstring(f"<link name='l'>{'<visual/>' * visuals}</link>")
        second = etree.fromstring("<link name='l'/>")
        count, same = calls(partial(_says_the_same, first, second))
        assert not same
        counted.append(count)
    assert counted[0] == counted[1]


@pytest.mark.slow
def test_memory_for_each_link_is_bounded(tmp_path: Path) -> None:
    source = tmp_path / "robot.urdf"
    source.write_text(urdf("tree", 300))
    convert(source)  # what is there once is there
    source.write_text(urdf("tree", 2000))
    tracemalloc.start()
    try:
        result = convert(source)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert result.conversion.proof is not None
    assert result.conversion.proof.same
    assert peak / 2000 < 22_000


def test_ten_thousand_joints_on_one_link(tmp_path: Path) -> None:
    source, output = tmp_path / "star.urdf", tmp_path / "star.mbs"
    source.write_text(urdf("star", 10_001))
    result = convert(source, output=output)
    result.write()
    assert len(result.mbs.bodies) == 10_001
    verdict = verify(str(source), output)
    assert verdict.same
    assert verdict.moving == 8000


# --- lines past the 65,534 that libxml2 can count ---


def test_the_lines_of_a_long_urdf_are_true(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "<robot name='r'>" + "\n" * 70_000 + urdf("tree", 20).partition("\n")[2]
    robot, _ = parse(text.encode(), "r.urdf")
    lines = text.splitlines()
    for joint in robot.joints.values():
        assert joint.line is not None
        assert f'<joint name="{joint.name}"' in lines[joint.line - 1]
    for link in robot.links.values():
        assert link.line is not None
        assert f'<link name="{link.name}"' in lines[link.line - 1]


@pytest.mark.parametrize("mechanics_only", [True, False])
def test_a_line_of_a_long_mbs_is_counted_only_for_an_error(
    mechanics_only: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = partial(reader.read, file="m.mbs", mechanics_only=mechanics_only)
    start = b"<bodytree>"
    data = converted(tmp_path, "chain", 5).data.replace(start, start + b"\n" * 70_000)
    with pytest.raises(ConversionError) as raised:
        read(data.replace(b"<mass>1.5<", b"<mass>heavy<"))
    assert raised.value.line is not None
    assert raised.value.line > 70_000
    assert b"<mass>" in data.splitlines()[raised.value.line - 1]
    monkeypatch.setattr("urdf2mbs.xml.lines._lines", None)
    assert len(read(data).bodies) == 5


def test_ten_megabytes_in_one_attribute_is_an_error_with_its_bound(tmp_path: Path) -> None:
    source = tmp_path / "robot.urdf"
    source.write_text(f"<robot name='r'>\n<link name='{'a' * 10_500_000}'/></robot>")
    with pytest.raises(ConversionError, match="10,000,000") as raised:
        read_robot(source, Packages({}, source), {})
    assert raised.value.code == "xml-too-large"


def test_nearly_that_much_is_read(tmp_path: Path) -> None:
    name = "a" * 9_000_000
    robot, _ = parse(f"<robot name='r'><link name='{name}'/></robot>".encode(), "r.urdf")
    assert list(robot.links) == [name]
