"""Limits of joints that follow each other, which leave no motion, are found; others are not."""

import pytest

from support.build import SOLID, joint, link, robot
from urdf2mbs.testing import convert_text
from urdf2mbs.urdf.mimic import find_locked_joints
from urdf2mbs.urdf.reader import parse_urdf


def model(*joints: tuple[str, ...]) -> str:
    """Return a robot; each joint is its name, its limits, its ``<mimic>`` and its kind."""
    elements = [link("base", SOLID)]
    for name, limits, *more in joints:
        mimic, kind = (*more, *("", "revolute")[len(more) :])
        content = f'<limit {limits} effort="1" velocity="1"/>' if limits else ""
        content += f"<mimic {mimic}/>" if mimic else ""
        elements += [link(f"of_{name}", SOLID)]
        elements += [joint("base", f"of_{name}", kind, content, limited=False, name=name)]
    return robot(*elements)


def describe_locked(*joints: tuple[str, ...]) -> list[str]:
    parsed, _ = parse_urdf(model(*joints).encode(), "r.urdf")
    return [locked.describe(parsed) for locked in find_locked_joints(parsed)]


ONE = 'lower="0" upper="1"'
LEAD = ("lead", ONE)


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (
            [LEAD, ("foll", ONE, 'joint="lead" multiplier="-1"')],
            "joint 'foll': its limits and those of 'lead' leave 'lead' only 0: 'lead' has the "
            "limits [0, 1]; 'foll' = -1 * lead has the limits [0, 1], and so 'lead' [-1, 0]",
        ),
        (
            [LEAD, ("foll", ONE, 'joint="lead" offset="3"')],
            "joint 'foll': its limits and those of 'lead' leave 'lead' no position: 'lead' has the "
            "limits [0, 1]; 'foll' = 1 * lead + 3 has the limits [0, 1], and so 'lead' [-3, -2]",
        ),
        # rounded: 1.5708 and pi / 2
        (
            [
                ("lead", 'lower="0" upper="1.5708"'),
                ("foll", ONE, 'joint="lead" offset="-1.570796"'),
            ],
            "joint 'foll': its limits and those of 'lead' leave 'lead' only 1.5708: 'foll' = 1 * "
            "lead - 1.5708 has the limits [0, 1], and so 'lead' [1.5708, 2.5708]; 'lead' has the "
            "limits [0, 1.5708]",
        ),
        # two followers of an unlimited leader
        (
            [
                ("lead", "", "", "continuous"),
                ("a", ONE, 'joint="lead" multiplier="2"'),
                ("b", 'lower="-1" upper="0"', 'joint="lead" multiplier="3"'),
            ],
            "joint 'b': its limits and those of 'a' leave 'lead' only 0: 'a' = 2 * lead has the "
            "limits [0, 1], and so 'lead' [0, 0.5]; 'b' = 3 * lead has the limits [-1, 0], and so "
            "'lead' [-0.333333, 0]",
        ),
        # a chain: -1 * -1 * lead + 2
        (
            [
                LEAD,
                ("mid", "", 'joint="lead" multiplier="-1"', "continuous"),
                ("end", ONE, 'joint="mid" multiplier="-1" offset="2"', "prismatic"),
            ],
            "joint 'end': its limits and those of 'lead' leave 'lead' no position: 'lead' has the "
            "limits [0, 1]; 'end' = 1 * lead + 2 has the limits [0, 1], and so 'lead' [-2, -1]",
        ),
        (
            [LEAD, ("foll", ONE, 'joint="lead" multiplier="0" offset="2"')],
            "joint 'foll' = 0 * lead + 2 is outside of its limits [0, 1] at any 'lead'",
        ),
    ],
)
def test_limits_that_lock(joints: list[tuple[str, ...]], message: str) -> None:
    assert describe_locked(*joints) == [message]


@pytest.mark.parametrize(
    "joints",
    [
        [LEAD, ("foll", ONE, 'joint="lead"')],
        [LEAD, ("foll", 'lower="-1" upper="0"', 'joint="lead" multiplier="-1"')],
        [LEAD, ("foll", 'lower="0.9" upper="2"', 'joint="lead"')],
        [LEAD, ("foll", 'lower="2" upper="3"', 'joint="lead" multiplier="-1" offset="3"')],
        [LEAD, ("foll", ONE, 'joint="lead" multiplier="0" offset="0.5"')],
        [LEAD, ("foll", "", 'joint="lead" multiplier="-1"', "continuous")],
        # limits of a continuous joint mean nothing
        [LEAD, ("foll", ONE, 'joint="lead" multiplier="-1"', "continuous")],
        [("lead", ONE, "", "continuous"), ("foll", ONE, 'joint="lead" multiplier="-1"')],
        # limits that are 0 and 0, or the wrong way round, have a fault of their own
        [("lead", 'lower="0" upper="0"'), ("foll", ONE, 'joint="lead" multiplier="-1"')],
        [("lead", 'lower="1" upper="0"'), ("foll", ONE, 'joint="lead" multiplier="-1"')],
        [LEAD, ("other", ONE)],
    ],
)
def test_limits_that_leave_a_motion(joints: list[tuple[str, ...]]) -> None:
    assert describe_locked(*joints) == []


@pytest.mark.parametrize("project", [False, True])
def test_a_conversion_names_them(project: bool) -> None:
    text = model(LEAD, ("foll", ONE, 'joint="lead" multiplier="-1"'))
    more = {"output": {"project": "p"}} if project else {}
    (locked,) = [d for d in convert_text(text, **more).diagnostics if d.code == "mimic-locked"]
    assert (locked.level, locked.joint) == ("warning", "foll")
    assert locked.line is not None
    assert "multiplier" in str(locked.hint)
