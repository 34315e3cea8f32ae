"""A project's Python: its equations and user functions, loaded from their files."""

from __future__ import annotations

import importlib.util
import os
import re
import sys
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from threading import RLock
from typing import Any, cast

import numpy as np

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_equations.files import FUNCTIONS, OWN
from urdf2mbs_equations.python import PythonWriter
from urdf2mbs_project.code import starters
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
KNOWN = frozenset([*USER, *(f"mbs_{name}" for name in (*FUNCTIONS, *OWN))])


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

    written = starters(language, data._run.mbs)
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


class _Active:
    """What user code sees of Python's modules, while simulations run, in any thread."""

    def __init__(self) -> None:
        self.lock = RLock()
        self.counts: Counter[Path] = Counter()
        """How many simulations run in a folder of user functions."""
        self.replaced: dict[str, Any] = {}
        """Modules whose names are those of stand-ins, by name."""


_active = _Active()


@contextmanager
def loaded(data: model_data.MbsData) -> Iterator[None]:
    """While user code runs: its folder is on Python's path, and MBsysPy is this runtime.

    Afterwards all is as it was.  Another project may have modules of the same names: those of this
    one are kept with the data meanwhile.
    """
    folders = [str(data.user_path), str(data.user_path.parent / "workR")]
    own = {file.stem for file in data.user_path.glob("*.py")}
    with _active.lock:
        others = _remove_modules(own, data.user_path)
        sys.path[:0] = folders
        if not _active.counts.total():
            _active.replaced = {
                name: sys.modules[name] for name in names.MODULES if name in sys.modules
            }
        _active.counts[data.user_path] += 1
        sys.modules.update({name: import_module(at) for name, at in names.MODULES.items()})
        sys.modules.update(data._run.modules)
    names.present.models.append(data)
    try:
        yield
    finally:
        names.present.models.pop()
        with _active.lock:
            _active.counts[data.user_path] -= 1
            for folder in folders:
                if folder in sys.path:
                    sys.path.remove(folder)
            data._run.modules = {name: sys.modules[name] for name in own & sys.modules.keys()}
            if not _active.counts[data.user_path]:
                for name in own:
                    sys.modules.pop(name, None)
            sys.modules.update(others)
            if not _active.counts.total():
                for name in names.MODULES:
                    sys.modules.pop(name, None)
                sys.modules.update(_active.replaced)


def _remove_modules(modules: set[str], folder: Path) -> dict[str, Any]:
    """Remove the modules of some names that are of other folders; return them."""
    removed = {}
    for name in modules & sys.modules.keys():
        file = getattr(sys.modules[name], "__file__", None)
        if file is None or Path(file).parent != folder:
            removed[name] = sys.modules.pop(name)
    return removed


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
        **writer.facts(), "ANY_DRIVEN": bool(data.nqc), "CUTS": cuts, "USER_ROWS": user, "np": np,
        "DEPENDENT": data.qv[1:].tolist(), "INDEPENDENT": data.qu[1:].tolist(),
        "DRIVEN": data.qc[1:].tolist(),
    }  # fmt: skip
    exec(compile(writer.sections("forces", "loops", "accelred"), "accelred.py.in", "exec"), space)
    every_hj, every_derivative = space["_constraints"], space["_derivative"]
    space["_constraints"] = lambda *words: tuple(every[kept] for every in every_hj(*words))
    space["_derivative"] = lambda s: every_derivative(s)[kept]
    return cast(Function, space["accelred"])
