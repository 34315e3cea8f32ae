"""Reframe inertia: mass, centre, and the inertia about it in body axes."""

import pytest

from support.build import SOLID, joint, link, robot
from support.presets import PRESETS
from urdf2mbs import Result
from urdf2mbs.testing import convert_text

ZEROS = (
    '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
    "</inertial>"
)


def reframed(*elements: str) -> Result:
    return convert_text(
        robot(link("world"), *elements),
        pipeline=["expand", "insert-base", "prune-massless", "reframe-inertia"],
    )


def solid(rpy: tuple[float, float, float], mass: float = 2.0) -> str:
    numbers = " ".join(map(repr, rpy))
    return SOLID.replace("0.3 -0.2 0.1", numbers).replace('"2"', f'"{mass!r}"')


@pytest.mark.parametrize(("mass", "told"), [(0.0, 0.0), (1e-300, 1e-300), (1e9, 1e9)])
def test_any_mass_is_kept(mass: float, told: float) -> None:
    (body,) = reframed(link("a", solid((0.0, 0.0, 0.0), mass)), joint("world", "a")).mbs.bodies
    assert body.mass == told
    assert body.inertia == (0.03, 0.001, -0.002, 0.04, 0.003, 0.05)


@pytest.mark.parametrize("inertial", ["", ZEROS])
def test_a_link_without_inertia_gets_none(inertial: str) -> None:
    result = convert_text(
        robot(
            link("world"),
            link("a", inertial),
            joint("world", "a"),
            link("b", SOLID),
            joint("a", "b"),
        ),
        pipeline=["expand", "insert-base", "prune-massless", "reframe-inertia"],
        passes={"prune-massless": {"keep": ["a"]}},
    )
    a, b = result.mbs.bodies
    assert (a.mass, a.com, a.inertia) == (None, None, None)
    assert b.mass == 2.0


RIGHT = "1.5707963267948966"
#: Its numbers are plain, and turned by right angles, whose cosines in floats are 6e-17.
PLAIN = SOLID.replace("0.1 -0.2 0.3", "0 0 0.3")
for _moment in ('ixy="0.001"', 'ixz="-0.002"', 'iyz="0.003"'):
    PLAIN = PLAIN.replace(_moment, f'{_moment[:3]}="0"')
TURNED = robot(
    link("world"),
    link("a", PLAIN.replace("0.3 -0.2 0.1", f"0 {RIGHT} 0")),
    link("b", PLAIN.replace("0.3 -0.2 0.1", f"{RIGHT} 0 0")),
    link("c", PLAIN.replace("0.3 -0.2 0.1", f"0 0 {RIGHT}")),
    joint("world", "a", xyz="0 0 0.2", rpy=f"{RIGHT} 0 0"),
    joint("a", "b", xyz="0 0 0.2", rpy=f"0 {RIGHT} 0"),
    joint("b", "c", xyz="0 0.2 0", rpy=f"{RIGHT} 0 {RIGHT}"),
)


@pytest.mark.skipif("compact" not in PRESETS, reason="the plugin compact is away")
def test_roundings_of_zero_are_zero_in_compact() -> None:
    result = convert_text(TURNED, pipeline="compact")
    assert result.report.proof is not None
    assert result.report.proof.same
    rows: list[tuple[float, ...]] = []
    for body in result.mbs.bodies:
        rows += [body.com, body.inertia, *(point.coordinates for point in body.points)]
    small = [v for row in rows for v in row if 0.0 < abs(v) < 1e-12 * max(map(abs, row))]
    assert small == []
    assert len(rows) >= 8


def test_what_a_urdf_states_is_not_rounded() -> None:
    """A product of inertia of 1e-20 stays, if nothing turns it."""
    own = SOLID.replace('ixy="0.001"', 'ixy="1e-20"').replace("0.3 -0.2 0.1", "0 0 0")
    (body,) = reframed(link("a", own), joint("world", "a")).mbs.bodies
    assert body.inertia[1] == 1e-20
