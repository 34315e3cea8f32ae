"""Where plugins come from, ours and those of installed packages, and the passes that they bring.

All metadata of the installed packages is not read, and the file of a pass only when it is needed.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Collection
from functools import cache, cached_property
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.disk.files import MAX_FILE_SIZE, is_file, read_beginning
from urdf2mbs.engine.tracebacks import FAILURES, in_words
from urdf2mbs.hookspecs import Pass, PassEntry
from urdf2mbs.messages.diagnostics import ConfigError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from urdf2mbs.conversion import Conversion

#: The entry point group in which an installed package names its plugin, and our own package.
GROUP = "urdf2mbs"


@cache
def find_own_plugins(path: tuple[str, ...]) -> dict[str, str]:
    """Return the plugins of our own package, as it is installed: the name and module of each.

    They are registered as anybody's, by entry points.  Our own are read without
    ``importlib.metadata``, whose import would be a tenth of a small conversion.

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
def installed_plugins(path: tuple[str, ...]) -> tuple[tuple[EntryPoint, str], ...]:
    """The installed plugins, each with its package.  ``path`` is ``sys.path``.

    The result is kept: a second search would take longer than the conversion of a small robot.
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
    """True if a package in a folder of ``sys.path`` may have entry points of our group.

    This does not import ``importlib.metadata``.

    Gain: a quarter of a process that converts a small robot, with 120 packages installed.
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
    """True if this finder cannot find a package outside ``sys.path``."""
    return finder is PathFinder or not hasattr(finder, "find_distributions")


@cache
def version_of(package: str) -> str:
    """The version of an installed package; empty where it is not known."""
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""


class Registered:
    """A pass and the plugin that brought it."""

    def __init__(
        self, brought: type[Pass] | PassEntry, plugin: str, package: str, file: str
    ) -> None:
        self.brought = brought
        self.plugin = plugin
        self.package = package
        """The package that brings the pass; empty for a file."""
        self._file = file

    @property
    def name(self) -> str:
        return self.brought.name

    @property
    def after(self) -> tuple[str, ...]:
        return self.brought.after

    def joins(self, presets: Collection[str]) -> bool:
        """True if the pass says its place in one of these presets, or in all."""
        own = self.brought.presets if isinstance(self.brought, PassEntry) else ()
        return not own or any(preset in presets for preset in own)

    @property
    def is_core(self) -> bool:
        return self.plugin == GROUP

    @property
    def is_ours(self) -> bool:
        return self.package == GROUP

    @cached_property
    def kind(self) -> type[Pass]:
        """The class of the pass; imports its file.  Raises ConfigError."""
        if not isinstance(self.brought, PassEntry):
            return self.brought
        name = self.brought.name
        try:
            module = import_module(f"{self.brought.package}.passes.{name.replace('-', '_')}")
            kind: type[Pass] = getattr(module, name.title().replace("-", ""))
        except FAILURES as error:
            raise ConfigError(
                "plugin-broken",
                f"plugin '{self.plugin}': pass '{name}' cannot be loaded: {in_words(error)}",
                file=self._file,
            ) from error
        return kind

    @property
    def file(self) -> str:
        """The file of the pass; that of the plugin, as long as the pass is not imported."""
        if isinstance(self.brought, PassEntry) and "kind" not in vars(self):
            return self._file
        return _source(self.kind, self.is_ours, self._file)

    @property
    def version(self) -> str:
        """The version of the package; empty if it is not known."""
        return version_of(self.package) if self.package else ""

    def has_work(self, conversion: Conversion, given: bool) -> bool:
        """True if the pass must run; ``given``: the config gives it options, or names it."""
        brought = self.brought
        return not isinstance(brought, PassEntry) or brought.work(conversion, given)


def _source(kind: type[Pass], is_ours: bool, file: str) -> str:
    """Return the file that a pass is written in: a plugin's own also where it lends our ``run``."""
    if not is_ours and kind.__module__.partition(".")[0].startswith(GROUP):
        return file
    return str(getattr(sys.modules.get(kind.__module__), "__file__", None) or file)
