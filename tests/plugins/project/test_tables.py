"""The tables of names and values in generated code."""

from typing import Any

import pytest

from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs_project.code import list_plotted_joints
from urdf2mbs_project.code.python import format_table

FLOATING = [f"base_{kind}" for kind in ("T1", "T2", "T3", "R1", "R2", "R3")]


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
def test_moving_joints_are_plotted_but_not_those_of_a_floating_base_beside_others(
    bodies: Any, names: list[str]
) -> None:
    """A star: driven."""
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
    text = f"TABLE = {format_table(value)}"
    exec(text, space)
    assert space["TABLE"] == value
    assert format_table([-0.0]) == "[\n    0.0,\n]"
    assert all(len(line) < 100 or "long" in line for line in text.splitlines())
