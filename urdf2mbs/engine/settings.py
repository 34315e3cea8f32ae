"""The settings of one conversion: what a config states, with absolute paths."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from urdf2mbs.config.lines import Lines
from urdf2mbs.config.model import Config, Project
from urdf2mbs.config.paths import make_absolute
from urdf2mbs.conversion import Settings
from urdf2mbs.disk.files import absolute, is_folder
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.urdf.reader import Located, stem


def make_settings(
    config: Config, lines: Lines, hook: Any = None, *, fresh: bool = False
) -> Settings:
    """Return the settings of a config, with absolute paths.

    Args:
        config: The config.
        lines: The line of each value of the config, and the folder of its relative paths.
        hook: The hooks of plugins, which find a robot by its name; None: the source is a file.
        fresh: Whether to start over, and discard the user's edits of the .mbs.

    Raises:
        ConfigError: A path of the config is wrong, or no robot has the name.
    """
    located: Located | None = None
    if hook is not None:
        located = hook.urdf2mbs_locate(source=config.source)
    if located is None:
        located = Located(make_absolute(config.source, lines, ("source",)), {}, {})
    source = absolute(located.source)
    packages = located.packages | {
        package_name: _find_package(package_name, folder, lines)
        for package_name, folder in config.packages.items()
    }
    project: Path | None = None
    languages: tuple[str, ...] = ()
    if isinstance(config.output, Project):
        project = make_absolute(config.output.project, lines, ("output", "project"))
        output = project / "dataR" / f"{identifiers([project.name])[0]}.mbs"
        languages = _list_languages(config.output)
    elif config.output is not None:
        output = make_absolute(config.output, lines, ("output",))
    else:
        output = absolute(lines.folder / f"{stem(source)}.mbs")
    return Settings(
        source=source,
        output=output,
        config=config,
        packages=packages,
        xacro_args=located.xacro_args | config.xacro_args,
        project=project,
        languages=languages,
        folder=absolute(lines.folder),
        fresh=fresh,
    )


def _find_package(package_name: str, stated_folder: str, config_lines: Lines) -> Path:
    """Return the folder of a ROS package; raises ConfigError if it does not exist."""
    package_folder = make_absolute(stated_folder, config_lines, ("packages", package_name))
    if not is_folder(package_folder):
        message = f"package '{package_name}': there is no folder '{package_folder}'"
        raise config_lines.error("package-missing", message, ("packages", package_name))
    return package_folder


def _list_languages(project: Project) -> tuple[str, ...]:
    """Return the languages of a project's code."""
    language = ["python", "c"] if project.language == "both" else project.language
    return (language,) if isinstance(language, str) else tuple(dict.fromkeys(language))


def check_output(settings: Settings, config_lines: Lines) -> None:
    """Raise ConfigError if the .mbs cannot be written to its place."""
    source, output, project = settings.source, settings.output, settings.project
    if is_folder(source):
        return
    if _is_same_file(output, source):
        message = f"the output would overwrite the robot '{source}'"
        raise config_lines.error("output-is-source", message, ("output",))
    if project is not None and not is_folder(project / "dataR") and _is_inside(source, project):
        message = (
            f"the folder '{project}' holds the robot '{source}'; "
            "expected a folder for the new project alone"
        )
        hint = f"such as '{project.name}_robotran'"
        raise config_lines.error("project-in-source", message, ("output", "project"), hint)
    if is_folder(output):
        message = f"the output '{output}' is a folder"
        hint = "name the .mbs file; for a whole project: 'output: {project: FOLDER}'"
        raise config_lines.error("output-is-folder", message, ("output",), hint)


def _is_inside(file_path: Path, folder: Path) -> bool:
    """Return whether a file is in a folder or its subfolders, with all links followed."""
    return Path(os.path.realpath(folder)) in Path(os.path.realpath(file_path)).parents


def _is_same_file(first_path: Path, second_path: Path) -> bool:
    """Return whether two paths are one file, by a link or by letter case."""
    try:
        return first_path.samefile(second_path)
    except OSError:
        return first_path == second_path
