"""Direct dynamics: our steps in C, or scipy's integrators, drive equations and user functions.

The state is q and qd of the independent joints, and the user states.  ``accelred`` closes the loops
by Newton's method (coordinate reduction) and gives the accelerations.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, cast
from warnings import catch_warnings, filterwarnings

import numpy as np

from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.partition import check_held, choose_again, hold, part, tell_stops
from urdf2mbs_simulate.push import add_pushes
from urdf2mbs_simulate.python_code import PythonCode, changes, loaded, shown
from urdf2mbs_simulate.results import Recorder, Results
from urdf2mbs_simulate.runge_kutta import RungeKutta4
from urdf2mbs_simulate.steps import STEPS, Rosenbrock
from urdf2mbs_simulate.turn import can_turn, own_axes, show, turn_if_near

if TYPE_CHECKING:
    from urdf2mbs_simulate.c_code import CCode

#: Our own method, in C; and scipy's that takes explicit steps, and implicit ones where the forces
#: are stiff, in Python.
OURS, METHOD = "Rosenbrock", "LSODA"
#: scipy's methods, and Robotran's names for the same.
IMPLICIT = (METHOD, "Radau", "BDF")
METHODS = (OURS, *IMPLICIT, "RK45", "DOP853", "RK23", "RK4")
#: By itself: the relative and the absolute error (rad, m) of our method, and of scipy's.
TOLERANCES = {True: (1e-5, 1e-6), False: (1e-6, 1e-8)}
ROBOTRAN = {"Dopri5": "RK45"}

#: The options of MbsDirdyn, by Robotran's names, with the values that they have here.
OPTIONS: dict[str, Any] = {
    "t0": 0.0, "tf": 5.0, "dt0": 1e-3, "dt_max": np.inf, "integrator": None,
    "rtoler": None, "atoler": None, "framerate": 100.0, "language": None,
    "save2file": 1, "resfilename": "dirdyn", "respath": None, "animpath": None,
}  # fmt: skip
#: A run ends where STEPS steps advance less than LEAST seconds: a force has diverged.
LEAST = 0.002
#: Others of Robotran's, which change nothing here.
WITHOUT_EFFECT = frozenset([
    "save_anim", "saveperiod", "realtime", "verbose", "accelred", "n_freeze", "flag_oneshot",
    "flag_waypoint", "delta_t_wp", "flag_baumgarte_stabilization", "baumgarte_alpha",
    "baumgarte_beta", "save_result", "lpk_itermax", "visualize", "clearmbsglobal",
    "soft",
])  # fmt: skip


class Module:
    """What all of Robotran's modules have: a model, and options."""

    OPTIONS: ClassVar[dict[str, Any]] = {}

    def __init__(self, mbs_data: MbsData) -> None:
        self.mbs_data = mbs_data
        self.options = dict(self.OPTIONS)

    def set_options(self, **options: Any) -> None:
        """By Robotran's names; see ``OPTIONS``."""
        for name, value in options.items():
            if name in self.OPTIONS:
                self.options[name] = value
            elif name not in WITHOUT_EFFECT:
                raise ConfigError("usage", f"{type(self).__name__} has no option '{name}'")

    def get_options(self, name: str) -> Any:
        return self.options[name]

    def _write(self, results: Results) -> None:
        """Write results, if the options want it, over those of an earlier run, as Robotran does."""
        options = self.options
        if options["save2file"]:
            folders = options["respath"], options["animpath"]
            paths = (folder and Path(folder) for folder in folders)
            results.write(options["resfilename"], *paths, force=True)


class MbsPart(Module):
    """Partition: that of the .mbs where it fits, else Robotran's choice; the loops are closed."""

    OPTIONS: ClassVar[dict[str, Any]] = {"rowperm": 1, "verbose": 0}

    def run(self) -> None:
        """Choose, and close the loops at the start; mbs_data.DonePart is 1 then."""
        data = self.mbs_data
        with loaded(data), shown(data):
            closed_code(data, None)
            data.DonePart = 1
        for said in data.said if self.options["verbose"] else ():
            print(said)


class MbsDirdyn(Module):
    """A direct dynamics: set its options, and run it.

    ``integrator`` is ``Rosenbrock``, our own method, or one of scipy's, and ``dt0`` its first step
    (s); or ``RK4``, Robotran's own, of which ``dt0`` is each step.
    """

    OPTIONS = OPTIONS

    def __init__(self, mbs_data: MbsData) -> None:
        super().__init__(mbs_data)
        self.watch: Callable[[float], None] = lambda _: None
        """Called with the time after each step."""

    def run(self) -> Results:
        """Integrate from t0 to tf; the results are written if ``save2file`` is set.

        Raises ConversionError where a step cannot be taken, the loops cannot be closed, or user
        code raises; it names time, joint and force, or file and line.
        """
        data, options = self.mbs_data, self.options
        with loaded(data), shown(data), catch_warnings():
            filterwarnings("ignore", "lsoda:", UserWarning)  # the error says more
            code = choose_code(data, options["language"])
            results = integrate(data, code, options, self)
        self._write(results)
        return results


def choose_code(data: MbsData, language: str | None) -> PythonCode:
    """C where there is a compiler, unless a language is given.

    User functions are those in C, where the project has them; by itself only if those in Python
    are as urdf2mbs wrote them.
    """
    from urdf2mbs_simulate.c_code import CCode, compiler

    if language not in (None, "c", "python"):
        raise ConfigError("usage", f"there is no language '{language}'", hint="c, or python")
    if not (data.mbs.cuts or data.nqv or data.held):
        hold(data)
    if language == "python" or (language is None and compiler() is None):
        written = {file.suffix for file in data.user_path.glob("user_JointForces.*")}
        if written == {".c"}:
            raise ConfigError(
                "usage", "the user functions of this project are in C only",
                hint="install a C compiler, and leave --language python out",
            )  # fmt: skip
        add_pushes(data)
        return PythonCode(data)
    return CCode(data, user_in_c=language == "c" or not changes(data, "python", "user_*.py"))


def closed_code(data: MbsData, language: str | None) -> PythonCode:
    """The code of a model whose loops are closed at the present position."""
    code = choose_code(data, language)
    part(code)
    return code


def close(data: MbsData, code: PythonCode) -> bool:
    """Solve the constraints at the present position; False if that cannot be done."""
    closed = bool(np.isfinite(code.accelerate(data.tsim, code.state())).all())
    code.remember()
    return closed


def integrate(
    data: MbsData, code: PythonCode, options: dict[str, Any], dirdyn: MbsDirdyn
) -> Results:
    """Step from t0 to tf.

    At the start and after each step: the user's loop; then the frames that the step has passed.
    """
    time, end = float(options["t0"]), float(options["tf"])
    if not time < end < np.inf or not all(
        options[x] is None or options[x] > 0 for x in ("framerate", "rtoler", "dt0")
    ):
        raise ConfigError("usage", f"a run from {time:g} to {end:g} s, with {options}, is none")
    data.tsim = time
    if not np.isfinite(data.q + data.qd).all():
        raise _no_partition(data)
    _begin(data, code, dirdyn)
    recorder, y = Recorder(data, code), code.state()
    frames = np.linspace(time, end, max(1, round((end - time) * options["framerate"])) + 1)
    if code.has_loop:  # Robotran's first call is that of the start
        _call_loop(data, code, dirdyn)
    recorder.add(time, y)
    check_held(data)
    count, steps, before = 1, 0, time
    for stop in [*_breaks(data, time, end), end]:
        # a force that begins at this time has not begun at the end of the step before
        last = stop if stop == end else np.nextafter(stop, time)
        solver = make_solver(code, time, y, last, options, frames)
        while solver.status == "running" and not data.flag_stop:
            _step(data, code, solver)
            time, y = float(solver.t), solver.y
            dirdyn.watch(time)
            steps += solver.taken if isinstance(solver, Rosenbrock) else 1
            if steps >= STEPS:
                if time - before < min(LEAST, options["dt_max"]):
                    said = f"{STEPS} steps lead from {before:g} s to {time:g} s only"
                    raise _stuck(data, code, time, y, said)
                steps, before = 0, time
            code.accelerate(time, y)
            code.remember()
            if code.has_loop and not (isinstance(solver, Rosenbrock) and solver.loops):
                _call_loop(data, code, dirdyn)
                if hasattr(solver, "f"):
                    solver.f = code.accelerate(time, y)  # the loop may have changed the forces
            passed = int(np.searchsorted(frames, time, side="right"))
            if passed > count:
                for frame in frames[count:passed]:
                    recorder.add(float(frame), y if frame == time else solver.dense_output()(frame))
                count = passed
                check_held(data)
            turns = turn_if_near(code, (time, y))
            if turns or choose_again(code):
                y = code.state()
                if time < last:
                    solver = make_solver(code, time, y, last, options, frames)
        if data.flag_stop:
            break
        time = stop
        if count < len(frames) and frames[count] <= time:
            recorder.add(time, y)
            count += 1
    show(data)
    data.turned = False
    code.take_axes()
    code.call("user_dirdyn_finish", dirdyn)
    return recorder.results()


def _begin(data: MbsData, code: PythonCode, dirdyn: MbsDirdyn) -> None:
    """Choose axes and joints, let the user begin, and close the loops."""
    data.can_turn, data.turned = can_turn(data), False
    turn_if_near(code)
    part(code)
    with own_axes(data):
        code.call("user_dirdyn_init", dirdyn)
    if not close(data, code):
        raise _no_partition(data)
    tell_stops(data)


def _call_loop(data: MbsData, code: PythonCode, dirdyn: MbsDirdyn) -> None:
    code.react()
    with own_axes(data):
        code.call("user_dirdyn_loop", dirdyn)


def make_solver(
    code: PythonCode, time: float, y: Any, end: float, options: dict[str, Any], frames: Any = ()
) -> Any:
    """Ours in C, or one of scipy's, from a time and state."""
    name = options["integrator"] or OURS
    name = ROBOTRAN.get(name, name)
    if name not in METHODS:
        raise ConfigError(
            "usage", f"there is no integrator '{name}'", hint=f"there are {', '.join(METHODS)}"
        )
    ours = name == OURS and code.steps_in_c
    rtol, atol = (
        default if given is None else given
        for given, default in zip(
            (options["rtoler"], options["atoler"]), TOLERANCES[ours], strict=True
        )
    )
    limits = {
        "rtol": rtol, "atol": atol, "max_step": options["dt_max"],
        "first_step": min(options["dt0"], end - time),
    }  # fmt: skip
    if ours:
        return Rosenbrock(cast("CCode", code), time, y, end, frames, **limits)
    if name == "RK4":
        return RungeKutta4(code.accelerate, time, y, end, **limits)
    from scipy import integrate as scipy_integrate  # which takes 0.2 s

    name = METHOD if name == OURS else name
    slopes = _kept_slopes(code) if name == METHOD else code.slopes
    more = {"jac": slopes} if name in IMPLICIT else {}
    return getattr(scipy_integrate, name)(code.accelerate, time, y, end, **limits, **more)


def _kept_slopes(code: PythonCode) -> Callable[[float, Any], Any]:
    """The slopes for LSODA, which asks whenever its step changes, and does with old ones.

    New ones are made where it asks at a time again, for they did not do, and else at every 10th
    time; VODE (Brown, Byrne, Hindmarsh, SIAM J. Sci. Stat. Comput. 10, 1989) keeps them for 50
    steps.
    """
    last, asked, kept = -np.inf, 0, np.empty(0)

    def slopes(t: float, y: Any) -> Any:
        nonlocal last, asked, kept
        if t <= last or asked % 10 == 0:
            asked, kept = 0, code.slopes(t, y)
        last, asked = t, asked + 1
        return kept.copy()

    return slopes


def _step(data: MbsData, code: PythonCode, solver: Any) -> None:
    """One step of a solver.  Raises ConversionError where none is short enough."""
    time, y = solver.t, solver.y.copy()
    with suppress(ValueError):  # the implicit methods raise it where a number is not finite
        solver.step()
        if solver.status != "failed" and np.isfinite(solver.y).all():
            return
    raise _stuck(data, code, time, y, f"no step from {time:g} s is short enough")


def _stuck(data: MbsData, code: PythonCode, time: float, y: Any, said: str) -> SimulationError:
    """It names the joint that accelerates most at a state, and the largest forces."""
    from urdf2mbs_project.singular import find_singular

    code.accelerate(time, y)
    joint = max(data.joint_id, key=lambda name: abs(data.qdd[data.joint_id[name]]))
    number = data.joint_id[joint]
    text = (
        f"{said}: joint '{joint}' has {data.qd[number]:.3g} rad/s or m/s and "
        f"{data.qdd[number]:.3g} rad/s^2 or m/s^2, and its force is {data.Qq[number]:.3g} N m or N"
    )
    if data.extforce_id:
        sizes = np.linalg.norm(data.SWr[1:, 1:4], axis=1)
        force = list(data.extforce_id)[int(sizes.argmax())]
        text += f"; the largest external force is '{force}' with {sizes.max():.3g} N"
    for push in data.pushes:
        if push.start <= time < push.stop:
            text += f"; the push on '{push.link}' is {np.linalg.norm(push.force):.3g} N"
    hint = "take softer contacts, stops and gains, smaller forces, or an implicit method: "
    for found in find_singular(data.mbs)[:1]:
        text += f"; at the start, nothing that has mass resists joint '{found.joint}'"
        hint = f"start elsewhere, {hint}"
    return SimulationError(
        "step-failed", text, file=str(data.mbs_file), hint=f"{hint}--method Radau"
    )


def _breaks(data: MbsData, time: float, end: float) -> list[float]:
    """The times at which a force begins or ends: no step goes over one."""
    times = {t for push in data.pushes for t in (push.start, push.stop)} | {
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
    return SimulationError("partition", text, file=str(data.mbs_file), hint=hint)
