"""Modes: how a model oscillates about a state (Robotran's MbsModal).

The state y is q and qd of the independent joints, and the user states: y = (q, v, w).  For small
changes, dy/dt = A y, and the modes are the eigenvalues and eigenvectors of A.  A is taken by
central differences, so controllers, contacts and friction are in it as they are in the code.

The null space of A is removed before the eigenvalues are computed: rounding would split its zeros.
It has the positions on which no force depends, such as the shift of a robot on the floor.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs.plugin import write_files
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.dirdyn import Module, load_closed_code
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.equilibrium import DIFFERENCE
from urdf2mbs_simulate.partition import compute_dependent_jacobian
from urdf2mbs_simulate.partition_messages import format_joints, note_stops
from urdf2mbs_simulate.python_code import locate_errors, user_code
from urdf2mbs_simulate.results import format_res

#: Joints of a mode are listed if they move by this part of the joint that moves most; how many.
MIN_MOVE, MAX_LISTED_JOINTS = 0.2, 4
#: A singular value of A is 0 if it is smaller relative to the largest one.
SINGULAR_VALUE = 1e-7
#: Elements of A (1/s, 1/s^2) up to this are 0: the error of the differences.
NOISE = 1e-8
#: A mode does not oscillate if a smaller part of its eigenvalue is imaginary.
MIN_IMAGINARY = 1e-7
#: A damping ratio (of either sign) up to this is 0.
NO_DAMPING = 1e-8
#: Joints do not move if they move by a smaller part of a user state: in a mode that fades without
#: oscillation, and in any mode.
INNER_MOVE, NO_MOVE = 0.05, 1e-6
#: The animation of a mode: frames in a second, and its length (s).
FRAME_RATE, DURATION = 50, 4.0
#: The highest frequency (Hz) in an animation.
MAX_ANIMATED_FREQUENCY = FRAME_RATE / 20


@dataclass
class Mode:
    """An eigenvector of A: a motion exp(value t) times the shape."""

    value: complex
    """1/s; of a pair that oscillates, the one with a positive imaginary part."""
    shape: Any
    """(joints + 1,), complex: amplitude and phase of each joint, the largest being 1."""
    is_inner: bool = False
    """True if user states fade, as those of contacts and friction, and joints hardly move."""

    @property
    def frequency(self) -> float:
        """The frequency of the oscillation, Hz."""
        return self.value.imag / (2 * math.pi)

    @property
    def damping(self) -> float:
        """The damping ratio: the mode grows below 0, and does not oscillate from 1 on."""
        ratio = -self.value.real / abs(self.value)
        return 0.0 if abs(ratio) < NO_DAMPING else ratio

    @property
    def grows(self) -> bool:
        """True if the mode is unstable."""
        return self.damping < 0.0

    def joints(self) -> list[int]:
        """Return the joints that move most, the largest amplitude first."""
        amplitudes = np.abs(self.shape)
        if not amplitudes.any():
            return []
        threshold = MIN_MOVE * amplitudes.max()
        order = np.argsort(-amplitudes, kind="stable")
        return [int(k) for k in order if amplitudes[k] > threshold][:MAX_LISTED_JOINTS]


class NullSpace(NamedTuple):
    """The components of the state that are in the null space of A, as masks."""

    positions: Any
    """Of the independent joints."""
    speeds: Any
    """Of the independent joints."""
    states: Any
    """Of the user states."""


class Modes:
    """The modes of a state, the slowest first; those that do not oscillate come last."""

    def __init__(self, data: MbsData, modes: list[Mode], null_space: NullSpace) -> None:
        self.data, self.modes = data, modes
        joints = data.qu[1:]
        self.free: list[int] = joints[null_space.positions].tolist()
        """Joints without a restoring force."""
        self.stopped: list[int] = joints[null_space.positions & ~null_space.speeds].tolist()
        """Those of them that friction or damping stops; the others are ignorable coordinates."""
        names = [
            f"{model.name}.{parameter.name}"
            for model in data._run.mbs.user_models
            for parameter in model.parameters
            for _ in parameter.values
            if parameter.type == "state"
        ]
        self.states = list(dict.fromkeys(itertools.compress(names, null_space.states)))
        """User states that stay constant."""
        self.q = data.q.copy()
        self.conversion: Any = None
        """The conversion that has made the model, if a command has converted a robot."""
        self.temporary_folder: Any = None
        """A folder that is removed with the modes."""

    def _repr_html_(self) -> str | None:
        """Return the page that lists and shows the modes, for a notebook; None without modes."""
        from urdf2mbs_report.page import frame_page
        from urdf2mbs_simulate.project import make_modes_page

        return frame_page(make_modes_page(self)) if self.modes else None

    @property
    def stable(self) -> bool:
        """True if no mode grows."""
        return not any(mode.grows for mode in self.modes)

    def lines(self) -> list[str]:
        """Return the table of the modes, in lines for people."""
        lines = ["mode  frequency (Hz)  damping ratio  joints that move most"]
        inner = [mode for mode in self.modes if mode.is_inner]
        for number, mode in enumerate(self.modes, start=1):
            if not mode.is_inner or len(inner) == 1:
                lines.append(self._format_mode(number, mode))
        return lines + self.notes()

    def notes(self) -> list[str]:
        """Return what the table of modes does not list, and whether one of them grows."""
        lines = []
        inner = [mode for mode in self.modes if mode.is_inner]
        if len(inner) > 1:
            times = sorted(1.0 / abs(mode.value.real) for mode in inner)
            lines.append(
                f"{len(inner)} more: states of contacts, friction or the user, which fade in "
                f"{times[0]:.3g} to {times[-1]:.3g} s while the joints stay"
            )
        if drifting := set(self.free) - set(self.stopped):
            names = format_joints(self.data, drifting)
            lines.append(f"rigid-body motion, without a restoring force: {names}")
        if self.stopped:
            names = format_joints(self.data, self.stopped)
            lines.append(f"friction or damping holds these where they are: {names}")
        if self.states:
            lines.append(f"user states that keep their values: {', '.join(self.states)}")
        growing = [number for number, mode in enumerate(self.modes, 1) if mode.grows]
        lines.append(f"unstable: mode {', '.join(map(str, growing))}" if growing else "stable")
        return lines

    def describe(self, chosen: int = 1) -> dict[str, Any]:
        """Return the modes that move joints, as data for ``js/modes.js``.

        Args:
            chosen: The number of the mode that is shown at first, from 1.
        """
        names = list(self.data.joint_id)
        modes = [
            {
                "number": number,
                "frequency": mode.frequency,
                "damping": mode.damping,
                "time": f"{'grows' if mode.grows else 'fades'} in {1 / abs(mode.value.real):.3g} s"
                if mode.value.real
                else "",
                "amplitudes": [round(float(size), 6) for size in np.abs(mode.shape[1:])],
                "phases": [round(float(phase), 6) for phase in np.angle(mode.shape[1:])],
                "joints": [names[joint - 1] for joint in mode.joints()],
            }
            for number, mode in enumerate(self.modes, start=1)
            if mode.joints() and not mode.is_inner
        ]
        numbers = [mode["number"] for mode in modes]
        positions = dict(zip(names, self.q[1:].tolist(), strict=True))
        index = numbers.index(chosen) if chosen in numbers else 0
        return {"modes": modes, "chosen": index, "positions": positions}

    def _format_mode(self, number: int, mode: Mode) -> str:
        names = ", ".join(format_joints(self.data, [k]) for k in mode.joints())
        if mode.value.imag > 0:
            frequency, damping = f"{mode.frequency:.4g}", f"{mode.damping:.4g}"
        else:
            frequency, damping = "-", _format_time_constant(mode)
        return f"{number:4}  {frequency:>14}  {damping:>13}  {names or 'user states'}"

    def table(self) -> bytes:
        """Return the .csv: a row for each mode, with amplitude and phase of each joint."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        joints = list(self.data.joint_id)
        columns = [f"{part}.{joint}" for joint in joints for part in ("size", "phase")]
        writer.writerow(["mode", "frequency", "damping", "real", "imaginary", *columns])
        for number, mode in enumerate(self.modes, start=1):
            value = [mode.frequency, mode.damping, mode.value.real, mode.value.imag]
            shape = [float(x) for z in mode.shape[1:] for x in (abs(z), np.angle(z))]
            writer.writerow([number, *value, *shape])
        return text.getvalue().encode()

    def motion(self, number: int, size: float = 0.2) -> Any:
        """Return an animation of a mode, which neither fades nor grows.

        Args:
            number: Of the mode, from 1.
            size: The amplitude (rad, m) of the joint that moves most.

        Returns:
            (frames, joints + 1): the time (s), then q of each joint.  The frequency is that of the
            mode, but at least one oscillation and at most ``MAX_ANIMATED_FREQUENCY``.
        """
        mode = self.modes[number - 1]
        time = np.arange(0.0, DURATION, 1.0 / FRAME_RATE)
        frequency = min(max(mode.frequency, 1.0 / DURATION), MAX_ANIMATED_FREQUENCY)
        rate = 2 * math.pi * frequency
        q = self.q + size * (np.exp(1j * rate * time)[:, None] * mode.shape).real
        q[:, 0] = time
        return q

    def write(self, number: int, *, force: bool = False) -> list[Path]:
        """Write modal.csv, and the animation of a mode, mode.csv, into resultsR of the project.

        Args:
            number: The number of the mode, from 1.
            force: True to replace files of another program, too.

        Raises:
            ConfigError: A file of another program would be replaced.
        """
        folder = self.data._run.project / "resultsR"
        header = ",".join(["time", *(f"q.{joint}" for joint in self.data.joint_id)])
        rows = format_res(self.motion(number)).replace(b" ", b",") if self.modes else b""
        files = {
            folder / "modal.csv": self.table(),
            folder / "mode.csv": f"{header}\n".encode() + rows,
        }
        write_files(files, force=force)
        return list(files)


def _format_time_constant(mode: Mode) -> str:
    """Say in which time a mode that does not oscillate fades, or grows, by the factor e."""
    return f"{'in' if mode.value.real < 0 else 'grows'} {1 / abs(mode.value.real):.3g} s"


class MbsModal(Module):
    """A modal analysis of the present state: set its options, and run it."""

    OPTIONS = {
        "save_result": 1,
        "save_anim": 0,
        "mode_ampl": 0.2,
        "save_eval": 1,
        "save_evec": 0,
        "save_mat": 0,
        "resfilename": "modal",
        "respath": None,
        "animpath": None,
        "language": None,
        "verbose": 1,
    }

    def run(self) -> Modes:
        """Compute the modes; results are written if ``save_result`` is set.

        Raises:
            SimulationError: The accelerations near the state are not numbers.
        """
        data, options = self.mbs_data, self.options
        with user_code(data), locate_errors(data):
            code = load_closed_code(data, options["language"])
            note_stops(data, touching=True)
            matrix = compute_state_matrix(code)
            modes = find_modes(code, matrix)
        if options["save_result"]:
            self._write_modes(modes, matrix)
        return modes

    def _write_modes(self, modes: Modes, matrix: Any) -> list[Path]:
        """Write the files of Robotran that the options ask for, and the table."""
        data, options, name = self.mbs_data, self.options, self.options["resfilename"]
        results = Path(options["respath"] or data._run.project / "resultsR")
        animation = Path(options["animpath"] or data._run.project / "animationR")
        values = np.array([mode.value for mode in modes.modes])
        files = {results / f"{name}.csv": modes.table()}
        if options["save_eval"]:
            files[results / f"{name}_eval_a.res"] = format_res(values.real[:, None])
            files[results / f"{name}_eval_b.res"] = format_res(values.imag[:, None])
        if options["save_evec"]:
            shapes = np.array([mode.shape[1:] for mode in modes.modes]).reshape(len(values), -1)
            files[results / f"{name}_evec_a.res"] = format_res(shapes.real)
            files[results / f"{name}_evec_b.res"] = format_res(shapes.imag)
        if options["save_mat"]:
            files[results / f"{name}_mat.res"] = format_res(matrix)
        for number in range(1, len(values) + 1) if options["save_anim"] else ():
            motion = modes.motion(number, options["mode_ampl"])
            files[animation / f"{name}_{number}_q.anim"] = format_res(motion)
        write_files(files, force=True)
        return list(files)


def compute_state_matrix(code: CCode) -> Any:
    """Compute A at the present state by central differences: (states, states).

    Raises:
        SimulationError: The accelerations near the state are not numbers.
    """
    data, y = code.data, code.get_state()
    forward = code.differentiate(data.tsim, y, DIFFERENCE)
    backward = code.differentiate(data.tsim, y, -DIFFERENCE)
    matrix = (forward + backward) / 2
    code.accelerate(data.tsim, y)
    if not np.isfinite(matrix).all():
        raise SimulationError(
            "partition",
            "the accelerations near this state are not numbers",
            file=str(data._run.file),
            hint="take another state, such as an equilibrium",
        )
    return matrix


def find_modes(code: CCode, matrix: Any) -> Modes:
    """Find the modes of dy/dt = A y, and name the components of its null space."""
    data, n = code.data, len(code.independent)
    reduced, basis, null_space = _remove_null_space(np.where(np.abs(matrix) > NOISE, matrix, 0.0))
    values, vectors = np.linalg.eig(reduced) if reduced.size else (np.zeros(0), np.zeros((0, 0)))
    dependent_jacobian = compute_dependent_jacobian(code)
    modes = []
    for value, vector in zip(values, (basis @ vectors).T, strict=True):
        if abs(value.imag) < MIN_IMAGINARY * abs(value):  # a double one, split by rounding
            value = complex(value.real)
        if value.imag >= 0:
            modes.append(_make_mode(code, value, vector, dependent_jacobian))
    modes.sort(key=lambda mode: (mode.is_inner, mode.value.imag == 0, abs(mode.value)))
    is_null = np.linalg.norm(null_space, axis=1) > 0.5
    return Modes(data, modes, NullSpace(is_null[:n], is_null[n : 2 * n], is_null[2 * n :]))


def _remove_null_space(matrix: Any) -> tuple[Any, Any, Any]:
    """Reduce a matrix A until it is regular.

    The null space of the reduced matrix is removed, too: (0, 1; 0, 0) of a free joint has rank 1,
    and reduces to 0.

    Returns:
        B' A B, the basis B, and the vectors that were removed, as columns.
    """
    reduced, basis = matrix, np.eye(len(matrix))
    removed = np.zeros((len(matrix), 0))
    while reduced.size:
        rows = reduced / np.maximum(np.abs(reduced).max(axis=1), NOISE)[:, None]
        _, singular_values, directions = np.linalg.svd(rows)
        threshold = SINGULAR_VALUE * max(singular_values[0], 1e-300)
        rank = int((singular_values > threshold).sum())
        if rank == len(reduced):
            break
        removed = np.column_stack([removed, basis @ directions[rank:].T])
        remaining = directions[:rank].T
        reduced, basis = remaining.T @ reduced @ remaining, basis @ remaining
    return reduced, basis, removed


def _make_mode(code: CCode, value: Any, vector: Any, dependent_jacobian: Any) -> Mode:
    """Make a mode of an eigenvalue and an eigenvector, which is scaled."""
    n = len(code.independent)
    shape = np.zeros(code.data.njoint + 1, complex)
    # v = value q: where q is in the null space, the speed still says how far the joint moves
    shape[code.independent] = vector[n : 2 * n] / value
    shape[code.dependent] = dependent_jacobian @ shape[code.independent]
    largest = shape[np.abs(shape).argmax()]
    largest_state = np.abs(vector[2 * n :]).max(initial=0.0)
    if abs(largest) < NO_MOVE * largest_state:  # rounding
        shape, largest = np.zeros_like(shape), 0.0
    fades = value.imag == 0 and value.real < 0
    is_inner = fades and abs(largest) < INNER_MOVE * largest_state
    return Mode(complex(value), shape / largest if largest else shape, bool(is_inner))
