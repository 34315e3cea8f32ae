"""A simulation with nothing but generated files: ``symbolicR`` and ``userfctR``.

What Robotran's library adds is small, and stands here: the data, and a Runge-Kutta integrator.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from project.standin import MbsData, from1

SYMBOLIC = ("dirdyna", "invdyna", "accelred", "cons_hJ", "cons_jdqd", "link", "link3D", "extforces",
            "sensor", "gensensor")  # fmt: skip


class Robotran(MbsData):
    """The data of a project, with its equations and user functions under Robotran's names."""

    def __init__(self, project: Path, user: dict[str, ModuleType]) -> None:
        (model,) = (project / "dataR").glob("*.mbs")
        super().__init__(model)
        n = self.njoint
        self.m, self.l, self.In = from1(n), from1(3, n), from1(9, n)
        self.frc, self.trq = from1(3, n), from1(3, n)
        for body in self.mbs.bodies:
            last = self.body_id[body.name]
            self.m[last] = body.mass or 0.0
            self.l[1:4, last] = body.com or (0.0, 0.0, 0.0)
            xx, xy, xz, yy, yz, zz = body.inertia or (0.0,) * 6
            self.In[1:10, last] = [xx, xy, xz, xy, yy, yz, xz, yz, zz]
        rods = [cut.length or 0.0 for cut in self.mbs.cuts if cut.kind == "rod"]
        self.lrod = np.array([0.0, *rods])
        self.Z, self.Zd, self.Fl = (from1(len(self.link_id)) for _ in range(3))
        self.flag_stop = 0
        for name in SYMBOLIC:
            path = project / "symbolicR" / f"mbs_{name}_{self.mbs.name}.py"
            spec = importlib.util.spec_from_file_location(path.stem, path)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            function = "sensor" if name == "gensensor" else name
            setattr(self, f"mbs_{name}", getattr(module, function))
        self.user_DrivenJoints = user["user_DrivenJoints"].user_DrivenJoints
        self.user_JointForces = user["user_JointForces"].user_JointForces
        self.user_LinkForces = user["user_LinkForces"].user_LinkForces
        self.user_ExtForces = user["user_ExtForces"].user_ExtForces
        self.user_cons_hJ = user["user_cons_hJ"].user_cons_hJ
        self.user_cons_jdqd = user["user_cons_jdqd"].user_cons_jdqd
        joints = [joint for body in self.mbs.bodies for joint in body.joints]
        self.free = [k for k, joint in enumerate(joints, 1) if joint.nature == "independent"]

    def unchecked(self) -> None:
        """Drop the checks of all arrays: they would take most of the time."""
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                object.__setattr__(self, name, np.asarray(value))

    def accelerate(self, t: float) -> Any:
        """All joints' accelerations for q and qd of the independent ones."""
        assert self.mbs_accelred(self, t) == 0
        return self.qdd

    def run(self, seconds: float, step: float) -> Iterator[float]:
        """Runge-Kutta of fourth order; yields the time at the start and after each step."""
        free = self.free

        def slope(t: float, y: Any) -> Any:
            self.q[free], self.qd[free] = np.split(y, 2)
            self.accelerate(t)
            return np.concatenate([self.qd[free], self.qdd[free]])

        y = np.concatenate([self.q[free], self.qd[free]])
        slope(0.0, y)  # with all checks
        self.unchecked()
        for k in range(round(seconds / step)):
            t = k * step
            k1 = slope(t, y)
            yield t
            k2 = slope(t + step / 2, y + step / 2 * k1)
            k3 = slope(t + step / 2, y + step / 2 * k2)
            y = y + step / 6 * (k1 + 2 * k2 + 2 * k3 + slope(t + step, y + step * k3))
            assert np.isfinite(y).all(), f"it exploded at {t} s"
        slope(seconds, y)
        yield seconds

    def energy(self, *, kinetic: bool = False) -> float:
        """Kinetic and potential energy, or the kinetic one alone (J)."""
        m, c = np.zeros((self.njoint + 1,) * 2), np.zeros(self.njoint + 1)
        self.mbs_dirdyna(m, c, self, 0.0)
        rates = np.asarray(self.qd)
        found = 0.5 * float(rates @ m @ rates)
        for body in [] if kinetic else self.mbs.bodies:
            sensor = self.gensensor(self.body_id[body.name])
            centre = sensor.P[1:] + sensor.R[1:, 1:].T @ (body.com or np.zeros(3))
            found -= (body.mass or 0.0) * float(np.asarray(self.g)[1:] @ centre)
        return found

    def gensensor(self, joint: int) -> Any:
        """The motion of the frame behind a joint."""
        from runtime import Sensor

        sensor = Sensor(self.njoint)
        self.mbs_gensensor(sensor, self, joint)
        return sensor
