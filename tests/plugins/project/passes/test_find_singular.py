"""What is said of models that cannot be solved, and which base ``auto`` takes."""

from typing import Any

import pytest

from support.build import SOLID, joint, link, robot
from support.folders import SHARED
from urdf2mbs import Result, convert
from urdf2mbs.testing import convert_text

ODD = SHARED / "odd-robots" / "17_massless_root_floats.urdf"
POINT = '<inertial><origin xyz="0 0 0.2"/><mass value="2"/></inertial>'
ROD = (
    '<inertial><origin xyz="0 0 0.2"/><mass value="2"/>'
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0"/></inertial>'
)
ASIDE = POINT.replace('"0 0 0.2"', '"0.3 0 0.2"')


def told(result: Result) -> list[tuple[str, str]]:
    return [
        (diagnostic.code, diagnostic.message.partition(": ")[2])
        for diagnostic in result.diagnostics
        if diagnostic.code.startswith("singular")
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            robot(link("a"), link("b", POINT), joint("a", "b")),
            [("singular", "joint 'a_to_b' turns about an axis about which nothing has inertia")],
        ),
        (
            robot(link("a"), link("b", ROD), joint("a", "b")),
            [("singular", "joint 'a_to_b' turns about an axis about which nothing has inertia")],
        ),
        (robot(link("a"), link("b", ROD), joint("a", "b", axis="1 0 0")), []),
        (robot(link("a"), link("b", ASIDE), joint("a", "b")), []),
        (
            robot(
                link("a"),
                link("b"),
                link("c", SOLID),
                joint("a", "b"),
                joint("b", "c", xyz="0 0 1"),
            ),
            [
                (
                    "singular",
                    "joint 'a_to_b' can move together with 'b_to_c' so that nothing that has "
                    "mass moves",
                )
            ],
        ),
        (
            robot(
                link("a"),
                link("b"),
                link("c", SOLID),
                joint("a", "b"),
                joint("b", "c", rpy="1.5708 0 0", axis="0 1 0"),
            ),
            [
                (
                    "singular",
                    "joint 'a_to_b' can move together with 'b_to_c' so that nothing that has "
                    "mass moves",
                )
            ],
        ),
        (
            robot(
                link("a"),
                link("b"),
                link("c"),
                link("d", ASIDE.replace("0.3 0 0.2", "1 0 0")),
                joint("a", "b"),
                joint("b", "c", xyz="1 0 0"),
                joint("c", "d", axis="0 1 0"),
            ),
            [
                (
                    "singular-at-start",
                    "joint 'a_to_b' can move together with 'b_to_c' so that nothing "
                    "that has mass moves",
                )
            ],
        ),
    ],
    ids=[
        "point",
        "rod",
        "rod-across",
        "point-aside",
        "same-axis",
        "same-axis-rounded",
        "stretched",
    ],
)
@pytest.mark.parametrize("pipeline", ["faithful", "compact"])
def test_the_joint_and_the_reason_are_named(text: str, expected: Any, pipeline: str) -> None:
    assert told(convert_text(text, base="fixed", pipeline=pipeline)) == expected


def test_what_moves_nothing_is_told_once_for_all_such_joints() -> None:
    tips = [f"t{number}" for number in range(7)]
    text = robot(link("a", SOLID), *(link(tip) for tip in tips), *(joint("a", tip) for tip in tips))
    assert told(convert_text(text)) == []
    result = convert_text(text, passes={"prune-massless": {"keep": ["*"]}})
    assert told(result) == [
        (
            "singular",
            "each of the 7 joints 'a_to_t0', 'a_to_t1', 'a_to_t2', 'a_to_t3', 'a_to_t4' "
            "and 2 more moves nothing that has mass",
        )
    ]
    assert [singular["urdf_joint"] for singular in result.report.passes["singular"]] == [
        f"a_to_{tip}" for tip in tips
    ]


def test_a_light_finger_on_a_heavy_crane_is_not_singular() -> None:
    light = SOLID.replace('"2"', '"2e-9"')
    for number in ("0.03", "0.001", "-0.002", "0.04", "0.003", "0.05"):
        light = light.replace(f'="{number}"', f'="{number}e-9"')
    text = robot(
        link("a"),
        link("crane", SOLID.replace('"2"', '"2e5"')),
        link("finger", light),
        joint("a", "crane"),
        joint("crane", "finger", xyz="30 0 0"),
    )
    assert told(convert_text(text)) == []


@pytest.mark.skipif(not ODD.is_file(), reason="there are no odd robots beside the checkout")
def test_a_massless_root_floats_only_if_asked_to() -> None:
    assert convert(ODD).report.base == "fixed"
    assert told(convert(ODD)) == []
    assert told(convert(ODD, base="floating")) == [
        (
            "singular",
            "joint 'floating_base' can move together with 'j1' so that nothing that has mass moves",
        )
    ]
