"""The integrators of a direct dynamics, with their options and tolerances."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from urdf2mbs.plugin import ConfigError
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.runge_kutta import RungeKutta4
from urdf2mbs_simulate.steps import Interval, Rosenbrock, StepLimits

#: Our own method; scipy's for second opinions, implicit and explicit; and Robotran's own.
OURS, RADAU, DOP853, RK4 = "Rosenbrock", "Radau", "DOP853", "RK4"
METHODS = (OURS, RADAU, DOP853, RK4)
#: Integrators of Robotran that scipy has, too, or nearly so.
ROBOTRAN_METHODS = {"Dopri5": DOP853}
#: The default relative error of a step, of our method and of the others.
RTOL, RTOL_OF_OTHERS = 1e-5, 1e-6
#: The default absolute error (rad, m), relative to the relative one.
ATOL_RATIO, ATOL_RATIO_OF_OTHERS = 0.1, 0.01
#: The default first step (s).
FIRST_STEP = 1e-3
#: The constant of a project's robot file that has the step of Robotran's method.
TIME_STEP = re.compile(r"(?m)^(?:#define )?\w*TIME_STEP\b\s*=?\s*([0-9.e+-]+)")

#: The options of MbsDirdyn, by Robotran's names, with their defaults.
OPTIONS: dict[str, Any] = {
    "t0": 0.0,
    "tf": 5.0,
    "dt0": None,
    "dt_max": np.inf,
    "integrator": None,
    "rtoler": None,
    "atoler": None,
    "framerate": 100.0,
    "language": None,
    "save2file": 1,
    "resfilename": "dirdyn",
    "respath": None,
    "animpath": None,
}


def list_passed_frames(solver: Any, frames: Any) -> list[tuple[float, Any]]:
    """Return time and state of the frames that the last step has passed."""
    if isinstance(solver, Rosenbrock):
        return solver.passed_frames
    first, last = np.searchsorted(frames, (solver.t_old, solver.t), side="right")
    if first == last:
        return []
    interpolant = solver.dense_output()
    return [
        (float(frame), solver.y if frame == solver.t else interpolant(frame))
        for frame in frames[first:last]
    ]


def make_solver(code: CCode, y: Any, interval: Interval, options: dict[str, Any]) -> Any:
    """Return a solver, with the interface of scipy's.

    Args:
        code: The functions of the model.
        y: The state at the start, see ``Code.get_state``.
        interval: From the start to the end of the last step.
        options: See ``OPTIONS``.

    Raises:
        ConfigError: There is no such integrator.
    """
    name = options["integrator"] or OURS
    name = ROBOTRAN_METHODS.get(name, name)
    if name not in METHODS:
        raise ConfigError(
            "usage", f"there is no integrator '{name}'", hint=f"there are {', '.join(METHODS)}"
        )
    rtol, atol = choose_tolerances(name, options["rtoler"], options["atoler"])
    first_step = options["dt0"] or (read_time_step(code.data) if name == RK4 else FIRST_STEP)
    limits = StepLimits(
        rtol, atol, options["dt_max"], min(first_step, interval.end - interval.start)
    )
    if name == OURS:
        return Rosenbrock(code, y, interval, limits)
    start, end = interval.start, interval.end
    if name == RK4:
        return RungeKutta4(code.accelerate, start, y, end, first_step=limits.first_step)
    from scipy import integrate as scipy_integrate  # its import takes 0.2 s

    more = {"jac": code.differentiate} if name == RADAU else {}
    method = getattr(scipy_integrate, name)
    return method(code.accelerate, start, y, end, **limits._asdict(), **more)


def read_time_step(data: MbsData) -> float:
    """Return the TIME_STEP of a project: the step (s) that Robotran's method can take.

    Without one it is ``FIRST_STEP``.
    """
    for suffix in ("py", "h"):
        file = data.user_path / f"{data.mbs_name}_robot.{suffix}"
        text = file.read_text("utf-8", "replace") if file.is_file() else ""
        if match := TIME_STEP.search(text):
            return float(match[1])
    return FIRST_STEP


def choose_tolerances(
    integrator: str, rtol: float | None, atol: float | None
) -> tuple[float, float]:
    """Return the relative and the absolute error of a step; by default the second follows."""
    is_ours = integrator == OURS
    rtol = (RTOL if is_ours else RTOL_OF_OTHERS) if rtol is None else rtol
    ratio = ATOL_RATIO if is_ours else ATOL_RATIO_OF_OTHERS
    return rtol, ratio * rtol if atol is None else atol
