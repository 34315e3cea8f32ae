"""The results of a simulation: arrays, a table, and Robotran's files."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf2mbs.plugin import check_ours, not_installed, write_files
from urdf2mbs_simulate.data import MbsData, MbsSensor
from urdf2mbs_simulate.push import compute_push_columns
from urdf2mbs_simulate.python_code import user_code

if TYPE_CHECKING:
    from urdf2mbs_simulate.c_code import CCode
    from urdf2mbs_simulate.story import Story

#: The quantities that are recorded of each frame, by the names of MbsData and Robotran's files.
QUANTITIES = ("q", "qd", "qdd", "Qq", "Qc", "Lambda", "ux", "uxd", "Z", "Zd", "Fl", "SWr")
#: The names of Robotran's files, where they differ.
FILE_NAMES = {"Z": "linkZ", "Zd": "linkZD", "Fl": "linkF"}
#: The quantities that every model has.
ALWAYS_WRITTEN = ("q", "qd", "qdd", "Qq")
#: The components of an external force: N and N m in the axes of the base, and the point (m) where
#: it acts, in those of the body.
WRENCH = ("Fx", "Fy", "Fz", "Mx", "My", "Mz", "dx", "dy", "dz")


class Results:
    """The frames of a simulation.

    ``q``, ``qd``, ``qdd``, ``Qq``, ``Qc``: a row for each frame; column 0 is the time (s), and a
    joint's column is its number, as in Robotran's results (rad, m, N m, N).  ``ux``: the user
    states, by their numbers.
    """

    def __init__(self, data: MbsData, frames: dict[str, Any], language: str) -> None:
        """Take the frames of a Recorder: ``time``, and an array for each of ``QUANTITIES``."""
        self.data, self.language = data, language
        self.time = frames["time"]
        self.frames = {name: frames[name] for name in QUANTITIES}
        self.q, self.qd, self.qdd, self.Qq, self.Qc = (
            self.frames[name] for name in ("q", "qd", "qdd", "Qq", "Qc")
        )
        self.ux = self.frames["ux"]
        self.joints = list(data.joint_id)
        self.outputs = {name: np.array(values) for name, values in data._run.outputs.items()}
        """What user code has given to ``set_output``: time and value, a row for each frame."""
        self.Qa: Any = None
        """Of inverse dynamics: time, and the force of each joint, a row for each frame."""
        self.stopped = bool(data.flag_stop)
        """True if user code has ended the run."""
        self.equilibrium: Any = None
        """The equilibrium that the run started from, if one was asked for."""
        self.files: list[Path] = []
        """Files that the run has written."""
        self.conversion: Any = None
        """The conversion that has made the model, if a command has converted a robot."""
        self.temporary_folder: Any = None
        """A folder that is removed with the results."""

    def joint(self, name: str) -> Any:
        """Return the positions of a joint (rad or m), one for each frame."""
        return self.q[:, self.data.joint_id[name]]

    @property
    def external(self) -> dict[str, Any]:
        """The external forces by name: a row for each frame, see ``WRENCH``."""
        wrenches = self.frames["SWr"]
        return {name: wrenches[:, number, 1:] for name, number in self.data.extforce_id.items()}

    def sensor(self, name: str) -> MbsSensor:
        """Return a sensor whose members have a row for each frame.

        Returns:
            P, V, OM, A, OMP (frames, 3) and R (frames, 3, 3), in the axes of the base.
        """
        sensor, number = MbsSensor(self.data), self.data.sensor_id[name]
        members = ("P", "V", "OM", "A", "OMP", "R")
        rows = []
        for _ in self._replay():
            sensor.comp_s_sensor(number)
            rows.append([getattr(sensor, member).copy() for member in members])
        for member, frames in zip(members, zip(*rows, strict=True), strict=True):
            values = np.array(frames)
            setattr(sensor, member, values[:, 1:, 1:] if member == "R" else values[:, 1:])
        return sensor

    def energy(self) -> Any:
        """Compute the kinetic energy, and that of gravity, which is 0 at the base's origin.

        Returns:
            (frames, 2), J.
        """
        energies = np.zeros((len(self.time), 3))
        for k in self._replay():
            self.data.mbs_energy(energies[k], self.data)
        return energies[:, 1:]

    def _replay(self) -> Iterator[int]:
        """Yield the index of each frame while the data have its state."""
        data = self.data
        saved = data.q.copy(), data.qd.copy(), data.qdd.copy()
        with user_code(data):
            for k in range(len(self.time)):
                data.q[1:], data.qd[1:] = self.q[k, 1:], self.qd[k, 1:]
                data.qdd[1:] = self.qdd[k, 1:]
                yield k
        data.q[:], data.qd[:], data.qdd[:] = saved

    def columns(self) -> dict[str, Any]:
        """Return all columns of the table by name: ``time``, ``q.JOINT``, ``FORCE.Fx``, ..."""
        columns = {"time": self.time}
        for name in (*ALWAYS_WRITTEN, *(["Qc"] if self.data.nqc else [])):
            for joint, number in self.data.joint_id.items():
                columns[f"{name}.{joint}"] = self.frames[name][:, number]
        for joint, number in self.data.joint_id.items() if self.Qa is not None else ():
            columns[f"Qa.{joint}"] = self.Qa[:, number]
        for force, rows in self.external.items():
            for k, component in enumerate(WRENCH):
                columns[f"{force}.{component}"] = rows[:, k]
        for link, number in self.data.link_id.items():
            for name in ("Z", "Zd", "Fl"):
                columns[f"{link}.{name}"] = self.frames[name][:, number]
        energies = self.energy()
        columns |= {"energy.kinetic": energies[:, 0], "energy.potential": energies[:, 1]}
        return columns | compute_push_columns(self.data, self.time)

    def story(self) -> Story | None:
        """Return whether a robot that stood has fallen, when and in which direction.

        Returns:
            None for a model that does not stand on the ground at the start.
        """
        from urdf2mbs_simulate.story import summarize_motion

        return summarize_motion(self)

    def table(self) -> Any:
        """Return a pandas DataFrame of ``columns``.

        Raises:
            ConfigError: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise not_installed("a table of results", "pandas") from None
        return pd.DataFrame(self.columns())

    def _repr_html_(self) -> str:
        """Return the page that plays the motion, for a notebook."""
        from urdf2mbs_report.page import frame_page
        from urdf2mbs_simulate.project import make_motion_page

        return frame_page(make_motion_page(self))

    def write(
        self,
        name: str = "dirdyn",
        results: Path | None = None,
        animation: Path | None = None,
        *,
        force: bool = False,
    ) -> list[Path]:
        """Write Robotran's files, and a table with the names of all columns.

        Args:
            name: How the files begin: NAME_q.res and so on, NAME.csv, NAME_q.anim.
            results: The folder of the results; by default, resultsR of the project.
            animation: The folder of the .anim; by default, animationR of the project.
            force: True to replace files of another program, such as MBsysC, too.

        Returns:
            The files, the animation and the table last.

        Raises:
            ConfigError: A file of another program would be replaced.
        """
        results = results or self.data._run.project / "resultsR"
        animation = animation or self.data._run.project / "animationR"
        files = {
            results / f"{name}_{quantity}.res": format_res(rows)
            for quantity, rows in self._list_tables().items()
        }
        files[animation / f"{name}_q.anim"] = format_res(self.q)
        files[results / f"{name}.csv"] = self._format_csv()
        write_files(files, force=force)
        return list(files)

    def _list_tables(self) -> dict[str, Any]:
        """Return what Robotran writes of the model, by the ends of the files' names."""
        data = self.data
        counts = {
            **dict.fromkeys(ALWAYS_WRITTEN, 1),
            "Qc": data.nqc,
            "Lambda": data.nqv,
            "ux": data.Nux,
            "uxd": data.Nux,
            **dict.fromkeys(FILE_NAMES, data.Nlink),
        }
        tables = {
            FILE_NAMES.get(quantity, quantity): self.frames[quantity]
            for quantity, count in counts.items()
            if count
        }
        if self.Qa is not None:
            tables["Qa"] = self.Qa
        return tables | self.outputs

    def _format_csv(self) -> bytes:
        text = io.StringIO()
        columns = self.columns()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(np.column_stack(list(columns.values())).tolist())
        return text.getvalue().encode()


def check_results(project: Path, name: str = "dirdyn") -> None:
    """Check that a run will replace results of urdf2mbs only.

    Raises:
        ConfigError: Results of another program would be replaced.
    """
    paths = [project / "resultsR" / f"{name}_{quantity}.res" for quantity in ALWAYS_WRITTEN]
    paths += [project / "resultsR" / f"{name}.csv", project / "animationR" / f"{name}_q.anim"]
    check_ours(dict.fromkeys(paths, b""))


def format_res(values: Any) -> bytes:
    """Return a .res file: a line for each row, with the shortest digits that are exact."""
    return "".join(" ".join(map(repr, row)) + "\n" for row in values.tolist()).encode()


class Recorder:
    """Records frames while a simulation runs."""

    def __init__(self, data: MbsData, code: CCode) -> None:
        self.data, self.code = data, code
        self.frames: dict[str, list[Any]] = {name: [] for name in ("time", *QUANTITIES)}
        data._run.outputs.clear()
        data._run.new_outputs.clear()

    def add(self, time: float, y: Any) -> None:
        """Compute the accelerations and reactions of a state, and record it."""
        with self.code.recording():
            self.code.accelerate(time, y)
        self.code.compute_reactions()
        self.record_data(time)

    def record_data(self, time: float) -> None:
        """Record what the data have as the frame of a time (s)."""
        self.data._run.store_outputs(time)
        with self.code.model_axes():
            for name in QUANTITIES:
                values = getattr(self.data, name).copy()
                if values.ndim == 1:
                    values[0] = time
                self.frames[name].append(values)
        self.frames["time"].append(time)

    def results(self) -> Results:
        """Return the frames, with what user code has given to set_output after the last one."""
        self.data._run.store_outputs(self.data.tsim)
        frames = {name: np.array(values) for name, values in self.frames.items()}
        return Results(self.data, frames, self.code.name)
