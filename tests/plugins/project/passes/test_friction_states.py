"""The states of friction, behind all other user models."""

from pathlib import Path

from urdf2mbs.testing import TINY, convert_text

RUBS = TINY.replace('damping="0.1"', 'damping="0.1" friction="0.2"')
CONTACTS = {"contacts": {"points": {"hand": [[0.0, 0.0, 0.0]]}}, "posture": {"hold": {}}}


def test_a_joint_has_one_state_and_a_body_three(tmp_path: Path) -> None:
    result = convert_text(RUBS, output={"project": tmp_path / "robot"}, passes=CONTACTS)
    *other_models, joints, bodies = result.mbs.user_models
    assert [(joints.name, bodies.name)] == [("friction_state", "contact_state")]
    assert [(p.name, p.type, p.values) for p in joints.parameters] == [
        ("shoulder", "state", ("0.0",))
    ]
    assert [(p.name, p.type, p.values) for p in bodies.parameters] == [
        ("hand", "state", ("0.0", "0.0", "0.0"))
    ]
    assert "hold_stiffness" in {model.name for model in other_models}
    assert "state" not in {p.type for model in other_models for p in model.parameters}


def test_a_model_alone_has_no_states() -> None:
    models = convert_text(RUBS, passes=CONTACTS).mbs.user_models
    assert not {model.name for model in models} & {"friction_state", "contact_state"}
