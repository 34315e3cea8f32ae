"""Followers: joints that linear constraints, such as those of ``<mimic>``, couple to others.

The constraints h(q) = J q + h(0) = 0 with a constant Jacobian J give the followers v by the other
joints u, exactly and at all positions::

           u    v
    J = [ J_u  J_v ]        v = -J_v^-1 J_u u - J_v^-1 h(0)

A project has them in ``user_cons_hJ``, whoever wrote it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from urdf2mbs_equations.followers import Follower
from urdf2mbs_project.singular import spread
from urdf2mbs_simulate.model_code import count_rows
from urdf2mbs_simulate.partition import find_pivots
from urdf2mbs_simulate.python_code import MbsData, user_code

#: At how many irregular positions constraints are compared.
N_POSITIONS = 4
#: Rounding of a linear constraint, relative to the size of its terms.
ROUNDING = 1e-12

#: Returns h (rows) and J (rows, joints + 1) of the user's constraints at q (joints + 1).
Constraints = Callable[[Any], tuple[Any, Any]]


def find_followers(data: MbsData) -> list[Follower]:
    """Find the dependent joints that follow others by linear constraints of the user.

    No leader is a follower.  The state of the data is as before.

    Raises:
        ConversionError: A user function fails, or does not compile.
    """
    is_python = (data.user_path / "user_cons_hJ.py").is_file()
    is_defined = is_python or (data.user_path / "user_cons_hJ.c").is_file()
    if not (data.nqv and is_defined):
        return []
    counts = count_rows(data)
    if not counts.user:
        return []
    evaluate = (_load_python if is_python else _load_c)(data, counts.cuts, counts.user)
    h, jacobian, is_linear = _compare_positions(evaluate, data.njoint)
    linear = np.flatnonzero(is_linear)
    dependent = data.qv[1:]
    rank = int(np.linalg.matrix_rank(jacobian[np.ix_(linear, dependent)])) if len(linear) else 0
    rows, joints = find_pivots(jacobian[linear], [dependent], [rank])
    if not len(joints):
        return []
    rows = linear[rows]
    rules = -np.linalg.solve(
        jacobian[np.ix_(rows, joints)], np.column_stack([h[rows], jacobian[rows, 1:]])
    )
    followers = []
    for joint, (offset, *factors) in sorted(zip(joints.tolist(), rules.tolist(), strict=True)):
        leaders = {
            number: factor + 0.0
            for number, factor in enumerate(factors, start=1)
            if factor and number not in joints
        }
        followers.append(Follower(joint, leaders, offset + 0.0))
    return followers


def _load_python(data: MbsData, cuts: int, n_rows: int) -> Constraints:
    """Return the user's constraints in Python."""

    def evaluate(q: Any) -> tuple[Any, Any]:
        h, jacobian = np.zeros(n_rows + 1), np.zeros((n_rows + 1, data.njoint + 1))
        present_q = data.q.copy()
        data.q[:] = q
        try:
            with user_code(data):
                data.user_cons_hJ(h, jacobian, data, data.tsim)
        finally:
            data.q[:] = present_q
        return h[1:], jacobian[1:]

    return evaluate


def _load_c(data: MbsData, cuts: int, n_rows: int) -> Constraints:
    """Return the user's constraints in C, of which another model of its own is compiled."""
    from urdf2mbs_simulate.c_code import CCode

    code = CCode(MbsData(data._run.file))

    def evaluate(q: Any) -> tuple[Any, Any]:
        code.data.q[:] = q
        with user_code(code.data):
            h, jacobian = code.compute_constraints()
        return h[cuts:], jacobian[cuts:]

    return evaluate


def _compare_positions(evaluate: Constraints, n_joints: int) -> tuple[Any, Any, Any]:
    """Compare constraints at several positions.

    Returns:
        h at q = 0 (rows), J (rows, joints + 1), and which rows are linear.
    """
    h, jacobian = evaluate(np.zeros(n_joints + 1))
    is_linear = np.isfinite(h)
    for number in range(1, N_POSITIONS):
        q = np.array([0.0, *spread(number * n_joints + np.arange(n_joints))])
        try:
            h_there, jacobian_there = evaluate(q)
        except (ArithmeticError, ValueError):  # a position that the constraints do not allow
            return h, jacobian, np.zeros(len(h), bool)
        size = np.abs(h) + np.abs(jacobian) @ np.abs(q)
        is_linear &= (jacobian_there == jacobian).all(axis=1)
        is_linear &= np.abs(h_there - h - jacobian @ q) <= ROUNDING * size
    return h, jacobian, is_linear
