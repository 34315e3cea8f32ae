"""Partition: the joints that the loops rule, the equations that are kept, the joints that are held.

The .mbs says which joints are dependent.  Its choice stands where there are as many equations, and
they rule these joints.  Else it is made by the rule of Robotran's MbsPart: the Jacobian of the
declared joints, their zeros disturbed, is eliminated with complete pivoting; what it leaves over is
no dependent joint, or no equation that is kept.  Newton's method closes the loops from the drawn
pose, and the choice is made once more there.  Joints that are not declared follow where the
declared ones are too few.

The rank is that of a closed pose near by: a loop such as Bennett's has redundant equations only
where it is closed, and one at a dead point has too few there.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from urdf2mbs.plugin import some
from urdf2mbs_equations.constraints import find_constant_gaps, list_constraints
from urdf2mbs_equations.tree import Tree, is_fixed
from urdf2mbs_project.singular import (
    GOLDEN_RATIO,
    estimate_size,
    find_singular_joints,
    find_singular_joints_at,
)
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.model_code import Code

#: Zeros of dependent joints are disturbed by this (rad, m) before the choice, as by Robotran.
DISTURBED = 1e-5
#: How far away (rad, m) the closed pose is where the rank is found.
AWAY = 1e-2
#: A singular value is none if it is so small a part of the largest, as a row is.
RANK, ROW = 1e-5, 1e-8
#: A loop is closed where a joint would close it by so little a move (rad, m).
CLOSED = 1e-10
#: A rod at its dead point, which no joint moves, need not be closed more closely than as if a joint
#: moved it by so small a part of what moves most.
DEAD = 1e-2
#: A joint is at its stop if it is so near (rad, m): slopes by differences count it half.
AT_STOP = 1e-5
#: The longest step (rad, m) of Newton's method.
STEP = 0.3
#: A new choice is made where a dependent joint moves so many times as fast as an independent one,
#: or where the determinant of the rows that are kept falls to such a part.
FAST = 20.0


def part(code: Code) -> None:
    """Choose dependent joints and equations, and close the loops from the present position.

    ``data._run.notes`` tells what was chosen.  Raises SimulationError where a loop does not close.
    """
    data = code.data
    if not code.has_loops:
        return
    data._run.notes += [
        said for _, said in find_constant_gaps(data._run.mbs) if said not in data._run.notes
    ]
    if not sum(code.rows):
        wrong = data.qv[1:]
        data.divide(dict.fromkeys(wrong, "independent"))
        _tell_joints(data, wrong, [])
        code.repartition(np.arange(0))
    elif not _fits(code):
        _choose(code)
    joints = data._run.mbs.joints().values()
    if not data.nqu + len(data._run.locked) and all(
        joint.nature != "driven" or is_fixed(joint) for joint in joints
    ):
        data._run.notes.append(
            "the loops leave no joint free, so nothing moves: add a joint, or let a ball "
            "(3 equations, 2 in a plane) be a rod (1)"
        )
    hold(data, code)
    choose_again(code)
    code.remember()


def _fits(code: Code) -> bool:
    """Whether the present choice stands; the loops are closed then."""
    rows, dependent = code.kept, code.dependent
    if len(rows) != len(dependent) or not close(code, rows, dependent):
        return False
    return _rank(code.constraints()[1][:, dependent]) == len(rows)


def _choose(code: Code) -> None:
    data, drawn = code.data, code.data.q.copy()
    declared = data.qv[1:]
    groups = [declared, data.qu[1:]]
    every = np.arange(sum(code.rows))
    data.q[declared] += np.where(drawn[declared] == 0.0, _spread(declared) * DISTURBED, 0.0)
    start = data.q.copy()
    if not (close(code, every, declared) or close(code, every, np.concatenate(groups))):
        raise _open(code)
    near = data.q.copy()
    ranks = _ranks_away(code, groups)
    for first in (start, near):  # where Newton fails from the drawn pose, a near one is closed
        data.q[:] = first
        rows, columns = _pivots(code.constraints()[1], groups, ranks)
        if not close(code, rows, columns):
            continue
        rows, columns = _pivots(code.constraints()[1], groups, ranks)
        if close(code, rows, columns):
            break
    else:
        raise _open(code)
    freed, added = np.setdiff1d(declared, columns), np.setdiff1d(columns, declared)
    data.divide(dict.fromkeys(freed, "independent") | dict.fromkeys(added, "dependent"))
    if len(rows) < len(every):
        data._run.notes.append(
            f"{len(rows)} of {len(every)} constraints are kept: {_others(code, rows)}"
        )
    moved = [k for k in data.qu[1:] if abs(data.q[k] - drawn[k]) > 2 * DISTURBED]
    if moved:
        data._run.notes.append(f"moved, for the loops to close: {names_of(data, moved)}")
    _tell_joints(data, freed, added)
    code.repartition(np.sort(rows))


def _others(code: Code, rows: Any) -> str:
    """What the constraints that are not kept do: do they hold, too, where the model has moved?"""
    data, here = code.data, code.data.q.copy()
    free = data.qu[1:]
    data.q[free] += AWAY * _spread(free)
    implied = close(code, rows, data.qv[1:])
    h, jac = code.constraints()
    data.q[:] = here
    if implied:
        return "they imply the others"
    size = 100 * CLOSED * np.abs(jac[:, 1:]).max(axis=1, initial=0.0)
    others = [row for row in range(len(h)) if not abs(h[row]) <= size[row]]
    if np.intersect1d(others, rows).size:  # they do not close there
        return "the others add nothing to them at this pose"
    names = ", ".join(dict.fromkeys(_name_of(code, row) for row in others))
    locked = names_of(data, free[jac[others][:, free].any(axis=0)])
    return (
        f"at a dead point, {names} would lock the model, and is left out; it stays with "
        f"<nature>dependent</nature> in {locked}"
    )


def choose_again(code: Code) -> bool:
    """Choose other dependent joints near a pose at which the present ones are singular; true if
    there are better ones.  The loops are closed."""
    data = code.data
    joints = np.concatenate([data.qv[1:], data.qu[1:]])
    if not len(code.kept):
        return False
    jac = code.constraints()[1]
    speed, size = _speed_and_size(jac, code.kept, code.dependent, joints)
    if code.least is None:
        code.least = size / FAST
    if speed <= FAST and size > code.least:
        return False
    rows, columns = _pivots(jac, [joints], [len(code.kept)])
    new_speed, new_size = _speed_and_size(jac, rows, columns, joints)
    code.least = max(size, new_size) / FAST
    if new_speed > FAST / 2 and new_size < 5 * size:
        return False
    data.divide(dict.fromkeys(data.qv[1:], "independent") | dict.fromkeys(columns, "dependent"))
    code.repartition(np.sort(rows))
    return True


def close(code: Code, rows: Any, columns: Any) -> bool:
    """Move the joints ``columns`` until the equations ``rows`` hold, by Newton's method with short
    steps; whether all equations hold then."""
    data, turns = code.data, 0
    h, jac = code.constraints()
    for _ in range(200):
        size = np.abs(jac[:, 1:]).max(axis=1, initial=0.0) + (~jac[:, 1:].any(axis=1))
        if not (np.isfinite(h).all() and np.isfinite(jac).all()):
            return False
        if np.all(np.abs(h[rows]) < CLOSED * size[rows]):
            turns += 1
            if turns == 3:  # as near as rounding allows
                break
        step = np.linalg.lstsq(jac[np.ix_(rows, columns)], -h[rows], rcond=RANK)[0]
        step *= min(1.0, STEP / max(np.abs(step).max(initial=0.0), STEP))
        here, gap = data.q[columns].copy(), np.linalg.norm(h[rows])
        for half in range(10):
            data.q[columns] = here + step * 0.5**half
            h, jac = code.constraints()
            if turns or np.linalg.norm(h[rows]) < gap:
                break
        else:
            break
    size = np.maximum(size, DEAD * size.max(initial=0.0))
    return bool(np.all(np.abs(h) < 100 * CLOSED * size))


def _pivots(jac: Any, groups: Sequence[Any], ranks: Sequence[int]) -> tuple[Any, Any]:
    """Rows and columns (joints) by complete pivoting, of each group in turn until there are as many
    as its rank (that of it with those before it)."""
    left = jac.copy()
    rows: list[int] = []
    columns: list[int] = []
    for group, rank in zip(groups, ranks, strict=True):
        while len(rows) < rank:
            part = np.abs(left[:, group])
            part[rows] = 0.0
            row, k = np.unravel_index(part.argmax(), part.shape)
            pivot = left[row, group[k]]
            if pivot == 0.0:
                break
            below = np.setdiff1d(np.arange(len(left)), [*rows, row])
            left[below] -= np.outer(left[below, group[k]] / pivot, left[row])
            left[below, group[k]] = 0.0
            rows.append(int(row))
            columns.append(int(group[k]))
    return np.array(rows, int), np.array(columns, int)


def following(code: Code) -> Any:
    """How fast the dependent joints move by the independent ones: (dependent, independent)."""
    jac = code.constraints()[1][code.kept]
    return -np.linalg.solve(jac[:, code.dependent], jac[:, code.free])


def _speed_and_size(jac: Any, rows: Any, columns: Any, joints: Any) -> tuple[float, float]:
    """If ``columns`` are the dependent joints: how many times as fast as another joint one of them
    moves; and the determinant."""
    others, square = np.setdiff1d(joints, columns), jac[np.ix_(rows, columns)]
    size = abs(float(np.linalg.det(square)))
    if size == 0.0:
        return np.inf, 0.0
    follow = np.linalg.solve(square, jac[np.ix_(rows, others)])
    return float(np.abs(follow).max(initial=0.0)), size


def _rank(jac: Any) -> int:
    if not jac.size:
        return 0
    size = np.abs(jac).max(axis=1)
    found = np.linalg.svd(
        jac / np.maximum(size, ROW * size.max() or 1.0)[:, None], compute_uv=False
    )
    return int((found > RANK * found[0]).sum())


def _ranks_away(code: Code, groups: Sequence[Any]) -> list[int]:
    """The ranks of the first groups together, at a closed pose near by."""
    data, here = code.data, code.data.q.copy()
    joints = np.concatenate(groups)
    data.q[joints] += AWAY * _spread(joints)
    if not close(code, np.arange(sum(code.rows)), joints):
        data.q[:] = here
    _, jac = code.constraints()
    data.q[:] = here
    return [_rank(jac[:, np.concatenate(groups[: k + 1])]) for k in range(len(groups))]


def _spread(joints: Any) -> Any:
    """Irregular numbers from -1 to 1, the same for a joint at all times."""
    return 2.0 * (GOLDEN_RATIO * np.asarray(joints) % 1.0) - 1.0


# --- joints without mass ---


def hold(data: MbsData, code: Code | None = None) -> None:
    """Hold the joints that move nothing that has mass; in loops (``code``) others move along.

    They are those of the present pose, if a general pose has as many: of three joints that turn a
    rod, the one about the rod.
    """
    if code is None and not any(found.always for found in find_singular_joints(data._run.mbs)):
        return
    names, here, free = list(data.joint_id), data.q.copy(), data.qu[1:]
    found: list[list[str]] = []
    for away in (0.0, AWAY):
        data.q[free] = here[free] + away * _spread(free)
        moves = {names[k - 1]: {names[k - 1]: 1.0} for k in free}
        if code is not None:
            if not close(code, code.kept, code.dependent):
                data.q[:] = here
            for k, column in zip(free, following(code).T, strict=True):
                along = zip(code.dependent, column, strict=True)
                moves[names[k - 1]] |= {names[d - 1]: float(x) for d, x in along if x}
        values = dict(zip(names, data.q[1:], strict=True))
        size = estimate_size(data._run.mbs)
        singular = find_singular_joints_at(data._run.mbs, values, moves, size)
        found.append([one.joint for one in singular])
        data.q[:] = here
    held = found[0] if len(found[0]) == len(found[1]) else found[1]
    if not held:
        return
    data._run.locked = [data.joint_id[joint] for joint in held]
    data.divide(dict.fromkeys(data._run.locked, "driven"))
    data.qd[data._run.locked] = 0.0
    data.qdd[data._run.locked] = 0.0
    said = f"held, since they move nothing that has mass: {names_of(data, data._run.locked)}"
    if not data.m.any():
        said += (
            "; no body has a mass: a config gives masses by "
            "'passes: {estimate-inertia: {total_mass: KG}}'"
        )
    data._run.notes.append(said)
    if code is not None:
        code.repartition(code.kept)


def check_held(data: MbsData) -> None:
    """Raise SimulationError where a force acts along a joint that is held; Qc is known."""
    size = 1.0 + max(np.abs(x[1:]).max(initial=0.0) for x in (data.Qq, data.Qc, data.Lambda))
    for number in data._run.locked:
        if not abs(data.Qc[number]) < 1e-7 * size:
            name = list(data.joint_id)[number - 1]
            raise SimulationError(
                "joint-without-mass",
                f"at {data.tsim:g} s a force of {-data.Qc[number]:.3g} N m or N acts along joint "
                f"'{name}', which moves nothing that has mass",
                file=str(data._run.file),
                hint="give mass and inertia to the links that it moves, or let the joint be driven",
            )


# --- words ---


def note_stops(data: MbsData, *, touching: bool = False) -> None:
    """Note which joints start beyond their soft stops, which push them; with ``touching``, also
    those that are at a stop: slopes by differences count it half."""
    models = data.user_model
    margin = AT_STOP if touching else -AT_STOP
    found = [
        joint
        for joint in models.get("stop_stiffness", {})
        for name, sign in (("q_min", 1.0), ("q_max", -1.0))
        if sign * (data.q[data.joint_id[joint]] - models.get(name, {}).get(joint, -sign * np.inf))
        < margin
    ]
    what = "at a stop, or beyond" if touching else "pushed by their stops from the start"
    note = f"{what}: {some(found)}; 'passes: {{posture: {{joints: {{NAME: VALUE}}}}}}' starts "
    note += "elsewhere"
    data._run.notes += [note] * (bool(found) and note not in data._run.notes)


def _tell_joints(data: MbsData, freed: Any, added: Any) -> None:
    """What was chosen, and the lines that let the .mbs say the same."""
    if len(freed):
        text = f"dependent in the .mbs, but no constraint rules them: {names_of(data, freed)}"
        if not any(data.user_path.glob("user_cons_hJ.*")):
            text += "; is user_cons_hJ of the project missing?"
        data._run.notes.append(text)
    if len(added):
        data._run.notes.append(
            f"dependent here, since those of the .mbs do not suffice: {names_of(data, added)}"
        )
    for joints, nature in ((freed, "independent"), (added, "dependent")):
        if len(joints):
            data._run.notes.append(
                f"in the .mbs: <nature>{nature}</nature> in {names_of(data, joints)}"
            )


def names_of(data: MbsData, joints: Iterable[int]) -> str:
    names = list(data.joint_id)
    return ", ".join(names[number - 1] for number in sorted(joints))


def _open(code: Code) -> SimulationError:
    """The equation that is missed by most."""
    data = code.data
    h, jac = code.constraints()
    size = np.abs(jac[:, 1:]).max(axis=1, initial=0.0)
    row = int(np.abs(h).argmax())
    gap, name = abs(h[row]), _name_of(code, row)
    text = f"{name} is missed by {gap:.3g}"
    if row < code.rows[0]:
        found = list_constraints(Tree(data._run.mbs))[row]
        if found.cut.kind == "rod":  # of which h is half the difference of squares
            rods = [cut.name for cut in data._run.mbs.cuts if cut.kind == "rod"]
            length = data.lrod[1 + rods.index(found.cut.name)]
            gap = abs(np.sqrt(max(length**2 + 2.0 * h[row], 0.0)) - length)
        gap, unit = (gap, "rad") if found.direction.startswith("about") else (1000 * gap, "mm")
        text = f"{name} is {gap:.3g} {unit} from closed {found.direction}"
    what = "no joint moves it" if size[row] == 0.0 else "no pose near the drawn one closes it"
    return SimulationError(
        "partition", f"a loop cannot be closed: {text}, and {what}", file=str(data._run.file),
        hint="draw the model nearer to a closed pose (initialvalue), or check lengths and points",
    )  # fmt: skip


def _name_of(code: Code, row: int) -> str:
    """What makes an equation."""
    cuts = code.rows[0]
    if row >= cuts:
        return f"equation {row - cuts + 1} of user_cons_hJ"
    cut = list_constraints(Tree(code.data._run.mbs))[row].cut
    return f"{cut.kind} '{cut.name}'"
