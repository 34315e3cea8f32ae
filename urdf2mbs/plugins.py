"""Finds and loads plugins, and remembers where each pass comes from."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path
from typing import Any, cast

import msgspec
import pluggy

from urdf2mbs import hookspecs, passes
from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.hookspecs import Pass

#: The entry point group in which an installed package names its plugin, and our own name there.
GROUP = "urdf2mbs"


class Found(msgspec.Struct, frozen=True):
    """A pass and the plugin that brought it."""

    pass_: Pass
    plugin: str
    version: str
    file: str


class Plugins:
    """All plugins at hand: the built-in one, the installed ones, and the config's files."""

    def __init__(self, files: Iterable[Path] = (), *, installed: bool = True) -> None:
        self._manager = pluggy.PluginManager(GROUP)
        self._manager.add_hookspecs(hookspecs)
        self._origin: dict[str, tuple[str, str]] = {}
        self._register(passes, GROUP, _version(GROUP), "")
        if installed:
            for entry in metadata.entry_points(group=GROUP):
                self._load_installed(entry)
        for file in files:
            self._load_file(file)
        self.hook: Any = self._manager.hook
        self.passes: dict[str, list[Found]] = {}
        for impl in self.hook.urdf2mbs_passes.get_hookimpls():
            self._collect(impl)

    def watch(self, observer: object) -> None:
        """Let an object's own hooks be called too, around every pass."""
        self._manager.register(observer)

    def _load_installed(self, entry: metadata.EntryPoint) -> None:
        dist = entry.dist
        package, version = (dist.name, dist.version) if dist else ("?", "?")
        try:
            plugin = entry.load()
        except Exception as error:
            raise ConfigError(
                "plugin-broken",
                f"installed plugin '{entry.name}' (package {package} {version}) cannot be loaded: "
                f"{type(error).__name__}: {error}",
                hint="mend or uninstall it, or leave installed plugins out with --no-plugins",
            ) from error
        self._register(plugin, entry.name, version, package)

    def _load_file(self, file: Path) -> None:
        if not file.is_file():
            raise ConfigError("plugin-missing", f"plugin file '{file}' does not exist")
        name = f"urdf2mbs_plugin_{file.stem}"
        spec = importlib.util.spec_from_file_location(name, file)
        if spec is None or spec.loader is None:
            raise ConfigError("plugin-broken", f"plugin '{file}' is not a Python file (.py)")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException as error:
            del sys.modules[name]
            if isinstance(error, KeyboardInterrupt):
                raise
            raise ConfigError(
                "plugin-broken",
                f"plugin '{file}' cannot be loaded: {type(error).__name__}: {error}",
                file=str(file), line=_line_in(file, error),
            ) from error  # fmt: skip
        self._register(module, file.stem, "", str(file))

    def _register(self, plugin: Any, name: str, version: str, origin: str) -> None:
        try:
            self._manager.register(plugin, name)
            self._manager.check_pending()
        except (pluggy.PluginValidationError, ValueError) as error:
            raise ConfigError("plugin-broken", f"plugin '{name}': {error}") from error
        if not self._manager.get_hookcallers(plugin):
            raise ConfigError(
                "plugin-empty",
                f"plugin '{name}' brings nothing: no function in it is a hook",
                hint="mark one with '@hookimpl' (from urdf2mbs.hookspecs import hookimpl)",
            )
        self._origin[name] = (version, origin)

    def _collect(self, impl: pluggy.HookImpl) -> None:
        name = impl.plugin_name
        version, origin = self._origin[name]
        try:
            found: list[Any] = list(cast("Any", impl.function()))
        except Exception as error:
            raise ConfigError(
                "plugin-broken",
                f"plugin '{name}': urdf2mbs_passes failed: {type(error).__name__}: {error}",
                file=origin or None,
            ) from error
        for pass_ in found:
            if not isinstance(pass_, Pass):
                raise ConfigError(
                    "plugin-broken",
                    f"plugin '{name}': urdf2mbs_passes gave {pass_!r}, which is no Pass",
                    file=origin or None,
                )
            file = getattr(sys.modules.get(pass_.run.__module__), "__file__", None) or origin
            offered = self.passes.setdefault(pass_.name, [])
            if any(other.plugin == name for other in offered):
                raise ConfigError(
                    "plugin-broken", f"plugin '{name}' brings two passes '{pass_.name}'"
                )
            found_pass = Found(pass_, name, version, str(file))
            # pluggy calls the last registered first; built-in passes stay first in the list
            offered.insert(0, found_pass)


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""


def _line_in(file: Path, error: BaseException) -> int | None:
    if isinstance(error, SyntaxError):
        return error.lineno
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(file)]
    return lines[-1] if lines else None
