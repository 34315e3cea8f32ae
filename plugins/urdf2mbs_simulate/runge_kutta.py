"""Robotran's own steps, those of its option ``RK4``: what repeats results that it has written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class RungeKutta4:
    """The classical steps of order 4, all of one length, with the interface of scipy's solvers.

    No error is estimated: where forces are stiff, or a wheel turns far in a step, they are wrong.
    """

    def __init__(
        self, fun: Callable[[float, Any], Any], t0: float, y0: Any, t_bound: float, *,
        first_step: float, **_: Any,
    ) -> None:  # fmt: skip
        self.fun, self.t, self.y, self.t_bound = fun, t0, y0, t_bound
        self.start, self.length, self.count = t0, first_step, 0
        self.before = t0, y0
        self.t_old = t0
        self.status = "running"

    def step(self) -> None:
        self.before = t, y = self.t, self.y
        self.t_old = t
        self.count += 1
        self.t = self.start + self.count * self.length  # which does not add up roundings
        if self.t > self.t_bound - 1e-9 * self.length:
            self.t, self.status = self.t_bound, "finished"
        h = self.t - t
        a = self.fun(t, y)
        b = self.fun(t + h / 2, y + h / 2 * a)
        c = self.fun(t + h / 2, y + h / 2 * b)
        d = self.fun(self.t, y + h * c)
        self.y = y + h / 6 * (a + 2 * (b + c) + d)

    def dense_output(self) -> Any:
        """The state at a time of the last step: a cubic of its ends and their slopes."""
        from scipy.interpolate import CubicHermiteSpline

        (t, y), fun = self.before, self.fun
        return CubicHermiteSpline([t, self.t], [y, self.y], [fun(t, y), fun(self.t, self.y)])
