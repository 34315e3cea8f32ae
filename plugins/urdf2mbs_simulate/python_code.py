"""A project's Python: its equations and user functions, loaded from their files."""

from __future__ import annotations

import importlib.util
import os
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from threading import RLock
from typing import Any, cast

import numpy as np

from urdf2mbs.plugin import ConversionError
from urdf2mbs_equations.files import ADDITIONAL_FUNCTIONS, FUNCTIONS
from urdf2mbs_equations.python import PythonWriter
from urdf2mbs_project.code import generate_starter_files
from urdf2mbs_simulate import data as model_data
from urdf2mbs_simulate import names
from urdf2mbs_simulate.equations import SimulationError, equations
from urdf2mbs_simulate.model_code import Code, count_rows

Function = Callable[..., Any]

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
KNOWN = frozenset([*USER, *(f"mbs_{name}" for name in (*FUNCTIONS, *ADDITIONAL_FUNCTIONS))])


def function(data: model_data.MbsData, name: str) -> Function:
    """``mbs_X`` of the equations, or ``user_X``: what the user has not does nothing."""
    if name.startswith("mbs_"):
        name = name.removeprefix("mbs_")
        module = load(equations(data, [name], "python")[name])
        return cast(Function, getattr(module, "sensor" if name == "gensensor" else name))
    file = data.user_path / f"{USER[name]}.py"
    if not file.is_file():
        return default(data, name)
    with shown(data):
        if data not in _modules.running:
            return cast(Function, getattr(load(file), name))
        with modules_of(data):
            return cast(Function, getattr(load(file), name))


def default(data: model_data.MbsData, name: str) -> Function:
    """A user function that the user has not: it gives zeros, or does nothing."""
    zeros: dict[str, Function] = {
        "user_ExtForces": lambda *words: data.SWr[words[-1]],
        "user_Link3DForces": lambda *words: data.l3DWr[words[-1]],
        "user_LinkForces": lambda *_: 0.0,
    }
    return zeros.get(name, _nothing)


def _nothing(*_: Any) -> None:
    """The user has no such function."""


def changes(data: model_data.MbsData, language: str, pattern: str) -> bool:
    """True if somebody has changed or written user functions in the files of a pattern.

    Comments count for nothing: those that urdf2mbs writes are others in each version.
    """

    def code(text: bytes) -> str:
        sign = "\n" if language == "python" else ""
        words = text.decode("utf-8", "replace")
        return re.sub(COMMENTS[language], sign, words, flags=re.DOTALL).strip("\n")

    written = generate_starter_files(language, data._run.mbs)
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


class _Modules:
    """What user code sees of Python's modules: those of one project at a time, in any thread.

    Projects have modules of the same names.  Those of a project are kept with its data while
    another one is shown.
    """

    def __init__(self) -> None:
        self.lock = RLock()
        self.running: list[Any] = []
        """The data whose simulations run, the last one last."""
        self.shown: Any = None
        """The data whose modules are in ``sys.modules``."""
        self.displaced: dict[str, Any] = {}
        """Modules of others, of the same names."""

    def show(self, data: Any) -> None:
        """Show the modules of some data, or (None) those that were there before."""
        if data is self.shown:
            return
        if self.shown is not None:
            self._hide()
        self.shown = data
        if data is None:
            return
        names_of_project = _stems(data)
        self.displaced = {
            name: sys.modules[name]
            for name in (*names_of_project, *names.MODULES)
            if name in sys.modules
        }
        for name, module in self.displaced.items():
            file = getattr(module, "__file__", None)
            if name in names_of_project and (file is None or Path(file).parent != data.user_path):
                del sys.modules[name]
        sys.path[:0] = _folders(data)
        sys.modules.update({name: import_module(at) for name, at in names.MODULES.items()})
        sys.modules.update(data._run.modules)

    def _hide(self) -> None:
        data = self.shown
        for folder in _folders(data):
            if folder in sys.path:
                sys.path.remove(folder)
        own = _stems(data)
        data._run.modules = {name: sys.modules[name] for name in own & sys.modules.keys()}
        for name in (*own, *names.MODULES):
            sys.modules.pop(name, None)
        sys.modules.update(self.displaced)


_modules = _Modules()


def _stems(data: model_data.MbsData) -> set[str]:
    return {file.stem for file in data.user_path.glob("*.py")}


def _folders(data: model_data.MbsData) -> list[str]:
    return [str(data.user_path), str(data.user_path.parent / "workR")]


@contextmanager
def loaded(data: model_data.MbsData) -> Iterator[None]:
    """While user code runs: its folder is on Python's path, and MBsysPy is this runtime.

    Afterwards all is as it was.
    """
    with _modules.lock:
        _modules.running.append(data)
        _modules.show(data)
    names.present.models.append(data)
    try:
        yield
    finally:
        names.present.models.pop()
        with _modules.lock:
            last = len(_modules.running) - 1 - _modules.running[::-1].index(data)
            del _modules.running[last]
            _modules.show(_modules.running[-1] if _modules.running else None)


@contextmanager
def modules_of(data: model_data.MbsData) -> Iterator[None]:
    """While user code of some data is called: what it imports is of its own project."""
    with _modules.lock:
        _modules.show(data)
        yield


@contextmanager
def shown(data: model_data.MbsData) -> Iterator[None]:
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


def _where_it_is(data: model_data.MbsData, module: str) -> str | None:
    """Where to look for a module that user code cannot import."""
    for file in data._run.project.rglob(f"{module}.py"):
        return f"it is in {file.parent.resolve()}: add this folder to PYTHONPATH"
    return names.describe_add_on(module)


class MbsData(model_data.MbsData):
    """The model of an .mbs file with the functions of its project, and the state of its simulation.

    What is no attribute yet is looked for in the project's Python files: ``mbs_dirdyna`` in
    symbolicR, ``user_JointForces`` in userfctR.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        user_path: str = "userfctR",
        symbolic_path: str = "symbolicR",
    ) -> None:
        super().__init__(path, user_path, symbolic_path, loader=_load_known)


def _load_known(data: model_data.MbsData, name: str) -> Function | None:
    return function(data, name) if name in KNOWN else None


class PythonEquations(Code):
    """Equations in Python, for ``load_equations``."""

    def __init__(self, data: model_data.MbsData) -> None:
        super().__init__(data, count_rows(data))

    def repartition(self, kept: Any) -> None:
        super().repartition(kept)
        if self.has_loops:
            self.accelred = _accelred(self.data, self.rows, kept)

    def solve(self) -> bool:
        accelred = self.accelred if self.has_loops else self.data.mbs_accelred
        try:
            return bool(accelred(self.data, self.data.tsim))
        except np.linalg.LinAlgError:
            return True

    def constraints(self) -> tuple[Any, Any]:
        data, (cuts, user) = self.data, self.rows
        h, jac = np.zeros(cuts + user + 1), np.zeros((cuts + user + 1, data.njoint + 1))
        if cuts:
            data.mbs_cons_hJ(h, jac, data)
        if user:
            data.user_cons_hJ(h[cuts:], jac[cuts:], data, data.tsim)
        return h[1:], jac[1:]

    def inverse(self) -> Any:
        phi = np.zeros(self.data.njoint + 1)
        self.data.mbs_invdyna(phi, self.data, self.data.tsim)
        return phi


def _accelred(data: model_data.MbsData, rows: tuple[int, int], kept: Any) -> Function:
    """Return accelred with the partition of the data, from the template of those that are
    generated."""
    writer = PythonWriter(data._run.mbs)
    cuts, user = rows
    space: dict[str, Any] = {
        **writer.find_features(), "ANY_DRIVEN": bool(data.nqc), "np": np,
        "CUTS": cuts, "USER_ROWS": user,
        "DEPENDENT": data.qv[1:].tolist(), "INDEPENDENT": data.qu[1:].tolist(),
        "DRIVEN": data.qc[1:].tolist(),
    }  # fmt: skip
    template = writer.read_sections("forces", "loops", "accelred")
    exec(compile(template, "accelred.py.in", "exec"), space)
    every_hj, every_derivative = space["_constraints"], space["_derivative"]
    space["_constraints"] = lambda *words: tuple(every[kept] for every in every_hj(*words))
    space["_derivative"] = lambda s: every_derivative(s)[kept]
    return cast(Function, space["accelred"])
