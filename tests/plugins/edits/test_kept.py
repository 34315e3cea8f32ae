"""What the model does not know of a file is kept as it stands, and so is what was not changed."""

import pickle
import re
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree

from support.edits import rename_part
from support.folders import SHARED
from support.mbs_models import everything, few
from support.merges import canonical
from urdf2mbs.mbs import writer
from urdf2mbs.mbs.model import Body, Joint, Mbs, Parameter, Point, Sensor
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs_edits.diff.table import list_entities, make_table
from urdf2mbs_edits.merge.merge import merge

SAMPLES = sorted([*SHARED.glob("mbs-samples/*.mbs"), *SHARED.glob("mbs-samples/saved/ur5*.mbs")])


def write(mbs: Mbs) -> bytes:
    """The file of a model that was read, in which a URDF changed what is changed in the model."""
    if mbs.origin is None:
        return writer.write(mbs)
    source = mbs.origin.source
    base = writer.write(read_mbs(source, "base"))
    new = read_mbs(writer.write(mbs), "new")
    return merge(read_mbs(base, "base"), read_mbs(source, "ours"), new, None).data


def sample(name: str) -> bytes:
    if not SAMPLES:
        pytest.skip(f"the real files are not here: {SHARED} does not exist")
    return (SHARED / "mbs-samples" / name).read_bytes()


def texts(root: etree._Element, old: str, new: str, *tags: str) -> None:
    for element in root.iter(*tags):
        if element.text == old:
            element.text = new


# --- the real files ---


@pytest.mark.skipif(not SAMPLES, reason=f"the real files are not here: {SHARED} does not exist")
@pytest.mark.parametrize(
    "file",
    [
        pytest.param(file, id=file.stem, marks=[pytest.mark.slow] * (k % 4 > 0))
        for k, file in enumerate(SAMPLES)
    ],
)
def test_a_real_file_stays_but_for_what_is_changed(file: Path) -> None:
    data = file.read_bytes()
    mbs = read_mbs(data, file.name)
    assert write(mbs) == data

    expected = etree.fromstring(data)
    if mbs.bodies:
        body = mbs.bodies[-1]
        old = body.name
        rename_part(mbs, body, "renamed")
        texts(expected, old, "renamed", "bodyname")
        body.joints[0].position = (1.5, 2.0)
        place = expected.findall("bodytree/body")[-1].find("joint/graphics/x2D/position")
        assert place is not None
        place[0].text, place[1].text = "1.5", "2.0"
        for heavy, mass in zip(
            [body for body in mbs.bodies if body.mass is not None][:1],
            expected.findall("bodytree/body/mass")[:1],
            strict=True,
        ):
            heavy.mass = 12345.0
            mass.text = "12345.0"
    mbs.name = "other"
    texts(expected, expected.findtext("mbsname") or "", "other", "mbsname")
    again = write(mbs)
    assert canonical(etree.fromstring(again)) == canonical(expected)
    # line by line, too: only the lines that hold the changes differ
    changed = sum(a != b for a, b in zip(data.splitlines(), again.splitlines(), strict=True))
    assert changed <= 5 + data.count(f">{old}<".encode() if mbs.bodies else b"!")
    assert read_mbs(again, file.name) == mbs


def test_a_force_that_goes_to_another_point_takes_its_arrows_along() -> None:
    mbs = read_mbs(sample("emecdelam-Jpp.mbs"), "m.mbs")
    body = next(b for b in mbs.bodies for p in b.points if p.extforce and p.name == "origin")
    point = next(point for point in body.points if point.name == "origin")
    target = Point("elsewhere", (1.0, 2.0, 3.0), (0.0, 0.0), extforce=point.extforce)
    body.points = [p for p in body.points if p is not point] + [target]
    root = etree.fromstring(write(mbs))
    [force] = root.xpath("//point[pointname='elsewhere']/extforce")
    assert [child.tag for child in force.find("x3D")] == ["force", "torque"]
    assert target.extforce is not None
    assert len(root.xpath(f"//extforce[@name='{target.extforce.name}']")) == 1


def test_line_ends_and_the_first_line_are_those_of_the_file() -> None:
    data = b"\xef\xbb\xbf" + write(everything()).replace(b"\n", b"\r\n").rstrip()
    mbs = read_mbs(data, "m.mbs")
    mbs.bodies[0].mass = 77.0
    again = write(mbs)
    assert again.startswith(b"\xef\xbb\xbf<?xml")
    assert again.count(b"\r\n") == again.count(b"\n") == data.count(b"\n")
    assert not again.endswith(b"\n")
    latin = write(everything()).replace(b"UTF-8", b"ISO-8859-1").replace(b"machine", b"m\xfcller")
    mbs = read_mbs(latin, "m.mbs")
    assert mbs.name == "müller"
    mbs.bodies[0].mass = 77.0
    assert b"m\xfcller" in write(mbs)
    assert read_mbs(write(mbs), "m.mbs") == mbs


# --- our own files, with anything in them ---

OWN = write(everything())
#: In these, something must stand first.
FIRST = {"bodyname", "jointname", "pointname", "coordinates"}
NUMBERS = {"x", "y", "z", "mass", "Ixx", "Iyy", "Izz", "q", "radius", "length", "angle", "frame"}


@st.composite
def sprinkled(draw: st.DrawFn) -> bytes:
    """Our own file with unknown elements, comments and attributes, and other spellings."""
    root = etree.fromstring(OWN)
    elements = [element for element in root.iter("*") if len(element)]
    for _ in range(draw(st.integers(1, 12))):
        place = draw(st.sampled_from(elements))
        kind = draw(st.sampled_from(["mine", "at", "mass", "comment", "attribute", "text"]))
        if kind == "attribute":
            name = draw(st.sampled_from(["note", "at", "Pos2"]))
            place.set(name, draw(st.text("ab<&\"'", max_size=4)))
            continue
        if kind == "text":
            place[-1].tail = f"{place[-1].tail} stray"
            continue
        if kind == "mass" and place.tag not in ("joint", "point", "cuts", "mbsDescR7", "lights"):
            kind = "mine"
        made: Any = etree.Comment(" why ") if kind == "comment" else etree.Element(kind, at="3")
        if kind != "comment" and draw(st.booleans()):
            etree.SubElement(made, "body").text = " 1.50 "
        least = 1 if place[0].tag in FIRST else 0
        place.insert(draw(st.integers(least, len(place))), made)
    numbers = [element for element in root.iter(*NUMBERS) if element.text and not len(element)]
    for element in draw(st.lists(st.sampled_from(numbers), max_size=8)):
        value = float(element.text or "")
        spelled = draw(st.sampled_from(["{:.17E}", " {!r}\n", "+{!r}", "{!r}"]))
        element.text = spelled.format(value)
    return etree.tostring(root)


def mass(mbs: Mbs, root: Any) -> None:
    mbs.bodies[0].mass = 99.0
    root.find("bodytree/body/mass").text = "99.0"


def start(mbs: Mbs, root: Any) -> None:
    mbs.bodies[0].joints[1].q = -1e-9
    root.findall("bodytree/body/joint")[1].find("initialvalue/q").text = "-1e-09"


def joint_name(mbs: Mbs, root: Any) -> None:
    mbs.bodies[0].joints[0].name = "rise"
    root.find("bodytree/body/joint/jointname").text = "rise"


def shape_kind(mbs: Mbs, root: Any) -> None:
    mbs.bodies[0].shapes[1].kind = "cone"
    root.find("bodytree/body/graphics/x3D/x3D_shapes/cylinder").tag = "cone"


def measures(mbs: Mbs, root: Any) -> None:
    sensor = mbs.bodies[0].points[1].extforce
    assert sensor is not None
    sensor.measures = ("Pos",)
    force = root.find(".//extforce")
    for name in ("Rot", "Vit", "Om", "Acc", "Omp"):
        del force.attrib[name]


def no_link(mbs: Mbs, root: Any) -> None:
    del mbs.links[0]
    remove(root.find("links/link"))


def no_cuts(mbs: Mbs, root: Any) -> None:
    """A list keeps what the model does not know of it."""
    mbs.cuts = []
    cuts = root.find("cuts")
    for tag in ("ball", "rod", "solid"):
        remove(cuts.find(tag))
    if not len(cuts) and not (cuts.text or "").strip():
        remove(cuts)


def no_com(mbs: Mbs, root: Any) -> None:
    mbs.bodies[0].com = None
    remove(root.find("bodytree/body/com"))


def a_point(mbs: Mbs, root: Any) -> None:
    body = mbs.bodies[2]
    body.points.append(Point("new", (1.0, 2.0, 3.0)))
    point = etree.fromstring(
        "<point><pointname>new</pointname><coordinates><x>1.0</x><y>2.0</y><z>3.0</z>"
        "</coordinates><graphics><x3D/></graphics></point>"
    )
    after = root.findall("bodytree/body")[2].find("joint")
    after.addnext(point)


def remove(element: Any) -> None:
    """Take an element away; text after it stays."""
    before, tail = element.getprevious(), element.tail or ""
    if before is not None:
        before.tail = (before.tail or "") + tail
    else:
        element.getparent().text = (element.getparent().text or "") + tail
    element.getparent().remove(element)


EDITS: list[Callable[[Mbs, Any], None]] = [
    mass,
    start,
    joint_name,
    shape_kind,
    measures,
    no_link,
    no_cuts,
    no_com,
    a_point,
]


def test_what_stands_in_a_place_goes_with_it() -> None:
    """A <com> without coordinates could not be read, and no merge would end."""
    root = etree.fromstring(OWN)
    place = root.find("bodytree/body/com")
    place.set("note", "why")
    etree.SubElement(place, "mine").text = "3"
    mbs = read_mbs(etree.tostring(root), "m.mbs")
    mbs.bodies[0].com = None
    assert b"<mine>" not in write(mbs)


@settings(few, max_examples=15)
@given(sprinkled(), st.lists(st.sampled_from(EDITS[:3] + EDITS[4:]), unique=True))
def test_whatever_else_stands_in_a_file_stays(
    data: bytes, edits: list[Callable[[Mbs, Any], None]]
) -> None:
    mbs = read_mbs(data, "m.mbs")
    assert mbs == everything()
    assert write(mbs) == data
    expected = etree.fromstring(data)
    for edit in edits:
        edit(mbs, expected)
    again = write(mbs)
    assert simplify(etree.fromstring(again)) == simplify(expected)
    assert read_mbs(again, "m.mbs") == mbs
    assert write(read_mbs(again, "m.mbs")) == again


def simplify(element: etree._Element) -> object:
    """``canonical``, with all stray text of an element in one: after what, is of no meaning."""
    tag = element.tag if isinstance(element.tag, str) else "?"
    stray = [element.text, *(child.tail for child in element)]
    return (
        tag,
        "".join("".join(text or "" for text in stray).split()),
        sorted(element.items()),
        [simplify(child) for child in element],
    )


def test_text_behind_what_goes_stays() -> None:
    mbs = read_mbs(OWN.replace(b"</link>", b"</link>stray", 1), "m.mbs")
    del mbs.links[0]
    assert (etree.fromstring(write(mbs)).findtext("links") or "").strip() == "stray"


# --- changes one by one ---


def test_an_order_that_changes_moves_the_elements_with_all_that_is_in_them() -> None:
    data = OWN.replace(b"<parameter>", b"<parameter><!-- mine --><unit/>")
    mbs = read_mbs(data, "m.mbs")
    mbs.user_models[0].parameters.reverse()
    root = etree.fromstring(write(mbs))
    parameters = root.findall("user_models/user_model/parameter")
    assert [p.findtext("name") for p in parameters] == ["empty", "table", "gain"]
    assert all(p.find("unit") is not None and p[0].text == " mine " for p in parameters)


def test_a_joint_that_moves_to_another_body_keeps_what_it_has() -> None:
    data = OWN.replace(b"<jointname>tilt</jointname>", b"<jointname>tilt</jointname><brake/>")
    mbs = read_mbs(data, "m.mbs")
    mbs.bodies[1].joints.append(mbs.bodies[0].joints.pop(2))
    root = etree.fromstring(write(mbs))
    first, second = root.findall("bodytree/body")[:2]
    assert [j.findtext("jointname") for j in first.findall("joint")] == ["lift", "turn", "still"]
    assert [j.findtext("jointname") for j in second.findall("joint")] == ["swing", "tilt"]
    assert second.findall("joint")[1].find("brake") is not None
    assert read_mbs(write(mbs), "m.mbs") == mbs


def test_what_is_new_stands_in_its_place_indented_as_the_rest() -> None:
    mbs = read_mbs(write(Mbs("m", bodies=[Body("a", joints=[Joint("j", "R1")])])), "m.mbs")
    mbs.bodies[0].mass = 1.0
    mbs.bodies[0].points.append(Point("p", sensor=Sensor("s")))
    mbs.bodies.append(Body("b", "a", "p", [Joint("k", "T1")]))
    mbs.user_models = read_mbs(OWN, "own.mbs").user_models  # of another file: new here
    fresh = deepcopy(mbs)
    fresh.origin = None
    assert write(mbs) == write(fresh)


def test_a_copy_of_an_object_is_a_new_one() -> None:
    data = OWN.replace(b"<bodyname>leg</bodyname>", b"<bodyname>leg</bodyname><mine/>", 1)
    mbs = read_mbs(data, "m.mbs")
    copy = deepcopy(mbs.bodies[2])
    copy.name, copy.joints[0].name = "other_leg", "other_kick"
    mbs.bodies.append(copy)
    again = write(mbs)
    assert again.count(b"<mine/>") == 1
    assert read_mbs(again, "m.mbs") == mbs


def test_a_model_that_was_read_may_go_to_another_process() -> None:
    data = OWN.replace(b"<base>", b"<base><!-- mine -->")
    mbs = pickle.loads(pickle.dumps(read_mbs(data, "m.mbs")))
    assert write(mbs) == data
    mbs.bodies[0].mass = 5.0
    assert b"<!-- mine -->" in write(mbs)


def test_a_parameter_of_a_type_that_the_model_does_not_know() -> None:
    lines = b"<type>structure</type>", b"<structure>Main</structure>", b"<header>r.h</header>"
    structure = b"\n        ".join(lines)
    data = OWN.replace(b"<type>state</type>", structure)
    mbs = read_mbs(data, "m.mbs")
    assert mbs.user_models[0].parameters[2] == Parameter("empty", "structure")
    mbs.user_models[0].parameters[2].name = "main"
    assert write(mbs) == data.replace(b"<name>empty</name>", b"<name>main</name>")


def first_and_last(mbs: Mbs, root: Any) -> None:
    """All that is first or last in its list goes."""
    del mbs.bodies[0].points[0], mbs.bodies[0].shapes[-1], mbs.bodies[0].joints[0]
    del mbs.bodies[2:], mbs.cuts[1:], mbs.links[:], mbs.user_models[0].parameters[1:]
    assert mbs.view is not None
    del mbs.view.lights[0]
    mbs.user_constraints[0].joints = mbs.user_constraints[0].joints[:1]
    mbs.bodies[1].point, mbs.cuts[0].endpoint1 = None, ("arm", "tip")


def more(mbs: Mbs, root: Any) -> None:
    """Something new before, between and behind, and where there was nothing."""
    point = Point("new", (1.0, 2.0, 3.0), sensor=Sensor("fresh", ("Pos",)))
    mbs.bodies[0].points[:0] = [point, Point("newer")]
    mbs.bodies[1].points.append(Point("tail"))
    mbs.bodies[2].mass, mbs.bodies[2].com = 4.0, (0.0, 1.0, 0.0)
    mbs.bodies.append(Body("foot", "leg", None, [Joint("twist", "R3", q=0.5)]))
    mbs.user_constraints[1].joints = ("twist",)
    mbs.base.points.insert(0, Point("before"))
    mbs.cuts.insert(1, mbs.cuts[0])
    del mbs.cuts[0]


def moved(mbs: Mbs, root: Any) -> None:
    """Elements go to another place or parent."""
    trunk, arm, leg, _ = mbs.bodies
    arm.joints.append(trunk.joints.pop(2))
    leg.joints.insert(0, trunk.joints.pop())
    trunk.points.reverse()
    trunk.shapes.sort(key=lambda shape: shape.name)
    leg.shapes.append(trunk.shapes.pop(0))
    arm.points.append(Point("fist", extforce=trunk.points[0].extforce))
    trunk.points[0].extforce = None
    mbs.user_models[0].parameters.reverse()


@pytest.mark.parametrize(
    "edit", [*EDITS, first_and_last, more, moved], ids=lambda edit: edit.__name__
)
def test_our_own_file_is_changed_to_what_would_be_written_anew(edit: Any) -> None:
    mbs = read_mbs(OWN, "m.mbs")
    edit(mbs, etree.fromstring(OWN))
    fresh = deepcopy(mbs)
    fresh.origin = None
    assert write(mbs) == write(fresh)


def test_a_comment_stays_between_its_neighbours() -> None:
    root = etree.fromstring(OWN)
    tags = ("body", "joint", "point", "sensor", "box", "cone", "rod", "link", "parameter")
    for number, element in enumerate([*root.iter(*tags)]):
        element.addnext(etree.Comment(f" {number} "))
    mbs = read_mbs(etree.tostring(root), "m.mbs")
    for edit in (mass, measures, joint_name):
        edit(mbs, root)
    assert canonical(etree.fromstring(write(mbs))) == canonical(root)


def test_an_element_that_stands_there_empty_is_filled() -> None:
    mbs = read_mbs(re.sub(rb"(?s)<x2D>(?:(?!<x2D>).)*?angle.*?</x2D>", b"<x2D/>", OWN), "m.mbs")
    mbs.bodies[2].drawing = everything().bodies[2].drawing
    again = write(mbs)
    assert read_mbs(again, "m.mbs") == mbs
    assert again.count(b"<x2D") == OWN.count(b"<x2D")


def test_a_value_that_a_file_leaves_out_comes_when_it_changes() -> None:
    data = re.sub(rb"\n *<frame>.*</frame>", b"", OWN)
    mbs = read_mbs(data, "m.mbs")
    assert mbs.view is not None
    mbs.view.joint = 7.0
    joint = rb"(<shapeScaleFactors>\n *)<joint>.*</joint>"
    assert write(mbs) == re.sub(joint, rb"\1<joint>7.0</joint>", data)
    mbs.view.frame = 0.5
    again = etree.fromstring(write(mbs))
    assert [child.tag for child in again.find("x3D/shapeScaleFactors")] == [
        "frame",
        "joint",
        "com",
        "point",
    ]
    assert read_mbs(write(mbs), "m.mbs") == mbs


def test_what_the_model_does_not_know() -> None:
    """By the object, the path from its element, and the text with one spelling of numbers."""
    data = OWN
    for old, new in (
        (b"<base>", b'<base size="9" at="2"><!-- why --><mine>\n 1.50</mine>'),
        (b"<bodyname>leg</bodyname>", b'<bodyname>leg</bodyname><a><b x="+2"> t </b>u</a><a/><a/>'),
        (b"<x3D_com/>", b"<x3D_com/><x3D_frame/><x3D_hand/>"),
        (b"<nature>driven</nature>", b'<nature unit="m">driven</nature>'),
        (b'<sensor name="touch"/>', b'<sensor name="touch" Jerk="true"/>'),
        (b'R="4"', b'R="4" A="1e0"'),
    ):
        assert data.count(old)
        data = data.replace(old, new, 1)
    mbs = read_mbs(data, "m.mbs")
    table, usual = (
        make_table(model, list_entities(model)) for model in (mbs, read_mbs(OWN, "m.mbs"))
    )
    texts = {}
    for entity, values, before in zip(
        table.entities.values(), table.values.values(), usual.values.values(), strict=True
    ):
        for field, text in values.items():
            if field[0] == "?" and before.get(field) != text:
                texts[entity.label, field] = text
    assert texts == {
        ("the base", "?@at"): "2",
        ("the base", "?@size"): "9",
        ("the base", "?mine"): "<mine>1.5</mine>",
        ("body 'leg'", "?a"): '<a><b x="2.0">t</b></a><a></a><a></a>',
        ("body 'trunk'", "?graphics/x3D/x3D_hand"): "<x3D_hand></x3D_hand>",
        ("joint 'turn'", "?nature/@unit"): "m",
        ("sensor 'touch'", "?@Jerk"): "true",
        ("the view", "?background/color/@A"): "1e0",
    }
