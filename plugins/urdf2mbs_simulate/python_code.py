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
from urdf2mbs_simulate.equations import SimulationError, find_equations
from urdf2mbs_simulate.model_code import Code, RowCounts, count_rows

Function = Callable[..., Any]

#: User functions that are in a file of their own name.
_FORCES_AND_CONSTRAINTS = (
    "user_JointForces",
    "user_DrivenJoints",
    "user_ExtForces",
    "user_LinkForces",
    "user_Link3DForces",
    "user_cons_hJ",
    "user_cons_jdqd",
)
#: The user functions, with the files that define them.
USER_FUNCTIONS = {
    **{name: name for name in _FORCES_AND_CONSTRAINTS},
    "user_derivatives": "user_Derivative",
    **{
        f"user_{module}_{when}": f"user_{module}"
        for module in ("dirdyn", "invdyn")
        for when in ("init", "loop", "finish")
    },
}
#: Comments and blanks, which change nothing.
COMMENTS = {"python": r"(?:[ \t]*(?:#[^\n]*)?\n)+", "c": r"/\*.*?\*/|//[^\n]*|\s"}
#: The functions of a project that are attributes of MbsData.
FUNCTION_NAMES = frozenset(
    [*USER_FUNCTIONS, *(f"mbs_{name}" for name in (*FUNCTIONS, *ADDITIONAL_FUNCTIONS))]
)


def load_function(data: model_data.MbsData, name: str) -> Function:
    """Load a function of a project.

    Args:
        data: The model.
        name: ``mbs_X`` of the equations, or ``user_X``; a user function that the project does not
            have is the default one.

    Raises:
        ConversionError: User code raises while it is loaded, or the equations cannot be made.
    """
    if name.startswith("mbs_"):
        name = name.removeprefix("mbs_")
        module = load_module(find_equations(data, [name], "python")[name])
        return cast(Function, getattr(module, "sensor" if name == "gensensor" else name))
    file = data.user_path / f"{USER_FUNCTIONS[name]}.py"
    if not file.is_file():
        return get_default_function(data, name)
    with locate_errors(data):
        if data not in _modules.running:
            return cast(Function, getattr(load_module(file), name))
        with show_modules(data):
            return cast(Function, getattr(load_module(file), name))


def get_default_function(data: model_data.MbsData, name: str) -> Function:
    """Return a user function that the project does not have: it returns zeros, or does nothing."""
    zeros: dict[str, Function] = {
        "user_ExtForces": lambda *arguments: data.SWr[arguments[-1]],
        "user_Link3DForces": lambda *arguments: data.l3DWr[arguments[-1]],
        "user_LinkForces": lambda *_: 0.0,
    }
    return zeros.get(name, _do_nothing)


def _do_nothing(*_: Any) -> None:
    """Replace a user function that the project does not have."""


def has_user_changes(data: model_data.MbsData, language: str, pattern: str) -> bool:
    """Return True if the user has changed or written user functions.

    Comments are ignored: those that urdf2mbs writes differ between versions.

    Args:
        data: The model.
        language: ``python`` or ``c``.
        pattern: Of the names of files in userfctR.
    """

    def strip_comments(content: bytes) -> str:
        separator = "\n" if language == "python" else ""
        text = content.decode("utf-8", "replace")
        return re.sub(COMMENTS[language], separator, text, flags=re.DOTALL).strip("\n")

    written = generate_starter_files(language, data._run.mbs)
    return any(
        strip_comments(written.get(f"userfctR/{file.name}", b"none"))
        != strip_comments(file.read_bytes())
        for file in data.user_path.glob(pattern)
    )


def load_module(file: Path) -> Any:
    """Load the module of a file."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class _ProjectModules:
    """The modules that user code can import: those of one project at a time, in any thread.

    Modules of different projects have the same names.  While another project is shown, those of a
    project are kept with its data.
    """

    def __init__(self) -> None:
        self.lock = RLock()
        self.running: list[Any] = []
        """The data whose simulations run, the innermost last."""
        self.shown: Any = None
        """The data whose modules are in ``sys.modules``."""
        self.displaced: dict[str, Any] = {}
        """Modules of the program that have the names of those of the project."""

    def show(self, data: Any) -> None:
        """Put the modules of a project into ``sys.modules``; None brings back the program's."""
        if data is self.shown:
            return
        if self.shown is not None:
            self._hide()
        self.shown = data
        if data is None:
            return
        project_names = _list_module_names(data)
        self.displaced = {
            name: sys.modules[name]
            for name in (*project_names, *names.MODULES)
            if name in sys.modules
        }
        for name, module in self.displaced.items():
            file = getattr(module, "__file__", None)
            if name in project_names and (file is None or Path(file).parent != data.user_path):
                del sys.modules[name]
        sys.path[:0] = _list_folders(data)
        sys.modules.update({name: import_module(module) for name, module in names.MODULES.items()})
        sys.modules.update(data._run.modules)

    def _hide(self) -> None:
        data = self.shown
        for folder in _list_folders(data):
            if folder in sys.path:
                sys.path.remove(folder)
        project_names = _list_module_names(data)
        data._run.modules = {name: sys.modules[name] for name in project_names & sys.modules.keys()}
        for name in (*project_names, *names.MODULES):
            sys.modules.pop(name, None)
        sys.modules.update(self.displaced)


_modules = _ProjectModules()


def _list_module_names(data: model_data.MbsData) -> set[str]:
    return {file.stem for file in data.user_path.glob("*.py")}


def _list_folders(data: model_data.MbsData) -> list[str]:
    return [str(data.user_path), str(data.user_path.parent / "workR")]


@contextmanager
def user_code(data: model_data.MbsData) -> Iterator[None]:
    """Let the user code of a model run: it imports its project's modules, and us as MBsysPy.

    Afterwards ``sys.path`` and ``sys.modules`` are as before.
    """
    with _modules.lock:
        _modules.running.append(data)
        _modules.show(data)
    names.active.models.append(data)
    try:
        yield
    finally:
        names.active.models.pop()
        with _modules.lock:
            last = len(_modules.running) - 1 - _modules.running[::-1].index(data)
            del _modules.running[last]
            _modules.show(_modules.running[-1] if _modules.running else None)


@contextmanager
def show_modules(data: model_data.MbsData) -> Iterator[None]:
    """Let a user function import modules of its own project, whatever other projects run."""
    with _modules.lock:
        _modules.show(data)
        yield


@contextmanager
def locate_errors(data: model_data.MbsData) -> Iterator[None]:
    """Turn an exception of user code into an error with its file and line."""
    try:
        yield
    except ConversionError:
        raise
    except Exception as error:
        places = [
            (frame.filename, frame.lineno)
            for frame in traceback.extract_tb(error.__traceback__)
            if Path(frame.filename).parent == data.user_path
        ]
        if isinstance(error, SyntaxError) and error.filename:
            places.append((error.filename, error.lineno))
        if not places:
            raise
        file, line = places[-1]
        raise SimulationError(
            "user-function-failed",
            f"at {data.tsim:g} s: {type(error).__name__}: {error}",
            file=file,
            line=line,
            hint=_locate_module(data, error.name or "") if isinstance(error, ImportError) else None,
        ) from error


def _locate_module(data: model_data.MbsData, module: str) -> str | None:
    """Return a hint where a module is that user code cannot import."""
    for file in data._run.project.rglob(f"{module}.py"):
        return f"it is in {file.parent.resolve()}: add this folder to PYTHONPATH"
    return names.describe_add_on(module)


class MbsData(model_data.MbsData):
    """The model of an .mbs file with the functions of its project, and the state of its simulation.

    Missing attributes are loaded from the project's Python files: ``mbs_dirdyna`` from symbolicR,
    ``user_JointForces`` from userfctR.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        user_path: str = "userfctR",
        symbolic_path: str = "symbolicR",
    ) -> None:
        super().__init__(path, user_path, symbolic_path, loader=_load_if_known)


def _load_if_known(data: model_data.MbsData, name: str) -> Function | None:
    return load_function(data, name) if name in FUNCTION_NAMES else None


class PythonEquations(Code):
    """Equations in Python, for ``load_equations``."""

    def __init__(self, data: model_data.MbsData) -> None:
        super().__init__(data, count_rows(data))

    def set_partition(self, used_rows: Any) -> None:
        """Take the natures of the joints from the data, see ``Code``."""
        super().set_partition(used_rows)
        if self.has_loops:
            self.accelred = _compile_accelred(self.data, self.row_counts, used_rows)

    def compute_accelerations(self) -> bool:
        """Set qdd, and q and qd of dependent joints; return True if it failed."""
        accelred = self.accelred if self.has_loops else self.data.mbs_accelred
        try:
            return bool(accelred(self.data, self.data.tsim))
        except np.linalg.LinAlgError:
            return True

    def compute_constraints(self) -> tuple[Any, Any]:
        """Compute h and J of all constraints, see ``Code``."""
        data, (cuts, user) = self.data, self.row_counts
        h, jacobian = np.zeros(cuts + user + 1), np.zeros((cuts + user + 1, data.njoint + 1))
        if cuts:
            data.mbs_cons_hJ(h, jacobian, data)
        if user:
            data.user_cons_hJ(h[cuts:], jacobian[cuts:], data, data.tsim)
        return h[1:], jacobian[1:]

    def compute_inverse_dynamics(self) -> Any:
        """Return M qdd + c of the present state and accelerations."""
        forces = np.zeros(self.data.njoint + 1)
        self.data.mbs_invdyna(forces, self.data, self.data.tsim)
        return forces


def _compile_accelred(data: model_data.MbsData, row_counts: RowCounts, used_rows: Any) -> Function:
    """Return accelred for the present partition, from the template of generated ones."""
    writer = PythonWriter(data._run.mbs)
    namespace: dict[str, Any] = {
        **writer.find_features(),
        "ANY_DRIVEN": bool(data.nqc),
        "CUTS": row_counts.cuts,
        "USER_ROWS": row_counts.user,
        "np": np,
        "DEPENDENT": data.qv[1:].tolist(),
        "INDEPENDENT": data.qu[1:].tolist(),
        "DRIVEN": data.qc[1:].tolist(),
    }
    template = writer.read_sections("forces", "loops", "accelred")
    exec(compile(template, "accelred.py.in", "exec"), namespace)
    compute_all, differentiate_all = namespace["_constraints"], namespace["_derivative"]
    namespace["_constraints"] = lambda *arguments: tuple(
        rows[used_rows] for rows in compute_all(*arguments)
    )
    namespace["_derivative"] = lambda s: differentiate_all(s)[used_rows]
    return cast(Function, namespace["accelred"])
