"""Reading: what is written comes back, the unknown is passed over, what is wrong is one error."""

import contextlib
import re
from pathlib import Path

import pytest
from hypothesis import given
from lxml import etree

from support.mbs_models import everything, few, models
from urdf2mbs.mbs.model import (
    Base,
    Body,
    Drawing,
    Joint,
    Light,
    Mbs,
    Point,
    Shape,
    Viewpoint,
)
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError


@pytest.fixture(params=["minimal.mbs", "walkman_robotran.mbs"])
def sample(request: pytest.FixtureRequest, shared: Path) -> bytes:
    return (shared / "mbs-samples" / request.param).read_bytes()


def seen(data: bytes) -> object:
    """Return what Robotran sees of a file, to compare it.

    That is without white space, comments and the spelling of numbers, and without elements that
    mean the same as a missing one.
    """

    def canonical(element: etree._Element) -> object:
        text = (element.text or "").strip()
        with contextlib.suppress(ValueError):
            text = repr(float(text) + 0.0)
        children = [canonical(child) for child in element if isinstance(child.tag, str)]
        if element.tag == "inertia":
            children = [child for child in children if child[1] != "0.0"]  # type: ignore[index]
        return (element.tag, text, sorted(element.items()), children)

    return canonical(etree.fromstring(data, etree.XMLParser(remove_comments=True)))


def test_everything_comes_back() -> None:
    assert read_mbs(write(everything()), "m.mbs") == everything()


@few
@given(models())
def test_any_model_comes_back(mbs: Mbs) -> None:
    assert read_mbs(write(mbs), "m.mbs") == mbs


def test_writing_a_real_file_again_changes_nothing_that_robotran_sees(sample: bytes) -> None:
    again = write(read_mbs(sample, "sample.mbs"))
    assert seen(again) == seen(sample)
    assert write(read_mbs(again, "again.mbs")) == again


def test_a_real_file_is_read_whole(shared: Path) -> None:
    file = shared / "mbs-samples/walkman_robotran.mbs"
    mbs = read_mbs(file.read_bytes(), str(file))
    assert (mbs.name, mbs.version) == ("walkman_robotran", "0.0.beta")
    assert (mbs.base.name, mbs.base.gravity) == ("Body_0", (0.0, 0.0, -9.81))
    assert len(mbs.bodies) == 35
    assert len(mbs.numbers()) == 55
    assert sum(body.mass or 0.0 for body in mbs.bodies) == pytest.approx(117.75424753)
    waist = mbs.bodies[0]
    assert [joint.type for joint in waist.joints] == ["T1", "T2", "T3", "R1", "R2", "R3"]
    assert waist.joints[2].q == 1.011324
    assert waist.com == (-3.2862932e-5, -5.0930727e-7, -1.2899617e-6)
    assert (waist.parent, waist.point) == (None, None)
    sensor = waist.points[-1].sensor
    assert sensor is not None
    assert sensor.measures == ("Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac")
    assert sum(body.joints[0].symbols == ("q",) for body in mbs.bodies) > 0
    [model] = mbs.user_models
    assert (model.name, len(model.parameters[0].values)) == ("Actuator", 93)
    assert len(mbs.user_variables) == 14
    assert mbs.view is not None
    assert len(mbs.view.lights) == 2


TINY = b"""<?xml version='1.0'?>
<mbsDescR7>
 <base>
  <gravity><coordinates><!-- g --><x>0</x><y>0.</y><z>-9.81E0</z></coordinates></gravity>
  <baseBodyName>ground</baseBodyName>
  <point><pointname>rail</pointname></point>
 </base>
 <bodytree>
  <body>
   <bodyname> a </bodyname>
   <parent><bodyname>base</bodyname><pointname>rail</pointname></parent>
   <joint><jointname>j</jointname><type>R1</type><nature>driven</nature></joint>
   <mass> +.5e1 </mass>
   <point><pointname>p</pointname><coordinates><x>1</x><y>2</y><z>3</z></coordinates></point>
  </body>
  <body>
   <bodyname>b</bodyname>
   <parent><bodyname>a</bodyname><pointname>p</pointname></parent>
   <joint><jointname>k</jointname><type>T2</type><nature>independent</nature></joint>
  </body>
 </bodytree>
</mbsDescR7>
"""


def edited(*changes: tuple[str, str]) -> bytes:
    text = TINY.decode()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text.encode()


def test_a_file_written_by_hand_is_read() -> None:
    mbs = read_mbs(TINY, "tiny.mbs")
    assert (mbs.name, mbs.version, mbs.view) == ("", "", None)
    assert mbs.base.gravity == (0.0, 0.0, -9.81)
    assert mbs.bodies == [
        Body(
            "a",
            None,
            "rail",
            [Joint("j", "R1", "driven")],
            5.0,
            points=[Point("p", (1.0, 2.0, 3.0))],
        ),
        Body("b", "a", "p", [Joint("k", "T2")]),
    ]


def test_unknown_elements_and_attributes_are_passed_over() -> None:
    data = edited(
        ("<gravity>", '<mine a="1"><b>x</b></mine><mine/><gravity unit="m/s2">'),
        (
            "</nature>",
            "</nature><tag/><graphics><x3D><x3D_joint><s>1</s></x3D_joint></x3D></graphics>",
        ),
        ("<bodytree>", '<bodytree note="n"><new q="2"/>'),
        ("</bodytree>", "</bodytree><other>y</other><cuts><spot/></cuts>"),
    )
    assert read_mbs(data, "m.mbs") == read_mbs(TINY, "tiny.mbs")


def test_unknown_elements_in_one_of_several_alike_are_passed_over() -> None:
    data = write(everything())
    more = data.replace(b"<type>lut1D</type>", b"<type>lut1D</type><unit/>")
    more = more.replace(b"<name>sun</name>", b"<name>sun</name><far>1</far>")
    more = more.replace(b"<x3D_shapes>", b"<x3D_shapes><torus><name>t</name></torus>")
    assert more.count(b"<far>") == more.count(b"<unit/>") == 1
    assert b"<torus>" in more
    assert read_mbs(more, "m.mbs") == everything()


@pytest.mark.parametrize(
    ("data", "code", "line", "words"),
    [
        (b"<mbsDescR7>\n<base>", "xml-truncated", 2, ""),
        (b"<mbsDescR7>\n<base></bases></mbsDescR7>", "xml-syntax", 2, "</bases>"),
        (b"<mbsDescR7>\n<<<<<<< HEAD\n<base/>", "merge-conflict", 2, ""),
        (b"<mbsDescR7>\n<base/>\n>>>>>>> theirs\n</mbsDescR7>", "merge-conflict", 3, ""),
        (b"<mbsDescR7>\n\xff\xfe</mbsDescR7>", "xml-syntax", 2, "encoding"),
        (b"\x89PNG\r\n\x1a\n\0\0", "not-xml", 1, ""),
        (b"MBsysPad", "not-xml", 1, ""),
        (b"<robot/>", "not-mbs", 1, "<robot>"),
        (b"<mbsDescR7><bodytree/></mbsDescR7>", "mbs-incomplete", 1, "<base>"),
        (b"<mbsDescR7>\n<base/></mbsDescR7>", "mbs-incomplete", 2, "<gravity>"),
        (
            b"<mbsDescR7>\n<base><gravity><coordinates><x>0</x><y>0</y><z>0</z></coordinates></gravity>"
            b"</base></mbsDescR7>",
            "mbs-incomplete",
            1,
            "<bodytree>",
        ),
        (b"<mbsDescR7>\n<base/>\n<bodytree/></mbsDescR7>", "mbs-incomplete", 2, "gravity"),
        (b'<!DOCTYPE a [<!ENTITY x "y">]><mbsDescR7/>', "xml-entity", 1, ""),
    ],
)
def test_files_that_are_no_mbs_are_refused(data: bytes, code: str, line: int, words: str) -> None:
    fails(data, code, line, words)


@pytest.mark.parametrize("data", [b"", b" \r\n", b"\xef\xbb\xbf\n"])
def test_an_empty_file_is_refused(data: bytes) -> None:
    with pytest.raises(ConversionError) as caught:
        read_mbs(data, "m.mbs")
    assert (caught.value.code, caught.value.file) == ("file-empty", "m.mbs")


@pytest.mark.parametrize(
    ("old", "new", "code", "line", "words"),
    [
        ("<bodyname> a </bodyname>", "", "name-missing", 9, "body"),
        ("<jointname>j</jointname>", "<jointname/>", "name-missing", 12, "joint"),
        ("<jointname>k</jointname>", "<jointname>j</jointname>", "name-doubled", 19, "'j'"),
        ("<bodyname>b<", "<bodyname> a <", "name-doubled", 16, "an earlier body"),
        ("<bodyname>b<", "<bodyname>ground<", "name-doubled", 16, "base"),
        ("<bodyname>b<", "<bodyname>base<", "name-doubled", 16, "ground"),
        ("<pointname>p</pointname><", "<pointname>origin</pointname><", "origin-moved", 14, "'a'"),
        (
            "<pointname>rail</pointname></point>",
            "<pointname>origin</pointname></point>",
            "name-doubled",
            6,
            "base",
        ),
        (
            "</pointname></point>",
            '</pointname><sensor name="s"/></point>',
            "base-sensor",
            6,
            "rail",
        ),
        (
            "</point>\n  </body>",
            "</point><point><pointname>p</pointname></point>\n  </body>",
            "name-doubled",
            14,
            "'p'",
        ),
        ("<bodyname>a</", "<bodyname>aa</", "parent-unknown", 18, "'aa'"),
        ("<bodyname>a</", "<bodyname>b</", "parent-unknown", 18, "'b'"),
        ("<bodyname>base</", "<bodyname>b</", "parent-order", 11, "'b'"),
        (
            "<parent><bodyname>a</bodyname><pointname>p</pointname></parent>",
            "",
            "parent-missing",
            16,
            "'b'",
        ),
        (
            "<pointname>p</pointname></parent>",
            "<pointname>q</pointname></parent>",
            "point-unknown",
            18,
            "body 'a'",
        ),
        (
            "<pointname>rail</pointname></parent>",
            "<pointname>p</pointname></parent>",
            "point-unknown",
            11,
            "the base",
        ),
        (
            "<joint><jointname>k</jointname><type>T2</type><nature>independent</nature></joint>",
            "",
            "body-without-joint",
            16,
            "'b'",
        ),
        ("<type>T2</type>", "<type>T4</type>", "joint-type-unknown", 19, "'T4'"),
        ("<type>T2</type>", "", "joint-type-unknown", 19, "'k'"),
        (">driven<", ">forced driven<", "joint-nature-unknown", 12, "'forced driven'"),
        (">driven<", "><", "joint-nature-unknown", 12, "'j'"),
        (" +.5e1 ", "", "number-invalid", 13, "<mass>"),
        (" +.5e1 ", "nan", "number-invalid", 13, "'nan'"),
        (" +.5e1 ", "1_0", "number-invalid", 13, "'1_0'"),
        (" +.5e1 ", "1e309", "number-invalid", 13, "<mass> is '1e309'; expected a smaller number"),
        (" +.5e1 ", "0x10", "number-invalid", 13, "'0x10'"),
        (" +.5e1 ", "1,5", "number-invalid", 13, "'1,5'"),
        (" +.5e1 ", "٣", "number-invalid", 13, ""),
        ("<y>2</y>", "", "number-missing", 14, "<y>"),
        ("<y>2</y>", "<y>2</y><y>2</y>", "doubled-element", 14, "<y>"),
        ("</mass>", "</mass><mass>1</mass>", "doubled-element", 13, "<mass>"),
        ("</mass>", "</mass><com/>", "mbs-incomplete", 13, "<com>"),
        ("</coordinates></point>", "</coordinates><sensor/></point>", "name-missing", 14, ""),
        (
            "</coordinates></point>",
            '</coordinates><sensor name="s"/></point><point><pointname>t'
            '</pointname><sensor name="s"/></point>',
            "name-doubled",
            14,
            "sensor",
        ),
        (
            "</mass>",
            "</mass><com><!-- x --><coordinates><x>1</x><y>0</y><z>0</z></coordinates></com>",
            "mbs-not-first",
            13,
            "comment",
        ),
        (
            "</mass>",
            "</mass><com><u/><coordinates><x>1</x><y>0</y><z>0</z></coordinates></com>",
            "mbs-not-first",
            13,
            "<u>",
        ),
        ("<gravity>", "<gravity><?p?>", "mbs-not-first", 4, "<gravity>"),
        ("<bodyname> a ", "<!-- a --><bodyname> a ", "mbs-not-first", 10, "<body>"),
        (
            "<joint><jointname>k</jointname><type>T2</type>",
            "<joint><type>T2</type><jointname>k</jointname>",
            "mbs-not-first",
            19,
            "<type>",
        ),
        (
            "<point><pointname>p</pointname>",
            "<point><sensor name='s'/><pointname>p</pointname>",
            "mbs-not-first",
            14,
            "<sensor>",
        ),
        (" +.5e1 ", "5<!-- kg -->0", "mbs-not-plain", 13, "<mass>"),
        (" +.5e1 ", "0<!-- kg -->.5", "mbs-not-plain", 13, "<mass>"),  # a 0 was read before
        ("<jointname>k", "<jointname>k<!-- -->l", "mbs-not-plain", 19, "<jointname>"),
        (
            "</coordinates></point>",
            '</coordinates><extforce name="s" Pos="1"/></point>',
            "value-unknown",
            14,
            "Pos",
        ),
    ],
)
def test_a_fault_in_the_body_tree_is_told_with_its_line(
    old: str, new: str, code: str, line: int, words: str
) -> None:
    fails(edited((old, new)), code, line, words)


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        ("<name>a_ball</name>", "", "name-missing", "ball"),
        ("<endpoint1>", "<endpoint0>", "mbs-incomplete", "<endpoint1>"),
        (
            "<pointname>tip</pointname>\n      </end",
            "<pointname>tap</pointname>\n      </end",
            "point-unknown",
            "'tap'",
        ),
        (
            "<jointname>kick</jointname>\n      </joints>",
            "<jointname>kic</jointname></joints>",
            "joint-unknown",
            "'kic'",
        ),
        ('R="4"', 'R="256"', "number-invalid", "'256'"),
        ('R="4"', 'R="0.5"', "number-invalid", "'0.5'"),
        ('R="4"', "", "number-invalid", "''"),
    ],
)
def test_a_fault_outside_the_body_tree_is_told(old: str, new: str, code: str, words: str) -> None:
    text = write(everything()).decode()
    assert old in text
    text = text.replace(old, new, 1).replace("</endpoint1>", "</endpoint0>", "endpoint0" in new)
    fails(text.encode(), code, None, words)


def test_three_thousand_bodies_in_a_row_are_read() -> None:
    bodies = [Body("b0", joints=[Joint("j0", "R1")])]
    bodies += [Body(f"b{k}", f"b{k - 1}", None, [Joint(f"j{k}", "R1")]) for k in range(1, 3_000)]
    mbs = Mbs("m", bodies=bodies)
    assert read_mbs(write(mbs), "m.mbs") == mbs


def fails(data: bytes, code: str, line: int | None, words: str) -> ConversionError:
    with pytest.raises(ConversionError) as caught:
        read_mbs(data, "m.mbs")
    error = caught.value
    assert (error.code, error.file) == (code, "m.mbs")
    assert error.line is not None
    assert line is None or error.line == line
    assert words in error.message
    return error


def test_mechanics_only_passes_over_graphics(shared: Path) -> None:
    data = (shared / "mbs-samples" / "minimal.mbs").read_bytes()
    model = read_mbs(data, "minimal.mbs")
    mechanics = read_mbs(data, "minimal.mbs", mechanics_only=True)
    assert [body.shapes for body in mechanics.bodies] == [[]] * 4
    for body in model.bodies:
        body.shapes, body.drawing = [], None
        for part in (*body.joints, *body.points):
            part.position = None
    assert mechanics.bodies == model.bodies


def test_a_body_that_is_its_own_parent_is_refused() -> None:
    data = write(Mbs("m", bodies=[Body("arm", joints=[Joint("j", "R1")])]))
    own = data.replace(b"<bodyname>base</bodyname>", b"<bodyname>arm</bodyname>")
    with pytest.raises(ConversionError, match="body 'arm' is its own parent"):
        read_mbs(own, "m.mbs")


def test_what_a_file_leaves_out_is_zero() -> None:
    """Moments of an inertia, and the places, turns and sizes of shapes and drawings."""
    text = write(everything()).decode()
    text = re.sub(r"<Ixy>.*?</Ixy>\s*|<Izz>.*?</Izz>\s*", "", text)
    for tag in ("position", "rotation", "scale", "transparency"):
        text = re.sub(rf"(?s)(<cone>.*?)<{tag}>.*?</{tag}>\s*", r"\1", text, count=1)
    text = re.sub(r"(?s)(<name_pos>.*?)<size>.*?</size>\s*", r"\1", text, count=2)
    mbs = read_mbs(text.encode(), "m.mbs")
    trunk = mbs.bodies[0]
    assert trunk.inertia is not None
    assert [moment == 0.0 for moment in trunk.inertia] == [False, True, False, False, False, True]
    cone = next(shape for shape in trunk.shapes if shape.kind == "cone")
    assert (cone.position, cone.rotation) == ((0.0,) * 3, (0.0,) * 3)
    assert (cone.scale, cone.transparency) == ((1.0,) * 3, 0.0)
    assert mbs.base.drawing is not None
    assert mbs.base.drawing.size == (0.0, 0.0)


def test_what_an_object_is_without_its_elements() -> None:
    """As MBSysPad shows it, and as a script makes it."""
    text = write(everything()).decode()
    for tag in ("viewpoint", "directionalLight", "cylinder", "base_body"):
        text = re.sub(rf"(?s)<{tag}>.*?</{tag}>", f"<{tag}><u/></{tag}>", text, count=1)
    text = re.sub(r"(?s)<background>.*?</background>|<shapeScaleFactors>.*?</shape.*?>", "", text)
    mbs = read_mbs(text.encode(), "m.mbs")
    assert mbs.view is not None
    zero, up = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    eye = Viewpoint("", zero, zero, up, "base", "perspective", 1.0, 0.785, 0.01, 50.0)
    assert mbs.view.viewpoints == [eye]
    assert mbs.view.lights[0] == Light("", zero, "base", False)
    assert (mbs.view.background, mbs.view.frame) == ((153, 153, 255), 0.1)
    assert (mbs.view.joint, mbs.view.com, mbs.view.point) == (0.2, 0.2, 0.3)
    grey, whole = (128, 128, 128), (1.0, 1.0, 1.0)
    assert mbs.bodies[0].shapes[1] == Shape("cylinder", "", zero, zero, whole, grey, 0.0)
    none = (0.0, 0.0)
    assert mbs.base.drawing == Drawing(none, none, (), "rectangle", none, 0.0)
    assert Mbs("m") == Mbs("m", "1.0", Base("ground", (0.0, 0.0, -9.81)))
    assert Light("", zero).active
    assert not Joint("j", "R1").actuated


#: An end of a cut that is not placed yet.
NO_END = b"<bodyname/>\n        <pointname>origin</pointname>"


def test_a_cut_of_which_an_end_is_not_placed_yet_is_read_and_kept() -> None:
    """A draft of MBSysPad; a body must have its parent all the same."""
    text = write(everything())
    end = b"<bodyname>arm</bodyname>\n        <pointname>tip</pointname>"
    assert end in text
    draft = read_mbs(text.replace(end, NO_END, 1), "m.mbs")
    assert [cut.is_draft for cut in draft.cuts] == [True, False, False]
    assert not any(cut.is_draft for cut in everything().cuts)
    assert read_mbs(write(draft), "m.mbs") == draft
    parent = b"<bodyname>trunk</bodyname>\n        <pointname>shoulder</pointname>"
    assert parent in text
    with pytest.raises(ConversionError, match="parent-unknown"):
        read_mbs(text.replace(parent, NO_END, 1), "m.mbs")
