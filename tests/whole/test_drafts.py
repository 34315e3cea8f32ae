"""A draft of MBSysPad: an end of a cut is not placed yet.  What does not need it still works."""

import pytest

from support.mbs_models import everything
from urdf2mbs.mbs.model import Point, Sensor
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_equations.files import generate
from urdf2mbs_equations.options import EquationOptions
from urdf2mbs_report.draw import draw

END = b"<bodyname>arm</bodyname>\n        <pointname>tip</pointname>"
EMPTY = b"<bodyname/>\n        <pointname>origin</pointname>"
WHOLE = write(everything())
DRAFT = WHOLE.replace(END, EMPTY, 1)


def test_it_is_read_and_kept() -> None:
    mbs = read_mbs(DRAFT, "m.mbs")
    assert [cut.is_draft for cut in mbs.cuts] == [True, False, False]
    assert not any(cut.is_draft for cut in everything().cuts)
    assert read_mbs(write(mbs), "m.mbs") == mbs


def test_a_parent_must_be_there_all_the_same() -> None:
    parent = b"<bodyname>trunk</bodyname>\n        <pointname>shoulder</pointname>"
    assert parent in WHOLE
    with pytest.raises(ConversionError, match="parent-unknown"):
        read_mbs(WHOLE.replace(parent, EMPTY, 1), "m.mbs")


def test_the_functions_that_need_the_cut_are_left_out_and_it_is_named() -> None:
    found = generate(read_mbs(DRAFT, "m.mbs"), DRAFT, "m.mbs", EquationOptions(language="python"))
    assert {"cons_hJ", "cons_jdqd"} <= set(found.left_out)
    assert "'a_ball'" in found.left_out["cons_hJ"]
    assert {"dirdyna", "invdyna", "link", "extforces", "sensor"}.isdisjoint(found.left_out)


def test_the_diagram_has_the_rest() -> None:
    mbs = everything()
    for body in mbs.bodies:
        for part in (*body.joints, *body.points):
            part.position = part.position or (5.0, 5.0)
    whole = draw(mbs)
    mbs.cuts[0].endpoint1 = ("", None)
    assert 'data-name="a_ball"' in whole
    assert 'data-name="a_ball"' not in draw(mbs)
    assert 'data-name="a_rod"' in draw(mbs)


def test_a_sensor_on_a_bodys_own_frame_is_drawn_there() -> None:
    mbs = everything()
    for body in mbs.bodies:
        for part in (*body.joints, *body.points):
            part.position = part.position or (5.0, 5.0)
    arm = mbs.bodies[1]
    arm.points.append(Point("origin", sensor=Sensor("own")))
    x, y = arm.joints[-1].position or (0.0, 0.0)
    assert f'<title>origin\n(0, 0, 0) m\nsensor own</title><circle cx="{x:.10g}" cy="{y:.10g}"' in (
        draw(mbs)
    )
    assert read_mbs(write(mbs), "m.mbs") == mbs
