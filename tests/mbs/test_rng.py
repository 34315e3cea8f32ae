"""The schema: it accepts what is written, and each rule of the format, broken once, is seen."""

from __future__ import annotations

import re
from copy import deepcopy
from pathlib import Path

import pytest
from hypothesis import given
from lxml import etree
from mbs.models import everything, few, models

from urdf2mbs.mbs import reader
from urdf2mbs.mbs.fields import LIGHT, SHAPE, VIEWPOINT
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import validate
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic

FILE = write(everything()).decode()


def problems(data: bytes) -> list[Diagnostic]:
    return validate(data, "m.mbs")


def test_a_model_with_everything_is_valid() -> None:
    assert problems(FILE.encode()) == []


@few
@given(models(drawn=True))
def test_every_file_we_write_is_valid(mbs: Mbs) -> None:
    assert problems(write(mbs)) == []


def test_a_body_without_a_diagram_is_not_for_mbsyspad() -> None:
    mbs = everything()
    mbs.bodies[0].drawing = None
    assert problems(write(mbs))


def element(tag: str, start: str = "") -> str:
    """A pattern: an element, its content without an element of its own name."""
    return rf"<{tag}{start}>(?:(?!<{tag}>).)*?</{tag}>\s*"


def test_a_body_has_a_joint_and_graphics() -> None:
    start = FILE.index("<bodyname>arm</bodyname>")
    end = FILE.index("</body>", start)
    joint = FILE.index("</joint>", start)
    rejected(
        re.sub(element("joint"), "", FILE[start:end], flags=re.DOTALL).join(
            [FILE[:start], FILE[end:]]
        )
    )
    for gone in ("graphics", "x2D", "x3D"):
        at = FILE.rindex(f"<{gone}>", joint, end)
        rejected(FILE[:at] + re.sub(f"(?s)^.*?</{gone}>", "", FILE[at:end]) + FILE[end:])


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("mbsname", "mbsyspad_version"), ("type", "nature"), ("jointname", "type"),
        ("initialvalue", "graphics"), ("mass", "com"), ("com", "inertia"), ("Ixx", "Ixy"),
        ("x", "y"), ("name_pos", "shape"), ("endpoint1", "endpoint2"), ("q", "qd"),
        ("scale", "rotation"), ("radius", "height"), ("base", "bodytree"), ("cuts", "links"),
    ],
)  # fmt: skip
def test_the_order(first: str, second: str) -> None:
    pattern = f"({element(first)})({element(second)})"
    broken, count = re.subn(pattern, r"\2\1", FILE, count=1, flags=re.DOTALL)
    assert count == 1
    rejected(broken)


#: Where one more of a kind is welcome.
LISTS = {
    "bodytree", "x3D_shapes", "cuts", "links", "user_constraints", "user_models",
    "user_variables", "viewpoints", "lights",
}  # fmt: skip
REPEATED = {
    ("base", "point"), ("body", "point"), ("body", "joint"), ("joints", "jointname"),
    ("user_model", "parameter"), ("parameter", "value"),
}  # fmt: skip
#: What may hold anything.
OPAQUE = {"x3D_joint", "x3D_frame", "x3D_com", "x3D_points", "x3D_lines"}
#: Text that looks like a number and is none.
FREE = {"mbsyspad_version", "user_variables/user_variable/size"}


def places() -> dict[str, str]:
    """For each kind of element, by the tags on the way to it, where the first one is."""
    tree = etree.ElementTree(etree.fromstring(FILE.encode()))
    found: dict[str, str] = {}
    for element in tree.iter():
        path = tree.getelementpath(element)
        found.setdefault(re.sub(r"\[\d+\]", "", path), path)
    return found


PLACES = places()


def at(place: str) -> tuple[etree._Element, etree._Element]:
    root = etree.fromstring(FILE.encode())
    found = root.find(PLACES[place])
    assert found is not None
    return root, found


#: What may be missing, by parent and child.
OPTIONAL = {
    "mbsDescR7": "mbsname mbsyspad_version cuts links user_constraints user_models user_variables "
    "x3D",
    "base": "baseBodyName graphics",
    "body": "mass com inertia",
    "inertia": "Ixx Ixy Ixz Iyy Iyz Izz",
    "joint": "initialvalue actuated symbols graphics",
    "initialvalue": "q qd qdd",
    "symbols": "q qd qdd",
    "point": "graphics sensor extforce",
    "x2D": "position base_body",
    "x3D": "x3D_joint x3D_frame x3D_com x3D_points x3D_lines x3D_shapes viewpoints",
    "directionalLight": "active",
    **dict.fromkeys(("box", "cylinder", "cone", "sphere", "inline"), "position rotation"),
}


@pytest.mark.parametrize("place", PLACES)
def test_what_is_required(place: str) -> None:
    root, found = at(place)
    parent = found.getparent()
    if parent is None or parent.tag in LISTS or (parent.tag, found.tag) in REPEATED:
        return
    optional = found.tag in OPTIONAL.get(parent.tag, "").split()
    if found.tag == "x2D":
        optional = "body/graphics/" not in place
    if found.tag == "position" and parent.tag == "x2D":
        optional = place.startswith("base/graphics")
    parent.remove(found)
    text = etree.tostring(root, encoding="unicode")
    assert bool(problems(text.encode())) is not optional


@pytest.mark.parametrize("place", PLACES)
def test_once_only(place: str) -> None:
    root, found = at(place)
    parent = found.getparent()
    if parent is None or parent.tag in LISTS or (parent.tag, found.tag) in REPEATED:
        return
    found.addnext(deepcopy(found))
    rejected(etree.tostring(root, encoding="unicode"))


@pytest.mark.parametrize("place", PLACES)
def test_text_stands_where_it_belongs_and_numbers_are_numbers(place: str) -> None:
    root, found = at(place)
    if found.tag in OPAQUE or place.endswith("point/graphics/x3D"):
        return
    text = (found.text or "").strip()
    wrong = [""] if text else ["text"]
    if place.endswith(("viewpoint/name", "directionalLight/name")):
        return  # MBSysPad leaves them empty
    if re.fullmatch(r"[-\d.e]+", text) and place not in FREE and found.tag != "value":
        wrong.append("one")
    for value in wrong:
        found.text = value
        rejected(etree.tostring(root, encoding="unicode"))


@pytest.mark.parametrize("place", [place for place in PLACES if at(place)[1].items()])
def test_attributes_have_their_words(place: str) -> None:
    root, found = at(place)
    for name, value in found.items():
        for other in ("",) if name == "name" else ("", "?", "2.5"):
            found.set(name, other)
            rejected(etree.tostring(root, encoding="unicode"))
        found.set(name, value)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("mbsDescR7>", "mbsDescR6>"),
        ("<type>R3<", "<type>R4<"),
        ("<type>R3<", "<type>r3<"),
        (">driven<", ">forced driven<"),
        (">driven<", ">Driven<"),
        (">rectangle<", ">square<"),
        (">rectangle<", ">circle<"),  # has one control point
        (">circle<", ">ellipse<"),  # has four
        ("<type>lut1D<", "<type>lut<"),
        ("<type>in<", "<type>input<"),
        ('Pos="true"', 'Pos="1"'),
        ('Pos="true"', 'Position="true"'),
        ('<sensor name="imu"', "<sensor"),
        ('<sensor name="imu"', '<sensor name=""'),
        ('Jac="true"/>', 'Jac="true">x</sensor>'),
        ('R="1"', 'R="256"'),
        ('R="1"', 'R="-1"'),
        ('R="1"', 'R="0.5"'),
        ('R="1"', ""),
        (".wrl<", ".stl<"),
        ("<bodyname>arm<", "<bodyname>base<"),
        ("<bodyname>arm<", "<bodyname>origin<"),
        ("<bodyname>arm<", "<bodyname> <"),
        ("<jointname>swing<", "<jointname><"),
        ("<pointname>tip<", "<pointname>origin<"),
        ("<actuated/>", "<actuated>yes</actuated>"),
        ("<qdd/>", "<qddd/>"),
        ("<qdd/>", "<qdd>0.0</qdd>"),
        ("<rod>", "<bar>"),
        ("<length>", "<len>"),
        ("<mass>", "<new/><mass>"),
        ("</base>", "<new/></base>"),
        ("<body>", '<body note="x">'),
    ],
)
def test_words_and_values(old: str, new: str) -> None:
    assert old in FILE
    start = FILE.index("<bodytree>") if old in (">rectangle<",) else 0
    text = FILE[:start] + FILE[start:].replace(old, new, 1)
    for was, becomes in (("<rod>", "<bar>"), ("<length>", "<len>")):
        if old == was:
            text = text.replace(was.replace("<", "</"), becomes.replace("<", "</"), 1)
    if old == "mbsDescR7>":
        text = FILE.replace(old, new)
    rejected(text)


@pytest.mark.parametrize(
    "number", ["", " ", "nan", "inf", "-INF", "1,5", "0x1p3", "1_0", "1d3", "1 2", ".", "e5", "٣"]
)
def test_what_is_no_number(number: str) -> None:
    rejected(re.sub("<mass>.*</mass>", f"<mass>{number}</mass>", FILE))


@pytest.mark.parametrize("number", ["1", "-1.", "+.5", "1.0E-5", "2e+3", " 0.5 ", "-0.0"])
def test_what_is_a_number(number: str) -> None:
    text = re.sub("<mass>.*</mass>", f"<mass>{number}</mass>", FILE)
    assert problems(text.encode()) == []


@pytest.mark.parametrize("what", ["sensor", "extforce"])
def test_no_sensor_or_force_on_the_base(what: str) -> None:
    rejected(FILE.replace("</point>", f'<{what} name="s"/></point>', 1))


def test_at_most_one_sensor_and_one_force_in_this_order() -> None:
    sensor, force = (re.search(f"<{tag} [^>]*>", FILE) for tag in ("sensor", "extforce"))
    assert sensor
    assert force
    rejected(FILE.replace(sensor[0], 2 * sensor[0], 1))
    rejected(FILE.replace(force[0], 2 * force[0], 1))
    rejected(FILE.replace(force[0], f'{force[0]}<sensor name="s"/>', 1))


def test_anything_may_stand_in_what_mbsyspad_keeps_for_itself() -> None:
    text = FILE.replace("<x3D_joint/>", '<x3D_joint a="1">x<size><z/></size></x3D_joint>')
    assert problems(text.encode()) == []


@pytest.mark.parametrize("place", ["</body>", "<bodytree>", "</bodytree>"])
def test_stray_text_between_bodies(place: str) -> None:
    rejected(FILE.replace(place, f"{place} stray ", 1))


def test_a_body_elsewhere() -> None:
    body = FILE[FILE.index("<body>") : FILE.index("</body>") + len("</body>")]
    rejected(FILE.replace("</bodytree>", f"</bodytree>{body}"))
    rejected(FILE.replace("<bodytree>", f"<bodytree><more>{body}</more>"))


def test_entities_are_refused() -> None:
    text = FILE.replace("<mbsDescR7>", '<!DOCTYPE mbsDescR7 [<!ENTITY a "b">]><mbsDescR7>')
    with pytest.raises(ConversionError, match="xml-entity"):
        validate(text.encode(), "m.mbs")


def rejected(text: str) -> None:
    assert text != FILE
    assert problems(text.encode())


def test_the_schema_has_the_elements_that_are_read_and_written_by_table() -> None:
    schema = Path(reader.__file__).with_name("mbs.rng").read_text("utf-8")
    for tag in (*SHAPE, *VIEWPOINT, *LIGHT):
        assert f'name="{tag}"' in schema
