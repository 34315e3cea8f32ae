"""A given motion: its dependent joints (Robotran's MbsSolvekin), and its forces (MbsInvdyn)."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs.plugin import ConfigError
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.dirdyn import Module, load_closed_code
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.partition import compute_dependent_jacobian, improve_partition
from urdf2mbs_simulate.partition_messages import format_joints
from urdf2mbs_simulate.python_code import locate_errors, user_code
from urdf2mbs_simulate.results import Recorder, Results

#: Forces make a motion if a smaller part of the largest force is missing.
MISSING_FORCE = 1e-6


class Motion(NamedTuple):
    """A motion of all joints: a row for each time (rad, m and their rates)."""

    q: Any
    qd: Any
    qdd: Any


class MbsSolvekin(Module):
    """The dependent joints along a motion: set its options, and run it.

    ``trajectoryqname`` is a .res file: the time (s), and a column for each joint; qd and qdd are
    derivatives of a spline, or come from files of their own.
    """

    OPTIONS = {
        "motion": "trajectory",
        "trajectoryqname": None,
        "trajectoryqdname": None,
        "trajectoryqddname": None,
        "t0": 0.0,
        "tf": 5.0,
        "dt": 1e-3,
        "framerate": 1000.0,
        "resfilename": "solvekin",
        "respath": None,
        "animpath": None,
        "language": None,
        "save2file": 1,
    }

    def run(self) -> Results:
        """Follow the motion from t0 to tf by dt; results are written if ``save2file`` is set.

        Raises:
            ConversionError: The motion cannot be read or followed, or user code raises.
        """
        data, options = self.mbs_data, self.options
        times, motion = self._read_motion()
        with user_code(data), locate_errors(data):
            # dependent joints whose columns are 0 start as they are drawn
            is_given = motion.q.any(axis=0) | (np.array(data._run.natures) != "dependent")
            data.q[1:][is_given] = motion.q[0, is_given]
            code = load_closed_code(data, options["language"])
            recorder, forces = Recorder(data, code), []
            self._call_user_function("init")
            for time, *state in zip(times, *motion, strict=True):
                _set_state(code, time, Motion(*state))
                if isinstance(self, MbsInvdyn):
                    forces.append([time, *compute_actuator_forces(code)])
                self._call_user_function("loop")
                recorder.record_data(time)
                improve_partition(code)
            self._call_user_function("finish")
            results = recorder.results()
        results.Qa = np.array(forces) if forces else None
        self._write(results)
        return results

    def _read_motion(self) -> tuple[Any, Motion]:
        """Read the times of the run, and the motion at these.

        Raises:
            ConfigError: There is no motion at these times, or a file cannot be read.
        """
        from scipy.interpolate import CubicSpline

        options, tables = self.options, list[Any]()
        if options["motion"] != "trajectory" or not options["trajectoryqname"]:
            raise ConfigError("usage", 'expected motion="trajectory" with a trajectoryqname')
        count = round((options["tf"] - options["t0"]) / options["dt"])
        times = options["t0"] + options["dt"] * np.arange(count + 1)
        for name in ("trajectoryqname", "trajectoryqdname", "trajectoryqddname"):
            if file := options[name]:
                rows = _read_res(Path(file), self.mbs_data.njoint)
                spline = CubicSpline(rows[:, 0], rows[:, 1:])
                if not rows[0, 0] <= times[0] <= times[-1] <= rows[-1, 0] + 1e-9:
                    message = f"there is no motion from {times[0]:g} s to {times[-1]:g} s"
                    raise ConfigError("usage", message, file=str(file), hint="set t0 and tf")
            else:
                spline = spline.derivative()
            tables.append(spline(times))
        return times, Motion(*tables)

    def _call_user_function(self, when: str) -> None:
        """Call a user function; solvekin has none."""


class MbsInvdyn(MbsSolvekin):
    """The forces of the actuated joints that make a motion.

    Without actuated joints, they are those of the independent ones.  Where many forces make the
    motion, the smallest are taken.
    """

    OPTIONS = MbsSolvekin.OPTIONS | {"resfilename": "invdyn"}

    def _call_user_function(self, when: str) -> None:
        getattr(self.mbs_data, f"user_invdyn_{when}")(self.mbs_data, self)


def _read_res(file: Path, n_joints: int) -> Any:
    """Read a .res file: rows with a time, and a number for each joint.

    Raises:
        ConfigError: The file cannot be read, or a row is not like that.
    """

    def make_error(message: str, line: int | None = None) -> ConfigError:
        return ConfigError("usage", message, file=str(file), line=line)

    try:
        lines = file.read_text("utf-8", "replace").splitlines()
    except OSError as error:
        raise make_error(f"it cannot be read: {error.strerror}") from None
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        try:
            row = [float(word) for word in line.partition("#")[0].split()]
        except ValueError as error:
            raise make_error(str(error), number) from None
        if not row:
            continue
        if len(row) != n_joints + 1 or not np.isfinite(row).all():
            message = f"expected a time and {n_joints} numbers, one for each joint"
            raise make_error(message, number)
        if rows and row[0] <= rows[-1][0]:
            raise make_error("its time is not after that of the row before", number)
        rows.append(row)
    if len(rows) < 2:
        raise make_error(f"it has {len(rows)} rows of numbers; expected two or more")
    return np.array(rows)


def compute_actuator_forces(code: CCode) -> Any:
    """Compute the forces Qa of the actuated joints for the present accelerations.

    They solve M qdd + c = Qq + Qa + J' Lambda, with Qc in driven joints: with the motion of all
    joints T = dq/du, T' Qa = T' (M qdd + c - Qq), by least squares.

    Returns:
        (joints), N m or N; 0 where a joint is not actuated.

    Raises:
        SimulationError: The actuated joints cannot make the motion.
    """
    data = code.data
    required = code.compute_inverse_dynamics() - data.Qq
    actuated = np.setdiff1d(data.qa[1:], data.qc) if data.nqa else code.independent
    dq_du = np.zeros((data.njoint + 1, len(code.independent)))
    dq_du[code.independent] = np.eye(len(code.independent))
    dq_du[code.dependent] = compute_dependent_jacobian(code)
    forces = np.linalg.lstsq(dq_du[actuated].T, dq_du.T @ required, rcond=None)[0]
    missing = np.abs(dq_du.T @ required - dq_du[actuated].T @ forces)
    if not missing.max(initial=0.0) <= MISSING_FORCE * (1.0 + np.abs(required).max()):
        joint = code.independent[int(missing.argmax())]
        raise SimulationError(
            "not-actuated",
            f"at {data.tsim:g} s the actuated joints cannot move '{format_joints(data, [joint])}': "
            f"{missing.max():.3g} N m or N is missing",
            file=str(data._run.file),
            hint="let more joints be actuated: mbs_data.set_qa(JOINT)",
        )
    data.Qa[:] = 0.0
    data.Qa[actuated] = forces
    data.Qq += data.Qa
    code.compute_reactions()
    data.Qq -= data.Qa
    return data.Qa[1:]


def _set_state(code: CCode, time: float, state: Motion) -> None:
    """Set a state and its accelerations; dependent joints are those that close the loops.

    Raises:
        SimulationError: The loops cannot be closed.
    """
    data, independent, driven = code.data, code.independent, code.data.qc[1:]
    q, qd, qdd = state
    data.q[driven], data.qd[driven], data.qdd[driven] = (x[driven - 1] for x in state)
    y = np.concatenate([q[independent - 1], qd[independent - 1], data.ux[1:]])
    if not np.isfinite(code.accelerate(time, y)).all():
        raise SimulationError(
            "partition",
            f"the loops cannot be closed at {time:g} s",
            file=str(data._run.file),
            hint="take a shorter dt, or a motion that the loops allow",
        )
    code.store_guess()
    # the model has computed the accelerations without the forces of the actuators
    change = qdd[independent - 1] - data.qdd[independent]
    data.qdd[independent] += change
    data.qdd[code.dependent] += compute_dependent_jacobian(code) @ change
