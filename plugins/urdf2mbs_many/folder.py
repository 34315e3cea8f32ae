"""Find the robots in a folder."""

from __future__ import annotations

import os
import unicodedata
from collections import Counter
from pathlib import Path
from typing import NoReturn

from urdf2mbs.plugin import ConfigError, is_file, is_robot_file, propose_in_folder, stem


def find_robots(folder: Path) -> dict[Path, Path]:
    """Find the robots in a folder and in those below it.

    A robot is a ``.urdf`` file, or a ``.xacro`` file whose ``<robot>`` has a name.

    Returns:
        The .mbs for each robot, relative to the output folder, by the robot's file.

    Raises:
        ConfigError: The folder contains no robot, or a folder cannot be read.
    """
    robot_files = sorted(
        robot_file
        for subfolder, _, file_names in os.walk(folder, onerror=_raise_unreadable)
        for robot_file in (Path(subfolder, file_name) for file_name in file_names)
        if is_file(robot_file) and is_robot_file(robot_file)
    )
    if not robot_files:
        message = (
            f"'{folder}' contains no robot: no .urdf file, and no .xacro file whose <robot> has a "
            "name"
        )
        hint = propose_in_folder(folder, "convert", "robot")
        raise ConfigError("folder-empty", message, hint=hint)
    outputs = {
        robot_file: robot_file.relative_to(folder).with_name(f"{stem(robot_file)}.mbs")
        for robot_file in robot_files
    }
    output_counts = Counter(get_file_key(str(output)) for output in outputs.values())
    for robot_file, output in outputs.items():
        if output_counts[get_file_key(str(output))] > 1:  # robot.urdf beside robot.urdf.xacro
            outputs[robot_file] = output.with_name(f"{robot_file.name.replace('.', '_')}.mbs")
    return outputs


def get_file_key(path: str) -> str:
    """Return a text that is equal for all names that Windows or macOS take for one file."""
    return unicodedata.normalize("NFC", os.path.normpath(path)).casefold()


def _raise_unreadable(error: OSError) -> NoReturn:
    """Raise an error for a folder that ``os.walk`` would otherwise skip silently."""
    raise ConfigError(
        "file-unreadable",
        f"cannot read the folder '{error.filename}': {error.strerror}",
        hint="check its permissions, or move it elsewhere",
    ) from None
