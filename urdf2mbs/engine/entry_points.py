"""Finds the plugins of installed packages, our own among them, by their entry points.

The metadata of packages that have no plugin is not parsed.
"""

from __future__ import annotations

import os
import sys
from functools import cache
from importlib.machinery import PathFinder
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.disk.files import MAX_FILE_SIZE, is_file, read_beginning
from urdf2mbs.hookspecs import GROUP

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


@cache
def find_own_plugins(path: tuple[str, ...]) -> dict[str, str]:
    """Return the plugins of our own package, as it is installed: the name and module of each.

    They are registered as anybody's, by entry points.  Our own are read without
    ``importlib.metadata``, whose import would take a tenth of a small conversion.

    Args:
        path: ``sys.path``.
    """
    for folder in path:
        try:
            names = os.listdir(folder or ".")  # noqa: PTH208
        except OSError:
            continue
        for name in names:
            if name.startswith(f"{GROUP}-") and name.endswith((".dist-info", ".egg-info")):
                text = read_beginning(Path(folder, name, "entry_points.txt"), MAX_FILE_SIZE)
                if plugins := _read_group(text.decode("utf-8", "replace")):
                    return plugins
    return {}


def _read_group(text: str) -> dict[str, str]:
    """Return the names and modules of our group in the text of an ``entry_points.txt``."""
    plugins: dict[str, str] = {}
    in_group = False
    for line in text.splitlines():
        if line.startswith("["):
            in_group = line.strip() == f"[{GROUP}]"
        name, sign, module = line.partition("=")
        if in_group and sign:
            plugins[name.strip()] = module.strip()
    return plugins


@cache
def find_installed_plugins(path: tuple[str, ...]) -> tuple[tuple[EntryPoint, str], ...]:
    """Return the entry points of plugins of other packages, each with the name of its package.

    The result is kept: a second search would take longer than the conversion of a small robot.

    Args:
        path: ``sys.path``.
    """
    if not any(map(_may_name_plugins, path)) and all(map(_is_usual, sys.meta_path)):
        return ()
    from importlib import metadata

    packages = {dist.name: dist for dist in reversed([*metadata.distributions(path=[*path])])}
    return tuple(
        (entry, name)
        for name, package in reversed(packages.items())
        if name != GROUP
        for entry in package.entry_points.select(group=GROUP)
    )


def _may_name_plugins(folder: str) -> bool:
    """Return whether a package in a folder of ``sys.path`` may have entry points of our group.

    This does not import ``importlib.metadata``: it saves a quarter of a process that converts a
    small robot, with 120 packages installed.
    """
    if is_file(Path(folder)) or folder.endswith(".egg"):
        return True  # only importlib.metadata looks into a zip file
    try:
        names = os.listdir(folder)  # noqa: PTH208
    except OSError:
        return False
    group = f"[{GROUP}]".encode()
    return any(
        name.endswith(".egg")
        or group in read_beginning(Path(folder, name, "entry_points.txt"), MAX_FILE_SIZE)
        for name in names
        if name.lower().endswith((".dist-info", ".egg-info", ".egg"))
        and not name.startswith(f"{GROUP}-")
    )


def _is_usual(finder: object) -> bool:
    """Return whether this finder cannot find a package outside ``sys.path``."""
    return finder is PathFinder or not hasattr(finder, "find_distributions")


@cache
def version_of(distribution: str) -> str:
    """Return the version of an installed distribution; empty if it is not known."""
    from importlib import metadata

    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return ""
