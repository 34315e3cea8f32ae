"""The functions of a model, in whatever language, with the partition of its joints."""

from __future__ import annotations

from typing import Any

import numpy as np

from urdf2mbs_equations.constraints import count_equations
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError


class Code:
    """The functions of a model, with the partition of its joints."""

    name = "Python"

    def __init__(self, data: MbsData, rows: tuple[int, int]) -> None:
        self.data, self.rows = data, rows
        natures = [joint.nature for joint in data._run.mbs.joints().values()]
        self.has_loops = bool(sum(rows) or data.nqv) or data._run.natures != natures
        """Whether the accelerations are those of the partition, not of the project's accelred."""
        self.repartition(np.arange(sum(rows)))

    def repartition(self, kept: Any) -> None:
        """Take the joints of the data, and of the constraints these rows."""
        data = self.data
        self.kept = kept
        self.least: float | None = None
        self.free, self.dependent = data.qu[1:], data.qv[1:]
        self.guess = data.q[self.dependent]

    def remember(self) -> None:
        """Let Newton's method start from the present place of the dependent joints: near a fold,
        a place that is left behind leads to another branch."""
        self.guess[:] = self.data.q[self.dependent]

    def state(self) -> Any:
        """Return q and qd of the independent joints, and ux."""
        data = self.data
        return np.concatenate([data.q[self.free], data.qd[self.free], data.ux[1:]])

    def solve(self) -> bool:
        """Set all qdd, and q and qd of dependent joints; return True where the loops cannot be
        closed."""
        raise NotImplementedError

    def constraints(self) -> tuple[Any, Any]:
        """Return h and J of all constraints, kept or not, from row 0; the columns count from 1."""
        raise NotImplementedError

    def inverse(self) -> Any:
        """Return the forces that the joints need for the present state and accelerations."""
        raise NotImplementedError

    def react(self) -> None:
        """Set Lambda and Qc for the state and accelerations that were computed last:
        M qdd + c = Qq + J' Lambda, and Qc in driven joints."""
        data = self.data
        if not (data.nqv or data.nqc):
            return
        rest = self.inverse() - data.Qq
        if data.nqv:
            jac = self.constraints()[1][self.kept]
            data.Lambda[1:] = np.linalg.solve(jac[:, self.dependent].T, rest[self.dependent])
            rest -= jac.T @ data.Lambda[1:]
        data.Qc[data.qc[1:]] = rest[data.qc[1:]]


def count_rows(data: MbsData) -> tuple[int, int]:
    """How many equations the cuts make, and how many the user's functions: as many as somebody has
    said, else as the cuts leave dependent joints for."""
    cuts = 0
    if data._run.mbs.cuts:
        cuts = count_equations(data._run.mbs)
    user = data._run.user_constraints
    if user is None:
        here = any(list(data.user_path.glob(f"user_cons_hJ.{end}")) for end in ("py", "c"))
        user = max(data.nqv - cuts, 0) if here else 0
    if data._run.mbs.user_constraints and not user:
        raise SimulationError(
            "partition",
            f"{data.nqv} joints are dependent, and there are {cuts} equations of cuts and "
            "0 of user_cons_hJ, though the .mbs names user constraints",
            file=str(data._run.file),
            hint="is the .mbs without the user functions of its project?",
        )
    return cuts, user
