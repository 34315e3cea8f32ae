"""What a simulation gives: arrays, a table, and Robotran's files."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf2mbs.plugin import check_ours, not_installed, write_files
from urdf2mbs_simulate.data import MbsData, MbsSensor
from urdf2mbs_simulate.push import columns_of_pushes
from urdf2mbs_simulate.python_code import loaded

if TYPE_CHECKING:
    from urdf2mbs_simulate.c_code import CCode
    from urdf2mbs_simulate.story import Story

#: What is kept of each frame, as MbsData and Robotran's files call it.
KEPT = ("q", "qd", "qdd", "Qq", "Qc", "Lambda", "ux", "uxd", "Z", "Zd", "Fl", "SWr")
#: The names of Robotran's files where they are others.
FILES = {"Z": "linkZ", "Zd": "linkZD", "Fl": "linkF"}
#: What comes at all times, whatever the model.
ALWAYS = ("q", "qd", "qdd", "Qq")
#: The parts of an external force: N and N m in the axes of the base, and the point (m) where it
#: acts, in those of the body.
WRENCH = ("Fx", "Fy", "Fz", "Mx", "My", "Mz", "dx", "dy", "dz")


class Results:
    """The frames of a simulation.

    ``q``, ``qd``, ``qdd``, ``Qq``, ``Qc``: a row for each frame; column 0 is the time (s), and a
    joint's column is its number, as in Robotran's results (rad, m, N m, N).  ``ux``: the user
    states, by their numbers.
    """

    def __init__(self, data: MbsData, rows: dict[str, Any], language: str) -> None:
        self.data, self.language = data, language
        self.time = rows["time"]
        self.kept = {name: rows[name] for name in KEPT}
        self.q, self.qd, self.qdd, self.Qq, self.Qc = (
            self.kept[name] for name in ("q", "qd", "qdd", "Qq", "Qc")
        )
        self.ux = self.kept["ux"]
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
        self.keep: Any = None
        """A folder that is removed with the results."""

    def joint(self, name: str) -> Any:
        """The positions of a joint (rad or m)."""
        return self.q[:, self.data.joint_id[name]]

    @property
    def external(self) -> dict[str, Any]:
        """By the name of an external force: a row for each frame, see ``WRENCH``."""
        return {
            name: self.kept["SWr"][:, number, 1:] for name, number in self.data.extforce_id.items()
        }

    def sensor(self, name: str) -> MbsSensor:
        """A sensor's P, V, OM, A, OMP (frames, 3) and R (frames, 3, 3), in the axes of the base."""
        sensor, number = MbsSensor(self.data), self.data.sensor_id[name]
        parts = ("P", "V", "OM", "A", "OMP", "R")
        found = []
        for _ in self._replayed():
            sensor.comp_s_sensor(number)
            found.append([getattr(sensor, part).copy() for part in parts])
        for part, frames in zip(parts, zip(*found, strict=True), strict=True):
            values = np.array(frames)
            setattr(sensor, part, values[:, 1:, 1:] if part == "R" else values[:, 1:])
        return sensor

    def energy(self) -> Any:
        """Kinetic energy, and that of gravity, which is 0 at the base's origin: (frames, 2), J."""
        found = np.zeros((len(self.time), 3))
        for k in self._replayed():
            self.data.mbs_energy(found[k], self.data)
        return found[:, 1:]

    def _replayed(self) -> Iterator[int]:
        """The frames, each one put into ``data`` while it is out."""
        data = self.data
        saved = data.q.copy(), data.qd.copy(), data.qdd.copy()
        with loaded(data):
            for k in range(len(self.time)):
                data.q[1:], data.qd[1:] = self.q[k, 1:], self.qd[k, 1:]
                data.qdd[1:] = self.qdd[k, 1:]
                yield k
        data.q[:], data.qd[:], data.qdd[:] = saved

    def columns(self) -> dict[str, Any]:
        """All that is known of each frame by its name: ``time``, ``q.JOINT``, ``FORCE.Fx``, ..."""
        found = {"time": self.time}
        for name in (*ALWAYS, *(["Qc"] if self.data.nqc else [])):
            for joint, number in self.data.joint_id.items():
                found[f"{name}.{joint}"] = self.kept[name][:, number]
        for joint, number in self.data.joint_id.items() if self.Qa is not None else ():
            found[f"Qa.{joint}"] = self.Qa[:, number]
        for force, rows in self.external.items():
            for k, part in enumerate(WRENCH):
                found[f"{force}.{part}"] = rows[:, k]
        for link, number in self.data.link_id.items():
            for name in ("Z", "Zd", "Fl"):
                found[f"{link}.{name}"] = self.kept[name][:, number]
        energies = self.energy()
        found |= {"energy.kinetic": energies[:, 0], "energy.potential": energies[:, 1]}
        return found | columns_of_pushes(self.data, self.time)

    def story(self) -> Story | None:
        """If a robot that stood has fallen, when, and which way; None of others."""
        from urdf2mbs_simulate.story import tell

        return tell(self)

    def table(self) -> Any:
        """A pandas DataFrame of ``columns``."""
        try:
            import pandas as pd
        except ImportError:
            raise not_installed("a table of results", "pandas") from None
        return pd.DataFrame(self.columns())

    def write(
        self,
        name: str = "dirdyn",
        results: Path | None = None,
        animation: Path | None = None,
        *,
        force: bool = False,
    ) -> list[Path]:
        """Write Robotran's files, NAME_q.res and so on, NAME.csv with the names of all columns,
        and the animation NAME_q.anim; into resultsR and animationR of the project by itself.

        Results that urdf2mbs wrote before are replaced; with ``force`` also those of another
        program, such as MBsysC.  Else raises ConfigError.
        """
        data = self.data
        results = results or data._run.project / "resultsR"
        animation = animation or data._run.project / "animationR"
        used = {
            **dict.fromkeys(ALWAYS, 1), "Qc": data.nqc, "Lambda": data.nqv, "ux": data.Nux,
            "uxd": data.Nux, **dict.fromkeys(FILES, data.Nlink),
        }  # fmt: skip
        files = {
            results / f"{name}_{FILES.get(kind, kind)}.res": res_rows(self.kept[kind])
            for kind, count in used.items()
            if count
        }
        if self.Qa is not None:
            files[results / f"{name}_Qa.res"] = res_rows(self.Qa)
        files |= {
            results / f"{name}_{output}.res": res_rows(values)
            for output, values in self.outputs.items()
        }
        files[animation / f"{name}_q.anim"] = res_rows(self.q)
        text = io.StringIO()
        columns = self.columns()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(np.column_stack(list(columns.values())).tolist())
        files[results / f"{name}.csv"] = text.getvalue().encode()
        write_files(files, force=force)
        return list(files)


def check_results(project: Path, name: str = "dirdyn") -> None:
    """Raise ConfigError if results of another program are where those of a run will go."""
    paths = [project / "resultsR" / f"{name}_{kind}.res" for kind in ALWAYS]
    paths += [project / "resultsR" / f"{name}.csv", project / "animationR" / f"{name}_q.anim"]
    check_ours(dict.fromkeys(paths, b""))


def res_rows(values: Any) -> bytes:
    """The lines of a .res file."""
    return "".join(" ".join(map(repr, row)) + "\n" for row in values.tolist()).encode()


class Recorder:
    """Keeps frames while a simulation runs."""

    def __init__(self, data: MbsData, code: CCode) -> None:
        self.data, self.code = data, code
        self.frames: dict[str, list[Any]] = {name: [] for name in ("time", *KEPT)}
        data._run.outputs.clear()
        data._run.new_outputs.clear()

    def add(self, time: float, y: Any) -> None:
        """Compute a state, and keep it."""
        with self.code.recording():
            self.code.accelerate(time, y)
        self.code.react()
        self.keep(time)

    def keep(self, time: float) -> None:
        """Keep what the data have."""
        self.data._run.keep_outputs(time)
        with self.code.model_axes():
            for name in KEPT:
                values = getattr(self.data, name).copy()
                if values.ndim == 1:
                    values[0] = time
                self.frames[name].append(values)
        self.frames["time"].append(time)

    def results(self) -> Results:
        """Return the frames, with what user code has given after the last one."""
        self.data._run.keep_outputs(self.data.tsim)
        rows = {name: np.array(values) for name, values in self.frames.items()}
        return Results(self.data, rows, self.code.name)
