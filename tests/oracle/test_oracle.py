"""The oracle can fail: it is held against Pinocchio, finite differences, and broken files."""

from typing import Any

import numpy as np
import pytest

from support.oracle.generated import random_state
from support.oracle.mbs import Evaluator
from support.oracle.multibody import State, opening, translation
from support.oracle.pin import Truth
from urdf2mbs.mbs.reader import read_mbs

VECTOR = "<coordinates><x>{}</x><y>{}</y><z>{}</z></coordinates>"


def body(name: str, parent: str, point: str, joints: str, mass: float, *numbers: float) -> str:
    """Joints as ``tilt:R1=0.7``, which is driven at 0.7, or ``swing:R3``."""
    text = f"<body><bodyname>{name}</bodyname><parent><bodyname>{parent}</bodyname>"
    text += f"<pointname>{point}</pointname></parent>"
    for joint in joints.split():
        named, _, kind = joint.partition(":")
        kind, driven, start = kind.partition("=")
        text += f"<joint><jointname>{named}</jointname><type>{kind}</type><nature>"
        text += f"{'driven' if driven else 'independent'}</nature>"
        text += f"<initialvalue><q>{start or 0.0}</q></initialvalue></joint>"
    text += f"<mass>{mass}</mass><com>{VECTOR.format(*numbers[:3])}</com><inertia>"
    for key, value in zip(("xx", "xy", "xz", "yy", "yz", "zz"), numbers[3:], strict=True):
        text += f"<I{key}>{value}</I{key}>"
    side = f"<point><pointname>side</pointname>{VECTOR.format(-0.4, 0.5, 0.6)}</point>"
    return f"{text}</inertia>{side}</body>"


#: A floating body; on it a slide along a y that is turned, and a turn behind it; beside these a
#: wheel.  Nothing is aligned by chance.
CHAIN = f"""<mbsDescR7><base><gravity>{VECTOR.format(0.3, -0.2, -9.7)}</gravity>
<baseBodyName>ground</baseBodyName>
<point><pointname>start</pointname>{VECTOR.format(0.1, 0.2, 0.3)}</point></base><bodytree>
{
    body(
        "trunk",
        "base",
        "start",
        "T1:T1 T2:T2 T3:T3 R1:R1 R2:R2 R3:R3",
        3.5,
        0.02,
        -0.03,
        0.05,
        0.11,
        0.012,
        -0.013,
        0.12,
        0.017,
        0.14,
    )
}
{
    body(
        "slide",
        "trunk",
        "side",
        "tilt:R1=0.7 along:T2 swing:R3",
        1.25,
        -0.1,
        0.2,
        0.15,
        0.02,
        -0.002,
        0.001,
        0.03,
        -0.004,
        0.025,
    )
}
{body("wheel", "trunk", "origin", "spin:R2", 0.4, 0, 0, 0, 0.005, 0, 0, 0.008, 0, 0.006)}
</bodytree></mbsDescR7>"""


@pytest.mark.parametrize("seed", range(3))
def test_a_chain_moves_as_pinocchio_says(seed: int) -> None:
    mbs, at = read_mbs(CHAIN.encode(), ""), np.array((0.1, -0.2, 0.3))
    ours, truth = Evaluator(CHAIN.encode()), Truth(mbs)
    s = random_state(mbs, np.random.default_rng(seed), loads=False)
    state = State(ours.system, s.q, s.qd, s.qdd)
    number = mbs.numbers()["swing"]
    place, wanted = state.place(number, translation(at)), truth.sensor(s, number, at)
    for name, value in place._asdict().items():
        value = value[:, 1:] if name == "J" else value  # the ground is a node, too
        expected = getattr(wanted, name)[(slice(1, None),) * value.ndim]
        np.testing.assert_allclose(value, expected, atol=1e-12)
    matrix, force = state.equations()
    np.testing.assert_allclose(matrix[1:, 1:], truth.matrix(s), atol=1e-12)
    np.testing.assert_allclose(force[1:], truth.forces(s, accelerated=True), atol=1e-11)
    assert ours.system.carried_mass()[1] == 3.5 + 1.25 + 0.4 == ours.total_mass()


@pytest.mark.parametrize("kind", ["ball", "rod", "solid"])
def test_a_cut_opens_as_its_derivatives_say(kind: str) -> None:
    mbs = Evaluator(CHAIN.encode())
    q, qd, qdd = np.random.default_rng(1).uniform(-1.0, 1.0, (3, len(mbs.joints) + 1))

    def at(t: float) -> Any:
        state = State(mbs.system, q + t * qd + t * t * qdd / 2, qd + t * qdd, qdd)
        ends = [state.place(mbs.bodies[name].node) for name in ("wheel", "slide")]
        return opening(kind, 0.3, *ends)

    h = 1e-4
    (before, *_), (gap, rows, bend), (after, *_) = at(-h), at(0.0), at(h)
    count = min(len(gap), 3)
    rates, bends = (after - before) / (2 * h), (after - 2 * gap + before) / h**2
    np.testing.assert_allclose((rows @ qd)[:count], rates[:count], atol=1e-5)
    np.testing.assert_allclose(bend[:count], bends[:count], atol=1e-4)
    speeds = [at(t)[1] @ (qd + t * qdd) for t in (-h, h)]
    np.testing.assert_allclose(bend, (speeds[1] - speeds[0]) / (2 * h), atol=1e-4)
    assert np.abs(rates[:count]).min() > 1e-3


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("<bodyname>wheel</bodyname>", "<bodyname>trunk</bodyname>"),
        ("<jointname>spin</jointname>", "<jointname>swing</jointname>"),
        ("<jointname>spin</jointname>", "<jointname>wheel</jointname>"),
        ("<pointname>side</pointname>", "<pointname>origin</pointname>"),
        ("<pointname>origin</pointname>", "<pointname>nowhere</pointname>"),
        ("<bodyname>trunk</bodyname><pointname>o", "<bodyname>wheel</bodyname><pointname>o"),
        ("<type>R2</type>", "<type>R4</type>"),
        ("<nature>driven</nature>", "<nature>forced driven</nature>"),
        ("<mass>0.4</mass>", "<mass/>"),
        ("<mass>0.4</mass>", "<mass>nan</mass>"),
        ("<mass>0.4</mass>", "<mass>0,4</mass>"),
        ("<q>0.7</q>", "<q/>"),
        ("<x>0.02</x>", ""),
        ("mbsDescR7", "mbsDesc"),
    ],
)
def test_what_robotran_would_drop_in_silence_is_an_error(wrong: str, right: str) -> None:
    assert wrong in CHAIN
    with pytest.raises(ValueError, match=r"."):
        Evaluator(CHAIN.replace(wrong, right).encode())
