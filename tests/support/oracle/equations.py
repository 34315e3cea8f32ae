"""Loops, and the project's own equations: M qdd + c = Qq + external + J' lambda."""

from typing import Any

import numpy as np

from support.oracle import followers
from support.oracle.case import Case
from support.oracle.multibody import opening


def prove(case: Case) -> None:
    options, cuts = case.asked.get("loops"), {cut.name: cut for cut in case.mbs.cuts}
    for name, asked in options.cuts.items() if options else ():
        if name not in cuts or cuts[name].kind != asked.kind:
            case.differ(f"cut '{name}'", f"is no {asked.kind} in the .mbs")
            continue
        ends = zip((cuts[name].endpoint1, cuts[name].endpoint2), asked.ends, strict=True)
        for end, meant in ends:
            case.compare_place(f"an end of cut '{name}'", end, meant.link, meant.at)
    if case.has_equations:
        rules = followers.rules(case, "dependent")
        for _ in range(2):
            q, qd, _ = case.near_start(0.02 if cuts or rules else np.pi)
            _prove_motion(case, q, qd, rules)


def _prove_motion(case: Case, q: Any, qd: Any, rules: Any) -> None:
    """Compare the accelerations of a state with the equations of motion."""
    data = case.data
    data.q[:], data.qd[:], data.qdd[:] = q, qd, 0.0
    if case.code.compute_accelerations():
        case.differ("accelerations", "none can be found near the start")
        return
    q, qd, qdd = data.q.copy(), data.qd.copy(), data.qdd.copy()
    case.move(q, qd)
    matrix, bias = case.ours.equations()
    should = matrix @ qdd + bias - _external(case, qdd)
    scale = np.abs(matrix) @ np.abs(qdd) + np.abs(bias) + np.abs(should)
    given, own = case.code.compute_inverse_dynamics(), np.zeros(len(q))
    own[case.moving] = given[case.moving]
    case.compare_joints("inverse dynamics", should, own, scale)
    # each constraint: how far it is open, its derivatives, and how it accelerates
    ties = [
        opening(
            cut.kind, cut.length or 0.0, case.end(cut.endpoint1, qdd), case.end(cut.endpoint2, qdd)
        )
        for cut in case.mbs.cuts
    ]
    ties += [(row @ q - offset, row[None], row @ qdd) for row, offset in rules.values()]
    opens = np.concatenate([np.zeros(0), *(np.atleast_1d(tie[0]) for tie in ties)])
    rows = np.concatenate([np.zeros((0, len(q))), *(tie[1] for tie in ties)])
    accelerate = np.concatenate([np.zeros(0), *(np.atleast_1d(tie[2]) for tie in ties)])
    case.compare("loops, how far they are open", 0.0 * opens, opens, "m, rad", 10.0)
    case.compare("loops, their speed", 0.0 * opens, rows @ qd, "m/s", 1.0)
    case.compare(
        "loops, their acceleration",
        0.0 * opens,
        accelerate,
        "m/s^2",
        float(np.abs(rows * qdd).max(initial=1.0)),
    )
    free = [number for number in case.moving if case.natures[number] != "driven"]
    rest = np.zeros(len(q))
    rest[free] = (should - data.Qq)[free]
    if len(rows):
        # what is left is the constraints' own force, which does no work where they stay closed
        _, sizes, ways = np.linalg.svd(rows[:, free])
        rank = int((sizes > 1e-9 * sizes.max()).sum())
        work = ways[rank:] @ rest[free]
        case.compare("accelerations, work of all forces", 0.0 * work, work, "N m", scale.max())
    else:
        case.compare_joints("accelerations", should, should - rest, scale)


def _external(case: Case, qdd: Any) -> Any:
    """Return the joint forces of forces at points and of springs, at the present state."""
    total = np.zeros(case.ours.size)
    for name in case.data.extforce_id:
        at = case.in_mbs(name, qdd)
        total += case.external(name, at.P, at.V, axes=at.R, spin=at.OM)[:6] @ at.J
    for link in [link for link in case.mbs.links if link.kind == "link"]:
        one, two = (case.end(end) for end in (link.endpoint1, link.endpoint2))
        length = float(np.linalg.norm(two.P - one.P))
        line = (two.P - one.P) / length
        number, rate = case.data.link_id[link.name], (two.V - one.V) @ line
        pull = case.data.user_LinkForces(length, rate, case.data, 0.0, number)
        total -= pull * line @ (two.J - one.J)[:3]
    return total
