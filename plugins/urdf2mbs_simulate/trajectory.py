"""Along a given motion: loops are closed (Robotran's MbsSolvekin), and the forces are found that
make the motion (MbsInvdyn)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.plugin import ConfigError
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.dirdyn import Module, closed_code
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.partition import choose_again, following, names_of
from urdf2mbs_simulate.python_code import loaded, shown
from urdf2mbs_simulate.results import Recorder, Results

#: Forces make a motion if so small a part of the largest force is missing.
MISSING = 1e-6


class MbsSolvekin(Module):
    """The dependent joints along a motion: set its options, and run it.

    ``trajectoryqname`` is a .res file: the time (s), and a column for each joint; qd and qdd are
    slopes of a spline, or of files of their own.
    """

    OPTIONS = {
        "motion": "trajectory", "trajectoryqname": None, "trajectoryqdname": None,
        "trajectoryqddname": None, "t0": 0.0, "tf": 5.0, "dt": 1e-3, "framerate": 1000.0,
        "resfilename": "solvekin", "respath": None, "animpath": None, "language": None,
        "save2file": 1,
    }  # fmt: skip

    def run(self) -> Results:
        """Follow the motion from t0 to tf by dt; results are written if ``save2file`` is set."""
        data, options = self.mbs_data, self.options
        times, motion = self._read()
        with loaded(data), shown(data):
            known = motion[0].any(axis=0) | (np.array(data._run.natures) != "dependent")
            data.q[1:][known] = motion[0][0, known]
            code = closed_code(data, options["language"])
            recorder, forces = Recorder(data, code), []
            self._call("init")
            for time, *state in zip(times, *motion, strict=True):
                _move(code, time, *state)
                if isinstance(self, MbsInvdyn):
                    forces.append([time, *find_forces(code)])
                self._call("loop")
                recorder.keep(time)
                choose_again(code)
            self._call("finish")
            results = recorder.results()
        results.Qa = np.array(forces) if forces else None
        self._write(results)
        return results

    def _read(self) -> tuple[Any, list[Any]]:
        """Times, and q, qd and qdd at these: (times, joints) each."""
        from scipy.interpolate import CubicSpline

        options, motion = self.options, list[Any]()
        if options["motion"] != "trajectory" or not options["trajectoryqname"]:
            raise ConfigError("usage", 'a motion="trajectory" with a trajectoryqname is wanted')
        count = round((options["tf"] - options["t0"]) / options["dt"])
        times = options["t0"] + options["dt"] * np.arange(count + 1)
        for name in ("trajectoryqname", "trajectoryqdname", "trajectoryqddname"):
            if file := options[name]:
                rows = _rows(Path(file), self.mbs_data.njoint)
                spline = CubicSpline(rows[:, 0], rows[:, 1:])
                if not rows[0, 0] <= times[0] <= times[-1] <= rows[-1, 0] + 1e-9:
                    said = f"there is no motion from {times[0]:g} s to {times[-1]:g} s"
                    raise ConfigError("usage", said, file=str(file), hint="set t0 and tf")
            else:
                spline = spline.derivative()
            motion.append(spline(times))
        return times, motion

    def _call(self, when: str) -> None:
        """Call a user function, which solvekin has none of."""


class MbsInvdyn(MbsSolvekin):
    """The forces of the actuated joints that make a motion; without actuated joints, those of the
    independent ones.  The smallest forces are taken where there are too many."""

    OPTIONS = MbsSolvekin.OPTIONS | {"resfilename": "invdyn"}

    def _call(self, when: str) -> None:
        getattr(self.mbs_data, f"user_invdyn_{when}")(self.mbs_data, self)


def _rows(file: Path, joints: int) -> Any:
    """The rows of a .res file: a time, and a number for each joint."""

    def wrong(said: str, line: int | None = None) -> ConfigError:
        return ConfigError("usage", said, file=str(file), line=line)

    try:
        lines = file.read_text("utf-8", "replace").splitlines()
    except OSError as error:
        raise wrong(f"it cannot be read: {error.strerror}") from None
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        try:
            row = [float(word) for word in line.partition("#")[0].split()]
        except ValueError as error:
            raise wrong(str(error), number) from None
        if row and (len(row) != joints + 1 or not np.isfinite(row).all()):
            raise wrong(f"a time and {joints} numbers, one for each joint, are wanted", number)
        if row and rows and row[0] <= rows[-1][0]:
            raise wrong("its time is not after that of the row before", number)
        rows += [row] if row else []
    if len(rows) < 2:
        raise wrong(f"it has {len(rows)} rows of numbers: a motion has two or more")
    return np.array(rows)


def find_forces(code: CCode) -> Any:
    """The forces of all joints (N m, N):
    M qdd + c = Qq + Qa + Jac' Lambda, and Qc in driven joints, for Qa."""
    data, follow = code.data, following(code)
    wanted = code.inverse() - data.Qq
    actuated = np.setdiff1d(data.qa[1:], data.qc) if data.nqa else code.free
    turn = np.zeros((data.njoint + 1, len(code.free)))
    turn[code.free], turn[code.dependent] = np.eye(len(code.free)), follow
    found = np.linalg.lstsq(turn[actuated].T, turn.T @ wanted, rcond=None)[0]
    left = np.abs(turn.T @ wanted - turn[actuated].T @ found)
    if not left.max(initial=0.0) <= MISSING * (1.0 + np.abs(wanted).max()):
        worst = code.free[int(left.argmax())]
        raise SimulationError(
            "not-actuated",
            f"at {data.tsim:g} s the actuated joints cannot move '{names_of(data, [worst])}': "
            f"{left.max():.3g} N m or N is missing",
            file=str(data._run.file), hint="let more joints be actuated: mbs_data.set_qa(JOINT)",
        )  # fmt: skip
    data.Qa[:] = 0.0
    data.Qa[actuated] = found
    data.Qq += data.Qa
    code.react()
    data.Qq -= data.Qa
    return data.Qa[1:]


def _move(code: CCode, time: float, q: Any, qd: Any, qdd: Any) -> None:
    """Let the model have a state, with the dependent joints as the loops want them."""
    data, free = code.data, code.free
    driven = data.qc[1:]
    data.q[driven], data.qd[driven], data.qdd[driven] = (x[driven - 1] for x in (q, qd, qdd))
    rates = code.accelerate(time, np.concatenate([q[free - 1], qd[free - 1], data.ux[1:]]))
    if not np.isfinite(rates).all():
        raise SimulationError(
            "partition", f"the loops cannot be closed at {time:g} s", file=str(data._run.file),
            hint="take a shorter dt, or a motion that the loops allow",
        )  # fmt: skip
    code.remember()
    more = qdd[free - 1] - data.qdd[free]  # than the forces of the model alone give
    data.qdd[free] += more
    data.qdd[code.dependent] += following(code) @ more
