"""The functions of a model, whatever their language, with the partition of its joints."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from urdf2mbs_equations.constraints import count_equations
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError


class RowCounts(NamedTuple):
    """How many equations the constraints of a model have."""

    cuts: int
    user: int
    """Those of ``user_cons_hJ``."""


class Code:
    """Abstract base of the functions of a model, in Python or C, with the partition of its joints.

    Joints are independent, dependent or driven (Robotran's qu, qv, qc).  As many constraints are
    used as there are dependent joints.
    """

    name = "Python"

    def __init__(self, data: MbsData, row_counts: RowCounts) -> None:
        self.data, self.row_counts = data, row_counts
        natures = [joint.nature for joint in data._run.mbs.joints().values()]
        self.has_loops = bool(sum(row_counts) or data.nqv) or data._run.natures != natures
        """True if the partition may differ from that of the project's accelred."""
        self.set_partition(np.arange(sum(row_counts)))

    def set_partition(self, used_rows: Any) -> None:
        """Set which joints are independent or dependent, and which constraints are used.

        Args:
            used_rows: The constraints that are used, as indices among all, from 0.
        """
        data = self.data
        self.used_rows = used_rows
        self.min_determinant: float | None = None
        """Of J_v, before other dependent joints are chosen; None until it is known."""
        self.independent, self.dependent = data.qu[1:], data.qv[1:]
        self.guess = data.q[self.dependent]

    def store_guess(self) -> None:
        """Let Newton's method start from the present positions of the dependent joints.

        Near a fold, an old guess leads to another branch.
        """
        self.guess[:] = self.data.q[self.dependent]

    def get_state(self) -> Any:
        """Return the state y: q and qd of the independent joints, then ux."""
        data = self.data
        return np.concatenate([data.q[self.independent], data.qd[self.independent], data.ux[1:]])

    def compute_accelerations(self) -> bool:
        """Set qdd of all joints, and q and qd of dependent ones.

        Returns:
            True if it failed, as the loops cannot be closed.
        """
        raise NotImplementedError

    def compute_constraints(self) -> tuple[Any, Any]:
        """Compute h (rows) and J = dh/dq (rows, joints + 1) of all constraints, used or not."""
        raise NotImplementedError

    def compute_inverse_dynamics(self) -> Any:
        """Return M qdd + c (joints + 1) of the present state and accelerations, in N m or N."""
        raise NotImplementedError

    def compute_reactions(self) -> None:
        """Set Lambda, and Qc of driven joints, for the state that was computed last.

        They solve M qdd + c = Qq + Qc + J' Lambda.
        """
        data = self.data
        if not (data.nqv or data.nqc):
            return
        missing = self.compute_inverse_dynamics() - data.Qq
        if data.nqv:
            jacobian = self.compute_constraints()[1][self.used_rows]
            data.Lambda[1:] = np.linalg.solve(
                jacobian[:, self.dependent].T, missing[self.dependent]
            )
            missing -= jacobian.T @ data.Lambda[1:]
        data.Qc[data.qc[1:]] = missing[data.qc[1:]]


def count_rows(data: MbsData) -> RowCounts:
    """Count the equations of the cuts, and those of the user.

    The user's are as many as ``set_nb_userc`` was given; by default, as many as there are dependent
    joints beyond the cuts.

    Raises:
        SimulationError: The .mbs names user constraints that no file defines.
    """
    cuts = count_equations(data._run.mbs) if data._run.mbs.cuts else 0
    user = data._run.user_constraints
    if user is None:
        is_defined = any(any(data.user_path.glob(f"user_cons_hJ.{end}")) for end in ("py", "c"))
        user = max(data.nqv - cuts, 0) if is_defined else 0
    if data._run.mbs.user_constraints and not user:
        raise SimulationError(
            "partition",
            f"{data.nqv} joints are dependent, and there are {cuts} equations of cuts and "
            "0 of user_cons_hJ, though the .mbs names user constraints",
            file=str(data._run.file),
            hint="is the .mbs without the user functions of its project?",
        )
    return RowCounts(cuts, user)
