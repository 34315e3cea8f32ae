"""Simulate a config, a project, a robot or an .mbs: ``simulate`` and ``modes``."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

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
    write_output,
)
from urdf2mbs_simulate.compiler import compiler
from urdf2mbs_simulate.dirdyn import MbsDirdyn
from urdf2mbs_simulate.equilibrium import Equilibrium, MbsEquil
from urdf2mbs_simulate.modal import MbsModal, Modes
from urdf2mbs_simulate.push import Push, parse_push
from urdf2mbs_simulate.python_code import MbsData
from urdf2mbs_simulate.results import Results

if TYPE_CHECKING:
    from urdf2mbs_report.page import Page


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
    """Simulate a Robotran project.

    Args:
        source: A project's folder, an .mbs, a robot or a config.  A config's project is made where
            its ``output`` says, by default in a temporary folder.
        time: The duration (s).
        push: Forces on links, such as ``chest:20,0,0@0.5..0.6`` (N, s).
        method: ``Rosenbrock``, our own (default), ``Radau`` or ``DOP853`` of scipy, or ``RK4``.
        language: Of the user functions, ``c`` or ``python``.  By default C, if the project has them
            in C, and those in Python are unchanged.
        rate: Frames in a second of the results.
        rtol: Relative error of a step.
        atol: Absolute error of a step (rad, m); by default a part of ``rtol``.
        watch: Called with the time (s) after each step.
        equilibrium: True to start at rest where nothing accelerates; ``results.equilibrium`` has
            it.
        on_compile: Called with the numbers of compiled files and of all files.
        **fields: Fields of the config, as in ``convert``.

    Returns:
        The results in memory; ``Results.write()`` writes them.

    Raises:
        ConversionError: The robot cannot be converted, the code cannot run, or no step is short
            enough.
    """
    resolved = resolve_model(source, fields)
    data = MbsData(resolved.model)
    data._run.on_compile = on_compile
    data._run.pushes = [parse_push(item) if isinstance(item, str) else item for item in push]
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(
        tf=time,
        integrator=method,
        language=language,
        framerate=rate,
        rtoler=rtol,
        atoler=atol,
        save2file=0,
    )
    dirdyn.watch = watch or dirdyn.watch
    start = find_equilibrium(data, language) if equilibrium else None
    results = dirdyn.run()
    results.equilibrium = start
    results.temporary_folder, results.conversion = resolved.temporary_folder, resolved.conversion
    return results


def find_equilibrium(data: MbsData, language: str | None = None) -> Equilibrium:
    """Move a model to the pose in which nothing accelerates, without its pushes.

    Raises:
        ConversionError: There is no such pose near by.
    """
    equil = MbsEquil(data)
    equil.set_options(language=language, save2file=0)
    pushes, data._run.pushes = data._run.pushes, []
    equilibrium = equil.run()
    data._run.pushes = pushes
    return equilibrium


def modes(
    source: Config | str | os.PathLike[str],
    *,
    drawn: bool = False,
    language: str | None = None,
    **fields: Any,
) -> Modes:
    """Compute the modes of a robot, a project or an .mbs.

    Args:
        source: As in ``simulate``.
        drawn: True for the modes about the drawn pose; by default, about the equilibrium.
        language: Of the user functions, as in ``simulate``.
        **fields: Fields of the config, as in ``convert``.

    Raises:
        ConversionError: There is no equilibrium, or the code cannot run.
    """
    resolved = resolve_model(source, fields)
    data = MbsData(resolved.model)
    if not drawn:
        data._run.notes += find_equilibrium(data, language).lines()
    modal = MbsModal(data)
    modal.set_options(language=language, save_result=0)
    results = modal.run()
    results.temporary_folder, results.conversion = resolved.temporary_folder, resolved.conversion
    return results


class ResolvedModel(NamedTuple):
    """The .mbs of a source, and what made it."""

    model: Path
    temporary_folder: tempfile.TemporaryDirectory[str] | None
    """The folder of its project, which lives as long as the object."""
    conversion: Conversion | None
    """The conversion of a robot or a config."""


def resolve_model(source: Config | str | os.PathLike[str], fields: dict[str, Any]) -> ResolvedModel:
    """Return the .mbs of a source; a robot or a config is converted to a project.

    Args:
        source: As in ``simulate``.
        fields: Fields of the config, as in ``convert``.
    """
    model = None if isinstance(source, Config) else model_of(Path(source))
    if model is not None:
        return ResolvedModel(model, None, None)
    config, lines = config_of(source, **fields)
    temporary_folder = None
    if not isinstance(config.output, Project):
        temporary_folder = tempfile.TemporaryDirectory(prefix="urdf2mbs-")
        config = with_project(config, Path(temporary_folder.name, stem(Path(config.source))))
    conversion = Pipeline(config, lines).run()
    return ResolvedModel(write_project(conversion), temporary_folder, conversion)


def with_project(config: Config, folder: Path) -> Config:
    """Return a config that writes a project: by default into ``folder``."""
    if isinstance(config.output, Project):
        return config
    languages: list[Any] = ["python", *(["c"] if compiler() else [])]
    return msgspec.structs.replace(config, output=Project(str(absolute(folder)), languages))


def write_project(conversion: Conversion, *, force: bool = False) -> Path:
    """Write the project of a conversion.

    Args:
        conversion: A finished one.
        force: True to replace files of other programs.

    Returns:
        Its .mbs.

    Raises:
        ConversionError: The .mbs is not the same robot.
    """
    write_output(conversion, force=force)
    if conversion.checked.rejected is not None:
        error = ConversionError(
            "not-the-same",
            f"the .mbs is not the same robot: see '{conversion.checked.rejected}'",
            hint="urdf2mbs report, in place of simulate, shows where they differ",
        )
        error.exit_code = 3
        raise error
    return conversion.settings.output


def make_modes_page(results: Modes, number: int = 1) -> Page:
    """Make the page that lists the modes, and shows one.

    Args:
        results: Modes; there is at least one.
        number: Of the mode that is shown at first, from 1.
    """
    from urdf2mbs_report.page import ShownModes, make_model_page

    run = results.data._run
    shown = ShownModes(results.describe(number), results.notes())
    return make_model_page(run.mbs, run.file, modes=shown, conversion=results.conversion)


def make_motion_page(results: Results) -> Page:
    """Make the page that plays results in memory."""
    from urdf2mbs_report.motion import stack_columns
    from urdf2mbs_report.page import make_model_page

    run, columns = results.data._run, stack_columns(results.columns())
    return make_model_page(run.mbs, run.file, columns, conversion=results.conversion)
