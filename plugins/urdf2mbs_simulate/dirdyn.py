"""Direct dynamics: our steps in C, or integrators of others, with equations and user functions.

The state is q and qd of the independent joints, and the user states.  Accelerations close the loops
by Newton's method (coordinate reduction).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from urdf2mbs.plugin import ConfigError
from urdf2mbs_project.singular import find_singular_joints
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.partition import (
    check_locked_joints,
    choose_partition,
    improve_partition,
    lock_massless_joints,
)
from urdf2mbs_simulate.partition_messages import note_stops
from urdf2mbs_simulate.python_code import has_user_changes, locate_errors, user_code
from urdf2mbs_simulate.results import Recorder, Results
from urdf2mbs_simulate.solvers import OPTIONS, list_passed_frames, make_solver
from urdf2mbs_simulate.steps import MAX_STEPS, Interval, Rosenbrock

#: A run ends where MAX_STEPS steps advance by less (s): a force has diverged.
MIN_ADVANCE = 0.002

#: Other options of Robotran, which change nothing here.
OPTIONS_WITHOUT_EFFECT = frozenset(
    [
        "accelred",
        "baumgarte_alpha",
        "baumgarte_beta",
        "clearmbsglobal",
        "delta_t_wp",
        "flag_baumgarte_stabilization",
        "flag_oneshot",
        "flag_waypoint",
        "lpk_itermax",
        "n_freeze",
        "realtime",
        "save_anim",
        "save_result",
        "saveperiod",
        "soft",
        "verbose",
        "visualize",
    ]
)


class Module:
    """The base of Robotran's modules: a model, and options."""

    OPTIONS: ClassVar[dict[str, Any]] = {}

    def __init__(self, mbs_data: MbsData) -> None:
        self.mbs_data = mbs_data
        self.options = dict(self.OPTIONS)

    def set_options(self, **options: Any) -> None:
        """Set options by Robotran's names, see ``OPTIONS``.

        Raises:
            ConfigError: Robotran has no such option.
        """
        for name, value in options.items():
            if name in self.OPTIONS:
                self.options[name] = value
            elif name not in OPTIONS_WITHOUT_EFFECT:
                raise ConfigError("usage", f"{type(self).__name__} has no option '{name}'")

    def get_options(self, name: str) -> Any:
        """Return the value of an option."""
        return self.options[name]

    def _write(self, results: Results) -> list[Path]:
        """Write results if the options say so, over those of an earlier run, as Robotran does.

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
        """Choose the partition, close the loops at the start, and set mbs_data.DonePart to 1."""
        data = self.mbs_data
        with user_code(data), locate_errors(data):
            load_closed_code(data, None)
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
        with user_code(data), locate_errors(data):
            code = load_code(data, options["language"])
            results = integrate(data, code, options, self)
        results.files = self._write(results)
        return results


def load_code(data: MbsData, language: str | None) -> CCode:
    """Compile and load the functions of a model.

    Args:
        data: The model.
        language: Of the user functions, ``c`` or ``python``.  By default they are those in C, where
            the project has them, and those in Python are as urdf2mbs wrote them.

    Raises:
        ConversionError: A file does not compile, or the project has no such user functions.
    """
    if language not in (None, "c", "python"):
        raise ConfigError("usage", f"there is no language '{language}'", hint="c, or python")
    if not (data._run.mbs.cuts or data.nqv or data._run.locked):
        lock_massless_joints(data)
    suffixes = {file.suffix for file in data.user_path.glob("user_JointForces.*")}
    if language == "python" and suffixes == {".c"}:
        raise ConfigError(
            "usage",
            "the user functions of this project are in C only",
            hint="leave --language python out",
        )
    if language is None:
        user_in_c = not has_user_changes(data, "python", "user_*.py")
    else:
        user_in_c = language == "c"
    return CCode(data, user_in_c=user_in_c)


def load_closed_code(data: MbsData, language: str | None) -> CCode:
    """Load the functions of a model, choose its partition, and close its loops."""
    code = load_code(data, language)
    choose_partition(code)
    return code


def solve_start_state(data: MbsData, code: CCode) -> bool:
    """Close the loops at the present position; return False if that fails."""
    is_solved = bool(np.isfinite(code.accelerate(data.tsim, code.get_state())).all())
    code.store_guess()
    return is_solved


def integrate(data: MbsData, code: CCode, options: dict[str, Any], dirdyn: MbsDirdyn) -> Results:
    """Integrate from t0 to tf.

    At the start and after each step, the user's loop is called; then the frames that the step has
    passed are recorded.

    Args:
        data: The model at its start.
        code: Its functions.
        options: See ``OPTIONS``.
        dirdyn: The second argument of user functions; its ``watch`` is called after each step.

    Raises:
        ConversionError: A step cannot be taken, or the loops cannot be closed.
    """
    time, end = float(options["t0"]), float(options["tf"])
    _check_options(time, end, options)
    data.tsim = time
    if not np.isfinite(data.q + data.qd).all():
        raise _make_start_error(data)
    data._run.is_recording = False
    try:
        return _Integration(code, options, dirdyn).run(time, end)
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

    def __init__(self, code: CCode, options: dict[str, Any], dirdyn: MbsDirdyn) -> None:
        self.data, self.code, self.options, self.dirdyn = code.data, code, options, dirdyn
        self.recorder = Recorder(code.data, code)
        self.step_count, self.counted_from = 0, float(options["t0"])
        """Steps since a time (s), see ``_count_steps``."""

    def run(self, time: float, end: float) -> Results:
        """Integrate, and return the results.

        ::

            time      force starts    force stops          end
              |--------------|-------------|---------------|     stops of the solvers
              :    :    :    :    :    :    :    :    :    :     frames
        """
        data, code = self.data, self.code
        y = self._begin()
        n_frames = max(1, round((end - time) * self.options["framerate"])) + 1
        frames = np.linspace(time, end, n_frames)
        if code.has_loop:  # Robotran's first call is that of the start
            self._call_loop()
        self._record(time, y)
        for stop in [*list_discontinuities(data, time, end), end]:
            # a force that begins at this time has not begun at the end of the step before
            last = stop if stop == end else np.nextafter(stop, time)
            time, y = self._integrate_to(time, y, last, frames[1:])
            if data.flag_stop:
                break
            time = stop
            if stop in frames[1:] and stop != last:
                self._record(time, y)
        code.call_user_function("user_dirdyn_finish", self.dirdyn)
        code.leave_turned_axes()
        return self.recorder.results()

    def _begin(self) -> Any:
        """Choose axes and joints, let the user begin, and close the loops; return the state."""
        data, code = self.data, self.code
        choose_partition(code)
        code.call_user_function("user_dirdyn_init", self.dirdyn)
        y = code.get_state()
        if code.turn_if_near(y):
            code.accelerate(data.tsim, y)
        if not solve_start_state(data, code):
            raise _make_start_error(data)
        note_stops(data)
        return code.get_state()

    def _integrate_to(self, time: float, y: Any, end: float, frames: Any) -> tuple[float, Any]:
        """Integrate from a time and state to ``end``, or until user code stops the run."""
        data, code = self.data, self.code
        solver = make_solver(code, y, Interval(time, end, frames), self.options)
        while solver.status == "running" and not data.flag_stop:
            self._step(solver)
            time, y = float(solver.t), solver.y
            self.dirdyn.watch(time)
            self._count_steps(solver, time, y)
            calls_loop = code.has_loop and not (
                isinstance(solver, Rosenbrock) and solver.calls_loop
            )
            if calls_loop or data.nqv:
                code.accelerate(time, y)
                code.store_guess()
            if calls_loop:
                self._call_loop()
                if hasattr(solver, "f"):
                    solver.f = code.accelerate(time, y)  # the loop may have changed the forces
            for frame, state in list_passed_frames(solver, frames):
                self._record(frame, state)
            if solver.status == "running" and self._change_coordinates(solver, time, y):
                y = code.get_state()
                solver = make_solver(code, y, Interval(time, end, frames), self.options)
        return time, solver.y

    def _change_coordinates(self, solver: Any, time: float, y: Any) -> bool:
        """Change axes of the base, or dependent joints, near a singular pose.

        Returns:
            True if the state is that of other axes or joints from now on.
        """
        code = self.code
        # our steps turn the axes themselves
        has_turned = not isinstance(solver, Rosenbrock) and code.turn_if_near(y)
        if has_turned or len(code.used_rows):
            code.accelerate(time, y)
        return improve_partition(code) or has_turned

    def _step(self, solver: Any) -> None:
        """Take one step of a solver.

        Raises:
            SimulationError: No step is short enough.
        """
        time, y = float(solver.t), solver.y.copy()
        try:
            solver.step()
        except ValueError:  # implicit methods raise it where a number is not finite
            self.code.raise_user_error()
            solver.status = "failed"
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            message = f"no step from {time:g} s is short enough"
            raise make_step_error(self.code, time, y, message)

    def _count_steps(self, solver: Any, time: float, y: Any) -> None:
        """Count steps.

        Raises:
            SimulationError: Many steps have hardly advanced.
        """
        self.step_count += solver.steps_taken if isinstance(solver, Rosenbrock) else 1
        if self.step_count < MAX_STEPS:
            return
        if time - self.counted_from < min(MIN_ADVANCE, self.options["dt_max"]):
            message = f"{MAX_STEPS} steps lead from {self.counted_from:g} s to {time:g} s only"
            raise make_step_error(self.code, time, y, message)
        self.step_count, self.counted_from = 0, time

    def _record(self, time: float, y: Any) -> None:
        self.recorder.add(time, y)
        check_locked_joints(self.data)

    def _call_loop(self) -> None:
        self.code.compute_reactions()
        self.code.call_user_function("user_dirdyn_loop", self.dirdyn)


def make_step_error(code: CCode, time: float, y: Any, message: str) -> SimulationError:
    """Return an error that names the joint that accelerates most, and the largest forces."""
    data = code.data
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
    for singular in find_singular_joints(data._run.mbs)[:1]:
        text += f"; at the start, nothing that has mass resists joint '{singular.joint}'"
        hint = f"start elsewhere, {hint}"
    return SimulationError(
        "step-failed", text, file=str(data._run.file), hint=f"{hint}--method Radau"
    )


def list_discontinuities(data: MbsData, time: float, end: float) -> list[float]:
    """Return the times at which a force begins or ends: no step goes over one."""
    push_times = {t for push in data._run.pushes for t in (push.start, push.stop)}
    model_times = {
        float(model[name])
        for model in data.user_model.values()
        if {"start", "stop"} <= model.keys()
        for name in ("start", "stop")
    }
    return sorted(t for t in push_times | model_times if time < t < end)


def _make_start_error(data: MbsData) -> SimulationError:
    """Return an error that says why there are no accelerations at the start."""
    names = list(data.joint_id)
    dependent = ", ".join(names[number - 1] for number in data.qv[1:])
    lost_joints = np.flatnonzero(~np.isfinite(data.q + data.qd))
    lost_forces = np.flatnonzero(~np.isfinite(data.Qq))
    hint: str | None = "choose another start position, or other dependent joints"
    text = f"no acceleration can be found at {data.tsim:g} s"
    if lost_joints.size:
        text = f"the start position or speed of '{names[lost_joints[0] - 1]}' is not a number"
        hint = None
    elif lost_forces.size:
        joint = names[lost_forces[0] - 1]
        text = f"the force of joint '{joint}' is not a number at {data.tsim:g} s"
        hint = "look at user_JointForces"
    elif dependent:
        text += f": {dependent} cannot be dependent together at this position"
    return SimulationError("partition", text, file=str(data._run.file), hint=hint)
