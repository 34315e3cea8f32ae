"""A wrong option of a pass is an error with its code; test_ranges.py has the ranges of numbers."""

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY, convert_text

ENDS = [{"link": "arm"}, {"link": "hand"}]


@pytest.mark.parametrize(
    ("name", "options", "code"),
    [
        ("actuators", {"joints": ["tool_mount"]}, "actuators-joints"),
        ("contacts", {"links": ["*_fot"]}, "contacts-links"),
        ("contacts", {"links": ["tool"]}, "contacts-shape"),
        ("contacts", {"links": ["wrist"]}, "contacts-body"),
        ("contacts", {"roll": ["hand"]}, "contacts-shape"),
        ("estimate-inertia", {"density": 1, "total_mass": 1}, "estimate-inertia"),
        ("force-torque", {"joints": ["tool_mount"]}, "force-torque-joint"),
        ("force-torque", {"joints": ["shoulder"]}, "force-torque-joint"),
        ("loops", {"cuts": {"x": {"ends": [ENDS[0], {"link": "hnad"}]}}}, "loops-link"),
        ("loops", {"cuts": {"x": {"ends": ENDS, "length": 1.0}}}, "loops-length"),
        ("loops", {"cuts": {"arm": {"ends": ENDS}}}, "loops-name"),
        ("mimic", {"joints": {"for": "driven"}}, "mimic-joints"),
        ("posture", {"joints": {"shuolder": 1.0}}, "posture-joint"),
        ("posture", {"joints": {"tool_mount": 1.0}}, "posture-joint"),
        ("posture", {"hold": {"gains": {"wirst": {}}}}, "posture-hold"),
        ("posture", {"state": "home"}, "posture-srdf"),
        ("posture", {"state": "home", "srdf": "not_there.srdf"}, "posture-srdf"),
        ("rotors", {"armature": {"x": 1.0}}, "rotors-joints"),
        ("sensors", {"links": ["hnad"]}, "sensors-links"),
        ("sensors", {"only": ["imu"]}, "sensors-only"),
    ],
)
def test_wrong_options(name: str, options: dict[str, Any], code: str) -> None:
    with pytest.raises(ConfigError) as caught:
        convert_text(TINY, passes={name: options})
    assert caught.value.code == code


def test_a_pass_of_ours_names_the_line(here: Path, capsys: Any) -> None:
    config = "source: tiny.urdf\npasses:\n  posture:\n    joints: {tool_mount: 1}\n"
    Path("tiny.yaml").write_text(config)
    assert main(["run", "tiny.yaml"]) == 2
    assert "tiny.yaml:4: error[posture-joint]" in capsys.readouterr().err
