"""Steps in C: ``steps.c`` with the interface of scipy's solvers."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf2mbs_simulate.memory import IntegrationInC, vector

if TYPE_CHECKING:
    from urdf2mbs_simulate.c_code import CCode

#: The most steps at once, and the most frames that one step passes (``MAX_FRAMES`` in C).
STEPS, MAX_FRAMES = 2000, 256


class Rosenbrock:
    """Linearly implicit steps of order 3, and explicit ones of order 5 where nothing is stiff; see
    ``steps.c``.

    ``step`` goes on until a frame is passed, with as many steps as it takes, or takes one step
    where user code is called after each.
    """

    def __init__(
        self,
        code: CCode,
        time: float,
        y: Any,
        end: float,
        frames: Any = (),
        *,
        rtol: float,
        atol: float,
        max_step: float,
        first_step: float,
    ) -> None:
        self.code, self.t_bound = code, end
        self.status, self.y, self.taken = "running", y.copy(), 0
        self.frames = np.ascontiguousarray(frames, float)
        self.passed: list[tuple[float, Any]] = []
        """Time and state of the frames that the last steps have passed."""
        self.loops = code.has_loop and code.in_c and not code.data.nqv
        """True if C calls the user's loop; it does not find Lambda."""
        self.frame_y = np.zeros((min(len(self.frames), MAX_FRAMES) + 1, len(y)))
        self.integration = IntegrationInC(
            t=time,
            h=first_step,
            end=end,
            longest_step=max_step,
            rtol=rtol,
            atol=atol,
            most_steps=1 if code.has_loop and not self.loops else STEPS,
            calls_loop=self.loops,
            y=vector(self.y),
            frame_y=vector(self.frame_y),
        )
        code.accelerate(time, y)
        code.library.begin_steps(code.at, ctypes.c_double(atol))
        code.check()

    @property
    def t(self) -> float:
        return float(self.integration.t)

    def step(self) -> None:
        at, code = self.integration, self.code
        first = int(np.searchsorted(self.frames, self.t, side="right"))
        coming = self.frames[first:]
        if code.has_loop:  # its outputs belong to the frames: steps end there
            at.end = min([self.t_bound, *coming[:1]])
        else:
            at.frame_time, at.n_frames = vector(coming), len(coming)
        self.taken = code.library.advance(code.at, ctypes.byref(at))
        code.check()
        code.note_turn()
        code.data.flag_stop |= code.run.data.flag_stop
        if code.has_loop:
            self.passed = [(self.t, self.y.copy())] if self.t in coming[:1] else []
        else:
            passed = coming[: at.n_passed].tolist()
            self.passed = [(t, self.frame_y[k].copy()) for k, t in enumerate(passed)]
        if self.taken < 0:
            self.status = "failed"
        elif self.t >= self.t_bound:
            self.status = "finished"
