"""The written file: the elements, the order and the spelling of MBSysPad, and nothing else."""

import re
from collections.abc import Callable
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from support.folders import SHARED
from support.mbs_models import everything, few, models
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
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write

WRITTEN = sorted(SHARED.glob("mbs-samples/saved/*.written.mbs"))


def tree(mbs: Mbs) -> etree._Element:
    return etree.fromstring(write(mbs))


def texts(element: etree._Element, path: str) -> list[str | None]:
    found = element.findall(path)
    assert found, path
    return [child.text for child in found]


def test_each_element_stands_where_mbsyspad_has_it() -> None:
    """The file agreed with a schema that was made of 236 real files."""
    assert write(everything()) == Path(__file__).with_name("everything.mbs").read_bytes()


@pytest.mark.skipif(not WRITTEN, reason=f"the real files are not here: {SHARED} does not exist")
@pytest.mark.parametrize("file", WRITTEN, ids=lambda file: file.stem)
def test_a_file_that_mbsyspad_has_opened_is_written_anew(file: Path) -> None:
    mbs = read_mbs(file.read_bytes(), file.name)
    mbs.origin = None
    assert write(mbs) == file.read_bytes()


def test_what_there_is_none_of_is_left_out() -> None:
    assert [child.tag for child in tree(Mbs("m"))] == [
        "mbsname",
        "mbsyspad_version",
        "base",
        "bodytree",
    ]
    assert "müller" in write(Mbs("müller")).decode("utf-8")


def test_a_view_has_the_values_that_mbsyspad_gives_a_new_one() -> None:
    zero = (0.0, 0.0, 0.0)
    view = View(viewpoints=[Viewpoint("v", zero, zero)], lights=[Light("l", zero)])
    top = tree(Mbs("m", view=view)).find("x3D")
    assert top is not None
    assert texts(top, "shapeScaleFactors/*") == ["0.1", "0.2", "0.2", "0.3"]
    assert texts(top, "viewpoints/viewpoint/up/*") == ["0.0", "0.0", "1.0"]
    [camera] = top.findall("viewpoints/viewpoint")
    wanted = {
        "joint": "base",
        "projection": "perspective",
        "scale": "1.0",
        "fieldOfView": "0.785",
        "frontClipDst": "0.01",
        "backClipDst": "50.0",
    }
    assert {tag: camera.findtext(tag) for tag in wanted} == wanted
    color: Any = top.find("background/color")
    assert dict(color.attrib) == {"R": "153", "G": "153", "B": "255"}
    assert top.find("lights/directionalLight/active") is not None


#: Elements whose presence or attributes are all they say.
EMPTY = {
    "actuated",
    "q",
    "qd",
    "qdd",
    "symbols",
    "active",
    "color",
    "sensor",
    "extforce",
    "joints",
    "x3D",
    "x3D_joint",
    "x3D_frame",
    "x3D_com",
    "x3D_points",
    "x3D_lines",
    "x3D_shapes",
    "bodytree",
    "viewpoints",
    "lights",
    "control_points",
}
NAMES = {
    "body": "bodyname",
    "joint": "jointname",
    "point": "pointname",
    "com": "coordinates",
    "gravity": "coordinates",
}


@few
@given(models())
def test_robotran_can_read_it(mbs: Mbs) -> None:
    """No empty element that its C library falls over; names first; a line for each element."""
    data = write(mbs)
    root = etree.fromstring(data)
    for element in root.iter():
        if not len(element) and not (element.text or "").strip():
            assert element.tag in EMPTY
            assert element.tag not in ("q", "qd", "qdd") or element.getparent().tag == "symbols"  # type: ignore[union-attr]
        if len(element) and element.tag in NAMES:  # a scale factor is called point, too
            assert element[0].tag == NAMES[element.tag]
    assert write(mbs) == data
    lines = etree.tostring(root, encoding="unicode").splitlines()
    etree.indent(root, "  ")
    assert lines == etree.tostring(root, encoding="unicode").splitlines()


@few
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_never_rounded_and_zero_has_no_sign(value: float) -> None:
    root = tree(Mbs("m", bodies=[Body("b", joints=[Joint("j", "R1", q=value)], mass=value)]))
    for text in texts(root, "bodytree/body/mass") + texts(root, "bodytree/body/joint//q"):
        assert text is not None
        assert re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?", text)
        assert float(text) == value
        assert value != 0.0 or text == "0.0"


def test_all_that_python_counts_as_a_number_is_written_as_a_float() -> None:
    joints = [Joint("j", "R1", q=2, qd=np.float64(0.1)), Joint("k", "R1", q=0.0, qd=-0.0)]
    root = tree(Mbs("m", bodies=[Body("b", joints=joints, mass=True, com=(-0.0, 0.0, -0.0))]))
    assert texts(root, "bodytree/body/joint/initialvalue/*") == ["2.0", "0.1", "0.0", "0.0"]
    assert texts(root, "bodytree/body/com/coordinates/*") == ["0.0"] * 3


def test_names_are_escaped() -> None:
    name = "<a & \"b'>]]>"
    body = Body(name, joints=[Joint(f"j{name}", "R1")], points=[Point("p", sensor=Sensor(name))])
    root = tree(Mbs("m", bodies=[body]))
    assert texts(root, "bodytree/body/bodyname") == [name]
    assert texts(root, "bodytree/body/joint/jointname") == [f"j{name}"]
    assert root.find("bodytree/body/point/sensor").get("name") == name  # type: ignore[union-attr]


ENDS = ((None, None), (None, None))
#: A change of a model of one body, and what the error names.
SPOILS: list[tuple[Callable[[Mbs], Any], str]] = [
    (lambda m: setattr(m.bodies[0], "name", "a\x00b"), "cannot hold the name"),
    (lambda m: setattr(m.bodies[0], "name", "a\ud800b"), "cannot hold the name"),
    (lambda m: m.bodies[0].joints.clear(), "body 'b' has no joint"),
    (lambda m: setattr(m.bodies[0].joints[0], "type", "R4"), "joint 'j'"),
    (lambda m: setattr(m.bodies[0].joints[0], "nature", "forced driven"), "joint 'j'"),
    (lambda m: setattr(m.bodies[0].joints[0], "symbols", ("q", "u")), "joint 'j'.*'u'"),
    (lambda m: setattr(m.bodies[0].points[0], "sensor", Sensor("s", ("jac",))), "'jac'"),
    (lambda m: m.bodies[0].shapes.append(Shape("capsule", "s")), "'capsule'"),
    (lambda m: m.cuts.append(Connection("link", "c", *ENDS)), "'link'"),
    (lambda m: m.links.append(Connection("ball", "c", *ENDS)), "'ball'"),
    (lambda m: m.base.points.append(Point("p", sensor=Sensor("s"))), "point 'p' of the base"),
    (lambda m: m.base.points.append(Point("p", extforce=Sensor("s"))), "point 'p' of the base"),
    (lambda m: setattr(m.base, "gravity", (0.0, 0.0, inf)), "^the base has the number inf"),
    (lambda m: setattr(m.bodies[0], "mass", nan), "^body 'b' has the number nan"),
    (lambda m: setattr(m.bodies[0].joints[0], "q", -inf), "^joint 'j' has the number -inf"),
    (lambda m: setattr(m.bodies[0].points[0], "position", (nan, 0.0)), "^point 'p' has the number"),
    (
        lambda m: m.user_models.append(UserModel("a", [Parameter("c", "scalar", ("inf",))])),
        "^parameter 'c' of user model 'a' has the number inf",
    ),
    (lambda m: m.cuts.append(Connection("rod", "tie", *ENDS, inf)), "^rod 'tie' has the number"),
    (lambda m: setattr(m, "view", View(frame=nan)), "^the 3D view has the number nan"),
]


@pytest.mark.parametrize(("spoil", "message"), SPOILS)
def test_what_no_file_can_hold_is_an_error(spoil: Callable[[Mbs], Any], message: str) -> None:
    body = Body("b", joints=[Joint("j", "R1")], points=[Point("p")])
    mbs = Mbs("m", base=Base(), bodies=[body])
    write(mbs)
    spoil(mbs)
    with pytest.raises(ValueError, match=message):
        write(mbs)
