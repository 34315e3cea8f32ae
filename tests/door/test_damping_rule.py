"""The example damping_rule.py: the damper takes its share of the effort at full speed."""

from pathlib import Path

import pytest

from urdf2mbs.plugin import ConfigError
from urdf2mbs.testing import assert_same_robot, run_pass

PLUGIN = Path(__file__).with_name("damping_rule.py")


def test_the_dampers_are_those_of_the_rule(tmp_path: Path) -> None:
    """The shoulder states 0.1 N m s/rad, the wrist 1 N m and 2 rad/s, its roll no limit."""
    output = {"project": tmp_path / "tiny"}
    result = run_pass("damping-rule", PLUGIN, options={"share": 0.4}, output=output)
    (damping,) = [model for model in result.mbs.user_models if model.name == "damping"]
    dampers = {number.name: float(number.values[0]) for number in damping.parameters}
    assert dampers == pytest.approx({"shoulder": 0.1, "wrist_pitch": 0.4 * 1 / 2})
    assert_same_robot(result)
    (note,) = [found for found in result.diagnostics if found.code == "undamped"]
    assert "wrist_roll" in note.message


@pytest.mark.parametrize("share", [0, -0.1, 2, "much"])
def test_a_wrong_share_is_an_error(share: object) -> None:
    with pytest.raises(ConfigError, match=r"passes\.damping-rule\.share"):
        run_pass("damping-rule", PLUGIN, options={"share": share})
