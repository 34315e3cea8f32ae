"""Joint laws: what the user models of joints need besides the URDF's numbers."""

from math import pi, sqrt
from pathlib import Path

import pytest

from support.proving import models
from urdf2mbs.testing import TINY, convert_text


def test_a_stop_swings_with_its_frequency(tmp_path: Path) -> None:
    """The hand has 1e-4 kg m^2, and 0.1 kg at 0.05 m, of which the axis sees the half squared."""
    inertia = 1e-4 + 0.1 * 0.05**2 / 2
    alone = TINY.replace('name="shoulder" type="revolute"', 'name="shoulder" type="fixed"')
    alone = alone.replace("continuous", "fixed")
    for frequency in (5.0, 20.0):
        options = {"joint-parameters": {"stop_frequency": frequency}}
        result = convert_text(
            alone, base="fixed", passes=options, output={"project": tmp_path / "p"}
        )
        stiffness = models(result.mbs)["stop_stiffness"]["wrist_pitch"]
        swing = sqrt(stiffness / inertia) / (2 * pi)
        assert swing == pytest.approx(frequency, rel=0.01)


def test_a_locked_joint_stays_where_it_is(tmp_path: Path) -> None:
    """Soft stops on both sides hold it, and its numbers are finite."""
    text = TINY.replace('lower="-1.5" upper="1.5" ', "").replace('lower="-1" upper="1"', "")
    options = {"joint-parameters": {"zero_limits": "locked"}}
    result = convert_text(text, passes=options, output={"project": str(tmp_path / "p")})
    written = models(result.mbs)
    assert written["stop_stiffness"]["shoulder"] > 0.0
    assert written["q_min"]["shoulder"] == written["q_max"]["shoulder"] == 0.0
