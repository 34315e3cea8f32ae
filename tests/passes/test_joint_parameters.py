"""Joint parameters: numbers of the URDF, and of soft stops; the oracle proves the laws."""

from support.presets import PRESETS
from support.proving import codes, models
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import TINY, convert_text


def test_user_models_hold_what_the_urdf_states() -> None:
    """By the names of the .mbs joints; a limit may be on one side only."""
    text = TINY.replace("shoulder", "shoulder/1").replace('lower="-1" upper', 'lower="-inf" upper')
    text = text.replace(
        '<dynamics damping="0.1"/>',
        '<dynamics damping="0.1" friction="0.4"/><calibration rising="0.3"/><safety_controller '
        'soft_lower_limit="-1" soft_upper_limit="1.25" k_position="15" k_velocity="10"/>',
    )
    result = convert_text(text)
    assert models(read_mbs(result.data, "robot.mbs")) == {
        "q_min": {"shoulder_1": -1.5},
        "q_max": {"shoulder_1": 1.5, "wrist_pitch": 1.0},
        "effort": {"shoulder_1": 10.0, "wrist_pitch": 1.0},
        "velocity": {"shoulder_1": 2.0, "wrist_pitch": 2.0},
        "damping": {"shoulder_1": 0.1},
        "friction": {"shoulder_1": 0.4},
        "soft_q_min": {"shoulder_1": -1.0},
        "soft_q_max": {"shoulder_1": 1.25},
        "k_position": {"shoulder_1": 15.0},
        "k_velocity": {"shoulder_1": 10.0},
        "calibration_rising": {"shoulder_1": 0.3},
    }
    assert not codes(result) & {"limit", "safety-controller", "calibration"}
    assert "joint-dynamics" in codes(result), "nothing applies them in a plain .mbs"


ZERO = TINY.replace('lower="-1.5" upper="1.5" ', "").replace('lower="-1" upper="1"', "")


def test_limits_from_zero_to_zero_are_none_or_lock_the_joint() -> None:
    """As the config chooses; the proof knows both, and an edited limit is a difference."""
    assert 'lower="-1.5"' in TINY
    free = convert_text(ZERO)
    assert "q_min" not in models(free.mbs)
    assert "limit-zero" in codes(free)
    for pipeline in PRESETS:
        options = {"joint-parameters": {"zero_limits": "locked"}}
        locked = convert_text(ZERO, pipeline=pipeline, passes=options)
        written = models(read_mbs(locked.data, "robot.mbs"))
        assert written["q_min"]["shoulder"] == written["q_max"]["shoulder"] == 0.0
        assert locked.report.proof.same
        assert not locked.report.proof.differences


def test_bounds_of_urdf_1_2_are_kept() -> None:
    rates = 'acceleration="4" deceleration="5" jerk="6" '
    result = convert_text(TINY.replace('lower="-1.5"', f'{rates} lower="-1.5"'))
    written = models(result.mbs)
    assert [written[kind]["shoulder"] for kind in ("acceleration", "deceleration", "jerk")] == [
        4.0,
        5.0,
        6.0,
    ]
    assert result.report.proof.same
    assert not result.report.proof.differences
