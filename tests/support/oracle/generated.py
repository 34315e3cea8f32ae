"""Generated equations, and a stand-in for the data of Robotran that they read, in both languages.

Written to the published description of MbsData, and sharing nothing with ``urdf2mbs``: arrays
count from 1, and a body's numbers stand at its last joint.  Python equations get the object
itself; C equations get a struct over the same memory.
"""

from __future__ import annotations

import ctypes
import runpy
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from urdf2mbs.mbs.model import Mbs
    from urdf2mbs_equations.files import Equations

    Array = NDArray[np.float64]

VECTORS = ("q", "qd", "qdd", "Qq", "m", "g", "lrod", "Z", "Zd", "Fl")
TABLES = ("l", "In", "dpt", "frc", "trq")
#: The functions that are told the time in Python; in C, the others do not look at it.
TIMED = ("dirdyna", "invdyna", "accelred", "link", "link3D", "extforces")

HEADER = f"""
#pragma once
typedef struct MbsData {{
    double {", ".join(f"*{name}" for name in VECTORS)};
    double {", ".join(f"**{name}" for name in TABLES)};
    int flag_stop;
}} MbsData;
typedef double *Row;
typedef double Table[4][4];
"""
SENSOR = """
#pragma once
typedef struct MbsSensor {
    double P[4], R[4][4], V[4], OM[4], A[4], OMP[4];
    double *J[7];
} MbsSensor;
"""
MOTION = "double *p, Table r, double *v, double *om, double *a, double *omp"
#: The user's functions in C: each calls a hook that Python sets.
USER = f"""
#include "mbs_data.h"
typedef double *(*Wrench)({MOTION}, MbsData *s, double tsim, int i);
Wrench hook_ExtForces, hook_Link3DForces;
double (*hook_LinkForces)(double z, double zd, MbsData *s, double tsim, int i);
double *user_call_ExtForces({MOTION}, MbsData *s, double tsim, int i)
{{ return hook_ExtForces(p, r, v, om, a, omp, s, tsim, i); }}
double *user_call_Link3DForces({MOTION}, MbsData *s, double tsim, int i)
{{ return hook_Link3DForces(p, r, v, om, a, omp, s, tsim, i); }}
double user_call_LinkForces(double z, double zd, MbsData *s, double tsim, int i)
{{ return hook_LinkForces(z, zd, s, tsim, i); }}
double *user_call_JointForces(MbsData *s, double tsim) {{ (void) tsim; return s->Qq; }}
void user_call_DrivenJoints(MbsData *s, double tsim) {{ (void) s, (void) tsim; }}
void (*hook_cons_hJ)(double *h, double **Jac, MbsData *s, double tsim);
void (*hook_cons_jdqd)(double *jdqd, MbsData *s, double tsim);
void user_call_cons_hJ(double *h, double **Jac, MbsData *s, double tsim)
{{ hook_cons_hJ(h, Jac, s, tsim); }}
void user_call_cons_jdqd(double *jdqd, MbsData *s, double tsim)
{{ hook_cons_jdqd(jdqd, s, tsim); }}
"""

_double = ctypes.c_double
_row = ctypes.POINTER(_double)
_data = ctypes.c_void_p
_WRENCH = ctypes.CFUNCTYPE(_data, *[_row] * 6, _data, _double, ctypes.c_int)
_SPRING = ctypes.CFUNCTYPE(_double, _double, _double, _data, _double, ctypes.c_int)
_OPENING = ctypes.CFUNCTYPE(None, _row, ctypes.POINTER(_row), _data, _double)
_REST = ctypes.CFUNCTYPE(None, _row, _data, _double)


class _CData(ctypes.Structure):
    _fields_ = [
        *((name, _row) for name in VECTORS),
        *((name, ctypes.POINTER(_row)) for name in TABLES),
        ("flag_stop", ctypes.c_int),
    ]


class _CSensor(ctypes.Structure):
    _fields_ = [
        ("P", _double * 4),
        ("R", _double * 16),
        ("V", _double * 4),
        ("OM", _double * 4),
        ("A", _double * 4),
        ("OMP", _double * 4),
        ("J", _row * 7),
    ]


class Sensor:
    def __init__(self, joints: int) -> None:
        self.P, self.V, self.OM, self.A, self.OMP = (np.zeros(4) for _ in range(5))
        self.R, self.J = np.zeros((4, 4)), np.zeros((7, joints + 1))


class Data:
    """MbsData of a model: masses and the like from the file, positions and forces zero."""

    q: Array
    qd: Array
    qdd: Array
    Qq: Array
    m: Array
    l: Array  # noqa: E741
    In: Array
    frc: Array
    trq: Array

    def __init__(self, mbs: Mbs) -> None:
        joints = [joint for body in mbs.bodies for joint in body.joints]
        n = self.njoint = len(joints)
        for name in ("q", "qd", "qdd", "Qq", "m"):
            setattr(self, name, np.zeros(n + 1))
        for name, rows in (("l", 4), ("In", 10), ("frc", 4), ("trq", 4)):
            setattr(self, name, np.zeros((rows, n + 1)))
        self.g = np.array([0.0, *mbs.base.gravity])
        self.flag_stop = 0
        number = 0
        for body in mbs.bodies:
            number += len(body.joints)
            self.m[number] = body.mass or 0.0
            self.l[1:, number] = body.com or (0.0, 0.0, 0.0)
            if body.inertia:
                xx, xy, xz, yy, yz, zz = body.inertia
                self.In[1:, number] = [xx, xy, xz, xy, yy, yz, xz, yz, zz]
        points = [*mbs.base.points, *(point for body in mbs.bodies for point in body.points)]
        self.dpt = np.zeros((4, len(points) + 1))
        for number, point in enumerate(points, start=1):
            self.dpt[1:, number] = point.coordinates
        rods = [cut.length for cut in mbs.cuts if cut.kind == "rod"]
        self.lrod = np.array([0.0, *(length or 0.0 for length in rods)])
        links = sum(link.kind == "link" for link in mbs.links)
        self.Z, self.Zd, self.Fl = (np.zeros(links + 1) for _ in range(3))
        for number, joint in enumerate(joints, start=1):
            self.q[number] = joint.q or 0.0
        self.hooks: list[Any] = []

    def user_JointForces(self, s: Data, tsim: float) -> None:  # noqa: N802
        """Nothing: the tests set Qq."""

    def user_DrivenJoints(self, s: Data, tsim: float) -> None:  # noqa: N802
        """Nothing: the tests set the driven joints."""


def _pointer(array: Array) -> Any:
    """A vector, or a table as Robotran's: rows that need not lie one after the other."""
    if array.ndim == 1:
        return array.ctypes.data_as(_row)
    rows = [_pointer(row) for row in array]
    return (_row * len(rows))(*rows)


class PythonEquations:
    """Generated Python files, as modules; ``s`` also gets them under Robotran's names."""

    def __init__(self, made: Equations, mbs: Mbs, folder: Path) -> None:
        self.mbs = mbs
        self.functions: dict[str, Callable[..., Any]] = {}
        for name in made.counts:
            file = folder / f"mbs_{name}_{mbs.name}.py"
            file.write_bytes(made.files[file.name])
            module = runpy.run_path(str(file))
            self.functions[name] = module["sensor" if name == "gensensor" else name]

    def fill(self, name: str, s: Data, *arrays: Array) -> Any:
        """Let a function fill some arrays."""
        for each, function in self.functions.items() if name == "accelred" else ():
            setattr(s, f"mbs_{each}", function)
        return self.functions[name](*arrays, s, *([0.0] if name in TIMED else []))

    def dirdyna(self, s: Data) -> tuple[Array, Array]:
        m, c = np.zeros((s.njoint + 1,) * 2), np.zeros(s.njoint + 1)
        self.fill("dirdyna", s, m, c)
        return m[1:, 1:], c[1:]

    def invdyna(self, s: Data) -> Array:
        phi = np.zeros(s.njoint + 1)
        self.fill("invdyna", s, phi)
        return phi[1:]

    def accelred(self, s: Data) -> int:
        return int(self.fill("accelred", s))

    def constraints(self, s: Data, count: int) -> tuple[Array, Array, Array]:
        (h, jdqd), jac = np.zeros((2, count + 1)), np.zeros((count + 1, s.njoint + 1))
        self.fill("cons_hJ", s, h, jac)
        self.fill("cons_jdqd", s, jdqd)
        return h[1:], jac[1:, 1:], jdqd[1:]

    def loads(self, s: Data, name: str) -> None:
        """Let ``link``, ``link3D`` or ``extforces`` add to s.frc and s.trq."""
        self.fill(name, s, s.frc, s.trq, *((s.Fl, s.Z, s.Zd) if name == "link" else ()))

    def sensor(self, s: Data, number: int, kind: str = "sensor") -> Sensor:
        sensor = Sensor(s.njoint)
        self.functions[kind](sensor, s, number)
        return sensor


class CEquations(PythonEquations):
    """Generated C files, compiled into one library."""

    def __init__(self, made: Equations, mbs: Mbs, folder: Path, *flags: str) -> None:
        self.mbs = mbs
        (folder / "mbs_data.h").write_text(HEADER)
        (folder / "mbs_sensor.h").write_text(SENSOR)
        (folder / "user.c").write_text(USER)
        for name, text in made.files.items():
            (folder / name).write_bytes(text)
        library = folder / "equations.so"
        subprocess.run(
            [
                "gcc",
                "-std=c99",
                "-Wall",
                "-Wextra",
                "-Werror",
                *(flags or ("-O0",)),
                "-shared",
                "-fPIC",
                "-I.",
                "-o",
                library.name,
                "user.c",
                *sorted(made.files),
                "-lm",
            ],
            cwd=folder,
            check=True,
        )
        self.library = ctypes.CDLL(str(library))

    def data(self, s: Data) -> _CData:
        c = _CData()
        for name in (*VECTORS, *TABLES):
            setattr(c, name, _pointer(getattr(s, name)))
        self._hook(s)
        return c

    def fill(self, name: str, s: Data, *arrays: Array) -> Any:
        data = self.data(s)
        function = getattr(self.library, f"mbs_{name}")
        return function(*map(_pointer, arrays), ctypes.byref(data), _double(0.0))

    def sensor(self, s: Data, number: int, kind: str = "sensor") -> Sensor:
        data, c, sensor = self.data(s), _CSensor(), Sensor(s.njoint)
        c.J = _pointer(sensor.J)
        function = getattr(self.library, f"mbs_{kind}")
        function(ctypes.byref(c), ctypes.byref(data), ctypes.c_int(number))
        for name in ("P", "V", "OM", "A", "OMP"):
            getattr(sensor, name)[:] = getattr(c, name)
        sensor.R[:] = np.array(c.R).reshape(4, 4)
        return sensor

    def _hook(self, s: Any) -> None:
        """Let the user's functions of C be those of ``s``; ``s.user_constraints`` is how many
        constraints there are."""
        array = np.ctypeslib.as_array

        def wrench(function: Any) -> Any:
            def call(p: Any, r: Any, v: Any, om: Any, a: Any, omp: Any, _: Any, t: float, i: int):
                p, v, om, a, omp = (array(x, (4,)) for x in (p, v, om, a, omp))
                out = function(p, array(r, (16,)).reshape(4, 4), v, om, a, omp, s, t, i)
                s.hooks.append(out)
                return out.ctypes.data

            return _WRENCH(call)

        def spring(function: Any) -> Any:
            return _SPRING(lambda z, zd, _, t, i: float(function(z, zd, s, t, i)))

        def opening(function: Any) -> Any:
            def call(h: Any, jac: Any, _: Any, t: float) -> None:
                rows = np.zeros((s.user_constraints + 1, s.njoint + 1))
                function(array(h, rows[:, 0].shape), rows, s, t)
                for i, row in enumerate(rows[1:], start=1):
                    array(jac[i], row.shape)[1:] += row[1:]

            return _OPENING(call)

        def rest(function: Any) -> Any:
            return _REST(lambda jdqd, _, t: function(array(jdqd, (s.user_constraints + 1,)), s))

        s.hooks.clear()
        kinds = {
            "ExtForces": wrench,
            "Link3DForces": wrench,
            "LinkForces": spring,
            "cons_hJ": opening,
            "cons_jdqd": rest,
        }
        for name, kind in kinds.items():
            if hasattr(s, f"user_{name}"):
                s.hooks.append(kind(getattr(s, f"user_{name}")))
                pointer = ctypes.c_void_p.in_dll(self.library, f"hook_{name}")
                pointer.value = ctypes.cast(s.hooks[-1], ctypes.c_void_p).value


def random_state(mbs: Mbs, rng: np.random.Generator, *, loads: bool = True) -> Data:
    """Random positions, rates, accelerations and forces; what never moves stands as written."""
    s = Data(mbs)
    joints = [joint for body in mbs.bodies for joint in body.joints]
    for number, joint in enumerate(joints, start=1):
        if joint.nature == "driven" and joint.symbols == ("q",):
            continue
        kept = ("q", "qd", "qdd") if joint.symbols is None else joint.symbols
        size = np.pi if joint.type[0] == "R" else 1.0
        s.q[number] = rng.uniform(-size, size) if "q" in kept else 0.0
        s.qd[number] = rng.uniform(-2.0, 2.0) if "qd" in kept else 0.0
        s.qdd[number] = rng.uniform(-2.0, 2.0) if "qdd" in kept else 0.0
    number = 0
    for body in mbs.bodies:
        number += len(body.joints)
        if loads:
            s.frc[1:, number], s.trq[1:, number] = rng.uniform(-10, 10, 3), rng.uniform(-5, 5, 3)
    return s


def error(found: Array, wanted: Array) -> float:
    """The largest deviation, relative to the largest number that was wanted."""
    size = float(np.abs(wanted).max(initial=0.0)) or 1.0
    return float(np.abs(np.asarray(found) - wanted).max(initial=0.0)) / size
