"""Direct dynamics: our steps in C, or integrators of others, drive equations and user functions.

The state is q and qd of the independent joints, and the user states.  Accelerations close the loops
by Newton's method (coordinate reduction).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from urdf2mbs.plugin import ConfigError
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.partition import check_held, choose_again, hold, note_stops, part
from urdf2mbs_simulate.python_code import changes, loaded, shown
from urdf2mbs_simulate.results import Recorder, Results
from urdf2mbs_simulate.runge_kutta import RungeKutta4
from urdf2mbs_simulate.steps import STEPS, Rosenbrock

#: Our own method; scipy's for second opinions, implicit and explicit; and Robotran's own.
OURS, RADAU, DOP853, RK4 = "Rosenbrock", "Radau", "DOP853", "RK4"
METHODS = (OURS, RADAU, DOP853, RK4)
#: Robotran's names for the same, or nearly so.
ROBOTRAN = {"Dopri5": DOP853}
#: By default: the relative error of a step of our method, and of the others; the absolute one (rad,
#: m) is this part of it.
RTOL, RTOL_OF_OTHERS = 1e-5, 1e-6
ATOL_PART, ATOL_PART_OF_OTHERS = 0.1, 0.01

#: The options of MbsDirdyn, by Robotran's names, with the values that they have here.
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
#: The first step (s) by default.
FIRST_STEP = 1e-3
TIME_STEP = re.compile(r"(?m)^(?:#define )?\w*TIME_STEP\b\s*=?\s*([0-9.e+-]+)")
#: A run ends where STEPS steps advance less than MIN_ADVANCE seconds: a force has diverged.
MIN_ADVANCE = 0.002
#: Others of Robotran's, which change nothing here.
WITHOUT_EFFECT = frozenset(
    [
        "save_anim", "saveperiod", "realtime", "verbose", "accelred", "n_freeze", "flag_oneshot",
        "flag_waypoint", "delta_t_wp", "flag_baumgarte_stabilization", "baumgarte_alpha",
        "baumgarte_beta", "save_result", "lpk_itermax", "visualize", "clearmbsglobal", "soft",
    ]
)  # fmt: skip


class Module:
    """What all of Robotran's modules have: a model, and options."""

    OPTIONS: ClassVar[dict[str, Any]] = {}

    def __init__(self, mbs_data: MbsData) -> None:
        self.mbs_data = mbs_data
        self.options = dict(self.OPTIONS)

    def set_options(self, **options: Any) -> None:
        """Set options by Robotran's names; see ``OPTIONS``."""
        for name, value in options.items():
            if name in self.OPTIONS:
                self.options[name] = value
            elif name not in WITHOUT_EFFECT:
                raise ConfigError("usage", f"{type(self).__name__} has no option '{name}'")

    def get_options(self, name: str) -> Any:
        return self.options[name]

    def _write(self, results: Results) -> list[Path]:
        """Write results, if the options want it, over those of an earlier run, as Robotran does.

        Returns:
            The files that were written.
        """
        options = self.options
        if not options["save2file"]:
            return []
        folders = options["respath"], options["animpath"]
        paths = (folder and Path(folder) for folder in folders)
        return results.write(options["resfilename"], *paths, force=True)


class MbsPart(Module):
    """Partition: that of the .mbs where it fits, else Robotran's choice; the loops are closed."""

    OPTIONS: ClassVar[dict[str, Any]] = {"rowperm": 1, "verbose": 0}

    def run(self) -> None:
        """Choose, and close the loops at the start; mbs_data.DonePart is 1 then."""
        data = self.mbs_data
        with loaded(data), shown(data):
            closed_code(data, None)
            data.DonePart = 1
        for note in data._run.notes if self.options["verbose"] else ():
            print(note)


class MbsDirdyn(Module):
    """A direct dynamics: set its options, and run it.

    ``integrator`` is ``Rosenbrock``, our own method, or ``Radau`` or ``DOP853`` of scipy, and
    ``dt0`` its first step (s); or ``RK4``, Robotran's own, of which ``dt0`` is each step.
    """

    OPTIONS = OPTIONS

    def __init__(self, mbs_data: MbsData) -> None:
        super().__init__(mbs_data)
        self.watch: Callable[[float], None] = lambda _: None
        """Called with the time after each step."""

    def run(self) -> Results:
        """Integrate from t0 to tf; the results are written if ``save2file`` is set.

        Raises:
            ConversionError: A step cannot be taken, the loops cannot be closed, or user code
                raises; it names time, joint and force, or file and line.
        """
        data, options = self.mbs_data, self.options
        with loaded(data), shown(data):
            code = choose_code(data, options["language"])
            results = integrate(data, code, options, self)
        results.files = self._write(results)
        return results


def choose_code(data: MbsData, language: str | None) -> CCode:
    """Return the code of a model, which is compiled.

    ``language`` is that of the user functions.  By default they are those in C, where the project
    has them, and those in Python are as urdf2mbs wrote them.
    """
    if language not in (None, "c", "python"):
        raise ConfigError("usage", f"there is no language '{language}'", hint="c, or python")
    if not (data._run.mbs.cuts or data.nqv or data._run.locked):
        hold(data)
    written = {file.suffix for file in data.user_path.glob("user_JointForces.*")}
    if language == "python" and written == {".c"}:
        raise ConfigError(
            "usage",
            "the user functions of this project are in C only",
            hint="leave --language python out",
        )
    in_c = language == "c" or (language is None and not changes(data, "python", "user_*.py"))
    return CCode(data, user_in_c=in_c)


def closed_code(data: MbsData, language: str | None) -> CCode:
    """Return the code of a model whose loops are closed at the present position."""
    code = choose_code(data, language)
    part(code)
    return code


def close(data: MbsData, code: CCode) -> bool:
    """Solve the constraints at the present position; return False if that cannot be done."""
    closed = bool(np.isfinite(code.accelerate(data.tsim, code.state())).all())
    code.remember()
    return closed


def integrate(data: MbsData, code: CCode, options: dict[str, Any], dirdyn: MbsDirdyn) -> Results:
    """Step from t0 to tf.

    At the start and after each step: the user's loop; then the frames that the step has passed.
    """
    time, end = float(options["t0"]), float(options["tf"])
    _check_options(time, end, options)
    data.tsim = time
    if not np.isfinite(data.q + data.qd).all():
        raise _no_partition(data)
    data._run.is_recording = False
    try:
        return _Integration(data, code, options, dirdyn).run(time, end)
    finally:
        data._run.is_recording = True


def _check_options(time: float, end: float, options: dict[str, Any]) -> None:
    if not time < end < np.inf:
        raise ConfigError("usage", f"tf must be after t0: a run from {time:g} to {end:g} s")
    for name in ("framerate", "rtoler", "atoler", "dt0"):
        if options[name] is not None and not options[name] > 0:
            raise ConfigError("usage", f"{name} must be above 0: {options[name]}")


class _Integration:
    """A run of a direct dynamics."""

    def __init__(
        self, data: MbsData, code: CCode, options: dict[str, Any], dirdyn: MbsDirdyn
    ) -> None:
        self.data, self.code, self.options, self.dirdyn = data, code, options, dirdyn
        self.recorder = Recorder(data, code)
        self.steps, self.time_before = 0, float(options["t0"])

    def run(self, time: float, end: float) -> Results:
        data, code = self.data, self.code
        y = self._begin()
        frames = np.linspace(time, end, max(1, round((end - time) * self.options["framerate"])) + 1)
        if code.has_loop:  # Robotran's first call is that of the start
            self._call_loop()
        self._record(time, y)
        for stop in [*_breaks(data, time, end), end]:
            # a force that begins at this time has not begun at the end of the step before
            last = stop if stop == end else np.nextafter(stop, time)
            time, y = self._integrate_to(time, y, last, frames[1:])
            if data.flag_stop:
                break
            time = stop
            if stop in frames[1:] and stop != last:
                self._record(time, y)
        code.call("user_dirdyn_finish", self.dirdyn)
        code.leave_turned_axes()
        return self.recorder.results()

    def _begin(self) -> Any:
        """Choose axes and joints, let the user begin, and close the loops; return the state."""
        data, code = self.data, self.code
        part(code)
        code.call("user_dirdyn_init", self.dirdyn)
        y = code.state()
        if code.turn_if_near(y):
            code.accelerate(data.tsim, y)
        if not close(data, code):
            raise _no_partition(data)
        note_stops(data)
        return code.state()

    def _integrate_to(self, time: float, y: Any, end: float, frames: Any) -> tuple[float, Any]:
        data, code = self.data, self.code
        solver = make_solver(code, time, y, end, self.options, frames)
        while solver.status == "running" and not data.flag_stop:
            self._step(solver)
            time, y = float(solver.t), solver.y
            self.dirdyn.watch(time)
            self._count_steps(solver, time, y)
            calls_loop = code.has_loop and not (isinstance(solver, Rosenbrock) and solver.loops)
            if calls_loop or data.nqv:
                code.accelerate(time, y)
                code.remember()
            if calls_loop:
                self._call_loop()
                if hasattr(solver, "f"):
                    solver.f = code.accelerate(time, y)  # the loop may have changed the forces
            for frame, state in _passed(solver, frames):
                self._record(frame, state)
            if solver.status == "running" and self._change_state(solver, time, y):
                y = code.state()
                solver = make_solver(code, time, y, end, self.options, frames)
        return time, solver.y

    def _change_state(self, solver: Any, time: float, y: Any) -> bool:
        """Return True if the state is from now on that of other axes, or of other joints."""
        code = self.code
        # our steps turn the axes themselves
        turns = not isinstance(solver, Rosenbrock) and code.turn_if_near(y)
        if turns or len(code.kept):
            code.accelerate(time, y)
        return choose_again(code) or turns

    def _step(self, solver: Any) -> None:
        """Take one step of a solver.

        Raises:
            SimulationError: No step is short enough.
        """
        time, y = float(solver.t), solver.y.copy()
        try:
            solver.step()
        except ValueError:  # implicit methods raise it where a number is not finite
            self.code.check()
            solver.status = "failed"
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            text = f"no step from {time:g} s is short enough"
            raise _stuck(self.data, self.code, time, y, text)

    def _count_steps(self, solver: Any, time: float, y: Any) -> None:
        """Raise SimulationError where many steps lead nowhere."""
        self.steps += solver.taken if isinstance(solver, Rosenbrock) else 1
        if self.steps < STEPS:
            return
        if time - self.time_before < min(MIN_ADVANCE, self.options["dt_max"]):
            text = f"{STEPS} steps lead from {self.time_before:g} s to {time:g} s only"
            raise _stuck(self.data, self.code, time, y, text)
        self.steps, self.time_before = 0, time

    def _record(self, time: float, y: Any) -> None:
        self.recorder.add(time, y)
        check_held(self.data)

    def _call_loop(self) -> None:
        self.code.react()
        self.code.call("user_dirdyn_loop", self.dirdyn)


def _passed(solver: Any, frames: Any) -> list[tuple[float, Any]]:
    """Return time and state of the frames that the last step has passed."""
    if isinstance(solver, Rosenbrock):
        return solver.passed
    first, last = np.searchsorted(frames, (solver.t_old, solver.t), side="right")
    if first == last:
        return []
    dense = solver.dense_output()
    return [
        (float(frame), solver.y if frame == solver.t else dense(frame))
        for frame in frames[first:last]
    ]


def make_solver(
    code: CCode, time: float, y: Any, end: float, options: dict[str, Any], frames: Any = ()
) -> Any:
    """Return our steps, or those of another, from a time and state."""
    name = options["integrator"] or OURS
    name = ROBOTRAN.get(name, name)
    if name not in METHODS:
        raise ConfigError(
            "usage", f"there is no integrator '{name}'", hint=f"there are {', '.join(METHODS)}"
        )
    rtol, atol = choose_tolerances(name, options["rtoler"], options["atoler"])
    first_step = options["dt0"] or (read_time_step(code.data) if name == RK4 else FIRST_STEP)
    limits = {
        "rtol": rtol,
        "atol": atol,
        "max_step": options["dt_max"],
        "first_step": min(first_step, end - time),
    }
    if name == OURS:
        return Rosenbrock(code, time, y, end, frames, **limits)
    if name == RK4:
        return RungeKutta4(code.accelerate, time, y, end, **limits)
    from scipy import integrate as scipy_integrate  # which takes 0.2 s

    more = {"jac": code.slopes} if name == RADAU else {}
    return getattr(scipy_integrate, name)(code.accelerate, time, y, end, **limits, **more)


def read_time_step(data: MbsData) -> float:
    """Return TIME_STEP of a project, the step (s) that Robotran's method can take; by default
    ``FIRST_STEP``."""
    for end in ("py", "h"):
        file = data.user_path / f"{data.mbs_name}_robot.{end}"
        text = file.read_text("utf-8", "replace") if file.is_file() else ""
        if found := TIME_STEP.search(text):
            return float(found[1])
    return FIRST_STEP


def choose_tolerances(
    integrator: str, rtol: float | None, atol: float | None
) -> tuple[float, float]:
    """Return the relative and the absolute error of a step; the second follows the first."""
    ours = integrator == OURS
    rtol = (RTOL if ours else RTOL_OF_OTHERS) if rtol is None else rtol
    part = ATOL_PART if ours else ATOL_PART_OF_OTHERS
    return rtol, part * rtol if atol is None else atol


def _stuck(data: MbsData, code: CCode, time: float, y: Any, message: str) -> SimulationError:
    """It names the joint that accelerates most at a state, and the largest forces."""
    from urdf2mbs_project.singular import find_singular_joints

    code.accelerate(time, y)
    joint = max(data.joint_id, key=lambda name: abs(data.qdd[data.joint_id[name]]))
    number = data.joint_id[joint]
    text = (
        f"{message}: joint '{joint}' has {data.qd[number]:.3g} rad/s or m/s and "
        f"{data.qdd[number]:.3g} rad/s^2 or m/s^2, and its force is {data.Qq[number]:.3g} N m or N"
    )
    if data.extforce_id:
        sizes = np.linalg.norm(data.SWr[1:, 1:4], axis=1)
        force = list(data.extforce_id)[int(sizes.argmax())]
        text += f"; the largest external force is '{force}' with {sizes.max():.3g} N"
    for push in data._run.pushes:
        if push.start <= time < push.stop:
            text += f"; the push on '{push.link}' is {np.linalg.norm(push.force):.3g} N"
    hint = "take softer contacts, stops and gains, smaller forces, or an implicit method: "
    for found in find_singular_joints(data._run.mbs)[:1]:
        text += f"; at the start, nothing that has mass resists joint '{found.joint}'"
        hint = f"start elsewhere, {hint}"
    return SimulationError(
        "step-failed", text, file=str(data._run.file), hint=f"{hint}--method Radau"
    )


def _breaks(data: MbsData, time: float, end: float) -> list[float]:
    """The times at which a force begins or ends: no step goes over one."""
    times = {t for push in data._run.pushes for t in (push.start, push.stop)} | {
        float(model[name])
        for model in data.user_model.values()
        if {"start", "stop"} <= model.keys()
        for name in ("start", "stop")
    }
    return sorted(t for t in times if time < t < end)


def _no_partition(data: MbsData) -> SimulationError:
    names = list(data.joint_id)
    dependent = ", ".join(names[number - 1] for number in data.qv[1:])
    lost = np.flatnonzero(~np.isfinite(data.q + data.qd))
    hint: str | None = "choose another start position, or other dependent joints"
    text = f"no acceleration can be found at {data.tsim:g} s"
    if lost.size:
        text = f"the start position or speed of '{names[lost[0] - 1]}' is not a number"
        hint = None
    elif (forces := np.flatnonzero(~np.isfinite(data.Qq))).size:
        text = f"the force of joint '{names[forces[0] - 1]}' is not a number at {data.tsim:g} s"
        hint = "look at user_JointForces"
    elif dependent:
        text += f": {dependent} cannot be dependent together at this position"
    return SimulationError("partition", text, file=str(data._run.file), hint=hint)
