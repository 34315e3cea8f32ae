"""The written file has exactly the tree and the order of the format, and nothing else."""

from __future__ import annotations

import math
import re
from math import inf, nan
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree
from mbs.models import everything, few, models

from urdf2mbs.mbs.model import (
    Base,
    Body,
    Connection,
    Joint,
    Light,
    Mbs,
    Parameter,
    Point,
    Sensor,
    Shape,
    UserModel,
    View,
    Viewpoint,
)
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import convert_text

if TYPE_CHECKING:
    from collections.abc import Callable

DRAWING = ["position", "name_pos", "shape", "size", "control_points", "angle"]
SHAPE = ["name", "position", "scale", "rotation", "color", "transparency"]
CONNECTION = ["name", "endpoint1", "endpoint2"]


def tree(mbs: Mbs) -> etree._Element:
    return etree.fromstring(write(mbs))


def tags(element: etree._Element, path: str = ".") -> list[str]:
    found = element.find(path)
    assert found is not None, path
    return [child.tag for child in found]


def texts(element: etree._Element, path: str) -> list[str | None]:
    found = element.findall(path)
    assert found, path
    return [child.text for child in found]


@pytest.fixture(scope="module")
def root() -> etree._Element:
    return tree(everything())


def test_it_is_utf_8_with_a_declaration_and_indented_as_robotran_does() -> None:
    data = write(Mbs("müller", bodies=[Body("b", joints=[Joint("j", "R1")])]))
    lines = data.decode("utf-8").splitlines()
    assert lines[0] == '<?xml version="1.0" encoding="UTF-8"?>'
    assert lines[1:4] == [
        "<mbsDescR7>",
        "  <mbsname>müller</mbsname>",
        "  <mbsyspad_version>1.0</mbsyspad_version>",
    ]
    at = lines.index("      <joint>")
    assert lines[at : at + 4] == [
        "      <joint>",
        "        <jointname>j</jointname>",
        "        <type>R1</type>",
        "        <nature>independent</nature>",
    ]
    assert data.endswith(b"</mbsDescR7>\n")


@few
@given(models())
def test_every_line_is_indented_by_its_depth(mbs: Mbs) -> None:
    depth = 0
    for line in write(mbs).decode().splitlines()[1:]:
        content = line.lstrip(" ")
        opens, closes = content.startswith("<") and "</" not in content, content.startswith("</")
        if content.endswith("/>"):
            opens = False
        depth -= closes
        assert len(line) - len(content) == 2 * depth
        depth += opens and not closes


def test_the_root_and_its_order(root: etree._Element) -> None:
    assert root.tag == "mbsDescR7"
    assert tags(root) == [
        "mbsname", "mbsyspad_version", "base", "bodytree", "cuts", "links", "user_constraints",
        "user_models", "user_variables", "x3D",
    ]  # fmt: skip


def test_what_there_is_none_of_is_left_out() -> None:
    root = tree(Mbs("m"))
    assert tags(root) == ["mbsname", "mbsyspad_version", "base", "bodytree"]


def test_the_base(root: etree._Element) -> None:
    assert tags(root, "base") == ["gravity", "baseBodyName", "point", "graphics"]
    assert tags(root, "base/gravity/coordinates") == ["x", "y", "z"]
    assert texts(tree(Mbs("m")), "base/gravity/coordinates/*") == ["0.0", "0.0", "-9.81"]
    assert tags(root, "base/graphics") == ["x2D", "x3D"]
    assert tags(root, "base/graphics/x2D") == ["position", "base_body"]
    assert tags(root, "base/graphics/x2D/base_body") == DRAWING
    assert tags(root, "base/graphics/x3D") == [
        "x3D_frame", "x3D_points", "x3D_lines", "x3D_shapes",
    ]  # fmt: skip


def test_a_body_and_its_order(root: etree._Element) -> None:
    assert tags(root, "bodytree/body") == [
        "bodyname", "parent", "joint", "joint", "joint", "joint", "mass", "com", "inertia",
        "point", "point", "graphics",
    ]  # fmt: skip
    assert tags(root, "bodytree/body/parent") == ["bodyname", "pointname"]
    assert tags(root, "bodytree/body/com") == ["coordinates"]
    assert tags(root, "bodytree/body/com/coordinates") == ["x", "y", "z"]
    assert tags(root, "bodytree/body/inertia") == ["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"]
    assert tags(root, "bodytree/body/graphics") == ["x2D", "x3D"]
    assert tags(root, "bodytree/body/graphics/x2D") == DRAWING
    assert tags(root, "bodytree/body/graphics/x3D") == [
        "x3D_com", "x3D_points", "x3D_lines", "x3D_shapes",
    ]  # fmt: skip


def test_each_element_of_inertia_and_com_stands_where_it_belongs() -> None:
    body = Body(
        "b", joints=[Joint("j", "R1")], mass=7.0, com=(1.0, 2.0, 3.0),
        inertia=(11.0, 12.0, 13.0, 22.0, 23.0, 33.0),
    )  # fmt: skip
    root = tree(Mbs("m", bodies=[body]))
    assert texts(root, "bodytree/body/mass") == ["7.0"]
    assert texts(root, "bodytree/body/com/coordinates/*") == ["1.0", "2.0", "3.0"]
    for name, value in (("xx", 11), ("xy", 12), ("xz", 13), ("yy", 22), ("yz", 23), ("zz", 33)):
        assert texts(root, f"bodytree/body/inertia/I{name}") == [f"{value}.0"]


def test_the_ground_is_base_and_a_bodys_own_frame_is_origin(root: etree._Element) -> None:
    parents = [tuple(part.text for part in parent) for parent in root.iter("parent")]
    assert parents == [
        ("base", "origin"), ("trunk", "shoulder"), ("trunk", "origin"), ("base", "rail"),
    ]  # fmt: skip
    assert root.findtext("base/baseBodyName") == "workshop"
    assert texts(root, "cuts/solid/endpoint2/*") == ["base", "origin"]


def test_joints(root: etree._Element) -> None:
    lift, turn, tilt, still = root.findall("bodytree/body/joint")[:4]
    assert tags(lift) == ["jointname", "type", "nature", "initialvalue", "graphics"]
    assert tags(lift, "initialvalue") == ["q", "qd", "qdd"]
    assert tags(turn) == ["jointname", "type", "nature", "initialvalue", "symbols", "graphics"]
    assert tags(turn, "initialvalue") == ["q"]
    assert tags(turn, "symbols") == ["q"]
    assert tags(tilt) == ["jointname", "type", "nature", "actuated", "symbols", "graphics"]
    assert tags(tilt, "symbols") == ["q", "qd", "qdd"]
    assert tags(still, "symbols") == []
    for joint in (lift, turn):
        assert tags(joint, "graphics") == ["x2D", "x3D"]
        assert tags(joint, "graphics/x2D") == ["position"]
    assert tags(tilt, "graphics") == ["x3D"]
    for joint in root.iter("joint"):
        if joint.getparent().tag == "body":  # type: ignore[union-attr]
            assert tags(joint, "graphics/x3D") == ["x3D_joint", "x3D_frame"]


def test_points_sensors_and_forces(root: etree._Element) -> None:
    shoulder, handle = root.findall("bodytree/body/point")[:2]
    assert tags(shoulder) == ["pointname", "coordinates", "graphics", "sensor"]
    assert tags(shoulder, "graphics") == ["x2D", "x3D"]
    assert tags(handle) == ["pointname", "coordinates", "graphics", "sensor", "extforce"]
    assert tags(handle, "graphics") == ["x3D"]
    force, sensor = handle.find("extforce"), shoulder.find("sensor")
    assert force is not None
    assert sensor is not None
    measures = [(key, "true") for key in ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")]
    assert force.items() == [("name", "push"), *measures]
    assert sensor.items() == [("name", "imu"), *measures, ("Jac", "true")]
    assert not len(force)
    assert not len(sensor)


def test_shapes(root: etree._Element) -> None:
    shapes = root.find("bodytree/body/graphics/x3D/x3D_shapes")
    assert shapes is not None
    assert {shape.tag: tags(shape) for shape in shapes} == {
        "box": [*SHAPE, "size"],
        "cylinder": [*SHAPE, "radius", "height"],
        "cone": [*SHAPE, "radius", "height"],
        "sphere": [*SHAPE, "radius"],
        "inline": [*SHAPE, "url"],
    }
    assert tags(shapes, "box/size") == ["x", "y", "z"]
    for color in shapes.iter("color"):
        assert color.items() == [("R", "1"), ("G", "2"), ("B", "3")]


def test_the_diagram(root: etree._Element) -> None:
    x2d = root.find("bodytree/body/graphics/x2D")
    assert x2d is not None
    for part in ("position", "name_pos", "size", "control_points/control_point"):
        assert tags(x2d, part) == ["x", "y"]
    assert tags(x2d, "control_points") == ["control_point"] * 4
    shapes = [body.findtext("graphics/x2D/shape") for body in root.iter("body")]
    assert shapes == ["rectangle", "circle", "ellipse", "rectangle"]


def test_cuts_and_links(root: etree._Element) -> None:
    assert tags(root, "cuts") == ["ball", "rod", "solid"]
    assert tags(root, "cuts/ball") == CONNECTION
    assert tags(root, "cuts/rod") == [*CONNECTION, "length"]
    assert tags(root, "cuts/solid") == CONNECTION
    assert tags(root, "links") == ["link", "link3D"]
    assert tags(root, "links/link") == CONNECTION
    assert tags(root, "cuts/ball/endpoint1") == ["bodyname", "pointname"]
    assert texts(root, "cuts/ball/endpoint1/*") == ["arm", "tip"]
    assert texts(root, "cuts/ball/endpoint2/*") == ["base", "rail"]


def test_what_users_add(root: etree._Element) -> None:
    assert tags(root, "user_constraints/user_constraint") == ["name", "joints"]
    assert texts(root, "user_constraints/user_constraint/joints/jointname") == ["swing", "kick"]
    assert tags(root, "user_models/user_model") == ["name", "parameter", "parameter", "parameter"]
    assert tags(root, "user_models/user_model/parameter[2]") == ["name", "type"] + 4 * ["value"]
    assert tags(root, "user_variables/user_variable") == ["varname", "type", "size"]


def test_the_view(root: etree._Element) -> None:
    assert tags(root, "x3D") == ["background", "shapeScaleFactors", "viewpoints", "lights"]
    assert tags(root, "x3D/background") == ["color"]
    assert tags(root, "x3D/shapeScaleFactors") == ["frame", "joint", "com", "point"]
    assert tags(root, "x3D/viewpoints/viewpoint") == [
        "name", "joint", "position", "target", "up", "projection", "scale", "fieldOfView",
        "frontClipDst", "backClipDst",
    ]  # fmt: skip
    sun, lamp = root.findall("x3D/lights/directionalLight")
    assert tags(sun) == ["name", "joint", "active", "direction"]
    assert tags(lamp) == ["name", "joint", "direction"]


#: Elements whose presence or attributes are all they say.
EMPTY = {
    "actuated", "q", "qd", "qdd", "symbols", "active", "color", "sensor", "extforce", "joints",
    "x3D", "x3D_joint", "x3D_frame", "x3D_com", "x3D_points", "x3D_lines", "x3D_shapes",
    "bodytree", "viewpoints", "lights", "control_points",
}  # fmt: skip


@few
@given(models())
def test_no_empty_element_that_robotran_cannot_read(mbs: Mbs) -> None:
    for element in tree(mbs).iter():
        if not len(element) and not (element.text or "").strip():
            assert element.tag in EMPTY
            if element.tag in ("q", "qd", "qdd"):
                parent = element.getparent()
                assert parent is not None
                assert parent.tag == "symbols"


@few
@given(models())
def test_names_come_first(mbs: Mbs) -> None:
    root = tree(mbs)
    for tag, name in (("bodytree/body", "bodyname"), (".//point", "pointname")):
        for element in root.iterfind(tag):
            if len(element):  # there is a scale factor called point
                assert element[0].tag == name
    for element in root.iterfind("bodytree/body/joint"):
        assert element[0].tag == "jointname"


@few
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_never_rounded_and_zero_has_no_sign(value: float) -> None:
    root = tree(Mbs("m", bodies=[Body("b", joints=[Joint("j", "R1", q=value)], mass=value)]))
    for text in texts(root, "bodytree/body/mass") + texts(root, "bodytree/body/joint//q"):
        assert text is not None
        assert re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?", text)
        assert float(text) == value
        assert value != 0.0 or text == "0.0"


def test_whole_numbers_are_written_as_floats() -> None:
    import numpy as np

    joints = [Joint("j", "R1", q=2), Joint("k", "R1", q=float(np.float64(0.1)), qd=np.float64(0.1))]
    root = tree(Mbs("m", bodies=[Body("b", joints=joints, mass=True)]))
    assert texts(root, "bodytree/body/joint/initialvalue/*") == ["2.0", "0.1", "0.1"]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    "put",
    [
        lambda mbs, value: setattr(mbs.bodies[0], "mass", value),
        lambda mbs, value: setattr(mbs.bodies[0].joints[0], "q", value),
        lambda mbs, value: setattr(mbs.bodies[0].points[0], "position", (value, 0.0)),
        lambda mbs, value: setattr(mbs.base, "gravity", (0.0, 0.0, value)),
    ],
)
def test_a_number_that_is_none_is_an_error(put: Callable[[Mbs, float], None], value: float) -> None:
    mbs = everything()
    put(mbs, value)
    with pytest.raises(ValueError, match=r"which no \.mbs file can hold"):
        write(mbs)


def test_names_are_escaped() -> None:
    name = "<a & \"b'>]]>"
    body = Body(name, joints=[Joint(f"j{name}", "R1")], points=[Point("p", sensor=Sensor(name))])
    root = tree(Mbs("m", bodies=[body]))
    assert texts(root, "bodytree/body/bodyname") == [name]
    assert texts(root, "bodytree/body/joint/jointname") == [f"j{name}"]
    assert root.find("bodytree/body/point/sensor").get("name") == name  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda body: setattr(body, "name", "a\x00b"), "cannot hold the name"),
        (lambda body: setattr(body, "name", "a\ud800b"), "cannot hold the name"),
        (lambda body: body.joints.clear(), "body 'b' has no joint"),
        (lambda body: setattr(body.joints[0], "type", "R4"), "joint 'j'"),
        (lambda body: setattr(body.joints[0], "nature", "forced driven"), "joint 'j'"),
        (lambda body: setattr(body.joints[0], "symbols", ("q", "u")), "joint 'j'.*'u'"),
        (lambda body: setattr(body.points[0], "sensor", Sensor("s", ("jac",))), "'jac'"),
        (lambda body: body.shapes.append(Shape("capsule", "s")), "'capsule'"),
    ],
)
def test_what_no_file_can_hold_is_an_error(spoil: Callable[[Body], Any], message: str) -> None:
    body = Body("b", joints=[Joint("j", "R1")], points=[Point("p")])
    mbs = Mbs("m", bodies=[body])
    write(mbs)
    spoil(body)
    with pytest.raises(ValueError, match=message):
        write(mbs)


def test_connections_of_other_kinds_are_an_error() -> None:
    ends = ((None, None), (None, None))
    for mbs in (
        Mbs("m", cuts=[Connection("link", "c", *ends)]),
        Mbs("m", links=[Connection("ball", "c", *ends)]),
    ):
        with pytest.raises(ValueError, match="no such word"):
            write(mbs)


def test_no_sensor_on_the_base() -> None:
    for point in (Point("p", sensor=Sensor("s")), Point("p", extforce=Sensor("s"))):
        mbs = Mbs("m")
        mbs.base.points.append(point)
        with pytest.raises(ValueError, match="point 'p' of the base"):
            write(mbs)


def test_the_same_bytes_every_time() -> None:
    assert write(everything()) == write(everything())


def test_a_chain_of_ten_thousand() -> None:
    bodies = [Body("b0", joints=[Joint("j0", "R1")])]
    bodies += [Body(f"b{k}", f"b{k - 1}", None, [Joint(f"j{k}", "R1")]) for k in range(1, 10_000)]
    assert write(Mbs("m", bodies=bodies)).count(b"<bodyname>b9999</bodyname>") == 1


def test_minus_zero_is_written_as_zero() -> None:
    """Whichever of the two comes first: they are one number, and so one text."""
    for first, second in ((-0.0, 0.0), (0.0, -0.0)):
        body = Body("a", joints=[Joint("j", "R1", q=first)], com=(second, first, -0.0), mass=-0.0)
        data = write(Mbs("m", base=Base(gravity=(first, -0.0, -9.81)), bodies=[body]))
        assert b"-0.0" not in data
        assert b"<q>0.0</q>" in data


@pytest.mark.parametrize(
    ("spoil", "element"),
    [
        (lambda mbs: setattr(mbs.base, "gravity", (0.0, 0.0, inf)), "the base"),
        (lambda mbs: setattr(mbs.bodies[1], "mass", nan), "body 'arm'"),
        (lambda mbs: setattr(mbs.bodies[1].joints[0], "q", -inf), "joint 'shoulder_origin_R2'"),
        (
            lambda mbs: setattr(mbs.bodies[1].points[0], "coordinates", (inf, 0.0, 0.0)),
            "point 'hand'",
        ),
        (
            lambda mbs: mbs.user_models.append(
                UserModel(
                    "a", [Parameter("b", "scalar", ("1.0",)), Parameter("c", "scalar", ("inf",))]
                )
            ),
            "parameter 'c' of user model 'a'",
        ),
        (
            lambda mbs: mbs.cuts.append(Connection("rod", "tie", ("arm", None), (None, None), inf)),
            "rod 'tie'",
        ),
        (lambda mbs: setattr(mbs.view, "frame", nan), "the 3D view"),
    ],
)
def test_what_is_not_finite_is_refused_and_its_element_named(
    spoil: Callable[[Mbs], None], element: str
) -> None:
    mbs = convert_text().mbs
    spoil(mbs)
    with pytest.raises(ValueError, match=f"^{element} has the number (nan|-?inf)"):
        write(mbs)


def test_a_view_has_the_values_that_mbsyspad_gives_a_new_one() -> None:
    zero = (0.0, 0.0, 0.0)
    view = View(viewpoints=[Viewpoint("v", zero, zero)], lights=[Light("l", zero)])
    top = tree(Mbs("m", view=view)).find("x3D")
    assert top is not None
    assert texts(top, "shapeScaleFactors/*") == ["0.1", "0.2", "0.2", "0.3"]
    (camera,) = top.findall("viewpoints/viewpoint")
    assert [camera.findtext(tag) for tag in ("joint", "projection", "scale", "fieldOfView")] == [
        "base", "perspective", "1.0", "0.785",
    ]  # fmt: skip
    assert texts(camera, "up/*") == ["0.0", "0.0", "1.0"]
    assert [camera.findtext(f"{end}ClipDst") for end in ("front", "back")] == ["0.01", "50.0"]
    color = top.find("background/color")
    assert color is not None
    assert dict(color.attrib) == {"R": "153", "G": "153", "B": "255"}
    assert top.find("lights/directionalLight/active") is not None
