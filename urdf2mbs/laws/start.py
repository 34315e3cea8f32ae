"""The start: positions that were asked for, limits, rules of followers, and feet on the ground."""

from __future__ import annotations

from fnmatch import fnmatchcase
from math import inf

import numpy as np

from urdf2mbs.laws import equations, followers
from urdf2mbs.laws.case import Case
from urdf2mbs.proof.parameters import stated


def prove(case: Case) -> None:
    q, options = case.code.start, case.asked.get("posture")
    tied = {**followers.rules(case, "dependent"), **followers.rules(case, "driven")}
    for own, (row, offset) in tied.items():
        case.compare(f"joint '{own}': its rule at start", offset, row @ q, 1.0, "rad or m", "posture")
    if options is None:
        return
    leaders = {k for row, _ in tied.values() for k in np.nonzero(row)[0]}
    loose = options.srdf is not None
    if loose:
        case.unproven["the start"] = f"from '{options.srdf}'"
    for name, own in case.single.items():
        number, joint = case.numbers[own], case.robot.joints[name]
        if own in tied or case.natures[number] != "independent":
            continue  # a loop may move it
        asked = [value for p, value in options.joints.items() if fnmatchcase(name, p)]
        sign = -1.0 if name in case.conversion.names.flipped else 1.0
        should = sign * (asked or [0.0])[-1]
        limits = stated(joint)
        low, high = limits.get("q_min", -inf), limits.get("q_max", inf)
        inside = min(max(should, low), high) if options.inside else should
        if (number not in leaders and not loose) or not low - 1e-9 <= q[number] <= high + 1e-9:
            case.compare(f"joint '{name}': its start", inside, q[number], 1.0, "rad or m", "posture")
    _stand(case)
    case.go(0)
    said = {d.message.partition("'")[2].partition("'")[0] for d in case.conversion.diagnostics
            if d.code in ("loop-open", "loop-never-closes")}  # fmt: skip
    for cut in case.mbs.cuts:
        if cut.name not in said:
            gap = equations.gap(case, cut)[0]
            case.compare(f"cut '{cut.name}': its gap at start", 0.0 * gap, gap, 1e2, "m", "posture")


def _stand(case: Case) -> None:
    """The lowest contact of a floating base is on the ground, and nothing else moves the base."""
    ground = case.asked.get("contacts")
    base = case.conversion.inserted
    if base is None or not case.conversion.floating:
        return
    case.go(0)
    origin = case.ours.on(case.robot.joints[base].child, (0.0, 0.0, 0.0), np.zeros(case.ours.size))
    up = case.simulation.up
    contacts = [case.points[str(c.point.extforce.name)] for c in case.simulation.contacts
                if c.point.extforce is not None]  # fmt: skip
    stands = ground is not None and ground.stand and contacts
    heights = [case.in_mbs(body, point.coordinates).at @ up for body, point in contacts]
    if stands:
        case.compare("the base: the lowest contact", ground.ground, min(heights), case.size, "m",
                     "posture")  # fmt: skip
    else:
        case.compare("the base: its start", np.zeros(3), origin.at, case.size, "m", "posture")
    case.compare("the base: its turn at start", np.eye(3), origin.axes, 1.0, "", "posture")
    case.compare("the base: its shift at start", np.zeros(3), origin.at - (origin.at @ up) * np.array(up),
                 case.size, "m", "posture")  # fmt: skip
