"""The steps of ``steps.c``, with the interface of scipy's solvers."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf2mbs_simulate.memory import IntegrationInC, as_c_vector

if TYPE_CHECKING:
    from urdf2mbs_simulate.c_code import CCode

#: The largest number of steps in one call of C.
MAX_STEPS = 2000
#: The largest number of frames that one step passes (``MAX_FRAMES`` in C).
MAX_FRAMES = 256


class Interval(NamedTuple):
    """The times (s) of an integration."""

    start: float
    end: float
    frames: Any = ()
    """Ascending times at which states are asked for."""


class StepLimits(NamedTuple):
    """The errors and lengths of steps that are allowed, by scipy's names."""

    rtol: float
    """Relative error."""
    atol: float
    """Absolute error (rad, m)."""
    max_step: float
    """The longest step (s)."""
    first_step: float
    """The first step (s) to try."""


class Rosenbrock:
    """Linearly implicit steps of order 3, and explicit ones of order 5 where nothing is stiff.

    See ``steps.c``.  A call of ``step`` takes as many steps as lead past a frame, or only one where
    user code is called after each.
    """

    def __init__(self, code: CCode, y: Any, interval: Interval, limits: StepLimits) -> None:
        """Prepare steps from a state y, see ``Code.get_state``."""
        self.code, self.t_bound = code, interval.end
        self.status, self.y = "running", y.copy()
        self.steps_taken = 0
        """In the last call of ``step``; negative if it failed."""
        self.frames = np.ascontiguousarray(interval.frames, float)
        self.passed_frames: list[tuple[float, Any]] = []
        """Time and state of the frames that the last call of ``step`` has passed."""
        self.calls_loop = code.has_loop and code.has_user_c and not code.data.nqv
        """True if C calls the user's loop; it cannot compute Lambda for one."""
        self.frame_y = np.zeros((min(len(self.frames), MAX_FRAMES) + 1, len(y)))
        self.integration = IntegrationInC(
            t=interval.start,
            h=limits.first_step,
            end=interval.end,
            max_step=limits.max_step,
            rtol=limits.rtol,
            atol=limits.atol,
            max_steps=1 if code.has_loop and not self.calls_loop else MAX_STEPS,
            calls_loop=self.calls_loop,
            y=as_c_vector(self.y),
            frame_y=as_c_vector(self.frame_y),
        )
        code.accelerate(interval.start, y)
        code.library.begin_steps(code.run_address, ctypes.c_double(limits.atol))
        code.raise_user_error()

    @property
    def t(self) -> float:
        """The time of the state ``y`` (s)."""
        return float(self.integration.t)

    def step(self) -> None:
        """Take steps until a frame is passed, or the end is reached."""
        integration, code = self.integration, self.code
        first = int(np.searchsorted(self.frames, self.t, side="right"))
        coming_frames = self.frames[first:]
        if code.has_loop:  # its outputs belong to the frames: steps end there
            integration.end = min([self.t_bound, *coming_frames[:1]])
        else:
            integration.frame_time = as_c_vector(coming_frames)
            integration.n_frames = len(coming_frames)
        self.steps_taken = code.library.advance(code.run_address, ctypes.byref(integration))
        code.raise_user_error()
        code.note_turn()
        code.data.flag_stop |= code.run.data.flag_stop
        if code.has_loop:
            self.passed_frames = [(self.t, self.y.copy())] if self.t in coming_frames[:1] else []
        else:
            times = coming_frames[: integration.n_passed].tolist()
            self.passed_frames = [(t, self.frame_y[k].copy()) for k, t in enumerate(times)]
        if self.steps_taken < 0:
            self.status = "failed"
        elif self.t >= self.t_bound:
            self.status = "finished"
