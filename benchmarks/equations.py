"""The generated equations beside Pinocchio: operations, compile time, microseconds.

    python benchmarks/equations.py [--counts] [--arms] [--generation] [--pairs] [--speed]
                                   [--derivatives] [ROBOT ...]

Without options all: the operations of every robot of ``../shared/robots``, and of three arms, as
in ``docs/how-equations-are-made.md``; how long the equations take to generate, which needs nothing
else; what pairs gain; how fast they are, and how fast their derivatives.  ROBOT is a name, or for
the speed a URDF: those of rbd-benchmarks are
``description/urdf/simplified/{iiwa,hyq,atlas}.urdf`` there.

For the speed, ``M`` and ``c`` of the generated C stand against ``crba`` plus ``nonLinearEffects``,
``invdyna`` against ``rnea``, ``accelred`` against ``aba``, and the three tables of ``derivatives``
against ``computeRNEADerivatives``, called from C++ on the same robot, arms fixed and all others
floating, in turn in one run; of each the least of many short runs counts, so that a busy machine
does not. Needs gcc, g++, Eigen's headers (libeigen3-dev, or cmeel-eigen beside ``pin``), ``pin``,
whose wheel brings its own headers, and for derivatives ``casadi``. Pinocchio is its library's
instances, which its Python uses too; with ``--headers`` also compiled here, with ``-O3
-march=native``, which takes minutes.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.util
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pinocchio as pin
from robots import ARMS, DH, REAL, by_dh, real, without_meshes

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import convert_text
from urdf2mbs_equations.contents import ContentMaker
from urdf2mbs_equations.files import Equations, generate
from urdf2mbs_equations.options import EquationOptions
from urdf2mbs_equations.routine import make_statements
from urdf2mbs_equations.tree import Tree
from urdf2mbs_equations.vectors import ZERO_SPATIAL

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))
from support.oracle.generated import HEADER, TABLES, VECTORS, Data, random_state

TESTS = Path(__file__).resolve().parents[1] / "tests"
FLAGS = {"-O2": ["-O2"], "-O3 native": ["-O3", "-march=native"]}
RUN = """
#include <time.h>
#include "mbs_data.h"
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);
void mbs_derivatives(double **A, double **B, double **M, MbsData *s);
void mbs_invdyna(double *phi, MbsData *s, double tsim);
int mbs_accelred(MbsData *s, double tsim);
void user_call_DrivenJoints(MbsData *s, double tsim) { }
double *user_call_JointForces(MbsData *s, double tsim) { return s->Qq; }
double run(double **M, double **A, double **B, double *c, MbsData *s, double *q, double *qd,
           double *qdd, int n, int times)
{
    struct timespec a, b;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (int i = 0; i < times; i++) {
        s->q = q + (i % 16) * n;
        s->qd = qd + (i % 16) * n;
        s->qdd = qdd + (i % 16) * n;
        CALL;
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    return ((b.tv_sec - a.tv_sec) + 1e-9 * (b.tv_nsec - a.tv_nsec)) / times;
}
"""
ROW = ctypes.POINTER(ctypes.c_double)


#: What is timed.
CALLS = {
    "dirdyna": "mbs_dirdyna(M, c, s, 0.0)",
    "invdyna": "mbs_invdyna(c, s, 0.0)",
    "accelred": "mbs_accelred(s, 0.0)",
    "derivatives": "mbs_derivatives(A, B, M, s)",
}
#: What Pinocchio does instead, as ``equations.cpp`` numbers it.
WAYS = {"dirdyna": (0, 1), "derivatives": (2,), "invdyna": (3,), "accelred": (4,)}

#: CasADi's C function as one of ours.
CASADI = """
#include "mbs_data.h"
int theirs(const double **arg, double **res, long long *iw, double *w, int mem);
void mbs_derivatives(double **A, double **B, double **M, MbsData *s)
{
    static double out[3][SIZE], w[WORK];
    const double *arg[] = {s->q + 1, s->qd + 1, s->qdd + 1};
    double *res[] = {out[0], out[1], out[2]};
    theirs(arg, res, 0, w, 0);
}
"""

#: Pinocchio: its library, and its headers compiled here.
BUILDS = {
    "library": ["-O2", "-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION"],
    "headers": ["-O3", "-march=native"],
}


def pinocchio_library(folder: Path, flags: list[str]) -> Path:
    prefix = Path(pin.__file__).parents[4]
    out = folder / f"pinocchio{len(list(folder.glob('pinocchio*.so')))}.so"
    subprocess.run(
        ["g++", "-w", *flags, "-DNDEBUG", "-std=c++17", "-shared", "-fPIC",
         "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
         "-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
         f"-I{prefix}/include", f"-I{prefix}/include/eigen3", "-I/usr/include/eigen3",
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


def compiled(made: Equations, function: str, flags: list[str], folder: Path) -> tuple[Any, float]:
    """The library, and the seconds that the compiler took for itself."""
    folder.mkdir()
    ((name, text),) = made.files.items()
    (folder / "mbs_data.h").write_text(HEADER)
    (folder / "run.c").write_text(RUN)
    (folder / name).write_bytes(text)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(
        ["gcc", *flags, f"-DCALL={CALLS[function]}", "-shared", "-fPIC", "-I.", "-o", "run.so",
         "run.c", name, "-lm"],
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
    drawn = [random_state(mbs, rng) for _ in range(16)]
    states = [np.array([getattr(one, name) for one in drawn]) for name in ("q", "qd", "qdd")]
    n = s.njoint + 1
    tables, c, struct = np.zeros((3, n, n)), np.zeros(n), Struct()
    for name in VECTORS:
        setattr(struct, name, getattr(s, name).ctypes.data_as(ROW))
    for name in TABLES:
        setattr(struct, name, pointers(getattr(s, name)))
    given = [*map(pointers, tables), c.ctypes.data_as(ROW), ctypes.byref(struct)]
    given += [array.ctypes.data_as(ROW) for array in states]

    def run() -> float:
        return float(library.run(*given, n, 100))

    run.keep = (s, tables, c, states)  # type: ignore[attr-defined]
    return run


def speed(
    names: list[str], functions: tuple[str, ...] = ("dirdyna", "invdyna", "accelred")
) -> None:
    """Microseconds of mass matrix and bias, of inverse and of forward dynamics, beside
    Pinocchio."""
    given = {Path(name).stem: Path(name) for name in names if name.endswith(".urdf")}
    robots = real(REAL | ARMS) | {name: without_meshes(path) for name, path in given.items()}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        libraries = {
            build: pinocchio_library(folder, flags).read_bytes()
            for build, flags in BUILDS.items()
            if build == "library" or "--headers" in sys.argv
        }
        for name, text in robots.items():
            for function in functions if not names or name in {*names, *given} else ():
                _one(name, text.decode(), function, libraries, folder)


def derivatives(names: list[str]) -> None:
    """Microseconds of the derivatives of the joint forces, beside Pinocchio and CasADi."""
    speed(names, ("derivatives",))


def casadis(data: bytes, folder: Path) -> tuple[Equations, int]:
    """CasADi's derivatives of our inverse dynamics, whose constants are numbers, and how many
    operations they are."""
    import casadi as cs

    from urdf2mbs import load_equations

    folder.mkdir()
    (folder / "robot.mbs").write_bytes(data)
    robot = load_equations(folder / "robot.mbs", math=cs)
    n = len(robot.joints)
    q, qd, qdd = (cs.SX.sym(name, n) for name in ("q", "qd", "qdd"))
    tau = cs.vertcat(*robot.inverse_dynamics(q, qd, qdd))
    tables = [cs.jacobian(tau, x) for x in (q, qd, qdd)]
    function = cs.Function("theirs", [q, qd, qdd], tables, {"cse": True})
    no_work = (cs.OP_INPUT, cs.OP_OUTPUT, cs.OP_CONST)
    kinds = [function.instruction_id(i) for i in range(function.n_instructions())]
    cwd = Path.cwd()
    os.chdir(folder)
    function.generate("theirs.c")
    os.chdir(cwd)
    shim = CASADI.replace("SIZE", str(n * n)).replace("WORK", str(function.sz_w()))
    text = f"{shim}\n{(folder / 'theirs.c').read_text()}"
    return Equations({"theirs.c": text.encode()}), sum(kind not in no_work for kind in kinds)


def _one(name: str, text: str, function: str, libraries: dict[str, bytes], folder: Path) -> None:
    base = "fixed" if name in {*ARMS, "iiwa"} else "floating"
    if base == "fixed":
        model = pin.buildModelFromXML(text)
    else:
        model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    described(model, folder / "model.txt")
    theirs: dict[str, Any] = {}
    for number, (build, library) in enumerate(libraries.items()):
        own = folder / f"{name}{function}{number}.so"  # a copy each: it holds one model
        own.write_bytes(library)
        theirs[build] = ctypes.CDLL(str(own))
        theirs[build].run.restype = ctypes.c_double
        assert theirs[build].load(str(folder / "model.txt").encode()) == model.nv
    # the quarter turns of rbd-benchmarks' iiwa have 12 digits
    options = {"snap": {"angle": 1e-9}} if "--snap" in sys.argv else {}
    data = convert_text(text, base=base, pipeline="compact", passes=options).data
    mbs = read_mbs(data, name, mechanics_only=True)
    runs: dict[str, Callable[[], float]] = {}
    told: dict[str, str] = {}
    for fold in (False, True):
        made = generate(mbs, data, name, EquationOptions(language="c", fold=fold), [function])
        for flag, flags in FLAGS.items():
            label = f"{flag}{', folded' if fold else ''}"
            built, took = compiled(made, function, flags, folder / f"{name} {function} {label}")
            runs[label] = runner(built, mbs)
            count = made.counts[function].operations
            told[label] = f"{count} operations, compiled in {took:.1f} s"
    if function == "derivatives":
        made, count = casadis(data, folder / f"{name} CasADi")
        for flag, flags in FLAGS.items():
            label = f"{flag}, CasADi"
            built, took = compiled(made, function, flags, folder / f"{name} {function} {label}")
            runs[label] = runner(built, mbs)
            told[label] = f"{count} operations, compiled in {took:.1f} s"
    best = dict.fromkeys(runs, 1.0)
    others = dict.fromkeys(theirs, 1.0)
    for _ in range(400):
        for build, other in theirs.items():
            others[build] = min(
                others[build], *(other.run(100, way) for way in WAYS[function]), 1.0
            )
        for label, run in runs.items():
            best[label] = min(best[label], run())
    print(f"{name}, {function}: {len(mbs.numbers())} joints")
    for build, seconds in others.items():
        print(f"  Pinocchio, {build:18} {1e6 * seconds:6.2f} us")
    for label, seconds in best.items():
        ratios = ", ".join(f"{seconds / other:.3f}" for other in others.values())
        print(f"  {label:29} {1e6 * seconds:6.2f} us, {ratios}; {told[label]}", flush=True)


def generation(names: list[str]) -> None:
    """Seconds of this process for all ten files; the least of several."""
    for name, text in real().items():
        if names and name not in names:
            continue
        data = convert_text(text.decode(), base="floating", pipeline="compact").data
        for language in ("python", "c"):
            best, size = 9.0, 0
            for _ in range(7):
                begun = time.process_time()
                mbs = read_mbs(data, name, mechanics_only=True)
                made = generate(mbs, data, name, EquationOptions(language=language))
                best = min(best, time.process_time() - begun)
                size = sum(len(file) for file in made.files.values())
            print(
                f"{name}, {language}: {best:.2f} s for {size / 1e6:.2f} MB, "
                f"{best / size * 1e6:.2f} s for each MB", flush=True,
            )  # fmt: skip


def pairs(names: list[str]) -> None:
    """Microseconds of mass matrix and bias in C with mirrored limbs in pairs, and without."""
    with tempfile.TemporaryDirectory() as temporary:
        for name, text in real().items():
            if names and name not in names:
                continue
            data = convert_text(text.decode(), base="floating", pipeline="compact").data
            mbs = read_mbs(data, name, mechanics_only=True)
            runs = []
            for paired in (True, False):
                made = generate(
                    mbs, data, name, EquationOptions(language="c", pairs=paired), ["dirdyna"]
                )
                folder = Path(temporary) / f"{name}{paired}"
                runs.append(runner(compiled(made, "dirdyna", FLAGS["-O2"], folder)[0], mbs))
            best = [1.0, 1.0]
            for _ in range(400):
                best = [min(seconds, run()) for seconds, run in zip(best, runs, strict=True)]
            told = " us, ".join(f"{1e6 * seconds:.2f}" for seconds in best)
            print(f"{name}: {told} us without pairs, {best[1] / best[0]:.2f} times", flush=True)


def counts(names: list[str]) -> None:
    """Operations of each robot, as the table of ``docs/how-equations-are-made.md`` has them."""
    spec = importlib.util.spec_from_file_location("robots_of_tests", TESTS / "robots.py")
    assert spec is not None
    assert spec.loader is not None
    tests = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tests)
    rows: dict[str, list[str]] = {}
    for param in tests.CONVERTIBLE:
        robot = param.values[0]
        if names and robot.name not in names:
            continue
        row = ""
        for preset in ("compact", "faithful"):
            mbs = read_mbs(robot.convert(pipeline=preset).data, robot.name, mechanics_only=True)
            if not mbs.numbers():
                break
            row += f" {len(mbs.numbers())} |"
            for fold in (False, True):
                maker = ContentMaker(mbs, fold=fold)
                for made in (maker.make_dirdyna(), maker.make_invdyna()):
                    count = make_statements(made)[1]
                    row += f" {count.operations - count.signs} |"
        if row:
            rows.setdefault(row, []).append(robot.name)
    for row, robots in rows.items():
        print(f"| {', '.join(robots)} |{row}", flush=True)


def arms(names: list[str]) -> None:
    """Products and sums of three arms, as the table of ``docs/how-equations-are-made.md``: with
    ``frc`` and ``trq`` on all bodies, and without."""
    for name in [arm for arm in DH if not names or arm in names]:
        data = convert_text(by_dh(name), base="fixed", pipeline="compact").data
        mbs = read_mbs(data, name, mechanics_only=True)
        forces, no_forces = Tree.get_external_force, lambda *_: ZERO_SPATIAL
        for fold, loads in product((False, True), (forces, no_forces)):
            maker = ContentMaker(mbs, fold=fold)
            with patch.object(Tree, "get_external_force", loads):
                count = make_statements(maker.make_invdyna())[1]
            told = f"{', folded' if fold else ''}{'' if loads is forces else ', no loads'}"
            print(f"{name}{told}: {count.products} products + {count.sums} sums")


PARTS = (counts, arms, generation, pairs, speed, derivatives)

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    for part in PARTS:
        parser.add_argument(f"--{part.__name__}", action="store_true", help=part.__doc__)
    parser.add_argument("--headers", action="store_true", help="compile Pinocchio here, too")
    parser.add_argument("--snap", action="store_true", help="with the pass snap, angle 1e-9")
    parser.add_argument("robots", nargs="*", help="only these")
    arguments = parser.parse_args()
    asked = [one for one in PARTS if getattr(arguments, one.__name__)]
    for part in asked or PARTS:
        part(arguments.robots)
