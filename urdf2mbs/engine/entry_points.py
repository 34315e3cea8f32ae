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
def find_own_plugins(search_path: tuple[str, ...]) -> dict[str, str]:
    """Return the plugins of our own package, as it is installed: the name and module of each.

    They are registered as anybody's, by entry points.  Our own are read without
    ``importlib.metadata``, whose import would take a tenth of a small conversion.

    Args:
        search_path: ``sys.path``.
    """
    for folder in search_path:
        try:
            entry_names = os.listdir(folder or ".")  # noqa: PTH208
        except OSError:
            continue
        for entry_name in entry_names:
            if entry_name.startswith(f"{GROUP}-") and entry_name.endswith(
                (".dist-info", ".egg-info")
            ):
                metadata_text = read_beginning(
                    Path(folder, entry_name, "entry_points.txt"), MAX_FILE_SIZE
                )
                if plugins := _read_group(metadata_text.decode("utf-8", "replace")):
                    return plugins
    return {}


def _read_group(metadata_text: str) -> dict[str, str]:
    """Return the names and modules of our group in the text of an ``entry_points.txt``."""
    plugins: dict[str, str] = {}
    in_group = False
    for line in metadata_text.splitlines():
        if line.startswith("["):
            in_group = line.strip() == f"[{GROUP}]"
        plugin_name, separator, module_name = line.partition("=")
        if in_group and separator:
            plugins[plugin_name.strip()] = module_name.strip()
    return plugins


@cache
def find_installed_plugins(search_path: tuple[str, ...]) -> tuple[tuple[EntryPoint, str], ...]:
    """Return the entry points of plugins of other packages, each with the name of its package.

    The result is kept: a second search would take longer than the conversion of a small robot.

    Args:
        search_path: ``sys.path``.
    """
    if not any(map(_may_name_plugins, search_path)) and all(map(_is_usual, sys.meta_path)):
        return ()
    from importlib import metadata

    packages = {
        distribution.name: distribution
        for distribution in reversed([*metadata.distributions(path=[*search_path])])
    }
    return tuple(
        (entry_point, package_name)
        for package_name, package in reversed(packages.items())
        if package_name != GROUP
        for entry_point in package.entry_points.select(group=GROUP)
    )


def _may_name_plugins(folder: str) -> bool:
    """Return whether a package in a folder of ``sys.path`` may have entry points of our group.

    This does not import ``importlib.metadata``: it saves a quarter of a process that converts a
    small robot, with 120 packages installed.
    """
    if is_file(Path(folder)) or folder.endswith(".egg"):
        return True  # only importlib.metadata looks into a zip file
    try:
        entry_names = os.listdir(folder)  # noqa: PTH208
    except OSError:
        return False
    group_header = f"[{GROUP}]".encode()
    return any(
        entry_name.endswith(".egg")
        or group_header
        in read_beginning(Path(folder, entry_name, "entry_points.txt"), MAX_FILE_SIZE)
        for entry_name in entry_names
        if entry_name.lower().endswith((".dist-info", ".egg-info", ".egg"))
        and not entry_name.startswith(f"{GROUP}-")
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
