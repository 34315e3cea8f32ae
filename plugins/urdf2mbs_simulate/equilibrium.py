"""Equilibrium: the pose in which nothing accelerates (Robotran's MbsEquil).

The unknowns are q of the independent joints and the user states; a parameter of a user model may
replace a joint.  Newton's method alone fails from the air and from most drawn poses.  So the model
first relaxes: it moves with a damping that takes its speed away, for longer and longer times, and
after each Newton's method is tried::

    relax         0.5 s        1 s             2 s
      o-------------o-----------o---------------o-------- ...
      Newton     Newton      Newton          Newton

A solution counts only near the relaxed state: friction makes whole sets of equilibria, of which the
nearest is taken, and a pendulum that falls must not go back to its upright pose.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs.plugin import ConfigError
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.dirdyn import Module, load_closed_code
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.partition_messages import format_joints
from urdf2mbs_simulate.python_code import locate_errors, user_code
from urdf2mbs_simulate.results import Recorder, Results
from urdf2mbs_simulate.solvers import OPTIONS, make_solver
from urdf2mbs_simulate.steps import Interval
from urdf2mbs_simulate.support import find_floating_base, propose_equilibrium

#: The largest acceleration (rad/s^2, m/s^2, or rate of a user state) in an equilibrium.
TOLERANCE = 1e-8
#: An acceleration is 0 if a move by this part of a radian or metre would cause it.
NEGLIGIBLE_MOVE = 1e-12
#: The differences (rad, m, and their rates) of numerical derivatives, to both sides.
DIFFERENCE = 3e-6
#: The damping (1/s) while the model relaxes, and the times (s) at which Newton's method is tried.
DAMPING, RELAXATION_TIMES = 5.0, (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
#: The largest number of calls of a solver while the model relaxes.
MAX_STEPS = 20000
#: How far (rad, m) Newton's method may end from the relaxed state, and its number of steps.
MAX_DISTANCE, MAX_NEWTON_STEPS, MAX_HALVINGS = 0.3, 30, 8
#: A base that has moved further (rad, m) does not stand as it was drawn.
MAX_BASE_MOVE = 0.1
#: Joints that have moved less (rad, m) are not listed in a posture.
MIN_POSTURE_MOVE = 1e-4
#: A singular value is 0 if it is smaller relative to the largest one.
SINGULAR_VALUE = 1e-10


class Exchange(NamedTuple):
    """A parameter of a user model that is unknown, and a joint that stays in its place."""

    model: str
    parameter: str
    joint: int


class Solution(NamedTuple):
    """The result of Newton's method."""

    residual: float
    """The largest acceleration that is left (rad/s^2, m/s^2)."""
    free_joints: list[int]
    """Joints whose position does not matter."""
    has_free_states: bool
    """True if values of user states do not matter, such as those of friction."""


class Equilibrium:
    """A pose in which nothing accelerates; ``mbs_data`` has it, at rest."""

    def __init__(self, data: MbsData, start_q: Any, solution: Solution) -> None:
        self.data, self.residual = data, solution.residual
        self.q, self.ux = data.q.copy(), data.ux.copy()
        self.start_q = start_q
        """q where the search began."""
        self.moved = data.q - start_q
        """How far each joint is from where the search began."""
        self.results: Results | None = None
        """The pose as results of one frame, with all forces."""
        self.free = solution.free_joints
        """Joints whose position does not matter."""
        self.friction = solution.has_free_states
        """True if friction allows other equilibria near by."""

    def lines(self) -> list[str]:
        """Describe the equilibrium, in lines for people."""
        data = self.data
        farthest = int(np.abs(self.moved[1:]).argmax()) + 1 if data.njoint else 0
        lines = [
            f"equilibrium: no joint accelerates by more than {self.residual:.1g} rad/s^2, m/s^2"
        ]
        if farthest:
            name, moved = format_joints(data, [farthest]), self.moved[farthest]
            unit = "m" if data._run.mbs.joints()[name].type.startswith("T") else "rad"
            lines.append(f"'{name}' is {moved:+.3g} {unit} from where it was")
            lines += self._describe_posture()
        if self.free:
            names = format_joints(data, self.free)
            verb = "does" if len(self.free) == 1 else "do"
            lines.append(f"{names} {verb} not matter: the equilibrium is the same along it")
        if self.friction:
            lines.append("friction allows other equilibria near by; this one was found first")
        return lines

    def _describe_posture(self) -> list[str]:
        """Return the lines of a config for this pose, if the base has not moved far."""
        data = self.data
        base = {joint.name for joint in find_floating_base(data._run.mbs)}
        base_numbers = [data.joint_id[name] for name in data.joint_id if name in base]
        held = [number for number in base_numbers if number not in self.free]
        if any(abs(self.moved[number]) > MAX_BASE_MOVE for number in held):
            return ["its base has moved, which 'posture' does not set: it does not stand as drawn"]
        pose = {
            name: round(float(data.q[number]), 4)
            for name, number in data.joint_id.items()
            if abs(self.moved[number]) > MIN_POSTURE_MOVE and name not in base and number in data.qu
        }
        posture = ", ".join(f"{name}: {q}" for name, q in pose.items())
        return [f"in a config: 'passes: {{posture: {{joints: {{{posture}}}}}}}'"] * bool(pose)


class MbsEquil(Module):
    """An equilibrium: set its options, and run it."""

    OPTIONS = {
        "method": 1,
        "senstol": TOLERANCE,
        "devjac": DIFFERENCE,
        "equitol": TOLERANCE,
        "itermax": MAX_NEWTON_STEPS,
        "mode": 1,
        "compute_uxd": 1,
        "resfilename": "equil",
        "respath": None,
        "animpath": None,
        "language": None,
        "save2file": 1,
    }

    def __init__(self, mbs_data: MbsData) -> None:
        super().__init__(mbs_data)
        self.exchanges: list[Exchange] = []
        self.found: Equilibrium | None = None

    def add_exchange(self, model: str, parameter: str, joint: int) -> None:
        """Exchange unknowns: a parameter of a user model is found, and a joint stays."""
        self.exchanges.append(Exchange(model, parameter, int(joint)))

    def run(self) -> Equilibrium:
        """Find the equilibrium; results are written if ``save2file`` is set.

        In mode 1 the model is at rest; in mode 2 the joints keep their speeds, as on a straight
        road.

        Raises:
            SimulationError: There is no equilibrium near by.
        """
        data, options = self.mbs_data, self.options
        is_at_rest = options["mode"] == 1
        with user_code(data), locate_errors(data):
            if is_at_rest:
                data.qd[1:] = 0.0
            start_q = data.q.copy()
            if self.exchanges:
                with self._locked_joints() as code:
                    _find_equilibrium(code, [], may_relax=is_at_rest)
            code = load_closed_code(data, options["language"])
            may_relax = is_at_rest and not self.exchanges
            solution = _find_equilibrium(code, self.exchanges, may_relax=may_relax)
            self.found = Equilibrium(data, start_q, solution)
            recorder = Recorder(data, code)
            recorder.add(data.tsim, code.get_state())
            self.found.results = recorder.results()
        self._write(self.found.results)
        return self.found

    @contextmanager
    def _locked_joints(self) -> Iterator[CCode]:
        """Let the joints of exchanges be driven, and return the code of the model."""
        data = self.mbs_data
        natures = {
            exchange.joint: data._run.natures[exchange.joint - 1] for exchange in self.exchanges
        }
        data.set_natures(dict.fromkeys(natures, "driven"))
        yield load_closed_code(data, self.options["language"])
        data.set_natures(natures)

    def print_equil(self) -> None:
        """Print the description of the equilibrium."""
        for line in self.found.lines() if self.found else ["there is no equilibrium yet"]:
            print(line)


class _Problem:
    """The equations f(x) = 0 of an equilibrium.

    x are the positions of joints, the user states, and the parameters of exchanges; f are the
    accelerations of joints, and the rates of user states.
    """

    def __init__(self, code: CCode, exchanges: list[Exchange]) -> None:
        self.code, self.data = code, code.data
        locked = [exchange.joint for exchange in exchanges]
        self.parameters = [
            (self.data.user_model[exchange.model], exchange.parameter) for exchange in exchanges
        ]
        self.joints = np.array(
            [k for k, joint in enumerate(code.independent) if joint not in locked], int
        )
        """Indices of the joints of x among the independent ones."""
        self.y = code.get_state()
        n = len(code.independent)
        self.x_in_y = np.concatenate([self.joints, np.arange(2 * n, len(self.y))])
        self.f_in_dy = np.arange(n, len(self.y))

    def get_x(self) -> Any:
        """Return the present unknowns."""
        parameters = [model[name] for model, name in self.parameters]
        return np.array([*self.y[self.x_in_y], *parameters])

    def compute_f(self, x: Any) -> Any:
        """Return the accelerations of joints and rates of user states; the data get x."""
        self.y[self.x_in_y] = x[: len(self.x_in_y)]
        for (model, name), value in zip(self.parameters, x[len(self.x_in_y) :], strict=True):
            model[name] = float(value)
        if self.parameters:
            self.code.update_user_model()
        f = self.code.accelerate(self.data.tsim, self.y)[self.f_in_dy]
        self.code.store_guess()
        return f

    def compute_jacobian(self, x: Any) -> Any:
        """Return df/dx by central differences: (accelerations, unknowns)."""
        differences = DIFFERENCE * np.maximum(1.0, np.abs(x))
        columns = [
            (self.compute_f(x + h * unit) - self.compute_f(x - h * unit)) / (2 * h)
            for h, unit in zip(differences, np.eye(len(x)), strict=True)
        ]
        return np.array(columns).T.reshape(len(self.f_in_dy), len(x))


def _find_equilibrium(code: CCode, exchanges: list[Exchange], *, may_relax: bool) -> Solution:
    """Relax, and solve, until an equilibrium is found near the relaxed state.

    Raises:
        ConfigError: There is no such parameter.
        SimulationError: There is no equilibrium.
    """
    data = code.data
    for model, parameter, _ in exchanges:
        if not isinstance(data.user_model.get(model, {}).get(parameter), float):
            message = f"there is no parameter '{model}.{parameter}' to exchange"
            raise ConfigError("usage", message)
    y, relaxed_time = code.get_state(), 0.0
    for time in RELAXATION_TIMES if may_relax else RELAXATION_TIMES[:1]:
        if time:
            y = _relax(code, y, time - relaxed_time)
            relaxed_time = time
        max_distance = np.inf
        if may_relax:
            max_distance = MAX_DISTANCE if time else DIFFERENCE
        solution = _solve_near(code, exchanges, y, max_distance)
        if solution is not None:
            return solution
    _set_state(code, y)
    code.accelerate(data.tsim, y)
    joint = max(code.independent, key=lambda k: abs(data.qdd[k]), default=0)
    name = format_joints(data, [joint])
    unit = "m/s^2" if data._run.mbs.joints()[name].type.startswith("T") else "rad/s^2"
    raise SimulationError(
        "no-equilibrium",
        f"no pose is found in which nothing accelerates: joint '{name}' still has "
        f"{data.qdd[joint]:.3g} {unit}",
        file=str(data._run.file),
        hint=propose_equilibrium(data),
    )


def _solve_near(
    code: CCode, exchanges: list[Exchange], y: Any, max_distance: float
) -> Solution | None:
    """Solve from the state y; return None if the solution is not near, or against the motion.

    Speeds are 0 where ``max_distance`` is finite.  Without a solution, the loops are closed again
    as they were: Newton's method may have left them on another branch.
    """
    n, state, guess = len(code.independent), y.copy(), code.guess.copy()
    if np.isfinite(max_distance):
        state[n : 2 * n] = 0.0
    _set_state(code, state)
    problem = _Problem(code, exchanges)
    x, jacobian, residual = _solve_newton(problem)
    n_joints = len(problem.joints)
    move = x[:n_joints] - y[problem.joints]
    speeds = y[n : 2 * n][problem.joints]
    distance = np.abs(move).max(initial=0.0)
    tolerance = max(TOLERANCE, NEGLIGIBLE_MOVE * np.abs(jacobian).max(initial=0.0))
    # it may not go back: a pendulum that falls does not look for the pose upright
    is_forward = move @ speeds >= -1e-3 * distance
    if not (residual < tolerance and distance < max_distance and is_forward):
        code.guess[:] = guess
        _set_state(code, y)
        return None
    _set_state(code, problem.y)
    freedom = _compute_freedom(jacobian)
    free_joints = code.independent[problem.joints][freedom[:n_joints] > 0.9].tolist()
    return Solution(residual, free_joints, bool((freedom[n_joints:] > 0.5).any()))


def _set_state(code: CCode, y: Any) -> None:
    """Let the data have a state, with its loops closed."""
    code.accelerate(code.data.tsim, y)
    code.store_guess()


def _relax(code: CCode, y: Any, duration: float) -> Any:
    """Return the state after a damped motion (s), in which user code sees a constant time."""
    if not len(y):
        return y
    options = OPTIONS | {"rtoler": 1e-4, "atoler": 1e-6, "dt0": 1e-4}
    code.run.damping, code.run.is_time_frozen = DAMPING, 1
    try:
        solver: Any = make_solver(code, y, Interval(0.0, duration), options)
        for _ in range(MAX_STEPS):
            solver.step()
            if solver.status != "running" or not np.isfinite(solver.y).all():
                break
            _set_state(code, solver.y)
    finally:
        code.run.damping, code.run.is_time_frozen = 0.0, 0
    return solver.y if np.isfinite(solver.y).all() else y


def _solve_newton(problem: _Problem) -> tuple[Any, Any, float]:
    """Solve f(x) = 0 by Newton's method with halved steps.

    Returns:
        x where no step makes f smaller, df/dx there, and the largest component of f.
    """
    x = problem.get_x()
    f, jacobian = problem.compute_f(x), np.zeros((len(problem.f_in_dy), len(x)))
    for _ in range(MAX_NEWTON_STEPS):
        if not np.isfinite(f).all():
            break
        jacobian = problem.compute_jacobian(x)
        if not np.isfinite(jacobian).all():
            break
        step = np.linalg.lstsq(jacobian, -f, rcond=SINGULAR_VALUE)[0]
        size = np.abs(f).max(initial=0.0)
        for n_halvings in range(MAX_HALVINGS):
            next_f = problem.compute_f(x + step * 0.5**n_halvings)
            if np.abs(next_f).max(initial=0.0) < size:
                break
        else:
            break
        x, f = x + step * 0.5**n_halvings, next_f
    problem.compute_f(x)
    return x, jacobian, float(np.abs(f).max(initial=0.0)) if np.isfinite(f).all() else np.inf


def _compute_freedom(jacobian: Any) -> Any:
    """Return the part (0 to 1) of each unknown in the null space of df/dx, where f stays 0."""
    if not jacobian.size:
        return np.zeros(jacobian.shape[1])
    _, singular_values, directions = np.linalg.svd(jacobian)
    rank = int((singular_values > SINGULAR_VALUE * singular_values[0]).sum())
    return np.linalg.norm(directions[rank:], axis=0)
