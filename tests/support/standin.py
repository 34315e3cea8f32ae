"""What tests of projects share: they make projects, and check what user functions do with data.

Arrays count from 1: index 0 raises.  The arrays that are memory of Robotran's C library cannot be
rebound.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from urdf2mbs import convert
from urdf2mbs_simulate import runtime
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.dirdyn import solve_start_state
from urdf2mbs_simulate.python_code import load_module, user_code


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


#: Memory of Robotran's C library: who binds such a name anew loses what it was.
BOUND = frozenset(["q", "qd", "qdd", "q0", "Qq", "Qc", "SWr", "dpt", "xfidpt", "g"])


class MbsData(runtime.MbsData):
    """The runtime's data with arrays that are checked."""

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        for name in BOUND:
            object.__setattr__(self, name, getattr(self, name).view(From1))
        self.DonePart = 1
        points = [(body.name, point) for body in self._run.mbs.bodies for point in body.points]
        #: The number among all points, the body and the point of each external force.
        self.forces = [
            (self.points_id[owner][point.name], owner, point)
            for owner, point in points
            if point.extforce is not None
        ]
        self.checked = True

    def __setattr__(self, name: str, value: Any) -> None:
        if name in BOUND and "checked" in vars(self):
            raise AssertionError(f"mbs_data.{name} is rebound: what it was is lost for Robotran")
        super().__setattr__(name, value)


class RungeKutta:
    """Fixed steps of the fourth order, as Robotran's: ``q``, ``qd`` and so on are in ``data``."""

    def __init__(self, code: CCode) -> None:
        self.code, self.data, self.time = code, code.data, 0.0
        assert solve_start_state(code.data, code)
        self.y = code.get_state()

    def run(self, seconds: float, step: float) -> None:
        """Advance by steps of about this length."""
        slope, count = self.code.accelerate, round(seconds / step)
        step = seconds / count
        with user_code(self.data):
            for _ in range(count):
                t, y = self.time, self.y
                k1 = slope(t, y)
                k2 = slope(t + step / 2, y + step / 2 * k1)
                k3 = slope(t + step / 2, y + step / 2 * k2)
                k4 = slope(t + step, y + step * k3)
                self.y = y + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
                self.time += step
            slope(self.time, self.y)

    def positions(self, seconds: float, step: float, samples: int) -> Any:
        """Of all joints (from index 1) at the start and at ``samples`` later times."""
        out = [self.data.q.copy()]
        for _ in range(samples):
            self.run(seconds / samples, step)
            out.append(self.data.q.copy())
        return np.array(out)


@contextmanager
def user_functions(project: Path) -> Iterator[dict[str, ModuleType]]:
    """Load the modules in a project's userfctR, each from its file, as the runtime does."""
    (model,) = project.glob("dataR/*.mbs")
    data = runtime.MbsData(model)
    with user_code(data):
        yield {file.stem: load_module(file) for file in sorted(data.user_path.glob("user_*.py"))}


def without_meshes(name: str) -> list[str]:
    """Return a preset's passes without the one that takes long."""
    from support.plugin_files import passes_of

    return [pass_name for pass_name in passes_of(name) if pass_name != "convert-meshes"]


def make(folder: Path, source: Path | str, name: str = "robot", **settings: Any) -> Path:
    """Convert a robot (its file, or its text) into a project; returns the project's folder."""
    if isinstance(source, str):
        file = folder / "source.urdf"
        file.write_text(source, "utf-8")
        source = file
    output = {"project": folder / name, "language": settings.pop("language", "python")}
    result = convert(source, output=output, **settings)
    result.write()
    assert result.conversion.checked.rejected is None
    return folder / name
