"""Loads plugins, and collects their passes, presets, commands, codes, names."""

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
def _load_shared(search_path: tuple[str, ...] | None) -> Plugins:
    return Plugins(installed=search_path is not None)


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
        self._plugin_files: dict[str, str] = {}
        """The file of each plugin, by the plugin's name."""
        self._own_plugins = {GROUP}
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
        self._add_plugin(passes, GROUP, GROUP, passes.__file__ or "")
        for plugin_name, plugin in _load_own_plugins():
            self._own_plugins.add(plugin_name)
            self._add_plugin(plugin, plugin_name, GROUP, plugin.__file__ or "")
        if installed:
            for entry_point, distribution in find_installed_plugins(tuple(sys.path)):
                self._add_installed(entry_point, distribution)
        for plugin_file in files:
            self._add_file(plugin_file)

    @cached_property
    def codes(self) -> dict[str, str]:
        """The codes of messages, those of plugins too, and the meaning of each."""
        from urdf2mbs.engine import codes as engine_codes
        from urdf2mbs.passes import codes as pass_codes
        from urdf2mbs.urdf import codes as urdf_codes

        codes = engine_codes.CODES | pass_codes.CODES | urdf_codes.CODES
        for plugin_name in self._plugin_files:
            offered_codes = self._call_hook(plugin_name, "urdf2mbs_codes", dict)
            codes |= {code: str(meaning) for code, meaning in offered_codes.items()}
        return codes

    def find_culprit(self, traceback: TracebackType | None) -> tuple[str, str] | None:
        """Return the other author's plugin (name, file) whose code a traceback went through."""
        for plugin_name, plugin_file in self._plugin_files.items():
            if plugin_name not in self._own_plugins and list_frames(plugin_file, traceback):
                return plugin_name, plugin_file
        return None

    def find_hook_users(self, hook_name: str) -> list[str]:
        """Return the other authors' plugins that have a hook."""
        hook_impls = getattr(self.hook, hook_name).get_hookimpls()
        return [
            hook_impl.plugin_name
            for hook_impl in hook_impls
            if hook_impl.plugin_name not in self._own_plugins
        ]

    def load_name(self, api_name: str) -> Any:
        """Return what ``urdf2mbs.NAME`` of a plugin is; None: no plugin offers the name."""
        target = self.api.get(api_name)
        if target is None:
            return None
        module_name, _, attribute = target.partition(":")
        module = import_module(module_name)
        return getattr(module, attribute) if attribute else module

    def list_only_passes(self, plugin_name: str) -> list[str]:
        """Return the passes of a plugin that brings nothing else; otherwise an empty list."""
        hook_callers = self._manager.get_hookcallers(self._manager.get_plugin(plugin_name)) or []
        if any(hook_caller.name != "urdf2mbs_passes" for hook_caller in hook_callers):
            return []
        return [
            pass_name
            for pass_name, entries in self.passes.items()
            if any(entry.plugin == plugin_name for entry in entries)
        ]

    def _add_installed(self, entry_point: EntryPoint, distribution: str) -> None:
        """Load an installed plugin.  A broken one is left out, with a warning."""
        try:
            try:
                plugin = entry_point.load()
            except FAILURES as error:
                message = f"it cannot be loaded: {describe_exception(error)}"
                raise ConfigError("plugin-broken", message) from error
            plugin_file = getattr(plugin, "__file__", None) or distribution
            self._add_plugin(plugin, entry_point.name, distribution, plugin_file)
        except ConfigError as error:
            package_version = f"{distribution} {version_of(distribution)}"
            message = (
                f"the installed plugin '{entry_point.name}' (package {package_version}) is left "
                f"out: {error.message}"
            )
            hint = "fix or uninstall it, or leave installed plugins out with --no-plugins"
            warning = Diagnostic(
                "warning", "plugin-broken", message, file=error.file, line=error.line, hint=hint
            )
            self.broken.append(warning)

    def _add_file(self, plugin_file: Path) -> None:
        if not is_file(plugin_file):
            raise ConfigError("plugin-missing", f"plugin file '{plugin_file}' does not exist")
        try:
            module = _import_plugin_file(plugin_file)
        except FAILURES as error:
            hint = None
            if isinstance(error, ModuleNotFoundError):
                hint = "install it where urdf2mbs is; a plugin of several files must be a package"
            message = f"plugin '{plugin_file}' cannot be loaded: {describe_exception(error)}"
            line = find_line(plugin_file, error)
            raise ConfigError(
                "plugin-broken", message, file=str(plugin_file), line=line, hint=hint
            ) from error
        if module is None:
            raise ConfigError("plugin-broken", f"plugin '{plugin_file}' is not a Python file (.py)")
        self._add_plugin(module, plugin_file.stem, "", str(plugin_file))

    def _add_plugin(
        self, plugin: Any, plugin_name: str, distribution: str, plugin_file: str
    ) -> None:
        """Register a plugin and collect its passes and commands, unless it has an error."""
        if plugin_name in self._plugin_files:
            loaded_file = self._plugin_files[plugin_name]
            message = f"two plugins are called '{plugin_name}': {loaded_file} and {plugin_file}"
            hint = (
                "load it once; or rename one file, or leave installed plugins out with --no-plugins"
            )
            raise ConfigError("plugin-doubled", message, hint=hint)
        self._plugin_files[plugin_name] = plugin_file
        try:
            self._register_hooks(plugin, plugin_name)
            entries = self._list_passes(plugin_name, distribution)
            commands = self._call_hook(plugin_name, "urdf2mbs_commands", list)
            api_names = self._call_hook(plugin_name, "urdf2mbs_api", dict)
            presets = self._read_presets(plugin_name)
        except ConfigError:
            del self._plugin_files[plugin_name]
            if self._manager.has_plugin(plugin_name):
                self._manager.unregister(name=plugin_name)
            raise
        for entry in entries:
            self.passes.setdefault(entry.name, []).append(entry)
        self.commands |= {command.name: command for command in commands}
        self.api |= api_names
        self.presets |= presets

    def _register_hooks(self, plugin: Any, plugin_name: str) -> None:
        try:
            self._manager.register(plugin, plugin_name)
            self._manager.check_pending()
        except (pluggy.PluginValidationError, ValueError) as error:
            hint = f"the hooks are: {', '.join(_list_hooks())}"
            raise self._broken_plugin_error(
                plugin_name, " ".join(str(error).split()), hint
            ) from error
        if not self._manager.get_hookcallers(plugin):
            message = (
                f"plugin '{plugin_name}' brings nothing: no function in it is marked as a hook"
            )
            hint = (
                "put '@hookimpl' above 'def urdf2mbs_passes():' "
                "(from urdf2mbs.plugin import hookimpl)"
            )
            raise ConfigError(
                "plugin-empty", message, file=self._plugin_files[plugin_name], hint=hint
            )

    def _call_hook(
        self, plugin_name: str, hook_name: str, expected_type: type[list[Any] | dict[str, Any]]
    ) -> Any:
        """Return what a plugin's hook returns, a list or a dict.

        Raises:
            ConfigError: ``plugin-broken``, the hook fails or returns something else.
        """
        for hook_impl in getattr(self.hook, hook_name).get_hookimpls():
            if hook_impl.plugin_name == plugin_name:
                try:
                    returned = hook_impl.function()
                except FAILURES as error:
                    message = f"{hook_name} failed: {describe_exception(error)}"
                    line = find_line(Path(self._plugin_files[plugin_name]), error)
                    raise self._broken_plugin_error(plugin_name, message, line=line) from error
                if not isinstance(returned, expected_type):
                    returned_text = "nothing" if returned is None else repr(returned)
                    message = (
                        f"{hook_name} returned {returned_text}; expected a {expected_type.__name__}"
                    )
                    raise self._broken_plugin_error(plugin_name, message, EXPECTED[hook_name])
                return returned
        return expected_type()

    def _read_presets(self, plugin_name: str) -> dict[str, Preset]:
        presets: dict[str, Preset] = {}
        for preset_name, preset_data in self._call_hook(
            plugin_name, "urdf2mbs_presets", dict
        ).items():
            try:
                preset: Preset = typed(Preset, preset_data, Lines())
                if not preset.pipeline and not preset.extends:
                    message = "it has neither 'pipeline' nor 'extends'"
                    raise ConfigError("config-key-missing", message)
            except ConfigError as error:
                message = f"preset {preset_name!r}: {error.message}"
                raise self._broken_plugin_error(
                    plugin_name, message, EXPECTED["urdf2mbs_presets"]
                ) from None
            presets[preset_name] = preset
        return presets

    def _list_passes(self, plugin_name: str, distribution: str) -> Iterable[PassEntry]:
        """Return the passes of a plugin, each with the plugin's name and file."""
        entries_by_name: dict[str, PassEntry] = {}
        for pass_or_entry in self._call_hook(plugin_name, "urdf2mbs_passes", list):
            entry = (
                pass_or_entry
                if isinstance(pass_or_entry, PassEntry)
                else self._make_entry(pass_or_entry, plugin_name, distribution)
            )
            if entry.name in entries_by_name:
                raise self._broken_plugin_error(
                    plugin_name, f"it brings two passes '{entry.name}'", "rename one"
                )
            entries_by_name[entry.name] = msgspec.structs.replace(
                entry,
                plugin=plugin_name,
                distribution=distribution,
                file=self._plugin_files[plugin_name],
            )
        return entries_by_name.values()

    def _make_entry(self, pass_class: Any, plugin_name: str, distribution: str) -> PassEntry:
        """Return the entry for a class of a pass; raises ConfigError if it is none."""
        if not isinstance(pass_class, type) or not issubclass(pass_class, Pass):
            message = f"urdf2mbs_passes returned {pass_class!r}; expected a subclass of Pass"
            raise self._broken_plugin_error(plugin_name, message, EXPECTED["urdf2mbs_passes"])
        fault, hint = ("", "") if distribution == GROUP else _find_pass_fault(pass_class)
        if fault:
            raise self._broken_plugin_error(plugin_name, f"pass {pass_class.name!r}: {fault}", hint)
        return PassEntry(pass_class.name, "", tuple(pass_class.after), always, kind=pass_class)

    def _broken_plugin_error(
        self, plugin_name: str, message: str, hint: str = "", *, line: int | None = None
    ) -> ConfigError:
        """Return the error for a plugin that is wrong."""
        return ConfigError(
            "plugin-broken",
            f"plugin '{plugin_name}': {message}",
            file=self._plugin_files[plugin_name],
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
    plugin_modules: dict[str, Any] = {}
    for plugin_name, module_name in find_own_plugins(tuple(sys.path)).items():
        try:
            plugin_modules[plugin_name] = import_module(module_name)
        except ModuleNotFoundError as error:
            if error.name != module_name:
                raise
    loaded_plugins: dict[str, Any] = {}
    while ready_names := [
        plugin_name
        for plugin_name, plugin in plugin_modules.items()
        if plugin_name not in loaded_plugins
        and loaded_plugins.keys() >= {*getattr(plugin, "NEEDS", ())}
    ]:
        loaded_plugins |= {plugin_name: plugin_modules[plugin_name] for plugin_name in ready_names}
    return tuple(loaded_plugins.items())


def _import_plugin_file(plugin_file: Path) -> ModuleType | None:
    """Import a plugin file under a name of its own; None: it is no Python file."""
    import importlib.util
    import zlib

    # files of one name in two folders must not replace each other
    module_name = f"urdf2mbs_plugin_{plugin_file.stem}_{zlib.crc32(str(plugin_file).encode()):08x}"
    module_spec = importlib.util.spec_from_file_location(module_name, plugin_file)
    if module_spec is None or module_spec.loader is None:
        return None
    module = importlib.util.module_from_spec(module_spec)
    sys.modules[module_name] = module
    try:
        module_spec.loader.exec_module(module)
    except FAILURES:
        del sys.modules[module_name]
        raise
    return module


def _list_hooks() -> list[str]:
    """Return each hook, with the arguments that it may have."""
    return [
        f"{hook_name}({', '.join(inspect.signature(hook_spec).parameters)})"
        for hook_name, hook_spec in vars(hookspecs).items()
        if hook_name.startswith("urdf2mbs_")
    ]


def _find_pass_fault(pass_class: type[Pass]) -> tuple[str, str]:
    """Return the fault of a pass and its remedy; two empty texts if the pass has no fault."""
    if not isinstance(pass_class.name, str) or not pass_class.name.strip():
        return "its name is not a word", "call it something like 'my-pass'"
    if pass_class.run is Pass.run:
        return "it has no method 'run'", "def run(self, conversion):"
    try:
        inspect.signature(pass_class.run).bind(None, None)
    except TypeError:
        return "its 'run' cannot be called with a conversion", "def run(self, conversion):"
    for field_name in ("reads", "writes"):
        sections = getattr(pass_class, field_name)
        if not isinstance(sections, (tuple, list)) or not all(
            isinstance(section, str) for section in sections
        ):
            return (
                f"'{field_name}' is {sections!r}",
                f"write it as {field_name} = ('robot',), with the comma",
            )
    try:
        msgspec.json.schema(pass_class)
    except FAILURES as error:
        return (
            f"its options cannot be read from YAML: {describe_exception(error)}",
            "use bool, int, float, str, list, dict, tuple, Literal, or Structs of these",
        )
    return "", ""
