"""A project's code, as the proof calls it: its user functions and equations, in Python or in C.

The files are those in memory, put into a temporary folder; a user function there is as urdf2mbs
writes it, so that nothing runs here that somebody has edited.
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.runtime.c_code import CCode
from urdf2mbs.runtime.data import MbsData, MbsSensor
from urdf2mbs.runtime.python_code import PythonCode, load, loaded
from urdf2mbs.runtime.robot import SensorInC, row

_MOTION = ("P", "V", "A", "OM", "OMP")


class InPython:
    """Python's functions.  ``laws.case.Code`` says what each gives."""

    language = "Python"

    def __init__(self, data: MbsData) -> None:
        self.data, self.start = data, data.q0
        name = f"mbs_accelred_{data.mbs_name}"
        self.has_equations = any(data.symbolic_path.glob(f"{name}.{self.suffix}"))
        self.robot = self._load()

    suffix = "py"

    def _load(self) -> Any:
        self.code = PythonCode(self.data)
        return load(self.data.user_path / f"{self.data.mbs_name}_robot.py")

    def set(self, model: str, name: str, value: float) -> None:
        self.data.user_model[model][name] = value

    def get(self, model: str, name: str) -> float | None:
        value = self.data.user_model.get(model, {}).get(name)
        return value if isinstance(value, float) else None

    def _move(self, q: Any, qd: Any, qdd: Any = 0.0) -> None:
        data = self.data
        data.q[:], data.qd[:], data.qdd[:] = q, qd, qdd

    def joint_forces(self, q: Any, qd: Any) -> Any:
        self._move(q, qd)
        self.data.Qq[:] = 1e3  # what was there before must not count
        self._joint_forces()
        return np.array([0.0, *self.data.Qq[1:]])

    def _joint_forces(self) -> None:
        self.data.user_JointForces(self.data, 0.0)

    def external(self, force: str, at: Any, speed: Any, time: float) -> Any:
        given = np.array([0.0, *at]), np.eye(4), np.array([0.0, *speed]), *np.zeros((3, 4))
        return np.array(self._external(given, time, self.data.extforce_id[force]))

    def _external(self, given: Any, time: float, number: int) -> Any:
        return self.data.user_ExtForces(*given, self.data, time, number)[1:10]

    def spring(self, link: str, length: float, rate: float) -> float:
        return float(self._spring(length, rate, self.data.link_id[link]))

    def _spring(self, length: float, rate: float, number: int) -> float:
        return float(self.data.user_LinkForces(length, rate, self.data, 0.0, number))

    def constraints(self, q: Any, qd: Any) -> tuple[Any, Any, Any]:
        self._move(q, qd)
        count = self.code.rows[1]
        h, rest = np.ones((2, count + 1))
        jacobian = np.zeros((count + 1, self.data.njoint + 1))
        if count:
            self._constraints(h, jacobian, rest)
        return h[1:], jacobian[1:], rest[1:]

    def _constraints(self, h: Any, jacobian: Any, rest: Any) -> None:
        self.data.user_cons_hJ(h, jacobian, self.data, 0.0)
        self.data.user_cons_jdqd(rest, self.data)

    def follow(self, q: Any, qd: Any, qdd: Any) -> tuple[Any, Any, Any]:
        self._move(q, qd, qdd)
        self._follow()
        return self.data.q.copy(), self.data.qd.copy(), self.data.qdd.copy()

    def _follow(self) -> None:
        self.data.user_DrivenJoints(self.data, 0.0)

    def imu(self, name: str, point: str, at: Any) -> Any:
        def fill(sensor: MbsSensor, *_: Any) -> None:
            for key, value in zip(_MOTION, (at.at, *at[2:4], *at[5:]), strict=True):
                getattr(sensor, key)[1:] = value
            sensor.R[1:, 1:] = at.axes.T

        own = vars(self.data).pop("mbs_sensor", None)
        self.data.mbs_sensor = fill
        try:
            return np.concatenate(self.robot.imu(self.data, name))
        finally:
            del self.data.mbs_sensor
            if own is not None:
                self.data.mbs_sensor = own

    def force_torque(self, name: str, forces: Any) -> Any | None:
        self.data.Qc[:] = forces
        return np.array(self.robot.force_torque(self.data, name))

    def measure(self, point: str, q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        self._move(q, qd, qdd)
        sensor = MbsSensor(self.data)
        sensor.comp_s_sensor(self.data.sensor_id[point])
        motion = (getattr(sensor, name)[1:] for name in _MOTION)
        return *motion, sensor.R[1:, 1:], sensor.J[1:]

    def forward(self, q: Any, qd: Any) -> tuple[Any, Any, Any, Any] | None:
        self._move(q, qd)
        data = self.data
        failed = self.code.solve()
        return None if failed else tuple(np.array(a) for a in (data.q, data.qd, data.qdd, data.Qq))  # type: ignore[return-value]

    def inverse(self, q: Any, qd: Any, qdd: Any) -> Any:
        self._move(q, qd, qdd)
        return self.code.inverse()


class InC(InPython):
    """C's functions, compiled; Python's numbers."""

    language, suffix = "C", "c"

    def _load(self) -> Any:
        self.code: CCode = CCode(self.data)
        self.has_equations = self.has_equations or True
        self.library, self.at = self.code.library, self.code.at
        for name in ("user_ExtForces", f"{self.data.mbs_name}_imu"):
            getattr(self.library, name).restype = ctypes.POINTER(ctypes.c_double)
        self.library.user_LinkForces.restype = ctypes.c_double
        return None

    def set(self, model: str, name: str, value: float) -> None:
        super().set(model, name, value)
        self.code.models[:] = self.code.user_models()

    def _joint_forces(self) -> None:
        self.library.user_JointForces(self.at, ctypes.c_double(0.0))

    def _external(self, given: Any, time: float, number: int) -> Any:
        at = [row(np.ascontiguousarray(array)) for array in given]
        found = self.library.user_ExtForces(*at, self.at, ctypes.c_double(time), number)
        return found[1:10]

    def _spring(self, length: float, rate: float, number: int) -> float:
        values = map(ctypes.c_double, (length, rate))
        return float(self.library.user_LinkForces(*values, self.at, ctypes.c_double(0.0), number))

    def _constraints(self, h: Any, jacobian: Any, rest: Any) -> None:
        rows = (ctypes.POINTER(ctypes.c_double) * len(jacobian))(*map(row, jacobian))
        self.library.user_cons_hJ(row(h), rows, self.at, ctypes.c_double(0.0))
        self.library.user_cons_jdqd(row(rest), self.at)

    def _follow(self) -> None:
        self.library.user_DrivenJoints(self.at, ctypes.c_double(0.0))

    def imu(self, name: str, point: str, at: Any) -> Any:
        sensor = SensorInC()
        for key, value in zip(_MOTION, (at.at, *at[2:4], *at[5:]), strict=True):
            getattr(sensor, key)[1:4] = value
        for k in (1, 2, 3):
            sensor.R[4 * k + 1 : 4 * k + 4] = at.axes[:, k - 1]
        force, turn = np.zeros((2, 4))
        read = getattr(self.library, f"{self.data.mbs_name}_imu")
        number = self.data.sensor_id[point]
        read(ctypes.byref(sensor), number, self.at, row(force), row(turn))
        return np.concatenate([force[1:], turn[1:]])

    def force_torque(self, name: str, forces: Any) -> Any | None:
        return None  # Robotran's C has no function for it

    def measure(self, point: str, q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        raise NotImplementedError


@contextmanager
def loaded_code(
    name: str, model: bytes, files: Mapping[str, bytes], language: str
) -> Iterator[InPython]:
    """A project's code, called NAME; ``files`` by their path in the project."""
    with tempfile.TemporaryDirectory(prefix="urdf2mbs-") as folder:
        mbs = Path(folder, "dataR", f"{name}.mbs")
        for path, data in {f"dataR/{mbs.name}": model, **files}.items():
            file = Path(folder, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(data)
        data = MbsData(mbs)
        with loaded(data):
            yield (InC if language == "c" else InPython)(data)
