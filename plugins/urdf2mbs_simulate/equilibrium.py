"""Equilibrium: the pose in which nothing accelerates (Robotran's MbsEquil).

The unknowns are q of the independent joints and the user states; a parameter of a user model may be
one in the place of a joint.  Newton's method alone fails from the air and from most drawn poses: so
the model first moves with a damping that takes its speed away, and Newton's method begins where it
slows down.  Its steps are the shortest ones that do, so that of a whole set of equilibria, as
friction makes them, the nearest is taken.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from urdf2mbs.plugin import ConfigError
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.dirdyn import OPTIONS, Module, closed_code, make_solver
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.partition import names_of
from urdf2mbs_simulate.python_code import loaded, shown
from urdf2mbs_simulate.results import Recorder, Results

#: Newton's method ends where no acceleration (rad/s^2, m/s^2, or rate of a state) is larger.
TOLERANCE = 1e-8
#: The differences (rad, m, and their rates) by which the slopes are taken, to both sides.
STEP = 3e-6
#: How fast damping takes speed away (1/s), and how long the model may take to settle (s).
DAMPING, TIMES = 5.0, (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
#: A motion that settles takes so many calls of a solver, at most.
MOST_STEPS = 20000
#: Newton's method may end so far (rad, m) from where it begins, and take so many steps.
NEAR, TURNS = 0.3, 30
#: A base that has moved further (rad, m) does not stand as it was drawn.
BASE_MOVES = 0.1
#: An acceleration counts as 0 if a move by this part of a radian or metre makes it.
MOVE = 1e-12
#: A slope is none if it is so small a part of the largest.
NONE = 1e-10


class Equilibrium:
    """Where nothing accelerates; ``mbs_data`` is there, and at rest."""

    def __init__(self, data: MbsData, drawn: Any, residual: float, still: Any) -> None:
        self.data, self.residual = data, residual
        self.q, self.ux = data.q.copy(), data.ux.copy()
        self.drawn = drawn
        """q where the search began."""
        self.moved = data.q - drawn
        """How far each joint is from where the search began."""
        self.results: Results | None = None
        """The pose as results of one frame, with all forces."""
        self.free, self.friction = still
        """Joints that may stand anywhere; whether user states may, such as those of friction."""

    def lines(self) -> list[str]:
        data = self.data
        largest = int(np.abs(self.moved[1:]).argmax()) + 1 if data.njoint else 0
        said = [
            f"equilibrium: no joint accelerates by more than {self.residual:.1g} rad/s^2, m/s^2"
        ]
        if largest:
            name, moved = names_of(data, [largest]), self.moved[largest]
            unit = "m" if data._run.mbs.joints()[name].type.startswith("T") else "rad"
            said.append(f"'{name}' is {moved:+.3g} {unit} from where it was")
            said += self._posture()
        if self.free:
            where = names_of(data, self.free)
            said.append(f"{where} does not matter: the equilibrium is the same anywhere along it")
        if self.friction:
            said.append("friction allows other equilibria near by; this one was found first")
        return said

    def _posture(self) -> list[str]:
        """Return the lines of a config that give this pose, where the base has not moved far."""
        data = self.data
        base = {
            joint.name
            for body in data._run.mbs.bodies
            if body.parent is None
            for joint in body.joints
        }
        far = [k for name, k in data.joint_id.items() if name in base and k not in self.free]
        if any(abs(self.moved[k]) > BASE_MOVES for k in far):
            return ["its base has moved, which 'posture' does not set: it does not stand as drawn"]
        pose = {
            name: round(float(data.q[k]), 4)
            for name, k in data.joint_id.items()
            if abs(self.moved[k]) > 1e-4 and name not in base and k in data.qu
        }
        posture = ", ".join(f"{name}: {q}" for name, q in pose.items())
        return [f"in a config: 'passes: {{posture: {{joints: {{{posture}}}}}}}'"] * bool(pose)


class MbsEquil(Module):
    """An equilibrium: set its options, and run it."""

    OPTIONS = {
        "method": 1, "senstol": TOLERANCE, "devjac": STEP, "equitol": TOLERANCE, "itermax": TURNS,
        "mode": 1, "compute_uxd": 1, "resfilename": "equil", "respath": None, "animpath": None,
        "language": None, "save2file": 1,
    }  # fmt: skip

    def __init__(self, mbs_data: MbsData) -> None:
        super().__init__(mbs_data)
        self.exchanges: list[tuple[str, str, int]] = []
        self.found: Equilibrium | None = None

    def add_exchange(self, model: str, parameter: str, joint: int) -> None:
        """Let a parameter of a user model be unknown, and this joint stay where it is."""
        self.exchanges.append((model, parameter, int(joint)))

    def run(self) -> Equilibrium:
        """Find it; results are written if ``save2file`` is set.

        In mode 1 the model is at rest; in mode 2 the joints keep their speeds, as on a straight
        road.  Raises SimulationError where there is none.
        """
        data, options = self.mbs_data, self.options
        with loaded(data), shown(data):
            if options["mode"] == 1:
                data.qd[1:] = 0.0
            drawn = data.q.copy()
            if self.exchanges:
                with self._held() as code:
                    _settle_and_solve(code, [], may_settle=options["mode"] == 1)
            code = closed_code(data, options["language"])
            may_settle = options["mode"] == 1 and not self.exchanges
            residual, still = _settle_and_solve(code, self.exchanges, may_settle=may_settle)
            self.found = Equilibrium(data, drawn, residual, still)
            recorder = Recorder(data, code)
            recorder.add(data.tsim, code.state())
            self.found.results = recorder.results()
        self._write(self.found.results)
        return self.found

    @contextmanager
    def _held(self) -> Iterator[CCode]:
        """The joints of exchanges as driven ones."""
        data = self.mbs_data
        before = {k: data._run.natures[k - 1] for *_, k in self.exchanges}
        data.divide(dict.fromkeys(before, "driven"))
        yield closed_code(data, self.options["language"])
        data.divide(before)

    def print_equil(self) -> None:
        """Print what was found."""
        for line in self.found.lines() if self.found else ["there is no equilibrium yet"]:
            print(line)


class _Unknowns:
    """The numbers that Newton's method looks for, and the accelerations that they give."""

    def __init__(self, code: CCode, exchanges: list[tuple[str, str, int]]) -> None:
        self.code, self.data = code, code.data
        given = [joint for *_, joint in exchanges]
        self.parameters = [(self.data.user_model[model], name) for model, name, _ in exchanges]
        self.joints = np.array([k for k, joint in enumerate(code.free) if joint not in given], int)
        self.y = code.state()
        n = len(code.free)
        self.places = np.concatenate([self.joints, np.arange(2 * n, len(self.y))])
        self.rates = np.arange(n, len(self.y))

    def x(self) -> Any:
        return np.array([*self.y[self.places], *(model[name] for model, name in self.parameters)])

    def f(self, x: Any) -> Any:
        self.y[self.places] = x[: len(self.places)]
        for (model, name), value in zip(self.parameters, x[len(self.places) :], strict=True):
            model[name] = float(value)
        if self.parameters:
            self.code.take_parameters()
        found = self.code.accelerate(self.data.tsim, self.y)[self.rates]
        self.code.remember()
        return found

    def slopes(self, x: Any) -> Any:
        """By differences to both sides: (rates, unknowns)."""
        steps = STEP * np.maximum(1.0, np.abs(x))
        columns = [
            (self.f(x + step * one) - self.f(x - step * one)) / (2 * step)
            for step, one in zip(steps, np.eye(len(x)), strict=True)
        ]
        return np.array(columns).T.reshape(len(self.rates), len(x))


def _settle_and_solve(
    code: CCode, exchanges: list[tuple[str, str, int]], *, may_settle: bool
) -> tuple[float, Any]:
    """The largest acceleration that is left; joints that may stand anywhere, and whether user
    states may."""
    data, n = code.data, len(code.free)
    for key in exchanges:
        if not isinstance(data.user_model.get(key[0], {}).get(key[1]), float):
            raise ConfigError("usage", f"there is no parameter '{key[0]}.{key[1]}' to exchange")
    y, now = code.state(), 0.0
    worst = np.inf
    for time in TIMES if may_settle else TIMES[:1]:
        if time:
            y = _settle(code, y, time - now)
            now = time
        state = y.copy()
        if may_settle:
            state[n : 2 * n] = 0.0
        _take(code, state)
        unknowns = _Unknowns(code, exchanges)
        x, slopes, residual = _newton(unknowns)
        # it may not go back: a pendulum that falls does not look for the pose upright
        there = x[: len(unknowns.joints)] - y[unknowns.joints]
        speeds = y[n : 2 * n][unknowns.joints]
        size = np.abs(there).max(initial=0.0)
        allowed = (NEAR if time else STEP) if may_settle else np.inf
        tolerance = max(TOLERANCE, MOVE * np.abs(slopes).max(initial=0.0))
        if residual < tolerance and size < allowed and there @ speeds >= -1e-3 * size:
            _take(code, unknowns.y)
            still = _still(slopes)
            count = len(unknowns.joints)
            joints = code.free[unknowns.joints][still[:count] > 0.9].tolist()
            return residual, (joints, bool((still[count:] > 0.5).any()))
        worst = min(worst, residual)
    _take(code, y)
    code.accelerate(data.tsim, y)
    joint = max(code.free, key=lambda k: abs(data.qdd[k]), default=0)
    raise SimulationError(
        "no-equilibrium",
        f"no pose is found in which nothing accelerates: joint '{names_of(data, [joint])}' still "
        f"has {data.qdd[joint]:.3g} rad/s^2 or m/s^2",
        file=str(data._run.file),
        hint="is there something that holds it, such as contacts, springs, or a controller?",
    )


def _take(code: CCode, y: Any) -> None:
    code.accelerate(code.data.tsim, y)
    code.remember()


def _settle(code: CCode, y: Any, time: float) -> Any:
    """Return the state after a motion in which each speed fades, at a time that stands still."""
    if not len(y):
        return y
    options = OPTIONS | {"rtoler": 1e-4, "atoler": 1e-6, "dt0": 1e-4}
    code.run.damping, code.run.is_time_frozen = DAMPING, 1
    try:
        steps: Any = make_solver(code, 0.0, y, time, options)
        for _ in range(MOST_STEPS):
            steps.step()
            if steps.status != "running" or not np.isfinite(steps.y).all():
                break
            _take(code, steps.y)
    finally:
        code.run.damping, code.run.is_time_frozen = 0.0, 0
    return steps.y if np.isfinite(steps.y).all() else y


def _newton(unknowns: _Unknowns) -> tuple[Any, Any, float]:
    """Unknowns, slopes and the largest acceleration, where no step makes it smaller."""
    x = unknowns.x()
    f, slopes = unknowns.f(x), np.zeros((len(unknowns.rates), len(x)))
    for _ in range(TURNS):
        if not np.isfinite(f).all():
            break
        slopes = unknowns.slopes(x)
        if not np.isfinite(slopes).all():
            break
        step = np.linalg.lstsq(slopes, -f, rcond=NONE)[0]
        size = np.abs(f).max(initial=0.0)
        for half in range(8):
            better = unknowns.f(x + step * 0.5**half)
            if np.abs(better).max(initial=0.0) < size:
                break
        else:
            break
        x, f = x + step * 0.5**half, better
    unknowns.f(x)
    return x, slopes, float(np.abs(f).max(initial=0.0)) if np.isfinite(f).all() else np.inf


def _still(slopes: Any) -> Any:
    """How much of each unknown is in the directions that change no acceleration: 0 to 1."""
    if not slopes.size:
        return np.zeros(slopes.shape[1])
    _, sizes, directions = np.linalg.svd(slopes)
    rank = int((sizes > NONE * sizes[0]).sum())
    return np.linalg.norm(directions[rank:], axis=0)
