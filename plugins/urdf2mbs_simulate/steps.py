"""Steps in C: ``steps.c`` with the interface of scipy's solvers."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf2mbs.messages.diagnostics import ConfigError

if TYPE_CHECKING:
    from urdf2mbs_simulate.c_code import CCode

#: The most steps at once.
STEPS = 2000

_double, _int = ctypes.c_double, ctypes.c_int


class Rosenbrock:
    """Linearly implicit steps of order 3, and explicit ones of order 5 where nothing is stiff; see
    ``steps.c``.

    ``step`` goes to the next of the ``frames``, with as many steps as it takes, or takes one step
    where user code wants to be called after each.
    """

    def __init__(
        self, code: CCode, time: float, y: Any, end: float, frames: Any, *,
        rtol: float, atol: float, max_step: float, first_step: float,
    ) -> None:  # fmt: skip
        self.code, self.frames, self.t_bound = code, frames, end
        self.status, self.y, self.taken = "running", y.copy(), 0
        self.limits = max_step, rtol, atol
        self.loops = code.has_loop and code.in_c and not code.data.nqv
        """True if C calls the user's loop; it does not find Lambda."""
        self.time, self.h = _double(time), _double(first_step)
        self.function = code.library.advance
        self.function.argtypes = [
            ctypes.c_void_p, ctypes.c_void_p, _double, ctypes.c_void_p, _double, ctypes.c_void_p,
            _double, _double, _int, _int,
        ]  # fmt: skip
        code.accelerate(time, y)
        if code.library.begin_steps(code.at):
            raise ConfigError(
                "usage", "an external force sets more than 8 user states", hint="--method LSODA"
            )

        self.most = 1 if code.has_loop and not self.loops else STEPS

    @property
    def t(self) -> float:
        return float(self.time.value)

    def step(self) -> None:
        most, rtol, atol = self.limits
        frame = int(np.searchsorted(self.frames, self.t, side="right"))
        end = min(self.t_bound, *self.frames[frame : frame + 1])
        self.taken = self.function(
            self.code.at, ctypes.byref(self.time), end, ctypes.byref(self.h), most,
            self.y.ctypes.data, rtol, atol, self.most, self.loops,
        )  # fmt: skip
        self.code.check()
        self.code.find_axes()
        self.code.data.flag_stop |= self.code.c.flag_stop
        if self.taken < 0:
            self.status = "failed"
        elif self.t >= self.t_bound:
            self.status = "finished"
