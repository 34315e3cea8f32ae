"""Partition: which joints are dependent, which constraints are used, which joints are locked.

The constraints h(q) = 0 of loops have the Jacobian J = dh/dq.  With independent joints u and
dependent joints v (Wehage and Haug, Journal of Mechanical Design 104, 1982)::

             u    v
    J = [   J_u  J_v  ]  used rows            J_v is square and regular
        [    .    .   ]  redundant rows       dq_v/dq_u = -J_v^-1 J_u

The .mbs declares which joints are dependent.  Its choice stays if there are as many equations, and
J_v is regular.  Otherwise the choice is made by the rule of Robotran's MbsPart: Gaussian
elimination of J with complete pivoting, in the columns of the declared joints, after their zeros
have been disturbed.  Columns without a pivot become independent, rows without one are redundant.
Newton's method closes the loops from the drawn pose, and the choice is made again there.  If the
declared joints are too few, others become dependent.

The rank of J is that of another closed pose near by.  A loop such as Bennett's has redundant
equations only where it is closed, and a loop at a dead point has too small a rank there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs_equations.constraints import find_constant_gaps
from urdf2mbs_equations.tree import is_fixed
from urdf2mbs_project.singular import (
    estimate_size,
    find_singular_joints,
    find_singular_joints_at,
    spread,
)
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.model_code import Code
from urdf2mbs_simulate.partition_messages import (
    describe_row,
    format_joints,
    make_gap_error,
    note_changes,
)

#: Zeros of dependent joints are disturbed by this (rad, m) before the choice, as by Robotran.
DISTURBANCE = 1e-5
#: Distance (rad, m) of the closed pose where the rank is computed.
RANK_DISTANCE = 1e-2
#: A singular value is 0 if it is smaller relative to the largest one.
SINGULAR_VALUE = 1e-5
#: A row of J is 0 if it is smaller relative to the largest one.
SMALL_ROW = 1e-8
#: An equation holds if a joint could close it by a smaller move (rad, m).
CLOSED = 1e-10
#: An equation that no joint moves, such as that of a rod at its dead point, holds as if a joint
#: moved it by this part of the largest element of J.
DEAD_POINT = 1e-2
#: The longest step (rad, m) of Newton's method, its number of steps, and of halvings of a step.
MAX_STEP, MAX_STEPS, MAX_HALVINGS = 0.3, 200, 10
#: Newton steps after all equations hold: they bring the loops as near as rounding allows.
FINAL_STEPS = 2
#: Other dependent joints are chosen if one of the present ones moves faster, relative to an
#: independent one; or if the determinant of J_v has fallen by this factor.
MAX_SPEED_RATIO = 20.0


class Conditioning(NamedTuple):
    """How well a choice of dependent joints is conditioned."""

    speed_ratio: float
    """The largest speed of a dependent joint, relative to that of an independent one."""
    determinant: float
    """Of J_v, absolute."""


def choose_partition(code: Code) -> None:
    """Choose dependent joints and equations, and close the loops from the present position.

    ``data._run.notes`` gets a description of the choice.

    Raises:
        SimulationError: A loop cannot be closed.
    """
    data = code.data
    if not code.has_loops:
        return
    data._run.notes += [
        note for _, note in find_constant_gaps(data._run.mbs) if note not in data._run.notes
    ]
    if not sum(code.row_counts):
        unconstrained = data.qv[1:]
        data.set_natures(dict.fromkeys(unconstrained, "independent"))
        note_changes(data, unconstrained, [])
        code.set_partition(np.arange(0))
    elif not _is_valid(code):
        _choose_rows_and_joints(code)
    if not data.nqu + len(data._run.locked) and not _is_any_joint_driven(data):
        data._run.notes.append(
            "the loops leave no joint free, so nothing moves: add a joint, or let a ball "
            "(3 equations, 2 in a plane) be a rod (1)"
        )
    lock_massless_joints(data, code)
    improve_partition(code)
    code.store_guess()


def _is_any_joint_driven(data: MbsData) -> bool:
    """Return True if the .mbs has a driven joint that may move."""
    joints = data._run.mbs.joints().values()
    return any(joint.nature == "driven" and not is_fixed(joint) for joint in joints)


def _is_valid(code: Code) -> bool:
    """Close the loops with the present partition; return False if it cannot stay."""
    rows, dependent = code.used_rows, code.dependent
    if len(rows) != len(dependent) or not close_loops(code, rows, dependent):
        return False
    return _compute_rank(code.compute_constraints()[1][:, dependent]) == len(rows)


def _choose_rows_and_joints(code: Code) -> None:
    """Choose the used equations and the dependent joints, and close the loops."""
    data, drawn_q = code.data, code.data.q.copy()
    declared = data.qv[1:]
    groups = [declared, data.qu[1:]]
    all_rows = np.arange(sum(code.row_counts))
    disturbance = spread(np.asarray(declared)) * DISTURBANCE
    data.q[declared] += np.where(drawn_q[declared] == 0.0, disturbance, 0.0)
    disturbed_q = data.q.copy()
    if not (
        close_loops(code, all_rows, declared) or close_loops(code, all_rows, np.concatenate(groups))
    ):
        raise make_gap_error(code)
    closed_q = data.q.copy()
    ranks = _compute_ranks_near(code, groups)
    # where Newton's method fails from the drawn pose, the loops are closed from a closed one
    for start_q in (disturbed_q, closed_q):
        data.q[:] = start_q
        rows, columns = find_pivots(code.compute_constraints()[1], groups, ranks)
        if not close_loops(code, rows, columns):
            continue
        rows, columns = find_pivots(code.compute_constraints()[1], groups, ranks)
        if close_loops(code, rows, columns):
            break
    else:
        raise make_gap_error(code)
    freed, added = np.setdiff1d(declared, columns), np.setdiff1d(columns, declared)
    data.set_natures(dict.fromkeys(freed, "independent") | dict.fromkeys(added, "dependent"))
    if len(rows) < len(all_rows):
        reason = _describe_unused(code, rows)
        data._run.notes.append(f"{len(rows)} of {len(all_rows)} constraints are used: {reason}")
    moved = [k for k in data.qu[1:] if abs(data.q[k] - drawn_q[k]) > 2 * DISTURBANCE]
    if moved:
        data._run.notes.append(f"moved, for the loops to close: {format_joints(data, moved)}")
    note_changes(data, freed, added)
    code.set_partition(np.sort(rows))


def _describe_unused(code: Code, rows: Any) -> str:
    """Describe the constraints that are not used: do they hold where the model has moved?"""
    data, present_q = code.data, code.data.q.copy()
    free = data.qu[1:]
    data.q[free] += RANK_DISTANCE * spread(np.asarray(free))
    are_implied = close_loops(code, rows, data.qv[1:])
    h, jacobian = code.compute_constraints()
    data.q[:] = present_q
    if are_implied:
        return "they imply the others"
    tolerance = 100 * CLOSED * np.abs(jacobian[:, 1:]).max(axis=1, initial=0.0)
    violated = [row for row in range(len(h)) if not abs(h[row]) <= tolerance[row]]
    if np.intersect1d(violated, rows).size:  # the used ones do not close there
        return "the others add nothing to them at this pose"
    names = ", ".join(dict.fromkeys(describe_row(code, row) for row in violated))
    locked = format_joints(data, free[jacobian[violated][:, free].any(axis=0)])
    return (
        f"at a dead point, {names} would lock the model, and is left out; it stays with "
        f"<nature>dependent</nature> in {locked}"
    )


def improve_partition(code: Code) -> bool:
    """Choose other dependent joints where the present ones are nearly singular.

    The loops must be closed.

    Returns:
        True if better ones were found.
    """
    data = code.data
    joints = np.concatenate([data.qv[1:], data.qu[1:]])
    if not len(code.used_rows):
        return False
    jacobian = code.compute_constraints()[1]
    present = _compute_conditioning(jacobian, code.used_rows, code.dependent, joints)
    if code.min_determinant is None:
        code.min_determinant = present.determinant / MAX_SPEED_RATIO
    is_slow = present.speed_ratio <= MAX_SPEED_RATIO
    if is_slow and present.determinant > code.min_determinant:
        return False
    rows, columns = find_pivots(jacobian, [joints], [len(code.used_rows)])
    candidate = _compute_conditioning(jacobian, rows, columns, joints)
    code.min_determinant = max(present.determinant, candidate.determinant) / MAX_SPEED_RATIO
    is_still_fast = candidate.speed_ratio > MAX_SPEED_RATIO / 2
    if is_still_fast and candidate.determinant < 5 * present.determinant:
        return False
    freed = dict.fromkeys(data.qv[1:], "independent")
    data.set_natures(freed | dict.fromkeys(columns, "dependent"))
    code.set_partition(np.sort(rows))
    return True


def close_loops(code: Code, rows: Any, joints: Any) -> bool:
    """Move joints until equations hold, by Newton's method with short steps.

    Args:
        code: The functions of the model; its data have the start and get the result.
        rows: The equations that are solved, as indices among all, from 0.
        joints: The joints that move, by their numbers.

    Returns:
        True if all equations hold then, those that were not solved, too.
    """
    data, n_final_steps = code.data, 0
    h, jacobian = code.compute_constraints()
    for _ in range(MAX_STEPS):
        # how far h changes for a joint's move of 1 rad or m; 1 where no joint changes it
        scale = np.abs(jacobian[:, 1:]).max(axis=1, initial=0.0)
        scale = scale + (~jacobian[:, 1:].any(axis=1))
        if not (np.isfinite(h).all() and np.isfinite(jacobian).all()):
            return False
        if np.all(np.abs(h[rows]) < CLOSED * scale[rows]):
            n_final_steps += 1
            if n_final_steps > FINAL_STEPS:
                break
        step = np.linalg.lstsq(jacobian[np.ix_(rows, joints)], -h[rows], rcond=SINGULAR_VALUE)[0]
        step *= min(1.0, MAX_STEP / max(np.abs(step).max(initial=0.0), MAX_STEP))
        start_q, gap = data.q[joints].copy(), np.linalg.norm(h[rows])
        for n_halvings in range(MAX_HALVINGS):
            data.q[joints] = start_q + step * 0.5**n_halvings
            h, jacobian = code.compute_constraints()
            if n_final_steps or np.linalg.norm(h[rows]) < gap:
                break
        else:
            break
    scale = np.maximum(scale, DEAD_POINT * scale.max(initial=0.0))
    return bool(np.all(np.abs(h) < 100 * CLOSED * scale))


def find_pivots(jacobian: Any, groups: Sequence[Any], ranks: Sequence[int]) -> tuple[Any, Any]:
    """Eliminate a Jacobian with complete pivoting.

    Args:
        jacobian: (rows, joints + 1).
        groups: The columns (joints) in which pivots are looked for, group by group.
        ranks: How many pivots there are in each group and all before it.

    Returns:
        The rows and the columns (joints) of the pivots.
    """
    remaining = jacobian.copy()
    rows: list[int] = []
    columns: list[int] = []
    for group, rank in zip(groups, ranks, strict=True):
        while len(rows) < rank:
            candidates = np.abs(remaining[:, group])
            candidates[rows] = 0.0
            row, k = np.unravel_index(candidates.argmax(), candidates.shape)
            pivot = remaining[row, group[k]]
            if pivot == 0.0:
                break
            below = np.setdiff1d(np.arange(len(remaining)), [*rows, row])
            remaining[below] -= np.outer(remaining[below, group[k]] / pivot, remaining[row])
            remaining[below, group[k]] = 0.0
            rows.append(int(row))
            columns.append(int(group[k]))
    return np.array(rows, int), np.array(columns, int)


def compute_dependent_jacobian(code: Code) -> Any:
    """Return dq_v/dq_u = -J_v^-1 J_u: (dependent, independent joints)."""
    jacobian = code.compute_constraints()[1][code.used_rows]
    return -np.linalg.solve(jacobian[:, code.dependent], jacobian[:, code.independent])


def _compute_conditioning(jacobian: Any, rows: Any, columns: Any, joints: Any) -> Conditioning:
    """Return the conditioning if the joints ``columns`` are dependent, the others independent."""
    independent, j_v = np.setdiff1d(joints, columns), jacobian[np.ix_(rows, columns)]
    determinant = abs(float(np.linalg.det(j_v)))
    if determinant == 0.0:
        return Conditioning(np.inf, 0.0)
    speeds = np.linalg.solve(j_v, jacobian[np.ix_(rows, independent)])
    return Conditioning(float(np.abs(speeds).max(initial=0.0)), determinant)


def _compute_rank(jacobian: Any) -> int:
    """Return the rank of a matrix whose rows may have different units."""
    if not jacobian.size:
        return 0
    sizes = np.abs(jacobian).max(axis=1)
    scale = np.maximum(sizes, SMALL_ROW * sizes.max() or 1.0)
    singular_values = np.linalg.svd(jacobian / scale[:, None], compute_uv=False)
    return int((singular_values > SINGULAR_VALUE * singular_values[0]).sum())


def _compute_ranks_near(code: Code, groups: Sequence[Any]) -> list[int]:
    """Return the ranks of the first groups of joints together, at a closed pose near by."""
    data, present_q = code.data, code.data.q.copy()
    joints = np.concatenate(groups)
    data.q[joints] += RANK_DISTANCE * spread(np.asarray(joints))
    if not close_loops(code, np.arange(sum(code.row_counts)), joints):
        data.q[:] = present_q
    _, jacobian = code.compute_constraints()
    data.q[:] = present_q
    columns = (np.concatenate(groups[: k + 1]) for k in range(len(groups)))
    return [_compute_rank(jacobian[:, joints]) for joints in columns]


# --- joints without mass ---


def lock_massless_joints(data: MbsData, code: Code | None = None) -> None:
    """Lock the joints that move no mass.

    They are those of the present pose, if there are as many in a general pose: of three joints
    that turn a rod, it is the one about the rod.

    Args:
        data: The model.
        code: Its functions where it has loops, in which dependent joints move along; None of a
            tree.
    """
    if code is None and not any(
        singular.always for singular in find_singular_joints(data._run.mbs)
    ):
        return
    present_q, free = data.q.copy(), data.qu[1:]
    massless_at = []
    for distance in (0.0, RANK_DISTANCE):
        data.q[free] = present_q[free] + distance * spread(np.asarray(free))
        massless_at.append(_list_massless_joints(data, code, present_q))
        data.q[:] = present_q
    drawn, general = massless_at
    massless = drawn if len(drawn) == len(general) else general
    if not massless:
        return
    locked = data._run.locked = [data.joint_id[joint] for joint in massless]
    data.set_natures(dict.fromkeys(locked, "driven"))
    data.qd[locked] = 0.0
    data.qdd[locked] = 0.0
    note = f"locked, since they move no mass: {format_joints(data, locked)}"
    if not data.m.any():
        note += (
            "; no body has a mass: a config gives masses by "
            "'passes: {estimate-inertia: {total_mass: KG}}'"
        )
    data._run.notes.append(note)
    if code is not None:
        code.set_partition(code.used_rows)


def _list_massless_joints(data: MbsData, code: Code | None, closed_q: Any) -> list[str]:
    """List independent joints that move no mass at the present pose, or nearest to it at closed_q.

    A joint moves itself by 1, and the dependent ones by its column of dq_v/dq_u.
    """
    names, free = list(data.joint_id), data.qu[1:]
    moves = {names[k - 1]: {names[k - 1]: 1.0} for k in free}
    if code is not None:
        if not close_loops(code, code.used_rows, code.dependent):
            data.q[:] = closed_q
        for k, column in zip(free, compute_dependent_jacobian(code).T, strict=True):
            dependent = zip(code.dependent, column, strict=True)
            moves[names[k - 1]] |= {names[d - 1]: float(x) for d, x in dependent if x}
    positions = dict(zip(names, data.q[1:], strict=True))
    mbs = data._run.mbs
    return [
        found.joint for found in find_singular_joints_at(mbs, positions, moves, estimate_size(mbs))
    ]


def check_locked_joints(data: MbsData) -> None:
    """Check that no force acts along a locked joint; Qc must have been computed.

    Raises:
        SimulationError: A force acts along one, so its acceleration would be infinite.
    """
    forces = (data.Qq, data.Qc, data.Lambda)
    size = 1.0 + max(np.abs(force[1:]).max(initial=0.0) for force in forces)
    for number in data._run.locked:
        if not abs(data.Qc[number]) < 1e-7 * size:
            name = list(data.joint_id)[number - 1]
            raise SimulationError(
                "joint-without-mass",
                f"at {data.tsim:g} s a force of {-data.Qc[number]:.3g} N m or N acts along joint "
                f"'{name}', which moves no mass",
                file=str(data._run.file),
                hint="give mass and inertia to the links that it moves, or let the joint be driven",
            )
