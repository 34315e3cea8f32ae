"""Forces: where external forces and springs are; the oracle proves what they do."""

import pytest

from support.proving import models
from urdf2mbs.mbs.kinematics import compute_placement
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_project.places import compute_point_position

ARM = [{"link": "body"}, {"link": "arm", "at": [0, 0, 0.3]}]


def test_wrenches_and_springs_have_points_names_and_numbers() -> None:
    """A link keeps its name; a spring without a length is at rest at the start."""
    wrench = {"link": "hand", "at": [0, 0, 0.1], "force": [1, 2, 3], "torque": [4, 5, 6]}
    springs = {
        "band": {"ends": ARM, "stiffness": 100, "damping": 5},
        "arm": {"ends": ARM, "stiffness": 7, "length": 0.5},
    }
    passes = {
        "forces": {"wrenches": {"hand": {**wrench, "start": 0.5}}, "springs": springs},
        "posture": {"joints": {"shoulder": 1.0}},
    }
    mbs = convert_text(TINY, passes=passes).mbs
    points = {p.extforce.name: p for b in mbs.bodies for p in b.points if p.extforce}
    assert {name: point.coordinates for name, point in points.items()} == {
        "hand_force": (0.0, 0.0, 0.1)
    }
    numbers = models(mbs)
    assert numbers["hand"] == {
        "Fx": 1,
        "Fy": 2,
        "Fz": 3,
        "Mx": 4,
        "My": 5,
        "Mz": 6,
        "start": 0.5,
        "stop": 1e9,
    }
    assert numbers["link_stiffness"] == {"band": 100, "arm_spring": 7}
    assert numbers["link_damping"] == {"band": 5, "arm_spring": 0}
    placement = compute_placement(mbs)
    start, two = (
        compute_point_position(placement, mbs, *end)
        for end in (mbs.links[0].endpoint1, mbs.links[0].endpoint2)
    )
    rest = sum((a - b) ** 2 for a, b in zip(start, two, strict=True)) ** 0.5
    assert numbers["link_length"] == pytest.approx({"band": rest, "arm_spring": 0.5})
