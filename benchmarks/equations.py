"""The generated equations beside Pinocchio: operations, compile time, microseconds.

    python benchmarks/equations.py [ROBOT ...]

``M`` and ``c`` of the generated C against ``crba`` plus ``nonLinearEffects`` called from C++ on
the same robot, floating, in turn in one run; of each the least of many short runs counts, so
that a busy machine does not.  Needs gcc, g++, Eigen's headers (libeigen3-dev) and ``pin``, whose
wheel brings its own.  Compiling against Pinocchio takes a minute; its library's instances of
``crba`` and ``nonLinearEffects`` are used, as its Python does.
"""

from __future__ import annotations

import ctypes
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from robots import real

from urdf2mbs.equations import Equations, equations
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.testing import convert_text

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from runtime import HEADER, TABLES, VECTORS, Data, random_state

FLAGS = {"-O2": ["-O2"], "-O3 native": ["-O3", "-march=native"]}
RUN = """
#include <time.h>
#include "mbs_data.h"
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);
double run(double **M, double *c, MbsData *s, double *q, double *qd, int n, int times)
{
    struct timespec a, b;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (int i = 0; i < times; i++) {
        s->q = q + (i % 16) * n;
        s->qd = qd + (i % 16) * n;
        mbs_dirdyna(M, c, s, 0.0);
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    return ((b.tv_sec - a.tv_sec) + 1e-9 * (b.tv_nsec - a.tv_nsec)) / times;
}
"""
ROW = ctypes.POINTER(ctypes.c_double)


def pinocchio_library(folder: Path) -> Path:
    prefix = Path(pin.__file__).parents[4]
    out = folder / "pinocchio.so"
    subprocess.run(
        ["g++", "-w", "-O2", "-DNDEBUG", "-std=c++17", "-shared", "-fPIC",
         "-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
         "-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
         f"-I{prefix}/include", "-I/usr/include/eigen3",
         str(Path(__file__).with_suffix(".cpp")), "-o", str(out),
         f"-L{prefix}/lib", "-lpinocchio_default", f"-Wl,-rpath,{prefix}/lib"],
        check=True,
    )  # fmt: skip
    return out


def described(model: pin.Model, file: Path) -> None:
    """The model as ``equations.cpp`` reads it."""
    with file.open("w") as out:
        for i in range(1, model.njoints):
            joint, pose, inertia = model.joints[i], model.jointPlacements[i], model.inertias[i]
            axis = getattr(joint.extract(), "axis", np.zeros(3))
            # a continuous joint as a plain turn, which Pinocchio does faster
            kind = joint.shortname().replace("JointModelRUB", "JointModelR")
            numbers = [*pose.rotation.ravel(), *pose.translation, *axis, inertia.mass]
            numbers += [*inertia.lever, *inertia.inertia.ravel()]
            print(model.parents[i], kind, *numbers, file=out)


def pointers(table: np.ndarray) -> Any:
    return (ROW * len(table))(*(row.ctypes.data_as(ROW) for row in table))


def compiled(made: Equations, mbs: Mbs, flags: list[str], folder: Path) -> tuple[Any, float]:
    """The library, and the seconds that the compiler took for itself."""
    folder.mkdir()
    name = f"mbs_dirdyna_{mbs.name}.c"
    (folder / "mbs_data.h").write_text(HEADER)
    (folder / "run.c").write_text(RUN)
    (folder / name).write_bytes(made.files[name])
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(
        ["gcc", *flags, "-shared", "-fPIC", "-I.", "-o", "run.so", "run.c", name, "-lm"],
        cwd=folder, check=True,
    )  # fmt: skip
    took = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    library = ctypes.CDLL(str(folder / "run.so"))
    library.run.restype = ctypes.c_double
    return library, took


def runner(library: Any, mbs: Mbs) -> Callable[[], float]:
    """Seconds for one evaluation, over sixteen random states."""

    class Struct(ctypes.Structure):
        _fields_ = [
            *((name, ROW) for name in VECTORS),
            *((name, ctypes.POINTER(ROW)) for name in TABLES),
            ("flag_stop", ctypes.c_int),
        ]

    rng, s = np.random.default_rng(0), Data(mbs)
    states = [random_state(mbs, rng) for _ in range(16)]
    q, qd = np.array([one.q for one in states]), np.array([one.qd for one in states])
    n = s.njoint + 1
    m, c, struct = np.zeros((n, n)), np.zeros(n), Struct()
    for name in VECTORS:
        setattr(struct, name, getattr(s, name).ctypes.data_as(ROW))
    for name in TABLES:
        setattr(struct, name, pointers(getattr(s, name)))
    rows = pointers(m)

    def run() -> float:
        arguments = (c.ctypes.data_as(ROW), ctypes.byref(struct), q.ctypes.data_as(ROW))
        return float(library.run(rows, *arguments, qd.ctypes.data_as(ROW), n, 100))

    run.keep = (s, m)  # type: ignore[attr-defined]
    return run


def main(names: list[str]) -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        library = pinocchio_library(folder)
        for name, text in real().items():
            if names and name not in names:
                continue
            model = pin.buildModelFromXML(text.decode(), pin.JointModelFreeFlyer())
            described(model, folder / "model.txt")
            own = folder / f"{name}.so"  # a copy each: it holds one model
            own.write_bytes(library.read_bytes())
            theirs = ctypes.CDLL(str(own))
            theirs.run.restype = ctypes.c_double
            assert theirs.load(str(folder / "model.txt").encode()) == model.nv
            data = convert_text(text.decode(), base="floating", pipeline="compact").data
            mbs = read(data, name, mechanics_only=True)
            runs: dict[str, Callable[[], float]] = {}
            told: dict[str, str] = {}
            for fold in (False, True):
                made = equations(mbs, data, name, language="c", fold=fold)
                for flag, flags in FLAGS.items():
                    label = f"{flag}{', folded' if fold else ''}"
                    built, took = compiled(made, mbs, flags, folder / f"{name} {label}")
                    runs[label] = runner(built, mbs)
                    count = made.counts["dirdyna"].operations
                    told[label] = f"{count} operations, compiled in {took:.1f} s"
            best = dict.fromkeys(runs, 1.0)
            other = 1.0
            for _ in range(400):
                other = min(other, theirs.run(100, 0), theirs.run(100, 1))
                for label, run in runs.items():
                    best[label] = min(best[label], run())
            print(f"{name}: {len(mbs.numbers())} joints; Pinocchio {1e6 * other:.2f} us")
            for label, seconds in best.items():
                ratio = seconds / other
                print(
                    f"  {label:18} {1e6 * seconds:6.2f} us, {ratio:.3f}; {told[label]}", flush=True
                )


if __name__ == "__main__":
    main(sys.argv[1:])
