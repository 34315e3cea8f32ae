"""Modes: how a model swings about a state (Robotran's MbsModal).

The state y is q and qd of the independent joints, and the user states; y' = A y for small changes.
A is taken by differences to both sides, so controllers, contacts and friction are in it as they are
in the code.  Directions in which nothing pulls back are taken out before the eigenvalues: they
would be zeros that rounding has split.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.plugin import write_files
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.dirdyn import Module, closed_code
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.equilibrium import STEP
from urdf2mbs_simulate.partition import following, names_of, note_stops
from urdf2mbs_simulate.python_code import loaded, shown
from urdf2mbs_simulate.results import res_rows

#: A joint is named of a mode if it moves by so much of the joint that moves most.
MOVES = 0.2
#: Nothing pulls back along a direction whose slopes are so small a part of the largest.
FLAT = 1e-7
#: Slopes (1/s, 1/s^2) up to this are none: what differences leave of zero.
NOISE = 1e-8
#: A mode does not swing if so small a part of its value is imaginary.
REAL = 1e-7
#: A damping ratio (of either sign) up to this is 0, and grows nothing.
NO_DAMPING = 1e-8
#: Joints that move by so small a part of a user state do not move: in a mode that fades, in any.
INNER, NO_SHAPE = 0.05, 1e-6
#: Frames of the animation of a mode: FRAMES a second, for SECONDS.
FRAMES, SECONDS = 50, 4.0


@dataclass
class Mode:
    """One way to move: exp(value t) times the shape."""

    value: complex
    """1/s; of a pair that swings, the one with a positive imaginary part."""
    shape: Any
    """(joints + 1,), complex: how far and in which phase each joint moves, the most being 1."""
    is_inner: bool = False
    """True if user states fade, as those of contacts and friction, and next to no joint moves."""

    @property
    def frequency(self) -> float:
        """How often it swings, Hz."""
        return self.value.imag / (2 * math.pi)

    @property
    def damping(self) -> float:
        """The damping ratio: below 0 it grows, and from 1 on it does not swing."""
        ratio = -self.value.real / abs(self.value)
        return 0.0 if abs(ratio) < NO_DAMPING else ratio

    @property
    def grows(self) -> bool:
        return self.damping < 0.0

    def joints(self) -> list[int]:
        """Those that move most, the most first."""
        far = np.abs(self.shape)
        if not far.any():
            return []
        return [int(k) for k in np.argsort(-far, kind="stable") if far[k] > MOVES * far.max()][:4]


class Modes:
    """The modes of a state, the slowest first; those that do not swing come last."""

    def __init__(self, data: MbsData, modes: list[Mode], zeros: tuple[Any, Any, Any]) -> None:
        self.data, self.modes = data, modes
        still, drifting, states = zeros
        self.free: list[int] = data.qu[1:][still].tolist()
        """Joints that nothing pulls back."""
        self.stopped: list[int] = data.qu[1:][still & ~drifting].tolist()
        """Those of them that friction or damping stops; the others are ignorable coordinates."""
        names = [
            f"{model.name}.{parameter.name}"
            for model in data._run.mbs.user_models
            for parameter in model.parameters
            for _ in parameter.values
            if parameter.type == "state"
        ]
        self.states = list(dict.fromkeys(itertools.compress(names, states)))
        """User states that nothing pulls back."""
        self.q = data.q.copy()
        self.keep: Any = None
        """A folder that is removed with the modes."""

    @property
    def stable(self) -> bool:
        return not any(mode.grows for mode in self.modes)

    def lines(self) -> list[str]:
        """The table of the modes."""
        said = ["mode  frequency (Hz)  damping ratio  joints that move most"]
        inner = [mode for mode in self.modes if mode.is_inner]
        for number, mode in enumerate(self.modes, start=1):
            if mode.is_inner and len(inner) > 1:
                continue
            names = ", ".join(names_of(self.data, [k]) for k in mode.joints())
            swings = mode.value.imag > 0
            rate = f"{mode.frequency:14.4g}" if swings else "             -"
            ratio = f"{mode.damping:13.4g}" if swings else f"{_time_of(mode):>13}"
            said.append(f"{number:4}  {rate}  {ratio}  {names or 'user states'}")
        if len(inner) > 1:
            times = sorted(1.0 / abs(mode.value.real) for mode in inner)
            said.append(
                f"{len(inner)} more: states of contacts, friction or the user, which fade in "
                f"{times[0]:.3g} to {times[-1]:.3g} s while the joints stay"
            )
        if drifting := set(self.free) - set(self.stopped):
            where = names_of(self.data, drifting)
            said.append(f"rigid-body motion, which nothing pulls back: {where}")
        if self.stopped:
            where = names_of(self.data, self.stopped)
            said.append(f"friction or damping holds these where they are: {where}")
        if self.states:
            said.append(f"user states that keep their values: {', '.join(self.states)}")
        growing = [number for number, mode in enumerate(self.modes, 1) if mode.grows]
        said.append(f"unstable: mode {', '.join(map(str, growing))}" if growing else "stable")
        return said

    def table(self) -> bytes:
        """The .csv: a row for each mode, with the shape as amplitude and phase of each joint."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        joints = list(self.data.joint_id)
        parts = [f"{part}.{joint}" for joint in joints for part in ("size", "phase")]
        writer.writerow(["mode", "frequency", "damping", "real", "imaginary", *parts])
        for number, mode in enumerate(self.modes, start=1):
            shape = [x for z in mode.shape[1:] for x in (abs(z), float(np.angle(z)))]
            writer.writerow([number, mode.frequency, mode.damping, mode.value.real,
                             mode.value.imag, *map(float, shape)])  # fmt: skip
        return text.getvalue().encode()

    def motion(self, number: int, size: float = 0.2) -> Any:
        """Frames of a mode that swings (time, then q of each joint): neither fading nor growing,
        with ``size`` (rad, m) for the joint that moves most, and at least once in SECONDS."""
        mode = self.modes[number - 1]
        time = np.arange(0.0, SECONDS, 1.0 / FRAMES)
        turn = 2 * math.pi * min(max(mode.frequency, 1.0 / SECONDS), FRAMES / 20)
        q = self.q + size * (np.exp(1j * turn * time)[:, None] * mode.shape).real
        q[:, 0] = time
        return q

    def write(self, number: int, *, force: bool = False) -> list[Path]:
        """Write modal.csv, and the swing of a mode, mode.csv, into resultsR of the project.

        Args:
            number: The number of the mode, from 1.
            force: True to replace files of another program, too.

        Raises:
            ConfigError: A file of another program would be replaced.
        """
        results = self.data._run.project / "resultsR"
        head = ",".join(["time", *(f"q.{joint}" for joint in self.data.joint_id)])
        rows = res_rows(self.motion(number)).replace(b" ", b",") if self.modes else b""
        files = {
            results / "modal.csv": self.table(),
            results / "mode.csv": f"{head}\n".encode() + rows,
        }
        write_files(files, force=force)
        return list(files)


def _time_of(mode: Mode) -> str:
    """How long a mode that does not swing takes to fade, or to grow, to a third (by e)."""
    return f"{'in' if mode.value.real < 0 else 'grows'} {1 / abs(mode.value.real):.3g} s"


class MbsModal(Module):
    """A modal analysis of the present state: set its options, and run it."""

    OPTIONS = {
        "save_result": 1, "save_anim": 0, "mode_ampl": 0.2, "save_eval": 1, "save_evec": 0,
        "save_mat": 0, "resfilename": "modal", "respath": None, "animpath": None,
        "language": None, "verbose": 1,
    }  # fmt: skip

    def run(self) -> Modes:
        """Find the modes; results are written if ``save_result`` is set.

        Raises SimulationError where the state has no slopes.
        """
        data, options = self.mbs_data, self.options
        with loaded(data), shown(data):
            code = closed_code(data, options["language"])
            note_stops(data, touching=True)
            matrix = slopes_of(code)
            modes = find_modes(code, matrix)
        if options["save_result"]:
            self._write_modes(modes, matrix)
        return modes

    def _write_modes(self, modes: Modes, matrix: Any) -> list[Path]:
        data, options, name = self.mbs_data, self.options, self.options["resfilename"]
        results = Path(options["respath"] or data._run.project / "resultsR")
        moving = Path(options["animpath"] or data._run.project / "animationR")
        values = np.array([mode.value for mode in modes.modes])
        files = {results / f"{name}.csv": modes.table()}
        if options["save_eval"]:
            files[results / f"{name}_eval_a.res"] = res_rows(values.real[:, None])
            files[results / f"{name}_eval_b.res"] = res_rows(values.imag[:, None])
        if options["save_evec"]:
            shapes = np.array([mode.shape[1:] for mode in modes.modes]).reshape(len(values), -1)
            files[results / f"{name}_evec_a.res"] = res_rows(shapes.real)
            files[results / f"{name}_evec_b.res"] = res_rows(shapes.imag)
        if options["save_mat"]:
            files[results / f"{name}_mat.res"] = res_rows(matrix)
        for number in range(1, len(values) + 1) if options["save_anim"] else ():
            motion = modes.motion(number, options["mode_ampl"])
            files[moving / f"{name}_{number}_q.anim"] = res_rows(motion)
        write_files(files, force=True)
        return list(files)


def slopes_of(code: CCode) -> Any:
    """A at the present state, by differences to both sides: (states, states)."""
    data, y = code.data, code.state()
    found = (code.slopes(data.tsim, y, STEP) + code.slopes(data.tsim, y, -STEP)) / 2
    code.accelerate(data.tsim, y)
    if not np.isfinite(found).all():
        raise SimulationError(
            "partition", "the accelerations near this state are no numbers",
            file=str(data._run.file), hint="take another state, such as an equilibrium",
        )  # fmt: skip
    return found


def find_modes(code: CCode, matrix: Any) -> Modes:
    """The modes of y' = A y; what nothing pulls back is left out of it, and named."""
    data, n = code.data, len(code.free)
    left, basis = np.where(np.abs(matrix) > NOISE, matrix, 0.0), np.eye(len(matrix))
    gone = np.zeros((len(matrix), 0))
    while left.size:
        rows = left / np.maximum(np.abs(left).max(axis=1), NOISE)[:, None]
        _, sizes, directions = np.linalg.svd(rows)
        rank = int((sizes > FLAT * max(sizes[0], 1e-300)).sum())
        if rank == len(left):
            break
        gone = np.column_stack([gone, basis @ directions[rank:].T])
        keep = directions[:rank].T
        left, basis = keep.T @ left @ keep, basis @ keep
    values, vectors = np.linalg.eig(left) if left.size else (np.zeros(0), np.zeros((0, 0)))
    follow = following(code)
    modes = []
    for value, vector in zip(values, (basis @ vectors).T, strict=True):
        if abs(value.imag) < REAL * abs(value):  # two of a double one, which rounding has split
            value = complex(value.real)
        if value.imag < 0:
            continue
        shape = np.zeros(data.njoint + 1, complex)
        # v = value q: where q was left out, the speed still says how far it swings
        shape[code.free] = vector[n : 2 * n] / value
        shape[code.dependent] = follow @ shape[code.free]
        largest, states = shape[np.abs(shape).argmax()], np.abs(vector[2 * n :]).max(initial=0.0)
        if abs(largest) < NO_SHAPE * states:  # what rounding has left
            shape, largest = np.zeros_like(shape), 0.0
        is_inner = value.imag == 0 and value.real < 0 and abs(largest) < INNER * states
        modes.append(Mode(complex(value), shape / largest if largest else shape, bool(is_inner)))
    modes.sort(key=lambda mode: (mode.is_inner, mode.value.imag == 0, abs(mode.value)))
    still = np.linalg.norm(gone, axis=1) > 0.5
    return Modes(data, modes, (still[:n], still[n : 2 * n], still[2 * n :]))
