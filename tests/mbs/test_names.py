"""Names: identifiers that are unique in their name space, changed no more than needed."""

import re
from copy import deepcopy

import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.mbs_models import everything, few, models
from urdf2mbs.mbs.model import (
    Body,
    Connection,
    Joint,
    Mbs,
    Parameter,
    Point,
    Sensor,
    UserConstraint,
    UserModel,
    UserVariable,
)
from urdf2mbs.mbs.names import C_KEYWORDS, assign_identifiers, free_name, identifiers
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError

names = st.lists(
    st.text(max_size=6)
    | st.sampled_from(["a", "a_b", "a-b", "a b", "a_2", "a_b_2", "int", "x_body", "x", "é", "1"])
)


@few
@given(names, names, st.sampled_from(["", "_body"]))
def test_names_become_identifiers_no_two_alike_and_none_reserved(
    given_names: list[str], reserved: list[str], suffix: str
) -> None:
    out = identifiers(given_names, reserved, suffix)
    assert len(out) == len(given_names)
    assert len(set(out)) == len(out)
    assert not {*out} & {*reserved, *C_KEYWORDS}
    assert all(re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name, re.ASCII) for name in out)


@few
@given(names)
def test_good_names_keep_themselves_and_a_second_time_changes_nothing(
    given_names: list[str],
) -> None:
    out = identifiers(given_names)
    for old in {*given_names} - C_KEYWORDS:
        if re.fullmatch("[A-Za-z][A-Za-z0-9_]*", old, re.ASCII):
            assert out[given_names.index(old)] == old
    assert identifiers(out) == out


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("left hip-yaw", "left_hip_yaw"),
        ("torso/chest.link", "torso_chest_link"),
        ("1st", "n_1st"),
        ("_x", "n__x"),
        ("-", "n__"),
        ("", "n_"),
        ("hüfte", "h_fte"),
        ("٣", "n__"),  # a digit, though not one of C's
        ("line\n", "line_"),
        ("double", "double_joint"),
    ],
)
def test_other_names_are_changed_as_little_as_possible(old: str, new: str) -> None:
    assert identifiers([old], suffix="_joint") == [new]


def test_a_good_name_goes_before_a_changed_one_that_would_be_the_same() -> None:
    assert identifiers(["a-b", "a_b", "a b"], suffix="_body") == ["a_b_body", "a_b", "a_b_body_2"]


def test_bodies_and_joints_share_a_name_space() -> None:
    mbs = Mbs(
        "m",
        bodies=[
            Body(
                "hip",
                joints=[Joint("hip", "R1"), Joint("base", "R1")],
                points=[Point("p", sensor=Sensor("hip"), extforce=Sensor("hip"))],
            ),
            Body("hip_body", "hip", "p", [Joint("hip body", "R1")]),
            Body("origin", "hip", None, [Joint("o", "R1")]),
            Body("floor", "origin", None, [Joint("f", "R1")]),
        ],
    )
    mbs.base.name = "floor"
    bodies, joints = assign_identifiers(mbs)
    assert bodies == {
        "hip": "hip_body_2",
        "hip_body": "hip_body",
        "origin": "origin_body",
        "floor": "floor_body",
    }
    assert joints == {
        "hip": "hip",
        "base": "base_joint",
        "hip body": "hip_body_joint",
        "o": "o",
        "f": "f",
    }
    sensor, force = mbs.bodies[0].points[0].sensor, mbs.bodies[0].points[0].extforce
    assert (sensor and sensor.name, force and force.name) == ("hip_sensor", "hip_force")
    assert [body.parent for body in mbs.bodies] == [None, "hip_body_2", "hip_body_2", "origin_body"]


def test_a_base_called_base_gets_a_name_of_its_own() -> None:
    mbs = Mbs("m")
    mbs.base.name = "base"
    assign_identifiers(mbs)
    assert mbs.base.name == "base_ground"


def test_points_have_a_name_space_for_each_body_and_references_follow() -> None:
    mbs = Mbs(
        "m",
        bodies=[
            Body("a-1", joints=[Joint("j-1", "R1")], points=[Point("p q"), Point("origin")]),
            Body("b", "a-1", "p q", [Joint("j2", "R1")], points=[Point("p q"), Point("p_q")]),
            Body("c", "a-1", "origin", [Joint("j3", "R1")]),
            Body("d", None, "q-r", [Joint("j4", "R1")]),
        ],
        cuts=[Connection("ball", "cut", ("b", "p q"), (None, "q-r"))],
        user_constraints=[UserConstraint("u", ("j-1", "j2"))],
    )
    mbs.base.points.append(Point("q-r"))
    assign_identifiers(mbs)
    assert [[point.name for point in body.points] for body in mbs.bodies[:2]] == [
        ["p_q", "origin_point"],
        ["p_q_point", "p_q"],
    ]
    assert [body.point for body in mbs.bodies] == [None, "p_q", "origin_point", "q_r"]
    assert mbs.cuts[0].endpoint1 == ("b", "p_q_point")
    assert mbs.cuts[0].endpoint2 == (None, "q_r")
    assert mbs.user_constraints[0].joints == ("j_1", "j2")


def test_what_is_good_already_stays_as_it_is() -> None:
    mbs = everything()
    assign_identifiers(mbs)
    assert mbs == everything()


@few
@given(models())
def test_a_renamed_model_can_be_read_and_is_renamed_no_further(mbs: Mbs) -> None:
    assign_identifiers(mbs)
    again = deepcopy(mbs)
    assign_identifiers(again)
    assert again == mbs
    assert read_mbs(write(mbs), "m.mbs") == mbs


def test_user_elements_have_name_spaces_of_their_own() -> None:
    """A parameter that is called as a joint keeps to the joint's new name."""
    parameters = [Parameter(name, "scalar") for name in ("j-1", "2x", "2x")]
    mbs = Mbs("m", bodies=[Body("b", joints=[Joint("j-1", "R1")])])
    mbs.user_constraints = [UserConstraint("a b"), UserConstraint("a_b", ("j-1",))]
    mbs.user_models = [UserModel("a b"), UserModel("a_b", parameters), UserModel("b")]
    mbs.user_variables = [UserVariable("a b", "in", "1"), UserVariable("a_b", "in", "1")]
    assign_identifiers(mbs)
    assert [element.name for element in mbs.user_constraints] == ["a_b_constraint", "a_b"]
    assert [element.name for element in mbs.user_models] == ["a_b_model", "a_b", "b"]
    assert [element.name for element in mbs.user_variables] == ["a_b_variable", "a_b"]
    assert [part.name for part in parameters] == ["j_1", "n_2x", "n_2x_parameter"]
    assert mbs.user_constraints[1].joints == ("j_1",)


HIP = ("hip", None)


@pytest.mark.parametrize(
    ("cut", "message", "hint"),
    [
        (
            Connection("ball", "c", HIP, ("hib", None)),
            "ball 'c' refers to body 'hib', which the .mbs does not have",
            "did you mean 'hip'?",
        ),
        (
            Connection("rod", "c", ("hip", "ankel"), HIP),
            "rod 'c' refers to point 'ankel', which body 'hip' does not have",
            "did you mean 'ankle'?",
        ),
        (
            Connection("rod", "c", (None, "x"), HIP),
            "rod 'c' refers to point 'x', which the base does not have",
            None,
        ),
    ],
)
def test_a_dangling_reference_is_an_error_that_names_the_nearest(
    cut: Connection, message: str, hint: str | None
) -> None:
    body = Body("hip", joints=[Joint("j", "R1")], points=[Point("ankle")])
    with pytest.raises(ConversionError) as caught:
        assign_identifiers(Mbs("m", bodies=[body], cuts=[cut]))
    error = caught.value
    assert (error.code, error.message, error.hint) == ("name-unknown", message, hint)


def test_the_first_free_name() -> None:
    assert free_name("a", set()) == "a"
    assert free_name("a", {"a"}) == "a_2"
    assert free_name("a", {"a", "a_2", "a_4"}) == "a_3"
    assert free_name("A", {"a"}) == "A"
    assert free_name("A", {"a", "a_2"}, str.lower) == "A_3"
