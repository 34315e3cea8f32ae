"""Runs the passes of a config, each with its hooks, under the contract of ``engine.contract``."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from time import perf_counter
from typing import Any

import pluggy

from urdf2mbs import hookspecs
from urdf2mbs.config.lines import Lines
from urdf2mbs.config.model import Config
from urdf2mbs.config.paths import expand
from urdf2mbs.conversion import Conversion, File
from urdf2mbs.disk.files import is_file
from urdf2mbs.engine.contract import PassCheck, check_protected, protected_state, record_change
from urdf2mbs.engine.failures import locating_option, naming_pass, naming_plugin
from urdf2mbs.engine.levels import apply_levels, raise_errors
from urdf2mbs.engine.order import ConfiguredPass, check_order, list_method, resolve
from urdf2mbs.engine.plugins import Plugins, load_plugins
from urdf2mbs.engine.robot_settings import apply_robot_settings, naming_robot_settings
from urdf2mbs.engine.settings import check_output, make_settings
from urdf2mbs.hookspecs import GROUP, Pass
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, nearest
from urdf2mbs.proof.verdict import NOT_CHECKED
from urdf2mbs.urdf.changes import encode
from urdf2mbs.urdf.reader import is_name

#: Ends an .mbs file that nobody compared with its URDF.
_UNPROVEN = f"<!-- {NOT_CHECKED}: the pass 'check' was not in the pipeline -->\n".encode()


class Pipeline:
    """The passes of one config, in an order that has been checked.

    Args:
        config: The config.
        config_lines: The line of each value of the config.
        installed_plugins: Whether the plugins of other installed packages take part.
        fresh: Whether to start over, and discard the user's edits of the .mbs.

    Raises:
        ConfigError: The config is wrong; with all its faults in the order of their lines.
    """

    passes: list[ConfiguredPass]
    plugins: Plugins

    def __init__(
        self,
        config: Config,
        config_lines: Lines,
        *,
        installed_plugins: bool = True,
        fresh: bool = False,
    ) -> None:
        if config.sweep is not None:
            config_lines.check()
            message = "this config is a sweep, which makes many robots"
            hint = "'urdf2mbs run' makes them; 'explain' shows the first"
            raise config_lines.error("sweep-many", message, ("sweep",), hint)
        self._config = config
        self._config_lines = config_lines
        self._plugin_files = self._list_plugin_files()
        if len(self._plugin_files) == len(config.plugins):  # otherwise passes would be missing, too
            self._resolve_passes(installed_plugins)
        hook: Any = None
        naming_hook: AbstractContextManager[None] = nullcontext()
        if is_name(config.source):
            config_lines.check()  # before a robot is downloaded
            hook = self.plugins.hook
            naming_hook = naming_plugin(
                self.plugins, "hook 'urdf2mbs_locate' of plugin '{}'".format
            )
        with config_lines.gather(), naming_hook:
            self.settings = make_settings(config, config_lines, hook, fresh=fresh)
        config_lines.check()
        self._hook_relays: list[Any] = [self.plugins.hook]
        """The hooks of the plugins, and of each observer."""
        self._check_order()

    def _list_plugin_files(self) -> list[Path]:
        """Return the plugin files of the config; those that do not exist become faults."""
        plugin_files: list[Path] = []
        for file_index, file_name in enumerate(self._config.plugins):
            config_key = ("plugins", file_index)
            with self._config_lines.gather():
                plugin_path = self._config_lines.folder / expand(
                    file_name, self._config_lines, config_key
                )
                if not is_file(plugin_path):
                    message = f"plugin file '{plugin_path}' does not exist"
                    raise self._config_lines.error("plugin-missing", message, config_key)
                plugin_files.append(plugin_path)
        return plugin_files

    def _resolve_passes(self, load_installed: bool) -> None:
        """Load the plugins and choose the passes; errors become faults of the lines."""
        config_lines = self._config_lines
        with config_lines.gather():
            self.plugins = load_plugins(self._plugin_files, installed=load_installed)
            for fault in config_lines.faults:
                for pass_name in self.plugins.passes:
                    if fault.message == f"unknown key '{pass_name}'":
                        fault.hint = f"did you mean 'passes: {{{pass_name}: {{}}}}'?"
            self._check_levels()
            n_earlier_faults = len(config_lines.faults)
            self.passes = resolve(self._config, config_lines, self.plugins)
            for fault in config_lines.faults[n_earlier_faults:]:
                # a plugin that was left out may have the missing pass
                broken_plugins = map(str, self.plugins.broken)
                fault.hint = "\n  ".join([fault.hint or "", *broken_plugins]).lstrip() or None

    def _check_levels(self) -> None:
        """Record a fault for each code that nobody has, or whose level is fixed."""
        levels = self._config.diagnostics
        if not levels:
            return
        codes = self.plugins.codes
        adjustable = {code for code, text in codes.items() if not text.startswith("error:")}
        for unknown_code in [code for code in levels if code not in adjustable]:
            message = f"there is no '{unknown_code}' among the codes whose level can be changed"
            hint = nearest(unknown_code, adjustable) or "docs/codes.md lists them"
            if unknown_code not in codes:
                hint += self._explain_declaration(unknown_code)
            fault = self._config_lines.error(
                "unknown-code", message, ("diagnostics", unknown_code), hint
            )
            self._config_lines.faults.append(fault)

    def _explain_declaration(self, diagnostic_code: str) -> str:
        """Return where plugins would declare a code, as more lines of a hint."""
        entries = [entry for entries in self.plugins.passes.values() for entry in entries]
        plugin_files = {entry.plugin: entry.source for entry in entries if not entry.is_ours}
        return "".join(
            f"\n  if it is a code of plugin '{plugin_name}': add \"{diagnostic_code}\" to what its "
            f"hook 'urdf2mbs_codes' returns, in {plugin_file}"
            for plugin_name, plugin_file in plugin_files.items()
        )

    def _check_order(self) -> None:
        """Check an order that is not that of the method, and the place of the output."""
        method_order = list_method(self.plugins)
        pass_names = [configured_pass.name for configured_pass in self.passes]
        if (
            pass_names != [pass_name for pass_name in method_order if pass_name in pass_names]
            or self._config.without
        ):
            check_order(self.passes, method_order, self._config_lines)
        # a pass that may have no work is not imported for this
        certain_passes = [
            configured_pass
            for configured_pass in self.passes
            if configured_pass.given or configured_pass.entry.is_core
        ]
        if any("mbs-file" in configured_pass.kind.writes for configured_pass in certain_passes):
            check_output(self.settings, self._config_lines)

    def watch(self, observer: object) -> None:
        """Call an object's own hooks, too, around every pass."""
        manager = pluggy.PluginManager(GROUP)
        manager.add_hookspecs(hookspecs)
        manager.register(observer)
        self._hook_relays.append(manager.hook)

    def run(self, *, stop_after: str | None = None, before: Conversion | None = None) -> Conversion:
        """Run the passes; nothing is written to disk.

        Messages get the user's levels here, and only here: after each pass, and with the error
        that ends a run.  An error that does not stop a pass is raised at the end, together with
        all such errors.

        Args:
            stop_after: The last pass that runs; None: all run.
            before: A conversion of the same robot, whose source is not read again.

        Raises:
            ConversionError: A pass failed, or a message has the level of an error.
        """
        pass_names = [configured_pass.name for configured_pass in self.passes]
        if stop_after is not None and stop_after not in pass_names:
            message = f"there is no pass '{stop_after}' in this pipeline to stop after"
            hint = nearest(stop_after, pass_names) or f"there are: {', '.join(pass_names)}"
            raise ConfigError("unknown-pass", message, hint=hint)
        conversion = Conversion(self.settings, hook=self.plugins.hook, progress=self._show_progress)
        if before is not None:
            conversion.input = before.input
        conversion.diagnostics += self.plugins.broken
        self._warn_of_idle_plugins(conversion)
        try:
            self._run_passes(conversion, stop_after)
        except ConversionError as error:
            diagnostics = [*conversion.diagnostics, *error.earlier]
            error.earlier = apply_levels(diagnostics, self._config, self.plugins)
            raise
        raise_errors(conversion.diagnostics)
        _mark_unproven(conversion)
        return conversion

    def _warn_of_idle_plugins(self, conversion: Conversion) -> None:
        """Warn of the files of the config that bring only passes, none of which is used."""
        used_plugins = {configured_pass.entry.plugin for configured_pass in self.passes}
        for plugin_name in [
            plugin_file.stem
            for plugin_file in self._plugin_files
            if plugin_file.stem not in used_plugins
        ]:
            unused_passes = self.plugins.list_only_passes(plugin_name)
            if unused_passes:
                conversion.warn(
                    "plugin-idle",
                    f"plugin '{plugin_name}' does nothing: none of its passes is in the pipeline "
                    f"({', '.join(unused_passes)})",
                    hint="put one in, by 'pipeline', 'before' or "
                    f"'after: {{PASS: {unused_passes[0]}}}'",
                )

    def _run_passes(self, conversion: Conversion, stop_after: str | None) -> None:
        finished_passes: list[ConfiguredPass] = []
        passes = list(self.passes)
        has_robot_settings = False
        for position, configured_pass in enumerate(passes):
            if self._has_work(configured_pass, conversion, finished_passes):
                self._call_hook("urdf2mbs_before_pass", configured_pass.pass_, conversion)
                start_time = perf_counter()
                self._run_pass(configured_pass, conversion, finished_passes)
                seconds = perf_counter() - start_time
                finished_passes.append(configured_pass)
                if not has_robot_settings and conversion.input.expansion is not None:
                    has_robot_settings = True
                    later_passes = passes[position + 1 :]
                    apply_robot_settings(conversion, self._config_lines, later_passes)
                    passes[position + 1 :] = later_passes
                conversion.diagnostics = apply_levels(
                    conversion.diagnostics, self._config, self.plugins
                )
                self._call_hook(
                    "urdf2mbs_after_pass", configured_pass.pass_, conversion, seconds=seconds
                )
            if configured_pass.name == stop_after:
                break

    def _has_work(
        self,
        configured_pass: ConfiguredPass,
        conversion: Conversion,
        finished_passes: Sequence[ConfiguredPass],
    ) -> bool:
        """Return whether a pass has work; the pass is imported then."""
        with naming_pass(self.plugins, configured_pass, conversion, finished_passes):
            return (
                configured_pass.entry.work(conversion, configured_pass.given)
                and configured_pass.pass_ is not None
            )

    def _run_pass(
        self,
        configured_pass: ConfiguredPass,
        conversion: Conversion,
        finished_passes: Sequence[ConfiguredPass],
    ) -> None:
        """Run a pass, and check its changes.

        Args:
            configured_pass: The pass, with its options.
            conversion: What the pass changes.
            finished_passes: The passes that ran before it.

        Raises:
            ConversionError: The pass failed, or broke the contract.
        """
        pass_check = PassCheck(configured_pass, conversion, finished_passes)
        with naming_pass(self.plugins, configured_pass, conversion, finished_passes):
            config = conversion.settings.config
            with (
                naming_robot_settings(configured_pass.name, conversion),
                locating_option(configured_pass.name, config, self._config_lines),
            ):
                configured_pass.pass_.run(conversion)
            pass_check.finish()
        pass_check.check_sections()

    def _call_hook(
        self, hook_name: str, pass_: Pass, conversion: Conversion, **timing: float
    ) -> None:
        """Call a hook around a pass, of all plugins and observers.

        Raises:
            ConversionError: A plugin's hook failed, or changed a read-only field.
        """
        listeners = [
            hook_relay
            for hook_relay in self._hook_relays
            if getattr(hook_relay, hook_name).get_hookimpls()
        ]
        if not listeners:
            return
        pass_moment = "before" if "before" in hook_name else "after"
        hook_users = self.plugins.find_hook_users(hook_name)
        robot_before = encode(conversion.robot) if hook_users else None
        protected = protected_state(conversion) if hook_users else ""
        failure_format = (
            f"hook '{hook_name}' of plugin '{{}}', called {pass_moment} pass '{pass_.name}',"
        )
        with naming_plugin(self.plugins, failure_format.format, conversion):
            for hook_relay in listeners:
                getattr(hook_relay, hook_name)(pass_=pass_, conversion=conversion, **timing)
        if robot_before is not None:
            change_author, plugin_names = (
                f"the hook {pass_moment} '{pass_.name}'",
                "' or '".join(hook_users),
            )
            check_protected(
                conversion, protected, f"{change_author} of plugin '{plugin_names}'", ""
            )
            record_change(conversion, robot_before, change_author, plugin_names, declared=False)

    def _show_progress(self, text: str) -> None:
        """Tell plugins and observers what a pass is doing."""
        for hook_relay in self._hook_relays:
            hook_relay.urdf2mbs_progress(text=text)


def _mark_unproven(conversion: Conversion) -> None:
    """Add to an .mbs that was not compared a comment that says so."""
    output = conversion.settings.output
    mbs_bytes = conversion.files.get(output)
    if conversion.checked.proof is None and mbs_bytes is not None and output.suffix == ".mbs":
        # after the root element: not every reader accepts a comment before it
        marked_bytes = mbs_bytes.removesuffix(_UNPROVEN) + _UNPROVEN
        conversion.files[output] = File(marked_bytes, replaces=getattr(mbs_bytes, "replaces", None))
