"""``simulate``: from a config, a project, a robot or an .mbs to its motion."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import (
    Config,
    Conversion,
    ConversionError,
    Pipeline,
    Project,
    absolute,
    config_of,
    model_of,
    stem,
)
from urdf2mbs.plugin import write_output as write
from urdf2mbs_simulate.compiler import compiler
from urdf2mbs_simulate.dirdyn import MbsDirdyn
from urdf2mbs_simulate.equilibrium import Equilibrium, MbsEquil
from urdf2mbs_simulate.modal import MbsModal, Modes
from urdf2mbs_simulate.push import Push, parse
from urdf2mbs_simulate.python_code import MbsData
from urdf2mbs_simulate.results import Results


def simulate(
    source: Config | str | os.PathLike[str],
    *,
    time: float = 2.0,
    push: Sequence[Push | str] = (),
    method: str | None = None,
    language: str | None = None,
    rate: float = 100.0,
    rtol: float | None = None,
    atol: float | None = None,
    watch: Callable[[float], None] | None = None,
    equilibrium: bool = False,
    on_compile: Callable[[int, int], None] | None = None,
    **fields: Any,
) -> Results:
    """Simulate a Robotran project for ``time`` seconds.

    ``source`` is a project's folder, an .mbs, a robot or a config.  A config's project is made
    where its ``output`` says, else in a temporary folder.  ``fields`` are as in ``convert``.

    ``push``: forces on links, such as ``chest:20,0,0@0.5..0.6`` (N, s).  ``method`` is
    ``Rosenbrock``, our own, ``Radau`` or ``DOP853`` of scipy, or ``RK4``, with ``rtol`` and
    ``atol`` (rad, m; by default a part of ``rtol``); the results have ``rate`` frames a second.
    ``language`` is that of the user functions, ``c`` or ``python``: by default C, if the project
    has them, and those in Python are unchanged.  ``watch`` is called with the time (s) after each
    step, ``on_compile`` with how many of how many files are compiled.  ``equilibrium``: start where
    nothing accelerates, at rest; ``results.equilibrium`` has it.

    The results are in memory; ``Results.write()`` writes them.  Raises ConversionError.
    """
    model, keep = project_of(source, fields)
    data = MbsData(model)
    data._run.on_compile = on_compile
    data._run.pushes = [parse(one) if isinstance(one, str) else one for one in push]
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(
        tf=time, integrator=method, language=language, framerate=rate, rtoler=rtol, atoler=atol,
        save2file=0,
    )  # fmt: skip
    dirdyn.watch = watch or dirdyn.watch
    found = find_equilibrium(data, language) if equilibrium else None
    results = dirdyn.run()
    results.equilibrium = found
    results.keep = keep
    return results


def find_equilibrium(data: MbsData, language: str | None = None) -> Equilibrium:
    """Let a model be where nothing accelerates.  Raises ConversionError where there is no pose."""
    equil = MbsEquil(data)
    equil.set_options(language=language, save2file=0)
    pushes, data._run.pushes = data._run.pushes, []
    found = equil.run()
    data._run.pushes = pushes
    return found


def modes(
    source: Config | str | os.PathLike[str],
    *,
    drawn: bool = False,
    language: str | None = None,
    **fields: Any,
) -> Modes:
    """How a robot, a project or an .mbs swings about its equilibrium, or where it is drawn.

    ``source``, ``language`` and ``fields`` are as in ``simulate``.  Raises ConversionError.
    """
    model, keep = project_of(source, fields)
    data = MbsData(model)
    if not drawn:
        data._run.notes += find_equilibrium(data, language).lines()
    modal = MbsModal(data)
    modal.set_options(language=language, save_result=0)
    found = modal.run()
    found.keep = keep
    return found


def project_of(source: Config | str | os.PathLike[str], fields: dict[str, Any]) -> tuple[Path, Any]:
    """The .mbs of what ``simulate`` is given, and a temporary folder that must be kept, or None."""
    model = None if isinstance(source, Config) else model_of(Path(source))
    if model is not None:
        return model, None
    config, lines = config_of(source, **fields)
    keep = None
    if not isinstance(config.output, Project):
        keep = tempfile.TemporaryDirectory(prefix="urdf2mbs-")
        config = with_project(config, Path(keep.name, stem(Path(config.source))))
    return make(Pipeline(config, lines).run()), keep


def with_project(config: Config, folder: Path) -> Config:
    """The config of a project: that of the config itself, else one in ``folder``."""
    if isinstance(config.output, Project):
        return config
    languages: list[Any] = ["python", *(["c"] if compiler() else [])]
    return msgspec.structs.replace(config, output=Project(str(absolute(folder)), languages))


def make(conversion: Conversion, *, force: bool = False) -> Path:
    """Write a project; gives its .mbs.  Raises ConversionError if it is not the same robot."""
    write(conversion, force=force)
    if conversion.checked.rejected is not None:
        error = ConversionError(
            "not-the-same", f"the .mbs is not the same robot: see '{conversion.checked.rejected}'",
            hint="urdf2mbs report, in place of simulate, shows where they differ",
        )  # fmt: skip
        error.exit_code = 3
        raise error
    return conversion.settings.output
