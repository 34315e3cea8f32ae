"""Snap: what is nearly a multiple of 45 degrees is this multiple, and how far this moves tips."""

import re
from pathlib import Path

import numpy as np
import pytest

from support.build import SOLID, joint, link, robot
from urdf2mbs.cli import main
from urdf2mbs.testing import convert_text
from urdf2mbs_certificate import certificate

RIGHT, HALF = "1.5707963267948966", "0.7853981633974483"


def written(right: str, half: str, axis: str, kind: str = "revolute") -> str:
    """Three joints in a row, with these numbers for 90 and 45 degrees and for an axis at 45."""
    return robot(
        *(link(name, SOLID) for name in "abcd"),
        joint("a", "b", "fixed", xyz="0 0 0.5", rpy=f"{right} 0 -{half}"),
        joint("b", "c", kind, xyz="0 0.4 0", rpy=f"0 0 {right}", axis=axis),
        joint("c", "d", "continuous", xyz="1 0 0.1", rpy=f"-{right} {right} 0"),
    )


ROUNDED = written("1.5708", "0.7854", "0 0.707106 0.707107")
EXACT = written(RIGHT, HALF, "0 1 1")
SNAP = {"snap": {"angle": 1e-4}}


def test_the_result_is_that_of_exact_numbers() -> None:
    for preset in ("faithful", "compact"):
        snapped = convert_text(ROUNDED, pipeline=preset, passes=SNAP)
        assert snapped.data == convert_text(EXACT, pipeline=preset).data
        assert snapped.report.verdict.endswith("what snap changed: 3 origins, 1 axis")
    assert snapped.report.joints.mbs < convert_text(ROUNDED, pipeline="compact").report.joints.mbs


def test_numbers_that_are_exact_or_further_off_are_not_snapped() -> None:
    """Not without the option, not what is exact, and not what is further off."""
    further = written("1.571", "0.785", "0 0.7 0.714")
    for text, passes in ((ROUNDED, {}), (EXACT, SNAP), (further, SNAP)):
        result = convert_text(text, passes=passes)
        assert not result.conversion.checked.changed
        assert "snapped" not in [diagnostic.code for diagnostic in result.diagnostics]


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_no_tip_moves_by_more_than_is_said(kind: str) -> None:
    """Pinocchio places the tips of both robots; the notes name each joint and each number."""
    pin = pytest.importorskip("pinocchio")
    limit = '<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
    texts = [
        written(*numbers, kind).replace("</joint>", limit)
        for numbers in (("1.5708", "0.7854", "0 0.707106 0.707107"), (RIGHT, HALF, "0 1 1"))
    ]
    result = convert_text(texts[0], passes=SNAP)
    assert result.data == convert_text(texts[1]).data
    found = result.conversion.report["snap"]
    models = [pin.buildModelFromXML(text) for text in texts]
    rng = np.random.default_rng(1)
    apart = []
    for _ in range(200):
        # a coordinate in the limits of the first joint, and an angle of the second
        angle = rng.uniform(-np.pi, np.pi)
        q = np.array([rng.uniform(-2, 2), np.cos(angle), np.sin(angle)])
        ends = []
        for model in models:
            data = model.createData()
            pin.framesForwardKinematics(model, data, q)
            ends.append(data.oMf[model.getFrameId("d")].translation)
        apart.append(float(np.linalg.norm(ends[0] - ends[1])))
    assert found["moves"] / 20 < max(apart) <= found["moves"] < 1e-4
    notes = [
        diagnostic.message for diagnostic in result.diagnostics if diagnostic.code == "snapped"
    ]
    assert len(notes) == 4
    assert "joint 'a_to_b': roll 1.5708 is taken for 90 degrees, yaw -0.7854 is taken" in notes[0]
    assert f"moves no tip by more than {found['joints']['a_to_b']['moves']:.2g} m" in notes[0]
    assert "axis 0.0 0.707106 0.707107 is taken for 0 1 1" in notes[1]


def test_certificate_and_page_know(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("r.urdf").write_text(ROUNDED)
    asked = ["--set", "snap.angle=1e-4"]
    assert main(["convert", "r.urdf", "-o", "p/", *asked]) == 0
    assert main(["report", "r.urdf", "-o", "page.html", *asked]) == 0
    assert "3 origins, 1 axis" in Path("page.html").read_text()
    assert certificate.main(["r.urdf", "p/dataR/p.mbs", "p/dataR/p.proof.json"]) == 0
    said = capsys.readouterr().out
    assert said.count("on purpose") == 4 + 2  # three origins and an axis, and the floating base


def test_a_slide_moves_a_tip_by_as_much_as_it_reaches() -> None:
    """The turn of the origin, times the way to the tip and the slide's farthest end."""
    text = robot(
        link("a", SOLID),
        link("b", SOLID.replace("0.1 -0.2 0.3", "0 0 2")),
        joint("a", "b", "prismatic", rpy="1.5708 0 0").replace('lower="-1"', 'lower="-5"'),
    )
    moves = convert_text(text, passes=SNAP).conversion.report["snap"]["moves"]
    assert moves == pytest.approx((2 + 5) * (1.5708 - float(RIGHT)), rel=1e-9)
    for rpy in ("0 1.5708 0", "0 0 1.5708"):
        turned = text.replace("1.5708 0 0", rpy)
        assert convert_text(turned, passes=SNAP).conversion.report["snap"]["moves"] == moves
    beside = text.replace("</robot>", f"{link('c', SOLID)}{joint('a', 'c')}</robot>")
    assert convert_text(beside, passes=SNAP).conversion.report["snap"]["moves"] == moves
    free = re.sub("<limit[^>]*>", "", text)
    moves = convert_text(free, passes=SNAP).conversion.report["snap"]["moves"]
    assert moves == pytest.approx(2 * (1.5708 - float(RIGHT)), rel=1e-9)
    axis = text.replace('"1.5708 0 0"', '"0 0 0"').replace('xyz="0 0 1"', 'xyz="0 0.00005 1"')
    moves = convert_text(axis, passes=SNAP).conversion.report["snap"]["moves"]
    assert moves == pytest.approx((2 + 5) * 2 * 0.00005, rel=1e-6)
