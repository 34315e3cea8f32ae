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

from urdf2mbs import Result, convert, verify
from urdf2mbs.diagnostics import ConversionError
from urdf2mbs.mbs import reader
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.reader import parse, read_robot
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


@pytest.fixture
def large(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every file is treated as a large one."""
    monkeypatch.setattr("urdf2mbs.xml_lines.LARGE", 0)
    monkeypatch.setattr("urdf2mbs.urdf.reader.LARGE", 0)
    monkeypatch.setattr("urdf2mbs.mbs.writer.INDENTED", 0)


@pytest.mark.any_python
@pytest.mark.usefixtures("large")
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


@pytest.mark.any_python
@pytest.mark.parametrize("of_one", [True, False])
def test_four_times_the_exact_doubles_are_four_times_the_work(
    of_one: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("urdf2mbs.urdf.reader.LARGE", 2**30)  # the first ones are to be there
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


@pytest.mark.any_python
@pytest.mark.usefixtures("large")
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
    assert peak / 2000 < 13_000


def test_ten_thousand_joints_on_one_link(tmp_path: Path) -> None:
    source, output = tmp_path / "star.urdf", tmp_path / "star.mbs"
    source.write_text(urdf("star", 10_001))
    result = convert(source, output=output)
    result.write()
    assert len(result.mbs.bodies) == 10_001
    verdict = verify(str(source), output)
    assert verdict.same
    assert verdict.schema == []
    assert verdict.moving == 8000


# --- a large file, read piece by piece, is what it is as a whole ---


def both_ways(data: bytes, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Any]:
    monkeypatch.setattr("urdf2mbs.xml_lines.LIMIT", 0)  # so that lines are counted, too
    monkeypatch.setattr("urdf2mbs.urdf.reader.LARGE", 2**30)
    whole = parse(data, "r.urdf")
    monkeypatch.setattr("urdf2mbs.urdf.reader.LARGE", 0)
    return whole, parse(data, "r.urdf")


SPRINKLED = """<!-- a comment --> text
<gazebo reference="l1">
  <link name="of another program"/>
</gazebo>
<material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
<gazebo><joint name="not one of ours"/></gazebo>
<link
   name="more"><visual unknown="1"><geometry><sphere
     radius="1"/></geometry></visual><nothing/></link>
<?pi in between?>
<joint name="last" type="fixed"><parent link="l0"/>
<child link="more"/></joint>
<sensor name="s"/>
"""


def test_a_robot_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    text = urdf("tree", 60).replace("</robot>", f"{SPRINKLED}</robot>")
    whole, pieces = both_ways(text.encode(), monkeypatch)
    assert pieces == whole
    robot, diagnostics = pieces
    assert [one.code for one in diagnostics].count("unknown-attribute") == 1
    assert [extension.tag for extension in robot.extensions] == ["gazebo", "gazebo", "sensor"]
    lines = text.splitlines()
    for joint in robot.joints.values():
        assert f'<joint name="{joint.name}"' in lines[joint.line - 1]
    for link in robot.links.values():
        assert link.line is not None
        assert lines[link.line - 1].startswith("<link")
        for visual in link.visuals:
            assert "<visual" in lines[visual.line - 1]


@pytest.mark.parametrize(
    "text",
    [
        "<robot name='r'/>",
        "<robot name='r'><link name='a'/><link name='b'/></robot>",
        "<robot name='r'><link name='a'/><joint name='j' type='fixed'/></robot>",
        "<robot name='r'><link name='a'/><link name='a'/></robot>",
        "<robot name='r'><link name='a'/><link name='a'><visual/></link></robot>",
        "<robot name='r'><link name='a'/><link name='b'>",
        "<robot name='r'><!-- -- --><link name='a'/></robot>",
        "<robot name='r'><link name='a'/></robot><robot/>",
        "<r:robot xmlns:r='urn:r' name='r'><r:link name='a'/></r:robot>",
        "<robot xmlns='urn:r' name='r'><link name='a'/></robot>",
        "<!DOCTYPE robot [<!ENTITY e 'a'>]><robot name='r'><link name='&e;'/></robot>",
        "<sdf><link name='a'/></sdf>",
        "<robot name='r'><link name='a' xml:id='i'/><gazebo xml:id='i'/></robot>",
        "<sdf><robot name='r'><link name='a'/></robot></sdf>",
        "<!-- long before --><robot name='r'><!-- alone --></robot>",
        "<!-- long before --><robot name='r'><!-- first --><link name='a'/><!-- last --></robot>",
    ],
)
def test_so_is_what_is_said(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def said(data: bytes) -> Any:
        try:
            return parse(data, "r.urdf")
        except ConversionError as error:
            return [str(error), *map(str, error.said)]

    whole = said(text.encode())
    monkeypatch.setattr("urdf2mbs.urdf.reader.LARGE", 0)
    monkeypatch.setattr("urdf2mbs.xml_lines._PIECE", 7)
    assert said(text.encode()) == whole


def test_a_large_file_is_read_once_where_nothing_is_wrong(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    data = urdf("chain", 20).encode()
    monkeypatch.setattr("urdf2mbs.urdf.reader.LARGE", 0)
    monkeypatch.setattr("urdf2mbs.urdf.xml.parse", None)
    assert len(parse(data, "r.urdf")[0].links) == 20


def test_an_mbs_is_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = converted(tmp_path, "tree", 40)
    data = result.data
    whole = [reader.read(data, "m.mbs"), reader.read(data, "m.mbs", mechanics_only=True)]
    monkeypatch.setattr("urdf2mbs.xml_lines.LARGE", 0)
    monkeypatch.setattr("urdf2mbs.mbs.reader._parse", None)
    assert reader.read(data, "m.mbs") == whole[0]
    assert reader.read(data, "m.mbs", mechanics_only=True) == whole[1]
    known = reader.read(data, "m.mbs", mechanics_only=True, known=result.mbs.bodies)
    assert all(one is other for one, other in zip(known.bodies, result.mbs.bodies, strict=True))


def test_a_body_that_carries_all_others_is_never_there_with_all_its_graphics(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = converted(tmp_path, "star", 40).data
    whole = reader.read(data, "m.mbs", mechanics_only=True)
    left: list[int] = []

    def strip(element: Any) -> None:
        left.append(sum(1 for _ in element.iter("graphics")))
        strip_rest(element)

    strip_rest = reader._only_mechanics
    monkeypatch.setattr("urdf2mbs.xml_lines.LARGE", 0)
    monkeypatch.setattr("urdf2mbs.xml_lines._PIECE", 100)
    monkeypatch.setattr("urdf2mbs.mbs.reader._only_mechanics", strip)
    monkeypatch.setattr("urdf2mbs.mbs.reader._parse", None)
    assert reader.read(data, "m.mbs", mechanics_only=True) == whole
    assert len(left) > 40
    assert not any(left)


def test_lines_of_a_long_mbs_are_counted_only_for_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = converted(tmp_path, "chain", 5).data
    monkeypatch.setattr("urdf2mbs.xml_lines.LIMIT", 0)
    with pytest.raises(ConversionError) as raised:
        reader.read(data.replace(b"<mass>1.5<", b"<mass>heavy<"), "m.mbs")
    assert raised.value.line is not None
    assert b"<mass>" in data.splitlines()[raised.value.line - 1]
    monkeypatch.setattr("urdf2mbs.xml_lines._lines", None)
    assert len(reader.read(data, "m.mbs").bodies) == 5


def test_a_body_that_differs_is_the_one_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = converted(tmp_path, "chain", 5)
    monkeypatch.setattr("urdf2mbs.xml_lines.LARGE", 0)
    edits = [
        ("<mass>1.5<", "<mass>1.25<"), ("<Ixx>", "<Ixx>1"), ("<y>0.01</y>", "<y>0.02</y>"),
        ("<type>R2<", "<type>R3<"), (">independent<", ">driven<"), ("<pointname>l", "<pointname>m"),
    ]  # fmt: skip
    for old, new in edits:
        text = result.data.decode()
        assert old in text
        edited = text.replace(old, new).encode()
        found = reader.read(edited, "m.mbs", mechanics_only=True, known=result.mbs.bodies)
        alone = reader.read(edited, "m.mbs", mechanics_only=True)
        stripped = reader.read(result.data, "m.mbs", mechanics_only=True)
        assert alone != stripped
        for one, other in zip(found.bodies, alone.bodies, strict=True):
            assert reader._mechanics(one) == reader._mechanics(other)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("</mbsDescR7>", ""), ("<bodyname>l3<", "<bodyname>l2<"), ("<base>", "<base><base/>"),
        ("<pointname>l3<", "<pointname>nowhere<"), ("<mass>1.5", "<mass>heavy"),
        ("<bodytree>", "<bodytree/><bodytree>"), ("mbsDescR7", "mbsDescR8"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_an_mbs_is_said_the_same(
    old: str, new: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = converted(tmp_path, "chain", 5).data.decode().replace(old, new).encode()

    def said() -> Any:
        try:
            return reader.read(data, "m.mbs")
        except ConversionError as error:
            return str(error)

    whole = said()
    monkeypatch.setattr("urdf2mbs.xml_lines.LARGE", 0)
    assert said() == whole


def test_bodies_before_the_base_and_elements_of_others(monkeypatch: pytest.MonkeyPatch) -> None:
    body = (
        "<body><bodyname>b</bodyname><parent><bodyname>base</bodyname><pointname>origin"
        "</pointname></parent><joint><jointname>j</jointname><type>R1</type>"
        "<nature>independent</nature></joint></body>"
    )
    base = "<base><gravity><coordinates><x>0</x><y>0</y><z>-9.81</z></coordinates></gravity></base>"
    data = (
        f"<mbsDescR7><bodytree>{body}</bodytree><other><bodytree>{body}<base/></bodytree></other>"
        f"{base}</mbsDescR7>"
    ).encode()
    whole = reader.read(data, "m.mbs")
    monkeypatch.setattr("urdf2mbs.xml_lines.LARGE", 0)
    assert reader.read(data, "m.mbs") == whole
    assert [body.name for body in whole.bodies] == ["b"]


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
