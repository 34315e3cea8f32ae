"""The example payload.py: mass, centre of mass and inertia are those of the robot and the box."""

from math import hypot
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.plugin import ConfigError
from urdf2mbs.testing import TINY, assert_same_robot, run_pass

PLUGIN = Path(__file__).with_name("payload.py")
BOX: dict[str, Any] = {"link": "hand", "mass": 0.3, "size": [0.1, 0.2, 0.4], "at": [0, 0, 0.25]}


def test_the_body_carries_the_box() -> None:
    """The hand: 0.1 kg at 0.05 m, moments 1e-4 kg m^2; the sums are those of Steiner."""
    result = run_pass("payload", PLUGIN, options=BOX, pipeline="compact")
    assert_same_robot(result)
    (hand,) = [body for body in result.mbs.bodies if body.name == "hand"]
    assert hand.mass == pytest.approx(0.4)
    assert hand.com is not None
    assert hypot(*hand.com) == pytest.approx((0.1 * 0.05 + 0.3 * 0.25) / 0.4)
    transverse = 0.1 * 0.3 / 0.4 * 0.2**2  # reduced mass times distance squared
    moments = sorted(
        [
            1e-4 + 0.3 * (0.2**2 + 0.4**2) / 12 + transverse,
            1e-4 + 0.3 * (0.1**2 + 0.4**2) / 12 + transverse,
            1e-4 + 0.3 * (0.1**2 + 0.2**2) / 12,
        ]
    )
    assert hand.inertia is not None
    trace = sum(hand.inertia[k] for k in (0, 3, 5))
    assert trace == pytest.approx(sum(moments))


def test_the_change_is_told() -> None:
    result = run_pass("payload", PLUGIN, options=BOX)
    (change,) = result.conversion.checked.changed
    assert (change.declared, {c.kind for c in change.changes}) == (
        True,
        {"link-added", "joint-added"},
    )


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({**BOX, "link": "hnad"}, "payload-link"),
        ({**BOX, "mass": -1}, "value-range"),
        ({**BOX, "size": [0.1, 0.2]}, "config-type"),
        ({"mass": 1}, "config-key-missing"),
    ],
)
def test_a_wrong_option_is_an_error(options: dict[str, Any], code: str) -> None:
    with pytest.raises(ConfigError) as caught:
        run_pass("payload", PLUGIN, options=options)
    assert caught.value.code == code


def test_a_link_may_be_called_payload() -> None:
    robot = TINY.replace('"tool"', '"payload"')
    result = run_pass("payload", PLUGIN, options=BOX, robot=robot)
    inertials = [link.inertial for link in result.robot.links.values() if link.inertial]
    assert sum(inertial.mass for inertial in inertials) == pytest.approx(2.6 + 0.3)
    assert_same_robot(result)
