"""A small stand-in for the data that Robotran gives to user functions.

It is built from an .mbs file as Robotran numbers it.  Arrays count from 1: index 0 raises.  The
arrays that are memory of Robotran's C library cannot be rebound.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from urdf2mbs.mbs.reader import read


class From1(np.ndarray):
    """An array whose index 0 is not used, in any of its dimensions."""

    def __getitem__(self, key: Any) -> Any:
        _check(key)
        return super().__getitem__(key)

    def __setitem__(self, key: Any, value: Any) -> None:
        _check(key)
        super().__setitem__(key, value)


def _check(key: Any) -> None:
    for part in key if isinstance(key, tuple) else (key,):
        if isinstance(part, slice):
            assert part.start is not None, "a slice from index 0"
            part = part.start
        for index in part if isinstance(part, list) else [part]:
            assert int(index) > 0, f"index {index}: arrays count from 1"


def from1(*shape: int) -> Any:
    return np.zeros([n + 1 for n in shape]).view(From1)


BOUND = ("q", "qd", "qdd", "q0", "Qq", "Qc", "SWr", "dpt", "xfidpt", "g")


class MbsData:
    """Of an .mbs file; ``user_model`` is a dict of dicts of floats, as MBsysPy has it."""

    def __init__(self, path: str | Path) -> None:
        mbs = read(Path(path).read_bytes(), str(path))
        self.mbs = mbs
        joints = [joint for body in mbs.bodies for joint in body.joints]
        n = self.njoint = len(joints)
        numbers = mbs.numbers()
        self.joint_id = numbers
        self.body_id = {body.name: numbers[body.joints[-1].name] for body in mbs.bodies}
        self.points_id: dict[str, dict[str, int]] = {}
        self.extforce_id: dict[str, int] = {}
        self.sensor_id: dict[str, int] = {}
        self.sensor_at: dict[int, tuple[str, Any]] = {}
        coordinates = []
        points = []
        for owner, listed in [("base", mbs.base.points)] + [(b.name, b.points) for b in mbs.bodies]:
            for point in listed:
                coordinates.append(point.coordinates)
                self.points_id.setdefault(owner, {})[point.name] = len(coordinates)
                if point.extforce is not None:
                    points.append((len(coordinates), owner, point))
                    self.extforce_id[point.extforce.name] = len(points)
                if point.sensor is not None:
                    self.sensor_id[point.sensor.name] = len(self.sensor_id) + 1
                    self.sensor_at[len(self.sensor_id)] = (owner, point)
        self.forces = points
        self.link_id = {link.name: k for k, link in enumerate(mbs.links, start=1)}
        self.user_model = {
            model.name: {p.name: float(p.values[0]) for p in model.parameters}
            for model in mbs.user_models
        }
        self.constraints: int | None = None
        self.flag_stop, self.tsim, self.DonePart, self.nqv = 0, 0.0, 1, 1
        for name in ("q", "qd", "qdd", "q0", "Qq", "Qc"):
            setattr(self, name, from1(n))
        self.SWr = from1(len(points), 9)
        self.dpt = from1(3, len(coordinates))
        self.xfidpt = np.array([0, *(k for k, _, _ in points)]).view(From1)
        self.g = from1(3)
        self.g[1:4] = mbs.base.gravity
        for k, (x, y, z) in enumerate(coordinates, start=1):
            self.dpt[1:4, k] = (x, y, z)
        for k, joint in enumerate(joints, start=1):
            self.q[k] = self.q0[k] = joint.q or 0.0
            self.qd[k] = joint.qd or 0.0
        self._bound = True

    def __setattr__(self, name: str, value: Any) -> None:
        if name in BOUND and hasattr(self, "_bound"):
            raise AssertionError(f"mbs_data.{name} is rebound: what it was is lost for Robotran")
        super().__setattr__(name, value)

    def set_nb_userc(self, count: int) -> None:
        self.constraints = count


@contextmanager
def user_functions(project: Path) -> Iterator[dict[str, ModuleType]]:
    """The modules in a project's userfctR, each loaded from its file as Robotran may do it; the
    folder is not on Python's path, and nothing stays there afterwards."""
    path, known = list(sys.path), set(sys.modules)
    loaded: dict[str, ModuleType] = {}
    try:
        for file in sorted((project / "userfctR").glob("user_*.py")):
            spec = importlib.util.spec_from_file_location(file.stem, file)
            assert spec is not None
            assert spec.loader is not None
            loaded[file.stem] = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(loaded[file.stem])
        yield loaded
    finally:
        sys.path[:] = path
        for name in set(sys.modules) - known:
            if name.endswith("_robot"):
                del sys.modules[name]


def without_meshes(name: str) -> list[str]:
    """A preset's passes but the one that takes long."""
    from making import passes_of

    return [one for one in passes_of(name) if one != "convert-meshes"]


def make(folder: Path, source: Path | str, name: str = "robot", **settings: Any) -> Path:
    """Convert a robot (its file, or its text) into a project; returns the project's folder."""
    from urdf2mbs.disk.output import write
    from urdf2mbs.engine.config import Config, Lines, typed
    from urdf2mbs.engine.pipeline import Pipeline

    if isinstance(source, str):
        file = folder / "source.urdf"
        file.write_text(source, "utf-8")
        source = file
    language = settings.pop("language", "python")
    output = {"project": str(folder / name), "language": language}
    given = {"source": str(source), "output": output, **settings}
    conversion = Pipeline(typed(Config, given, Lines()), Lines(), installed_plugins=False).run()
    write(conversion)
    assert conversion.rejected is None
    return folder / name
