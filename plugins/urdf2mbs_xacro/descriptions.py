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
    """The file of ``robot_descriptions:NAME``; fetches it where the cache does not have it.

    :raises ConfigError: ``unknown-description``, ``description-no-urdf``,
        ``description-unreachable``
    """
    from importlib.util import find_spec

    name = source.removeprefix(PREFIX)
    module = f"robot_descriptions.{name}"
    if find_spec("robot_descriptions") is None:
        raise not_installed("a robot by its name", "robot_descriptions")
    if not name.isidentifier() or find_spec(module) is None:
        known = _names()
        raise ConfigError(
            "unknown-description",
            f"robot_descriptions has no robot '{name}'",
            hint=_likely(name, known) or f"it has {len(known)}; 'robot_descriptions list' tells",
        )
    found = _fetch(module, source)
    path = getattr(found, "URDF_PATH", None) or getattr(found, "XACRO_PATH", None)
    if path is None:
        raise ConfigError(
            "description-no-urdf",
            f"'{source}' is not a URDF: robot_descriptions has it in another format only",
            hint=nearest(name.replace("_mj", ""), _names()),
        )
    args = {} if hasattr(found, "URDF_PATH") else getattr(found, "XACRO_ARGS", {})
    packages = getattr(found, "XACRO_PACKAGE_PATHS", {})
    return Located(
        Path(path),
        {key: Path(folder) for key, folder in packages.items()},
        {key: str(value) for key, value in args.items()},
    )


def _likely(name: str, known: list[str]) -> str | None:
    """A hint: the names that begin as this one, such as 'atlas', else the nearest."""
    like = [robot for robot in known if len(name) > 1 and robot.startswith(name)]
    return f"there are: {', '.join(like[:6])}" if like else nearest(name, known)


def _fetch(module: str, source: str) -> Any:
    try:
        with redirect_stdout(sys.stderr):  # where it says what it fetches
            return import_module(module)
    except Exception as error:  # git's own, and those of the network
        said = str(getattr(error, "stderr", "") or error).strip().splitlines() or [""]
        raise ConfigError(
            "description-unreachable",
            f"'{source}' is not in the cache, and cannot be fetched: {said[-1].strip()}",
            hint="connect to the network once; the robot then stays in the cache, which is "
            "~/.cache/robot_descriptions or $ROBOT_DESCRIPTIONS_CACHE",
        ) from error


def _names() -> list[str]:
    """The robots that the package has as a URDF."""
    from robot_descriptions import DESCRIPTIONS

    return sorted(name for name, robot in DESCRIPTIONS.items() if robot.has_urdf)
