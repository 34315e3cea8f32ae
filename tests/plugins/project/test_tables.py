"""The tables of names and numbers in generated code, without a compiler."""

import re
from typing import Any

import numpy as np
import pytest

from urdf2mbs.mbs.model import (
    Body,
    Connection,
    Joint,
    Mbs,
    Parameter,
    Point,
    Sensor,
    UserModel,
)
from urdf2mbs.spatial import ZERO
from urdf2mbs_project.code import c, list_plotted_joints, python
from urdf2mbs_project.simulation import (
    CONTACT_STATES,
    JOINT_STATES,
    Contact,
    Coupling,
    Simulation,
    Spot,
)
from urdf2mbs_project.stability import SpringDamper, compute_longest_steps, find_fastest_mode

FLOATING = [f"base_{kind}" for kind in ("T1", "T2", "T3", "R1", "R2", "R3")]


def robot() -> tuple[Mbs, Simulation]:
    """Two joints, of which the second rubs, and two feet; a point is called as a joint."""
    feet = [Point(f"foot{k}", extforce=Sensor(f"touch{k}")) for k in (1, 2)]
    mbs = Mbs(
        "r",
        bodies=[
            Body("a", joints=[Joint("lift", "T3")], points=[Point("swing"), *feet]),
            Body(
                "b",
                "a",
                "swing",
                [Joint("still", "T1", "driven"), Joint("a_swing", "R2")],
                points=[Point("tip", sensor=Sensor("eye"))],
            ),
        ],
        links=[
            Connection("link3D", "bushing", ("a", None), (None, None)),
            Connection("link", "rope", ("a", None), (None, None)),
        ],
        user_models=[
            UserModel.of("joint_forces", {"friction": 1.0}),
            UserModel.of("friction", {"lift": 1.0, "a_swing": 2.0}),
            UserModel(JOINT_STATES, [Parameter("a_swing", "state", ("0.0",))]),
            UserModel(CONTACT_STATES, [Parameter(n, "state", ("0.0",) * 3) for n in "ab"]),
        ],
    )
    simulation = Simulation(
        couplings=[Coupling(mbs.bodies[1].joints[0], mbs.bodies[0].joints[0], 2.0, -0.0)],
        contacts=[
            Contact(body, [body.name], foot, [Spot((1.0, 2.0, 2.0)), Spot(ZERO, 0.5)])
            for body, foot in zip(mbs.bodies, feet, strict=True)
        ],
    )
    return mbs, simulation


def test_states_of_friction_are_named_by_their_places() -> None:
    """A joint without a state has no friction."""
    files = {name: data.decode() for name, data in c.generate_c_files(*robot()).items()}
    rows = re.findall(r"Contact (\w+) = \{\w+_spots, (.*)\};", files["r_tables.h"])
    assert rows == [("touch1", "2, 2, 3.0"), ("touch2", "2, 5, 3.0")]
    assert "{.centre = {0.0, 0.0, 0.0}, .rim = {0.5, 0.0}},\n" in files["r_tables.h"]
    assert re.findall(r"joint_friction\(mbs_data, (\d, qd\[\w+\])", files["r_robot.c"]) == [
        "1, qd[a_swing_id]"
    ]
    assert "h[1] = q[still_id] - 2.0 * q[lift_id];\n" in files["r_robot.c"]
    module = python.generate_robot_module(*robot()).decode()
    assert "CONTACT_STATE = 2\n" in module
    assert '"a_swing": 1,' in module


def test_a_body_with_another_name_keeps_its_states() -> None:
    """The .mbs reserves ``base``, so a body of this name is called ``base_body`` in the end."""
    mbs, simulation = robot()
    mbs.bodies[0].name = "base_body"
    rows = re.findall(
        r"_spots, (\d+, \d+)", c.generate_c_files(mbs, simulation)["r_tables.h"].decode()
    )
    assert rows == ["2, 2", "2, 5"]


def test_each_thing_has_one_number_in_c() -> None:
    """Where two things would have one name, the kind stands behind the second."""
    mbs, simulation = robot()
    header = c.generate_c_files(mbs, simulation)["user_all_id.h"].decode()
    definitions = re.findall(r"#define (\w+)_id (\d+)\n", header)
    assert dict(definitions) == {
        "lift": "1",
        "still": "2",
        "a_swing": "3",
        "a": "1",
        "b": "3",
        "a_foot1": "2",
        "a_foot2": "3",
        "b_tip": "4",
        "a_swing_point": "1",
        "eye": "1",
        "touch1": "1",
        "touch2": "2",
        "rope": "1",
    }
    assert len(definitions) == 13
    heads = re.findall(r"\n/\* (\w+)", header)
    assert heads == ["joints", "bodies", "sensors", "external", "links", "points"]
    (sensor,) = [point.sensor for point in mbs.points().values() if point.sensor]
    sensor.name = "b"
    files = c.generate_c_files(mbs, simulation)
    assert b"#define b_sensor_id 1\n" in files["user_all_id.h"]
    assert (b"case b_sensor_id:" in files["r_robot.c"]) == bool(simulation.sensors)


def test_states_are_no_numbers_of_user_models_in_c() -> None:
    files = c.generate_c_files(*robot())
    structs = re.findall(r"struct (\w+) \{", files["user_model.h"].decode())
    assert structs == ["joint_forces", "friction"]
    source = files["user_model.c"].decode()
    body = " ".join(source.split("UserModel *um)\n")[-1].split())
    values = [
        f'um->{model}.{name} = find_parameter(gen, "{model}", "{name}", 0)->value_list[0];'
        for model, name in (
            ("joint_forces", "friction"),
            ("friction", "lift"),
            ("friction", "a_swing"),
        )
    ]
    states = [
        f'find_parameter(gen, "{model}", "{name}", {number});'
        for model, name, number in (
            ("friction_state", "a_swing", 1),
            ("contact_state", "a", 2),
            ("contact_state", "b", 5),
        )
    ]
    assert body == " ".join(["{", *values, *states, "}"])
    files = c.generate_c_files(Mbs("r"), Simulation())
    assert "double none;" in files["user_model.h"].decode()
    assert "list" not in files["user_model.c"].decode().split("UserModel *um)\n")[-1]


@pytest.mark.parametrize(
    ("bodies", "names"),
    [
        ([(None, ["j", "k"])], ["j", "k"]),
        ([(None, FLOATING), ("0", ["j"])], ["j"]),
        ([(None, FLOATING)], FLOATING),
        ([(None, FLOATING[:5]), ("0", ["j"])], [*FLOATING[:5], "j"]),
        ([(None, ["j"]), ("0", FLOATING)], ["j", *FLOATING]),
        ([(None, ["*j"]), ("0", ["k", "*l"])], ["k"]),
    ],
)
def test_what_is_plotted(bodies: Any, names: list[str]) -> None:
    """What moves; not the six joints of a floating base beside others.  A star: driven."""
    joints = [
        [Joint(n.lstrip("*"), "R1", "driven" if n[0] == "*" else "independent") for n in of]
        for _, of in bodies
    ]
    made = [Body(str(k), parent, None, joints[k]) for k, (parent, _) in enumerate(bodies)]
    assert list_plotted_joints(Mbs("r", bodies=made)) == names


@pytest.mark.parametrize(
    "value",
    [
        {},
        [],
        {"a": 1.0},
        ["a", 'quoted "b"'],
        {"a": "long" * 30},
        {"a": ("x",)},
        {"a": tuple(k / 7 for k in range(9)), "b": (("c", "d"), (1.0, 2.0, 3.0))},
    ],
)
def test_a_table_in_python_is_its_value(value: Any) -> None:
    space: dict[str, Any] = {}
    text = f"TABLE = {python._format_table(value)}"
    exec(text, space)
    assert space["TABLE"] == value
    assert python._format_table([-0.0]) == "[\n    0.0,\n]"
    assert all(len(line) < 100 or "long" in line for line in text.splitlines())


@pytest.mark.parametrize(("mass", "rate"), [(1e-14, 100.0), (1.0, 0.1), (1e6, 100.0)])
def test_the_fastest_mode_of_a_joint_beside_light_and_heavy_ones(mass: float, rate: float) -> None:
    """A direction without mass has no mode."""
    matrix = np.diag([0.0, mass, 1e9])
    stiffnesses = (("none", 1.0), ("own", mass * rate**2), ("far", 1.0))
    forces = [
        SpringDamper("spring", name, np.eye(3)[k], stiffness, 0.0)
        for k, (name, stiffness) in enumerate(stiffnesses)
    ]
    mode = find_fastest_mode(matrix, forces)
    assert abs(mode.eigenvalue) == pytest.approx(rate, rel=1e-9)
    assert mode.step == pytest.approx(compute_longest_steps(np.array([rate * 1j]))[0], rel=1e-9)
    assert mode.shares == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


def test_the_shares_of_a_mode_are_those_of_its_forces() -> None:
    row = np.ones(1)
    forces = [
        SpringDamper("hold", "a", row, 100.0, 2.0),
        SpringDamper("spring", "b", row, 50.0, 0.0),
    ]
    mode = find_fastest_mode(np.ones((1, 1)), forces)
    rate = np.roots([1.0, 2.0, 150.0])[0]
    assert abs(mode.eigenvalue) == pytest.approx(abs(rate), rel=1e-9)
    assert mode.eigenvalue.real == pytest.approx(-1.0, rel=1e-9)
    assert mode.shares == pytest.approx([1.0, 50.0 / abs(100.0 + 2.0 * rate)], rel=1e-9)
