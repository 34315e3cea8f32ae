"""Joints that follow others: the generated constraints, on a stand-in for Robotran's data."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.project_robots import MIMIC_CHAIN, unit_link, y_joint
from support.proving import codes
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import convert_text
from urdf2mbs_project.simulation import Simulation


@pytest.mark.parametrize(
    ("joints", "natures"),
    [
        ({}, ["dependent"] * 2),
        # a follower that is free leads those that follow it
        ({"two": "independent"}, ["independent", "dependent"]),
        # the first pattern that fits counts
        ({"two": "independent", "*": "driven"}, ["independent", "driven"]),
        ({"*": "driven"}, ["driven"] * 2),
    ],
)
def test_followers_are_coupled_by_their_rules_and_start_by_them(
    tmp_path: Path, joints: dict[str, str], natures: list[str]
) -> None:
    """The oracle proves the code that holds the rules."""
    passes = {"posture": {"joints": {"one": 0.7}}, "mimic": {"joints": joints}}
    result = convert_text(MIMIC_CHAIN, output={"project": tmp_path / "p"}, passes=passes)
    followers = [result.mbs.joints()[name] for name in ("two", "three")]
    assert [joint.nature for joint in followers] == natures
    assert [joint.q or 0.0 for joint in followers] == pytest.approx([1.9, -5.45], rel=1e-15)
    simulation = result.conversion.state(Simulation)
    actual = [
        (c.follower.name, c.leader.name, c.multiplier, c.offset)
        for c in (*simulation.couplings, *simulation.driven)
    ]
    rules = [("two", "one", 2.0, 0.5), ("three", "one", -6.0, -1.25)]
    assert actual == ([("three", "two", -3.0, 0.25)] if "two" in joints else rules)
    held = [constraint.joints for constraint in result.mbs.user_constraints]
    assert held == [(f, leader) for f, leader, *_ in actual if "*" not in joints]


def test_a_plain_mbs_keeps_them_independent_and_warns() -> None:
    result = convert_text(MIMIC_CHAIN)
    assert "mimic" in codes(result)
    joints = result.mbs.joints()
    assert joints["two"].nature == joints["three"].nature == "independent"
    assert not result.mbs.user_constraints


def test_a_leader_that_does_not_move() -> None:
    text = MIMIC_CHAIN.replace('name="one" type="continuous"', 'name="one" type="fixed"')
    result = convert_text(text, passes={"mimic": {"joints": {"*": "dependent"}}})
    assert [
        diagnostic.joint for diagnostic in result.diagnostics if diagnostic.code == "mimic-leader"
    ] == [
        "two",
        "three",
    ]


#: The leader of two fingers, one of which turns while the other shifts, has no mass of its own.
GRIPPER = (
    '<robot name="gripper">'
    + unit_link("palm")
    + '<link name="knob"/>'
    + unit_link("left")
    + unit_link("right")
    + y_joint("wrist", "palm", "left", '<origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/>')
    + unit_link("hand")
    + y_joint("arm", "left", "hand", '<origin xyz="0 0.1 -0.4"/>')
    + y_joint("drive", "hand", "knob", '<dynamics damping="0.3"/>')
    + unit_link("one")
    + y_joint(
        "turns",
        "hand",
        "one",
        '<origin xyz="0.1 0 0.2" rpy="1 2 3"/><mimic joint="drive" multiplier="0.5" offset="0.1"/>',
    )
    + y_joint(
        "shifts",
        "one",
        "right",
        '<origin xyz="0.3 0 0"/><limit lower="-9" upper="9" '
        'effort="1" velocity="1"/><mimic joint="drive" multiplier="-2"/>',
        "prismatic",
    )
    + '<transmission name="t"><joint name="drive"/></transmission></robot>'
)
FOLLOWERS = {"turns": (0.5, 0.1), "shifts": (-2.0, 0.0)}


def reduced_mass_matrix(model: Any, free: dict[str, float]) -> Any:
    """B^T M B over the joints that follow no other, at their positions (rad): B has the speed of
    each joint for each of theirs."""
    pin = pytest.importorskip("pinocchio")
    columns = list(free)
    turn, q = np.zeros((model.nv, len(free))), pin.neutral(model)
    for name, row in zip(list(model.names)[1:], model.joints[1:], strict=True):
        leader, multiplier, offset = name, 1.0, 0.0
        if name in FOLLOWERS:
            leader, (multiplier, offset) = "drive", FOLLOWERS[name]
        turn[row.idx_v, columns.index(leader)] = multiplier
        value = multiplier * free[leader] + offset
        if row.nq == 2:  # a continuous joint
            q[row.idx_q : row.idx_q + 2] = np.cos(value), np.sin(value)
        else:
            q[row.idx_q] = value
    matrix = pin.crba(model, model.createData(), q, pin.Convention.WORLD)
    return turn.T @ (np.triu(matrix) + np.triu(matrix, 1).T) @ turn


@pytest.mark.parametrize("pipeline", ["faithful", "compact"])
def test_a_leader_without_mass_feels_its_followers(tmp_path: Path, pipeline: str) -> None:
    """The reduced mass matrix is the URDF's, and regular; nothing says that it is singular."""
    pin = pytest.importorskip("pinocchio")
    from support.oracle.pin import to_pinocchio

    project = {"project": tmp_path / "p"}
    result = convert_text(GRIPPER, output=project, base="fixed", pipeline=pipeline)
    told = codes(result)
    assert "mimic-massless" in told
    assert not told & {"mimic", "mimic-leader", "massless-leaf", "singular", "singular-at-start"}
    assert not result.report.frozen
    joints = result.mbs.joints()
    assert [joints[name].nature for name in ("drive", "turns", "shifts")] == [
        "independent",
        "dependent",
        "dependent",
    ]
    assert joints["drive"].actuated
    random = np.random.default_rng(4)
    urdf, mbs = pin.buildModelFromXML(GRIPPER), to_pinocchio(result.mbs)
    for _ in range(10):
        free = dict(zip(("wrist", "arm", "drive"), random.uniform(-2, 2, 3), strict=True))
        wanted, actual = (reduced_mass_matrix(model, free) for model in (urdf, mbs))
        assert np.linalg.cond(wanted) < 1e4
        assert np.linalg.norm(actual - wanted) <= 1e-10 * np.linalg.norm(wanted)


def test_a_plain_mbs_has_no_leader_without_mass() -> None:
    """There nothing couples the fingers, and it would be singular, which `keep` brings."""
    result = convert_text(GRIPPER)
    assert result.report.frozen == {"drive": "nothing that it moves has mass"}
    assert "mimic" in codes(result)
    assert "singular" not in codes(result)
    keep: dict[str, Any] = {"prune-massless": {"keep": ["knob"]}}
    (singular,) = convert_text(GRIPPER, passes=keep).report.passes["singular"]
    assert (singular["joint"], singular["why"]) == ("drive", "moves-nothing")
    # whoever writes the user functions may say so
    coupled = {**keep, "mimic": {"joints": {"*": "dependent"}}}
    assert convert_text(GRIPPER, passes=coupled).report.passes["singular"] == []
    del coupled["prune-massless"]
    hints = {
        singular.joint: singular.hint
        for singular in convert_text(GRIPPER, passes=coupled).diagnostics
        if singular.code == "mimic-leader"
    }
    assert list(hints) == ["turns", "shifts"]
    assert "prune-massless: {keep: [knob]}" in str(hints["turns"])


def test_a_multiplier_of_zero_holds_a_joint(tmp_path: Path) -> None:
    """Where its leader is no joint of the .mbs; else the constraint does it."""
    text = GRIPPER.replace('multiplier="0.5"', 'multiplier="0"').replace('"-2"', '"0"')
    settings = {"output": {"project": tmp_path / "p"}, "base": "fixed"}
    result = convert_text(text, **settings)
    joints = result.mbs.joints()
    held = [(joints[name].nature, joints[name].q) for name in ("turns", "shifts")]
    assert held == [("driven", 0.1), ("driven", 0.0)]
    assert "drive" in result.report.frozen
    assert "mimic-held" in codes(result)
    options = {"posture": {"joints": {"turns": 1.0}}}
    with pytest.raises(ConfigError, match="follows another joint"):
        convert_text(text, passes=options, **settings)
