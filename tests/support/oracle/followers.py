"""Joints that follow others (``<mimic>``): the rules of the URDF, chain by chain."""

from typing import Any

import numpy as np

from support.oracle.case import Case

#: Of q, qd and qdd.
UNIT = "rad or m, and s"


def rules(case: Case, nature: str) -> dict[int, tuple[Any, float]]:
    """Return row and offset of ``row q = offset`` (rad, m) of followers, by Robotran's number."""
    rows: dict[int, tuple[Any, float]] = {}
    for name, number in case.single.items():
        mimics, factor, offset, leader = case.stated.mimics, 1.0, 0.0, name
        if case.natures[number] != nature or name not in mimics:
            continue
        while (rule := mimics.get(leader)) is not None:
            if leader != name and case.natures[case.single[leader]] == "independent":
                break
            offset, factor = offset + factor * rule.offset, factor * rule.multiplier
            leader = rule.leader
        row = np.zeros(case.ours.size)
        row[number] = 1.0
        row[case.single.get(leader, 0)] -= factor
        rows[number] = row, offset
    return rows


def prove(case: Case) -> None:
    data, tied = case.data, rules(case, "dependent")
    q, qd, qdd = data.q[:], data.qd[:], data.qdd[:] = case.go(1)
    (h, rest), jacobian = np.ones((2, len(tied) + 1)), np.zeros((len(tied) + 1, len(q)))
    if tied:
        data.user_cons_hJ(h, jacobian, data, 0.0)
        data.user_cons_jdqd(rest, data)
    for number, (row, offset) in tied.items():
        who = f"joint '{list(data.joint_id)[number - 1]}': its rule"
        (line, *more) = np.flatnonzero(jacobian[:, number]).tolist() or [0]
        factor = jacobian[line, number] or 1.0
        if more:
            case.differ(who, f"{1 + len(more)} constraints move it")
        case.compare(f"{who}, its derivatives", row, jacobian[line] / factor, "")
        case.compare(who, row @ q - offset, h[line] / factor, "", 1.0)
        case.compare(f"{who}, its acceleration", 0.0, rest[line], "", 1.0)
    data.user_DrivenJoints(data, 0.0)
    wanted = {"q": (q, 1.0), "qd": (qd, 0.0), "qdd": (qdd, 0.0)}
    for kind, (values, rate) in wanted.items():
        expected = values.copy()
        for number, (row, offset) in rules(case, "driven").items():
            expected[number] += rate * offset - row @ values
        case.compare_joints(
            f"its {kind}, where it is driven", expected, getattr(data, kind), 0.0, UNIT
        )
