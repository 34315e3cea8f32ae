"""Loads plugins, and collects what they bring: passes, presets, commands, codes, names."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterable, Sequence
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import pluggy

from urdf2mbs import hookspecs, passes
from urdf2mbs.config.lines import Lines
from urdf2mbs.config.load import typed
from urdf2mbs.config.model import Preset
from urdf2mbs.disk.files import is_file
from urdf2mbs.engine.entry_points import find_installed_plugins, find_own_plugins, version_of
from urdf2mbs.hookspecs import GROUP, Command, Pass, PassEntry, always
from urdf2mbs.messages.diagnostics import ConfigError, Diagnostic
from urdf2mbs.messages.tracebacks import FAILURES, describe_exception, find_line, list_frames

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint
    from types import ModuleType, TracebackType


def load_plugins(files: Sequence[Path] = (), *, installed: bool = True) -> Plugins:
    """Return the core, our plugins, installed plugins and those of some files.

    Without files, the whole process shares the result: loading takes a quarter of the time of a
    small robot among many.

    Args:
        files: The plugin files of a config.
        installed: Whether to load the plugins of other installed packages.
    """
    if files:
        return Plugins(files, installed=installed)
    return _load_shared(tuple(sys.path) if installed else None)


@cache
def _load_shared(path: tuple[str, ...] | None) -> Plugins:
    return Plugins(installed=path is not None)


def load_pass(entry: PassEntry) -> type[Pass]:
    """Import the class of a pass.

    Raises:
        ConfigError: ``plugin-broken``, its file cannot be imported.
    """
    try:
        return entry.load()
    except FAILURES as error:
        message = (
            f"plugin '{entry.plugin}': pass '{entry.name}' cannot be loaded: "
            f"{describe_exception(error)}"
        )
        raise ConfigError("plugin-broken", message, file=entry.file) from error


class Plugins:
    """The core's passes, our plugins, the installed ones, and the plugin files of a config."""

    def __init__(self, files: Iterable[Path] = (), *, installed: bool = True) -> None:
        self._manager = pluggy.PluginManager(GROUP)
        self._manager.add_hookspecs(hookspecs)
        self._files: dict[str, str] = {}
        """The file of each plugin, by the plugin's name."""
        self._own = {GROUP}
        """The names of the core and of our own plugins."""
        self.broken: list[Diagnostic] = []
        """A warning for each installed plugin that is left out."""
        self.hook: Any = self._manager.hook
        self.passes: dict[str, list[PassEntry]] = {}
        """Every pass by name; one of ours comes before those of other plugins."""
        self.presets: dict[str, Preset] = {}
        """Every preset by name; a later plugin's replaces an earlier one's."""
        self.commands: dict[str, Command] = {}
        """The commands of plugins."""
        self.api: dict[str, str] = {}
        """The names that plugins offer to users of Python: ``module:name`` of each."""
        self._add(passes, GROUP, GROUP, passes.__file__ or "")
        for name, plugin in _load_own_plugins():
            self._own.add(name)
            self._add(plugin, name, GROUP, plugin.__file__ or "")
        if installed:
            for entry_point, distribution in find_installed_plugins(tuple(sys.path)):
                self._add_installed(entry_point, distribution)
        for file in files:
            self._add_file(file)

    @cached_property
    def codes(self) -> dict[str, str]:
        """The codes of messages, those of plugins too, and the meaning of each."""
        from urdf2mbs.engine import codes as engine_codes
        from urdf2mbs.passes import codes as pass_codes
        from urdf2mbs.urdf import codes as urdf_codes

        codes = engine_codes.CODES | pass_codes.CODES | urdf_codes.CODES
        for name in self._files:
            offered = self._call(name, "urdf2mbs_codes", dict)
            codes |= {code: str(meaning) for code, meaning in offered.items()}
        return codes

    def find_culprit(self, traceback: TracebackType | None) -> tuple[str, str] | None:
        """Return the other author's plugin (name, file) whose code a traceback went through."""
        for plugin, file in self._files.items():
            if plugin not in self._own and list_frames(file, traceback):
                return plugin, file
        return None

    def find_hook_users(self, hook: str) -> list[str]:
        """Return the other authors' plugins that have a hook."""
        impls = getattr(self.hook, hook).get_hookimpls()
        return [impl.plugin_name for impl in impls if impl.plugin_name not in self._own]

    def load_name(self, name: str) -> Any:
        """Return what ``urdf2mbs.NAME`` of a plugin is; None: no plugin offers the name."""
        place = self.api.get(name)
        if place is None:
            return None
        module, _, attribute = place.partition(":")
        loaded = import_module(module)
        return getattr(loaded, attribute) if attribute else loaded

    def list_only_passes(self, plugin: str) -> list[str]:
        """Return the passes of a plugin that brings nothing else; otherwise an empty list."""
        callers = self._manager.get_hookcallers(self._manager.get_plugin(plugin)) or []
        if any(caller.name != "urdf2mbs_passes" for caller in callers):
            return []
        return [
            name
            for name, entries in self.passes.items()
            if any(entry.plugin == plugin for entry in entries)
        ]

    def _add_installed(self, entry_point: EntryPoint, distribution: str) -> None:
        """Load an installed plugin.  A broken one is left out, with a warning."""
        try:
            try:
                plugin = entry_point.load()
            except FAILURES as error:
                message = f"it cannot be loaded: {describe_exception(error)}"
                raise ConfigError("plugin-broken", message) from error
            file = getattr(plugin, "__file__", None) or distribution
            self._add(plugin, entry_point.name, distribution, file)
        except ConfigError as error:
            package = f"{distribution} {version_of(distribution)}"
            message = (
                f"the installed plugin '{entry_point.name}' (package {package}) is left out: "
                f"{error.message}"
            )
            hint = "fix or uninstall it, or leave installed plugins out with --no-plugins"
            warning = Diagnostic(
                "warning", "plugin-broken", message, file=error.file, line=error.line, hint=hint
            )
            self.broken.append(warning)

    def _add_file(self, file: Path) -> None:
        if not is_file(file):
            raise ConfigError("plugin-missing", f"plugin file '{file}' does not exist")
        try:
            module = _import_file(file)
        except FAILURES as error:
            hint = None
            if isinstance(error, ModuleNotFoundError):
                hint = "install it where urdf2mbs is; a plugin of several files must be a package"
            message = f"plugin '{file}' cannot be loaded: {describe_exception(error)}"
            line = find_line(file, error)
            raise ConfigError(
                "plugin-broken", message, file=str(file), line=line, hint=hint
            ) from error
        if module is None:
            raise ConfigError("plugin-broken", f"plugin '{file}' is not a Python file (.py)")
        self._add(module, file.stem, "", str(file))

    def _add(self, plugin: Any, name: str, distribution: str, file: str) -> None:
        """Register a plugin and collect what it brings; a plugin with an error leaves nothing."""
        if name in self._files:
            message = f"two plugins are called '{name}': {self._files[name]} and {file}"
            hint = (
                "load it once; or rename one file, or leave installed plugins out with --no-plugins"
            )
            raise ConfigError("plugin-doubled", message, hint=hint)
        self._files[name] = file
        try:
            self._register(plugin, name)
            entries = self._list_passes(name, distribution)
            commands = self._call(name, "urdf2mbs_commands", list)
            api = self._call(name, "urdf2mbs_api", dict)
            presets = self._read_presets(name)
        except ConfigError:
            del self._files[name]
            if self._manager.has_plugin(name):
                self._manager.unregister(name=name)
            raise
        for entry in entries:
            self.passes.setdefault(entry.name, []).append(entry)
        self.commands |= {command.name: command for command in commands}
        self.api |= api
        self.presets |= presets

    def _register(self, plugin: Any, name: str) -> None:
        try:
            self._manager.register(plugin, name)
            self._manager.check_pending()
        except (pluggy.PluginValidationError, ValueError) as error:
            hint = f"the hooks are: {', '.join(_list_hooks())}"
            raise self._fault(name, " ".join(str(error).split()), hint) from error
        if not self._manager.get_hookcallers(plugin):
            message = f"plugin '{name}' brings nothing: no function in it is marked as a hook"
            hint = (
                "put '@hookimpl' above 'def urdf2mbs_passes():' "
                "(from urdf2mbs.plugin import hookimpl)"
            )
            raise ConfigError("plugin-empty", message, file=self._files[name], hint=hint)

    def _call(self, name: str, hook: str, kind: type[list[Any] | dict[str, Any]]) -> Any:
        """Return what a plugin's hook returns, a list or a dict.

        Raises:
            ConfigError: ``plugin-broken``, the hook fails or returns something else.
        """
        for impl in getattr(self.hook, hook).get_hookimpls():
            if impl.plugin_name == name:
                try:
                    returned = impl.function()
                except FAILURES as error:
                    message = f"{hook} failed: {describe_exception(error)}"
                    line = find_line(Path(self._files[name]), error)
                    raise self._fault(name, message, line=line) from error
                if not isinstance(returned, kind):
                    value = "nothing" if returned is None else repr(returned)
                    message = f"{hook} returned {value}; expected a {kind.__name__}"
                    raise self._fault(name, message, EXPECTED[hook])
                return returned
        return kind()

    def _read_presets(self, name: str) -> dict[str, Preset]:
        presets: dict[str, Preset] = {}
        for key, data in self._call(name, "urdf2mbs_presets", dict).items():
            try:
                preset: Preset = typed(Preset, data, Lines())
                if not preset.pipeline and not preset.extends:
                    message = "it has neither 'pipeline' nor 'extends'"
                    raise ConfigError("config-key-missing", message)
            except ConfigError as error:
                message = f"preset {key!r}: {error.message}"
                raise self._fault(name, message, EXPECTED["urdf2mbs_presets"]) from None
            presets[key] = preset
        return presets

    def _list_passes(self, name: str, distribution: str) -> Iterable[PassEntry]:
        """Return the passes of a plugin, each with the plugin's name and file."""
        entries: dict[str, PassEntry] = {}
        for item in self._call(name, "urdf2mbs_passes", list):
            entry = item if isinstance(item, PassEntry) else self._enter(item, name, distribution)
            if entry.name in entries:
                raise self._fault(name, f"it brings two passes '{entry.name}'", "rename one")
            entries[entry.name] = msgspec.structs.replace(
                entry, plugin=name, distribution=distribution, file=self._files[name]
            )
        return entries.values()

    def _enter(self, item: Any, name: str, distribution: str) -> PassEntry:
        """Return the entry for a class of a pass; raises ConfigError if it is none."""
        if not isinstance(item, type) or not issubclass(item, Pass):
            message = f"urdf2mbs_passes returned {item!r}; expected a subclass of Pass"
            raise self._fault(name, message, EXPECTED["urdf2mbs_passes"])
        fault, hint = ("", "") if distribution == GROUP else _find_fault(item)
        if fault:
            raise self._fault(name, f"pass {item.name!r}: {fault}", hint)
        return PassEntry(item.name, "", tuple(item.after), always, kind=item)

    def _fault(
        self, plugin: str, message: str, hint: str = "", *, line: int | None = None
    ) -> ConfigError:
        """Return the error for a plugin that is wrong."""
        return ConfigError(
            "plugin-broken",
            f"plugin '{plugin}': {message}",
            file=self._files[plugin],
            line=line,
            hint=hint or None,
        )


#: What each hook of a plugin returns.
EXPECTED = {
    "urdf2mbs_passes": "return a list of the classes of your passes, such as [MyPass]",
    "urdf2mbs_codes": "return the codes, such as {'links-dropped': 'warning: links are left out'}",
    "urdf2mbs_commands": "return a list, such as [Command('weigh', 'weigh a robot', "
    "'my_package.weigh')]",
    "urdf2mbs_api": "return names and places, such as {'weigh': 'my_package.weigh:weigh'}",
    "urdf2mbs_presets": "{'my-preset': {'extends': 'compact', 'after': {'expand': 'my-pass'}}}",
}


@cache
def _load_own_plugins() -> tuple[tuple[str, Any], ...]:
    """Return our own plugins that are installed, each after those that it ``NEEDS``."""
    modules: dict[str, Any] = {}
    for name, module in find_own_plugins(tuple(sys.path)).items():
        try:
            modules[name] = import_module(module)
        except ModuleNotFoundError as error:
            if error.name != module:
                raise
    loaded: dict[str, Any] = {}
    while ready := [
        name
        for name, plugin in modules.items()
        if name not in loaded and loaded.keys() >= {*getattr(plugin, "NEEDS", ())}
    ]:
        loaded |= {name: modules[name] for name in ready}
    return tuple(loaded.items())


def _import_file(file: Path) -> ModuleType | None:
    """Import a plugin file under a name of its own; None: it is no Python file."""
    import importlib.util
    import zlib

    # files of one name in two folders must not replace each other
    name = f"urdf2mbs_plugin_{file.stem}_{zlib.crc32(str(file).encode()):08x}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        return None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except FAILURES:
        del sys.modules[name]
        raise
    return module


def _list_hooks() -> list[str]:
    """Return each hook, with the arguments that it may have."""
    return [
        f"{hook}({', '.join(inspect.signature(spec).parameters)})"
        for hook, spec in vars(hookspecs).items()
        if hook.startswith("urdf2mbs_")
    ]


def _find_fault(kind: type[Pass]) -> tuple[str, str]:
    """Return what is wrong with a pass and what to do; two empty texts if nothing is wrong."""
    if not isinstance(kind.name, str) or not kind.name.strip():
        return "its name is not a word", "call it something like 'my-pass'"
    if kind.run is Pass.run:
        return "it has no method 'run'", "def run(self, conversion):"
    try:
        inspect.signature(kind.run).bind(None, None)
    except TypeError:
        return "its 'run' cannot be called with a conversion", "def run(self, conversion):"
    for field in ("reads", "writes"):
        sections = getattr(kind, field)
        if not isinstance(sections, (tuple, list)) or not all(
            isinstance(section, str) for section in sections
        ):
            return f"'{field}' is {sections!r}", f"write it as {field} = ('robot',), with the comma"
    try:
        msgspec.json.schema(kind)
    except FAILURES as error:
        return (
            f"its options cannot be read from YAML: {describe_exception(error)}",
            "use bool, int, float, str, list, dict, tuple, Literal, or Structs of these",
        )
    return "", ""
