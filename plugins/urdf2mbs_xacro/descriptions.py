"""Robots by their name in the package ``robot_descriptions``: ``robot_descriptions:NAME``.

The package (extra ``robots``) knows where well over a hundred robots are published, and keeps what
it has fetched in a cache: ``~/.cache/robot_descriptions``, or ``$ROBOT_DESCRIPTIONS_CACHE``.
"""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from importlib import import_module
from pathlib import Path
from typing import Any

from urdf2mbs.plugin import ConfigError, Located, nearest, not_installed
from urdf2mbs_xacro import PREFIX


def locate(source: str) -> Located:
    """Return the file of ``robot_descriptions:NAME``, fetched if the cache does not have it.

    Raises:
        ConfigError: ``unknown-description``, ``description-no-urdf``, ``description-unreachable``.
    """
    from importlib.util import find_spec

    robot_name = source.removeprefix(PREFIX)
    module_name = f"robot_descriptions.{robot_name}"
    if find_spec("robot_descriptions") is None:
        raise not_installed("a robot by its name", "robot_descriptions")
    if not robot_name.isidentifier() or find_spec(module_name) is None:
        robot_names = _list_names()
        hint = _suggest_names(robot_name, robot_names)
        raise ConfigError(
            "unknown-description",
            f"robot_descriptions has no robot '{robot_name}'",
            hint=hint or f"it has {len(robot_names)}: see 'robot_descriptions list'",
        )
    module = _fetch(module_name, source)
    robot_file = getattr(module, "URDF_PATH", None) or getattr(module, "XACRO_PATH", None)
    if robot_file is None:
        raise ConfigError(
            "description-no-urdf",
            f"'{source}' is not a URDF: robot_descriptions has it in another format only",
            hint=nearest(robot_name.replace("_mj", ""), _list_names()),
        )
    xacro_args = {} if hasattr(module, "URDF_PATH") else getattr(module, "XACRO_ARGS", {})
    packages = getattr(module, "XACRO_PACKAGE_PATHS", {})
    return Located(
        Path(robot_file),
        {package: Path(folder) for package, folder in packages.items()},
        {argument: str(value) for argument, value in xacro_args.items()},
    )


def _suggest_names(robot_name: str, robot_names: list[str]) -> str | None:
    """Return a hint: the names that begin as this one, such as 'atlas', else the nearest."""
    similar = [
        similar_name
        for similar_name in robot_names
        if len(robot_name) > 1 and similar_name.startswith(robot_name)
    ]
    return f"there are: {', '.join(similar[:6])}" if similar else nearest(robot_name, robot_names)


def _fetch(module_name: str, source: str) -> Any:
    """Import the module of a robot, which fetches it; raise ConfigError."""
    try:
        with redirect_stdout(sys.stderr):  # where it reports progress
            return import_module(module_name)
    except Exception as error:  # git's own, and those of the network
        error_text = str(getattr(error, "stderr", "") or error)
        last_line = (error_text.strip().splitlines() or [""])[-1].strip()
        raise ConfigError(
            "description-unreachable",
            f"'{source}' is not in the cache, and cannot be fetched: {last_line}",
            hint="connect to the network once; the robot then stays in the cache, which is "
            "~/.cache/robot_descriptions or $ROBOT_DESCRIPTIONS_CACHE",
        ) from error


def _list_names() -> list[str]:
    """Return the robots that the package has as a URDF."""
    from robot_descriptions import DESCRIPTIONS

    return sorted(name for name, robot in DESCRIPTIONS.items() if robot.has_urdf)
