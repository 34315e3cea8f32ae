"""The motion of a cut's ends: its derivatives are those of how far it is open."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from oracle.motion import Motion
from proving import SOLID, joint, link, robot

from urdf2mbs.mbs.model import Connection
from urdf2mbs.mbs.reader import read
from urdf2mbs.proof.mbs_side import mbs_side
from urdf2mbs.testing import convert_text


@pytest.mark.parametrize("kind", ["ball", "rod", "solid"])
def test_how_fast_a_cut_opens(kind: str) -> None:
    text = robot(
        link("world"), *(link(name, SOLID) for name in "abc"),
        joint("world", "a", axis="0 0 1", xyz="0.3 0.1 0"),
        joint("a", "b", "prismatic", axis="1 0 0", xyz="0 0.4 0.2", rpy="0.2 0 0.5"),
        joint("b", "c", axis="0 1 0", xyz="0.5 -0.1 0"),
    )  # fmt: skip
    mbs = read(convert_text(text).data, "")
    joints, numbers = mbs.joints(), mbs.numbers()
    cut = Connection(kind, "tie", ("c", None), ("a", None), 0.3)
    side, random = mbs_side(mbs, joints), np.random.default_rng(1)
    q, qd, qdd = np.insert(random.uniform(-1.0, 1.0, (3, len(joints))), 0, 0.0, axis=1)

    def opening(t: float) -> Any:
        moved = Motion(side, numbers, len(q)).moved(q + t * qd + t * t * qdd / 2, qd + t * qdd)
        return moved.opening(mbs, cut, qdd)

    h = 1e-4
    gap, rows, acceleration = opening(0.0)
    before, after = opening(-h)[0], opening(h)[0]
    count = 1 if kind == "rod" else 3
    rates, bends = (after - before) / (2 * h), (after - 2 * gap + before) / h**2
    np.testing.assert_allclose((rows @ qd)[:count], rates[:count], atol=1e-6)
    np.testing.assert_allclose(acceleration[:count], bends[:count], atol=1e-5)
    speeds = [opening(t)[1] @ (qd + t * qdd) for t in (-h, h)]
    np.testing.assert_allclose(acceleration, (speeds[1] - speeds[0]) / (2 * h), atol=1e-5)
    assert np.abs(rates[:count]).min() > 1e-3
    if kind == "rod":
        here = Motion(side, numbers, len(q)).moved(q, qd)
        away = here.end(mbs, cut.endpoint2).P - here.end(mbs, cut.endpoint1).P
        assert gap[0] == pytest.approx(np.linalg.norm(away) - 0.3)
    if kind == "solid":  # its ends turn with their bodies
        assert np.abs(gap[3:]).max() > 0.1
        assert (rows @ qd).shape == acceleration.shape == gap.shape
