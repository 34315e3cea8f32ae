"""The steps of Robotran's option ``RK4``, which repeat results that Robotran has written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class RungeKutta4:
    """The classical Runge-Kutta method of order 4, with the interface of scipy's solvers.

    All steps have one length, and no error is estimated: where forces are stiff, or a wheel turns
    far in a step, the results are wrong.
    """

    def __init__(
        self,
        fun: Callable[[float, Any], Any],
        t0: float,
        y0: Any,
        t_bound: float,
        *,
        first_step: float,
    ) -> None:
        self.fun, self.t, self.y, self.t_bound = fun, t0, y0, t_bound
        self.start_time, self.step_length, self.step_count = t0, first_step, 0
        self.t_old, self.y_old = t0, y0
        self.status = "running"

    def step(self) -> None:
        """Take one step; the last one ends at ``t_bound``."""
        self.t_old, self.y_old = t, y = self.t, self.y
        self.step_count += 1
        # not t + h: rounding errors would add up
        self.t = self.start_time + self.step_count * self.step_length
        if self.t > self.t_bound - 1e-9 * self.step_length:
            self.t, self.status = self.t_bound, "finished"
        h = self.t - t
        k1 = self.fun(t, y)
        k2 = self.fun(t + h / 2, y + h / 2 * k1)
        k3 = self.fun(t + h / 2, y + h / 2 * k2)
        k4 = self.fun(self.t, y + h * k3)
        self.y = y + h / 6 * (k1 + 2 * (k2 + k3) + k4)

    def dense_output(self) -> Any:
        """Return the state in the last step as a function: a cubic of its ends and derivatives."""
        from scipy.interpolate import CubicHermiteSpline

        times, states = [self.t_old, self.t], [self.y_old, self.y]
        return CubicHermiteSpline(times, states, [*map(self.fun, times, states)])
