"""Every field of MuJoCo's model is read, named as lost, or known to say no mechanics.

A new version of MuJoCo may bring a law that nothing here reads; then this fails.
"""

import pytest

from urdf2mbs_mjcf.compiler import ENUMERATIONS
from urdf2mbs_mjcf.fields import LOST, LOST_OPTIONS, PLUGINS, classify, classify_option

mujoco = pytest.importorskip("mujoco")
MODEL = mujoco.MjModel.from_xml_string("<mujoco/>")
FIELDS = [
    name for name in dir(MODEL) if not name.startswith("_") and not callable(getattr(MODEL, name))
]
OPTIONS = [name for name in dir(MODEL.opt) if not name.startswith("_")]


def test_each_field_and_option_is_classified() -> None:
    assert [field for field in FIELDS if classify(field) is None] == []
    assert [option for option in OPTIONS if classify_option(option) is None] == []


def test_a_new_field_is_not_classified_by_accident() -> None:
    new = ("jnt_ratchet", "dof_gyro", "body_magnet", "geom_glue", "actuator_backlash", "eq_slack")
    assert [classify(field) for field in new] == [None] * len(new)
    assert classify_option("tide") is None


def test_the_tables_name_fields_that_exist() -> None:
    """Of the newest version that is tested; an older one has fewer."""
    if int(mujoco.__version__.split(".")[0]) >= 4:
        assert {*LOST, *PLUGINS} <= {*FIELDS}
    assert {*LOST_OPTIONS} <= {*OPTIONS}
    assert {*ENUMERATIONS} <= {*FIELDS}


def test_lost_fields_are_zero_by_default() -> None:
    """Otherwise each model would lose them."""
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><joint name='j'/><geom size='.1'/></body></worldbody>"
        "<actuator><motor joint='j'/></actuator><keyframe><key/></keyframe></mujoco>"
    )
    for field in LOST.keys() & {*FIELDS}:
        assert not getattr(model, field).any(), field
    for field in PLUGINS:
        assert (getattr(model, field) == -1).all(), field
