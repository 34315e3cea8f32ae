"""What a config says of one conversion, with absolute paths."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.config.model import Config, Lines, Project, place
from urdf2mbs.conversion import Settings
from urdf2mbs.disk.files import absolute, is_folder
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.urdf.reader import stem


def settings_of(config: Config, lines: Lines, hook: Any = None, *, fresh: bool = False) -> Settings:
    """What a config says, with absolute paths.

    ``hook`` are the hooks of plugins, which know where a robot is that is no file but has a name.
    """
    xacro_args = dict(config.xacro_args)
    packages = {}
    located = None if hook is None else hook.urdf2mbs_locate(source=config.source)
    if located is not None:
        source = absolute(located.source)
        packages = located.packages
        xacro_args = {**located.xacro_args, **xacro_args}
    else:
        source = place(config.source, lines, ("source",))
    project = None
    languages: tuple[str, ...] = ()
    if isinstance(config.output, Project):
        project = place(config.output.project, lines, ("output", "project"))
        output = project / "dataR" / f"{identifiers([project.name])[0]}.mbs"
        language = config.output.language
        if language == "both":
            language = ["python", "c"]
        languages = (language,) if isinstance(language, str) else tuple(dict.fromkeys(language))
    elif config.output is not None:
        output = place(config.output, lines, ("output",))
    else:
        output = absolute(lines.folder / f"{stem(source)}.mbs")
    for name, directory in config.packages.items():
        packages[name] = place(directory, lines, ("packages", name))
        if not is_folder(packages[name]):
            raise lines.error(
                "package-missing",
                f"package '{name}': there is no folder '{packages[name]}'",
                ("packages", name),
            )
    config = msgspec.structs.replace(config, xacro_args=xacro_args)
    folder = absolute(lines.folder)
    return Settings(source, output, config, packages, project, languages, folder, fresh)


def check_output(settings: Settings, lines: Lines) -> None:
    """Raise ConfigError if the .mbs cannot be written to its place."""
    if is_folder(settings.source):
        return
    if _same(settings.output, settings.source):
        said = f"the output would overwrite the robot '{settings.source}'"
        raise lines.error("output-is-source", said, ("output",))
    project = settings.project
    if project is not None and not is_folder(project / "dataR"):
        real = Path(os.path.realpath(project))
        if real in Path(os.path.realpath(settings.source)).parents:
            raise lines.error(
                "project-in-source",
                f"the folder '{project}' holds the robot '{settings.source}', and a new project "
                "wants a folder of its own",
                ("output", "project"),
                f"such as '{project.name}_robotran'",
            )
    if is_folder(settings.output):
        raise lines.error(
            "output-is-folder",
            f"the output '{settings.output}' is a folder",
            ("output",),
            "name the .mbs file; for a whole project: 'output: {project: FOLDER}'",
        )


def _same(first: Path, second: Path) -> bool:
    """True if two paths are one file, by a link or by letter case."""
    try:
        return first.samefile(second)
    except OSError:
        return first == second
