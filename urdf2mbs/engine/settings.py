"""What a config says of one conversion, with absolute paths."""

from __future__ import annotations

import os
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from urdf2mbs.conversion import Settings
from urdf2mbs.engine.config import Config, Lines, Project
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.levels import Levels
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.urdf.reader import stem


def settings_of(config: Config, lines: Lines, folder: Path) -> Settings:
    source = _path(folder / config.source)
    project = None
    languages: tuple[str, ...] = ()
    if isinstance(config.output, Project):
        project = _path(folder / config.output.project)
        output = project / "dataR" / f"{identifiers([project.name])[0]}.mbs"
        language = config.output.language
        if language == "both":
            language = ["python", "c"]
        languages = (language,) if isinstance(language, str) else tuple(dict.fromkeys(language))
    elif config.output is not None:
        output = _path(folder / config.output)
    else:
        output = _path(folder / f"{stem(source)}.mbs")
    if not all(map(isfinite, config.gravity)):
        raise lines.error(
            "gravity-infinite",
            f"gravity is {list(config.gravity)}: each part must be a finite number, in m/s^2",
            ("gravity",),
        )
    packages = {}
    for name, directory in config.packages.items():
        packages[name] = _path(folder / directory)
        if not packages[name].is_dir():
            raise lines.error(
                "package-missing",
                f"package '{name}': there is no folder '{packages[name]}'",
                ("packages", name),
            )
    return Settings(
        source, output, config.base, packages, dict(config.xacro_args), config.gravity, project,
        Levels(config.diagnostics, config.strict), languages, _path(folder),
        config.cache,
    )  # fmt: skip


def check_output(settings: Settings, passes: Sequence[Pass], lines: Lines) -> None:
    """Where an .mbs is written to; a pipeline that makes none needs no place."""
    if not any("mbs-file" in pass_.gives for pass_ in passes) or settings.source.is_dir():
        return
    if settings.output == settings.source:
        raise lines.error(
            "output-is-source",
            f"the output would overwrite the robot '{settings.source}'",
            ("output",),
        )
    if settings.output.is_dir():
        raise lines.error(
            "output-is-folder",
            f"the output '{settings.output}' is a folder",
            ("output",),
            "name the .mbs file; for a whole project: 'output: {project: FOLDER}'",
        )


def _path(path: Path) -> Path:
    return Path(os.path.abspath(path))  # noqa: PTH100 unlike resolve(), links keep their name
