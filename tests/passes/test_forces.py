"""Forces: external forces at points, and springs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from project.standin import MbsData, from1, make, user_functions

from urdf2mbs.mbs.kinematics import place
from urdf2mbs.testing import TINY


def test_wrenches_and_springs(tmp_path: Path) -> None:
    passes = {
        "forces": {
            "wrenches": {
                "hand": {"link": "hand", "at": [0, 0, 0.1], "force": [1, 2, 3],
                         "torque": [4, 5, 6], "start": 0.5, "stop": 1.0},
            },
            "springs": {
                "band": {"ends": [{"link": "body"}, {"link": "arm", "at": [0, 0, 0.3]}],
                         "stiffness": 100, "damping": 5},
            },
        }
    }  # fmt: skip
    project = make(tmp_path, TINY, passes=passes)
    data = MbsData(project / "dataR" / "robot.mbs")
    assert data.extforce_id == {"hand_force": 1}, "the body keeps its name"
    assert "hand" in data.body_id
    with user_functions(project) as user:
        P, R = from1(3), from1(3, 3)
        for t, wanted in ((0.0, [0.0] * 6), (0.5, [1, 2, 3, 4, 5, 6]), (1.0, [0.0] * 6)):
            row = user["user_ExtForces"].user_ExtForces(P, R, P, P, P, P, data, t, 1)
            assert np.array_equal(np.array(row)[1:7], wanted)
        rest = data.user_model["link_length"]["band"]
        placement = place(data.mbs)
        (link,) = data.mbs.links
        ends = [placement.point(data.mbs, *end) for end in (link.endpoint1, link.endpoint2)]
        assert rest == pytest.approx(np.linalg.norm(np.subtract(*ends)))
        pull = user["user_LinkForces"].user_LinkForces(rest + 0.02, 0.1, data, 0.0, 1)
        assert pull == pytest.approx(100 * 0.02 + 5 * 0.1)
        assert user["user_LinkForces"].user_LinkForces(1.0, 0.0, data, 0.0, 9) == 0.0
