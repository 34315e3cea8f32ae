"""Fit view: a camera that sees the whole robot."""

from typing import Any

import pytest

from support.build import BOX, SOLID, joint, link, robot
from urdf2mbs import Result
from urdf2mbs.testing import convert_text


def emitted(*elements: str, **settings: Any) -> Result:
    return convert_text(robot(link("world"), *elements), **settings)


@pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
def test_the_view_is_of_the_robots_size_and_looks_at_its_middle(scale: float) -> None:
    box = BOX.replace('size="1 2 3"', f'size="{scale} {scale} {scale}"').replace(
        'xyz="0.1 0 0.2" rpy="0.1 0.2 0.3"', f'xyz="{5 * scale} 0 0"'
    )
    light = SOLID.replace("0.1 -0.2 0.3", "0 0 0")
    view = emitted(link("a", light, box), joint("world", "a")).mbs.view
    (camera,) = view.viewpoints
    half = 3**0.5 / 2 * scale  # the ball round the box
    long = 5 * scale + half
    assert camera.target == pytest.approx((long / 2, 0.0, 0.0), rel=6e-3)
    size = max((long**2 + 2 * (2 * half) ** 2) ** 0.5, 0.1)
    away = [a - b for a, b in zip(camera.position, camera.target, strict=True)]
    assert away == pytest.approx([1.3 * size, 0.6 * size, 0.5 * size], rel=2e-2)
    assert camera.back_clip == pytest.approx(30 * size, rel=6e-3)
    assert camera.front_clip == pytest.approx(size / 200, rel=6e-3)
    assert view.frame == pytest.approx(size / 18, rel=6e-3)
    assert view.joint == view.com == pytest.approx(size / 9, rel=6e-3)
    assert view.point == pytest.approx(size / 6, rel=6e-3)


def test_the_view_sees_links_where_they_are_at_zero() -> None:
    light = SOLID.replace("0.1 -0.2 0.3", "0 0 0")
    down = joint("world", "a", xyz="0 0 -4", rpy="0 1.5707963267948966 0")
    view = emitted(link("a", light), link("b", light), down, joint("a", "b", xyz="2 0 0")).mbs.view
    assert view.viewpoints[0].target == pytest.approx((0.0, 0.0, -3.0), abs=1e-9)
