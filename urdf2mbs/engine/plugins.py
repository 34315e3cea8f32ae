"""Finds and loads plugins, and remembers where each pass comes from."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Collection, Iterable, Sequence
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import pluggy

from urdf2mbs import hookspecs, passes
from urdf2mbs.config.model import Lines, Preset, typed
from urdf2mbs.disk.files import is_file
from urdf2mbs.engine.registered import (
    GROUP,
    Registered,
    find_own_plugins,
    installed_plugins,
    version_of,
)
from urdf2mbs.engine.tracebacks import FAILURES, frames_in, in_words, line_in
from urdf2mbs.hookspecs import Command, Pass, PassEntry
from urdf2mbs.messages.diagnostics import ConfigError, Diagnostic

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint
    from types import TracebackType

    from urdf2mbs.conversion import Conversion, Summary


def plugins_of(files: Sequence[Path], *, installed: bool) -> Plugins:
    """The plugins at hand.

    Without files of a config, the whole process shares them: a quarter of the time of a small
    robot among many.
    """
    if files:
        return Plugins(files, installed=installed)
    return _without_files(tuple(sys.path) if installed else None)


@cache
def _without_files(path: tuple[str, ...] | None) -> Plugins:
    return Plugins(installed=path is not None)


def our_names() -> dict[str, str]:
    """The functions and classes that our plugins offer by name: ``module:name``."""
    offered: Iterable[dict[str, str]] = (
        getattr(plugin, "urdf2mbs_api", dict)() for _, plugin in _ours()
    )
    return {name: place for names in offered for name, place in names.items()}


def of_ours(name: str) -> Any:
    """What one of our plugins has under this name; None: no plugin has it."""
    return _import(our_names().get(name))


def of_plugin(name: str, plugin: str) -> Any:
    """What one of our plugins has under this name; raises ConfigError without the plugin."""
    found = of_ours(name)
    if found is None:
        raise ConfigError(
            "plugin-missing", f"this is work for the plugin '{plugin}', which is not installed",
            hint=f"install urdf2mbs whole: the package {GROUP}_{plugin} is missing",
        )  # fmt: skip
    return found


def hooks_of(observer: object) -> Any:
    """The hooks of an object that is no plugin, to be called beside those of the plugins."""
    manager = pluggy.PluginManager(GROUP)
    manager.add_hookspecs(hookspecs)
    manager.register(observer)
    return manager.hook


class Plugins:
    """All plugins at hand: the core's passes, ours, the installed ones, and the config's files."""

    def __init__(self, files: Iterable[Path] = (), *, installed: bool = True) -> None:
        self._manager = pluggy.PluginManager(GROUP)
        self._manager.add_hookspecs(hookspecs)
        self._files: dict[str, str] = {}
        """The file of each plugin, by the plugin's name."""
        self._own = {GROUP}
        """The names of the core and of our own plugins."""
        self.broken: list[Diagnostic] = []
        """Installed plugins that are left out, and what is wrong with each."""
        self.hook: Any = self._manager.hook
        self.passes: dict[str, list[Registered]] = {}
        """Every pass by name; a built-in one stands before those of plugins."""
        self.presets: dict[str, Preset] = {}
        """Every preset by name; a later plugin's takes the place of an earlier one's."""
        self.commands: dict[str, Command] = {}
        """The commands of plugins."""
        self.api: dict[str, str] = {}
        """The functions and classes of plugins that others call by name: ``module:name``."""
        self._add(passes, GROUP, GROUP, passes.__file__ or "")
        for name, plugin in _ours():
            self._own.add(name)
            self._add(plugin, name, GROUP, plugin.__file__ or "")
        if installed:
            for entry, package in installed_plugins(tuple(sys.path)):
                self._add_installed(entry, package)
        for file in files:
            self._load_file(file)

    @cached_property
    def codes(self) -> dict[str, str]:
        """The codes of messages, those of plugins too, and what each means."""
        from urdf2mbs.engine import codes as of_engine
        from urdf2mbs.passes import codes as of_passes
        from urdf2mbs.urdf import codes as of_urdf

        codes = of_engine.CODES | of_passes.CODES | of_urdf.CODES
        for name in self._files:
            brought = self._brought(name, "urdf2mbs_codes", dict)
            codes |= {code: str(meaning) for code, meaning in brought.items()}
        return codes

    def blame(self, tb: TracebackType | None) -> tuple[str, str] | None:
        """The plugin (name, file) whose code a traceback went through; None: no plugin's."""
        for plugin, file in self._files.items():
            if plugin not in self._own and frames_in(file, tb):
                return plugin, file
        return None

    def with_hook(self, hook: str) -> list[str]:
        """The plugins, ours apart, that have a hook."""
        impls = getattr(self.hook, hook).get_hookimpls()
        return [impl.plugin_name for impl in impls if impl.plugin_name not in self._own]

    def summaries(self, conversion: Conversion) -> tuple[list[Summary], list[Diagnostic]]:
        """Return what plugins have to say of a conversion, and a warning for each that fails."""
        from urdf2mbs.conversion import Summary  # help needs none

        summaries, failures = list[Summary](), list[Diagnostic]()
        for impl in reversed(self.hook.urdf2mbs_summary.get_hookimpls()):
            file = self._files[impl.plugin_name]
            try:
                summary = impl.function(**dict.fromkeys(impl.argnames, conversion))
                if summary is not None:
                    fields = {name: getattr(summary, name) for name in Summary.__struct_fields__}
                    summaries.append(msgspec.convert(fields, Summary))
            except FAILURES as error:
                message = f"plugin '{impl.plugin_name}': urdf2mbs_summary failed: {in_words(error)}"
                line = line_in(Path(file), error)
                failures.append(
                    Diagnostic("warning", "plugin-summary", message, file=file, line=line)
                )
        return summaries, failures

    def find(self, name: str) -> Any:
        """The function or class of a plugin that others call by this name; None: no plugin has
        it."""
        return _import(self.api.get(name))

    @cached_property
    def method(self) -> list[str]:
        """The core's passes, and those of our plugins, in their order."""
        ours = [name for name, offered in self.passes.items() if offered[0].is_ours]
        core = [name for name in ours if not self.passes[name][0].after]
        return [name for name in self.join(core, self.presets) if name in ours]

    def join(self, names: Iterable[str], presets: Collection[str] = ()) -> list[str]:
        """Passes, and with them those of plugins that say their place among them.

        ``presets``: whose passes these are, and those that extend it.
        """
        joined = list(names)
        waiting = {
            name: offered[0].after for name, offered in self.passes.items()
            if offered[0].after and name not in joined and offered[0].joins(presets)
        }  # fmt: skip
        while waiting:
            # a pass stands behind others that wait, if they are among those that it names
            ready = (name for name, after in waiting.items() if waiting.keys().isdisjoint(after))
            name = next(ready, None) or next(iter(waiting))
            first, *others = waiting.pop(name)
            if first in joined:
                behind = [joined.index(other) for other in (first, *others) if other in joined]
                joined.insert(max(behind) + 1, name)
        return joined

    def only_passes(self, plugin: str) -> list[str]:
        """The passes that a plugin brings; none if it has other hooks too."""
        callers = self._manager.get_hookcallers(self._manager.get_plugin(plugin)) or []
        if any(caller.name != "urdf2mbs_passes" for caller in callers):
            return []
        return [
            name
            for name, offered in self.passes.items()
            if any(registered.plugin == plugin for registered in offered)
        ]

    def _add_installed(self, entry: EntryPoint, package: str) -> None:
        """Load an installed plugin.  A broken plugin is left out, and the conversion goes on."""
        try:
            try:
                plugin = entry.load()
            except FAILURES as error:
                fault = f"it cannot be loaded: {in_words(error)}"
                raise ConfigError("plugin-broken", fault) from error
            self._add(plugin, entry.name, package, getattr(plugin, "__file__", None) or package)
        except ConfigError as error:
            version = f"{package} {version_of(package)}"
            self.broken.append(Diagnostic(
                "warning", "plugin-broken",
                f"the installed plugin '{entry.name}' (package {version}) is left out: "
                f"{error.message}",
                file=error.file, line=error.line,
                hint="mend or uninstall it, or leave installed plugins out with --no-plugins",
            ))  # fmt: skip

    def _load_file(self, file: Path) -> None:
        import importlib.util
        import zlib

        if not is_file(file):
            raise ConfigError("plugin-missing", f"plugin file '{file}' does not exist")
        # files of one name in two folders must not take each other's place
        name = f"urdf2mbs_plugin_{file.stem}_{zlib.crc32(str(file).encode()):08x}"
        spec = importlib.util.spec_from_file_location(name, file)
        if spec is None or spec.loader is None:
            raise ConfigError("plugin-broken", f"plugin '{file}' is not a Python file (.py)")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except FAILURES as error:
            del sys.modules[name]
            hint = None
            if isinstance(error, ModuleNotFoundError):
                hint = "install it where urdf2mbs is; a plugin of several files must be a package"
            raise ConfigError(
                "plugin-broken", f"plugin '{file}' cannot be loaded: {in_words(error)}",
                file=str(file), line=line_in(file, error), hint=hint,
            ) from error  # fmt: skip
        self._add(module, file.stem, "", str(file))

    def _add(self, plugin: Any, name: str, package: str, file: str) -> None:
        """Register a plugin and note what it brings; nothing stays of a plugin that is wrong."""
        if name in self._files:
            raise ConfigError(
                "plugin-doubled",
                f"two plugins are called '{name}': {self._files[name]} and {file}",
                hint="load it once; or rename one file, or leave installed plugins out with "
                "--no-plugins",
            )
        self._files[name] = file
        try:
            self._register(plugin, name)
            passes = self._passes_of(name, package)
            commands = self._brought(name, "urdf2mbs_commands", list)
            api = self._brought(name, "urdf2mbs_api", dict)
            presets = self._presets_of(name)
        except ConfigError:
            del self._files[name]
            if self._manager.has_plugin(name):
                self._manager.unregister(name=name)
            raise
        for registered in passes:
            self.passes.setdefault(registered.name, []).append(registered)
        self.commands |= {command.name: command for command in commands}
        self.api |= api
        for key, preset in presets.items():
            self.presets[key] = preset

    def _register(self, plugin: Any, name: str) -> None:
        try:
            self._manager.register(plugin, name)
            self._manager.check_pending()
        except (pluggy.PluginValidationError, ValueError) as error:
            hint = f"the hooks are: {', '.join(_hooks())}"
            raise self._broken(name, " ".join(str(error).split()), hint) from error
        if not self._manager.get_hookcallers(plugin):
            raise ConfigError(
                "plugin-empty",
                f"plugin '{name}' brings nothing: no function in it is marked as a hook",
                file=self._files[name],
                hint="put '@hookimpl' above 'def urdf2mbs_passes():' "
                "(from urdf2mbs.plugin import hookimpl)",
            )

    def _presets_of(self, name: str) -> dict[str, Preset]:
        presets = {}
        for key, given in self._brought(name, "urdf2mbs_presets", dict).items():
            try:
                preset: Preset = typed(Preset, given, Lines())
                if not preset.pipeline and not preset.extends:
                    raise ConfigError(
                        "config-key-missing", "it has neither 'pipeline' nor 'extends'"
                    )
            except ConfigError as error:
                fault, hint = f"preset {key!r}: {error.message}", EXPECTED["urdf2mbs_presets"]
                raise self._broken(name, fault, hint) from None
            presets[key] = preset
        return presets

    def _brought(self, name: str, hook: str, kind: type[list[Any] | dict[str, Any]]) -> Any:
        """Return what a plugin's hook returns, a list or a dict.

        Raises:
            ConfigError: ``plugin-broken``, the hook fails or returns something else.
        """
        for impl in getattr(self.hook, hook).get_hookimpls():
            if impl.plugin_name == name:
                try:
                    brought = impl.function()
                except FAILURES as error:
                    fault = f"{hook} failed: {in_words(error)}"
                    raise self._broken(name, fault, "", error) from error
                if not isinstance(brought, kind):
                    returned = "nothing" if brought is None else repr(brought)
                    fault = f"{hook} returned {returned}; expected a {kind.__name__}"
                    raise self._broken(name, fault, EXPECTED[hook])
                return brought
        return kind()

    def _passes_of(self, name: str, package: str) -> Iterable[Registered]:
        found: dict[str, Registered] = {}
        for kind in self._brought(name, "urdf2mbs_passes", list):
            if isinstance(kind, PassEntry):
                found[kind.name] = Registered(kind, name, package, self._files[name])
                continue
            if not isinstance(kind, type) or not issubclass(kind, Pass):
                fault = f"urdf2mbs_passes gave {kind!r}, which is no subclass of Pass"
                raise self._broken(name, fault, EXPECTED["urdf2mbs_passes"])
            fault, hint = ("", "") if package == GROUP else _fault(kind)
            if fault:
                raise self._broken(name, f"pass {kind.name!r}: {fault}", hint)
            if kind.name in found:
                raise self._broken(name, f"it brings two passes '{kind.name}'", "rename one")
            found[kind.name] = Registered(kind, name, package, self._files[name])
        return found.values()

    def _broken(
        self, plugin: str, fault: str, hint: str, error: BaseException | None = None
    ) -> ConfigError:
        file = self._files[plugin]
        return ConfigError(
            "plugin-broken", f"plugin '{plugin}': {fault}", file=file, hint=hint or None,
            line=line_in(Path(file), error) if error else None,
        )  # fmt: skip


def _import(place: str | None) -> Any:
    if place is None:
        return None
    module, _, thing = place.partition(":")
    return getattr(import_module(module), thing) if thing else import_module(module)


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
def _ours() -> tuple[tuple[str, Any], ...]:
    """Return our own plugins, as far as they are there, each after those that it ``NEEDS``."""
    there: dict[str, Any] = {}
    for name, module in find_own_plugins(tuple(sys.path)).items():
        try:
            there[name] = import_module(module)
        except ModuleNotFoundError as error:
            if error.name != module:
                raise
    found: dict[str, Any] = {}
    while ready := [
        name
        for name, plugin in there.items()
        if name not in found and found.keys() >= {*getattr(plugin, "NEEDS", ())}
    ]:
        found |= {name: there[name] for name in ready}
    return tuple(found.items())


def _hooks() -> list[str]:
    """Each hook, and the arguments that it may have."""
    return [
        f"{hook}({', '.join(inspect.signature(spec).parameters)})"
        for hook, spec in vars(hookspecs).items()
        if hook.startswith("urdf2mbs_")
    ]


def _fault(kind: type[Pass]) -> tuple[str, str]:
    """What is wrong with a pass, and what to do; two empty texts: nothing is."""
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
            f"its options cannot be read from YAML: {in_words(error)}",
            "use bool, int, float, str, list, dict, tuple, Literal, or Structs of these",
        )
    return "", ""
