"""The project's own equations of motion, and its loops: M qdd + c = Qq + external + J' lambda."""

from __future__ import annotations

from typing import Any

import numpy as np

from urdf2mbs.laws import followers
from urdf2mbs.laws.case import Case
from urdf2mbs.mbs.model import Connection


def prove(case: Case) -> None:
    _prove_cuts(case)
    if not case.code.has_equations:
        return
    tied = bool(case.mbs.cuts or followers.rules(case, "dependent"))
    for _ in range(2):
        q, qd, _ = case.state(0.02 if tied else np.pi)
        moved = case.code.forward(q, qd)
        if moved is None:
            case.unproven["accelerations"] = "the loops cannot be closed near the start"
            return
        _prove_motion(case, *moved)


def _prove_motion(case: Case, q: Any, qd: Any, qdd: Any, forces: Any) -> None:
    """A state with its accelerations and joint forces obeys the equations of motion."""
    case.move(q, qd)
    matrix, bias = case.ours.equations(case.conversion.settings.config.gravity)
    should = matrix @ qdd + bias - _external(case, qdd)
    moving = list(case.moving.values())
    given, own = case.code.inverse(q, qd, qdd), np.zeros(len(q))
    own[moving] = given[moving]
    terms = np.abs(matrix) @ np.abs(qdd) + np.abs(bias) + np.abs(should)
    case.compare_joints("inverse dynamics", should, own, scale=terms)
    rows, closing, gaps = [], [], []
    for cut in case.mbs.cuts:
        gap, lines, rest = _closing(case, cut, qdd)
        rows += [*lines]
        gaps += [*gap]
        closing += [*rest]
    for own_joint, (row, offset) in followers.rules(case, "dependent").items():
        rows.append(row)
        gaps.append(row @ q - offset)
        closing.append(row @ qdd)
        case.compare(f"joint '{own_joint}': it follows at speed", 0.0, row @ qd, 1.0)
    lines = np.array(rows).reshape(-1, len(q))
    case.compare("loops: what they are open by", np.zeros(len(gaps)), gaps, 10.0, "m")
    speed = lines @ qd
    case.compare("loops: the speed with which they open", 0.0 * speed, speed, 1.0, "m/s")
    scale = float(np.abs(lines * qdd).max(initial=1.0))
    case.compare("loops: how they accelerate", 0.0 * speed, closing, scale, "m/s^2")
    free = [k for k in moving if case.natures[k] != "driven"]
    rest = (should - forces)[free]
    if len(rows):
        # what is left is what the constraints do: it does no work
        _, sizes, ways = np.linalg.svd(lines[:, free])
        ways = ways[int((sizes > 1e-9 * sizes.max(initial=0.0)).sum()) :]
        work, scale = ways @ rest, float(np.abs(rest).max(initial=0.0))
        scale += float(np.abs(matrix @ qdd).max() + np.abs(bias).max())
        case.compare("accelerations: the work of all forces", 0.0 * work, work, scale, "N m")
    else:
        left = np.zeros(len(q))
        left[free] = rest
        case.compare_joints("accelerations", should, should - left, scale=terms)


def _external(case: Case, qdd: Any) -> Any:
    """What the forces at points and of springs do in the joints, at the present state."""
    total = np.zeros(case.ours.size)
    for name, (body, point) in case.points.items():
        if point.extforce is not None and point.extforce.name == name:
            at = case.in_mbs(body, point.coordinates, qdd)
            total += case.code.external(name, at.at, at.speed, 0.0)[:6] @ at.jacobian
    points = case.mbs.points()
    for link in case.mbs.links:
        one, two = (case.in_mbs(end[0], points[end].coordinates)
                    for end in (link.endpoint1, link.endpoint2))  # fmt: skip
        length = float(np.linalg.norm(two.at - one.at))
        line = (two.at - one.at) / length
        pull = case.code.spring(link.name, length, (two.speed - one.speed) @ line)
        total -= pull * line @ (two.jacobian - one.jacobian)[:3]
    return total


# --- loops ---


def gap(case: Case, cut: Connection) -> tuple[Any, Any]:
    """How far a cut is open (m, rad), and its derivatives by the joints, at the present state."""
    return _closing(case, cut, np.zeros(case.theirs.size))[:2]


def _closing(case: Case, cut: Connection, qdd: Any) -> tuple[Any, Any, Any]:
    """The same, and with which acceleration it opens."""
    points = case.mbs.points()
    one, two = (
        case.in_mbs(body, points[body, point].coordinates if point else (0.0, 0.0, 0.0), qdd)
        for body, point in (cut.endpoint1, cut.endpoint2)
    )
    away, rows = two.at - one.at, two.jacobian - one.jacobian
    speed, opens = two.speed - one.speed, two.acceleration - one.acceleration
    if cut.kind == "rod":
        length = float(np.linalg.norm(away)) or 1.0
        line = away / length
        rate = opens @ line + (speed @ speed - (speed @ line) ** 2) / length
        return np.array([length - (cut.length or 0.0)]), (line @ rows[:3])[None], np.array([rate])
    if cut.kind == "ball":
        return away, rows[:3], opens
    turn = one.axes.T @ two.axes
    angles = np.array((turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]))
    spin = two.spin_rate - one.spin_rate
    return np.concatenate([away, angles / 2.0]), rows, np.concatenate([opens, spin])


def _prove_cuts(case: Case) -> None:
    """The ends of the cuts that the config gives are where it says."""
    options, points = case.asked.get("loops"), case.mbs.points()
    cuts = {cut.name: cut for cut in case.mbs.cuts}
    for name, asked in options.cuts.items() if options else ():
        cut = cuts.get(name)
        if cut is None or cut.kind != asked.kind:
            said = "is not in the .mbs" if cut is None else f"is a {cut.kind}"
            case.differ(f"cut '{name}' ({asked.kind})", said, kind="forces")
            continue
        for end, meant in zip((cut.endpoint1, cut.endpoint2), asked.ends, strict=True):
            at = points[end[0], end[1]].coordinates if end[1] else (0.0, 0.0, 0.0)
            case.is_there(f"cut '{name}': where it ends", end[0], at, meant.link, meant.at)
        if asked.length is not None:
            case.compare(f"cut '{name}': its length", asked.length, cut.length, 0.0, "m", "forces")
