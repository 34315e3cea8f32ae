"""A project's C files, equations and user functions, as one library with a Runge-Kutta integrator.

What is generated runs as it is: the data and the integrator stand here in the place of MBsysC's.
"""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
from project.standin import MbsData

import urdf2mbs.runtime

HEADERS = Path(urdf2mbs.runtime.__file__).with_name("mbsysc")

RUN = """
#include <math.h>
#include <string.h>
#include "mbs_data.h"
int mbs_accelred(MbsData *s, double tsim);

static int slope(MbsData *s, double t, int n, const int *number, const double *y, double *k)
{
    for (int i = 0; i < n; i++)
        s->q[number[i]] = y[i], s->qd[number[i]] = y[n + i];
    if (mbs_accelred(s, t))
        return 1;
    for (int i = 0; i < n; i++)
        k[i] = s->qd[number[i]], k[n + i] = s->qdd[number[i]];
    return 0;
}

/* Runge-Kutta of fourth order; the number of steps done. */
int run(MbsData *s, int n, const int *number, double *y, double t, double h, int steps)
{
    double k[4][2000], z[2000];
    for (int step = 0; step < steps; step++, t += h) {
        if (slope(s, t, n, number, y, k[0]))
            return step;
        for (int i = 0; i < 2 * n; i++)
            z[i] = y[i] + h / 2 * k[0][i];
        if (slope(s, t + h / 2, n, number, z, k[1]))
            return step;
        for (int i = 0; i < 2 * n; i++)
            z[i] = y[i] + h / 2 * k[1][i];
        if (slope(s, t + h / 2, n, number, z, k[2]))
            return step;
        for (int i = 0; i < 2 * n; i++)
            z[i] = y[i] + h * k[2][i];
        if (slope(s, t + h, n, number, z, k[3]))
            return step;
        for (int i = 0; i < 2 * n; i++) {
            y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
            if (!isfinite(y[i]))
                return step;
        }
    }
    slope(s, t, n, number, y, k[0]);
    return steps;
}
"""

_double = ctypes.c_double
_row = ctypes.POINTER(_double)
_table = ctypes.POINTER(_row)


class _Parameter(ctypes.Structure):
    _fields_ = [("n_value", ctypes.c_int), ("value_list", _row)]


class _Model(ctypes.Structure):
    _fields_ = [
        ("n_parameter", ctypes.c_int),
        ("parameter_list", ctypes.POINTER(ctypes.POINTER(_Parameter))),
    ]


class _Models(ctypes.Structure):
    _fields_ = [
        ("n_user_model", ctypes.c_int),
        ("user_model_list", ctypes.POINTER(ctypes.POINTER(_Model))),
    ]


class _File(ctypes.Structure):
    _fields_ = [("user_models", ctypes.POINTER(_Models))]


class _Data(ctypes.Structure):
    _fields_ = [
        ("njoint", ctypes.c_int), ("process", ctypes.c_int), ("flag_stop", ctypes.c_int),
        *((name, _row) for name in ("q", "qd", "qdd", "q0", "Qq", "Qc", "ux", "uxd")),
        ("dpt", _row * 4), ("xfidpt", ctypes.POINTER(ctypes.c_int)),
        ("SWr", _table), ("l3DWr", _table), ("g", _double * 4), ("user_model", ctypes.c_void_p),
        ("DonePart", ctypes.c_int), ("tsim", _double),
        *((name, _row) for name in ("m", "lrod", "Z", "Zd", "Fl")),
        *((name, _table) for name in ("l", "In", "frc", "trq")),
    ]  # fmt: skip


class Compiled:
    """A project that runs in C; ``data`` is the memory that it works on."""

    def __init__(self, project: Path, *flags: str) -> None:
        (model,) = (project / "dataR").glob("*.mbs")
        self.data = data = MbsData(model)
        self.step = self._step(project)
        (project / "run.c").write_text(RUN)
        used = (
            f"mbs_{name}_*.c"
            for name in ("accelred", "dirdyna", "extforces", "link", "link3D", "cons*")
        )
        sources = [file for name in used for file in project.glob(f"symbolicR/{name}")]
        sources += [*project.glob("userfctR/*.c"), project / "run.c"]
        library = project / "run.so"
        subprocess.run(
            ["gcc", "-std=gnu99", *(flags or ("-O0",)), "-w", "-DMBS_BEFORE_2025", f"-I{HEADERS}",
             f"-I{project / 'userfctR'}", "-shared", "-fPIC", "-o", library,
             *sorted(map(str, sources)), "-lm"],
            check=True,
        )  # fmt: skip
        self.library = ctypes.CDLL(str(library))
        self.keep: list[Any] = []
        self.c = self._c()
        joints = [joint for body in data.mbs.bodies for joint in body.joints]
        self.free = [k for k, joint in enumerate(joints, 1) if joint.nature == "independent"]

    @staticmethod
    def _step(project: Path) -> float:
        (header,) = project.glob("userfctR/*_robot.h")
        (line,) = [x for x in header.read_text().splitlines() if "_TIME_STEP " in x]
        return float(line.split()[-1])

    def _c(self) -> _Data:
        data, n = self.data, self.data.njoint
        c = _Data(njoint=n)

        def vector(array: Any) -> Any:
            array = np.asarray(array)
            self.keep.append(array)
            return array.ctypes.data_as(_row)

        def table(array: Any) -> Any:
            pointers = (_row * len(array))(*(vector(array[k]) for k in range(len(array))))
            self.keep.append(pointers)
            return ctypes.cast(pointers, _table)

        for name in ("q", "qd", "qdd", "q0", "Qq", "Qc"):
            setattr(c, name, vector(getattr(data, name)))
        mass, centre, inertia = np.zeros(n + 1), np.zeros((4, n + 1)), np.zeros((10, n + 1))
        for body in data.mbs.bodies:
            last = data.body_id[body.name]
            mass[last] = body.mass or 0.0
            centre[1:, last] = body.com or (0.0, 0.0, 0.0)
            xx, xy, xz, yy, yz, zz = body.inertia or (0.0,) * 6
            inertia[1:, last] = [xx, xy, xz, xy, yy, yz, xz, yz, zz]
        c.m, c.l, c.In = vector(mass), table(centre), table(inertia)
        c.frc, c.trq = table(np.zeros((4, n + 1))), table(np.zeros((4, n + 1)))
        c.lrod = vector(
            np.array([0.0, *(x.length or 0.0 for x in data.mbs.cuts if x.kind == "rod")])
        )
        for name in ("Z", "Zd", "Fl"):
            setattr(c, name, vector(np.zeros(len(data.link_id) + 1)))
        c.dpt = (_row * 4)(*(vector(np.asarray(data.dpt)[k]) for k in range(4)))
        points = np.asarray(data.xfidpt).astype(np.int32)
        c.xfidpt = points.ctypes.data_as(ctypes.POINTER(ctypes.c_int))
        c.SWr = table(np.asarray(data.SWr))
        c.g = (_double * 4)(*np.asarray(data.g))
        self.library.mbs_new_user_model.restype = ctypes.c_void_p
        c.user_model = self.library.mbs_new_user_model()
        self.keep.append(points)
        self._load(c)
        return c

    def _load(self, c: _Data) -> None:
        """The user models of ``data.mbs``, as MBsysC loads them."""
        models = []
        for model in self.data.mbs.user_models:
            parameters = []
            for p in model.parameters:
                value = (_double * 1)(float(p.values[0]))
                parameters.append(ctypes.pointer(_Parameter(1, ctypes.cast(value, _row))))
                self.keep.append(value)
            array = (ctypes.POINTER(_Parameter) * len(parameters))(*parameters)
            models.append(ctypes.pointer(_Model(len(parameters), array)))
            self.keep += [array, parameters]
        array = (ctypes.POINTER(_Model) * len(models))(*models)
        file = _File(ctypes.pointer(_Models(len(models), array)))
        self.library.mbs_load_user_model_xml(ctypes.pointer(file), ctypes.c_void_p(c.user_model))
        self.keep += [models, array, file]

    def run(self, seconds: float, step: float, samples: int) -> Any:
        """Positions of all joints (from index 1) at the start and ``samples`` later times; rows
        are not a number from where the state is not, or no acceleration can be found."""
        data, n = self.data, len(self.free)
        np.asarray(data.q)[:] = np.asarray(data.q0)
        np.asarray(data.qd)[:] = 0.0
        for body in data.mbs.bodies:
            for joint in body.joints:
                data.qd[data.joint_id[joint.name]] = joint.qd or 0.0
        y = np.concatenate([np.asarray(data.q)[self.free], np.asarray(data.qd)[self.free]])
        numbers = (ctypes.c_int * n)(*self.free)
        per = round(seconds / samples / step)
        out = np.full((samples + 1, data.njoint + 1), np.nan)
        out[0] = np.asarray(data.q)
        for k in range(samples):
            t = k * seconds / samples
            done = self.library.run(
                ctypes.byref(self.c), n, numbers, y.ctypes.data_as(_row), _double(t),
                _double(seconds / samples / per), per,
            )  # fmt: skip
            if done < per:
                break
            out[k + 1] = np.asarray(data.q)
        return out

    def ground_force(self) -> Any:
        """The sum of all external forces at the last state (N)."""
        return np.asarray(self.data.SWr)[1:, 1:4].sum(axis=0)
