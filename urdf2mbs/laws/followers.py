"""Joints that follow others (``<mimic>``): the rules of the URDF, chain by chain."""

from __future__ import annotations

from typing import Any

import numpy as np

from urdf2mbs.laws.case import Case


def rules(case: Case, nature: str) -> dict[str, tuple[Any, float]]:
    """The followers of a nature, by their .mbs joint: the row of ``row q = offset`` (rad, m)."""
    found: dict[str, tuple[Any, float]] = {}
    for name, own in case.single.items():
        if case.natures[case.numbers[own]] != nature or case.robot.joints[name].mimic is None:
            continue
        row, factor, offset, leader = np.zeros(case.ours.size), 1.0, 0.0, name
        row[case.numbers[own]] = 1.0
        while (rule := case.robot.joints[leader].mimic) is not None:
            if leader != name and case.natures[case.numbers[case.single[leader]]] == "independent":
                break
            offset, factor = offset + factor * rule.offset, factor * rule.multiplier
            leader = rule.joint
        if leader in case.single:
            row[case.numbers[case.single[leader]]] -= factor
            found[own] = row, offset
    return found


def prove(case: Case) -> None:
    tied, code = rules(case, "dependent"), case.code
    q, qd, qdd = case.state()
    h, jacobian, rest = code.constraints(q, qd)
    if len(h) != len(tied):
        case.differ("constraints", f"there are {len(h)}, and {len(tied)} joints follow others")
        return
    for own, (row, offset) in tied.items():
        number = case.numbers[own]
        (lines,) = np.nonzero(jacobian[:, number])
        if len(lines) != 1:
            case.differ(f"joint '{own}'", f"{len(lines)} constraints move it")
            continue
        factor, line = jacobian[lines[0], number], lines[0]
        case.compare(f"joint '{own}': its rule's derivatives", row, jacobian[line] / factor)
        case.compare(f"joint '{own}': its rule", row @ q - offset, h[line] / factor, 1.0)
        case.compare(f"joint '{own}': its rule's acceleration", 0.0, rest[line], 1.0)
    followed = code.follow(q, qd, qdd)
    for values, given, rate in zip((q, qd, qdd), followed, (0.0, 1.0, 1.0), strict=True):
        should = values.copy()
        for own, (row, offset) in rules(case, "driven").items():
            number = case.numbers[own]
            should[number] = values[number] - row @ values + offset * (1.0 - rate)
        case.compare_joints("where it is driven to", should, given, "rad or m, and its rates")
