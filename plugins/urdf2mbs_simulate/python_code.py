"""A project's Python: its equations and user functions, loaded from their files."""

from __future__ import annotations

import importlib.util
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import numpy as np

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_equations.files import FUNCTIONS, OWN
from urdf2mbs_equations.python import PythonWriter
from urdf2mbs_project.code import starters
from urdf2mbs_simulate import names
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError, equations
from urdf2mbs_simulate.turn import functions_in_own_axes

Function = Callable[..., Any]

#: The difference (rad, m, and their rates) by which a derivative is taken.
NEAR = 1e-7

#: The user functions, and the files that they are in.
USER = {
    **{
        f"user_{name}": f"user_{name}"
        for name in ("JointForces", "DrivenJoints", "ExtForces", "LinkForces", "Link3DForces",
                     "cons_hJ", "cons_jdqd")
    },
    "user_derivatives": "user_Derivative",
    **{f"user_{what}_{when}": f"user_{what}" for what in ("dirdyn", "invdyn")
       for when in ("init", "loop", "finish")},
}  # fmt: skip
#: Comments, and the blanks that count for nothing.
COMMENTS = {"python": r"(?:[ \t]*(?:#[^\n]*)?\n)+", "c": r"/\*.*?\*/|//[^\n]*|\s"}
#: Modules and headers that are Robotran's, and not of MBsysPy itself, by how their names begin.
ADD_ONS = {
    "mbs_tgc": "tyres on the ground", "tgc_": "tyres on the ground", "mbs_rw": "wheels on rails",
    "mbs_car_tireGround": "tyres on the ground", "tireGroundCar": "tyres on the ground",
}  # fmt: skip
KNOWN = frozenset([*USER, *(f"mbs_{name}" for name in (*FUNCTIONS, *OWN))])


def function(data: MbsData, name: str) -> Function:
    """``mbs_X`` of the equations, or ``user_X``: what the user has not does nothing."""
    if name.startswith("mbs_"):
        name = name.removeprefix("mbs_")
        module = load(equations(data, [name], "python")[name])
        return cast(Function, getattr(module, "sensor" if name == "gensensor" else name))
    file = data.user_path / f"{USER[name]}.py"
    if not file.is_file():
        return default(data, name)
    with shown(data):
        return cast(Function, getattr(load(file), name))


def default(data: MbsData, name: str) -> Function:
    """A user function that the user has not: it gives zeros, or does nothing."""
    zeros: dict[str, Function] = {
        "user_ExtForces": lambda *words: data.SWr[words[-1]],
        "user_Link3DForces": lambda *words: data.l3DWr[words[-1]],
        "user_LinkForces": lambda *_: 0.0,
    }
    return zeros.get(name, _nothing)


def _nothing(*_: Any) -> None:
    """The user has no such function."""


def changes(data: MbsData, language: str, pattern: str) -> bool:
    """True if somebody has changed or written user functions in the files of a pattern.

    Comments count for nothing: those that urdf2mbs writes are others in each version.
    """

    def code(text: bytes) -> str:
        sign = "\n" if language == "python" else ""
        words = text.decode("utf-8", "replace")
        return re.sub(COMMENTS[language], sign, words, flags=re.DOTALL).strip("\n")

    written = starters(language, data.mbs)
    return any(
        code(written.get(f"userfctR/{file.name}", b"none")) != code(file.read_bytes())
        for file in data.user_path.glob(pattern)
    )


def load(file: Path) -> Any:
    """The module in a file."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@contextmanager
def loaded(data: MbsData) -> Iterator[None]:
    """While user code runs: its folder is on Python's path, and MBsysPy is this runtime.

    Afterwards all is as it was.  Another project may have modules of the same names: those of this
    one are kept in ``data.modules`` meanwhile.
    """
    path, before = list(sys.path), dict(sys.modules)
    own = {file.stem for file in data.user_path.glob("*.py")}
    for name in own & before.keys():
        file = getattr(before[name], "__file__", None)
        if file is None or Path(file).parent != data.user_path:
            del sys.modules[name]
    sys.path[:0] = [str(data.user_path), str(data.user_path.parent / "workR")]
    stand_ins = {name: import_module(at) for name, at in names.MODULES.items()}
    sys.modules.update(data.modules | stand_ins)
    names.present.append(data)
    try:
        yield
    finally:
        names.present.pop()
        sys.path[:] = path
        data.modules = {name: sys.modules[name] for name in own & sys.modules.keys()}
        for name in {*own, *stand_ins}:
            sys.modules.pop(name, None)
            if name in before:
                sys.modules[name] = before[name]


@contextmanager
def shown(data: MbsData) -> Iterator[None]:
    """An exception of user code becomes an error that names its file and line."""
    try:
        yield
    except ConversionError:
        raise
    except Exception as error:
        rows = [
            (row.filename, row.lineno)
            for row in traceback.extract_tb(error.__traceback__)
            if Path(row.filename).parent == data.user_path
        ]
        if isinstance(error, SyntaxError) and error.filename:
            rows.append((error.filename, error.lineno))
        if not rows:
            raise
        raise SimulationError(
            "user-function-failed",
            f"at {data.tsim:g} s: {type(error).__name__}: {error}",
            file=rows[-1][0], line=rows[-1][1],
            hint=_where_it_is(data, error.name or "") if isinstance(error, ImportError) else None,
        ) from error  # fmt: skip


def add_on(name: str) -> str | None:
    """What a module or a header is, if it is of an add-on of Robotran's."""
    for start, what in ADD_ONS.items():
        if name.startswith(start):
            return f"it is of an add-on of Robotran's, for {what}, which is not here"
    return None


def _where_it_is(data: MbsData, module: str) -> str | None:
    """Where to look for a module that user code cannot import."""
    for file in data.project.rglob(f"{module}.py"):
        return f"it is in {file.parent.resolve()}: add this folder to PYTHONPATH"
    return add_on(module)


class PythonCode:
    """The functions of a simulation, in Python."""

    name = "Python"
    steps_in_c = False

    def __init__(self, data: MbsData) -> None:
        self.data = data
        self.rows = count_rows(data)
        self.own: dict[str, Function] = {}
        """The user functions, while others stand for them in turned axes."""
        self.has_loops = bool(sum(self.rows) or data.nqv) or data.natures != [
            joint.nature for joint in data.mbs.joints().values()
        ]
        """Whether accelred is that of the partition, not that of the project."""
        self.has_loop = self.find_loop()
        self.repartition(np.arange(sum(self.rows)))

    def find_loop(self) -> bool:
        """True if the user has a loop to call after each step."""
        return self.data.user_dirdyn_loop is not _nothing

    def repartition(self, kept: Any) -> None:
        """Take the joints of the data, and of the constraints these rows."""
        data = self.data
        self.kept = kept
        self.least: float | None = None
        self.free, self.dependent = data.qu[1:], data.qv[1:]
        self.guess = data.q[self.dependent]
        self.remember()
        if type(self) is PythonCode and self.has_loops:
            self.accelred = _accelred(data, self.rows, kept)

    def remember(self) -> None:
        """Let Newton's method start from the present place of the dependent joints, and move on
        with their speeds: near a fold, a place that is left behind leads to another branch."""
        data = self.data
        self.guess[:] = data.q[self.dependent]
        self.rate, self.since = data.qd[self.dependent], data.tsim

    def state(self) -> Any:
        """q and qd of the independent joints, and ux."""
        data = self.data
        return np.concatenate([data.q[self.free], data.qd[self.free], data.ux[1:]])

    def accelerate(self, t: float, y: Any) -> Any:
        """The derivative of the state.

        Not a number where the loops cannot be closed; Newton's method starts from ``guess``.
        """
        data, free, n = self.data, self.free, len(self.free)
        data.tsim = t
        data.q[free], data.qd[free], data.ux[1:] = y[:n], y[n : 2 * n], y[2 * n :]
        data.q[self.dependent] = self.guess + self.rate * (t - self.since)
        if self.solve():
            return np.full(len(y), np.nan)
        if data.Nux:
            data.user_derivatives(data)
        return np.concatenate([data.qd[free], data.qdd[free], data.uxd[1:]])

    def take_axes(self) -> None:
        """Take the axes in which the base is."""
        vars(self.data).update(self.own)
        self.own = {}
        if self.data.turned:
            turned = functions_in_own_axes(self.data)
            self.own = {name: getattr(self.data, name) for name in turned}
            vars(self.data).update(turned)

    def take_parameters(self) -> None:
        """Take the parameters of user models anew."""

    def slopes(self, t: float, y: Any, near: float = NEAR) -> Any:
        """The derivative of ``accelerate`` by the state, by differences: (states, states).

        Implicit integrators that are left to themselves scale their differences by a rate that
        vanishes in a robot at rest: what they then find is rounding, and their steps stay short.
        """
        here, found = self.accelerate(t, y), np.empty((len(y), len(y)))
        for k in range(len(y)):
            there = y.copy()
            there[k] += near * max(1.0, abs(y[k]))
            found[:, k] = (self.accelerate(t, there) - here) / (there[k] - y[k])
        return found

    def solve(self) -> bool:
        """Set all qdd, and q and qd of dependent joints; True where the loops cannot be closed."""
        accelred = self.accelred if self.has_loops else self.data.mbs_accelred
        try:
            return bool(accelred(self.data, self.data.tsim))
        except np.linalg.LinAlgError:
            return True

    def react(self) -> None:
        """Set Lambda and Qc for the state and accelerations that were computed last:
        M qdd + c = Qq + Jac' Lambda, and Qc in driven joints."""
        data = self.data
        if not (data.nqv or data.nqc):
            return
        rest = self.inverse() - data.Qq
        if data.nqv:
            jac = self.constraints()[1][self.kept]
            data.Lambda[1:] = np.linalg.solve(jac[:, self.dependent].T, rest[self.dependent])
            rest -= jac.T @ data.Lambda[1:]
        data.Qc[data.qc[1:]] = rest[data.qc[1:]]

    def constraints(self) -> tuple[Any, Any]:
        """h and Jac of all constraints, kept or not, from row 0; the columns count from 1."""
        data, (cuts, user) = self.data, self.rows
        h, jac = np.zeros(cuts + user + 1), np.zeros((cuts + user + 1, data.njoint + 1))
        if cuts:
            data.mbs_cons_hJ(h, jac, data)
        if user:
            data.user_cons_hJ(h[cuts:], jac[cuts:], data, data.tsim)
        return h[1:], jac[1:]

    def inverse(self) -> Any:
        """The forces that the joints need for the present state and accelerations."""
        phi = np.zeros(self.data.njoint + 1)
        self.data.mbs_invdyna(phi, self.data, self.data.tsim)
        return phi

    def call(self, name: str, dirdyn: Any) -> None:
        """Call user_dirdyn_init, _loop or _finish."""
        getattr(self.data, name)(self.data, dirdyn)


def _accelred(data: MbsData, rows: tuple[int, int], kept: Any) -> Function:
    """accelred with the partition of the data, from the template of those that are generated."""
    writer = PythonWriter(data.mbs)
    cuts, user = rows
    space: dict[str, Any] = {
        **writer.facts(), "ANY_DRIVEN": bool(data.nqc), "CUTS": cuts, "USER_ROWS": user, "np": np,
        "DEPENDENT": data.qv[1:].tolist(), "INDEPENDENT": data.qu[1:].tolist(),
        "DRIVEN": data.qc[1:].tolist(),
    }  # fmt: skip
    exec(compile(writer.sections("forces", "loops", "accelred"), "accelred.py.in", "exec"), space)
    every_hj, every_derivative = space["_constraints"], space["_derivative"]
    space["_constraints"] = lambda *words: tuple(every[kept] for every in every_hj(*words))
    space["_derivative"] = lambda s: every_derivative(s)[kept]
    return cast(Function, space["accelred"])


def count_rows(data: MbsData) -> tuple[int, int]:
    """How many equations the cuts make, and how many the user's functions: as many as somebody has
    said, else as the cuts leave dependent joints for."""
    cuts = 0
    if data.mbs.cuts:
        from urdf2mbs_equations.constraints import count_equations

        cuts = count_equations(data.mbs)
    user = data.user_constraints
    if user is None:
        here = any(list(data.user_path.glob(f"user_cons_hJ.{end}")) for end in ("py", "c"))
        user = max(data.nqv - cuts, 0) if here else 0
    if data.mbs.user_constraints and not user:
        raise SimulationError(
            "partition",
            f"{data.nqv} joints are dependent, and there are {cuts} equations of cuts and "
            "0 of user_cons_hJ, though the .mbs names user constraints",
            file=str(data.mbs_file),
            hint="is the .mbs without the user functions of its project?",
        )
    return cuts, user
