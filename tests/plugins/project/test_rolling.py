"""Wheels and balls roll: their lowest point touches, wherever they have turned."""

from pathlib import Path

import pytest

from support.build import joint, link, robot, solid
from urdf2mbs import simulate
from urdf2mbs.config.load import config_of
from urdf2mbs.engine.output import write
from urdf2mbs.engine.pipeline import Pipeline

FORCE, TIME = 2.0, 0.4


def shape(geometry: str) -> str:
    origin = '<origin rpy="1.5707963267948966 0 0"/>'
    return f"<collision>{origin}<geometry>{geometry}</geometry></collision>"


WHEEL = shape('<cylinder radius="0.08" length="0.04"/>')
CART = robot(
    link("chassis", solid(4.0, (0.05, 0.08, 0.1))),
    link("left", solid(0.5, (0.0008, 0.0012, 0.0008)), WHEEL),
    link("right", solid(0.5, (0.0008, 0.0012, 0.0008)), WHEEL),
    link("ball", solid(0.2, (5e-5, 5e-5, 5e-5)), shape('<sphere radius="0.03"/>')),
    joint("chassis", "left", xyz="0.1 0.2 0.08", axis="0 1 0"),
    joint("chassis", "right", xyz="0.1 -0.2 0.08", axis="0 1 0"),
    joint("chassis", "ball", "ball", xyz="-0.15 0 0.03", axis="0 1 0"),
)


@pytest.mark.parametrize("language", ["python", "c"])
def test_a_cart_that_is_pushed_rolls(tmp_path: Path, language: str) -> None:
    (tmp_path / "cart.urdf").write_text(CART)
    values = {
        "source": str(tmp_path / "cart.urdf"),
        "base": "floating",
        "pipeline": "compact",
        "output": {"project": str(tmp_path / "cart"), "language": language},
        "passes": {
            "contacts": {"roll": ["left", "right", "ball"]},
            "forces": {"wrenches": {"push": {"link": "chassis", "force": [FORCE, 0.0, 0.0]}}},
        },
    }
    conversion = Pipeline(*config_of(values), installed_plugins=False).run()
    assert conversion.checked.rejected is None
    write(conversion)
    results = simulate(tmp_path / "cart", time=TIME, language=language, rate=100.0)
    # what turns adds its inertia over the square of its radius
    mass = 5.2 + 2 * 0.0012 / 0.08**2 + 5e-5 / 0.03**2
    distance = FORCE / mass * TIME**2 / 2
    assert results.joint("floating_base_T1")[-1] == pytest.approx(distance, rel=0.02)
    for wheel, radius in (("left", 0.08), ("right", 0.08), ("ball_R2", 0.03)):
        assert results.joint(f"chassis_to_{wheel}")[-1] * radius == pytest.approx(
            distance, rel=0.05
        )
