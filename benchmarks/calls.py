"""Calls of equations from Python, beside pinocchio's from Python and in C++: microseconds.

    python benchmarks/calls.py [--cpp] [ROBOT.urdf ...]

Without robots: fr3 and atlas of ``../shared/robots``.  Arms, whose names are in ``FIXED``, stand on
a fixed base, all others float.  Each robot is loaded as ``load_equations(..., moving=True,
pipeline="compact")``, and called

- once, from Python;
- in C, without Python: many states into the memory of one result;
- in a batch of 1,000 states, in one call, with the memory of all results: for each state.

Pinocchio is called once from Python, and with ``--cpp`` in a loop in C++, as by ``equations.py``,
which says what this needs.  All are measured in turn, in many runs; of each, the least time of the
processor counts, so that a busy machine makes little difference.  Where joints follow others,
pinocchio gets all joints as independent ones, since it has neither ``aba`` nor derivatives of
``<mimic>``.
"""

from __future__ import annotations

import argparse
import ctypes
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from equations import BUILDS, described, pinocchio_library
from robots import ARMS, REAL, ROBOTS, without_meshes

from urdf2mbs import Robot, load_equations
from urdf2mbs_simulate.memory import CallInC, as_c_vector

#: Robots on a fixed base, by the beginning of the file's name.
FIXED = ("fr3", "fer", "panda", "ur")
N_STATES = 1000
#: States of a run in C, calls of a run in Python, and runs of each program.
N_IN_C, N_CALLS, N_RUNS = 50, 20, 300
#: Our functions: title, name in C, method; pinocchio's, and the number of its loop in C++.
FUNCTIONS: list[tuple[str, str, str, Any, int]] = [
    ("mass matrix", "mass_matrix", "mass_matrix", lambda m, d, q, v, a: pin.crba(m, d, q), 5),
    ("inverse dynamics", "inverse_dynamics", "inverse_dynamics", pin.rnea, 3),
    ("forward dynamics", "forward_dynamics", "forward_dynamics", pin.aba, 4),
    (
        "derivatives, inverse",
        "inverse_derivatives",
        "inverse_dynamics_derivatives",
        pin.computeRNEADerivatives,
        2,
    ),
    (
        "derivatives, forward",
        "forward_derivatives",
        "forward_dynamics_derivatives",
        pin.computeABADerivatives,
        6,
    ),
]


def measure(function: Callable[[], Any], times: int = 1) -> float:
    """Return the microseconds of the processor for one of ``times`` evaluations."""
    begin = time.thread_time()
    function()
    return 1e6 * (time.thread_time() - begin) / times


def make_loop(robot: Robot, name: str, states: Any) -> Callable[[], Any]:
    """Return a call of C that computes states into the memory of one result."""
    function = robot.functions.functions[name]
    call = CallInC.from_buffer_copy(function.call)
    call.n_states, call.n_numbers = N_IN_C, 0
    for k, values in enumerate(states):
        call.input[k] = as_c_vector(values)
    address = ctypes.addressof(call)
    return lambda _=call: function.entry(address)


def make_model(file: Path, *, is_fixed: bool) -> Any:
    if is_fixed:
        return pin.buildModelFromUrdf(str(file))
    return pin.buildModelFromUrdf(str(file), pin.JointModelFreeFlyer())


def load_cpp(library: Path | None, model: Any, folder: Path, name: str) -> Any:
    """Load a copy of the library, which holds one model."""
    if library is None:
        return None
    described(model, folder / "model.txt")
    copy = ctypes.CDLL(str(shutil.copy(library, folder / f"{name}.so")))
    copy.run.restype = ctypes.c_double
    assert copy.load(str(folder / "model.txt").encode()) == model.nv
    return copy


def repeat(function: Callable[[], Any]) -> None:
    """Call a function several times: one call is too short for the clock."""
    for _ in range(N_CALLS):
        function()


def compare(file: Path, folder: Path, library: Path | None) -> None:
    name = file.stem
    is_fixed = name.startswith(FIXED)
    plain = folder / f"{name}.urdf"
    plain.write_bytes(without_meshes(file))
    base = "fixed" if is_fixed else "floating"
    robot = load_equations(plain, base=base, moving=True, pipeline="compact")
    model = make_model(plain, is_fixed=is_fixed)
    data, cpp = model.createData(), load_cpp(library, model, folder, name)
    rng = np.random.default_rng(1)
    states = rng.uniform(-1, 1, (3, N_STATES, len(robot.joints)))
    pose = pin.integrate(model, pin.neutral(model), rng.uniform(-1, 1, model.nv))
    rates = rng.uniform(-1, 1, (2, model.nv))
    print(f"{name}: {len(robot.joints)} joints; pinocchio's model has {model.nv}")
    print(f"  {'':22}{'call':>8}{'in C':>8}{'batch':>8}{'pin':>8}{'in C++':>8}")
    for title, in_c, method, theirs, number in FUNCTIONS:
        call = getattr(robot, method)
        arguments = states[:1] if in_c == "mass_matrix" else states
        one = [values[0] for values in arguments]
        call(*one)
        loop = make_loop(robot, in_c, arguments)
        programs: list[Callable[[], float]] = [
            lambda call=call, one=one: measure(lambda: repeat(lambda: call(*one)), N_CALLS),
            lambda loop=loop: measure(loop, N_IN_C),
            lambda call=call, arguments=arguments: measure(lambda: call(*arguments), N_STATES),
            lambda theirs=theirs: measure(
                lambda: repeat(lambda: theirs(model, data, pose, *rates)), N_CALLS
            ),
        ]
        if cpp is not None:
            programs.append(lambda number=number: 1e6 * cpp.run(N_IN_C, number))
        best = [np.inf] * len(programs)
        for run in range(N_RUNS):
            for k, program in enumerate(programs):
                if k != 2 or run % 10 == 0:  # a batch is a long run
                    best[k] = min(best[k], program())
        print(f"  {title:22}" + "".join(f"{x:8.2f}" for x in best), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", type=Path)
    parser.add_argument("--cpp", action="store_true", help="pinocchio in C++, too")
    options = parser.parse_args()
    paths = REAL | ARMS
    robots = options.robots or [ROBOTS / paths[name] for name in ("fr3", "atlas")]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        library = pinocchio_library(folder, BUILDS["library"]) if options.cpp else None
        for file in robots:
            compare(file, folder, library)


if __name__ == "__main__":
    main()
